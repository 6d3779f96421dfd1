"""Dimensionless outputs of one converged level: films, pressures, friction."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.fluid.rheology import ShearLaw, ShearNumbers
from ehl.smooth import _kernels
from ehl.smooth.newton import Level

FRICTION_INLET = 100.0  # start of the integral of the shear, in lengths of the loaded zone upstream


@dataclass(frozen=True)
class FilmShear:
    """Film shear in units of p_h, from ln(eta/eta0), film H and pressure P."""

    law: ShearLaw  # stress over rate [Pa]
    pressure_hertz: float  # [Pa]
    rate: float  # eta0 |v_s| R/(p_h b^2)

    @cached_property
    def numbers(self) -> tuple[ShearNumbers, float, float]:
        """Shear law for the compiled kernels, and ambient value [p_h] and slope of a limit that cuts the stress off."""
        slope = self.law.limit_slope if self.law.limited and self.law.limit == "cut" else math.inf
        unit = self.pressure_hertz
        return self.law.numbers(unit, unit, 1.0), self.law.limit_ambient / unit, slope

    def stress_at(self, log_eta: FloatArray, film: FloatArray, pressure: FloatArray) -> FloatArray:
        """Shear stress at the nodes."""
        if self.rate == 0.0:
            return np.zeros(film.size)
        log_viscous = math.log(self.rate * self.pressure_hertz) + log_eta - np.log(film)
        p = np.maximum(pressure, 0.0) * self.pressure_hertz
        stress = np.minimum(np.exp(self.law.log_stress(log_viscous, p)[0]), self.law.limiting_stress(p))
        return np.asarray(stress / self.pressure_hertz)


@dataclass(frozen=True)
class Numbers:
    """Dimensionless outputs of one level, or their errors."""

    film_central: float
    film_min: float
    friction: float
    pressure_max: float
    flow: float
    exit: float
    rolling: float

    def as_array(self) -> FloatArray:
        """Outputs as an array, in this order."""
        values = (self.film_central, self.film_min, self.friction, self.pressure_max, self.flow, self.exit)
        return np.array([*values, self.rolling])


def numbers_of(level: Level, shear: FilmShear) -> Numbers:
    """Outputs of a level; mu = (2/pi) integral of the shear stress from the friction inlet to the exit."""
    law, ambient, slope = shear.numbers
    return Numbers(
        *_kernels.outputs(
            level.x, level.unknowns.pressure, level.film, level.log_eta, level.unknowns.flow, level.scaled.lam,
            friction_inlet(level), shear.rate, law, ambient, slope,
        )
    )  # fmt: skip


def friction_inlet(level: Level) -> float:
    """Start of the integrals of the shear, in half-widths."""
    return -FRICTION_INLET * level.grid.grading.size
