"""Four definitions of the pressure-viscosity coefficient for every law, and constants of laws from coefficients.

With L(p) = ln(eta(p)/eta0): the slope L'(0); the secant L(0.2 GPa)/0.2 GPa (FVA 400, Gold's formula); the reciprocal
isoviscous pressure alpha*, 1/alpha* = int_0^inf exp(-L) dp (Blok); and alpha_film = (1 - e^-3)/int_0^(3/alpha*) exp(-L)
dp for Newtonian film formulas (Bair, Liu & Wang 2006). For the Barus law all are equal to alpha.

The integral to infinity follows the law up to 3 GPa and its tangent beyond, since it is not finite for laws whose L
tends to a limit. The part beyond 3 GPa is below 1e-3 of the integral for the oils of `data/oils`.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.fluid.viscosity import ROELANDS_LOG_VISCOSITY, ROELANDS_PRESSURE, PressureLaw

AlphaDefinition = Literal["slope", "secant_200", "star", "film"]
DEFINITIONS: tuple[AlphaDefinition, ...] = get_args(AlphaDefinition)

SECANT_PRESSURE = 0.2e9  # [Pa]
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(20)
_PIECES = np.array([0.0, 0.03, 0.1, 0.25, 0.5, 1.0, 1.8, 3.0]) * 1e9  # of the integral over the pressure [Pa]
_ROUNDS = 60


def alpha_star(law: PressureLaw) -> FloatArray:
    """1/int_0^inf exp(-L) dp [1/Pa]."""
    half = 0.5 * np.diff(_PIECES)[:, None]
    nodes = (_PIECES[:-1, None] + half * (1.0 + _NODES)).ravel()[:, None]
    weights = (half * _WEIGHTS).ravel()
    top = _PIECES[-1:, None]
    # beyond a pole of the law exp(-L) is 0; beyond its largest pressure it is extrapolated
    tail = np.exp(-law.log_ratio(top)) / np.maximum(law.by_pressure(top), 1e-12)
    return np.asarray(1.0 / (weights @ np.exp(-law.log_ratio(nodes)) + tail[0]))


def alpha_film(law: PressureLaw) -> FloatArray:
    """(1 - e^-3)/int_0^(3/alpha*) exp(-L) dp [1/Pa]."""
    half = 1.5 / alpha_star(law)
    nodes = half * (1.0 + _NODES[:, None])
    return np.asarray(-math.expm1(-3.0) / (half * (_WEIGHTS @ np.exp(-law.log_ratio(nodes)))))


_ALPHAS: dict[AlphaDefinition, Callable[[PressureLaw], FloatArray]] = {
    "slope": lambda law: np.asarray(law.by_pressure(np.zeros(1))),
    "secant_200": lambda law: np.asarray(law.log_ratio(np.full(1, SECANT_PRESSURE)) / SECANT_PRESSURE),
    "star": alpha_star,
    "film": alpha_film,
}


def alpha_of(law: PressureLaw, definition: AlphaDefinition) -> Any:
    """The coefficient of a law by one of the four definitions.

    law: law of `ehl.fluid.viscosity` or `Lubricant.pressure_law`; its inlet temperature may be an array.
    Returns: [1/Pa]; a float for one inlet temperature.
    """
    found = _ALPHAS[definition](law)
    return float(found[0]) if found.shape == (1,) else found


def solve_constant(
    law_of: Callable[[Any], PressureLaw], stated: ArrayLike, definition: AlphaDefinition, start: ArrayLike
) -> Any:
    """The free constant for which a law has the stated coefficient, to 1e-13.

    law_of: returns the law for a free constant: alpha for Roelands and Barus, a factor on L for the others.
    stated: coefficient [1/Pa].
    start: initial value of the constant.
    Raises `InputError`: the law cannot have this coefficient.
    """
    wanted = np.log(np.atleast_1d(np.asarray(stated, dtype=float)))
    x = np.broadcast_to(np.log(np.asarray(start, dtype=float)), wanted.shape).copy()

    def error(place: FloatArray) -> FloatArray:
        return np.asarray(np.log(_ALPHAS[definition](law_of(np.exp(place)))) - wanted)

    value = error(x)
    slope = np.ones_like(x)
    for _ in range(_ROUNDS):
        if np.all(np.abs(value) < 1e-13):
            break
        step = np.clip(-value / slope, -1.0, 1.0)
        new = error(x + step)
        change = (new - value) / np.where(step == 0.0, 1.0, step)
        # slopes of the order of rounding errors are ignored
        slope = np.where((np.abs(step) > 1e-7) & (change > 0.1), change, slope)
        x, value = x + step, new
    if not np.all(np.abs(value) < 1e-11):
        given = np.ravel(np.asarray(stated, dtype=float))
        raise InputError(
            "pressure_viscosity", f"{1e9 * given[0]:.4g} 1/GPa", f"a coefficient the law can have as {definition}"
        )
    found = np.exp(x)
    return float(found[0]) if np.ndim(stated) == 0 else found


def roelands_slope(secant: Any, viscosity: Any) -> Any:
    """The slope of the Roelands law through a secant [1/Pa]: A z/p0, z = ln(1 + 0.2 GPa secant/A)/ln(1 + 0.2 GPa/p0).

    secant: L(0.2 GPa)/0.2 GPa [1/Pa].
    viscosity: eta0 [Pa s]; A = ln eta0 + 9.67.
    """
    height = np.log(viscosity) + ROELANDS_LOG_VISCOSITY
    exponent = np.log(1.0 + SECANT_PRESSURE * secant / height) / math.log(1.0 + SECANT_PRESSURE / ROELANDS_PRESSURE)
    return height * exponent / ROELANDS_PRESSURE


@dataclass(frozen=True)
class TemperatureFit:
    """ln of a positive function of temperature by polynomials, in operations that can be exported as code."""

    # (lowest, highest temperature [K], coefficients of the powers of t, -1 to 1) of each piece, from cold to warm
    pieces: tuple[tuple[float, float, tuple[float, ...]], ...]
    error: float  # largest relative error of the function at four times as many temperatures [-]

    def __call__(self, temperature: Any) -> Any:
        """The function at temperatures [K]; the end pieces are extrapolated."""
        values = [self._piece(temperature, *piece) for piece in self.pieces]
        found = values[-1]
        for (_, high, _), value in zip(reversed(self.pieces[:-1]), reversed(values[:-1]), strict=True):
            found = np.where(temperature <= high, value, found)
        return np.exp(found)

    @staticmethod
    def _piece(temperature: Any, low: float, high: float, coefficients: tuple[float, ...]) -> Any:
        """Horner's scheme."""
        place = (2.0 * temperature - (low + high)) / (high - low)
        value: Any = coefficients[-1] + 0.0 * place
        for coefficient in coefficients[-2::-1]:
            value = value * place + coefficient
        return value


