"""Result of a study: its points, and sections through them."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import asdict, dataclass, fields
from typing import Any, Literal

import numpy as np

from efficiency.loss.result import EfficiencyResult
from efficiency.study.levels import MISALIGNED, OPERATING, Levels
from ehl.io.numbers import finite_or_none
from ehl.quantities import Quantity, quantities


def level_quantity(name: str) -> Quantity:
    """What a parameter of a study is: misalignments by their letters, the roughness that of each flank."""
    known = quantities()
    return known.get(f"study.{name}") or known.get(f"misalignment.{name}") or known[name]


@dataclass(frozen=True)
class StudyPoint:
    """One design, misalignment and operating point; SI units, names as in `EfficiencyResult`.

    Attributes
    ----------
    design, hypoid_offset : str, float
        [-], [m].
    E, P, G, alpha : float
        Misalignments added to the design's [m], [rad].
    torque, speed, temperature_oil, roughness_rms : float
        Of the pinion [N m], [rad/s]; oil [K]; Rq of both flanks, each [m].
    efficiency ... outside_range_share : float
        nan where the point failed.
    film_ratio : float
        Mean weighted with the sliding power [-].
    temperature_flash : float
        Greatest surface temperature of the cycle [K].
    status, reason : str
    seconds : float
    """

    design: str
    hypoid_offset: float
    E: float
    P: float
    G: float
    alpha: float
    torque: float
    speed: float
    temperature_oil: float
    roughness_rms: float
    efficiency: float = math.nan
    efficiency_lower: float = math.nan
    efficiency_upper: float = math.nan
    efficiency_error: float = math.nan
    efficiency_with_rolling: float = math.nan
    power_loss: float = math.nan
    power_loss_rolling: float = math.nan
    power_input: float = math.nan
    friction_coefficient_mean: float = math.nan
    film_ratio: float = math.nan
    pressure_max: float = math.nan
    temperature_flash: float = math.nan
    transmission_error_loaded: float = math.nan
    transmission_error_unloaded: float = math.nan
    outside_range_share: float = math.nan
    status: str = "failed"
    reason: str = ""
    seconds: float = 0.0

    @property
    def label(self) -> str:
        """Design and state in words, to name a point that failed."""
        names = ("torque", "speed", "temperature_oil", "roughness_rms", *filter(self._shifted, MISALIGNED))
        levels = (f"{name} {level_quantity(name).text(getattr(self, name))}" for name in names)
        return f"{self.design}, {', '.join(levels)}"

    def _shifted(self, name: str) -> bool:
        return bool(getattr(self, name) != 0.0)

    @property
    def aligned(self) -> bool:
        """Whether no misalignment is added."""
        return not any(self._shifted(name) for name in MISALIGNED)


def with_result(point: StudyPoint, result: EfficiencyResult) -> StudyPoint:
    """A point with what was computed for it."""
    names = {f.name for f in fields(StudyPoint)} & set(result.__dataclass_fields__)
    names -= {"design", "temperature_oil"}
    weight = result.points.force * result.points.speed_sliding
    ratio = np.where(np.isfinite(result.lubrication.film_ratio), result.lubrication.film_ratio, np.nan)
    mean = float(np.nansum(weight * ratio) / np.sum(weight)) if weight.sum() > 0.0 else math.nan
    values = asdict(point) | {name: getattr(result, name) for name in names}
    flash = float(np.nanmax(result.lubrication.temperature_flash)) if result.points.force.size else math.nan
    return StudyPoint(**values | {"film_ratio": mean, "temperature_flash": flash})


@dataclass(frozen=True)
class Study:
    """Efficiencies of some designs over the parameters.

    Attributes
    ----------
    designs : tuple of str
        In the order given.
    side, oil, friction_model : str
    levels : Levels
    reference : dict
        Operating point through which the sections go.
    points : tuple of StudyPoint
    notes : dict
        Note of a computation, and of how many points.
    jobs, reused : int
        Worker processes; points that an earlier run had computed.
    seconds : float
        Wall time.
    """

    designs: tuple[str, ...]
    side: str
    oil: str
    friction_model: str
    levels: Levels
    reference: dict[str, float]
    points: tuple[StudyPoint, ...]
    notes: dict[str, int]
    jobs: int
    reused: int
    seconds: float

    @property
    def status(self) -> Literal["converged", "failed"]:
        """``failed`` if any point failed."""
        return "failed" if self.failed else "converged"

    @property
    def failed(self) -> tuple[StudyPoint, ...]:
        """Points that failed."""
        return tuple(point for point in self.points if point.status == "failed")

    @property
    def reason(self) -> str:
        """How many points failed for which reason."""
        reasons = Counter(point.reason for point in self.failed)
        return ", ".join(f"{count} of {len(self.points)} points {reason}" for reason, count in reasons.items())

    def section(self, design: str, name: str, **fixed: float) -> list[StudyPoint]:
        """Points of a design along one parameter, in its order; the others as fixed, else at the reference."""
        state = self.reference | fixed
        held = {key: value for key, value in state.items() if key != name}
        shifts = {key: fixed.get(key, 0.0) for key in MISALIGNED if key != name}
        chosen = [
            point
            for point in self.points
            if point.design == design and all(getattr(point, key) == value for key, value in (held | shifts).items())
            if name in MISALIGNED or getattr(point, name) in getattr(self.levels, name)
        ]
        return sorted(chosen, key=lambda point: float(getattr(point, name)))

    def reference_point(self, design: str) -> StudyPoint:
        """The point of a design at the reference."""
        torque = self.reference["torque"]
        return next(point for point in self.section(design, "torque") if point.torque == torque and point.aligned)

    def influence(self, design: str, name: str) -> tuple[float, float]:
        """Least and greatest efficiency over one parameter, the others at the reference; nan where all failed."""
        values = [point.efficiency for point in self.section(design, name)]
        known = [value for value in values if math.isfinite(value)]
        return (min(known), max(known)) if known else (math.nan, math.nan)

    @property
    def varied(self) -> list[str]:
        """Parameters with more than one value."""
        return [name for name in OPERATING if len(getattr(self.levels, name)) > 1] + [
            name for name in MISALIGNED if any(value != 0.0 for value in getattr(self.levels, name))
        ]

    def to_dict(self) -> dict[str, Any]:
        """For JSON; not-a-number becomes None."""
        names = (
            "designs",
            "side",
            "oil",
            "friction_model",
            "reference",
            "status",
            "reason",
            "notes",
            "jobs",
            "seconds",
        )
        head = {name: getattr(self, name) for name in names}
        rows = finite_or_none(self.points)
        return head | {"designs": list(self.designs), "levels": self.levels.to_dict(), "points": rows}
