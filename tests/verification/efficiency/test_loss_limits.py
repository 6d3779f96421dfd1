"""Loss against independent quadrature and exact limits."""

import math
from dataclasses import replace

import numpy as np
import pytest
from samples import AXLE_OIL as OIL
from samples import tiny_load, tiny_mesh

from efficiency.loss.closed_form import PitchGeometry, buckingham_type, coleman_type, lengthwise_sliding
from efficiency.loss.efficiency import load_grids, mesh_efficiency
from efficiency.loss.kinematics import Operation
from regression.friction.models import ConstantFriction

OPERATION = Operation(100.0, 363.15)


@pytest.mark.parametrize("name", ["fh_hypoid_9x34", "fm_spiral_bevel_14x39"])
def test_constant_friction_is_the_integral_over_the_lines(name: str) -> None:
    """Sliding from both axes of rotation, and the trapezoidal rule for w' |v_s| over the length of the lines."""
    mesh = tiny_mesh(design=name).grids
    loaded = load_grids(mesh, 200.0)
    result = mesh_efficiency(loaded, ConstantFriction(0.05), OIL, OPERATION)
    pinion, gear = mesh.axes
    total = 0.0
    for load in loaded.fine.positions:
        p = load.position
        ratio = float(np.mean(p.lever_gear / p.lever_pinion))
        # the gear turns so that the flanks stay in touch: equal velocities along the normal
        one = np.cross(pinion.direction, p.position - pinion.origin)
        two = np.cross(gear.direction, p.position - gear.origin)
        way = np.sum(one * p.normal, axis=1) / np.sum(two * p.normal, axis=1)
        np.testing.assert_allclose(np.abs(way), 1.0 / ratio, rtol=1e-3)
        slip = one - way[:, None] * two
        density = load.load_per_length * np.linalg.norm(slip, axis=1)
        for at in p.lines:
            if at.size < 3:
                continue
            # midpoints of equal parts: the ends of a line lie half a part beyond its outer points
            middle = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p.position[at], axis=0), axis=1))])
            half = 0.5 * p.length[at]
            run = np.concatenate([[-half[0]], middle, [middle[-1] + half[-1]]])
            ends = np.concatenate([density[at][:1], density[at], density[at][-1:]])
            total += float(np.trapezoid(ends, run))
    mean = 0.05 * total * OPERATION.speed / len(loaded.fine.positions)
    assert result.power_loss == pytest.approx(mean, rel=0.01)


def test_no_friction_no_loss_either_way() -> None:
    loaded = tiny_load()
    for driver in ("pinion", "gear"):
        result = mesh_efficiency(loaded, ConstantFriction(0.0), OIL, replace(OPERATION, driver=driver))
        assert (result.efficiency, result.power_loss) == (1.0, 0.0)
        # rolling goes on, and is told apart
        assert result.power_loss_rolling > 0.0
        assert 0.99 < result.efficiency_with_rolling < 1.0


WITHOUT_HEIGHT = PitchGeometry(
    *(math.radians(angle) for angle in (20.0, 48.0, 22.0, 25.0, 63.0)),
    radius_pinion=0.03,
    radius_gear=0.085,
    module_normal=1e-8,
    contact_ratio_profile=1.2,
)


@pytest.mark.parametrize("mu", [0.02, 0.08])
def test_closed_forms_without_profile_sliding(mu: float) -> None:
    """Teeth of vanishing height: Coleman-type and Buckingham-type become the lengthwise identity, with friction in the
    equilibrium; the frictionless one differs in the second order of mu.
    """
    pair = WITHOUT_HEIGHT
    exact = lengthwise_sliding(pair, mu)
    assert coleman_type(pair, mu) == pytest.approx(exact, abs=1e-6)
    assert buckingham_type(pair, mu) == pytest.approx(exact, abs=1e-6)
    tangents = math.tan(math.radians(48.0)) - math.tan(math.radians(22.0))
    cos_n = math.cos(math.radians(20.0))
    linear = 1.0 - mu * tangents / cos_n
    assert abs(exact - linear) < 2.0 * mu**2


def test_a_driving_gear_is_the_pinion_with_friction_reversed() -> None:
    """eta = (cos a - mu tan b1)/(cos a - mu tan b2), and both ways there and back lose alike to first order."""
    pair = WITHOUT_HEIGHT
    back = lengthwise_sliding(pair, 0.05, driver="gear")
    cos_n, t1, t2 = (math.cos(math.radians(20.0)), math.tan(math.radians(48.0)), math.tan(math.radians(22.0)))
    assert back == pytest.approx((cos_n - 0.05 * t1) / (cos_n - 0.05 * t2), rel=1e-14)
    assert back == pytest.approx(1.0 / (1.0 + 0.05 * (t1 - t2) / cos_n), abs=2.0 * 0.05**2)
    for form in (coleman_type, buckingham_type):
        assert form(pair, 0.05, "gear") == pytest.approx(back, abs=1e-6)
