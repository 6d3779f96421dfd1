"""What the command line shows of a calibration."""

from __future__ import annotations

import math

from rich.console import Console
from rich.table import Table

from regression.calibration.calibrate import CalibrationResult
from regression.calibration.parameters import PARAMETERS


def calibration_report(result: CalibrationResult) -> None:
    """Values with intervals, correlations, noise, outliers, what is not told, and what it cost."""
    console = Console(soft_wrap=True, highlight=False)
    how = "profile on the solver" if result.profiled else "standard errors"
    table = Table(title=f"calibrated parameters (95 % intervals by {how})")
    for heading, right in (
        ("parameter", False),
        ("value", True),
        ("95 % interval", True),
        ("unit", False),
        ("", False),
    ):
        table.add_column(heading, justify="right" if right else "left", no_wrap=True)
    for estimate in result.parameters:
        parameter = PARAMETERS[estimate.name]
        value, low, high = (
            f"{number * parameter.shown:.4g}" if math.isfinite(number) else "-"
            for number in (estimate.value, estimate.interval_low, estimate.interval_high)
        )
        table.add_row(estimate.name, value, f"{low} to {high}", parameter.shown_unit, estimate.status)
    console.print(table)
    for estimate in result.parameters:
        if estimate.status != "determined":
            console.print(f"{estimate.name}: {estimate.verdict}.", markup=False)
    if len(result.fitted) > 1:
        matrix = Table(title="correlation of the logarithms")
        for heading in ("", *result.fitted):
            matrix.add_column(heading, justify="right", overflow="fold")
        for name, row in zip(result.fitted, result.correlation, strict=True):
            matrix.add_row(name, *(f"{value:+.2f}" for value in row))
        console.print(matrix)
    stated = "" if math.isnan(result.noise_stated) else f" (stated {result.noise_stated:.2g})"
    console.print(
        f"misfit {result.misfit:.2g} of mu (RMS), noise {result.noise:.2g}{stated}; "
        f"largest error the solver states of itself {100.0 * result.solver_error:.2g} %"
    )
    if result.outliers:
        console.print(f"far off, and weighed less: rows {', '.join(map(str, result.outliers))} of the file")
    if result.excluded:
        console.print(f"not used (no sliding, or no solution): rows {', '.join(map(str, result.excluded))} of the file")
    for note in result.notes:
        console.print(f"note: {note}", markup=False)
    console.print(f"{result.solver_calls} contacts solved in {result.iterations} rounds, {result.seconds:.1f} s")
