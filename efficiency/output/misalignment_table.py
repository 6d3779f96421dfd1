"""A misalignment study as a table and as CSV."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ehl.io.errors import InputError

if TYPE_CHECKING:
    from efficiency.misalignment import MisalignmentStudy

AXES = ("E", "P", "G", "alpha")
ARCSEC = math.degrees(1.0) * 3600.0
SHOWN_UNITS = {"E": ("mm", 1e3), "P": ("mm", 1e3), "G": ("mm", 1e3), "alpha": ("arcmin", math.degrees(1.0) * 60.0)}
_ROWS = 60
_HEADER = (
    "TE p-p\n[arcsec]",
    "contact\n[mm]",
    "pattern\nat [mm]",
    "length\n[%]",
    "area\n[%]",
    "edge in contact,\nor why it failed",
)


def varied(study: MisalignmentStudy) -> list[str]:
    """Names of the misalignments with more than one value."""
    return [name for name in AXES if len(getattr(study, name)) > 1]


def study_rows(study: MisalignmentStudy) -> list[tuple[str, ...]]:
    """One row per state: misalignments that vary, transmission error, places along the gear face, pattern, edges."""
    names = varied(study)
    return [
        (
            *(f"{getattr(point, name) * SHOWN_UNITS[name][1]:+.4g}" for name in names),
            _number(point.peak_to_peak * ARCSEC, ".3f"),
            _number(1e3 * point.error_maximum_u, "+.3f"),
            _number(1e3 * point.pattern_u, "+.3f"),
            _number(100.0 * point.pattern_length, ".1f"),
            _number(100.0 * point.pattern_area, ".1f"),
            point.reason or point.edges,
        )
        for point in study.points
    ]


def _number(value: float, form: str) -> str:
    return format(value, form) if math.isfinite(value) else "–"


def print_study(study: MisalignmentStudy) -> None:
    """Print the table, its extremes where it is long, and what failed."""
    from rich import box
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    rows = study_rows(study)
    table = Table(
        title=f"{study.design}, {study.side}: unloaded contact, marking {1e6 * study.marking:.4g} µm",
        box=box.SIMPLE,
        padding=(0, 1, 0, 0),
        title_justify="left",
    )
    for name in varied(study):
        table.add_column(escape(f"{name}\n[{SHOWN_UNITS[name][0]}]"), justify="right")
    for name in _HEADER:
        table.add_column(escape(name), justify="left" if name == _HEADER[-1] else "right")
    for row in rows[:_ROWS]:
        table.add_row(*row)
    console = Console()
    console.print(table)
    if len(rows) > _ROWS:
        console.print(f"{len(rows) - _ROWS} of {len(rows)} states are not shown: --csv writes all of them")
    failed = sum(point.status == "failed" for point in study.points)
    edges = sum(point.status == "edge contact" for point in study.points)
    console.print(
        f"{study.status}: {len(rows)} states, {edges} with edge contact, {failed} failed, {study.seconds:.2f} s",
        highlight=False,
    )


def write_study(path: Path, studies: Sequence[MisalignmentStudy]) -> None:
    """Write all states as CSV in SI units: a line that starts with #, the column names, one line per state.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    import pandas as pd

    table = pd.concat([study.table().assign(side=study.side) for study in studies])
    first = studies[0]
    head = f"# mixed-ehl misalignment study v1; design={first.design}; marking={first.marking:g} m; units=m, rad\n"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(head + table.to_csv(index=False), encoding="utf-8")
    except OSError as error:
        raise InputError("--csv", str(path), "a writable file", f"{error}.") from None
