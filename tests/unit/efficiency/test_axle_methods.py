"""Losses of bearings, seals and gears in oil against calculations by hand, and their limits."""

import math
from typing import Any

import numpy as np
import pytest

from efficiency.axle.axle_input import HousingInput, ShaftInput
from efficiency.axle.bearings import (
    BEARING_METHODS,
    BearingInput,
    BearingState,
    bearing_limits,
    palmgren_moment,
    skf_load_variables,
    skf_moment,
)
from efficiency.axle.drag import (
    CHURNING_METHODS,
    SMALL_SUMP,
    OilBath,
    Wheel,
    changenet_velex_torque,
    iso_14179_2_seal,
    iso_14179_2_torque,
    linke_seal,
    windage_torque,
)
from ehl.common.errors import InputError
from ehl.fluid.oil import Oil

RPM = 2.0 * math.pi / 60.0
SIZE = {"position": 0.0, "bore": 0.05, "outside_diameter": 0.09, "width": 0.02}
TAPERED: dict[str, Any] = SIZE | {"type": "tapered_roller", "series": "302", "thrust": "outwards", "axial_factor": 1.4}
BALL: dict[str, Any] = SIZE | {"type": "deep_groove_ball", "series": "62", "bore": 0.04, "outside_diameter": 0.08}
ROLLER = BALL | {"type": "cylindrical_roller", "series": "2"}
WHEEL = Wheel(41, 0.1, 0.105, 0.03, 0.01, math.radians(20.0), math.radians(30.0))
PINION = Wheel(10, 0.025, 0.03, 0.025, 0.01, math.radians(20.0), math.radians(30.0))


def bearing(**given: Any) -> BearingInput:
    return BearingInput.model_validate({"name": "one"} | given)


def test_skf_moments_by_hand() -> None:
    """d_m = 70 mm, 1500 rpm, 20 cSt, Fr = 4 kN, Fa = 1.5 kN; each line of the model with a pocket calculator."""
    state = BearingState(4000.0, 1500.0, 1500.0 * RPM, 20e-6)
    rolling, sliding = skf_load_variables(bearing(**TAPERED), 4000.0, 1500.0)
    # 1.76e-6 70^2.38 = 0.043337; (4000 + 10.9 1.4 1500)^0.31 = 23.614
    assert rolling == pytest.approx(1.0234, rel=1e-4)
    assert sliding == pytest.approx(0.55388 * 8200.0, rel=1e-4)  # 0.017 70^0.82 = 0.55388
    found = skf_moment(bearing(**TAPERED), state)
    # phi_ish = 0.96761, phi_rs = 0.96608, (nu n)^0.6 = 485.6; phi_bl = 0.0343, mu_sl = 0.006047
    assert found["rolling"] == pytest.approx(1e-3 * 0.96761 * 0.96608 * 1.0234 * 485.6, rel=2e-3)
    assert found["sliding"] == pytest.approx(1e-3 * 0.006047 * 4541.8, rel=2e-3)
    assert found["drag"] == found["seal"] == 0.0
    wet = skf_moment(bearing(**TAPERED), BearingState(4000.0, 1500.0, 1500.0 * RPM, 20e-6, 0.02))
    # t = 2.039, R_s = 2123.8 mm^2: 4.73 N mm; V_M = 4.29e-4, K_roll = 1.47e-11, C_w = 0.6631: 18.07 N mm
    assert wet["drag"] == pytest.approx(1e-3 * (4.73 + 18.07), rel=2e-3)
    assert wet["rolling"] == pytest.approx(found["rolling"] / 0.96608, rel=1e-4)  # no starvation in the bath


@pytest.mark.parametrize(
    ("given", "rating", "coefficient"),
    [
        (BALL | {"static_load_rating": 19000.0, "thrust": "both"}, 32500.0, 0.0015),
        (ROLLER, 62000.0, 0.0011),
        (TAPERED, 98000.0, 0.0018),
    ],
)
def test_both_methods_near_the_printed_coefficients_of_friction(given: Any, rating: float, coefficient: float) -> None:
    """``M = mu P d/2`` with mu of the same catalogue, printed for P = 0.1 C and normal running."""
    load = 0.1 * rating
    simple = 0.5 * coefficient * load * given["bore"]
    for method in BEARING_METHODS.values():
        moment = sum(method(bearing(**given), BearingState(load, 0.0, 1500.0 * RPM, 20e-6)).values())
        assert moment == pytest.approx(simple, rel=0.3)


