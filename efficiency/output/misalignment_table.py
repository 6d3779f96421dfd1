"""A misalignment study as a table and as CSV."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ehl.io.files import write_file
from ehl.quantities import Quantity, quantity
from ehl.view.table import Column, Table

if TYPE_CHECKING:
    from efficiency.geometry.misalignment import MisalignmentGrid, MisalignmentStudy

_ROWS = 60


def misalignment_quantity(name: str) -> Quantity:
    """What one of `AXES` is."""
    return quantity(f"misalignment.{name}")


def misalignment_table(study: MisalignmentStudy) -> Table:
    """One row per state: misalignments that vary, transmission error, places along the gear face, pattern, edges."""
    names = study.varied
    fields = ("peak_to_peak", "error_maximum_u", "pattern_u", "pattern_length", "pattern_area")
    shares = [Column(name, of="share", label=name.replace("_", " ")) for name in fields[3:]]
    count = len(study.points)
    failed = sum(point.status == "failed" for point in study.points)
    edges = sum(point.status == "edge contact" for point in study.points)
    notes = [f"{study.status}: {count} states, {edges} with edge contact, {failed} failed, {study.seconds:.2f} s"]
    if count > _ROWS:
        notes.insert(0, f"{count - _ROWS} of {count} states are not shown: --csv writes all of them")
    return Table(
        [
            *(Column(name, of=misalignment_quantity(name).name, label=name) for name in names),
            *fields[:3],
            *shares,
            Column("edges", label="edge in contact, or why it failed"),
        ],
        [
            [*(getattr(point, name) for name in (*names, *fields)), point.reason or point.edges]
            for point in study.points[:_ROWS]
        ],
        title=f"{study.design}, {study.side}: unloaded contact, marking {1e6 * study.marking:.4g} µm",
        notes=notes,
    )


def write_misalignment(path: Path, grid: MisalignmentGrid) -> None:
    """Write all states as CSV in SI units: a line that starts with #, the column names, one line per state.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    first = grid.studies[0]
    head = f"# mixed-ehl misalignment study v1; design={first.design}; marking={first.marking:g} m; units=m, rad\n"
    write_file(path, head + grid.to_frame().to_csv(index=False), "csv", folder=True)
