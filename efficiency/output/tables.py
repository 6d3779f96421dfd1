"""What the command line shows of a gear pair: tables and figures."""

from __future__ import annotations

import math
from collections import Counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

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
    film, flash = result.lubrication.film_ratio, result.lubrication.temperature_flash
    rows += [
        ("efficiency with rolling loss", percent(result.efficiency_with_rolling, 4), "%"),
        ("power_loss (sliding)", f"{result.power_loss:.2f}", "W"),
        ("power_loss_rolling", f"{result.power_loss_rolling:.2f}", "W"),
        (f"power_input, {result.driver} driving", f"{result.power_input / 1e3:.3f}", "kW"),
        ("friction_coefficient_mean", f"{result.friction_coefficient_mean:.5f}", ""),
        ("outside_range_share", percent(result.outside_range_share, 1), "% of the sliding power"),
        *_contact_rows(result),
        ("pressure_max, flanks", f"{result.pressure_max / 1e9:.3f}", "GPa"),
        *_edge_rows(result),
        ("film ratio", _span(film, ".2f"), ""),
        ("surface temperature, greatest", _greatest(flash - KELVIN), "degC"),
        ("transmission error, loaded", f"{result.transmission_error_loaded * ARCSEC:.2f}", "arcsec peak to peak"),
        ("transmission error, unloaded", f"{result.transmission_error_unloaded * ARCSEC:.2f}", "arcsec peak to peak"),
        ("torque_residual", f"{result.torque_residual:.1e}", ""),
    ]
    return rows


def _edge_rows(result: EfficiencyResult) -> list[tuple[str, str, str]]:
    """Pressure, load and loss where the contact reaches an edge; nothing where it does not."""
    if not result.edge_load_share > 0.0:
        return []
    low, high = (f"{value / 1e9:.2f}" for value in (result.pressure_edge_lower, result.pressure_edge_upper))
    return [
        ("pressure at an edge", f"{result.pressure_edge / 1e9:.2f} ({low} to {high})", "GPa"),
        ("share of the load at edges", percent(result.edge_load_share, 2), "%"),
        ("share of the loss at edges", percent(result.edge_loss_share, 2), "%"),
    ]


def _contact_rows(result: EfficiencyResult) -> list[tuple[str, str, str]]:
    """How many contacts were solved, and what the others cost; nothing where a formula gave the friction."""
    if not result.contacts:
        return []
    failed = sum(result.contacts_failed.values())
    rows = [("contacts solved", f"{result.contacts - failed} of {result.contacts}", "")]
    if result.flags["predicted"]:
        rows.append(("share of the loss next to failed contacts", percent(result.flag_shares["predicted"], 2), "%"))
    return rows


def _greatest(values: NDArray[np.float64]) -> str:
    return f"{np.nanmax(values):.1f}" if np.isfinite(values).any() else "–"


def _span(values: NDArray[np.float64], form: str) -> str:
    if not np.isfinite(values).any():
        return "–"
    return f"{np.nanmin(values):{form}} to {np.nanmax(values):{form}}"


# name, shown name, factor from SI, offset, unit
_RANGES = (
    ("pressure_hertz", "Hertz pressure", 1e-9, 0.0, "GPa"),
    ("load_per_length", "load per length", 1e-3, 0.0, "N/mm"),
    ("radius_equivalent", "equivalent radius", 1e3, 0.0, "mm"),
    ("half_width", "half-width of the contact", 1e3, 0.0, "mm"),
    ("speed_entrainment", "entrainment speed", 1.0, 0.0, "m/s"),
    ("speed_sliding", "sliding speed", 1.0, 0.0, "m/s"),
    ("speed_sliding_lengthwise", "sliding along the contact line", 1.0, 0.0, "m/s"),
    ("slide_to_roll", "slide-to-roll ratio, across the line", 1.0, 0.0, ""),
    ("slide_to_roll_total", "sliding over rolling, total", 1.0, 0.0, ""),
    ("film_central", "central film thickness", 1e9, 0.0, "nm"),
    ("film_ratio", "film ratio", 1.0, 0.0, ""),
    ("temperature_flash", "greatest surface temperature", 1.0, -KELVIN, "degC"),
    ("mu", "friction coefficient", 1.0, 0.0, ""),
)


def range_rows(result: EfficiencyResult) -> list[tuple[str, ...]]:
    """(quantity, least, greatest, unit) of the local conditions at the loaded points."""
    rows: list[tuple[str, ...]] = []
    for name, shown, factor, offset, unit in _RANGES:
        source = next(
            part for part in (result.friction, result.lubrication, result.points.state) if hasattr(part, name)
        )
        values = getattr(source, name) * factor + offset
        finite = values[np.isfinite(values)]
        least, greatest = (f"{finite.min():.4g}", f"{finite.max():.4g}") if finite.size else ("–", "–")
        rows.append((shown, least, greatest, unit))
    return rows


def position_rows(result: EfficiencyResult) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Header and one row per mesh position: roll, load, pressure, transmission error, friction, loss."""
    header = (
        "pinion roll [deg]",
        "normal force [kN]",
        "pairs loaded",
        "greatest share [-]",
        "pressure [GPa]",
        "TE loaded [arcsec]",
        "mean mu [-]",
        "loss [W]",
    )
    points = result.points
    rows: list[tuple[str, ...]] = []
    weight = points.force * points.speed_sliding
    for number, load in enumerate(result.load.positions):
        at = points.position == number
        total, shares = float(weight[at].sum()), load.share.values()
        mu = float((weight[at] * result.friction.mu[at]).sum()) / total if total > 0.0 else math.nan
        rows.append(
            (
                f"{math.degrees(result.pinion_angle[number]):.2f}",
                f"{load.force.sum() / 1e3:.3f}",
                str(sum(share > 0.0 for share in shares)),
                f"{max(shares):.3f}",
                f"{load.pressure_hertz.max() / 1e9:.3f}",
                f"{result.transmission_error_positions[number] * ARCSEC:.2f}",
                f"{mu:.4f}" if math.isfinite(mu) else "–",
                f"{result.power_loss_positions[number]:.1f}",
            )
        )
    return header, rows


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


COMPARISON_HEADER = ("friction", "efficiency [%]", "loss [W]", "mean mu", "interval [%]", "outside [%]", "time [s]")


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
                f"{row.seconds:.2g}" if row.kind == "mesh" else "–",
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
