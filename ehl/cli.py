"""Commands of one contact: `solve`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import ehl
from ehl.console import App, print_json


def solve(
    case_file: Annotated[Path, typer.Argument(metavar="CASE.toml", help="Input file of one contact.")],
    json_output: Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.")] = False,
    plot: Annotated[Path | None, typer.Option(help="Write a figure of the solution (PNG, SVG, PDF).")] = None,
    animate: Annotated[Path | None, typer.Option(help="Write the moving roughness as a film (GIF, HTML).")] = None,
    report: Annotated[Path | None, typer.Option(help="Write one HTML page with results, notes and figure.")] = None,
) -> None:
    """Solve one lubricated contact."""
    contact = ehl.Contact.from_file(case_file)
    if animate is not None:
        contact.check_animation(animate)
    result = contact.solve()
    if json_output:
        print_json(result.to_dict())
    else:
        result.table().print()
    if report is not None:
        result.report(report)
    if result.status != "failed":
        if plot is not None:
            result.plot(plot)
        if animate is not None:
            result.animate(animate)
    if result.status != "converged":
        typer.echo(f"{result.status}: {result.reason}", err=True)
        raise typer.Exit(1)


def register(app: App) -> None:
    """Add the commands of this package to the application."""
    app.command()(solve)
