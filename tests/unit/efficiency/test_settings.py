"""Targets files, wanted ease-off, crowning and relief sized for a torque, the command `settings`."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import efficiency
from efficiency.contact.tooth_grid import tooth_shape
from efficiency.design.design import load_design
from efficiency.machine_settings.conjugate import target_relief
from efficiency.machine_settings.inputs import FlankTarget, SettingsInput, load_targets
from efficiency.machine_settings.solve import machine_settings
from efficiency.optimisation.load_sizing import EDGE_LIMIT, FlankLoad, _grown, sized_for_load
from ehl.common.data import data_path
from ehl.common.errors import InputError
from ehl.common.validation import validate

TEXT = data_path("targets", "fh_hypoid_9x34.toml").read_text(encoding="utf-8")
OWN = validate(SettingsInput, tomllib.loads(efficiency.new_file("targets", "own")))


def changed(**cutting: Any) -> SettingsInput:
    given = load_targets("fh_hypoid_9x34")
    return given.model_copy(update={"cutting": given.cutting.model_copy(update=cutting)})


def test_relief_of_a_target() -> None:
    """Amounts at the ends; bias moves the crest with the height, twist lifts corners; none at the contact position."""

    def relief(x: list[float], y: list[float], **target: float) -> Any:
        return 1e6 * target_relief(FlankTarget(**target), np.array(x), np.array(y))

    amounts = {"crowning_toe": 30e-6, "crowning_heel": 50e-6, "relief_root": 8e-6, "relief_tip": 20e-6}
    ends = relief([-1.0, 1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 1.0, 0.0], **amounts)
    np.testing.assert_allclose(ends, [30.0, 50.0, 8.0, 20.0, 0.0], atol=1e-12)
    corners = relief([1.0, -1.0, 1.0, -1.0], [1.0, -1.0, -1.0, 1.0], **dict.fromkeys(amounts, 0.0), twist=5e-6)
    np.testing.assert_allclose(corners, [5.0, 5.0, -5.0, -5.0], atol=1e-12)
    leant = relief([0.4], [1.0], bias=0.4, relief_root=0.0, relief_tip=0.0)
    middle = relief([0.3], [-0.2], contact_face=0.3, contact_depth=-0.2, bias=0.5, twist=4e-6)
    assert (leant[0], middle[0]) == pytest.approx((0.0, 0.0), abs=1e-12)


def test_pinion_without_settings() -> None:
    result = machine_settings(changed(pinion="conjugate"), transmission=False)
    given = result.design.pinion.concave.model_dump()
    assert given["ease_off"]["lengthwise_crowning"] == pytest.approx(40e-6)
    assert result.rms < 1e-12


def test_blades_can_stay_at_the_radius_of_their_head() -> None:
    result = machine_settings(changed(radius_offsets="none"), transmission=False)
    for side in ("concave", "convex"):
        cutter = getattr(result.design.pinion, side).cutter
        assert cutter.radius_offset == 0.0
        assert cutter.cutter_radius == pytest.approx(0.076)
    assert result.rms < 3e-6


def test_cradle_machine_keeps_root_angle_and_tilt() -> None:
    limit = np.radians(7.0)
    result = machine_settings(changed(pinion="each_flank", machine="cradle", tilt_limit=limit), transmission=False)
    blank = result.design.pinion.blank
    for side in ("concave", "convex"):
        machine = getattr(result.design.pinion, side).machine
        assert machine.machine_root_angle == pytest.approx(blank.pitch_angle - blank.dedendum_angle, abs=1e-8)
        assert abs(machine.tilt) <= limit + 1e-9
    assert result.rms < 6e-6


def test_wanted_transmission_error_is_reached() -> None:
    given = load_targets("fh_spiral_bevel_12x37")
    wish = given.targets.drive.model_copy(update={"transmission_error": np.radians(25.0 / 3600.0)})
    targets = given.targets.model_copy(update={"drive": wish})
    result = machine_settings(given.model_copy(update={"targets": targets}), transmission=False)
    assert result.concave.transmission_error == pytest.approx(wish.transmission_error, rel=0.011)
    assert result.convex.transmission is None


def test_a_pointed_tooth_is_no_result(mixed_ehl: Any, tmp_path: Path) -> None:
    text = data_path("targets", "fh_hypoid_9x34_offset_10.toml").read_text(encoding="utf-8")
    # depth and thickness that the pair with the larger offset has
    text = text.replace("depth_factor = 1.8", "depth_factor = 2.0")
    text = text.replace("thickness_factor = 0.3", "thickness_factor = 0.1")
    targets, design = tmp_path / "targets.toml", tmp_path / "design.toml"
    targets.write_text(text, encoding="utf-8")
    assert mixed_ehl("settings", targets, "-o", design).code == 1
    shape = tooth_shape(load_design(design).flanks(), "pinion")
    assert shape.thickness_tip.min() < 0.0


def test_too_much_undercut_is_no_result() -> None:
    given = load_targets("fh_spiral_bevel_12x37")
    depth = given.blank.depth.model_copy(update={"gear_addendum_factor": 0.45})
    blank = given.blank.model_copy(update={"depth": depth})
    result = machine_settings(given.model_copy(update={"blank": blank}), transmission=False)
    assert result.status == "undercut"


@pytest.mark.parametrize(
    ("table", "changes", "field"),
    [
        ("cutting", {"pinion": "conjugate"}, "crowning_heel"),
        ("blank", {"gear_cutting": "generated"}, "gear_cutting"),
        ("blank", {"gear_cutting": "formate", "inside_blade_angle_gear": 0.4}, "inside_blade_angle_gear"),
    ],
)
def test_blank_cutting_and_targets_have_to_agree(table: str, changes: dict[str, Any], field: str) -> None:
    """Conjugate flanks need even targets; blank and targets name one way of cutting."""
    content = load_targets("fh_hypoid_9x34").model_dump()
    content["targets"]["drive"]["crowning_heel"] = 20e-6
    content[table] |= changes
    with pytest.raises(ValueError, match=field):
        SettingsInput.model_validate(content)


def test_residual_above_the_limit_is_exit_code_1(mixed_ehl: Any, tmp_path: Path) -> None:
    # so much crowning is beyond one setting for both flanks
    targets = tmp_path / "targets.toml"
    targets.write_text(TEXT.replace('"40 um"', '"400 um"'), encoding="utf-8")
    assert mixed_ehl("settings", targets).code == 1


def test_edges_of_a_template_carry_next_to_nothing_on_both_flanks() -> None:
    """In the aligned pair the load on the edges is that of the sizing, and the load is central."""
    found = sized_for_load(OWN, misalignment={"P": "0.05 mm", "E": "0 mm", "G": "0 mm"})
    assert found.shares[-1] < EDGE_LIMIT < found.shares[0]
    pair = efficiency.GearPair(efficiency.settings(found.targets).design)
    for side in ("drive", "coast"):
        loaded = pair.mesh(side, 12, 21).load(OWN.operation.torque)
        assert loaded.efficiency("constant:0.05").edges.load_share < EDGE_LIMIT
        assert found.sides[side].worst < EDGE_LIMIT
        assert abs(found.sides[side].centre) < 0.15


def test_sizing_of_the_drive_side_alone() -> None:
    box = dict.fromkeys(("E", "P", "G"), "0 mm")
    found = sized_for_load(OWN, misalignment=box, coast_torque="0 N m")
    assert list(found.sides) == ["drive"]
    assert found.targets.targets.coast == OWN.targets.coast
    for wrong in ("-5 N m", "5 mm"):
        with pytest.raises(InputError):
            sized_for_load(OWN, coast_torque=wrong)


@pytest.mark.parametrize(("name", "width"), [("E", "5 mm"), ("P", "-0.1 mm"), ("G", "1 arcmin"), ("X", "0.1 mm")])
def test_half_widths_are_checked_as_typed(name: str, width: str) -> None:
    with pytest.raises(InputError, match=f"= '{name if name == 'X' else width}'"):
        sized_for_load(OWN, misalignment={name: width})


def test_a_search_starts_from_the_sized_pair() -> None:
    found = efficiency.optimise(
        OWN, {"bias": "-0.2:0.2"}, misalignment={}, friction="constant:0.05", evaluations=4, check=0, sized=True
    )
    assert found.start.figures["edge_load_share"] < EDGE_LIMIT
    assert found.allowed["pressure_flank"] == found.start.figures["pressure_flank"]


def test_relief_grows_where_an_edge_carries() -> None:
    relief = {edge: {"amount": 1e-5, "length": 1e-3} for edge in ("tip", "toe", "heel")}
    members = {name: getattr(OWN, name).model_validate({"edge_relief": relief}) for name in ("pinion", "gear")}
    start = OWN.model_copy(update=members)
    shares = {"drive": {"pinion tip": 0.1, "gear heel": 0.02}, "coast": {}}
    grown = _grown(start, {side: FlankLoad((0.1,), edges, -0.2) for side, edges in shares.items()})
    assert grown.pinion.edge_relief.tip.amount > 1.5e-5
    assert grown.gear.edge_relief.heel.amount > grown.gear.edge_relief.toe.amount == 1e-5
    assert grown.targets.drive.crowning_heel > grown.targets.drive.crowning_toe == OWN.targets.drive.crowning_toe
    assert grown.targets.coast.crowning_heel == OWN.targets.coast.crowning_heel
    # the load lies towards the toe: the contact moves to the heel
    assert grown.targets.coast.contact_face > 0.0
