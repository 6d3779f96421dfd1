"""Reader for machine summaries: lines of "label, value" of a setting sheet, converted to tables of a design file.

A summary is text with one entry per line: label, separator (comma, semicolon, tab, ``=``, ``:``), value. Labels are
those of `LABELS` in any case; ``#`` starts a comment. Three labels apply to all following lines until they are given
again: ``units`` (``inch`` or ``mm``; angles are in degrees), ``member`` (``pinion`` or ``gear``) and ``flank``
(``concave``, ``convex``, ``outside blade``, ``inside blade`` or ``both``). A value may have its own unit ("4.108 in"),
or the label has it in brackets ("radial [mm]"); degrees may be given with minutes ("67d11m"). Numbers are kept as
written, with their unit; a decimal comma is read if no comma separates label and value.

Conventions of a sheet that are converted to those of the design file:

- cradle angle: unsigned or 0..360 deg on a sheet; negative for a left-hand member here
- a zero ratio of roll or motion of a Formate member, whose cradle is at rest, is omitted with a note
- blank offset ``down`` is positive, ``up`` negative; sliding base ``with`` (drawn) positive, ``advance`` negative
- cutter diameter, point diameter and blade radius are converted to radii and curvature; horizontal and vertical setting
  of a Formate member to radial setting and cradle angle; test rolls, or crown gear teeth over 75, to the roll ratio
- face and root angle, outer cone distance, outer addendum and whole depth are converted to values of the mean section

Tilt and swivel are kept as written: i about y, then j about z of the cradle frame (docs/cutting.md).
"""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from efficiency.cutting.blank import Blank
from efficiency.cutting.machine import GENERATIONS, MACHINE_INPUTS
from efficiency.cutting.process import PROCESSES
from ehl.common.data import data_rows
from ehl.common.errors import InputError, check_choice
from ehl.common.files import read_text, toml_text
from ehl.common.units import ValueRange, parse_quantity, spellings
from ehl.common.validation import locate_field


def _keys() -> Iterator[tuple[str, str, str]]:
    """Table, key and unit of all numbers and words of blanks, cutters and machines, from their input models."""
    yield "blank", "hand", "text"
    cutters = [process.cutter for process in PROCESSES.values()]
    for table, models in (("blank", [Blank]), ("cutter", cutters), ("machine", [*MACHINE_INPUTS.values()])):
        for model in models:
            yield from ((table, *entry) for entry in _entries(model))


def _entries(model: type[BaseModel], within: str = "") -> Iterator[tuple[str, str]]:
    for name in model.model_fields:
        place = locate_field(model, (name,))
        unit = next((part.unit for part in place.metadata if isinstance(part, ValueRange)), None)
        if isinstance(place.annotation, type) and issubclass(place.annotation, BaseModel):
            yield from _entries(place.annotation, f"{name}.")
        elif unit in ("m", "rad", ""):
            yield within + name, {"m": "mm", "rad": "deg", "": ""}[unit]
        elif unit is None:
            yield within + name, "#" if place.annotation is int else "text"


# labels that differ from the key of the design file with spaces; those with a table have a key in capitals, whose value
# is converted after reading
_SHEET = data_rows("setting_sheet.csv")
_TURNED_KEYS = {row["key"] for row in _SHEET if row["table"]}
_BY_KEY = {key: (table, key, unit) for table, key, unit in _keys()}


def _labels(written: str) -> dict[str, tuple[str, str, str]]:
    """Labels of the table with table, key and unit of their values; those `written` precede those only read."""
    return {
        row["label"]: (row["table"], row["key"], row["unit"]) if row["table"] else _BY_KEY[row["key"]]
        for row in _SHEET
        if row["written"] == written
    }


# the first label of a key is written
LABELS = _labels("yes")
LABELS |= {re.sub(r"[_.]", " ", key): entry for key, entry in _BY_KEY.items() if key != "type"} | _labels("no")
_FLANKS = dict.fromkeys(("concave", "outside blade", "ob"), "concave")
_FLANKS |= dict.fromkeys(("convex", "inside blade", "ib"), "convex") | {"both": ""}
_TEXTS = {
    "type": {process.label: name for name, process in PROCESSES.items()},
    "process": {word: name for name, generation in GENERATIONS.items() for word in generation.words},
    "hand": {"left": "left", "lh": "left", "right": "right", "rh": "right"},
}
# direction words of a sheet with their sign in the design file
_DIRECTIONS = {"down": 1.0, "up": -1.0, "with": 1.0, "withdraw": 1.0, "advance": -1.0, "adv": -1.0}
_MINUTES = re.compile(r"([+-]?\d+)\s*(?:d|deg|°)\s*(\d+(?:\.\d+)?)\s*(?:m|min|')\s*", re.IGNORECASE)
_UNITS = {"inch": "in", "in": "in", "mm": "mm", "metric": "mm"}


