"""`Lubricant`: properties and laws of an oil at one inlet temperature; conductivity of the film under pressure.

It combines the laws of `ehl.fluid.viscosity`, `ehl.fluid.density` and `ehl.fluid.rheology`. `Oil.at` gives a
`Lubricant` at any temperature.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Self

import numpy as np
from pydantic import model_validator

from ehl.common.arrays import FloatArray, Values
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel
from ehl.fluid import viscosity as laws
from ehl.fluid.density import DOWSON_HIGGINSON_LAW, Compression
from ehl.fluid.pressure_viscosity import alpha_of
from ehl.fluid.rheology import Limit, PressureStress, Rheology, ShearLaw

PerPressure = Annotated[float, ValueRange("1/Pa", ge=0.0, le=1e-8)]


class FilmConductivity(InputModel):
    """k/k0 = 1 + c1 p/(1 + c2 p), measured up to 1.1 GPa and extrapolated above; zeros give the ambient value.

    Larsson, R., Larsson, P. O., Eriksson, E., Sjöberg, M. & Höglund, E. (2000), Proc. IMechE J 214; form and constants
    read in public codes that cite the paper, not in the paper itself. Files may name a family of oils instead.

    c1, c2: constants [1/Pa].
    """

    c1: PerPressure
    c2: PerPressure

    @model_validator(mode="before")
    @classmethod
    def _of_a_family(cls, values: Any) -> Any:
        if not isinstance(values, str):
            return values
        if values not in CONDUCTIVITY_FAMILIES:
            allowed = "one of " + ", ".join(CONDUCTIVITY_FAMILIES) + "; or a table with c1 and c2"
            raise InputError("", values, allowed)
        return CONDUCTIVITY_FAMILIES[values].model_dump()

    def __call__(self, pressure: Values, ambient: Any) -> Values:
        """Conductivity [W/(m K)] at pressure [Pa], from its value at ambient pressure."""
        found: Values = ambient * (1.0 + self.c1 * pressure / (1.0 + self.c2 * pressure))
        return found


PAO = FilmConductivity(c1=1.40e-9, c2=0.34e-9)
PARAFFINIC = FilmConductivity(c1=1.72e-9, c2=0.54e-9)
CONDUCTIVITY_FAMILIES = {"pao": PAO, "mineral": PARAFFINIC}
# default by base oil, for oils without their own law; a polyalphaolefin and a paraffinic oil were measured
CONDUCTIVITY_OF_BASE = {"mineral": PARAFFINIC, "hydrocracked": PARAFFINIC, "pao": PAO, "ester": PAO, "polyglycol": PAO}
ASSUMED_CONDUCTIVITY = (
    "the conductivity of the film is assumed to increase with pressure as that of a polyalphaolefin (twofold at 1 GPa);"
    " conductivity_pressure selects another law"
)


@dataclass(frozen=True)
class Lubricant:
    """A lubricant at one inlet temperature.

    Parameters
    ----------
    viscosity_inlet : float
        eta0, dynamic viscosity at ambient pressure and inlet temperature [Pa s].
    pressure_viscosity : float
        alpha = d ln eta/dp at p = 0 [1/Pa], before `pressure_rise_factor`.
    viscosity_law : str
        Pressure dependence: "barus", "roelands", "modulus" or the name of `absolute_law`.
    modulus_constants : tuple of float
        (a1 [Pa], a2 [Pa/K], b1 [-], b2 [1/K]) of ln(eta/eta0) = p/(a1 + a2 T + (b1 + b2 T) p), T in degC, for the
        modulus law.
    compression : Compression
        rho/rho0 over pressure at the inlet temperature; default: that of Dowson & Higginson.
    rheology : {"newtonian", "eyring", "carreau"}
        Shear law.
    eyring_stress : float, LinearStress or RisingStress
        tau0 [Pa], constant or increasing with pressure.
    limiting_shear_coefficient : float
        Lambda in tau <= tau_L0 + Lambda p [-]; infinity switches the limit off.
    temperature : float
        Inlet temperature [K].
    temperature_viscosity : float
        beta = -d ln eta0/dT at the inlet temperature [1/K].
    temperature_constants : tuple of float
        (B [K], C [K]) of eta0(T) = K exp(B/(T + C)), T in degC, for an oil with this law; else empty.
    density : float
        rho0 at ambient pressure and inlet temperature [kg/m3].
    thermal_conductivity : float
        Thermal conductivity at ambient pressure [W/(m K)].
    heat_capacity : float
        Specific heat capacity [J/(kg K)].
    extrapolated : float
        Difference of ln eta0 from its tangent over 1/T at the end of the measured temperatures [-]; 0 within them.
    carreau_stress : float
        G in eta_effective = eta (1 + (eta rate/G)^2)^((n - 1)/2) [Pa], for Carreau.
    carreau_exponent : float
        n [-]; 1 is Newtonian.
    limiting_shear_ambient : float
        tau_L0 [Pa].
    limiting_shear : {"cut", "smooth"}
        "cut" limits the traction only; "smooth" approaches the limit smoothly and affects the pressure flow as well.
    absolute_law : AbsoluteLaw
        A law of eta by its constants, instead of those above.
    absolute_scale : float
        Factor on ln(eta(p, T)/eta(0, T)) of `absolute_law` [-], contained in `pressure_viscosity`.
    pressure_rise_factor : float
        Factor on ln(eta(p, T)/eta(0, T)) of any law [-], for its uncertainty.
    pressure_valid : float
        Highest measured pressure of the law [Pa]; infinity if unknown.
    shear_modulus : float
        G of the film for the elastic part of its shear rate [Pa]; infinity switches the elastic part off, including
        that of the bodies.
    film_conductivity : FilmConductivity
        Increase of `thermal_conductivity` with pressure; default: that of a polyalphaolefin.

    Examples
    --------
    >>> oil = Oil.load("75w90").at(373.15)
    >>> f"{1e3 * oil.viscosity_inlet:.2f} mPa s, {1e9 * oil.pressure_viscosity:.2f} 1/GPa"
    '10.60 mPa s, 12.02 1/GPa'
    """

    viscosity_inlet: float
    pressure_viscosity: float
    viscosity_law: str = "roelands"
    modulus_constants: tuple[float, ...] = ()
    compression: Compression = DOWSON_HIGGINSON_LAW
    rheology: Rheology = "newtonian"
    eyring_stress: float | PressureStress = 5e6
    limiting_shear_coefficient: float = math.inf
    temperature: float = 353.15
    temperature_viscosity: float = 0.03
    temperature_constants: tuple[float, ...] = ()
    density: float = 850.0
    thermal_conductivity: float = 0.14
    heat_capacity: float = 2000.0
    extrapolated: float = 0.0
    carreau_stress: float = math.nan
    carreau_exponent: float = math.nan
    limiting_shear_ambient: float = 0.0
    limiting_shear: Limit = "cut"
    absolute_law: laws.AbsoluteLaw | None = None
    absolute_scale: float = 1.0
    pressure_rise_factor: float = 1.0
    pressure_valid: float = math.inf
    shear_modulus: float = math.inf
    film_conductivity: FilmConductivity = field(default_factory=lambda: PAO)
    # precomputed for an oil; dataclasses.replace resets it, as the law may change
    _alpha_film: Any = field(init=False, default=None, repr=False, compare=False)

    def with_alpha_film(self, alpha_film: Any) -> Self:
        """This lubricant with a precomputed coefficient of film formulas [1/Pa]."""
        object.__setattr__(self, "_alpha_film", alpha_film)
        return self

    @property
    def pressure_viscosity_film(self) -> Any:
        """alpha_film, the coefficient for Newtonian film formulas [1/Pa] (`ehl.fluid.pressure_viscosity`)."""
        return alpha_of(self.pressure_law, "film") if self._alpha_film is None else self._alpha_film

    def referred_to(self, temperature: float) -> Lubricant:
        """The same oil with another reference temperature [K] and the same function eta(p, T).

        Density, conductivity and shear law remain those of the inlet temperature.
        """
        law, ambient, there = self.pressure_law, np.zeros(1), np.array([temperature])
        viscosity = float(np.exp(self.log_viscosity(ambient, there))[0])
        beta = -float(law.by_temperature(ambient, there)[0])
        moved = replace(self, temperature=temperature, viscosity_inlet=viscosity, temperature_viscosity=beta)
        if self.viscosity_law == "roelands":  # the same exponent z = alpha p0/A at another height A
            heights = [math.log(eta) + laws.ROELANDS_LOG_VISCOSITY for eta in (viscosity, self.viscosity_inlet)]
            moved = replace(moved, pressure_viscosity=self.pressure_viscosity * heights[0] / heights[1])
        return moved

    def continuation_difference(self, pressure: float) -> float:
        """Relative difference of ln(eta/eta0) on the tangent at `pressure_valid` from the law [-].

        A measure of the uncertainty of the extrapolated law at a higher pressure [Pa]; 0 up to `pressure_valid`.
        """
        if not pressure > self.pressure_valid:
            return 0.0
        law, end = self.pressure_law, np.array([self.pressure_valid])
        tangent = law.log_ratio(end) + law.by_pressure(end) * (pressure - end)
        return float((tangent / law.log_ratio(np.array([pressure])))[0]) - 1.0

    @property
    def alpha(self) -> float:
        """d ln eta/dp at p = 0 [1/Pa], with `pressure_rise_factor`."""
        return self.pressure_rise_factor * self.pressure_viscosity

    @property
    def shear_law(self) -> ShearLaw:
        """Shear stress over shear rate, with its limit."""
        carreau = self.rheology == "carreau"
        stress, exponent = (self.carreau_stress, self.carreau_exponent) if carreau else (self.eyring_stress, 1.0)
        limit = (self.limiting_shear_coefficient, self.limiting_shear_ambient, self.limiting_shear)
        return ShearLaw(self.rheology, stress, exponent, *limit)

    @property
    def pressure_law(self) -> laws.PressureLaw:
        """ln(eta(p, T)/eta0), with its derivatives."""
        law: laws.BarusLaw | laws.RoelandsLaw | laws.ModulusLaw | laws.RelativeLaw
        temperature, beta, scale = self.temperature, self.temperature_viscosity, self.pressure_rise_factor
        if self.absolute_law is not None:
            law, scale = laws.RelativeLaw(self.absolute_law, temperature), self.absolute_scale * scale
        elif self.viscosity_law == "barus":
            law = laws.BarusLaw(self.pressure_viscosity, temperature, beta)
        elif self.viscosity_law == "roelands":
            law = laws.RoelandsLaw(self.viscosity_inlet, self.pressure_viscosity, temperature, beta)
        else:
            law = laws.ModulusLaw(self.modulus_constants, temperature, self.temperature_constants, beta)
        return law if scale == 1.0 else laws.ScaledRise(law, scale)

    def log_viscosity_ratio(self, pressure: FloatArray) -> FloatArray:
        """ln(eta/eta0) at the inlet temperature, elementwise."""
        return self.pressure_law.log_ratio(pressure)

    def viscosity(self, pressure: FloatArray) -> FloatArray:
        """eta(p) [Pa s] at the inlet temperature, at most 1e300 Pa s."""
        exponent = np.log(self.viscosity_inlet) + self.log_viscosity_ratio(pressure)
        return np.asarray(np.exp(np.minimum(exponent, 690.0)))

    def log_viscosity(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """ln eta(p, T) with eta in Pa s, elementwise; `temperature` in K."""
        return np.asarray(np.log(self.viscosity_inlet) + self.pressure_law.log_ratio(pressure, temperature))

    def dlog_viscosity_dtemperature(self, pressure: FloatArray, temperature: FloatArray) -> FloatArray:
        """d ln eta/dT [1/K] at (p, T), elementwise; the derivative of `log_viscosity`."""
        return self.pressure_law.by_temperature(pressure, temperature)

    def references(self) -> set[str]:
        """Uses of `data/references.toml`: laws of viscosity, density and shear."""
        density = type(self.compression).__name__
        return {f"viscosity:{self.viscosity_law}", f"density:{density}", f"shear:{self.rheology}"}

    def density_ratio(self, pressure: FloatArray) -> FloatArray:
        """rho/rho0, elementwise."""
        return self.compression.ratio(pressure)

    def shear_stress(self, pressure: FloatArray, film: FloatArray, speed_sliding: float) -> FloatArray:
        """Shear stress along the sliding vector [Pa] at the inlet temperature, at most the limiting one."""
        log_rate = np.log(max(speed_sliding, 1e-300)) - np.log(film)
        log_viscous = np.log(self.viscosity_inlet) + self.log_viscosity_ratio(pressure) + log_rate
        law = self.shear_law
        return np.minimum(np.exp(law.log_stress(log_viscous, pressure)[0]), law.limiting_stress(pressure))
