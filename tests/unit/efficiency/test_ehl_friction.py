"""The contact solver as a friction model: which points it solves, how it interpolates, what it says of failures."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from refusals import refuses

import efficiency
from efficiency.conditions.conditions import resolve_friction
from efficiency.loss import ehl_friction as module
from efficiency.loss.ehl_friction import EhlFriction, ehl_friction
from ehl.common.progress import Progress, progress_to
from ehl.fluid.oil import Oil
from ehl.inputs import ContactProblem, SurfaceInput
from ehl.line_contact import LineContact
from ehl.state import ContactState
from regression.friction.models import FrictionFlag

OIL = Oil.load("fva3")


def states(n: int, seed: int = 1) -> ContactState:
    """Conditions of a smooth two-parameter family, as over a flank."""
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(-1.0, 1.0, (2, n))
    return ContactState.of(
        pressure_hertz=1e9 * np.exp(0.5 * a - 0.2 * b**2),
        radius_equivalent=0.012 * np.exp(0.2 * b),
        effective_modulus=226e9,
        speed_entrainment=3.0 * np.exp(0.1 * a),
        slide_to_roll=0.5 * b,
        roughness_rms_1=0.3e-6,
    )


def law(contact: LineContact) -> float:
    """Smooth in all variables; nearly proportional to small sliding."""
    sliding = np.tanh(contact.slide_to_roll_total / 0.1)
    return float(0.04 * sliding * (contact.pressure_hertz / 1e9) ** 0.5 * contact.speed_entrainment**-0.1)


class Solver:
    """Stands in for the contact solver; notes what it is asked."""

    def __init__(self, fails: Any = lambda contact: False) -> None:
        self.fails, self.asked, self.rough = fails, [], []

    def __call__(self, problem: ContactProblem) -> Any:
        contact, surface = problem.line, problem.surface
        self.asked.append(contact)
        self.rough.append(surface.roughness_rms_1)
        if self.fails(contact):
            return SimpleNamespace(status="failed", reason="film_jump")
        rough = surface.roughness_rms_1 > 0.0
        return SimpleNamespace(
            status="converged",
            friction_coefficient=law(contact),
            friction_error=0.01,
            statistical_error=0.004,
            film_central=1e-7 * contact.speed_entrainment,
            film_ratio=contact.speed_entrainment / 3.0 if rough else np.inf,
            temperature_flash=360.0,
            rolling_traction=1e-4,
        )


def exact(state: ContactState) -> np.ndarray:
    sliding = np.tanh(state.slide_to_roll_total / 0.1)
    return 0.04 * sliding * (state.pressure_hertz / 1e9) ** 0.5 * state.speed_entrainment**-0.1


def test_interpolation_is_within_its_stated_interval(monkeypatch: pytest.MonkeyPatch) -> None:
    solver = Solver()
    monkeypatch.setattr(module, "solve_contact", solver)
    state = states(1500)
    estimate = EhlFriction("ehl", points=module.SAMPLED, jobs=1).mu(state, oil=OIL)
    assert len(solver.asked) == module.SAMPLED
    assert all(estimate.flag == FrictionFlag.OK)
    wrong = np.abs(estimate.mu - exact(state))
    half = 0.5 * (estimate.upper - estimate.lower)
    power = state.load_per_length * state.speed_sliding
    assert np.sqrt(np.average(wrong**2, weights=power)) < np.median(half) < 0.15 * exact(state).mean()
    assert estimate.mu.mean() == pytest.approx(exact(state).mean(), rel=0.01)
    # the rest of each solution comes along
    np.testing.assert_allclose(estimate.film_central, 1e-7 * state.speed_entrainment, rtol=0.01)
    np.testing.assert_allclose(estimate.film_ratio, state.speed_entrainment / 3.0, rtol=0.01)
    np.testing.assert_allclose(estimate.temperature_flash, 360.0, rtol=1e-9)
    np.testing.assert_allclose(estimate.rolling_traction, 1e-4, rtol=1e-6)


def test_few_points_are_all_solved_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 30 all, of 150 where that is requested; equal contacts have one friction."""
    for count, model in ((30, EhlFriction("ehl", points=module.SAMPLED, jobs=1)), (150, ehl_friction("ehl:all"))):
        solver, state = Solver(), states(count)
        monkeypatch.setattr(module, "solve_contact", solver)
        estimate = replace(model, jobs=1).mu(state, oil=OIL)
        np.testing.assert_allclose(estimate.mu, exact(state), rtol=1e-9)
        np.testing.assert_allclose(estimate.upper - estimate.mu, 0.01 * estimate.mu, rtol=1e-9)
        assert sorted(c.pressure_hertz for c in solver.asked) == pytest.approx(sorted(state.pressure_hertz))
    equal = ContactState.of(
        pressure_hertz=np.full(4, 1e9), radius_equivalent=0.01, effective_modulus=226e9, speed_entrainment=3.0
    )
    assert np.ptp(EhlFriction("ehl", jobs=1).mu(equal, oil=OIL).mu) == 0.0


