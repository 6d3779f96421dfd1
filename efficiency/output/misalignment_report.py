"""Report sections and figures of a misalignment study."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from efficiency.conditions.conditions import level_quantity
from efficiency.contact.flank_pair import ContactPattern, FlankPair, flank_pair
from efficiency.design.design import MISALIGNMENTS, Design
from efficiency.geometry.misalignment import LOADED, MisalignmentGrid, MisalignmentPoint, MisalignmentStudy
from efficiency.ltca.limits import EDGE_LIMIT
from efficiency.output.plots_geometry import flank_axes, member_figure
from ehl.common.arrays import FloatArray
from ehl.common.data import reason_text
from ehl.common.errors import ConvergenceError
from ehl.common.figures import BLUE, GREY, ORANGE, figure_of, new_figure, panels
from ehl.common.quantities import axis_label, quantity, to_display, typeset_units
from ehl.common.sections import Folded, Head, Item, Medium, Picture, Row, Section, picture
from ehl.common.table import Column, Table

_PATTERNS = 7
_DISTRIBUTED = ("peak_to_peak", *LOADED)


def _nearest_to_zero(study: MisalignmentStudy, *names: str) -> list[MisalignmentPoint]:
    """States with all misalignments other than these nearest to zero."""
    others = {other: min(getattr(study, other), key=abs) for other in MISALIGNMENTS if other not in names}
    return [p for p in study.points if all(getattr(p, other) == value for other, value in others.items())]


def section_points(study: MisalignmentStudy, name: str) -> tuple[FloatArray, list[MisalignmentPoint]]:
    """Values of one misalignment in the displayed unit, and its states with all others nearest to zero."""
    chosen = sorted(_nearest_to_zero(study, name), key=lambda point: float(getattr(point, name)))
    values = np.array([getattr(point, name) for point in chosen])
    return np.asarray(level_quantity(name).to_display(values)), chosen


Panel = tuple[str, str, Mapping[str, str]]
"""Title and label of a panel, and the fields of its curves with their texts."""
_SHARES = ("pattern_length", "pattern_area")
_STYLES: tuple[dict[str, Any], ...] = ({"marker": "o", "ms": 4}, {"marker": ".", "ls": "--"})
_POSITIONS = {"error_maximum_u": ", highest point of the TE", "pattern_u": ", centre of the pattern"}
_SIZES = {"pattern_length": ", length / face width", "pattern_area": ", area share"}
_UNLOADED: tuple[Panel, ...] = (
    ("unloaded transmission error", "TE, peak to peak [arcsec]", {"peak_to_peak": ""}),
    ("position of the contact", "along the gear face [mm]", _POSITIONS),
    ("size of the pattern", "of the gear [%]", _SIZES),
)
_FIELDS = ("transmission_error_loaded", "pressure_hertz_max", "edge_load_share", "efficiency")


def section_figure(studies: Sequence[MisalignmentStudy]) -> Figure:
    """One row per varied misalignment: transmission error, position along the face, size of the pattern."""
    others = "" if len(studies[0].varied) < 2 else "; each with the others nearest to zero"
    figure = _sections(studies, _UNLOADED, f", marking {1e6 * studies[0].marking:.4g} µm{others}")
    for axes in (*figure.axes[::3], *figure.axes[2::3]):
        axes.set_ylim(0.0, 1.05 * axes.get_ylim()[1])
    return figure


def loaded_figure(studies: Sequence[MisalignmentStudy]) -> Figure:
    """One row per varied misalignment: transmission error, pressure, edge load and efficiency at the torque."""
    panels: list[Panel] = [("", axis_label(field), {field: ""}) for field in _FIELDS]
    return _sections(studies, panels, f" at {quantity('torque').text(studies[0].torque or 0.0)} of the pinion")


def _sections(studies: Sequence[MisalignmentStudy], panels: Sequence[Panel], case: str) -> Figure:
    """One row of panels for each varied misalignment."""
    names = studies[0].varied or ["E"]
    figure = new_figure(5.0 + 2.0 * len(panels), 0.9 + 2.7 * len(names))
    grid = figure.subplots(len(names), len(panels), squeeze=False)
    for row, name in zip(grid, names, strict=True):
        for axes, (_, label, curves) in zip(row, panels, strict=True):
            for (field, text), style in zip(curves.items(), _STYLES, strict=False):
                _curves(axes, studies, name, field, text, **style)
            axes.set(xlabel=level_quantity(name).axis_label, ylabel=label)
            axes.grid(alpha=0.3)
            axes.ticklabel_format(axis="y", useOffset=False)
    for axes, (title, _, _) in zip(grid[0], panels, strict=True):
        axes.set_title(title, fontsize=10)
        axes.legend(fontsize=7, framealpha=0.6)
    figure.suptitle(f"{studies[0].design}: misalignments{case}", fontsize=11)
    return figure


def _curves(
    axes: Axes, studies: Sequence[MisalignmentStudy], name: str, field: str, text: str = "", **style: Any
) -> None:
    """A field over a misalignment, one curve for each study."""
    for study, colour in zip(studies, (BLUE, ORANGE), strict=False):
        values, points = section_points(study, name)
        y = _shown(field, [getattr(point, field) for point in points])
        axes.plot(values, y, color=colour, label=study.side + text, **style)
        edge = [point.status == "edge contact" for point in points]
        if field == "peak_to_peak" and any(edge):
            axes.plot(values[edge], y[edge], "x", color="k", ms=7, label=f"{study.side}, edge contact")


def _shown(field: str, values: Any) -> FloatArray:
    """Values of a field of a state in its display unit."""
    return np.asarray(to_display("share" if field in _SHARES else field, np.array(values)))


def distribution_figure(studies: Sequence[MisalignmentStudy]) -> Axes:
    """Histogram of each result over random states, with its mean and its quantiles of 5, 50 and 95 %."""
    names = [name for name in _DISTRIBUTED if name in studies[0].distribution()]
    grid = panels(len(names), 3, (1.0, 0.9), (3.9, 2.9))
    for axes, name in zip(grid, names, strict=True):
        for study, colour in zip(studies, (BLUE, ORANGE), strict=False):
            if not study.distribution():
                continue
            values = [getattr(p, name) for p in study.points if p.status != "failed"]
            axes.hist(to_display(name, np.array(values)), bins="auto", color=colour, alpha=0.55, label=study.side)
            mean, _, low, middle, high = (to_display(name, x) for x in study.distribution()[name])
            for place, style in ((low, ":"), (middle, "--"), (high, ":"), (mean, "-")):
                axes.axvline(place, color=colour, ls=style, lw=1.2)
        axes.set(xlabel=axis_label(name), ylabel="states")
        axes.ticklabel_format(axis="x", useOffset=False)
    grid[0].legend(fontsize=7, framealpha=0.6)
    title = f"{studies[0].design}: {studies[0].samples} random states; lines: mean, 5, 50, 95 %"
    figure_of(grid[0]).suptitle(title, fontsize=11)
    return grid[0]


def map_figure(study: MisalignmentStudy) -> Figure:
    """Maps over the first two varied misalignments, the others nearest to zero."""
    first, second = study.varied[:2]
    states = {(getattr(p, first), getattr(p, second)): p for p in _nearest_to_zero(study, first, second)}
    x, y = (np.array(sorted(getattr(study, name))) for name in (first, second))
    figure = new_figure(12.0, 3.9)
    fields = {
        "peak_to_peak": "transmission error, peak to peak [arcsec]",
        "pattern_u": "centre of the pattern, positive to the heel [mm]",
        "pattern_area": "pattern, area share of the flank [%]",
    }
    for axes, (field, label) in zip(figure.subplots(1, 3), fields.items(), strict=True):
        values = _shown(field, [[getattr(states[a, b], field) for a in x] for b in y])
        across, up = (level_quantity(n).to_display(v) for n, v in ((first, x), (second, y)))
        shown = axes.pcolormesh(across, up, np.ma.masked_invalid(values), cmap="viridis", shading="nearest")
        figure.colorbar(shown, ax=axes, label=label)
        middle = 0.5 * (np.nanmin(values) + np.nanmax(values)) if np.isfinite(values).any() else 0.0
        if values.size <= 121:
            for place in np.ndindex(values.shape):
                text = f"{values[place]:.3g}" if np.isfinite(values[place]) else ""
                at = (across[place[1]], up[place[0]])
                axes.annotate(
                    text, at, ha="center", va="center", fontsize=7, color="k" if values[place] > middle else "w"
                )
        axes.set(xlabel=level_quantity(first).axis_label, ylabel=level_quantity(second).axis_label)
    figure.suptitle(f"{study.design}, {study.side}: {first} and {second}", fontsize=11)
    return figure


def pattern_figure(
    study: MisalignmentStudy, name: str, contacts: Sequence[tuple[float, FlankPair, ContactPattern]]
) -> Figure:
    """Outlines of the contact pattern on the gear and paths of contact for values of one misalignment.

    study: the study, for names and units.
    name: the varied misalignment.
    contacts: value of the misalignment in SI units, mesh and pattern.
    """
    figure, axes = member_figure(contacts[0][1], "gear", f"contact pattern over {name},")
    shades = colormaps["coolwarm"](np.linspace(0.0, 1.0, len(contacts)))
    for colour, (value, pair, pattern) in zip(shades, contacts, strict=True):
        aligned = value == 0.0
        tint = GREY if aligned else colour
        axes.plot([], [], color=tint, lw=2.0, label=typeset_units(level_quantity(name).text(value, 3)))
        if pattern.marked.any():
            gap = np.ma.masked_where(~pattern.inside, np.where(pattern.inside, pattern.separation, 0.0))
            axes.contour(
                pattern.gear_u * 1e3,
                pattern.gear_height * 1e3,
                gap,
                levels=[pattern.thickness],
                colors=[tint],
                linewidths=2.0 if aligned else 1.4,
            )
        axes.plot(
            np.where(pair.path.free, pair.path.u, np.nan) * 1e3, pair.path.height * 1e3, color=tint, lw=1.0, ls="--"
        )
    axes.plot([], [], color="k", lw=1.0, ls="--", label="path of contact")
    flank_axes(axes, contacts[0][1], "gear")
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), title=name)
    what = f"contact pattern over {name}, marking {1e6 * study.marking:.4g} µm, on the gear"
    axes.set_title(f"{study.design}, {study.side}:\n{what}", fontsize=10)
    return figure


def section_contacts(
    design: Design, study: MisalignmentStudy, name: str
) -> list[tuple[float, FlankPair, ContactPattern]]:
    """Mesh and pattern at up to seven values of one misalignment, the others nearest to zero.

    States that cannot be computed are omitted.
    """
    values, points = section_points(study, name)
    chosen = np.unique(np.linspace(0, values.size - 1, _PATTERNS).round().astype(int))
    start = design.assembly.misalignment
    found: list[tuple[float, FlankPair, ContactPattern]] = []
    for number in chosen:
        point = points[number]
        moved = design.with_misalignment(
            **{name: getattr(start, name) + getattr(point, name) for name in MISALIGNMENTS}
        )
        try:
            pair = flank_pair(moved.flanks(), study.side, grid=found[0][1].surface.grid if found else None)
        except ConvergenceError:
            continue
        found.append((float(getattr(point, name)), pair, pair.pattern(study.marking)))
    return found


def misalignment_figures(design: Design, studies: Sequence[MisalignmentStudy]) -> Iterator[Picture]:
    """Sections of all studies, then maps and patterns of each; of random states their distribution."""
    if studies[0].samples:
        if studies[0].distribution():
            caption = "Distribution of the results over random misalignments and flank deviations."
            yield picture("distribution", caption, distribution_figure, studies)
        return
    caption = "Transmission error, position and size of the contact over each misalignment."
    yield picture("misalignment", caption, section_figure, studies)
    if studies[0].torque is not None:
        caption = "Transmission error, pressure, edge load and efficiency at the torque."
        yield picture("misalignment_loaded", caption, loaded_figure, studies)
    for study in studies:
        if len(study.varied) > 1:
            yield picture(f"{study.side}_map", "Maps over two misalignments.", map_figure, study)
        for name in study.varied:
            contacts = section_contacts(design, study, name)
            if contacts:
                caption = f"Contact pattern on the gear over {name}."
                yield picture(f"{study.side}_pattern_{name}", caption, pattern_figure, study, name, contacts)


def plot_misalignment(grid: MisalignmentGrid, ax: Axes | None) -> Axes:
    """Transmission error, position and size of the contact; in `ax` only the error over the first misalignment."""
    if ax is None:
        return distribution_figure(grid.studies) if grid.studies[0].samples else section_figure(grid.studies).axes[0]
    name = (grid.studies[0].varied or ["E"])[0]
    _curves(ax, grid.studies, name, "peak_to_peak", marker="o", ms=4)
    ax.set(xlabel=level_quantity(name).axis_label, ylabel=axis_label("peak_to_peak"))
    ax.legend(fontsize=7, framealpha=0.6)
    return ax


_ROWS = 60


def misalignment_table(study: MisalignmentStudy) -> Table:
    """One row per state: varied misalignments, transmission error, contact positions, pattern, edges.

    At a torque, positions and sizes are those under load.
    """
    names = study.varied
    fields: tuple[str, ...] = ("peak_to_peak", *LOADED)
    if study.torque is None:
        fields = ("peak_to_peak", "error_maximum_u", "pattern_u", *_SHARES)
        what, edges = f"unloaded contact, marking {1e6 * study.marking:.4g} µm", "edge in contact"
    else:
        what, edges = f"contact at {quantity('torque').text(study.torque)} of the pinion", "unloaded edge contact"
    return Table(
        [
            *(Column(name, of=level_quantity(name).name, label=name) for name in names),
            *(Column(n, of="share", label=n.replace("_", " ")) if n in _SHARES else n for n in fields),
            Column("edges", label=f"{edges}, or reason of failure"),
        ],
        [
            [*(getattr(point, name) for name in (*names, *fields)), reason_text(point.reason) or point.edges]
            for point in study.points[:_ROWS]
        ],
        title=f"{study.design}, {study.side}: {what}",
        notes=_notes(study),
    )


def distribution_table(study: MisalignmentStudy) -> Table:
    """Mean, standard deviation and quantiles of each result over random misalignments."""
    spread = ", ".join(f"{name} {level_quantity(name).text(getattr(study, name)[0])}" for name in study.varied)
    found = study.distribution()
    columns = ["statistic", *found]
    names = ("mean", "standard deviation", "5 %", "median", "95 %")
    rows = [(name, *(values[i] for values in found.values())) for i, name in enumerate(names)]
    title = f"{study.design}, {study.side}: {study.samples} random states, standard deviations {spread or 'none'}"
    notes = _notes(study)
    if study.accuracy_grade is not None:
        made = ", ".join(f"{n.replace('_', ' ')} {1e6 * x:.2g} µm" for n, x in study.tolerances.model_dump().items())
        notes.append(
            f"flanks of grade {study.accuracy_grade} (ISO 1328-1), standard deviations of both together: {made}"
        )
    return Table(columns, rows, title, notes, "distribution", vertical=True)


def _notes(study: MisalignmentStudy) -> list[str]:
    count = len(study.points)
    failed = sum(point.status == "failed" for point in study.points)
    edges = sum(point.status == "edge contact" for point in study.points)
    notes = [
        f"{study.status}: {count} states, {edges} with unloaded edge contact, {failed} failed, {study.seconds:.2f} s"
    ]
    if study.torque is not None and failed < count:
        worst = max((p for p in study.points if p.status != "failed"), key=lambda p: p.edge_load_share)
        if worst.edge_load_share >= EDGE_LIMIT:
            place = ", ".join(f"{name} {level_quantity(name).text(getattr(worst, name))}" for name in study.varied)
            share = 100.0 * worst.edge_load_share
            remedy = "add relief or stiffen the mounting"
            notes.insert(0, f"edges carry up to {share:.2g} % of the torque ({place}): {remedy}")
    if count > _ROWS:
        notes.insert(0, f"{count - _ROWS} of {count} states are omitted here; --csv writes all of them")
    return notes


def misalignment_sections(grid: MisalignmentGrid, medium: Medium) -> list[Section]:
    """Contact in all states: a table for each side and figures; files hold all states in one table."""
    first = grid.studies[0]
    kind = "Tolerance analysis" if first.samples else "Misalignment study"
    head = Head(f"{kind}: {first.design}", f"marking {1e6 * first.marking:.4g} µm")
    if medium == "files":
        records = grid.to_frame().to_dict("list")
        known = {name: level_quantity(name).name for name in MISALIGNMENTS} | {
            "crest_u": "error_maximum_u",
            "crest_depth": "error_maximum_depth",
        }
        columns = {Column(str(name), of=known.get(str(name), "")): values for name, values in records.items()}
        return [Section("", [head, Table.from_columns(columns, name="misalignment")])]
    tables = [misalignment_table(study) for study in grid.studies]
    if first.samples:
        found: list[Item] = [head, *(distribution_table(study) for study in grid.studies)]
        if medium == "page":
            states = Folded("Random states", [replace(table, notes=()) for table in tables])
            found += [*misalignment_figures(grid.pair, grid.studies), states]
        return [Section("", found)]
    if medium == "terminal":
        return [Section("", [head, *tables])]
    wide, *others = misalignment_figures(grid.pair, grid.studies)
    return [Section("", [head]), Section("Contact", [wide, Row(others)]), Section("Numerical results", tables)]
