"""A comparison of friction models as one HTML page."""

from __future__ import annotations

import math
import platform
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from efficiency.output.notes import comparison_notes
from efficiency.output.plots_comparison import (
    plot_friction_along_mesh,
    plot_loss_along_mesh,
    plot_loss_by_region,
    plot_run_time,
)
from efficiency.output.plots_load import plot_comparison
from efficiency.output.tables import models_table, operating_point, percent
from ehl import __version__
from ehl.common.pages import write_report
from ehl.common.sections import KeyFigures, MainResult, Notes, Picture, Row, Section, Text
from regression.friction.published_registry import model_label

if TYPE_CHECKING:
    from efficiency.loss.compare import Comparison, ComparisonRow

CAPTION = (
    "Power loss by friction model, with its 90 % interval by uncertain inputs; closed forms in grey. An arrow: beyond "
    "the axis, which is that of the others."
)
REGIONS = "Share of the sliding loss in thirds of face width and height of the gear flank; each panel adds up to 100 %."


def write_comparison_report(comparison: Comparison, path: Path) -> Path:
    """One self-contained page: efficiencies with their intervals, friction along the mesh, loss on the flank, notes.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    mesh = [row for row in comparison.rows if row.kind == "mesh"]
    along = [
        Picture(plot_friction_along_mesh(comparison), "Weighted with the sliding power, of all pairs in mesh."),
        Picture(plot_loss_along_mesh(comparison), "Power loss at each position of a pinion pitch."),
    ]
    fitted = f"The constant fitted to {model_label(comparison.reference)} has its loss at this operating point. "
    shared = (
        f"{fitted if comparison.reference else ''}Geometry and load are shared; the closed forms take one constant "
        "friction coefficient for the whole pair. A model that knows no uncertain input has no interval: its error "
        "is not small, it is not known."
    )
    return write_report(
        path,
        f"Friction models compared: {comparison.design}",
        operating_point(comparison),
        [
            Section(
                "",
                [
                    _answer(comparison),
                    KeyFigures([_tile(row) for row in mesh[:10]]),
                    Notes(comparison_notes(comparison), len(comparison.results)),
                ],
            ),
            Section(
                "Power loss",
                [
                    Picture(plot_comparison(comparison), CAPTION),
                    replace(models_table(comparison), title=""),
                    Text(shared),
                ],
            ),
            Section("Along the mesh", [Row(along)]),
            Section("Where on the tooth", [Picture(plot_loss_by_region(comparison), REGIONS)]),
            Section("Run time", [Picture(plot_run_time(comparison), "One run each; geometry and load are shared.")]),
        ],
        f"mixed-ehl {__version__}, Python {platform.python_version()}.",
    )


def _answer(comparison: Comparison) -> MainResult:
    """What the choice of the friction model makes of the efficiency."""
    found = [row for row in comparison.rows if row.kind == "mesh" and math.isfinite(row.efficiency)]
    if not found:
        return MainResult("no answer", f"of any friction model: {comparison.reason}")
    best, worst = max(found, key=_efficiency), min(found, key=_efficiency)
    known = [
        (f"{percent(row.efficiency, 2)} %", f"{word}, {row.label}") for row, word in ((worst, "least"), (best, "most"))
    ]
    error = 100.0 * max((row.efficiency_error for row in found if math.isfinite(row.efficiency_error)), default=0.0)
    known.append((f"±\N{NO-BREAK SPACE}{error:.1g} %", "greatest error of the solution of a model"))
    value = f"{percent(worst.efficiency, 2)} to {percent(best.efficiency, 2)} %"
    return MainResult(value, f"mesh efficiency by {len(found)} friction models", known)


def _efficiency(row: ComparisonRow) -> float:
    return row.efficiency


def _tile(row: ComparisonRow) -> tuple[str, str]:
    if not math.isfinite(row.efficiency):
        return "no answer", f"{row.label}: {row.reason}"
    low, high = (percent(end, 1) for end in (row.efficiency_lower, row.efficiency_upper))
    known = row.efficiency_lower < row.efficiency_upper
    return f"{percent(row.efficiency, 2)} %", f"{row.label}, {low} to {high} %" if known else row.label
