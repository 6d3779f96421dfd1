"""One family fitted to rows: least squares on ln mu, linear or bounded nonlinear, and the networks on its parts.

design matrix or log_mu of the family -> coefficients -> standard errors, collinearity, terms that could not be fitted
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ehl.common.errors import ConvergenceError, InputError
from regression.data.dataset import columns
from regression.fitting.rows import boundary_friction_of, computed_friction
from regression.fitting.training import train
from regression.friction.conditions import Array
from regression.friction.families import Family
from regression.friction.fitted import friction_of_form
from regression.friction.network import Network

_OUTLIER = 0.05  # residual of ln mu from which the loss grows linearly
_FORM_ERROR = 0.05  # of ln mu, of a form in the mean
# weight of the parts of mu in the fit: without them a share too high is balanced by a film too low
_PARTS_WEIGHT = 0.25


@dataclass(frozen=True)
class Coefficients:
    """Fitted coefficients.

    Parameters
    ----------
    values, standard_errors : dict
        By term; a dropped term has neither spread nor effect of its own.
    dropped : dict
        Term to the reason it could not be fitted.
    variance_inflation : dict
        VIF of every fitted term but the constant: how much its variance grows by collinearity.
    condition_number : float
        Of the design matrix with columns of unit length.
    """

    values: dict[str, float]
    standard_errors: dict[str, float]
    dropped: dict[str, str]
    variance_inflation: dict[str, float]
    condition_number: float


def fit_coefficients(
    family: Family, frame: pd.DataFrame, boundary_friction: float, near: Mapping[str, float] | None = None
) -> Coefficients:
    """Coefficients of one family from the rows of a dataset.

    Rows weigh by what is left to chance in their band of lambda beside the error of a form. The stated error of a case
    is no such weight: it is relative to its own friction, so that profiles that happen to rub more would be preferred
    (on 75W90 the friction along gear meshes came out 20 % too high that way).
    Where the family gives both parts of mu and the rows have them, the fit meets asperity and film friction as well.
    A nonlinear fit starts from the coefficients `near`, of a fit to most of the same rows, where they are given.
    """
    table, target = columns(frame), np.log(computed_friction(frame))
    if family.design is not None:
        return linear_fit(family.terms, family.design(table), target)
    weight = np.ones(len(frame))
    if "realisations" in frame and frame["realisations"].max() > 1:
        weight = 1.0 / np.sqrt(1.0 + frame["noise_variance"].to_numpy(dtype=float) / _FORM_ERROR**2)
    return _nonlinear_fit(family, table, target, weight, boundary_friction, parts_of(family, frame), near)


def linear_fit(terms: tuple[str, ...], design: Array, target: Array) -> Coefficients:
    """Ordinary least squares by QR; the first column is the constant.

    A column that does not vary cannot be told from the constant: its term is dropped, with coefficient 0.
    """
    spread = np.ptp(design, axis=0)
    varies = spread > 1e-9 * np.maximum(np.abs(design).max(axis=0), 1e-30)
    kept = [0, *(int(i) for i in np.flatnonzero(varies) if i != 0)]
    dropped = {terms[i]: "does not vary in the data" for i in range(len(terms)) if i not in kept}
    columns_kept = design[:, kept]
    scale = np.linalg.norm(columns_kept, axis=0)
    scaled = columns_kept / scale
    condition = float(np.linalg.cond(scaled))
    if not condition < 1e12:
        # two columns are one and the same; say so rather than return noise
        raise InputError("run", "data of too few dimensions", "cases that vary every variable on its own")
    q, r = np.linalg.qr(scaled)
    beta = np.linalg.solve(r, q.T @ target)
    freedom = len(target) - len(kept)
    residual = target - scaled @ beta
    variance = float(residual @ residual) / freedom if freedom > 0 else math.nan
    inverse = np.linalg.inv(r)
    errors = np.sqrt(np.maximum(variance, 0.0) * np.sum(inverse**2, axis=1)) / scale
    values = dict.fromkeys(terms, 0.0) | {terms[i]: float(b) for i, b in zip(kept, beta / scale, strict=True)}
    return Coefficients(
        values,
        {terms[i]: float(e) for i, e in zip(kept, errors, strict=True)},
        dropped,
        _variance_inflation([terms[i] for i in kept[1:]], columns_kept[:, 1:]),
        condition,
    )


def _variance_inflation(terms: list[str], design: Array) -> dict[str, float]:
    if len(terms) < 2:
        return dict.fromkeys(terms, 1.0)
    inverse = np.linalg.inv(np.corrcoef(design, rowvar=False))
    return {term: float(value) for term, value in zip(terms, np.diag(inverse), strict=True)}


def parts_of(family: Family, frame: pd.DataFrame) -> tuple[Array, Array] | None:
    """Asperity load share and film friction of every row, where the family has these parts and all rows do."""
    names = ["asperity_load_share", "friction_fluid"]
    if family.parts is None or not set(names) <= set(frame.columns) or frame[names].isna().any(axis=None):
        return None
    share, film = (frame[name].to_numpy(dtype=float) for name in names)
    return share, film


def _nonlinear_fit(
    family: Family,
    table: Mapping[str, Array],
    target: Array,
    weight: Array,
    boundary_friction: float,
    computed: tuple[Array, Array] | None,
    near: Mapping[str, float] | None,
) -> Coefficients:
    """Bounded least squares with a loss that outliers do not dominate, started from physical values."""
    from scipy.optimize import least_squares

    terms = family.terms
    part = weight * _PARTS_WEIGHT / np.exp(target)

    def residual(x: Array) -> Array:
        k = dict(zip(terms, map(float, x), strict=True))
        if computed is None or family.parts is None:
            return np.asarray(weight * (family.log_mu(table, k, boundary_friction) - target))
        share, film = family.parts(table, k)
        asperity = (share - computed[0]) * boundary_friction
        mu = share * boundary_friction + film
        return np.concatenate((weight * (np.log(mu) - target), part * asperity, part * (film - computed[1])))

    lower, upper = np.array(family.lower), np.array(family.upper)
    if near is not None:
        start = np.array([near[term] for term in terms])
    else:
        start = np.array(family.start)
        # the level by the mean of the log residual: the linear part of the problem
        start[0] = np.clip(start[0] * np.exp(-np.median(residual(start)[: target.size])), lower[0], upper[0])
    solution = least_squares(
        residual,
        start,
        bounds=(lower, upper),
        loss="soft_l1",
        f_scale=_OUTLIER,
        x_scale=np.maximum(np.abs(start), 0.05),
        ftol=1e-8,
        xtol=1e-8,
        gtol=1e-8,
        max_nfev=1000,
    )
    if solution.status <= 0:
        raise ConvergenceError("fit", f"family {family.name} after {solution.nfev} evaluations")
    x, jacobian = solution.x, np.asarray(solution.jac)
    strength = np.linalg.norm(jacobian * np.maximum(np.abs(x), 0.05), axis=0)
    at_bound = (x <= lower + 1e-6 * (upper - lower)) | (x >= upper - 1e-6 * (upper - lower))
    free = np.flatnonzero((strength > 1e-8 * strength.max()) & ~at_bound)
    dropped = {
        terms[i]: "at its bound" if at_bound[i] else "has no effect in the data"
        for i in range(len(terms))
        if i not in free
    }
    scale = np.linalg.norm(jacobian[:, free], axis=0)
    scaled = jacobian[:, free] / scale
    rest = residual(x)
    variance = float(rest @ rest) / max(len(rest) - len(free), 1)
    covariance = np.linalg.pinv(scaled.T @ scaled)
    errors = np.sqrt(variance * np.diag(covariance)) / scale
    return Coefficients(
        {term: float(v) for term, v in zip(terms, x, strict=True)},
        {terms[i]: float(e) for i, e in zip(free, errors, strict=True)},
        dropped,
        {terms[i]: float(v) for i, v in zip(free, np.diag(covariance), strict=True)},
        float(np.linalg.cond(scaled)),
    )


@dataclass(frozen=True)
class FittedForm:
    """A family with the numbers found for it.

    Parameters
    ----------
    family : Family
    coefficients : Coefficients
        Of all rows.
    network : Network or None
    of_oil : mapping
        Coefficients of the rows of each oil, where the networks correct the form of each.
    """

    family: Family
    coefficients: Coefficients
    network: Network | None
    of_oil: Mapping[str, Coefficients] = field(default_factory=dict)

    def coefficients_of(self, oil: str | None) -> Coefficients:
        """Those of an oil; of all rows where it has none of its own."""
        return self.of_oil.get(oil or "", self.coefficients)

    def friction(self, frame: pd.DataFrame) -> tuple[Array, Array | None]:
        """mu of every row, and the networks' standard deviation of ln mu (None without)."""
        mu, deviation = np.empty(len(frame)), np.empty(len(frame))
        for oil, rows in _rows_of_oils(frame, self.of_oil):
            part = frame[rows]
            values, mu_b = self.coefficients_of(oil).values, boundary_friction_of(part)
            mu[rows], spread = friction_of_form(self.family, values, self.network, columns(part), mu_b)
            deviation[rows] = 0.0 if spread is None else spread
        return mu, None if self.network is None else deviation


