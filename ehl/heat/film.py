"""Heat across the lubricant film: its conductivity, how it divides the heat, and heating of the inlet."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.linalg.lapack import dgesv

from ehl.fluid.lubricant import Lubricant
from ehl.line_contact import LineContact

FloatArray = NDArray[np.float64]


def flux_to_surface_1(
    conductance: FloatArray, matrix_1: FloatArray, matrix_2: FloatArray, bulk_difference: float
) -> tuple[FloatArray, FloatArray]:
    """Division of the friction heat q between the surfaces: q1 = M q + m, q2 = q - q1.

    With heat freed evenly across the film, q1 = q/2 + (k_f/h)(T2 - T1); T1 and T2 follow from q1 and q2 by conduction
    in the bodies, which closes a linear system.

    Parameters
    ----------
    conductance : ndarray, shape (n,)
        k_f/h [W/(m2 K)].
    matrix_1, matrix_2 : ndarray, shape (n, n)
        Rise of each surface per flux into it [K m2/W].
    bulk_difference : float
        Bulk temperature of body 2 less that of body 1 [K].

    Returns
    -------
    M : ndarray, shape (n, n)
    m : ndarray, shape (n,)
        [W/m2].
    """
    n = len(conductance)
    diagonal = np.arange(n)
    system, rhs = np.empty((n, n), order="F"), np.empty((n, n + 1), order="F")
    np.multiply(conductance[:, None], matrix_1 + matrix_2, out=system)
    system[diagonal, diagonal] += 1.0
    np.multiply(conductance[:, None], matrix_2, out=rhs[:, :n])
    rhs[diagonal, diagonal] += 0.5
    rhs[:, n] = conductance * bulk_difference
    _, _, solution, _ = dgesv(system, rhs, overwrite_a=True, overwrite_b=True)
    return solution[:, :n], solution[:, n]


_HALF = np.geomspace(1e-5, 1e4, 1000)
_HALF_OF_HEAT = PchipInterpolator(np.log(_HALF * np.tanh(_HALF)), np.log(_HALF))
# where beta is taken on the way from wall to mid-layer: by trial, against the energy equation across a Roelands film
_SLOPE_AT = 0.8


@dataclass(frozen=True)
class CouetteFilm:
    """Mid-layer of a sheared film and what its profile adds to the viscosity there.

    Parameters
    ----------
    rise : ndarray
        Mid-layer above the walls [K].
    log_viscosity : ndarray
        ln of the viscosity the film shears with over that of its mid-layer [-].
    share : ndarray
        Derivative of the log of that effective viscosity with the parabola's rise, over d ln eta/dT of the mid-layer
        [-]; 1 for a parabola whose middle acts.
    """

    rise: FloatArray
    log_viscosity: FloatArray
    share: FloatArray


def couette_film(pressure: FloatArray, walls: FloatArray, parabola: FloatArray, lubricant: Lubricant) -> CouetteFilm:
    """Film temperature with the shear gathered where the film is hot, instead of spread evenly.

    Closed solution of the heated Couette flow for a viscosity that falls as exp(-beta T) about the mid-layer: with
    Q = beta tau |v| h/(8 k) = a tanh a the mid-layer is 2 ln(cosh a)/beta above the walls and the film shears with
    a/tanh(a) times the viscosity there. It holds for any law in which the rate is a function of stress over viscosity.
    Against the energy equation across a Roelands film (0.5 to 2 GPa) the stress at given heat errs by 0.5 % for a
    mid-layer 30 K above the walls, 3 % for 80 K, 6 % for 150 K; that of the parabola by -7 to +3, +21 and +49 %.

    Parameters
    ----------
    pressure, walls, parabola : ndarray
        Pressure [Pa], mean wall temperature [K] and tau |v| h/(8 k) [K].
    lubricant : Lubricant
    """
    rise = parabola
    for _ in range(4):
        beta = np.maximum(-lubricant.dlog_viscosity_dtemperature(pressure, walls + _SLOPE_AT * rise), 1e-12)
        heat_number = np.maximum(beta * parabola, 1e-9)
        half = np.exp(_HALF_OF_HEAT(np.log(np.minimum(heat_number, 1e4))))
        # ln cosh without overflow
        rise = 2.0 * (half + np.log1p(np.exp(-2.0 * half)) - np.log(2.0)) / beta
    tangent = np.tanh(half)
    growth = 1.0 / (tangent + half * (1.0 - tangent**2))
    # beta counts as constant in the derivative: Newton's iteration only loses a little speed by that
    rise_slope = 2.0 * tangent * growth
    log_slope = growth * (1.0 / half - (1.0 - tangent**2) / tangent)
    middle = np.minimum(lubricant.dlog_viscosity_dtemperature(pressure, walls + rise), -1e-12)
    share = rise_slope + beta * log_slope / middle
    return CouetteFilm(np.asarray(rise), np.asarray(np.log(half / tangent)), np.asarray(share))


def thermal_loading(contact: LineContact, lubricant: Lubricant) -> float:
    """Thermal loading parameter L = eta0 beta u_r^2/k of the inlet [-], with the mean surface speed."""
    return (
        lubricant.viscosity_inlet
        * lubricant.temperature_viscosity
        * contact.speed_entrainment**2
        / lubricant.thermal_conductivity
    )


def murch_wilson_1975(loading: float) -> float:
    """Film factor of inlet heating in pure rolling, 3.94/(3.94 + L^0.62) (Murch & Wilson 1975; from memory)."""
    return float(3.94 / (3.94 + loading**0.62))


def wilson_gupta_1992(loading: float, slide_to_roll: float) -> float:
    """Film factor 1/(1 + 0.1 (1 + 14.8 SR^0.83) L^0.64) of inlet heating with sliding (Murch-Wilson/Gupta)."""
    return float(1.0 / (1.0 + 0.1 * (1.0 + 14.8 * abs(slide_to_roll) ** 0.83) * loading**0.64))


def zhu_cheng_1984(loading: float, slide_to_roll: float, pressure_over_modulus: float) -> float:
    """Film factor (1 - 13.2 (p_h/E') L^0.42)/(1 + 0.213 (1 + 2.23 SR^0.83) L^0.64) (Zhu-Cheng).

    Zero or less far outside its range (heavy load, large L): held at 0.05.
    """
    upper = 1.0 - 13.2 * pressure_over_modulus * loading**0.42
    lower = 1.0 + 0.213 * (1.0 + 2.23 * abs(slide_to_roll) ** 0.83) * loading**0.64
    return float(max(upper / lower, 0.05))


@dataclass(frozen=True)
class InletFactor:
    """Film thickness with inlet heating over that without, by three published formulas [-]."""

    thermal_loading: float
    zhu_cheng: float
    murch_wilson_gupta: float
    murch_wilson_rolling: float


def inlet_thermal_factors(contact: LineContact, lubricant: Lubricant) -> InletFactor:
    """The published inlet factors of one contact; they disagree by tens of per cent at large L."""
    loading = thermal_loading(contact, lubricant)
    ratio = contact.pressure_hertz / contact.effective_modulus
    slide = contact.slide_to_roll_total
    return InletFactor(
        loading,
        zhu_cheng_1984(loading, slide, ratio),
        wilson_gupta_1992(loading, slide),
        murch_wilson_1975(loading),
    )


@dataclass(frozen=True)
class CarriedShearHeat:
    """What a film that carries the heat of shear along would change, at most: estimates, ours (docs/heat.md).

    Parameters
    ----------
    peclet_film : float
        rho c u_r h^2/(k b), with the film and its conductivity at the Hertz pressure [-].
    friction_change, film_change : float
        Relative [-].
    """

    peclet_film: float
    friction_change: float
    film_change: float


def carried_shear_heat(
    contact: LineContact, lubricant: Lubricant, film: float, film_reduction: float
) -> CarriedShearHeat:
    """Estimate what is left out by conducting the heat of shear to the walls on the spot.

    A cooler inlet thickens a film in the measure in which heat had thinned it; in the contact the change grows with
    the film Peclet number. Both terms lie above the changes of 699 solved contacts, by the third by which the mean
    temperature they were solved with lags behind the energy equation across the film (docs/heat.md).

    Parameters
    ----------
    contact, lubricant
        As in `ehl.heat.thermal_traction`.
    film : float
        Central film with heat [m].
    film_reduction : float
        That film over the isothermal one [-].
    """
    k_film = lubricant.film_conductivity(contact.pressure_hertz, lubricant.thermal_conductivity)
    capacity = lubricant.density * lubricant.heat_capacity
    peclet = capacity * contact.speed_entrainment * film**2 / (k_film * contact.half_width)
    loss = max(-math.log(film_reduction), 0.0) ** 1.4
    return CarriedShearHeat(peclet, 0.05 * loss + 0.03 * peclet + 0.002, 0.18 * loss + 0.002)
