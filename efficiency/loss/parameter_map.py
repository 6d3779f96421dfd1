"""Efficiency over any axes: torque, speed, oil temperature, roughness, misalignment, designs.

Each geometry is computed once, each load once per geometry and torque, whatever the order of the axes.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from efficiency.loss.efficiency import LoadedGrids, MeshGrids, load_grids, mesh_efficiency
from efficiency.loss.kinematics import Operation
from efficiency.loss.result import EfficiencyResult
from ehl.fluid.oil import Oil
from ehl.io.errors import ConvergenceError, InputError
from regression.friction.models import FrictionModel

FloatArray = NDArray[np.float64]
Place = Mapping[str, Any]

GEOMETRY_AXES = ("design", "E", "P", "G", "alpha")
OPERATION_AXES = (
    *("speed", "temperature_oil", "roughness_rms", "roughness_rms_pinion", "roughness_rms_gear"),
    *("correlation_length", "peklenik_number"),
)
AXES = (*GEOMETRY_AXES, "torque", *OPERATION_AXES)


@dataclass(frozen=True)
class ParameterMap:
    """Efficiencies at all combinations of any axes.

    Attributes
    ----------
    axes : dict
        Values of each axis in SI units; a design by its name.
    results : tuple of EfficiencyResult or None
        First axis outermost; None where there was no geometry to load.
    reasons : tuple of str
        Why a point failed; empty where it did not.
    """

    axes: dict[str, tuple[Any, ...]]
    results: tuple[EfficiencyResult | None, ...] = field(repr=False)
    reasons: tuple[str, ...] = field(repr=False)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes."""
        return tuple(len(values) for values in self.axes.values())

    def values(self, name: str = "efficiency") -> FloatArray:
        """One figure of all results in the shape of the map; nan where a point failed."""
        found = [
            np.nan if result is None or reason else getattr(result, name)
            for result, reason in zip(self.results, self.reasons, strict=True)
        ]
        return np.array(found, dtype=np.float64).reshape(self.shape)

    @property
    def status(self) -> Literal["converged", "failed"]:
        """``failed`` if any point failed."""
        return "failed" if any(self.reasons) else "converged"

    @property
    def reason(self) -> str:
        """How many points failed for which reason."""
        counts = Counter(reason for reason in self.reasons if reason)
        return ", ".join(f"{count} of {len(self.reasons)} points {reason}" for reason, count in counts.items())

    def to_dict(self) -> dict[str, Any]:
        """Axes, status and one object per point, for JSON."""
        places = itertools.product(*self.axes.values())
        points = [
            {**dict(zip(self.axes, place, strict=True)), "reason": reason}
            | ({} if result is None else {"result": result.to_dict()})
            for place, result, reason in zip(places, self.results, self.reasons, strict=True)
        ]
        return {"axes": {k: list(v) for k, v in self.axes.items()}, "status": self.status, "points": points}


def parameter_map(
    make_mesh: Callable[[Place], MeshGrids],
    friction: FrictionModel | Callable[[Place], FrictionModel],
    oil: Oil,
    axes: Mapping[str, Sequence[Any]],
    operation: Callable[[Place], Operation],
    torque: Callable[[Place], float],
    report: Callable[[int, int], None] | None = None,
) -> ParameterMap:
    """Efficiency at every combination of the axes.

    Parameters
    ----------
    make_mesh : callable
        Mesh at a place on the axes of `GEOMETRY_AXES`.
    friction : FrictionModel, or callable
        One friction model, or the one at a geometry.
    oil : Oil
        Oil card.
    axes : mapping
        Names of `AXES` to values in SI units.
    operation, torque : callables
        Operation and pinion torque [N m] at a place; what has no axis is theirs to fill in.
    report : callable, optional
        Called with the number of points done and of all points.

    Returns
    -------
    ParameterMap
        A geometry that cannot mesh is a recorded reason at its points, never a lost map.

    Raises
    ------
    InputError
        An unknown axis, an axis without values, or a value that a single computation refuses.
    """
    for name, values in axes.items():
        if name not in AXES:
            raise InputError("axis", name, "one of " + ", ".join(AXES))
        if not len(values):
            raise InputError(name, list(values), "at least one value")
    if "roughness_rms" in axes and {"roughness_rms_pinion", "roughness_rms_gear"} & axes.keys():
        raise InputError("axis", "roughness_rms", "either roughness_rms or that of pinion and gear")
    numbers = {name: range(len(values)) for name, values in axes.items()}
    geometry, loading, running = (
        [name for name in axes if name in group] for group in (GEOMETRY_AXES, ("torque",), OPERATION_AXES)
    )
    shape = tuple(len(values) for values in axes.values())
    total = int(np.prod(shape))
    results: list[EfficiencyResult | None] = [None] * total
    reasons = [""] * total
    done = 0

    def at(index: Mapping[str, int]) -> Place:
        return {name: axes[name][k] for name, k in index.items()}

    def indices(names: Sequence[str]) -> list[dict[str, int]]:
        return [dict(zip(names, k, strict=True)) for k in itertools.product(*(numbers[name] for name in names))]

    for shape_index in indices(geometry):
        mesh: MeshGrids | str
        try:
            mesh = make_mesh(at(shape_index))
        except ConvergenceError as error:
            mesh = error.reason
        model = friction if isinstance(friction, FrictionModel) else friction(at(shape_index))
        for load_index in indices(loading):
            loaded: LoadedGrids | str = "" if isinstance(mesh, MeshGrids) else mesh
            if isinstance(mesh, MeshGrids):
                loaded = load_grids(mesh, torque(at(shape_index | load_index)))
            for run_index in indices(running):
                index = shape_index | load_index | run_index
                place = int(np.ravel_multi_index(tuple(index[name] for name in axes), shape)) if shape else 0
                if isinstance(loaded, LoadedGrids):
                    result = mesh_efficiency(loaded, model, oil, operation(at(index)))
                    results[place], reasons[place] = result, result.reason
                else:
                    reasons[place] = loaded
                done += 1
                if report is not None:
                    report(done, total)
    named = {name: tuple(getattr(v, "name", v) for v in values) for name, values in axes.items()}
    return ParameterMap(named, tuple(results), tuple(reasons))
