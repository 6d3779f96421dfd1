"""Cut flanks against published data and independent computations (data/reference/gear_cutting.json)."""

import numpy as np
import pytest
from reference_flanks import CUTTING, HOBBED, hobbed_blank, hobbed_gear

from efficiency.cutting.blank import Blank
from efficiency.cutting.cutter import Blade
from efficiency.cutting.flank import CutFlank
from efficiency.cutting.limits import flank_limits
from efficiency.cutting.machine import MachineSettings

INCH = 25.4e-3
GLEASON = CUTTING["gleason_no16_gear_10x41"]
SIDES = ("concave", "convex")


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


def gleason_blank() -> Blank:
    b = GLEASON["blank"]
    pitch_angle, face_angle, root_angle = (np.radians(b[f"{name}_angle"]) for name in ("pitch", "face", "root"))
    face, outer = b["face_width"] * INCH, b["outer_cone_distance"] * INCH
    addendum_angle, dedendum_angle = face_angle - pitch_angle, pitch_angle - root_angle
    addendum, depth = b["outer_addendum"] * INCH, b["outer_whole_depth"] * INCH
    crown = outer * np.cos(pitch_angle) - addendum * np.sin(pitch_angle)
    return Blank(
        teeth=b["teeth"], pitch_angle=pitch_angle, mean_cone_distance=outer - 0.5 * face, face_width=face,
        mean_addendum=addendum - 0.5 * face * np.tan(addendum_angle),
        mean_dedendum=depth - addendum - 0.5 * face * np.tan(dedendum_angle), addendum_angle=addendum_angle,
        dedendum_angle=dedendum_angle, pitch_apex_beyond_crossing=crown - b["crown_to_crossing"] * INCH,
        hand="right",
    )  # fmt: skip


def gleason_gear(side: str) -> CutFlank:
    """Spread-blade gear of the sheet: roll ratio from the teeth of the crown gear, machine settings as printed."""
    m, c, blank = GLEASON["machine"], GLEASON["cutter"], gleason_blank()
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
    printed, cutter, blank, at = GLEASON["printed"], GLEASON["cutter"], gleason_blank(), np.zeros(1)
    points = {side: gleason_gear(side).solve(at, at)[0] for side in SIDES}
    spiral = np.mean([points[side].angles(blank.pitch_angle)[0][0] for side in SIDES])
    assert np.degrees(spiral) == pytest.approx(printed["spiral_angle"], abs=0.3)
    root_angle = blank.pitch_angle - blank.dedendum_angle
    for side, blade in (("concave", "outside_blade"), ("convex", "inside_blade")):
        assert np.degrees(points[side].angles(root_angle)[1][0]) == pytest.approx(cutter[blade], abs=0.35)
    angle = abs(points["concave"].azimuth[0] - points["convex"].azimuth[0])
    radius = np.hypot(points["concave"].position[0], points["concave"].position[1])[0]
    thickness = (2.0 * np.pi / blank.teeth - angle) * radius * np.cos(spiral)
    assert thickness / INCH == pytest.approx(printed["normal_chordal_thickness"], abs=1.5e-4)
    heel = np.array([0.5 * blank.face_width])
    outside = 2.0 * blank.axial(heel, blank.tip(heel))[0][0]
    assert outside / INCH == pytest.approx(GLEASON["blank"]["outside_diameter"], abs=5e-4)


@pytest.mark.parametrize("side", SIDES)
def test_gleason_gear_root_and_back_of_the_cutter(side: str) -> None:
    printed, limits = GLEASON["printed"], flank_limits(gleason_gear(side), stations=5)
    depth = (limits.tip - limits.root) / INCH
    # machine settings are printed to 0.005 in
    assert depth[2] == pytest.approx(printed["whole_depth_mid"], abs=0.005)
    assert depth[-1] == pytest.approx(printed["whole_depth_heel"], abs=0.005)
    assert not limits.undercut.any()
