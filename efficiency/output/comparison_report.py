"""Report sections of a comparison of friction models."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING

from efficiency.output.notes import comparison_notes
from efficiency.output.plots_comparison import (
    plot_comparison,
    plot_friction_along_mesh,
    plot_loss_along_mesh,
    plot_loss_by_region,
    plot_run_time,
)
from efficiency.output.tables import comparison_tables, models_table, operating_point, percent
from ehl.common.data import reason_text
from ehl.common.sections import Head, KeyFigures, MainResult, Medium, Notes, Picture, Row, Section, Text
from regression.friction.published_registry import model_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from efficiency.loss.compare import Comparison, ComparisonRow

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
    if medium == "terminal":
        return [Section("", [models_table(comparison), notes])]
    mesh = [row for row in comparison.rows if row.kind == "mesh"]
    fitted = f"The fitted constant has the same loss as {model_label(comparison.reference)} at this operating point. "
    shared = (
        f"{fitted if comparison.reference else ''}Geometry and load are shared. The closed forms use one constant "
        "friction coefficient for the pair. No uncertainty is available for a model without uncertain inputs."
    )
    along = (
        (plot_friction_along_mesh, "Mean over all tooth pairs in mesh, weighted with the sliding power."),
        (plot_loss_along_mesh, "Power loss at each position of a pinion pitch."),
    )

    def picture(draw: Callable[[Comparison], Figure | Axes], caption: str) -> Picture:
        return Picture(partial(draw, comparison), caption, draw.__name__.removeprefix("plot_"))

    return [
        Section(
            "",
            [
                Head(f"Friction models compared: {comparison.design}", point),
                _answer(comparison),
                KeyFigures([_tile(row) for row in mesh[:10]]),
                notes,
            ],
        ),
        Section(
            "Power loss", [picture(plot_comparison, CAPTION), replace(models_table(comparison), title=""), Text(shared)]
        ),
        Section("Along the mesh", [Row([picture(*each) for each in along])]),
        Section("Loss by region of the flank", [picture(plot_loss_by_region, REGIONS)]),
        Section("Run time", [picture(plot_run_time, "One run each; geometry and load are shared.")]),
    ]


def _answer(comparison: Comparison) -> MainResult:
    """Range of the efficiency over the friction models."""
    found = [row for row in comparison.rows if row.kind == "mesh" and math.isfinite(row.efficiency)]
    if not found:
        return MainResult("no result", f"no friction model has a result: {comparison.reason}")
    best, worst = max(found, key=attrgetter("efficiency")), min(found, key=attrgetter("efficiency"))
    ends = ((worst, "lowest"), (best, "highest"))
    known = [(f"{percent(row.efficiency, 2)} %", f"{word}, {row.label}") for row, word in ends]
    error = 100.0 * max((row.efficiency_error for row in found if math.isfinite(row.efficiency_error)), default=0.0)
    known.append((f"±\N{NO-BREAK SPACE}{error:.1g} %", "largest numerical error of a model"))
    value = f"{percent(worst.efficiency, 2)} to {percent(best.efficiency, 2)} %"
    return MainResult(value, f"mesh efficiency by {len(found)} friction models", known)


def _tile(row: ComparisonRow) -> tuple[str, str]:
    if not math.isfinite(row.efficiency):
        return "no result", f"{row.label}: {reason_text(row.reason)}"
    low, high = (percent(end, 1) for end in (row.efficiency_lower, row.efficiency_upper))
    known = row.efficiency_lower < row.efficiency_upper
    return f"{percent(row.efficiency, 2)} %", f"{row.label}, {low} to {high} %" if known else row.label
