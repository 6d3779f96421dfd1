"""Families that are linear in ln mu: the nine terms of Xu et al. (2007) and powers of the six variables."""

from collections.abc import Callable, Mapping

import numpy as np

from regression.friction.conditions import Array, Conditions
from regression.friction.families.family import BOX, Family


def _xu_design(c: Conditions) -> Array:
    """Columns in the order of the published b1..b9: P in GPa, n0 in mPa s, S in um, others in SI units."""
    pressure, sliding = c["pressure_hertz"] * 1e-9, c["slide_to_roll_total"]
    viscosity = c["viscosity_inlet"] * 1e3
    group = sliding * pressure * np.log10(viscosity)
    return np.column_stack(
        [
            np.ones_like(pressure),
            np.log(pressure),
            np.log(sliding),
            group,
            np.exp(-group),
            np.log(c["speed_entrainment"]),
            np.log(viscosity),
            np.log(c["radius_equivalent"]),
            np.exp(c["roughness_rms"] * 1e6),
        ]
    )


def _power_design(c: Conditions) -> Array:
    rough = np.log(np.maximum(c["roughness_rms"] * 1e6, 1e-6))
    names = ("radius_equivalent", "speed_entrainment", "slide_to_roll_total")
    pressure, viscosity = np.log(c["pressure_hertz"] * 1e-9), np.log(c["viscosity_inlet"] * 1e3)
    return np.column_stack([np.ones_like(rough), pressure, *(np.log(c[name]) for name in names), viscosity, rough])


def _linear(
    design: Callable[[Conditions], Array], terms: tuple[str, ...]
) -> Callable[[Conditions, Mapping[str, float], float], Array]:
    def log_mu(c: Conditions, coefficients: Mapping[str, float], boundary_friction: float) -> Array:
        return np.asarray(design(c) @ np.array([coefficients[term] for term in terms]))

    return log_mu


_XU_TERMS = ("b1", "b2", "b3", "b4", "b5", "b6", "b7", "b8", "b9")
_POWER_TERMS = ("constant", "pressure", "radius", "speed", "sliding", "viscosity", "roughness")

XU = Family(
    "xu",
    "nine terms of Xu, Kahraman, Anderson & Maddock (2007), refitted",
    "mu = exp(b1 + b4 |SR| P lg n + b5 exp(-|SR| P lg n) + b9 exp(S)) P^b2 |SR|^b3 u^b6 n^b7 R^b8"
    " with P = p_h in GPa, SR = |v_s|/u, u = u_r in m/s, n = eta0 in mPa s, R in m, S = Rq in um, lg = log10",
    _XU_TERMS,
    BOX,
    _linear(_xu_design, _XU_TERMS),
    _xu_design,
)

POWER_LAW = Family(
    "power_law",
    "powers of the six variables",
    "mu = exp(constant) P^pressure R^radius u^speed |SR|^sliding n^viscosity S^roughness"
    " with P = p_h in GPa, R in m, u = u_r in m/s, SR = |v_s|/u, n = eta0 in mPa s, S = Rq in um",
    _POWER_TERMS,
    BOX,
    _linear(_power_design, _POWER_TERMS),
    _power_design,
)
