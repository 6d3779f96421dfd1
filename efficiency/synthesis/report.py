"""What the command line shows of machine settings: settings of all four flanks, residual map, undercut, warnings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rich.table import Table

    from efficiency.synthesis.result import FlankFit, SettingsResult


def settings_tables(result: SettingsResult) -> None:
    """Print the tables of a result."""
    from rich.console import Console

    console = Console()
    console.print(_settings(result))
    console.print(_residuals(result))
    for flank in result.flanks:
        if flank.fitted.largest > 1e-9:
            console.print(_map(flank))
    for warning in result.warnings:
        console.print(f"warning: {warning}")
    console.print(f"{result.iterations} iterations, {result.seconds:.2f} s, {result.status}")


def _table(title: str, *columns: str) -> Table:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, collapse_padding=True, pad_edge=False)
    for k, column in enumerate(columns):
        table.add_column(column, justify="left" if k == 0 else "right", no_wrap=k == 0)
    return table


def _settings(result: SettingsResult) -> Table:
    """The numbers of the design file, a column per flank."""
    from efficiency.synthesis.design_file import formatted

    columns = {}
    for member in ("pinion", "gear"):
        for side in ("concave", "convex"):
            given = getattr(getattr(result.design, member), side).model_dump()
            columns[f"{member} {side}"] = {name: value for table in given.values() for name, value in table.items()}
    names = dict.fromkeys(name for values in columns.values() for name in values)
    table = _table(result.design.name, "setting", *columns)
    for name in names:
        values = [values.get(name) for values in columns.values()]
        if any(value not in (None, 0.0) for value in values):
            table.add_row(name, *("" if value is None else formatted(name, value) for value in values))
    return table


def _residuals(result: SettingsResult) -> Table:
    table = _table("fit", "pinion flank", "rms um", "max um", "undercut", "root toe/middle/heel mm", "TE arcsec")
    for flank in result.flanks:
        fitted, amplitude = flank.fitted, flank.transmission_error
        table.add_row(
            flank.side,
            f"{fitted.rms * 1e6:.2f}",
            f"{fitted.largest * 1e6:.2f}",
            f"{len(flank.undercut)} of {fitted.found.size}",
            " / ".join(f"{error * 1e3:+.3f}" for error in fitted.root_error) or "not found",
            "" if amplitude is None else f"{np.degrees(amplitude) * 3600:.2f}",
        )
    return table


def _map(flank: FlankFit) -> Table:
    """Residual over the gear flank, tip on top; undercut points are marked x."""
    along, deep = flank.grid.shape
    shape = (deep, along)
    residual, found = flank.fitted.residual.reshape(shape), flank.fitted.found.reshape(shape)
    u, depth = flank.grid.u.reshape(shape)[0], 0.5 * (flank.grid.y.reshape(shape)[:, 0] + 1.0)
    picked = range(0, along, 2)
    table = _table(
        f"residual of the {flank.side} pinion flank, um (gear: toe to heel in mm, root to tip)",
        "depth",
        *(f"{u[k] * 1e3:.1f}" for k in picked),
    )
    for row in reversed(range(deep)):
        cells = (f"{residual[row, k] * 1e6:.1f}" if found[row, k] else "x" for k in picked)
        table.add_row(f"{depth[row]:.2f}", *cells)
    return table
