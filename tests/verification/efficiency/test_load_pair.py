"""The face-milled 14x39 pair from its design file to its efficiency."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from efficiency.design.design import load_design
from efficiency.loss.closed_form import profile_contact_ratio
from efficiency.loss.efficiency import LoadedGrids, load_grids, mesh_efficiency
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.kinematics import Operation
from efficiency.ltca.load_distribution import distribute_load, elastic_cycle
from efficiency.mesh import Mesh
from ehl.fluid.oil import Oil
from regression.formula import friction_model
from regression.friction.models import ConstantFriction

DESIGN = load_design("fm_spiral_bevel_14x39")
OIL = Oil.load("75w90")
OPERATION = Operation(1200.0 * math.pi / 30.0, 363.15, 0.4e-6, 0.4e-6)


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    return Mesh.of(DESIGN, "drive", 12, 15, keep=True)


@pytest.fixture(scope="module")
def loaded(mesh: Mesh) -> LoadedGrids:
    return load_grids(mesh.grids, 300.0)


def efficiency(loaded: LoadedGrids, mu: float) -> EfficiencyResult:
    return mesh_efficiency(loaded, ConstantFriction(mu), OIL, OPERATION)


def test_cycle_closes(mesh: Mesh) -> None:
    """The load goes over smoothly from the last position to the first one, one tooth pair further."""
    share = {}
    for k, load in enumerate(load_grids(mesh.grids, 300.0).fine.positions):
        for pair, part in load.share.items():
            share[12 * pair + k] = part
    order = sorted(share)
    values = np.array([share[k] for k in order])
    assert order == list(range(order[0], order[-1] + 1))
    assert values[0] < 0.02
    assert values[-1] < 0.02
    assert np.max(np.abs(np.diff(values))) < 0.12
    assert 0.75 < values.max() < 0.95


def test_error_estimate_covers_a_finer_grid(mesh: Mesh) -> None:
    """12 x 21 points: stated error at most 0.8 % of the loss, true error at most 0.08 %."""
    bodies = mesh.grids.teeth.pinion, mesh.grids.teeth.gear
    default, fine = (Mesh.of(DESIGN, "drive", *grid, bodies=bodies).grids for grid in ((12, 21), (24, 41)))
    models = [ConstantFriction(0.05), friction_model("xu_kahraman_2007")]
    for torque in (30.0, 300.0):
        on_default, on_fine = load_grids(default, torque), load_grids(fine, torque)
        for model in models:
            coarse = mesh_efficiency(on_default, model, OIL, OPERATION)
            truth = mesh_efficiency(on_fine, model, OIL, OPERATION)
            assert abs(coarse.efficiency - truth.efficiency) < coarse.efficiency_error
            assert coarse.efficiency_error < 0.01 * (1.0 - coarse.efficiency)


def test_pitch_geometry_of_the_design(mesh: Mesh) -> None:
    assert mesh.pitch.contact_ratio_profile == pytest.approx(1.165, abs=0.003)
    assert math.degrees(mesh.pitch.spiral_angle_gear) == pytest.approx(35.335, abs=0.01)
    nominal = profile_contact_ratio(DESIGN.pinion.blank, DESIGN.gear.blank, math.radians(35), math.radians(20))
    assert nominal == pytest.approx(1.165, abs=5e-4)


def test_ranges_are_those_of_an_automotive_bevel_gear(loaded: LoadedGrids) -> None:
    """Orders of magnitude: sum of normal forces of the standard's sample, pressure, speeds."""
    result = efficiency(loaded, 0.05)
    forces = [load.force.sum() for load in loaded.fine.positions]
    assert np.mean(forces) == pytest.approx(14193.3, rel=0.03)  # ISO/TR 10300-30 sample 1, F_n
    assert 1.0e9 < result.pressure_hertz_max < 2.0e9
    ranges = result.friction_range.ranges
    assert ranges["slide_to_roll"][0] < 0.0 < ranges["slide_to_roll"][1]  # sliding changes sign at the pitch line
    # no offset: hardly any sliding along the line
    assert np.abs(ranges["speed_sliding_lengthwise"]).max() < 0.05 * ranges["speed_sliding"][1]


def test_loaded_transmission_error(mesh: Mesh) -> None:
    """Load drags the gear back and evens it out.

    Peak to peak 0.554 of the unloaded one at 300 N m, 0.346 at 100 N m (48 x 81 points); 12 positions miss the former.
    """
    bodies = mesh.grids.teeth.pinion, mesh.grids.teeth.gear
    cycle = Mesh.of(DESIGN, "drive", 24, 21, bodies=bodies).grids
    middle, heavy = (load_grids(cycle, torque).fine for torque in (100.0, 300.0))
    unloaded = np.array([p.transmission_error for p in cycle.fine])
    assert np.all(heavy.transmission_error < middle.transmission_error)
    assert np.all(middle.transmission_error < unloaded)
    assert np.ptp(heavy.transmission_error) == pytest.approx(0.554 * np.ptp(unloaded), rel=0.03)
    assert np.ptp(middle.transmission_error) == pytest.approx(0.346 * np.ptp(unloaded), rel=0.03)


def test_light_load_is_hertz_point_contact() -> None:
    """A lightly loaded crowned pair touches in a slender ellipse (a/b = 24), here 2.8 mm half-long of a 20 mm line.

    Slices of Weber's line contact know nothing of their neighbours: peak pressure 2 % low, length 8 % high.
    """
    mesh = Mesh.of(DESIGN, "drive", 4, 201, keep=True).grids
    position, teeth = mesh.fine[0], mesh.teeth
    load = distribute_load(elastic_cycle((position,), teeth), teeth, 5.0).positions[0]
    at = np.flatnonzero(position.pair == 0)
    along, gap = np.cumsum(position.length[at]), position.gap[at]
    closest = int(np.argmin(gap))
    near = np.abs(along - along[closest]) < 3e-3
    crown = 0.5 / np.polyfit(along[near] - along[closest], gap[near], 4)[2]
    radius = float(position.radius_equivalent[at][closest])

    def mismatch(ratio: float) -> float:
        m = 1.0 - ratio**-2
        return float((ratio**2 * ellipe(m) - ellipk(m)) / (ellipk(m) - ellipe(m)) - crown / radius)

    ratio = brentq(mismatch, 1.1, 500.0)
    reduced = 1.0 / (1.0 / radius + 1.0 / crown)
    force = load.force[at].sum()
    second_kind = float(ellipe(1.0 - ratio**-2))
    half_length = (6.0 * ratio**2 * second_kind * force * reduced / (math.pi * teeth.effective_modulus)) ** (1 / 3)
    peak = 1.5 * force * ratio / (math.pi * half_length**2)
    assert load.share[0] == pytest.approx(1.0)
    assert load.pressure_hertz.max() == pytest.approx(peak, rel=0.03)
    assert 0.5 * position.length[load.force > 0.0].sum() == pytest.approx(half_length, rel=0.12)
