"""Friction of a lubricated line contact with the heat it makes: film and surface temperatures at given p and h."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgesv

from ehl.fluid.conductivity import FilmConductivity
from ehl.fluid.lubricant import Lubricant
from ehl.heat.conduction import PECLET_FLOOR, Conduction, peclet_number, surface_matrix
from ehl.heat.film import CouetteFilm, couette_film, flux_to_surface_1
from ehl.io.errors import InputError
from ehl.line_contact import LineContact
from ehl.material import Material

FloatArray = NDArray[np.float64]
Matrices = tuple[FloatArray, FloatArray]

FilmProfile = Literal["parabolic", "couette"]

PECLET_WARNING = 2.0
_AT_LIMIT = 1.0 - 1e-12


@dataclass(frozen=True)
class ThermalTraction:
    """Temperatures and friction of one contact in thermal balance; arrays are on the nodes `x`.

    Parameters
    ----------
    status : {"converged", "failed"}
    reason : str
        Empty, "no_thermal_balance" or "not_finite".
    x : ndarray, shape (n,)
        [m].
    shear_stress : ndarray
        Along the sliding vector [Pa].
    temperature_film : ndarray
        Mid-layer of the film [K].
    temperature_flash_1, temperature_flash_2 : ndarray
        Surface temperatures, bulk plus rise [K].
    heat_flux_1, heat_flux_2 : ndarray
        Into each body [W/m2].
    log_viscosity_offset : ndarray
        ln eta(p, T_film) - ln eta(p, T_inlet), what the heat does to the viscosity in the Reynolds equation [-].
    rolling_heat : ndarray
        Heat of the pressure-driven flow [W/m2].
    temperature_rise_rolling : ndarray
        What it adds to the film temperature, surfaces included [K].
    friction_fluid : float
        Integral of the shear stress over the load per length [-].
    friction_isothermal : float
        The same without heat, at the inlet temperature, the same film [-].
    temperature_film_max, temperature_flash : float
        Highest film and highest surface temperature [K].
    energy_residual : float
        |heat into both bodies - friction power|/friction power, the power taken anew at the final temperatures [-].
    peclet_number : float
        The lower one of the two bodies [-].
    conduction : str
        The conduction model used.
    iterations : int
        Newton iterations.
    notes : tuple of str
        "peclet_low" (below 2: heat spreads against the motion), "peclet_floor" (below 0.1: the heat field of a body
        nearly at rest is bounded in depth), "limiting_shear_stress" (it acts where the pressure is above a tenth of
        its maximum).
    """

    status: Literal["converged", "failed"]
    reason: str
    x: FloatArray
    shear_stress: FloatArray
    temperature_film: FloatArray
    temperature_flash_1: FloatArray
    temperature_flash_2: FloatArray
    heat_flux_1: FloatArray
    heat_flux_2: FloatArray
    log_viscosity_offset: FloatArray
    rolling_heat: FloatArray
    temperature_rise_rolling: FloatArray
    friction_fluid: float
    friction_isothermal: float
    temperature_film_max: float
    temperature_flash: float
    energy_residual: float
    peclet_number: float
    conduction: str
    iterations: int
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Balance:
    """Film temperature T = constant + surface @ q + film * (heat freed in the film)."""

    constant: FloatArray
    surface: FloatArray
    film: FloatArray
    division: FloatArray
    division_constant: FloatArray
    matrix_1: FloatArray
    matrix_2: FloatArray


def thermal_traction(
    x: FloatArray,
    pressure: FloatArray,
    film: FloatArray,
    contact: LineContact,
    lubricant: Lubricant,
    bodies: tuple[Material, Material],
    *,
    temperature_bulk: tuple[float, float] | None = None,
    asperity_heat: FloatArray | None = None,
    rolling_heat: FloatArray | None = None,
    conduction: Conduction = "jaeger",
    conductivity: FilmConductivity | None = None,
    film_profile: FilmProfile = "parabolic",
    matrices: Matrices | None = None,
    guess: FloatArray | None = None,
    tolerance: float = 1e-9,
    max_iterations: int = 80,
) -> ThermalTraction:
    """Shear stress, film and surface temperatures of a steady contact whose pressure and film are given.

    At each node tau = tau(p, h, T_film), T_film = (T1 + T2)/2 + tau |v_s| h/(8 k_f), with the surface temperatures
    T_i = bulk + conduction of q_i and the heat divided by the conductance of the film. The whole nonlocal balance is
    one Newton iteration in ln tau: a lagged temperature oscillates at high load and sliding.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Nodes, increasing [m]; graded meshes welcome. Cost grows as n^3: a few hundred are plenty.
    pressure, film : ndarray, shape (n,)
        Fluid pressure [Pa] and film thickness [m]; no heat is made where the pressure is zero.
    contact : LineContact
        Speeds and load.
    lubricant : Lubricant
        Its temperature is that of the inlet.
    bodies : tuple of Material
        Both bodies.
    temperature_bulk : tuple of float, optional
        Bulk temperatures [K]; the inlet temperature when not given.
    asperity_heat : ndarray, optional
        Heat freed at asperity contacts, mu_b p_c |v_s| [W/m2]: it enters the surfaces, not the film.
    rolling_heat : ndarray, optional
        Heat of the pressure-driven flow, u_r (h - h*) dp/dx with h* = flow/density [W/m2]. It is freed near the walls:
        its mid-layer rise is q h/(16 k_f).
    conduction : {"jaeger", "one_dimensional"}
        Exact two-dimensional conduction, or the one-dimensional limit the transient solver uses.
    conductivity : FilmConductivity, optional
        Film conductivity under pressure; that of the lubricant when not given.
    film_profile : {"parabolic", "couette"}
        Temperature across the film: a parabola, whose middle acts on the viscosity (as in the transient solver), or
        the profile of a film that shears most where it is hot (`ehl.heat.couette_film`).
    matrices : pair of ndarray, shape (n, n), optional
        `surface_matrices` of these nodes, where they are known.
    guess : ndarray, shape (n,), optional
        Shear stress to start from [Pa].
    tolerance : float
        On ln tau.

    Returns
    -------
    ThermalTraction

    Raises
    ------
    InputError
        Arrays of unequal shape or not increasing, a film that is not positive, or a body at rest with
        one-dimensional conduction.
    """
    _check(x, pressure, film)
    if matrices is None:
        matrices = surface_matrices(x, contact, bodies, conduction)
    found = film_temperature(
        pressure,
        film,
        contact,
        lubricant,
        temperature_bulk or (lubricant.temperature, lubricant.temperature),
        conductivity or lubricant.film_conductivity,
        matrices,
        rolling_heat=np.zeros_like(x) if rolling_heat is None else rolling_heat,
        asperity_heat=asperity_heat,
        film_profile=film_profile,
        guess=guess,
        tolerance=tolerance,
        max_iterations=max_iterations,
    )
    return traction_of(found, x, contact, lubricant, bodies, conduction)


@dataclass(frozen=True)
class FilmTemperature:
    """Shear stress and film temperature in balance at a given film; arrays on its nodes.

    Parameters
    ----------
    pressure, film : ndarray
        [Pa], [m].
    stress : ndarray
        Shear stress [Pa].
    temperature : ndarray
        Mid-layer of the film [K].
    log_viscosity_profile : ndarray
        What the profile across the film adds to ln eta of the mid-layer [-].
    log_viscosity_offset : ndarray
        As in `ThermalTraction`.
    rolling_heat, surface_heat : ndarray
        Heat of the pressure-driven flow; that and the heat of asperities [W/m2].
    bulk : tuple of float
        [K].
    balance : _Balance
    iterations : int
    converged : bool
    """

    pressure: FloatArray
    film: FloatArray
    stress: FloatArray
    temperature: FloatArray
    log_viscosity_profile: FloatArray
    log_viscosity_offset: FloatArray
    rolling_heat: FloatArray
    surface_heat: FloatArray
    bulk: tuple[float, float]
    balance: _Balance
    iterations: int
    converged: bool


def film_temperature(
    pressure: FloatArray,
    film: FloatArray,
    contact: LineContact,
    lubricant: Lubricant,
    bulk: tuple[float, float],
    conductivity: FilmConductivity,
    matrices: Matrices,
    *,
    rolling_heat: FloatArray,
    asperity_heat: FloatArray | None = None,
    film_profile: FilmProfile = "parabolic",
    guess: FloatArray | None = None,
    tolerance: float = 1e-9,
    max_iterations: int = 80,
) -> FilmTemperature:
    """The balance of `thermal_traction` by itself, with conduction `matrices` of its nodes; parameters as there."""
    speed = contact.speed_sliding
    wet = pressure > 0.0
    rolling = np.where(wet, rolling_heat, 0.0)
    extra = rolling if asperity_heat is None else rolling + asperity_heat
    balance = _balance(pressure, film, lubricant, bulk, conductivity, matrices)
    offset = balance.constant + balance.surface @ extra + 0.5 * balance.film * rolling
    if speed > 0.0:
        stress, iterations, converged = _newton(
            pressure, film, lubricant, speed, wet, balance, offset, film_profile, guess, tolerance, max_iterations
        )
    else:
        stress, iterations, converged = np.zeros_like(film), 0, True
    heat = speed * stress
    walls = offset + balance.surface @ heat
    across = _across(film_profile, pressure, walls, balance.film * heat, lubricant)
    temperature = walls + across.rise
    change = lubricant.log_viscosity(pressure, temperature) + across.log_viscosity
    change -= lubricant.log_viscosity(pressure, np.full_like(film, lubricant.temperature))
    return FilmTemperature(
        pressure, film, stress, temperature, across.log_viscosity, change, rolling, extra, bulk, balance,
        iterations, converged,
    )  # fmt: skip


def traction_of(
    found: FilmTemperature,
    x: FloatArray,
    contact: LineContact,
    lubricant: Lubricant,
    bodies: tuple[Material, Material],
    conduction: Conduction,
) -> ThermalTraction:
    """Friction, surface temperatures and notes of a film in balance."""
    speed, load = contact.speed_sliding, contact.load_per_length
    pressure, film, temperature, bulk = found.pressure, found.film, found.temperature, found.bulk
    balance, extra = found.balance, found.surface_heat
    heat = speed * found.stress
    isothermal = _stress(pressure, film, np.full_like(x, lubricant.temperature), lubricant, speed)
    flux_1 = balance.division @ (heat + extra) + balance.division_constant
    flux_2 = heat + extra - flux_1
    surface_1 = bulk[0] + balance.matrix_1 @ flux_1
    surface_2 = bulk[1] + balance.matrix_2 @ flux_2

    # the power is taken from the law at the final temperatures, so the residual sees any imbalance left
    final = _stress(pressure, film, temperature, lubricant, speed, found.log_viscosity_profile)
    power = float(np.trapezoid(speed * final + extra, x))
    into = float(np.trapezoid(flux_1 + flux_2, x))
    residual = abs(into - power) / power if power > 0.0 else 0.0
    numbers = [
        peclet_number(u, contact.half_width, b) for u, b in zip((contact.speed_1, contact.speed_2), bodies, strict=True)
    ]
    finite = bool(np.all(np.isfinite(temperature)) and np.all(np.isfinite(final)))
    reason = "" if found.converged and finite else ("no_thermal_balance" if finite else "not_finite")
    # near the edges p tends to zero and the limit always acts; what counts is the loaded part
    loaded = pressure > 0.1 * np.max(pressure)
    limited = bool(np.any(final[loaded] >= lubricant.shear_law.limiting_stress(pressure)[loaded] * _AT_LIMIT))
    notes = tuple(
        note
        for note, holds in (
            ("peclet_low", min(numbers) < PECLET_WARNING),
            ("peclet_floor", min(numbers) < PECLET_FLOOR),
            ("limiting_shear_stress", limited and speed > 0.0),
        )
        if holds
    )
    rolling = found.rolling_heat
    return ThermalTraction(
        status="failed" if reason else "converged",
        reason=reason,
        x=x,
        shear_stress=final,
        temperature_film=temperature,
        temperature_flash_1=surface_1,
        temperature_flash_2=surface_2,
        heat_flux_1=flux_1,
        heat_flux_2=flux_2,
        log_viscosity_offset=found.log_viscosity_offset,
        rolling_heat=rolling,
        temperature_rise_rolling=balance.surface @ rolling + 0.5 * balance.film * rolling,
        friction_fluid=float(np.trapezoid(final, x)) / load,
        friction_isothermal=float(np.trapezoid(isothermal, x)) / load,
        temperature_film_max=float(np.max(temperature)),
        temperature_flash=float(max(np.max(surface_1), np.max(surface_2))),
        energy_residual=residual,
        peclet_number=min(numbers),
        conduction=conduction,
        iterations=found.iterations,
        notes=notes,
    )


def surface_matrices(
    x: FloatArray, contact: LineContact, bodies: tuple[Material, Material], conduction: Conduction = "jaeger"
) -> Matrices:
    """Rise of each surface per flux into it at the nodes `x` [K m2/W]."""
    first, second = (
        surface_matrix(x, speed, body, contact.half_width, conduction)
        for speed, body in zip((contact.speed_1, contact.speed_2), bodies, strict=True)
    )
    return first, second


def _balance(
    pressure: FloatArray,
    film: FloatArray,
    lubricant: Lubricant,
    bulk: tuple[float, float],
    law: FilmConductivity,
    matrices: Matrices,
) -> _Balance:
    a1, a2 = matrices
    k_film = law(pressure, lubricant.thermal_conductivity)
    division, constant = flux_to_surface_1(k_film / film, a1, a2, bulk[1] - bulk[0])
    difference = a1 - a2
    return _Balance(
        constant=0.5 * (bulk[0] + bulk[1]) + 0.5 * (difference @ constant),
        surface=0.5 * (a2 + difference @ division),
        film=film / (8.0 * k_film),
        division=division,
        division_constant=constant,
        matrix_1=a1,
        matrix_2=a2,
    )


def _newton(
    pressure: FloatArray,
    film: FloatArray,
    lubricant: Lubricant,
    speed: float,
    wet: NDArray[np.bool_],
    balance: _Balance,
    offset: FloatArray,
    film_profile: FilmProfile,
    guess: FloatArray | None,
    tolerance: float,
    max_iterations: int,
) -> tuple[FloatArray, int, bool]:
    """Solve ln tau = ln tau(p, h, T(tau)) on the wet nodes; returns stress, iterations, converged."""
    size = int(np.count_nonzero(wet))
    # all but the exit, as a rule
    place: Any = slice(size) if wet[:size].all() else wet
    surface = balance.surface[:size, :size] if wet[:size].all() else balance.surface[np.ix_(wet, wet)]
    kernel, across = np.multiply(speed, surface, order="F"), speed * balance.film[place]
    p, h, base = pressure[place], film[place], offset[place]
    diagonal = np.arange(size)

    def residual(y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        stress = np.exp(y)
        walls = base + kernel @ stress
        state = _across(film_profile, p, walls, across * stress, lubricant)
        law, slope = _log_stress(p, h, walls + state.rise, lubricant, speed, state.log_viscosity)
        return y - law, slope, state.share

    known = np.zeros(size, dtype=bool) if guess is None else guess[place] > 0.0
    y = np.zeros(size) if known.all() else _log_stress(p, h, base, lubricant, speed)[0]
    if guess is not None:
        y[known] = np.log(guess[place][known])
    # heat alone cannot lift the film by more than this: brings an isothermal start of any size into reach
    y = np.minimum(y, np.log(_MAX_RISE / np.maximum(kernel[diagonal, diagonal] + across, 1e-300)))
    value, slope, share = residual(y)
    for iteration in range(1, max_iterations + 1):
        stress = np.exp(y)
        jacobian = np.multiply(kernel, stress)
        jacobian[diagonal, diagonal] += across * share * stress
        jacobian *= -slope[:, None]
        jacobian[diagonal, diagonal] += 1.0
        _, _, change, singular = dgesv(jacobian, value, overwrite_a=True)
        if singular:
            break
        step = -change
        length = min(1.0, 3.0 / max(float(np.max(np.abs(step))), 1e-300))
        norm = float(np.max(np.abs(value)))
        for _ in range(12):
            trial = y + length * step
            new_value, new_slope, new_share = residual(trial)
            if float(np.max(np.abs(new_value))) < (1.0 - 0.1 * length) * norm or norm < 10.0 * tolerance:
                break
            length *= 0.5
        y, value, slope, share = trial, new_value, new_slope, new_share
        if length == 1.0 and float(np.max(np.abs(step))) < tolerance:
            return _filled(y, wet), iteration, True
        if float(np.max(np.abs(value))) < 0.1 * tolerance:
            return _filled(y, wet), iteration, True
    return _filled(y, wet), max_iterations, False


_MAX_RISE = 500.0  # K


def _across(
    profile: FilmProfile, pressure: FloatArray, walls: FloatArray, parabola: FloatArray, lubricant: Lubricant
) -> CouetteFilm:
    if profile == "parabolic":
        return CouetteFilm(parabola, np.zeros_like(parabola), np.ones_like(parabola))
    return couette_film(pressure, walls, parabola, lubricant)


def _filled(y: FloatArray, wet: NDArray[np.bool_]) -> FloatArray:
    stress = np.zeros(len(wet))
    stress[wet] = np.exp(y)
    return stress


def _stress(
    pressure: FloatArray,
    film: FloatArray,
    temperature: FloatArray,
    lubricant: Lubricant,
    speed: float,
    extra: FloatArray | float = 0.0,
) -> FloatArray:
    if speed == 0.0:
        return np.zeros_like(pressure)
    stress = np.exp(_log_stress(pressure, film, temperature, lubricant, speed, extra)[0])
    return np.where(pressure > 0.0, stress, 0.0)


def _log_stress(
    pressure: FloatArray,
    film: FloatArray,
    temperature: FloatArray,
    lubricant: Lubricant,
    speed: float,
    extra: FloatArray | float = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """ln tau and d ln tau/dT at given film temperature; `extra` is added to ln eta."""
    log_viscosity = lubricant.log_viscosity(pressure, temperature) + extra
    slope = lubricant.dlog_viscosity_dtemperature(pressure, temperature)
    log_viscous = log_viscosity + math.log(max(speed, 1e-300)) - np.log(film)
    log_stress, growth = lubricant.shear_law.log_stress(log_viscous, pressure)
    return np.asarray(np.maximum(log_stress, -300.0)), np.asarray(slope * growth)


def _check(x: FloatArray, pressure: FloatArray, film: FloatArray) -> None:
    if not (x.ndim == 1 and len(x) >= 3 and x.shape == pressure.shape == film.shape):
        raise InputError("x, pressure, film", (x.shape, pressure.shape, film.shape), "one shape, at least 3 nodes")
    if not np.all(np.diff(x) > 0.0):
        raise InputError("x", "array", "increasing nodes [m]")
    if not (np.all(np.isfinite(pressure)) and np.all(pressure >= 0.0)):
        raise InputError("pressure", "array", "finite, >= 0 Pa everywhere")
    if not (np.all(np.isfinite(film)) and np.all(film > 0.0)):
        raise InputError("film", "array", "finite, > 0 m everywhere")
