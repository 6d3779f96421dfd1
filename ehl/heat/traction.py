"""Thermal traction of a lubricated line contact: friction, film and surface temperatures at given p and h."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.linalg.lapack import dgesv

from ehl.common.arrays import FloatArray
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.viscosity import ModulusLaw, PressureLaw
from ehl.heat import _kernels
from ehl.heat._kernels import Film, Walls
from ehl.heat.conduction import Matrices, peclet_number
from ehl.line_contact import LineContact
from ehl.material import Material


@dataclass(frozen=True)
class ThermalTraction:
    """Temperatures and friction of one contact in thermal balance; arrays are on the nodes `x`."""

    status: Literal["converged", "failed"]
    reason: str  # empty, "no_thermal_balance" or "not_finite"
    x: FloatArray  # [m]; shape (n,)
    shear_stress: FloatArray  # along the sliding vector [Pa]
    temperature_film: FloatArray  # at which the film has its effective viscosity [K]
    # surface temperatures, bulk plus rise [K]
    temperature_flash_1: FloatArray
    temperature_flash_2: FloatArray
    # into each body [W/m2]
    heat_flux_1: FloatArray
    heat_flux_2: FloatArray
    # for the Reynolds equation: ln eta(p, T_film) - ln eta(p, T_inlet), and ln of `flow_shares`; shape (2, n) [-]
    log_viscosity_offset: FloatArray
    log_flow_shares: FloatArray
    rolling_heat: FloatArray  # heat of the pressure-driven flow [W/m2]
    shear_heat: FloatArray  # heat of the shear where it reaches the walls [W/m2]
    lag_heat: FloatArray  # of it what a change of the surface temperature causes, behind which the film lags [W/m2]
    temperature_rise_rolling: FloatArray  # its part of the film temperature, rise of the surfaces included [K]
    friction_fluid: float  # integral of the shear stress over the load per length [-]
    # highest film and highest surface temperature [K]
    temperature_film_max: float
    temperature_flash: float
    # |heat into both bodies - power|/power, with the power into the walls at the final temperatures [-]
    energy_residual: float
    peclet_number: float  # the lower one of the two bodies [-]
    iterations: int  # Newton iterations


def flux_to_surface_1(
    conductance: FloatArray, matrix_1: FloatArray, matrix_2: FloatArray, bulk_difference: float
) -> tuple[FloatArray, FloatArray]:
    """Division of the friction heat q between the surfaces: q1 = M q + m, q2 = q - q1.

    For a uniform heat source across the film, q1 = q/2 + (k_f/h)(T2 - T1). T1 and T2 follow from q1 and q2 by
    conduction in the bodies, which closes a linear system.

    conductance (n,): k_f/h [W/(m2 K)].
    matrix_1, matrix_2 (n, n): rise of each surface per flux into it [K m2/W].
    bulk_difference: bulk temperature of body 2 minus that of body 1 [K].
    Returns: M: shape (n, n); m: [W/m2], shape (n,).
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


@dataclass(frozen=True)
class Conducted:
    """Conduction in both bodies and through a given film between them."""

    walls: Walls  # for the compiled loops
    weights: FloatArray  # of `ehl.heat._kernels.conduct`
    resistance: FloatArray  # h/(8 k) of the film

    def exact(self) -> FloatArray:
        """Rise of the mean surface temperature per heat."""
        first, second = self.walls.matrix_1, self.walls.matrix_2
        division, _ = flux_to_surface_1(self.walls.conductance, first, second, 0.0)
        return np.asarray(0.5 * (second + (first - second) @ division))


@dataclass(frozen=True)
class Convection:
    """Convection of heat by the film, for `film_temperature`."""

    x: FloatArray  # nodes [m]
    length: FloatArray  # C h/(12 k_f) [m], over which heat is conducted to the walls
    capacity: float  # C, that of the flow, rho c u_r h* [W/(m K)]
    surfaces: FloatArray  # mean surface temperature [K], behind whose change the film lags


@dataclass(frozen=True)
class FilmTemperature:
    """Shear stress and film temperature in balance at a given film; arrays on its nodes."""

    # [Pa], [m]
    pressure: FloatArray
    film: FloatArray
    stress: FloatArray  # shear stress [Pa]
    model: Film  # at the temperatures found
    walls: FloatArray  # mean surface temperature and rise by the heat of the pressure-driven flow [K]
    # as in `ThermalTraction`
    log_viscosity_offset: FloatArray
    log_flow_shares: FloatArray
    bulk: tuple[float, float]  # [K]
    conducted: Conducted
    iterations: int
    converged: bool

    @property
    def temperature(self) -> FloatArray:
        """Temperature at which the film has its effective viscosity [K]."""
        return np.asarray(self.model.nodes[_kernels.TEMPERATURE])

    @property
    def rolling_heat(self) -> FloatArray:
        """Heat of the pressure-driven flow [W/m2]."""
        return np.asarray(self.model.nodes[_kernels.SOURCE])

    @property
    def surfaces(self) -> FloatArray:
        """Mean surface temperature [K]."""
        return np.asarray(self.walls - self.model.nodes[_kernels.RAISED])

    def shear_heat(self, stress: FloatArray) -> FloatArray:
        """Heat of a shear stress where it reaches the walls [W/m2]."""
        heat = np.empty(stress.size)
        _kernels.conducted(self.model, self.model.speed * stress, heat)
        return heat


