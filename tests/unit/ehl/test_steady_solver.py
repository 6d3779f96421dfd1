"""What solve_steady promises: invariances, shear laws, starts, offsets, failures."""

import dataclasses
import math

import numpy as np
import pytest
from contacts import line_contact
from refusals import refuses

from ehl.contact import Contact
from ehl.fluid.lubricant import Lubricant
from ehl.smooth import continuation, scaling
from ehl.smooth.newton import numbers_of, solve_level
from ehl.smooth.solver import FALLBACKS, REASONS, film_shear, solve_steady

OIL = Lubricant(0.02, 1.8e-8, "roelands", rheology="eyring", eyring_stress=5e6)


def contact(pressure=1.0e9, radius=0.01, speed=5.0, slip=0.3, lengthwise=0.0):
    return line_contact(
        radius_equivalent=radius,
        effective_modulus=2.264e11,
        pressure_hertz=pressure,
        speed_entrainment=speed,
        slide_to_roll=slip,
        speed_sliding_lengthwise=lengthwise,
    )


def test_direction_of_sliding_does_not_matter():
    forward, backward = (solve_steady(contact(slip=s, lengthwise=1.0), OIL) for s in (0.7, -0.7))
    assert forward.friction_fluid == backward.friction_fluid
    assert forward.film_min == backward.film_min


def test_sliding_along_and_across_share_the_shear_law_not_the_film():
    across = solve_steady(contact(slip=0.5), OIL, accuracy="reference")
    along = solve_steady(contact(slip=0.0, lengthwise=2.5), OIL, accuracy="reference")
    for result in (across, along):
        law = OIL.shear_stress(result.pressure, result.film, 2.5)
        np.testing.assert_allclose(result.shear_stress, law, rtol=1e-7)  # the solver reads its table
    # the flow along x sees cosh(S) in one case and sinh(S)/S < cosh(S) in the other
    assert along.film_min > across.film_min * (1.0 + 20.0 * across.film_error)
    newtonian = dataclasses.replace(OIL, rheology="newtonian")
    films = [solve_steady(contact(slip=s, lengthwise=v), newtonian).film_central for s, v in ((0.02, 0.0), (0.0, 0.1))]
    assert films[0] == pytest.approx(films[1], rel=1e-10)


def test_same_groups_same_numbers():
    # radius, rolling and sliding speed times k leave every group as it is
    one, two = solve_steady(contact(), OIL), solve_steady(contact(radius=0.07, speed=35.0), OIL)
    assert two.film_min == pytest.approx(7.0 * one.film_min, rel=1e-9)
    assert two.friction_fluid == pytest.approx(one.friction_fluid, rel=1e-9)
    assert two.rolling_traction == pytest.approx(one.rolling_traction, rel=1e-8)


def test_start_saves_work_and_changes_nothing():
    base = solve_steady(contact(), OIL)
    moved = contact(pressure=1.05e9, speed=4.8)
    cold, warm = solve_steady(moved, OIL), solve_steady(moved, OIL, start=base)
    assert warm.fallbacks == ()
    assert warm.iterations < cold.iterations
    for name in ("film_central", "film_min"):
        allowed = getattr(cold, f"{name}_error") + getattr(warm, f"{name}_error")
        assert getattr(warm, name) == pytest.approx(getattr(cold, name), rel=allowed)
    assert warm.friction_fluid == pytest.approx(cold.friction_fluid, rel=cold.friction_error + warm.friction_error)


def test_far_start_falls_back_to_the_path():
    base = solve_steady(contact(), OIL)
    far = contact(pressure=2.4e9, radius=0.05, speed=0.3)
    result = solve_steady(far, OIL, start=base)
    assert result.status == "converged"
    assert set(result.fallbacks) <= set(FALLBACKS)
    assert result.film_central == pytest.approx(solve_steady(far, OIL).film_central, rel=2e-3)


def test_offset_of_the_log_viscosity():
    barus = Lubricant(0.02, 1.2e-8, "barus", rheology="eyring", eyring_stress=5e6)
    level = solve_steady(contact(), barus).coarse
    x, shear = level.x, film_shear(contact(), barus)

    def numbers(oil, offset):
        scaled = dataclasses.replace(scaling.scaled_contact(contact(), oil), offset=offset)
        return numbers_of(solve_level(level.grid, scaled, level.unknowns), shear)

    plain, nothing = numbers(barus, None), numbers(barus, scaling.Offset.of(x, np.zeros_like(x)))
    assert nothing.film_min == pytest.approx(plain.film_min, rel=1e-9)
    # a constant offset is another inlet viscosity for Barus
    cooler = numbers(barus, scaling.Offset.of(x, np.full_like(x, 0.4)))
    same = numbers(dataclasses.replace(barus, viscosity_inlet=0.02 * math.exp(0.4)), None)
    assert cooler.film_central == pytest.approx(same.film_central, rel=1e-8)
    assert cooler.pressure_max == pytest.approx(same.pressure_max, rel=1e-8)
    # heat that thins the oil behind the inlet changes friction, hardly the film
    local = numbers(barus, scaling.Offset.of(x, -1.0 / (1.0 + np.exp(-(x + 0.5) / 0.1))))
    assert local.friction < 0.95 * plain.friction
    assert local.film_central == pytest.approx(plain.film_central, rel=0.02)


