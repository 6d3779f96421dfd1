"""The command `axle`: losses of a whole axle."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, cast

import typer

import efficiency
from efficiency.cli import options as shared
from ehl import InputError
from ehl.common.console import AXLE, App, given, is_list, names_of, working

_AxleArgument = Annotated[
    str,
    typer.Argument(
        metavar="AXLE", help="An axle file, or the name of a shipped one.", autocompletion=names_of("axles")
    ),
]
_MethodOptions = Annotated[
    dict[str, Any],
    shared.OptionGroup(
        {
            "bearings": shared.text_option("Method: skf or iso_14179_2."),
            "seals": shared.text_option("Method: linke or iso_14179_2."),
            "churning": shared.text_option("Method: changenet_velex or iso_14179_2."),
        }
    ),
]


@shared.with_groups
def axle(
    *,
    axle: _AxleArgument,
    point: shared.PointOptions,
    friction: shared.FrictionOption = None,
    duty: Annotated[Path | None, typer.Option(help="Duty cycle, CSV or XLSX, instead of torque and speed.")] = None,
    model: shared.MapFileOption = None,
    test: Annotated[str | None, typer.Option(help="Test points of 40 CFR 1037.560: single or tandem.")] = None,
    methods: _MethodOptions,
    report: shared.ReportOption = None,
    json_output: shared.JsonOption = False,
    files: shared.TableOptions,
) -> None:
    """Losses of an axle (mesh, bearings, seals, churning) at a point, over a map, a duty cycle or the test points.

    With --temperature balance, the oil temperature follows from the heat balance of loss, housing and cooler.
    """
    shared.check_map_files(model)
    files = files | given({"report": report})
    shared.check_files(files)
    application = shared.one_of("test", test, "single", "tandem")
    of_map = any(is_list(point.get(name, "")) for name in ("torque", "speed", "temperature"))
    if model and not of_map:
        raise InputError("model", str(model[0]), "only together with lists of --torque and --speed")
    with working("axle losses"):
        found = _solve(efficiency.Axle(axle, methods=methods), point, of_map, friction, duty, application)
    if model:
        shared.write_map(found.loss_map(), model)
    shared.present(found, json_output, **files)


def _solve(axle: efficiency.Axle, point: Any, of_map: bool, friction: Any, duty: Path | None, application: Any) -> Any:
    if duty is not None or application is not None:
        for name in ("torque", "speed"):
            if name in point:
                raise InputError(name, point[name], "not together with --duty or --test")
        if duty is not None:
            return axle.duty(duty, friction, **point)
        return axle.axle_test(cast("Any", application), friction, **point)
    if of_map:
        for name in ("torque", "speed"):
            if name not in point:
                raise InputError(name, None, "required if another one is a list")
        return axle.map(point.pop("torque"), point.pop("speed"), friction=friction, **point)
    return axle.at(friction=friction, **point)


def register(app: App) -> None:
    """Add the command to the application."""
    app.command("axle", rich_help_panel=AXLE)(axle)