# polynomials of `ehl.heat._kernels.effective_rise`, and of `along_share` and `across_share` there
RISE = (_kernels.RISE_ABOVE, _kernels.RISE_BELOW)
SHARES = ((_kernels.ALONG_ABOVE, _kernels.ALONG_BELOW), (_kernels.ACROSS_ABOVE, _kernels.ACROSS_BELOW))


def flow_shares(decay: FloatArray, even: FloatArray, rolling: FloatArray) -> FloatArray:
    """Shares of the mobilities along and across the sliding by the temperatures across the film; shape (2, n).

    `ehl.heat._kernels.along_share` and `across_share` by the heat of the shear, both times `flow_heat_share` there.

    decay: -d ln eta/dT at the film temperature [1/K].
    even, rolling: q h/(8 k_f) by the heat of the shear and of the flow [K].
    """
    heat = np.maximum(decay * even, 0.0)
    middle = np.minimum(_kernels.MID_FILM_BY_FLOW * decay * rolling, _kernels.FLOW_TURN)
    by_flow = np.exp(middle * (_kernels.FLOW_SLOPE + _kernels.FLOW_BEND * middle))
    both = [np.polyval(above[::-1], heat) / np.polyval(below[::-1], heat) for above, below in SHARES]
    return np.asarray(by_flow * np.array(both))


def _fill_viscosity(nodes: FloatArray, law: PressureLaw, log_inlet: float, numbers: FloatArray) -> None:
    """Fill ln(eta), its slope and the fall of the slope at the temperatures of the nodes."""
    if numbers.size > 0:
        _kernels.modulus_viscosity(nodes, log_inlet, numbers)
        return
    pressure, temperature = nodes[_kernels.PRESSURE], nodes[_kernels.TEMPERATURE]
    slope, warmer = (law.by_temperature(pressure, temperature + kelvin) for kelvin in (0.0, 1.0))
    loss = np.clip(1.0 - warmer / np.where(slope < 0.0, slope, -1.0), 0.0, _kernels.MOST_LOSS)
    nodes[_kernels.LOG_ETA], nodes[_kernels.BY_TEMPERATURE] = log_inlet + law.log_ratio(pressure, temperature), slope
    nodes[_kernels.LOSS] = np.where(slope < 0.0, loss, 0.0)


