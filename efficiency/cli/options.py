"""Options that several gear commands share, and how their text is read."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, cast

import typer

from ehl import InputError
from ehl.common.console import ADVANCED, check_suffix, fail_unless_converged, given, names_of, print_json

OPERATION, OUTPUT = "Operating point", "Output"

DesignArgument = Annotated[
    str,
    typer.Argument(
        metavar="DESIGN", help="A design file, or the name of a shipped one.", autocompletion=names_of("designs")
    ),
]
SideOption = Annotated[str, typer.Option(help="Flanks that carry the load: drive or coast.", rich_help_panel=OPERATION)]
TorqueOption = Annotated[
    str | None, typer.Option(help="Pinion torque with its unit: '250 N m'.", rich_help_panel=OPERATION)
]
SpeedOption = Annotated[
    str | None, typer.Option(help="Pinion speed with its unit: '1500 rpm'.", rich_help_panel=OPERATION)
]
TemperatureOption = Annotated[
    str | None, typer.Option(help="Oil temperature with its unit: '80 degC'.", rich_help_panel=OPERATION)
]
OilOption = Annotated[
    str | None,
    typer.Option(help="Oil card in place of the design's.", rich_help_panel=OPERATION, autocompletion=names_of("oils")),
]
RoughnessEachOption = Annotated[
    str | None, typer.Option(help="Rq of the flanks of both members: '0.4 um'.", rich_help_panel=ADVANCED)
]
RoughnessPinionOption = Annotated[str | None, typer.Option(help="Rq of the pinion flanks.", rich_help_panel=ADVANCED)]
RoughnessGearOption = Annotated[str | None, typer.Option(help="Rq of the gear flanks.", rich_help_panel=ADVANCED)]
EOption = Annotated[
    str | None, typer.Option("--E", help="Shift E along the offset: '0.1 mm'.", rich_help_panel=ADVANCED)
]
POption = Annotated[
    str | None,
    typer.Option("--P", help="Shift P along the pinion axis, from apex to heel.", rich_help_panel=ADVANCED),
]
GOption = Annotated[
    str | None,
    typer.Option("--G", help="Shift G along the gear axis, from apex to heel.", rich_help_panel=ADVANCED),
]
ShaftAngleOption = Annotated[
    str | None,
    typer.Option("--shaft-angle-error", help="Change of the shaft angle: '2 arcmin'.", rich_help_panel=ADVANCED),
]
LoadBalanceOption = Annotated[
    str | None,
    typer.Option(
        help="What carries the torque: frictional (default, normal and friction forces), or frictionless.",
        rich_help_panel=ADVANCED,
    ),
]
FrictionOption = Annotated[
    str, typer.Option(help="Formula file or name, constant:0.05, a published formula, ehl or ehl:smooth.")
]
DriverOption = Annotated[
    str | None, typer.Option(help="Member the power comes from: pinion or gear.", rich_help_panel=ADVANCED)
]
StrengthOption = Annotated[
    bool,
    typer.Option(
        "--strength",
        help="Columns of worst grade, safety factors, integral temperature and specific film (0.1 s a point).",
        rich_help_panel=ADVANCED,
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.", rich_help_panel=OUTPUT)]
ReportOption = Annotated[Path | None, typer.Option(help="Write one HTML page, for print too.", rich_help_panel=OUTPUT)]
XlsxOption = Annotated[
    Path | None, typer.Option("--xlsx", help="Write every table into one workbook.", rich_help_panel=OUTPUT)
]
CsvOption = Annotated[
    Path | None, typer.Option("--csv", help="Folder for every table as CSV.", rich_help_panel=ADVANCED)
]
FiguresOption = Annotated[Path | None, typer.Option(help="Folder for figures (PNG).", rich_help_panel=OUTPUT)]
UnitsOption = Annotated[str, typer.Option(help="Units of design tables: metric or inch.", rich_help_panel=ADVANCED)]
DaskOption = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="A dask scheduler (tcp://..., file.json), or local:N.")
]
JobsOption = Annotated[int | None, typer.Option(min=1, help="Worker processes; default: the cores there are.")]


def check_files(report: Path | None, xlsx: Path | None) -> None:
    """Names of files that cannot be meant are refused before anything is computed."""
    check_suffix(report, "report")
    check_suffix(xlsx, "xlsx")


def unit_system(units: str) -> Literal["metric", "inch"]:
    """Metric or inch."""
    if units not in ("metric", "inch"):
        raise InputError("units", units, "metric or inch")
    return cast('Literal["metric", "inch"]', units)


def one_side(side: str) -> Literal["drive", "coast"]:
    """Drive or coast."""
    if side not in ("drive", "coast"):
        raise InputError("side", side, "drive or coast")
    return cast('Literal["drive", "coast"]', side)


def roughness(each: str | None, pinion: str | None, gear: str | None) -> dict[str, Any]:
    """Rq of the flanks, by the names of the conditions; what is not given is left out."""
    return given({"roughness_rms_each": each, "roughness_rms_pinion": pinion, "roughness_rms_gear": gear})


def load_balance_of(text: str | None) -> Literal["frictional", "frictionless"] | None:
    """What carries the torque; None leaves it to the default."""
    if text not in (None, "frictional", "frictionless"):
        raise InputError("load-balance", text, "frictional or frictionless")
    return cast('Literal["frictional", "frictionless"] | None', text)


def present(result: Any, json_output: bool, **files: Any) -> None:
    """Print and write a result; exit code 1 where it failed."""
    balance, units = files.pop("balance", None), files.pop("units", None)
    options = given({"balance": balance, "units": units})
    if json_output:
        more = {} if balance is None else {"heat_balance": balance.to_dict()}
        print_json(result.to_dict() | more)
    else:
        result.show(**options)
    result.write(**files, **options)
    fail_unless_converged(result.status, result.reason)


def refuse(what: str, options: Mapping[str, object]) -> None:
    """`InputError` for options that mean nothing beside something else."""
    for name, value in options.items():
        if value is not None and value is not False:
            raise InputError(name, str(value), f"nothing beside {what}")
