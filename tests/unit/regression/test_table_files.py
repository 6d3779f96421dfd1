"""Tables users bring: units in header or cells, spreadsheets, and complaints that name row and column."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from ehl.common.errors import InputError
from ehl.common.table_reader import read_table
from regression.plan.plan import Plan

PLAN = """
name = "table"
[table]
file = "points.csv"
[variables]
temperature_oil = ["60 degC", "90 degC"]
roughness_rms = "0.4 um"
[lubricant]
oil = "fva3"
"""
POINTS = """pressure_hertz [GPa],radius_equivalent (mm),speed_entrainment,slide_to_roll,# who
1.2,10,5,0.3,test rig
0.8,20,2.5 m/s,0.1,gear
"""


def plan_with(folder: Path, points: str, text: str = PLAN) -> Plan:
    (folder / "points.csv").write_text(points, encoding="utf-8")
    (folder / "plan.toml").write_text(text)
    return Plan.from_file(folder / "plan.toml")


def test_points_of_a_table_cross_the_lists(tmp_path: Path) -> None:
    plan = plan_with(tmp_path, POINTS)
    assert plan.count == len(plan.points) == 4
    assert set(plan.points.origin) == {"table"}
    cases = [case for _, case in plan.cases()]
    assert [c.contact.pressure_hertz for c in cases] == pytest.approx([1.2e9, 0.8e9] * 2)
    assert [c.contact.radius_equivalent for c in cases] == pytest.approx([0.01, 0.02] * 2)
    assert [c.contact.speed_entrainment for c in cases] == [5.0, 2.5] * 2
    assert [c.lubricant.temperature_oil for c in cases] == pytest.approx([333.15] * 2 + [363.15] * 2)


@pytest.mark.parametrize(
    "points",
    [
        POINTS.replace(",", ";").replace("1.2;", "1,2;").replace("0.8;", "0,8;").replace("0.3;", "0,3;"),
        "\ufeff" + POINTS.replace(",", "\t"),
        # units in a row of their own, as `sweep merge` writes them
        "pressure_hertz,radius_equivalent,speed_entrainment,slide_to_roll\nGPa,mm,m/s,1\n1.2,10,5,0.3\n0.8,20,2.5,0.1\n",
    ],
)
def test_dialects(tmp_path: Path, points: str) -> None:
    assert plan_with(tmp_path, points).plan_hash == plan_with(tmp_path, POINTS).plan_hash


def test_the_same_table_in_a_spreadsheet(tmp_path: Path) -> None:
    from openpyxl import Workbook

    from_csv = plan_with(tmp_path, POINTS)
    book = Workbook()
    for row in (line.split(",") for line in POINTS.splitlines()):
        book.active.append([float(c) if c.replace(".", "").isdigit() else c for c in row])
    book.save(tmp_path / "points.xlsx")
    (tmp_path / "plan.toml").write_text(PLAN.replace("points.csv", "points.xlsx"))
    assert Plan.from_file(tmp_path / "plan.toml").plan_hash == from_csv.plan_hash
    (tmp_path / "points.xlsx").write_text("no spreadsheet")
    with pytest.raises(InputError, match=r"points\.xlsx.*readable XLSX"):
        Plan.from_file(tmp_path / "plan.toml")


def test_a_spreadsheet_without_its_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    (tmp_path / "points.xlsx").write_bytes(b"")
    with pytest.raises(InputError, match=r"pip install \"mixed-ehl\[excel\]\""):
        read_table(tmp_path / "points.xlsx", {})


def test_columns_in_the_plan_and_oils_by_row(tmp_path: Path) -> None:
    text = PLAN.replace('file = "points.csv"', COLUMNS).replace('oil = "fva3"', "")
    plan = plan_with(tmp_path, "", text)
    assert [case.lubricant.oil for _, case in plan.cases()] == ["fva3", "75w90"] * 2
    assert plan.oils == ("fva3", "75w90")


COLUMNS = """
pressure_hertz = ["1.2 GPa", "0.8 GPa"]
radius_equivalent = [0.01, 0.02]
speed_entrainment = [5, 2.5]
slide_to_roll = [0.3, 0.1]
oil = ["fva3", "75w90"]
"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("slide_to_roll", "slip", ["header", "slip", "slide_to_roll", "'#'"]),
        (",slide_to_roll,", ",# slip,", ["variables.slide_to_roll is missing", "column of [table]"]),
        ("0.8,", "high,", ["points.csv, row 3, pressure_hertz", "high", "GPa"]),
        ("0.8,", ",", ["points.csv, row 3, pressure_hertz is missing", "empty"]),
        ("0.8,", "8e3,", ["points.csv, row 3, pressure_hertz", "at most"]),
        ("2.5 m/s", "2.5 mm", ["row 3, speed_entrainment", "2.5 mm", "dimension"]),
        (",slide_to_roll", ",speed_entrainment", ["each column once"]),
        (POINTS, "", ["no rows", "a header"]),
        (POINTS, POINTS.splitlines()[0], ["at least one row"]),
        ("0.8,", "nan,", ["row 3", "finite"]),
        ("0.8,20", "30,20", ["pressure_hertz", "at most"]),
    ],
)
def test_bad_tables_name_row_and_column(tmp_path: Path, old: str, new: str, words: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        plan_with(tmp_path, POINTS.replace(old, new, 1))
    for word in words:
        assert word in str(caught.value)


HEADER = "pressure_hertz,radius_equivalent,speed_entrainment,slide_to_roll"


@pytest.mark.parametrize(
    ("lines", "wanted"),
    [
        ([HEADER, "1e9,0.01,5,wrong"], 2),
        ([HEADER, "GPa,mm,m/s,1", "1,10,5,wrong"], 3),
        (["# a rig", "", HEADER, "", "GPa,mm,m/s,1", "1,10,5,0.3", "# a note", "1,10,5,wrong"], 8),
        # a cell with a line break
        (["#notes," + HEADER, '"two\nlines",1e9,0.01,5,0.3', "x,1e9,0.01,5,wrong"], 4),
    ],
)
def test_rows_are_counted_as_in_the_file(tmp_path: Path, lines: list[str], wanted: int) -> None:
    with pytest.raises(InputError, match=rf"points\.csv, row {wanted}, slide_to_roll"):
        plan_with(tmp_path, "\n".join(lines))


def test_bare_numbers_can_be_refused_and_columns_required(tmp_path: Path) -> None:
    from regression.plan.plan import QUANTITIES

    path = tmp_path / "points.csv"
    path.write_text(POINTS)
    with pytest.raises(InputError, match=r"row 2, speed_entrainment = '5'.*unit.*ambiguous"):
        read_table(path, QUANTITIES, bare=False)
    with pytest.raises(InputError, match=r"column temperature_oil is missing"):
        read_table(path, QUANTITIES, ("pressure_hertz", "temperature_oil"))
    with pytest.raises(InputError, match=r"existing CSV"):
        read_table(tmp_path / "none.csv", QUANTITIES)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["plan.toml", "[variables]", "docs/sweep.md"]),
        (PLAN.replace('roughness_rms = "0.4 um"', "pressure_hertz = 1e9"), ["pressure_hertz", "[table]"]),
        (PLAN.replace('"0.4 um"', '{ low = "0.1 um", high = "0.4 um" }'), ["roughness_rms", "lists and values"]),
        (PLAN.replace('file = "points.csv"', 'file = "points.csv"\nslide_to_roll = [1]'), ["either a file"]),
        (PLAN.replace('file = "points.csv"', "slide_to_roll = [1, 2]\npressure_hertz = [1e9]"), ["one length"]),
        (PLAN.replace('file = "points.csv"', "slip = [1, 2]"), ["table.slip", "columns named"]),
        (PLAN.replace('file = "points.csv"', "slide_to_roll = []"), ["slide_to_roll", "list of 1 to"]),
    ],
)
def test_bad_plans_with_tables(tmp_path: Path, text: str, words: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        plan_with(tmp_path, POINTS, text)
    for word in words:
        assert word in str(caught.value)
