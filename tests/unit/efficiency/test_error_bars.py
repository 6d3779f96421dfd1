"""Error bars of the efficiency: every factor and every term, by hand, exact laws or random draws."""

import importlib
import json
import math
from dataclasses import astuple, dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from refusals import refuses
from samples import AXLE_OIL as OIL
from samples import BEVEL, OPERATION, tiny_load

import efficiency
from efficiency.conditions.duty import DutyRow
from efficiency.design.design import Design
from efficiency.loss.contact_sample import remoteness
from efficiency.loss.efficiency import mesh_efficiency
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.ehl_friction import EhlFriction, Solved, _friction, _left_open
from efficiency.loss.friction_equilibrium import balance_error
from efficiency.loss.kinematics import LoadedPoints, Operation, loaded_points
from efficiency.loss.lubrication import warmed
from efficiency.loss.power_loss import rolling_losses
from efficiency.loss.uncertainty import LossSample, stand_in
from ehl.common.errors import InputError
from ehl.common.validation import validate
from ehl.fluid.oil import Oil
from ehl.state import ContactState
from ehl.uncertainty.result import score_of
from ehl.uncertainty.spread import UncertaintyInput
from regression.formula import friction_model
from regression.friction.conditions import Conditions
from regression.friction.models import ConstantFriction, FrictionEstimate, FrictionModel
from regression.friction.uncertainty import boundary_friction_of, uncertain_inputs

MU = 0.05


def loss_of(points: LoadedPoints, positions: int) -> float:
    """Mean power loss at a constant friction coefficient [W]."""
    return MU * float(points.force @ points.speed_sliding) / positions


@pytest.mark.parametrize("driver", ["pinion", "gear"])
def test_error_is_twice_what_half_the_positions_and_half_the_points_change(driver: str) -> None:
    operation = replace(OPERATION, driver=driver)
    result = mesh_efficiency(tiny_load(), ConstantFriction(MU), OIL, operation)
    power = 200.0 * 125.0

    def efficiency_at(loss: float) -> float:
        return 1.0 - loss / power if driver == "pinion" else power / (power + loss)

    loaded = tiny_load()
    fine = loaded_points(loaded.fine, loaded.mesh.teeth.effective_modulus, operation)
    coarse = loaded_points(loaded.coarse, loaded.mesh.teeth.effective_modulus, operation)
    every = efficiency_at(loss_of(fine, 4))
    assert result.efficiency == pytest.approx(every, rel=1e-12)
    second = fine.position % 2 == 0
    half = efficiency_at(MU * float(fine.force[second] @ fine.speed_sliding[second]) / 2)
    fewer = efficiency_at(loss_of(coarse, 4))
    assert min(abs(half - every), abs(fewer - every)) > 1e-7
    assert result.errors.positions == pytest.approx(2.0 * abs(half - every), rel=1e-9)
    assert result.errors.points == pytest.approx(2.0 * abs(fewer - every), rel=1e-9)
    assert result.efficiency_error == pytest.approx(sum(astuple(result.errors)), rel=1e-9)


def test_error_of_the_balance_by_forces_of_before(monkeypatch: pytest.MonkeyPatch) -> None:
    """mu as force^0.7 changes the loss by 0.7 of a small change of the forces; a tangent of a tenth by 0.3 %."""
    assert balance_error(0.02, 1e-3, 0.0) == pytest.approx(0.02 * (1.001**0.7 - 1.0), rel=1e-3)
    assert balance_error(0.02, 0.0, 0.1) == pytest.approx(0.02 * 0.003)
    monkeypatch.setattr("efficiency.loss.efficiency.balance_error", lambda loss, moved, distance: loss)
    result = mesh_efficiency(tiny_load(), ConstantFriction(MU), OIL, OPERATION, "frictional")
    assert result.errors.balance == pytest.approx(result.power_loss / (200.0 * 125.0), rel=1e-12)
    assert result.efficiency_error == pytest.approx(sum(astuple(result.errors)))


def solved(mu: np.ndarray, scatter: np.ndarray, bias: np.ndarray) -> Solved:
    rest = np.ones((4, mu.size))
    reasons = tuple("" if math.isfinite(value) else "film_jump" for value in mu)
    return Solved(np.vstack([mu, np.where(np.isfinite(mu), rest, np.nan)]), scatter, bias, reasons)


