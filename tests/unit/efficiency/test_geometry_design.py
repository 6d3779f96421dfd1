from pathlib import Path

import pytest
from refusals import fails, refuses

from efficiency.contact.flank_pair import flank_pair
from efficiency.contact.tooth_grid import tooth_shapes
from efficiency.design.design import load_design
from ehl.common.data import data_path
from ehl.common.errors import InputError

TEXT = data_path("designs", "fm_spiral_bevel_14x39.toml").read_text(encoding="utf-8")


def changed(folder: Path, old: str, new: str) -> Path:
    assert TEXT.count(old) >= 1
    path = folder / "pair.toml"
    path.write_text(TEXT.replace(old, new, 1), encoding="utf-8")
    return path


def test_shipped_design_by_name_and_by_path(tmp_path: Path) -> None:
    design = load_design("fm_spiral_bevel_14x39")
    assert design == load_design(changed(tmp_path, "name = ", "name = "))
    assert design.operation.temperature == pytest.approx(363.15)
    assert design.gear.convex.machine.radial_setting == pytest.approx(0.09485354936)  # type: ignore[union-attr]
    for side, expected in (("drive", ["concave", "convex"]), ("coast", ["convex", "concave"])):
        assert [flank.blade.side for flank in design.flanks().mating(side)] == expected


RADIUS = 'point_radius = "114.47823644967657 mm"'
MISTAKES = [
    (RADIUS, 'point_radius = "-114 mm"', "pinion.concave.cutter.point_radius"),
    (RADIUS, "point_radius = nan", "pinion.concave.cutter.point_radius"),
    ('face_width = "25.4 mm"', 'face_width = "180 mm"', "pinion.blank.face_width"),
    ('face_width = "25.4 mm"', 'face_width = "100 mm"', "pinion.blank.face_width"),  # no tooth left at the toe
    ('face_width = "25.4 mm"', 'face_width = "0.0254 mm"', "pinion.blank.face_width"),
    ("teeth = 14", "teeth = 41", "pinion.blank.teeth"),
    ("teeth = 14", "", "pinion.blank.teeth"),
    ('hand = "left"', 'hand = "right"', "pinion.concave.machine.cradle_angle"),
    ('process = "generated"', 'process = "hand filed"', "pinion.concave.machine.process"),
    ('type = "face_milling"', 'type = "face_hobbing"', "pinion.concave.cutter.cutter_radius"),
    ('type = "face_milling"', "", "pinion.concave.cutter.type"),
    ('torque = "300 N m"', 'torque = "-300 N m"', "operation.torque"),
    ("E = 0.0", 'E = "5 mm"', "assembly.misalignment.E"),
    ('shaft_angle = "90 deg"\n', "", "assembly.shaft_angle"),
]


@pytest.mark.parametrize(("old", "new", "field"), MISTAKES)
def test_bad_input_names_its_field(tmp_path: Path, old: str, new: str, field: str) -> None:
    """What is written wrong, of a wrong unit or unknown is in test_mistakes as well as on the command line."""
    with refuses(field):
        load_design(changed(tmp_path, old, new))


def test_settings_that_cut_no_flank_are_refused_with_a_reason(tmp_path: Path) -> None:
    # a cradle twice as far out leaves the cutter beside the blank
    path = changed(tmp_path, 'radial_setting = "96.01838217906185 mm"', 'radial_setting = "300 mm"')
    with fails("flank"):
        flank_pair(load_design(path).flanks(), "drive")


@pytest.mark.parametrize(("old", "new"), [("115.40012999999999 mm", "121 mm"), ("113.19987 mm", "107.5 mm")])
def test_flanks_that_cross_are_told_by_member_and_place(tmp_path: Path, old: str, new: str) -> None:
    told = r"(pinion|gear): tooth thickness at the (tip|root) = '-.* mm at .* mm from the toe"
    with pytest.raises(InputError, match=told) as caught:
        tooth_shapes(load_design(changed(tmp_path, old, new)).flanks())
    assert "[" not in str(caught.value)
