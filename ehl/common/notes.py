"""Notes of results grouped by kind and sorted by severity.

Notes are sentences with the values of one case. `group_notes` combines sentences that differ only in numbers and
places into one row with the number of cases, the worst sentence, and its case.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from typing import Literal

from ehl.common.table import Table
from ehl.common.terminal import print_text

Grade = Literal["fault", "warning", "for information"]
GRADES: tuple[Grade, ...] = ("fault", "warning", "for information")

_CASES_NAMED = 2  # number of cases that are named
_NUMBER = re.compile(r"(?<![\w.])[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
# parts of a sentence that describe a place
_PLACE = re.compile(r"\([^)]*\)|\b(?:near the|midway) (?:toe|heel|root|tip)(?: to (?:heel|tip))?|;.*$")


@dataclass(frozen=True)
class NoteKind:
    """A kind of note, recognised by a phrase in its sentences."""

    words: str  # part of every sentence of this kind
    # "fault": the result is invalid; "warning": it is valid with the stated limit; "for information"
    grade: Grade
    low: bool = False  # whether the smallest value is the worst


@dataclass(frozen=True)
class Note:
    """All notes of one kind."""

    grade: Grade  # one of `GRADES`
    text: str  # the sentence with the worst value
    count: int = 1  # number of cases with such a note
    where: str = ""  # the case of `text`; the first cases if all sentences are equal; empty for a single case
    alike: bool = field(default=False, repr=False)  # whether all sentences are equal


CONTACT_NOTES: tuple[NoteKind, ...] = (
    NoteKind("no law of the oil is valid", "fault"),
    NoteKind(": yielding", "fault"),
    NoteKind("thinner than a few oil molecules", "warning", low=True),
    NoteKind("oils decompose", "warning"),
    NoteKind("outside the measured range", "warning"),
    NoteKind("measured range of the oil: its law is extrapolated", "warning"),
    NoteKind("is neglected; it changes", "warning"),
    NoteKind("may not resolve", "warning"),
    NoteKind("maximum number of nodes", "warning"),
    NoteKind("overestimated by", "warning"),
    NoteKind("than the oil: the oil enters at their temperature", "for information"),
    NoteKind("of a map, with the median Rq", "for information"),
    NoteKind("read by SurfaceTopography", "for information"),
    NoteKind("resampled: steps", "for information"),
    NoteKind("running-in", "for information"),
    NoteKind("no effect", "for information"),
    NoteKind("without effect", "for information"),
)
"""Kinds of notes on one contact; others count as warnings."""


def group_notes(sentences: Iterable[tuple[str, str]], kinds: Sequence[NoteKind] = CONTACT_NOTES) -> list[Note]:
    """One note for each kind, sorted by grade, then by the order of `kinds`, then by frequency.

    sentences: case and sentence; the case is empty if there is only one.
    kinds: kinds of notes by importance. A sentence is of the first kind whose phrase it contains. Sentences without a
        kind are grouped by their words and follow the others of their grade.
    """
    groups: dict[str, list[tuple[str, str]]] = {}
    for case, text in sentences:
        kind = _kind(text, kinds)
        words = kind.words if kind is not None else _NUMBER.sub("#", _PLACE.sub("", text))
        groups.setdefault(words, []).append((case, text))
    found: list[tuple[int, int, int, Note]] = []
    for members in groups.values():
        kind = _kind(members[0][1], kinds)
        sign = -1.0 if kind is not None and kind.low else 1.0
        # index of the first number that differs between the sentences
        numbers = zip(*(_NUMBER.findall(text) for _, text in members), strict=False)
        column = next((k for k, each in enumerate(numbers) if len(set(each)) > 1), 0)
        case, text = max(members, key=lambda member: sign * _value(member[1], column))
        cases = list(dict.fromkeys(case for case, _ in members))
        alike = len({text for _, text in members}) == 1
        if alike:
            case = "; ".join(cases[:_CASES_NAMED]) + ("; ..." if len(cases) > _CASES_NAMED else "")
        grade: Grade = "warning" if kind is None else kind.grade
        note = Note(grade, text, len(cases), case, alike and len(cases) > 1)
        place = len(kinds) if kind is None else list(kinds).index(kind)
        found.append((GRADES.index(note.grade), place, -note.count, note))
    return [note for *_, note in sorted(found, key=itemgetter(0, 1, 2))]


def notes_table(notes: Sequence[Note], cases: int = 1) -> Table:
    """The notes as a table: grade, note, and for several cases the number of cases and the worst case."""
    if cases <= 1:
        return Table(("grade", "note"), [(note.grade, note.text) for note in notes], name="notes")
    rows = [(note.grade, *_scope(note, cases), note.text) for note in notes]
    # the long text is the last column
    return Table(("grade", "cases", "where, at its worst", "note"), rows, name="notes")


def print_notes(notes: Sequence[Note], cases: int = 1) -> None:
    """Print each note with its grade, the number of cases and the worst case; continuation lines are indented."""
    for note in notes:
        count, place = _scope(note, cases)
        where = "" if cases <= 1 else f", {count}" if place else ", all cases"
        worst = f" ({'' if note.alike or note.count == 1 else 'worst at '}{place})" if place and cases > 1 else ""
        print_text(f"{note.grade}{where}{worst}: {note.text}", indent=2)


def _scope(note: Note, cases: int) -> tuple[str, str | None]:
    """Number of cases of a note, and those that are named."""
    if not note.where or (note.alike and note.count == cases):
        return "all", None
    return f"{note.count} of {cases}", note.where


def _kind(text: str, kinds: Sequence[NoteKind]) -> NoteKind | None:
    return next((kind for kind in kinds if kind.words in text), None)


def _value(text: str, column: int) -> float:
    numbers = _NUMBER.findall(text)
    return float(numbers[column]) if column < len(numbers) else 0.0
