"""Closed-form efficiencies of three ISO 23509 blanks, to the six digits of the project's table."""

import math
from collections.abc import Callable
from dataclasses import replace

import pytest
from refusals import refuses

from efficiency.loss.closed_form import PitchGeometry, buckingham_type, coleman_type, lengthwise_sliding
from efficiency.loss.kinematics import Driver

DRIVERS: tuple[Driver, ...] = ("pinion", "gear")
# a_n, b1, b2, d1, d2 [deg], dm1, dm2, m_mn [mm] of the printed blanks; profile contact ratio of the rating
# samples
BLANKS = {
    "F2_14x39": (20.0, 35.0, 35.0, 19.747, 70.253, 54.918, 152.987, 3.213, 1.165),
    "F3_13x42": (17.747, 49.998, 38.609, 21.291, 68.321, 53.383, 141.877, 2.640, 1.010),
    "F4_9x34": (15.868, 44.990, 21.009, 24.765, 63.212, 51.258, 146.7, 4.028, 1.176),
}
# a, k, S, C, Coleman-type, Buckingham-type at mu = 0.05
TABLE = {
    "F2_14x39": (0.0, 0.309841, 0.154920, 0.0, 0.991757, 0.991757),
    "F3_13x42": (0.393122, 0.325735, 0.434334, 0.910992, 0.978428, 0.972027),
    "F4_9x34": (0.615607, 0.476244, 0.672420, 0.920266, 0.966642, 0.957203),
}


def blank(name: str) -> PitchGeometry:
    *angles, dm1, dm2, module, ratio = BLANKS[name]
    pressure, one, two, *cones = map(math.radians, angles)
    return PitchGeometry(pressure, (one, two), (cones[0], cones[1]), (dm1 / 2e3, dm2 / 2e3), module / 1e3, ratio)


@pytest.mark.parametrize("name", BLANKS)
def test_table_to_six_digits(name: str) -> None:
    pair = blank(name)
    values = (
        pair.lengthwise_measure, pair.profile_measure, pair.mean_sliding, pair.mean_lengthwise_share,
        coleman_type(pair, 0.05), buckingham_type(pair, 0.05),
    )  # fmt: skip
    assert tuple(round(value, 6) for value in values) == TABLE[name]


def test_mean_sliding_is_the_average_over_the_line_of_action() -> None:
    pair = blank("F4_9x34")
    steps = (2 * j + 1 for j in range(2000))
    a, k = pair.lengthwise_measure, pair.profile_measure
    mean = sum(math.hypot(a, k * step / 4000) for step in steps) / 2000
    assert pair.mean_sliding == pytest.approx(mean, rel=1e-7)


def test_vanishing_offset_is_continuous() -> None:
    pair = blank("F2_14x39")
    nearly = replace(pair, spiral_angle=(pair.spiral_angle[0] + 1e-9, pair.spiral_angle[1]))
    assert coleman_type(nearly) == pytest.approx(coleman_type(pair), abs=1e-9)
    assert buckingham_type(nearly) == pytest.approx(buckingham_type(pair), abs=1e-9)


@pytest.mark.parametrize(
    ("field", "value"), [("radius", (-0.01, 0.1)), ("contact_ratio_profile", 0.0), ("pressure_angle", 2.0)]
)
def test_impossible_geometry_is_refused(field: str, value: float) -> None:
    with refuses(field):
        replace(blank("F2_14x39"), **{field: value})


@pytest.mark.parametrize("form", [coleman_type, buckingham_type, lengthwise_sliding])
def test_friction_is_colemans_by_default_and_none_loses_nothing(form: Callable[..., float]) -> None:
    pair = blank("F4_9x34")
    assert (form(pair), form(pair, 0.0)) == (form(pair, 0.05), 1.0)
    for mu in (-0.01, 1.0, math.nan):
        with refuses("friction_coefficient"):
            form(pair, mu)


def test_without_offset_back_driving_loses_the_same_power_of_a_larger_input() -> None:
    """The efficiency differs by the square of the loss alone, in favour of back-driving; with offset it is worse."""
    drive, back = (coleman_type(blank("F2_14x39"), 0.05, driver) for driver in DRIVERS)
    loss = 1.0 - drive
    assert back == pytest.approx(1.0 / (1.0 + loss), rel=1e-12)
    assert back - drive == pytest.approx(loss**2 / (1.0 + loss), rel=1e-9)
    drive, back = (coleman_type(blank("F3_13x42"), 0.05, driver) for driver in DRIVERS)
    assert back < drive
