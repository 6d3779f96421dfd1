"""Command of the parameter study: `study`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from efficiency.cli.options import (
    MISALIGNMENT,
    OPERATION,
    OUTPUT,
    JobsOption,
    JsonOption,
    OilOption,
    SideOption,
    chosen_side,
    progress,
    value_list,
)

PAIRS = ("fh_hypoid_9x34", "fh_hypoid_9x34_offset_10")


def study(
    designs: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[DESIGN...]", help=f"Design files or names of shipped ones; default: {' '.join(PAIRS)}."
        ),
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for page, tables and figures.", rich_help_panel=OUTPUT)
    ] = Path("mixed-ehl-study"),
    friction: Annotated[
        str | None, typer.Option(help="Friction model as in `gear`; default: the formula shipped for the oil.")
    ] = None,
    torque: Annotated[
        str | None,
        typer.Option(help="Pinion torques, '50, 100, 200 N m' or '50:250:5 N m'.", rich_help_panel=OPERATION),
    ] = None,
    speed: Annotated[str | None, typer.Option(help="Pinion speeds.", rich_help_panel=OPERATION)] = None,
    temperature: Annotated[str | None, typer.Option(help="Oil temperatures.", rich_help_panel=OPERATION)] = None,
    roughness: Annotated[
        str | None, typer.Option(help="Rq of each flank: '0.2, 0.4 um'.", rich_help_panel=OPERATION)
    ] = None,
    oil: OilOption = None,
    side: SideOption = "drive",
    e: Annotated[
        str | None,
        typer.Option("--E", help="Along the offset: '-0.1, 0.1 mm'; '0 mm': none.", rich_help_panel=MISALIGNMENT),
    ] = None,
    p: Annotated[str | None, typer.Option("--P", help="Along the pinion axis.", rich_help_panel=MISALIGNMENT)] = None,
    g: Annotated[str | None, typer.Option("--G", help="Along the gear axis.", rich_help_panel=MISALIGNMENT)] = None,
    alpha: Annotated[
        str | None, typer.Option("--alpha", help="Of the shaft angle: '-4, 4 arcmin'.", rich_help_panel=MISALIGNMENT)
    ] = None,
    jobs: JobsOption = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Forget what an earlier run left in the folder.")] = False,
    json_output: JsonOption = False,
) -> None:
    """Parameter study: torque, speed, temperature, roughness, offset and misalignment against efficiency.

    All combinations of the operating parameters, misalignments one at a time. A study that was killed goes on.
    """
    from efficiency.design.design import OPERATION_LIMITS, MemberInput, Misalignment, load_design
    from efficiency.output.study_report import influence_table, study_json, write_study
    from efficiency.study.levels import Levels
    from efficiency.study.solve import run_study
    from ehl.io.errors import InputError
    from ehl.io.validation import value_range_of
    from ehl.view.report import print_json
    from regression.plan.cost import available_jobs

    quantities = {
        "torque": ("--torque", torque, OPERATION_LIMITS["torque"]),
        "speed": ("--speed", speed, OPERATION_LIMITS["speed"]),
        "temperature_oil": ("--temperature", temperature, OPERATION_LIMITS["temperature_oil"]),
        "roughness_rms": ("--roughness", roughness, value_range_of(MemberInput, "roughness_rms")),
    }
    for name, text in {"E": e, "P": p, "G": g, "alpha": alpha}.items():
        quantities[name] = (f"--{name}", text, value_range_of(Misalignment, name))
    given = {
        name: value_list(option, text, quantity)
        for name, (option, text, quantity) in quantities.items()
        if text is not None
    }
    pairs = [load_design(name) for name in designs or PAIRS]
    store = output / "points.jsonl"
    if fresh and store.exists():
        store.unlink()
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError("--output", str(output), "a folder that can be written", f"{error}.") from None
    with progress("points") as move:
        result = run_study(
            pairs,
            friction,
            Levels.around(pairs[0], **given),
            side=chosen_side(side),
            oil=oil,
            jobs=jobs or available_jobs(),
            store=store,
            report=move,
        )
    written = write_study(result, output)
    if json_output:
        print_json(study_json(result))
    else:
        influence_table(result).print()
        for path in written:
            print(path)
    if result.status != "converged":
        typer.echo(f"not converged: {result.reason}", err=True)
        raise typer.Exit(1)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command()(study)
