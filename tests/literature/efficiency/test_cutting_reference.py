"""Cut flanks against published data and independent computations (data/reference/gear_cutting.json)."""

from collections.abc import Callable

import numpy as np
import pytest
from reference_flanks import CUTTING, HEAD, HOBBED, MM, PINION, hobbed_blank, hobbed_gear, hobbed_pinion

from efficiency.cutting.blank import Blank
from efficiency.cutting.cutter import Blade
from efficiency.cutting.flank import CutFlank
from efficiency.cutting.limits import flank_limits
from efficiency.cutting.machine import MachineSettings

INCH = 25.4e-3
SIDES = ("concave", "convex")


@pytest.mark.parametrize("side", SIDES)
def test_face_hobbed_gear_has_its_spiral_and_pressure_angle_on_both_flanks(side: str) -> None:
    gear, at = hobbed_gear(side), np.zeros(1)
    spiral, pressure = gear.solve(at, at)[0].angles(gear.blank.pitch_angle)
    assert np.degrees(spiral[0]) == pytest.approx(HOBBED["printed"]["beta_m2"], abs=1e-9)
    assert np.degrees(pressure[0]) == pytest.approx(HEAD[f"alpha_{side}"], abs=1e-9)


def test_spiral_of_the_face_hobbed_gear_along_its_face() -> None:
    """Mean of both flanks at heel and toe against the printed angles, between them the trace of an epicycloid."""
    blank, printed = hobbed_blank(HOBBED["blank"]), HOBBED["printed"]
    u = np.linspace(-0.5, 0.5, 7) * blank.face_width
    spiral = 0.5 * sum(hobbed_gear(side).solve(u, 0.0 * u)[0].angles(blank.pitch_angle)[0] for side in SIDES)
    np.testing.assert_allclose(np.degrees(spiral[[0, -1]]), [printed["beta_i2"], printed["beta_e2"]], atol=0.01)
    gear = hobbed_gear("concave")
    radius, centre, rc = blank.mean_cone_distance + u, gear.machine.radial_setting, gear.blade.point_radius
    base = centre / (1.0 + gear.blade.groups / blank.teeth * np.sin(blank.pitch_angle))
    cosine = (radius**2 + centre**2 - rc**2) / (2.0 * radius * centre)
    trace = np.arctan((radius - base * cosine) / (base * np.sqrt(1.0 - cosine**2)))
    np.testing.assert_allclose(np.degrees(spiral), np.degrees(trace), atol=0.01)


def slot_angle(gear: Callable[[str], CutFlank]) -> float:
    concave, convex = (gear(side).solve(np.zeros(1), np.zeros(1))[0].azimuth[0] for side in SIDES)
    return float(abs(concave - convex))


def test_slot_of_the_face_hobbed_gear_is_that_of_its_blade_phase() -> None:
    angle = slot_angle(hobbed_gear)
    assert angle == pytest.approx(2.0 * HEAD["phase_rotation"], abs=1.1e-5)
    blank = hobbed_blank(HOBBED["blank"])
    pitch_radius = 0.5 * HOBBED["blank"]["mean_pitch_diameter"] * MM
    tooth = (2.0 * np.pi / blank.teeth - angle) * pitch_radius * np.cos(np.radians(HOBBED["printed"]["beta_m2"]))
    assert tooth / MM == pytest.approx(HOBBED["printed"]["smn2"], abs=1e-9)


def test_hobbed_pinion_angles() -> None:
    at = np.zeros(1)
    for side in SIDES:
        pinion = hobbed_pinion(side)
        spiral, _ = pinion.solve(at, at)[0].angles(pinion.blank.pitch_angle)
        # crowned flanks differ from the conjugate ones by minutes of arc
        assert np.degrees(spiral[0]) == pytest.approx(PINION["spiral_angle"], abs=0.02)


