"""Fit of one family to rows: linear or bounded nonlinear least squares in ln mu, and networks for its parts.

Results are coefficients with standard errors, collinearity, and terms that could not be fitted.

Training of the neural networks that correct a closed form: mu and both of its parts, weighted by the errors.

The loss of a case is linear above one standard deviation. Gradients are by backpropagation and the optimiser is L-BFGS.
Each network of the ensemble starts from different random weights, or from trained ones to which it is held (tuning).
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar, cast

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ehl.common.errors import ConvergenceError, InputError
from ehl.common.threads import one_thread
from regression.data.dataset import columns
from regression.fitting.rows import NORMAL_90, boundary_friction_of, computed_friction
from regression.friction.conditions import GROUPS, Array
from regression.friction.families import Family
from regression.friction.fitted import FittedFormula, friction_of_form
from regression.friction.network import DIGITS, FILM_PART, FILM_POWER, INPUTS, Network, parts_of_form, squashed

Single = NDArray[np.float32]
Number = TypeVar("Number", bound=np.generic)

MEMBERS, UNITS_OF_A_LAYER = 3, 44
_STEPS = (500, 4000)  # as many as there are cases, within these limits
_BLOCK = 1024  # cases of a block whose units fit into the cache
_DIGITS = 6  # decimals of means and scales
# tuned on the shipped oils for points that were not fitted and contacts along gear meshes
_DECAY = 0.5  # weight decay of a dataset, divided by its number of cases
_SCATTER = 0.08  # standard deviation of ln mu that is added to the error of a case
_WEIGHT_OF_PARTS = 0.5
# tuned on each shipped oil with networks of the others and 32 to 1280 of its contacts (docs/friction_formula.md)
_HOLD = 300.0  # weight of the squared change of the weights of tuned networks, divided by the number of cases
_TUNING_STEPS = 200
MAX_ERROR = 0.25  # largest stated error of mu of a training case


@one_thread
def train(
    table: Mapping[str, Array],
    form: tuple[Array, Array],
    computed: tuple[Array, Array] | None,
    mu: Array,
    error: Array,
    boundary_friction: float | Array,
    trained: Network | None = None,
) -> Network:
    """Networks that correct a closed form to computed friction.

    table: columns of the cases, shape (n,).
    form (n,): asperity load share and film friction by the closed form.
    computed (n,): computed asperity load share and film friction, if the data have them.
    mu (n,): computed friction.
    error (n,): its stated relative error (90 %); cases above `MAX_ERROR` are excluded.
    boundary_friction: number or array of shape (n,).
    trained: networks of other cases, which are tuned to these.
    Raises `InputError`: no variable varies.
    """
    share, film = form
    if trained is None:
        network, x = _untrained(table, share, film)
    else:
        network = trained
        inputs = np.column_stack(network.inputs(share, film, table))
        x = (inputs - np.array(network.mean)) / np.array(network.scale)
    plain = share * boundary_friction + film
    # relative to the closed form, so that profiles with high friction do not have a smaller error
    deviation = np.sqrt(_SCATTER**2 + (error * mu / plain / NORMAL_90) ** 2)
    known = error <= MAX_ERROR
    with np.errstate(divide="ignore"):
        logit = np.clip(np.log(share / np.maximum(1.0 - share, 1e-12)), -30.0, 30.0)
    part, mu_b = parts_of_form(share, film)[FILM_PART], np.broadcast_to(boundary_friction, mu.shape)
    cases = (logit, part, mu_b, mu, deviation, *(computed or ()))
    problem = _Problem(x[known], [values[known] for values in cases], network.units)
    if trained is None:
        members = [problem.solved(problem.random(np.random.default_rng(seed))) for seed in range(1, MEMBERS + 1)]
    else:
        members = [problem.tuned(np.concatenate(rows) * network.step) for rows in network.members]
    return Network.model_validate({**network.model_dump(), "members": members})


def _untrained(table: Mapping[str, Array], share: Array, film: Array) -> tuple[Network, Array]:
    """A network without effect for the inputs that vary, and their standardised values, shape (n, d)."""
    seen = {name: GROUPS[name](table) if name in GROUPS else table[name] for name in INPUTS[:-2]}
    seen |= parts_of_form(share, film)
    with np.errstate(divide="ignore"):
        logs = {name: np.log(np.abs(values)) for name, values in seen.items()}
    names = tuple(name for name, values in logs.items() if np.isfinite(values).all() and np.ptp(values) > 1e-6)
    if not names:
        raise InputError("run", "data that do not vary", "cases that vary at least one variable")
    inputs = np.column_stack([logs[name] for name in names])
    mean, scale = np.round(inputs.mean(axis=0), _DIGITS), np.round(inputs.std(axis=0), _DIGITS)
    x = (inputs - mean) / scale
    widths = [len(names) + 1] * UNITS_OF_A_LAYER + [UNITS_OF_A_LAYER + 1] * (UNITS_OF_A_LAYER + 2)
    network = Network(
        variables=names,
        mean=tuple(map(float, mean)),
        scale=tuple(map(float, scale)),
        low=tuple(map(float, np.round(x.min(axis=0), _DIGITS))),
        high=tuple(map(float, np.round(x.max(axis=0), _DIGITS))),
        members=(tuple((0,) * width for width in widths),),
    )
    return network, x


class _Problem:
    """Loss of one network and its gradient by the weights.

    x (n, d): inputs of the cases.
    cases: logit of the asperity load share and film part of the closed form, boundary friction, computed friction, its
        deviation, and optionally the computed load share and film friction; each of shape (n,).
    units: of each hidden layer.
    """

    def __init__(self, x: Array, cases: Sequence[Array], units: int) -> None:
        # single precision is twice as fast, and its errors are far below those of the cases
        self.x, *self.cases = (values.astype(np.float32) for values in (x, *cases))
        n, d = units, x.shape[1]
        self.shapes = ((n, d + 1), (n, n + 1), (2, n + 1))
        self.decay, self.held = _DECAY / len(x), np.zeros(0)

    def layers(self, weights: NDArray[Number]) -> list[NDArray[Number]]:
        """Weights of each layer, biases last."""
        ends = np.cumsum([rows * columns for rows, columns in self.shapes])[:-1]
        return [part.reshape(shape) for part, shape in zip(np.split(weights, ends), self.shapes, strict=True)]

    def loss(self, weights: Array) -> tuple[float, Array]:
        """Mean loss with weight decay, and its gradient."""
        layers, value = self.layers(weights.astype(np.float32)), 0.0
        gradient = [np.zeros_like(layer) for layer in layers]
        for start in range(0, len(self.x), _BLOCK):
            value += self._add(slice(start, start + _BLOCK), layers, gradient)
        moved = weights - self.held if self.held.size else weights
        count, flat = len(self.x), np.concatenate([part.ravel() for part in gradient]).astype(float)
        return value / count + 0.5 * self.decay * float(moved @ moved), flat / count + self.decay * moved

    def _add(self, block: slice, layers: Sequence[Single], gradient: Sequence[Single]) -> float:
        """Loss of a block of cases; its gradient is added."""
        first, second, last = layers
        x, (logit, part, mu_b, found, deviation, *computed) = self.x[block], (values[block] for values in self.cases)
        one = squashed(x @ first[:, :-1].T + first[:, -1])
        two = squashed(one @ second[:, :-1].T + second[:, -1])
        shift, stretch = (two @ last[:, :-1].T + last[:, -1]).T
        share = 1.0 / (1.0 + np.exp(-np.clip(logit + shift, -50.0, 50.0)))
        film = part * (1.0 - share) ** np.float32(FILM_POWER) * np.exp(np.clip(stretch, -20.0, 20.0))
        asperity = share * mu_b
        mu = asperity + film
        # derivatives by the logit and by the logarithm of the film part
        asperity_slope, film_slope = asperity * (1.0 - share), -FILM_POWER * share * film
        total = (asperity_slope + film_slope) / mu / deviation
        terms = [(np.log(mu / found) / deviation, total, film / mu / deviation)]
        if computed:
            weight = _WEIGHT_OF_PARTS / (found * deviation)
            terms += [
                (weight * (asperity - computed[0] * mu_b), weight * asperity_slope, np.zeros_like(mu)),
                (weight * (film - computed[1]), weight * film_slope, weight * film),
            ]
        value, slopes = 0.0, np.zeros((len(mu), 2), dtype=np.float32)
        for residual, by_shift, by_stretch in terms:
            root = np.sqrt(1.0 + residual**2)
            value += float(np.sum(root - 1.0, dtype=float))
            slopes[:, 0] += residual / root * by_shift
            slopes[:, 1] += residual / root * by_stretch
        inner = (slopes @ last[:, :-1]) * _slope_of(two)
        outer = (inner @ second[:, :-1]) * _slope_of(one)
        slopes_of_layers = [np.asarray(part, dtype=np.float32) for part in (outer, inner, slopes)]
        for total_of_layer, down, up in zip(gradient, slopes_of_layers, (x, one, two), strict=True):
            total_of_layer[:, :-1] += down.T @ up
            total_of_layer[:, -1] += down.sum(axis=0)
        return value

    def random(self, random: np.random.Generator) -> Array:
        """Weights from which a network starts."""
        start = []
        for shape, size in zip(self.shapes, (1.0, 1.0, 0.1), strict=True):
            layer = random.standard_normal(shape) * size / np.sqrt(shape[1] - 1)
            start.append(layer.ravel())
        return np.concatenate(start)

    def tuned(self, start: Array) -> tuple[tuple[int, ...], ...]:
        """As `solved`, held to the weights of a trained network."""
        self.decay, self.held = _HOLD / len(self.x), start
        return self.solved(start, _TUNING_STEPS)

    def solved(self, start: Array, steps: int | None = None) -> tuple[tuple[int, ...], ...]:
        """Weights of one trained network by rows, in units of their last digit."""
        from scipy.optimize import minimize

        steps = int(np.clip(len(self.x), *_STEPS)) if steps is None else steps
        found = minimize(self.loss, start, jac=True, method="L-BFGS-B", options={"maxiter": steps, "maxcor": 20})
        rounded = np.rint(np.asarray(found.x) * 10.0**DIGITS).astype(int)
        return tuple(tuple(map(int, row)) for layer in self.layers(rounded) for row in layer)


def _slope_of(squashed: Single) -> Single:
    """ds/dz = (1 - s^2)^1.5 of the activation s(z)."""
    rest = 1.0 - squashed * squashed
    return np.asarray(rest * np.sqrt(rest))


_OUTLIER = 0.05  # residual of ln mu above which the loss is linear
_FORM_ERROR = 0.05  # mean error of ln mu of a closed form
# weight of the parts of mu in the fit; without them errors of share and film friction may compensate each other
_PARTS_WEIGHT = 0.25


@dataclass(frozen=True)
class Coefficients:
    """Fitted coefficients."""

    values: dict[str, float]  # by term
    standard_errors: dict[str, float]  # by term, without dropped ones
    dropped: dict[str, str]  # terms that could not be fitted, with reasons
    variance_inflation: dict[str, float]  # increase of the variance of each term by collinearity (VIF)
    condition_number: float  # of the design matrix with columns of unit length


def fit_coefficients(
    family: Family, frame: pd.DataFrame, boundary_friction: float, near: Mapping[str, float] | None = None
) -> Coefficients:
    """Coefficients of one family from the rows of a dataset.

    Weights follow from the statistical error in the band of lambda relative to the error of a closed form. The stated
    error of a case is not suitable: it is relative to its own friction, so that profiles with high asperity friction
    would be preferred (for 75W90 friction along gear meshes was then 20 % too high). If family and rows have both parts
    of mu, asperity and film friction are fitted as well. A nonlinear fit may start from the coefficients `near` of a
    fit to most of the same rows.
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

    The term of a column that does not vary is dropped with coefficient 0, as it cannot be separated from the constant.
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
        # linearly dependent columns have no meaningful coefficients
        raise InputError("run", "data of too few dimensions", "cases with independent variations of all variables")
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
    """Asperity load share and film friction of every row, or None if the family or a row has no such parts."""
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
    """Bounded least squares with a robust loss, started from physical values."""
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
        # the level follows from the median residual of ln mu, which is linear in its logarithm
        start[0] = np.clip(start[0] * np.exp(-np.median(residual(start)[: target.size])), lower[0], upper[0])
    solution = least_squares(
        residual, start, bounds=(lower, upper), loss="soft_l1", f_scale=_OUTLIER,
        x_scale=np.maximum(np.abs(start), 0.05), max_nfev=1000,
    )  # fmt: skip
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
    # the residuals of mu and of its parts in one case are dependent: sandwich estimator with the cases as clusters
    cases, covariance = target.size, np.linalg.pinv(scaled.T @ scaled)
    # SciPy returns the Jacobian of soft_l1 times (1 + z)^-3/4, z = (r/C)^2; the score is r (1 + z)^-1/2 dr/dk
    left = residual(x)
    pull = left * (1.0 + (left / _OUTLIER) ** 2) ** 0.25
    score = (pull[:, None] * scaled).reshape(-1, cases, free.size).sum(axis=0) @ covariance
    errors = np.sqrt(cases / max(cases - free.size, 1) * np.sum(score**2, axis=0)) / scale
    return Coefficients(
        {term: float(v) for term, v in zip(terms, x, strict=True)},
        {terms[i]: float(e) for i, e in zip(free, errors, strict=True)},
        dropped,
        {terms[i]: float(v) for i, v in zip(free, np.diag(covariance), strict=True)},
        float(np.linalg.cond(scaled)),
    )


