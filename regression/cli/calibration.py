"""The command `calibrate`."""

from pathlib import Path
from typing import Annotated

import typer

import regression
from ehl.common.console import FORMULA, App, JsonOption, advanced, check_outputs, print_json, working


def calibrate(
    measured: Annotated[Path, typer.Argument(metavar="MEASURED", help="Measured friction, CSV or XLSX.")],
    setup: Annotated[Path, typer.Option(metavar="SETUP.toml", help="Oil, parameters, specimens, common conditions.")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="CARD.toml", help="Write the calibrated oil card.")
    ] = None,
    fit: Annotated[
        list[str] | None,
        typer.Option("--fit", metavar="NAME", help="Fitted parameter, in place of the setup; repeat for several."),
    ] = None,
    oil: Annotated[str | None, typer.Option(help="Initial oil card, in place of that of the setup.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Write measured and computed curves (PNG, SVG, PDF).")] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="CALIBRATION.html", help="Write one page on parameters, curves, misfit.")
    ] = None,
    jobs: Annotated[int | None, typer.Option(min=1, help="Worker processes; default: all processors.")] = None,
    profile: Annotated[
        bool | None, advanced("--profile/--no-profile", help="Intervals from profiles; default: at low cost only.")
    ] = None,
    force: Annotated[
        bool, advanced("--force", help="Write the card even if the misfit exceeds the stated noise.")
    ] = False,
    json_output: JsonOption = False,
) -> None:
    """Fit oil and surface parameters to measured traction or Stribeck curves, and write an oil card."""
    check_outputs({"output": output, "plot": plot, "report": report}, output=".toml")
    with working("calibration"):
        result = regression.calibrate(measured, setup, profile=profile, parameters=fit, oil=oil, jobs=jobs)
    result.write(plot=plot, report=report)
    if json_output:
        print_json(result.to_dict())
    else:
        result.show()
    if output is not None:
        result.save_card(output, force=force)
    if output is not None and not json_output:
        typer.echo(f"written: {output}. To use it:")
        for line in result.use_lines(output):
            typer.echo(f"  {line}")


def register(app: App) -> None:
    """Add the command to the application."""
    app.command(rich_help_panel=FORMULA)(calibrate)
