"""Maps over many torques, speeds and temperatures from few solved points.

The loss is a smooth function of each axis. ln(loss) is interpolated by cubic splines over ln(torque), ln(speed) and
ln(temperature); the nodes are the values nearest to the Chebyshev-Lobatto points of the axis. Points between the nodes
are solved for comparison; the difference is added to the error of the efficiency of all interpolated points.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from efficiency.conditions.grid import Grid, GridPoint, Place, Solve, named_axes, solve_grid, solve_places
from efficiency.contact.chebyshev import cubic_spline
from efficiency.loss.power_loss import efficiency_of
from ehl.common.arrays import FloatArray
from ehl.common.progress import ProgressCallback

Rule = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""Values (..., m) at places (m,) from nodes (n,) and values (..., n)."""

AXES = ("torque", "speed", "temperature")
# number of solved values of an axis, and the least number of values of an interpolated axis (ours)
NODES, FEWEST = 7, 10
# stated error over the largest difference at the points of the comparison (ours; eight maps of 20 x 20 of four pairs:
# it covers 97 % of the points)
SAFETY = 3.0
# largest difference of ln(loss) for which a map is interpolated, unless it is within the numerical error
WORST = 2e-3
_SMOOTH = ("power_loss", "power_loss_rolling")
# piecewise linear figures; figures of edges, which begin to carry at some torque, are not interpolated
_LINEAR = ("pressure_max", "outside_range_share", "transmission_error_loaded")


def solve_map(
    axes: Mapping[str, Sequence[Any]], solve: Solve, progress: ProgressCallback | None = None, *, interval: bool = False
) -> Grid:
    """Efficiency at every combination of the axes, interpolated for axes with many values.

    Every point is solved if a node has no result, or if the error of the interpolation at solved points between the
    nodes exceeds both their own error and `WORST`.

    axes: names of `efficiency.conditions.conditions.AXES` with values in SI units.
    solve, progress, interval: as in `efficiency.conditions.grid.solve_points`.
    """
    nodes = [_nodes(values) if name in AXES else range(len(values)) for name, values in axes.items()]
    if all(len(some) == len(values) for some, values in zip(nodes, axes.values(), strict=True)):
        return solve_grid(axes, solve, progress, interval=interval)
    checks = list(itertools.product(*map(_between, nodes, axes.values())))
    places = [*itertools.product(*nodes), *checks]
    solved = solve_places(axes, places, solve, progress, interval=interval)
    found = None if any(point.reason for point in solved.values()) else _interpolated(axes, nodes, solved)
    if found is not None:
        differences = [
            (abs(math.log(found["power_loss"][place] / solved[place].figure("power_loss"))), solved[place])
            for place in checks
        ]
        if all(d <= max(WORST, _own_error(point)) for d, point in differences):
            error = SAFETY * max(d for d, _ in differences)
            found["efficiency_error"] += error * (1.0 - found["efficiency"])
            return _assembled(axes, solved, found, error)
    missing = [p for p in itertools.product(*(range(len(v)) for v in axes.values())) if p not in solved]
    return _assembled(axes, solved | solve_places(axes, missing, solve, progress, interval=interval), {}, 0.0)


def _nodes(values: Sequence[float]) -> Sequence[int]:
    """Indices of the values to solve: those nearest to the Chebyshev-Lobatto points of their logarithm."""
    x = np.log(values)
    if len(values) < FEWEST or np.unique(x).size < len(values):
        return range(len(values))
    cosines = 0.5 - 0.5 * np.cos(np.pi * np.arange(NODES) / (NODES - 1))
    return sorted({int(np.argmin(np.abs(x - at))) for at in x.min() + np.ptp(x) * cosines}, key=lambda k: float(x[k]))


