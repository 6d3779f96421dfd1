"""Commands of the gear pair: `gear`, `compare`, `demo`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from efficiency.command_options import (
    GEOMETRY,
    OPERATION,
    OUTPUT,
    AlphaOption,
    CsvOption,
    DesignArgument,
    DriverOption,
    EOption,
    FiguresOption,
    GOption,
    JobsOption,
    JsonOption,
    OilOption,
    POption,
    ReportOption,
    SideOption,
    SpeedOption,
    TemperatureOption,
    TorqueOption,
    UnitsOption,
    XlsxOption,
    aligned_design,
    chosen_side,
    first_conditions,
    operating_lists,
    output_files,
    progress,
)
from efficiency.commands_loss import (
    BulkOption,
    DriverOption,
    DutyOption,
    EquilibriumOption,
    UncertaintyOption,
    show_duty,
    with_driver,
)

if TYPE_CHECKING:
    from efficiency.command_options import Lists
    from efficiency.contact.pair import Side
    from efficiency.design import Design
    from efficiency.output.gear_files import OutputFiles
    from efficiency.output.machine_summary import Units
    from efficiency.run import Conditions


def gear(
    design: DesignArgument,
    friction: Annotated[
        str, typer.Option(help="Formula file, constant:0.05, a published formula's name, ehl or ehl:smooth.")
    ] = "constant:0.05",
    torque: TorqueOption = None,
    speed: SpeedOption = None,
    temperature: TemperatureOption = None,
    oil: OilOption = None,
    side: Annotated[
        str | None,
        typer.Option(
            help="Flanks in contact: drive (default under load), coast, or both (geometry only).",
            rich_help_panel=OPERATION,
        ),
    ] = None,
    e: EOption = None,
    p: POption = None,
    g: GOption = None,
    alpha: AlphaOption = None,
    driver: DriverOption = None,
    friction_in_equilibrium: EquilibriumOption = False,
    bulk_temperature: BulkOption = False,
    uncertainty: UncertaintyOption = False,
    duty: DutyOption = None,
    json_output: JsonOption = False,
    plot: FiguresOption = None,
    report: ReportOption = None,
    xlsx: XlsxOption = None,
    csv: CsvOption = None,
    units: UnitsOption = "metric",
    geometry: Annotated[
        bool,
        typer.Option(
            "--geometry",
            help="Unloaded contact: no load, no friction.",
            rich_help_panel=GEOMETRY,
        ),
    ] = False,
    marking: Annotated[
        str | None,
        typer.Option(help="Thickness of the marking compound, default '6.35 um'.", rich_help_panel=GEOMETRY),
    ] = None,
) -> None:
    """Efficiency of a gear pair: geometry, contact, load, friction, power loss.

    A comma-separated list of torques, speeds or temperatures ('100, 200, 300 N m') makes a map.
    """

    from efficiency.output.machine_summary import chosen_units
    from ehl.errors import InputError

    misaligned = {"E": e, "P": p, "G": g, "alpha": alpha}
    if geometry:
        from efficiency.commands_geometry import show_geometry

        loaded = {"torque": torque, "speed": speed, "temperature": temperature, "oil": oil, "xlsx": xlsx, "csv": csv}
        loaded |= {"duty": duty, "driver": driver}
        for name, value in loaded.items():
            if value is not None:
                raise InputError(f"--{name}", str(value), "nothing beside --geometry, which takes no load and no oil")
        show_geometry(aligned_design(design, misaligned), side or "both", marking, json_output, plot, report, units)
        return
    if marking is not None:
        raise InputError("--marking", marking, "only together with --geometry")
    files, shown = output_files(plot, report, xlsx, csv), chosen_units(units)
    pair, flanks = with_driver(aligned_design(design, misaligned), driver), chosen_side(side or "drive")
    extras = {
        "friction-in-equilibrium": friction_in_equilibrium,
        "bulk-temperature": bulk_temperature,
        "uncertainty": uncertainty,
    }
    if duty is not None:
        taken: dict[str, object] = {"torque": torque, "speed": speed, "temperature": temperature}
        taken |= {"side": side, "driver": driver}
        taken |= {"plot": plot, "report": report, "xlsx": xlsx, "csv": csv}
        taken |= {name: given or None for name, given in extras.items()}
        for name, unused in taken.items():
            if unused is not None:
                raise InputError(f"--{name}", str(unused), "nothing beside --duty")
        show_duty(pair, friction, duty, oil, json_output)
        return
    lists = operating_lists(torque, speed, temperature)
    single = {"--heat-balance": heat_balance, "--uncertainty": uncertainty}
    if duty is not None:
        points = {
            "--torque": torque,
            "--speed": speed,
            "--temperature": temperature,
            "--side": side,
            "--driver": driver,
        }
        _refuse("--duty", points | single | {"--friction-in-equilibrium": friction_in_equilibrium})
        _show_duty(pair, friction, duty, oil, files, json_output)
    elif any(len(values) > 1 for values in lists):
        _refuse("lists of operating points", single | {"--friction-in-equilibrium": friction_in_equilibrium})
        _show_map(pair, friction, lists, oil, flanks, driver, files, shown, json_output)
    else:
        options = _SinglePoint(heat_balance, uncertainty, friction_in_equilibrium)
        _show_point(pair, friction, first_conditions(lists, oil, driver), flanks, options, files, shown, json_output)


class _SinglePoint(NamedTuple):
    """What can be asked of one operating point."""

    heat_balance: bool
    uncertainty: bool
    friction_in_equilibrium: bool


def _refuse(what: str, options: dict[str, str | bool | None]) -> None:
    """`InputError` for options that mean nothing beside something else."""
    from ehl.errors import InputError

    for name, value in options.items():
        if value not in (None, False):
            raise InputError(name, str(value), f"nothing beside {what}")


def _fail_unless_converged(status: str, reason: str) -> None:
    if status != "converged":
        typer.echo(f"not converged: {reason}", err=True)
        raise typer.Exit(1)


def _show_point(
    pair: Design,
    friction: str,
    conditions: Conditions,
    side: Side,
    options: _SinglePoint,
    files: OutputFiles,
    units: Units,
    json_output: bool,
) -> None:
    """Compute, print and write one operating point."""
    from threadpoolctl import threadpool_limits

    from efficiency.output.gear_files import Extras, write_result
    from efficiency.output.tables import efficiency_table
    from efficiency.run import run_gear, run_heat_balance, run_uncertainty
    from ehl.report import print_json

    chosen = {"side": side, "friction_in_equilibrium": options.friction_in_equilibrium}
    # matrices are small: threads of the linear algebra would only wait for each other
    with threadpool_limits(1):
        balance = run_heat_balance(pair, friction, conditions, **chosen) if options.heat_balance else None
        result = run_gear(pair, friction, conditions, **chosen) if balance is None else balance.result
        warm = (result.temperature_bulk_1, result.temperature_bulk_2, result.temperature_inlet)
        spread = (
            run_uncertainty(pair, friction, conditions, temperatures=warm, **chosen) if options.uncertainty else None
        )
    extras = Extras(balance, spread)
    if json_output:
        print_json(result.to_dict() | extras.to_dict())
    else:
        efficiency_table(result)
        extras.show()
    write_result(pair, result, files, units, extras)
    _fail_unless_converged(result.status, result.reason)


def _show_map(
    pair: Design,
    friction: str,
    lists: Lists,
    oil: str | None,
    side: Side,
    driver: str | None,
    files: OutputFiles,
    units: Units,
    json_output: bool,
) -> None:
    """Compute, print and write a map."""
    from threadpoolctl import threadpool_limits

    from efficiency.output.gear_files import write_map
    from efficiency.output.tables import map_table
    from efficiency.run import run_map
    from ehl.report import print_json

    if driver is not None:
        operation = pair.operation.model_copy(update={"driver": first_conditions(lists, oil, driver).driver})
        pair = pair.model_copy(update={"operation": operation})
    with threadpool_limits(1), progress("operating points") as move:
        grid = run_map(pair, friction, *lists, oil=oil, side=side, report=move)
    print_json(grid.to_dict()) if json_output else map_table(grid)
    write_map(pair, grid, files, units)
    _fail_unless_converged(grid.status, grid.reason)


def _show_duty(pair: Design, friction: str, file: Path, oil: str | None, files: OutputFiles, json_output: bool) -> None:
    """Compute, print and write a duty cycle."""
    from threadpoolctl import threadpool_limits

    from efficiency.loss.duty import read_duty
    from efficiency.output.gear_extras import DUTY_HEADER, duty_rows, print_rows
    from efficiency.output.gear_files import write_duty
    from efficiency.run import run_duty
    from ehl.report import print_json

    rows = read_duty(file)
    with threadpool_limits(1), progress("rows of the duty cycle") as move:
        cycle = run_duty(pair, friction, rows, oil=oil, report=move)
    if json_output:
        print_json(cycle.to_dict())
    else:
        print_rows(f"{cycle.design}: duty cycle, friction {cycle.friction_model}", DUTY_HEADER, duty_rows(cycle), 2)
    write_duty(cycle, files)
    _fail_unless_converged(cycle.status, cycle.reason)


def compare(
    design: DesignArgument,
    friction: Annotated[
        list[str] | None, typer.Option(help="A friction model; repeat for several. Default: constants, published, ehl.")
    ] = None,
    torque: TorqueOption = None,
    speed: SpeedOption = None,
    temperature: TemperatureOption = None,
    oil: OilOption = None,
    side: SideOption = "drive",
    driver: DriverOption = None,
    json_output: JsonOption = False,
    plot: Annotated[Path | None, typer.Option(help="Write the figure (PNG, SVG, PDF).", rich_help_panel=OUTPUT)] = None,
    report: ReportOption = None,
    xlsx: XlsxOption = None,
    csv: CsvOption = None,
) -> None:
    """Compare friction models, constant mu and closed forms on one gear pair."""
    from threadpoolctl import threadpool_limits

    from efficiency.output.gear_files import write_comparison
    from efficiency.output.tables import comparison_table
    from efficiency.run import run_compare
    from ehl.errors import InputError
    from ehl.report import print_json

    files = output_files(plot, report, xlsx, csv)
    lists = operating_lists(torque, speed, temperature)
    for values, name in zip(lists, ("--torque", "--speed", "--temperature"), strict=True):
        if len(values) > 1:
            raise InputError(name, values, "one value; lists make a map with `mixed-ehl gear`")
    with threadpool_limits(1):
        comparison = run_compare(design, friction, first_conditions(lists, oil, driver), side=chosen_side(side))
    print_json(comparison.to_dict()) if json_output else comparison_table(comparison)
    write_comparison(comparison, files)
    if comparison.status != "converged":
        failed = ", ".join(f"{row.name} ({row.reason})" for row in comparison.rows if row.status == "failed")
        typer.echo(f"not converged: {failed}", err=True)
        raise typer.Exit(1)


def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the results.")] = Path("mixed-ehl-demo"),
    jobs: JobsOption = None,
) -> None:
    """The main job, small and real: sweep, fit, gear, compare, one HTML report."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from efficiency.demo import run_demo
    from efficiency.output.tables import comparison_table
    from regression.sweep import available_jobs

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True)) as bars:
        tasks = {name: bars.add_task(name, total=None) for name in ("contacts", "formulas", "gear pair")}

        def notify(step: str, done: int, total: int) -> None:
            bars.update(tasks[step], completed=done, total=total)

        result = run_demo(output, jobs or available_jobs(), notify)
    comparison_table(result.comparison)
    print(f"report: {output / 'report.html'}")
    if result.comparison.status != "converged":
        raise typer.Exit(1)


def register(app: typer.Typer) -> None:
    """Add the commands of this package to the application."""
    app.command()(gear)
    app.command()(compare)
    app.command()(demo)
