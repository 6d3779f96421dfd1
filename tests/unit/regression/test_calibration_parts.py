"""Parts of the calibration: point contacts, parameters on cards, robust noise, the card that is written."""

import datetime
import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from calibration_stub import OneLineSolver, measured, setup_with
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.stats import norm

from ehl.fluid.lubricant_inputs import OilLubricant
from ehl.fluid.oil import Oil
from ehl.fluid.oil_sheet import write_card
from ehl.fluid.rheology import stress_at
from regression.calibration import robust
from regression.calibration.calibrate import Calibration, ParameterEstimate, solver_of
from regression.calibration.measurement import Measurement
from regression.calibration.prediction import contact_groups, hertz_point_pressure, line_pressure
from regression.calibration.report import calibrated_card
from regression.calibration.search import surrogate_at
from regression.calibration.setup import card_with, lubricant_of, start_values
from regression.friction.fitted import FittedFormula
from regression.friction.models import FrictionFlag

STEEL = 206e9 / (1.0 - 0.3**2)  # E' of the shipped steel on itself
WARM = 353.15


def measurement_of(load: str, values: list[float]) -> Measurement:
    speeds = np.linspace(0.5, 2.0, len(values))
    rest = {"radius_equivalent": 9.525e-3, "slide_to_roll": 0.3, "temperature_oil": WARM, "roughness_rms": 1e-7}
    return measured(load, 0.05, **{load: np.array(values)}, speed_entrainment=speeds, **rest)


def test_pressure_of_a_ball_is_hertz() -> None:
    # p0 = (6 W E*^2/(pi^3 R^2))^(1/3), E* = E'/2 (Johnson 1985, eq. 3.39 to 3.41)
    by_hand = (6.0 * 36.0 * (0.5 * STEEL) ** 2 / (math.pi**3 * 9.525e-3**2)) ** (1.0 / 3.0)
    assert hertz_point_pressure(36.0, 9.525e-3, 9.525e-3, STEEL) == pytest.approx(by_hand, rel=1e-12)


@pytest.mark.parametrize("ratio", [1.001, 1.5, 4.0, 30.0])
def test_pressure_of_an_ellipse_is_in_equilibrium_with_its_displacements(ratio: float) -> None:
    """Independent of the formulas: pressure p0 sqrt(1 - ..) over the ellipse deforms to the gap of both radii."""
    larger, smaller, load = 0.02 * ratio, 0.02, 500.0
    peak = hertz_point_pressure(load, larger, smaller, STEEL)
    area = 1.5 * load / peak  # pi a b

    def curvature(own: float, other: float) -> float:
        # u'' = (p0 a b/E*) int_0^inf dw/((own^2 + w) sqrt((own^2 + w)(other^2 + w) w)); w = t^2
        value, _ = quad(
            lambda t: 2.0 / ((own**2 + t * t) ** 1.5 * math.sqrt(other**2 + t * t)), 0.0, math.inf, epsabs=0, limit=200
        )
        return peak * own * other / (0.5 * STEEL) * value

    def mismatch(log_ratio: float) -> float:
        short = math.sqrt(area / math.pi * math.exp(-log_ratio))
        return curvature(short * math.exp(log_ratio), short) * larger - 1.0

    axes = math.exp(brentq(mismatch, 1e-6, 8.0))
    short = math.sqrt(area / math.pi / axes)
    assert curvature(short, short * axes) * smaller == pytest.approx(1.0, rel=1e-6)


def test_line_in_place_of_a_point() -> None:
    balls = measurement_of("pressure_hertz", [1e9, 1.2e9])
    np.testing.assert_allclose(line_pressure(balls, setup_with()), [1e9, 1.2e9])
    mean = line_pressure(balls, setup_with(specimens={"geometry": "point", "match": "mean_pressure"}))
    # 2/3 p0 of the ball is pi/4 p0 of the line
    np.testing.assert_allclose(mean * math.pi / 4.0, [2e9 / 3.0, 2.4e9 / 3.0])
    rollers = measurement_of("load", [1000.0, 2000.0])
    line = setup_with(specimens={"geometry": "line", "length": "10 mm"})
    contact = contact_groups(rollers, line)[0].contacts[1]
    assert contact.load_per_length == pytest.approx(2e5, rel=1e-12)
    assert contact.pressure_hertz == pytest.approx(line_pressure(rollers, line)[1], rel=1e-12)


