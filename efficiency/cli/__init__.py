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
    from efficiency.cli import axle, design, gear, new
    from efficiency.cli.options import with_groups
    from ehl import __version__
    from ehl.common.console import App, JsonOption, print_result, run
except KeyboardInterrupt:  # Ctrl-C in the first second
    print("mixed-ehl: stopped", file=sys.stderr)
    raise SystemExit(130) from None


class Commands(typer.core.TyperGroup):
    """All commands in the order of the work."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of the commands."""
        return [name for _, commands in COMMANDS for name in commands]


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


def warmup(
    kind: Annotated[str, typer.Argument(metavar="KIND", help="smooth, rough (includes smooth) or gear.")] = "gear",
    json_output: JsonOption = False,
) -> None:
    """Compile the solvers in advance."""
    print_result(efficiency.warmup(kind), json_output)


def show_app(
    design: Annotated[
        Path | None, typer.Argument(metavar="DESIGN", help="Design file, in addition to the shipped pairs.")
    ] = None,
    port: Annotated[int, typer.Option(help="Port on the loopback address.", min=1024, max=65535)] = 8642,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open a browser.")] = True,
) -> None:
    """Show a pair in the browser: pattern, loss, map, friction models, misalignment."""
    efficiency.serve_app(design, port=port, browser=browser)


# panels and commands of `mixed-ehl --help`, in the order of the work
FORMULA, DESIGN, GEAR = "Friction formula", "Gear design", "Gear efficiency"
COMMANDS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("Input files", {"new": new.new_app, "import": design.import_summary}),
    ("Contact", {"solve": ehl.cli.solve, "oil": ehl.cli.oil, "profile": ehl.cli.profile}),
    (FORMULA, {"plan": design.plan, "sweep": regression.cli.sweep_app, "fit": regression.cli.fit}),
    (FORMULA, {"mu": regression.cli.mu, "calibrate": regression.cli.calibrate}),
    (DESIGN, {"blank": design.blank, "settings": design.settings, "geometry": gear.geometry}),
    (DESIGN, {"misalignment": design.misalignment, "optimise": design.optimise, "correct": design.correct}),
    (DESIGN, {"export": design.export}),
    (GEAR, {"gear": gear.gear, "map": gear.map_points, "duty": gear.duty, "compare": gear.compare}),
    (GEAR, {"study": design.study}),
    ("Axle", {"loss-map": axle.loss_map, "axle-test": axle.axle_test, "axle": axle.axle}),
    ("Program", {"demo": gear.demo, "app": show_app, "doctor": doctor, "warmup": warmup}),
)
for panel, commands in COMMANDS:
    for name, command in commands.items():
        if isinstance(command, App):
            app.add_typer(command, name=name, rich_help_panel=panel)
        else:
            app.command(name, rich_help_panel=panel)(with_groups(command))


def main() -> None:
    """Entry point; every error is printed as one sentence and sets the exit code."""
    run(_command)


def _command() -> None:
    efficiency.doctor(installation_only=True)
    app(prog_name="mixed-ehl")  # also if another program runs the module


if __name__ == "__main__":
    main()
