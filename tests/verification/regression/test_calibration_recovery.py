"""Calibration gives back known parameters within its stated intervals, and does not claim more than the data determine.

Statistics are run on a friction law of one line in place of the contact solver; one recovery uses the solver itself.
"""

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from calibration_stub import OneLineSolver, measured, setup_with
from scipy.stats import binom

import regression.calibration.calibrate as calibrate_module
from ehl.fluid.oil import Oil
from ehl.inputs import ContactProblem
from ehl.result import ContactResult
from ehl.solve import solve_contact
from regression.calibration import prediction
from regression.calibration.calibrate import Calibration, ParameterEstimate, all_values, calibrate, solver_of
from regression.calibration.measurement import SYNTHETIC, Measurement, read_measurement
from regression.calibration.setup import CalibrationSetup

SIGMA = 8e-4
TRUTH = {"eyring_stress": 4e6, "boundary_friction": 0.12, "boundary_film": 30e-9}


def setup_of(parameters: Sequence[str], **changes: object) -> CalibrationSetup:
    return setup_with(parameters, **{"specimens": {"geometry": "line"}, "noise": {"absolute": SIGMA}} | changes)


def planned(pressures: list[float], slides: list[float], speeds: list[float]) -> Measurement:
    """Traction curves at each pressure, and one Stribeck curve."""
    rows = [(p, 2.0, s, f"traction {p:.2g}") for p in pressures for s in slides]
    pressure, speed, slide, curves = zip(*rows, *((1e9, u, 0.5, "stribeck") for u in speeds), strict=True)
    varied = {"pressure_hertz": pressure, "speed_entrainment": speed, "slide_to_roll": slide}
    fixed = {"radius_equivalent": 0.01, "temperature_oil": 353.15, "roughness_rms": 1e-7}
    return measured("pressure_hertz", curves=curves, **varied, **fixed)


ROWS = planned([0.7e9, 1.1e9], [0.005, 0.01, 0.05, 0.3], [0.03, 0.06, 0.12, 0.25, 0.5, 1.0])


@pytest.fixture(autouse=True)
def _one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def stub(measurement: Measurement, setup: CalibrationSetup, jobs: int) -> OneLineSolver:
        plain = solver_of(measurement, setup, jobs)
        return OneLineSolver(plain.setup, plain.groups, plain.roughness, plain.temperature)

    monkeypatch.setattr(calibrate_module, "solver_of", stub)


def made(rows: Measurement, setup: CalibrationSetup, truth: dict[str, float], noise: np.ndarray) -> Measurement:
    solver = calibrate_module.solver_of(rows, setup, 1)
    values = all_values(rows, setup) | truth
    return replace(rows, friction=solver.friction(solver.transformed(solver.parts([values])[0]), values) + noise)


def estimates(result: Calibration) -> dict[str, ParameterEstimate]:
    return {estimate.name: estimate for estimate in result.parameters}


def test_intervals_cover_the_truth_as_often_as_they_say() -> None:
    setup = setup_of(list(TRUTH))
    clean = made(ROWS, setup, TRUTH, np.zeros(ROWS.size))
    runs, covered, scores = 7, dict.fromkeys(TRUTH, 0), []
    for seed in range(runs):
        noise = SIGMA * np.random.default_rng(seed).standard_normal(ROWS.size)
        found = estimates(calibrate(replace(clean, friction=clean.friction + noise), setup))
        for name, truth in TRUTH.items():
            assert found[name].status == "determined"
            covered[name] += found[name].interval_low <= truth <= found[name].interval_high
            scores.append(math.log(found[name].value / truth) / found[name].standard_error)
    # a right 95 % interval covers fewer than this once in a thousand
    least = int(binom.ppf(1e-3, runs, 0.95))
    assert min(covered.values()) >= least
    assert np.std(scores) == pytest.approx(1.0, abs=0.25)


def test_outliers_are_listed_and_hardly_move_the_values() -> None:
    setup = setup_of(list(TRUTH))
    noise = SIGMA * np.random.default_rng(5).standard_normal(ROWS.size)
    clean = estimates(calibrate(made(ROWS, setup, TRUTH, noise), setup))
    noise[[3, 10]] += 15.0 * SIGMA
    spoiled = calibrate(made(ROWS, setup, TRUTH, noise), setup)
    assert set(spoiled.outliers) == {5, 12}  # the first row stands below a header
    for name, estimate in estimates(spoiled).items():
        # 15 standard deviations weigh like 1.5
        assert abs(math.log(estimate.value / clean[name].value)) < 2.5 * clean[name].standard_error


def test_what_the_rows_do_not_tell_is_not_returned_as_a_number() -> None:
    # a limit of 0.12 p is never reached here
    setup = setup_of(["eyring_stress", "limiting_shear_coefficient"])
    noise = SIGMA * np.random.default_rng(6).standard_normal(ROWS.size)
    result = calibrate(made(ROWS, setup, {"limiting_shear_coefficient": 0.12}, noise), setup)
    limit = estimates(result)["limiting_shear_coefficient"]
    assert limit.status == "undetermined"
    assert math.isnan(limit.value)
    assert result.fitted == ("eyring_stress",)
    assert result.notes