@pytest.mark.parametrize("name", ["fva3", "m100", "estr", "squalane", "pao 97.5/13.3"])
def test_pressure_viscosity_is_scaled_at_all_temperatures(name: str) -> None:
    card = Oil.load(name)
    start = start_values(card, WARM, rising=False)["pressure_viscosity"]
    assert start == pytest.approx(card.at(WARM).pressure_viscosity, rel=1e-12)
    other = card_with(card, {"pressure_viscosity": 1.25 * start}, WARM)
    for temperature in (313.15, WARM, 373.15):
        steep, own = other.at(temperature), card.at(temperature)
        assert steep.pressure_viscosity == pytest.approx(1.25 * own.pressure_viscosity, rel=1e-9)
        assert other.alpha(temperature) == pytest.approx(1.25 * card.alpha(temperature), rel=1e-12)
        assert other.viscosity_dynamic(temperature) == card.viscosity_dynamic(temperature)
        if name not in ("m100", "pao100", "estr"):
            rise = [each.log_viscosity_ratio(np.array([0.1e9, 0.5e9, 1e9])) for each in (steep, own)]
            np.testing.assert_allclose(rise[0], 1.25 * rise[1], rtol=1e-9)
    again = card_with(other, {"pressure_viscosity": 1.21 * start}, WARM)
    assert again.at(WARM).pressure_viscosity == pytest.approx(1.21 * start, rel=1e-9)


def test_the_cards_own_values_change_nothing() -> None:
    for name, rising in (("fva3", False), ("75w90", True), ("m100", False)):
        card = Oil.load(name)
        again = card_with(card, start_values(card, WARM, rising=rising), WARM)
        found, own = lubricant_of(again, WARM, rising=rising), lubricant_of(card, WARM, rising=rising)
        if not rising:  # a constant one starts at that of the card at 1 GPa
            assert found.eyring_stress == stress_at(own.eyring_stress, 1e9)
            found = replace(found, eyring_stress=own.eyring_stress)
        assert found == own
    card = card_with(Oil.load("75w90"), {"stress_low": 3e6, "stress_slope": 0.05}, WARM)
    law: Any = lubricant_of(card, WARM, rising=True).eyring_stress
    assert (law.stress_low, law.stress_slope, law.pressure_start, law.pressure_end) == (3e6, 0.05, 0.5e9, 3.5e9)


def test_huber_constants_are_gaussian_integrals() -> None:
    squared = norm.expect(lambda x: np.clip(x, -robust.TUNING, robust.TUNING) ** 2)
    assert squared == pytest.approx(robust.PSI_SQUARED, rel=1e-6)
    assert norm.cdf(robust.TUNING) - norm.cdf(-robust.TUNING) == pytest.approx(robust.PSI_SLOPE, rel=1e-4)
    # the textbook efficiency of Huber's estimate at c = 1.5
    assert pytest.approx(0.964, abs=0.001) == robust.INEFFICIENCY**-2


def test_noise_is_found_among_outliers_and_stated_noise_is_checked() -> None:
    residuals = np.random.default_rng(1).standard_normal(4000)
    spoiled = residuals.copy()
    spoiled[:80] = 40.0
    clean = robust.noise_of(residuals, 3, stated=False, tuned_to=robust.spread(residuals, 3))
    dirty = robust.noise_of(spoiled, 3, stated=False, tuned_to=robust.spread(spoiled, 3))
    # standard error of a scale from 4000 values is 1.2 %; 2 % of outliers bias Huber's by a few per cent, not by 5.6
    assert clean.scale == pytest.approx(1.0, abs=0.04)
    assert dirty.scale == pytest.approx(1.0, abs=0.1)
    true, small = (robust.noise_of(k * residuals, 3, stated=True, tuned_to=1.0) for k in (1.0, 2.0))
    assert (true.scale, true.larger_than_stated, small.larger_than_stated) == (1.0, False, True)
    assert small.chi_square > 1.5


def test_neighbours_that_go_together_are_found() -> None:
    noise = np.random.default_rng(2).standard_normal(400)
    together = np.convolve(noise, np.ones(4), mode="same")
    labels = tuple("ab"[i >= 200] for i in range(400))
    alone, random_limit = robust.serial_correlation(noise, labels)
    moving, _ = robust.serial_correlation(together, labels)
    assert abs(alone) < random_limit
    # a running mean of four has the correlation 3/4 between neighbours
    assert moving == pytest.approx(0.75, abs=0.1)


