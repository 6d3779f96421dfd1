"""Smooth, steady, thermal line contact: the film solver and the heat balance, each in turn until both agree.

isothermal film -> (heat matters?) -> temperatures at that film -> film with the viscosity of those temperatures
-> ... -> friction of the last film, temperatures of the last balance.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from ehl.fluid.conductivity import FilmConductivity
from ehl.fluid.lubricant import Lubricant
from ehl.heat import (
    FilmProfile,
    InletFactor,
    Matrices,
    ThermalEstimate,
    ThermalTraction,
    estimate_thermal_effect,
    inlet_thermal_factors,
    surface_matrices,
    thermal_traction,
)
from ehl.heat.conduction import Conduction
from ehl.inputs import ModelInput
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.smooth import SteadyResult, solve_steady
from ehl.smooth.refine import Accuracy
from ehl.smooth.solver import solve_on_mesh

FloatArray = NDArray[np.float64]
Offset = Callable[[FloatArray], FloatArray]
Thermal = Literal["auto", "on"]

# on the change of friction and film between two rounds, and the number of nodes of the heat balance
ROUND_TOLERANCE: dict[str, float] = {"fast": 1e-3, "standard": 2e-4, "reference": 2e-5}
HEAT_NODES: dict[Accuracy, int] = {"fast": 65, "standard": 97, "reference": 257}
FIRST_ROUNDS = 5.0  # of this tolerance, before the nodes are doubled
MAX_ROUNDS = 40
MAX_HALVINGS = 4
# where twice the nodes change friction or film by more, the balance is struck anew at the next accuracy
REFINED_ALLOWED = 0.05
# a change in the last round up to this is accepted, noted and counted in the error
ACCEPTED_CHANGE = 0.1
# a thinner film is heated less: whole steps overshoot by up to 0.7 of themselves
RELAXATION = 0.65
MEMORY = 4


@dataclass(frozen=True)
class ThermalSteadyResult:
    """A contact in thermal balance, or the isothermal one where heat was found not to matter.

    Parameters
    ----------
    status : {"converged", "failed"}
    reason : str
        Empty; one of the film solver's; "no_thermal_balance", "not_finite"; or "thermal_rounds" (film and
        temperature still changed by more than 10 % in the last round).
    film : SteadyResult
        Pressure and film with the viscosity of the hot film; its friction is the thermal one, with its grid error.
    isothermal : SteadyResult
        The same contact without heat.
    heat : ThermalTraction or None
        Temperatures on the nodes of the heat balance; None where heat was left out.
    estimate : ThermalEstimate
        What decided that.
    friction_fluid, friction_isothermal : float
        [-].
    friction_error, film_error : float
        Relative: grid errors of film and heat balance, and half the change in the last round (all of it where that
        is above the tolerance).
    film_reduction : float
        film_central over its isothermal value [-].
    inlet_factors : InletFactor
        What published formulas say of that reduction.
    temperature_film_max, temperature_flash : float
        Highest film and surface temperature [K].
    energy_residual : float
        |heat into both bodies - power|/power, the power from the shear stress of the film solver on its own mesh [-].
    rounds : int
    iterations : int
        Newton iterations of all film solutions.
    notes : tuple of str
        Those of the heat balance, and "thermal_rounds" where the last change was between tolerance and 10 %.
    skipped : tuple of str
    """

    status: Literal["converged", "failed"]
    reason: str
    film: SteadyResult
    isothermal: SteadyResult
    heat: ThermalTraction | None
    estimate: ThermalEstimate
    friction_fluid: float
    friction_isothermal: float
    friction_error: float
    film_error: float
    film_reduction: float
    inlet_factors: InletFactor
    temperature_film_max: float
    temperature_flash: float
    energy_residual: float
    rounds: int
    iterations: int
    notes: tuple[str, ...] = ()
    skipped: tuple[str, ...] = ()


def solve_steady_thermal(
    contact: LineContact,
    lubricant: Lubricant,
    bodies: tuple[Material, Material],
    *,
    temperature_bulk: tuple[float, float] | None = None,
    thermal: Thermal = "auto",
    accuracy: Accuracy = "standard",
    start: SteadyResult | None = None,
    start_heat: ThermalTraction | None = None,
    conduction: Conduction = "jaeger",
    conductivity: FilmConductivity | None = None,
    rolling_heat: bool = True,
    film_profile: FilmProfile = "parabolic",
) -> ThermalSteadyResult:
    """Solve the smooth, steady contact with the heat of sliding and of the pressure-driven flow.

    The film temperature acts on the viscosity in the Reynolds equation itself, inlet included. The published inlet
    factors are therefore reported beside the reduction found, never multiplied in: that would count the inlet twice.

    Parameters
    ----------
    contact, lubricant, bodies, temperature_bulk, conduction, conductivity, film_profile
        As in `ehl.heat.thermal_traction`.
    thermal : {"auto", "on"}
        "auto" leaves heat out where `estimate_thermal_effect` finds that it does not matter.
    accuracy : {"fast", "standard", "reference"}
        As in `ehl.smooth.solve_steady`.
    start : SteadyResult, optional
        A neighbouring contact's isothermal film.
    start_heat : ThermalTraction, optional
        A neighbouring contact's temperatures.
    rolling_heat : bool
        Whether the pressure-driven flow heats the film (inlet heating in pure rolling). The transient solver takes
        this heat from here.

    Returns
    -------
    ThermalSteadyResult
    """
    bulk = temperature_bulk or (lubricant.temperature, lubricant.temperature)
    isothermal = solve_steady(contact, lubricant, accuracy=accuracy, start=start)
    central = isothermal.film_central if isothermal.status == "converged" else None
    estimate = estimate_thermal_effect(
        contact, lubricant, bodies, film_central=central, temperature_bulk=bulk, conductivity=conductivity
    )
    base = _without_heat(contact, lubricant, isothermal, estimate, max(bulk))
    if isothermal.status != "converged":
        return base
    if thermal == "auto" and not estimate.matters:
        skipped = f"heat: estimated change of ln(viscosity) {estimate.viscosity_change:.2g}"
        return replace(base, skipped=(*isothermal.skipped, skipped))

    balance = _HeatBalance(contact, lubricant, bodies, bulk, rolling_heat, conduction, conductivity, film_profile)
    film, mixer, rounds, iterations = isothermal, _Mixer(), 0, isothermal.iterations
    if start_heat is not None:
        # the temperatures of the neighbour, stretched to this contact's exit
        offset = _curve(start_heat.x * (isothermal.x_exit / start_heat.x[-1]), start_heat.log_viscosity_offset)
        warm = solve_on_mesh(contact, lubricant, film, HEAT_NODES[accuracy], offset)
        iterations += warm.iterations
        if warm.status == "converged":
            film, mixer = warm, _Mixer(offset)
    found, levels = None, list(HEAT_NODES)
    for level in levels[levels.index(accuracy) :]:
        following = _settled(balance, film, mixer, level)
        rounds, iterations = rounds + following.rounds, iterations + following.iterations
        if following.reason and found is not None:
            break  # what the coarser nodes gave stands, with its error
        found = following
        if found.reason or max(found.refined) <= REFINED_ALLOWED:
            break
        film, mixer = found.film, _Mixer()  # on nodes of its own: old ones would hide what new ones change
    assert found is not None
    if found.reason:
        return _failed(base, found.reason, rounds, iterations)

    film, heat = found.film, found.heat
    # on the mesh of the film: the little shear of the open inlet before it heats nothing here
    power = float(np.trapezoid(film.shear_stress, film.x)) * contact.speed_sliding + float(
        np.trapezoid(heat.rolling_heat, heat.x)
    )
    into = float(np.trapezoid(heat.heat_flux_1 + heat.heat_flux_2, heat.x))
    unsettled = max(found.change) > ROUND_TOLERANCE[accuracy]
    last_share = 1.0 if unsettled else 0.5
    return replace(
        base,
        film=film,
        heat=heat,
        friction_fluid=film.friction_fluid,
        friction_error=film.friction_error + found.refined[0] + last_share * found.change[0],
        film_error=film.film_error + found.refined[1] + last_share * found.change[1],
        film_reduction=film.film_central / isothermal.film_central,
        temperature_film_max=heat.temperature_film_max,
        temperature_flash=heat.temperature_flash,
        energy_residual=abs(into - power) / power if power > 0.0 else 0.0,
        rounds=rounds,
        iterations=iterations,
        notes=(*heat.notes, *(("thermal_rounds",) if unsettled else ())),
        skipped=(),
    )


@dataclass(frozen=True)
class _Settled:
    """Film and heat in balance on one set of nodes; with a reason where they are not, and the last of both.

    `change` is that of friction and film in the last round, `refined` what twice the nodes then changed [-].
    """

    film: SteadyResult
    heat: ThermalTraction
    reason: str
    rounds: int
    iterations: int
    change: tuple[float, float] = (math.inf, math.inf)
    refined: tuple[float, float] = (math.inf, math.inf)


def _settled(balance: _HeatBalance, film: SteadyResult, mixer: _Mixer, accuracy: Accuracy) -> _Settled:
    """Rounds on one mesh, then on twice the nodes, until heat and film agree; then the film with its grid error."""
    contact, lubricant = balance.contact, balance.lubricant
    nodes, tolerance = HEAT_NODES[accuracy], ROUND_TOLERANCE[accuracy]
    first = _rounds(balance, film, mixer, nodes, accuracy, FIRST_ROUNDS * tolerance)
    if first.reason:
        return first
    offset = mixer.last_offset()
    fine = solve_on_mesh(contact, lubricant, first.film, 2 * nodes - 1, offset)
    if fine.status != "converged":
        fine = solve_steady(contact, lubricant, accuracy=accuracy, start=first.film, film_log_viscosity_offset=offset)
    if fine.status != "converged":
        return replace(first, reason=fine.reason)
    finer = _Mixer(offset)
    second = _rounds(balance, fine, finer, 2 * nodes - 1, accuracy, tolerance, first.heat)
    rounds = first.rounds + second.rounds
    iterations = first.iterations + fine.iterations + second.iterations
    if second.reason:
        return replace(second, rounds=rounds, iterations=iterations)
    # all of what twice the nodes change counts as error
    offset = finer.last_offset()
    check = solve_on_mesh(contact, lubricant, first.film, nodes, offset)
    last = solve_steady(contact, lubricant, accuracy=accuracy, start=second.film, film_log_viscosity_offset=offset)
    iterations += check.iterations + last.iterations
    refined = _changes(first.film, check if check.status == "converged" else last)
    return _Settled(last, second.heat, last.reason, rounds, iterations, second.change, refined)


def _rounds(
    balance: _HeatBalance,
    film: SteadyResult,
    mixer: _Mixer,
    nodes: int,
    accuracy: Accuracy,
    tolerance: float,
    last: ThermalTraction | None = None,
) -> _Settled:
    """Heat balance and film on one mesh in turn, until friction and film change by less than the tolerance."""
    contact, lubricant = balance.contact, balance.lubricant
    change, rounds, iterations = (math.inf, math.inf), 0, 0
    heat = balance.on_nodes_of(film, nodes, last)
    matrices = surface_matrices(heat.x, contact, balance.bodies, balance.conduction)
    while max(change) > tolerance and rounds < MAX_ROUNDS:
        rounds += 1
        if rounds > 1:
            heat = balance.on_nodes(heat, film, matrices)
        if heat.status != "converged":
            return _Settled(film, heat, heat.reason, rounds, iterations)
        offset = mixer.next_offset(heat)
        for _ in range(MAX_HALVINGS):
            hot = solve_on_mesh(contact, lubricant, film, nodes, offset)
            iterations += hot.iterations
            if hot.status != "converged":
                hot = solve_steady(contact, lubricant, accuracy=accuracy, start=film, film_log_viscosity_offset=offset)
                iterations += hot.iterations
            if hot.status == "converged":
                break
            offset = mixer.halved()
        if hot.status != "converged":
            return _Settled(film, heat, hot.reason, rounds, iterations)
        change = _changes(film, hot)
        film = hot
    reason = "thermal_rounds" if max(change) > ACCEPTED_CHANGE else ""
    return _Settled(film, heat, reason, rounds, iterations, change)


def _without_heat(
    contact: LineContact, lubricant: Lubricant, film: SteadyResult, estimate: ThermalEstimate, hottest: float
) -> ThermalSteadyResult:
    return ThermalSteadyResult(
        status=film.status,
        reason=film.reason,
        film=film,
        isothermal=film,
        heat=None,
        estimate=estimate,
        friction_fluid=film.friction_fluid,
        friction_isothermal=film.friction_fluid,
        friction_error=film.friction_error,
        film_error=film.film_error,
        film_reduction=1.0,
        inlet_factors=inlet_thermal_factors(contact, lubricant),
        temperature_film_max=lubricant.temperature,
        temperature_flash=hottest,
        energy_residual=0.0,
        rounds=0,
        iterations=film.iterations,
        skipped=film.skipped,
    )


def _failed(base: ThermalSteadyResult, reason: str, rounds: int, iterations: int) -> ThermalSteadyResult:
    """No thermal friction: zero with infinite error, never the isothermal number in its place."""
    return replace(
        base,
        status="failed",
        reason=reason,
        friction_fluid=0.0,
        friction_error=math.inf,
        film_error=math.inf,
        rounds=rounds,
        iterations=iterations,
    )


@dataclass(frozen=True)
class _HeatBalance:
    """The heat balance of a film: see `ehl.heat.thermal_traction`."""

    contact: LineContact
    lubricant: Lubricant
    bodies: tuple[Material, Material]
    bulk: tuple[float, float]
    rolling_heat: bool
    conduction: Conduction
    conductivity: FilmConductivity | None
    film_profile: FilmProfile

    def on_nodes_of(self, film: SteadyResult, nodes: int, last: ThermalTraction | None = None) -> ThermalTraction:
        """On every k-th node of the film's mesh, so that they are at least so many; from the stress of another one."""
        step = max(1, (film.x.size - 1) // (nodes - 1))
        x, pressure, heat = film.x[::step], np.maximum(film.pressure, 0.0), self._heat(film)
        guess = None if last is None else np.interp(x, last.x, last.shear_stress)
        return self._found(x, pressure[::step], film.film[::step], heat[::step], guess=guess)

    def on_nodes(self, last: ThermalTraction, film: SteadyResult, matrices: Matrices) -> ThermalTraction:
        """On the nodes of another one, whose stress is the start; nothing is freed behind the exit."""
        columns = np.column_stack((np.maximum(film.pressure, 0.0), film.film, self._heat(film)))
        pressure, thickness, heat = PchipInterpolator(film.x, columns)(np.clip(last.x, film.x[0], film.x[-1])).T
        pressure = np.where(last.x < film.x[-1], np.maximum(pressure, 0.0), 0.0)
        return self._found(last.x, pressure, thickness, heat, matrices, last.shear_stress)

    def _found(
        self,
        x: FloatArray,
        pressure: FloatArray,
        thickness: FloatArray,
        heat: FloatArray,
        matrices: Matrices | None = None,
        guess: FloatArray | None = None,
    ) -> ThermalTraction:
        return thermal_traction(
            x,
            pressure,
            thickness,
            self.contact,
            self.lubricant,
            self.bodies,
            temperature_bulk=self.bulk,
            rolling_heat=heat if self.rolling_heat else None,
            conduction=self.conduction,
            conductivity=self.conductivity,
            film_profile=self.film_profile,
            matrices=matrices,
            guess=guess,
        )

    def _heat(self, film: SteadyResult) -> FloatArray:
        """Of the pressure-driven flow, where it reaches the walls."""
        pressure = np.maximum(film.pressure, 0.0)
        # the flow of this very mesh (density 1 at the exit): in the contact h - h* is a small difference
        excess = film.film - film.film[-1] / self.lubricant.density_ratio(pressure)
        heat = np.maximum(self.contact.speed_entrainment * excess * _gradient(film.x, pressure), 0.0)
        return _carried(film.x, heat, pressure, film.film, self.contact, self.lubricant, self.conductivity)


def _carried(
    x: FloatArray,
    heat: FloatArray,
    pressure: FloatArray,
    thickness: FloatArray,
    contact: LineContact,
    lubricant: Lubricant,
    conductivity: FilmConductivity | None,
) -> FloatArray:
    """Where the heat of the pressure-driven flow reaches the walls: the film carries it along while it conducts.

    d(l Q)/dx = q - Q with l = rho c u_r h* h/(12 k): the mean rise of an evenly heated film is Q h/(12 k), and the flow
    u_r h* is the same everywhere. Behind the pressure spike of a thick, fast film q is freed within a hundredth of l;
    conducted on the spot it would heat the oil by thousands of kelvin, carried along by a few.
    """
    k_film = (conductivity or lubricant.film_conductivity)(pressure, lubricant.thermal_conductivity)
    capacity = lubricant.density * lubricant.heat_capacity * contact.speed_entrainment * thickness[-1]
    length = capacity * thickness / (12.0 * k_film)
    stored = np.zeros_like(heat)
    for i in range(1, x.size):
        middle = 0.5 * (length[i] + length[i - 1])
        decay = math.exp(-(x[i] - x[i - 1]) / middle)
        stored[i] = stored[i - 1] * decay + 0.5 * (heat[i] + heat[i - 1]) * middle * (1.0 - decay)
    return np.where(pressure > 0.0, stored / length, 0.0)  # what is left at the exit goes with the oil


def _gradient(x: FloatArray, pressure: FloatArray) -> FloatArray:
    """dp/dx; in the inlet from ln p over ln|x|, since the pressure there nears a power of x on a coarse mesh."""
    slope = np.gradient(pressure, x, edge_order=2)
    inlet = (x < 0.0) & (np.maximum.accumulate(pressure) < 0.1 * pressure.max()) & (pressure > 0.0)
    if np.count_nonzero(inlet) > 3:
        distance = np.log(-x[inlet])
        slope[inlet] = pressure[inlet] / x[inlet] * np.gradient(np.log(pressure[inlet]), distance, edge_order=2)
    return np.asarray(slope)


class _Mixer:
    """Anderson mixing of the change of ln(viscosity) along x, on the nodes of the first round.

    Walker & Ni (2011), SIAM J. Numer. Anal. 49, 1715, with the first step relaxed.
    """

    def __init__(self, start: Offset | None = None) -> None:
        self.start = start
        self.x: FloatArray = np.zeros(0)
        self.used: list[FloatArray] = []
        self.residuals: list[FloatArray] = []

    def next_offset(self, heat: ThermalTraction) -> Offset:
        """The offset to solve the next film with, from the temperatures of the last one."""
        if not len(self.x):
            self.x = heat.x
            self.used.append(np.zeros_like(self.x) if self.start is None else self.start(self.x))
        found = _curve(heat.x, heat.log_viscosity_offset)(self.x)
        used = self.used[-1]
        residual = found - used
        self.residuals.append(residual)
        mixed = used + RELAXATION * residual
        if len(self.residuals) > 1:
            steps = np.diff(np.array(self.used[-MEMORY:]), axis=0).T
            changes = np.diff(np.array(self.residuals[-MEMORY:]), axis=0).T
            share = np.linalg.lstsq(changes, residual, rcond=1e-6)[0]
            mixed = mixed - (steps + RELAXATION * changes) @ share
        self.used.append(mixed)
        return self.last_offset()

    def last_offset(self) -> Offset:
        """What the last film was solved with."""
        return _curve(self.x, self.used[-1])

    def halved(self) -> Offset:
        """Half the last step, where the film could not be solved with all of it."""
        self.used[-1] = 0.5 * (self.used[-1] + self.used[-2])
        return self.last_offset()


def _curve(x: FloatArray, values: FloatArray) -> Offset:
    curve = PchipInterpolator(x, values)
    first, last = float(x[0]), float(x[-1])
    return lambda points: np.asarray(curve(np.clip(points, first, last)))


def _changes(before: SteadyResult, after: SteadyResult) -> tuple[float, float]:
    """Relative change of friction, and the larger one of both films."""

    def change(a: float, b: float) -> float:
        return abs(a - b) / b if b > 0.0 else 0.0

    films = (change(before.film_central, after.film_central), change(before.film_min, after.film_min))
    return change(before.friction_fluid, after.friction_fluid), max(films)


@dataclass(frozen=True)
class SmoothFilm:
    """The smooth contact with or without heat; fields as in `ThermalSteadyResult`."""

    status: str
    reason: str
    film: SteadyResult
    isothermal: SteadyResult
    heat: ThermalTraction | None
    friction_fluid: float
    film_error: float
    friction_error: float
    temperature_film_max: float
    temperature_flash: float
    iterations: int
    skipped: tuple[str, ...]
    notes: tuple[str, ...] = ()


def isothermal_fallback(smooth: SmoothFilm | ThermalSteadyResult) -> SmoothFilm:
    """The isothermal film of a contact whose heat balance was not found."""
    return _isothermal(smooth.isothermal, smooth.temperature_film_max, smooth.temperature_flash, smooth.iterations)


def _isothermal(film: SteadyResult, temperature_film: float, temperature_flash: float, iterations: int) -> SmoothFilm:
    return SmoothFilm(
        film.status,
        film.reason,
        film,
        film,
        None,
        film.friction_fluid,
        film.film_error,
        film.friction_error,
        temperature_film,
        temperature_flash,
        iterations,
        film.skipped,
    )


def smooth_film(
    contact: LineContact,
    lubricant: Lubricant,
    model: ModelInput,
    bodies: tuple[Material, Material],
    bulk: tuple[float, float],
    *,
    start: SteadyResult | None,
    start_heat: ThermalTraction | None,
) -> SmoothFilm | ThermalSteadyResult:
    """The smooth contact with the heat that `model` asks for, from film and heat of a similar contact where given."""
    if model.thermal == "off":
        film = solve_steady(contact, lubricant, accuracy=model.accuracy, start=start)
        return _isothermal(film, lubricant.temperature, lubricant.temperature, film.iterations)
    return solve_steady_thermal(
        contact,
        lubricant,
        bodies,
        temperature_bulk=bulk,
        thermal=model.thermal,
        accuracy=model.accuracy,
        start=start,
        start_heat=start_heat,
    )
