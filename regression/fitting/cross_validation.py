"""Cross-validation grouped by cells of pressure and radius, optionally including the choice of the family."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ehl.common.errors import ConvergenceError, InputError
from ehl.common.runner import run_tasks
from regression.data.dataset import Dataset, columns
from regression.fitting.coefficients import Coefficients, FittedForm, fit_form, parts_of, with_networks
from regression.fitting.rows import box_of, computed_friction, fitted_rows, own_rows
from regression.friction.conditions import Array
from regression.friction.data_cloud import CloudDistance, data_cloud
from regression.friction.families import FAMILIES, Family
from regression.friction.fitted import FittedFormula

FOLDS, FOLDS_OF_MANY, MANY = 10, 5, 4000  # the second number from so many rows on
_INNER_FOLDS = 5
# cache of fits with their held-out friction, for reports and for formulas of several oils
_KEPT: dict[tuple[str, bool, bool, bytes], tuple[FittedForm, HeldOut]] = {}
_MAX_KEPT = 32
# networks of other oils that are tuned to few contacts: their formula, the number of contacts from which on a fit has
# networks of its own, and the mean error of ln mu up to which they are tuned
TUNED, OWN_NETWORKS, TUNABLE = "gear", MANY, 0.25
_CELLS = 4  # cells per axis of the (p, R) groups
# closed form, the rows it was fitted to, rows that were held out
HeldTask = tuple[FittedForm, pd.DataFrame, pd.DataFrame]


@dataclass(frozen=True)
class HeldOut:
    """Friction of every row by a formula fitted without its fold; arrays of shape (n,)."""

    mu: Array
    deviation: Array | None  # standard deviation of ln mu by the formula, if it has one
    folds: NDArray[np.int64]
    extrapolated: NDArray[np.bool_]  # rows outside the range of the cases of the other folds

    def of(self, rows: NDArray[np.bool_]) -> HeldOut:
        """Selected rows."""
        deviation = None if self.deviation is None else self.deviation[rows]
        return HeldOut(self.mu[rows], deviation, self.folds[rows], self.extrapolated[rows])


def cell_groups(frame: pd.DataFrame) -> NDArray[np.int64]:
    """Group of every row: its cell in a 4 x 4 grid of pressure and logarithm of the radius."""
    groups = np.zeros(len(frame), dtype=np.int64)
    for values in (frame["pressure_hertz"].to_numpy(), np.log(frame["radius_equivalent"].to_numpy())):
        low, width = values.min(), np.ptp(values)
        cell = (values - low) / width * _CELLS if width > 1e-9 * abs(low) else np.zeros(len(values))
        groups = groups * _CELLS + np.minimum(cell.astype(np.int64), _CELLS - 1)
    return groups


def fold_numbers(frame: pd.DataFrame, count: int | None = None) -> NDArray[np.int64]:
    """Fold of every row from whole cells of `cell_groups`; with fewer than two cells from alternating rows."""
    from sklearn.model_selection import GroupKFold

    count = count or (FOLDS if len(frame) < MANY else FOLDS_OF_MANY)
    groups = cell_groups(frame)
    count = min(count, np.unique(groups).size)
    if count < 2:
        return np.arange(len(frame)) % min(FOLDS, len(frame))
    folds = np.zeros(len(frame), dtype=np.int64)
    for number, (_, held) in enumerate(GroupKFold(count).split(groups, groups=groups)):
        folds[held] = number
    return folds


def cross_validate(
    family: Family,
    frame: pd.DataFrame,
    *,
    network: bool = False,
    by_oil: bool = False,
    folds: NDArray[np.int64] | None = None,
    near: FittedForm | None = None,
    jobs: int | None = 1,
) -> HeldOut:
    """Friction of every row by a formula, including networks, fitted without its fold.

    frame: usable rows.
    network, by_oil, near: as in `fit_form`.
    folds (n,): default: those of `fold_numbers`.
    jobs: worker processes that train the networks.
    """
    folds = fold_numbers(frame) if folds is None else folds
    mu, deviation = np.empty(len(frame)), np.zeros(len(frame))
    extrapolated = np.zeros(len(frame), dtype=bool)
    form = near
    tasks: list[HeldTask] = []
    for number in np.unique(folds):
        held = folds == number
        rest = frame[~held].reset_index(drop=True)
        form = fit_form(family, rest, by_oil=by_oil, near=form)
        tasks.append((form, rest, frame[held]))
        cloud = data_cloud(columns(rest), box_of(family, rest))
        if cloud is not None:
            extrapolated[held] = cloud.extrapolation(columns(frame[held])) >= CloudDistance.NEAR
    for number, (value, spread) in zip(np.unique(folds), frictions(tasks, network=network, jobs=jobs), strict=True):
        mu[folds == number] = value
        if spread is not None:
            deviation[folds == number] = spread
    return HeldOut(mu, deviation if network else None, folds, extrapolated)


def frictions(
    tasks: Sequence[HeldTask], *, network: bool, jobs: int | None = 1
) -> Iterator[tuple[Array, Array | None]]:
    """mu of held-out rows and the standard deviation of ln mu, by forms that get their networks first."""
    if not network:
        return (form.friction(held) for form, _, held in tasks)
    return run_tasks(tasks, lambda task: with_networks(*task[:2]).friction(task[2]), jobs=jobs)


def fitted_and_held_out(
    family: Family, frame: pd.DataFrame, plan: str, *, network: bool = False, by_oil: bool = False, jobs: int | None = 1
) -> tuple[FittedForm, HeldOut]:
    """The fit to all rows of a plan and the result of `cross_validate`, cached in the process."""
    identity = (family.name, network, by_oil, _digest(frame))
    if identity not in _KEPT:
        near = networks_to_tune(family, frame, plan) if network else None
        found = (
            fit_form(family, frame, network=network, by_oil=by_oil, near=near),
            cross_validate(family, frame, network=network, by_oil=by_oil, near=near, jobs=jobs),
        )
        while len(_KEPT) >= _MAX_KEPT:
            del _KEPT[next(iter(_KEPT))]
        _KEPT[identity] = found
    return _KEPT[identity]


def networks_to_tune(family: Family, frame: pd.DataFrame, plan: str) -> FittedForm | None:
    """The shipped networks of several oils, for other contacts; None if they do not describe these or contain them.

    None also for as many contacts as make networks of their own, and for contacts without both parts of mu.

    plan: name of the plan, or several joined by " + ".
    """
    if parts_of(family, frame) is None or len(frame) > OWN_NETWORKS:
        return None
    shipped = FittedFormula.load(TUNED)
    if shipped.network is None or shipped.family != family.name:
        return None
    same_oil = set(frame["oil"].unique()) & {identity.name for identity in shipped.oils}
    if same_oil and set(plan.split(" + ")) & set(shipped.data.plan.split(" + ")):
        return None
    known = shipped.coefficients, shipped.standard_errors, shipped.dropped, shipped.variance_inflation
    # their constant deviation is that of the errors of their own contacts
    network = shipped.network.model_copy(update={"noise": 0.0})
    form = FittedForm(family, Coefficients(*known, shipped.condition_number), network, source=shipped)
    error = np.abs(np.log(form.friction(frame)[0] / computed_friction(frame)))
    return form if float(error.mean()) < TUNABLE else None


def _digest(frame: pd.DataFrame) -> bytes:
    """Hash of the cases with their friction and error."""
    digest = hashlib.sha256("\n".join(frame["key"]).encode())
    for name in ("friction_coefficient", "friction_error", "boundary_friction"):
        digest.update(np.ascontiguousarray(frame[name].to_numpy(dtype=float)).tobytes())
    return digest.digest()


def nested_cross_validate(families: Sequence[Family], frame: pd.DataFrame) -> tuple[Array, Mapping[str, int]]:
    """Held-out friction with the family chosen by cross-validation of the other folds.

    Returns: mu, shape (n,); chosen: number of folds of each chosen family.
    Raises `InputError`, `ConvergenceError`: no family can be fitted to the rows of a fold.
    """
    folds = fold_numbers(frame)
    mu, chosen = np.empty(len(frame)), dict.fromkeys((family.name for family in families), 0)
    for number in np.unique(folds):
        held = folds == number
        rest = frame[~held].reset_index(drop=True)
        inner = fold_numbers(rest, _INNER_FOLDS)
        errors: dict[str, float] = {}
        for family in families:
            try:
                found = cross_validate(family, rest, folds=inner).mu
            except (InputError, ConvergenceError):
                continue
            errors[family.name] = float(np.mean(np.log(found / computed_friction(rest)) ** 2))
        if not errors:
            raise InputError("run", "no family fits", "data for a fit of at least one family")
        best = min(errors, key=lambda name: errors[name])
        chosen[best] += 1
        mu[held] = fit_form(next(f for f in families if f.name == best), rest).friction(frame[held])[0]
    return mu, chosen


def held_out_friction(dataset: Dataset, formula: FittedFormula) -> HeldOut:
    """Friction of the rows of `fitted_rows` by the same form fitted without their fold, cached in the process."""
    rows, by_oil = fitted_rows(dataset, formula), len(formula.oils) == 1 < len(dataset.oils)
    family, network = FAMILIES[formula.family], formula.network is not None
    return fitted_and_held_out(family, rows, dataset.plan_name, network=network, by_oil=by_oil)[1]


def interval_factors(dataset: Dataset, formula: FittedFormula) -> list[tuple[float, float, float]]:
    """Factors exp(w s) of the interval of a formula with networks, for each of its bands; empty without.

    Returns: median, 5 % and 95 % quantile over the held-out cases of the band, those of its oil for a formula of one of
    several oils, with the standard deviation s of the networks and the multiple w of the band.
    """
    if formula.network is None:
        return []
    spread, rows = held_out_friction(dataset, formula).deviation, fitted_rows(dataset, formula)
    deviation = np.hypot(0.0 if spread is None else spread, formula.network.noise)
    ratio, own = rows["film_ratio_formula"].to_numpy(dtype=float), np.ones(len(rows), dtype=bool)
    if len(formula.oils) == 1 < len(dataset.oils):
        own = own_rows(rows, formula.oils[0].name)
    factors = []
    for band in formula.interval.bands:
        low, middle, high = np.quantile(np.exp(band.log_width * deviation[own & band.holds(ratio)]), (0.05, 0.5, 0.95))
        factors.append((float(middle), float(low), float(high)))
    return factors
