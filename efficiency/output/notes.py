"""Notes on a gear pair and its results, graded and grouped for pages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from efficiency.output.tables import operating_state, percent
from ehl.view.notes import Note, NoteKind, group_notes, notes_table
from regression.friction.published_registry import model_label

if TYPE_CHECKING:
    from efficiency.loss.efficiency_result import EfficiencyResult
    from efficiency.loss.grid import Grid
    from ehl.view.table import Table

GEAR_NOTES: tuple[NoteKind, ...] = (
    # before the limits that its sentence names too
    NoteKind("edges carry", "warning"),
    NoteKind("not converged:", "fault"),
    NoteKind("no answer:", "fault"),
    NoteKind("above shakedown", "fault"),
    NoteKind("the teeth would yield", "fault"),
    NoteKind("the two flanks do not match", "fault"),
    NoteKind("has no value at", "fault"),
    NoteKind("no state of uniform motion", "fault"),
    NoteKind("contacts not solved", "warning"),
    NoteKind("was fitted to", "warning"),
    NoteKind("has other figures now", "warning"),
    NoteKind("of the sliding power lies outside the range", "warning"),
    NoteKind("above first yield", "warning"),
    NoteKind("above the contact endurance", "warning"),
    NoteKind("pitting safety", "warning", low=True),
    NoteKind("is undercut", "warning"),
    NoteKind("the mating tip would reach it", "warning"),
    NoteKind("withdraw the cutter", "warning"),
    NoteKind("of the whole depth above the root cone", "for information"),
    NoteKind("the contact pattern runs into", "warning"),
    NoteKind("unloaded contact runs over an edge", "warning"),
    NoteKind("teeth as plates on an elastic root", "warning"),
    NoteKind("from memory, to be checked in print", "warning"),
    # with the lay of ground flanks the loss of the 14x39 is a third smaller
    NoteKind("the Peklenik number has no effect", "warning"),
    NoteKind("not graded", "for information"),
    NoteKind("error of that surface", "for information"),
    NoteKind("by the uncertainty of the measured flanks", "for information"),
    NoteKind("is approximate at some pinion angles", "for information"),
    NoteKind("shafts and bearings give way", "for information"),
)
"""Kinds of notes on a pair; others count as warnings."""


def pair_notes(said: Iterable[tuple[str, str]]) -> list[Note]:
    """Notes on a pair, each with its case, one for each kind and the gravest first."""
    return group_notes(said, GEAR_NOTES)


def result_notes(result: EfficiencyResult, of_design: Sequence[str] = (), case: str = "") -> list[tuple[str, str]]:
    """Case and sentence of all that has to be known of one operating point, each kind once.

    Parameters
    ----------
    result : EfficiencyResult
    of_design : sequence of str
        Notes on the pair without load.
    case : str
        How the operating point is called among others.
    """
    said = [f"not converged: {result.reason}"] if result.status != "converged" else []
    edges = False
    if result.source is not None:
        said += [grade.text for grade in result.strength.grades]
        edges = any(grade.kind == "edges" for grade in result.strength.grades)
    # of load at edges the grade says what to do about it, the note where it is
    said += [note for note in result.notes if not (edges and note.startswith("edges carry"))]
    if outside := outside_note(result.outside_range_share, model_label(result.friction_model)):
        said.append(outside)
    # those without load belong to every case
    return [(case, text) for text in said] + [("", note) for note in of_design if note not in said]


def grid_notes(grid: Grid) -> Table:
    """What has to be known of a map: a row for each kind of note with the worst point; below what is left out."""
    said = [pair for result in grid.results for pair in result_notes(result, (), operating_state(result))]
    skipped = dict.fromkeys(text for result in grid.results for text in result.skipped)
    table = notes_table(pair_notes(said), len(grid.results))
    return replace(table, notes=tuple(f"skipped: {text}" for text in skipped))


def outside_note(share: float, model: str) -> str:
    """One sentence where more than 1 % of the sliding power lies outside the range of a friction model; else empty."""
    return f"{percent(share, 1)} % of the sliding power lies outside the range of {model}" if share > 0.01 else ""
