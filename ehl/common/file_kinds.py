"""Kinds of input files, recognised by their keys, so that errors can name the kind of a wrong file."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from ehl.common.errors import InputError


@dataclass(frozen=True)
class Kind:
    """A kind of input file."""

    words: str  # name with article
    signs: tuple[tuple[str, ...], ...]  # tuples of keys of the first level; all keys of one tuple identify the kind
    use: str  # what reads it


# the first kind with matching keys is used
KINDS = {
    "contact": Kind("a contact file", (("contact",),), "mixed-ehl solve FILE"),
    "oil": Kind(
        "an oil card",
        (("viscosity_kinematic_40",), ("viscosity_kinematic_100",)),
        'mixed-ehl oil FILE, and oil = "FILE" in other files',
    ),
    "plan": Kind("a plan", (("variables",), ("sampling",)), "mixed-ehl sweep FILE"),
    "setup": Kind("the setup of a calibration", (("conditions",), ("specimens",)), "mixed-ehl calibrate --setup FILE"),
    "blank": Kind(
        "a blank",
        (("teeth_pinion",), ("face_width_gear",)),
        'mixed-ehl blank FILE, and blank = "FILE" in targets',
    ),
    "targets": Kind("a targets file", (("targets",), ("cutting",), ("blank", "operation")), "mixed-ehl settings FILE"),
    "axle": Kind("an axle", (("pinion_shaft",), ("gear_shaft",)), "mixed-ehl axle FILE"),
    "design": Kind("a design", (("assembly",), ("pinion", "gear")), "mixed-ehl gear FILE"),
}  # fmt: skip
_NEW = ("oil", "contact", "plan", "design", "targets")


def kind_of(content: Mapping[str, Any]) -> str:
    """Kind of the content of a file (a key of `KINDS`); empty if its keys are ambiguous."""
    for name, kind in KINDS.items():
        if any(all(key in content for key in keys) for keys in kind.signs):
            return name
    return ""


def refuse_other_kind(content: Mapping[str, Any], path: str | Path, wanted: str) -> None:
    """`InputError` if the file is recognised as another kind than the expected one."""
    found = kind_of(content)
    if wanted and found and found != wanted:
        kind = KINDS[found]
        raise InputError(
            "file", str(path), KINDS[wanted].words, f"It is {kind.words}, for {kind.use}. {_write(wanted)}"
        )


def looks_like(text: str) -> str:
    """Sentence with the format of a text that is not TOML; empty if the format is unknown."""
    start = text.lstrip()[:1]
    lines = [line for line in text.splitlines() if line.strip()][:3]
    if start in ("{",):
        return "It is JSON, such as a formula, for mixed-ehl mu, export and gear --friction."
    if start == "<":
        return "It is HTML or XML, such as a report."
    if lines and all("," in line and "=" not in line for line in lines):
        return "It is a table (CSV), such as a duty cycle, for mixed-ehl duty."
    return ""


def told_kind(text: str) -> str:
    """Sentence with the kind of a text file; empty if the kind is unknown."""
    try:
        kind = KINDS.get(kind_of(tomllib.loads(text)))
    except tomllib.TOMLDecodeError:
        return looks_like(text)
    return f"It is {kind.words}, for {kind.use}." if kind else ""


def refuse_unreadable(text: str, path: str | Path, wanted: str, error: InputError) -> NoReturn:
    """Error for a text that is not TOML, with its apparent format."""
    hint = looks_like(text)
    if not hint:
        raise error
    allowed = KINDS[wanted].words + " (TOML)" if wanted else error.allowed
    raise InputError(error.field, str(path), allowed, f"{hint} {_write(wanted)}".strip())


def _write(kind: str) -> str:
    return f"`mixed-ehl new {kind}` writes a valid one." if kind in _NEW else ""
