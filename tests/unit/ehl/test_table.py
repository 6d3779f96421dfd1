"""One table in every form: hostile words stay words, numbers keep their digits, files are SI."""

import csv
import html
import io
import json
import re
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from ehl.common.pages import write_csv, write_workbook
from ehl.common.sections import Head, Section
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


def test_terminal_shows_words_as_they_are_and_obeys_none() -> None:
    text = printed(TABLE, 200)
    for word in HOSTILE[:-1]:
        assert word in text
    assert "\x1b" not in text.replace("\x1b[3m", "").replace("\x1b[0m", "")
    assert "[/title] <i>" in text
    assert "note [/n] <u>" in text


def test_page_escapes_words() -> None:
    page = TABLE.html()
    assert set(re.findall(r"<(\w+)", page)) <= {"table", "caption", "span", "thead", "tbody", "tr", "th", "td", "p"}
    cells = [re.findall(r"<t[hd].*?>(.*?)</t[hd]>", row) for row in page.split("<tr")[1:]]
    head, first, *others = ([html.unescape(re.sub("<.*?>", "", cell)) for cell in row] for row in cells)
    assert head == ["oil", "central film thickness [nm]", "efficiency [%]", "oil temperature [°C]"]
    assert [row[0] for row in (first, *others)] == HOSTILE
    assert first[1:] == ["250.0", "98.765", "80.00"]


def test_csv_is_si_and_computes_nothing() -> None:
    rows = list(csv.reader(io.StringIO(TABLE.csv())))
    assert rows[0] == ["oil", "film_central [m]", "efficiency", "temperature_oil [K]"]
    for row, word in zip(rows[1:], HOSTILE, strict=True):
        assert row[0] == (f"'{word}" if word[0] in "=+-@" else word)
        assert float(row[3]) == 353.15
    assert [float(row[1]) for row in rows[1:]] == [record["film_central"] for record in TABLE.records()]


def test_workbook_is_in_display_units_and_computes_nothing(tmp_path: Path) -> None:
    from openpyxl import load_workbook

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
    assert json.loads(json.dumps(table.records(), allow_nan=False)) == [
        {"oil": "a", "film_central": 1e-7},
        {"oil": "b", "film_central": None},
        {"oil": "c", "film_central": 0},
    ]
    assert list(table.to_frame().columns) == ["oil", "film_central"]


@pytest.mark.parametrize("width", [8, 15, 29, 50, 78, 113])
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
    if "954.9" not in words:
        assert "pinionspeed[rpm]" in "".join(text.split())


def test_vertical_table_gives_each_quantity_its_line_and_unit() -> None:
    table = Table(["member", "pitch_angle", "face_width"], [("pinion", 0.4, 0.02), ("gear", 1.1, None)], vertical=True)
    assert table.csv() == "quantity,pinion,gear,unit\npitch_angle,0.4,1.1,rad\nface_width,0.02,,m\n"
    assert "pitch angle   22.92  63.03  deg" in printed(table, 60)
    one = Table(["power_loss", "oil"], [(12.0, "a")], vertical=True)
    assert one.csv() == "quantity,value,unit\npower_loss,12.0,W\noil,a,\n"


def test_columns_may_hold_another_quantity_under_their_name(tmp_path: Path) -> None:
    table = Table([Column("E", of="misalignment.E", label="offset"), Column("share", of="largest")], [(1e-3, 0.05)])
    assert table.csv().splitlines()[0] == "E [m],share"
    assert "offset [mm]" in table.html()
    assert "5.00" in table.html()
    assert [path.name for path in write_csv(tmp_path / "new", [Table(["a"], [], name="a/b c")])] == ["a_b_c.csv"]


def test_rows_of_another_length_are_refused() -> None:
    with pytest.raises(ValueError, match="rows of 2 cells"):
        Table(["a", "b"], [(1,)])
