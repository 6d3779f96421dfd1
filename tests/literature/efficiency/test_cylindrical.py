"""Cylindrical pairs against figures that a public program prints for the FZG test gears, and against textbooks."""

import math
from functools import cache

import numpy as np
import pytest

import efficiency
from efficiency.cylindrical_gears.contact_lines import axes_of, mesh_cycle
from efficiency.cylindrical_gears.design import CylindricalDesign
from efficiency.ltca.mesh_grids import friction_arm
from efficiency.pairs import CylindricalPair
from ehl.common.errors import InputError

# reports of GEARpie (REPORT/*.txt): base pitch, radii of tip of pinion and gear, T1T2, AC, AE [mm], contact ratio and
# overlap ratio, loss factors by Ohlendorf and over the lines of contact (load even along them), pressure at 200 N m:
# at the pitch point and the largest [GPa]
REPORTS = {
    "fzg_c14": (13.285, 41.228, 59.182, 34.93, 9.50, 19.10, 1.44, 0.00, 0.1950, 0.1945, 1.3473, 1.4475),
    "fzg_h501": (10.652, 40.336, 58.132, 34.45, 7.48, 15.55, 1.46, 0.54, 0.1639, 0.1869, 0.8489, 1.3182),
    "fzg_h701": (7.609, 39.276, 57.193, 34.45, 5.49, 11.53, 1.52, 0.56, 0.1225, 0.1404, 0.9622, 1.3026),
    "fzg_h951": (5.326, 38.115, 55.867, 43.44, 1.98, 4.98, 0.93, 1.00, 0.0739, 0.0688, 1.0396, 1.0486),
}


@cache
def pair(name: str, sharing: str = "rigid") -> CylindricalPair:
    found = efficiency.load(name)
    return CylindricalPair(found.design.model_copy(update={"load_share": sharing}))


@pytest.mark.parametrize("name", REPORTS)
def test_geometry_has_the_printed_figures(name: str) -> None:
    base_pitch, tip_pinion, tip_gear, between, before, path, ratio, overlap, loss, *_ = REPORTS[name]
    found = pair(name).design.involute
    assert 1e3 * found.base_pitch == pytest.approx(base_pitch, abs=1e-3)
    assert 1e3 * found.centre == pytest.approx(91.5, abs=0.01)
    assert [1e3 * r for r in found.tip] == pytest.approx([tip_pinion, tip_gear], abs=2e-3)
    assert 1e3 * sum(found.tangent) == pytest.approx(between, abs=0.01)
    assert -1e3 * found.path[0] == pytest.approx(before, abs=0.01)
    assert 1e3 * (found.path[1] - found.path[0]) == pytest.approx(path, abs=0.01)
    assert found.contact_ratio == pytest.approx(ratio, abs=0.005)
    assert found.overlap_ratio == pytest.approx(overlap, abs=0.005)
    assert found.loss_factor == pytest.approx(loss, abs=1e-4)


@pytest.mark.parametrize("name", REPORTS)
def test_loss_and_pressure_of_rigid_teeth_are_those_printed(name: str) -> None:
    """Their load is even along the lines, ours within 10 %; their lines are cut at fewer places."""
    overlap, _, loss, pitch_point, largest = REPORTS[name][7:]
    result = pair(name).mesh().load("200 N m").efficiency("constant:0.05", load_balance="frictionless")
    factor = result.power_loss / (result.conditions.torque * result.conditions.speed) / 0.05
    assert factor == pytest.approx(loss, rel=0.025)
    assert result.pressure_hertz_max / 1e9 == pytest.approx(largest, rel=0.03)
    if overlap == 0.0:  # the lines of helical gears are of several lengths when one of them crosses the pitch point
        at = min(result.load.positions, key=lambda p: float(np.abs(p.position.position[:, 0]).min()))
        point = int(np.argmin(np.abs(at.position.position[:, 0])))
        assert at.pressure_hertz[point] / 1e9 == pytest.approx(pitch_point, rel=0.01)


def test_elastic_teeth_share_by_stiffness() -> None:
    """In double contact the outer ends of the path carry less: the loss falls below that of even loads."""
    rigid, elastic = (pair("fzg_c14", sharing).mesh().load("200 N m").grids.fine for sharing in ("rigid", "elastic"))
    assert elastic.contact_ratio == pytest.approx(1.44, abs=0.03)
    ends = [
        (float(one.force[one.position.pair == k].sum()), float(two.force[two.position.pair == k].sum()))
        for one, two in zip(elastic.positions, rigid.positions, strict=True)
        for k in np.unique(one.position.pair)
        if abs(one.position.position[one.position.pair == k, 0][0]) > 8e-3
    ]
    assert len(ends) >= 4
    assert all(soft < even for soft, even in ends)