def test_error_of_the_mean_over_solved_contacts_by_hand() -> None:
    """Chance adds in squares, bias in a line, both in squares: shares 1/2, 1/4, 1/4 of the sliding power.

    chance = sqrt((0.5 x 4)^2 + (0.25 x 8)^2 + (0.25 x 8)^2) 1e-4 = sqrt(12) 1e-4; bias = (0.5 + 0.5 + 0.75) 1e-3.
    """
    place, power = np.eye(3), np.array([2.0, 1.0, 1.0])
    mu, scatter = np.array([0.05, 0.04, 0.06]), np.array([4e-4, 8e-4, 8e-4])
    bias = np.array([1e-3, 2e-3, 3e-3])
    found = _friction(place, power, np.arange(3), solved(mu, scatter, bias))
    assert found.mean_error == pytest.approx(math.sqrt(12e-8 + 1.75e-3**2) / 0.05, rel=1e-12)
    assert found.method_error == pytest.approx(1.75e-3 / 0.05, rel=1e-12)
    for half in (found.upper - mu, mu - found.lower):
        np.testing.assert_allclose(half, np.hypot(scatter, bias), rtol=1e-12)


def test_error_of_sampled_contacts_is_the_scatter_of_their_mean() -> None:
    """Two standard deviations of the mean over 200 points, by 50 draws of the scatter of 40 contacts."""
    rng = np.random.default_rng(8)
    place, power, chosen = rng.uniform(size=(200, 2)), rng.uniform(0.5, 1.5, 200), np.arange(40)
    means, errors = [], []
    for _ in range(50):
        mu = 0.05 + 0.01 * place[:40, 0] + 0.003 * rng.standard_normal(40)
        contacts = solved(mu, np.zeros(40), np.zeros(40))
        found, error = _friction(place, power, chosen, contacts), _left_open(place, power, chosen, contacts)[0]
        assert found.mean_error == pytest.approx(error)
        means.append(float(np.average(found.mu, weights=power)))
        errors.append(error * means[-1])
    assert np.mean(errors) == pytest.approx(2.0 * np.std(means), rel=0.3)
    assert remoteness(np.array([[0.5], [4.0]]), np.array([[0.0], [1.0], [2.0]])) == pytest.approx([1.0, 2.0])


