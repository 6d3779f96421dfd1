"""What the command line shows of a gear pair: tables and figures."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ehl.errors import InputError
from ehl.plots import save_figure

if TYPE_CHECKING:
    from efficiency.loss.compare import Comparison
    from efficiency.loss.map import EfficiencyMap
    from efficiency.loss.result import EfficiencyResult

RPM = 30.0 / math.pi
KELVIN = 273.15
ARCSEC = math.degrees(1.0) * 3600.0


def percent(value: float, digits: int = 3) -> str:
    """A share in per cent, a dash where there is none."""
    return f"{100.0 * value:.{digits}f}" if math.isfinite(value) else "–"


def efficiency_rows(result: EfficiencyResult) -> list[tuple[str, str, str]]:
    """(quantity, value, unit) of one operating point."""
    rows = [
        ("efficiency", percent(result.efficiency, 4), "%"),
        ("efficiency_error (discretisation)", percent(result.efficiency_error, 5), "%"),
    ]
    if math.isfinite(result.efficiency_lower) and result.efficiency_lower < result.efficiency_upper:
        interval = f"{percent(result.efficiency_lower)} to {percent(result.efficiency_upper)}"
        rows.append(("interval of the friction model", interval, "%"))
    low, high = result.ranges["film_ratio_formula"]
    rows += [
        ("power_loss", f"{result.power_loss:.2f}", "W"),
        ("power_input", f"{result.power_input / 1e3:.3f}", "kW"),
        ("friction_coefficient_mean", f"{result.friction_coefficient_mean:.5f}", ""),
        ("outside_range_share", percent(result.outside_range_share, 1), "% of the sliding power"),
        ("pressure_max", f"{result.pressure_max / 1e9:.3f}", "GPa"),
        ("film ratio (formula)", f"{low:.2f} to {high:.2f}", ""),
        ("transmission error, loaded", f"{result.transmission_error_loaded * ARCSEC:.2f}", "arcsec peak to peak"),
        ("transmission error, unloaded", f"{result.transmission_error_unloaded * ARCSEC:.2f}", "arcsec peak to peak"),
        ("torque_residual", f"{result.torque_residual:.1e}", ""),
    ]
    return rows


def operating_point(result: EfficiencyResult | Comparison) -> str:
    """One line: pair, side, torque, speed, oil."""
    return (
        f"{result.design}, {result.side}, {result.torque_pinion:.4g} N m, {result.speed_pinion * RPM:.4g} rpm, "
        f"{result.oil} at {result.temperature_oil - KELVIN:.4g} degC"
    )


def efficiency_table(result: EfficiencyResult) -> None:
    """Print one operating point."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title=f"{operating_point(result)}, friction {result.friction_model}")
    table.add_column("quantity")
    table.add_column("value", justify="right")
    table.add_column("unit")
    for row in efficiency_rows(result):
        table.add_row(*row)
    console = Console()
    console.print(table)
    console.print(f"{result.status}{f' ({result.reason})' if result.reason else ''}, {result.points_loaded} points")
    for item in result.notes:
        console.print(f"note     {item}", highlight=False)
    for item in result.skipped:
        console.print(f"skipped  {item}")


COMPARISON_HEADER = ("friction", "efficiency [%]", "loss [W]", "mean mu", "interval [%]", "outside [%]")


def comparison_rows(comparison: Comparison) -> list[tuple[str, ...]]:
    """Cells of the comparison, one row per way to the efficiency."""
    rows: list[tuple[str, ...]] = []
    for row in comparison.rows:
        interval = "–"
        if math.isfinite(row.efficiency_lower) and row.efficiency_lower < row.efficiency_upper:
            interval = f"{percent(row.efficiency_lower, 2)}–{percent(row.efficiency_upper, 2)}"
        rows.append(
            (
                row.name if row.status == "converged" else f"{row.name} ({row.status}: {row.reason})",
                percent(row.efficiency),
                f"{row.power_loss:.1f}" if math.isfinite(row.power_loss) else "–",
                f"{row.friction_coefficient_mean:.4f}" if math.isfinite(row.friction_coefficient_mean) else "–",
                interval,
                percent(row.outside_range_share, 1),
            )
        )
    return rows


def comparison_table(comparison: Comparison) -> None:
    """Print the comparison."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(title=operating_point(comparison), box=box.SIMPLE, padding=(0, 1, 0, 0))
    table.add_column(COMPARISON_HEADER[0], min_width=22, overflow="fold")
    for name in COMPARISON_HEADER[1:]:
        table.add_column("\n".join(name.rsplit(" ", 1)), justify="right")
    for row in comparison_rows(comparison):
        table.add_row(*row)
    console = Console()
    console.print(table)
    for item in comparison.notes:
        console.print(f"note     {item}", highlight=False)


def map_table(grid: EfficiencyMap) -> None:
    """Print efficiency over torque (rows) and speed (columns), one table per temperature."""
    from rich.console import Console
    from rich.table import Table

    values = grid.values("efficiency")
    console = Console()
    for number, temperature in enumerate(grid.temperature_oil):
        table = Table(title=f"efficiency [%] at {temperature - KELVIN:.4g} degC")
        table.add_column("pinion torque")
        for speed in grid.speed_pinion:
            table.add_column(f"{speed * RPM:.4g} rpm", justify="right")
        for torque, row in zip(grid.torque_pinion, values[:, :, number], strict=True):
            table.add_row(f"{torque:.4g} N m", *(percent(float(value)) for value in np.asarray(row)))
        console.print(table)
    for item, count in Counter(note for result in grid.results for note in result.notes).items():
        console.print(f"note     {count} of {len(grid.results)} points: {item}", highlight=False)


def _folder(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError("--plot", str(folder), "a folder that can be written", f"{error}.") from None
    return folder


def save_gear_figures(result: EfficiencyResult, folder: Path) -> None:
    """Pressure on the flank, load sharing, transmission error, friction and loss, as PNG files."""
    from efficiency.output.plots_load import (
        plot_flank_pressure,
        plot_friction_and_loss,
        plot_load_sharing,
        plot_transmission_error,
    )

    folder = _folder(folder)
    for name, plot in (
        ("flank_pressure", plot_flank_pressure),
        ("load_sharing", plot_load_sharing),
        ("transmission_error", plot_transmission_error),
        ("friction_and_loss", plot_friction_and_loss),
    ):
        save_figure(plot(result), folder / f"{name}.png")


def save_map_figure(grid: EfficiencyMap, folder: Path) -> None:
    """The map as a PNG file."""
    from efficiency.output.plots_load import plot_map

    save_figure(plot_map(grid), _folder(folder) / "efficiency_map.png")
