"""Dimensionless groups of a rough, heated line contact, in which friction varies more smoothly than in its inputs.

Each is a function of `Conditions` by ufuncs, so that `regression.export` records it, and is greater than 0.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ehl.surface.roughness import EP_FILM, TIP_LENGTH
from regression.friction.conditions import Array, Conditions

MIN_ROUGHNESS = 1e-12  # [m]
_LEAST_ACROSS = 0.01  # no friction differs between less sliding across the line and none


def boundary_film(c: Conditions) -> Array:
    """h_b = 30 nm + (2.1 nm Rq)^1/2, the default rule of `ehl.surface.roughness.boundary_film` [m]."""
    return np.asarray(EP_FILM + np.sqrt(TIP_LENGTH * _rough(c)))


def flattening(c: Conditions) -> Array:
    """P = p_h lc/(0.5 E' Rq): the pressure over the one that flattens the roughness."""
    return np.asarray(c["pressure_hertz"] * c["correlation_length"] / (0.5 * c["effective_modulus"] * _rough(c)))


def _rough(c: Conditions) -> Array:
    return np.maximum(c["roughness_rms"], MIN_ROUGHNESS)


GROUPS: dict[str, Callable[[Conditions], Array]] = {
    "film_over_boundary_film": lambda c: c["film_formula"] / boundary_film(c),
    "flattening": flattening,
    "correlation_over_width": lambda c: c["correlation_length"] / c["half_width"],
    "pressure_over_modulus": lambda c: c["pressure_hertz"] / c["effective_modulus"],
    "viscosity_exponent": lambda c: c["pressure_viscosity"] * c["pressure_hertz"],
    "shear_over_eyring": lambda c: c["viscosity_inlet"] * c["speed_sliding"] / (c["eyring_stress"] * _rough(c)),
    # rise of the surfaces by the Eyring stress, times the temperature coefficient of viscosity and their effusivity
    "flash": lambda c: (
        c["temperature_viscosity"]
        * c["eyring_stress"]
        * c["speed_sliding"]
        * np.sqrt(c["half_width"] / np.abs(c["speed_entrainment"]))
    ),
    "slide_across": lambda c: _LEAST_ACROSS + np.abs(c["slide_to_roll"]),
}
