"""Options of several gear commands, and groups of options that are passed on as one dictionary."""

import functools
import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer

from ehl import InputError
from ehl.common import console

operation: Any = functools.partial(typer.Option, rich_help_panel=console.OPERATION)
output_option: Any = functools.partial(typer.Option, rich_help_panel=console.OUTPUT)


@dataclass(frozen=True)
class OptionGroup:
    """Options passed to a command as one dictionary: keyword and annotation of each, and their check."""

    options: dict[str, Any]
    check: Callable[[dict[str, Any]], None] | None = None


def with_groups(command: Callable[..., None]) -> Callable[..., None]:
    """The command with the options of a group instead of each parameter that is annotated with one.

    The parameter receives the options that were given, by keyword.
    """
    hints = get_type_hints(command, include_extras=True)
    parameters, groups = [], {}
    for parameter in inspect.signature(command).parameters.values():
        hint = hints[parameter.name]
        group = next((part for part in getattr(hint, "__metadata__", ()) if isinstance(part, OptionGroup)), None)
        if group is None:
            parameters.append(parameter.replace(annotation=hint, kind=inspect.Parameter.KEYWORD_ONLY))
            continue
        groups[parameter.name] = group
        parameters += [
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=annotation)
            for name, annotation in group.options.items()
        ]

    @functools.wraps(command)
    def grouped(**values: Any) -> None:
        for name, group in groups.items():
            values[name] = console.given({option: values.pop(option) for option in group.options})
            if group.check is not None:
                group.check(values[name])
        command(**values)

    grouped.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    grouped.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return grouped


def group(check: Callable[[dict[str, Any]], None] | None = None, /, **options: Any) -> Any:
    """Annotation of a parameter that receives those of the options that are given, as a dictionary."""
    return Annotated[dict[str, Any], OptionGroup(options, check)]


def text_option(text: str, panel: str | None = console.ADVANCED, name: str = "") -> Any:
    """Annotation of a text option; None if it is not given."""
    return Annotated[str | None, typer.Option(*filter(None, [name]), help=text, rich_help_panel=panel)]


def switch(names: str, text: str) -> Any:
    """Annotation of a switch in the advanced panel; None if it is not given."""
    return Annotated[bool | None, console.advanced(names, help=text)]


def misalignment_group(e: str, p: str, g: str, angle: str, panel: str | None = console.ADVANCED) -> Any:
    """Options of the misalignments with their help texts."""
    shifts = {name: text_option(text, panel, f"--{name}") for name, text in (("E", e), ("P", p), ("G", g))}
    return group(**shifts, shaft_angle_error=text_option(angle, panel))


def check_files(files: Mapping[str, Any]) -> None:
    """Raise an `InputError` for files and folders that cannot be written, or unknown units."""
    console.check_outputs({n: path for n, path in files.items() if isinstance(path, Path)}, ("csv", "plot"))
    unit_system(files.get("units"))


def one_of(field: str, text: str | None, *allowed: str) -> Any:
    """Check an option that accepts only the given words; None if it is not given."""
    text = next((word for word in allowed if text is not None and word.casefold() == text.casefold()), text)
    if text is not None and text not in allowed:
        raise InputError(field, text, " or ".join(allowed))
    return text


def unit_system(units: str | None) -> Any:
    """Metric or inch."""
    return one_of("units", units, "metric", "inch") or "metric"


