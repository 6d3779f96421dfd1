"""Options that several gear commands share, and how their text is read."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Literal, cast

import typer

from ehl import InputError

OPERATION, MISALIGNMENT = "Operating point", "Misalignment"
OUTPUT, GEOMETRY = "Output", "Geometry only"

DesignArgument = Annotated[str, typer.Argument(metavar="DESIGN", help="A design file, or the name of a shipped one.")]
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
OilOption = Annotated[str | None, typer.Option(help="Oil card in place of the design's.", rich_help_panel=OPERATION)]
EOption = Annotated[str | None, typer.Option("--E", help="Along the offset: '0.1 mm'.", rich_help_panel=MISALIGNMENT)]
POption = Annotated[
    str | None, typer.Option("--P", help="Along the pinion axis, from apex to heel.", rich_help_panel=MISALIGNMENT)
]
GOption = Annotated[
    str | None, typer.Option("--G", help="Along the gear axis, from apex to heel.", rich_help_panel=MISALIGNMENT)
]
AlphaOption = Annotated[
    str | None, typer.Option("--alpha", help="Of the shaft angle: '2 arcmin'.", rich_help_panel=MISALIGNMENT)
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.", rich_help_panel=OUTPUT)]
ReportOption = Annotated[Path | None, typer.Option(help="Write one HTML page, for print too.", rich_help_panel=OUTPUT)]
XlsxOption = Annotated[
    Path | None, typer.Option("--xlsx", help="Write every table into one workbook.", rich_help_panel=OUTPUT)
]
CsvOption = Annotated[Path | None, typer.Option("--csv", help="Folder for every table as CSV.", rich_help_panel=OUTPUT)]
FiguresOption = Annotated[Path | None, typer.Option(help="Folder for figures (PNG).", rich_help_panel=OUTPUT)]
UnitsOption = Annotated[str, typer.Option(help="Units of design tables: metric or inch.", rich_help_panel=OUTPUT)]
JobsOption = Annotated[int | None, typer.Option(min=1, help="Worker processes; default: the cores there are.")]


def given(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options that have a value; a number with a unit has to say it."""
    return {name: value for name, value in options.items() if value is not None}


def is_list(text: str) -> bool:
    """Whether a text is a list ``a, b, c unit`` or a range ``from:to:number unit``."""
    return "," in text or ":" in text


def check_files(**files: Path | None) -> None:
    """Names of files that cannot be meant are refused before anything is computed."""
    suffixes = {"report": (".html", ".htm"), "xlsx": (".xlsx",)}
    for name, path in files.items():
        if path is not None and path.suffix.lower() not in suffixes[name]:
            raise InputError(f"--{name}", str(path), f"a file name ending in {suffixes[name][0]}")


def check_units(units: str) -> None:
    """Metric or inch."""
    if units not in ("metric", "inch"):
        raise InputError("--units", units, "metric or inch")


@contextmanager
def progress(*steps: str) -> Iterator[Callable[..., None]]:
    """Bars on the terminal for what takes long; gives the function that moves them: ([step], done, total)."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=len(steps) == 1) as bars:
        tasks = {step: bars.add_task(step, total=None) for step in steps}

        def move(*state: Any) -> None:
            step, done, total = state if len(state) == 3 else (steps[0], *state)
            bars.update(tasks[step], completed=done, total=total)

        yield move


def print_json(content: dict[str, Any]) -> None:
    """One JSON object on standard output, strict (no NaN)."""
    print(json.dumps(content, allow_nan=False))


def fail_unless_converged(status: str, reason: str) -> None:
    """Exit code 1 with the reason on standard error."""
    if status != "converged":
        if reason:
            typer.echo(f"not converged: {reason}", err=True)
        raise typer.Exit(1)


def one_side(side: str) -> Literal["drive", "coast"]:
    """Drive or coast."""
    if side not in ("drive", "coast"):
        raise InputError("--side", side, "drive or coast")
    return cast('Literal["drive", "coast"]', side)


def present(result: Any, json_output: bool, **files: Any) -> None:
    """Print and write a result; exit code 1 where it failed."""
    parts = {name: files[name] for name in ("balance", "uncertainty") if name in files}
    if json_output:
        more = {"heat_balance": parts["balance"].to_dict()} if "balance" in parts else {}
        more |= {"uncertainty": parts["uncertainty"].to_dict()} if "uncertainty" in parts else {}
        print_json(result.to_dict() | more)
    else:
        result.show(**parts)
    result.write(**files)
    fail_unless_converged(result.status, result.reason)
