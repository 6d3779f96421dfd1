"""The Gaussian-process residual: scikit-learn is the second algorithm; limits by construction."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern

from ehl.common.data import data_path
from ehl.common.errors import InputError
from ehl.common.validation import validate
from regression.data.dataset import columns, load_dataset
from regression.fitting.coefficients import fit_form
from regression.fitting.rows import computed_friction, usable_rows
from regression.formula import Formula
from regression.friction.families import ROUGH_SHARE
from regression.friction.fitted import corrected_form
from regression.friction.gaussian_process import ASPERITY_ODDS, GpResidual, corrected_parts, fit_residual, matern
from regression.friction.gaussian_process import _unlikelihood as unlikelihood

NAMES = ("pressure_hertz", "speed_entrainment", "roughness_rms")


def table(count: int, seed: int = 1) -> dict[str, np.ndarray]:
    random = np.random.default_rng(seed)
    low, high = np.array([0.4e9, 1.0, 1e-7]), np.array([2e9, 20.0, 1e-6])
    values = np.exp(np.log(low) + random.uniform(size=(count, 3)) * np.log(high / low))
    return dict(zip(NAMES, values.T, strict=True))


def truth(t: dict[str, np.ndarray]) -> np.ndarray:
    return np.asarray(0.1 * np.sin(2.0 * np.log(t["speed_entrainment"])) * np.log(t["pressure_hertz"] / 1e9))


def test_with_all_cases_kept_it_is_the_process_of_scikit_learn() -> None:
    t = table(120)
    random = np.random.default_rng(2)
    noise = random.uniform(1e-4, 1e-3, 120)
    residual = truth(t) + np.sqrt(noise) * random.standard_normal(120)
    found = fit_residual(t, residual, noise, NAMES, count=120, variance_count=120)
    assert len(found.points) == 120
    kernel = ConstantKernel(found.variance, "fixed") * Matern(found.length_scales, "fixed", nu=2.5)
    # the stored points are the cases in another order, rounded
    lengths = np.array(found.length_scales)
    order = [int(np.argmin(np.sum((found.coordinates(t) / lengths - z) ** 2, axis=1))) for z in np.array(found.points)]
    assert sorted(order) == list(range(120))
    own = GpResidual(
        **{
            **found.model_dump(),
            "points": tuple(map(tuple, found.coordinates(t)[order] / lengths)),
            "weights": tuple(
                np.linalg.solve(
                    kernel(found.coordinates(t)[order]) + np.diag(noise[order] + found.noise), residual[order]
                )
            ),
        }
    )
    process = GaussianProcessRegressor(kernel, alpha=noise[order] + found.noise, optimizer=None)
    process.fit(found.coordinates(t)[order], residual[order])
    x = own.coordinates(table(200, seed=3))
    mean, deviation = process.predict(x, return_std=True)
    own_mean, own_deviation = own.predict(x)
    np.testing.assert_allclose(own_mean, mean, rtol=0.0, atol=1e-10)
    # the jitter of 1e-10 of the variance is what sets them apart
    np.testing.assert_allclose(own_deviation, deviation, rtol=0.0, atol=1e-7)
    # and the sparse weights are those of the full process where no case is left out
    np.testing.assert_allclose(found.predict(x)[0], mean, rtol=0.0, atol=1e-5)


def test_few_points_learn_from_all_cases() -> None:
    t, new = table(1500), table(400, seed=4)
    random = np.random.default_rng(5)
    noise = np.full(1500, 0.05**2)
    residual = truth(t) + 0.05 * random.standard_normal(1500)
    all_cases = fit_residual(t, residual, noise, NAMES, count=100)
    chosen = np.sort(random.permutation(1500)[:100])
    hundred = fit_residual({n: v[chosen] for n, v in t.items()}, residual[chosen], noise[chosen], NAMES, count=100)

    def error(process: GpResidual) -> float:
        return float(np.sqrt(np.mean((process.correction(new)[0] - truth(new)) ** 2)))

    assert error(all_cases) < 0.015  # a third of the noise
    assert error(all_cases) < 0.6 * error(hundred)


def test_deviation_grows_where_no_case_lies() -> None:
    t = table(300)
    kept = t["speed_entrainment"] < 8.0
    process = fit_residual({n: v[kept] for n, v in t.items()}, truth(t)[kept], np.zeros(kept.sum()), NAMES)
    deviation = process.predict(process.coordinates(t))[1]
    assert deviation[~kept].mean() > 3.0 * deviation[kept].mean()


def test_correction_fades_to_exactly_nothing_outside_the_data() -> None:
    t = table(300)
    process = fit_residual(t, truth(t), np.zeros(300), NAMES)
    point = {"pressure_hertz": 1.5e9, "speed_entrainment": 3.0, "roughness_rms": 3e-7}

    def at(**changes: float) -> float:
        values = {name: np.array([value]) for name, value in {**point, **changes}.items()}
        return float(process.correction(values)[0][0])

    assert abs(at()) > 0.01
    for far in (0.0, 1e-9, 1e-3, 1e3, 1e9, np.inf):
        assert at(speed_entrainment=far) == 0.0
    assert at(roughness_rms=0.0) == 0.0
    # continuous in value and slope at the edge of the data, and monotone on the way out
    edge = float(t["speed_entrainment"].max())
    walk = np.array([at(speed_entrainment=edge * f) for f in np.linspace(0.98, 2.2, 80)])
    assert np.abs(np.diff(walk)).max() < 0.2 * np.abs(walk).max()
    assert walk[-1] == 0.0


def test_a_variable_without_effect_or_variation_does_no_harm() -> None:
    t = table(200) | {"radius_equivalent": np.full(200, 0.01)}
    process = fit_residual(t, truth(t), np.zeros(200), (*NAMES, "radius_equivalent"))
    assert process.variables == NAMES
    assert process.length_scales[2] > 2.0 * max(process.length_scales[:2])
    with pytest.raises(InputError, match="vary"):
        fit_residual(t, truth(t), np.zeros(200), ("radius_equivalent",))


def test_damaged_numbers_are_refused() -> None:
    t = table(60)
    content = fit_residual(t, truth(t), np.zeros(60), NAMES, count=20, variance_count=10).model_dump(mode="json")
    assert validate(GpResidual, content).predict(np.zeros((1, 3)))[0].shape == (1,)
    for name, value, words in (
        ("weights", content["weights"][:-1], "weights"),
        ("mean", content["mean"][:-1], "one per variable"),
        ("points", [[0.0, 0.0]] * 20, "rows of 3 numbers"),
        ("alpha", [], "alpha"),
        ("variables", ["pressure", *content["variables"][1:]], "pressure_hertz"),
        ("variance", -1.0, "variance"),
    ):
        with pytest.raises(InputError, match=words):
            validate(GpResidual, content | {name: value})


@pytest.mark.parametrize("name", ["75w90_gp", "fva3_gp"])
def test_compiled_sums_are_those_of_the_covariances(name: str) -> None:
    """At gear contacts, against the libraries' distances and exponentials; far off, at stored points, at no number."""
    formula = Formula.load(data_path("formulas", f"{name}.json"))
    contacts = columns(load_dataset(f"gear_{name.removesuffix('_gp')}_paths").frame)
    odds = np.geomspace(1e-3, 1e3, len(contacts["pressure_hertz"]))
    for process in formula.processes:
        scales, z = np.array(process.length_scales), np.array(process.points)
        x = process.coordinates({**contacts, ASPERITY_ODDS: odds}) / scales
        x[:2], x[2], x[3] = z[[0, -1]], 1e3, np.nan
        covariance = matern(x, z, process.variance)
        found, reduction = process.sums(list(x.T))
        np.testing.assert_allclose(found, covariance @ np.array(process.weights), rtol=0.0, atol=1e-9)
        spread = covariance[:, : len(process.alpha)] @ process.root
        np.testing.assert_allclose(reduction, np.sum(spread**2, axis=1), rtol=0.0, atol=1e-9)
        assert np.isnan(found[3])
        assert abs(found[2]) < 1e-9
        np.testing.assert_array_equal(process.mean_alone(list(x.T))[0], found)
    np.testing.assert_array_equal(formula.coefficient(contacts), formula.evaluate(contacts).mu)