@dataclass(frozen=True)
class FittedForm:
    """A family with its coefficients and networks."""

    family: Family
    coefficients: Coefficients  # of all rows
    network: Network | None
    # coefficients of the rows of each oil, if the networks correct a form for each oil
    of_oil: Mapping[str, Coefficients] = field(default_factory=dict)
    networks: Mapping[str, Network] = field(default_factory=dict)  # `network` tuned to the rows of each of these oils
    source: FittedFormula | None = None  # formula of other oils with these coefficients, whose networks are tuned

    def coefficients_of(self, oil: str | None) -> Coefficients:
        """Coefficients of an oil; those of all rows if it has none."""
        return self.of_oil.get(oil or "", self.coefficients)

    def network_of(self, oil: str | None) -> Network | None:
        """Networks of an oil; those of all rows if it has none."""
        return self.networks.get(oil or "", self.network)

    def friction(self, frame: pd.DataFrame) -> tuple[Array, Array | None]:
        """mu of every row, and the standard deviation of ln mu by the networks (None without)."""
        mu, deviation = np.empty(len(frame)), np.empty(len(frame))
        for oil, rows in _rows_of_oils(frame, self.of_oil):
            part = frame[rows]
            values, mu_b = self.coefficients_of(oil).values, boundary_friction_of(part)
            mu[rows], spread = friction_of_form(self.family, values, self.network_of(oil), columns(part), mu_b)
            deviation[rows] = 0.0 if spread is None else spread
        return mu, None if self.network is None else deviation


