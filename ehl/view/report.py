"""What the command line shows of one contact: a table, or JSON."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ehl.case import Case
    from ehl.solve import ContactResult

# name, factor from SI, shown unit, digits
_ROWS: tuple[tuple[str, float, str, str], ...] = (
    ("friction_coefficient", 1.0, "", ".5f"),
    ("friction_fluid", 1.0, "", ".5f"),
    ("friction_asperity", 1.0, "", ".5f"),
    ("friction_error", 100.0, "%", ".2g"),
    ("mesh_error", 100.0, "%", ".2g"),
    ("statistical_error", 100.0, "%", ".2g"),
    ("friction_boundary_half", 1.0, "", ".5f"),
    ("friction_boundary_double", 1.0, "", ".5f"),
    ("film_central", 1e9, "nm", ".1f"),
    ("film_min", 1e9, "nm", ".1f"),
    ("film_error", 100.0, "%", ".2g"),
    ("film_ratio", 1.0, "", ".2f"),
    ("asperity_load_share", 1.0, "", ".3f"),
    ("roughness_load_share", 1.0, "", ".3f"),
    ("pressure_max", 1e-9, "GPa", ".4f"),
    ("rolling_traction", 1.0, "", ".5f"),
)


def print_json(content: dict[str, Any]) -> None:
    """One JSON object on standard output, strict (no NaN)."""
    print(json.dumps(content, allow_nan=False))


def result_table(case: Case, result: ContactResult) -> None:
    """Print the result as a table."""
    from rich.console import Console
    from rich.table import Table

    contact = case.line_contact()
    table = Table(
        title=f"line contact, p_h {contact.pressure_hertz / 1e9:.3g} GPa, R {contact.radius_equivalent * 1e3:.3g} mm, "
        f"u_r {contact.speed_entrainment:.3g} m/s, SR {contact.slide_to_roll:.3g}"
    )
    table.add_column("quantity")
    table.add_column("value", justify="right")
    table.add_column("unit")
    for name, factor, unit, digits in _ROWS:
        value = getattr(result, name)
        table.add_row(name, format(value * factor, digits) if math.isfinite(value) else "-", unit)
    kelvin = 273.15
    table.add_row("temperature_film_max", f"{result.temperature_film_max - kelvin:.1f}", "degC")
    table.add_row("temperature_flash", f"{result.temperature_flash - kelvin:.1f}", "degC")
    console = Console()
    console.print(table)
    status = result.status if not result.reason else f"{result.status} ({result.reason})"
    console.print(f"{status}, {result.iterations} Newton iterations, {result.seconds:.3g} s")
    for item in result.skipped:
        console.print(f"skipped  {item}")
    for item in result.notes:
        console.print(f"note     {item}")
