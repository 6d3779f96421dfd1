"""Results that must not count as converged, and the notes with the numbers."""

import math
import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from contacts import line_contact
from samples import CONTACT, STEEL
from samples import PLAIN_OIL as OIL
from samples import contact_case as case

from ehl.contact import Contact
from ehl.elastic_shear import rubbing_friction
from ehl.fluid.density import INCOMPRESSIBLE
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.line_contact import LineContact
from ehl.result import ContactResult
from ehl.smooth.solver import solve_steady
from ehl.uncertainty.contact_design import uncertain_contact_inputs
from ehl.uncertainty.spread import UncertaintyInput
from ehl.validity import _limits_of_heat, checked, friction_above_limit_temperature, limits_of, rejection_reason


@pytest.fixture(scope="module")
def good() -> ContactResult:
    return case(model={"thermal": "off"}).solve()


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({}, ""),
        ({"friction_coefficient": math.nan}, "not_finite"),
        ({"friction_error": math.inf}, "not_finite"),
        ({"film_min": -1e-9}, "negative"),
        ({"asperity_load_share": 1.5}, "negative"),
        ({"mesh_error": 0.5}, "inaccurate"),
        ({"film_error": 0.5}, "inaccurate"),
        ({"film_central": 0.11 * CONTACT["radius_equivalent"]}, "film_above_radius"),
    ],
)
def test_what_cannot_stand(good: ContactResult, change: dict[str, float], reason: str) -> None:
    assert rejection_reason(replace(good, **change), good.problem) == reason


def test_rough_film_beyond_any_shear_strength_in_the_mean_fails(good: ContactResult) -> None:
    """The last step of a rough run may be a calm one: the mean friction must be possible too."""
    problem = SimpleNamespace(units=SimpleNamespace(pressure=0.7e9))
    run: Any = SimpleNamespace(run=SimpleNamespace(state=SimpleNamespace(shear=np.array([0.1])), problem=problem))
    rough = replace(good, transient=run)
    assert rejection_reason(rough, good.problem) == ""
    strong = replace(rough, friction_coefficient=5e6, friction_fluid=5e6)
    assert rejection_reason(strong, good.problem) == "shear_strength"


def test_newtonian_film_beyond_any_shear_strength_fails() -> None:
    """A Newtonian law without limit gives any stress; a friction coefficient above one is no answer."""
    stiff = {**OIL, "viscosity_inlet": 0.1, "pressure_viscosity": 25e-9, "rheology": "newtonian"}
    result = case(lubricant=stiff, model={"thermal": "off"}).solve()
    assert (result.status, result.reason) == ("failed", "shear_strength")
    assert math.isnan(result.friction_coefficient)


@pytest.mark.parametrize("pressure", [0.837e9, 1.0e9, 1.3e9])
def test_limiting_stress_far_below_the_newtonian_stress(pressure: float) -> None:
    """mu is the integral of the limited stress, to the accuracy of the trapezoid, however large the free stress."""
    law: dict[str, Any] = {"rheology": "newtonian", "limiting_shear_coefficient": 0.08}
    lubricant = Lubricant(0.02344, 25e-9, compression=INCOMPRESSIBLE, **law)
    speeds = {"speed_entrainment": 1.54, "slide_to_roll": 0.0196}
    contact = line_contact(radius_equivalent=0.08, pressure_hertz=pressure, **speeds)
    for accuracy in ("standard", "reference"):
        result = solve_steady(contact, lubricant, accuracy=accuracy)
        limited = np.trapezoid(result.shear_stress, result.x) / contact.load_per_length
        assert 0.0 < result.friction_fluid <= 0.08
        assert result.friction_fluid == pytest.approx(limited, rel=5e-3)


