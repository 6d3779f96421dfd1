"""Options of `gear` that concern friction and loss, and the duty cycle."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from efficiency.contact.pair import Side
    from efficiency.design import Design
    from efficiency.loss.result import EfficiencyResult
    from efficiency.run import Conditions

LOSS = "Friction and loss"

DriverOption = Annotated[
    str | None, typer.Option(help="Member the power comes from: pinion or gear.", rich_help_panel=LOSS)
]
EquilibriumOption = Annotated[
    bool,
    typer.Option(
        "--friction-in-equilibrium", help="Let friction forces help to carry the torque.", rich_help_panel=LOSS
    ),
]
BulkOption = Annotated[
    bool,
    typer.Option(
        "--bulk-temperature",
        help="Bulk temperature of the teeth by a heat balance, [cooling] of the design.",
        rich_help_panel=LOSS,
    ),
]
UncertaintyOption = Annotated[
    bool,
    typer.Option(
        "--uncertainty",
        help="Interval of the efficiency from formula, boundary friction and roughness.",
        rich_help_panel=LOSS,
    ),
]
DutyOption = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Duty cycle, CSV or XLSX: torque, speed, temperature, hours; energies by row and in total.",
        rich_help_panel=LOSS,
    ),
]


def with_driver(design: Design, driver: str | None) -> Design:
    """The design, driven by the member the command line names."""
    from ehl.errors import InputError

    if driver is None:
        return design
    if driver not in ("pinion", "gear"):
        raise InputError("--driver", driver, "pinion or gear")
    return design.model_copy(update={"operation": design.operation.model_copy(update={"driver": driver})})


def one_point(
    design: Design,
    friction: str,
    conditions: Conditions,
    side: Side,
    *,
    friction_in_equilibrium: bool,
    bulk_temperature: bool,
    uncertainty: bool,
    json_output: bool,
) -> EfficiencyResult:
    """Compute and print one operating point."""
    from efficiency.output.loss_tables import heat_lines, uncertainty_table
    from efficiency.output.tables import efficiency_table
    from efficiency.run import run_gear, run_heat_balance, run_uncertainty
    from ehl.report import print_json

    lines: list[str] = []
    content: dict[str, object] = {}
    if bulk_temperature:
        balance = run_heat_balance(
            design, friction, conditions, side=side, friction_in_equilibrium=friction_in_equilibrium
        )
        result, lines = balance.result, heat_lines(balance)
        content["heat_balance"] = {
            "heat": list(balance.heat),
            "thermal_resistance": list(balance.thermal_resistance),
            "rounds": balance.rounds,
            "residual": balance.residual,
        }
    else:
        result = run_gear(design, friction, conditions, side=side, friction_in_equilibrium=friction_in_equilibrium)
    known = None
    if uncertainty and result.status == "converged":
        bulk = (result.temperature_bulk_1, result.temperature_bulk_2, result.temperature_inlet)
        known = run_uncertainty(
            design,
            friction,
            conditions,
            side=side,
            friction_in_equilibrium=friction_in_equilibrium,
            temperatures=bulk if bulk_temperature else None,
        )
        content["uncertainty"] = known.to_dict()
    if json_output:
        print_json(result.to_dict() | content)
        return result
    efficiency_table(result)
    for line in lines:
        typer.echo(line)
    if known is not None:
        uncertainty_table(known)
    return result


def show_duty(design: Design, friction: str, duty: Path, oil: str | None, json_output: bool) -> None:
    """Compute and print a duty cycle.

    Raises
    ------
    typer.Exit
        With 1 where a row did not converge.
    """
    from threadpoolctl import threadpool_limits

    from efficiency.command_options import progress
    from efficiency.loss.duty import read_duty
    from efficiency.output.loss_tables import duty_table
    from efficiency.run import run_duty
    from ehl.report import print_json

    rows = read_duty(duty)
    with threadpool_limits(1), progress("operating points") as move:
        cycle = run_duty(design, friction, rows, oil=oil, report=move)
    print_json(cycle.to_dict()) if json_output else duty_table(cycle)
    if cycle.status != "converged":
        typer.echo(f"not converged: {cycle.reason}", err=True)
        raise typer.Exit(1)
