"""Report sections and figures of a parameter study: efficiency over each parameter, designs, influences."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from efficiency.conditions.conditions import level_quantity
from efficiency.design.design import MISALIGNMENTS
from efficiency.loss.efficiency_result import pair_notes
from efficiency.output.gear_report import SPIN
from efficiency.output.tables import outside_note, percent, timing
from efficiency.studies.parameter_study import Study, StudyPoint
from ehl.common.data import reason_text
from ehl.common.figures import BLUE, GREY, ORANGE, axes_or_new, new_figure, panels
from ehl.common.notes import Note
from ehl.common.quantities import quantities, to_display, typeset_units
from ehl.common.sections import Head, Item, KeyFigures, MainResult, Medium, Notes, Picture, Section, Text, picture
from ehl.common.table import Column, Table
from regression.friction.published_registry import model_label

_MARKERS = "os^vD<>P"
# combinations shown: (parameter along the axis, parameter of the lines)
_CROSSED = (
    *(("torque", "speed"), ("speed", "temperature")),
    *(("temperature", "roughness_rms_each"), ("roughness_rms_each", "speed")),
)


def reference_text(study: Study, *without: str) -> str:
    """The reference as text, without the parameters that a figure varies."""
    levels = [level_quantity(name).text(value) for name, value in study.reference.items() if name not in without]
    return typeset_units(", ".join(levels))


def study_figures(study: Study) -> Iterator[Picture]:
    """Figures of all varied parameters."""
    if len(study.designs) > 1 and set(study.varied) & set(study.reference):
        yield picture("designs", "Each single parameter, the others at the reference.", designs_figure, study)
    offsets = {study.reference_point(design).hypoid_offset for design in study.designs}
    if len(offsets) > 1:
        caption = (
            "Designs by their hypoid offset. They differ in more than the offset, because spiral angles, cutters and "
            "settings depend on it."
        )
        yield picture("offset", caption, offset_figure, study)
    for along, lines in _CROSSED:
        if len(getattr(study.levels, along)) > 1:
            caption = f"Efficiency over {level_quantity(along).label}, with the other parameters as stated."
            yield picture(f"over_{along}", caption, crossed_figure, study, along, lines)
    if any(study.levels.shifts()):
        caption = f"One misalignment at a time, added to that of the design; {reference_text(study)}."
        yield picture("misalignment", caption, misalignment_figure, study)
    caption = "Range of the efficiency over the levels of each single parameter."
    yield picture("influence", caption, plot_study, study)
    if causes_of(study):
        caption = (
            "Half width of the 90 % interval of the efficiency at the reference from each single cause. Measuring the "
            "causes with the longest bars reduces the interval most. The numerical error is not included."
        )
        yield picture("causes", caption, causes_figure, study)


def crossed_figure(study: Study, along: str, lines: str) -> Axes:
    """Efficiency along one parameter, one line for each value of another, one panel for each design."""
    count = len(study.designs)
    all_axes = panels(count, count, (1.6, 0.0), (4.2, 3.9), sharey=True)
    levels = getattr(study.levels, lines)
    shades = colormaps["viridis"](np.linspace(0.05, 0.85, max(len(levels), 2)))
    for axes, design in zip(all_axes, study.designs, strict=True):
        for number, level in enumerate(levels):
            points = study.section(design, along, **{lines: level})
            label = typeset_units(level_quantity(lines).text(level))
            _line(axes, points, along, color=shades[number], marker=_MARKERS[number % 8], label=label)
        axes.set(xlabel=level_quantity(along).axis_label, title=f"{design}\n{reference_text(study, along, lines)}")
        axes.title.set_fontsize(9)
        axes.grid(alpha=0.3)
    all_axes[0].set_ylabel("mesh efficiency [%]")
    place: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5)}
    all_axes[-1].legend(title=level_quantity(lines).label, fontsize=8, title_fontsize=8, frameon=False, **place)
    return all_axes[0]


def designs_figure(study: Study) -> Axes:
    """Efficiency over each operating parameter with all designs in one panel; the band is the interval of the model."""
    names = [name for name in study.varied if name in study.reference]
    all_axes = panels(len(names), 2, (1.0, 0.6), (4.6, 3.2), sharey=True)
    for place, (axes, name) in enumerate(zip(all_axes, names, strict=True)):
        for number, design in enumerate(study.designs):
            points = study.section(design, name)
            x = [level_quantity(name).to_display(getattr(point, name)) for point in points]
            low, high = ([100.0 * getattr(p, f"efficiency_{end}") for p in points] for end in ("lower", "upper"))
            axes.fill_between(x, low, high, color=_colour(number), alpha=0.15, lw=0.0)
            _line(axes, points, name, **_style(study, number))
        axes.set(xlabel=level_quantity(name).axis_label, title=f"at {reference_text(study, name)}")
        axes.title.set_fontsize(9)
        axes.grid(alpha=0.3)
        if place % 2 == 0:
            axes.set_ylabel("mesh efficiency [%]")
    all_axes[0].legend(fontsize=8, frameon=False)
    return all_axes[0]


def offset_figure(study: Study) -> Figure:
    """Efficiency and mean friction coefficient over the hypoid offset of the designs, one line for each torque."""
    figure = new_figure(9.4, 3.9)
    left, right = figure.subplots(1, 2)
    ordered = sorted(study.designs, key=lambda design: study.reference_point(design).hypoid_offset)
    shades = colormaps["viridis"](np.linspace(0.05, 0.85, max(len(study.levels.torque), 2)))
    for number, torque in enumerate(study.levels.torque):
        points = [
            next(p for p in study.section(design, "torque") if p.torque == torque and p.aligned) for design in ordered
        ]
        x = [level_quantity("hypoid_offset").to_display(point.hypoid_offset) for point in points]
        style = {"color": shades[number], "marker": _MARKERS[number % 8], "ms": 4, "lw": 1.3}
        left.plot(x, [100.0 * p.efficiency for p in points], label=level_quantity("torque").text(torque), **style)
        right.plot(x, [p.friction_coefficient_mean for p in points], **style)
    for axes, label in ((left, "mesh efficiency [%]"), (right, "mean friction coefficient [-]")):
        axes.set(xlabel=level_quantity("hypoid_offset").axis_label, ylabel=label)
        axes.grid(alpha=0.3)
    left.legend(title="pinion torque", fontsize=8, title_fontsize=8, frameon=False)
    figure.suptitle(f"at {reference_text(study, 'torque')}", fontsize=10)
    return figure


def misalignment_figure(study: Study) -> Figure:
    """Efficiency (top) and maximum pressure (bottom) over each misalignment, all designs in one panel."""
    names = [name for name in study.varied if name not in study.reference]
    figure = new_figure(1.0 + 3.1 * len(names), 5.4)
    grid = figure.subplots(2, len(names), sharey="row", squeeze=False)
    for column, name in enumerate(names):
        for number, design in enumerate(study.designs):
            points = study.section(design, name)
            for axes, value in zip(grid[:, column], ("efficiency", "pressure_hertz_max"), strict=True):
                _line(axes, points, name, value, **_style(study, number))
        grid[1, column].set_xlabel(level_quantity(name).axis_label.replace(" [", "\n["))
        for axes in grid[:, column]:
            axes.axvline(0.0, color=GREY, lw=0.7)
            axes.grid(alpha=0.3)
    grid[0, 0].set_ylabel("mesh efficiency [%]")
    grid[1, 0].set_ylabel("maximum Hertz pressure [GPa]")
    grid[0, 0].legend(fontsize=7, frameon=False)
    return figure


def plot_study(study: Study, ax: Axes | None = None) -> Axes:
    """Range of the efficiency over each single parameter, one bar per parameter and design; a line at the reference."""
    names = study.varied or ["torque"]
    labels = [f"{level_quantity(name).label}\n{span_text(study, name)}" for name in names]
    ranges: dict[str, list[tuple[float, float]]] = {}  # bars of zero length would be invisible
    for design in study.designs:
        ends = (study.influence(design, name) for name in names)
        ranges[design] = [(100.0 * low, max(100.0 * (high - low), 0.004)) for low, high in ends]
    axes = _bars(study, labels, ranges, ax)
    for number, design in enumerate(study.designs):
        axes.axvline(100.0 * study.reference_point(design).efficiency, color=_colour(number), lw=0.9, ls="--")
    axes.tick_params(axis="y", labelsize=8)
    axes.margins(x=0.04)
    axes.set_xlabel("mesh efficiency [%]; dashed: reference")
    return axes


def _bars(
    study: Study, labels: Sequence[str], bars: Mapping[str, Sequence[tuple[float, float]]], ax: Axes | None = None
) -> Axes:
    """Horizontal bars, one for each label and design: `bars` has start and length by design."""
    count, rows = len(study.designs), np.arange(len(labels))[::-1]
    axes = axes_or_new(ax, 7.6, 1.1 + 0.34 * len(labels) * count + 0.2 * len(labels))
    for number, design in enumerate(study.designs):
        start, length = np.array(bars[design]).T
        style: dict[str, Any] = {"color": _colour(number), "label": _design_text(study, design)}
        axes.barh(rows + 0.8 * (0.5 - (number + 0.5) / count), length, left=start, height=0.72 / count, **style)
    axes.set_yticks(rows, labels)
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


def causes_figure(study: Study) -> Axes:
    """Half width of the interval of the efficiency, one bar per cause of uncertainty and design."""
    causes, points = causes_of(study), [study.reference_point(design) for design in study.designs]
    bars = {p.design: [(0.0, 100.0 * p.causes.get(cause, 0.0)) for cause in causes] for p in points}
    axes = _bars(study, causes, bars)
    axes.set_xlabel(f"half width of the mesh efficiency [% points] at {reference_text(study)}")
    return axes


def span_text(study: Study, name: str) -> str:
    """Range of the levels of a parameter; for a misalignment including zero."""
    levels = sorted({*getattr(study.levels, name), *(() if name in study.reference else (0.0,))})
    return typeset_units(level_quantity(name).span(levels[0], levels[-1]))


def _design_text(study: Study, design: str) -> str:
    return f"{design}, offset {1e3 * study.reference_point(design).hypoid_offset:.4g} mm"


def _colour(number: int) -> str | tuple[float, ...]:
    fixed = (BLUE, ORANGE, "#3b7a57", "#7a3b69")
    return fixed[number] if number < len(fixed) else tuple(colormaps["tab10"](number % 10))


def _style(study: Study, number: int) -> dict[str, Any]:
    """Colour, marker and label of a design."""
    label = _design_text(study, study.designs[number])
    return {"color": _colour(number), "marker": _MARKERS[number % 8], "label": label}


def _line(axes: Axes, points: list[StudyPoint], along: str, value: str = "efficiency", **style: Any) -> None:
    """One line with gaps at failed points."""
    x = [level_quantity(along).to_display(getattr(point, along)) for point in points]
    axes.plot(x, [to_display(value, getattr(point, value)) for point in points], ms=4, lw=1.3, **style)


_FAILED_SHOWN = 40
_OUTCOME = ("status", "reason")
_SECTION = (
    *("efficiency", "efficiency_lower", "efficiency_upper", "power_loss", "friction_coefficient_mean"),
    *("film_ratio", "pressure_hertz_max", *_OUTCOME),
)


def _column(name: str) -> Column:
    """Column of a field of a study point."""
    return Column(name, of=level_quantity(name).name if name in quantities() or name in MISALIGNMENTS else "")


def study_tables(study: Study) -> list[Table]:
    """All points, the levels and the notes."""
    points = Table.from_records([point.scalars() for point in study.points]).records()
    levels = [
        (name, level_quantity(name).unit, ", ".join(f"{value:.6g}" for value in values), study.reference.get(name, 0.0))
        for name, values in study.levels.to_dict().items()
    ]
    return [
        Table([_column(name) for name in points[0]], [tuple(point.values()) for point in points], name="study"),
        Table(("parameter", "SI unit", "values", Column("reference", label="reference")), levels, name="levels"),
        Table(("note", "points"), list(study.notes.items()), name="notes"),
    ]


def section_table(study: Study, design: str, name: str) -> Table:
    """The section of one design along one parameter."""
    columns = (name, *(_SECTION if study.failed else _SECTION[: -len(_OUTCOME)]))
    return Table(
        [_column(column) for column in columns],
        [[getattr(point, column) for column in columns] for point in study.section(design, name)],
        title=f"{design}: {level_quantity(name).label}, at {reference_text(study, name)}.",
    )


def influence_table(study: Study) -> Table:
    """Levels of each parameter, and minimum and maximum efficiency of each design."""
    columns: list[Column | str] = ["parameter", "levels"]
    for design in study.designs:
        of = f"{design}, " * (len(study.designs) > 1)
        columns += [Column(f"{design}: {end}", "efficiency", of + end) for end in ("minimum", "maximum")]
    rows: list[tuple[object, ...]] = []
    at = [study.reference_point(design).efficiency for design in study.designs]
    rows.append(("reference", reference_text(study), *(value for value in at for _ in range(2))))
    for name in study.varied:
        ends = [end for design in study.designs for end in study.influence(design, name)]
        rows.append((level_quantity(name).label, span_text(study, name), *ends))
    model = model_label(study.friction_model)
    failed = (f"failed   {point.label}: {reason_text(point.reason)}" for point in study.failed[:_FAILED_SHOWN])
    return Table(
        columns,
        rows,
        title=f"efficiency over each single parameter, {study.side}, {study.oil}, friction: {model}",
        notes=(*failed, timing(study, f"{len(study.points)} points")),
        name="influence",
    )


def study_notes(study: Study) -> list[Note]:
    """Notes on all points, one for each kind with its count and worst point, the most severe first."""
    said = []
    for point in study.points:
        said += [(point.label, note) for note in point.notes]
        if point.status == "failed":
            said.append((point.label, f"no result: {reason_text(point.reason)}"))
        elif outside := outside_note(point.outside_range_share, model_label(study.friction_model)):
            said.append((point.label, outside))
    return pair_notes(said)


def study_sections(study: Study, medium: Medium) -> list[Section]:
    """Sections of a study: influence of each parameter, uncertainty, efficiency over the parameters, all points."""
    title = f"parameter study: {', '.join(study.designs)}"
    if medium == "files":
        return [Section("", [Head(title), *study_tables(study)])]
    if medium == "terminal":
        return [Section("", [influence_table(study), Notes(study_notes(study), len(study.points))])]
    pictures = {picture.name: picture for picture in study_figures(study)}
    influence, causes = pictures.pop("influence"), pictures.pop("causes", None)
    head = Head(
        "Parameter study: mesh efficiency",
        f"{', '.join(study.designs)}; {study.side} side, {study.oil}, friction: {model_label(study.friction_model)}",
        f"{timing(study, f'{len(study.points)} points').capitalize()}. {SPIN}",
    )
    cuts = [section_table(study, design, name) for name in study.varied for design in study.designs]
    model = model_label(study.friction_model)
    certain = f"The friction model ({model}) has no uncertain inputs and therefore no interval."
    return [
        Section("", [head, *_headline(study)]),
        Section("Influence of each parameter", [influence, replace(influence_table(study), title="", notes=())]),
        Section("Sources of uncertainty", [causes, causes_table(study)] if causes else [Text(certain)]),
        Section("Efficiency over the parameters", list(pictures.values())),
        Section("Sections through the reference", cuts),
        Section("Method", _computed(study)),
    ]


def causes_table(study: Study) -> Table:
    """Half width of the interval of the efficiency from each cause of uncertainty, at the reference of each design."""
    points = [study.reference_point(design) for design in study.designs]
    columns: list[Column | str] = ["cause", *(Column(p.design, of="efficiency_error", label=p.design) for p in points)]
    rows = [(cause, *(p.causes.get(cause, 0.0) for p in points)) for cause in causes_of(study)]
    title = "Half width of the efficiency from each single cause, in percentage points; combine as root sum of squares."
    return Table(columns, rows, title=title, name="causes")


def _headline(study: Study) -> list[Item]:
    points = [study.reference_point(design) for design in study.designs]
    first = points[0]
    tiles = [
        (f"{percent(p.efficiency, 2)} %", f"{p.design}, {_interval(p)}, offset {1e3 * p.hypoid_offset:.4g} mm")
        for p in points[1:10]
    ]
    widths = [(name, *study.influence(first.design, name)) for name in study.varied]
    widths = sorted((w for w in widths if math.isfinite(w[1])), key=lambda w: w[1] - w[2])
    tiles += [
        (f"{percent(high - low, 2)} points", f"range over {level_quantity(name).label}, {span_text(study, name)}")
        for name, low, high in widths[:4]
    ]
    known = []
    if first.efficiency_lower < first.efficiency_upper:
        known.append((_interval(first), "90 % interval from uncertain inputs"))
    if math.isfinite(first.efficiency_error):
        known.append((f"±\N{NO-BREAK SPACE}{100.0 * first.efficiency_error:.1g} %", "numerical error"))
    ends = [point.efficiency for point in study.points if math.isfinite(point.efficiency)]
    if ends:
        span = f"{percent(min(ends), 2)} to {percent(max(ends), 2)} %"
        known.append((span, f"range of all {len(study.points)} points"))
    value = f"{percent(first.efficiency, 2)} %" if math.isfinite(first.efficiency) else "no result"
    answer = MainResult(value, f"mesh efficiency of {first.design} at {reference_text(study)}", known)
    notes = Notes(study_notes(study), len(study.points))
    return [answer, *([KeyFigures(tiles)] if tiles else []), notes]


def _interval(point: StudyPoint) -> str:
    return f"{percent(point.efficiency_lower, 2)} to {percent(point.efficiency_upper, 2)} %"


def _computed(study: Study) -> list[Item]:
    blocks: list[Item] = [
        Text(
            "Every operating point is a combination of the levels of torque, speed, temperature and roughness for the "
            "aligned pair; misalignments are varied one at a time at the reference. The load is solved once for each "
            "torque and misalignment. All points are in study.csv and study.xlsx."
        )
    ]
    if study.failed:
        rows = [(point.label, point.reason) for point in study.failed]
        blocks.append(Table(("failed point", "reason"), rows))
    return blocks
