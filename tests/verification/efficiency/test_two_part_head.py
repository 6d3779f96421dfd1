"""Two-part heads against a second algorithm, ISO 23509 and the one-part head; a pinion with one tooth."""

import math
from typing import Any

import numpy as np
import pytest
from refusals import refuses
from twins.two_part_head import HeadFlank

import efficiency
from efficiency.blanks.inputs import PairBlankInput
from efficiency.blanks.method_1 import lengthwise_radius
from efficiency.blanks.pair import pair_blank
from efficiency.blanks.tangency import PitchCones
from efficiency.contact.tooth_grid import normal_thickness, tooth_grid
from efficiency.cutting.cutter import FLANK_SIDES
from efficiency.cutting.flank import CutFlank
from efficiency.design.design import Design, load_design
from efficiency.loss.closed_form import PitchGeometry, buckingham_type, lengthwise_sliding
from efficiency.ltca.ritz_solid import Orders
from efficiency.ltca.solid_tooth import solid_tooth_of
from efficiency.machine_settings.inputs import SettingsInput, load_targets
from efficiency.machine_settings.settings_result import SettingsResult
from efficiency.machine_settings.solve import machine_settings
from ehl.common.validation import validate

NAME = "tp_spiral_bevel_12x37_relieved"


def targets(blank: str, machine: str = "free_form", **ease_off: float) -> SettingsInput:
    """Shipped targets of a face-hobbed pair for the two-part head, both members generated."""
    content = load_targets(blank).model_dump(exclude_unset=True)
    content["blank"]["process"] = "two_part_face_hobbing"
    content["cutting"] = {"gear": "generated", "machine": machine}
    for side in ("drive", "coast"):
        content["targets"][side] |= ease_off
    return validate(SettingsInput, content)


@pytest.fixture(scope="module")
def hypoid() -> SettingsResult:
    return machine_settings(targets("fh_hypoid_9x34"), transmission=False)


@pytest.fixture(scope="module")
def pairs(hypoid: SettingsResult) -> dict[str, Design]:
    bevel = load_design(NAME)
    eccentric = bevel.model_dump()
    for member in ("pinion", "gear"):
        for side in FLANK_SIDES:
            eccentric[member][side]["cutter"] |= {"eccentricity": 2e-3, "eccentricity_angle": 0.1}
    return {"spiral bevel": bevel, "hypoid": hypoid.design, "both members eccentric": validate(Design, eccentric)}


def twin(content: dict[str, Any], member: str, side: str) -> HeadFlank:
    return HeadFlank(content[member][side], content[member]["blank"], side)


def places(flank: CutFlank) -> tuple[np.ndarray, np.ndarray]:
    u, share = (g.ravel() for g in np.meshgrid(np.linspace(-0.45, 0.45, 5), np.linspace(0.35, 0.95, 4)))
    u = u * flank.blank.face_width
    return u, flank.blank.height(u, share)


def changed(design: Design, member: str, **cutter: Any) -> dict[str, CutFlank]:
    one = getattr(design, member)
    out = {}
    for side in FLANK_SIDES:
        table = getattr(one, side)
        out[side] = table.model_copy(update={"cutter": table.cutter.model_copy(update=cutter)}).flank(side, one.blank)
    return out


@pytest.mark.parametrize("pair", ["spiral bevel", "hypoid", "both members eccentric"])
def test_flanks_are_the_envelope_of_the_swept_edge(pairs: dict[str, Design], pair: str) -> None:
    design = pairs[pair]
    content = design.model_dump()
    for member in ("pinion", "gear"):
        for side in FLANK_SIDES:
            flank, second = design.flank(member, side), twin(content, member, side)
            u, h = places(flank)
            points, found = flank.solve(u, h)
            assert found.mean() > 0.9
            target = second.cone(u, h)[:, found]
            azimuth, _ = second.azimuth(target)
            off = np.angle(np.exp(1j * (azimuth - points.azimuth[found])))
            assert np.abs(off * target[0]).max() < 1e-12


