"""The lubricant: viscosity, density and shear laws, oil cards, and the numbers a solver needs.

The pure functions carry one published law each. `Lubricant` holds the numbers at one inlet temperature; `Oil` is a
card of `data/oils/` that gives a `Lubricant` at any temperature.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ehl.fluid.rheology import Limit, Rheology, RisingStress, ShearLaw

Array = NDArray[np.float64]

ROELANDS_PRESSURE = 1.96e8  # p0 [Pa]
ROELANDS_LOG_VISCOSITY = 9.67  # -ln of the viscosity all curves meet at, 6.31e-5 Pa s
ROELANDS_TEMPERATURE = 138.0  # [K]
DOWSON_HIGGINSON = (0.6e-9, 1.7e-9)  # [1/Pa]
KELVIN = 273.15

ViscosityLaw = Literal["barus", "roelands", "modulus"]
DensityLaw = Literal["incompressible", "dowson_higginson"]
LAW_CODES: dict[str, int] = {"barus": 0, "roelands": 1, "modulus": 2}


def walther_1931(temperature: float, viscosity_40: float, viscosity_100: float) -> float:
    """Kinematic viscosity at any temperature from its values at 40 and 100 degC.

    log10 log10(nu + 0.7) = m - n log10 T, nu in cSt, T in K (Walther 1931; ASTM D341).

    Parameters
    ----------
    temperature : float
        [K].
    viscosity_40, viscosity_100 : float
        Kinematic viscosity at 40 and 100 degC [m2/s].

    Returns
    -------
    float
        Kinematic viscosity [m2/s].
    """

    m, n = _walther_constants(viscosity_40, viscosity_100)
    return float((10.0 ** (10.0 ** (m - n * math.log10(temperature))) - 0.7) * 1e-6)


def walther_slope(temperature: float, viscosity_40: float, viscosity_100: float) -> float:
    """-d ln(nu)/dT of `walther_1931` [1/K]: n (nu + 0.7) ln(nu + 0.7)/(nu T), nu in cSt; arguments as there."""
    _, n = _walther_constants(viscosity_40, viscosity_100)
    nu = 1e6 * walther_1931(temperature, viscosity_40, viscosity_100)
    return n * (nu + 0.7) * math.log(nu + 0.7) / (nu * temperature)


def _walther_constants(viscosity_40: float, viscosity_100: float) -> tuple[float, float]:
    """m and n of the line through both viscosities."""

    def double_log(viscosity: float) -> float:
        return math.log10(math.log10(viscosity * 1e6 + 0.7))

    low, high = math.log10(40.0 + KELVIN), math.log10(100.0 + KELVIN)
    slope = (double_log(viscosity_40) - double_log(viscosity_100)) / (high - low)
    return double_log(viscosity_40) + slope * low, slope


def density_at(temperature: float, density_15: float, coefficient: float) -> float:
    """Density at ambient pressure, rho15 (1 + a_T (T - 15 degC)) [kg/m3]; `temperature` in K."""
    return density_15 * (1.0 + coefficient * (temperature - KELVIN - 15.0))


# (s, t) of Gold's formula by base oil; nu in cSt, alpha in 1/GPa
GOLD_COEFFICIENTS: dict[str, tuple[float, float]] = {
    "mineral": (9.904, 0.1390),
    "pao": (7.382, 0.1335),
    "polyglycol": (5.489, 0.1485),
    "ester": (6.605, 0.1360),
}


def gold_2001(viscosity_kinematic: float, base: str) -> float:
    """Pressure-viscosity coefficient alpha = s nu^t 1e-9 [1/Pa], nu in cSt (Gold et al. 2001).

    Parameters
    ----------
    viscosity_kinematic : float
        [m2/s] at the wanted temperature.
    base : str
        Base oil, a key of `GOLD_COEFFICIENTS`.
    """
    scale, exponent = GOLD_COEFFICIENTS[base]
    return float(scale * (viscosity_kinematic * 1e6) ** exponent * 1e-9)


def dowson_higginson_1966(pressure: Array, a: float = 0.6e-9, b: float = 1.7e-9) -> Array:
    """rho/rho0 = 1 + a p/(1 + b p) (Dowson & Higginson 1966).

    The variant (5.9e8 + 1.34 p)/(5.9e8 + p) is another function: 0.8 % apart at 2 GPa.
    """
    return np.asarray(1.0 + a * pressure / (1.0 + b * pressure))


@dataclass(frozen=True)
class Lubricant:
    """A lubricant at one inlet temperature.

    Parameters
    ----------
    viscosity_inlet : float
        eta0, dynamic viscosity at ambient pressure and inlet temperature [Pa s].
    pressure_viscosity : float
        alpha = d ln eta/dp at p = 0 [1/Pa].
    viscosity_law : {"barus", "roelands", "modulus"}
        Pressure dependence.
    modulus_constants : tuple of float
        (a1 [Pa], a2 [Pa/K], b1 [-], b2 [1/K]) of ln(eta/eta0) = p/(a1 + a2 T + (b1 + b2 T) p), T in degC;
        needed by the modulus law only.
    density_law : {"incompressible", "dowson_higginson"}
        Pressure dependence of the density.
    density_coefficients : tuple of float
        (a, b) of Dowson & Higginson [1/Pa].
    rheology : {"newtonian", "eyring", "carreau"}
        Shear law.
    eyring_stress : float or RisingStress
        tau0 [Pa], constant or rising with pressure.
    carreau_stress : float
        G in eta_effective = eta (1 + (eta rate/G)^2)^((n - 1)/2) [Pa]; needed by Carreau only.
    carreau_exponent : float
        n [-]; 1 is Newtonian.
    limiting_shear_coefficient : float
        Lambda in tau <= tau_L0 + Lambda p [-]; infinity switches the limit off.
    limiting_shear_ambient : float
        tau_L0 [Pa].
    limiting_shear : {"cut", "smooth"}
        Whether the limit only cuts off the traction, or is approached smoothly and acts on the pressure flow as well.
    temperature : float
        Inlet temperature [K].
    temperature_viscosity : float
        beta = -d ln eta0/dT at the inlet temperature [1/K].
    temperature_constants : tuple of float
        (B [K], C [K]) of eta0(T) = K exp(B/(T + C)), T in degC, where the card has this form; else empty.
    density : float
        rho0 at ambient pressure and inlet temperature [kg/m3].
    thermal_conductivity : float
        [W/(m K)] at ambient pressure.
    heat_capacity : float
        [J/(kg K)].
    extrapolated : bool
        The card was read outside the temperatures it was measured at.
    """

    viscosity_inlet: float
    pressure_viscosity: float
    viscosity_law: ViscosityLaw = "roelands"
    modulus_constants: tuple[float, ...] = ()
    density_law: DensityLaw = "dowson_higginson"
    density_coefficients: tuple[float, float] = DOWSON_HIGGINSON
    rheology: Rheology = "newtonian"
    eyring_stress: float | RisingStress = 5e6
    limiting_shear_coefficient: float = math.inf
    temperature: float = 353.15
    temperature_viscosity: float = 0.03
    temperature_constants: tuple[float, ...] = ()
    density: float = 850.0
    thermal_conductivity: float = 0.14
    heat_capacity: float = 2000.0
    extrapolated: bool = False
    carreau_stress: float = math.nan
    carreau_exponent: float = math.nan
    limiting_shear_ambient: float = 0.0
    limiting_shear: Limit = "cut"

    @property
    def shear_law(self) -> ShearLaw:
        """Shear stress over shear rate, with its limit."""
        carreau = self.rheology == "carreau"
        return ShearLaw(
            self.rheology,
            self.carreau_stress if carreau else self.eyring_stress,
            self.carreau_exponent if carreau else 1.0,
            self.limiting_shear_coefficient,
            self.limiting_shear_ambient,
            self.limiting_shear,
        )

    @property
    def law_code(self) -> int:
        """Number of the viscosity law, for kernels: 0 barus, 1 roelands, 2 modulus."""
        return LAW_CODES[self.viscosity_law]

    @property
    def law_constants(self) -> Array:
        """Constants (c0, c1, c2) of ln(eta/eta0) at the inlet temperature, for kernels.

        barus c0 p; roelands c0 ((1 + p/c1)^c2 - 1); modulus p/(c0 + c1 p).
        """
        return self._law_constants(self.temperature)

    def _law_constants(self, temperature: float) -> Array:
        if self.viscosity_law == "barus":
            return np.array([self.pressure_viscosity, 0.0, 0.0])
        if self.viscosity_law == "roelands":
            scale = math.log(self.viscosity_inlet) + ROELANDS_LOG_VISCOSITY
            return np.array([scale, ROELANDS_PRESSURE, self.pressure_viscosity * ROELANDS_PRESSURE / scale])
        a1, a2, b1, b2 = self.modulus_constants
        celsius = temperature - KELVIN
        return np.array([a1 + a2 * celsius, b1 + b2 * celsius, 0.0])

    def log_viscosity_ratio(self, pressure: Array) -> Array:
        """ln(eta/eta0) at the inlet temperature, elementwise.

        Barus (1893) alpha p; Roelands (1966) A ((1 + p/p0)^z - 1), A = ln eta0 + 9.67, z = alpha p0/A, p0 = 1.96e8 Pa;
        modulus law p/(c0 + c1 p).
        """
        c0, c1, c2 = self.law_constants
        if self.viscosity_law == "barus":
            return np.asarray(c0 * pressure)
        if self.viscosity_law == "roelands":
            return np.asarray(c0 * ((1.0 + pressure / c1) ** c2 - 1.0))
        return np.asarray(pressure / (c0 + c1 * pressure))

    def dlog_viscosity_dp(self, pressure: Array) -> Array:
        """d ln eta/dp [1/Pa] at the inlet temperature, elementwise."""
        c0, c1, c2 = self.law_constants
        if self.viscosity_law == "barus":
            return np.full_like(np.asarray(pressure, dtype=float), c0)
        if self.viscosity_law == "roelands":
            return np.asarray(c0 * c2 / c1 * (1.0 + pressure / c1) ** (c2 - 1.0))
        return np.asarray(c0 / (c0 + c1 * pressure) ** 2)

    def viscosity(self, pressure: Array) -> Array:
        """eta(p) [Pa s] at the inlet temperature; beyond the range of doubles it is held at 1e300 Pa s."""
        exponent = np.log(self.viscosity_inlet) + self.log_viscosity_ratio(pressure)
        return np.asarray(np.exp(np.minimum(exponent, 690.0)))

    def log_viscosity(self, pressure: Array, temperature: Array) -> Array:
        """ln eta(p, T) with eta in Pa s, elementwise; `temperature` in K.

        Roelands: ln eta0 + A ((1 + p/p0)^z ((T - 138)/(T0 - 138))^-s0 - 1), s0 = beta (T0 - 138)/A.
        Barus: ln eta0 + alpha p - beta (T - T0). Modulus law: its own temperature form.
        """
        base = math.log(self.viscosity_inlet)
        if self.viscosity_law == "roelands":
            scale, reference, exponent = self.law_constants
            slope = self.temperature_viscosity * (self.temperature - ROELANDS_TEMPERATURE) / scale
            relative = np.maximum(temperature - ROELANDS_TEMPERATURE, 1.0) / (self.temperature - ROELANDS_TEMPERATURE)
            return np.asarray(base + scale * ((1.0 + pressure / reference) ** exponent * relative**-slope - 1.0))
        if self.viscosity_law == "barus":
            rise = temperature - self.temperature
            return np.asarray(base + self.pressure_viscosity * pressure - self.temperature_viscosity * rise)
        a1, a2, b1, b2 = self.modulus_constants
        celsius = temperature - KELVIN
        if self.temperature_constants:
            b, c = self.temperature_constants
            thermal = b / (celsius + c) - b / (self.temperature - KELVIN + c)
        else:
            thermal = -self.temperature_viscosity * (temperature - self.temperature)
        return np.asarray(base + thermal + pressure / (a1 + a2 * celsius + (b1 + b2 * celsius) * pressure))

    def dlog_viscosity_dtemperature(self, pressure: Array, temperature: Array) -> Array:
        """d ln eta/dT [1/K] at (p, T), elementwise; the derivative of `log_viscosity`."""
        if self.viscosity_law == "roelands":
            scale, reference, exponent = self.law_constants
            span = self.temperature - ROELANDS_TEMPERATURE
            slope = self.temperature_viscosity * span / scale
            above = np.maximum(temperature - ROELANDS_TEMPERATURE, 1.0)
            level = (1.0 + pressure / reference) ** exponent * (above / span) ** -slope
            return np.asarray(-scale * slope * level / above)
        if self.viscosity_law == "barus":
            return np.full(np.broadcast(pressure, temperature).shape, -self.temperature_viscosity)
        a1, a2, b1, b2 = self.modulus_constants
        celsius = temperature - KELVIN
        if self.temperature_constants:
            b, c = self.temperature_constants
            thermal = -b / (celsius + c) ** 2
        else:
            thermal = np.full_like(celsius, -self.temperature_viscosity)
        modulus = a1 + a2 * celsius + (b1 + b2 * celsius) * pressure
        return np.asarray(thermal - pressure * (a2 + b2 * pressure) / modulus**2)

    @property
    def density_constants(self) -> tuple[float, float]:
        """(a, b) of rho/rho0 = 1 + a p/(1 + b p) [1/Pa]; zeros when incompressible."""
        return self.density_coefficients if self.density_law == "dowson_higginson" else (0.0, 0.0)

    def density_ratio(self, pressure: Array) -> Array:
        """rho/rho0, elementwise."""
        return dowson_higginson_1966(pressure, *self.density_constants)

    def ddensity_ratio_dp(self, pressure: Array) -> Array:
        """d(rho/rho0)/dp [1/Pa], elementwise."""
        a, b = self.density_constants
        return np.asarray(a / (1.0 + b * pressure) ** 2)

    def shear_stress(self, pressure: Array, film: Array, speed_sliding: float) -> Array:
        """Shear stress along the sliding vector [Pa] at the inlet temperature, at most the limiting one."""
        log_viscous = (
            np.log(self.viscosity_inlet)
            + self.log_viscosity_ratio(pressure)
            + np.log(max(speed_sliding, 1e-300))
            - np.log(film)
        )
        law = self.shear_law
        return np.minimum(np.exp(law.log_stress(log_viscous, pressure)[0]), law.limiting_stress(pressure))
