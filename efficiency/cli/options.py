"""Options that several gear commands share, and how their text is read."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from efficiency.contact.gear_flanks import Side
    from efficiency.design.design import Design
    from efficiency.output.gear_files import OutputFiles
    from efficiency.run import Conditions
    from ehl.io.units import ValueRange

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

MAX_VALUES = 10_000
Lists = tuple[list[float], list[float], list[float]]
Report = Callable[[int, int], None]


def chosen_side(side: str) -> Side:
    """Drive or coast.

    Raises
    ------
    InputError
        Any other word.
    """
    from ehl.io.errors import InputError

    if side == "drive":
        return "drive"
    if side == "coast":
        return "coast"
    raise InputError("--side", side, "drive or coast")


def operating_lists(torque: str | None, speed: str | None, temperature: str | None) -> Lists:
    """Values of torque, speed and temperature, each with its unit; empty where nothing is given."""
    from efficiency.design.design import OPERATION_LIMITS

    def check(text: str | None, name: str, option: str) -> list[float]:
        return [] if text is None else OPERATION_LIMITS[name].check_list(text, option)

    return (
        check(torque, "torque", "--torque"),
        check(speed, "speed", "--speed"),
        check(temperature, "temperature_oil", "--temperature"),
    )


def value_list(option: str, text: str, quantity: ValueRange) -> tuple[float, ...]:
    """Values in SI units: a list ``a, b, c unit``, or ``from:to:number unit``.

    Raises
    ------
    InputError
        Neither of both, or a value out of its range.
    """
    from ehl.io.errors import InputError

    if ":" not in text:
        return tuple(quantity.check_list(text, option))
    match = re.fullmatch(r"\s*([^:]+):([^:]+):\s*(\d+)\s*([^\d:][^:]*)", text)
    count = int(match[3]) if match else 0
    if match is None or not 2 <= count <= MAX_VALUES:
        raise InputError(option, text, "'from:to:number unit' such as '-0.2:0.2:9 mm', with a number of at least 2")
    first, last = (quantity.check(f"{match[k].strip()} {match[4]}", option, bare=False) for k in (1, 2))
    # values that are zero but for the last binary digit are zero
    steps = (first + (last - first) * k / (count - 1) for k in range(count))
    return tuple(0.0 if abs(step) < 1e-12 * abs(last - first) else step for step in steps)


def first_conditions(lists: Lists, oil: str | None) -> Conditions:
    """Operating point of the first value of each list."""
    from efficiency.run import Conditions

    torque, speed, temperature = (values[0] if values else None for values in lists)
    return Conditions(torque, speed, temperature, oil)


def aligned_design(design: str, misalignment: dict[str, str | None]) -> Design:
    """A design with what the command line says of its misalignment."""
    from threadpoolctl import threadpool_limits

    from efficiency.design.design import Misalignment, load_design
    from ehl.io.validation import value_range_of

    with threadpool_limits(1):
        loaded = load_design(design)
    given = {
        name: value_range_of(Misalignment, name).check(text, f"--{name}", bare=False)
        for name, text in misalignment.items()
        if text is not None
    }
    return loaded.with_misalignment(**loaded.assembly.misalignment.model_dump() | given) if given else loaded


def output_files(plot: Path | None, report: Path | None, xlsx: Path | None, csv: Path | None) -> OutputFiles:
    """Where results go besides the terminal; names that cannot be meant are refused before anything is computed."""
    from efficiency.output.gear_files import OutputFiles

    return OutputFiles(plot, report, xlsx, csv)


@contextmanager
def progress(what: str) -> Iterator[Report]:
    """A bar on the terminal for what takes long; gives the function that moves it: (done, total)."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        task = bars.add_task(what, total=None)

        def move(done: int, total: int) -> None:
            bars.update(task, completed=done, total=total)

        yield move