def test_tip_relief_takes_load_off_the_ends_of_the_path() -> None:
    plain = pair("fzg_c14", "elastic")
    member = {"tip_relief": 30e-6, "tip_relief_length": 4e-3}
    changes = {name: getattr(plain.design, name).model_copy(update=member) for name in ("pinion", "gear")}
    relieved = CylindricalPair(plain.design.model_copy(update=changes))
    end = relieved.design.involute.path[1]
    assert relieved.design.relief(np.array([end, end - 2e-3, end - 4e-3, 0.0])) == pytest.approx([30e-6, 15e-6, 0, 0])

    def share(found: CylindricalPair) -> float:
        load = found.mesh(positions=12, points_per_line=9).load("200 N m").grids.fine
        at_ends = [float(p.force[np.abs(p.position.position[:, 0]) > 7e-3].sum()) for p in load.positions]
        return sum(at_ends) / sum(float(p.force.sum()) for p in load.positions)

    assert share(relieved) < 0.7 * share(plain)


@pytest.mark.parametrize("name", ["fzg_c14", "fzg_h501"])
def test_levers_and_friction_arms_are_those_of_the_vectors(name: str) -> None:
    """Levers by r x n about each axis; velocities by omega x r: pinion less gear is the stated sliding."""
    involute = pair(name).design.involute
    pinion, gear = axes_of(involute)
    ratio = involute.teeth[1] / involute.teeth[0]
    for p in mesh_cycle(involute, 6, 7, np.zeros_like):
        for axis, lever in ((pinion, p.lever_pinion), (gear, p.lever_gear)):
            turning = np.cross(p.position - axis.origin, p.normal) @ axis.direction
            np.testing.assert_allclose(np.abs(turning), lever, rtol=1e-12)
        one = np.cross(pinion.direction, p.position - pinion.origin)
        two = np.cross(gear.direction, p.position - gear.origin) / -ratio
        np.testing.assert_allclose(np.sum((one - two) * p.normal, axis=1), 0.0, atol=1e-12)
        np.testing.assert_allclose(np.sum((one - two) * p.across, axis=1), p.sliding_across, atol=1e-12)
        np.testing.assert_allclose(0.5 * np.sum((one + two) * p.across, axis=1), p.entrainment, atol=1e-12)
        # energy: friction torque of the pinion less what it takes from the gear is the sliding
        arms = [friction_arm(p, axis) for axis in (pinion, gear)]
        lost = arms[0] - arms[1] / ratio
        np.testing.assert_allclose(np.abs(lost), np.abs(p.sliding_across), atol=1e-12)


def test_the_function_and_the_file_give_the_same_pair() -> None:
    made = efficiency.cylindrical(
        (20, 30), "3.5 mm", "23 mm", helix_angle="15 deg", profile_shift=(0.1809, 0.0891), torque="183.35 N m",
        speed="2250 rpm", temperature="90 degC", oil="fva3", finish="ground", roughness_rms="0.56 um",
    )  # fmt: skip
    read = efficiency.load("fzg_h501").design
    assert isinstance(read, CylindricalDesign)
    assert made.design.model_dump(exclude={"name", "source"}) == read.model_dump(exclude={"name", "source"})
    assert math.degrees(made.design.involute.base_helix) == pytest.approx(14.076, abs=1e-3)


def test_friction_of_a_gear_without_page_of_strength() -> None:
    result = efficiency.load("fzg_c14").mesh(positions=8, points_per_line=9).load().efficiency("schlenk_1994")
    assert result.status == "converged"
    assert 0.03 < result.friction_coefficient_mean < 0.08
    assert not result.has_strength


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"centre_distance": "80 mm"}, "centre_distance"),
        ({"centre_distance": "99 mm"}, "centre_distance"),
        ({"profile_shift": (1.2, -1.0)}, "tip_diameter"),
        ({"tip_relief": "20 um"}, "tip_relief_length"),
        ({"helix_angle": "60 deg"}, "helix_angle"),
    ],
)
def test_impossible_pairs_are_refused(changes: dict[str, object], field: str) -> None:
    with pytest.raises(InputError) as caught:
        efficiency.cylindrical(
            (16, 24), "4.5 mm", "14 mm", torque="200 N m", speed="1500 rpm", temperature="75 degC", oil="fva3",
            **changes,  # type: ignore[arg-type]
        )  # fmt: skip
    assert caught.value.field.rpartition(".")[2] == field


def test_what_belongs_to_bevel_gears_is_refused() -> None:
    found = efficiency.load("fzg_c14")
    for ask in (found.geometry, found.export, lambda: found.misaligned(E="0.1 mm")):
        with pytest.raises(InputError):
            ask()
