"""Commands of the gear pair: `gear`, `compare`, `demo`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import efficiency
from efficiency.cli.options import (
    GEOMETRY,
    OPERATION,
    OUTPUT,
    CsvOption,
    DesignArgument,
    EOption,
    FiguresOption,
    GOption,
    JobsOption,
    JsonOption,
    LoadBalanceOption,
    OilOption,
    POption,
    ReportOption,
    RoughnessEachOption,
    RoughnessGearOption,
    RoughnessPinionOption,
    ShaftAngleOption,
    SideOption,
    SpeedOption,
    TemperatureOption,
    TorqueOption,
    UnitsOption,
    XlsxOption,
    check_files,
    load_balance_of,
    one_side,
    present,
    refuse,
    roughness,
    unit_system,
)
from ehl import InputError
from ehl.common.console import App, fail_unless_converged, given, is_list, print_json, working

LOSS = "Friction and loss"

DriverOption = Annotated[
    str | None, typer.Option(help="Member the power comes from: pinion or gear.", rich_help_panel=LOSS)
]
BulkOption = Annotated[
    bool | None,
    typer.Option(
        "--bulk-temperature/--oil-temperature",
        help="Teeth by a heat balance, or as warm as the oil; default: a balance where the design states its cooling.",
        rich_help_panel=LOSS,
    ),
]
UncertaintyOption = Annotated[
    bool,
    typer.Option(
        "--uncertainty",
        help="What each input makes of the interval; for ehl by solving contacts at both ends (minutes).",
        rich_help_panel=LOSS,
    ),
]
StrengthOption = Annotated[
    bool,
    typer.Option(
        "--strength",
        help="Maps: columns of worst grade, safety factors, integral temperature and specific film (0.1 s a point).",
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
    roughness_each: RoughnessEachOption = None,
    roughness_pinion: RoughnessPinionOption = None,
    roughness_gear: RoughnessGearOption = None,
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
    shaft_angle_error: ShaftAngleOption = None,
    driver: DriverOption = None,
    load_balance: LoadBalanceOption = None,
    bulk_temperature: BulkOption = None,
    uncertainty: UncertaintyOption = False,
    strength: StrengthOption = False,
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
    point: dict[str, object] = {"torque": torque, "speed": speed, "temperature": temperature, "driver": driver}
    rough = roughness(roughness_each, roughness_pinion, roughness_gear)
    options: dict[str, object] = {
        "bulk_temperature": bulk_temperature,
        "uncertainty": uncertainty,
        "load_from": load_from,
        "save_load": save_load,
    }
    check_files(report=report, xlsx=xlsx)
    system = unit_system(units)
    pair = efficiency.load(design).misaligned(**given({"E": e, "P": p, "G": g, "shaft_angle_error": shaft_angle_error}))
    if geometry:
        refuse(
            "--geometry, which takes no load and no oil",
            point
            | rough
            | options
            | {"load_balance": load_balance, "duty": duty, "oil": oil, "xlsx": xlsx, "csv": csv},
        )
        shape = pair.geometry(side or "both", marking)
        shape.write(units=system, plot=plot, report=report)
        print_json(shape.to_dict()) if json_output else shape.show(units=system)
        for name, reason in shape.failures.items():
            typer.echo(f"{name}: {reason}", err=True)
        fail_unless_converged(shape.status, "")
        return
    if marking is not None:
        raise InputError("marking", marking, "only together with --geometry")
    balance_of = load_balance_of(load_balance)
    axes = given({"torque": torque, "speed": speed, "temperature": temperature})
    fixed = given({"oil": oil, "driver": driver}) | rough
    [model] = pair.check([friction], **axes, **fixed)
    flanks = one_side(side or "drive")
    if duty is not None:
        refuse("--duty", point | rough | options | {"strength": strength, "side": side, "plot": plot, "report": report})
        with working("duty cycle"):
            cycle = pair.duty(duty, model, oil=oil, load_balance=balance_of)
        present(cycle, json_output, xlsx=xlsx, csv=csv)
        return
    if any(is_list(text) for text in axes.values()):
        refuse("lists of operating points", options)
        with working("operating points"):
            more = fixed | given({"load_balance": balance_of})
            grid = pair.mesh(flanks).map(model, fixed=more, strength=strength, **axes)
        present(grid, json_output, units=system, plot=plot, report=report, xlsx=xlsx, csv=csv)
        return
    refuse("one operating point, whose strength is always shown", {"strength": strength})
    if load_from is not None:
        refuse("--load-from", {"bulk_temperature": bulk_temperature, "uncertainty": uncertainty})
    mesh = pair.mesh(flanks)
    at = axes.pop("torque", None)
    conditions, balance = axes | fixed, None
    with working("gear pair"):
        loaded = mesh.load(at) if load_from is None else mesh.load_from(load_from, at)
        if loaded.balances_heat(None if bulk_temperature is None else "balance" if bulk_temperature else "oil"):
            balance = loaded.heat_balance(model, load_balance=balance_of, **conditions)
            result = balance.result
        else:
            result = loaded.efficiency(model, load_balance=balance_of, bulk="oil", **conditions)
        if save_load is not None:
            loaded.write_load(save_load)
        spread = None
        if uncertainty and result.status == "converged":
            result = result.with_inputs(result.uncertainty(solved=True))
            spread = result.inputs
    more = given({"balance": balance, "uncertainty": spread})
    present(result, json_output, units=system, plot=plot, report=report, xlsx=xlsx, csv=csv, **more)


def compare(
    design: DesignArgument,
    friction: Annotated[
        list[str] | None, typer.Option(help="A friction model; repeat for several. Default: constants, published, ehl.")
    ] = None,
    torque: TorqueOption = None,
    speed: SpeedOption = None,
    temperature: TemperatureOption = None,
    oil: OilOption = None,
    roughness_each: RoughnessEachOption = None,
    roughness_pinion: RoughnessPinionOption = None,
    roughness_gear: RoughnessGearOption = None,
    side: SideOption = "drive",
    driver: DriverOption = None,
    load_balance: LoadBalanceOption = None,
    load_from: LoadFromOption = None,
    json_output: JsonOption = False,
    plot: Annotated[Path | None, typer.Option(help="Write the figure (PNG, SVG, PDF).", rich_help_panel=OUTPUT)] = None,
    report: ReportOption = None,
    xlsx: XlsxOption = None,
    csv: CsvOption = None,
) -> None:
    """Compare friction models, constant mu and closed forms on one gear pair."""
    check_files(report=report, xlsx=xlsx)
    axes = given({"torque": torque, "speed": speed, "temperature": temperature})
    for name, text in axes.items():
        if is_list(text):
            raise InputError(name, text, "one value; lists make a map with `mixed-ehl gear`")
    fixed = given({"oil": oil, "driver": driver}) | roughness(roughness_each, roughness_pinion, roughness_gear)
    pair = efficiency.load(design)
    models = pair.check(friction or (), **axes, **fixed) or None
    mesh, at = pair.mesh(one_side(side)), axes.pop("torque", None)
    with working("comparison"):
        loaded = mesh.load(at) if load_from is None else mesh.load_from(load_from, at)
        comparison = loaded.compare(models, load_balance=load_balance_of(load_balance), **axes, **fixed)
    present(comparison, json_output, plot=plot, report=report, xlsx=xlsx, csv=csv)


def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the results.")] = Path("mixed-ehl-demo"),
    jobs: JobsOption = None,
) -> None:
    """The main job, small and real: sweep, fit, gear, compare, one HTML report."""
    kept = f"solved contacts are kept in {output}, the same command goes on from there"
    with working("demonstration", kept):
        result = efficiency.demo(output, jobs)
    result.comparison.show()
    print(f"report: {output / 'report.html'}")
    fail_unless_converged(result.comparison.status, result.comparison.reason)


def register(app: App) -> None:
    """Add the commands of this package to the application."""
    app.command()(gear)
    app.command()(compare)
    app.command()(demo)
