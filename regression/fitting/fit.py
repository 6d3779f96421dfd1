"""Fit of a formula to a dataset: coefficients by least squares in ln mu, errors over all cases and by region."""

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ehl.common.arrays import finite_or_none
from ehl.common.errors import ConvergenceError, InputError, MixedEhlError, same_name
from ehl.common.progress import report_progress
from ehl.common.quantities import rounded_towards
from ehl.common.threads import single_thread
from ehl.fluid.viscosity import TEMPERATURE_RANGE
from regression import __version__
from regression.data.dataset import Dataset, columns
from regression.fitting.coefficients import FittedForm, fit_form
from regression.fitting.cross_validation import (
    HeldOut,
    fitted_and_held_out,
    frictions,
    nested_cross_validate,
    networks_to_tune,
)
from regression.fitting.rows import (
    BANDS,
    NORMAL_90,
    band_noise,
    box_of,
    checkable_rows,
    computed_friction,
    drawn_rows,
    expected_rows,
    kept_rows,
    measured_noise,
    own_rows,
    realisation_scatter,
    rms,
    usable_rows,
)
from regression.friction.conditions import UNITS, Array
from regression.friction.data_cloud import CloudDistance, data_cloud
from regression.friction.error_tables import Band, ErrorInterval, NoiseFloor, Scores, WidthBand, WorstCase
from regression.friction.families import FAMILIES, Family, family_named
from regression.friction.fitted import FORMULA_SCHEMA, NETWORK, DataIdentity, FittedFormula
from regression.friction.oil_cards import OilIdentity

INTERVAL_LEVEL = 0.9
_MIN_IN_BAND = 20  # smallest number of held-out cases of a band with its own interval


def scores(frame: pd.DataFrame, predicted: Array, **shares: float) -> Scores:
    """Errors of predicted friction compared with computed friction over all rows; `shares` are further fields."""
    mu = computed_friction(frame)
    relative = predicted / mu - 1.0
    worst = int(np.argmax(np.abs(relative)))
    names = ("pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll_total", "temperature_oil")
    case = {name: float(frame[name].iloc[worst]) for name in (*names, "roughness_rms", "friction_coefficient")}
    return Scores(
        **_errors(mu, predicted),
        r2_log=_r2(np.log(mu), np.log(predicted)),
        worst=WorstCase(key=str(frame["key"].iloc[worst]), relative_error=float(relative[worst]), conditions=case),
        **shares,
    )


def _errors(mu: Array, predicted: Array) -> dict[str, Any]:
    """Fields of `Errors`."""
    relative = predicted / mu - 1.0
    size = np.abs(relative)
    return {
        "count": len(mu),
        "r2": _r2(mu, predicted),
        "rmse": rms(predicted - mu),
        "rmse_log": rms(np.log(predicted / mu)),
        "mape": float(np.mean(size)),
        "p95": float(np.quantile(size, 0.95)),
        "largest": float(size.max()),
        "bias": float(np.mean(relative)),
    }


def _r2(observed: Array, predicted: Array) -> float:
    total = float(np.sum((observed - observed.mean()) ** 2))
    return 1.0 - float(np.sum((observed - predicted) ** 2)) / total if total > 0.0 else 0.0


def bands(
    frame: pd.DataFrame, predicted: Array, covered: NDArray[np.bool_] | None = None, noise: NoiseFloor | None = None
) -> tuple[Band, ...]:
    """Errors by region (lambda, SR, pressure, temperature), without empty bands."""
    mu, result = computed_friction(frame), []
    for variable, edges in BANDS.items():
        values = frame[variable].to_numpy(dtype=float)
        finite = values[np.isfinite(values)]
        if not finite.size:
            continue
        limits = (float(finite.min()), *(e for e in edges if finite.min() < e < finite.max()), float(finite.max()))
        for low, high in itertools.pairwise(limits):
            inside = (values >= low) & ((values < high) | ((high == limits[-1]) & (values <= high)))
            if inside.any():
                errors = _errors(mu[inside], predicted[inside])
                share = None if covered is None else float(covered[inside].mean())
                lowest = band_noise(noise, variable, low)
                result.append(Band(**errors, variable=variable, low=low, high=high, coverage=share, noise=lowest))
    return tuple(result)