def iso_curvature(eccentricity: float) -> float:
    """1/rho_mbeta of ISO 23509 [1/m] for blades moved out by an eccentricity: r cos nu grows by it, r sin nu stays."""
    design, inputs = load_design(NAME), load_targets(NAME).blank
    spiral, cone = pair_blank(inputs).gear.mean_spiral_angle, design.gear.blank.mean_cone_distance
    angle, lead = design.gear.blank.pitch_angle, design.gear.concave.cutter.blade_offset_angle
    cones = PitchCones(angle, angle, cone, cone, spiral, spiral, 0.5)
    radius = math.hypot(inputs.cutter_radius * math.cos(lead) + eccentricity, inputs.cutter_radius * math.sin(lead))
    return 1.0 / lengthwise_radius(inputs.model_copy(update={"cutter_radius": radius}), cones)


@pytest.mark.parametrize("e", [1e-3, 5e-3])
def test_crowning_of_an_eccentricity_is_that_of_the_lengthwise_radii_of_iso_23509(e: float) -> None:
    """At the mean point the distance grows with half the difference of the curvatures."""
    design, u = load_design(NAME), np.linspace(-5e-3, 5e-3, 11)
    spiral = pair_blank(load_targets(NAME).blank).gear.mean_spiral_angle
    pressure = design.gear.concave.cutter.blade_angle
    none, with_it = (changed(design, "gear", eccentricity=value) for value in (0.0, e))
    for side, sign in (("concave", 1.0), ("convex", -1.0)):
        one, other = (flanks[side].solve(u, 0.0 * u)[0] for flanks in (none, with_it))
        distance = np.sum((other.position - one.position) * one.normal, axis=0)
        found = np.polynomial.Polynomial.fit(u, distance, 5).convert().coef
        bent = 0.5 * abs(iso_curvature(sign * e) - iso_curvature(0.0))
        # positive eccentricity removes material at the ends of both flanks
        assert found[2] == pytest.approx(-bent * math.cos(pressure) / math.cos(spiral) ** 2, rel=1e-5)
        assert abs(found[0]) < 1e-9
        assert abs(found[1]) < 1e-6


@pytest.mark.parametrize("pair", ["spiral bevel", "hypoid"])
def test_mean_thickness_is_that_of_the_blank(pairs: dict[str, Design], pair: str) -> None:
    inputs = load_targets(NAME if pair == "spiral bevel" else "fh_hypoid_9x34")
    wanted, flanks = pair_blank(inputs.blank.model_copy(update={"gear_cutting": "generated"})), pairs[pair].flanks()
    gear, pinion = (
        normal_thickness(flanks, member, np.array([-getattr(wanted, member).middle_shift]), np.zeros(1))[0]
        for member in ("gear", "pinion")
    )
    assert gear == pytest.approx(wanted.gear.mean_normal_thickness, rel=1e-6)
    # touching flanks against the fit on the whole of both; the ease-off thins the tooth at the pitch cone
    assert pinion == pytest.approx(wanted.pinion.mean_normal_thickness, abs=8e-6)


def test_hypoid_from_targets(hypoid: SettingsResult) -> None:
    assert hypoid.status == "converged"
    assert hypoid.rms < 1e-6
    assert max(np.abs(flank.fitted.root_error).max() for flank in hypoid.flanks) < 0.2e-3
    pinion = hypoid.design.pinion
    assert pinion.concave.machine == pinion.convex.machine
    for side in FLANK_SIDES:
        assert 0.5e-3 < getattr(pinion, side).cutter.eccentricity < 5e-3
        assert getattr(hypoid.design.gear, side).cutter.eccentricity == 0.0


def test_gear_and_pinion_share_the_eccentricity() -> None:
    plain, sums, found = targets("fh_hypoid_9x34_offset_10", "cradle"), [], []
    for value in (0.0, 1e-3):
        cutting = plain.cutting.model_copy(update={"gear_eccentricity": value})
        result = machine_settings(plain.model_copy(update={"cutting": cutting}), transmission=False)
        assert result.rms < 1.5e-6
        assert result.design.gear.concave.cutter.eccentricity == pytest.approx(value)
        found.append(result.design.pinion.concave.cutter.eccentricity)
        sums.append(found[-1] + result.design.gear.convex.cutter.eccentricity)
    assert found[1] < 0.7 * found[0]
    assert sums[1] == pytest.approx(sums[0], rel=0.05)


