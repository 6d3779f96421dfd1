"""Machine summaries and setting sheets: read into tables of a design file, written and read back."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from refusals import refuses

from efficiency.cutting.summary import parse_summary, read_summary
from efficiency.design.design import MemberInput, bevel_names, load_design
from efficiency.output.machine_summary import design_from_sheet, sheet_text
from ehl.common.errors import InputError

# gear of the Gleason sheet 74782608 (meshingwithgears.com/cpchyp16.html), typed off as an operator would
SHEET = """
# No. 16, spread blade
units, inch
member, gear
teeth, 41
Hand of spiral, RH
Pitch angle, 74.8167
Face angle, 75d59m
root angle, 69.1167
Outer cone distance, 4.274
Face width, 1.25
Addendum, 0.064
Whole depth, 0.422
Pitch apex beyond crossing point, -0.2354
Cutter type, face milling
Cutter diameter, 9.0
Point width, 0.09
Edge radius, 1.016 mm
Outside blade angle, 24.5
Inside blade angle, 18.0
Process, generated
Machine root angle, 69.1167
Machine center to back, -0.24
Sliding base, with 0.07
Blank offset, 0.225 down
Radial distance, 4.108
Cradle angle, 67.1833
NC/75, 0.545665
Gear fixture, 74-12
"""


def test_a_sheet_becomes_a_member(tmp_path: Path) -> None:
    file = tmp_path / "gear.txt"
    file.write_text(SHEET, encoding="utf-8")
    summary = read_summary(file)
    assert summary.unread == ("Gear fixture, 74-12",)
    tables = tomllib.loads(summary.toml())
    assert tables == summary.tables
    # numbers stay as the sheet has them
    assert tables["gear"]["machine"]["radial_setting"] == "4.108 in"
    member = MemberInput.model_validate(tables["gear"])
    assert member.completing
    inch = 0.0254
    cutter, machine = member.concave.cutter, member.concave.machine
    assert cutter.blade("concave", "right").point_radius == pytest.approx(4.545 * inch)
    assert member.convex.cutter.blade("convex", "right").point_radius == pytest.approx(4.455 * inch)  # type: ignore[union-attr]
    assert (cutter.blade_angle, member.convex.cutter.blade_angle) == pytest.approx((np.radians(24.5), np.radians(18.0)))  # type: ignore[union-attr]
    assert cutter.edge_radius == pytest.approx(1.016e-3)
    assert machine.roll_ratio == pytest.approx(75.0 * 0.545665 / 41.0, rel=1e-9)
    assert machine.blank_offset == pytest.approx(0.225 * inch)
    assert machine.sliding_base == pytest.approx(0.07 * inch)
    blank = member.blank
    assert np.degrees(blank.addendum_angle) == pytest.approx(75.0 + 59.0 / 60.0 - 74.8167, abs=1e-9)
    assert np.degrees(blank.dedendum_angle) == pytest.approx(5.7, abs=1e-9)
    assert blank.mean_cone_distance == pytest.approx((4.274 - 0.625) * inch, rel=1e-9)
    # depths of the sheet at the heel come back
    heel = np.array([0.5 * blank.face_width])
    assert blank.tip(heel)[0] == pytest.approx(0.064 * inch, rel=1e-9)
    assert (blank.tip(heel) - blank.root(heel))[0] == pytest.approx(0.422 * inch, rel=1e-9)


def test_formate_member_of_a_left_hand_in_millimetres() -> None:
    head = "units: mm\nmember: gear\nhand: left\nprocess: formate\nhorizontal: 30\nvertical: 40\n"
    cutter = "cutter type: face hobbing\ncutter radius: 76\nblade groups: 13\nblade offset angle: 20.1507\n"
    outside = "flank: outside blade\nblade angle: 24.1269\nblade radius: 500\nblade phase: 8.9\n"
    inside = "flank: inside blade\nblade angle: 15.8731\ntoprem height: 1.2\ntoprem radius: 20\n"
    summary = parse_summary(head + cutter + outside + inside)
    gear = summary.tables["gear"]
    assert (gear["machine"]["process"], gear["machine"]["radial_setting"]) == ("formate", "50.0 mm")
    assert float(gear["machine"]["cradle_angle"].split()[0]) == pytest.approx(-np.degrees(np.arctan2(4.0, 3.0)))
    assert (gear["cutter"]["type"], gear["cutter"]["blade_groups"]) == ("face_hobbing", 13)
    assert float(gear["concave"]["cutter"]["blade_curvature"].split()[0]) == pytest.approx(2.0)
    assert gear["convex"]["cutter"]["toprem"] == {"height": "1.2 mm", "radius": "20.0 mm"}
    assert not summary.unread


def test_cradle_angle_takes_its_sign_from_the_hand_and_test_rolls_give_the_ratio() -> None:
    for angle, hand, expected in ((293.0, "left", -67.0), (293.0, "right", 67.0), (67.0, "left", -67.0)):
        summary = parse_summary(f"member = pinion\nhand = {hand}\ncradle angle = {angle}")
        assert summary.tables["pinion"]["machine"]["cradle_angle"] == f"{expected!r} deg"
    tables = parse_summary("member, gear\ncradle test roll, 30\nwork test roll, 29.95").tables
    assert tables["gear"]["machine"]["roll_ratio"] == pytest.approx(29.95 / 30.0)


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("teeth, 41", "line 1"),
        ("member, gear\nradial, 4.1", "line 2 (radial)"),
        ("member, gear\nradial, 4.1 deg", "line 2 (radial)"),
        ("member, gear\nnc/75, 0.5", "gear: nc/75"),
        ("member, pinion\nteeth, inf", "line 2 (teeth)"),
    ],
)
def test_bad_lines_are_named(text: str, field: str) -> None:
    with refuses(field):
        parse_summary(text)


def test_two_values_of_a_setting_are_refused() -> None:
    parse_summary(SHEET + "radial setting, 4.108\n")
    with refuses(f"line {SHEET.count(chr(10)) + 1} (radial setting)"):
        parse_summary(SHEET + "radial setting, 4.18\n")


def test_missing_file(tmp_path: Path) -> None:
    with refuses("summary"):
        read_summary(tmp_path / "none.csv")


PAIR = "fm_spiral_bevel_14x39"
Cli = Callable[..., Any]


@pytest.mark.parametrize("units", ["metric", "inch"])
@pytest.mark.parametrize("name", bevel_names())
def test_sheet_of_every_shipped_design_is_read_back(name: str, units: Any, tmp_path: Path) -> None:
    design = load_design(name)
    sheet = tmp_path / "sheet.csv"
    sheet.write_text(sheet_text(design, units), encoding="utf-8")
    assert read_summary(sheet).unread == ()
    text, notes = design_from_sheet(sheet, name)
    assert notes == []
    path = tmp_path / "again.toml"
    path.write_text(text, encoding="utf-8")
    again = load_design(path)
    for member in ("pinion", "gear"):
        first, second = (pd.json_normalize(getattr(d, member).model_dump()) for d in (design, again))
        # angles pass through degrees with twelve digits
        pd.testing.assert_frame_equal(first, second, check_dtype=False, rtol=2e-11, atol=1e-15)
    assert again.operation == design.operation
    assert again.assembly == design.assembly


def test_a_sheet_as_papers_print_it(mixed_ehl: Cli, tmp_path: Path) -> None:
    """Zeros of a Formate gear, labels with units, decimal commas, cp1252; the hands are those of the other design."""
    base, sheet, output = load_design("fm_hypoid_13x42"), tmp_path / "sheet.csv", tmp_path / "again.toml"
    text = sheet_text(base, "metric")
    lines = ["Setting sheet, 20 \u00b0C"]
    for line in text.splitlines():
        label, _, value = (part.strip() for part in line.partition(","))
        if label == "cradle angle":
            value = str(abs(float(value)))
        label = {"radial setting": "Radial distance [mm]", "cradle angle": "Cradle angle (\u00b0)"}.get(label, label)
        if label != "hand":
            lines.append(f"{label};{value.replace('.', ',')};;" if label != "name" else line)
    for after in [k for k, line in enumerate(lines) if line.startswith("process;formate")][::-1]:
        lines[after + 1 : after + 1] = ["ratio of roll;0", "helical motion (mm/rad);0", "modified roll 2c;0"]
    sheet.write_bytes("\r\n".join(lines).encode("cp1252"))
    outcome = mixed_ehl("import", sheet, "-o", output, "--like", "fm_hypoid_13x42")
    assert outcome.code == 0, outcome.err
    again = load_design(output)
    for member in ("pinion", "gear"):
        for flank in ("concave", "convex"):
            first, second = (getattr(getattr(d, member), flank).machine for d in (base, again))
            assert second.radial_setting == pytest.approx(first.radial_setting, rel=1e-9)
            assert second.cradle_angle == pytest.approx(first.cradle_angle, rel=1e-9)
    sheet.write_text("\n".join(line.replace("ratio of roll;0", "ratio of roll;3") for line in lines), encoding="utf-8")
    assert mixed_ehl("import", sheet, "-o", output, "--like", "fm_hypoid_13x42").code == 2


def test_all_lines_that_cannot_be_used_are_reported_together() -> None:
    with pytest.raises(InputError) as caught:
        parse_summary("member, gear\nteeth, 41.5\nradial [deg], 90\nhand, middle")
    assert [problem.field for problem in caught.value.problems] == ["line 2 (teeth)", "line 3", "line 4 (hand)"]
