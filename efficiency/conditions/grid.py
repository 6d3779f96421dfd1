"""Efficiency at many conditions, for grids, parameter studies and duty cycles.

Maps over many torques, speeds and temperatures from few solved points.

The loss is a smooth function of each axis. ln(loss) is interpolated by cubic splines over ln(torque), ln(speed) and
ln(temperature); the nodes are the values nearest to the Chebyshev-Lobatto points of the axis. Points between the nodes
are solved for comparison; the difference is added to the error of the efficiency of all interpolated points.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from efficiency.conditions.conditions import AXES, check_size
from efficiency.contact.chebyshev import cubic_spline
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.power_loss import efficiency_of
from ehl.common.arrays import FloatArray, finite_or_none
from ehl.common.data import reason_text
from ehl.common.errors import ConvergenceError
from ehl.common.pages import Reportable, StatusOfReason, Tabular
from ehl.common.progress import ProgressCallback, progress_to, report_progress
from ehl.common.table import Table

if TYPE_CHECKING:
    import pandas

Rule = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""Values (..., m) at places (m,) from nodes (n,) and values (..., n)."""

_INTERPOLATED = ("torque", "speed", "temperature")
# number of solved values of an axis, and the least number of values of an interpolated axis (this work)
NODES, FEWEST = 7, 10
# stated error over the largest difference at the points of the comparison (this work; eight maps of 20 x 20 of four
# pairs: it covers 97 % of the points)
SAFETY = 3.0
# largest difference of ln(loss) for which a map is interpolated, unless it is within the numerical error
WORST = 2e-3
# share of the points as nodes of a second attempt above which all points are solved (ours)
MOST = 0.5
_SMOOTH = ("power_loss", "power_loss_rolling")
# points whose friction is evaluated together: more are not faster (this work)
_TOGETHER = 12
# piecewise linear figures; figures of edges, which begin to carry at some torque, are not interpolated
_LINEAR = ("pressure_hertz_max", "outside_range_share", "transmission_error_loaded")


def _nodes(values: Sequence[float]) -> Sequence[int]:
    """Indices of the values to solve: those nearest to the Chebyshev-Lobatto points of their logarithm."""
    x = np.log(values)
    if len(values) < FEWEST or np.unique(x).size < len(values):
        return range(len(values))
    cosines = 0.5 - 0.5 * np.cos(np.pi * np.arange(NODES) / (NODES - 1))
    return sorted({int(np.argmin(np.abs(x - at))) for at in x.min() + np.ptp(x) * cosines}, key=lambda k: float(x[k]))


