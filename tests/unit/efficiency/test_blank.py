"""Blank files: what is refused and how, recommended values, warnings, the command."""

import json
import math
from dataclasses import astuple
from pathlib import Path
from typing import Any

import pytest
from refusals import refuses

import efficiency
from efficiency.blanks.dimensions import recommended_addendum_factor, recommended_thickness_factor
from efficiency.blanks.inputs import PairBlankInput, load_blank
from efficiency.blanks.pair import pair_blank, pitch_cones
from efficiency.blanks.pair_blank import PairBlank
from efficiency.cutting.blank import Blank
from ehl.common.data import data_names, data_path
from ehl.common.validation import read_toml, validate


def made(name: str = "iso23509_f4", **changes: Any) -> PairBlank:
    """Blank of a shipped file with keys replaced; a dotted key goes into a table, None removes it."""
    table = read_toml(data_path("blanks", f"{name}.toml"))
    for key, value in changes.items():
        *path, last = key.split("__")
        place = table
        for part in path:
            place = place.setdefault(part, {})
        place[last] = value
        if value is None:
            del place[last]
    return pair_blank(validate(PairBlankInput, table))


@pytest.mark.parametrize("name", data_names("blanks"))
def test_shipped_blanks_give_two_blanks_of_a_design(name: str) -> None:
    pair = pair_blank(load_blank(name))
    assert "nan" not in repr(astuple(pair))
    for member in (pair.pinion, pair.gear):
        assert validate(Blank, member.cones.model_dump()) == member.cones
        assert member.cones.hand == member.hand
    if not name.startswith("iso"):
        assert abs(pair.tangency_error) < 1e-12


@pytest.mark.parametrize(
    ("field", "changes"),
    [
        ("cutter_radius", {"name": "iso23509_f2", "cutter_radius": "44 mm", "taper": {"type": "duplex"}}),
        ("hypoid_offset", {"name": "iso23509_f5", "hypoid_offset": "195 mm", "pitch_cones": "converged"}),
        ("mean_spiral_angle_gear", {"mean_spiral_angle_gear": "70 deg"}),
        ("depth.clearance_factor", {"depth__clearance_factor": -0.05}),
        ("cutter_radius", {"cutter_radius": "20 mm"}), ("cutter_radius", {"cutter_radius": "33 mm"}),
        ("hand_gear", {"hand_pinion": "right", "hand_gear": "right"}),
        ("hypoid_offset", {"hypoid_offset": "75 mm"}), ("hypoid_offset", {"hypoid_offset": "-75 mm"}),
        ("hypoid_offset", {"method": 0}), ("teeth_gear", {"teeth_gear": 8}),
        ("face_width_gear", {"face_width_gear": "170 mm"}),
        ("blade_groups", {"blade_groups": None}), ("blade_groups", {"process": "face_milling"}),
        ("outer_pitch_diameter_gear", {"outer_pitch_diameter_gear": "170 mm"}),
        ("outer_pitch_diameter_gear", {"mean_pitch_diameter_gear": None}),
        ("mean_spiral_angle_gear", {"mean_spiral_angle_gear": None}),
        ("mean_spiral_angle_pinion", {"mean_spiral_angle_pinion": "45 deg"}),
        ("shaft_angle", {"hypoid_offset": "0 mm", "shaft_angle": "110 deg"}),
        ("taper.addendum_angle_gear", {"taper__type": "given"}),
        ("taper.addendum_angle_gear", {"taper__addendum_angle_gear": "1 deg"}),
        ("backlash.type", {"backlash__type": "none"}), ("pressure_angle.drive", {"pressure_angle__drive": "8.5 deg"}),
        ("depth", {"depth__thickness_factor": 0.6, "depth__gear_addendum_factor": 0.01}),
    ],
)  # fmt: skip
def test_impossible_combinations_are_refused_by_name(field: str, changes: dict[str, Any]) -> None:
    with refuses(field) as caught:
        made(**changes)
    assert caught.value.allowed


