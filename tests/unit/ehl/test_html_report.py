from __future__ import annotations

from pathlib import Path

import pytest
from matplotlib.figure import Figure
from pages import read_page

from ehl.common.errors import InputError
from ehl.common.html_report import (
    Answer,
    Beside,
    Folded,
    Formula,
    KeyFigures,
    Notes,
    Picture,
    Pictures,
    Section,
    Text,
    write_report,
)
from ehl.common.notes import Note, NoteKind, group_notes, notes_table
from ehl.common.table import Table

KINDS = (NoteKind("teeth yield", "fault"), NoteKind("edges carry", "warning"), NoteKind("safety", "warning", low=True))


def figure() -> Figure:
    drawn = Figure()
    axes = drawn.add_subplot()
    axes.plot([0.2, 0.7], [0, 1])
    axes.set_xscale("log")
    return drawn


def test_page_holds_everything_and_escapes(tmp_path: Path) -> None:
    picture = Picture(figure(), "a line")
    many = [Note("warning", f"note {k} at 90 degC", 2, f"{k} N m") for k in range(5)]
    page = read_page(
        write_report(
            tmp_path / "sub" / "page.html",
            "Title & more",
            "subtitle",
            [
                Section(
                    "", [Answer("99.1 %", "efficiency", [("98 to 99.5 %", "interval")]), KeyFigures([("5 W", "loss")])]
                ),
                Section("One", [Text("a < b"), Folded("The formula", [Formula("mu = 0.05")]), Notes(many, cases=7)]),
                Section(
                    "Two",
                    [
                        Table(["name", "value"], [["x", "1"], ["y", "2"]], "cap", highlight=1),
                        Pictures([picture, Picture(figure(), "another")]),
                        Beside([Text("left"), Text("right")]),
                    ],
                ),
            ],
            "footer",
        )
    )
    assert page.sections[0].startswith("99.1 % efficiency 98 to 99.5 % interval 5 W loss")
    assert "1. One 2. Two" in page.sections[0]
    for part in ("Title & more", "a < b", "mu = 0.05", "cap", "a line", "footer", "2 more of less weight"):
        assert part in page.text
    # units typeset, each note with its count and the worst case
    assert "note 4 at 90 °C 2 of 7; worst: 4 N m" in page.sections[1]
    assert 'class="highlight"' in page.source
    assert page.source.count("<svg") == 2


def test_powers_of_ten_between_the_marks_of_an_axis_are_typeset(tmp_path: Path) -> None:
    page = write_report(tmp_path / "page.html", "", "", [Section("", [Picture(figure(), "")])])
    assert "mathdefault" not in page.read_text(encoding="utf-8")


def test_notes_that_differ_in_numbers_and_places_are_one_row() -> None:
    said = [
        ("50 N m", "edges carry 2 % of the torque (gear tip 2 %), near the toe"),
        ("90 N m", "edges carry 11 % of the torque (pinion tip 11 %), near the heel"),
        ("90 N m", "another kind at 3 of 24 places, near the root"),
        ("70 N m", "another kind at 5 of 24 places, near the tip"),
        ("90 N m", "safety 0.8 below 1"),
        ("70 N m", "safety 0.9 below 1"),
        ("90 N m", "2.1 GPa: the teeth yield"),
    ]
    notes = group_notes(said, KINDS)
    assert [(note.grade, note.count, note.where) for note in notes] == [
        ("fault", 1, "90 N m"),
        ("warning", 2, "90 N m"),
        ("warning", 2, "90 N m"),
        ("warning", 2, "70 N m"),
    ]
    assert [note.text.split(" (")[0] for note in notes] == [
        "2.1 GPa: the teeth yield",
        "edges carry 11 % of the torque",
        "safety 0.8 below 1",
        "another kind at 5 of 24 places, near the tip",
    ]
    assert notes_table(notes, 4).rows[1][1:3] == ("2 of 4", "90 N m")
    assert group_notes([], KINDS) == []


def test_of_cases_that_say_the_same_none_is_the_worst(capsys: pytest.CaptureFixture[str]) -> None:
    said = [(f"model {letter}", "the same, in 2007") for letter in "cab"]
    (same,) = group_notes(said)
    assert (same.count, same.where) == (3, "model c, model a, ...")
    assert notes_table([same, Note("for information", "of every case")], 3).rows == (
        ("warning", "3 of 3", "model c, model a, ...", "the same, in 2007"),
        ("for information", "all", None, "of every case"),
    )
    notes_table([], 3).print()
    assert capsys.readouterr().out == ""


def test_unwritable_page(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="writable"):
        write_report(tmp_path / "file" / "page.html", "", "", [])