def test_likelihood_is_that_of_scikit_learn_and_its_gradient_that_of_differences() -> None:
    t, random = table(80), np.random.default_rng(6)
    x, noise = np.log(np.column_stack([t[name] for name in NAMES])), random.uniform(1e-3, 1e-2, 80)
    residual, logs = truth(t), np.log([2.0, 0.7, 1.5, 0.02, 3e-4])
    process = GaussianProcessRegressor(
        ConstantKernel(0.02, "fixed") * Matern([2.0, 0.7, 1.5], "fixed", nu=2.5), alpha=noise + 3e-4, optimizer=None
    ).fit(x, residual)
    value, gradient = unlikelihood(logs, x, residual, noise)
    assert value == pytest.approx(-process.log_marginal_likelihood_value_ - 40.0 * np.log(2.0 * np.pi), rel=1e-9)
    for i, step in enumerate(1e-5 * np.eye(5)):
        ahead, behind = (unlikelihood(logs + sign * step, x, residual, noise)[0] for sign in (1.0, -1.0))
        assert gradient[i] == pytest.approx((ahead - behind) / 2e-5, rel=1e-6, abs=1e-6)


def constant_process(value: float, name: str = "pressure_hertz") -> GpResidual:
    """A process of almost the same value everywhere near 1 GPa, of variance 0.01 less little."""
    return GpResidual(
        variables=(name,), mean=(np.log(1e9),), scale=(1.0,), low=(-1.0,), high=(1.0,), length_scales=(1e6,),
        variance=0.01, noise=1e-3, points=((0.0,),), weights=(value / 0.01,), alpha=(1.0,),
    )  # fmt: skip


