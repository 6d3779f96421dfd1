"""Monotone maps from Gaussian heights to heights with a given skewness and kurtosis (Johnson's system)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from ehl.common.errors import InputError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Translation:
    """Increasing map from z of N(0, 1) to a height of mean 0 and variance 1.

    Johnson, N. L. (1949), Biometrika 36, 149-176: unbounded family ``sinh((z - a)/b)``, bounded family
    ``1/(1 + exp(-(z - a)/b))``.

    Parameters
    ----------
    family : {"unbounded", "bounded"}
    a, b : float
        Location and scale in the family; b > 0.
    mean, std, sign : float
        Standardisation, and -1 for a mirrored curve.
    """

    family: str
    a: float
    b: float
    mean: float
    std: float
    sign: float

    def __call__(self, z: FloatArray) -> FloatArray:
        raw = _shape(self.family, self.a, self.b, self.sign * z)
        return np.asarray(self.sign * (raw - self.mean) / self.std)


def _shape(family: str, a: float, b: float, z: FloatArray) -> FloatArray:
    t = (z - a) / b
    # clipped so that both families are finite at the lognormal line between them
    if family == "unbounded":
        return np.asarray(np.sinh(np.clip(t, -300.0, 300.0)))
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(t, -300.0, 300.0))))


NEARLY_GAUSSIAN = 0.07  # skewness below which the fit starts at the limit of a small one
# trapezoidal rule on the normal density: spectrally accurate, nodes to 9 sigma
_NODES = np.linspace(-9.0, 9.0, 721)
_WEIGHTS = np.exp(-0.5 * _NODES**2)
_WEIGHTS /= _WEIGHTS.sum()


def _moments(family: str, a: float, b: float) -> tuple[float, float, float, float]:
    y = _shape(family, a, b, _NODES)
    mean = float(_WEIGHTS @ y)
    centred = y - mean
    std = math.sqrt(float(_WEIGHTS @ centred**2))
    unit = centred / std
    return mean, std, float(_WEIGHTS @ unit**3), float(_WEIGHTS @ unit**4)


def lognormal_kurtosis(skewness: float) -> float:
    """Kurtosis of the lognormal distribution of that skewness, the border of Johnson's two families [-]."""
    half = scipy.optimize.brentq(lambda w: (w + 2.0) * math.sqrt(w - 1.0) - abs(skewness), 1.0, 1.0 + skewness**2)
    return float(half**4 + 2.0 * half**3 + 3.0 * half**2 - 3.0)


@lru_cache(maxsize=64)
def translation(skewness: float, kurtosis: float) -> Callable[[FloatArray], FloatArray]:
    """The Johnson curve with these moments.

    Raises
    ------
    InputError
        kurtosis <= skewness^2 + 1 (impossible), kurtosis above 60, or no curve was found (close to that limit or to the
        lognormal line).
    """
    if not kurtosis > skewness**2 + 1.0:
        raise InputError(
            "kurtosis", kurtosis, f"> skewness^2 + 1 = {skewness**2 + 1.0:g}", "No distribution has such moments."
        )
    if not kurtosis <= 60.0:
        raise InputError("kurtosis", kurtosis, "at most 60")
    sign = -1.0 if skewness < 0.0 else 1.0
    border = lognormal_kurtosis(skewness)
    family = "unbounded" if kurtosis > border else "bounded"

    def residual(q: FloatArray) -> FloatArray:
        _, _, third, fourth = _moments(family, float(q[0]), math.exp(float(q[1])))
        # kurtosis above its bound on a logarithmic scale, which resolves the region near the bound
        return np.array([third - sign * skewness, math.log((fourth - third**2 - 1.0) / (kurtosis - skewness**2 - 1.0))])

    starts = [(0.0, 0.3), (-1.0, 0.3), (1.0, 0.3), (2.0, 0.0), (-2.0, 0.7), (4.0, 1.0), (0.5, -0.5), (6.0, 0.5)]
    low, high = [-60.0, -3.0], [60.0, 4.0]
    size = abs(skewness)
    if family == "bounded" and 1e-4 < size < NEARLY_GAUSSIAN:  # location and scale grow as 1/skewness
        starts, low, high = [(3.23 / size, -math.log(0.5 * size))], [0.0, 0.0], [1e5, 12.0]
    for start in starts:
        fit = scipy.optimize.least_squares(residual, start, bounds=(low, high), xtol=1e-14, ftol=1e-14)
        if np.max(np.abs(fit.fun)) < 1e-7:
            a, b = float(fit.x[0]), math.exp(float(fit.x[1]))
            mean, std, _, _ = _moments(family, a, b)
            return Translation(family, a, b, mean, std, sign)
    allowed = f"moments of a Johnson curve; none was found near the lognormal kurtosis {border:.3g} of this skewness"
    raise InputError("skewness, kurtosis", (skewness, kurtosis), allowed, "Change the kurtosis by 1 %.")
