"""Free-volume viscosity (Doolittle 1951) and the hybrid McEwen-Paluch law."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from ehl.common.arrays import FloatArray
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel
from ehl.fluid.density import Murnaghan, Tait
from ehl.fluid.viscosity import (
    MEASURED_DEVIATION,
    AlphaValue,
    DynamicViscosity,
    Expansion,
    Positive,
    Temperature,
    pole_growth,
    vogel_1921,
    vogel_slope,
)

LAST_OCCUPIED = 0.93  # occupied share of the volume above which the tangent is used
LAST_SHARE = 0.9  # share of the diverging pressure above which the tangent is used


class Doolittle(InputModel):
    """ln(eta/etaR) = B R0 [(Vo/VoR)/(V/VR - R0 Vo/VoR) - 1/(1 - R0)], Vo/VoR = 1 + eps (T - TR) (Doolittle; Bair).

    With the occupied share y = R0 (Vo/VoR)/(V/VR) this is B [y/(1 - y) - R0/(1 - R0)]. V/VR follows from the equation
    of state, (V/V0)(p, T) (1 + aV (T - TR)). Above y = 0.93 the law is continued by its tangent in y (own choice).
    """

    deviation: ClassVar[float] = MEASURED_DEVIATION
    law: Literal["doolittle"] = "doolittle"
    # etaR [Pa s] at TR [K] and ambient pressure
    viscosity_reference: DynamicViscosity
    temperature_reference: Temperature
    # [-]
    B: Positive
    R0: Annotated[float, ValueRange("", gt=0.0, lt=0.9)]
    # eps and aV [1/K]
    epsilon: Expansion
    volume_expansion: Expansion
    state: Annotated[Tait | Murnaghan, Field(discriminator="law")]  # V/V0 over pressure

    def log_viscosity(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """ln eta, eta in Pa s, at pressures [Pa] and temperatures [K]."""
        growth, _ = pole_growth(self._share(pressure, temperature), LAST_OCCUPIED)
        at_reference = self.R0 / (1.0 - self.R0)
        return np.asarray(np.log(self.viscosity_reference) + self.B * (growth - at_reference))

    def by_pressure(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """d ln eta/dp [1/Pa]."""
        share = self._share(pressure, temperature)
        state = self.state.at(temperature)
        share_p = share * state.slope(pressure) / state.ratio(pressure)
        return np.asarray(self.B * pole_growth(share, LAST_OCCUPIED)[1] * share_p)

    def by_temperature(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """d ln eta/dT [1/K]."""
        share, over = self._share(pressure, temperature), temperature - self.temperature_reference
        occupied = self.epsilon / (1.0 + self.epsilon * over)
        volume = self.volume_expansion / (1.0 + self.volume_expansion * over)
        state = self.state.at(temperature)
        # V/V0 depends on p/K0(T) only, and K0 decreases as exp(-betaK T)
        softer = self.state.betaK * pressure * state.slope(pressure) / state.ratio(pressure)
        return np.asarray(self.B * pole_growth(share, LAST_OCCUPIED)[1] * share * (occupied - volume + softer))

    def _share(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        over = temperature - self.temperature_reference
        volume = (1.0 + self.volume_expansion * over) / self.state.at(temperature).ratio(pressure)
        return np.asarray(self.R0 * (1.0 + self.epsilon * over) / volume)


class McEwenPaluch(InputModel):
    """eta = K exp(B/(T + C)) (1 + a0 p/q)^q exp(CF p/(pinf - p)), T in degC (hybrid of Bair; form from memory).

    The temperature dependence is own work: pinf = pinf40 + dpinf (T - 40) and a0 = a40 exp(-beta_a (T - 40)). Above
    0.9 pinf the exponent is continued by its tangent in p/pinf (own choice).
    """

    deviation: ClassVar[float] = MEASURED_DEVIATION
    law: Literal["mcewen_paluch"] = "mcewen_paluch"
    # of `vogel_1921` [Pa s, K, K]
    K: DynamicViscosity
    B: float
    C: float
    # a40 [1/Pa] and beta_a [1/K]
    a0: AlphaValue
    a0_fall: Expansion = 0.0
    # exponent and fragility [-]
    q: Positive
    CF: Annotated[float, ValueRange("", ge=0.0, le=1e3)]
    # pinf at 40 degC [Pa] and its rise [Pa/K]
    pinf: Annotated[float, ValueRange("Pa", ge=1e8, le=1e12)]
    pinf_rise: Annotated[float, ValueRange("Pa/K", ge=0.0, le=1e9)] = 0.0

    def log_viscosity(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """ln eta, eta in Pa s, at pressures [Pa] and temperatures [K]."""
        initial, end = self._at(temperature)
        rise = self.q * np.log(1.0 + initial * pressure / self.q)
        growth, _ = pole_growth(pressure / end, LAST_SHARE)
        return np.asarray(np.log(vogel_1921(temperature, self.K, self.B, self.C)) + rise + self.CF * growth)

    def by_pressure(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """d ln eta/dp [1/Pa]."""
        initial, end = self._at(temperature)
        _, growth = pole_growth(pressure / end, LAST_SHARE)
        return np.asarray(initial / (1.0 + initial * pressure / self.q) + self.CF * growth / end)

    def by_temperature(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """d ln eta/dT [1/K]."""
        initial, end = self._at(temperature)
        _, growth = pole_growth(pressure / end, LAST_SHARE)
        thinning = vogel_slope(temperature, self.B, self.C)
        fall = self.a0_fall * initial * pressure / (1.0 + initial * pressure / self.q)
        return np.asarray(-thinning - fall - self.CF * growth * pressure * self.pinf_rise / end**2)

    def _at(self, temperature: FloatArray) -> tuple[FloatArray, FloatArray]:
        """a0 and pinf."""
        warmer = temperature - 313.15
        # lower bound of pinf far outside the measured range
        end = np.maximum(self.pinf + self.pinf_rise * warmer, 0.2 * self.pinf)
        return self.a0 * np.exp(-self.a0_fall * warmer), end
