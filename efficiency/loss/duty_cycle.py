"""Energy into, out of and lost in the mesh over a duty cycle, row by row and in total."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from efficiency.contact.gear_flanks import Side
from efficiency.loss.duty import DutyRow
from efficiency.loss.efficiency import LoadedGrids, mesh_efficiency
from efficiency.loss.kinematics import Driver, Operation
from efficiency.loss.result import EfficiencyResult
from ehl.fluid.oil import Oil
from ehl.io.numbers import finite_or_none
from regression.friction.models import FrictionModel

HOUR = 3600.0


@dataclass(frozen=True)
class DutyEnergy:
    """One operating point of the duty cycle.

    Attributes
    ----------
    side, driver : str
        Flanks in contact and the member the power comes from.
    torque_pinion, speed_pinion, temperature_oil : float
        Magnitudes [N m], [rad/s]; [K].
    hours : float
        Duration [h].
    efficiency, efficiency_error : float
        [-].
    energy_input, energy_output, energy_loss, energy_loss_rolling : float
        [J]; the rolling loss is not in `energy_loss`.
    outside_range_share : float
        Share of the sliding power outside the range of the friction model [-].
    status, reason : str
    """

    side: str
    driver: Driver
    torque_pinion: float
    speed_pinion: float
    temperature_oil: float
    hours: float
    efficiency: float
    efficiency_error: float
    energy_input: float
    energy_output: float
    energy_loss: float
    energy_loss_rolling: float
    outside_range_share: float
    status: str
    reason: str


@dataclass(frozen=True)
class DutyCycle:
    """Energies of all rows of a duty cycle.

    Attributes
    ----------
    design, friction_model, oil : str
    rows : tuple of DutyEnergy
        In the order of the file.
    results : tuple of EfficiencyResult
        Of the rows; not in `to_dict`.
    """

    design: str
    friction_model: str
    oil: str
    rows: tuple[DutyEnergy, ...]
    results: tuple[EfficiencyResult, ...] = field(repr=False, compare=False)

    def total(self, name: str) -> float:
        """Sum over all rows: of energy_input, energy_output, energy_loss, energy_loss_rolling [J] or hours [h]."""
        return math.fsum(getattr(row, name) for row in self.rows)

    @property
    def efficiency(self) -> float:
        """Energy out over energy in, all rows together [-]; nan if a row failed."""
        return self.total("energy_output") / self.total("energy_input")

    @property
    def efficiency_error(self) -> float:
        """Discretisation error of the efficiency, all rows off the same way [-]."""
        return math.fsum(row.efficiency_error * row.energy_input for row in self.rows) / self.total("energy_input")

    @property
    def status(self) -> Literal["converged", "failed"]:
        """``failed`` if any row failed."""
        return "failed" if any(row.status == "failed" for row in self.rows) else "converged"

    @property
    def reason(self) -> str:
        """How many rows failed for which reason."""
        reasons = Counter(row.reason for row in self.rows if row.status == "failed")
        return ", ".join(f"{count} of {len(self.rows)} rows {reason}" for reason, count in reasons.items())

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes of all rows, each once."""
        return tuple(dict.fromkeys(note for result in self.results for note in result.notes))

    def to_dict(self) -> dict[str, Any]:
        """Rows and totals, for JSON; not-a-number becomes None."""
        names = ("hours", "energy_input", "energy_output", "energy_loss", "energy_loss_rolling")
        total = {name: self.total(name) for name in names}
        total |= {"efficiency": self.efficiency, "efficiency_error": self.efficiency_error}
        return {
            "design": self.design,
            "friction_model": self.friction_model,
            "oil": self.oil,
            "status": self.status,
            "reason": self.reason,
            "total": finite_or_none(total),
            "rows": finite_or_none(self.rows),
            "notes": list(self.notes),
        }


def duty_cycle(
    duty: Sequence[DutyRow],
    load: Callable[[Side, float], LoadedGrids],
    friction: FrictionModel,
    oil: Oil,
    operation: Callable[[DutyRow], Operation],
    report: Callable[[int, int], None] | None = None,
) -> DutyCycle:
    """Efficiency at every row and the energies of all.

    Parameters
    ----------
    duty : sequence of DutyRow
        Operating points.
    load : callable
        Loaded mesh of a side at a torque; asked once for each pair of them.
    friction : FrictionModel
        One friction model.
    oil : Oil
        Oil card.
    operation : callable
        How the pair runs in a row.
    report : callable, optional
        Called with the number of rows done and of all rows.
    """
    loaded: dict[tuple[Side, float], LoadedGrids] = {}
    rows, results = [], []
    for row in duty:
        key = row.side, abs(row.torque)
        if key not in loaded:
            loaded[key] = load(*key)
        result = mesh_efficiency(loaded[key], friction, oil, operation(row))
        results.append(result)
        rows.append(_energy(row, result))
        if report is not None:
            report(len(rows), len(duty))
    return DutyCycle(results[0].design, friction.name, oil.name, tuple(rows), tuple(results))


def _energy(row: DutyRow, result: EfficiencyResult) -> DutyEnergy:
    seconds = row.hours * HOUR
    return DutyEnergy(
        side=result.side,
        driver=result.driver,
        torque_pinion=result.torque_pinion,
        speed_pinion=result.speed_pinion,
        temperature_oil=result.temperature_oil,
        hours=row.hours,
        efficiency=result.efficiency,
        efficiency_error=result.efficiency_error,
        energy_input=result.power_input * seconds,
        energy_output=result.power_output * seconds,
        energy_loss=result.power_loss * seconds,
        energy_loss_rolling=result.power_loss_rolling * seconds,
        outside_range_share=result.outside_range_share,
        status=result.status,
        reason=result.reason,
    )
