"""Design files: fields, cutters, machines, other ways to give a flank; machine summaries and setting sheets."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from refusals import fails, refuses

from efficiency.contact.conjugate import ConjugateFlank
from efficiency.contact.flank_pair import flank_pair
from efficiency.contact.grid_flank import SmoothFlank
from efficiency.contact.tooth_grid import tooth_shapes
from efficiency.cutting.summary import parse_summary, read_summary
from efficiency.design.design import Design, MemberInput, bevel_names, load_design
from efficiency.output.files import inspection_grid, write_inspection_grid
from efficiency.output.machine_summary import design_from_sheet, sheet_text
from ehl.common.data import data_path
from ehl.common.errors import InputError

SHIPPED = data_path("designs", "fm_spiral_bevel_14x39.toml").read_text(encoding="utf-8")
HEAD, _, _GEAR_CUT = SHIPPED.partition("[gear.concave.cutter]")
# the gear of the shipped pair once more, as a spread-blade cutter in one machine setting, partly in inches
COMPLETING = f"""{HEAD}
[gear.cutter]
type = "face_milling"
cutter_radius = "4.5 in"
point_width = "2.20026 mm"
edge_radius = "0.04 in"

[gear.machine]
process = "generated"
radial_setting = "94.85354936012699 mm"
cradle_angle = "1.4099427556430841 rad"
machine_root_angle = "1.1128166950838285 rad"
roll_ratio = 1.05566307882317
sliding_base = "3.5883797953689816 mm"

[gear.concave.cutter]
blade_angle = "0.2840607379613066 rad"

[gear.convex.cutter]
blade_angle = "0.4140709628364252 rad"
"""
HOBBED = f"""{HEAD}
[gear.cutter]
type = "face_hobbing"
cutter_radius = "3.25 in"
blade_groups = 13
blade_offset_angle = "18 deg"
reference_height = "5.6 mm"
edge_radius = "0.9 mm"

[gear.machine]
process = "formate"
radial_setting = "94 mm"
cradle_angle = "50 deg"
machine_root_angle = "70.2532 deg"
sliding_base = "-5.6 mm"

[gear.concave.cutter]
blade_angle = "20 deg"
blade_phase = "9 deg"
toprem = {{ height = "1.5 mm", radius = "30 mm", angle = "3 deg" }}