def test_inputs_without_effect_are_named() -> None:
    given: dict[str, Any] = {"model": {"thermal": "off"}, "solid_1": {"temperature_bulk": 363.15}}
    given |= {"lubricant": {**OIL, "rheology": "newtonian", "eyring_stress": 5e6}}
    surface = {"lay_angle": 0.1, "hurst_exponent": 0.6}
    rolling = case(contact={**CONTACT, "slide_to_roll": 0.0}, surface=surface, **given)
    named = {"lubricant.eyring_stress", "solid_1.temperature_bulk", "surface.lay_angle", "surface.hurst_exponent"}
    assert {note.split()[0] for note in rolling.unused_inputs()} == named
    result = rolling.solve()
    assert set(rolling.unused_inputs()) <= set(result.notes)
    assert result.temperature_flash == 353.15
    rough = case(surface=surface | {"roughness_rms": 0.4e-6, "spectrum": "self_affine"})
    assert [note.split()[0] for note in rough.unused_inputs()] == ["surface.lay_angle"]


def test_no_friction_of_asperities_without_sliding() -> None:
    rough, fast = {"roughness_rms_1": 3e-7, "roughness_rms_2": 3e-7}, {"thermal": "off", "accuracy": "fast"}
    rolling = case(contact={**CONTACT, "slide_to_roll": 0.0}, surface=rough, model=fast).solve()
    assert rolling.asperity_load_share > 0.01
    assert rolling.friction_coefficient == 0.0
    lengthwise = {**CONTACT, "slide_to_roll": 0.0, "speed_sliding_lengthwise": 1.0}
    assert case(contact=lengthwise, surface=rough, model=fast).solve().friction_asperity > 0.0


def test_simplified_convection_is_noted_where_heat_thins_the_film() -> None:
    """A slow film gets the floor of the estimate; beyond 2 % of friction a note names it and the Peclet number."""
    oil = {"oil": "fva3", "temperature_oil": 303.15}
    fast = {"radius_equivalent": 0.02, "pressure_hertz": 8e8, "speed_entrainment": 14.0, "slide_to_roll": 1.0}

    slow = fast | {"speed_entrainment": 2.0, "slide_to_roll": 0.1}
    found = [case(contact=each, lubricant=oil, model={"accuracy": "fast"}).solve() for each in (fast, slow)]
    assert all(result.status == "converged" and result.heat is not None for result in found)
    (note,), none = ([note for note in result.notes if "convection of heat" in note] for result in found)
    assert none == []
    assert "film Peclet number 1.3" in note
    result = found[0]
    stated = [float(number) / 100.0 for number in re.findall(r"([0-9.]+) %", note)]
    assert result.friction_error > stated[0] > 0.02
    assert float(f"{result.film_error:.2g}") >= stated[1]


@pytest.mark.parametrize("bulk", ["110 degC", "60 degC"])
def test_bodies_at_another_temperature_than_the_oil_are_noted_with_their_size(bulk: str) -> None:
    contact = Contact(oil="fva3", temperature_oil="80 degC", **CONTACT)
    even = contact.solve()
    other = contact.replace(temperature_bulk_1=bulk, temperature_bulk_2=bulk).solve()
    assert not any(note.startswith("bodies") for note in even.notes)
    (note,) = (note for note in other.notes if note.startswith("bodies"))
    assert (" 30 K " if bulk == "110 degC" else " 20 K ") in note
    expected = float(note.rpartition("about ")[2].split()[0])
    assert other.film_central / even.film_central == pytest.approx(expected, rel=0.12)


@pytest.mark.parametrize(
    ("reason", "oil", "temperature", "radius", "pressure", "speed", "more"),
    [
        ("film_above_radius", "ke_additive", -40.0, 5e-4, 5e7, 200.0, {}),
        ("film_above_radius", "hvi", -40.0, 5e-4, 1.177e9, 100.0, {"slide_to_roll": 2.0, "roughness_rms": 5e-6}),
        ("path_stalled", "pg_1_1", -40.0, 5e-4, 4e9, 1e-4, {"slide_to_roll": 10.0, "speed_sliding_lengthwise": 1.666}),
        ("", "fva2", 96.06, 2.65e-3, 5e7, 4.733e-4, {"slide_to_roll": 1e-6, "roughness_rms": 2.728e-7}),
    ],
)
def test_contacts_far_from_any_gear_have_an_error_or_a_reason(reason, oil, temperature, radius, pressure, speed, more):
    keys: dict[str, Any] = {"oil": oil, "temperature_oil": 273.15 + temperature, "pressure_hertz": pressure} | more
    result = Contact(**keys, radius_equivalent=radius, speed_entrainment=speed, accuracy="fast").solve()
    assert (result.reason, result.status) == (reason, "failed" if reason else "converged")
    if not reason:
        assert 0.005 < result.friction_error < 1.0
        expected = rubbing_friction(result.problem.line, 0.085)  # a slip of 1e-6: most of the contact sticks
        assert result.friction_coefficient == pytest.approx(expected, rel=result.friction_error)