@dataclass(frozen=True)
class Summary:
    """Tables of a design file read from a summary."""

    # nested tables ``pinion`` and ``gear`` with ``blank``, ``cutter``, ``machine``, ``concave``, ``convex``
    tables: dict[str, Any]
    unread: tuple[str, ...]  # lines with an unknown label, as written
    left_out: tuple[str, ...] = ()  # zeros of settings that do not exist for the machine of a member

    def toml(self) -> str:
        """The tables as text of a design file; unread lines are appended as comments."""
        lines = toml_text(self.tables).splitlines()
        if self.unread:
            lines += ["# not read from the summary:", *(f"# {line}" for line in self.unread)]
        return "\n".join(lines).strip() + "\n"


def read_summary(path: str | Path, hands: Mapping[str, str] | None = None) -> Summary:
    """Read a machine summary file; text in any encoding.

    hands: hand of ``pinion`` and ``gear`` if the sheet states none.
    Raises `InputError` with all invalid lines.
    """
    return parse_summary(read_text(path, "summary", "a readable text file"), hands)


def parse_summary(text: str, hands: Mapping[str, str] | None = None) -> Summary:
    """Read a machine summary from text, as `read_summary`."""
    length, member, flank = "", "", ""
    found: dict[tuple[str, str, str, str], Any] = {}
    unread: list[str] = []
    problems: list[InputError] = []
    for number, line in enumerate(text.splitlines(), 1):
        label, brackets, value = _entry(line)
        if not label:
            continue
        where = f"line {number}"
        try:
            if label == "units":
                length = _chosen(_UNITS, value, where)
            elif label == "member":
                member = _chosen({"pinion": "pinion", "gear": "gear"}, value, where)
                flank = ""
            elif label == "flank":
                flank = _chosen(_FLANKS, value, where)
            elif label in LABELS:
                if not member:
                    raise InputError(where, label, "a line 'member, pinion' or 'member, gear' before the first value")
                table, key, unit = LABELS[label]
                of_label = length if brackets is None else _unit_of_label(brackets, unit, f"{where} ({label})")
                read = _value(value, key, unit, of_label, f"{where} ({label})")
                if found.setdefault((member, flank, table, key), read) != read:
                    raise InputError(f"{where} ({label})", value, "one value of each setting")
            else:
                unread.append(line.strip())
        except InputError as problem:
            problems.append(problem)
    tables: dict[str, Any] = {}
    left_out: list[str] = []
    for name in ("pinion", "gear"):
        own = {key[1:]: value for key, value in found.items() if key[0] == name}
        if own:
            left_out += _without_rest(own, name)
            try:
                tables[name] = _member(own, name, (hands or {}).get(name))
            except InputError as problem:
                problems.append(problem)
    if problems:
        raise InputError.of(problems)
    return Summary(tables, tuple(unread), tuple(left_out))


def _entry(line: str) -> tuple[str, str | None, str]:
    """Label in lower case, its unit in brackets, and value of a line; all empty for a line without content."""
    bare = line.partition("#")[0].strip().rstrip(",;\t ")
    entry = re.fullmatch(r"([^,;\t=:]+)([,;\t=:](?:\s*[,;\t=:])*)(.*)", bare)
    label, separator, value = (entry[1], entry[2], entry[3].strip()) if entry else (bare, "", "")
    if "," not in separator:
        value = re.sub(r"(?<![\d.,])(\d+),(\d+)(?![\d.,])", r"\1.\2", value)
    named = re.fullmatch(r"(.*?)\s*[\[(]([^\])]*)[\])]", " ".join(label.strip('"').lower().split()))
    return (named[1], named[2].strip(), value.strip('"')) if named else (" ".join(label.lower().split()), None, value)


