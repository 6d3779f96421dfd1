"""Machine summary of a pair (blanks, cutters, machine settings of all four flanks): output, and import into a design.

The summary is written as a table with a column for each flank, and as a setting sheet with one entry per line in the
format that `efficiency.cutting.summary` reads.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel

from efficiency.cutting.blank import blank_dimensions
from efficiency.cutting.cutter import FLANK_SIDES
from efficiency.cutting.summary import LABELS, Summary, read_summary
from efficiency.design.design import Design, load_design
from ehl.common.data import named_file
from ehl.common.errors import InputError
from ehl.common.files import write_file
from ehl.common.quantities import quantity
from ehl.common.table import Table
from ehl.common.units import ValueRange
from ehl.common.validation import locate_field, read_toml, validate

Units = Literal["metric", "inch"]
FLANKS = ("pinion concave", "pinion convex", "gear concave", "gear convex")
_INCH = 0.0254
KINDS = ("type", "process")
_LENGTH = {"metric": ("mm", 1e3), "inch": ("inch", 1.0 / _INCH)}
_WIDTH = 34

# shown unit, factor from SI, decimals
_SHOWN: dict[str, dict[str, tuple[str, float, int]]] = {
    "metric": {"m": ("mm", 1e3, 4), "1/m": ("1/mm", 1e-3, 7), "rad": ("deg", math.degrees(1.0), 4)},
    "inch": {"m": ("in", 1.0 / _INCH, 5), "1/m": ("1/in", _INCH, 6), "rad": ("deg", math.degrees(1.0), 4)},
}


@dataclass(frozen=True)
class SummaryRow:
    """One row of the summary."""

    section: str  # ``"blank"``, ``"cutter"``, ``"machine"`` and the like
    name: str  # name as in the design file
    unit: str  # unit of the values after conversion
    # numbers or words for pinion concave, pinion convex, gear concave and gear convex; None without a value
    values: tuple[float | str | None, ...]
    decimals: int  # displayed decimals

    @property
    def texts(self) -> tuple[str, ...]:
        """Displayed values; a dash for a missing value."""
        return tuple(
            "–" if x is None else f"{x:.{self.decimals}f}" if isinstance(x, float) else str(x) for x in self.values
        )


def summary_rows(design: Design, units: Units = "metric") -> list[SummaryRow]:
    """All data of a design file on blanks, cutters and machine, and the dimensions that follow from the blanks.

    units: lengths in mm or inch; angles in deg.
    """
    members = [design.pinion, design.pinion, design.gear, design.gear]
    blanks = [_columns(member.blank, "blank") for member in members]
    derived = [
        {("blank", name): (value, quantity(name).unit) for name, value in blank_dimensions(m.blank).items()}
        for m in members
    ]
    flanks = [_columns(getattr(member, side)) for member, side in zip(members, FLANK_SIDES * 2, strict=True)]
    columns = [blank | more | flank for blank, more, flank in zip(blanks, derived, flanks, strict=True)]
    keys = dict.fromkeys(key for column in columns for key in column)
    order = list(dict.fromkeys(section for section, _ in keys))
    rows = []
    for section, name in sorted(keys, key=lambda key: order.index(key[0])):
        given = [column.get((section, name)) for column in columns]
        unit_si = next(entry[1] for entry in given if entry is not None)
        unit, factor, decimals = _SHOWN[units].get(unit_si, (unit_si, 1.0, 6))
        values = tuple(_converted(entry, factor) for entry in given)
        rows.append(SummaryRow(section, name, unit, values, decimals))
    return rows


def settings_tables(design: Design, units: Units = "metric") -> list[Table]:
    """Cutters and machine settings of each flank; rows that are zero everywhere are omitted."""
    parts: dict[str, list[tuple[str, ...]]] = {}
    for row in summary_rows(design, units):
        part, _, inner = row.section.partition(".")
        if part != "blank" and any(value not in (None, 0, 0.0) for value in row.values):
            name = f"{inner}: {row.name}" if inner else row.name
            parts.setdefault(part, []).append((name.replace("_", " "), row.unit, *row.texts))
    omitted = "settings that are zero for all four flanks are omitted"
    heads = ("setting", "unit", *FLANKS)
    return [Table(heads, rows, f"{part.capitalize()} of each flank; {omitted}") for part, rows in parts.items()]


def write_summary(path: Path, design: Design, units: Units = "metric") -> None:
    """Write the summary as CSV: section, name, unit, then one column for each flank, numbers in full precision.

    Raises `InputError` if the file cannot be written.
    """
    heads = ["section", "name", "unit", *(flank.replace(" ", "_") for flank in FLANKS)]
    table = Table(heads, [(row.section, row.name, row.unit, *row.values) for row in summary_rows(design, units)])
    write_file(path, f"# mixed-ehl machine summary v1; design={design.name}; units={units}\n{table.csv()}")


def _entries(model: BaseModel, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any, str, bool]]:
    """(names, value, SI unit, whether it is the default) of a model and its inner models, without None values."""
    fields = type(model).model_fields
    # the type of a cutter or machine is listed before its numbers
    for name in sorted(fields, key=lambda name: name not in KINDS):
        value = getattr(model, name)
        if isinstance(value, BaseModel):
            yield from _entries(value, (*path, name))
        elif isinstance(value, (int, float, str)):
            metadata = locate_field(type(model), (name,)).metadata
            unit = next((item.unit for item in metadata if isinstance(item, ValueRange)), "")
            yield (*path, name), value, unit, value == fields[name].get_default()


def _columns(model: BaseModel, section: str = "") -> dict[tuple[str, str], tuple[Any, str]]:
    """(value, SI unit) by section and name."""
    head = (section,) if section else ()
    return {
        (".".join((*head, *path[:-1])) or "points", path[-1]): (value, unit) for path, value, unit, _ in _entries(model)
    }


def _converted(entry: tuple[Any, str] | None, factor: float) -> float | str | None:
    if entry is None:
        return None
    value = entry[0]
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (int, str)):
        return value
    return float(value) * factor


def sheet_text(design: Design, units: Units = "metric") -> str:
    """Setting sheet: blanks of both members, cutter and machine of each flank; angles in deg, lengths in one unit.

    Values without a label are listed as comments.
    """
    name, factor = _LENGTH[units]
    lines = [f"# machine summary of {design.name}", _line("units", name)]
    for member, part in (("pinion", design.pinion), ("gear", design.gear)):
        lines += ["", _line("member", member), *_lines("blank", part.blank, factor)]
        for side in FLANK_SIDES:
            lines += ["", _line("flank", side)]
            flank = getattr(part, side)
            for table in ("cutter", "machine"):
                inner = getattr(flank, table, None)
                if inner is not None:
                    lines += _lines(table, inner, factor)
            if getattr(flank, "machine", None) is None:
                lines.append("# not cut: given by points or by its ease-off")
    return "\n".join(lines) + "\n"


def _lines(table: str, model: BaseModel, factor: float) -> Iterator[str]:
    """Lines of a table without values that equal their default."""
    labels = {(where, key): label for label, (where, key, _) in reversed(LABELS.items())}
    for path, value, unit, default in _entries(model):
        if default and path[-1] not in KINDS:
            continue
        key = ".".join(path)
        if key == "blade_curvature":
            key, value, unit = "BLADE_RADIUS", 1.0 / value, "m"
        label, shown = labels.get((table, key)), _shown(value, unit, factor)
        yield _line(label, shown) if label else f"# no label: {table} {key} = {shown}"


def _shown(value: Any, unit: str, factor: float) -> str:
    if isinstance(value, str):
        return value.replace("_", " ")
    if unit == "m":
        return f"{value * factor:.12g}"
    return f"{math.degrees(value):.12g}" if unit == "rad" else f"{value:.12g}"


def _line(label: str, value: str) -> str:
    return f"{label + ',':{_WIDTH}} {value}"


_OF_SHEET = ("blank", "cutter", "machine", "concave", "convex")


def design_from_sheet(sheet: Path, like: str | None = None) -> tuple[str, list[str]]:
    """Text of a design file with the blanks, cutters and settings of a machine summary.

    Parameters
    ----------
    sheet : Path
        File for `efficiency.cutting.summary.read_summary`.
    like : str, optional
        Design file or name of a shipped design for the data that a sheet does not contain: assembly, operating point,
        materials, and members without data in the sheet. The resulting design is checked.

    Returns
    -------
    text : str
        The design file.
    notes : list of str
        Lines that were not read, and missing data.

    Raises
    ------
    InputError
        The sheet cannot be read, or the design is inconsistent.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import efficiency
    >>> folder = Path(tempfile.mkdtemp())
    >>> files = efficiency.load("fm_spiral_bevel_14x39").export(folder, ["summary"])
    >>> text, notes = efficiency.import_design(folder / "setting_sheet.csv", like="fm_spiral_bevel_14x39")
    >>> text.splitlines()[0]
    'name = "setting_sheet"'
    """
    content: dict[str, Any] = {}
    hands: dict[str, str] = {}
    if like is not None:
        hands = {name: getattr(load_design(like), name).blank.hand for name in ("pinion", "gear")}
        content = read_toml(named_file("design", "designs", like))
    summary = read_summary(sheet, hands)
    if not any(summary.tables.values()):
        allowed = "a machine summary: one label and its value per line, such as 'radial setting, 98.1'"
        hint = "No line has this form; `mixed-ehl export DESIGN -o FOLDER --what summary` writes setting_sheet.csv."
        raise InputError("summary", str(sheet), allowed, hint)
    notes = [f"not read: {line}" for line in summary.unread] + [f"omitted: {line}" for line in summary.left_out]
    if like is None:
        notes.append("name, assembly and operation are missing; --like DESIGN takes them from another design")
        return summary.toml(), notes
    content |= {"name": sheet.stem, "source": f"machine summary {sheet.name}; the rest as {content['name']}"}
    for member, tables in summary.tables.items():
        kept = {key: value for key, value in content[member].items() if key not in _OF_SHEET}
        content[member] = kept | _complete(tables, content[member])
    validate(Design, content)
    return Summary(content, summary.unread).toml(), notes


def _complete(tables: dict[str, Any], base: dict[str, Any]) -> dict[str, Any]:
    """Tables of a member; its blank or the hand of the blank is that of the base if the sheet has none."""
    own = tables.get("blank", {})
    start = base["blank"] if own.keys() <= {"hand"} else {"hand": base["blank"]["hand"]}
    return {"blank": {}} | tables | {"blank": start | own}
