"""The command line `mixed-ehl`: all commands of the three packages."""

import sys
from pathlib import Path
from typing import Annotated, Any

try:
    import typer
    import typer.core

    import efficiency
    import ehl.cli
    import regression.cli
    from efficiency.cli import axle, design, gear, loss_map, new, optimise
    from ehl import __version__
    from ehl.common.console import PROGRAM, App, JsonOption, print_json, run
except KeyboardInterrupt:  # Ctrl-C in the first second
    print("mixed-ehl: stopped", file=sys.stderr)
    raise SystemExit(130) from None

# commands of `mixed-ehl --help` in the order of the work
_ORDER = (
    *("new", "import", "solve", "oil", "profile", "plan", "sweep", "fit", "mu", "calibrate"),
    *("blank", "settings", "geometry", "misalignment", "optimise", "correct", "export"),
    *("gear", "map", "duty", "compare", "study", "loss-map", "axle-test", "axle", "demo", "app", "doctor", "warmup"),
)


class Commands(typer.core.TyperGroup):
    """All commands in the order of the work."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of the commands."""
        return sorted(super().list_commands(ctx), key=_ORDER.index)


app = App(
    name="mixed-ehl",
    cls=Commands,
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


for commands_of in (ehl.cli, regression.cli, gear, design, axle, loss_map, new, optimise):
    commands_of.register(app)
app.command(rich_help_panel=PROGRAM)(gear.demo)


@app.command(rich_help_panel=PROGRAM)
def doctor() -> None:
    """Check the installation and compare one solution with its reference value."""
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
    """Compile the solvers in advance."""
    ready = efficiency.warmup(kind)
    if json_output:
        print_json(ready.to_dict())
        return
    ready.show()


@app.command("app", rich_help_panel=PROGRAM)
def show_app(
    design: Annotated[
        Path | None, typer.Argument(metavar="DESIGN", help="Design file, in addition to the shipped pairs.")
    ] = None,
    port: Annotated[int, typer.Option(help="Port on the loopback address.", min=1024, max=65535)] = 8642,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open a browser.")] = True,
) -> None:
    """Show a pair in the browser: pattern, loss, map, friction models, misalignment."""
    efficiency.serve_app(design, port=port, browser=browser)


def main() -> None:
    """Entry point; every error is printed as one sentence and sets the exit code."""
    run(_command)


def _command() -> None:
    efficiency.doctor(installation_only=True)
    app(prog_name="mixed-ehl")  # also if another program runs the module


if __name__ == "__main__":
    main()
