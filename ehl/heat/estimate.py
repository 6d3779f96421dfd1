"""Closed-form estimates of the thermal effect on friction (``thermal = "auto"``) and of errors of convection."""

import math
from dataclasses import dataclass, replace

import numpy as np

from ehl.fluid._kernels import limited_stress
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.rheology import LOG_STRESS_MAX
from ehl.heat.conduction import bounded_rate
from ehl.line_contact import LineContact
from ehl.material import Material

# tuned: change of ln(viscosity) and relative change of film below which heat is neglected; the error of friction was
# at most 1.5 % in 543 contacts (docs/heat.md, tests/unit/ehl/test_heat.py)
THERMAL_THRESHOLD = 0.02


def thermal_loading(contact: LineContact, lubricant: Lubricant) -> float:
    """Thermal loading parameter L = eta0 beta u_r^2/k of the inlet [-], with the mean surface speed."""
    return (
        lubricant.viscosity_inlet
        * lubricant.temperature_viscosity
        * contact.speed_entrainment**2
        / lubricant.thermal_conductivity
    )


def murch_wilson_1975(loading: float) -> float:
    """Film factor of inlet heating in pure rolling, 3.94/(3.94 + L^0.62) (Murch & Wilson 1975; unverified)."""
    return float(3.94 / (3.94 + loading**0.62))


@dataclass(frozen=True)
class ThermalEstimate:
    """Estimated thermal effect; every figure is an upper estimate."""

    # rise of the mid-layer above the surfaces, and of the surfaces above bulk, at the contact centre with isothermal
    # friction [K]
    rise_film: float
    rise_flash: float
    bulk_offset: float  # largest difference between a bulk temperature and the oil temperature [K]
    viscosity_change: float  # (rises + bulk offset) times -d ln eta/dT at the Hertz pressure [-]
    friction_change: float  # size of the resulting relative change of friction [-]
    film_change: float  # relative loss of film by inlet heating [-]
    matters: bool  # viscosity_change or film_change above the threshold


def estimate_thermal_effect(
    contact: LineContact,
    lubricant: Lubricant,
    bodies: tuple[Material, Material],
    *,
    film_central: float | None = None,
    temperature_bulk: tuple[float, float] | None = None,
) -> ThermalEstimate:
    """Upper estimate of the thermal change of friction without a thermal solution (own work).

    The isothermal shear stress at the Hertz pressure heats a film of central thickness and a band as wide as the
    contact. Both rises act on the viscosity there. Heating reduces the shear stress, so the isothermal stress gives an
    upper estimate. The threshold of 0.02 in d ln eta is from a parameter study.

    contact, lubricant, bodies: as in `ehl.heat.traction.film_temperature`.
    film_central: [m]; default: the formula of Moes (1992).
    temperature_bulk: [K]; default: the inlet temperature.
    """
    bulk = temperature_bulk or (lubricant.temperature, lubricant.temperature)
    bulk_offset = max(abs(t - lubricant.temperature) for t in bulk)
    b, speed = contact.half_width, contact.speed_sliding
    film = contact.film_moes(lubricant) if film_central is None else film_central
    pressure = np.array([contact.pressure_hertz])
    temperature = np.array([lubricant.temperature])
    k_film = float(lubricant.film_conductivity(pressure, lubricant.thermal_conductivity)[0])
    log_viscous = float(lubricant.log_viscosity(pressure, temperature)[0]) + math.log(max(speed, 1e-300) / film)
    # d ln tau/d ln eta (1 for a Newtonian film), without the limiting stress, which may act at the centre only
    law = lubricant.shear_law
    log_stress, _, _ = limited_stress(log_viscous, contact.pressure_hertz, law.numbers(1.0, 1.0, 1.0))
    unlimited = replace(law, limit_slope=math.inf).numbers(1.0, 1.0, 1.0)
    _, sensitivity, _ = limited_stress(log_viscous, contact.pressure_hertz, unlimited)
    stress = min(math.exp(min(log_stress, LOG_STRESS_MAX)), float(law.limiting_stress(pressure)[0]))
    heat = speed * stress if speed > 0.0 else 0.0
    rise_film = heat * film / (8.0 * k_film)
    # rise at the trailing edge of a band, 2 q sqrt(2 b/(pi u))/e for each body, both bodies in parallel
    parallel = 0.0
    for u, body in zip((contact.speed_1, contact.speed_2), bodies, strict=True):
        u_used = 2.0 * body.thermal_diffusivity * bounded_rate(u / (2.0 * body.thermal_diffusivity), b)
        parallel += body.thermal_effusivity * math.sqrt(math.pi * u_used / (2.0 * b)) / 2.0
    rise_flash = heat / parallel
    slope = -float(lubricant.dlog_viscosity_dtemperature(pressure, temperature)[0])
    viscosity_change = slope * (rise_film + rise_flash + bulk_offset)
    loading = thermal_loading(contact, lubricant)
    # a factor quoted without source, too low with sliding: at SR 1 up to 50 % below solved films
    sliding = 1.0 / (1.0 + 0.1 * (1.0 + 14.8 * abs(contact.slide_to_roll_total) ** 0.83) * loading**0.64)
    loss = 1.0 - min(sliding, murch_wilson_1975(loading))
    return ThermalEstimate(
        rise_film,
        rise_flash,
        bulk_offset,
        viscosity_change,
        # far above the measured pressures of a law, its viscosity may increase with temperature: heat is then neglected
        abs(viscosity_change) * sensitivity,
        loss,
        max(viscosity_change, loss) > THERMAL_THRESHOLD,
    )


@dataclass(frozen=True)
class ConvectionError:
    """Upper estimates of the errors of the convection model of the film (this work, docs/heat.md)."""

    peclet_film: float  # rho c u_r h^2/(k b), with the film and its conductivity at the Hertz pressure [-]
    # relative [-]
    friction_change: float
    film_change: float


def convection_error(contact: LineContact, lubricant: Lubricant, film: float, film_reduction: float) -> ConvectionError:
    """Estimate the error of the film temperature by the first mode of conduction and by the net flow of the inlet.

    In the contact the error of friction grows with the film Peclet number and the thinning. Against the energy equation
    across the film it is at most 0.91 of the estimate, with a median of a quarter (64 contacts). The error of the
    inlet, whose reversed flow is neglected, grows with the thermal thinning of the film.

    contact, lubricant: as in `ehl.heat.traction.film_temperature`.
    film: central film with heat [m].
    film_reduction: that film over the isothermal one [-].
    """
    k_film = lubricant.film_conductivity(contact.pressure_hertz, lubricant.thermal_conductivity)
    capacity = lubricant.density * lubricant.heat_capacity
    peclet = capacity * contact.speed_entrainment * film**2 / (k_film * contact.half_width)
    loss = max(-math.log(film_reduction), 0.0) ** 1.4
    return ConvectionError(peclet, 0.05 * loss + 0.01 * peclet + 0.002, 0.18 * loss + 0.002)