def test_smooth_leaves_the_roughness_out(monkeypatch: pytest.MonkeyPatch) -> None:
    for spec, rough in (("ehl:smooth", 0.0), ("ehl", 0.3e-6)):
        solver = Solver()
        monkeypatch.setattr(module, "solve_contact", solver)
        ehl_friction(spec).mu(states(5), oil=OIL)  # too few for worker processes
        assert set(solver.rough) == {rough}
    assert np.all(np.isinf(ehl_friction("ehl:smooth").mu(states(5), oil=OIL).film_ratio))


def test_each_contact_has_its_own_roughness(monkeypatch: pytest.MonkeyPatch) -> None:
    seeds: list[int] = []

    def solver(problem: ContactProblem) -> Any:
        seeds.append(problem.surface.seed)
        return Solver()(problem)

    monkeypatch.setattr(module, "solve_contact", solver)
    EhlFriction("ehl", points=40, jobs=1, seed=7).mu(states(200), oil=OIL)
    assert seeds == list(range(7, 47))
    seeds.clear()
    with refuses("points"):  # too few to predict the others from
        EhlFriction("ehl", points=12, jobs=1).mu(states(200), oil=OIL)
    # those that are added count on
    EhlFriction("ehl", points=40, tolerance=1e-9, jobs=1, seed=7).mu(states(200), oil=OIL)
    assert seeds == list(range(7, 47))


def test_bulk_temperatures_reach_the_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []

    def solver(problem: ContactProblem) -> Any:
        seen.append((problem.lubricant.temperature, problem.temperature_bulk))
        return Solver()(problem)

    monkeypatch.setattr(module, "solve_contact", solver)
    hot = {"temperature_oil": 350.0, "temperature_bulk_1": 370.0, "temperature_bulk_2": 360.0}
    EhlFriction("ehl", jobs=1).mu(replace(states(1), **{name: np.array([t]) for name, t in hot.items()}), oil=OIL)
    assert seen == [(350.0, (370.0, 360.0))]


def test_failed_contacts_are_predicted_by_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    state = states(1000)
    power = state.load_per_length * state.speed_sliding
    hard = float(np.quantile(state.pressure_hertz, 0.97))
    monkeypatch.setattr(module, "solve_contact", Solver(lambda contact: contact.pressure_hertz > hard))
    estimate = EhlFriction("ehl", points=module.SAMPLED, jobs=1).mu(state, oil=OIL)
    guessed = estimate.flag == FrictionFlag.PREDICTED
    assert set(estimate.failed) == {"film_jump"}
    assert 0 < estimate.failed["film_jump"] < 10
    assert 0 < np.count_nonzero(guessed) < 150
    assert np.all(np.isfinite(estimate.mu))
    # an extrapolation, and its interval is wide enough for it
    half = estimate.upper - estimate.mu
    assert half[guessed].min() > 1.5 * half[~guessed].max()
    wrong = np.abs(estimate.mu - exact(state))
    assert np.average((wrong < half)[guessed], weights=power[guessed]) > 0.98
    monkeypatch.setattr(module, "solve_contact", Solver())
    sound = EhlFriction("ehl", points=module.SAMPLED, jobs=1).mu(state, oil=OIL)
    assert sound.failed == {}
    assert sound.contacts == module.SAMPLED
    assert estimate.mean_error > 1.2 * sound.mean_error
    mean = np.average(exact(state), weights=power)
    assert abs(np.average(estimate.mu, weights=power) / mean - 1.0) < estimate.mean_error


