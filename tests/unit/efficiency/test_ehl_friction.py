"""The contact solver as a friction model: points solved, interpolation, failures, texture of the flanks, efficiency."""

import json
import tomllib
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest
from refusals import refuses
from samples import AXLE_OIL, OPERATION
from samples import BEVEL as DESIGN

from efficiency.conditions.conditions import resolve_friction
from efficiency.conditions.duty import DutyRow
from efficiency.design.design import Design
from efficiency.loss import ehl_friction as module
from efficiency.loss.efficiency import mesh_efficiency
from efficiency.loss.ehl_friction import EhlFriction, ehl_friction
from efficiency.loss.power_loss import friction_along_mesh, loss_by_region
from efficiency.ltca.mesh_grids import LoadedGrids, load_grids
from efficiency.mesh import Mesh
from efficiency.output.tables import efficiency_table
from efficiency.pair import GearPair
from efficiency.studies.parameter_study import Levels, run_study
from ehl.common.errors import InputError
from ehl.common.progress import Progress, progress_to
from ehl.common.validation import validate
from ehl.fluid.oil import Oil
from ehl.inputs import ContactProblem, SurfaceInput
from ehl.line_contact import LineContact
from ehl.state import ContactState
from regression.formula import friction_model
from regression.friction.conditions import Conditions
from regression.friction.models import ConstantFriction, FrictionEstimate, FrictionFlag

OIL = Oil.load("fva3")


def states(n: int, seed: int = 1) -> ContactState:
    """Conditions of a smooth two-parameter family, as over a flank."""
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(-1.0, 1.0, (2, n))
    speed, pressure = 3.0 * np.exp(0.1 * a), 1e9 * np.exp(0.5 * a - 0.2 * b**2)
    at = {"pressure_hertz": pressure, "effective_modulus": 226e9, "speed_entrainment": speed, "slide_to_roll": 0.5 * b}
    return ContactState.of(**at, radius_equivalent=0.012 * np.exp(0.2 * b), roughness_rms_1=0.3e-6)


def exact(contact: ContactState | LineContact) -> Any:
    """Smooth in all variables; nearly proportional to small sliding."""
    sliding = np.tanh(contact.slide_to_roll_total / 0.1)
    return 0.04 * sliding * (contact.pressure_hertz / 1e9) ** 0.5 * contact.speed_entrainment**-0.1


class Solver:
    """Stands in for the contact solver; keeps the problems it is called with."""

    def __init__(self, fails: Any = lambda contact: False, friction: Any = exact, error: float = 0.01) -> None:
        self.fails, self.friction, self.error, self.problems = fails, friction, error, list[ContactProblem]()

    def __call__(self, problem: ContactProblem) -> Any:
        contact = problem.line
        self.problems.append(problem)
        if self.fails(contact):
            return SimpleNamespace(status="failed", reason="film_jump")
        rough = problem.surface.roughness_rms_1 > 0.0
        speed = contact.speed_entrainment
        return SimpleNamespace(
            status="converged", friction_coefficient=float(self.friction(contact)), friction_error=self.error,
            statistical_error=0.4 * self.error, film_central=1e-7 * speed, film_ratio=speed / 3.0 if rough else np.inf,
            temperature_flash=360.0, rolling_traction=1e-4,
        )  # fmt: skip


def test_interpolation_is_within_its_stated_interval(monkeypatch: pytest.MonkeyPatch) -> None:
    solver = Solver()
    monkeypatch.setattr(module, "solve_contact", solver)
    state = states(1500)
    estimate = EhlFriction("ehl", points=module.SAMPLED, jobs=1).mu(state, oil=OIL)
    assert len(solver.problems) == module.SAMPLED
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
        pressures = sorted(problem.line.pressure_hertz for problem in solver.problems)
        assert pressures == pytest.approx(sorted(state.pressure_hertz))
    one = {"radius_equivalent": 0.01, "effective_modulus": 226e9, "speed_entrainment": 3.0, "slide_to_roll": 0.2}
    equal = ContactState.of(pressure_hertz=np.full(4, 1e9), **one)
    estimate = EhlFriction("ehl", jobs=1).mu(equal, oil=OIL)
    assert np.ptp(estimate.mu) == 0.0
    # chance falls with the root of the number, the rest of the error stays
    assert estimate.mean_error == pytest.approx(np.hypot(0.004 / 2.0, np.sqrt(0.01**2 - 0.004**2)))


