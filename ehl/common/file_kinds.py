"""Kinds of files a user writes, told by their keys: a file of the wrong kind is named as what it is."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from ehl.common.errors import InputError


@dataclass(frozen=True)
class Kind:
    """A kind of input file."""

    words: str  # what it is called, with its article
    signs: tuple[tuple[str, ...], ...]  # keys of its first level, all of one of the tuples, that no other kind has
    use: str  # what reads it


# in this order: the first whose signs are there
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
    """Which of `KINDS` the content of a file is; empty where its keys do not tell."""
    for name, kind in KINDS.items():
        if any(all(key in content for key in keys) for keys in kind.signs):
            return name
    return ""


def refuse_other_kind(content: Mapping[str, Any], path: str | Path, wanted: str) -> None:
    """`InputError` where the file is of another kind than the one wanted; none where that cannot be told."""
    found = kind_of(content)
    if wanted and found and found != wanted:
        kind = KINDS[found]
        raise InputError(
            "file", str(path), KINDS[wanted].words, f"It is {kind.words}, for {kind.use}. {_write(wanted)}"
        )


def looks_like(text: str) -> str:
    """The sentence that says what a text is that is no TOML; empty where it does not tell."""
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
    """The sentence that says what a text file is; empty where it does not tell."""
    try:
        kind = KINDS.get(kind_of(tomllib.loads(text)))
    except tomllib.TOMLDecodeError:
        return looks_like(text)
    return f"It is {kind.words}, for {kind.use}." if kind else ""


def refuse_unreadable(text: str, path: str | Path, wanted: str, error: InputError) -> NoReturn:
    """The error of a text that is no TOML, with what it looks like."""
    hint = looks_like(text)
    if not hint:
        raise error
    allowed = KINDS[wanted].words + " (TOML)" if wanted else error.allowed
    raise InputError(error.field, str(path), allowed, f"{hint} {_write(wanted)}".strip())


def _write(kind: str) -> str:
    return f"`mixed-ehl new {kind}` writes one that works." if kind in _NEW else ""
