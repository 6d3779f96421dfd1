"""Families that are linear in ln mu: Xu et al. (2007), powers of the six variables, and powers for each film regime.

Li & Kahraman give one power product of dimensionless groups for each regime of the film ratio. Their coefficients were
not available; those of `regimes` are fitted. The exponents are linear in ln lambda between knots, so that ln mu is
continuous with a kink at each knot.
"""

import itertools

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


_XU_TERMS = ("b1", "b2", "b3", "b4", "b5", "b6", "b7", "b8", "b9")
_POWER_TERMS = ("constant", "pressure", "radius", "speed", "sliding", "viscosity", "roughness")

XU = Family(
    "xu",
    "nine terms of Xu, Kahraman, Anderson & Maddock (2007), refitted",
    "mu = exp(b1 + b4 |SR| P lg n + b5 exp(-|SR| P lg n) + b9 exp(S)) P^b2 |SR|^b3 u^b6 n^b7 R^b8"
    " with P = p_h in GPa, SR = |v_s|/u, u = u_r in m/s, n = eta0 in mPa s, R in m, S = Rq in um, lg = log10",
    _XU_TERMS,
    BOX,
    _xu_design,
)

POWER_LAW = Family(
    "power_law",
    "powers of the six variables",
    "mu = exp(constant) P^pressure R^radius u^speed |SR|^sliding n^viscosity S^roughness"
    " with P = p_h in GPa, R in m, u = u_r in m/s, SR = |v_s|/u, n = eta0 in mPa s, S = Rq in um",
    _POWER_TERMS,
    BOX,
    _power_design,
)

KNOTS = (0.1, 0.5, 1.0, 2.0)
_MIN_SLIDING = 1e-12


def _groups(c: Conditions) -> dict[str, Array]:
    """Logarithms of the dimensionless groups."""
    speed = np.abs(c["speed_entrainment"])
    return {
        "constant": 0.0 * speed + 1.0,
        "film": np.log(np.minimum(c["film_ratio_formula"], 1e6)),
        "pressure": np.log(c["pressure_hertz"] / c["effective_modulus"]) + 5.0,
        "viscosity": np.log(np.maximum(np.log(c["viscosity_mean_pressure"] / c["viscosity_inlet"]), 1e-3)),
        "speed": np.log(c["viscosity_inlet"] * speed / (c["effective_modulus"] * c["radius_equivalent"])) + 25.0,
        "sliding": np.log(np.maximum(c["slide_to_roll_total"], _MIN_SLIDING)),
        "heat": np.log(c["viscosity_inlet"] * c["temperature_viscosity"] * speed**2 / c["thermal_conductivity"]),
        "flattening": np.log(c["pressure_hertz"] * c["correlation_length"] / c["effective_modulus"])
        - np.log(np.maximum(c["roughness_rms"], 1e-12)),
    }


GROUPS = ("constant", "film", "pressure", "viscosity", "speed", "sliding", "heat", "flattening")
_TERMS = (
    "constant",
    *(f"{group}_{knot:g}" for knot in KNOTS for group in GROUPS if (group, knot) != ("constant", KNOTS[0])),
)


def hats(film_ratio: Array) -> list[Array]:
    """Weight of each regime: 1 at its knot, 0 at the neighbouring ones, linear in ln lambda; the sum is 1."""
    place = np.log(np.maximum(film_ratio, 1e-12))
    knots = np.log(KNOTS)
    # rise[i] increases from 0 at knot i to 1 at knot i + 1
    rise = [
        np.minimum(np.maximum((place - low) / (high - low), 0.0), 1.0)
        for low, high in zip(knots[:-1].tolist(), knots[1:].tolist(), strict=True)
    ]
    return [1.0 - rise[0], *(before - after for before, after in itertools.pairwise(rise)), rise[-1]]


def _design(c: Conditions) -> Array:
    groups, shares = _groups(c), hats(c["film_ratio_formula"])
    columns = [
        groups[group] if (group, knot) == ("constant", KNOTS[0]) else share * groups[group]
        for knot, share in zip(KNOTS, shares, strict=True)
        for group in GROUPS
    ]
    return np.column_stack(columns)


REGIMES = Family(
    "regimes",
    "powers of dimensionless groups, one set for each regime of lambda, in the manner of Li & Kahraman",
    "ln mu = constant + sum over the knots K = 0.1, 0.5, 1, 2 of w_K (constant_K + film_K ln l"
    " + pressure_K (ln(p_h/E') + 5) + viscosity_K ln ln(eta_p/eta0) + speed_K (ln(eta0 u_r/(E' R)) + 25)"
    " + sliding_K ln SR + heat_K ln(eta0 beta u_r^2/k) + flattening_K ln(p_h lc/(E' Rq))), without constant_0.1;"
    " l = h0/Rq with h0 the film of Moes (1992) over the density ratio of Dowson & Higginson at p_h, eta_p the"
    " viscosity at pi p_h/4, SR = |v_s|/u_r, lc the correlation length; w_K is 1 at l = K, 0 at the next knots, linear"
    " in ln l, and constant beyond the outer ones",
    _TERMS,
    (*BOX, "correlation_length"),
    _design,
)