# up to which a piece is halved, and the length [K] below which it is not
_FIT_ERROR, _SHORTEST_PIECE = 1e-6, 5.0
# of ln of the function: omitted last coefficients of Chebyshev polynomials, and digits of those of powers
_NEGLIGIBLE, _DIGITS = 1e-14, 15


def temperature_fit(function: Callable[[FloatArray], FloatArray], ends: tuple[float, ...]) -> TemperatureFit:
    """A `TemperatureFit` between temperatures [K]; inner ends are known kinks of the function, others are searched."""
    pieces, error, degree = [], 0.0, 20
    spot = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
    left = list(itertools.pairwise(ends))[::-1]
    while left:
        low, high = left.pop()
        values = np.log(function(0.5 * (low + high) + 0.5 * (high - low) * spot))
        coefficients = np.polynomial.chebyshev.chebfit(spot, values, degree)
        powers = np.polynomial.chebyshev.cheb2poly(np.polynomial.chebyshev.chebtrim(coefficients, _NEGLIGIBLE))
        piece = (low, high, tuple(map(float, np.round(powers, _DIGITS))))
        between = np.linspace(low, high, 4 * degree + 1)
        own = float(np.max(np.abs(TemperatureFit((piece,), 0.0)(between) / function(between) - 1.0)))
        if own > _FIT_ERROR and high - low > _SHORTEST_PIECE:
            left += [(0.5 * (low + high), high), (low, 0.5 * (low + high))]
            continue
        pieces.append(piece)
        error = max(error, own)
    return TemperatureFit(tuple(pieces), error)
