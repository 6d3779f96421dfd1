"""Targets files, wanted ease-off, the command `settings`."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refuses

from efficiency.contact.tooth_grid import tooth_shape
from efficiency.design.design import load_design
from efficiency.machine_settings.conjugate import target_relief
from efficiency.machine_settings.inputs import FlankTarget, SettingsInput, load_targets
from efficiency.machine_settings.solve import machine_settings
from ehl.common.data import data_path

TEXT = data_path("targets", "fh_hypoid_9x34.toml").read_text(encoding="utf-8")


def changed(**cutting: Any) -> SettingsInput:
    given = load_targets("fh_hypoid_9x34")
    return given.model_copy(update={"cutting": given.cutting.model_copy(update=cutting)})


def test_relief_has_the_amounts_of_the_targets() -> None:
    target = FlankTarget(crowning_toe=30e-6, crowning_heel=50e-6, relief_root=8e-6, relief_tip=20e-6)
    x, y = np.array([-1.0, 1.0, 0.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0, 1.0, 0.0])
    np.testing.assert_allclose(target_relief(target, x, y), [30e-6, 50e-6, 8e-6, 20e-6, 0.0], atol=1e-18)


def test_bias_leans_the_crest_and_twist_lifts_corners() -> None:
    leaning = FlankTarget(bias=0.4, relief_root=0.0, relief_tip=0.0)
    assert target_relief(leaning, np.array([0.4]), np.array([1.0]))[0] == pytest.approx(0.0, abs=1e-18)
    twisted = FlankTarget(crowning_toe=0.0, crowning_heel=0.0, relief_root=0.0, relief_tip=0.0, twist=5e-6)
    x, y = np.array([1.0, -1.0, 1.0, -1.0]), np.array([1.0, -1.0, -1.0, 1.0])
    np.testing.assert_allclose(target_relief(twisted, x, y), [5e-6, 5e-6, -5e-6, -5e-6], atol=1e-18)


def test_contact_position_is_without_relief() -> None:
    target = FlankTarget(contact_face=0.3, contact_depth=-0.2, bias=0.5, twist=4e-6)
    assert target_relief(target, np.array([0.3]), np.array([-0.2]))[0] == pytest.approx(0.0, abs=1e-18)


def test_conjugate_flanks_need_even_targets() -> None:
    content = load_targets("fh_hypoid_9x34").model_dump()
    content["cutting"]["pinion"] = "conjugate"
    content["targets"]["drive"]["crowning_heel"] = 20e-6
    with pytest.raises(ValueError, match="crowning_heel"):
        SettingsInput.model_validate(content)


def test_pinion_without_settings_is_labelled() -> None:
    result = machine_settings(changed(pinion="conjugate"), transmission=False)
    assert "without machine settings" in result.warnings[0]
    assert "no settings" in result.text
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


def test_command_writes_a_design_that_loads(mixed_ehl: Callable[..., Any], tmp_path: Path) -> None:
    targets, design = tmp_path / "targets.toml", tmp_path / "made" / "design.toml"
    targets.write_text(TEXT.replace('pinion = "both_flanks"', 'pinion = "each_flank"'), encoding="utf-8")
    outcome = mixed_ehl("settings", targets, "-o", design, "--json")
    assert outcome.code == 0
    content = json.loads(outcome.out)
    assert content["status"] == "converged"
    assert content["concave"]["residual_rms"] < 1e-6
    assert len(content["convex"]["residual_map"]) == 135
    assert load_design(design).name == "fh_hypoid_9x34"
    assert design.read_text(encoding="utf-8").startswith("# fh_hypoid_9x34: made by")


def test_a_pointed_tooth_is_no_result(mixed_ehl: Callable[..., Any], tmp_path: Path) -> None:
    text = data_path("targets", "fh_hypoid_9x34_offset_10.toml").read_text(encoding="utf-8")
    # depth and thickness that the pair with the larger offset has
    for old, new in (
        ("depth_factor = 1.8", "depth_factor = 2.0"),
        ("thickness_factor = 0.3", "thickness_factor = 0.1"),
    ):
        assert old in text
        text = text.replace(old, new)
    targets, design = tmp_path / "targets.toml", tmp_path / "design.toml"
    targets.write_text(text, encoding="utf-8")
    outcome = mixed_ehl("settings", targets, "-o", design)
    assert outcome.code == 1
    assert "pointed" in outcome.out + outcome.err
    assert "addendum" in " ".join((outcome.out + outcome.err).split())
    shape = tooth_shape(load_design(design).flanks(), "pinion")
    assert shape.thickness_tip.min() < 0.0


def test_too_much_undercut_is_no_result() -> None:
    given = load_targets("fh_spiral_bevel_12x37")
    depth = given.blank.depth.model_copy(update={"gear_addendum_factor": 0.45})
    blank = given.blank.model_copy(update={"depth": depth})
    result = machine_settings(given.model_copy(update={"blank": blank}), transmission=False)
    assert result.status == "undercut"
    assert any("points undercut" in warning and "pressure angle" in warning for warning in result.warnings)


def test_blank_and_targets_name_one_way_of_cutting() -> None:
    content = load_targets("fh_hypoid_9x34").model_dump()
    content["blank"]["gear_cutting"] = "generated"
    with pytest.raises(ValueError, match="gear_cutting"):
        SettingsInput.model_validate(content)
    content["blank"] |= {"gear_cutting": "formate", "inside_blade_angle_gear": 0.4}
    with pytest.raises(ValueError, match="inside_blade_angle_gear"):
        SettingsInput.model_validate(content)


def test_unknown_targets_name_the_shipped_ones() -> None:
    with refuses("targets"):
        load_targets("nothing")


def test_residual_above_the_limit_is_exit_code_1(mixed_ehl: Callable[..., Any], tmp_path: Path) -> None:
    # so much crowning is beyond one setting for both flanks
    targets = tmp_path / "targets.toml"
    targets.write_text(TEXT.replace('"40 um"', '"400 um"'), encoding="utf-8")
    outcome = mixed_ehl("settings", targets)
    assert outcome.code == 1
    assert "um rms, above 3" in outcome.err
