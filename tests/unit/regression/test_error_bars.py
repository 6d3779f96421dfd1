"""Error estimates of fits: samples whose scatter, standard error or coverage is known."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.signal import lfilter

from ehl.fluid.oil import Oil
from ehl.uncertainty.result import score_of
from ehl.uncertainty.spread import DEFAULT, UncertaintyInput
from regression.calibration import determination, robust
from regression.calibration.determination import _Side, determination_of, intervals_by_errors
from regression.calibration.search import Fit, Target
from regression.fitting.coefficients import _nonlinear_fit
from regression.fitting.fit import _width_of_oils_left_out, _with_noise, interval_of, ratio_of_means
from regression.formula import Formula
from regression.friction.conditions import UNITS, contact_points
from regression.friction.families import POWER_LAW, Family
from regression.friction.network import Network
from regression.friction.uncertainty import _lateral_error, friction_changes

ODD, PAIRS = np.array([1.0, -1.0, 1.0, -1.0]), np.array([1.0, 1.0, -1.0, -1.0])
TERMS = ("constant", "slope")


def _line(table: Any, k: Any) -> tuple[Any, Any]:
    return np.zeros_like(table["x"]), np.exp(k["constant"] + k["slope"] * table["x"])


LINE = Family("line", "", "", TERMS, (), None, (-2.0, 0.1), (-9.0, -9.0), (9.0, 9.0), _line)


@pytest.mark.parametrize("with_parts", [False, True])
def test_standard_errors_of_a_nonlinear_fit_count_a_case_once(with_parts: bool) -> None:
    """ln mu = a + b x with x = +-1 and residuals of +-s orthogonal to both: s/sqrt(8 - 2)."""
    x, target = np.tile(ODD, 2), np.tile(-3.0 + 0.2 * ODD + 1e-3 * PAIRS, 2)

    computed = (np.zeros(8), np.exp(target)) if with_parts else None
    found = _nonlinear_fit(LINE, {"x": x}, target, np.ones(8), 0.1, computed, None)
    assert found.standard_errors == pytest.approx(dict.fromkeys(TERMS, 1e-3 / math.sqrt(6.0)), rel=2e-3)


def _networks(*outputs: tuple[float, float], noise: float = 0.0) -> Network:
    """A network for each pair of outputs, which do not depend on its input."""
    members = tuple(((0, 0), (0, 0), (0, round(1e3 * a)), (0, round(1e3 * b))) for a, b in outputs)
    ends = {"mean": (math.log(1e9),), "scale": (1.0,), "low": (-1.0,), "high": (1.0,)}
    return Network(variables=("pressure_hertz",), members=members, noise=noise, **ends)


@pytest.mark.parametrize("share", [0.02, 0.3, 0.9])
@pytest.mark.parametrize("slope", [(1.0, 0.0), (0.0, 1.0), (1.0, 0.7), (1.0, -0.7)])
def test_scatter_of_networks_is_that_of_the_friction_by_each(share: float, slope: tuple[float, float]) -> None:
    """Standard deviation of ln mu over the members to first order in their scatter; the noise in quadrature."""
    outputs = [(0.4 + size * slope[0], -0.2 + size * slope[1]) for size in (-0.01, -0.004, 0.002, 0.012)]
    case = np.full(2, share), np.full(2, 0.03), {"pressure_hertz": np.full(2, 1e9)}, 0.1
    alone = [_networks(pair).corrected(*case)[0][0] for pair in outputs]
    scatter = _networks(*outputs).corrected(*case)[1][1]
    assert scatter == pytest.approx(np.std(np.log(alone)), rel=0.05)
    assert _networks(*outputs, noise=0.02).corrected(*case)[1][1] == pytest.approx(math.hypot(scatter, 0.02))


def test_correction_decreases_to_half_an_eighth_of_the_range_outside() -> None:
    """The range of ln p is 2, the correction ends a quarter of it outside."""
    parts = np.full(1, 0.3), np.full(1, 0.03)
    outside = {"pressure_hertz": np.array([1e9 * math.exp(1.25)])}
    found = _networks((0.4, -0.2)).corrected(*parts, outside, 0.1)[0]
    inside = _networks((0.2, -0.1)).corrected(*parts, {"pressure_hertz": np.array([1e9])}, 0.1)[0]
    assert found == pytest.approx(inside)


def test_width_of_oils_left_out() -> None:
    """ln mu 0, 0.1 and 0.3 above a power law: without an oil the mean of the others, 0.2, 0.05 and 0.25 away."""
    rng, names = np.random.default_rng(4), ("75w90", "fva3", "pao220")
    frame = pd.DataFrame({name: np.exp(rng.uniform(-1.0, 1.0, 60)) for name in UNITS})
    frame = pd.concat([frame] * 3, ignore_index=True).assign(oil=np.repeat(names, 60), boundary_friction=0.1)
    offset = np.repeat([0.0, 0.1, 0.3], 60)
    frame["friction_coefficient"] = 0.05 * frame["pressure_hertz"] ** 0.4 * np.exp(offset)
    found = _width_of_oils_left_out(POWER_LAW, frame, "plan", network=False, jobs=1)
    assert found == pytest.approx(0.25, rel=1e-9)
    two = frame[frame["oil"] != "fva3"]
    assert _width_of_oils_left_out(POWER_LAW, two, "plan", network=False, jobs=1) is None


def _cases(count: int, seed: int) -> tuple[np.random.Generator, pd.DataFrame, np.ndarray]:
    """Film ratios over all bands with a friction of 0.05, and deviations of ln mu over a factor of ten."""
    rng = np.random.default_rng(seed)
    ratio = np.exp(rng.uniform(math.log(0.1), math.log(10.0), count))
    frame = pd.DataFrame({"film_ratio_formula": ratio, "friction_coefficient": np.full(count, 0.05)})
    return rng, frame, np.exp(rng.uniform(math.log(0.02), math.log(0.2), count))


def test_noise_of_networks_and_their_widths() -> None:
    """Double exponential errors of the scatter and a noise of 0.05: 90 % are within ln 10 of their scale."""
    rng, frame, scatter = _cases(8000, 3)
    error = rng.exponential(np.hypot(scatter, 0.05))
    noise, deviation = _with_noise(error, scatter)
    assert noise == pytest.approx(0.05, rel=0.15)  # the trials are 12 % apart
    assert deviation == pytest.approx(np.hypot(scatter, noise))
    found = interval_of(frame, error, deviation=deviation, of_means=0.5)
    assert found.log_width == pytest.approx(0.5 * math.log(10.0), rel=0.03)
    assert [band.log_width for band in found.bands] == pytest.approx([0.5 * math.log(10.0)] * 4, rel=0.1)
    assert found.largest == error.max()
    assert np.mean(error <= found.near) == pytest.approx(0.9, abs=1e-3)  # of all, as none is extrapolated


def test_means_over_sixteen_profiles_scatter_by_a_quarter(monkeypatch: pytest.MonkeyPatch) -> None:
    rng, frame, scatter = _cases(4000, 5)
    monkeypatch.setattr("regression.fitting.fit.expected_rows", lambda rows: rows)
    single, mean = (0.05 * np.exp(size * scatter * rng.standard_normal(4000)) for size in (1.0, 0.25))
    form: Any = SimpleNamespace(friction=lambda rows: (mean, scatter))
    held_out: Any = SimpleNamespace(mu=single, deviation=scatter)
    assert ratio_of_means(form, frame, held_out, frame) == pytest.approx(0.25, rel=0.08)


@pytest.mark.parametrize(("first", "power"), [(0.1, 1.0), (0.59, 1.0), (2.0, 1.0), (0.4, 0.8), (0.7, 1.3)])
def test_end_of_a_profile_whose_root_is_a_power_of_the_step(first: float, power: float) -> None:
    """The root is (step/0.3)^power, and 1.96 at the end; a root that stays small gives no end."""
    side, flat = _Side(0, 1.0, first, 10.0), _Side(0, 1.0, first, 10.0)
    for _ in range(determination.MAX_PROFILE):
        if not side.done:
            side.root = (side.size / 0.3) ** power
            side.follow(1.96)
        flat.root = 0.1
        flat.follow(1.96)
    assert side.done
    assert side.end == pytest.approx(0.3 * 1.96 ** (1.0 / power), rel=0.03)
    assert flat.end == math.inf


def test_error_of_the_rough_model_lies_on_both_sides() -> None:
    spreads = UncertaintyInput.none(rough_contact_model=0.08)
    (found,) = _lateral_error(spreads, np.array([0.5, 2.0, 5.0]), 2.0, True)
    assert found.above == pytest.approx([0.16, 0.04, 0.0])
    assert found.below == pytest.approx([-0.16, -0.04, 0.0])


@pytest.mark.parametrize(("stated", "memory"), [(True, 0.0), (False, 0.0), (False, 0.5)])
def test_intervals_of_a_calibration_cover_as_they_state(stated: bool, memory: float) -> None:
    """A level and a slope by least squares from 200 rows whose noise has this correlation of neighbours."""
    rng, rows, sigma = np.random.default_rng(7), 200, 0.002
    jacobian = np.column_stack([np.full(rows, 0.04), 0.02 * np.linspace(-1.0, 1.0, rows)])
    names, truth = ("eyring_stress", "boundary_friction"), np.log([5e6, 0.1])
    nothing: Any = None
    scores = []
    for _ in range(200):
        noise = lfilter([math.sqrt(1.0 - memory**2)], [1.0, -memory], sigma * rng.standard_normal(rows + 20))[20:]
        change = np.linalg.lstsq(jacobian, noise)[0]
        target = Target(noise, np.full(rows, sigma if stated else 1.0), np.ones(rows, dtype=bool), stated)
        residuals = target.residuals(jacobian @ change)
        level = robust.noise_of(residuals, 2, stated=stated, tuned_to=target.scale(residuals, 2))
        values = dict(zip(names, np.exp(truth + change), strict=True))
        fit = Fit(names, values, jacobian @ change, jacobian, nothing, 1.0, 0.0, 1, ())
        intervals = intervals_by_errors(fit, level, determination_of(fit, target, level, ("a",) * rows))
        scores.append(change / (0.5 * np.ptp(intervals, axis=1) / level.quantile))
        assert level.quantile == pytest.approx(1.96, rel=0.01)
    assert np.std(scores, axis=0) == pytest.approx(np.ones(2), abs=0.15)


def test_standard_errors_of_a_robust_fit_agree_with_monte_carlo() -> None:
    """Normal residuals of twice the limit of outliers: the stated errors are the scatter of the fitted values."""
    rng, x = np.random.default_rng(3), np.linspace(-1.0, 1.0, 200)

    values, stated = [], []
    for _ in range(300):
        target = -3.0 + 0.2 * x + 0.1 * rng.standard_normal(200)
        found = _nonlinear_fit(LINE, {"x": x}, target, np.ones(200), 0.1, None, None)
        values.append([found.values[term] for term in TERMS])
        stated.append([found.standard_errors[term] for term in TERMS])
    ratio = np.sqrt(np.mean(np.square(stated), axis=0)) / np.std(values, axis=0, ddof=1)
    assert ratio == pytest.approx(np.ones(2), abs=0.12)


def test_ends_of_a_given_peklenik_number_and_of_the_lay_of_a_finish() -> None:
    """gamma = 3 is varied from 1 to 9, that of ground flanks with their lay ratio, from 3 to 9."""
    formula, point = Formula.load("75w90"), {"pressure_hertz": 1.2e9, "radius_equivalent": 0.015, "slide_to_roll": 0.2}
    point |= {"temperature": 363.15, "roughness_rms": 0.4e-6, "speed_entrainment": 1.0}
    for given, ends in (({"peklenik_number": 3.0}, (1.0, 9.0)), ({"finish": "ground"}, (3.0, 9.0))):
        sources = {source.name: source for source in formula.uncertainty(**point, **given).sources}
        mu = [float(formula.mu(**(point | given | {"peklenik_number": gamma})).mu) for gamma in ends]
        found = sources["peklenik_number"]
        assert (found.below, found.above) == pytest.approx(mu, rel=1e-9)
    own = formula.uncertainty(**point, finish="ground", spreads=UncertaintyInput(viscosity=0.01))
    assert {source.name for source in own.sources} >= {"roughness_rms", "peklenik_number"}


POINT: Any = {
    "pressure_hertz": 1.2e9, "radius_equivalent": 0.015, "slide_to_roll": 0.2, "temperature": 363.15,
    "roughness_rms": 0.4e-6,
}  # fmt: skip


@pytest.mark.parametrize("speed", [3.0, 5.0, 20.0])
def test_interval_of_a_contact_holds_random_draws_of_all_inputs(speed: float) -> None:
    """89 to 94 % of 700 draws are inside at these speeds; the standard error of 150 draws is 2.5 %."""
    formula, rng = Formula.load("75w90"), np.random.default_rng(1)
    found = formula.uncertainty(**POINT, speed_entrainment=speed)
    state = contact_points(**POINT, speed_entrainment=speed)
    changes = friction_changes(formula, state, Oil.load("75w90"), DEFAULT)
    names = [change.name for change in changes.each]
    draws = rng.normal(size=(150, len(names))) / score_of(0.9)
    drawn = [float(np.ravel(c)[0]) for c in changes.together([dict(zip(names, row, strict=True)) for row in draws])]
    inside = (np.log(found.low / found.value) < drawn) & (drawn < np.log(found.high / found.value))
    assert np.mean(inside) == pytest.approx(0.91, abs=0.06)