def interval_of(
    frame: pd.DataFrame,
    error: Array,
    folds: NDArray[np.int64] | None = None,
    *,
    deviation: Array | None = None,
    extrapolated: NDArray[np.bool_] | None = None,
    of_means: float = 1.0,
) -> ErrorInterval:
    """ErrorInterval from the held-out errors of ln mu by bands of lambda (Mondrian), on which the errors depend most.

    frame: the fitted rows.
    error (n,): held-out absolute error of ln mu.
    folds (n,): folds of the rows, for the coverage of every band with widths from the other folds.
    deviation (n,): held-out standard deviation of ln mu by the formula; widths are then multiples of it.
    extrapolated (n,): rows outside the range of the cases of the other folds, for the error of extrapolation.
    of_means: factor of the widths (`ratio_of_means`); coverage is that of the rows, without it.
    """
    ratio = frame["film_ratio_formula"].to_numpy(dtype=float)
    score = error if deviation is None else error / deviation
    widths = _band_widths(ratio, score)
    if folds is not None:
        covered = covered_by_other_folds(ratio, score, folds)
        widths = tuple(
            band.model_copy(update={"coverage": float(covered[band.holds(ratio)].mean())}) for band in widths
        )
    outer = error if extrapolated is None or extrapolated.sum() < _MIN_IN_BAND else error[extrapolated]
    return ErrorInterval(
        level=INTERVAL_LEVEL,
        log_width=of_means * conformal_width(score, INTERVAL_LEVEL),
        largest=float(error.max()),
        bands=tuple(band.model_copy(update={"log_width": of_means * band.log_width}) for band in widths),
        of_means=of_means,
        normalised=deviation is not None,
        near=conformal_width(outer, INTERVAL_LEVEL),
    )


def _band_widths(ratio: Array, error: Array) -> tuple[WidthBand, ...]:
    widths = []
    for low, high in itertools.pairwise((0.0, *BANDS["film_ratio"], math.inf)):
        inside = (ratio >= low) & (ratio < high if math.isfinite(high) else True)
        count = int(np.count_nonzero(inside))
        if count >= _MIN_IN_BAND:
            end = finite_or_none(high)
            width = conformal_width(error[inside], INTERVAL_LEVEL)
            widths.append(WidthBand(low=low, high=end, count=count, log_width=width))
    return tuple(widths)


