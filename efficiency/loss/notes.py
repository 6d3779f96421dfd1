"""Kinds of notes on a gear pair, the gravest first in each grade."""

from __future__ import annotations

from collections.abc import Iterable

from ehl.common.notes import Note, NoteKind, group_notes

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
    NoteKind("from memory, to be checked in print", "warning"),
    # with the lay of ground flanks the loss of the 14x39 is a third smaller
    NoteKind("the Peklenik number has no effect", "warning"),
    NoteKind("loss of the mesh alone", "for information"),
    NoteKind("bearings and drag:", "for information"),
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
