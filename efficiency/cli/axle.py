"""Commands of an axle: `axle`, and its loss maps `loss-map` and `axle-test`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, cast

import typer

import efficiency
from efficiency.cli import options as shared
from ehl import InputError
from ehl.common.console import advanced, check_outputs, is_list, working

_Conditions: Any = shared.group(temperature=shared.TemperatureOption, **shared.HELD)
_AxleOptions: Any = shared.group(
    axle_losses=Annotated[
        Path | None, advanced(help="Bearing and drag losses, CSV or XLSX: torque, speed of the pinion, torque_loss.")
    ],
    drag=shared.text_option("Constant drag torque at the pinion: '2 N m' (our model)."),
    load_share=shared.text_option("Bearings: share of the pinion torque lost, '0.5 %' (our model)."),
)


def loss_map(
    *,
    design: shared.DesignArgument,
    torque: Annotated[str, typer.Option(help="Pinion torques, negative in coast: '-300:300:7 N m', or a list.")],
    speed: Annotated[str, typer.Option(help="Pinion speeds: '50:2000:5 rpm', or a list.")],
    friction: shared.FrictionOption = None,
    conditions: _Conditions,
    axle: _AxleOptions,
    model: shared.MapFileOption = None,
    files: shared.TableOptions,
) -> None:
    """Torque loss over pinion torque and speed, drive and coast, for vehicle simulation."""
    shared.check_map_files(model)
    losses = _axle(axle)
    with working("loss map"):
        pair = efficiency.load(design)
        found = pair.loss_map(
            torque, speed, friction, axle=losses, interval=bool(model), models=model or (), **conditions
        )
    shared.write_map(found, model)
    shared.present(found, **files)


_TestOptions: Any = shared.group(
    application=shared.text_option("single (default; output torque to 4000 N m) or tandem (2000 N m).", panel=None),
    torque_max=shared.text_option("Rated output torque of the axle, e.g. '2500 N m'.", panel=None),
    revolutions_per_mile=Annotated[
        float | None, advanced(help="Tyre revolutions per mile, of the smallest tyre; default 650.")
    ],
)


def axle_test(
    *,
    design: shared.DesignArgument,
    test: _TestOptions,
    friction: shared.FrictionOption = None,
    conditions: _Conditions,
    axle: _AxleOptions,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write the test points as CSV in the format of GEM.")
    ] = None,
    files: shared.TableOptions,
) -> None:
    """Power loss at the test points of 40 CFR 1037.560."""
    check_outputs({"output": output})
    losses = _axle(axle)
    with working("loss map"):
        found = efficiency.load(design).axle_test(friction=friction, axle=losses, **test, **conditions)
    if output is not None and found.status == "converged":
        found.to_csv(output)
    shared.present(found, **files)


def _axle(options: dict[str, Any]) -> Any:
    """Axle losses from a table or constants; None if not given."""
    table = options.pop("axle_losses", None)
    if table is None:
        return options or None
    shared.refuse("--axle-losses", options)
    return table


_MethodOptions: Any = shared.group(
    bearings=shared.text_option("Method: skf or iso_14179_2."),
    seals=shared.text_option("Method: linke or iso_14179_2."),
    churning=shared.text_option("Method: changenet_velex or iso_14179_2."),
)


def axle(
    *,
    axle: shared.AxleArgument,
    point: shared.PointOptions,
    friction: shared.FrictionOption = None,
    duty: Annotated[Path | None, typer.Option(help="Duty cycle, CSV or XLSX, instead of torque and speed.")] = None,
    tyre_radius: shared.TyreOption = None,
    model: shared.MapFileOption = None,
    test: Annotated[str | None, typer.Option(help="Test points of 40 CFR 1037.560: single or tandem.")] = None,
    methods: _MethodOptions,
    files: shared.ReportOptions,
) -> None:
    """Losses of an axle (mesh, bearings, seals, churning) at a point, over a map, a duty cycle or the test points.

    With --temperature balance, the oil temperature follows from the heat balance of loss, housing and cooler.
    """
    application = shared.one_of("test", test, "single", "tandem")
    if duty is None and tyre_radius is not None:
        raise InputError("tyre_radius", tyre_radius, "only together with --duty")
    if duty is not None:
        shared.refuse("--duty", {"test": test})
        point["tyre_radius"] = tyre_radius
    of_map = any(is_list(point.get(name, "")) for name in ("torque", "speed", "temperature"))
    if model:
        if not (of_map and point.get("torque") and point.get("speed")):
            raise InputError("model", str(model[0]), "only together with lists of --torque and --speed")
        shared.check_map_files(model)
        point["models"] = model
        if is_list(kelvin := point.get("temperature", "")):
            raise InputError("temperature", kelvin, "one value", "A map for another program has one oil temperature.")
    with working("axle losses"):
        found = _solve(efficiency.Axle(axle, methods=methods), point, of_map, friction, duty, application)
    if model:
        shared.write_map(found.loss_map(), model)
    shared.present(found, **files)


def _solve(axle: efficiency.Axle, point: Any, of_map: bool, friction: Any, duty: Path | None, application: Any) -> Any:
    if duty is not None or application is not None:
        shared.refuse("--duty or --test", {name: point.get(name) for name in ("torque", "speed")})
        if duty is not None:
            return axle.duty(duty, friction, **point)
        return axle.axle_test(cast("Any", application), friction, **point)
    if of_map:
        for name in ("torque", "speed"):
            if name not in point:
                raise InputError(name, None, "required if another one is a list")
        return axle.map(point.pop("torque"), point.pop("speed"), friction=friction, **point)
    return axle.at(friction=friction, **point)