[gear.convex.cutter]
blade_angle = "20 deg"
blade_phase = "-9 deg"
rake_angle = "4 deg"
hook_angle = "6 deg"
radius_offset = "0.1 mm"
flankrem = {{ height = "6 mm", radius = "200 mm" }}
"""


def load(folder: Path, text: str, *changes: tuple[str, str]) -> Design:
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    path = folder / "pair.toml"
    path.write_text(text, encoding="utf-8")
    return load_design(path)


def test_shipped_design_by_name_and_by_path(tmp_path: Path) -> None:
    design = load_design("fm_spiral_bevel_14x39")
    assert design == load(tmp_path, SHIPPED)
    assert design.operation.temperature == pytest.approx(363.15)
    assert design.gear.convex.machine.radial_setting == pytest.approx(0.09485354936)  # type: ignore[union-attr]
    for side, expected in (("drive", ["concave", "convex"]), ("coast", ["convex", "concave"])):
        assert [flank.blade.side for flank in design.flanks().mating(side)] == expected


def test_tables_shared_by_both_flanks(tmp_path: Path) -> None:
    own, shared = load_design("fm_spiral_bevel_14x39"), load(tmp_path, COMPLETING)
    assert shared.gear.completing
    assert own.gear.completing
    assert not own.pinion.completing
    for side in ("concave", "convex"):
        one, other = own.gear.flank(side), shared.gear.flank(side)  # type: ignore[arg-type]
        assert other.machine == one.machine
        assert other.blade.point_radius == pytest.approx(one.blade.point_radius, rel=1e-12)
        assert other.blade.edge_radius == pytest.approx(1.016e-3)
        at = np.zeros(1)
        np.testing.assert_allclose(other.solve(at, at)[0].position, one.solve(at, at)[0].position, atol=1e-12)
    # entries of a flank take precedence
    own_machine = "[gear.convex.cutter]", '[gear.convex.machine]\nblank_offset = "1 mm"\n[gear.convex.cutter]'
    assert not load(tmp_path, COMPLETING, own_machine).gear.completing
    # a design that was read can be written and read again
    assert Design.model_validate(shared.model_dump()) == shared


def test_face_hobbed_formate_gear(tmp_path: Path) -> None:
    design = load(tmp_path, HOBBED)
    concave, convex = design.gear.flank("concave"), design.gear.flank("convex")
    assert not concave.machine.generation.rolls
    assert concave.index_ratio == pytest.approx(13.0 / 39.0)
    assert concave.index_zero == convex.index_zero
    assert concave.blade.point_radius == pytest.approx(0.08255)
    assert np.degrees(concave.blade.offset_angle) == pytest.approx(18.0)
    assert len(concave.blade.profile.breaks) == 2
    assert (np.degrees(convex.blade.rake), np.degrees(convex.blade.hook)) == pytest.approx((4.0, 6.0))
    assert np.degrees(convex.blade.phase) == pytest.approx(-9.0)


def test_point_radius_belongs_to_the_tip_plane(tmp_path: Path) -> None:
    """A reference height changes where a curved edge has its angle, not where the tangent meets the tip plane."""
    text = COMPLETING.replace('edge_radius = "0.04 in"', 'reference_height = "4 mm"')
    for side, sign in (("concave", 1.0), ("convex", -1.0)):
        blade = load(tmp_path, text).gear.flank(side).blade  # type: ignore[arg-type]
        at_tip = blade.edge(np.zeros(1))[0][:, 0]
        np.testing.assert_allclose(at_tip, [0.1143 + sign * 0.00110013, 0.0, 0.0], atol=1e-15)


WIDTH, TOPREM = 'point_width = "2.20026 mm"', 'toprem = { height = "1.5 mm", radius = "30 mm", angle = "3 deg" }'
CRADLE = 'cradle_angle = "1.4099427556430841 rad"'
MISTAKES = [
    (COMPLETING, WIDTH, "", "concave.cutter.point_radius"),
    (COMPLETING, WIDTH, 'point_radius = "1 in"', "concave.cutter.point_radius"),
    (COMPLETING, WIDTH, 'point_width = "0.5 m"', "concave.cutter.point_width"),
    (COMPLETING, 'cutter_radius = "4.5 in"', 'cutter_radius = "1 mm"', "concave.cutter.point_width"),
    (COMPLETING, '[gear.machine]\nprocess = "generated"', '[gear.machine]\nprocess = "formate"',
     "concave.machine.roll_ratio"),
    (COMPLETING, CRADLE, 'cradle_angle = "-1.4 rad"', "concave.machine.cradle_angle"),
    (HOBBED, "blade_groups = 13", "", "concave.cutter.blade_groups"),
    (HOBBED, '_offset_angle = "18 deg"', '_offset_angle = "80 deg"', "concave.cutter.blade_offset_angle"),
    (HOBBED, 'height = "1.5 mm"', 'height = "0.5 mm"', "concave.cutter.edge_radius"),
    (HOBBED, "flankrem = {", 'toprem = { height = "7 mm", radius = "9 mm" }\nflankrem = {',
     "convex.cutter.flankrem.height"),
    (HOBBED, 'blade_phase = "9 deg"', 'protuberance = { height = "2 mm", amount = "0.1 mm", radius = "1 mm" }',
     "concave.cutter.protuberance"),
    (HOBBED, "toprem = {", 'protuberance = { amount = "0.1 mm",', "concave.cutter.protuberance.angle"),
    (HOBBED, TOPREM, 'protuberance = { height = "1.5 mm", amount = "0.1 mm", radius = "30 mm" }',
     "concave.cutter.protuberance.radius"),
    (HOBBED, TOPREM, 'protuberance = { height = "1.5 mm", amount = "0.5 mm", radius = "0.2 mm" }',
     "concave.cutter.protuberance.amount"),
    (HEAD + '[gear.concave]\nease_off = { twist = "5 um" }\n[gear.convex]\nease_off = {}', "", "", "concave.ease_off"),
]  # fmt: skip


RADIUS = 'point_radius = "114.47823644967657 mm"'
IN_SHIPPED = [
    (RADIUS, "point_radius = nan", "pinion.concave.cutter.point_radius"),
    ('face_width = "25.4 mm"', 'face_width = "180 mm"', "pinion.blank.face_width"),
    ('face_width = "25.4 mm"', 'face_width = "100 mm"', "pinion.blank.face_width"),  # no tooth left at the toe
    ('face_width = "25.4 mm"', 'face_width = "0.0254 mm"', "pinion.blank.face_width"),
    ("teeth = 14", "teeth = 41", "pinion.blank.teeth"),
    ('hand = "left"', 'hand = "right"', "pinion.concave.machine.cradle_angle"),
    ('process = "generated"', 'process = "hand filed"', "pinion.concave.machine.process"),
    ('type = "face_milling"', 'type = "face_hobbing"', "pinion.concave.cutter.cutter_radius"),
    ('type = "face_milling"', "", "pinion.concave.cutter.type"),
    ('torque = "300 N m"', 'torque = "-300 N m"', "operation.torque"),
    ("E = 0.0", 'E = "5 mm"', "assembly.misalignment.E"),
    ('shaft_angle = "90 deg"\n', "", "assembly.shaft_angle"),
]


@pytest.mark.parametrize(
    ("text", "old", "new", "field"),
    [*((*row, f"gear.{field}") for *row, field in MISTAKES), *((SHIPPED, *row) for row in IN_SHIPPED)],
)
def test_bad_input_names_its_field(tmp_path: Path, text: str, old: str, new: str, field: str) -> None:
    with refuses(field):
        load(tmp_path, text, (old, new))


def test_settings_that_cut_no_flank_are_refused_with_a_reason(tmp_path: Path) -> None:
    # a cradle twice as far out leaves the cutter outside the blank
    design = load(tmp_path, SHIPPED, ('radial_setting = "96.01838217906185 mm"', 'radial_setting = "300 mm"'))
    with fails("flank"):
        flank_pair(design.flanks(), "drive")


@pytest.mark.parametrize(("old", "new"), [("115.40012999999999 mm", "121 mm"), ("113.19987 mm", "107.5 mm")])
def test_flanks_that_cross_are_told_by_member_and_place(tmp_path: Path, old: str, new: str) -> None:
    with pytest.raises(InputError, match=r"(pinion|gear): tooth thickness at the (tip|root)"):
        tooth_shapes(load(tmp_path, SHIPPED, (old, new)).flanks())


def pinion_given(way: dict[str, str]) -> str:
    """The shipped pair with the pinion flanks given another way."""
    head, _, rest = SHIPPED.partition("[pinion.concave.cutter]")
    gear = "[gear]" + rest.partition("[gear]")[2]
    return head + "".join(f"[pinion.{side}]\n{text}\n\n" for side, text in way.items()) + gear


def test_pinion_given_by_points(tmp_path: Path) -> None:
    """A grid written of the shipped pinion and read again; file names count from the folder of the design file."""
    design = load_design("fm_spiral_bevel_14x39")
    own, sides, points = design.pinion.flank("concave"), ("concave", "convex"), tmp_path / "points"
    points.mkdir()
    write_inspection_grid(points / "concave.csv", design, "pinion", "concave", inspection_grid(own, 9, 17))
    measured = load(tmp_path, pinion_given({"concave": 'grid = "points/concave.csv"', "convex": "ease_off = {}"}))
    at, up = np.array([-8e-3, 0.0, 9e-3]), np.array([0.0, 1e-3, 3e-3])
    flank = measured.flank("pinion", "concave")
    assert isinstance(flank, SmoothFlank)
    np.testing.assert_allclose(flank.solve(at, up)[0].position, own.solve(at, up)[0].position, atol=2e-7)
    with refuses("pinion.concave.grid"):
        load(tmp_path, pinion_given(dict.fromkeys(sides, 'grid = "none.csv"')))
    # cutter and machine given with a grid are its nominal flank, which must be complete
    with refuses("pinion.concave.cutter.type"):
        load(tmp_path, pinion_given(dict.fromkeys(sides, 'grid = "points/concave.csv"\ncutter = {}')))


def test_pinion_given_by_an_ease_off(tmp_path: Path) -> None:
    rows = "".join(f"{x},{y},{5.0 * x * x + 2.0 * y}\n" for x in (-1.0, -0.5, 0.0, 0.5, 1.0) for y in (-1.0, 0.0, 1.0))
    (tmp_path / "map.csv").write_text(f"# um\nlength,depth,ease_off\n{rows}", encoding="utf-8")
    relief = 'lengthwise_crowning = "35 um", profile_crowning = "12 um", map = "map.csv"'
    relief += ', terms = [{ length_power = 3, depth_power = 0, relief = "2 um" }]'
    given = {"concave": f"ease_off = {{ {relief} }}", "convex": "ease_off = {}"}
    design = load(tmp_path, pinion_given(given))
    pinion, gear = design.flanks().mating("drive")
    assert isinstance(pinion, ConjugateFlank)
    assert (pinion.side, gear.side) == ("concave", "convex")
    pair = flank_pair(design.flanks())
    assert 10.0 < np.degrees(pair.transmission.peak_to_peak) * 3600.0 < 20.0
    # misalignment moves the members, it does not make another pinion
    moved, at = design.with_misalignment(E=1e-4).flanks().mating("drive")[0], np.zeros(1)
    np.testing.assert_allclose(moved.solve(at, at)[0].position, pinion.solve(at, at)[0].position)
    with refuses("convex.ease_off"):
        design.pinion.flank("convex")


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
    file.write_text(SHEET + "radial setting, 4.108\n", encoding="utf-8")  # twice the same value
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
        (SHEET + "radial setting, 4.18\n", f"line {SHEET.count(chr(10)) + 1} (radial setting)"),
    ],
)
def test_bad_lines_are_named(text: str, field: str) -> None:
    with refuses(field):
        parse_summary(text)


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


def test_a_sheet_as_papers_print_it(mixed_ehl: Any, tmp_path: Path) -> None:
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


def test_a_missing_file_and_all_invalid_lines_are_reported(tmp_path: Path) -> None:
    with refuses("summary"):
        read_summary(tmp_path / "none.csv")
    with pytest.raises(InputError) as caught:
        parse_summary("member, gear\nteeth, 41.5\nradial [deg], 90\nhand, middle")
    assert [one.field for one in caught.value.problems] == ["line 2 (teeth)", "line 3 (radial)", "line 4 (hand)"]
