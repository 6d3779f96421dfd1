"""Rough contacts of the tests of the transient engine, and runs of one of them on several meshes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ehl.fluid.lubricant import Lubricant
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.rough import RoughSurfaces
from ehl.rough._kernels.march import MU_FLUID, SHARE
from ehl.rough.accuracy import mesh_length
from ehl.rough.averaging import Window
from ehl.rough.run import TransientRun
from ehl.rough.scaling import Settings, build_problem
from ehl.surface.roughness import generate_profile

Array = NDArray[np.float64]

STEEL = Material.load("steel")
MODULUS = 228e9
RADIUS = 0.015
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

    @property
    def film_ratio(self) -> float:
        """lambda by Moes's formula."""
        return self.contact.film_moes(self.lubricant) / self.surfaces.rms if self.surfaces.rms else math.inf

    def run(self, nodes_per_half_width: float, start_travel: float = 0.0) -> TransientRun:
        """A run that has not moved yet."""
        problem = build_problem(
            self.contact,
            self.lubricant,
            self.surfaces,
            (STEEL, STEEL),
            Settings(
                nodes=round(nodes_per_half_width * self._length()),
                boundary_film=self.boundary_film,
                boundary_friction=BOUNDARY_FRICTION,
                peklenik_number=self.peklenik_number,
                thermal=self.thermal,
                hardness=8e9,
                start_travel=start_travel,
            ),
        )
        return TransientRun(problem)

    def _length(self) -> float:
        return mesh_length(self.contact, self.contact.film_moes(self.lubricant))


def line(speed: float, slide_to_roll: float = 0.5, pressure: float = 1e9, radius: float = RADIUS) -> LineContact:
    """The test line of the validation."""
    return LineContact.from_pressure(
        radius_equivalent=radius,
        effective_modulus=MODULUS,
        pressure_hertz=pressure,
        speed_entrainment=speed,
        slide_to_roll=slide_to_roll,
    )


def eyring_oil(viscosity: float = 0.015, alpha: float = 15e-9, **changes: object) -> Lubricant:
    """Roelands oil with tau0 = 5 MPa at 100 degC."""
    values = {"rheology": "eyring", "eyring_stress": 5e6, "temperature": 373.15, "temperature_viscosity": 0.04}
    return Lubricant(viscosity, alpha, **(values | changes))  # type: ignore[arg-type]


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
    low, high = 1e-8, 1e4
    for _ in range(80):
        middle = math.sqrt(low * high)
        if line(middle, **contact).film_moes(lubricant) < ratio * rms:
            low = middle
        else:
            high = middle
    return math.sqrt(low * high)


def family(scene: Scene, meshes: Sequence[float], startup: float, window: float, settling: float = 0.5) -> list[Window]:
    """The same travel of the same surfaces on several meshes (nodes per b), all started from the first one's state."""
    first = Window(scene.run(meshes[0]))
    first.start(startup)
    windows = [first]
    for mesh in meshes[1:]:
        finer = Window(scene.run(mesh, start_travel=first.run.travel))
        finer.run.start_from(first.run)
        windows.append(finer)
    for member in windows:
        member.start(settling)
        member.roll(window)
    return windows


def friction(records: Array) -> Array:
    """mu of every step."""
    return np.asarray(records[:, MU_FLUID] + BOUNDARY_FRICTION * records[:, SHARE])