def test_two_parameters_known_only_together_are_told_so() -> None:
    # in the linear part of the shear law, viscosity under pressure and tau0 at one pressure: tau0 drops out
    rows = planned([0.6e9], [0.0005, 0.0007, 0.001, 0.0015, 0.002], [])
    setup = setup_of(["eyring_stress", "pressure_viscosity"], noise={"relative": 0.02})
    clean = made(rows, setup, {}, np.zeros(rows.size))
    noisy = replace(clean, friction=clean.friction * (1 + 0.02 * np.random.default_rng(7).standard_normal(rows.size)))
    found = estimates(calibrate(noisy, setup))
    assert found["pressure_viscosity"].status == "determined"
    assert found["eyring_stress"].status == "undetermined"


def test_where_nothing_is_identifiable_the_card_has_a_wide_interval() -> None:
    rows = planned([0.6e9], [0.0005, 0.001, 0.002], [])
    setup = setup_of(["limiting_shear_coefficient"])
    found = calibrate(made(rows, setup, {"limiting_shear_coefficient": 0.2}, np.zeros(rows.size)), setup)
    (limit,) = found.parameters
    assert limit.status == "weak"
    assert limit.interval_high > 3.0 * limit.interval_low
    record = found.card("wide").calibration
    assert record.fitted["limiting_shear_coefficient"].interval_high == limit.interval_high


def test_wide_intervals_and_nothing_determined_beyond_a_credible_misfit(tmp_path: Path) -> None:
    setup = setup_of(list(TRUTH))
    noise = SIGMA * np.random.default_rng(8).standard_normal(ROWS.size)
    sound = calibrate(made(ROWS, setup, TRUTH, noise), setup)
    assert sound.misfit_credible
    poor = calibrate(made(ROWS, setup, TRUTH, 4.0 * noise), setup)
    assert not poor.misfit_credible
    assert (poor.noise, poor.noise_stated) == (pytest.approx(4.0 * SIGMA, rel=0.5), pytest.approx(SIGMA))
    assert len(poor.notes) > len(sound.notes)
    assert all(estimate.status != "determined" for estimate in poor.parameters)
    # four times the noise, which no longer averages out
    narrow, wide = estimates(sound), estimates(poor)
    for name in set(sound.fitted) & set(poor.fitted):
        ratio = wide[name].standard_error / narrow[name].standard_error
        assert ratio > 0.5 * 4.0 * math.sqrt(ROWS.size)
    poor.save_card(tmp_path / "poor.toml")
    card = Oil.load(str(tmp_path / "poor.toml"))
    initial = Oil.load(setup.oil)
    for name in set(poor.fitted) & {"eyring_stress"}:
        sd = math.log(wide[name].interval_high / wide[name].interval_low) / 3.92
        assert card.uncertainty.eyring_stress == pytest.approx(max(sd, initial.uncertainty.eyring_stress), rel=1e-3)
    hopeless = replace(poor, misfit=calibrate_module.NO_MODEL * poor.misfit / poor.misfit_share * 1.01)
    with pytest.raises(calibrate_module.MisfitTooLarge) as caught:
        hopeless.save_card(tmp_path / "hopeless.toml")
    assert caught.value.exit_code == 1
    assert not (tmp_path / "hopeless.toml").exists()
    hopeless.save_card(tmp_path / "hopeless.toml", force=True)


def test_without_a_stated_noise_the_misfit_is_judged_by_the_friction() -> None:
    setup = setup_of(list(TRUTH), noise={})
    clean = made(ROWS, setup, TRUTH, np.zeros(ROWS.size))
    draw = np.random.default_rng(8).standard_normal(ROWS.size)
    for share, credible in ((0.3 * calibrate_module.MAX_MISFIT, True), (3.0 * calibrate_module.MAX_MISFIT, False)):
        found = calibrate(replace(clean, friction=clean.friction * (1.0 + share * draw)), setup)
        assert found.misfit_credible is credible
    assert math.isnan(found.noise_stated)


def test_the_elastic_part_of_the_shear_is_in_what_is_fitted() -> None:
    """Left out, mu of a small slip is too high, and no Eyring stress makes up for it."""
    setup = setup_of(["eyring_stress"])
    rows = planned([2e9], [0.0005, 0.1], [])
    rows.columns["roughness_rms"] = np.zeros(2)
    solver = solver_of(rows, setup, 1)
    film_friction = solver.parts([all_values(rows, setup)])[0, :, 0]
    bodies, bulk = (setup.solid_1.body(), setup.solid_2.body()), (353.15, 353.15)
    lubricant = replace(Oil.load("fva3").at(353.15), shear_modulus=math.inf)
    (group,) = solver.groups
    rigid = [
        solve_contact(ContactProblem(contact, lubricant, group.surface, setup.model, bodies, bulk)).friction_fluid
        for contact in group.contacts
    ]
    assert film_friction[0] < 0.9 * rigid[0]
    assert film_friction[1] == pytest.approx(rigid[1], rel=0.02)