def test_skf_moments_of_independent_programs() -> None:
    """Numbers that public programs give, computed with them; their starvation is that of grease (6e-8), ours of oil."""
    # github.com/cfernandesFEUP/Gear-Calculation, bearings.py: NJ 406, 3 kN, 1500 rpm, 32 cSt; 5 kN, 300 rpm, 80 cSt
    nj406 = bearing(**ROLLER | {"series": "4", "bore": 0.03, "outside_diameter": 0.09, "width": 0.023})
    for state, rolling, sliding in (
        (BearingState(3000.0, 0.0, 1500.0 * RPM, 32e-6), 138.261, 5.50156),
        (BearingState(5000.0, 400.0, 300.0 * RPM, 80e-6), 111.877, 96.1661),
    ):
        found = skf_moment(nj406, state)
        assert (found["rolling"], found["sliding"]) == pytest.approx((1e-3 * rolling, 1e-3 * sliding), rel=1e-5)
    # a public calculation of the losses of a passenger e-axle (Getrieberechnung_Einstufig.m): 16011, 2000 rpm, 9 cSt
    size = {"bore": 0.055, "outside_diameter": 0.09, "width": 0.011, "static_load_rating": 26000.0}
    ball = bearing(**BALL | size | {"series": "160", "thrust": "both"})
    found = skf_moment(ball, BearingState(2500.0, 800.0, 2000.0 * RPM, 9e-6, synthetic=True))
    assert found["sliding"] == pytest.approx(63.6376e-3, rel=1e-5)
    assert found["rolling"] == pytest.approx(91.6170e-3 * 0.967582**-0.5, rel=1e-5)
    # a third one, of bearings under oil: 40 x 80 mm, 3000 rpm, 20 cSt, its diagram read as 0.0012 in place of 0.00124
    drag = skf_moment(bearing(**BALL), BearingState(1.0, 0.0, 3000.0 * RPM, 20e-6, 1.0))["drag"]
    assert drag == pytest.approx(1e-3 * (31.2409 * 1.24 / 1.2 + 10.0134), rel=1e-4)


@pytest.mark.parametrize("depth", [0.0, 0.02])
def test_rolling_moment_never_falls_in_colder_oil(depth: float) -> None:
    """Starvation would bring it to zero in cold oil outside of a bath."""
    states = [BearingState(4000.0, 1500.0, 1500.0 * RPM, nu, depth) for nu in np.geomspace(1e-5, 1.0, 40)]
    moments = [skf_moment(bearing(**TAPERED), state)["rolling"] for state in states]
    assert np.all(np.diff(moments) >= -1e-9)
    noted = [any("rolling" in note for note in bearing_limits("skf", bearing(**TAPERED), state)) for state in states]
    assert noted[-1]
    assert not noted[0]


def test_palmgren_by_hand() -> None:
    """f0 = 6, nu n = 30000: 1e-7 6 965.5 70^3 N mm; P1 = 2 1.4 1500 = 4200 N > Fr: 4e-4 4200 70 N mm."""
    found = palmgren_moment(bearing(**TAPERED), BearingState(4000.0, 1500.0, 1500.0 * RPM, 20e-6))
    assert found["no load"] == pytest.approx(0.19870, rel=1e-4)
    assert found["load"] == pytest.approx(0.1176, rel=1e-9)
    below, above = (
        palmgren_moment(bearing(**TAPERED), BearingState(0.0, 0.0, n * RPM, 20e-6))["no load"] for n in (99.9, 100.1)
    )
    assert above == pytest.approx(below, rel=0.01)  # both branches meet at nu n = 2000
    # printed in a public study: f0 = 1.7, nu = 30 cSt, d_m = 45 mm, 10 500 rpm: 0.072 N m
    printed = bearing(**BALL | {"bore": 0.03, "outside_diameter": 0.06}, f0=1.7)
    assert palmgren_moment(printed, BearingState(0.0, 0.0, 10500.0 * RPM, 30e-6))["no load"] == pytest.approx(
        0.072, rel=5e-3
    )
    stated = bearing(**TAPERED, f0=3.0)
    assert palmgren_moment(stated, BearingState(0.0, 0.0, 157.0, 20e-6))["no load"] == pytest.approx(0.09932, rel=2e-3)