def gleason_blank() -> Blank:
    b = CUTTING["gleason_no16_gear_10x41"]["blank"]
    pitch_angle = np.radians(b["pitch_angle"])
    face, outer = b["face_width"] * INCH, b["outer_cone_distance"] * INCH
    addendum_angle, dedendum_angle = (
        np.radians(b["face_angle"]) - pitch_angle,
        pitch_angle - np.radians(b["root_angle"]),
    )
    addendum, depth = b["outer_addendum"] * INCH, b["outer_whole_depth"] * INCH
    crown = outer * np.cos(pitch_angle) - addendum * np.sin(pitch_angle)
    return Blank(
        teeth=b["teeth"], pitch_angle=pitch_angle, mean_cone_distance=outer - 0.5 * face, face_width=face,
        mean_addendum=addendum - 0.5 * face * np.tan(addendum_angle),
        mean_dedendum=depth - addendum - 0.5 * face * np.tan(dedendum_angle), addendum_angle=addendum_angle,
        dedendum_angle=dedendum_angle, pitch_apex_beyond_crossing=crown - b["crown_to_crossing"] * INCH,
    )  # fmt: skip


def gleason_gear(side: str) -> CutFlank:
    """Spread-blade gear of the sheet: roll ratio from the teeth of the crown gear, machine settings as printed."""
    values = CUTTING["gleason_no16_gear_10x41"]
    m, c, blank = values["machine"], values["cutter"], gleason_blank()
    machine = MachineSettings(
        radial_setting=m["radial_setting"] * INCH, cradle_angle=np.radians(m["cradle_angle"]),
        machine_root_angle=np.radians(m["machine_root_angle"]), roll_ratio=75.0 * m["nc75_ratio"] / blank.teeth,
        blank_offset=m["blank_offset"] * INCH, sliding_base=m["sliding_base"] * INCH,
        machine_centre_to_back=m["machine_centre_to_back"] * INCH,
    )  # fmt: skip
    sign, angle = (1.0, c["outside_blade"]) if side == "concave" else (-1.0, c["inside_blade"])
    radius = 0.5 * (c["diameter"] + sign * c["point_width"]) * INCH
    return CutFlank(Blade(radius, np.radians(angle), side, edge_radius=c["edge_radius"] * INCH), machine, blank)  # type: ignore[arg-type]


def test_gleason_gear_tooth() -> None:
    """Thickness to the printed digits; angles within what the settings' own digits and the taper leave.

    The sheet's pressure angles are those of the blades, measured against the root line; the flank at the pitch cone
    has them within 0.35 deg. Its spiral angle is that of the slot's middle in the root plane (26.93 deg there).
    """
    values, blank, at = CUTTING["gleason_no16_gear_10x41"], gleason_blank(), np.zeros(1)
    printed, cutter = values["printed"], values["cutter"]
    points = {side: gleason_gear(side).solve(at, at)[0] for side in SIDES}
    spiral = np.mean([points[side].angles(blank.pitch_angle)[0][0] for side in SIDES])
    assert np.degrees(spiral) == pytest.approx(printed["spiral_angle"], abs=0.3)
    root_angle = blank.pitch_angle - blank.dedendum_angle
    for side, blade in (("concave", "outside_blade"), ("convex", "inside_blade")):
        assert np.degrees(points[side].angles(root_angle)[1][0]) == pytest.approx(cutter[blade], abs=0.35)
    angle = slot_angle(gleason_gear)
    radius = np.hypot(points["concave"].position[0], points["concave"].position[1])[0]
    thickness = (2.0 * np.pi / blank.teeth - angle) * radius * np.cos(spiral)
    assert thickness / INCH == pytest.approx(printed["normal_chordal_thickness"], abs=1.5e-4)
    heel = np.array([0.5 * blank.face_width])
    outside = 2.0 * blank.axial(heel, blank.tip(heel))[0][0]
    assert outside / INCH == pytest.approx(values["blank"]["outside_diameter"], abs=5e-4)


@pytest.mark.parametrize("side", SIDES)
def test_gleason_gear_root_and_back_of_the_cutter(side: str) -> None:
    values, gear = CUTTING["gleason_no16_gear_10x41"], gleason_gear(side)
    limits = flank_limits(gear, stations=5)
    depth = (limits.tip - limits.root) / INCH
    # machine settings are printed to 0.005 in
    assert depth[2] == pytest.approx(values["printed"]["whole_depth_mid"], abs=0.005)
    assert depth[-1] == pytest.approx(values["printed"]["whole_depth_heel"], abs=0.005)
    assert not limits.undercut.any()
