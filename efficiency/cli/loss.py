"""What `gear` computes, prints and writes: one operating point, a map, a duty cycle; options of friction and loss."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from efficiency.cli.options import Lists
    from efficiency.contact.gear_flanks import Side
    from efficiency.design.design import Design
    from efficiency.output.gear_files import OutputFiles
    from efficiency.output.machine_summary import Units
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
LoadFromOption = Annotated[
    Path | None,
    typer.Option(
        help="CSV file with the load distribution of another program, in place of the own one.", rich_help_panel=LOSS
    ),
]
SaveLoadOption = Annotated[
    Path | None, typer.Option(help="Write the load distribution as CSV, as --load-from reads it.", rich_help_panel=LOSS)
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
    from ehl.io.errors import InputError

    if driver is None:
        return design
    if driver not in ("pinion", "gear"):
        raise InputError("--driver", driver, "pinion or gear")
    return design.model_copy(update={"operation": design.operation.model_copy(update={"driver": driver})})


def refuse(what: str, options: Mapping[str, object]) -> None:
    """`InputError` for options that mean nothing beside something else."""
    from ehl.io.errors import InputError

    for name, value in options.items():
        if value is not None and value is not False:
            raise InputError(name, str(value), f"nothing beside {what}")


def show_point(
    design: Design,
    friction: str,
    conditions: Conditions,
    side: Side,
    files: OutputFiles,
    units: Units,
    *,
    friction_in_equilibrium: bool,
    bulk_temperature: bool,
    uncertainty: bool,
    load_from: Path | None,
    save_load: Path | None,
    json_output: bool,
) -> None:
    """Compute, print and write one operating point."""
    from threadpoolctl import threadpool_limits

    from efficiency.ltca.external_load import write_load
    from efficiency.output.gear_files import Extras, write_result
    from efficiency.output.tables import efficiency_table
    from efficiency.run import run_gear, run_heat_balance, run_uncertainty
    from ehl.view.report import print_json

    if load_from is not None:
        refuse("--load-from", {"--bulk-temperature": bulk_temperature, "--uncertainty": uncertainty})
    balance = spread = bulk = None
    # matrices are small: threads of the linear algebra would only wait for each other
    with threadpool_limits(1):
        if bulk_temperature:
            balance = run_heat_balance(
                design, friction, conditions, side=side, friction_in_equilibrium=friction_in_equilibrium
            )
            result = balance.result
            bulk = (result.temperature_bulk_1, result.temperature_bulk_2, result.temperature_inlet)
        else:
            result = run_gear(
                design,
                friction,
                conditions,
                side=side,
                friction_in_equilibrium=friction_in_equilibrium,
                load_from=load_from,
            )
        if save_load is not None:
            write_load(result.load, save_load)
        if uncertainty and result.status == "converged":
            spread = run_uncertainty(
                design,
                friction,
                conditions,
                side=side,
                friction_in_equilibrium=friction_in_equilibrium,
                temperatures=bulk,
            )
    extras = Extras(balance, spread)
    if json_output:
        print_json(result.to_dict() | extras.to_dict())
    else:
        for table in (efficiency_table(result), *extras.tables()):
            table.print()
    write_result(design, result, files, units, extras)
    _fail_unless_converged(result.status, result.reason)


def show_map(
    design: Design,
    friction: str,
    lists: Lists,
    oil: str | None,
    side: Side,
    files: OutputFiles,
    units: Units,
    json_output: bool,
) -> None:
    """Compute, print and write a map."""
    from threadpoolctl import threadpool_limits

    from efficiency.cli.options import progress
    from efficiency.output.gear_files import write_map
    from efficiency.output.tables import efficiency_grids, remarks_table
    from efficiency.run import run_map
    from ehl.view.report import print_json

    with threadpool_limits(1), progress("operating points") as move:
        grid = run_map(design, friction, *lists, oil=oil, side=side, report=move)
    if json_output:
        print_json(grid.to_dict())
    else:
        for table in (*efficiency_grids(grid), remarks_table(grid.results)):
            table.print()
    write_map(design, grid, files, units)
    _fail_unless_converged(grid.status, grid.reason)


def show_duty(
    design: Design, friction: str, duty: Path, oil: str | None, files: OutputFiles, json_output: bool
) -> None:
    """Compute, print and write a duty cycle."""
    from threadpoolctl import threadpool_limits

    from efficiency.cli.options import progress
    from efficiency.loss.duty import read_duty
    from efficiency.output.gear_files import write_duty
    from efficiency.output.tables import duty_table
    from efficiency.run import run_duty
    from ehl.view.report import print_json

    rows = read_duty(duty)
    with threadpool_limits(1), progress("rows of the duty cycle") as move:
        cycle = run_duty(design, friction, rows, oil=oil, report=move)
    print_json(cycle.to_dict()) if json_output else duty_table(cycle).print()
    write_duty(cycle, files)
    _fail_unless_converged(cycle.status, cycle.reason)


def _fail_unless_converged(status: str, reason: str) -> None:
    """Exit code 1 with the reason on standard error."""
    if status != "converged":
        typer.echo(f"not converged: {reason}", err=True)
        raise typer.Exit(1)