def test_seals_of_bearings_and_limits_of_speed_and_oil() -> None:
    sealed = bearing(**TAPERED, seal_diameter=0.06, seal_constants=(0.018, 2.25, 15.0))
    state = BearingState(4000.0, 1500.0, 1500.0 * RPM, 20e-6)
    assert skf_moment(sealed, state)["seal"] == pytest.approx(1e-3 * (0.018 * 60.0**2.25 + 15.0))
    still = skf_moment(bearing(**TAPERED), BearingState(4000.0, 1500.0, 0.0, 20e-6, 0.02))
    # at rest the starting torque: mu = 0.15 on the sliding load alone
    assert still == {"rolling": 0.0, "sliding": pytest.approx(0.15e-3 * 4541.8, rel=1e-4), "seal": 0.0, "drag": 0.0}
    unloaded = skf_moment(bearing(**TAPERED), BearingState(0.0, 0.0, 100.0, 20e-6))
    assert sum(unloaded.values()) == 0.0
    cold = BearingState(4000.0, 1500.0, 1500.0 * RPM, 0.05, 0.02)
    assert math.isfinite(sum(skf_moment(bearing(**TAPERED), cold).values()))
    assert "500 cSt" in bearing_limits("skf", bearing(**TAPERED), cold)[0]
    assert (
        bearing_limits("iso_14179_2", bearing(**TAPERED), cold)
        == bearing_limits("skf", bearing(**TAPERED), state)
        == []
    )
    drags = [
        skf_moment(bearing(**TAPERED), BearingState(1.0, 1.0, 150.0, 2e-5, h))["drag"] for h in np.linspace(0, 0.1, 9)
    ]
    assert np.all(np.diff(drags) >= 0.0)
    assert drags[0] == 0.0


def test_seals_by_hand() -> None:
    """50 mm, 1500 rpm; 75W-90 of 97.5 cSt: lg lg 98.3 = 0.29941."""
    oil, kelvin = Oil.load("75w90"), 90.0 + 273.15
    assert iso_14179_2_seal(0.05, 1500.0 * RPM, oil, kelvin) == pytest.approx(28.84, rel=1e-3)
    by_hand = (145.0 - 144.0 + 350.0 * 0.29941) * 1e-7 * 2500.0 * 1500.0
    assert linke_seal(0.05, 1500.0 * RPM, oil, kelvin) == pytest.approx(by_hand, rel=1e-4)
    assert linke_seal(0.05, -157.0, oil, kelvin) == linke_seal(0.05, 157.0, oil, kelvin)
    assert linke_seal(0.05, 157.0, oil, 233.15) > linke_seal(0.05, 157.0, oil, kelvin)


def test_churning_by_hand() -> None:
    """R = 100 mm, b = 30 mm, h = 50 mm: theta = 60 deg; wetted 12284 + 6283 + 10057 mm^2; V = D^3 or more."""
    wetted = 0.012284 + 0.0062832 + 2.0 * 41 * 1.047198 * 0.01 * 0.03 / (math.pi * 0.939693 * 0.866025)
    viscous = 1.366 * 0.25**0.45 * 2.0**0.1 * 0.254929**-0.6 * 1000.0**-0.21  # 5 rad/s, 15 cSt, V = 2 D^3
    at_5 = 0.5 * 820.0 * 25.0 * 1e-3 * wetted * viscous
    assert changenet_velex_torque(WHEEL, 0.05, 5.0, 15e-6, 820.0, 0.016) == pytest.approx(at_5, rel=1e-3)
    inertial = 3.644 * 0.25**0.1 * 2.0**-0.35 * 25.4929**-0.88 * 0.15**0.85  # 50 rad/s
    at_50 = 0.5 * 820.0 * 2500.0 * 1e-3 * wetted * inertial
    assert changenet_velex_torque(WHEEL, 0.05, 50.0, 15e-6, 820.0, 0.016) == pytest.approx(at_50, rel=1e-3)
    # less oil than was measured counts as V = D^3
    small, least = (changenet_velex_torque(WHEEL, 0.05, 50.0, 15e-6, 820.0, v) for v in (0.001, SMALL_SUMP * 0.2**3))
    assert small == least
    # Mauz: C1 = 0.063 5 + 0.0128 27, C2 = 5/80 + 0.2, v = 5 m/s
    assert iso_14179_2_torque(0.05, 0.03, 5.0) == pytest.approx(0.6606 * math.exp(0.13125), rel=1e-4)


@pytest.mark.parametrize("method", CHURNING_METHODS.values())
def test_churning_of_a_stage(method: Any) -> None:
    """Nothing without oil or at rest; more where the gears dip deeper; a dry pinion adds nothing."""

    def loss(*depths: float, speed: float = 50.0) -> float:
        return float(method((PINION, WHEEL), OilBath(depths, (4.0 * speed, speed), 15e-6, 820.0, 0.01)))  # type: ignore[arg-type]

    assert loss(0.0, 0.0) == loss(0.02, 0.05, speed=0.0) == 0.0
    assert loss(0.02, 0.05) > loss(0.0, 0.05) > loss(0.0, 0.02) > 0.0
    assert loss(0.02, 0.0) > 0.0


