"""One table in every form, and the pages and files of a result: hostile words stay words, files are SI."""

import csv
import html
import io
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from openpyxl import load_workbook
from pages import read_page
from refusals import refuses
from rich.console import Console

from ehl.common.notes import Note, NoteKind, group_notes, notes_table
from ehl.common.pages import Reportable, write_csv, write_workbook
from ehl.common.sections import Code, Folded, Head, KeyFigures, MainResult, Medium, Notes, Picture, Row, Section, Text
from ehl.common.table import Column, Table

HOSTILE = ["pair [80W]", "[/x]", "[bold red]no", "=cmd|' /C calc'!A0", "+1-1", "@SUM(A1)", "油脂テスト", "<b>&</b>"]
HOSTILE.append("a\x1b[31mb")
TABLE = Table(
    ["oil", "film_central", "efficiency", "temperature_oil"],
    [(text, 2.5e-7 + 1e-10 * i, 0.98765 + 1e-5 * i, 353.15) for i, text in enumerate(HOSTILE)],
    title="[/title] <i>",
    notes=["note [/n] <u>"],
    name="a/b [c]",
)


def printed(table: Table, width: int) -> str:
    file = io.StringIO()
    Console(file=file, width=width, force_terminal=True, color_system=None).print(table)
    return file.getvalue()


def test_page_escapes_words() -> None:
    page = TABLE.html()
    assert set(re.findall(r"<(\w+)", page)) <= {"table", "caption", "span", "thead", "tbody", "tr", "th", "td", "p"}
    cells = [re.findall(r"<t[hd].*?>(.*?)</t[hd]>", row) for row in page.split("<tr")[1:]]
    head, first, *others = ([html.unescape(re.sub("<.*?>", "", cell)) for cell in row] for row in cells)
    assert head == ["oil", "central film thickness [nm]", "efficiency [%]", "oil temperature [°C]"]
    assert [row[0] for row in (first, *others)] == HOSTILE
    assert first[1:] == ["250.0", "98.765", "80.00"]


def test_csv_is_si_and_computes_nothing() -> None:
    head, *rows = csv.reader(io.StringIO(TABLE.csv()))
    assert head == ["oil", "film_central [m]", "efficiency", "temperature_oil [K]"]
    assert [row[0] for row in rows] == [f"'{word}" if word[0] in "=+-@" else word for word in HOSTILE]
    numbers = [(record["film_central"], 353.15) for record in TABLE.records()]
    assert [(float(row[1]), float(row[3])) for row in rows] == numbers


def test_workbook_is_in_display_units_and_computes_nothing(tmp_path: Path) -> None:
    many = [TABLE, TABLE, Table(["note"], [], name="x" * 40), Table(["note"], [["a"]], name="x" * 50)]
    book = load_workbook(write_workbook(tmp_path / "t.xlsx", [Section("", [Head("=title"), *many])]))
    assert book.sheetnames[:3] == ["about", "a b  c", "a b  c 2"]
    assert len({name.lower() for name in book.sheetnames}) == 5
    sheet = book["a b  c"]
    assert [c.value for c in sheet[1]] == ["oil", "film_central [nm]", "efficiency [%]", "temperature_oil [degC]"]
    assert sheet["B2"].value == pytest.approx(250.0)
    assert sheet["D2"].value == pytest.approx(80.0)
    assert [cell.data_type for cell in sheet["A"]] == ["s"] * (1 + len(HOSTILE))
    assert "note [/n] <u>" in {cell.value for cell in book["about"]["B"]}


def test_json_and_frame_are_si_without_nan() -> None:
    table = Table(["oil", "film_central"], [(np.str_("a"), np.float64(1e-7)), ("b", np.nan), ("c", np.int64(0))])
    records = json.loads(json.dumps(table.records(), allow_nan=False))
    assert [(record["oil"], record["film_central"]) for record in records] == [("a", 1e-7), ("b", None), ("c", 0)]
    assert list(table.to_frame().columns) == ["oil", "film_central"]


@pytest.mark.parametrize("width", [8, 29, 78])
@pytest.mark.parametrize("vertical", [False, True])
def test_narrow_terminals_lose_columns_but_no_digits(width: int, vertical: bool) -> None:
    numbers = {"film_central": 2.5e-7, "efficiency": 0.98765, "pressure_hertz": 1.23456e9, "speed": 100.0}
    table = Table.from_records([{"oil": "a", **numbers}, {"oil": "b", **numbers}], vertical=vertical)
    text = printed(table, width)
    assert all(len(line) <= width for line in text.splitlines())
    # every number that is shown is shown whole
    words = {word.strip(".;,:") for word in text.split() if word[0].isdigit()} - {str(width)}
    assert words <= {"250.0", "98.765", "1.235", "954.9"}
    assert "250.0" in words


def test_vertical_table_gives_each_quantity_its_line_and_unit() -> None:
    table = Table(["member", "pitch_angle", "face_width"], [("pinion", 0.4, 0.02), ("gear", 1.1, None)], vertical=True)
    assert table.csv() == "quantity,pinion,gear,unit\npitch_angle,0.4,1.1,rad\nface_width,0.02,,m\n"
    assert "pitch angle   22.92  63.03  deg" in printed(table, 60)
    one = Table(["power_loss", "oil"], [(12.0, "a")], vertical=True)
    assert one.csv() == "quantity,value,unit\npower_loss,12.0,W\noil,a,\n"


