"""Commands that write loss maps of an axle: `loss-map`, `axle-test`."""

from pathlib import Path
from typing import Annotated, Any, cast

import typer

import efficiency
from efficiency.cli import options as shared
from ehl import InputError
from ehl.common.console import AXLE, App, advanced, check_outputs, given, working

_AxleOptions = Annotated[
    dict[str, Any],
    shared.OptionGroup(
        {
            "axle_losses": Annotated[
                Path | None,
                advanced(help="Bearing and drag losses, CSV or XLSX: torque, speed of the pinion, torque_loss."),
            ],
            "drag": shared.text_option("Constant drag torque at the pinion: '2 N m' (our model)."),
            "load_share": shared.text_option("Bearings: share of the pinion torque lost, '0.5 %' (our model)."),
        }
    ),
]


@shared.with_groups
def loss_map(
    *,
    design: shared.DesignArgument,
    torque: Annotated[str, typer.Option(help="Pinion torques, negative in coast: '-300:300:7 N m', or a list.")],
    speed: Annotated[str, typer.Option(help="Pinion speeds: '50:2000:5 rpm', or a list.")],
    friction: shared.FrictionOption = None,
    temperature: shared.TemperatureOption = None,
    conditions: shared.HeldOptions,
    axle: _AxleOptions,
    model: shared.MapFileOption = None,
    json_output: shared.JsonOption = False,
    files: shared.TableOptions,
) -> None:
    """Torque loss over pinion torque and speed, drive and coast, for vehicle simulation."""
    shared.check_map_files(model)
    shared.check_files(files)
    losses = _axle(axle)
    with working("loss map"):
        found = efficiency.load(design).loss_map(
            torque, speed, friction, axle=losses, interval=bool(model), temperature=temperature, **conditions
        )
    shared.write_map(found, model)
    shared.present(found, json_output, **files)


@shared.with_groups
def axle_test(
    *,
    design: shared.DesignArgument,
    application: Annotated[
        str, typer.Option(help="single (output torque to 4000 N m) or tandem (2000 N m).")
    ] = "single",
    torque_max: Annotated[str | None, typer.Option(help="Rated output torque of the axle, e.g. '2500 N m'.")] = None,
    revolutions_per_mile: Annotated[float, advanced(help="Tyre revolutions per mile, of the smallest tyre.")] = 650.0,
    friction: shared.FrictionOption = None,
    temperature: shared.TemperatureOption = None,
    conditions: shared.HeldOptions,
    axle: _AxleOptions,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write the test points as CSV in the format of GEM.")
    ] = None,
    json_output: shared.JsonOption = False,
    files: shared.TableOptions,
) -> None:
    """Power loss at the test points of 40 CFR 1037.560."""
    check_outputs({"output": output})
    shared.check_files(files)
    options = conditions | given({"torque_max": torque_max, "temperature": temperature})
    losses = _axle(axle)
    with working("loss map"):
        found = efficiency.load(design).axle_test(
            cast("Any", application), friction, revolutions_per_mile=revolutions_per_mile, axle=losses, **options
        )
    if output is not None and found.status == "converged":
        found.to_csv(output)
    shared.present(found, json_output, **files)


def _axle(options: dict[str, Any]) -> Any:
    """Axle losses from a table or constants; None if not given."""
    table = options.pop("axle_losses", None)
    if table is None:
        return options or None
    if options:
        raise InputError("axle-losses", str(table), "either a table, or --drag and --load-share")
    return table


def register(app: App) -> None:
    """Add the commands of this package to the application."""
    app.command("loss-map", rich_help_panel=AXLE)(loss_map)
    app.command("axle-test", rich_help_panel=AXLE)(axle_test)