def _unit_of_label(brackets: str, unit: str, where: str) -> str:
    """Validated unit of a label in brackets; the unit of a motion is a length per radian."""
    if unit not in ("mm", "deg"):
        return ""
    own, si = _UNITS.get(brackets, brackets.removesuffix("/rad")), {"mm": "m", "deg": "rad"}[unit]
    if own not in spellings(si):
        allowed = "in brackets a unit of " + ("length such as mm or in" if si == "m" else "angle such as deg")
        raise InputError(where, brackets, allowed, "Write other remarks after '#'.")
    return own


def _without_rest(own: dict[tuple[str, str, str], Any], name: str) -> list[str]:
    """Remove zeros of settings that do not exist for a machine, such as a Formate member's; returns a note for each."""
    left_out: dict[str, None] = {}
    for flank, table, key in list(own):
        process = own.get((flank, "machine", "process"), own.get(("", "machine", "process")))
        if table == "machine" and process in MACHINE_INPUTS and key not in _TURNED_KEYS:
            value = own[flank, table, key]
            number = value[0] if isinstance(value, tuple) else value
            if key not in MACHINE_INPUTS[process].model_fields and number == 0.0:
                del own[flank, table, key]
                left_out[f"{name}: {key} is 0 and does not apply to a {GENERATIONS[process].label} member"] = None
    return list(left_out)


def _chosen(words: dict[str, str], value: str, where: str) -> str:
    word = " ".join(value.lower().split())
    check_choice(where, word, words)
    return words[word]


def _value(text: str, key: str, unit: str, length: str, where: str) -> Any:
    """Value of a label: a word, a whole number, a number, or (number, unit)."""
    if unit == "text":
        return _chosen(_TEXTS[key], text, where)
    word = text.split()[-1].lower() if text.split() else ""
    sign = _DIRECTIONS.get(word, 0.0)
    bare = text[: -len(word)].strip() if sign else text
    if not sign and text.split() and text.split()[0].lower() in _DIRECTIONS:
        sign, bare = _DIRECTIONS[text.split()[0].lower()], text.partition(" ")[2].strip()
    minutes = _MINUTES.fullmatch(bare)
    if unit == "deg" and minutes:
        turn = -1.0 if bare.startswith("-") else 1.0
        return (sign or 1.0) * (float(minutes[1]) + turn * float(minutes[2]) / 60.0), "deg"
    try:
        number, own = float(bare), ""
    except ValueError:
        # the unit is validated here and kept as written
        try:
            si = parse_quantity(bare, {"mm": "m", "deg": "rad"}.get(unit, ""), field=where)
        except InputError as error:
            allowed = {"deg": "degrees, such as 62.78 or 62d47m", "mm": "a length, such as 4.108 or '4.108 in'"}
            raise InputError(where, text, allowed.get(unit, error.allowed), error.hint) from None
        match = re.fullmatch(r"([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*([^\d]*)", bare)
        # degrees with minutes and seconds become degrees
        number, own = (float(match[1]), match[2]) if match else (math.degrees(si), "deg")
    if not math.isfinite(number):
        raise InputError(where, text, "a finite number")
    number *= sign or 1.0
    if unit == "#":
        if number != int(number):
            raise InputError(where, text, "a whole number")
        return int(number)
    if unit == "":
        return number
    if unit == "deg" and length in _UNITS.values():
        length = ""  # unit of lengths only
    if unit == "mm" and not own and not length:
        if number == 0.0:
            return number, "mm"  # the same in any unit
        raise InputError(where, text, "a value with its unit, or a preceding line 'units, inch' or 'units, mm'")
    return number, own or length or "deg"


class _Part:
    """Entries of one table of one flank, removed as they are converted to those of the design file."""

    def __init__(self, values: dict[str, Any]) -> None:
        self.values = values

    def si(self, key: str, unit: str) -> float | None:
        """Remove an entry and return its value in SI units."""
        entry = self.values.pop(key, None)
        return None if entry is None else parse_quantity(f"{entry[0]!r} {entry[1]}", unit, field=key)

    def scaled(self, key: str, name: str, factor: float) -> None:
        """Move a value to another key, multiplied by a factor, in its original unit."""
        if key in self.values:
            number, unit = self.values.pop(key)
            self.values[name] = (factor * number, unit)