def covered_by_other_folds(ratio: Array, error: Array, folds: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether each held-out error lies within the width of its band from the errors of the other folds."""
    covered = np.zeros(len(error), dtype=bool)
    for number in np.unique(folds):
        held = folds == number
        width = np.full(len(error), conformal_width(error[~held], INTERVAL_LEVEL))
        for band in _band_widths(ratio[~held], error[~held]):
            width[band.holds(ratio)] = band.log_width
        covered[held] = error[held] <= width[held]
    return covered


def conformal_width(error: Array, level: float) -> float:
    """The smallest width that covers ceil((n + 1) level) of n held-out errors (split conformal)."""
    rank = min(math.ceil((len(error) + 1) * level), len(error))
    return float(np.sort(error)[rank - 1])


def ratio_of_means(form: FittedForm, frame: pd.DataFrame, held_out: HeldOut, repeated: pd.DataFrame) -> float:
    """Width of the interval of the mean of mu over roughness profiles, over that of single profiles [-].

    The held-out error of a case contains the scatter of its own profile, that of a mean over several hardly any.

    frame: the fitted rows.
    repeated: points with several profiles, not fitted; fewer than 20 give 1.
    """
    means = expected_rows(repeated)
    if len(means) < _MIN_IN_BAND:
        return 1.0
    error = np.abs(np.log(held_out.mu / computed_friction(frame)))
    noise, deviation = _with_noise(error, held_out.deviation)
    mu, spread = form.friction(means)
    width = interval_of(frame, error, deviation=deviation).width(
        means["film_ratio_formula"].to_numpy(dtype=float), None if spread is None else np.hypot(spread, noise)
    )
    return conformal_width(np.abs(np.log(mu / computed_friction(means))) / width, INTERVAL_LEVEL)


def noise_floor(frame: pd.DataFrame) -> float:
    """RMS standard deviation of the relative numerical error of mu, mesh included [-]; 0 if unknown.

    The stated error of a case is the half width of a 90 % interval, 1.645 standard deviations of a normal variable.
    """
    deviation = frame["friction_error"].to_numpy(dtype=float) / NORMAL_90
    deviation = deviation[np.isfinite(deviation)]
    return rms(deviation) if deviation.size else 0.0


def fit_formula(
    dataset: Dataset,
    family_name: str = "xu",
    *,
    corners: bool = False,
    paths: Dataset | None = None,
    noise: Dataset | None = None,
    oil: str | None = None,
    jobs: int | None = None,
) -> FittedFormula:
    """Fit one family of formulas to a dataset; arguments as in `regression.fit`.

    The same data give bit-identical coefficients on one machine and build, as rows are sorted by key and one thread is
    used.
    """
    family, network = family_named("short" if family_name == NETWORK else family_name), family_name == NETWORK
    oil = None if oil is None else same_name(oil, dataset.oils)
    if oil is not None and oil not in dataset.oils:
        raise InputError("oil", oil, "one of the oils of the data: " + ", ".join(dataset.oils))
    frame, excluded = usable_rows(dataset, corners=corners)
    _require_enough(frame, family, oil, excluded)
    _require_known_oils(dataset, paths=paths, noise=noise)
    with single_thread():
        by_oil = oil is not None and len(dataset.oils) > 1
        workers = jobs if network and expected_seconds([NETWORK], len(frame)) > _WORTH_WORKERS else 1
        form, held_out = fitted_and_held_out(
            family, frame, dataset.plan_name, network=network, by_oil=by_oil, jobs=workers
        )
        other_oil = (
            None
            if oil is not None
            else _width_of_oils_left_out(family, frame, dataset.plan_name, network=network, jobs=workers)
        )
    of_means = 1.0
    if noise is not None:
        drawn, repeated = drawn_rows(frame), _never_fitted(dataset, noise.frame)
        if by_oil:  # those of the other oils, so that its own points remain a check
            drawn, repeated = drawn & ~own_rows(frame, oil), repeated[~own_rows(repeated, oil)]
        of_means = ratio_of_means(form, frame[drawn].reset_index(drop=True), held_out.of(drawn), repeated)
    # networks are trained on all rows and tuned to each oil; the following results are for the selected oil
    own = own_rows(frame, oil)
    frame, held_out = frame[own].reset_index(drop=True), held_out.of(own)
    within, _ = form.friction(frame)
    drawn = drawn_rows(frame)
    judged, held_out = frame[drawn].reset_index(drop=True), held_out.of(drawn)
    box = box_of(family, frame)
    hashes = dataset.card_hashes or dict.fromkeys(dataset.oils, dataset.oil_hash or None)
    fitted, network_of_oil = form.coefficients_of(oil), form.network_of(oil)
    floor = measured_noise(realisation_scatter((dataset if noise is None else noise).frame))
    error = np.abs(np.log(held_out.mu / computed_friction(judged)))
    noise_of_network, deviation = _with_noise(error, held_out.deviation)
    score = error if deviation is None else error / deviation
    covered = covered_by_other_folds(judged["film_ratio_formula"].to_numpy(dtype=float), score, held_out.folds)
    mu_b, ranges = frame["boundary_friction"], _ranges(frame, box, form)
    formula = FittedFormula(
        schema_version=FORMULA_SCHEMA,
        writer=f"mixed-ehl {__version__}",
        family=family.name,
        equation=family.equation,
        coefficients=fitted.values,
        standard_errors=fitted.standard_errors,
        dropped=fitted.dropped,
        variance_inflation=fitted.variance_inflation,
        condition_number=fitted.condition_number,
        # the most frequent value, the smaller of two equally frequent ones
        boundary_friction=float(mu_b.mode().min()),
        boundary_friction_range=(float(mu_b.min()), float(mu_b.max())),
        ranges=ranges,
        units={name: UNITS[name] for name in ranges},
        oils=tuple(OilIdentity(name=n, card_hash=hashes.get(n)) for n in dataset.oils if oil in (None, n)),
        fit=scores(frame, within),
        validation=scores(
            judged, held_out.mu, coverage=float(covered.mean()), extrapolated=float(held_out.extrapolated.mean())
        ),
        corners=None,
        folds=int(np.unique(held_out.folds).size),
        bands=bands(judged, held_out.mu, covered, floor),
        interval=interval_of(
            judged, error, held_out.folds, deviation=deviation, extrapolated=held_out.extrapolated, of_means=of_means
        ).model_copy(update={"other_oil": other_oil}),
        noise_floor=noise_floor(judged),
        noise=floor,
        data=DataIdentity(
            hash=dataset.data_hash,
            plan=dataset.plan_name,
            plan_hash=dataset.plan_hash,
            solver_version=dataset.solver_version,
            count=len(dataset.frame),
            used=len(own),
            excluded=excluded,
            tuned=None if form.source is None else form.source.name,
        ),
        cloud=data_cloud(columns(frame), box),
        network=None if network_of_oil is None else network_of_oil.model_copy(update={"noise": noise_of_network}),
    )
    return _checked(formula, dataset, corners=corners, paths=paths, noise=noise, oil=oil)


def _require_enough(frame: pd.DataFrame, family: Family, oil: str | None, excluded: Mapping[str, int]) -> None:
    """Raises `InputError`: fewer than two usable cases per term, of all oils or of the selected one."""
    own, least = int(own_rows(frame, oil).sum()), 2 * len(family.terms)
    if own < least:
        reasons = ", ".join(f"{count} {reason}" for reason, count in excluded.items()) or "none"
        needed = f"at least {least} usable cases for family {family.name}, by a larger sampling.size"
        raise InputError("run", f"{own} usable cases", needed, f"Excluded: {reasons}.")


def _require_known_oils(dataset: Dataset, **checks: Dataset | None) -> None:
    """Raises `InputError`: contacts for checks have an oil that the data lack."""
    for name, extra in checks.items():
        others = sorted(set(extra.oils) - set(dataset.oils)) if extra is not None else []
        if others:
            hint = f"Repeat the sweep of {name} with that oil, or omit {name}."
            allowed = f"contacts with the oils of the data, {', '.join(dataset.oils)}"
            raise InputError(name, ", ".join(others), allowed, hint)


def _ranges(frame: pd.DataFrame, names: Iterable[str], form: FittedForm) -> dict[str, tuple[float, float]]:
    """Ranges of the fitted cases, with those of the networks that were tuned to them."""
    ranges = {name: _rounded_range(frame[name].to_numpy(dtype=float)) for name in names}
    if "temperature_oil" in ranges:  # no further than an oil has a viscosity
        low, high = ranges["temperature_oil"]
        ranges["temperature_oil"] = low, min(high, TEMPERATURE_RANGE[1])
    if form.source is not None:  # tuned networks describe these as well; `cloud` shows where the new contacts end
        for name, known in form.source.ranges.items():
            low, high = ranges.get(name, known)
            ranges[name] = min(low, known[0]), max(high, known[1])
    return ranges


def _checked(
    formula: FittedFormula,
    dataset: Dataset,
    *,
    corners: bool,
    paths: Dataset | None,
    noise: Dataset | None,
    oil: str | None,
) -> FittedFormula:
    """The formula with its errors at contacts that were not fitted: corners, along meshes, several profiles."""
    on_paths = kept_rows(dataset, "path")
    if paths is not None:
        on_paths = pd.concat([on_paths, checkable_rows(paths.frame)], ignore_index=True)
    unseen = on_paths[:0] if noise is None else _never_fitted(dataset, noise.frame)
    not_fitted = (kept_rows(dataset, "corner"), on_paths, unseen)
    at_corners, on_paths, unseen = (rows[own_rows(rows, oil)].reset_index(drop=True) for rows in not_fitted)
    (of_corners, _), (of_paths, _), (of_unseen, unseen_bands) = (
        checked_scores(formula, rows) for rows in (at_corners, expected_rows(on_paths), expected_rows(unseen))
    )
    return formula.model_copy(
        update={
            "corners": None if corners else of_corners,
            "paths": of_paths,
            "unseen": of_unseen,
            "unseen_bands": unseen_bands,
        }
    )


# processor time of a fit, of any closed form and of a network, with its folds [s, s per row]
CLOSED_FORM_SECONDS, NETWORK_SECONDS = (1.0, 0.001), (6.0, 0.1)
_WORTH_WORKERS = 30.0  # processor time of a fit from which on worker processes, 2 s each, save time [s]


def expected_seconds(names: Sequence[str], rows: int) -> float:
    """Expected processor time of the fits of some families to a number of rows [s]."""
    costs = [NETWORK_SECONDS if name == NETWORK else CLOSED_FORM_SECONDS for name in names]
    return sum(fixed + each * rows for fixed, each in costs)


def fit_families(
    dataset: Dataset,
    *,
    corners: bool = False,
    nested: bool = False,
    paths: Dataset | None = None,
    noise: Dataset | None = None,
    oil: str | None = None,
    jobs: int | None = None,
) -> tuple[FittedFormula, ...]:
    """All families fitted to the same rows, sorted by mean held-out error of mu.

    Families that cannot be fitted are omitted. With `nested` the errors of the best closed form include the choice of
    the family. Other arguments are as in `fit_formula`.

    Raises `InputError`, `ConvergenceError`: as in `fit_formula`, if no family can be fitted.
    """
    fitted: list[FittedFormula] = []
    refused: dict[str, MixedEhlError] = {}
    names = (*FAMILIES, NETWORK)
    for number, name in enumerate(names):
        report_progress("formulas", number, len(names), expected_seconds(names[number:], len(dataset.frame)))
        try:
            fitted.append(fit_formula(dataset, name, corners=corners, paths=paths, noise=noise, oil=oil, jobs=jobs))
        except (InputError, ConvergenceError) as error:
            refused[name] = error
    if not fitted:
        # the error of the family with the fewest terms describes the missing data best
        raise refused[min(refused, key=lambda name: len(FAMILIES[name].terms) if name in FAMILIES else 99)]
    ordered = sorted(fitted, key=lambda formula: formula.validation.mape)
    if nested:
        frame, _ = usable_rows(dataset, corners=corners)
        with single_thread():
            closed = [formula for formula in ordered if formula.network is None]
            mu, _ = nested_cross_validate([formula.form for formula in closed], frame)
        place = ordered.index(closed[0])
        ordered[place] = closed[0].model_copy(update={"nested": scores(frame, mu)})
    return tuple(ordered)


def _width_of_oils_left_out(
    family: Family, frame: pd.DataFrame, plan: str, *, network: bool, jobs: int | None
) -> float | None:
    """Half width of ln mu that covers the cases of each oil with a fit without it; None for fewer than three oils."""
    oils = frame["oil"].unique() if "oil" in frame else ()
    if len(oils) < 3:
        return None
    tasks, near = [], networks_to_tune(family, frame, plan) if network else None
    for oil in oils:
        held = own_rows(frame, oil)
        rest = frame[~held].reset_index(drop=True)
        tasks.append((fit_form(family, rest, near=near), rest, frame[held]))
    found = zip(tasks, frictions(tasks, network=network, jobs=jobs), strict=True)
    error = [np.abs(np.log(mu / computed_friction(held))) for (_, _, held), (mu, _) in found]
    return conformal_width(np.concatenate(error), INTERVAL_LEVEL)


def _with_noise(error: Array, spread: Array | None) -> tuple[float, Array | None]:
    """Constant part of the deviation of ln mu from the held-out errors, and the deviation with it.

    Maximum likelihood for a double exponential distribution whose width is a multiple of the deviation.
    """
    if spread is None:
        return 0.0, None
    trials = np.geomspace(0.003, 0.3, 41)

    def unlikelihood(noise: float) -> float:
        deviation = np.hypot(spread, noise)
        return float(np.log(np.mean(error / deviation)) + np.mean(np.log(deviation)))

    noise = float(f"{min(trials, key=unlikelihood):.3g}")
    return noise, np.hypot(spread, noise)


def checked_scores(formula: FittedFormula, frame: pd.DataFrame) -> tuple[Scores | None, tuple[Band, ...]]:
    """Errors at cases that were not fitted, with the coverage of the interval and the share of extrapolated cases.

    Returns: errors of all cases, and by film ratio; none if there are no cases or the formula has no value at one.
    """
    if frame.empty:
        return None, ()
    value = formula.evaluate(columns(frame))
    if np.isnan(value.mu).any():
        return None, ()
    mu = computed_friction(frame)
    covered = (value.lower <= mu) & (mu <= value.upper)
    extrapolated = formula.extrapolation(columns(frame)) >= CloudDistance.NEAR
    by_film = tuple(band for band in bands(frame, value.mu, covered) if band.variable == "film_ratio")
    return scores(frame, value.mu, coverage=float(covered.mean()), extrapolated=float(extrapolated.mean())), by_film


def _never_fitted(dataset: Dataset, repeated: pd.DataFrame) -> pd.DataFrame:
    """Usable rows with other cases than those of a dataset."""
    return checkable_rows(repeated[~repeated["key"].isin(dataset.frame["key"])])


def _rounded_range(values: Array) -> tuple[float, float]:
    """Smallest and largest value, rounded outwards to three digits, as samples do not reach the ends of a plan."""
    low, high = float(values.min()), float(values.max())
    return min(rounded_towards(low, math.floor), low), max(rounded_towards(high, math.ceil), high)
