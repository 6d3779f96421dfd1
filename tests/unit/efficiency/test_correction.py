"""Machine corrections from measured flanks, maps of ease-off, the command `correct`."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refuses

from efficiency.contact.conjugate import read_ease_off_map
from efficiency.design.design import load_design
from efficiency.machine_settings.conjugate import target_relief
from efficiency.machine_settings.correction import machine_corrections
from efficiency.machine_settings.inputs import FlankTarget
from efficiency.output.files import export_ease_off, inspection_grid, write_inspection_grid
from ehl.common.errors import InputError
from ehl.common.validation import validate

BEVEL, HOBBED = "fm_spiral_bevel_14x39", "fh_hypoid_9x34_offset_10"


def grids(folder: Path, name: str, changes: dict[str, float], noise: float = 0.0, sides: str = "both") -> list[Path]:
    """Points of pinion flanks as a machine cuts them whose settings are off."""
    design, rng, files = load_design(name), np.random.default_rng(1), []
    for side in ("concave", "convex"):
        if sides not in ("both", side):
            continue
        flank = design.flank("pinion", side)
        off = replace(flank.machine, **{key: getattr(flank.machine, key) + by for key, by in changes.items()})
        grid = inspection_grid(replace(flank, machine=off), 7, 11, 0.08)
        shift = noise * rng.standard_normal(grid.u.shape)
        files.append(folder / f"{side}.csv")
        write_inspection_grid(
            files[-1], design, "pinion", side, replace(grid, position=grid.position + shift * grid.normal)
        )
    return files


@pytest.mark.parametrize("name", [BEVEL, HOBBED])
def test_settings_that_are_off_are_found(tmp_path: Path, name: str) -> None:
    changes = {"machine_root_angle": 3e-4, "radial_setting": 5e-5, "roll_ratio": 4e-4, "sliding_base": -2e-5}
    found = machine_corrections(name, grids(tmp_path, name, changes), "0.01 um")
    by_side = {(row.flank, row.part): row for row in found.deviations}
    for side in ("concave", "convex"):
        assert by_side[side, "measured"].deviation_rms > 2e-6
        assert by_side[side, "expected"].deviation_rms < 2e-9
        assert abs(by_side[side, "expected"].pressure_angle_error) < 1e-7
    completing = name == HOBBED
    assert {row.flanks for row in found.corrections} == ({"both"} if completing else {"concave", "convex"})
    if not completing:
        change = {row.setting: row for row in found.corrections if row.flanks == "concave"}
        for setting, by in changes.items():
            # what the points tell apart comes back; each within its own uncertainty
            assert abs(change[setting].change + by) < 2.0 * change[setting].uncertainty
        assert abs(change["roll_ratio"].change + 4e-4) < 5e-5


def test_noise_leaves_its_own_size_and_the_angles(tmp_path: Path) -> None:
    files = grids(tmp_path, BEVEL, {"machine_root_angle": 4e-4, "blank_offset": 4e-5}, 1e-6)
    found = machine_corrections(BEVEL, files, 1e-6, 1)
    for row in found.deviations:
        if row.part == "expected":
            assert 0.7e-6 < row.deviation_rms < 1.2e-6
            assert abs(row.spiral_angle_error) < 2e-5
            assert abs(row.pressure_angle_error) < 3e-5
    assert "modified_roll_2c" not in {row.setting for row in found.corrections}


def test_dirt_inches_reversed_numbers_and_missing_points_change_nothing(tmp_path: Path) -> None:
    """A point 80 um off and two that were not measured; inch, decimal commas, rows counted from the tip."""
    changes = {"machine_root_angle": 3e-4, "radial_setting": 5e-5}
    files = grids(tmp_path, BEVEL, changes, 0.5e-6)
    clean = {(row.setting, row.flanks): row for row in machine_corrections(BEVEL, files, 1e-6).corrections}
    for file in files:
        text = file.read_text(encoding="utf-8").splitlines()
        head = text[0]
        assert "units=mm" in head
        names, *lines = [line for line in text if not line.startswith("#")]
        points = [[float(cell) for cell in line.split(",")] for line in lines]
        for k, point in enumerate(points):
            if k == 25:
                normal = np.array(point[5:8])
                point[2:5] = list(np.array(point[2:5]) + 0.08 * normal)
            point[0] = 100 - point[0]
            point[2:5] = [x / 25.4 for x in point[2:5]]
        rows = [";".join(f"{cell:.12g}" for cell in point).replace(".", ",") for point in points]
        for k in (3, 44):
            rows[k] = ";".join([*rows[k].split(";")[:2], "Bad", "-999", "-999", "0", "0", "1"])
        new = "\r\n".join([head.replace("units=mm", "units=inch") + ";;;", names.replace(",", ";"), *rows])
        file.write_bytes(new.encode("utf-16"))
    found = machine_corrections(BEVEL, files, 1e-6)
    assert sum("omitted" in note for note in found.notes) == 2
    for row in found.corrections:
        assert abs(row.change - clean[row.setting, row.flanks].change) < row.uncertainty


def test_a_part_as_designed_asks_for_nothing(tmp_path: Path) -> None:
    found = machine_corrections(BEVEL, grids(tmp_path, BEVEL, {}, sides="concave"), 1e-6, 1)
    assert all(abs(row.change) < 1e-3 * row.uncertainty for row in found.corrections)
    assert "[pinion.concave.machine]" in found.text
    assert "[pinion.convex.machine]" not in found.text


def test_one_flank_of_a_completing_pinion_is_told(tmp_path: Path) -> None:
    found = machine_corrections(HOBBED, grids(tmp_path, HOBBED, {"tilt": 2e-4}, sides="convex"))
    assert any("the other flank changes too" in note for note in found.notes)


@pytest.mark.parametrize(
    ("given", "count", "member", "field"),
    [
        ({"uncertainty": "1 mm"}, 1, "pinion", "uncertainty"),
        ({"uncertainty": "1 N"}, 1, "pinion", "uncertainty"),
        ({}, 0, "pinion", "grids"),
        ({}, 2, "pinion", "grids"),
        ({}, 1, "gear", "row 1, column 11"),
        ({}, 1, "", "grids"),
    ],
)
def test_wrong_input_is_refused(tmp_path: Path, given: dict[str, Any], count: int, member: str, field: str) -> None:
    (file,) = grids(tmp_path, BEVEL, {}, sides="concave")
    file.write_text(file.read_text(encoding="utf-8").replace("member=pinion", f"member={member}", 1), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        machine_corrections(BEVEL, [file] * count, **given)
    assert caught.value.field.endswith(field)


def test_command(tmp_path: Path, mixed_ehl: Any) -> None:
    (file,) = grids(tmp_path, BEVEL, {"roll_ratio": 4e-4}, sides="concave")
    outcome = mixed_ehl("correct", BEVEL, file, "--json", "--order", "1", "-o", tmp_path / "new.toml")
    assert outcome.code == 0
    assert "roll_ratio" in (tmp_path / "new.toml").read_text(encoding="utf-8")
    content = json.loads(outcome.out)
    assert {row["part"] for row in content["deviations"]} == {"measured", "expected"}


def test_a_map_of_ease_off_is_a_target(tmp_path: Path) -> None:
    lines = export_ease_off(load_design(BEVEL), tmp_path)
    assert len(lines) == 2
    given = read_ease_off_map(tmp_path / "ease_off_drive.csv")
    assert given.error < 1e-8
    x, y = np.array([0.0, 0.5, -0.7]), np.array([0.0, -0.3, 0.6])
    target = FlankTarget(map=str(tmp_path / "ease_off_drive.csv"))
    np.testing.assert_allclose(
        target_relief(target, x, y), target_relief(FlankTarget(), x, y) + given(x, y), rtol=1e-12
    )
    with refuses("transmission_error"):
        validate(FlankTarget, {"map": str(tmp_path / "ease_off_drive.csv"), "transmission_error": "20 arcsec"})
