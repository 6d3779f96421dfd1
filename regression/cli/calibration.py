"""The command `calibrate`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def calibrate(
    measured: Annotated[Path, typer.Argument(metavar="MEASURED", help="Measured friction, CSV or XLSX.")],
    setup: Annotated[Path, typer.Option(metavar="SETUP.toml", help="Oil, parameters, specimens, common conditions.")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="CARD.toml", help="Write the calibrated oil card.")
    ] = None,
    fit: Annotated[
        list[str] | None, typer.Option("--fit", metavar="NAME", help="Parameter to fit, in place of the setup's.")
    ] = None,
    oil: Annotated[str | None, typer.Option(help="Oil card to begin with, in place of the setup's.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Write measured and computed curves (PNG, SVG, PDF).")] = None,
    jobs: Annotated[int | None, typer.Option(min=1, help="Worker processes; all processors if not given.")] = None,
    profile: Annotated[
        bool | None, typer.Option("--profile/--no-profile", help="Intervals by profiles; by default if cheap.")
    ] = None,
    json_output: Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.")] = False,
    synthetic: Annotated[
        Path | None,
        typer.Option(metavar="OUT.csv", help="Fit nothing: write synthetic friction for these conditions."),
    ] = None,
    true: Annotated[
        list[str] | None, typer.Option("--true", metavar="NAME=VALUE", help="Behind the synthetic friction.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the synthetic noise.")] = 1,
) -> None:
    """Fit oil and surface parameters to measured traction or Stribeck curves, and write an oil card."""
    import regression
    from ehl.view.report import print_json
    from regression.calibration.calibrate import setup_of
    from regression.cli.files import FIGURE, check_outputs
    from regression.plan.cost import available_jobs

    files = {"--output": output, "--plot": plot, "--synthetic": synthetic}
    check_outputs(files, {"--output": (".toml",), "--plot": FIGURE})
    content = setup_of(setup, fit, oil)
    workers = available_jobs() if jobs is None else jobs
    if synthetic is not None:
        from regression.calibration.measurement import read_measurement
        from regression.calibration.synthetic import parse_true, write_synthetic
        from regression.calibration.synthetic import synthetic as make

        planned = read_measurement(measured, content.conditions.given(), friction=False)
        truth = parse_true(true or [])
        made = make(planned, content, seed, truth=truth, jobs=workers)
        write_synthetic(made, content, seed, truth, synthetic)
        typer.echo(f"written: {synthetic}, synthetic")
        return
    result = regression.calibrate(
        measured, content, jobs=workers, profile=profile, progress=lambda words: typer.echo(words, err=True)
    )
    if plot is not None:
        from ehl.view.plots import save_figure

        save_figure(result.plot(), plot)
    if output is not None:
        result.save_card(output)
    if json_output:
        print_json(result.to_dict())
        return
    result.print()
    if output is not None:
        typer.echo(f"written: {output}. To use it:")
        for line in result.use_lines(output):
            typer.echo(f"  {line}")


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command()(calibrate)