def _between(nodes: Sequence[int], values: Sequence[Any]) -> list[int]:
    """Indices of two values between nodes, in the first and the widest gap; of a fully solved axis the middle one."""
    if len(nodes) == len(values):
        return [len(values) // 2]
    x = np.log(values)
    gaps = [(x[a], x[b]) for a, b in itertools.pairwise(nodes)]
    inside = [[k for k in range(len(values)) if low < x[k] < high] for low, high in gaps]
    filled = [k for k, among in enumerate(inside) if among]
    chosen = {filled[0], max(filled, key=lambda k: gaps[k][1] - gaps[k][0])}
    return [min(inside[k], key=lambda at: abs(float(x[at]) - 0.5 * sum(gaps[k]))) for k in sorted(chosen)]


def _own_error(point: GridPoint) -> float:
    """Numerical error of a point relative to its loss."""
    return float(point.figure("efficiency_error") / (1.0 - point.figure("efficiency")))


def _interpolated(
    axes: Mapping[str, Sequence[Any]], nodes: Sequence[Sequence[int]], solved: Mapping[Place, GridPoint]
) -> dict[str, FloatArray] | None:
    """Figures at all points from those at the nodes; None if the loss at a node is not positive."""
    first = next(point.result for point in solved.values() if point.result is not None)
    shape = tuple(len(some) for some in nodes)

    def at_nodes(name: str) -> FloatArray:
        values = [solved[place].figure(name) for place in itertools.product(*nodes)]
        return np.array(values, dtype=np.float64).reshape(shape)

    def spread(values: FloatArray, rule: Rule) -> FloatArray:
        for axis, (some, every) in enumerate(zip(nodes, axes.values(), strict=True)):
            if len(some) < len(every):
                x = np.log(every)
                values = np.moveaxis(rule(x[list(some)], np.moveaxis(values, axis, -1), x), -1, axis)
        return values

    with np.errstate(divide="ignore", invalid="ignore"):
        logs = {name: np.log(at_nodes(name)) for name in _SMOOTH}
    if not all(np.all(np.isfinite(part)) for part in logs.values()):
        return None
    found = {name: np.exp(spread(part, cubic_spline)) for name, part in logs.items()}
    found |= {name: spread(at_nodes(name), _linear) for name in _LINEAR}
    found["efficiency_error"] = spread(at_nodes("efficiency_error"), _largest)
    sliding = spread(np.log(at_nodes("power_loss") / at_nodes("friction_coefficient_mean")), cubic_spline)
    found["friction_coefficient_mean"] = found["power_loss"] / np.exp(sliding)
    torque, speed = (_on_axis(axes, name, float(getattr(first, name))) for name in ("torque", "speed"))
    pinion, driven = torque * speed, first.driver == "pinion"
    found["power_input"] = pinion + (0.0 if driven else found["power_loss"])
    found["power_output"] = found["power_input"] - found["power_loss"]
    efficiencies = np.vectorize(lambda loss, torque, speed: efficiency_of(loss, torque, speed, first.driver))
    found["efficiency"] = efficiencies(found["power_loss"], torque, speed)
    found["efficiency_with_rolling"] = efficiencies(found["power_loss"] + found["power_loss_rolling"], torque, speed)
    lost = 1.0 - at_nodes("efficiency")
    for name in ("efficiency_lower", "efficiency_upper"):
        if all(name in point.requested for point in solved.values()):
            ratio = np.log((1.0 - at_nodes(name)) / lost)
            found[name] = 1.0 - (1.0 - found["efficiency"]) * np.exp(spread(ratio, _linear))
    return found


def _on_axis(axes: Mapping[str, Sequence[Any]], name: str, held: float) -> FloatArray:
    """A condition at all points of the grid."""
    shape = tuple(len(values) for values in axes.values())
    if name not in axes:
        return np.full(shape, held)
    place = list(axes).index(name)
    line = np.array(axes[name], dtype=np.float64).reshape([-1 if k == place else 1 for k in range(len(shape))])
    return np.broadcast_to(line, shape)


def _linear(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    return np.asarray(y @ np.array([np.interp(at, x, unit) for unit in np.eye(x.size)]))


def _largest(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    """The larger value of both neighbouring nodes at each position."""
    above = np.clip(np.searchsorted(x, at), 1, x.size - 1)
    return np.maximum(y[..., above - 1], y[..., above])


def _assembled(
    axes: Mapping[str, Sequence[Any]], solved: Mapping[Place, GridPoint], found: Mapping[str, FloatArray], error: float
) -> Grid:
    points = []
    for place in itertools.product(*(range(len(values)) for values in axes.values())):
        if place in solved:
            points.append(solved[place])
            continue
        condition = {name: values[k] for (name, values), k in zip(axes.items(), place, strict=True)}
        figures = {name: float(values[place]) for name, values in found.items()}
        points.append(GridPoint(condition, None, interpolated=figures))
    return Grid(named_axes(axes), tuple(points), error)
