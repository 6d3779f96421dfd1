"""Shear laws: stress over shear rate, pressure and temperature, in SI units.

Every law gives the stress as scale T(x), x = eta rate/scale:

    newtonian   T = x
    eyring      T = asinh x                      scale tau0, constant or over pressure          Ree & Eyring (1955)
    carreau     T = x (1 + x^2)^((n - 1)/2)      scale G                                        Carreau (1972)

and a limiting shear stress tau_L = tau_L0 + Lambda p, which either cuts the traction off, tau = min(tau, tau_L), or is
approached smoothly, tau_L (1 - exp(-tau/tau_L)) (Bair & Winer 1979), and then takes part in the pressure flow as well.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import model_validator

from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel

NEWTONIAN, EYRING, CARREAU = range(3)
LARGE = 20.0  # of ln x: beyond it 1 + x^2 is x^2

Rheology = Literal["newtonian", "eyring", "carreau"]
Limit = Literal["cut", "smooth"]
KINDS: dict[str, int] = {"newtonian": NEWTONIAN, "eyring": EYRING, "carreau": CARREAU}
LOG_STRESS_MAX = 600.0  # of a stress in Pa: sums of more would leave the range of doubles
STRESS_FLOOR = 1e-3  # Pa: keeps the logarithm where the limiting stress Lambda p vanishes


class ShearNumbers(NamedTuple):
    """A shear law for the compiled loops, in scaled variables.

    Stresses are in a reference stress, pressure and film in the solver's units.
    """

    kind: int  # 0 newtonian, 1 eyring, 2 carreau
    plain: bool  # constant stress scale and no limit in the pressure flow: the solvers' short forms serve
    exponent: float  # of Carreau
    low: float  # stress scale: low + rise/2 (1 + tanh(steepness (p/centre - 1)))
    rise: float
    steepness: float
    centre: float
    ambient: float  # limiting stress that takes part in the pressure flow: ambient + slope p; infinite without one
    slope: float
    smooth: bool  # whether there is one
    plug: float  # 6 reference stress/(reference gradient times film unit), of the largest pressure flow


PLAIN = ShearNumbers(NEWTONIAN, True, 1.0, 1.0, 0.0, 1.0, 1.0, math.inf, 0.0, False, math.inf)


class RisingStress(InputModel):
    """Eyring stress that rises with pressure between two levels.

    tau0(p) = low + (te/2) (1 + tanh(Th (2 p/(start + end) - 1))), te = low + slope (end - start),
    Th = slope (end - start)/te: the form published for a 75W-90 axle oil (low 5 MPa, slope 0.035, 0.5 and 3.5 GPa:
    36, 47, 60 MPa at 1, 1.5, 2 GPa). The publication states no dependence of tau0 on temperature.
    """

    stress_low: Annotated[float, ValueRange("Pa", ge=1e4, le=1e9)]
    stress_slope: Annotated[float, ValueRange("", gt=0.0, le=0.5)]
    pressure_start: Annotated[float, ValueRange("Pa", ge=0.0, le=1e10)]
    pressure_end: Annotated[float, ValueRange("Pa", gt=0.0, le=1e11)]

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if not self.pressure_end > self.pressure_start:
            raise InputError("pressure_end", f"{self.pressure_end:.6g} Pa", "above pressure_start")
        return self

    def scaled(self, factor: float) -> RisingStress:
        """All stresses times a factor."""
        return self.model_copy(
            update={"stress_low": factor * self.stress_low, "stress_slope": factor * self.stress_slope}
        )

    @property
    def rise(self) -> float:
        """Height of the step [Pa]."""
        return self.stress_low + self.stress_slope * (self.pressure_end - self.pressure_start)

    @property
    def steepness(self) -> float:
        """Th [-]."""
        return self.stress_slope * (self.pressure_end - self.pressure_start) / self.rise

    @property
    def centre(self) -> float:
        """Pressure in the middle of the step [Pa]."""
        return 0.5 * (self.pressure_start + self.pressure_end)

    def __call__(self, pressure: FloatArray) -> FloatArray:
        """tau0 at a pressure [Pa]."""
        bend = np.tanh(self.steepness * (pressure / self.centre - 1.0))
        return np.asarray(self.stress_low + 0.5 * self.rise * (1.0 + bend))


# pressure at which the rise of `LinearStress` bends [Pa]: 0.3 % below the straight line at 1 GPa, 1.3 % at 2 GPa
BEND = 10e9


@dataclass(frozen=True)
class LinearStress:
    """Eyring stress that rises linearly with pressure, tau0(p) = ambient + slope P tanh(p/P), P = 10 GPa.

    The hyperbolic tangent is the form of `RisingStress`, so that one compiled law serves both.

    ambient: tau0 at ambient pressure [Pa].
    slope: d tau0/dp there [-].
    """

    ambient: Any
    slope: Any

    def scaled(self, factor: float) -> LinearStress:
        """All stresses times a factor."""
        return LinearStress(factor * self.ambient, factor * self.slope)

    @property
    def stress_low(self) -> Any:
        """Lower level of the step, which no pressure reaches [Pa]."""
        return self.ambient - 0.5 * self.rise

    @property
    def rise(self) -> Any:
        """Height of the step [Pa]."""
        return 2.0 * BEND * self.slope

    @property
    def steepness(self) -> float:
        """Pressure of the centre over `BEND` [-]."""
        return self.centre / BEND

    @property
    def centre(self) -> float:
        """Centre of the step, so near zero that it counts as zero [Pa]."""
        return 1.0

    def __call__(self, pressure: Any) -> Any:
        """tau0 at a pressure [Pa]."""
        return self.ambient + self.slope * BEND * np.tanh(pressure / BEND)


PressureStress = RisingStress | LinearStress


def stress_at(stress: Any, pressure: Any) -> Any:
    """tau0 at a pressure [Pa], of a constant or of a law."""
    return stress(pressure) if isinstance(stress, PressureStress) else stress


@dataclass(frozen=True)
class ShearLaw:
    """One shear law with its limiting stress.

    rheology: {"newtonian", "eyring", "carreau"}
    stress: stress scale: tau0 of Ree-Eyring, G of Carreau [Pa]; without meaning for a Newtonian oil.
    exponent: n of Carreau [-].
    limit_slope, limit_ambient: Lambda [-] and tau_L0 [Pa] of tau_L = tau_L0 + Lambda p; infinite Lambda switches the
        limit off.
    limit: {"cut", "smooth"}
    """

    rheology: Rheology = "newtonian"
    stress: float | PressureStress = 5e6
    exponent: float = 1.0
    limit_slope: float = math.inf
    limit_ambient: float = 0.0
    limit: Limit = "cut"

    @property
    def limited(self) -> bool:
        """Whether there is a limiting stress."""
        return math.isfinite(self.limit_slope)

    @property
    def limit_in_flow(self) -> bool:
        """Whether the limit takes part in the pressure flow."""
        return self.limited and self.limit == "smooth"

    @property
    def plain(self) -> bool:
        """Newtonian or Ree-Eyring with constant tau0, and no limit but that of the traction."""
        constant = self.rheology == "newtonian" or (self.rheology == "eyring" and isinstance(self.stress, float))
        return constant and not self.limit_in_flow

    def scale(self, pressure: FloatArray) -> FloatArray:
        """Stress scale at a pressure [Pa]; 1 Pa for a Newtonian oil, where it drops out."""
        if self.rheology == "newtonian":
            return np.ones_like(pressure)
        return np.asarray(stress_at(self.stress, pressure) + np.zeros_like(pressure))

    def reference(self, pressure_hertz: float) -> float:
        """A stress to measure this law's stresses in: its scale at the Hertz pressure, or that itself [Pa]."""
        if self.rheology == "newtonian":
            return pressure_hertz
        return float(self.scale(np.array([pressure_hertz]))[0])

    def limiting_stress(self, pressure: FloatArray) -> FloatArray:
        """tau_L [Pa]; infinite without a limit."""
        if not self.limited:
            return np.full_like(pressure, math.inf)
        return np.asarray(self.limit_ambient + self.limit_slope * np.maximum(pressure, 0.0))

    def log_stress(self, log_viscous: FloatArray, pressure: FloatArray) -> tuple[FloatArray, FloatArray]:
        """ln of the shear stress in Pa and its derivative by ln eta.

        log_viscous: ln of eta |v_s|/h in Pa.
        pressure: [Pa].
        """
        log_scale = np.log(self.scale(pressure))
        log_curve, slope = self._curve(log_viscous - log_scale)
        log_stress = np.minimum(log_scale + log_curve, LOG_STRESS_MAX)
        if not self.limited:
            return np.asarray(log_stress), slope
        log_limit = np.log(np.maximum(self.limiting_stress(pressure), STRESS_FLOOR))
        if self.limit == "cut":
            cut = log_stress > log_limit
            return np.where(cut, log_limit, log_stress), np.where(cut, 0.0, slope)
        ratio = np.exp(np.minimum(log_stress - log_limit, 5.0))
        rest = -np.expm1(-ratio)
        return np.asarray(log_limit + np.log(rest)), np.asarray(slope * ratio * np.exp(-ratio) / rest)

    def _curve(self, log_x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """ln T and d ln T/d ln x."""
        if self.rheology == "newtonian":
            return log_x, np.ones_like(log_x)
        large = log_x > LARGE
        x = np.exp(np.minimum(log_x, LARGE))
        if self.rheology == "carreau":
            share = np.where(large, 1.0, x * x / (1.0 + x * x))
            root = np.where(large, 2.0 * log_x, np.log1p(x * x))
            return np.asarray(log_x - 0.5 * (1.0 - self.exponent) * root), 1.0 - (1.0 - self.exponent) * share
        small = x < 1e-4
        angle = np.where(small, 1.0, np.where(large, log_x + math.log(2.0), np.arcsinh(x)))
        slope = np.where(small, 1.0 - x * x / 3.0, x / np.sqrt(1.0 + x * x) / angle)
        return np.where(small, log_x - x * x / 6.0, np.log(angle)), slope

    def numbers(self, pressure_unit: float, reference: float, film_over_length: float) -> ShearNumbers:
        """The law for the kernels.

        pressure_unit: [Pa].
        reference: reference stress [Pa].
        film_over_length: film unit over the Hertz half-width: the reference gradient of the largest pressure flow is
            `pressure_unit` over the half-width.
        """
        rise, steepness, centre = 0.0, 1.0, pressure_unit
        if self.rheology == "newtonian":
            low = reference
        elif isinstance(self.stress, PressureStress):
            low, rise = self.stress.stress_low, self.stress.rise
            steepness, centre = self.stress.steepness, self.stress.centre
        else:
            low = self.stress
        return ShearNumbers(
            kind=KINDS[self.rheology],
            plain=self.plain,
            exponent=float(self.exponent),
            low=low / reference,
            rise=rise / reference,
            steepness=steepness,
            centre=centre / pressure_unit,
            ambient=self.limit_ambient / reference if self.limit_in_flow else math.inf,
            slope=self.limit_slope * pressure_unit / reference if self.limit_in_flow else 0.0,
            smooth=self.limit_in_flow,
            plug=6.0 * reference / (pressure_unit * film_over_length),
        )
