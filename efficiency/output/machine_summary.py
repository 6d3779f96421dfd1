"""Summary of a pair as a machine setter reads it: blanks, cutters and machine settings of all four flanks."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from pydantic import BaseModel

from ehl.io.errors import InputError
from ehl.io.expectation import find_place
from ehl.io.units import ValueRange

if TYPE_CHECKING:
    from efficiency.blanks.cones import Blank
    from efficiency.design.design import Design

Units = Literal["metric", "inch"]
FLANKS = ("pinion concave", "pinion convex", "gear concave", "gear convex")
_INCH = 0.0254
KINDS = ("type", "process")

# shown unit, factor from SI, decimals
_SHOWN: dict[str, dict[str, tuple[str, float, int]]] = {
    "metric": {"m": ("mm", 1e3, 4), "1/m": ("1/mm", 1e-3, 7), "rad": ("deg", math.degrees(1.0), 4)},
    "inch": {"m": ("in", 1.0 / _INCH, 5), "1/m": ("1/in", _INCH, 6), "rad": ("deg", math.degrees(1.0), 4)},
}


@dataclass(frozen=True)
class SummaryRow:
    """One line of the summary.

    Attributes
    ----------
    section : str
        ``"blank"``, ``"cutter"``, ``"machine"`` and the like.
    name : str
        Name as in the design file.
    unit : str
        Of the values, after conversion.
    values : tuple
        Numbers or words for pinion concave, pinion convex, gear concave and gear convex; None where there is none.
    decimals : int
        Decimals a table shows.
    """

    section: str
    name: str
    unit: str
    values: tuple[float | str | None, ...]
    decimals: int

    @property
    def texts(self) -> tuple[str, ...]:
        """Values as a table shows them; a dash where there is none."""
        return tuple(self._text(value) for value in self.values)

    def _text(self, value: float | str | None) -> str:
        if value is None:
            return "–"
        if isinstance(value, str):
            return value
        if isinstance(value, int):
            return str(value)
        return f"{value:.{self.decimals}f}"


def summary_rows(design: Design, units: Units = "metric") -> list[SummaryRow]:
    """Everything a design file says of blanks, cutters and machine, and the dimensions that follow from the blanks.

    Parameters
    ----------
    design : Design
        The pair.
    units : {"metric", "inch"}
        Lengths in mm or inch; angles in deg.
    """
    members = [design.pinion, design.pinion, design.gear, design.gear]
    blanks = [dict(_entries("blank", member.blank)) for member in members]
    derived = [{("blank", name): entry for name, entry in _dimensions(m.blank.blank()).items()} for m in members]
    flanks = [
        dict(_entries("", getattr(member, side)))
        for member, side in zip(members, ("concave", "convex") * 2, strict=True)
    ]
    columns = [blank | more | flank for blank, more, flank in zip(blanks, derived, flanks, strict=True)]
    keys: dict[tuple[str, str], None] = {}
    for column in columns:
        keys.update(dict.fromkeys(column))
    order = {section: number for number, section in enumerate(dict.fromkeys(section for section, _ in keys))}
    rows = []
    for section, name in sorted(keys, key=lambda key: order[key[0]]):
        given = [column.get((section, name)) for column in columns]
        unit_si = next(entry[1] for entry in given if entry is not None)
        unit, factor, decimals = _SHOWN[units].get(unit_si, (unit_si, 1.0, 6))
        values = tuple(_converted(entry, factor) for entry in given)
        rows.append(SummaryRow(section, name, unit, values, decimals))
    return rows


def write_summary(path: Path, design: Design, units: Units = "metric") -> None:
    """Write the summary as CSV: section, name, unit, then one column for each flank, numbers in full.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow([f"# mixed-ehl machine summary v1; design={design.name}; units={units}"])
            writer.writerow(["section", "name", "unit", *(flank.replace(" ", "_") for flank in FLANKS)])
            for row in summary_rows(design, units):
                writer.writerow([row.section, row.name, row.unit, *("" if v is None else v for v in row.values)])
    except OSError as error:
        raise InputError("--summary", str(path), "a writable file", f"{error}.") from None


def chosen_units(text: str) -> Units:
    """Units named on the command line."""
    if text == "metric":
        return "metric"
    if text == "inch":
        return "inch"
    raise InputError("--units", text, "metric or inch")


def _entries(section: str, model: BaseModel) -> Iterator[tuple[tuple[str, str], tuple[Any, str]]]:
    """((section, name), (value, SI unit)) of a model and the models in it; what is not set is left out."""
    names = type(model).model_fields
    # the kind of a cutter or machine comes before its numbers
    for name in sorted(names, key=lambda name: name not in KINDS):
        value = getattr(model, name)
        if isinstance(value, BaseModel):
            yield from _entries(f"{section}.{name}" if section else name, value)
        elif isinstance(value, (int, float, str)):
            metadata = find_place(type(model), (name,)).metadata
            unit = next((item.unit for item in metadata if isinstance(item, ValueRange)), "")
            yield (section or "points", name), (value, unit)


def _dimensions(blank: Blank) -> dict[str, tuple[float, str]]:
    """What a blank drawing adds to the cones; crossing point to crown is taken along the axis."""
    u = np.array([-0.5, 0.5]) * blank.face_width
    radius, crown = blank.axial(u, blank.tip(u))
    face_angle, root_angle = blank.pitch_angle + blank.addendum_angle, blank.pitch_angle - blank.dedendum_angle
    root_radius, root = blank.axial(u, blank.root(u))
    return {
        "face_angle": (face_angle, "rad"),
        "root_angle": (root_angle, "rad"),
        "outer_cone_distance": (blank.mean_cone_distance + float(u[1]), "m"),
        "outer_diameter": (2.0 * (blank.mean_cone_distance + float(u[1])) * math.sin(blank.pitch_angle), "m"),
        "outer_tip_diameter": (2.0 * float(radius[1]), "m"),
        "outer_whole_depth": (float(blank.tip(u)[1] - blank.root(u)[1]), "m"),
        "crossing_to_crown": (float(crown[1]), "m"),
        "crossing_to_front_crown": (float(crown[0]), "m"),
        "face_apex_beyond_crossing": (float(radius[1] / math.tan(face_angle) - crown[1]), "m"),
        "root_apex_beyond_crossing": (float(root_radius[1] / math.tan(root_angle) - root[1]), "m"),
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
