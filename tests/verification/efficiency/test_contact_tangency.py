"""Unloaded contact of every shipped design against direct tangency in space; random blanks with undercut gears."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from direct_tangency import check_path

from efficiency.blanks.inputs import PairBlankInput
from efficiency.blanks.pair import pair_blank
from efficiency.contact.conjugate import EaseOffTarget, conjugate_flank
from efficiency.contact.contact_search import contact_path, transmission
from efficiency.contact.flank_pair import flank_pair
from efficiency.contact.mesh_surface import MeshSurface, mesh_surface
from efficiency.design.design import Design, bevel_names, load_design
from efficiency.ltca.limits import edge_load
from efficiency.machine_settings.gear import cut_gear, pair_dimensions
from efficiency.machine_settings.inputs import SettingsInput
from efficiency.machine_settings.solve import machine_settings
from efficiency.pair import GearPair
from ehl.common.errors import ConvergenceError
from ehl.common.units import ARCSEC
from ehl.common.validation import validate

SIDES: tuple[Any, ...] = ("drive", "coast")
ALL = {"E": -5e-5, "P": 5e-5, "G": 5e-5, "shaft_angle_error": -5e-4}
STATES: tuple[dict[str, float], ...] = ({}, {"E": 1e-4}, {"P": -1e-4}, {"G": 1e-4}, ALL)


@pytest.mark.parametrize("side", SIDES)
# the path is that of flanks without relief: that of pairs made for relief runs over their tips
@pytest.mark.parametrize("name", [name for name in bevel_names() if not name.endswith("_relieved")])
def test_path_and_transmission_error_against_direct_tangency(name: str, side: Any) -> None:
    """Asked for: 0.1 arcsec and 0.05 mm in five states of misalignment. Flanks and edges, 0.7 pitches to both sides."""
    design = load_design(name)
    grid = None
    for state in STATES:
        pinion, gear = design.flanks().mating(side)
        surface = mesh_surface(gear, pinion, design.with_misalignment(**state).placement(), grid=grid)
        grid = surface.grid
        path = contact_path(surface, surface.error_maximum_roll + np.linspace(-0.7, 0.7, 7) * surface.pitch)
        assert path.settled.all()
        error, distance, free, _ = check_path(surface, path)
        assert free >= 4
        assert error / ARCSEC < 0.02
        assert distance < 0.02e-3


def test_edges_of_both_members_against_direct_tangency(design: Design) -> None:
    touched, compared = set(), 0
    states = [("drive", {"E": 3e-4}), ("drive", {"P": -2e-4}), ("coast", {"G": 2e-4}), ("coast", {"P": -1e-4})]
    for side, state in states:
        pinion, gear = design.flanks().mating(side)
        surface = mesh_surface(gear, pinion, design.with_misalignment(**state).placement())
        path = contact_path(surface, surface.error_maximum_roll + np.linspace(-1.0, 1.0, 13) * surface.pitch)
        assert path.settled.all()
        error, distance, _, edges = check_path(surface, path)
        assert error / ARCSEC < 1e-3
        assert distance < 1e-6
        touched |= set(path.edges)
        compared += edges
    assert {"gear tip", "pinion tip"} < touched
    assert any(name.endswith(("toe", "heel")) for name in touched)
    assert compared > 12


def test_curve_of_the_mesh_is_the_upper_envelope_of_its_pairs(design: Design) -> None:
    pair = flank_pair(design.flanks())
    mesh, pitch = pair.transmission, pair.surface.pitch
    angle = mesh.pinion_angle[5::97]
    single = [contact_path(pair.surface, angle + k * pitch).transmission_error for k in range(-2, 3)]
    np.testing.assert_allclose(mesh.at(angle), np.max(single, axis=0), atol=0.005 * ARCSEC)
    # a parabola per pitch has amplitudes like 1/order^2
    assert mesh.harmonics[0] / mesh.harmonics[1] == pytest.approx(4.0, rel=0.02)
    assert mesh.harmonics[0] == pytest.approx(mesh.peak_to_peak * 4.0 / np.pi**2, rel=0.05)


RELIEF = EaseOffTarget(lengthwise_crowning=40e-6, profile_crowning=12e-6)
HOBBED: dict[str, Any] = {
    "name": "both roots of the equation of meshing near the axial plane",
    "method": 1, "process": "face_hobbing", "teeth_pinion": 12, "teeth_gear": 36, "hand_pinion": "left",
    "shaft_angle": "65.507 deg", "hypoid_offset": "24.8573 mm", "outer_pitch_diameter_gear": "124.582 mm",
    "face_width_gear": "21.132 mm", "mean_spiral_angle_pinion": "36.198 deg", "cutter_radius": "81.818 mm",
    "blade_groups": 13, "pressure_angle": {"drive": "24.011 deg", "coast": "24.011 deg"},
    "backlash": {"type": "mean_normal", "value": "0.09 mm"},
}  # fmt: skip
MILLED: dict[str, Any] = {
    "name": "generated gear undercut below its working depth",
    "method": 0, "process": "face_milling", "teeth_pinion": 18, "teeth_gear": 40, "hand_pinion": "right",
    "shaft_angle": "67.751 deg", "hypoid_offset": "0 mm", "outer_pitch_diameter_gear": "178.465 mm",
    "face_width_gear": "29.245 mm", "mean_spiral_angle_gear": "6.041 deg", "cutter_radius": "124.137 mm",
    "pressure_angle": {"drive": "16.685 deg", "coast": "16.685 deg"},
    "backlash": {"type": "mean_normal", "value": "0.12 mm"},
}  # fmt: skip


@pytest.fixture(scope="module", params=[HOBBED, MILLED], ids=["hobbed", "milled"])
def surface(request: pytest.FixtureRequest) -> MeshSurface:
    """Generated gear and the pinion conjugate to it less `RELIEF`."""
    geometry = pair_dimensions(pair_blank(validate(PairBlankInput, request.param)))
    gear = cut_gear(geometry).flank("convex")
    return mesh_surface(gear, conjugate_flank(gear, geometry.pinion, geometry.assembly, RELIEF), geometry.assembly)


def test_ease_off_is_the_one_asked_for(surface: MeshSurface) -> None:
    u, v = surface.grid.u[:-1], surface.grid.v[:-1]
    inside = surface.margin(u, v) > 0.0
    gear, pinion = surface.gear.blank, surface.pinion.blank
    low, high = -pinion.mean_addendum, gear.mean_addendum
    depth = (surface.height(u, v) - 0.5 * (low + high)) / (0.5 * (high - low))
    asked = RELIEF(2.0 * u / gear.face_width, depth)[inside]
    measured, lever = surface.patch(u[inside], v[inside], ("ease_off", "lever"))
    # the pinion may turn as a whole
    turned = np.sum((measured - asked) * lever) / np.sum(lever * lever)
    assert inside.sum() > 100
    assert np.abs(measured - asked - turned * lever).max() < 0.3e-6


def test_a_contact_out_of_proportion_with_the_ease_off_is_refused(surface: MeshSurface) -> None:
    # a gear flank at another azimuth than the one used for the ease-off
    patch = surface.patch
    spoilt = patch.coefficients.copy()
    spoilt[0, 1, list(patch.names).index("azimuth")] += 0.02
    with pytest.raises(ConvergenceError, match="out of proportion"):
        transmission(replace(surface, patch=replace(patch, coefficients=spoilt)))


def test_lines_beyond_the_limit_of_undercut_carry_no_load() -> None:
    """Near the heel the lines at the gear tip pass the limit of undercut in this misaligned state.

    The flanks separate there to both sides of the largest penetration. Taken as contact, 2.1 % of the torque was on
    the tip edge whatever its relief, and the loaded transmission error had a step of 130 arcsec.
    """
    end, flank = {"amount": "26 um", "length": "2.5 mm"}, {"crowning_toe": "61 um", "crowning_heel": "61 um"}
    flank |= {"relief_root": "15 um", "relief_tip": "15 um", "bias": -0.25}
    blank = {
        "name": "milled", "method": 0, "process": "face_milling", "teeth_pinion": 12, "teeth_gear": 23,
        "hand_pinion": "right", "outer_pitch_diameter_gear": "129.227 mm", "face_width_gear": "21.0434 mm",
        "mean_spiral_angle_gear": "22.854 deg", "cutter_radius": "51.7077 mm", "taper": {"type": "tilted_root"},
        "backlash": {"type": "outer_transverse", "value": "0.129 mm"},
    }  # fmt: skip
    targets = {
        "name": "milled", "blank": blank, "cutting": {"gear": "formate", "pinion": "each_flank"},
        "targets": {"drive": flank, "coast": flank},
        "operation": {"torque": "169 N m", "speed": "2865 rpm", "temperature": "90 degC", "oil": "75w90"},
    }  # fmt: skip
    for member, tip in (("pinion", "35 um"), ("gear", "69 um")):
        targets[member] = {"edge_relief": {"tip": {"amount": tip, "length": "2.2 mm"}, "toe": end, "heel": end}}
    pair = GearPair(machine_settings(validate(SettingsInput, targets), transmission=False).design)
    mesh = pair.mesh("drive", positions=12, points_per_line=21, E=5e-5, P=5e-5, G=5e-5)
    load = mesh.load("169 N m").grids.fine
    assert edge_load(load, mesh.grids.teeth).share < 1e-3
    assert float(np.ptp(load.transmission_error)) < 80.0 * ARCSEC
