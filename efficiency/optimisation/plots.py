"""Figures of an optimisation: trade-offs, parallel coordinates, progress."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ehl.common.figures import BLUE, GREY, ORANGE, axes_or_new, new_figure
from ehl.common.quantities import quantities
from ehl.common.sections import Picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from efficiency.optimisation.evaluation import Evaluation
    from efficiency.optimisation.result import Optimisation

_LIGHT = "0.8"
# axes end at this multiple of the start, so that the front remains visible
_VIEW = 1.6


def optimisation_figures(result: Optimisation) -> list[Picture]:
    """Figures of a search."""
    trade = (
        "Points of the search: grey above a limit, blue within all limits, orange the front; the square is the start. "
        "Figures are relative to the start, the edge load in % of the torque; the dashed line is the limit."
    )
    parallel = (
        "Parallel coordinates of the front: variables between their bounds, then figures relative to the start, edge "
        "load in % of the torque; one line for each point, darker for less loss."
    )
    progress = "Lowest first objective within the limits over the evaluations."
    return [
        Picture(partial(trade_figure, result), trade, "trade"),
        Picture(partial(parallel_figure, result), parallel, "parallel"),
        Picture(partial(progress_figure, result), progress, "progress"),
    ]


def _scale(result: Optimisation, name: str) -> float:
    """Divisor of an axis: the figure of the start; the unit for shares of the torque, which may vanish there."""
    start = result.start.figures[name]
    return start if start > 0.0 and name != "edge_load_share" else float(quantities()[name].to_si(1.0))


def _shares(points: list[Evaluation], result: Optimisation, name: str) -> np.ndarray:
    return np.array([point.figures[name] for point in points]) / _scale(result, name)


def _label(result: Optimisation, name: str) -> str:
    quantity = quantities()[name]
    scale = _scale(result, name)
    if scale == result.start.figures[name]:
        return f"{quantity.label}\nrelative to the start, {quantity.text(scale)} [-]"
    return quantity.axis_label


def trade_figure(result: Optimisation) -> Figure:
    """First objective over each of the others and the limited figures."""
    first, *rest = result.problem.figures
    names = rest[:3] or [first]
    figure = new_figure(1.0 + 3.6 * len(names), 3.8)
    computed = [point for point in result.evaluations if point.figures]
    front = list(result.front)
    within = [p for p in computed if p.feasible(result.allowed)]
    beyond = [p for p in computed if not p.feasible(result.allowed)]
    for axes, name in zip(np.atleast_1d(figure.subplots(1, len(names), sharey=True)), names, strict=True):
        for points, style in (
            (beyond, {"color": _LIGHT, "s": 12, "label": "above a limit"}),
            (within, {"color": BLUE, "s": 16, "label": "within the limits"}),
            (front, {"color": ORANGE, "s": 26, "label": "front"}),
            ([result.start], {"color": "k", "s": 40, "marker": "s", "label": "start"}),
        ):
            axes.scatter(_shares(points, result, name), _shares(points, result, first), **style)
        across = _shares(computed, result, name)
        if name in result.allowed:
            limit = result.allowed[name] / _scale(result, name)
            axes.axvline(limit, color=GREY, lw=0.8, ls="--")
            across = np.append(across, limit)
        _window(axes, across, _shares(computed, result, first))
        axes.set_xlabel(_label(result, name))
        axes.grid(alpha=0.3)
    figure.axes[0].set_ylabel(_label(result, first))
    figure.axes[0].legend(fontsize=8, frameon=False)
    return figure


def _window(axes: Axes, across: np.ndarray, up: np.ndarray) -> None:
    """Limit the axes to the points near the start."""
    for values, limits in ((across, axes.set_xlim), (up, axes.set_ylim)):
        near = values[values < _VIEW * max(1.0, float(np.median(values)))]
        low, high = float(near.min()), float(near.max())
        gap = 0.06 * max(high - low, 1e-3)
        limits(low - gap, high + gap)


def parallel_figure(result: Optimisation) -> Figure:
    """One line for each point of the front over variables and figures."""
    variables, names = result.problem.variables, result.problem.figures
    front = list(result.front) or [result.start]
    columns = [np.array([v.place(point.variables[v.name]) for point in front]) for v in variables]
    shares = [_shares(front, result, name) for name in names]
    own = [v.place(result.problem.start_values[v.name]) for v in variables]
    starts = [result.start.figures[name] / _scale(result, name) for name in names]
    ranges = [(min(float(s.min()), at), max(float(s.max()), at)) for s, at in zip(shares, starts, strict=True)]
    many = len(variables) + len(names)
    figure = new_figure(min(2.0 + 1.1 * many, 13.0), 4.4 if many < 12 else 6.0)
    axes = figure.add_subplot()

    def between(value: Any, span: tuple[float, float]) -> Any:
        return (value - span[0]) / (span[1] - span[0]) if span[1] > span[0] else 0.0 * value + 0.5

    lines = np.array([*columns, *map(between, shares, ranges)])
    start = [*own, *map(between, starts, ranges)]
    order = np.argsort(np.argsort(shares[0]))
    for k in range(len(front)):
        strength = 1.0 - 0.8 * order[k] / max(len(front) - 1, 1)
        axes.plot(lines[:, k], color=BLUE, alpha=float(strength), lw=1.2)
    axes.plot(start, color="k", lw=1.6, ls="--", marker="s", ms=4, label="start")
    heads = [f"{v.quantity.label}\n{v.quantity.span(v.low, v.high)}" for v in variables]
    heads += [
        f"{quantities()[name].label}\n"
        + (f"{low:.2g} to {high:.2g} %" if name == "edge_load_share" else f"{100.0 * low:.0f} to {100.0 * high:.0f} %")
        for name, (low, high) in zip(names, ranges, strict=True)
    ]
    axes.set_xticks(
        range(len(heads)), heads, **({"rotation": 60, "ha": "right"} if many < 12 else {"rotation": 90}), fontsize=8
    )
    axes.set_yticks([0.0, 1.0], ["low", "high"])
    axes.set_xlabel("variables between their bounds, figures relative to the start [-]")
    axes.grid(axis="x", alpha=0.4)
    axes.legend(fontsize=8, frameon=False, loc="upper right")
    return figure


def progress_figure(result: Optimisation, ax: Axes | None = None) -> Axes:
    """Least value of the first objective so far, over the evaluations."""
    name = result.problem.objectives[0]
    axes = axes_or_new(ax, 6.4, 3.4)
    kept = np.array([p.figures[name] if p.feasible(result.allowed) else np.inf for p in result.evaluations])
    least = np.minimum.accumulate(kept)
    scale = result.start.figures[name]
    known = np.isfinite(least)
    axes.step(np.flatnonzero(known), least[known] / scale, where="post", color=BLUE, lw=1.5)
    within = np.isfinite(kept)
    axes.scatter(np.flatnonzero(within), kept[within] / scale, color=GREY, s=10)
    axes.set(xlabel="evaluations [-]", ylabel=_label(result, name))
    axes.grid(alpha=0.3)
    return axes
