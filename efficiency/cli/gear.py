"""Commands of one gear pair: `gear`, `map`, `duty`, `geometry`, `compare`, `demo`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import efficiency
from efficiency.cli.options import (
    OUTPUT,
    CsvOption,
    DesignArgument,
    DriverOption,
    EOption,
    FiguresOption,
    FrictionOption,
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
    StrengthOption,
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
from ehl.common.console import ADVANCED, GEAR, App, fail_unless_converged, given, is_list, print_json, working

BulkOption = Annotated[
    bool | None,
    typer.Option(
        "--bulk-temperature/--oil-temperature",
        help="Teeth by a heat balance, or as warm as the oil; default: a balance where the design states its cooling.",
        rich_help_panel=ADVANCED,
    ),
]
UncertaintyOption = Annotated[
    bool,
    typer.Option(
        "--uncertainty",
        help="Contribution of each input to the interval; for ehl by solved contacts at both ends (minutes).",
        rich_help_panel=ADVANCED,
    ),
]
LoadFromOption = Annotated[
    Path | None,
    typer.Option(
        help="CSV file with the load distribution of another program, in place of the own one.",
        rich_help_panel=ADVANCED,
    ),
]
SaveLoadOption = Annotated[
    Path | None,
    typer.Option(help="Write the load distribution as CSV, as --load-from reads it.", rich_help_panel=ADVANCED),
]
DutyArgument = Annotated[
    Path, typer.Argument(metavar="DUTY", help="Duty cycle, CSV or XLSX: torque, speed, temperature, hours.")
]


def gear(
    design: DesignArgument,
    friction: FrictionOption = "constant:0.05",
    torque: TorqueOption = None,
    speed: SpeedOption = None,
    temperature: TemperatureOption = None,
    oil: OilOption = None,
    side: SideOption = "drive",
    json_output: JsonOption = False,
    plot: FiguresOption = None,
    report: ReportOption = None,
    xlsx: XlsxOption = None,
    csv: CsvOption = None,
    units: UnitsOption = "metric",
    roughness_each: RoughnessEachOption = None,
    roughness_pinion: RoughnessPinionOption = None,
    roughness_gear: RoughnessGearOption = None,
    e: EOption = None,
    p: POption = None,
    g: GOption = None,
    shaft_angle_error: ShaftAngleOption = None,
    driver: DriverOption = None,
    load_balance: LoadBalanceOption = None,
    bulk_temperature: BulkOption = None,
    uncertainty: UncertaintyOption = False,
    load_from: LoadFromOption = None,
    save_load: SaveLoadOption = None,
) -> None:
    """Efficiency of a gear pair at one operating point: contact, load, friction, power loss, strength."""
    check_files(report=report, xlsx=xlsx)
    system = unit_system(units)
    pair = efficiency.load(design).misaligned(**given({"E": e, "P": p, "G": g, "shaft_angle_error": shaft_angle_error}))
    axes = _one_point(torque, speed, temperature)
    fixed = roughness(roughness_each, roughness_pinion, roughness_gear) | given({"oil": oil, "driver": driver})
    [model] = pair.check([friction], **axes, **fixed)
    balance_of = load_balance_of(load_balance)
    if load_from is not None:
        refuse("--load-from", {"bulk_temperature": bulk_temperature, "uncertainty": uncertainty})
    mesh = pair.mesh(one_side(side))
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
        if uncertainty and result.status == "converged":
            result = result.with_inputs(result.uncertainty(solved=True))
    files = {"plot": plot, "report": report, "xlsx": xlsx, "csv": csv}
    present(result, json_output, units=system, balance=balance, **files)


def map_points(
    design: DesignArgument,
    friction: FrictionOption = "constant:0.05",
    torque: TorqueOption = None,
    speed: SpeedOption = None,
    temperature: TemperatureOption = None,
    oil: OilOption = None,
    side: SideOption = "drive",
    json_output: JsonOption = False,
    plot: FiguresOption = None,
    report: ReportOption = None,
    xlsx: XlsxOption = None,
    csv: CsvOption = None,
    units: UnitsOption = "metric",
    roughness_each: RoughnessEachOption = None,
    roughness_pinion: RoughnessPinionOption = None,
    roughness_gear: RoughnessGearOption = None,
    e: EOption = None,
    p: POption = None,
    g: GOption = None,
    shaft_angle_error: ShaftAngleOption = None,
    driver: DriverOption = None,
    load_balance: LoadBalanceOption = None,
    strength: StrengthOption = False,
) -> None:
    """Efficiency of a gear pair over torque, speed and temperature.

    Each is one value, a list '100, 200, 300 N m' or a range '50:200:4 N m'; what is not given is that of the design.
    """
    check_files(report=report, xlsx=xlsx)
    system = unit_system(units)
    pair = efficiency.load(design).misaligned(**given({"E": e, "P": p, "G": g, "shaft_angle_error": shaft_angle_error}))
    axes: dict[str, Any] = given({"torque": torque, "speed": speed, "temperature": temperature})
    fixed = roughness(roughness_each, roughness_pinion, roughness_gear) | given({"oil": oil, "driver": driver})
    [model] = pair.check([friction], **axes, **fixed)
    fixed |= given({"load_balance": load_balance_of(load_balance)})
    with working("operating points"):
        grid = pair.mesh(one_side(side)).map(model, strength=strength, **axes, **fixed)
    present(grid, json_output, units=system, plot=plot, report=report, xlsx=xlsx, csv=csv)


def duty(
    design: DesignArgument,
    file: DutyArgument,
    friction: FrictionOption = "constant:0.05",
    oil: OilOption = None,
    json_output: JsonOption = False,
    xlsx: XlsxOption = None,
    csv: CsvOption = None,
    e: EOption = None,
    p: POption = None,
    g: GOption = None,
    shaft_angle_error: ShaftAngleOption = None,
    load_balance: LoadBalanceOption = None,
    roughness_each: RoughnessEachOption = None,
    roughness_pinion: RoughnessPinionOption = None,
    roughness_gear: RoughnessGearOption = None,
) -> None:
    """Energies of a gear pair over a duty cycle, by row and in total."""
    check_files(report=None, xlsx=xlsx)
    pair = efficiency.load(design).misaligned(**given({"E": e, "P": p, "G": g, "shaft_angle_error": shaft_angle_error}))
    conditions: dict[str, Any] = given({"oil": oil, "load_balance": load_balance_of(load_balance)})
    conditions |= roughness(roughness_each, roughness_pinion, roughness_gear)
    [model] = pair.check([friction], **conditions)
    with working("duty cycle"):
        cycle = pair.duty(file, model, **conditions)
    present(cycle, json_output, xlsx=xlsx, csv=csv)


def geometry(
    design: DesignArgument,
    side: Annotated[str, typer.Option(help="Flanks in contact: drive, coast or both.")] = "both",
    marking: Annotated[str | None, typer.Option(help="Thickness of the marking compound, default '6.35 um'.")] = None,
    json_output: JsonOption = False,
    plot: FiguresOption = None,
    report: ReportOption = None,
    units: UnitsOption = "metric",
    e: EOption = None,
    p: POption = None,
    g: GOption = None,
    shaft_angle_error: ShaftAngleOption = None,
) -> None:
    """Geometry and unloaded contact of a gear pair: ease-off, contact pattern, transmission error, contact ratios."""
    check_files(report=report, xlsx=None)
    system = unit_system(units)
    pair = efficiency.load(design).misaligned(**given({"E": e, "P": p, "G": g, "shaft_angle_error": shaft_angle_error}))
    shape = pair.geometry(side, marking)
    shape.write(units=system, plot=plot, report=report)
    print_json(shape.to_dict()) if json_output else shape.show(units=system)
    for name, reason in shape.failures.items():
        typer.echo(f"{name}: {reason}", err=True)
    fail_unless_converged(shape.status, "")


def _one_point(torque: str | None, speed: str | None, temperature: str | None) -> dict[str, Any]:
    """What is given of an operating point; lists are refused."""
    axes: dict[str, Any] = given({"torque": torque, "speed": speed, "temperature": temperature})
    for name, text in axes.items():
        if is_list(text):
            raise InputError(name, text, "one value", "Lists and ranges make a map: mixed-ehl map.")
    return axes


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
    axes = _one_point(torque, speed, temperature)
    fixed = roughness(roughness_each, roughness_pinion, roughness_gear) | given({"oil": oil, "driver": driver})
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
    app.command(rich_help_panel=GEAR)(gear)
    app.command("map", rich_help_panel=GEAR)(map_points)
    app.command(rich_help_panel=GEAR)(duty)
    app.command(rich_help_panel=GEAR)(geometry)
    app.command(rich_help_panel=GEAR)(compare)
