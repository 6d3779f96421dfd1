"""The lubricant: the numbers a solver needs at one inlet temperature, and the laws they stand for.

`Lubricant` composes the laws of `ehl.fluid.viscosity`, `ehl.fluid.density` and `ehl.fluid.rheology`; `Oil` is a card of
`data/oils/` that gives a `Lubricant` at any temperature.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ehl.fluid.density import DOWSON_HIGGINSON, dowson_higginson_1966, dowson_higginson_slope
from ehl.fluid.rheology import Limit, Rheology, RisingStress, ShearLaw
from ehl.fluid.viscosity import BarusLaw, ModulusLaw, PressureLaw, RoelandsLaw

Array = NDArray[np.float64]

ViscosityLaw = Literal["barus", "roelands", "modulus"]
DensityLaw = Literal["incompressible", "dowson_higginson"]


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
    limiting_shear_coefficient : float
        Lambda in tau <= tau_L0 + Lambda p [-]; infinity switches the limit off.
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
    carreau_stress : float
        G in eta_effective = eta (1 + (eta rate/G)^2)^((n - 1)/2) [Pa]; needed by Carreau only.
    carreau_exponent : float
        n [-]; 1 is Newtonian.
    limiting_shear_ambient : float
        tau_L0 [Pa].
    limiting_shear : {"cut", "smooth"}
        Whether the limit only cuts off the traction, or is approached smoothly and acts on the pressure flow as well.

    Examples
    --------
    >>> oil = Oil.load("75w90").at(373.15)
    >>> f"{1e3 * oil.viscosity_inlet:.2f} mPa s, {1e9 * oil.pressure_viscosity:.2f} 1/GPa"
    '10.60 mPa s, 9.68 1/GPa'
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
    def pressure_law(self) -> PressureLaw:
        """ln(eta(p, T)/eta0), with its derivatives."""
        if self.viscosity_law == "barus":
            return BarusLaw(self.pressure_viscosity, self.temperature, self.temperature_viscosity)
        if self.viscosity_law == "roelands":
            return RoelandsLaw(
                self.viscosity_inlet, self.pressure_viscosity, self.temperature, self.temperature_viscosity
            )
        return ModulusLaw(
            self.modulus_constants, self.temperature, self.temperature_constants, self.temperature_viscosity
        )

    def log_viscosity_ratio(self, pressure: Array) -> Array:
        """ln(eta/eta0) at the inlet temperature, elementwise."""
        return self.pressure_law.log_ratio(pressure)

    def dlog_viscosity_dp(self, pressure: Array) -> Array:
        """d ln eta/dp [1/Pa] at the inlet temperature, elementwise."""
        return self.pressure_law.by_pressure(pressure)

    def viscosity(self, pressure: Array) -> Array:
        """eta(p) [Pa s] at the inlet temperature; beyond the range of doubles it is held at 1e300 Pa s."""
        exponent = np.log(self.viscosity_inlet) + self.log_viscosity_ratio(pressure)
        return np.asarray(np.exp(np.minimum(exponent, 690.0)))

    def log_viscosity(self, pressure: Array, temperature: Array) -> Array:
        """ln eta(p, T) with eta in Pa s, elementwise; `temperature` in K."""
        return np.asarray(np.log(self.viscosity_inlet) + self.pressure_law.log_ratio(pressure, temperature))

    def dlog_viscosity_dtemperature(self, pressure: Array, temperature: Array) -> Array:
        """d ln eta/dT [1/K] at (p, T), elementwise; the derivative of `log_viscosity`."""
        return self.pressure_law.by_temperature(pressure, temperature)

    @property
    def density_constants(self) -> tuple[float, float]:
        """(a, b) of rho/rho0 = 1 + a p/(1 + b p) [1/Pa]; zeros when incompressible."""
        return self.density_coefficients if self.density_law == "dowson_higginson" else (0.0, 0.0)

    def density_ratio(self, pressure: Array) -> Array:
        """rho/rho0, elementwise."""
        return dowson_higginson_1966(pressure, *self.density_constants)

    def ddensity_ratio_dp(self, pressure: Array) -> Array:
        """d(rho/rho0)/dp [1/Pa], elementwise."""
        return dowson_higginson_slope(pressure, *self.density_constants)

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