@pytest.mark.parametrize(("process", "value"), [("face_hobbing", 1e-3), ("two_part_face_hobbing", 16e-3)])
def test_gear_eccentricity_is_checked(process: str, value: float) -> None:
    content = targets("fh_hypoid_9x34").model_dump(exclude_unset=True)
    content["blank"]["process"] = process
    content["cutting"]["gear_eccentricity"] = value
    with refuses("cutting.gear_eccentricity"):
        validate(SettingsInput, content)


def test_crowning_beyond_the_head_is_refused() -> None:
    with refuses("eccentricity"):
        machine_settings(targets("fh_spiral_bevel_12x37", crowning_toe=1e-3, crowning_heel=1e-3), transmission=False)


@pytest.mark.parametrize("value", [None, -6e-3, 16e-3, 0.1, float("nan")])
def test_invalid_eccentricities_are_refused(value: float | None) -> None:
    content = load_design(NAME).model_dump()
    cutter = content["pinion"]["concave"]["cutter"]
    cutter["eccentricity"] = value
    if value is None:
        del cutter["eccentricity"]
    with refuses("pinion.concave.cutter.eccentricity"):
        validate(Design, content)


EASE_OFF = {"crowning_toe": "10 um", "crowning_heel": "10 um", "relief_root": "4 um", "relief_tip": "4 um"}
BLANK = {
    "name": "1x60", "method": 1, "process": "face_milling", "teeth_pinion": 1, "teeth_gear": 60,
    "hypoid_offset": "30 mm", "outer_pitch_diameter_gear": "150 mm", "face_width_gear": "12 mm",
    "mean_spiral_angle_pinion": "75 deg", "cutter_radius": "60 mm", "depth": {
        "data_type": "I", "profile_shift": 0.65, "addendum_factor": 0.85, "dedendum_factor": 1.1,
        "thickness_modification": 0.06,
    },
}  # fmt: skip
MEMBER = {"material": "steel", "finish": "ground"}


@pytest.fixture(scope="module")
def design() -> Design:
    content = {
        "name": "1x60",
        "blank": BLANK,
        "cutting": {"gear": "formate", "pinion": "each_flank"},
        "targets": {"drive": EASE_OFF, "coast": EASE_OFF},
        "pinion": MEMBER,
        "gear": MEMBER,
        "operation": {"torque": "5 N m", "speed": "1500 rpm", "temperature": "60 degC", "oil": "75w90"},
    }  # fmt: skip
    made = efficiency.settings(validate(SettingsInput, content))
    assert made.status == "converged"
    # as much as the ease-off makes, 4 um over the depth: no other turn of the thread takes part
    assert made.concave.transmission.edges == ()
    assert made.concave.transmission.peak_to_peak == pytest.approx(6.36 / 206265.0, rel=0.02)
    return made.design


def test_a_pinion_with_one_tooth_runs(design: Design) -> None:
    assert tooth_grid(design.flanks(), "pinion", 7, 7).winding > 6.0 * np.pi
    pair = efficiency.GearPair(design)
    result = pair.at("constant:0.05", grid=(6, 15))
    assert result.status == "converged"
    assert 1e9 < result.pressure_hertz_max < 3e9
    # the lengthwise sliding of the pitch point, and profile sliding on top of it
    made = efficiency.blank(validate(PairBlankInput, BLANK))
    pinion, gear = made.pinion, made.gear
    angles = pinion.mean_spiral_angle, gear.mean_spiral_angle, pinion.pitch_angle, gear.pitch_angle
    sizes = 0.5 * pinion.mean_diameter, 0.5 * gear.mean_diameter, made.module_normal
    pitch = PitchGeometry(made.pressure_angle_drive, *angles, *sizes, made.virtual_drive.contact_ratio_profile)
    assert result.efficiency < lengthwise_sliding(pitch, 0.05)
    assert result.efficiency == pytest.approx(buckingham_type(pitch, 0.05), abs=0.03)


def test_the_next_tooth_of_a_ring_of_one_is_the_loaded_one(design: Design) -> None:
    body = design.pinion.tooth_body()
    tooth = solid_tooth_of(design.flanks(), body, "pinion", "drive", Orders((4, 5, 10), (4, 4, 8)))
    # far from the load, where no local deformation is subtracted
    assert tooth.ahead[0][0, -1] == pytest.approx(tooth.own[0, -1], rel=0.05, abs=1e-3 * np.abs(tooth.own).max())
