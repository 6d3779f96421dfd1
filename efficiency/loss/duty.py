"""What the contact points of designs see over their duty: local conditions, weighted with the work lost there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from efficiency.design.design import OPERATION_LIMITS, Design
from efficiency.gear_mesh import gear_mesh
from efficiency.loss.efficiency import MeshGrids, load_grids
from efficiency.loss.kinematics import Driver, Operation, loaded_points
from ehl.fluid.oil import Oil
from ehl.io.errors import ConvergenceError, InputError
from ehl.io.table_files import read_table
from ehl.io.units import ValueRange
from regression.plan.operating_range import WeightedPoints

_MAX_TORQUE, _MAX_SPEED = (float(OPERATION_LIMITS[name].le or 1e6) for name in ("torque", "speed"))
COLUMNS: dict[str, ValueRange | None] = {
    "torque": ValueRange("N*m", ge=-_MAX_TORQUE, le=_MAX_TORQUE, hint="Below zero on the coast side."),
    "speed": ValueRange("rad/s", ge=-_MAX_SPEED, le=_MAX_SPEED, hint="Below zero in reverse."),
    "temperature": OPERATION_LIMITS["temperature_oil"],
    "hours": ValueRange("h", ge=0.0),
}
POSITIONS, POINTS_PER_LINE = 12, 21


@dataclass(frozen=True)
class DutyRow:
    """One operating point of a duty cycle.

    Parameters
    ----------
    torque : float
        Of the pinion [N m]; below zero the coast flanks carry it.
    speed : float
        Of the pinion [rad/s]; below zero in reverse.
    temperature_oil : float
        [K].
    hours : float
        How long it lasts [h].
    """

    torque: float
    speed: float
    temperature_oil: float
    hours: float

    @property
    def side(self) -> Literal["drive", "coast"]:
        """Flanks that carry the torque."""
        return "drive" if self.torque > 0.0 else "coast"

    @property
    def driver(self) -> Driver:
        """Member the power comes from: the pinion where its torque acts in the direction it turns."""
        return "pinion" if self.torque * self.speed > 0.0 else "gear"


def read_duty(path: Path) -> tuple[DutyRow, ...]:
    """A duty cycle: CSV or XLSX with the columns torque, speed, temperature and hours, each with its unit.

    Rows without torque, speed or duration count for nothing.

    Raises
    ------
    InputError
        Naming row and column; or nothing of the duty is left.
    """
    columns = read_table(path, COLUMNS, tuple(COLUMNS), bare=False)
    rows = [DutyRow(*(float(x) for x in row)) for row in zip(*(columns[name] for name in COLUMNS), strict=True)]
    loaded = tuple(row for row in rows if row.torque * row.speed != 0.0 and row.hours > 0.0)
    if not loaded:
        raise InputError(path.name, f"{len(rows)} rows", "at least one row with torque, speed and hours")
    return loaded


def duty_points(
    designs: Sequence[Design],
    duty: Sequence[DutyRow],
    *,
    oil: str | None = None,
    positions: int = POSITIONS,
    points_per_line: int = POINTS_PER_LINE,
    report: Callable[[str, int, int], None] | None = None,
) -> list[WeightedPoints]:
    """Contact points of all designs at all operating points.

    The weight of a point is force times sliding speed times duration: with friction that does not change along the
    flank it is the work lost there. Geometry is computed once per flank, load once per torque.

    Parameters
    ----------
    designs : sequence of Design
        Gear pairs that run the same duty.
    duty : sequence of DutyRow
        Operating points.
    oil : str, optional
        Oil card in place of the designs'.
    positions, points_per_line : int
        Resolution; quantiles need less than an efficiency.
    report : callable, optional
        Called with the design's name, operating points done and in all.

    Raises
    ------
    ConvergenceError
        The flanks do not exist or do not mesh, or the load does not settle.
    """
    found: list[WeightedPoints] = []
    total, done = len(designs) * len(duty), 0
    for design in designs:
        card = Oil.load(oil or design.operation.oil)
        meshes: dict[str, MeshGrids] = {}
        for torque in dict.fromkeys(row.torque for row in duty):
            rows = [row for row in duty if row.torque == torque]
            side = rows[0].side
            if side not in meshes:
                meshes[side] = gear_mesh(design, side, positions, points_per_line).mesh
            loaded = load_grids(meshes[side], abs(torque)).fine
            if loaded.reason:
                raise ConvergenceError(loaded.reason, f"{design.name} at {torque:g} N m")
            for row in rows:
                operation = Operation.of_design(design, abs(row.speed), row.temperature_oil)
                points = loaded_points(loaded, meshes[side].teeth.effective_modulus, operation)
                weight = points.force * points.speed_sliding * (row.hours / len(meshes[side].fine))
                found.append(WeightedPoints(points.state, np.asarray(weight), card))
                done += 1
                if report is not None:
                    report(design.name, done, total)
    return found