def _rows_of_oils(frame: pd.DataFrame, oils: Collection[str]) -> list[tuple[str | None, NDArray[np.bool_]]]:
    """The rows of each of these oils, and of all others."""
    if not oils:
        return [(None, np.ones(len(frame), dtype=bool))]
    names = frame["oil"].to_numpy()
    found: list[tuple[str | None, NDArray[np.bool_]]] = [(oil, names == oil) for oil in oils]
    found.append((None, ~np.isin(names, list(oils))))
    return [(oil, rows) for oil, rows in found if rows.any()]


def fit_form(
    family: Family, frame: pd.DataFrame, *, network: bool = False, by_oil: bool = False, near: FittedForm | None = None
) -> FittedForm:
    """Fit the coefficients of a family to the rows of a dataset, then the networks for its parts.

    frame: usable rows.
    network: add the networks (`with_networks`).
    by_oil: coefficients of each oil, and networks that correct all of these forms, tuned to the rows of each.
    near: fit to most of the same rows as the start, or a form with networks of other oils (`source`) to be tuned.
    Raises `InputError`: several boundary frictions that are no input of the family, or too few dimensions;
    `ConvergenceError`: the nonlinear fit did not converge.
    """
    if near is not None and near.source is not None:
        return with_networks(near, frame) if network else near
    mu_b = boundary_friction_of(frame)
    if family.design is not None and isinstance(mu_b, np.ndarray):
        values = sorted({float(value) for value in mu_b})
        hint = "Fit a family with this input, or data of one boundary friction."
        raise InputError("boundary_friction", values, f"one value for all cases of family {family.name}", hint)

    def fitted(rows: pd.DataFrame, oil: str | None) -> Coefficients:
        start = None if near is None else near.coefficients_of(oil).values
        # families accept arrays of boundary friction
        return fit_coefficients(family, rows, cast("float", boundary_friction_of(rows)), start)

    form = FittedForm(family, fitted(frame, None), None)
    if by_oil:
        each = {str(oil): fitted(frame[frame["oil"] == oil], str(oil)) for oil in frame["oil"].unique()}
        form = replace(form, of_oil=each)
    return with_networks(form, frame) if network else form


def with_networks(form: FittedForm, frame: pd.DataFrame) -> FittedForm:
    """The form with networks that correct its parts, trained on the rows it was fitted to; unchanged without parts."""
    family = form.family
    if family.parts is None:
        return form
    parts, groups = np.empty((2, len(frame))), _rows_of_oils(frame, form.of_oil)
    for oil, rows in groups:
        parts[:, rows] = family.parts(columns(frame[rows]), form.coefficients_of(oil).values)

    def trained(rows: NDArray[np.bool_], start: Network | None) -> Network:
        part = frame[rows]
        error = np.nan_to_num(part["friction_error"].to_numpy(dtype=float))
        computed, mu_b = parts_of(family, part), boundary_friction_of(part)
        form_parts = parts[0, rows], parts[1, rows]
        return train(columns(part), form_parts, computed, computed_friction(part), error, mu_b, start)

    network = trained(np.ones(len(frame), dtype=bool), form.network)
    own = {oil: trained(rows, network) for oil, rows in groups if oil is not None}
    return replace(form, network=network, networks=own)