@pytest.mark.parametrize(("shift", "stretch"), [(0.0, 0.0), (0.8, -0.2), (-2.0, 0.3), (8.0, 0.0), (-8.0, 0.0)])
def test_parts_are_moved_as_the_processes_say(shift: float, stretch: float) -> None:
    share = np.array([0.0, 1e-9, 0.02, 0.5, 0.97, 1.0])
    film = 0.03 * (1.0 - share) ** 1.5
    here = {"pressure_hertz": np.full(6, 1e9)}
    mu, variance = corrected_parts(share, film, (constant_process(shift), constant_process(stretch)), here, 0.1)
    moved = share * np.exp(shift) / (1.0 - share + share * np.exp(shift))
    sheared = 0.03 * np.exp(stretch) * (1.0 - moved) ** 1.5
    np.testing.assert_allclose(mu, 0.1 * moved + sheared, rtol=1e-8, atol=1e-15)
    # variance by the delta method: ends of one standard deviation of either process
    spread = np.sqrt(0.01 * (1.0 - 0.01 / 1.011) + 1e-3)
    ends = [
        corrected_parts(share, film, (constant_process(a), constant_process(b)), here, 0.1)[0]
        for a, b in ((shift + 1e-4, stretch), (shift - 1e-4, stretch), (shift, stretch + 1e-4), (shift, stretch - 1e-4))
    ]
    by_share, by_film = (np.log(ends[0] / ends[1]) / 2e-4, np.log(ends[2] / ends[3]) / 2e-4)
    np.testing.assert_allclose(np.sqrt(variance), spread * np.hypot(by_share, by_film), rtol=1e-3, atol=1e-6)


def test_processes_take_a_third_off_the_error_of_the_form_on_cases_held_out() -> None:
    frame, _ = usable_rows(load_dataset("gear_fva3", "gear_fva3_mesh"), corners=False)
    held = np.arange(len(frame)) % 4 == 0
    rest, new = frame[~held].reset_index(drop=True), frame[held].reset_index(drop=True)
    form = fit_form(ROUGH_SHARE, rest, gaussian_process=True)
    assert [ASPERITY_ODDS in process.variables for process in form.processes] == [True, True]
    mu, deviation = form.friction(new)
    plain, _ = corrected_form(ROUGH_SHARE, form.coefficients.values, (), columns(new), 0.085)
    error, before = (np.abs(np.log(found / computed_friction(new))) for found in (mu, plain))
    assert error.mean() < 0.67 * before.mean()
    assert deviation is not None
    # what they state is what they err by
    # half of them; where asperities carry all, mu is mu_b and both are nearly nothing
    assert 0.6 < np.median(error / deviation) / 0.6745 < 1.6
