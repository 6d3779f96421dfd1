"""Command of the blank: `blank`."""

from __future__ import annotations

from typing import Annotated

import typer


def blank(
    file: Annotated[str, typer.Argument(metavar="FILE", help="A blank file, or the name of a shipped one.")],
    json_output: Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.")] = False,
) -> None:
    """Blank of a bevel or hypoid pair after ISO 23509: cones, depths, thicknesses, contact ratios, warnings."""
    from efficiency.blanks.inputs import load_blank
    from efficiency.blanks.pair import pair_blank
    from efficiency.blanks.report import blank_tables
    from ehl.view.report import print_json

    pair = pair_blank(load_blank(file))
    print_json(pair.to_dict()) if json_output else blank_tables(pair)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command()(blank)
