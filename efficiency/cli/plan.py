"""The command `plan`: the plan of a sweep over what designs see in their duty."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def plan(
    designs: Annotated[list[str], typer.Argument(metavar="DESIGN...", help="Design files, or names of shipped ones.")],
    duty: Annotated[
        Path, typer.Option(metavar="FILE", help="Duty cycle, CSV or XLSX: torque, speed, temperature, hours.")
    ],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="PLAN.toml", help="The plan file.")],
    oil: Annotated[str | None, typer.Option(help="Oil card in place of the designs'.")] = None,
    size: Annotated[int, typer.Option(min=1, help="Cases of the plan, for each oil.")] = 1024,
    coverage: Annotated[float, typer.Option(help="Share of the lost work inside each range.")] = 0.98,
    model: Annotated[
        str, typer.Option(help="Model of the roughness: deterministic or load_sharing.")
    ] = "deterministic",
) -> None:
    """Write the plan of a sweep whose ranges are what the contact points of gear designs see in their duty.

    The ranges are quantiles weighted with the work lost at each point.
    """
    from efficiency.design.design import load_design
    from efficiency.loss.duty import duty_points, read_duty
    from ehl.io.errors import InputError
    from regression import Plan, operating_range
    from regression.cli.files import check_outputs

    if model not in ("deterministic", "load_sharing"):
        raise InputError("--model", model, "deterministic or load_sharing")
    check_outputs({"--output": output}, {"--output": (".toml",)})
    rows = read_duty(duty)
    pairs = [load_design(design) for design in designs]
    points = duty_points(pairs, rows, oil=oil)
    ranges = operating_range(points, coverage)
    oils = tuple(dict.fromkeys([oil] if oil else [pair.operation.oil for pair in pairs]))
    names = ", ".join(pair.name for pair in pairs)
    words = f"{100.0 * coverage:g} % of the work lost by {names} over {len(rows)} operating points of {duty.name}"
    text = ranges.plan_text(output.stem, oils, size=size, description=words, roughness=model)
    try:
        output.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError("--output", str(output), "a writable path", f"{error.strerror}.") from None
    ranges.table().print()
    written = Plan.from_file(output)
    typer.echo(f"{output}: {written.count} cases; for its cost: mixed-ehl sweep {output} --estimate")


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command()(plan)