def test_no_error_is_negative_where_a_law_has_a_viscosity_that_rises_with_temperature() -> None:
    keys: dict[str, Any] = {"oil": "hc_additive", "temperature": "149 degC", "pressure_hertz": "4.37 GPa"}
    keys |= {"radius_equivalent": "10.8 mm", "speed_entrainment": "7.33 mm/s", "slide_to_roll": 0.298}
    result = Contact(**keys, accuracy="fast").solve()
    assert result.friction_error > 0.02
    assert result.film_error >= 0.0


def test_friction_above_the_shear_strength_of_liquids_is_an_error(good: ContactResult) -> None:
    """0.15 p and 5 MPa over the solved length; what a law without a limit gives above that counts whole."""
    line = good.problem.line
    most = 0.15 + 5e6 * (good.film.x_exit - good.film.x_inlet) / line.load_per_length
    plain = sum(limit.friction for limit in limits_of(good, good.problem))
    strong = replace(good, friction_coefficient=2.0 * most, friction_fluid=2.0 * most)
    found = [limit for limit in limits_of(strong, good.problem) if "shear strength" in limit.note]
    assert [limit.friction for limit in found] == pytest.approx([0.5], rel=1e-12)
    assert plain < 0.01
    assert checked(strong, good.problem).reason == "beyond_laws"


@pytest.mark.parametrize(
    ("gamma", "share", "asperities", "error"),
    [
        (0.5, 0.36, 0.64, 0.25 * 0.64 * 0.8),
        (0.85, 0.36, 0.64, 0.125 * 0.64 * 0.8),
        (0.5, 0.36, 0.0, 0.25 * 0.64 * 0.6),  # without boundary friction the film is sheared by another load
        (0.5, 1.0, 1.0, 0.0),
        (1.0, 0.36, 0.64, 0.0),
    ],
)
def test_marks_along_the_motion_widen_the_error_alone(good, gamma, share, asperities, error):
    problem = replace(good.problem, surface=good.problem.surface.model_copy(update={"peklenik_number": gamma}))
    found = replace(good, asperity_load_share=share, friction_asperity=asperities * good.friction_coefficient)
    plain = sum(limit.friction for limit in limits_of(good, good.problem))
    still = replace(found, friction_coefficient=0.0, friction_asperity=0.0, friction_fluid=0.0)  # no sliding
    assert all(np.isfinite(limit.friction) for limit in limits_of(still, problem))
    limits = list(limits_of(found, problem))
    assert sum(limit.friction for limit in limits) - plain == pytest.approx(error, abs=1e-12)
    assert any("Peklenik number" in limit.note for limit in limits) is (error > 0.0)
    stated = checked(found, problem)
    assert (stated.status, stated.friction_error) == ("converged", pytest.approx(found.friction_error + plain + error))


def test_laws_of_the_oil_beyond_their_measurements_widen_the_interval() -> None:
    """The half-width holds the change with the tangent of the law at the end of what was measured."""
    contact, spreads = Contact(oil="75w90", temperature="60 degC", accuracy="fast", **CONTACT), UncertaintyInput()
    oil = Oil.load("75w90")

    def spread(name: str, temperature: str, pressure: str) -> tuple[float, float]:
        problem = contact.replace(temperature=temperature, pressure_hertz=pressure).problem()
        inputs = {found.name: found.spread.sd for found in uncertain_contact_inputs(problem, spreads, oil, math.inf)}
        beyond = problem.lubricant.continuation_difference(problem.line.pressure_hertz)
        return inputs[name], problem.lubricant.extrapolated if name == "viscosity" else abs(beyond)

    for name, *beyond in (("viscosity", "-20 degC", "0.6 GPa"), ("pressure_viscosity", "60 degC", "2 GPa")):
        plain, none = spread(name, "60 degC", "0.6 GPa")
        assert none == 0.0
        wider, change = spread(name, *beyond)
        assert change > 0.05
        assert wider == pytest.approx(math.hypot(plain, change / 1.6449), rel=1e-4)


