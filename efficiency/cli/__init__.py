"""The command line `mixed-ehl`: all commands of the three packages, and what happens to errors."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

import ehl.cli
import regression.cli
import regression.cli.calibration
from efficiency.cli import blank, commands, geometry, plan, settings, study
from ehl import __version__
from ehl.io.errors import MixedEhlError

app = typer.Typer(
    name="mixed-ehl",
    help="Friction and efficiency of hypoid and spiral bevel gears.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        print(f"mixed-ehl {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """Friction and efficiency of hypoid and spiral bevel gears."""


for commands_of in (
    ehl.cli,
    regression.cli,
    regression.cli.calibration,
    commands,
    blank,
    geometry,
    plan,
    settings,
    study,
):
    commands_of.register(app)


@app.command()
def doctor() -> None:
    """Check the installation, and one solution against its reference value."""
    from rich.console import Console

    from efficiency.cli.doctor import examine

    console = Console()
    checks = examine()
    for check in checks:
        console.print(f"{'[green]ok   [/]' if check.passed else '[red]FAULT[/]'} {check.name}: {check.detail}")
    if not all(check.passed for check in checks):
        raise typer.Exit(1)


def main() -> None:
    """Entry point: errors of ours become one sentence and their exit code."""
    from efficiency.cli.doctor import require_one_installation

    try:
        require_one_installation()
        app()
    except MixedEhlError as error:
        print(f"mixed-ehl: {error}", file=sys.stderr)
        sys.exit(error.exit_code)


if __name__ == "__main__":
    main()
