"""Neural networks that correct a closed form of friction.

The closed form gives the load share X of the asperities and the friction F of the film. Each network of the ensemble
corrects the logit of X and the logarithm of F/(1 - X)^1.5, which vary more smoothly than mu:

    y = W3 s(W2 s(W1 x + b1) + b2) + b3,    s(z) = z/sqrt(1 + z^2)

with the standardised logarithms x of dimensionless groups. The correction is the mean of the networks; their scatter is
a measure of its uncertainty (Lakshminarayanan, Pritzel & Blundell 2017). Outside the range of the data the correction
decreases to 0, so that the limits of the closed form are preserved. Weights are stored as integers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from ehl.common.errors import InputError, check_choice
from ehl.common.validation import InputModel
from regression.friction.conditions import GROUPS, UNITS, Array, Conditions
from regression.friction.error_tables import Finite, Positive

Real = TypeVar("Real", np.float64, np.float32)
# weight of the correction, mean of both outputs over the networks, their variances and covariance
Statistics = tuple[Array, Array, Array, Array, Array, Array]
Evaluate = Callable[[list[Array]], Sequence[Array]]
ODDS, FILM_PART = "asperity_odds", "film_part"  # of the closed form, inputs of the networks
INPUTS = ("film_ratio_formula", *(name for name in GROUPS), "slide_to_roll_total", "peklenik_number", ODDS, FILM_PART)
ODDS_LIMIT = 1e3  # limit of the odds, beyond which friction does not depend on the smaller share
FILM_POWER = 1.5  # of the load share of the film, that of the form `short`
DIGITS = 3  # decimals of a weight
FADE = 0.25  # width of the decrease to 0, over the range of a variable
_BLOCK = 256  # points of a block whose units fit into the cache


class Network(InputModel):
    """An ensemble of networks that corrects both parts of a closed form."""

    # names of `regression.friction.conditions.UNITS` or `GROUPS`, `ODDS` or `FILM_PART`; x = (ln |v| - mean)/scale
    variables: tuple[str, ...]
    mean: tuple[Finite, ...]
    scale: tuple[Positive, ...]
    # range of x over the cases; outside the correction decreases to 0 within a quarter of the range
    low: tuple[Finite, ...]
    high: tuple[Finite, ...]
    # rows of weights in units of 1e-3, one row per unit with its bias last: first layer, second layer, both outputs
    members: tuple[tuple[tuple[int, ...], ...], ...] = Field(min_length=1)
    noise: Finite = 0.0  # standard deviation of ln mu that is added to the scatter of the networks

    @model_validator(mode="after")
    def _consistent(self) -> Network:
        size = len(self.variables)
        for name in self.variables:
            check_choice("variables", name, (*UNITS, *GROUPS, ODDS, FILM_PART))
        for field in ("mean", "scale", "low", "high"):
            if len(getattr(self, field)) != size:
                raise InputError(field, f"{len(getattr(self, field))} numbers", f"{size}, one per variable")
        units = self.units
        widths = [size + 1] * units + [units + 1] * (units + 2)
        if any([len(row) for row in rows] != widths for rows in self.members):
            raise InputError("members", "rows of another length", f"{2 * units + 2} rows, {units} units per layer")
        return self

    @property
    def units(self) -> int:
        """Units of each hidden layer."""
        return len(self.members[0]) // 2 - 1

    @property
    def step(self) -> float:
        """Unit of the integer weights."""
        return 10.0**-DIGITS

    @cached_property
    def layers(self) -> tuple[Array, Array, Array]:
        """Weights of the three layers with the biases last, shapes (k, n, d + 1), (k, n, n + 1), (k, 2, n + 1)."""
        n = self.units
        parts = [[rows[:n], rows[n : 2 * n], rows[2 * n :]] for rows in self.members]
        first, second, last = (np.array(layer, dtype=float) * self.step for layer in zip(*parts, strict=True))
        return first, second, last

    def statistics(self, logarithms: list[Array]) -> Statistics:
        """Weight of the correction (1 within the data), mean outputs of the networks, their variances and covariance.

        logarithms: ln |v| of each variable, shape (n,).
        """
        first, second, last = self.layers
        count, units = len(self.members), self.units
        mean, scale, low, high = (np.array(getattr(self, name))[:, None] for name in ("mean", "scale", "low", "high"))
        reach = FADE * (high - low)
        flat = first.reshape(count * units, -1)
        out, fading = np.empty((count, 2, len(logarithms[0]))), np.empty(len(logarithms[0]))
        for start in range(0, fading.size, _BLOCK):
            block = slice(start, start + _BLOCK)
            x = (np.clip([part[block] for part in logarithms], -1e3, 1e3) - mean) / scale
            beyond = (np.maximum(low - x, x - high) / reach).max(axis=0)
            fading[block] = np.clip(1.0 - beyond, 0.0, 1.0)
            # the networks are not evaluated beyond the range of the correction
            one = squashed(flat[:, :-1] @ np.clip(x, low - reach, high + reach) + flat[:, -1:])
            two = squashed(np.matmul(second[:, :, :-1], one.reshape(count, units, -1)) + second[:, :, -1:])
            out[:, :, block] = np.matmul(last[:, :, :-1], two) + last[:, :, -1:]
        a, b = out[:, 0], out[:, 1]
        mean_a, mean_b = a.mean(axis=0), b.mean(axis=0)
        a, b = a - mean_a, b - mean_b
        part = fading * fading * (3.0 - 2.0 * fading)
        return part, mean_a, mean_b, (a * a).mean(axis=0), (a * b).mean(axis=0), (b * b).mean(axis=0)

    def inputs(self, share: Array, film: Array, conditions: Conditions) -> list[Array]:
        """ln |v| of each variable, shape (n,); arguments as in `corrected`."""
        seen, logarithms = parts_of_form(share, film), []
        for name, mean, scale, high in zip(self.variables, self.mean, self.scale, self.high, strict=True):
            value = seen[name] if name in seen else GROUPS[name](conditions) if name in GROUPS else conditions[name]
            if name == "film_ratio_formula":  # no further effect of roughness in thicker films
                value = np.minimum(value, np.exp(mean + scale * high))
            with np.errstate(divide="ignore"):
                logarithms.append(np.log(np.abs(value)))
        return logarithms

    def corrected(
        self,
        share: Array,
        film: Array,
        conditions: Conditions,
        boundary_friction: float | Array,
        evaluate: Evaluate | None = None,
        logarithms: list[Array] | None = None,
    ) -> tuple[Array, Array]:
        """mu of the corrected parts and standard deviation of ln mu, by ufuncs for `regression.export`.

        share, film (n,): asperity load share and film friction by the closed form.
        conditions: columns of shape (n,).
        boundary_friction: number or array of shape (n,).
        evaluate: replacement of `statistics`.
        logarithms: replacement of `inputs`.
        """
        odds = share / np.maximum(1.0 - share, 1e-12)
        logarithms = logarithms or self.inputs(share, film, conditions)
        found = (evaluate or self.statistics)(logarithms)
        fading, shift, stretch, share_variance, covariance, film_variance = found
        moved = odds * np.exp(fading * shift)
        asperities = moved / (1.0 + moved) * boundary_friction
        sheared = film * ((1.0 + odds) / (1.0 + moved)) ** FILM_POWER * np.exp(fading * stretch)
        mu = asperities + sheared
        # d ln mu/d logit, and d ln mu/d ln film
        by_share = (asperities - FILM_POWER * sheared * moved) / (1.0 + moved) / mu
        by_film = sheared / mu
        variance = by_share * (by_share * share_variance + 2.0 * by_film * covariance) + by_film**2 * film_variance
        return mu, np.sqrt(np.maximum(variance, 0.0) + self.noise**2)


def squashed(z: NDArray[Real]) -> NDArray[Real]:
    """s(z) = z/sqrt(1 + z^2), in place."""
    root = np.multiply(z, z)
    root += 1.0
    np.sqrt(root, out=root)
    return np.divide(z, root, out=z)


def parts_of_form(share: Array, film: Array) -> dict[str, Any]:
    """Inputs of the networks from the closed form."""
    odds = np.clip(share / np.maximum(1.0 - share, 1e-12), 1.0 / ODDS_LIMIT, ODDS_LIMIT)
    return {ODDS: odds, FILM_PART: film / np.maximum(1.0 - share, 1e-12) ** FILM_POWER}
