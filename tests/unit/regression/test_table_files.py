"""Tables of users: units in header or cells, spreadsheets, and errors that name row and column."""

import sys
from pathlib import Path

import pytest
from refusals import refuses

from ehl.common.errors import InputError
from ehl.common.table_reader import read_table
from ehl.common.units import ValueRange
from regression.plan.plan import QUANTITIES, Plan

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


def test_the_same_table_in_a_spreadsheet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from openpyxl import Workbook

    from_csv = plan_with(tmp_path, POINTS)
    book = Workbook()
    for row in (line.split(",") for line in POINTS.splitlines()):
        book.active.append([float(c) if c.replace(".", "").isdigit() else c for c in row])
    book.save(tmp_path / "points.xlsx")
    (tmp_path / "plan.toml").write_text(PLAN.replace("points.csv", "points.xlsx"))
    assert Plan.from_file(tmp_path / "plan.toml").plan_hash == from_csv.plan_hash
    (tmp_path / "points.xlsx").write_text("no spreadsheet")
    with pytest.raises(InputError):
        Plan.from_file(tmp_path / "plan.toml")
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(InputError):
        read_table(tmp_path / "points.xlsx", {})


COLUMNS = """
pressure_hertz = ["1.2 GPa", "0.8 GPa"]
radius_equivalent = [0.01, 0.02]
speed_entrainment = [5, 2.5]
slide_to_roll = [0.3, 0.1]
oil = ["fva3", "75w90"]
"""


def test_columns_in_the_plan_and_oils_by_row(tmp_path: Path) -> None:
    plan = plan_with(tmp_path, "", PLAN.replace('file = "points.csv"', COLUMNS).replace('oil = "fva3"', ""))
    assert [case.lubricant.oil for _, case in plan.cases()] == ["fva3", "75w90"] * 2


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        ("slide_to_roll", "slide_to_rol", "table.points.csv, header"),
        (",slide_to_roll,", ",# slip,", "variables.slide_to_roll"),
        ("0.8,", "high,", "table.points.csv, row 3, pressure_hertz"),
        ("0.8,", ",", "table.points.csv, row 3, pressure_hertz"),
        ("0.8,", "8e3,", "table.points.csv, row 3, pressure_hertz"),
        ("2.5 m/s", "2.5 mm", "table.points.csv, row 3, speed_entrainment"),
        (",slide_to_roll", ",speed_entrainment", "table.points.csv, header"),
        (POINTS, "", "table.points.csv"),
        (POINTS, POINTS.splitlines()[0], "table.points.csv"),
    ],
)
def test_bad_tables_name_row_and_column(tmp_path: Path, old: str, new: str, field: str) -> None:
    with refuses(field):
        plan_with(tmp_path, POINTS.replace(old, new, 1))


