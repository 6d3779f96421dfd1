"""Contacts, oils and states that many tests of the contact solver and of friction models share."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.stats import qmc

from ehl.fluid.lubricant import Lubricant
from ehl.heat import _kernels
from ehl.heat.conduction import Matrices, surface_matrices
from ehl.heat.traction import RISE, ThermalTraction, film_temperature, traction_of
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.state import ContactState

BEARING_STEEL = Material(
    youngs_modulus=206e9, poisson_ratio=0.3, thermal_conductivity=46.0, heat_capacity=470.0, density=7850.0
)


def line_contact(**change: Any) -> LineContact:
    """Line contact of a gear: R 15 mm, E' 228 GPa, 1 GPa, 5 m/s, SR 0.5."""
    values = {"radius_equivalent": 15e-3, "effective_modulus": 228e9, "pressure_hertz": 1e9, "speed_entrainment": 5.0}
    return LineContact.from_pressure(**(values | {"slide_to_roll": 0.5} | change))


def hot_oil(**change: Any) -> Lubricant:
    """Roelands oil with tau0 = 5 MPa at 100 degC."""
    values = {"viscosity_inlet": 0.0106, "pressure_viscosity": 15e-9, "rheology": "eyring", "eyring_stress": 5e6}
    return Lubricant(**(values | {"temperature": 373.15, "temperature_viscosity": 0.04} | change))  # type: ignore[arg-type]


def gear_range(count: int, seed: int) -> Iterator[tuple[LineContact, Lubricant]]:
    """Contacts and oils of the gear range (scrambled Sobol, logarithmic).

    p_h 0.3..2.5 GPa, R 5..80 mm, u_r 0.2..20 m/s, eta0 3..150 mPa s, alpha 10..25 1/GPa, tau0 3..10 MPa, SR 0.01..1.5.
    """
    low = np.array([0.3e9, 0.005, 0.2, 0.003, 10e-9, 3e6, 0.01])
    high = np.array([2.5e9, 0.08, 20.0, 0.15, 25e-9, 10e6, 1.5])
    for share in qmc.Sobol(7, rng=seed).random(count):
        p_h, radius, speed, viscosity, alpha, stress, slip = low * (high / low) ** share
        yield (
            line_contact(pressure_hertz=p_h, radius_equivalent=radius, speed_entrainment=speed, slide_to_roll=slip),
            hot_oil(viscosity_inlet=viscosity, pressure_viscosity=alpha, eyring_stress=stress),
        )


def gear_state(**changes: Any) -> ContactState:
    """State of a rough contact of a gear at 90 degC."""
    values = {
        "pressure_hertz": 1.2e9, "radius_equivalent": 0.012, "effective_modulus": 226e9, "speed_entrainment": 5.0,
        "slide_to_roll": 0.5, "temperature_oil": 363.15, "roughness_rms_1": 0.3e-6, "roughness_rms_2": 0.3e-6,
    }  # fmt: skip
    return ContactState.of(**(values | changes))


def thermal_traction(
    x: np.ndarray, pressure: np.ndarray, film: np.ndarray, contact: LineContact, lubricant: Lubricant,
    bodies: tuple[Material, Material], *, temperature_bulk: tuple[float, float] | None = None,
    matrices: Matrices | None = None, rolling_heat: np.ndarray | None = None, **options: Any,
) -> ThermalTraction:  # fmt: skip
    """Friction and temperatures at given pressure and film; by default both bodies have the inlet temperature."""
    bulk = temperature_bulk or (lubricant.temperature, lubricant.temperature)
    conduction = matrices or surface_matrices(x, contact, bodies)
    rolling = np.zeros_like(x) if rolling_heat is None else rolling_heat
    found = film_temperature(
        pressure, film, lubricant.film_conductivity(pressure, lubricant.thermal_conductivity), contact, lubricant, bulk,
        conduction, rolling_heat=rolling, **options,
    )  # fmt: skip
    return traction_of(found, x, contact, bodies)


def effective_rise(even: np.ndarray, decay: np.ndarray) -> np.ndarray:
    """Share of the even rise and derivative of their product, of each node."""
    return np.array([_kernels.effective_rise(float(heat), RISE) for heat in decay * even]).T