def film_temperature(
    pressure: FloatArray,
    film: FloatArray,
    conductivity: FloatArray,
    contact: LineContact,
    lubricant: Lubricant,
    bulk: tuple[float, float],
    matrices: Matrices,
    *,
    rolling_heat: FloatArray,
    convection: Convection | None = None,
    guess: tuple[FloatArray, FloatArray] | None = None,
    tolerance: float = 1e-9,
    max_iterations: int = 80,
) -> FilmTemperature:
    """Shear stress, film and surface temperatures of a steady contact whose pressure and film are given.

    At each node tau = tau(p, h, T_film), T_film = (T1 + T2)/2 + `effective_rise` of q h/(8 k_f), with q = tau |v_s| or,
    with convection, its `conducted` part, the surface temperatures T_i = bulk + conduction of q_i and the heat divided
    by the conductance of the film. The nonlocal balance is solved by one Newton iteration in ln tau, as a lagged
    temperature oscillates at high load and sliding.

    pressure, film (n,): fluid pressure [Pa] and film thickness [m]; there is no heat where the pressure is zero.
    conductivity (n,): k_f of the film [W/(m K)].
    contact: speeds and load.
    lubricant: its temperature is that of the inlet.
    bulk: bulk temperatures [K].
    matrices (n, n): `surface_matrices` of the nodes. Cost grows as n^3: a few hundred nodes suffice.
    rolling_heat: heat of the pressure-driven flow, u_r (h - h*) dp/dx with h* = flow/density [W/m2]. Its source is near
        the walls: the rise is a quartic with q h/(16 k_f) at mid-film and the mean q h/(20 k_f).
    convection: of the heat of the shear by the film; None: all heat is conducted to the walls where it arises.
    guess: initial stress and mean surface temperature.
    tolerance: on ln tau.
    """
    speed, n = contact.speed_sliding, film.size
    conducted = _conducted(film, conductivity, bulk, matrices)
    walls, resistance, weights = conducted.walls, conducted.resistance, conducted.weights
    shear, law, log_inlet = lubricant.shear_law, lubricant.pressure_law, math.log(lubricant.viscosity_inlet)
    cut = shear.limit_slope if shear.limited and shear.limit == "cut" else math.inf
    nodes, work = np.empty((_kernels.ROWS, n)), np.zeros((_kernels.WORK_ROWS, n))
    model = Film(nodes, speed, shear.numbers(1.0, 1.0, 1.0), shear.limit_ambient, cut, RISE)
    nodes[_kernels.PRESSURE], nodes[_kernels.SOURCE] = pressure, rolling_heat
    nodes[_kernels.LOG_RATE] = math.log(max(speed, 1e-300)) - np.log(film)
    nodes[_kernels.KEPT :], nodes[_kernels.HERE] = 0.0, _kernels.FIRST_MODE
    if convection is not None:
        _kernels.fill_convection(nodes, convection.x, convection.length, convection.surfaces, convection.capacity)
    numbers = law.numbers if isinstance(law, ModulusLaw) else np.empty(0)
    stress, work[_kernels.SURFACE] = guess or (np.zeros(n), walls.mean)
    if not (stress > 0.0)[pressure > 0.0].all():
        nodes[_kernels.TEMPERATURE] = work[_kernels.SURFACE]
        _fill_viscosity(nodes, law, log_inlet, numbers)
        stress = np.where(stress > 0.0, stress, _kernels.stresses(model))
    work[_kernels.EVEN] = stress
    exact, progress, end = np.empty((0, 0)), np.array([_kernels.BEGUN, 0.0, math.inf]), _kernels.BEGUN
    while end < _kernels.BALANCED:
        end = _kernels.balanced(
            walls, model, weights, exact, resistance, numbers, log_inlet, tolerance, max_iterations, work, progress
        )
        if end == _kernels.EXACT:
            exact = conducted.exact()
        elif end < _kernels.EXACT:
            _fill_viscosity(nodes, law, log_inlet, numbers)
    change = nodes[_kernels.LOG_ETA] - log_inlet - law.log_ratio(pressure)
    even = np.where(pressure > 0.0, work[_kernels.EVEN], 0.0)
    shares = flow_shares(-nodes[_kernels.BY_TEMPERATURE], even, resistance * nodes[_kernels.SOURCE])
    stress = np.where((pressure > 0.0) & (speed > 0.0), np.exp(work[_kernels.LOG_STRESS]), 0.0)
    return FilmTemperature(
        pressure, film, stress, model, work[_kernels.SURFACE], change, np.log(shares), bulk, conducted,
        int(progress[1]), end == _kernels.BALANCED,
    )  # fmt: skip


def traction_of(
    found: FilmTemperature, x: FloatArray, contact: LineContact, bodies: tuple[Material, Material]
) -> ThermalTraction:
    """Friction and surface temperatures of a film in layer."""
    walls, bulk = found.conducted.walls, found.bulk
    temperature, rolling = found.temperature, found.rolling_heat
    heat = found.shear_heat(found.stress) + rolling
    flux_1, rise_1, rise_2 = _kernels.divided(walls, heat)
    flux_2, surface_1, surface_2 = heat - flux_1, bulk[0] + rise_1, bulk[1] + rise_2
    _, *rolling_rises = _kernels.divided(walls._replace(difference=0.0), rolling)

    # the power follows from the law at the final temperatures, so that the residual contains any imbalance
    final, width = _kernels.stresses(found.model), np.diff(x)
    rows = final, found.shear_heat(final) + rolling, flux_1 + flux_2
    friction, power, into = (0.5 * float(width @ (row[1:] + row[:-1])) for row in rows)
    residual = abs(into - power) / power if power > 0.0 else 0.0
    numbers = [
        peclet_number(u, contact.half_width, b) for u, b in zip((contact.speed_1, contact.speed_2), bodies, strict=True)
    ]
    finite = bool(np.isfinite(temperature + final).all())
    reason = "" if found.converged and finite else ("no_thermal_balance" if finite else "not_finite")
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
        log_flow_shares=found.log_flow_shares,
        rolling_heat=rolling,
        shear_heat=heat - rolling,
        lag_heat=found.model.nodes[_kernels.LAGGED],
        temperature_rise_rolling=0.5 * sum(rolling_rises) + found.model.nodes[_kernels.RAISED],
        friction_fluid=friction / contact.load_per_length,
        temperature_film_max=float(temperature.max()),
        temperature_flash=float(max(surface_1.max(), surface_2.max())),
        energy_residual=residual,
        peclet_number=min(numbers),
        iterations=found.iterations,
    )


def _conducted(film: FloatArray, conductivity: FloatArray, bulk: tuple[float, float], matrices: Matrices) -> Conducted:
    n = film.size
    factors, pivots, weights = np.empty((n, n)), np.empty(n, np.int32), np.empty(n)
    conductance = conductivity / film
    _kernels.conduct(*matrices, conductance, factors, pivots, weights)
    walls = Walls(*matrices, factors, pivots, conductance, 0.5 * (bulk[0] + bulk[1]), bulk[1] - bulk[0])
    return Conducted(walls, weights, 0.125 / conductance)
