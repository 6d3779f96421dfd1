"""Efficiency over lists of torque, speed and oil temperature."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from efficiency.loss.efficiency import MeshGrids, load_grids, mesh_efficiency
from efficiency.loss.kinematics import Operation
from efficiency.loss.result import EfficiencyResult
from ehl.fluid.oil import Oil
from ehl.io.errors import InputError
from regression.friction.models import FrictionModel

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class EfficiencyMap:
    """Efficiencies at all combinations of three lists.

    Attributes
    ----------
    torque_pinion, speed_pinion, temperature_oil : tuples of float
        The lists [N m], [rad/s], [K].
    results : tuple of EfficiencyResult
        Torque outermost, temperature innermost.
    """

    torque_pinion: tuple[float, ...]
    speed_pinion: tuple[float, ...]
    temperature_oil: tuple[float, ...]
    results: tuple[EfficiencyResult, ...] = field(repr=False)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Lengths of the three lists."""
        return len(self.torque_pinion), len(self.speed_pinion), len(self.temperature_oil)

    def values(self, name: str = "efficiency") -> FloatArray:
        """One scalar of the results as an array (torque, speed, temperature)."""
        return np.array([getattr(result, name) for result in self.results]).reshape(self.shape)

    @property
    def status(self) -> Literal["converged", "failed"]:
        """``failed`` if any point failed."""
        return "failed" if any(result.status == "failed" for result in self.results) else "converged"

    @property
    def reason(self) -> str:
        """How many points failed for which reason."""
        reasons = Counter(result.reason for result in self.results if result.status == "failed")
        return ", ".join(f"{count} of {len(self.results)} points {reason}" for reason, count in reasons.items())

    def to_dict(self) -> dict[str, Any]:
        """Lists, status and one object per point, for JSON."""
        return {
            "torque_pinion": list(self.torque_pinion),
            "speed_pinion": list(self.speed_pinion),
            "temperature_oil": list(self.temperature_oil),
            "status": self.status,
            "points": [result.to_dict() for result in self.results],
        }


def efficiency_map(
    mesh: MeshGrids,
    friction: FrictionModel,
    oil: Oil,
    torques: Sequence[float],
    operations: Callable[[float, float], Operation],
    speeds: Sequence[float],
    temperatures: Sequence[float],
    report: Callable[[int, int], None] | None = None,
) -> EfficiencyMap:
    """Efficiency at every combination; the load is solved once per torque.

    Parameters
    ----------
    mesh : MeshGrids
        Geometry of the mesh.
    friction : FrictionModel
        One friction model.
    oil : Oil
        Oil card.
    torques, speeds, temperatures : sequences of float
        Pinion torque [N m], pinion speed [rad/s], oil temperature [K].
    operations : callable
        The operation (with its roughness) at a speed and a temperature.
    report : callable, optional
        Called with the number of points done and of all points.

    Raises
    ------
    InputError
        An empty list, or a value that a single computation refuses.
    """
    lists = {"torque": torques, "speed": speeds, "temperature": temperatures}
    for name, values in lists.items():
        if not values:
            raise InputError(name, list(values), "at least one value")
    total = len(torques) * len(speeds) * len(temperatures)
    states = [operations(speed, temperature) for speed in speeds for temperature in temperatures]
    results: list[EfficiencyResult] = []
    for torque in torques:
        loaded = load_grids(mesh, torque)
        for operation in states:
            results.append(mesh_efficiency(loaded, friction, oil, operation))
            if report is not None:
                report(len(results), total)
    return EfficiencyMap(tuple(torques), tuple(speeds), tuple(temperatures), tuple(results))