def test_surrogate_is_the_solver_where_it_was_built_and_close_beside() -> None:
    setup = setup_with(parameters=["eyring_stress", "boundary_friction", "boundary_film"])
    plain = solver_of(measurement_of("pressure_hertz", [0.8e9, 1e9, 1.2e9, 1e9]), setup, 1)
    solver = OneLineSolver(plain.setup, plain.groups, plain.roughness, plain.temperature)
    values = {"eyring_stress": 5e6, "boundary_friction": 0.1, "boundary_film": 3e-8}
    values |= {"limiting_shear_coefficient": 0.05, "pressure_viscosity": 1.7e-8}
    rows = np.ones(4, dtype=bool)
    surrogate = surrogate_at(solver, values, setup.parameters, rows)

    def friction(changes: dict[str, float]) -> np.ndarray:
        there = {**values, **changes}
        return solver.friction(solver.transformed(solver.parts([there])[0]), there)

    np.testing.assert_allclose(surrogate.at(surrogate.log_values), friction({}), rtol=1e-12)
    # boundary friction is exact at any distance
    far = surrogate.at(np.log([5e6, 0.3, 3e-8]))
    np.testing.assert_allclose(far, friction({"boundary_friction": 0.3}), rtol=1e-12)
    for name, near in (("eyring_stress", [5.25e6, 0.1, 3e-8]), ("boundary_film", [5e6, 0.1, 3.06e-8])):
        change = {name: near[setup.parameters.index(name)]}
        np.testing.assert_allclose(surrogate.at(np.log(near)), friction(change), rtol=2e-3)


def test_card_is_written_read_and_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    setup = setup_with(parameters=["stress_low", "stress_slope", "pressure_viscosity", "boundary_friction"])
    measurement = measurement_of("pressure_hertz", [1e9, 1.2e9])
    values = {"stress_low": 4e6, "stress_slope": 0.03, "pressure_viscosity": 2e-8, "boundary_friction": 0.12}
    values |= {"limiting_shear_coefficient": 0.047}
    fitted = ("stress_slope", "pressure_viscosity", "boundary_friction")
    parameters = []
    for name in ("stress_low", *fitted):
        known = {"name": name, "unit": "", "interval_low": 0.96 * values[name], "interval_high": 1.04 * values[name]}
        known |= {"status": "determined", "value": values[name]} if name in fitted else {"status": "undetermined"}
        parameters.append(ParameterEstimate(**dict.fromkeys(ParameterEstimate.__dataclass_fields__, 1e-3) | known))
    given = {"parameters": parameters, "fitted": fitted, "values": values, "measurement": measurement, "setup": setup}
    given |= {"excluded": (), "outliers": (2,), "friction_computed": (0.05, 0.05), "notes": (), "misfit_credible": True}
    result = Calibration(**dict.fromkeys(Calibration.__dataclass_fields__, 1e-3) | given)
    card = calibrated_card("mine", result, datetime.date(2026, 1, 31))
    write_card(card, Path("mine.toml"), "Mine")
    again = Oil.load("mine.toml")
    assert again == card
    # as a key of caches, and in a formula of another oil
    assert hash(again) == hash(card)
    assert FittedFormula.load("fva3").oil_flag(again) == FrictionFlag.OTHER_OIL
    # a card that is written again is read again
    text = Path("mine.toml").read_text(encoding="utf-8")
    Path("mine.toml").write_text(text.replace("density_15 = ", "density_15 = 890.0 # "), encoding="utf-8")
    os.utime("mine.toml", ns=(1, 10**18))
    assert Oil.load("mine.toml").density_15 == 890.0 != again.density_15
    assert again.alpha(WARM) == pytest.approx(2e-8, rel=1e-12)
    record = again.calibration
    assert (record.file, record.file_hash, record.date, record.rows_used) == ("made.csv", "0" * 64, "2026-01-31", 2)
    assert record.undetermined == ("stress_low",)
    assert record.fitted["stress_slope"].interval_high == pytest.approx(1.04 * 0.03)
    assert (record.conditions["pressure_hertz"], record.surface["boundary_friction"]) == ((1e9, 1.2e9), 0.12)
    # the card by its path in an input file
    oil = OilLubricant(oil="mine.toml", temperature_oil=WARM, eyring_stress_law="pressure").lubricant()
    assert not isinstance(oil.eyring_stress, float)
    assert oil.eyring_stress.stress_slope == 0.03


@pytest.mark.parametrize("law", ["table", "gold"])
def test_alpha_of_a_card_that_states_secants_becomes_the_fitted_slope(law: str) -> None:
    laws = {"table": {"temperature": (313.15, 373.15), "value": (14e-9, 10e-9)}, "gold": {"base": "pao"}}
    content = Oil.load("paor").model_dump() | {"viscosity": {"law": "roelands"}}
    content["pressure_viscosity"] = {"law": law, "alpha_definition": "secant_200", **laws[law]}
    card = Oil.model_validate({key: value for key, value in content.items() if value is not None})
    fitted = card_with(card, {"pressure_viscosity": 15e-9}, 353.15)
    assert fitted.at(353.15).pressure_viscosity == pytest.approx(15e-9, rel=0.02)
    assert fitted.alpha_definition == "slope"