def _between(nodes: Sequence[int], values: Sequence[Any]) -> list[int]:
    """Indices of up to three values between nodes; of a fully solved axis the middle one.

    They are in the first gap, the widest one and, if any has several, the one with the most values.
    """
    if len(nodes) == len(values):
        return [len(values) // 2]
    x = np.log(values)
    gaps = [(x[a], x[b]) for a, b in itertools.pairwise(nodes)]
    inside = [[k for k in range(len(values)) if low < x[k] < high] for low, high in gaps]
    filled = [k for k, among in enumerate(inside) if among]
    chosen = {filled[0], max(filled, key=lambda k: gaps[k][1] - gaps[k][0])}
    if len(inside[fullest := max(filled, key=lambda k: len(inside[k]))]) > 1:
        chosen.add(fullest)
    return [min(inside[k], key=lambda at: abs(float(x[at]) - 0.5 * sum(gaps[k]))) for k in sorted(chosen)]


def _interpolated(
    axes: Axes, nodes: Sequence[Sequence[int]], solved: Mapping[Place, GridPoint]
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
    torque, speed = (_on_axis(axes, name, float(first.value(name))) for name in ("torque", "speed"))
    pinion, driven = torque * speed, first.conditions.driver == "pinion"
    found["power_input"] = pinion + (0.0 if driven else found["power_loss"])
    found["power_output"] = found["power_input"] - found["power_loss"]
    efficiencies = np.vectorize(lambda loss, torque, speed: efficiency_of(loss, torque, speed, first.conditions.driver))
    found["efficiency"] = efficiencies(found["power_loss"], torque, speed)
    found["efficiency_with_rolling"] = efficiencies(found["power_loss"] + found["power_loss_rolling"], torque, speed)
    lost = 1.0 - at_nodes("efficiency")
    for name in ("efficiency_lower", "efficiency_upper"):
        if all(name in point.requested for point in solved.values()):
            ratio = np.log((1.0 - at_nodes(name)) / lost)
            found[name] = 1.0 - (1.0 - found["efficiency"]) * np.exp(spread(ratio, _linear))
    return found


def _on_axis(axes: Axes, name: str, held: float) -> FloatArray:
    """A condition at all points of the grid."""
    shape = tuple(len(values) for values in axes.values())
    if name not in axes:
        return np.full(shape, held)
    return np.asarray(np.array(axes[name], dtype=np.float64)[np.indices(shape)[list(axes).index(name)]])


def _linear(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    return np.asarray(y @ np.array([np.interp(at, x, unit) for unit in np.eye(x.size)]))


def _largest(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    """The larger value of both neighbouring nodes at each position."""
    above = np.clip(np.searchsorted(x, at), 1, x.size - 1)
    return np.maximum(y[..., above - 1], y[..., above])


Condition = Mapping[str, Any]
Axes = Mapping[str, Sequence[Any]]
Place = tuple[int, ...]
"""Index of the value of each axis."""


@dataclass(frozen=True)
class GridPoint(StatusOfReason):
    """One point of a grid."""

    condition: dict[str, Any]  # value of each axis, SI units
    # None if geometry or load could not be computed, or if the point is interpolated
    result: EfficiencyResult | None = field(repr=False)
    reason: str = ""  # reason of failure; empty otherwise
    detail: str = ""  # explanation of the reason, if there is no result
    # interval from uncertain inputs, most severe grade and safety factors, if requested
    requested: dict[str, str | float] = field(default_factory=dict)
    interpolated: dict[str, float] = field(default_factory=dict)  # figures of an interpolated point

    def figure(self, name: str) -> Any:
        """A figure of the point; nan if the point failed or the figure is not interpolated."""
        if name in self.requested:
            return self.requested[name]
        if self.reason or self.result is None:
            return self.interpolated.get(name, np.nan)
        return self.result.value(name)

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes of the result, or the reason of failure."""
        if self.result is None:
            return (reason_text(f"{self.reason}: {self.detail}"),) if self.reason else ()
        return self.result.notes

    def row(self) -> dict[str, Any]:
        """Condition, scalar values of the result, requested values, and notes."""
        values = self.interpolated if self.result is None else self.result.scalars()
        named = {name: getattr(value, "name", value) for name, value in self.condition.items()}
        last = {"interpolated": bool(self.interpolated), "status": self.status, "reason": self.reason}
        return named | values | self.requested | last | {"notes": "; ".join(self.notes)}


class PointsResult(StatusOfReason, Reportable):
    """A result of several points, each with its `reason` and `notes`."""

    points: tuple[Any, ...]
    kind_of_points = "points"

    @property
    def reason(self) -> str:
        """Number of failed points by reason, such as ``"2 of 9 points: no contact"``; empty if none failed."""
        counts = Counter(point.reason for point in self.points if point.reason)
        total = f"{len(self.points)} {self.kind_of_points}"
        return ", ".join(f"{count} of {total}: {reason_text(reason)}" for reason, count in counts.items())

    @property
    def notes(self) -> Mapping[str, int]:
        """Each note with the number of its points."""
        return dict(Counter(note for point in self.points for note in point.notes))


@dataclass(frozen=True, repr=False)
class Grid(Tabular, PointsResult):
    """Efficiencies at all combinations of several axes; a failed point keeps its reason.

    Parameters
    ----------
    axes : dict
        Values of each axis, SI units; designs by name.
    points : tuple of GridPoint
        Points with the first axis outermost.
    interpolation_error : float
        Stated error of ln(loss) at interpolated points, included in their `efficiency_error` [-].

    Examples
    --------
    >>> import efficiency
    >>> mesh = efficiency.load("fm_spiral_bevel_14x39").mesh(positions=4, points_per_line=9)
    >>> grid = mesh.over("constant:0.05", torque="200, 300 N m", speed=["500 rpm", "1500 rpm"])
    >>> grid.shape, len(grid.to_frame())
    ((2, 2), 4)
    """

    presenter = "efficiency.output.gear_report:map"

    axes: dict[str, tuple[Any, ...]]
    points: tuple[GridPoint, ...] = field(repr=False)
    interpolation_error: float = 0.0

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes."""
        return tuple(len(values) for values in self.axes.values())

    @property
    def results(self) -> tuple[EfficiencyResult, ...]:
        """Results of the solved points."""
        return tuple(point.result for point in self.points if point.result is not None)

    def values(self, name: str = "efficiency") -> FloatArray:
        """One figure of all points in the shape of the grid; nan if unavailable (`GridPoint.figure`)."""
        found = [point.figure(name) for point in self.points]
        return np.array(found, dtype=np.float64).reshape(self.shape)

    @property
    def interpolation(self) -> str:
        """Number of interpolated points and their error as text; empty if all are solved."""
        count = sum(bool(point.interpolated) for point in self.points)
        if not count:
            return ""
        error = f"{100.0 * self.interpolation_error:.1g} % of the loss"
        return f"{count} of {len(self.points)} points are interpolated between solved ones, within {error}"

    def _dimensions(self) -> tuple[str, ...]:
        return tuple(self.axes)

    def to_frame(self) -> pandas.DataFrame:
        """One row per point: its condition, its figures in SI units, status, reason, notes."""
        import pandas

        return pandas.DataFrame([point.row() for point in self.points])

    def to_dict(self) -> dict[str, Any]:
        """Axes, status and one object per point, for JSON; not-a-number becomes None."""
        axes = {name: list(values) for name, values in self.axes.items()}
        points = [finite_or_none(point.row() | {"notes": list(point.notes)}) for point in self.points]
        found = {"status": self.status, "reason": self.reason, "interpolation_error": self.interpolation_error}
        return axes | found | {"points": points}

    def __repr__(self) -> str:
        axes = ", ".join(f"{name} x {len(values)}" for name, values in self.axes.items())
        return f"Grid({axes}; {self.status}{': ' if self.reason else ''}{self.reason})"

    def _repr_html_(self) -> str:
        names = ("efficiency", "power_loss", "friction_coefficient_mean", "outside_range_share", "status", "reason")
        frame = self.to_frame().head(20)
        shown = frame[[*self.axes, *(name for name in names if name in frame)]]
        more = (f"20 of {len(self.points)} points",) * (len(self.points) > len(shown))
        return Table([str(name) for name in shown], shown.to_numpy().tolist(), notes=more).html()


@dataclass(frozen=True)
class Evaluator:
    """Efficiency at many conditions; geometry and load are computed once each for any order of the conditions."""

    # efficiencies at conditions by names of `AXES` that have geometry, torque and oil in common
    at: Callable[[Sequence[Condition]], Sequence[EfficiencyResult]]
    progress: ProgressCallback | None = None  # called with a `Progress` after each point
    strength: bool = False  # add grades and safety factors: 0.1 s a point
    interval: bool = False  # add the interval of the efficiency from uncertain inputs

    def points(self, conditions: Sequence[Condition]) -> list[GridPoint]:
        """Points in the given order; a failed condition becomes a point with its reason."""
        points: list[GridPoint] = []
        with progress_to(self.progress):
            for _, some in itertools.groupby(conditions, _shared):
                waiting = list(some)
                while waiting:
                    points += self._points(waiting[:_TOGETHER])
                    waiting = waiting[_TOGETHER:]
                    report_progress("points", len(points), len(conditions))
        return points

    def _points(self, conditions: Sequence[Condition]) -> list[GridPoint]:
        try:
            results = self.at(conditions)
        except ConvergenceError as error:
            if len(conditions) > 1:  # one by one: others may converge
                return [point for condition in conditions for point in self._points([condition])]
            return [GridPoint(dict(conditions[0]), None, error.reason, error.detail)]
        return list(map(self._point, conditions, results))

    def _point(self, condition: Condition, result: EfficiencyResult) -> GridPoint:
        try:
            more: dict[str, str | float] = {}
            if self.interval:
                more |= {"efficiency_lower": result.efficiency_lower, "efficiency_upper": result.efficiency_upper}
            if self.strength and not result.reason:
                more |= result.strength.columns()
        except ConvergenceError as error:
            return GridPoint(dict(condition), None, error.reason, error.detail)
        return GridPoint(dict(condition), result, result.reason, requested=more)

    def grid(self, axes: Axes, *, every_point: bool = True) -> Grid:
        """Points at every combination of the axes.

        axes: names of `AXES` with values in SI units.
        every_point: solve every point. Otherwise axes with many values are interpolated, unless the strength is
            requested, a node has no result, or the error of the interpolation at solved points between the nodes
            exceeds both their own error and `WORST`.
        Raises `InputError` for an axis without values, or too many points.
        """
        check_size(axes)
        every = list(itertools.product(*(range(len(values)) for values in axes.values())))
        solved, found, error = ({}, {}, 0.0) if every_point or self.strength else self._few(axes, len(every))
        if not found:
            solved |= self._places(axes, [place for place in every if place not in solved])
        points = tuple(
            solved[place]
            if place in solved
            else GridPoint(_at(axes, place), None, interpolated={n: float(v[place]) for n, v in found.items()})
            for place in every
        )
        named = {name: tuple(getattr(v, "name", v) for v in values) for name, values in axes.items()}
        return Grid(named, points, error)

    def _few(self, axes: Axes, count: int) -> tuple[dict[Place, GridPoint], dict[str, FloatArray], float]:
        """Points at the nodes and between them, figures interpolated at all points (empty: not possible), error."""
        nodes = [_nodes(values) if name in _INTERPOLATED else range(len(values)) for name, values in axes.items()]
        solved: dict[Place, GridPoint] = {}
        while (share := math.prod(map(len, nodes)) / count) < 1.0 and (not solved or share <= MOST):
            between = list(map(_between, nodes, axes.values()))
            checks = list(itertools.product(*between))
            wanted = [*itertools.product(*nodes), *checks]
            solved |= self._places(axes, [place for place in wanted if place not in solved])
            found = None if any(point.reason for point in solved.values()) else _interpolated(axes, nodes, solved)
            if found is None:
                break
            differences, own = [], []  # of ln(loss); numerical errors relative to the loss
            for place in checks:
                point = solved[place]
                differences.append(abs(math.log(found["power_loss"][place] / point.figure("power_loss"))))
                own.append(float(point.figure("efficiency_error") / (1.0 - point.figure("efficiency"))))
            if all(d <= max(WORST, error) for d, error in zip(differences, own, strict=True)):
                error = SAFETY * max(differences)
                found["efficiency_error"] += error * (1.0 - found["efficiency"])
                return solved, found, error
            nodes = [
                sorted({*some, *more}, key=values.__getitem__) if name in _INTERPOLATED else some
                for some, more, (name, values) in zip(nodes, between, axes.items(), strict=True)
            ]
        return solved, {}, 0.0

    def _places(self, axes: Axes, places: Sequence[Place]) -> dict[Place, GridPoint]:
        """Points at given combinations, sorted so that geometry and load are shared."""
        cost = [list(axes).index(name) for name in AXES if name in axes]
        order = sorted(places, key=lambda place: [place[axis] for axis in cost])
        return dict(zip(order, self.points([_at(axes, place) for place in order]), strict=True))


def _shared(condition: Condition) -> list[Any]:
    """The part of a condition that points of one evaluation have in common: geometry, torque and oil."""
    return [condition.get(name) for name in AXES[: AXES.index("oil") + 1]]


def _at(axes: Axes, place: Place) -> dict[str, Any]:
    """Condition at a place of the axes."""
    return {name: values[k] for (name, values), k in zip(axes.items(), place, strict=True)}
