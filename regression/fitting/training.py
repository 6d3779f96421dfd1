"""Training of the neural networks that correct a closed form: mu and both of its parts, weighted by the errors.

The loss of a case is linear above one standard deviation. Gradients are by backpropagation and the optimiser is L-BFGS.
Each network of the ensemble starts from different random weights.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ehl.common.errors import InputError
from ehl.common.threads import one_thread
from regression.friction.conditions import GROUPS, Array
from regression.friction.network import DIGITS, FILM_POWER, INPUTS, Network, parts_of_form, squashed

MEMBERS, UNITS_OF_A_LAYER = 5, 16
_STEPS = 500
_DIGITS = 6  # decimals of means and scales
# tuned on 75W90 and FVA3 for points that were not fitted and contacts along gear meshes
_DECAY = 5.0  # weight decay of a dataset, divided by its number of cases
_FORM_ERROR = 0.08  # standard deviation of ln mu that is added to the error of a case
_PARTS_WEIGHT = 0.5
MAX_ERROR = 0.25  # largest stated error of mu of a training case


@one_thread
def train(
    table: Mapping[str, Array],
    form: tuple[Array, Array],
    computed: tuple[Array, Array] | None,
    mu: Array,
    error: Array,
    boundary_friction: float | Array,
) -> Network:
    """Networks that correct a closed form to computed friction.

    table: columns of the cases, shape (n,).
    form (n,): asperity load share and film friction by the closed form.
    computed (n,): computed asperity load share and film friction, if the data have them.
    mu (n,): computed friction.
    error (n,): its stated relative error (90 %); cases above `MAX_ERROR` are excluded.
    boundary_friction: number or array of shape (n,).
    Raises `InputError`: no variable varies.
    """
    share, film = form
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
    plain = share * boundary_friction + film
    # relative to the closed form, so that profiles with high friction do not have a smaller error
    deviation = np.sqrt(_FORM_ERROR**2 + (error * mu / plain / 1.645) ** 2)
    known = error <= MAX_ERROR
    problem = _Problem(
        x[known],
        (share / np.maximum(1.0 - share, 1e-12))[known],
        seen["film_part"][known],
        np.broadcast_to(boundary_friction, mu.shape)[known],
        mu[known],
        deviation[known],
        None if computed is None else (computed[0][known], computed[1][known]),
    )
    members = tuple(problem.solved(np.random.default_rng(seed)) for seed in range(1, MEMBERS + 1))
    return Network(
        variables=names,
        mean=tuple(map(float, mean)),
        scale=tuple(map(float, scale)),
        low=tuple(map(float, np.round(x.min(axis=0), _DIGITS))),
        high=tuple(map(float, np.round(x.max(axis=0), _DIGITS))),
        members=members,
    )


class _Problem:
    """Loss of one network and its gradient by the weights."""

    def __init__(
        self,
        x: Array,
        odds: Array,
        part: Array,
        boundary_friction: Array,
        mu: Array,
        deviation: Array,
        computed: tuple[Array, Array] | None,
    ) -> None:
        self.x, self.part, self.boundary_friction = x, part, boundary_friction
        with np.errstate(divide="ignore"):
            self.logit = np.clip(np.log(odds), -30.0, 30.0)
        self.mu, self.deviation, self.computed = mu, deviation, computed
        n, d = UNITS_OF_A_LAYER, x.shape[1]
        self.shapes = ((n, d + 1), (n, n + 1), (2, n + 1))
        self.decay = _DECAY / len(mu)

    def layers(self, weights: Array) -> list[Array]:
        """Weights of each layer, biases last."""
        ends = np.cumsum([rows * columns for rows, columns in self.shapes])[:-1]
        return [part.reshape(shape) for part, shape in zip(np.split(weights, ends), self.shapes, strict=True)]

    def loss(self, weights: Array) -> tuple[float, Array]:
        """Mean loss with weight decay, and its gradient."""
        first, second, last = self.layers(weights)
        one = squashed(self.x @ first[:, :-1].T + first[:, -1])
        two = squashed(one @ second[:, :-1].T + second[:, -1])
        shift, stretch = (two @ last[:, :-1].T + last[:, -1]).T
        share = 1.0 / (1.0 + np.exp(-np.clip(self.logit + shift, -50.0, 50.0)))
        film = self.part * (1.0 - share) ** FILM_POWER * np.exp(np.clip(stretch, -20.0, 20.0))
        asperity = share * self.boundary_friction
        mu = asperity + film
        # derivatives by the logit and by the logarithm of the film part
        asperity_slope, film_slope = asperity * (1.0 - share), -FILM_POWER * share * film
        scale = self.mu * self.deviation
        total = (asperity_slope + film_slope) / mu / self.deviation
        terms = [(np.log(mu / self.mu) / self.deviation, total, film / mu / self.deviation)]
        if self.computed is not None:
            found, sheared = self.computed
            weight = _PARTS_WEIGHT / scale
            terms += [
                (weight * (asperity - found * self.boundary_friction), weight * asperity_slope, np.zeros_like(mu)),
                (weight * (film - sheared), weight * film_slope, weight * film),
            ]
        value, slopes = 0.0, np.zeros((len(mu), 2))
        for residual, by_shift, by_stretch in terms:
            root = np.sqrt(1.0 + residual**2)
            value += float(np.sum(root - 1.0))
            slopes[:, 0] += residual / root * by_shift
            slopes[:, 1] += residual / root * by_stretch
        slopes /= len(mu)
        inner = (slopes @ last[:, :-1]) * (1.0 - two**2) ** 1.5
        outer = (inner @ second[:, :-1]) * (1.0 - one**2) ** 1.5
        gradient = [
            np.column_stack([down.T @ up, down.sum(axis=0)])
            for down, up in ((outer, self.x), (inner, one), (slopes, two))
        ]
        flat = np.concatenate([part.ravel() for part in gradient])
        return value / len(mu) + 0.5 * self.decay * float(weights @ weights), flat + self.decay * weights

    def solved(self, random: np.random.Generator) -> tuple[tuple[int, ...], ...]:
        """Weights of one trained network by rows, in units of their last digit."""
        from scipy.optimize import minimize

        start = []
        for (rows, columns), size in zip(self.shapes, (1.0, 1.0, 0.1), strict=True):
            layer = random.standard_normal((rows, columns)) * size / np.sqrt(columns - 1)
            start.append(layer.ravel())
        found = minimize(
            self.loss, np.concatenate(start), jac=True, method="L-BFGS-B", options={"maxiter": _STEPS, "maxcor": 20}
        )
        rounded = np.rint(np.asarray(found.x) * 10.0**DIGITS).astype(int)
        return tuple(tuple(map(int, row)) for layer in self.layers(rounded) for row in layer)
