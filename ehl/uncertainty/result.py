"""Interval of a result by uncertain inputs, and the contribution of each input."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

import numpy as np

from ehl.common.arrays import FloatArray, finite_or_none
from ehl.common.errors import InputError
from ehl.common.figures import BLUE, GREY, axes_or_new
from ehl.common.pages import TableResult
from ehl.common.quantities import Quantity, quantities, typeset_unit
from ehl.common.sections import Head, Medium, Picture, Section
from ehl.common.table import Column, Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LEVEL = 0.90
_BARS = 12  # largest number of bars of a figure


def score_of(level: float) -> float:
    """Half width of the central interval of coverage `level` of a normal distribution, in standard deviations.

    Raises `InputError`: the level is not between 0 and 1.
    """
    if not 0.0 < level < 1.0:
        raise InputError("level", level, "between 0 and 1, such as 0.9")
    return NormalDist().inv_cdf(0.5 + 0.5 * level)


@dataclass(frozen=True)
class Change:
    """Change of friction or loss by one uncertain input."""

    name: str  # of the input
    group: str  # inputs of one cause, for a headline
    sd: float  # standard deviation of the input: of its logarithm, or in SI units; nan if it depends on the place
    # change of ln(friction) at the lower and upper end of the interval of this input
    below: Any
    above: Any
    note: str = ""  # source of spread and change


def combined(changes: Sequence[Change]) -> tuple[FloatArray, FloatArray]:
    """Both ends of ln(friction) relative to its value for independent inputs: root sum of squares on each side.

    lower = -sqrt(sum min(below, above, 0)^2), upper = sqrt(sum max(below, above, 0)^2). This is exact for one input and
    for a linear ln(friction). An input that increases friction at both its ends widens the upper side only.
    """
    down: FloatArray | float = 0.0
    up: FloatArray | float = 0.0
    for change in changes:
        low, high = np.minimum(change.below, change.above), np.maximum(change.below, change.above)
        down = down + np.minimum(low, 0.0) ** 2
        up = up + np.maximum(high, 0.0) ** 2
    return np.asarray(-np.sqrt(down)), np.asarray(np.sqrt(up))


# change of ln(friction) with several inputs shifted together; each case has the scores of the inputs by name, in units
# of the score of the level
Together = Callable[[Sequence[Mapping[str, float]]], Sequence[float]]

# tuned: 89 to 94 % of random draws of all inputs lie in the interval of a contact (docs/uncertainty.md); more repeats
# cost more and give wider intervals
STEP = 0.25  # of a score for the derivatives at an end, in units of the score of the level
SMALL = 0.1  # of the root sum of squares: inputs with smaller changes keep their first score
WEIGHTS = (1.0, 0.5)  # of the steepest direction in those tried, the rest is the first direction


def ends(
    changes: Sequence[Change], together: Together | None = None, slopes: Together | None = None
) -> tuple[float, float]:
    """Both ends of ln(friction) relative to its value.

    The changes by single inputs give a first direction of the scores. With ``together`` friction is computed there with
    all inputs shifted, so that saturation, such as that of the asperity load share, is included. Without it, or if it
    has no value, `combined` is used.

    With ``slopes`` each direction is corrected once (first-order reliability method, Hasofer and Lind 1974, with the
    iteration of Rackwitz and Fiessler 1978): the derivatives at the end found give the steepest direction. As it may
    overshoot, a direction between both is tried as well. The farthest point is the end.

    together: friction with several inputs shifted.
    slopes: the same for derivatives, which need less accuracy; None for friction that is expensive to compute.
    """
    found = [float(end) for end in combined(changes)]
    if together is None or len(changes) < 2:
        return found[0], found[1]
    names, sides = [change.name for change in changes], np.array([-1.0, 1.0])
    below, above = (sides[:, None] * [float(getattr(change, end)) for change in changes] for end in ("below", "above"))
    first = np.where(above >= below, np.maximum(above, 0.0), -np.maximum(below, 0.0))
    length = np.linalg.norm(first, axis=1)

    def at(points: FloatArray, of: Together) -> FloatArray:
        """Change of ln(friction) towards each end; points: scores, of shape (end, point, input)."""
        rows = points.reshape(-1, len(names))
        cases = [{name: float(z) for name, z in zip(names, row, strict=True) if z != 0.0} for row in rows]
        values = np.array([float(value) for value in of(cases)], dtype=np.float64)
        return np.asarray(sides[:, None] * values.reshape(points.shape[:2]))

    point = first / np.where(length > 0.0, length, 1.0)[:, None]
    value = at(point[:, None], together)[:, 0]
    large = np.maximum(np.abs(below), np.abs(above)).max(axis=0) > SMALL * length.min()
    if slopes and np.any(large) and np.all(np.isfinite(value)):
        steps = np.where(point < 0.0, -STEP, STEP)[:, large]
        moved = np.repeat(point[:, None], steps.shape[1] + 1, axis=1)
        moved[:, 1:, large] += steps[:, :, None] * np.eye(steps.shape[1])
        near = at(moved, slopes)
        slope = np.nan_to_num((near[:, 1:] - near[:, :1]) / steps)
        steepest = np.where(large, 0.0, point)
        left = np.sqrt(np.maximum(1.0 - np.sum(steepest**2, axis=1, keepdims=True), 0.0))
        steepest[:, large] = left * slope / np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-12)
        tried = np.stack([point + weight * (steepest - point) for weight in WEIGHTS], axis=1)
        tried /= np.maximum(np.linalg.norm(tried, axis=2, keepdims=True), 1e-12)
        value = np.fmax(value, np.fmax.reduce(at(tried, together), axis=1))
    for k in (0, 1):
        if length[k] > 0.0 and math.isfinite(value[k]):
            found[k] = float(sides[k] * max(value[k], 0.0))
    return found[0], found[1]


@dataclass(frozen=True)
class UncertaintySource(Change):
    """One uncertain input; `below` and `above` are the result with it at the ends of its interval."""

    share: float = 0.0  # of the sum of the squared changes by single inputs, over both ends [-]

    @property
    def label(self) -> str:
        """Label of the input."""
        known = quantities().get(self.name)
        return self.name.replace("_", " ") if known is None else known.label

    @property
    def low(self) -> float:
        """Lower end of the result by this input."""
        return min(float(self.below), float(self.above))

    @property
    def high(self) -> float:
        """Upper end of the result by this input."""
        return max(float(self.below), float(self.above))


@dataclass(frozen=True, repr=False)
class InputUncertainty(TableResult):
    """Interval of a result by the uncertainty of its inputs, without the error of the solver."""

    name: str  # of the result (`efficiency`, `friction_coefficient`)
    # the result and its interval, SI
    value: float
    low: float
    high: float
    level: float  # coverage of the interval [-]
    sources: tuple[UncertaintySource, ...]  # contributions, largest first
    notes: tuple[str, ...] = ()  # contributions that are not in the interval

    @classmethod
    def of(
        cls,
        name: str,
        value: float,
        changes: Sequence[Change],
        figure: Callable[[float], float],
        level: float = LEVEL,
        notes: Sequence[str] = (),
        together: Together | None = None,
        slopes: Together | None = None,
    ) -> InputUncertainty:
        """Interval from the changes of ln(friction or loss); `figure` converts such a change to the result.

        together, slopes: as in `ends`.
        """
        parts = [float(np.square(combined([change])).sum()) for change in changes]
        total = sum(parts)
        sources = []
        for change, part in zip(changes, parts, strict=True):
            alone = figure(float(change.below)), figure(float(change.above))
            share = part / total if total > 0.0 else 0.0
            sources.append(UncertaintySource(change.name, change.group, change.sd, *alone, change.note, share))
        down, up = ends(changes, together, slopes)
        sources.sort(key=lambda source: -source.share)
        low, high = sorted((figure(down), figure(up)))
        return cls(name, value, low, high, level, tuple(sources), tuple(notes))

    @property
    def quantity(self) -> Quantity:
        """Quantity of the result."""
        return quantities()[self.name]

    @property
    def groups(self) -> dict[str, float]:
        """Half width by each cause, the largest first; inputs of one cause add as squares."""
        squares: dict[str, float] = {}
        for source in self.sources:
            squares[source.group] = squares.get(source.group, 0.0) + (0.5 * (source.high - source.low)) ** 2
        return {name: math.sqrt(square) for name, square in sorted(squares.items(), key=lambda item: -item[1])}

    def headline(self, most: int = 3) -> str:
        """Result, interval and largest contributions as text."""
        shown, unit = self.quantity, self.quantity.display
        width = float(shown.to_display(self.high) - shown.to_display(self.low))
        digits = max(0, 1 - math.floor(math.log10(width))) if width > 0.0 else 4  # two significant ones of the width
        low, value, high = (f"{shown.to_display(end):.{digits}f}" for end in (self.low, self.value, self.high))
        text = f"{value} {unit}".strip() + f" ({low} to {high})"
        kept = [(name, half) for name, half in self.groups.items() if half > 0.05 * (self.high - self.low)][:most]
        if not kept:
            return text
        parts = ", ".join(f"{name} {shown.to_display(half):.{digits}f}" for name, half in kept)
        return f"{text}, of which {parts}" + (" points" if unit == "%" else "")

    def __repr__(self) -> str:
        return f"InputUncertainty({self.quantity.label} {self.headline()})"

    def to_dict(self) -> dict[str, Any]:
        """Content for JSON, with None for values that are not finite."""
        content: dict[str, Any] = finite_or_none(self)
        return content

    def table(self) -> Table:
        """Table of the contributions, largest first."""
        head = self.quantity.label
        columns = (
            Column("input", label="input"),
            Column("below", of=self.name, label=f"{head} at its lower end"),
            Column("above", of=self.name, label="at its upper end"),
            Column("share", of="share", label="share of the squares", digits=3),
            Column("sd", label="standard deviation", digits=3),
            Column("note", label="from"),
        )
        rows = [(s.label, s.below, s.above, s.share, s.sd, s.note) for s in self.sources]
        title = f"Input uncertainty: {head} {self.headline()} ({100.0 * self.level:.0f} % interval)."
        return Table(columns, rows, title=title, notes=self.notes, name="uncertainty")

    def sections(self, medium: Medium = "page", *args: Any, **options: Any) -> list[Section]:
        """Bars of the change by each input alone, and its table."""
        bars = Picture(lambda: plot_sources(self), "Change by each input alone.", "uncertainty")
        return [Section("", [Head(f"Input uncertainty: {self.quantity.label}", self.headline()), bars, self.table()])]

    def _plot(self, ax: Axes | None, **options: Any) -> Axes:
        return plot_sources(self, ax)


def plot_sources(found: InputUncertainty, ax: Axes | None = None) -> Axes:
    """One bar for each input from the lower to the upper end by this input, the widest on top."""
    shown = found.quantity
    sources = [s for s in found.sources if s.high > s.low][:_BARS]
    axes = axes_or_new(ax, 7.0, 1.6 + 0.32 * (len(sources) + 1))
    bars = [("all inputs", found.low, found.high, GREY)]
    bars += [(source.label, source.low, source.high, BLUE) for source in sources]
    for place, (_, low, high, colour) in enumerate(bars):
        left, right = shown.to_display(low), shown.to_display(high)
        axes.barh(place, right - left, left=left, height=0.6, color=colour)
    axes.axvline(shown.to_display(found.value), color="black", lw=0.8)
    axes.set_yticks(range(len(bars)), [name for name, *_ in bars])
    axes.invert_yaxis()
    unit = typeset_unit(shown.display)
    axes.set_xlabel(f"{shown.label} [{unit or '-'}], {100.0 * found.level:.0f} % interval")
    axes.set_title("Contribution of each input", fontsize=10)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.tick_params(axis="y", length=0)
    return axes