@pytest.mark.parametrize(
    ("pressure", "speed", "viscosity", "alpha"),
    [
        (0.3e9, 20.0, 0.15, 2.5e-8),
        (0.1e9, 60.0, 2.0, 3.5e-8),
        (2.5e9, 0.2, 0.003, 1.0e-8),
        (3.0e9, 0.05, 0.002, 8e-9),
        (1e9, 5.0, 0.02, 0.0),
    ],
)
def test_corners_of_the_gear_range_and_beyond(pressure, speed, viscosity, alpha):
    oil = dataclasses.replace(OIL, viscosity_inlet=viscosity, pressure_viscosity=alpha)
    result = solve_steady(contact(pressure=pressure, speed=speed), oil)
    assert result.status == "converged"
    assert 0.0 < result.film_min <= result.film_central * (1.0 + 1e-6) < math.inf
    assert result.pressure.min() >= 0.0
    assert result.film_error < 5e-3
    assert result.mass_residual < 1e-6
    assert result.load_residual < 1e-10


def hard(pressure, radius, speed, viscosity, alpha, slip=0.0):
    """A fast or thin contact of a steep Roelands oil; z = alpha 1.96e8/(ln eta0 + 9.67) of 1.7 and more."""
    return contact(pressure, radius, speed, slip), Lubricant(viscosity, alpha, "roelands")


HARD = {
    "M = 18, ln eta = 148": hard(1.031e9, 0.01034, 52.0, 0.00115, 3.19e-8, 0.33),
    "M = 620, ln eta = 553": hard(3.070e9, 0.0220, 6.55, 0.00132, 2.87e-8),
    "M = 670, ln eta = 1240": hard(3.451e9, 0.0394, 12.5, 0.0017, 3.40e-8),
    "M = 3600, ln eta = 355": hard(2.659e9, 0.2194, 0.607, 0.00238, 3.17e-8, 0.5),
}


@pytest.mark.parametrize("name", HARD)
def test_rounding_of_the_spike_is_covered_by_its_error(name, monkeypatch):
    line, oil = HARD[name]
    result = solve_steady(line, oil, accuracy="fast")
    assert result.status == "converged"
    assert result.fallbacks[:1] == ("spike_rounded",)
    assert result.film_error < 0.02
    monkeypatch.setattr(scaling, "ROUNDING", 1e-4)  # a thirtieth, on a mesh three times as fine
    sharp = solve_steady(line, oil, accuracy="reference")
    for value in ("film_central", "film_min"):
        allowed = getattr(result, f"{value}_error") + getattr(sharp, f"{value}_error")
        assert getattr(result, value) == pytest.approx(getattr(sharp, value), rel=allowed)


def test_rounding_leaves_a_film_alone_that_shears():
    scene = scaling.scaled_contact(contact(slip=0.1), OIL)
    assert scene.rounded().gamma == scene.gamma > scene.rounding > 0.0
    still = scaling.scaled_contact(contact(slip=0.0), OIL)
    assert still.gamma == 0.0
    assert still.rounded(2.0).gamma == 2.0 * still.rounding
    rolling = solve_steady(contact(slip=0.0), OIL)
    assert (rolling.friction_fluid, rolling.friction_error) == (0.0, 0.0)
    assert rolling.rolling_traction > 0.0


def test_a_rounded_neighbour_is_met_without_its_path():
    line, oil = HARD["M = 620, ln eta = 553"]
    first = solve_steady(line, oil, accuracy="fast")
    moved = dataclasses.replace(line, speed_entrainment=1.02 * line.speed_entrainment)
    warm, cold = (solve_steady(moved, oil, accuracy="fast", start=start) for start in (first, None))
    assert warm.fallbacks == ("spike_rounded",)
    assert warm.iterations < 0.3 * cold.iterations
    assert warm.film_min == pytest.approx(cold.film_min, rel=warm.film_min_error + cold.film_min_error)


def test_thin_film_of_a_steep_oil_with_little_shear():
    # M = 2600, ln eta up to 1070: the path must not pass Newtonian contacts
    oil = Lubricant(0.00148, 3.24e-8, "roelands", rheology="eyring", eyring_stress=2.32e6)
    line = contact(3.354e9, 0.0882, 1.844, 0.81)
    result, reference = (solve_steady(line, oil, accuracy=accuracy) for accuracy in ("fast", "reference"))
    assert result.fallbacks == ()
    assert result.film_min == pytest.approx(reference.film_min, rel=result.film_min_error + reference.film_min_error)


def test_failure_is_a_status_with_a_reason_and_no_nan(monkeypatch):
    assert solve_steady(contact(speed=0.0), OIL).reason == "no_entrainment"
    with refuses("accuracy"):
        solve_steady(contact(), OIL, accuracy="best")
    monkeypatch.setattr(continuation, "MAX_ITERATIONS", 3)
    result = solve_steady(contact(), OIL)
    assert result.fallbacks == ()
    assert result.status == "failed"
    assert result.reason in REASONS
    numbers = [getattr(result, f.name) for f in dataclasses.fields(result)]
    numbers = [n for n in numbers if isinstance(n, float)]
    assert not np.isnan(numbers).any()
    assert math.isinf(result.film_error)
    assert result.film_central == 0.0


def test_a_path_whose_last_step_has_no_first_iterate_ends():
    """Near its end the path steps to the end; a step that failed is shortened all the same."""
    keys = {"pressure_hertz": 6.3032e9, "radius_equivalent": 0.3773327, "speed_entrainment": 0.0016570174}
    keys |= {"slide_to_roll": -0.000131044, "speed_sliding_lengthwise": 41.316371}
    found = Contact(oil="fva2a", temperature_oil=324.8745942354202, accuracy="fast", **keys).solve()
    assert (found.status, found.reason in REASONS) == ("failed", True)