def test_recommended_values_are_those_of_the_printed_sample() -> None:
    inputs = load_blank("iso23509_f2")
    assert recommended_addendum_factor(inputs, pitch_cones(inputs)) == pytest.approx(0.24737, abs=5e-6)
    assert recommended_thickness_factor(inputs) == pytest.approx(0.0915, abs=5e-5)
    given = made("iso23509_f2")
    pair = made("iso23509_f2", depth={"data_type": "II"}, taper=None)
    named = {text.split(" = ")[0] for text in pair.defaults}
    assert {"depth.clearance_factor", "depth.thickness_factor", "taper.type"} <= named
    # the sample's tapers are those of a constant slot width, Annex C
    duplex = made("iso23509_f2", taper={"type": "duplex"})
    assert duplex.gear.dedendum_angle == pytest.approx(given.gear.dedendum_angle, abs=1e-5)
    assert duplex.gear.addendum_angle == pytest.approx(given.gear.addendum_angle, abs=1e-5)
    assert pair.gear.mean_addendum == pytest.approx(given.gear.mean_addendum, rel=1e-4)


def test_tapers() -> None:
    uniform = made("iso23509_f2", taper={"type": "uniform"})
    standard = made("iso23509_f2", taper={"type": "standard"})
    tilted = made("iso23509_f2", taper={"type": "tilted_root"})
    duplex = made("iso23509_f2", taper={"type": "duplex"})
    assert uniform.gear.outer_whole_depth == pytest.approx(uniform.gear.inner_whole_depth)
    # standard taper: root lines of both members run to the common apex
    for member in (standard.pinion, standard.gear):
        # up to the clearance, kept square to the root line and not to the pitch cone
        assert member.root_apex_beyond_crossing == pytest.approx(0.0, abs=2e-6)
    sums = [pair.gear.addendum_angle + pair.gear.dedendum_angle for pair in (standard, duplex, tilted)]
    assert sums[2] == pytest.approx(min(sums[1], 1.3 * sums[0]))
    # a face mill cuts a slot of constant width; with duplex taper that of the pinion is about constant too
    assert max(duplex.gear.slot_width) == pytest.approx(min(duplex.gear.slot_width), rel=1e-12)
    ratio = [max(pair.pinion.slot_width) / min(pair.pinion.slot_width) for pair in (duplex, standard)]
    assert ratio[0] < 1.06 < ratio[1]


@pytest.mark.parametrize(
    ("kind", "name", "changes"),
    [
        ("undercut", "iso23509_f4", {}),
        ("top_land", "fh_hypoid_9x34_offset_10", {}),
        ("slot_width", "iso23509_f4", {"depth__depth_factor": 2.5, "depth__gear_addendum_factor": 0.2}),
        ("cutter_radius", "iso23509_f2", {"cutter_radius": "50 mm"}),
        ("cutter_radius", "iso23509_f2", {"taper": {"type": "uniform"}}),
        ("face_width", "iso23509_f3", {}),
        ("spiral_angle", "iso23509_f3", {"mean_spiral_angle_pinion": "56 deg"}),
        ("spiral_angle", "iso23509_f4", {"mean_spiral_angle_gear": "5 deg"}),
        ("offset", "iso23509_f4", {"hypoid_offset": "44 mm"}),
        ("clearance", "iso23509_f4", {"depth__clearance_factor": 0.05}),
        ("contact_ratio", "iso23509_f4", {"mean_spiral_angle_gear": "0 deg", "hypoid_offset": "1 mm",
                                          "depth__depth_factor": 1.3, "pressure_angle__drive": "28 deg"}),
        ("common_factor", "iso23509_f4", {"blade_groups": 17}),
        ("tangency", "iso23509_f4", {}),
        ("slot_taper", "iso23509_f2", {"taper": {"type": "standard"}, "cutter_radius": "400 mm",
                                       "depth__thickness_factor": 0.2}),
    ],
)  # fmt: skip
def test_warnings_carry_number_and_limit(kind: str, name: str, changes: dict[str, Any]) -> None:
    found = [warning for warning in made(name, **changes).warnings if warning.kind == kind]
    assert found
    assert not made("iso23509_f2").warnings
    for warning in found:
        wrong = warning.value < warning.limit if warning.side == "at least" else warning.value > warning.limit
        assert wrong