def test_too_many_failed_contacts_leave_their_neighbourhood_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "solve_contact", Solver(lambda contact: contact.pressure_hertz > 1.4e9))
    state = states(1000)
    power = state.load_per_length * state.speed_sliding
    estimate = EhlFriction("ehl", points=module.SAMPLED, jobs=1).mu(state, oil=OIL)
    unknown = estimate.flag == FrictionFlag.NOT_CONVERGED
    assert power[unknown].sum() > module.MAX_FAILED * power.sum()
    assert np.count_nonzero(unknown) < 250
    np.testing.assert_array_equal(unknown, np.isnan(estimate.mu))
    assert state.pressure_hertz[unknown].min() > 1.1e9
    assert np.isnan(estimate.mean_error)


def test_a_failed_contact_among_all_points_is_predicted_too(monkeypatch: pytest.MonkeyPatch) -> None:
    state = states(60)
    failed = int(np.argsort(state.load_per_length * state.speed_sliding)[30])
    bad = float(state.pressure_hertz[failed])
    monkeypatch.setattr(module, "solve_contact", Solver(lambda contact: contact.pressure_hertz == pytest.approx(bad)))
    estimate = replace(ehl_friction("ehl:all"), jobs=1).mu(state, oil=OIL)
    np.testing.assert_array_equal(np.flatnonzero(estimate.flag == FrictionFlag.PREDICTED), [failed])
    others = np.arange(60) != failed
    np.testing.assert_allclose(estimate.mu[others], exact(state)[others], rtol=1e-9)
    assert 0.0 < abs(estimate.mu - exact(state))[failed] < estimate.upper[failed] - estimate.mu[failed]


def scattered(noise: np.random.Generator, scatter: float) -> Any:
    def solver(contact: LineContact, *rest: Any) -> Any:
        found = Solver()(contact, *rest)
        found.friction_coefficient *= 1.0 + scatter * noise.standard_normal()
        found.friction_error = found.statistical_error = scatter
        return found

    return solver


def test_contacts_are_added_until_chance_leaves_what_was_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """The error that ends the growth holds as often as two standard deviations of a chosen end should."""
    state = states(500)
    power = state.load_per_length * state.speed_sliding
    mean = np.average(exact(state), weights=power)
    counts: dict[float, list[int]] = {0.04: [], 0.02: []}
    inside, runs = 0, 10
    for asked, counted in counts.items():
        for seed in range(runs):
            monkeypatch.setattr(module, "solve_contact", scattered(np.random.default_rng(seed), 0.06))
            estimate = EhlFriction("ehl", points=200, tolerance=asked, jobs=1).mu(state, oil=OIL)
            counted.append(estimate.contacts)
            assert estimate.mean_error <= 1.001 * asked or estimate.contacts == 200
            inside += abs(np.average(estimate.mu, weights=power) / mean - 1.0) < estimate.mean_error
    assert inside >= 0.85 * 2 * runs
    assert module.FIRST <= min(counts[0.04]) < np.median(counts[0.04]) < np.median(counts[0.02]) <= 200