def test_error_of_the_mean_of_draws_of_the_roughness(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four draws by random numbers with common errors of grid and method, in units of their standard deviations."""
    monkeypatch.syspath_prepend(str(Path(__file__).resolve().parents[3] / "validation"))
    error_of_mean = importlib.import_module("operating_points").error_of_mean

    def draw(grid: float, method: float, chance: float) -> SimpleNamespace:
        errors = SimpleNamespace(positions=grid, points=0.0, balance=0.0, contacts=math.hypot(method, chance))
        friction = SimpleNamespace(mean_error=3.0 * math.hypot(method, chance), method_error=3.0 * method)
        return SimpleNamespace(errors=errors, friction=friction)

    rng = np.random.default_rng(2)
    for method, chance in ((0.0, 1.0), (1.0, 0.0), (0.6, 1.5)):
        means = method * rng.standard_normal(20_000) + chance * rng.standard_normal((4, 20_000)).mean(axis=0)
        assert error_of_mean([draw(0.0, method, chance)] * 4) == pytest.approx(means.std(), rel=0.02)
        assert error_of_mean([draw(0.5, method, chance)] * 4) == pytest.approx(0.5 + means.std(), rel=0.02)
    assert error_of_mean([draw(0.2, 0.6, 1.5)]) == pytest.approx(0.2 + math.hypot(0.6, 1.5))


def test_rolling_loss_is_the_work_on_both_surfaces() -> None:
    """2 t_r F u_r at each point: 2 x 1e-3 x 100 x 2 and 2 x 2e-3 x 50 x 2."""
    one = {"radius_equivalent": 0.01, "effective_modulus": 226e9, "speed_entrainment": 2.0}
    state = ContactState.of(pressure_hertz=[1e9, 1e9], **one)
    points = LoadedPoints(state, np.array([100.0, 50.0]), np.ones(2), np.array([0, 2]), np.array([0, 0]))
    np.testing.assert_allclose(rolling_losses(points, np.array([1e-3, 2e-3]), 3), [0.4, 0.0, 0.4], rtol=1e-12)
    result = mesh_efficiency(tiny_load(), ConstantFriction(MU), OIL, OPERATION)
    assert result.power_loss_rolling == pytest.approx(result.cycle.power_loss_rolling.mean(), rel=1e-12)
    lost = (result.efficiency - result.efficiency_with_rolling) * result.power_input
    assert lost == pytest.approx(result.power_loss_rolling, rel=1e-9)


Z = score_of(0.9)
ROUGH = Operation(125.0, 363.15, 0.4e-6, 0.3e-6)


@dataclass(frozen=True)
class Product(FrictionModel):
    """mu = mu_b Rq1 sqrt(lc), without an error of its own."""

    boundary_friction: float = 0.1
    error: float = 0.0
    name: str = "product"

    def evaluate(self, conditions: Conditions, oil: Oil) -> FrictionEstimate:
        mu = self.boundary_friction * conditions["roughness_rms_1"] / 1e-6
        mu = mu * np.sqrt(conditions["correlation_length"] / 30e-6)
        width = 2.0 * self.error
        return FrictionEstimate(mu, mu * np.exp(-width), mu * np.exp(width), np.zeros(mu.shape, np.int8))


def solve(model: FrictionModel, spreads: UncertaintyInput) -> EfficiencyResult:
    return mesh_efficiency(tiny_load(), model, OIL, replace(ROUGH, uncertainty=spreads))


def test_products_add_their_relative_spreads_as_squares() -> None:
    spreads = UncertaintyInput.none(boundary_friction=0.1, roughness_rms=0.2, correlation_length=0.4)
    found = solve(Product(error=0.04), spreads)
    widths = {part.name: -math.log((1.0 - part.below) / (1.0 - part.above)) / 2.0 / Z for part in found.inputs.sources}
    expected = {"boundary_friction": 0.1, "roughness_rms_1": 0.2, "correlation_length": 0.2, "friction formula": 0.04}
    assert widths == pytest.approx(expected, rel=1e-9)
    total = math.exp(Z * math.sqrt(0.1**2 + 0.2**2 + 0.2**2 + 0.04**2))
    loss = 1.0 - found.efficiency
    assert 1.0 - found.efficiency_lower == pytest.approx(loss * total, rel=1e-9)
    assert 1.0 - found.efficiency_upper == pytest.approx(loss / total, rel=1e-9)
    assert sum(source.share for source in found.inputs.sources) == pytest.approx(1.0)
    assert json.loads(json.dumps(found.to_dict()))["uncertainty"]["low"] == found.efficiency_lower


def test_one_finish_makes_both_surfaces_wrong_the_same_way() -> None:
    """Of a sum of both Rq, two independent ones leave 1/sqrt(2) of what one cause leaves."""

    @dataclass(frozen=True)
    class Sum(FrictionModel):
        name: str = "sum"

        def evaluate(self, conditions: Conditions, oil: Oil) -> FrictionEstimate:
            mu = 0.1 * (conditions["roughness_rms_1"] + conditions["roughness_rms_2"]) / 1e-6
            return FrictionEstimate(mu, mu, mu, np.zeros(mu.shape, np.int8))

    at = replace(ROUGH, roughness_rms_gear=ROUGH.roughness_rms_pinion)
    spreads = UncertaintyInput.none(roughness_rms=0.01)
    apart, together = (
        mesh_efficiency(tiny_load(), Sum(), OIL, replace(at, uncertainty=each)).inputs
        for each in (spreads, spreads.model_copy(update={"same_surface": True}))
    )
    assert len(together.sources) == 1
    assert (together.high - together.low) / (apart.high - apart.low) == pytest.approx(math.sqrt(2.0), rel=1e-4)


def test_nothing_uncertain_leaves_nothing_open() -> None:
    found = solve(Product(), UncertaintyInput.none())
    assert found.inputs.sources == ()
    assert found.efficiency_lower == found.efficiency_upper == found.efficiency
    constant = solve(friction_model("constant:0.05"), UncertaintyInput())
    assert constant.efficiency_lower == constant.efficiency_upper == constant.efficiency
    # a published formula has no error of its own
    published = solve(friction_model("benedict_kelley_1961"), UncertaintyInput())
    assert {source.group for source in published.inputs.sources} == {"oil", "roughness"}
    assert constant.inputs.notes
    assert published.inputs.notes


def test_interval_on_the_formula_holds_what_random_inputs_give() -> None:
    """300 draws of all inputs the formula holds at once: 85 to 95 % lie in the 90 % interval, both sides in use."""
    model = friction_model("75w90")
    outside = dict.fromkeys(("peklenik_number", "boundary_film", "temperature_bulk"), 0.0)
    spreads = UncertaintyInput(**outside)
    result = solve(model, spreads)
    sample = LossSample.of(result.points, result.friction)
    formula = [source for source in result.inputs.sources if source.group == "formula"]
    assert len(formula) == 1
    loss, rng = float(result.friction.mu @ sample.power), np.random.default_rng(3)
    low, high = result.inputs.low, result.inputs.high
    inputs, count, inside, below = uncertain_inputs(model, sample.state, OIL, spreads), 300, 0, 0
    for _ in range(count):
        case = model, sample.state, OIL
        for entry in inputs:
            case = entry.moved(case, float(rng.normal()))
        friction, state, oil = case
        width = math.log((1.0 - formula[0].below) / (1.0 - result.efficiency)) / Z
        drawn = float(friction.mu(state, oil=oil).mu @ sample.power) / loss * math.exp(width * rng.normal())
        eta = 1.0 - (1.0 - result.efficiency) * drawn
        inside += low <= eta <= high
        below += eta < low
    assert 0.85 * count <= inside <= 0.95 * count
    assert 0.01 * count <= below <= 0.09 * count


def test_solved_contacts_ask_the_formula_of_their_oil_and_keep_their_error_apart() -> None:
    formula, note = stand_in(EhlFriction("ehl", boundary_friction=0.08), OIL)
    assert boundary_friction_of(formula) == 0.08
    assert note != stand_in(EhlFriction("ehl"), OIL.model_copy(update={"name": "mine"}))[1]


def test_a_design_may_state_its_own_spreads() -> None:
    content = BEVEL.model_dump(exclude_none=True)
    design = validate(Design, content | {"uncertainty": {"roughness_rms": 0.01, "temperature_bulk": "5 K"}})
    assert design.running(100.0, 350.0).uncertainty.roughness_rms == 0.01
    with refuses("uncertainty.roughness_rms"):
        validate(Design, content | {"uncertainty": {"roughness_rms": -0.1}})
    with refuses("level"):
        solve(Product(), UncertaintyInput()).uncertainty(level=1.0)


@pytest.mark.parametrize("torque", [300.0, -300.0])
def test_rows_of_a_duty_cycle_are_wrong_the_same_way(torque: float) -> None:
    """Numerical errors of 1e-4 in a quarter of the energy and 3e-4 in the rest change the efficiency by 2.5e-4."""
    pair = efficiency.load("fm_spiral_bevel_14x39")
    one = DutyRow(torque=torque, speed=100.0, temperature=363.15, hours=1.0)
    cycle = pair.duty([one, replace(one, hours=3.0)], "75w90", grid=(4, 9))
    alone = cycle.results[0]
    assert alone.conditions.driver == ("pinion" if torque > 0.0 else "gear")
    assert cycle.inputs.low == pytest.approx(alone.efficiency_lower, rel=1e-9)
    assert cycle.inputs.high == pytest.approx(alone.efficiency_upper, rel=1e-9)
    errors = [replace(row, efficiency_error=error) for row, error in zip(cycle.rows, (1e-4, 3e-4), strict=True)]
    assert replace(cycle, rows=tuple(errors)).efficiency_error == pytest.approx(2.5e-4)


def test_interval_of_the_loss_holds_independent_sliding_and_rolling_losses() -> None:
    """Both as large and log-normal, with standard deviations of 0.1 and 0.12."""
    found = solve(Product(), UncertaintyInput.none(boundary_friction=0.1))
    both = replace(found, power_loss_rolling=found.power_loss)
    draws = np.random.default_rng(2).standard_normal((2, 100_000)) * [[0.1], [0.12]]
    drawn = found.power_loss * np.exp(draws).sum(axis=0)
    assert both.loss_interval == pytest.approx(np.quantile(drawn, (0.05, 0.95)), rel=0.01)


def test_estimated_temperature_of_the_teeth_is_uncertain_by_its_rise() -> None:
    """30 % of a rise of 40 K, and 2 K of the oil."""
    warm = mesh_efficiency(tiny_load(), friction_model("75w90"), OIL, warmed(ROUGH, 40.0)).inputs
    bulk = next(source for source in warm.sources if source.name == "temperature_bulk")
    assert bulk.sd == pytest.approx(math.hypot(12.0, 2.0))


def test_loss_of_some_points_is_that_of_all() -> None:
    """mu doubled where a share of the sliding power is lost adds this share to the loss, also of a quarter of them."""
    points = loaded_points(tiny_load().fine, tiny_load().mesh.teeth.effective_modulus, OPERATION)
    power, mu = points.force * points.speed_sliding, np.full(points.force.size, MU)
    doubled = np.cumsum(power) <= 0.5 * power.sum()
    for step, close in ((1, 1e-9), (4, 0.15)):
        sample = LossSample.of(points, FrictionEstimate(mu, mu, mu, 0 * points.position), math.ceil(mu.size / step))
        assert sample.power.size == math.ceil(mu.size / step)
        found = sample.mean(np.log(2.0) * doubled[::step])
        assert found == pytest.approx(math.log1p(power[doubled].sum() / power.sum()), rel=close)


def test_uncertainty_of_a_formula_is_that_of_one_point() -> None:
    point = {"pressure_hertz": 1.2e9, "radius_equivalent": 0.015, "speed_entrainment": 5.0, "temperature": 363.15}
    with pytest.raises(InputError, match="one contact point"):
        friction_model("75w90").uncertainty(**point, roughness_rms=4e-7, slide_to_roll=[0.1, 0.2])
