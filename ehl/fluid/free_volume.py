"""Viscosity over free volume: Doolittle (1951), the hybrid McEwen-Paluch law, and Yasutomi.

Yasutomi's law is one of the distance from the glass transition (Yasutomi, Bair & Winer 1984; Bair 2007).
"""

import math
from functools import lru_cache
from typing import Annotated, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from ehl.common.arrays import FloatArray
from ehl.common.units import KELVIN, ValueRange
from ehl.common.validation import InputModel
from ehl.fluid import viscosity
from ehl.fluid.density import Murnaghan, Tait

LAST_DEPTH = 0.5  # share of the way from the glass transition to the pole above which the tangent is used
_REST = 2e-13  # slope where the original form would decrease, so that ln eta remains monotone [1/Pa]
_GRID = np.linspace(0.0, 6e9, 301)  # pressures for the largest viscosity of the original form [Pa]
_TEMPERATURES = np.linspace(200.0, 700.0, 4001)  # [K]

GlassTemperature = Annotated[float, ValueRange("K", ge=100.0, le=400.0)]
PerPressure = Annotated[float, ValueRange("1/Pa", gt=0.0, le=1e-6)]
Difference = Annotated[float, ValueRange("K", gt=0.0, le=1e4)]


class _Yasutomi(InputModel):
    """log10 eta = log10 etaG - C1 X/(C2 + X), X = (T - Tg) F, Tg = Tg0 + A1 ln(1 + A2 p), T and Tg in degC.

    Within C2/2 of the pole X = -C2, where eta exceeds etaG 10^C1, log10 eta is continued by its tangent in X (own
    choice).
    """

    deviation: ClassVar[float] = viscosity.MEASURED_DEVIATION
    viscosity_glass: viscosity.DynamicViscosity = 1e12
    Tg0: GlassTemperature
    A1: Difference
    A2: PerPressure
    C1: viscosity.Positive
    C2: Difference

    def log_viscosity(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """ln eta, eta in Pa s, at pressures [Pa] and temperatures [K]."""
        held = self._held(pressure, temperature)
        growth, _ = viscosity.pole_growth(-self._distance(held, temperature) / self.C2, LAST_DEPTH)
        rest = _REST * (pressure - held)
        return np.asarray(np.log(self.viscosity_glass) + math.log(10.0) * self.C1 * growth + rest)

    def by_pressure(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """d ln eta/dp [1/Pa]."""
        held = self._held(pressure, temperature)
        factor, factor_p = self._factor(held)
        glass_p = self.A1 * self.A2 / (1.0 + self.A2 * held)
        distance_p = self._above_glass(held, temperature) * factor_p - glass_p * factor
        slope = self._by_distance(held, temperature) * distance_p
        return np.where(pressure > held, _REST, slope)

    def by_temperature(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """d ln eta/dT [1/K]."""
        pressure = self._held(pressure, temperature)
        return np.asarray(self._by_distance(pressure, temperature) * self._factor(pressure)[0])

    def _by_distance(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        _, slope = viscosity.pole_growth(-self._distance(pressure, temperature) / self.C2, LAST_DEPTH)
        return np.asarray(-math.log(10.0) * self.C1 / self.C2 * slope)

    def _above_glass(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        glass = (self.Tg0 - KELVIN) + self.A1 * np.log(1.0 + self.A2 * pressure)
        return np.asarray(temperature - KELVIN - glass)

    def _distance(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        return np.asarray(self._above_glass(pressure, temperature) * self._factor(pressure)[0])

    def _factor(self, pressure: FloatArray) -> tuple[FloatArray, FloatArray]:
        """F and dF/dp."""
        raise NotImplementedError

    def _held(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """The pressure, limited to that of the largest viscosity."""
        return pressure


class ImprovedYasutomi(_Yasutomi):
    """Improved form: F = (1 + b1 p)^b2; equation and pole as in `_Yasutomi`."""

    law: Literal["yasutomi_improved"] = "yasutomi_improved"
    b1: PerPressure
    b2: Annotated[float, ValueRange("", ge=-2.0, lt=0.0)]

    def _factor(self, pressure: FloatArray) -> tuple[FloatArray, FloatArray]:
        inside = 1.0 + self.b1 * pressure
        factor = inside**self.b2
        return factor, self.b2 * self.b1 * factor / inside


class OriginalYasutomi(_Yasutomi):
    """Original form: F = 1 - B1 ln(1 + B2 p), which turns negative at high pressure.

    Above the pressure of its largest viscosity ln eta increases by 2e-4 per GPa (own choice).
    """

    law: Literal["yasutomi_original"] = "yasutomi_original"
    B1: viscosity.Positive
    B2: PerPressure

    def _factor(self, pressure: FloatArray) -> tuple[FloatArray, FloatArray]:
        inside = 1.0 + self.B2 * pressure
        return 1.0 - self.B1 * np.log(inside), -self.B1 * self.B2 / inside

    def _held(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """The pressure, at most that of the largest viscosity of the original form [Pa]; `temperature` in K."""
        return np.minimum(pressure, np.interp(temperature, _TEMPERATURES, _largest(self)))


@lru_cache(maxsize=32)
def _largest(law: OriginalYasutomi) -> FloatArray:
    """Solution of dX/dp = 0 by bisection at `_TEMPERATURES`."""

    def falls(pressure: FloatArray) -> NDArray[np.bool_]:
        factor, factor_p = law._factor(pressure)
        glass_p = law.A1 * law.A2 / (1.0 + law.A2 * pressure)
        return np.asarray(law._above_glass(pressure, _TEMPERATURES) * factor_p - glass_p * factor >= 0.0, dtype=bool)

    rising = np.logical_and.accumulate(~falls(_GRID[:, None]), axis=0)
    low = _GRID[np.maximum(rising.sum(axis=0) - 1, 0)]
    high = low + _GRID[1]
    for _ in range(50):
        middle = 0.5 * (low + high)
        over = falls(middle)
        low, high = np.where(over, low, middle), np.where(over, middle, high)
    return np.asarray(low)


LAST_OCCUPIED = 0.93  # occupied share of the volume above which the tangent is used
LAST_SHARE = 0.9  # share of the diverging pressure above which the tangent is used


class Doolittle(InputModel):
    """ln(eta/etaR) = B R0 [(Vo/VoR)/(V/VR - R0 Vo/VoR) - 1/(1 - R0)], Vo/VoR = 1 + eps (T - TR) (Doolittle; Bair).

    With the occupied share y = R0 (Vo/VoR)/(V/VR) this is B [y/(1 - y) - R0/(1 - R0)]. V/VR follows from the equation
    of state, (V/V0)(p, T) (1 + aV (T - TR)). Above y = 0.93 the law is continued by its tangent in y (own choice).
    """

    deviation: ClassVar[float] = viscosity.MEASURED_DEVIATION
    law: Literal["doolittle"] = "doolittle"
    # etaR [Pa s] at TR [K] and ambient pressure
    viscosity_reference: viscosity.DynamicViscosity
    temperature_reference: viscosity.Temperature
    # [-]
    B: viscosity.Positive
    R0: Annotated[float, ValueRange("", gt=0.0, lt=0.9)]
    # eps and aV [1/K]
    epsilon: viscosity.Expansion
    volume_expansion: viscosity.Expansion
    state: Annotated[Tait | Murnaghan, Field(discriminator="law")]  # V/V0 over pressure

    def log_viscosity(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """ln eta, eta in Pa s, at pressures [Pa] and temperatures [K]."""
        growth, _ = viscosity.pole_growth(self._share(pressure, temperature), LAST_OCCUPIED)
        at_reference = self.R0 / (1.0 - self.R0)
        return np.asarray(np.log(self.viscosity_reference) + self.B * (growth - at_reference))

    def by_pressure(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """d ln eta/dp [1/Pa]."""
        share = self._share(pressure, temperature)
        state = self.state.at(temperature)
        share_p = share * state.slope(pressure) / state.ratio(pressure)
        return np.asarray(self.B * viscosity.pole_growth(share, LAST_OCCUPIED)[1] * share_p)

    def by_temperature(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """d ln eta/dT [1/K]."""
        share, over = self._share(pressure, temperature), temperature - self.temperature_reference
        occupied = self.epsilon / (1.0 + self.epsilon * over)
        volume = self.volume_expansion / (1.0 + self.volume_expansion * over)
        state = self.state.at(temperature)
        # V/V0 depends on p/K0(T) only, and K0 decreases as exp(-betaK T)
        softer = self.state.betaK * pressure * state.slope(pressure) / state.ratio(pressure)
        return np.asarray(
            self.B * viscosity.pole_growth(share, LAST_OCCUPIED)[1] * share * (occupied - volume + softer)
        )

    def _share(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        over = temperature - self.temperature_reference
        volume = (1.0 + self.volume_expansion * over) / self.state.at(temperature).ratio(pressure)
        return np.asarray(self.R0 * (1.0 + self.epsilon * over) / volume)


class McEwenPaluch(InputModel):
    """eta = K exp(B/(T + C)) (1 + a0 p/q)^q exp(CF p/(pinf - p)), T in degC (hybrid of Bair; form unverified).

    The temperature dependence is own work: pinf = pinf40 + dpinf (T - 40) and a0 = a40 exp(-beta_a (T - 40)). Above
    0.9 pinf the exponent is continued by its tangent in p/pinf (own choice).
    """

    deviation: ClassVar[float] = viscosity.MEASURED_DEVIATION
    law: Literal["mcewen_paluch"] = "mcewen_paluch"
    # of `vogel_1921` [Pa s, K, K]
    K: viscosity.DynamicViscosity
    B: float
    C: float
    # a40 [1/Pa] and beta_a [1/K]
    a0: viscosity.AlphaValue
    a0_fall: viscosity.Expansion = 0.0
    # exponent and fragility [-]
    q: viscosity.Positive
    CF: Annotated[float, ValueRange("", ge=0.0, le=1e3)]
    # pinf at 40 degC [Pa] and its rise [Pa/K]
    pinf: Annotated[float, ValueRange("Pa", ge=1e8, le=1e12)]
    pinf_rise: Annotated[float, ValueRange("Pa/K", ge=0.0, le=1e9)] = 0.0

    def log_viscosity(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """ln eta, eta in Pa s, at pressures [Pa] and temperatures [K]."""
        initial, end = self._at(temperature)
        rise = self.q * np.log(1.0 + initial * pressure / self.q)
        growth, _ = viscosity.pole_growth(pressure / end, LAST_SHARE)
        return np.asarray(np.log(viscosity.vogel_1921(temperature, self.K, self.B, self.C)) + rise + self.CF * growth)

    def by_pressure(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """d ln eta/dp [1/Pa]."""
        initial, end = self._at(temperature)
        _, growth = viscosity.pole_growth(pressure / end, LAST_SHARE)
        return np.asarray(initial / (1.0 + initial * pressure / self.q) + self.CF * growth / end)

    def by_temperature(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """d ln eta/dT [1/K]."""
        initial, end = self._at(temperature)
        _, growth = viscosity.pole_growth(pressure / end, LAST_SHARE)
        thinning = viscosity.vogel_slope(temperature, self.B, self.C)
        fall = self.a0_fall * initial * pressure / (1.0 + initial * pressure / self.q)
        return np.asarray(-thinning - fall - self.CF * growth * pressure * self.pinf_rise / end**2)

    def _at(self, temperature: FloatArray) -> tuple[FloatArray, FloatArray]:
        """a0 and pinf."""
        warmer = temperature - 313.15
        # lower bound of pinf far outside the measured range
        end = np.maximum(self.pinf + self.pinf_rise * warmer, 0.2 * self.pinf)
        return self.a0 * np.exp(-self.a0_fall * warmer), end
