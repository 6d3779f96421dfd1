"""Grouped cross-validation: whole (p, R) cells are held out together; the choice of the family too where asked for."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ehl.common.errors import ConvergenceError, InputError
from regression.data.dataset import Dataset, columns
from regression.fitting.coefficients import FittedForm, fit_form
from regression.fitting.rows import box_of, computed_friction, fitted_rows
from regression.friction.conditions import Array
from regression.friction.data_cloud import CloudDistance, data_cloud
from regression.friction.families import FAMILIES, Family
from regression.friction.fitted import FittedFormula

FOLDS = 10
_INNER_FOLDS = 5
# fits of this process with their held-out friction: reports show it, and formulas of several oils share one fit
_KEPT: dict[tuple[str, bool, bool, bytes], tuple[FittedForm, HeldOut]] = {}
_MAX_KEPT = 32
_CELLS = 4  # cells per axis of the (p, R) groups


@dataclass(frozen=True)
class HeldOut:
    """Friction of every row by a formula fitted without its fold.

    Parameters
    ----------
    mu : array, shape (n,)
    deviation : array, shape (n,), or None
        The formula's own standard deviation of ln mu, where it has one.
    folds : array of int, shape (n,)
    extrapolated : array of bool, shape (n,)
        Rows that lie outside the cloud of the cases of the other folds.
    """

    mu: Array
    deviation: Array | None
    folds: NDArray[np.int64]
    extrapolated: NDArray[np.bool_]

    def of(self, rows: NDArray[np.bool_]) -> HeldOut:
        """Some of the rows."""
        deviation = None if self.deviation is None else self.deviation[rows]
        return HeldOut(self.mu[rows], deviation, self.folds[rows], self.extrapolated[rows])


def cell_groups(frame: pd.DataFrame) -> NDArray[np.int64]:
    """Group of every row: its cell of a 4 x 4 grid in pressure and radius (logarithm) over their ranges."""
    groups = np.zeros(len(frame), dtype=np.int64)
    for values in (frame["pressure_hertz"].to_numpy(), np.log(frame["radius_equivalent"].to_numpy())):
        low, width = values.min(), np.ptp(values)
        cell = (values - low) / width * _CELLS if width > 1e-9 * abs(low) else np.zeros(len(values))
        groups = groups * _CELLS + np.minimum(cell.astype(np.int64), _CELLS - 1)
    return groups


def fold_numbers(frame: pd.DataFrame, count: int = FOLDS) -> NDArray[np.int64]:
    """Fold of every row: whole (p, R) cells are held out together; fewer than two cells fall back to rows in turn."""
    from sklearn.model_selection import GroupKFold

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
) -> HeldOut:
    """Friction of every row by a formula fitted without its fold, its networks too.

    Parameters
    ----------
    family : Family
    frame : DataFrame
        Usable rows.
    network, by_oil : bool
        As of `fit_form`.
    folds : array of int, shape (n,), optional
        Those of `fold_numbers` if not given.
    """
    folds = fold_numbers(frame) if folds is None else folds
    mu, deviation = np.empty(len(frame)), np.zeros(len(frame))
    extrapolated = np.zeros(len(frame), dtype=bool)
    form: FittedForm | None = None
    for number in np.unique(folds):
        held = folds == number
        rest = frame[~held].reset_index(drop=True)
        form = fit_form(family, rest, network=network, by_oil=by_oil, near=form)
        mu[held], spread = form.friction(frame[held])
        if spread is not None:
            deviation[held] = spread
        cloud = data_cloud(columns(rest), box_of(family, rest))
        if cloud is not None:
            extrapolated[held] = cloud.extrapolation(columns(frame[held])) >= CloudDistance.NEAR
    return HeldOut(mu, deviation if network else None, folds, extrapolated)


def fitted_and_held_out(
    family: Family, frame: pd.DataFrame, *, network: bool = False, by_oil: bool = False
) -> tuple[FittedForm, HeldOut]:
    """The fit to all rows and what `cross_validate` gives; at once where this process has done it before."""
    identity = (family.name, network, by_oil, _digest(frame))
    if identity not in _KEPT:
        found = (
            fit_form(family, frame, network=network, by_oil=by_oil),
            cross_validate(family, frame, network=network, by_oil=by_oil),
        )
        while len(_KEPT) >= _MAX_KEPT:
            del _KEPT[next(iter(_KEPT))]
        _KEPT[identity] = found
    return _KEPT[identity]


def _digest(frame: pd.DataFrame) -> bytes:
    """Tells rows apart: which cases they are, and what friction they have with which error."""
    digest = hashlib.sha256("\n".join(frame["key"]).encode())
    for name in ("friction_coefficient", "friction_error", "boundary_friction"):
        digest.update(np.ascontiguousarray(frame[name].to_numpy(dtype=float)).tobytes())
    return digest.digest()


def nested_cross_validate(families: Sequence[Family], frame: pd.DataFrame) -> tuple[Array, Mapping[str, int]]:
    """Held-out friction where the family too is chosen without the fold, by cross-validation among the other rows.

    Returns
    -------
    mu : array, shape (n,)
    chosen : mapping
        Family to the number of folds it was chosen in.

    Raises
    ------
    InputError, ConvergenceError
        No family can be fitted to the rows of some fold.
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
            raise InputError("run", "no family fits", "data that at least one family can be fitted to")
        best = min(errors, key=lambda name: errors[name])
        chosen[best] += 1
        mu[held] = fit_form(next(f for f in families if f.name == best), rest).friction(frame[held])[0]
    return mu, chosen


def held_out_friction(dataset: Dataset, formula: FittedFormula) -> HeldOut:
    """Friction of the rows of `fitted_rows` by the same form fitted without their fold.

    At once for a formula this process has fitted; else it is cross-validated again.
    """
    rows, by_oil = fitted_rows(dataset, formula), len(formula.oils) == 1 < len(dataset.oils)
    family, network = FAMILIES[formula.family], formula.network is not None
    return fitted_and_held_out(family, rows, network=network, by_oil=by_oil)[1]


def interval_factors(dataset: Dataset, formula: FittedFormula) -> list[tuple[float, float, float]]:
    """exp(w s) of the interval of a formula with networks, for each of its bands; none without.

    Returns
    -------
    list of (median, 5 %, 95 %)
        Over the held-out cases of the band: s is the deviation of the networks at each, w the multiple of the band.
    """
    if formula.network is None:
        return []
    spread = held_out_friction(dataset, formula).deviation
    deviation = np.hypot(0.0 if spread is None else spread, formula.network.noise)
    ratio = fitted_rows(dataset, formula)["film_ratio_formula"].to_numpy(dtype=float)
    factors = []
    for band in formula.interval.bands:
        inside = (ratio >= band.low) & (True if band.high is None else ratio < band.high)
        low, middle, high = np.quantile(np.exp(band.log_width * deviation[inside]), (0.05, 0.5, 0.95))
        factors.append((float(middle), float(low), float(high)))
    return factors
