"""Machine summary as a setting sheet: one entry a line, in the form that `efficiency.cutting.summary` reads back."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from efficiency.cutting.summary import LABELS
from efficiency.output.machine_summary import KINDS, Units
from ehl.io.errors import InputError
from ehl.io.expectation import find_place
from ehl.io.units import ValueRange

if TYPE_CHECKING:
    from collections.abc import Iterator

    from efficiency.design.design import Design

_LENGTH = {"metric": ("mm", 1e3), "inch": ("inch", 1.0 / 0.0254)}
_TABLES = ("blank", "cutter", "machine")
_WIDTH = 34


def sheet_text(design: Design, units: Units = "metric") -> str:
    """The sheet: members, their blanks, then cutter and machine of each flank; angles in deg, lengths in one unit.

    What has no label on a sheet follows as a comment.
    """
    name, factor = _LENGTH[units]
    lines = [f"# machine summary of {design.name}", _line("units", name)]
    for member, part in (("pinion", design.pinion), ("gear", design.gear)):
        lines += ["", _line("member", member), *_lines("blank", part.blank, factor)]
        for side in ("concave", "convex"):
            lines += ["", _line("flank", side)]
            flank = getattr(part, side)
            for table in _TABLES[1:]:
                inner = getattr(flank, table, None)
                if inner is not None:
                    lines += _lines(table, inner, factor)
            if getattr(flank, "machine", None) is None:
                lines.append("# not cut: given by points or by its ease-off")
    return "\n".join(lines) + "\n"


def write_sheet(path: Path, design: Design, units: Units = "metric") -> None:
    """Write the sheet.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(sheet_text(design, units), encoding="utf-8")
    except OSError as error:
        raise InputError("--output", str(path), "a writable file", f"{error}.") from None


def _lines(table: str, model: BaseModel, factor: float) -> Iterator[str]:
    labels = {(where, key): label for label, (where, key, _) in reversed(LABELS.items())}
    for key, value, unit in _entries(model, ""):
        if key == "blade_curvature":
            key, value, unit = "BLADE_RADIUS", 1.0 / value, "m"
        label, shown = labels.get((table, key)), _shown(value, unit, factor)
        yield _line(label, shown) if label else f"# no label: {table} {key} = {shown}"


def _entries(model: BaseModel, prefix: str) -> Iterator[tuple[str, Any, str]]:
    """(key, value, SI unit) of a model and the models in it; what stands at its default is left out."""
    fields = type(model).model_fields
    for name in sorted(fields, key=lambda name: name not in KINDS):
        value = getattr(model, name)
        if isinstance(value, BaseModel):
            yield from _entries(value, f"{prefix}{name}.")
        elif name in KINDS or value != fields[name].get_default():
            metadata = find_place(type(model), (name,)).metadata
            unit = next((item.unit for item in metadata if isinstance(item, ValueRange)), "")
            yield f"{prefix}{name}", value, unit


def _shown(value: Any, unit: str, factor: float) -> str:
    if isinstance(value, str):
        return value.replace("_", " ")
    if unit == "m":
        return f"{value * factor:.12g}"
    return f"{math.degrees(value):.12g}" if unit == "rad" else f"{value:.12g}"


def _line(label: str, value: str) -> str:
    return f"{label + ',':{_WIDTH}} {value}"