def _rows_of_oils(frame: pd.DataFrame, oils: Collection[str]) -> list[tuple[str | None, NDArray[np.bool_]]]:
    """The rows of each of these oils, and of all others together."""
    if not oils:
        return [(None, np.ones(len(frame), dtype=bool))]
    names = frame["oil"].to_numpy()
    found: list[tuple[str | None, NDArray[np.bool_]]] = [(oil, names == oil) for oil in oils]
    found.append((None, ~np.isin(names, list(oils))))
    return [(oil, rows) for oil, rows in found if rows.any()]


def fit_form(
    family: Family, frame: pd.DataFrame, *, network: bool = False, by_oil: bool = False, near: FittedForm | None = None
) -> FittedForm:
    """Fit a family to the rows of a dataset, the coefficients first, then the networks on its parts.

    Parameters
    ----------
    family : Family
    frame : DataFrame
        Usable rows.
    network : bool
        Add the networks; only for a family with parts.
    by_oil : bool
        Coefficients of each oil, and networks that correct all of these forms.
    near : FittedForm, optional
        Of a fit to most of the same rows, where the fit begins.

    Raises
    ------
    InputError
        Several boundary frictions, and the family does not take it as an input; or too few dimensions.
    ConvergenceError
        The nonlinear fit did not settle.
    """
    mu_b = boundary_friction_of(frame)
    if family.design is not None and isinstance(mu_b, np.ndarray):
        values = sorted({float(value) for value in mu_b})
        hint = "Fit a family that takes it as an input, or one boundary friction at a time."
        raise InputError("boundary_friction", values, f"one value for all cases of family {family.name}", hint)

    def fitted(rows: pd.DataFrame, oil: str | None) -> Coefficients:
        start = None if near is None else near.coefficients_of(oil).values
        # the families compute with arrays of boundary friction as with one number
        return fit_coefficients(family, rows, cast("float", boundary_friction_of(rows)), start)

    form = FittedForm(family, fitted(frame, None), None)
    if by_oil:
        each = {str(oil): fitted(frame[frame["oil"] == oil], str(oil)) for oil in frame["oil"].unique()}
        form = replace(form, of_oil=each)
    if not network or family.parts is None:
        return form
    parts = np.empty((2, len(frame)))
    for oil, rows in _rows_of_oils(frame, form.of_oil):
        parts[:, rows] = family.parts(columns(frame[rows]), form.coefficients_of(oil).values)
    trained = train(
        columns(frame),
        (parts[0], parts[1]),
        parts_of(family, frame),
        computed_friction(frame),
        np.nan_to_num(frame["friction_error"].to_numpy(dtype=float)),
        mu_b,
    )
    return replace(form, network=trained)
