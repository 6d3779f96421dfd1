"""Families of friction formulas: what each computes from the local conditions and its coefficients.

Two are linear in ln mu (`xu`, `power_law`), one is nonlinear (`load_share`). All take slide_to_roll_total and
speed_sliding, the length of the whole sliding vector: mu does not depend on the sign of the sliding.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import erfc

from ehl.errors import InputError
from regression.conditions import Array, Conditions

# steel: sqrt(46 W/(m K) * 7830 kg/m3 * 465 J/(kg K)); only scales the coefficient heat_flash
EFFUSIVITY = 12941.4
_CAP_ORDER = 8.0
# free in trials with our solver it came out at 0.7 to 0.8 and could not be told from the heat coefficients
HEAT_POWER = 0.75


@dataclass(frozen=True)
class Family:
    """One form of the friction formula.

    Parameters
    ----------
    name : str
        What `mixed-ehl fit --family` takes.
    title : str
        One line for reports.
    equation : str
        The equation in words a reader can type into a calculator.
    terms : tuple of str
        Names of the coefficients.
    box : tuple of str
        Variables whose range the formula states and checks.
    log_mu : callable
        ln mu from conditions, coefficients and boundary friction.
    design : callable or None
        Columns of the linear problem ln mu = X b, one per term; None where the family is nonlinear.
    start, lower, upper : tuple of float
        Start and bounds of the coefficients of a nonlinear family.
    """

    name: str
    title: str
    equation: str
    terms: tuple[str, ...]
    box: tuple[str, ...]
    log_mu: Callable[[Conditions, Mapping[str, float], float], Array]
    design: Callable[[Conditions], Array] | None = None
    start: tuple[float, ...] = ()
    lower: tuple[float, ...] = ()
    upper: tuple[float, ...] = ()


_BOX = (
    "pressure_hertz",
    "radius_equivalent",
    "speed_entrainment",
    "slide_to_roll_total",
    "temperature_oil",
    "viscosity_inlet",
    "roughness_rms",
)


def _xu_design(c: Conditions) -> Array:
    """Columns in the order of the published b1..b9: P in GPa, n0 in mPa s, S in um, the rest SI."""
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
    return np.column_stack(
        [
            np.ones_like(rough),
            np.log(c["pressure_hertz"] * 1e-9),
            np.log(c["radius_equivalent"]),
            np.log(c["speed_entrainment"]),
            np.log(c["slide_to_roll_total"]),
            np.log(c["viscosity_inlet"] * 1e3),
            rough,
        ]
    )


def _linear(
    design: Callable[[Conditions], Array], terms: tuple[str, ...]
) -> Callable[[Conditions, Mapping[str, float], float], Array]:
    def log_mu(c: Conditions, coefficients: Mapping[str, float], boundary_friction: float) -> Array:
        return np.asarray(design(c) @ np.array([coefficients[term] for term in terms]))

    return log_mu


def load_share_parts(c: Conditions, k: Mapping[str, float]) -> tuple[Array, Array]:
    """Asperity load share and film friction of the family `load_share`.

    A film as thick as the Hertz depth b^2/R spreads the load and relieves the viscosity of pressure (`relief`). The
    film heats and its stress falls: tau = tau_iso - tau0 beta dT with dT proportional to tau itself gives
    tau = tau_iso/(1 + heat groups); the solver's results follow it with the power `HEAT_POWER`. The cap
    mu_f <= Lambda is a smooth minimum. Roughness that the pressure flattens carries less (`share_flattening`): the
    deterministic solver shows it, the load-sharing model does not know it.
    """
    pressure = 0.25 * np.pi * c["pressure_hertz"]
    speed, sliding, stress = c["speed_entrainment"], c["speed_sliding"], c["eyring_stress"]
    beta, conductivity, film = c["temperature_viscosity"], c["thermal_conductivity"], c["film_formula"]
    inlet = (c["viscosity_inlet"] * beta * speed**2 / conductivity) ** 0.64
    film = film / (1.0 + k["inlet"] * (1.0 + 14.8 * c["slide_to_roll_total"] ** 0.83) * inlet)
    relief = 1.0 + k["relief"] * c["film_formula"] * c["radius_equivalent"] / c["half_width"] ** 2
    rise = np.log(c["viscosity_mean_pressure"] / c["viscosity_inlet"]) / relief
    strain = k["strain"] * c["viscosity_inlet"] * np.exp(rise) * sliding / (stress * film)
    isothermal = k["stress"] * stress / pressure * np.arcsinh(strain)
    heat_film = beta * stress * sliding * film / (8.0 * conductivity)
    heat_flash = beta * stress * sliding * np.sqrt(c["half_width"] / speed) / EFFUSIVITY
    fluid = isothermal / (1.0 + k["heat_film"] * heat_film + k["heat_flash"] * heat_flash) ** HEAT_POWER
    capped = fluid * (1.0 + (fluid / c["limiting_shear_coefficient"]) ** _CAP_ORDER) ** (-1.0 / _CAP_ORDER)
    flattening = c["pressure_hertz"] / 1e9 * 0.5e-6 / np.maximum(c["roughness_rms"], 1e-12)
    ratio = k["share_scale"] * c["film_ratio_formula"] * flattening ** k["share_flattening"]
    share = erfc(ratio ** k["share_power"])
    return np.asarray(share), np.asarray(capped)


def _load_share_log(c: Conditions, k: Mapping[str, float], boundary_friction: float) -> Array:
    share, fluid = load_share_parts(c, k)
    return np.asarray(np.log(share * boundary_friction + (1.0 - share) * fluid))


_XU_TERMS = ("b1", "b2", "b3", "b4", "b5", "b6", "b7", "b8", "b9")
_POWER_TERMS = ("constant", "pressure", "radius", "speed", "sliding", "viscosity", "roughness")

XU = Family(
    "xu",
    "nine terms of Xu, Kahraman, Anderson & Maddock (2007), refitted",
    "mu = exp(b1 + b4 |SR| P lg n + b5 exp(-|SR| P lg n) + b9 exp(S)) P^b2 |SR|^b3 u^b6 n^b7 R^b8"
    " with P = p_h in GPa, SR = |v_s|/u, u = u_r in m/s, n = eta0 in mPa s, R in m, S = Rq in um, lg = log10",
    _XU_TERMS,
    _BOX,
    _linear(_xu_design, _XU_TERMS),
    _xu_design,
)

POWER_LAW = Family(
    "power_law",
    "powers of the six variables",
    "mu = exp(constant) P^pressure R^radius u^speed |SR|^sliding n^viscosity S^roughness"
    " with P = p_h in GPa, R in m, u = u_r in m/s, SR = |v_s|/u, n = eta0 in mPa s, S = Rq in um",
    _POWER_TERMS,
    _BOX,
    _linear(_power_design, _POWER_TERMS),
    _power_design,
)

LOAD_SHARE = Family(
    "load_share",
    "load sharing of a heated Ree-Eyring film and asperities (ours)",
    "mu = X mu_b + (1 - X) F; X = erfc((share_scale (h0/Rq) g^share_flattening)^share_power);"
    " g = (p_h/1 GPa) (0.5 um/Rq);"
    " F = f (1 + (f/Lam)^8)^(-1/8); f = stress (tau0/p) asinh(strain eta v_s/(tau0 h))"
    " / (1 + heat_film beta tau0 v_s h/(8 k) + heat_flash beta tau0 v_s sqrt(b/u_r)/e)^0.75;"
    " eta = eta0 (eta_p/eta0)^(1/(1 + relief h0 R/b^2));"
    " h = h0/(1 + inlet (1 + 14.8 SR^0.83) (eta0 beta u_r^2/k)^0.64)"
    " with h0 the film of Moes (1992) over the density ratio of Dowson & Higginson at p_h, p = pi p_h/4,"
    " eta_p the viscosity at p, SR = |v_s|/u_r, b the Hertz half-width, e = 12941.4 W s^0.5/(m2 K);"
    " tau0, Lam, beta, k of the oil at inlet temperature; SI units",
    (
        "stress",
        "strain",
        "relief",
        "heat_film",
        "heat_flash",
        "inlet",
        "share_scale",
        "share_power",
        "share_flattening",
    ),
    _BOX,
    _load_share_log,
    None,
    (1.0, 1.0, 0.05, 1.0, 1.0, 0.05, 1.0, 1.0, 0.0),
    (0.5, 0.1, 0.0, 0.0, 0.0, 0.0, 0.1, 0.3, -2.0),
    (2.0, 20.0, 1.0, 5.0, 5.0, 0.3, 10.0, 3.0, 2.0),
)

FAMILIES: dict[str, Family] = {family.name: family for family in (XU, POWER_LAW, LOAD_SHARE)}


def family_named(name: str) -> Family:
    """The family of that name.

    Raises
    ------
    InputError
        There is none; the message lists those there are.
    """
    if name not in FAMILIES:
        raise InputError("family", name, "one of " + ", ".join(FAMILIES))
    return FAMILIES[name]
