"""Cutters, machines and other ways to give a flank in a design file."""

from pathlib import Path

import numpy as np
import pytest
from refusals import refuses

from efficiency.contact.conjugate import ConjugateFlank
from efficiency.contact.flank_pair import flank_pair
from efficiency.contact.grid_flank import SmoothFlank
from efficiency.design.design import Design, load_design
from efficiency.output.files import inspection_grid, write_inspection_grid
from ehl.common.data import data_path

SHIPPED = data_path("designs", "fm_spiral_bevel_14x39.toml").read_text(encoding="utf-8")
HEAD, _, _GEAR_CUT = SHIPPED.partition("[gear.concave.cutter]")
# the gear of the shipped pair once more, as a spread-blade cutter in one machine setting, partly in inches
COMPLETING = (
    HEAD
    + """
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
)
HOBBED = (
    HEAD
    + """
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
toprem = { height = "1.5 mm", radius = "30 mm", angle = "3 deg" }

[gear.convex.cutter]
blade_angle = "20 deg"
blade_phase = "-9 deg"
rake_angle = "4 deg"
hook_angle = "6 deg"
radius_offset = "0.1 mm"
flankrem = { height = "6 mm", radius = "200 mm" }
"""
)


def load(folder: Path, text: str, *changes: tuple[str, str]) -> Design:
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    path = folder / "pair.toml"
    path.write_text(text, encoding="utf-8")
    return load_design(path)


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
    # what a flank says itself overrides
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


@pytest.mark.parametrize(("text", "old", "new", "field"), MISTAKES)
def test_bad_input_names_its_field(tmp_path: Path, text: str, old: str, new: str, field: str) -> None:
    with refuses(f"gear.{field}"):
        load(tmp_path, text, (old, new))


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
    # cutter and machine beside a grid are its nominal flank, which needs to be whole
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