AxleArgument = console.shipped_argument("AXLE", "axles", "An axle file")
BlankArgument = console.shipped_argument("FILE", "blanks", "A blank file")
TargetsArgument = console.shipped_argument("TARGETS", "targets", "A targets file")
DesignArgument = console.shipped_argument("DESIGN", "designs", "A design file")
SideOption = text_option("Flanks that carry the load: drive (default) or coast.", console.OPERATION)
TemperatureOption = text_option("Oil temperature with its unit: '80 degC'.", console.OPERATION)
OilOption = Annotated[
    str | None, operation(help="Oil card; default: that of the design.", autocompletion=console.names_of("oils"))
]
_POINT = {
    "torque": text_option("Pinion torque with its unit: '250 N m'.", console.OPERATION),
    "speed": text_option("Pinion speed with its unit: '1500 rpm'.", console.OPERATION),
    "temperature": TemperatureOption,
}
PointOptions = group(**_POINT)
ROUGHNESS = {
    "roughness_rms_each": text_option("Rq of the flanks of both members: '0.4 um'.", name="--roughness-each"),
    "roughness_rms_pinion": text_option("Rq of the pinion flanks.", name="--roughness-pinion"),
    "roughness_rms_gear": text_option("Rq of the gear flanks.", name="--roughness-gear"),
}
BulkOption = text_option(
    "Bulk temperature of the teeth: estimate (default, from the loss after ISO/TR 15144-1), or oil.",
    name="--bulk-temperature",
)
LoadBalanceOption = text_option("Torque balance: frictional (default, with friction forces) or frictionless.")
HELD = {"oil": OilOption, **ROUGHNESS, "load_balance": LoadBalanceOption}
HeldOptions = group(**HELD)
CONDITIONS = {**_POINT, "side": SideOption, **HELD, "driver": text_option("Driving member: pinion or gear.")}
ConditionOptions = group(**CONDITIONS)
MisalignmentOptions = misalignment_group(
    "Shift E along the offset: '0.1 mm'.",
    "Shift P along the pinion axis, from apex to heel.",
    "Shift G along the gear axis, from apex to heel.",
    "Change of the shaft angle: '2 arcmin'.",
)
FrictionOption = Annotated[
    str | None,
    typer.Option(
        help="Formula file or name, constant:0.05, a published formula, ehl, ehl:smooth; default: that of the oil."
    ),
]
StrengthOption = switch(
    "--strength", "Add columns of worst grade, safety factors, integral temperature, specific film (0.1 s per point)."
)
MarkingOption = Annotated[str | None, console.advanced(help="Thickness of the marking compound, default '6.35 um'.")]
JsonOption = Annotated[bool, output_option("--json", help="Print one JSON object in SI units.")]
ReportOption = Annotated[Path | None, output_option(help="Write one HTML page, also for printing.")]
UnitsOption = Annotated[str | None, console.advanced(help="Units of design tables: metric (default) or inch.")]
_PAGE = {
    "plot": Annotated[Path | None, output_option(help="Folder for figures (PNG).")],
    "report": ReportOption,
    "units": UnitsOption,
}
_TABLES = {
    "cite": switch("--cite", "References of the laws, formulas and standards used; BibTeX with --json."),
    "xlsx": Annotated[Path | None, output_option(help="Write all tables into one workbook.")],
    "csv": Annotated[Path | None, console.advanced(help="Folder for all tables as CSV.")],
}
FigureOption = Annotated[Path | None, output_option(help="Write the figure (PNG, SVG, PDF).")]
# for `present`
TableOptions = group(check_files, json_output=JsonOption, **_TABLES)
PageOptions = group(check_files, json_output=JsonOption, **_PAGE)
FileOptions = group(check_files, json_output=JsonOption, **_PAGE, **_TABLES)
FolderOptions = group(check_files, json_output=JsonOption, plot=_PAGE["plot"], report=ReportOption, **_TABLES)
ReportOptions = group(check_files, json_output=JsonOption, report=ReportOption, **_TABLES)
FigureOptions = group(check_files, json_output=JsonOption, plot=FigureOption, report=ReportOption, **_TABLES)
FreshOption = Annotated[
    bool, console.advanced("--fresh", help="Delete the results of an earlier run in the folder and start again.")
]


def started_store(folder: Path, fresh: bool) -> Path:
    """File of finished points in an output folder; it is deleted if the run starts again."""
    store = folder / "points.jsonl"
    if fresh:
        try:
            store.unlink(missing_ok=True)
        except OSError as error:
            raise InputError("--fresh", str(store), "a file that can be deleted", f"{error}.") from None
    return store


def kept(what: str, store: Path, fresh: bool) -> str:
    """What remains of a stopped run, and how to resume it."""
    return f"finished {what} are kept in {store}; the same command{' without --fresh' if fresh else ''} resumes"


def present_folder(result: Any, json_output: bool, folder: Path, failed: str = "not converged") -> None:
    """Print a result and write it into a folder; exit code 1 if it `failed`."""
    written = result.write(folder=folder)
    console.print_result(result, json_output)
    for path in () if json_output else written:
        print(path)
    console.fail_unless_converged(result.status, result.reason, failed)


TYRE = "Tyre radius for a vehicle speed in km/h, e.g. '0.32 m'."
TyreOption = text_option(TYRE)
MAP_FILES = (".vtlm", ".fmu", ".mo", ".m")
MapFileOption = Annotated[
    list[Path] | None,
    typer.Option("--model", help="Write the map for VECTO (.vtlm), FMI (.fmu), Modelica (.mo) or Simscape (.m)."),
]


def check_map_files(files: Sequence[Path] | None) -> None:
    """Raise an `InputError` for map files that cannot be written."""
    for path in files or ():
        if path.suffix.lower() not in MAP_FILES:
            raise InputError("model", str(path), f"a file name ending in {', '.join(MAP_FILES)}")
        console.check_outputs({"model": path})


def write_map(found: Any, files: Sequence[Path] | None) -> None:
    """Write a loss map without failed points for other programs."""
    for path in files or ():
        if found.status == "converged":
            found.write_model(path)


def present(
    result: Any, *, json_output: bool = False, more: Mapping[str, Any] | None = None, cite: bool = False, **files: Any
) -> None:
    """Print and write a result, with more content of the JSON; exit code 1 if it failed."""
    options = {"units": unit_system(files.pop("units"))} if "units" in files else {}
    try:  # files first, as standard output may be closed; the result is shown even if a file cannot be written
        result.write(**files, **options)
    finally:
        console.print_result(result, json_output, more, cite=cite, **options)
    console.fail_unless_converged(result.status, result.reason)


def refuse(what: str, options: Mapping[str, object]) -> None:
    """Raise an `InputError` for options that have no effect together with another choice."""
    for name, value in console.given(options).items():
        raise InputError(name, str(value), f"not together with {what}")