def test_columns_may_hold_another_quantity_under_their_name(tmp_path: Path) -> None:
    assert "[N\xa0m]" in Table(["torque"], [(1.0,)]).html()
    table = Table([Column("E", of="misalignment.E", label="offset"), Column("share", of="largest")], [(1e-3, 0.05)])
    assert table.csv().splitlines()[0] == "E [m],share"
    assert "offset [mm]" in table.html()
    with pytest.raises(ValueError, match="rows of 2 cells"):
        Table(["a", "b"], [(1,)])
    assert [path.name for path in write_csv(tmp_path / "new", [Table(["a"], [], name="a/b c")])] == ["a_b_c.csv"]


KINDS = (NoteKind("teeth yield", "fault"), NoteKind("edges carry", "warning"), NoteKind("safety", "warning", low=True))


def figure() -> Figure:
    drawn = Figure()
    axes = drawn.add_subplot()
    axes.plot([0.2, 0.7], [0, 1])
    axes.set_xscale("log")
    return drawn


class Result(Reportable):
    def sections(self, medium: Medium = "page") -> list[Section]:
        table = Table(["name", "value"], [["x", "1"], ["y", "2"]], "cap", ["a note"], "numbers", highlight=1)
        if medium != "page":
            return [Section("", [Head("Title"), table, Notes([Note("warning", "hot")])])]
        many = [Note("warning", f"note {k} at 90 degC", 2, f"{k} N m") for k in range(5)]
        answer = MainResult("99.1 %", "efficiency", [("98 to 99.5 %", "interval")])
        row = Row([Picture(figure, "a line", "line"), Picture(figure, "another")])
        return [
            Section("", [Head("Title & more", "subtitle", "footer"), answer, KeyFigures([("5 W", "loss")])]),
            Section("One", [Text("a < b"), Folded("The formula", [Code("mu = 0.05")]), Notes(many, cases=7)]),
            Section("Two", [table, row, Row([Text("left"), Text("right")])]),
        ]

    def to_dict(self) -> dict[str, Any]:
        return {"x": 1}

    def _plot(self, ax: Axes | None, **options: Any) -> Axes:
        return figure().axes[0] if ax is None else ax


def test_page_holds_everything_and_escapes(tmp_path: Path) -> None:
    page = read_page(Result().report(tmp_path / "sub" / "page.html"))
    assert page.sections[0].startswith("99.1 % efficiency 98 to 99.5 % interval 5 W loss")
    assert "1. One 2. Two" in page.sections[0]
    for part in ("Title & more", "a < b", "mu = 0.05", "cap", "a line", "footer", "2 further notes"):
        assert part in page.text
    # units typeset, each note with its count and the worst case
    assert "note 4 at 90 °C 2 of 7; worst: 4 N m" in page.sections[1]
    assert 'class="highlight"' in page.source
    assert page.source.count("<svg") == 2


def test_suffix_chooses_the_kind_of_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = Result()
    assert json.loads(result.report(tmp_path / "r.json").read_text()) == {"x": 1}
    assert result.report(tmp_path / "r.csv").read_text() == "name,value\nx,1\ny,2\n"
    book = load_workbook(result.report(tmp_path / "r.xlsx"))
    assert book.sheetnames == ["about", "numbers", "notes"]
    assert book["about"]["B1"].value == "Title"
    places = {"report": "p.html", "xlsx": "p.xlsx", "csv": "tables", "plot": "figures"}
    written = result.write(**{name: tmp_path / place for name, place in places.items()})
    assert [path.name for path in written] == list(places.values())
    # a picture without name is part of the page alone
    assert [path.name for path in (tmp_path / "figures").iterdir()] == ["line.png"]
    assert {path.name for path in (tmp_path / "tables").iterdir()} == {"numbers.csv", "notes.csv"}
    assert result.figure("line").axes
    result.write(plot=tmp_path / "main.svg")
    assert "<svg" in (tmp_path / "main.svg").read_text(encoding="utf-8")
    (tmp_path / "file").write_text("")
    for place in ("r.doc", "file/page.html"):
        with refuses("report"):
            result.report(tmp_path / place)
    with refuses("report"):
        result.write(report=tmp_path / "r.xlsx")
    with refuses("figure"):
        result.figure("nothing")
    result.show()
    assert "hot" in capsys.readouterr().out


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
    assert [(note.grade, note.count) for note in notes] == [("fault", 1), *[("warning", 2)] * 3]
    assert [said.index((note.where, note.text)) for note in notes] == [6, 1, 4, 3]  # the worst of each kind
    assert notes_table(notes, 4).rows[1][1:3] == ("2 of 4", "90 N m")
    # of cases with equal notes none is the worst
    (same,) = group_notes([(f"model {letter}", "the same, in 2007") for letter in "cab"])
    assert (same.count, same.where) == (3, "model c; model a; ...")
    assert notes_table([same], 3).rows == (("warning", "all", None, "the same, in 2007"),)
    assert group_notes([], KINDS) == []
