"""Rough contacts of the tests of the transient engine, and runs of one of them on several meshes."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from contacts import hot_oil, line_contact
from scipy.optimize import brentq

from ehl.common.arrays import FloatArray
from ehl.fluid.lubricant import Lubricant
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.rough import RoughSurfaces
from ehl.rough._kernels.march import MU_FLUID, SHARE
from ehl.rough.accuracy import mesh_length
from ehl.rough.run import TransientRun
from ehl.rough.scaling import Settings, build_problem
from ehl.surface.roughness import generate_profile

STEEL = Material.load("steel")
BOUNDARY_FRICTION = 0.1


@dataclass(frozen=True)
class Scene:
    """One contact with its surfaces."""

    contact: LineContact
    lubricant: Lubricant
    surfaces: RoughSurfaces
    boundary_film: float = 30e-9
    peklenik_number: float = math.inf
    thermal: bool = False

    def run(self, nodes_per_half_width: float, **changes: Any) -> TransientRun:
        """A run that has not moved yet, with other settings."""
        surface = self.boundary_film, BOUNDARY_FRICTION, self.peklenik_number
        settings = Settings(round(nodes_per_half_width * self._length()), *surface, self.thermal, hardness=8e9)
        given = self.contact, self.lubricant, self.surfaces, (STEEL, STEEL), replace(settings, **changes)
        return TransientRun(build_problem(*given))

    def _length(self) -> float:
        return mesh_length(self.contact, self.contact.film_moes(self.lubricant))


def line(speed: float, slide_to_roll: float = 0.5, pressure: float = 1e9) -> LineContact:
    """The test line of the validation."""
    return line_contact(speed_entrainment=speed, slide_to_roll=slide_to_roll, pressure_hertz=pressure)


def eyring_oil(viscosity: float = 0.015, alpha: float = 15e-9, **changes: object) -> Lubricant:
    """Roelands oil with tau0 = 5 MPa at 100 degC."""
    return hot_oil(viscosity_inlet=viscosity, pressure_viscosity=alpha, **changes)


def gaussian_pair(
    contact: LineContact, rms: float, correlation: float, seed: int = 1, length: float = 32.0
) -> RoughSurfaces:
    """Two independent Gaussian surfaces of composite Rq ``rms``; correlation and period in half-widths."""
    b = contact.half_width
    each = rms / math.sqrt(2.0)
    period = max(length, 60.0 * correlation) * b
    one, two = (generate_profile(each, correlation * b, period, correlation * b / 20.0, 2 * seed + i) for i in (1, 2))
    return RoughSurfaces(one, two)


def speed_of_film_ratio(ratio: float, rms: float, lubricant: Lubricant, **contact: float) -> float:
    """Entrainment speed at which the film estimate is ``ratio`` times the roughness [m/s]."""
    films = lambda log: line(math.exp(log), **contact).film_moes(lubricant) / rms - ratio  # noqa: E731
    return math.exp(brentq(films, math.log(1e-8), math.log(1e4), xtol=1e-13))


def friction(records: FloatArray) -> FloatArray:
    """mu of every step."""
    return np.asarray(records[:, MU_FLUID] + BOUNDARY_FRICTION * records[:, SHARE])