def test_what_reaches_the_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bulk temperatures, and the roughness but for smooth contacts; too few contacts to predict others are refused."""
    temperatures = {"temperature_oil": 350.0, "temperature_bulk_1": 370.0, "temperature_bulk_2": 360.0}
    state = replace(states(5), **{name: np.full(5, t) for name, t in temperatures.items()})
    for spec, rough in (("ehl:smooth", 0.0), ("ehl", 0.3e-6)):
        monkeypatch.setattr(module, "solve_contact", solver := Solver())
        ehl_friction(spec).mu(state, oil=OIL)  # too few for worker processes
        assert {problem.surface.roughness_rms_1 for problem in solver.problems} == {rough}
        assert {problem.temperature_bulk for problem in solver.problems} == {(370.0, 360.0)}
        assert {problem.lubricant.temperature for problem in solver.problems} == {350.0}
    with refuses("points"):
        EhlFriction("ehl", points=12, jobs=1).mu(states(200), oil=OIL)


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
    assert (sound.failed, sound.contacts) == ({}, module.SAMPLED)
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
        # progress is reported before the first contact and after each
        assert (heard[0].step, heard[0].done, heard[0].total) == ("contacts", 0, module.FIRST)
        assert heard[0].seconds_left is None  # before a contact is finished its time is not known
        assert sorted({state.done for state in heard}) == list(range(wanted + 1))
        assert heard[-1].done == heard[-1].total == wanted


def test_growth_goes_where_the_others_are_missed(monkeypatch: pytest.MonkeyPatch) -> None:
    """One half of the family scatters: the contacts that are added lie there, each with a roughness of its own."""
    noise, solver = np.random.default_rng(2), Solver()

    def solve(problem: ContactProblem) -> Any:
        found = solver(problem)
        if problem.line.slide_to_roll > 0.0:
            found.friction_coefficient *= 1.0 + 0.3 * noise.standard_normal()
        return found

    monkeypatch.setattr(module, "solve_contact", solve)
    EhlFriction("ehl", points=80, tolerance=1e-3, jobs=1, seed=7).mu(states(1000), oil=OIL)
    assert [problem.surface.seed for problem in solver.problems] == list(range(7, 87))
    scatters = np.array([problem.line.slide_to_roll > 0.0 for problem in solver.problems])
    assert 0.3 < scatters[: module.FIRST].mean() < 0.7
    assert scatters[module.FIRST :].mean() > 0.65


def test_worker_processes_give_the_same_friction(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MIN_SECONDS", 0.1)
    monkeypatch.setattr("joblib.externals.loky.cpu_count", lambda: 2)
    state = states(24, 4)
    one, two = (replace(ehl_friction("ehl:smooth"), jobs=jobs).mu(state, oil=OIL) for jobs in (1, 2))
    np.testing.assert_array_equal(two.mu, one.mu)
    assert np.all(two.flag == FrictionFlag.OK)


def test_names() -> None:
    for spec, points, tolerance in (
        ("ehl:5%", module.POINTS, 0.05), ("ehl:smooth:0.5%", module.POINTS, 0.005),
        ("ehl:sampled", module.SAMPLED, 0.03), ("ehl:smooth:all", None, 0.002),
    ):  # fmt: skip
        assert (ehl_friction(spec).points, ehl_friction(spec).tolerance) == (points, pytest.approx(tolerance))
    for spec in ("ehl:rough", "ehl:", "ehl:all:sampled", "ehl:0%", "ehl:x%", "ehl:200%", "ehl:all:5%", "ehl:5%:6%"):
        with refuses("friction model"):
            ehl_friction(spec)


@pytest.mark.parametrize(("state", "skewness"), [("run_in", -0.8), ("new", 0.0)])
def test_surfaces_of_flanks_are_those_of_contacts_with_their_finish(state: str, skewness: float) -> None:
    """Boundary friction of the additive and the heights of the finish: a gear and a contact have one surface."""
    design = DESIGN.with_finish("ground", state)
    model = resolve_friction("ehl", design)
    _, _, surface, _ = model._contact(states(3), OIL, 0, 1)
    named = SurfaceInput(finish="ground", finish_state=state)
    for name in ("boundary_friction", "film_of_contact", "skewness", "kurtosis"):
        assert getattr(surface, name) == getattr(named, name)
    assert surface.skewness == pytest.approx(skewness)


TEXTURE = {"correlation_length": 60e-6, "peklenik_number": 4.0}
TEXTURED = DESIGN.model_copy(update={"surface": DESIGN.surface.model_copy(update=TEXTURE)})
PAIR, COARSE = GearPair(TEXTURED), (4, 9)


@pytest.fixture(scope="module")
def loaded() -> LoadedGrids:
    return load_grids(Mesh.of(DESIGN, "drive", 6, 15, keep=True).grids, 200.0)


def falling(fails: Any = lambda contact: False) -> Solver:
    """Friction that falls with the pressure."""
    return Solver(fails, lambda contact: 0.06 - 0.02 * contact.pressure_hertz / 1e9, 0.03)


def model() -> EhlFriction:
    return replace(ehl_friction("ehl"), points=60, tolerance=0.0, jobs=1)


def test_failed_contacts_are_counted_and_an_error(loaded: LoadedGrids, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "solve_contact", falling())
    sound = mesh_efficiency(loaded, model(), AXLE_OIL, OPERATION)
    pressure = np.sort(sound.points.state.pressure_hertz)
    hard = float(pressure[-8])
    monkeypatch.setattr(module, "solve_contact", falling(lambda contact: contact.pressure_hertz >= hard))
    result = mesh_efficiency(loaded, model(), AXLE_OIL, OPERATION)
    assert (sound.solution.contacts, sound.solution.contacts_failed) == (60, {})
    error = sound.errors
    assert error.contacts == pytest.approx((1.0 - sound.efficiency) * sound.friction.mean_error)  # type: ignore[attr-defined]
    assert sound.efficiency_error == pytest.approx(error.contacts + error.positions + error.points)
    assert (result.status, result.solution.contacts) == ("converged", 60)
    failed = result.solution.contacts_failed["film_jump"]
    assert 0 < failed < 6
    share = result.friction_range.flag_shares["predicted"]
    assert 0.0 < share < 0.1
    assert result.efficiency == pytest.approx(sound.efficiency, abs=2e-5)
    assert result.efficiency_upper - result.efficiency_lower > sound.efficiency_upper - sound.efficiency_lower
    # every share is of all the loss
    assert sum(result.friction_range.flag_shares.values()) == pytest.approx(1.0)
    assert loss_by_region(result).sum() == pytest.approx(1.0)
    assert np.all(np.isfinite(friction_along_mesh(result)))
    assert json.loads(json.dumps(result.to_dict()))["solution"]["contacts_failed"] == {"film_jump": failed}
    (shown,) = efficiency_table(result).records()
    assert (shown["contacts"], shown["failed"], shown["predicted_share"]) == (60, failed, share)


def test_where_too_much_failed_is_no_efficiency(loaded: LoadedGrids, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "solve_contact", falling(lambda contact: contact.pressure_hertz > 0.9e9))
    result = mesh_efficiency(loaded, model(), AXLE_OIL, OPERATION)
    assert (result.status, result.reason) == ("failed", "friction_not_converged")
    assert np.isnan([result.efficiency, result.efficiency_lower, result.edges.loss_share]).all()
    assert np.all(np.isnan(loss_by_region(result)))
    assert result.friction_range.flag_shares["not_converged"] > module.MAX_FAILED
    monkeypatch.setattr(module, "solve_contact", falling(lambda contact: True))
    failed = mesh_efficiency(loaded, model(), AXLE_OIL, OPERATION)
    (shown,) = efficiency_table(failed).records()
    assert (shown["contacts"], shown["failed"], shown["film_ratio_min"]) == (60, 60, None)


def test_the_peklenik_number_is_told_where_friction_does_not_know_it(loaded: LoadedGrids) -> None:
    ground = replace(OPERATION, peklenik_number=5.0)
    model = friction_model("schlenk_1994")
    notes, usual = (mesh_efficiency(loaded, model, AXLE_OIL, at).notes for at in (ground, OPERATION))
    assert len(set(notes) - set(usual)) == 1
    # the data of this one vary the lay, and marks across the motion rub less
    by_formula, isotropic = (
        mesh_efficiency(loaded, friction_model("75w90"), AXLE_OIL, at).friction_coefficient_mean
        for at in (ground, OPERATION)
    )
    assert by_formula < 0.98 * isotropic


def test_texture_in_the_design_file_and_its_limits() -> None:
    content = DESIGN.model_dump(exclude_none=True)
    given = content | tomllib.loads('[surface]\ncorrelation_length = "45 um"\npeklenik_number = 3')
    assert validate(Design, given).surface.correlation_length == pytest.approx(45e-6)
    for wrong in ({"correlation_length": "0.1 um"}, {"peklenik_number": 0.1}, {"rq": 1}):
        with pytest.raises(InputError, match=r"surface\."):
            validate(Design, content | {"surface": wrong})


class Witness(ConstantFriction):
    seen: ClassVar[list[tuple[float, ...]]] = []

    def evaluate(self, conditions: Conditions, oil: Oil) -> FrictionEstimate:
        # points of several conditions may be evaluated together
        self.seen += set(zip(conditions["correlation_length"], conditions["peklenik_number"], strict=True))
        return super().evaluate(conditions, oil)


def test_texture_reaches_points_maps_duty_and_study() -> None:
    witness = Witness(0.05)
    witness.seen.clear()
    rows = [DutyRow(200.0, 125.0, 363.15, 1.0)]
    result = PAIR.at(witness, grid=COARSE)
    assert (result.conditions.correlation_length, result.conditions.peklenik_number) == (60e-6, 4.0)
    PAIR.over(witness, grid=COARSE, torque=[200.0], speed=[100.0])
    PAIR.duty(rows, witness, grid=COARSE)
    levels = Levels((200.0,), (125.0,), (363.15,), (2e-7,), E=(), P=(), G=(), shaft_angle_error=())
    assert run_study([TEXTURED], witness, levels, grid=COARSE).points[0].reason == ""
    assert set(witness.seen) == {(60e-6, 4.0)}
    assert len(witness.seen) >= 4
    state = PAIR.duty_points(rows, grid=COARSE)[0].state
    assert np.all(state.correlation_length == 60e-6)
    PAIR.over(witness, grid=COARSE, correlation_length=[2e-5, 1e-4])
    assert set(witness.seen) == {(60e-6, 4.0), (2e-5, 4.0), (1e-4, 4.0)}


def test_texture_reaches_the_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "solve_contact", solver := falling())
    PAIR.at(model(), grid=COARSE)
    surfaces = [problem.surface for problem in solver.problems]
    assert {(surface.correlation_length, surface.peklenik_number) for surface in surfaces} == {(60e-6, 4.0)}