def test_outer_diameter_of_method_2() -> None:
    mean = made()
    outer = made(mean_pitch_diameter_gear=None, outer_pitch_diameter_gear=f"{mean.gear.outer_diameter * 1e3!r} mm")
    assert outer.gear.mean_diameter == pytest.approx(mean.gear.mean_diameter, rel=1e-12)
    assert outer.pinion.pitch_angle == pytest.approx(mean.pinion.pitch_angle, rel=1e-10)


@pytest.mark.parametrize("kind", ["outer_normal", "outer_transverse", "mean_normal"])
def test_backlash_is_stated_in_each_section(kind: str) -> None:
    """The value of the file is that of its own section; normal and transverse differ by both angles at the heel."""
    pair = made("fm_hypoid_13x42", backlash={"type": kind, "value": "0.15 mm"})
    name = f"backlash_{kind}" if kind.startswith("outer") else "backlash_normal"
    assert getattr(pair, name) == pytest.approx(0.15e-3, rel=1e-12)
    normal = 0.5 * (pair.pressure_angle_drive + pair.pressure_angle_coast)
    ratio = math.cos(normal) * math.cos(pair.gear.outer_spiral_angle)
    assert pair.backlash_outer_normal == pytest.approx(ratio * pair.backlash_outer_transverse, rel=1e-12)


def test_drawing_data_with_mounting_distances(mixed_ehl: Any, tmp_path: Path) -> None:
    """Mounting distance less crown distance is the height of the crown over the locating face; checked values."""
    pair = made("iso23509_f4", mounting_distance_pinion="130 mm")
    assert pair.pinion.crown_to_back == pytest.approx(0.13 - pair.pinion.crossing_to_crown)
    assert pair.pinion.front_crown_to_back == pytest.approx(0.13 - pair.pinion.crossing_to_front_crown)
    assert pair.gear.mounting_distance is None
    assert pair.gear.crown_to_back is None
    rows = {row[0]: row for row in pair.drawing_table().rows}
    assert rows["pitch angle"][2:] == ("deg", "24.763", "63.212")
    with refuses("mounting_distance_gear"):
        made(mounting_distance_gear="1 mm")
    assert mixed_ehl("blank", "iso23509_f4", "--csv", tmp_path / "tables", "--report", tmp_path / "b.html").code == 0
    assert "mounting distance" in (tmp_path / "tables" / "drawing.csv").read_text(encoding="utf-8")


@pytest.mark.usefixtures("commands_alone")
def test_drawing_data_of_a_design_are_those_of_its_blank(mixed_ehl: Any, tmp_path: Path) -> None:
    rows = {row[0]: row[3:] for row in made("iso23509_f2").drawing_table().rows}
    pair = efficiency.load("fm_spiral_bevel_14x39")
    drawing = pair.drawing()
    of_design = {row[0]: row[3:] for row in drawing.table().rows}
    assert rows.keys() - of_design.keys() == {"cutting"}
    for name in of_design.keys() - {"hand of spiral"}:
        loose = "thick" in name or "chordal" in name or "backlash" in name
        for own, other in zip(of_design[name], rows[name], strict=True):
            if own != other:
                assert float(own) == pytest.approx(float(other), rel=0.12 if loose else 2e-3, abs=0.06), name
    inch = {row[0]: row[2:] for row in drawing.table("inch").rows}
    assert float(inch["face width"][1]) == pytest.approx(1.0)
    assert efficiency.load("eaxle_helical_23x75").drawing() is None
    design = tmp_path / "design.toml"
    text = data_path("designs", "fm_spiral_bevel_14x39.toml").read_text(encoding="utf-8")
    design.write_text(text.replace("[gear]\n", '[gear]\nmounting_distance = "60 mm"\n', 1), encoding="utf-8")
    found = json.loads(mixed_ehl("gear", design, "--friction", "constant:0.05", "--json").out)["drawing"]["gear"]
    assert found["crown_to_back"] == pytest.approx(0.06 - found["crossing_to_crown"])
    design.write_text(text.replace("[gear]\n", '[gear]\nmounting_distance = "20 mm"\n', 1), encoding="utf-8")
    assert mixed_ehl("gear", design).code == 2
