"""The command line `mixed-ehl`: all commands of the three packages, and what happens to errors."""

from pathlib import Path
from typing import Annotated

import typer

import efficiency
import ehl.cli
import regression.cli
from efficiency.cli import axle, design, gear, loss_map, new, optimise
from ehl import __version__
from ehl.common.console import PROGRAM, App, JsonOption, print_json, run

app = App(
    name="mixed-ehl",
    help="Friction and efficiency of hypoid and spiral bevel gears.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
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


for commands_of in (ehl.cli, regression.cli, gear, design, loss_map, axle, new, optimise):
    commands_of.register(app)
app.command(rich_help_panel=PROGRAM)(gear.demo)


@app.command(rich_help_panel=PROGRAM)
def doctor() -> None:
    """Check the installation, and one solution against its reference value."""
    from rich.console import Console
    from rich.text import Text

    console = Console(markup=False, highlight=False)
    checks = efficiency.doctor()
    for check in checks:
        mark = Text("ok   ", "green") if check.passed else Text("FAULT", "red")
        console.print(mark, f"{check.name}: {check.detail}")
    if not all(check.passed for check in checks):
        raise typer.Exit(1)


@app.command(rich_help_panel=PROGRAM)
def warmup(
    kind: Annotated[str, typer.Argument(metavar="KIND", help="smooth, rough (includes smooth) or gear.")] = "gear",
    json_output: JsonOption = False,
) -> None:
    """Compile the solver in advance."""
    ready = efficiency.warmup(kind)
    if json_output:
        print_json(ready.to_dict())
        return
    ready.show()


@app.command("app", rich_help_panel=PROGRAM)
def show_app(
    design: Annotated[
        Path | None, typer.Argument(metavar="DESIGN", help="Design file, listed with the shipped pairs.")
    ] = None,
    port: Annotated[int, typer.Option(help="Port on the loopback address.", min=1024, max=65535)] = 8642,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open a browser.")] = True,
) -> None:
    """Show a pair in the browser: pattern, loss, map, friction models, misalignment; on this machine only."""
    efficiency.serve_app(design, port=port, browser=browser)


def main() -> None:
    """Entry point: whatever goes wrong becomes one sentence and an exit code."""
    run(_command)


def _command() -> None:
    efficiency.doctor(installation_only=True)
    app(prog_name="mixed-ehl")  # also where the module is run by another program


if __name__ == "__main__":
    main()
