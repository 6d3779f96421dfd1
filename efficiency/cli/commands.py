"""Commands of the gear pair: `gear`, `compare`, `demo`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from efficiency.cli.loss import (
    BulkOption,
    DriverOption,
    DutyOption,
    EquilibriumOption,
    LoadFromOption,
    SaveLoadOption,
    UncertaintyOption,
    refuse,
    show_duty,
    show_map,
    show_point,
    with_driver,
)
from efficiency.cli.options import (
    GEOMETRY,
    OPERATION,
    OUTPUT,
    AlphaOption,
    CsvOption,
    DesignArgument,
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
)


def gear(
    design: DesignArgument,
    friction: Annotated[
        str,
        typer.Option(
            help="Formula file, constant:0.05, a published formula's name, ehl, ehl:load_sharing or ehl:smooth."
        ),
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
    load_from: LoadFromOption = None,
    save_load: SaveLoadOption = None,
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
    from ehl.io.errors import InputError

    misaligned = {"E": e, "P": p, "G": g, "alpha": alpha}
    point: dict[str, object] = {"--torque": torque, "--speed": speed, "--temperature": temperature, "--driver": driver}
    options: dict[str, object] = {
        "--friction-in-equilibrium": friction_in_equilibrium,
        "--bulk-temperature": bulk_temperature,
        "--uncertainty": uncertainty,
        "--load-from": load_from,
        "--save-load": save_load,
    }
    if geometry:
        from efficiency.cli.geometry import show_geometry

        files_of_load = {"--duty": duty, "--oil": oil, "--xlsx": xlsx, "--csv": csv}
        refuse("--geometry, which takes no load and no oil", point | options | files_of_load)
        show_geometry(aligned_design(design, misaligned), side or "both", marking, json_output, plot, report, units)
        return
    if marking is not None:
        raise InputError("--marking", marking, "only together with --geometry")
    files, shown = output_files(plot, report, xlsx, csv), chosen_units(units)
    pair, flanks = with_driver(aligned_design(design, misaligned), driver), chosen_side(side or "drive")
    if duty is not None:
        refuse("--duty", point | options | {"--side": side, "--plot": plot, "--report": report})
        show_duty(pair, friction, duty, oil, files, json_output)
        return
    lists = operating_lists(torque, speed, temperature)
    if any(len(values) > 1 for values in lists):
        refuse("lists of operating points", options)
        show_map(pair, friction, lists, oil, flanks, files, shown, json_output)
    else:
        show_point(
            pair,
            friction,
            first_conditions(lists, oil),
            flanks,
            files,
            shown,
            friction_in_equilibrium=friction_in_equilibrium,
            bulk_temperature=bulk_temperature,
            uncertainty=uncertainty,
            load_from=load_from,
            save_load=save_load,
            json_output=json_output,
        )


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
    load_from: LoadFromOption = None,
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
    from ehl.io.errors import InputError
    from ehl.view.report import print_json

    files = output_files(plot, report, xlsx, csv)
    lists = operating_lists(torque, speed, temperature)
    for values, name in zip(lists, ("--torque", "--speed", "--temperature"), strict=True):
        if len(values) > 1:
            raise InputError(name, values, "one value; lists make a map with `mixed-ehl gear`")
    with threadpool_limits(1):
        pair = with_driver(aligned_design(design, {}), driver)
        comparison = run_compare(
            pair, friction, first_conditions(lists, oil), side=chosen_side(side), load_from=load_from
        )
    print_json(comparison.to_dict()) if json_output else comparison_table(comparison).print()
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

    from efficiency.cli.demo import run_demo
    from efficiency.output.tables import comparison_table
    from regression.plan.cost import available_jobs

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
