"""Command of the machine settings: `settings`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def settings(
    targets: Annotated[str, typer.Argument(metavar="TARGETS", help="A targets file, or the name of a shipped one.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Write the design file here.")] = None,
    json_output: Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.")] = False,
) -> None:
    """Machine settings of both members from a blank, a cutter and contact targets: a complete design file.

    Exit code 1: a residual stays above 3 um rms; the design is written all the same.
    """
    from efficiency.synthesis.inputs import load_targets
    from efficiency.synthesis.report import settings_tables
    from efficiency.synthesis.solve import machine_settings
    from ehl.view.report import print_json

    result = machine_settings(load_targets(targets))
    if output is not None:
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(result.text, encoding="utf-8")
    print_json(result.to_dict()) if json_output else settings_tables(result)
    if output is not None and not json_output:
        print(f"design: {output}")
    if result.status != "converged":
        typer.echo(f"not converged: {'; '.join(result.warnings)}", err=True)
        raise typer.Exit(1)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command()(settings)
