"""Report sections of a comparison of friction models."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from efficiency.output.notes import comparison_notes
from efficiency.output.plots_comparison import (
    plot_comparison,
    plot_friction_along_mesh,
    plot_loss_along_mesh,
    plot_loss_by_region,
    plot_run_time,
)
from efficiency.output.tables import comparison_tables, duty_models_table, models_table, operating_point, percent
from ehl.common.data import reason_text
from ehl.common.sections import Head, Item, KeyFigures, MainResult, Medium, Notes, Picture, Row, Section, Text
from regression.friction.published_registry import PUBLISHED, model_label

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
                Text(_sentence(comparison)),
                KeyFigures([_tile(row) for row in mesh[:10]]),
                notes,
            ],
        ),
        Section(
            "Power loss",
            [picture(plot_comparison, CAPTION), replace(models_table(comparison), title=""), Text(shared), *duty],
        ),
        Section("Along the mesh", [Row([picture(*each) for each in along])]),
        Section("Loss by region of the flank", [picture(plot_loss_by_region, REGIONS)]),
        Section("Run time", [picture(plot_run_time, "One run each; geometry and load are shared.")]),
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
