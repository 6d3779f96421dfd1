"""Sensitivity of friction: first-order and total Sobol indices over the range of a formula.

Saltelli's scheme uses two independent samples A and B, and A with one column from B. First-order indices are after
Saltelli et al. (2010), total indices after Jansen (1999). `scipy.stats.sobol_indices` has the same estimators (a test
compares them). Its BCa bootstrap takes twenty times as long and gives no interval for an input without effect;
percentile intervals are used here.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ehl.common.errors import InputError
from ehl.fluid.oil import Oil
from ehl.material import Material, effective_modulus
from regression.friction.conditions import Array, conditions_of, state_across
from regression.friction.fitted import FittedFormula
from regression.plan.sampling import to_range

SIZE = 4096
_RESAMPLES = 200
_LEVEL = 0.9
# independent inputs; all other variables follow from these and the oil
INPUTS = (
    *("pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll_total"),
    *("temperature_oil", "roughness_rms", "correlation_length", "peklenik_number"),
)
_LINEAR = ("pressure_hertz", "temperature_oil")  # uniform; the logarithms of the others are uniform, as in plans


@dataclass(frozen=True)
class SobolIndices:
    """Shares of the variance of an output by each input."""

    names: tuple[str, ...]  # of the d inputs
    # without and with interactions; shape (d,)
    first: Array
    total: Array
    # 90 % intervals by bootstrap over the samples; shape (d, 2)
    first_interval: Array
    total_interval: Array
    evaluations: int  # of the output


def sobol_indices(
    output: Callable[[Array], Array], names: tuple[str, ...], size: int = SIZE, seed: int = 1
) -> SobolIndices:
    """Sobol indices of a function of d independent inputs, each uniform in 0 to 1.

    output: function from an array of shape (n, d) to an array of shape (n,).
    names: of the inputs.
    size: rows of each sample, a power of two; the function is evaluated size (d + 2) times.
    seed: of the scrambled Sobol sequence and the bootstrap.
    Raises `InputError`: the output does not vary.
    """
    from scipy.stats import qmc

    d = len(names)
    sample = qmc.Sobol(2 * d, scramble=True, rng=np.random.default_rng(seed)).random(size)
    a, b = sample[:, :d], sample[:, d:]
    f_a, f_b = output(a), output(b)
    mixed = np.empty((d, size))
    for i in range(d):
        ab = a.copy()
        ab[:, i] = b[:, i]
        mixed[i] = output(ab)
    if not np.var(np.concatenate([f_a, f_b])) > 0.0:
        raise InputError("output", "constant", "a quantity that varies with its inputs")
    first, total = _estimates(f_a, f_b, mixed)
    random = np.random.default_rng(seed)
    draws = []
    for _ in range(_RESAMPLES):
        rows = random.integers(0, size, size)
        draws.append(_estimates(f_a[rows], f_b[rows], mixed[:, rows]))
    ends = np.quantile(np.array(draws), [0.5 - _LEVEL / 2.0, 0.5 + _LEVEL / 2.0], axis=0)
    return SobolIndices(names, first, total, ends[:, 0].T, ends[:, 1].T, size * (d + 2))


def _estimates(f_a: Array, f_b: Array, mixed: Array) -> tuple[Array, Array]:
    variance = np.var(np.concatenate([f_a, f_b]))
    first = np.mean((f_b - f_b.mean()) * (mixed - f_a), axis=1) / variance
    total = 0.5 * np.mean((f_a - mixed) ** 2, axis=1) / variance
    return first, total


def formula_sensitivity(formula: FittedFormula, oil: Oil, size: int = SIZE) -> SobolIndices:
    """Sobol indices of ln mu of a fitted formula over the range of its data, for one oil.

    Pressure and temperature are uniform over their range, the others in their logarithm. Sliding is across the contact
    line, and both bodies are steel. Combinations that do not occur in gears are included.
    """
    names = tuple(n for n in INPUTS if n in formula.ranges and formula.ranges[n][0] < formula.ranges[n][1])
    steel = Material.load("steel")
    fixed = {n: formula.ranges[n][0] for n in INPUTS if n in formula.ranges and n not in names}
    fixed["effective_modulus"] = effective_modulus(steel, steel)

    def log_mu(unit: Array) -> Array:
        values = {
            name: to_range(column, *formula.ranges[name], "linear" if name in _LINEAR else "log")
            for name, column in zip(names, unit.T, strict=True)
        }
        values |= {name: np.full(len(unit), value) for name, value in fixed.items()}
        mu = formula.evaluate(conditions_of(state_across(values), oil)).mu
        if not np.isfinite(mu).all():
            raise InputError("formula", formula.name, "a formula with a value everywhere in its range")
        return np.log(mu)

    return sobol_indices(log_mu, names, size)
