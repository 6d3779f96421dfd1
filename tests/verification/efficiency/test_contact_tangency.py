"""Unloaded contact of every shipped design against direct tangency in space, edges included."""

from typing import Any

import numpy as np
import pytest
from direct_tangency import check_path

from efficiency.contact.contact_search import contact_path
from efficiency.contact.flank_pair import flank_pair
from efficiency.contact.mesh_surface import mesh_surface
from efficiency.design.design import Design, bevel_names, load_design
from ehl.common.units import ARCSEC

SIDES: tuple[Any, ...] = ("drive", "coast")
STATES: tuple[dict[str, float], ...] = (
    {},
    {"E": 1e-4},
    {"P": -1e-4},
    {"G": 1e-4},
    {"E": -5e-5, "P": 5e-5, "G": 5e-5, "shaft_angle_error": -5e-4},
)


@pytest.mark.parametrize("side", SIDES)
# the path is that of flanks without relief: that of pairs made for relief runs over their tips
@pytest.mark.parametrize("name", [name for name in bevel_names() if not name.endswith("_relieved")])
def test_path_and_transmission_error_against_direct_tangency(name: str, side: Any) -> None:
    """Asked for: 0.1 arcsec and 0.05 mm in five states of misalignment. Flanks and edges, 0.7 pitches to both sides."""
    design = load_design(name)
    grid, before = None, None
    for state in STATES:
        pinion, gear = design.flanks().mating(side)
        assembly = design.with_misalignment(**state).placement()
        surface = mesh_surface(gear, pinion, assembly, grid=grid)
        grid = surface.grid
        path = contact_path(surface, surface.error_maximum_roll + np.linspace(-0.7, 0.7, 7) * surface.pitch)
        assert path.settled.all()
        check = check_path(surface, path, before)
        before = before or (assembly, check.tangency)
        assert check.free == path.free.sum() >= 4
        assert check.transmission_error / ARCSEC < 0.02
        assert check.distance < 0.02e-3


def test_edges_of_both_members_against_direct_tangency(bevel: Design) -> None:
    """Misaligned so that tip, toe and heel edges come into contact within a pitch."""
    touched, compared = set(), 0
    for side, state in (
        ("drive", {"E": 3e-4}),
        ("drive", {"P": -2e-4}),
        ("coast", {"G": 2e-4}),
        ("coast", {"P": -1e-4}),
    ):
        pinion, gear = bevel.flanks().mating(side)  # type: ignore[arg-type]
        surface = mesh_surface(gear, pinion, bevel.with_misalignment(**state).placement())
        path = contact_path(surface, surface.error_maximum_roll + np.linspace(-1.0, 1.0, 13) * surface.pitch)
        assert path.settled.all()
        check = check_path(surface, path)
        assert check.transmission_error / ARCSEC < 1e-3
        assert check.distance < 1e-6
        touched |= set(path.edges)
        compared += check.edge
    assert {"gear tip", "pinion tip"} < touched
    assert any(name.endswith(("toe", "heel")) for name in touched)
    assert compared > 12


@pytest.fixture(scope="module")
def bevel() -> Design:
    return load_design("fm_spiral_bevel_14x39")


def test_error_falls_with_the_grid(bevel: Design) -> None:
    """More Chebyshev coefficients: the error falls fast, and the estimate is not far below it."""
    pinion, gear = bevel.flanks().mating("drive")
    errors, estimates = [], []
    for shape in ((6, 5), (9, 7), (13, 10)):
        surface = mesh_surface(gear, pinion, bevel.placement(), shape=shape)
        path = contact_path(surface, surface.error_maximum_roll + np.array([-0.4, 0.0, 0.4]) * surface.pitch)
        assert path.free.all()
        errors.append(check_path(surface, path).transmission_error * 0.07)
        estimates.append(surface.interpolation_error)
    assert errors[1] < 0.2 * errors[0]
    assert errors[2] < 0.2 * errors[1]
    assert (np.array(errors) < 10.0 * np.array(estimates)).all()


def test_curve_of_the_mesh_is_the_upper_envelope_of_its_pairs(bevel: Design) -> None:
    pair = flank_pair(bevel.flanks())
    mesh, pitch = pair.transmission, pair.surface.pitch
    angle = mesh.pinion_angle[5::97]
    single = [contact_path(pair.surface, angle + k * pitch).transmission_error for k in range(-2, 3)]
    np.testing.assert_allclose(mesh.at(angle), np.max(single, axis=0), atol=0.005 * ARCSEC)
    # a parabola per pitch has amplitudes like 1/order^2
    ratio = mesh.harmonics[0] / mesh.harmonics[1]
    assert ratio == pytest.approx(4.0, rel=0.05)
    assert mesh.harmonics[0] == pytest.approx(mesh.peak_to_peak * 4.0 / np.pi**2, rel=0.05)
