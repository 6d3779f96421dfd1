"""Command that searches a better ease-off and blank: `optimise`."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any

import typer

import efficiency
from efficiency.cli.options import OPERATION, OUTPUT, DaskOption, JobsOption, JsonOption, OilOption
from ehl import InputError
from ehl.common.console import ADVANCED, GEAR, App, fail_unless_converged, given, output_folder, print_json, working


def optimise(
    targets: Annotated[str, typer.Argument(metavar="TARGETS", help="A targets file, or the name of a shipped one.")],
    output: Annotated[
        Path,
        typer.Option("--output", "-o", help="Folder for page, designs, tables and figures.", rich_help_panel=OUTPUT),
    ] = Path("mixed-ehl-optimise"),
    vary: Annotated[
        list[str] | None,
        typer.Option(
            help="A variable, with bounds or without: 'lengthwise_crowning=20:120 um', 'bias', 'hypoid_offset'; repeat "
            "for several. 'ease_off' (the default) and 'blank' stand for the usual ones of each.",
            rich_help_panel=ADVANCED,
        ),
    ] = None,
    objective: Annotated[
        list[str] | None,
        typer.Option(
            help="Figure to minimise, the most important first; default: power_loss, pressure_max, "
            "transmission_error_loaded.",
            rich_help_panel=ADVANCED,
        ),
    ] = None,
    limit: Annotated[
        list[str] | None,
        typer.Option(
            help="Figure that may not rise above today's, or above a value: 'pressure_max=1.4 GPa'; 'none' for none. "
            "Default: pressure, transmission error, edge load, root stresses, not above today's.",
            rich_help_panel=ADVANCED,
        ),
    ] = None,
    duty: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Duty cycle, CSV or XLSX: torque, speed, temperature, hours. Default: the targets' operating point.",
            rich_help_panel=OPERATION,
        ),
    ] = None,
    friction: Annotated[
        str | None,
        typer.Option(help="Friction formula; default: the one shipped for the oil.", rich_help_panel=OPERATION),
    ] = None,
    oil: OilOption = None,
    e: Annotated[
        str | None,
        typer.Option(
            "--E", help="Half width of the box; default '0.05 mm', '0 mm' for none.", rich_help_panel=ADVANCED
        ),
    ] = None,
    p: Annotated[
        str | None,
        typer.Option("--P", help="The same along the pinion axis; default '0.05 mm'.", rich_help_panel=ADVANCED),
    ] = None,
    g: Annotated[
        str | None, typer.Option("--G", help="Along the gear axis; default none.", rich_help_panel=ADVANCED)
    ] = None,
    shaft_angle_error: Annotated[
        str | None,
        typer.Option("--shaft-angle-error", help="Change of the shaft angle; default none.", rich_help_panel=ADVANCED),
    ] = None,
    tolerance: Annotated[
        list[str] | None,
        typer.Option(
            help="Error of the ease-off as made, to both sides: 'lengthwise_crowning=5 um'; repeat for several.",
            rich_help_panel=ADVANCED,
        ),
    ] = None,
    over: Annotated[
        str, typer.Option(help="Loss over the box: mean or worst; all else is the worst.", rich_help_panel=ADVANCED)
    ] = "mean",
    flanks: Annotated[
        str, typer.Option(help="Whose ease-off is varied: drive, coast or both.", rich_help_panel=ADVANCED)
    ] = "drive",
    evaluations: Annotated[int, typer.Option(help="Evaluations of the search.", rich_help_panel=ADVANCED)] = 120,
    batch: Annotated[int, typer.Option(help="Evaluations at the same time.", rich_help_panel=ADVANCED)] = 4,
    check: Annotated[int, typer.Option(help="Points checked on the full mesh.", rich_help_panel=ADVANCED)] = 4,
    check_friction: Annotated[
        str | None,
        typer.Option(
            help="Check the gain of the best with solved contacts: 'ehl' (minutes).", rich_help_panel=ADVANCED
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random numbers.", rich_help_panel=ADVANCED)] = 1,
    jobs: JobsOption = None,
    dask: DaskOption = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Forget what an earlier run left in the folder.")] = False,
    json_output: JsonOption = False,
) -> None:
    """Search ease-off and blank of a pair for less loss within limits of pressure, transmission error, edges and roots.

    Writes the front, and each checked point as a design file that `gear` opens. A search that was killed goes on. Exit
    code 1: no point is better within the limits.
    """
    store = output / "points.jsonl"
    if fresh and os.path.exists(store):
        store.unlink()
    box = {"E": "0.05 mm", "P": "0.05 mm"} | given({"E": e, "P": p, "G": g, "shaft_angle_error": shaft_angle_error})
    chosen: dict[str, Any] = {"objectives": objective, "limits": _limits(limit), "duty": duty, "misalignment": box}
    chosen |= {
        "tolerance": _tolerance(tolerance),
        "over": over,
        "flanks": flanks,
        "friction": friction,
        "oil": oil,
        "solved": check_friction,
    }
    chosen |= {"evaluations": evaluations, "batch": batch, "check": check, "seed": seed, "jobs": jobs}
    chosen |= {"dask": dask, "store": store}
    kept = f"finished evaluations are kept in {store}, the same command resumes"
    with output_folder(output), working("optimisation", kept):
        result = efficiency.optimise(targets, _variables(vary), **chosen)
    written = result.write(folder=output)
    if json_output:
        print_json(result.to_dict())
    else:
        result.show()
        for path in written:
            print(path)
    fail_unless_converged(result.status, result.reason)


def _variables(texts: list[str] | None) -> dict[str, Any] | None:
    if not texts:
        return None
    parts = [[part.strip() for part in text.partition("=")] for text in texts]
    return {name: bounds if equals else None for name, equals, bounds in parts}


def _tolerance(texts: list[str] | None) -> dict[str, Any]:
    parts = [[part.strip() for part in text.partition("=")] for text in texts or ()]
    for name, equals, value in parts:
        if not value:
            raise InputError("tolerance", name + equals, "'name=half width' such as 'lengthwise_crowning=5 um'")
    return {name: value for name, _, value in parts}


def _limits(texts: list[str] | None) -> dict[str, Any] | None:
    if not texts:
        return None
    if "none" in texts:
        if len(texts) > 1:
            raise InputError("limit", "none", "nothing beside it")
        return {}
    parts = [[part.strip() for part in text.partition("=")] for text in texts]
    return {name: value if equals else "start" for name, equals, value in parts}


def register(app: App) -> None:
    """Add the command to the application."""
    app.command(rich_help_panel=GEAR)(optimise)