def test_stage_of_iso_14179_2_has_one_torque() -> None:
    """Depths 20 and 50 mm, the smaller face, speed of the gear; not one torque for each gear."""
    bath = OilBath((0.02, 0.05), (200.0, 50.0), 15e-6, 820.0, 0.01)
    by_hand = 50.0 * (0.063 * 7.0 + 0.0128 * 2.5**3) * math.exp((7.0 / 80.0 + 0.2) * 0.5)
    assert CHURNING_METHODS["iso_14179_2"]((PINION, WHEEL), bath) == pytest.approx(by_hand, rel=1e-9)


def test_regimes_of_churning_are_joined() -> None:
    speeds = np.linspace(15.0, 60.0, 400)
    torques = np.array([changenet_velex_torque(WHEEL, 0.05, w, 15e-6, 820.0, 0.016) for w in speeds])
    assert np.max(np.abs(np.diff(torques))) < 0.02 * torques.max()


def test_windage_of_a_disc() -> None:
    """Turbulent at Re = 66 667: C = 0.146 Re^-0.2; laminar at 3333: 3.87 Re^-0.5 (Schlichting)."""
    assert windage_torque(0.1, 100.0) == pytest.approx(0.6 * 1e4 * 1e-5 * 0.146 * 66666.7**-0.2, rel=1e-5)
    assert windage_torque(0.1, 5.0) == pytest.approx(0.6 * 25.0 * 1e-5 * 3.87 * 3333.33**-0.5, rel=1e-5)
    assert windage_torque(0.1, 0.0) == 0.0


def shaft(preload: float = 0.0, third: tuple[Any, ...] = ()) -> ShaftInput:
    one = TAPERED | {"name": "a", "position": 0.1, "thrust": "outwards", "axial_factor": 2.0}
    two = TAPERED | {"name": "b", "position": 0.2, "thrust": "inwards", "axial_factor": 1.0}
    return ShaftInput.model_validate({"preload": preload, "bearings": (one, two, *third)})


def test_shaft_on_two_bearings_by_hand() -> None:
    """1 kN at the origin, 0.1 m before the first of two bearings 0.1 m apart: 2 kN and 1 kN."""
    (first, axial_1), (second, axial_2) = shaft().loads(np.array([600.0, 800.0, 0.0, 0.0, 0.0, 5.0]))
    assert (first, second) == pytest.approx((2000.0, 1000.0))
    # induced 0.5 Fr/Y: 500 N each, no outer axial force
    assert (axial_1, axial_2) == pytest.approx((500.0, 500.0))
    # an axial force at a radius of 50 mm: its moment is 100 N m, couple of 1 kN
    couple = shaft().loads(np.array([0.0, 0.0, 2000.0, 0.0, 100.0, 0.0]))
    assert [radial for radial, _ in couple] == pytest.approx([1000.0, 1000.0])
    assert [axial for _, axial in couple] == pytest.approx([2500.0, 500.0])


@pytest.mark.parametrize(
    ("pushed", "expected"), [(0.0, (3e3, 3e3)), (2e3, (4e3, 2e3)), (9e3, (9.5e3, 500.0)), (-9e3, (500.0, 9.5e3))]
)
def test_preload_of_a_shaft(pushed: float, expected: tuple[float, float]) -> None:
    """Springs share an outer force until one bearing is relieved to the force it needs for its radial load."""
    found = shaft(3e3).loads(np.array([600.0, 800.0, pushed, 0.0, 0.0, 0.0]))
    assert [axial for _, axial in found] == pytest.approx(expected)


def test_three_bearings_carry_the_load() -> None:
    pilot = (ROLLER | {"name": "pilot", "position": -0.05},)
    found = shaft(third=pilot).loads(np.array([1000.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    assert len(found) == 3
    assert all(radial < 1000.0 for radial, _ in found)


def test_heat_through_housing_and_cooler() -> None:
    """100 and 25 W/(m^2 K) in series: 20; 60 K over the air, 0.5 m^2: 600 W, wall at 20 + 48 degC."""
    housing = HousingInput(area=0.5, heat_transfer=25.0, oil_heat_transfer=100.0, cooler_conductance=10.0)
    wall, cooler, temperature = housing.removed(353.15)
    assert (wall, cooler, temperature) == pytest.approx((600.0, 200.0, 341.15))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"series": "999"}, "302"),
        ({"axial_factor": 0.0}, "Y"),
        ({"thrust": "both"}, "outwards"),
        ({"bore": 0.2}, "outside"),
    ],
)
def test_impossible_bearings_are_refused(change: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        bearing(**(TAPERED | change))
    with pytest.raises((ValueError, InputError)):
        ShaftInput.model_validate({"bearings": (TAPERED | {"name": "a"},)})