CONDITIONS = {"load": ValueRange("N", gt=0.0), "speed_entrainment": ValueRange("m/s"), "slide_to_roll": ValueRange("")}
MTM = """MTM Test Data File
Test file\tC:\\data\\run1.txt
Step 1 "Traction"\tstarted at 10:00
Step type\tTraction
Rolling Speed (mm/s)\tSliding Speed (mm/s)\tPot Temp (°C)\tLube Temp (°C)\tBall Load (N)\tSRR (%)
2000.1\t20.0\t80.2\t79.9\t36.02\t1
2000.1\t40.0\t80.2\tBad\t36.02\t2
Step 2 "Traction"
SRR (%)\tRolling Speed (mm/s)\tBall Load (N)\tLube Temp (°C)
5\t1000\t20\t60
All steps completed
"""


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("decimal", [".", ","])
def test_an_export_of_a_test_rig(tmp_path: Path, encoding: str, decimal: str, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO", "mixed_ehl")
    (tmp_path / "run.txt").write_bytes(MTM.replace(".", decimal).replace("\n", "\r\n").encode(encoding))
    quantities = CONDITIONS | {"temperature_oil": ValueRange("K", gt=200.0)}
    found, numbers = read_table(tmp_path / "run.txt", quantities, tuple(quantities), missing=True)
    assert numbers == (6, 10)
    assert found["load"] == pytest.approx((36.02, 20.0))
    assert found["speed_entrainment"] == pytest.approx((2.0001, 1.0))
    assert found["slide_to_roll"] == pytest.approx((0.01, 0.05))
    assert found["temperature_oil"] == pytest.approx((353.05, 333.15))
    assert "Ball Load -> load" in caplog.text


@pytest.mark.parametrize(
    "text",
    [
        "u_e / m/s;F_N N;SRR / %\n2,5;1.234,5;10\n",
        "Normal Load [kN]\tMean speed [km/h]\tSlip (%)\n1.2345\t9\t10\n",
        "Load(kN) Rolling_Speed(mm/s) SRR(%)\n1.2345 2500 10\n",
        "Ball Load (N)   Rolling Speed (mm/s)   SRR %\n1234.5          2500                   10\n",
        "load,speed_entrainment,slide_to_roll\nkN,m/s,%\n1.2345,2.5,10\n-999,2.5,10\n1,n/a,10\n2,2.5,10\n3,2.5,10\n",
        # statistics and tables below the data, dates, quotes, empty cells at the end, units behind an underscore
        "load_kN,speed_entrainment_mm/s,slide_to_roll\n1.2345,2500,0.1\nMean,1,2500,0.1\n",
        "load [N],speed_entrainment [m/s],slide_to_roll\n1234.5,2.5,0.1\nMean,2,0.2\nSD,1,0.1\n",
        "load [N],speed_entrainment [m/s],slide_to_roll\n1234.5,2.5,0.1\n\nname,value\nmean,3\n",
        '"load [N]","speed_entrainment [m/s]","slide_to_roll"\n"1234,5","2,5","0,1"\n',
        "Datum;Normalkraft [N];Rolling speed (m/s);Schlupf [%]\n12.03.2024;1234,5;2,5;10\nMittelwert;1;1;1\n",
        "load [N],speed_entrainment [m/s],slide_to_roll\n1'234.5,2.5 m/s,0.1\n",
        "load [N];speed_entrainment [m/s];slide_to_roll;;\n1234,5;−2,5;−0,1;;\n",
    ],
)
def test_heads_and_numbers_of_other_programs(tmp_path: Path, text: str) -> None:
    (tmp_path / "t.csv").write_bytes(text.encode("cp1252" if text.isascii() else "utf-8"))
    found, _ = read_table(tmp_path / "t.csv", CONDITIONS, tuple(CONDITIONS), missing="n/a" in text)
    assert [abs(found[name][0]) for name in CONDITIONS] == pytest.approx([1234.5, 2.5, 0.1])  # type: ignore[arg-type]
    assert len(found["load"]) == (3 if "n/a" in text else 1)


@pytest.mark.parametrize(
    "text",
    [
        "load [N];speed_entrainment [m/s];slide_to_roll\n1.500;2,5;0,1\n",  # 1.5 or 1500?
        "load [N];speed_entrainment [m/s];slide_to_roll\n1,500;2.5;0.1\n",
        "load [N],speed_entrainment [m/s],slide_to_roll\n1,500,2.5,0.1\n",
        "load [N],speed_entrainment [m/s],slide_to_roll\n1500,-999,0.1\n",  # a value, or none?
        "load [N],speed_entrainment [m/s],slide_to_roll\n-999,2.5,0.1\n-999,2.5,0.2\n1,2.5,0.3\n",  # most are missing
    ],
)
def test_what_may_mean_two_things_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(InputError):
        read_table(tmp_path / "t.csv", CONDITIONS, tuple(CONDITIONS), missing=True)


HEADER = "pressure_hertz,radius_equivalent,speed_entrainment,slide_to_roll"


@pytest.mark.parametrize(
    ("lines", "wanted"),
    [
        ([HEADER, "1e9,0.01,5,wrong"], 2),
        ([HEADER, "GPa,mm,m/s,1", "1,10,5,wrong"], 3),
        (["# a rig", "", HEADER, "", "GPa,mm,m/s,1", "1,10,5,0.3", "# a note", "1,10,5,wrong"], 8),
        (["#notes," + HEADER, '"two\nlines",1e9,0.01,5,0.3', "x,1e9,0.01,5,wrong"], 4),
    ],
)
def test_rows_are_counted_as_in_the_file(tmp_path: Path, lines: list[str], wanted: int) -> None:
    with refuses(f"table.points.csv, row {wanted}, slide_to_roll"):
        plan_with(tmp_path, "\n".join(lines))


def test_bare_numbers_can_be_refused_and_columns_required(tmp_path: Path) -> None:
    (tmp_path / "points.csv").write_text(POINTS)
    for name, field, options in (
        ("points.csv", "column speed_entrainment", {"bare": False}),
        ("points.csv", "temperature_oil", {"required": ("pressure_hertz", "temperature_oil")}),
        ("none.csv", "", {}),
    ):
        with pytest.raises(InputError) as caught:
            read_table(tmp_path / name, QUANTITIES, **options)
        assert field in caught.value.field


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("", "file"),
        (PLAN.replace('roughness_rms = "0.4 um"', "pressure_hertz = 1e9"), "variables.pressure_hertz"),
        (PLAN.replace('"0.4 um"', '{ low = "0.1 um", high = "0.4 um" }'), "variables.roughness_rms"),
        (PLAN.replace('file = "points.csv"', 'file = "points.csv"\nslide_to_roll = [1]'), "table.file"),
        (PLAN.replace('file = "points.csv"', "slide_to_roll = [1, 2]\npressure_hertz = [1e9]"), "table.slide_to_roll"),
        (PLAN.replace('file = "points.csv"', "slide_to_roll = []"), "table.slide_to_roll"),
    ],
)
def test_bad_plans_with_tables(tmp_path: Path, text: str, field: str) -> None:
    with refuses(field):
        plan_with(tmp_path, POINTS, text)