def test_growth_ends_at_the_most_contacts_and_where_it_is_met_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    heard: list[Progress] = []
    state = states(300)
    for tolerance, wanted in ((1e-6, 40), (0.9, module.FIRST)):
        monkeypatch.setattr(module, "solve_contact", scattered(np.random.default_rng(1), 0.1))
        heard.clear()
        with progress_to(heard.append):
            estimate = EhlFriction("ehl", points=40, tolerance=tolerance, jobs=1).mu(state, oil=OIL)
        assert estimate.contacts == wanted
        # the estimated time is reported before the first contact, and the progress after each
        assert (heard[0].step, heard[0].done, heard[0].total) == ("contacts", 0, module.FIRST)
        assert 0.05 * module.FIRST < heard[0].seconds_left < 10.0 * module.FIRST
        assert [state.done for state in heard if state.seconds_left is None] == list(range(1, wanted + 1))
        assert heard[-1].done == heard[-1].total == wanted


def test_growth_goes_where_the_others_are_missed(monkeypatch: pytest.MonkeyPatch) -> None:
    """One half of the family scatters: the contacts that are added lie there."""
    noise = np.random.default_rng(2)
    asked: list[float] = []

    def solver(problem: ContactProblem) -> Any:
        contact = problem.line
        asked.append(contact.slide_to_roll)
        found = Solver()(problem)
        if contact.slide_to_roll > 0.0:
            found.friction_coefficient *= 1.0 + 0.3 * noise.standard_normal()
        return found

    monkeypatch.setattr(module, "solve_contact", solver)
    EhlFriction("ehl", points=80, tolerance=1e-3, jobs=1).mu(states(1000), oil=OIL)
    first, added = np.array(asked[: module.FIRST]), np.array(asked[module.FIRST :])
    assert 0.3 < np.mean(first > 0.0) < 0.7
    assert np.mean(added > 0.0) > 0.65


def test_worker_processes_give_the_same_friction(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MIN_SECONDS", 0.1)
    monkeypatch.setattr("joblib.externals.loky.cpu_count", lambda: 2)
    state = states(24, 4)
    one, two = (replace(ehl_friction("ehl:smooth"), jobs=jobs).mu(state, oil=OIL) for jobs in (1, 2))
    np.testing.assert_array_equal(two.mu, one.mu)
    assert np.all(two.flag == FrictionFlag.OK)


def test_names() -> None:
    for spec, points, tolerance in (
        ("ehl", module.POINTS, 0.03),
        ("ehl:smooth", module.POINTS, 0.002),
        ("ehl:5%", module.POINTS, 0.05),
        ("ehl:smooth:0.5%", module.POINTS, 0.005),
        ("ehl:sampled", module.SAMPLED, None),
        ("ehl:all", None, None),
        ("ehl:smooth:all", None, None),
    ):
        model = ehl_friction(spec)
        assert model.points == points
        assert tolerance is None or model.tolerance == pytest.approx(tolerance)
    wrong = ["ehl:rough", "ehl:", "ehl2", "ehl:all:sampled"]
    for spec in (*wrong, "ehl:0%", "ehl:x%", "ehl:200%", "ehl:all:5%", "ehl:5%:6%"):
        with refuses("friction model"):
            ehl_friction(spec)


@pytest.mark.parametrize(("state", "skewness"), [("run_in", -0.8), ("new", 0.0)])
def test_surfaces_of_flanks_are_those_of_contacts_with_their_finish(state: str, skewness: float) -> None:
    """Boundary friction of the additive and the heights of the finish: a gear and a contact have one surface."""
    design = efficiency.load("fm_spiral_bevel_14x39").design.with_finish("ground", state)
    model = resolve_friction("ehl", design)
    _, _, surface, _ = model._contact(states(3), OIL, 0, 1)
    named = SurfaceInput(finish="ground", finish_state=state)
    for name in ("boundary_friction", "film_of_contact", "skewness", "kurtosis"):
        assert getattr(surface, name) == getattr(named, name)
    assert surface.skewness == pytest.approx(skewness)
