"""Film, flash temperature and rolling traction at contact points against the solver and independent computations."""

import numpy as np
import pytest

from efficiency.loss.kinematics import LoadedPoints
from efficiency.loss.lubrication import SolvedFriction, biboulet_houpert_2010, local_lubrication, surface_temperature
from efficiency.loss.power_loss import rolling_losses
from ehl.fluid.oil import Oil
from ehl.inputs import ContactProblem, ModelInput, SurfaceInput
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.rough.dry_limit import flash_of_rubbing
from ehl.solve import solve_contact
from ehl.state import ContactState
from regression.friction.conditions import conditions_of
from regression.friction.models import ConstantFriction, FrictionEstimate

STEEL = Material.load("steel")
BODIES = (STEEL, STEEL)
OIL = Oil.load("75w90")
MOTIONS = [(1e9, 5.0, 0.5, 5.0), (1.8e9, 2.0, 0.3, 0.0), (1e9, 20.0, 1.0, 10.0)]


def point(pressure: float, speed: float, slide: float, along: float, **more: float) -> tuple[ContactState, LineContact]:
    motion = {
        "pressure_hertz": pressure,
        "radius_equivalent": 0.015,
        "effective_modulus": 226e9,
        "speed_entrainment": speed,
        "slide_to_roll": slide,
        "speed_sliding_lengthwise": along,
    }
    state = ContactState.of(**{name: [value] for name, value in motion.items()}, temperature_oil=363.15, **more)
    return state, LineContact.from_pressure(**motion)


@pytest.mark.parametrize("motion", MOTIONS)
def test_blok_flash_is_that_of_the_moving_heat_source(motion: tuple[float, float, float, float]) -> None:
    """Against Jaeger's band sources on a grid; 1.11 is printed with three digits."""
    state, contact = point(*motion)
    rise = flash_of_rubbing(contact, 0.08, BODIES, (363.15, 363.15)) - 363.15
    assert surface_temperature(state, np.array([0.08]), BODIES)[0] - 363.15 == pytest.approx(rise, rel=5e-3)


def test_heat_goes_to_the_faster_surface_and_both_bulks_count() -> None:
    state, _ = point(1e9, 4.0, 1.2, 0.0, temperature_bulk_1=400.0, temperature_bulk_2=370.0)
    # u1 = 6.4, u2 = 1.6 m/s: effusivities times sqrt(u) as 2 to 1, so that two thirds of the heat go to body 1
    np.testing.assert_allclose(surface_temperature(state, np.zeros(1), BODIES), 390.0)


@pytest.mark.parametrize(("pressure", "speed"), [(1e8, 1.0), (3e8, 10.0), (1e9, 1.0), (1.8e9, 10.0)])
def test_rolling_traction_formula_against_the_solver(pressure: float, speed: float) -> None:
    _, contact = point(pressure, speed, 0.0, 0.0)
    lubricant = OIL.at(363.15)
    model = ModelInput(accuracy="fast", thermal="off")
    solved = solve_contact(ContactProblem(contact, lubricant, SurfaceInput(), model, BODIES, (363.15, 363.15)))
    scale = contact.effective_modulus * contact.radius_equivalent
    formula = biboulet_houpert_2010(
        np.array([2.0 * lubricant.viscosity_inlet * speed / scale]), np.array([contact.load_per_length / scale])
    )
    assert 0.8 < formula[0] / solved.rolling_traction < 1.05


def test_rolling_traction_has_both_limits() -> None:
    speed = np.array([1e-11])
    # light loads: sqrt(U W); heavy ones: U^0.75, whatever the load
    light, heavy = (biboulet_houpert_2010(speed, np.array([load])) * load for load in (1e-8, 1e-3))
    np.testing.assert_allclose(light, 1.42 * np.sqrt(speed * 1e-8), rtol=1e-3)
    np.testing.assert_allclose(heavy, 1.47 * speed**0.75, rtol=1e-9)


def loaded(state: ContactState) -> LoadedPoints:
    return LoadedPoints(state, np.array([100.0]), state.speed_sliding, np.zeros(1, np.int64), np.zeros(1, np.int64))


def test_solved_contacts_bring_their_own_lubrication() -> None:
    state, _ = point(1e9, 3.0, 0.2, 0.0, roughness_rms_1=3e-7, roughness_rms_2=4e-7)
    mu, one = np.array([0.05]), np.ones(1)
    given = SolvedFriction(mu, mu, mu, np.zeros(1, np.int8), 1e-7 * one, 0.5 * one, 400.0 * one, 1e-4 * one)
    own = local_lubrication(loaded(state), given, conditions_of(state, OIL), BODIES)
    assert (own.source, own.film_central[0], own.film_ratio[0]) == ("ehl", 1e-7, 0.5)
    plain = ConstantFriction(0.05).mu(state, oil=OIL)
    formula = local_lubrication(loaded(state), plain, conditions_of(state, OIL), BODIES)
    assert formula.source == "formula"
    # the film ratio is that of the isothermal film, the film itself thinner by the heat of the inlet
    assert 0.8 < formula.film_central[0] / (formula.film_ratio[0] * 5e-7) < 1.0


def test_formula_film_is_near_the_solved_one() -> None:
    state, contact = point(1e9, 3.0, 0.2, 0.0)
    plain = FrictionEstimate(np.array([0.03]), np.zeros(1), np.zeros(1), np.zeros(1, np.int8))
    formula = local_lubrication(loaded(state), plain, conditions_of(state, OIL), BODIES)
    model = ModelInput(accuracy="fast")
    solved = solve_contact(ContactProblem(contact, OIL.at(363.15), SurfaceInput(), model, BODIES, (363.15, 363.15)))
    assert formula.film_central[0] == pytest.approx(solved.film_central, rel=0.15)


def test_rolling_power_is_the_work_on_both_surfaces() -> None:
    state, _ = point(1e9, 3.0, 0.0, 0.0)
    # 2 t_r F u_r
    np.testing.assert_allclose(rolling_losses(loaded(state), np.array([2e-4]), 1), [2.0 * 2e-4 * 100.0 * 3.0])