@pytest.fixture(scope="module")
def heated() -> ContactResult:
    result = case(contact={**CONTACT, "slide_to_roll": 0.8}, model={"thermal": "on", "accuracy": "fast"}).solve()
    assert result.heat is not None
    return result


def test_friction_of_films_too_hot_for_any_law_counts_as_error(heated: ContactResult) -> None:
    """A third of the shear on nodes above 1000 K: a third of the fluid friction has no law."""
    x = np.linspace(0.0, 3.0, 301)
    hot = np.where(x > 2.0, 1001.0, 900.0)
    heat: Any = SimpleNamespace(x=x, shear_stress=np.full(301, 5e7), temperature_film=hot)
    result = replace(heated, heat=heat, temperature_film_max=1001.0)
    assert friction_above_limit_temperature(result) == pytest.approx(heated.friction_fluid / 3.0, rel=0.01)
    assert friction_above_limit_temperature(replace(result, temperature_film_max=999.0)) == 0.0


def test_rough_films_too_hot_count_by_the_larger_of_two_shares(heated: ContactResult) -> None:
    """Hot spots of the last step count twice: 2 x 0.2; under the mean profile half of the pressure is hot."""

    def rough(spots: float, mean: float) -> ContactResult:
        hot, shares = np.array([1100.0, 400.0]), np.array([[spots, 1.0 - spots], [mean, 1.0 - mean]])
        run = SimpleNamespace(state=SimpleNamespace(shear=shares[0], temperature=hot))
        profiles = SimpleNamespace(pressure_fluid=shares[1], temperature_film=hot)
        transient: Any = SimpleNamespace(run=run, profiles=profiles)
        return replace(heated, transient=transient, temperature_film_max=1100.0, friction_fluid=0.04)

    for spots, mean, share in ((0.2, 0.1, 0.4), (0.2, 0.5, 0.5), (0.8, 0.0, 1.0)):
        assert friction_above_limit_temperature(rough(spots, mean)) == pytest.approx(share * 0.04, rel=1e-12)


@pytest.mark.parametrize(("peclet", "error"), [(0.1, 0.22), (5.0, 0.04), (0.5**0.5, 0.18), (100.0, 0.006)])
def test_error_of_conduction(monkeypatch: pytest.MonkeyPatch, peclet: float, error: float) -> None:
    """Of the thermal change of ln mu, 0.05 to 0.04 without asperities, for 80 % of the friction."""
    monkeypatch.setattr("ehl.validity.peclet_number", lambda *body: peclet)
    line = LineContact.from_pressure(effective_modulus=226e9, **CONTACT)
    hot, cold = (SimpleNamespace(film_central=3e-7, friction_fluid=mu) for mu in (0.04, 0.05))
    friction: dict[str, Any] = {"friction_fluid": 0.04, "friction_coefficient": 0.05}
    result: Any = SimpleNamespace(**friction, film=hot, isothermal=cold, transient=1)
    problem: Any = SimpleNamespace(line=line, lubricant=Lubricant(0.02, 18e-9), bodies=(STEEL, STEEL))
    assert list(_limits_of_heat(result, problem))[-1].friction == pytest.approx(0.8 * error * math.log(1.25))


@pytest.mark.parametrize(("share", "reason"), [(0.02, ""), (0.03, "too_hot")])
def test_friction_without_a_law_widens_the_error_and_unsettles_a_result(monkeypatch, share, reason):
    """Its share of mu is added whole; above half the tolerance of 5 % the result does not stand as converged."""
    given = case(model={"thermal": "off", "accuracy": "fast"})
    plain, above = given.solve(), lambda result: share * result.friction_coefficient
    monkeypatch.setattr("ehl.validity.friction_above_limit_temperature", above)
    hot = given.solve()
    assert hot.friction_error == pytest.approx(plain.friction_error + share, rel=1e-12)
    assert hot.reason == reason
    assert hot.status == ("unsettled" if reason else "converged")
