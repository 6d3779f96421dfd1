"""A comparison of friction models as one HTML page."""

from __future__ import annotations

import platform
from pathlib import Path
from typing import TYPE_CHECKING

from efficiency.output.plots_comparison import (
    plot_friction_along_mesh,
    plot_loss_along_mesh,
    plot_loss_by_region,
    plot_run_time,
)
from efficiency.output.plots_load import plot_comparison
from efficiency.output.tables import comparison_table, operating_point, percent
from ehl import __version__
from ehl.view.html_report import Block, KeyFigures, Picture, Pictures, Section, Text, write_report
from ehl.view.table import Table

if TYPE_CHECKING:
    from efficiency.loss.compare import Comparison

REGIONS = "Share of the sliding loss in thirds of face width and height of the gear flank; each panel adds up to 100 %."


def write_comparison_report(comparison: Comparison, path: Path) -> Path:
    """One self-contained page: table, losses, friction along the mesh, loss by region of the flank, notes.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    best = [row for row in comparison.rows if row.status == "converged"]
    blocks: list[Block] = [
        KeyFigures([(f"{percent(row.efficiency, 2)} %", row.name) for row in best[:5]]),
        Text(
            f"The constant fitted to {comparison.reference} has its loss at this operating point. "
            if comparison.reference
            else ""
        ),
        Text(
            "The same loaded mesh with each friction model; loads from frictionless equilibrium. The closed forms take "
            "one constant friction coefficient for the whole pair."
        ),
        comparison_table(comparison),
        Picture(plot_comparison(comparison), "Power loss by friction model; closed forms in grey."),
    ]
    along: list[Block] = [
        Pictures(
            [
                Picture(plot_friction_along_mesh(comparison), "Weighted with the sliding power, of all pairs in mesh."),
                Picture(plot_loss_along_mesh(comparison), "Power loss at each position of a pinion pitch."),
            ]
        )
    ]
    notes = [(note,) for note in comparison.notes] or [("none",)]
    return write_report(
        path,
        f"Friction models compared: {comparison.design}",
        operating_point(comparison),
        [
            Section("", blocks),
            Section("1. Along the mesh", along),
            Section("2. Where on the tooth", [Picture(plot_loss_by_region(comparison), REGIONS)]),
            Section("3. Run time", [Picture(plot_run_time(comparison), "One run each; geometry and load are shared.")]),
            Section("4. Notes", [Table(("notes on the pair",), notes)]),
        ],
        f"mixed-ehl {__version__}, Python {platform.python_version()}.",
    )
