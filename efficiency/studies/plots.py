"""Figures of a parameter study: efficiency over each parameter, comparison of designs, influences."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps

from efficiency.studies.parameter_study import level_quantity
from ehl.common.figures import BLUE, GREY, ORANGE, axes_or_new, new_figure
from ehl.common.quantities import to_display, typeset_units
from ehl.common.sections import Picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from efficiency.studies.parameter_study import Study, StudyPoint

_MARKERS = "os^vD<>P"
# combinations shown: (parameter along the axis, parameter of the lines)
_CROSSED = (
    *(("torque", "speed"), ("speed", "temperature")),
    *(("temperature", "roughness_rms_each"), ("roughness_rms_each", "speed")),
)


def reference_text(study: Study, *without: str) -> str:
    """The reference in words, without the parameters that a figure varies."""
    levels = [level_quantity(name).text(value) for name, value in study.reference.items() if name not in without]
    return typeset_units(", ".join(levels))


def study_figures(study: Study) -> Iterator[Picture]:
    """Figures of all varied parameters."""

    def picture(name: str, caption: str, draw: Callable[..., Figure | Axes], *args: str) -> Picture:
        return Picture(partial(draw, study, *args), caption, name)

    if len(study.designs) > 1 and set(study.varied) & set(study.reference):
        yield picture("designs", "Each single parameter, the others at the reference.", designs_figure)
    offsets = {study.reference_point(design).hypoid_offset for design in study.designs}
    if len(offsets) > 1:
        caption = (
            "Designs by their hypoid offset. They differ in more than the offset, because spiral angles, cutters and "
            "settings depend on it."
        )
        yield picture("offset", caption, offset_figure)
    for along, lines in _CROSSED:
        if len(getattr(study.levels, along)) > 1:
            caption = f"Efficiency over {level_quantity(along).label}, with the other parameters as stated."
            yield picture(f"over_{along}", caption, crossed_figure, along, lines)
    if any(study.levels.shifts()):
        caption = f"One misalignment at a time, added to that of the design; {reference_text(study)}."
        yield picture("misalignment", caption, misalignment_figure)
    yield picture("influence", "Range of the efficiency over the levels of each single parameter.", influence_figure)
    if causes_of(study):
        caption = (
            "Half width of the 90 % interval of the efficiency at the reference from each single cause. Measuring the "
            "causes with the longest bars reduces the interval most. The numerical error is not included."
        )
        yield picture("causes", caption, causes_figure)


def crossed_figure(study: Study, along: str, lines: str) -> Figure:
    """Efficiency along one parameter, one line for each value of another, one panel for each design."""
    figure = new_figure(1.6 + 4.2 * len(study.designs), 3.9)
    panels = np.atleast_1d(figure.subplots(1, len(study.designs), sharey=True))
    levels = getattr(study.levels, lines)
    shades = colormaps["viridis"](np.linspace(0.05, 0.85, max(len(levels), 2)))
    for axes, design in zip(panels, study.designs, strict=True):
        for number, level in enumerate(levels):
            points = study.section(design, along, **{lines: level})
            label = typeset_units(level_quantity(lines).text(level))
            _line(axes, points, along, colour=shades[number], marker=_MARKERS[number % 8], label=label)
        axes.set(xlabel=level_quantity(along).axis_label, title=f"{design}\n{reference_text(study, along, lines)}")
        axes.title.set_fontsize(9)
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("mesh efficiency [%]")
    place = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5)}
    panels[-1].legend(title=level_quantity(lines).label, fontsize=8, title_fontsize=8, frameon=False, **place)
    return figure


def designs_figure(study: Study) -> Figure:
    """Efficiency over each operating parameter with all designs in one panel; the band is the interval of the model."""
    names = [name for name in study.varied if name in study.reference]
    columns = min(len(names), 2)
    rows = -(-len(names) // 2)
    figure = new_figure(1.0 + 4.6 * columns, 0.6 + 3.2 * rows)
    panels = figure.subplots(rows, columns, sharey=True, squeeze=False)
    for axes, name in zip(panels.ravel(), names, strict=False):
        for number, design in enumerate(study.designs):
            points, colour = study.section(design, name), _colour(number)
            x = [level_quantity(name).to_display(getattr(point, name)) for point in points]
            low, high = (
                np.array([100.0 * getattr(point, bound) for point in points], dtype=float)
                for bound in ("efficiency_lower", "efficiency_upper")
            )
            axes.fill_between(x, low, high, color=colour, alpha=0.15, lw=0.0)
            _line(axes, points, name, colour=colour, marker=_MARKERS[number % 8], label=_design_text(study, design))
        axes.set(xlabel=level_quantity(name).axis_label, title=f"at {reference_text(study, name)}")
        axes.title.set_fontsize(9)
        axes.grid(alpha=0.3)
    for axes in panels.ravel()[len(names) :]:
        axes.set_axis_off()
    for row in panels:
        row[0].set_ylabel("mesh efficiency [%]")
    panels[0, 0].legend(fontsize=8, frameon=False)
    return figure


def offset_figure(study: Study) -> Figure:
    """Efficiency and mean friction coefficient over the hypoid offset of the designs, one line for each torque."""
    figure = new_figure(9.4, 3.9)
    panels = figure.subplots(1, 2)
    ordered = sorted(study.designs, key=lambda design: study.reference_point(design).hypoid_offset)
    shades = colormaps["viridis"](np.linspace(0.05, 0.85, max(len(study.levels.torque), 2)))
    for number, torque in enumerate(study.levels.torque):
        points = [
            next(p for p in study.section(design, "torque") if p.torque == torque and p.aligned) for design in ordered
        ]
        x = [level_quantity("hypoid_offset").to_display(point.hypoid_offset) for point in points]
        style = {"color": shades[number], "marker": _MARKERS[number % 8], "ms": 4, "lw": 1.3}
        panels[0].plot(x, [100.0 * p.efficiency for p in points], label=level_quantity("torque").text(torque), **style)
        panels[1].plot(x, [p.friction_coefficient_mean for p in points], **style)
    panels[0].set(ylabel="mesh efficiency [%]")
    panels[1].set(ylabel="mean friction coefficient [-]")
    for axes in panels:
        axes.set(xlabel=level_quantity("hypoid_offset").axis_label)
        axes.grid(alpha=0.3)
    panels[0].legend(title="pinion torque", fontsize=8, title_fontsize=8, frameon=False)
    figure.suptitle(f"at {reference_text(study, 'torque')}", fontsize=10)
    return figure


def misalignment_figure(study: Study) -> Figure:
    """Efficiency (top) and maximum pressure (bottom) over each misalignment, all designs in one panel."""
    names = [name for name in study.varied if name not in study.reference]
    figure = new_figure(1.0 + 3.1 * len(names), 5.4)
    panels = figure.subplots(2, len(names), sharey="row", squeeze=False)
    for column, name in enumerate(names):
        for number, design in enumerate(study.designs):
            points = study.section(design, name)
            colour, marker, label = _colour(number), _MARKERS[number % 8], _design_text(study, design)
            _line(panels[0, column], points, name, colour=colour, marker=marker, label=label)
            _line(panels[1, column], points, name, colour=colour, marker=marker, label=label, value="pressure_max")
        panels[1, column].set_xlabel(level_quantity(name).axis_label.replace(" [", "\n["))
        for row in panels:
            row[column].axvline(0.0, color=GREY, lw=0.7)
            row[column].grid(alpha=0.3)
    panels[0, 0].set_ylabel("mesh efficiency [%]")
    panels[1, 0].set_ylabel("maximum Hertz pressure [GPa]")
    panels[0, 0].legend(fontsize=7, frameon=False)
    return figure


def influence_figure(study: Study, ax: Axes | None = None) -> Axes:
    """Range of the efficiency over each single parameter, one bar per parameter and design; a line at the reference."""
    names = study.varied or ["torque"]
    count = len(study.designs)
    axes = axes_or_new(ax, 7.6, 1.1 + 0.34 * len(names) * count + 0.2 * len(names))
    for number, design in enumerate(study.designs):
        bounds = [study.influence(design, name) for name in names]
        low, high = (np.array([100.0 * bound[side] for bound in bounds]) for side in (0, 1))
        place = np.arange(len(names))[::-1] + 0.8 * (0.5 - (number + 0.5) / count)
        # bars of zero length would be invisible
        length, label = np.maximum(high - low, 0.004), _design_text(study, design)
        axes.barh(place, length, left=low, height=0.72 / count, color=_colour(number), label=label)
        axes.axvline(100.0 * study.reference_point(design).efficiency, color=_colour(number), lw=0.9, ls="--")
    labels = [f"{level_quantity(name).label}\n{span_text(study, name)}" for name in names]
    axes.set_yticks(np.arange(len(names))[::-1], labels, fontsize=8)
    axes.margins(x=0.04)
    axes.set_xlabel("mesh efficiency [%]; dashed: reference")
    axes.grid(axis="x", alpha=0.3)
    axes.legend(fontsize=8, frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=max(1, min(count, 3)))
    return axes


def causes_of(study: Study) -> list[str]:
    """Causes of uncertainty at the reference, sorted by their largest effect on any design."""
    largest: dict[str, float] = {}
    for design in study.designs:
        for cause, half in study.reference_point(design).causes.items():
            if math.isfinite(half) and half > 0.0:
                largest[cause] = max(half, largest.get(cause, 0.0))
    return sorted(largest, key=lambda cause: -largest[cause])


def causes_figure(study: Study) -> Figure:
    """Half width of the interval of the efficiency, one bar per cause of uncertainty and design."""
    causes, count = causes_of(study), len(study.designs)
    figure = new_figure(7.6, 1.1 + 0.34 * len(causes) * count + 0.2 * len(causes))
    axes = figure.add_subplot()
    for number, design in enumerate(study.designs):
        found = study.reference_point(design).causes
        place = np.arange(len(causes))[::-1] + 0.8 * (0.5 - (number + 0.5) / count)
        values = [100.0 * found.get(cause, 0.0) for cause in causes]
        axes.barh(place, values, height=0.72 / count, color=_colour(number), label=_design_text(study, design))
    axes.set_yticks(np.arange(len(causes))[::-1], causes)
    axes.set_xlabel(f"half width of the mesh efficiency [% points] at {reference_text(study)}")
    axes.grid(axis="x", alpha=0.3)
    axes.legend(fontsize=8, frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=max(1, min(count, 3)))
    return figure


def span_text(study: Study, name: str) -> str:
    """Range of the levels of a parameter; for a misalignment including zero."""
    levels = sorted({*getattr(study.levels, name), *(() if name in study.reference else (0.0,))})
    return typeset_units(level_quantity(name).span(levels[0], levels[-1]))


def _design_text(study: Study, design: str) -> str:
    return f"{design}, offset {1e3 * study.reference_point(design).hypoid_offset:.4g} mm"


def _colour(number: int) -> str | tuple[float, ...]:
    fixed = (BLUE, ORANGE, "#3b7a57", "#7a3b69")
    return fixed[number] if number < len(fixed) else tuple(colormaps["tab10"](number % 10))


def _line(
    axes: Axes,
    points: list[StudyPoint],
    along: str,
    *,
    colour: str | tuple[float, ...] | np.ndarray,
    marker: str,
    label: str,
    value: str = "efficiency",
) -> None:
    """One line with gaps at failed points."""
    x = [level_quantity(along).to_display(getattr(point, along)) for point in points]
    y = [to_display(value, getattr(point, value)) for point in points]
    axes.plot(x, y, color=colour, marker=marker, ms=4, lw=1.3, label=label)
