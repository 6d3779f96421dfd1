"""Commands that write loss maps of an axle: `loss-map`, `axle-test`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, cast

import typer

import efficiency
from efficiency.cli.options import (
    CsvOption,
    DesignArgument,
    JsonOption,
    LoadBalanceOption,
    OilOption,
    RoughnessEachOption,
    RoughnessGearOption,
    RoughnessPinionOption,
    TemperatureOption,
    XlsxOption,
    check_files,
    load_balance_of,
    present,
    roughness,
)
from ehl import InputError
from ehl.common.console import ADVANCED, GEAR, App, check_outputs, check_suffix, given, working

FrictionOption = Annotated[str, typer.Option(help="Friction model, as of `mixed-ehl gear`.")]
AxleOption = Annotated[
    Path | None,
    typer.Option(
        help="Table of bearing and drag losses, CSV or XLSX: torque, speed of the pinion, torque_loss.",
        rich_help_panel=ADVANCED,
    ),
]
DragOption = Annotated[
    str | None, typer.Option(help="Constant drag torque at the pinion: '2 N m' (our model).", rich_help_panel=ADVANCED)
]
BearingOption = Annotated[
    str | None,
    typer.Option(help="Bearings: share of the pinion torque lost, '0.5 %' (our model).", rich_help_panel=ADVANCED),
]


def loss_map(
    design: DesignArgument,
    torque: Annotated[str, typer.Option(help="Pinion torques, below zero in coast: '-300:300:7 N m', or a list.")],
    speed: Annotated[str, typer.Option(help="Pinion speeds: '50:2000:5 rpm', or a list.")],
    friction: FrictionOption = "constant:0.05",
    temperature: TemperatureOption = None,
    oil: OilOption = None,
    axle_losses: AxleOption = None,
    drag: DragOption = None,
    load_share: BearingOption = None,
    load_balance: LoadBalanceOption = None,
    roughness_each: RoughnessEachOption = None,
    roughness_pinion: RoughnessPinionOption = None,
    roughness_gear: RoughnessGearOption = None,
    vecto: Annotated[Path | None, typer.Option(help="Write a VECTO loss map (.vtlm).")] = None,
    json_output: JsonOption = False,
    xlsx: XlsxOption = None,
    csv: CsvOption = None,
) -> None:
    """Torque loss over pinion torque and speed, drive and coast, for vehicle simulation."""
    check_suffix(vecto, "vecto", (".vtlm",))
    check_outputs({"vecto": vecto})
    rough = roughness(roughness_each, roughness_pinion, roughness_gear)
    options = _options(temperature, oil, load_balance, xlsx) | rough
    axle = _axle(axle_losses, drag, load_share)
    with working("loss map"):
        found = efficiency.load(design).loss_map(torque, speed, friction, axle=axle, **options)
    if vecto is not None and found.status == "converged":
        found.to_vecto(vecto)
    present(found, json_output, xlsx=xlsx, csv=csv)


def axle_test(
    design: DesignArgument,
    application: Annotated[
        str, typer.Option(help="single (output torque to 4000 N m) or tandem (2000 N m).")
    ] = "single",
    torque_max: Annotated[str | None, typer.Option(help="Output torque the axle is rated for: '2500 N m'.")] = None,
    revolutions_per_mile: Annotated[
        float, typer.Option(help="Revolutions of the smallest tyre.", rich_help_panel=ADVANCED)
    ] = 650.0,
    friction: FrictionOption = "constant:0.05",
    temperature: TemperatureOption = None,
    oil: OilOption = None,
    axle_losses: AxleOption = None,
    drag: DragOption = None,
    load_share: BearingOption = None,
    load_balance: LoadBalanceOption = None,
    roughness_each: RoughnessEachOption = None,
    roughness_pinion: RoughnessPinionOption = None,
    roughness_gear: RoughnessGearOption = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write the grid as CSV, with GEM's decimals.")
    ] = None,
    json_output: JsonOption = False,
    xlsx: XlsxOption = None,
    csv: CsvOption = None,
) -> None:
    """Power loss at the test points of 40 CFR 1037.560."""
    check_outputs({"output": output})
    rough = roughness(roughness_each, roughness_pinion, roughness_gear)
    options = _options(temperature, oil, load_balance, xlsx) | rough | given({"torque_max": torque_max})
    axle = _axle(axle_losses, drag, load_share)
    with working("loss map"):
        found = efficiency.load(design).axle_test(
            cast("Any", application),
            friction,
            revolutions_per_mile=revolutions_per_mile,
            axle=axle,
            **options,
        )
    if output is not None and found.status == "converged":
        found.to_csv(output)
    present(found, json_output, xlsx=xlsx, csv=csv)


def _options(temperature: str | None, oil: str | None, load_balance: str | None, xlsx: Path | None) -> dict[str, Any]:
    check_files(report=None, xlsx=xlsx)
    return given({"temperature": temperature, "oil": oil, "load_balance": load_balance_of(load_balance)})


def _axle(table: Path | None, drag: str | None, load_share: str | None) -> Any:
    """Losses beside the mesh; None where nothing is said of them."""
    simple = given({"drag": drag, "load_share": load_share})
    if table is None:
        return simple or None
    if simple:
        raise InputError("axle-losses", str(table), "either a table, or --drag and --load-share")
    return table


def register(app: App) -> None:
    """Add the commands of this package to the application."""
    app.command("loss-map", rich_help_panel=GEAR)(loss_map)
    app.command("axle-test", rich_help_panel=GEAR)(axle_test)
