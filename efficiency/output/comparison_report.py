"""Report sections and figures of a comparison of friction models."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from itertools import chain
from operator import attrgetter

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from efficiency.loss.compare import Comparison, ComparisonRow
from efficiency.loss.efficiency_result import pair_notes
from efficiency.loss.power_loss import FACES, HEIGHTS, friction_along_mesh
from efficiency.output.tables import (
    limit_columns,
    operating_point,
    operating_state,
    percent,
    remarks_table,
    result_notes,
)
from ehl.common.arrays import FloatArray
from ehl.common.data import reason_text
from ehl.common.figures import BLUE, GREY, ORANGE, axes_or_new, figure_of, panels
from ehl.common.notes import Note
from ehl.common.quantities import typeset_units
from ehl.common.sections import Head, Item, KeyFigures, MainResult, Medium, Notes, Row, Section, Text, picture
from ehl.common.table import Column, Table
from regression.friction.published_registry import PUBLISHED, model_label

MARKERS = "os^vD<>PX*"


def plot_comparison(comparison: Comparison, ax: Axes | None = None) -> Axes:
    """Power loss in percent of the input, one bar per friction model; closed forms in grey.

    A bar or interval far above the median ends in an arrow with its value.
    """
    rows = sorted(comparison.rows, key=lambda row: (math.isnan(row.power_loss), row.power_loss))  # as in the table
    axes = axes_or_new(ax, 7.5, 0.9 + 0.42 * len(rows))
    loss = np.array([100.0 * (1.0 - row.efficiency) for row in rows])
    low, high = (np.array([100.0 * (1.0 - getattr(row, f"efficiency_{end}")) for row in rows]) for end in _ENDS)
    limit = axis_limit(np.fmax(loss, high))
    place = np.arange(len(rows))[::-1]
    colors = [GREY if row.kind == "closed form" else BLUE for row in rows]
    axes.barh(place, np.minimum(np.nan_to_num(loss), limit), color=colors)
    for at, row, value, left, right in zip(place, rows, loss, low, high, strict=True):
        text = f"{100.0 * row.efficiency:.2f} %" if math.isfinite(row.efficiency) else reason_text(row.reason)
        end = value if math.isfinite(value) else 0.0
        if right > left and value <= limit:
            ends = [[max(value - left, 0.0)], [max(min(right, limit) - value, 0.0)]]
            axes.errorbar(value, at, xerr=ends, fmt="none", ecolor=ORANGE, capsize=3)
        end = np.fmax(end, right)
        if end > limit:
            axes.plot(limit, at, marker=">", ms=8, color=ORANGE, zorder=5)
            if right > left:
                text += f"\n{100.0 * row.efficiency_lower:.3g} to {100.0 * row.efficiency_upper:.3g} %"
        size, gap = (8, 8) if end > limit else (9, 5)
        axes.annotate(
            text, (min(end, limit), at), xytext=(gap, 0), textcoords="offset points", fontsize=size, va="center"
        )
    axes.set_yticks(place, [row.label for row in rows])
    axes.set(xlabel="mesh power loss [% of input]; bars end with the efficiency", xlim=(0.0, 1.35 * limit))
    # title of the whole figure, because long names of friction models leave narrow axes
    title = axes.set_title if ax is not None else figure_of(axes).suptitle
    title(typeset_units(f"{comparison.design}: {operating_state(comparison)}"))
    return axes


_ENDS = ("upper", "lower")
_FAR = 6.0  # times the median


def axis_limit(ends: FloatArray) -> float:
    """End of an axis for bars of lengths `ends`, without the lengths far above the median."""
    known = ends[np.isfinite(ends) & (ends > 0.0)]
    if not known.size:
        return 1.0
    near = known[known <= _FAR * np.median(known)]
    return float(near.max())


def plot_friction_along_mesh(comparison: Comparison) -> Axes:
    """Friction coefficient over one pinion pitch, one line per model."""
    return _along(comparison, list(map(friction_along_mesh, comparison.results)), "friction coefficient [-]")


def plot_loss_along_mesh(comparison: Comparison) -> Axes:
    """Power loss over one pinion pitch, one line per model."""
    return _along(comparison, [result.cycle.power_loss for result in comparison.results], "power loss [W]")


def _along(comparison: Comparison, values: list[FloatArray], label: str) -> Axes:
    axes = axes_or_new(None, 7.0, 3.9 + 0.2 * len(values))
    shades = colormaps["viridis"](np.linspace(0.0, 0.9, max(len(values), 2)))
    for number, (result, line) in enumerate(zip(comparison.results, values, strict=True)):
        roll = result.cycle.pinion_angle / result.cycle.pitch
        style = {"color": shades[number], "marker": MARKERS[number % len(MARKERS)], "ms": 3.5, "lw": 1.2}
        axes.plot(roll, line, label=comparison.rows[number].label, **style)
    axes.set(xlabel="pinion roll [pinion pitches]", ylabel=label, ylim=(0.0, None))
    axes.grid(alpha=0.3)
    figure_of(axes).legend(fontsize=8, frameon=False, loc="outside lower center")
    return axes


def plot_loss_by_region(comparison: Comparison) -> Figure:
    """Share of the sliding loss by thirds of the gear flank, one panel for each friction model."""
    rows = [row for row in comparison.rows if row.loss_regions]
    all_axes = panels(len(rows), 3, (0.9, 0.5), (3.0, 1.9), sharey=True)
    figure = figure_of(all_axes[0])
    top = 100.0 * max((float(np.nanmax(row.loss_regions)) for row in rows), default=1.0)
    shown = None
    for axes, row in zip(all_axes, rows, strict=True):
        shares = 100.0 * np.array(row.loss_regions)
        shown = axes.imshow(shares, origin="lower", cmap="Oranges", vmin=0.0, vmax=top, aspect="auto")
        for (height, face), share in np.ndenumerate(shares):
            dark = share > 0.6 * top
            axes.annotate(
                f"{share:.1f}", (face, height), ha="center", va="center", color="w" if dark else "k", fontsize=8
            )
        axes.set_xticks(range(3), FACES, fontsize=8)
        axes.set_yticks(range(3), HEIGHTS, fontsize=8)
        axes.set_title(row.label, fontsize=8)
    if shown is not None:
        figure.colorbar(shown, ax=figure.axes, label="share of the sliding loss [%]")
    figure.supxlabel("third of the gear face", fontsize=9)
    figure.supylabel("third of the gear height", fontsize=9)
    return figure


def plot_run_time(comparison: Comparison) -> Axes:
    """Run time of friction and loss for each friction model, without geometry and load."""
    rows = [row for row in comparison.rows if row.kind == "mesh"][::-1]
    axes = axes_or_new(None, 7.0, 0.9 + 0.34 * len(rows))
    seconds = np.maximum([row.seconds for row in rows], 1e-5)
    bars = axes.barh(np.arange(len(rows)), seconds, color=BLUE)
    axes.bar_label(bars, [f"{value:.3g} s" for value in seconds], padding=4, fontsize=8)
    axes.set_yticks(np.arange(len(rows)), [row.label for row in rows], fontsize=8)
    axes.set_xscale("log")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set(xlabel="run time of friction and loss [s]", xlim=(None, 6.0 * float(seconds.max())))
    return axes


_COMPARED = (
    *("friction_model", "efficiency", "power_loss", "friction_coefficient_mean"),
    *("efficiency_lower", "efficiency_upper", "outside_range_share", "seconds", "status", "reason", "kind"),
    *("efficiency_error", "efficiency_with_rolling"),
)


def comparison_notes(comparison: Comparison) -> list[Note]:
    """Notes of a comparison, one for each kind with the model for which it is worst."""
    return pair_notes(
        pair for result in comparison.results for pair in result_notes(result, (), model_label(result.friction_model))
    )


def models_table(comparison: Comparison) -> Table:
    """The table for terminal and page, by increasing loss; a model without uncertain inputs has no interval."""
    limits, known = limit_columns(comparison.rows), comparison.rows
    columns = [
        Column("friction_model"),
        Column("power_loss", label="loss", digits=3, rounded=True),
        Column("loss_factor", label="loss ratio", decimals=2),
        Column("efficiency", decimals=2),
        replace(limits["efficiency_lower"], label="lower limit"),
        replace(limits["efficiency_upper"], label="upper limit"),
        Column("friction_coefficient_mean", label="mean mu", digits=3),
        Column("outside_range_share", label="outside its range", decimals=1),
    ]
    if any(row.status != "converged" for row in known):
        columns.append(Column("reason"))
    rows = []
    for row in sorted(known, key=lambda row: (math.isnan(row.power_loss), row.power_loss)):
        exact = ["outside_range_share"] if row.kind == "closed form" else []
        exact += [] if row.efficiency_lower < row.efficiency_upper else ["efficiency_lower", "efficiency_upper"]
        rows.append((row.label, *(None if c.name in exact else getattr(row, c.name) for c in columns[1:])))
    return Table(columns, rows, title=operating_point(comparison), name="models")


def duty_models_table(comparison: Comparison) -> Table:
    """Energies of a duty cycle by friction model, by increasing loss."""
    columns = [
        Column("friction_model"),
        Column("energy_loss", digits=3, rounded=True),
        Column("energy_factor", label="ratio", decimals=2),
        Column("energy_factor_min", label="least of a row", decimals=2),
        Column("energy_factor_max", label="largest of a row", decimals=2),
    ]
    known = sorted((row for row in comparison.rows if row.energy_loss > 0.0), key=attrgetter("energy_loss"))
    rows = [(row.label, *(getattr(row, column.name) for column in columns[1:])) for row in known]
    base = next((row.label for row in known if row.energy_factor == 1.0), "the first model")
    title = f"Energy lost by sliding over the duty cycle; ratios over {base}"
    return Table(columns, rows, title=title, name="duty")


def comparison_tables(comparison: Comparison) -> list[Table]:
    """One row per result, friction and loss along the mesh, loss by region of the flank, remarks."""

    def along(name: str, quantity: str, lines: Iterable[FloatArray]) -> Table:
        columns: dict[Column, FloatArray] = {Column("pinion_angle"): comparison.results[0].cycle.pinion_angle}
        for row, line in zip(comparison.rows, lines, strict=False):
            columns[Column(row.name, of=quantity, label=row.name)] = line
        return Table.from_columns(columns, name=name)

    regions = [
        Column(f"{height}, {face}", of="share", label=f"{height}, {face}") for height in HEIGHTS for face in FACES
    ]
    shares = [(row.name, *chain.from_iterable(row.loss_regions)) for row in comparison.rows if row.loss_regions]
    rows = [[row.name, *(getattr(row, name) for name in _COMPARED[1:])] for row in comparison.rows]
    return [
        # all columns, models by their names in commands
        Table(_COMPARED, rows, title=operating_point(comparison), name="models"),
        along("friction along the mesh", "mu", map(friction_along_mesh, comparison.results)),
        along("loss along the mesh", "power_loss", (result.cycle.power_loss for result in comparison.results)),
        Table(("friction_model", *regions), shares, name="share of loss by region"),
        remarks_table(comparison.results),
    ]


CAPTION = (
    "Power loss by friction model, with the 90 % interval from uncertain inputs; closed forms in grey. An arrow marks "
    "a value beyond the axis."
)
REGIONS = "Share of the sliding loss in thirds of face width and height of the gear flank; each panel adds up to 100 %."


def comparison_sections(comparison: Comparison, medium: Medium) -> list[Section]:
    """Efficiencies with their intervals, friction along the mesh, loss on the flank, notes."""
    point = operating_point(comparison)
    notes = Notes(comparison_notes(comparison), len(comparison.results))
    if medium == "files":
        return [Section("", [Head(f"{point}: friction models"), *comparison_tables(comparison)])]
    duty = [duty_models_table(comparison)] if any(row.energy_loss > 0.0 for row in comparison.rows) else []
    if medium == "terminal":
        items: list[Item] = [_answer(comparison), Text(_sentence(comparison)), models_table(comparison), *duty, notes]
        return [Section("", items)]
    mesh = [row for row in comparison.rows if row.kind == "mesh"]
    fitted = f"The fitted constant has the same loss as {model_label(comparison.reference)} at this operating point. "
    shared = (
        f"{fitted if comparison.reference else ''}Geometry and load are shared. The closed forms use one constant "
        "friction coefficient for the pair. No uncertainty is available for a model without uncertain inputs."
    )
    weighted = "Mean over all tooth pairs in mesh, weighted with the sliding power."
    along = [
        picture("friction_along_mesh", weighted, plot_friction_along_mesh, comparison),
        picture("loss_along_mesh", "Power loss at each position of a pinion pitch.", plot_loss_along_mesh, comparison),
    ]
    head = Head(f"Friction models compared: {comparison.design}", point)
    tiles = KeyFigures([_tile(row) for row in mesh[:10]])
    bars = picture("comparison", CAPTION, plot_comparison, comparison)
    run_time = picture("run_time", "One run each; geometry and load are shared.", plot_run_time, comparison)
    return [
        Section("", [head, _answer(comparison), Text(_sentence(comparison)), tiles, notes]),
        Section("Power loss", [bars, replace(models_table(comparison), title=""), Text(shared), *duty]),
        Section("Along the mesh", [Row(along)]),
        Section("Loss by region of the flank", [picture("loss_by_region", REGIONS, plot_loss_by_region, comparison)]),
        Section("Run time", [run_time]),
    ]


def _answer(comparison: Comparison) -> MainResult:
    """Efficiency by the reference; range over all models."""
    found = [row for row in comparison.rows if row.kind == "mesh" and math.isfinite(row.efficiency)]
    base = comparison.base
    if not found or base is None:
        return MainResult("no result", f"no friction model has a result: {comparison.reason}")
    known = []
    if base.efficiency_lower < base.efficiency_upper:
        known.append((f"{percent(base.efficiency_lower, 1)} to {percent(base.efficiency_upper, 1)} %", "90 % interval"))
    low, high = (end(row.efficiency for row in found) for end in (min, max))
    known.append((f"{percent(low, 2)} to {percent(high, 2)} %", f"by {len(found)} friction models"))
    return MainResult(f"{percent(base.efficiency, 2)} %", f"mesh efficiency by {base.label}", known)


def _sentence(comparison: Comparison) -> str:
    """Loss by kinds of friction models over that of the reference."""
    base = comparison.base
    if base is None:
        return ""
    kinds: dict[str, list[float]] = {}
    for row in comparison.rows:
        if row is base or not math.isfinite(row.loss_factor):
            continue
        kinds.setdefault(_kind(row), []).append(row.loss_factor)
    parts = [
        f"{kind}: {min(found):.2f}" + (f" to {max(found):.2f}" if max(found) - min(found) >= 0.005 else "")
        for kind, found in kinds.items()
    ]
    return f"Ratio of the loss to that of {base.label} – {'; '.join(parts)}." if parts else ""


def _kind(row: ComparisonRow) -> str:
    if row.kind == "closed form":
        return f"closed forms with mu {row.friction_coefficient_mean:.3g}"
    if "fitted to" in row.name:
        return "the constant fitted to it"
    if row.name.startswith(("constant:", "ehl")):
        return row.label
    return "published formulas" if row.name in PUBLISHED else row.label


def _tile(row: ComparisonRow) -> tuple[str, str]:
    if not math.isfinite(row.efficiency):
        return "no result", f"{row.label}: {reason_text(row.reason)}"
    low, high = (percent(end, 1) for end in (row.efficiency_lower, row.efficiency_upper))
    known = row.efficiency_lower < row.efficiency_upper
    return f"{percent(row.efficiency, 2)} %", f"{row.label}, {low} to {high} %" if known else row.label