def _member(own: dict[tuple[str, str, str], Any], name: str, hand: str | None) -> dict[str, Any]:
    hand = own.get(("", "blank", "hand"), hand)
    tables: dict[str, Any] = {}
    teeth = own.get(("", "blank", "teeth"))
    for flank in ("", "concave", "convex"):
        for table in ("blank", "cutter", "machine"):
            part = _Part({key[2]: value for key, value in own.items() if key[:2] == (flank, table)})
            if not part.values:
                continue
            target = tables if not flank else tables.setdefault(flank, {})
            if table == "blank":
                _blank(part, name)
            elif table == "cutter":
                for key, side in (("OUTSIDE_ANGLE", "concave"), ("INSIDE_ANGLE", "convex")):
                    if key in part.values:
                        cutter = tables.setdefault(side, {}).setdefault("cutter", {})
                        cutter["blade_angle"] = _text(part.values.pop(key))
                part.scaled("DIAMETER", "cutter_radius", 0.5)
                part.scaled("POINT_DIAMETER", "point_radius", 0.5)
                radius = part.si("BLADE_RADIUS", "m")
                if radius:
                    part.values["blade_curvature"] = (1.0 / radius, "1/m")
            else:
                _machine(part, hand, teeth, name)
            place = target.setdefault(table, {})
            for key, value in part.values.items():
                outer, _, inner = key.partition(".")
                (place.setdefault(outer, {}) if inner else place)[inner or outer] = _text(value)
    return tables


def _blank(part: _Part, name: str) -> None:
    """Compute mean section and cone angles from the dimensions at the heel."""
    values = part.values

    def known(key: str, unit: str) -> float | None:
        entry = values.get(key)
        return None if entry is None else parse_quantity(f"{entry[0]!r} {entry[1]}", unit, field=f"{name}.{key}")

    pitch, face = known("pitch_angle", "rad"), known("face_width", "m")
    tip, root, cone = part.si("FACE_ANGLE", "rad"), part.si("ROOT_ANGLE", "rad"), part.si("OUTER_CONE", "m")
    addendum, depth = part.si("OUTER_ADDENDUM", "m"), part.si("OUTER_DEPTH", "m")
    if pitch is not None:
        for key, angle in (("addendum_angle", tip and tip - pitch), ("dedendum_angle", root and pitch - root)):
            if angle is not None:
                values[key] = (round(math.degrees(angle), 10), "deg")
    if face is None:
        return
    if cone is not None:
        values["mean_cone_distance"] = (_rounded(cone - 0.5 * face), "mm")
    rise, fall = known("addendum_angle", "rad"), known("dedendum_angle", "rad")
    if addendum is not None and rise is not None:
        values["mean_addendum"] = (_rounded(addendum - 0.5 * face * math.tan(rise)), "mm")
        if depth is not None and fall is not None:
            values["mean_dedendum"] = (_rounded(depth - addendum - 0.5 * face * math.tan(fall)), "mm")


def _machine(part: _Part, hand: str | None, teeth: int | None, name: str) -> None:
    values = part.values
    horizontal, vertical = part.si("HORIZONTAL", "m"), part.si("VERTICAL", "m")
    if horizontal is not None and vertical is not None:
        values["radial_setting"] = (_rounded(math.hypot(horizontal, vertical)), "mm")
        values["cradle_angle"] = (round(math.degrees(math.atan2(vertical, horizontal)), 10), "deg")
    cradle, work = part.si("CRADLE_ROLL", "rad"), part.si("WORK_ROLL", "rad")
    if cradle and work:
        values.setdefault("roll_ratio", round(work / cradle, 10))
    crown = values.pop("CROWN_TEETH", None)
    if crown is not None:
        if teeth is None:
            raise InputError(f"{name}: nc/75", crown, "a line 'teeth, ...' of the member as well")
        values["roll_ratio"] = round(75.0 * crown / teeth, 10)
    if "cradle_angle" in values:
        number, unit = values["cradle_angle"]
        if unit != "deg":
            number = math.degrees(parse_quantity(f"{number!r} {unit}", "rad", field=f"{name}: cradle angle"))
        angle = math.remainder(number, 360.0)
        if hand is not None:
            angle = math.copysign(angle, 1.0 if hand == "right" else -1.0)
        values["cradle_angle"] = (round(angle, 10), "deg")


def _rounded(length: float) -> float:
    """Metres in millimetres, rounded to remove binary noise."""
    return round(length * 1e3, 10)


def _text(value: Any) -> Any:
    return f"{value[0]!r} {value[1]}" if isinstance(value, tuple) else value
