"""Viscosity by free volume (Doolittle 1951) and by two factors of pressure (hybrid McEwen-Paluch)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ehl.fluid.density import Murnaghan, Tait
from ehl.fluid.poles import pole_growth
from ehl.fluid.viscosity import vogel_1921, vogel_slope

Array = NDArray[np.float64]

LAST_OCCUPIED = 0.93  # occupied share of the volume: from there on along the tangent
LAST_SHARE = 0.9  # of the diverging pressure: from there on along the tangent


@dataclass(frozen=True)
class Doolittle:
    """ln(eta/etaR) = B R0 [(Vo/VoR)/(V/VR - R0 Vo/VoR) - 1/(1 - R0)], Vo/VoR = 1 + eps (T - TR) (Doolittle; Bair).

    In the occupied share y = R0 (Vo/VoR)/(V/VR) this is B [y/(1 - y) - R0/(1 - R0)]; V/VR is that of the equation of
    state, (V/V0)(p, T) (1 + aV (T - TR)). Beyond y = 0.93 it goes on along its tangent in y (ours).

    Parameters
    ----------
    viscosity_reference : float
        etaR at TR and ambient pressure [Pa s].
    temperature_reference : float
        TR [K].
    factor : float
        B [-].
    occupied : float
        R0 [-].
    occupied_expansion : float
        eps [1/K].
    volume_expansion : float
        aV [1/K].
    state : Tait or Murnaghan
        V/V0 over pressure.
    """

    viscosity_reference: float
    temperature_reference: float
    factor: float
    occupied: float
    occupied_expansion: float
    volume_expansion: float
    state: Tait | Murnaghan

    def log_viscosity(self, pressure: Array, temperature: Array) -> Array:
        """ln eta, eta in Pa s, at pressures [Pa] and temperatures [K]."""
        growth, _ = pole_growth(self._share(pressure, temperature), LAST_OCCUPIED)
        at_reference = self.occupied / (1.0 - self.occupied)
        return np.asarray(np.log(self.viscosity_reference) + self.factor * (growth - at_reference))

    def by_pressure(self, pressure: Array, temperature: Array) -> Array:
        """d ln eta/dp [1/Pa]."""
        share = self._share(pressure, temperature)
        state = self.state.at(temperature)
        share_p = share * state.slope(pressure) / state.ratio(pressure)
        return np.asarray(self.factor * pole_growth(share, LAST_OCCUPIED)[1] * share_p)

    def by_temperature(self, pressure: Array, temperature: Array) -> Array:
        """d ln eta/dT [1/K]."""
        share, over = self._share(pressure, temperature), temperature - self.temperature_reference
        occupied = self.occupied_expansion / (1.0 + self.occupied_expansion * over)
        volume = self.volume_expansion / (1.0 + self.volume_expansion * over)
        state = self.state.at(temperature)
        # V/V0 depends on p/K0(T) alone, and K0 falls as exp(-betaK T)
        softer = self.state.softening * pressure * state.slope(pressure) / state.ratio(pressure)
        return np.asarray(self.factor * pole_growth(share, LAST_OCCUPIED)[1] * share * (occupied - volume + softer))

    def _share(self, pressure: Array, temperature: Array) -> Array:
        over = temperature - self.temperature_reference
        volume = (1.0 + self.volume_expansion * over) / self.state.at(temperature).ratio(pressure)
        return np.asarray(self.occupied * (1.0 + self.occupied_expansion * over) / volume)


@dataclass(frozen=True)
class McEwenPaluch:
    """eta = K exp(B/(T + C)) (1 + a0 p/q)^q exp(CF p/(pinf - p)), T in degC (hybrid of Bair; form from memory).

    pinf grows linearly with temperature, pinf = pinf40 + dpinf (T - 40), and a0 falls with it as
    a0 = a40 exp(-beta_a (T - 40)): both ours, for one law over temperature. Beyond 0.9 pinf the exponent goes on along
    its tangent in p/pinf (ours).

    Parameters
    ----------
    vogel : tuple of float
        (K [Pa s], B [K], C [K]).
    slope, slope_fall : float
        a40 [1/Pa] and beta_a [1/K].
    exponent : float
        q [-].
    fragility : float
        CF [-].
    diverging, diverging_rise : float
        pinf at 40 degC [Pa] and its rise [Pa/K].
    """

    vogel: tuple[float, float, float]
    slope: float
    slope_fall: float
    exponent: float
    fragility: float
    diverging: float
    diverging_rise: float

    def log_viscosity(self, pressure: Array, temperature: Array) -> Array:
        """ln eta, eta in Pa s, at pressures [Pa] and temperatures [K]."""
        initial, end = self._at(temperature)
        rise = self.exponent * np.log(1.0 + initial * pressure / self.exponent)
        growth, _ = pole_growth(pressure / end, LAST_SHARE)
        return np.asarray(np.log(vogel_1921(temperature, *self.vogel)) + rise + self.fragility * growth)

    def by_pressure(self, pressure: Array, temperature: Array) -> Array:
        """d ln eta/dp [1/Pa]."""
        initial, end = self._at(temperature)
        _, growth = pole_growth(pressure / end, LAST_SHARE)
        return np.asarray(initial / (1.0 + initial * pressure / self.exponent) + self.fragility * growth / end)

    def by_temperature(self, pressure: Array, temperature: Array) -> Array:
        """d ln eta/dT [1/K]."""
        initial, end = self._at(temperature)
        _, growth = pole_growth(pressure / end, LAST_SHARE)
        thinning = vogel_slope(temperature, *self.vogel[1:])
        fall = self.slope_fall * initial * pressure / (1.0 + initial * pressure / self.exponent)
        return np.asarray(-thinning - fall - self.fragility * growth * pressure * self.diverging_rise / end**2)

    def _at(self, temperature: Array) -> tuple[Array, Array]:
        """a0 and pinf."""
        warmer = temperature - 313.15
        # far from where it was measured pinf is kept from falling to nothing
        end = np.maximum(self.diverging + self.diverging_rise * warmer, 0.2 * self.diverging)
        return self.slope * np.exp(-self.slope_fall * warmer), end