def test_a_limit_far_off_on_the_card_is_found() -> None:
    """The card's limit does not act on these rows, or hides the rest: neither start has a slope to follow."""
    for truth in (0.04, 0.06):
        setup = setup_of(["eyring_stress", "limiting_shear_coefficient"])
        rows = planned([0.6e9, 1.5e9], [0.002, 0.01, 0.05, 0.2, 0.4], [])
        values = {"eyring_stress": 12e6, "limiting_shear_coefficient": truth}
        noise = 0.2 * SIGMA * np.random.default_rng(9).standard_normal(rows.size)
        found = estimates(calibrate(made(rows, setup, values, noise), setup))
        for name in values:
            assert found[name].status == "determined"
            assert found[name].value == pytest.approx(values[name], rel=0.1)


def test_resolved_roughness_is_averaged_over_one_travel(monkeypatch: pytest.MonkeyPatch) -> None:
    """A travel that ends by the interval of mu would jump with the parameters, and mu with it by some per cent."""
    setup = setup_of(["boundary_film"])
    rows = planned([], [], [0.4])
    rows.columns.update(pressure_hertz=np.array([0.5e9]), radius_equivalent=np.array([0.005]))
    travels: list[float] = []

    def watched(*arguments: Any, **options: Any) -> ContactResult:
        result = solve_contact(*arguments, **options)
        travels.append(result.transient.travel)
        return result

    monkeypatch.setattr(prediction, "solve_contact", watched)
    solver = solver_of(rows, setup, 1)
    values = all_values(rows, setup)
    sets = [values, {**values, "boundary_film": 30e-9}]
    solver.parts(sets)
    solver.parts([{**values, "boundary_film": 35e-9}])
    # the second set, and the third, which is the first of its call; a step is a few thousandths of a window
    assert travels == pytest.approx([solver.windows[0]] * 2, rel=0.01)
    shares = [solver.parts([{**values, "boundary_film": film}])[0, 0, 1] for film in (20e-9, 30e-9, 35e-9)]
    assert shares == sorted(shares)
    assert solver.calls == 3


SETUP = """
oil = "fva3"
parameters = ["eyring_stress", "limiting_shear_coefficient"]
[conditions]
radius_equivalent = "10 mm"
temperature_oil = "80 degC"
pressure_hertz = "1 GPa"
[specimens]
geometry = "point"
[noise]
absolute = 0.0005
[model]
accuracy = "fast"
thermal = "off"
"""
TEXT = "speed_entrainment [m/s],slide_to_roll [%],friction_coefficient\n"
TEXT += "2,0.5,{}\n2,2,{}\n2,10,{}\n1,20,{}\n0.2,20,{}\n0.08,20,{}\n"


def test_the_solver_gives_back_what_was_put_in(mixed_ehl: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From synthetic friction to values, figure and card, on the command line."""
    monkeypatch.setattr(calibrate_module, "solver_of", solver_of)
    monkeypatch.chdir(tmp_path)
    Path("setup.toml").write_text(SETUP, encoding="utf-8")
    Path("conditions.csv").write_text(TEXT.format(*[0.05] * 6), encoding="utf-8")
    truth, setup = {"eyring_stress": 8e6, "limiting_shear_coefficient": 0.04}, calibrate_module.setup_of("setup.toml")
    rows = read_measurement(Path("conditions.csv"), setup.conditions.model_dump(exclude_none=True))
    friction = made(rows, setup, truth, 5e-4 * np.random.default_rng(3).standard_normal(rows.size)).friction
    Path("made.csv").write_text(f"{SYNTHETIC}\n{TEXT.format(*friction)}", encoding="utf-8")
    files = ["-o", "mine.toml", "--plot", "curves.png", "--json", "--jobs", "1"]
    outcome = mixed_ehl("calibrate", "made.csv", "--setup", "setup.toml", *files)
    assert outcome.code == 0
    result = json.loads(outcome.out)
    assert result["solver_calls"] >= 6
    for estimate in result["parameters"]:
        assert estimate["status"] == "determined"
        # four standard errors: once in 16 000
        assert abs(math.log(estimate["value"] / truth[estimate["name"]])) < 4.0 * estimate["standard_error"]
    assert Path("curves.png").stat().st_size > 10_000
    card = Oil.load("mine.toml")
    assert card.calibration.file == "made.csv (synthetic)"
    assert card.eyring_stress == result["parameters"][0]["value"]
    assert card.calibration.fitted["limiting_shear_coefficient"].value == result["parameters"][1]["value"]
