"""Commands of one contact: `solve`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def solve(
    case_file: Annotated[Path, typer.Argument(metavar="CASE.toml", help="Input file of one contact.")],
    json_output: Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.")] = False,
    plot: Annotated[Path | None, typer.Option(help="Write a figure of the solution (PNG, SVG, PDF).")] = None,
    animate: Annotated[Path | None, typer.Option(help="Write the moving roughness as a film (GIF, HTML).")] = None,
) -> None:
    """Solve one lubricated contact."""
    from ehl.case import load_case
    from ehl.solve import solve_case
    from ehl.view.report import print_json, result_table

    case = load_case(case_file)
    if animate is not None:
        from ehl.view.animation import check_animation

        check_animation(case, animate)
    result = solve_case(case)
    if json_output:
        print_json(result.to_dict())
    else:
        result_table(case, result)
    if plot is not None and result.status != "failed":
        from ehl.view.plots import plot_contact, save_figure

        save_figure(plot_contact(case, result), plot)
    if animate is not None and result.status != "failed":
        from ehl.view.animation import animate_contact

        animate_contact(case, result, animate)
    if result.status != "converged":
        typer.echo(f"{result.status}: {result.reason}", err=True)
        raise typer.Exit(1)


def register(app: typer.Typer) -> None:
    """Add the commands of this package to the application."""
    app.command()(solve)
