"""Friction with the film of a solution held: what the oil's figures do to it without another solution.

Pressure, temperature and shape of the film stay those of the solution; its thickness follows the formula of Moes
(1992), its shear stress the shear law with the new figures. Exact but for what the friction does to film and
temperature, and it sees at once where a limiting stress begins to act.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ehl.fluid.lubricant import Lubricant
from ehl.line_contact import LineContact
from ehl.result import ContactResult

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FrozenFilm:
    """A solved film, as its shear stress needs it.

    Parameters
    ----------
    pressure : ndarray, shape (m,)
        [Pa].
    log_rest : ndarray, shape (m,)
        ln of v_s/h times the change of viscosity with temperature [1/s].
    weight : ndarray, shape (m,)
        Length of each node over the load per length [m^2/N]: friction is the sum of weight times stress.
    log_film : float
        ln of the film of Moes of the solution.
    """

    pressure: Array
    log_shear_rate: Array
    weight: Array
    log_film: float

    def friction_and_film(self, contact: LineContact, lubricant: Lubricant) -> tuple[float, float]:
        """ln of the friction coefficient and ln of the film of Moes [m] with another lubricant."""
        film = log_moes_film(contact, lubricant)
        log_viscosity = math.log(lubricant.viscosity_inlet) + lubricant.log_viscosity_ratio(self.pressure)
        law = lubricant.shear_law
        stress = np.exp(law.log_stress(log_viscosity + self.log_shear_rate - (film - self.log_film), self.pressure)[0])
        friction = float(self.weight @ np.minimum(stress, law.limiting_stress(self.pressure)))
        return math.log(max(friction, 1e-300)), film


def log_moes_film(contact: LineContact, lubricant: Lubricant) -> float:
    """ln of the central film of Moes (1992) [m]."""
    return math.log(contact.film_moes(lubricant))


def frozen_film(result: ContactResult, contact: LineContact, lubricant: Lubricant) -> FrozenFilm | None:
    """The film of a smooth, steady solution; None where there is none, or no sliding."""
    if result.status == "failed" or result.transient is not None or result.film is None or contact.speed_sliding == 0.0:
        return None
    film = result.film
    x, pressure = film.x, np.maximum(film.pressure, 0.0)
    inside = pressure > 1e-3 * pressure.max()
    hotter = np.zeros_like(x) if result.heat is None else np.interp(x, result.heat.x, result.heat.log_viscosity_offset)
    rest = np.log(contact.speed_sliding / film.film) + hotter
    weight = np.gradient(x) / contact.load_per_length
    return FrozenFilm(pressure[inside], rest[inside], weight[inside], log_moes_film(contact, lubricant))
