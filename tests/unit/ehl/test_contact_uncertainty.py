"""Interval of one contact: every input reaches the solver, and products add as squares."""

import math
from typing import Any

import numpy as np
import pytest
import samples

import ehl
from ehl.fluid.oil import Oil
from ehl.inputs import ContactProblem
from ehl.surface.finish import Finish
from ehl.uncertainty.contact_design import contact_uncertainty, uncertain_contact_inputs, varied_lubricant
from ehl.uncertainty.result import score_of
from ehl.uncertainty.spread import DEFAULT, UncertaintyInput

OIL = Oil.load("75w90")
CONTACT = ehl.Contact(oil="75w90", temperature="90 degC", roughness_rms="0.4 um", **samples.CONTACT)


def product(problem: ContactProblem) -> tuple[float, float, float]:
    """mu = eta0 mu_b sqrt(boundary film), a film ratio of 0.5."""
    surface = problem.surface
    film = math.sqrt(surface.film_of_contact)
    return problem.lubricant.viscosity_inlet * surface.boundary_friction * film, 0.01, 0.5


def smooth(problem: ContactProblem) -> tuple[float, float, float]:
    return product(problem)[0], 0.01, 5.0


def test_a_product_adds_as_squares() -> None:
    spreads = UncertaintyInput.none(viscosity=0.1, boundary_friction=0.2, boundary_film=0.2)
    found = contact_uncertainty(CONTACT.problem(), product, spreads, OIL, jobs=1)
    reach = score_of(0.9) * math.sqrt(0.1**2 + 0.2**2 + 0.1**2)
    assert math.log(found.high / found.value) == pytest.approx(reach, rel=1e-9)
    assert math.log(found.low / found.value) == pytest.approx(-reach, rel=1e-9)
    assert {source.name for source in found.sources} == {"viscosity", "boundary_friction", "boundary_film"}


def test_thick_films_do_not_ask_for_roughness_and_nothing_uncertain_leaves_nothing() -> None:
    found = contact_uncertainty(CONTACT.problem(), smooth, DEFAULT, OIL, jobs=1)
    assert {source.group for source in found.sources} == {"oil", "bulk temperature", "steel"}
    exact = contact_uncertainty(CONTACT.problem(), product, UncertaintyInput.none(), OIL, jobs=1)
    assert exact.low == exact.high == exact.value
    by_numbers = contact_uncertainty(CONTACT.problem(), smooth, UncertaintyInput.none(), None, jobs=1)
    assert "no oil card" in by_numbers.notes[0]


def test_every_input_is_moved_by_its_own_spread() -> None:
    z, problem = score_of(0.9), CONTACT.problem()
    inputs = uncertain_contact_inputs(problem, DEFAULT, OIL, 0.5)
    below = {entry.name: entry.moved(problem, -z) for entry in inputs}
    above = {entry.name: entry.moved(problem, z) for entry in inputs}
    assert above["boundary_film"].surface.boundary_film == pytest.approx(2.0 * problem.surface.film_of_contact)
    ratio = below["roughness_rms_1"].surface.roughness_rms_1 / problem.surface.roughness_rms_1
    assert ratio == pytest.approx(1.0 / 1.2)
    assert below["roughness_rms_1"].surface.roughness_rms_2 == problem.surface.roughness_rms_2
    assert above["temperature_bulk"].temperature_bulk[1] - problem.temperature_bulk[1] == pytest.approx(10.0 * z)
    for number, body in enumerate(problem.bodies):  # 30 +- 10 W/(m K)
        ratio = above["conductivity_solid"].bodies[number].thermal_conductivity / body.thermal_conductivity
        assert ratio == pytest.approx(math.exp(0.30 * z))
    thick = above["pressure_viscosity"].lubricant
    rise = float(thick.log_viscosity_ratio(0.8e9) / problem.lubricant.log_viscosity_ratio(0.8e9))
    beyond = problem.lubricant.continuation_difference(problem.line.pressure_hertz) / z
    assert rise == pytest.approx(math.exp(z * math.hypot(OIL.uncertainty.pressure_viscosity, beyond)))


def test_rq_of_a_finish_is_one_cause_and_its_waves_another() -> None:
    z, problem = score_of(0.9), CONTACT.problem()
    ground = DEFAULT.of_surface(finish="ground")
    entries = {entry.name: entry for entry in uncertain_contact_inputs(problem, ground, OIL, 0.5)}
    assert not {"finish", "roughness_rms_1", "roughness_rms_2"} & set(entries)
    rough = entries["roughness_rms"].moved(problem, z).surface
    figure = Finish.load("ground").roughness_rms
    for number in ("1", "2"):
        ratio = getattr(rough, f"roughness_rms_{number}") / getattr(problem.surface, f"roughness_rms_{number}")
        assert ratio == pytest.approx(figure.high / figure.value)
    assert rough.correlation_length == problem.surface.correlation_length
    longer = entries["correlation_length"].moved(problem, z).surface
    length = Finish.load("ground").correlation_length
    assert longer.correlation_length / problem.surface.correlation_length == pytest.approx(length.high / length.value)
    assert longer.roughness_rms == problem.surface.roughness_rms


def test_lubricant_figures_are_scaled_one_by_one() -> None:
    oil = CONTACT.problem().lubricant
    fields = {"viscosity": "viscosity_inlet", "limiting_shear": "limiting_shear_coefficient"}
    for name in (*fields, "thermal_conductivity"):
        field = fields.get(name, name)
        assert getattr(varied_lubricant(oil, name, 1.5), field) == pytest.approx(1.5 * getattr(oil, field))
    stress = [one.shear_law.scale(np.array([0.0, 1e9])) for one in (varied_lubricant(oil, "eyring_stress", 1.5), oil)]
    np.testing.assert_allclose(stress[0], 1.5 * stress[1], rtol=1e-12)


def test_a_failed_end_is_named_and_left_out() -> None:
    def fails(problem: ContactProblem) -> tuple[float, float, float]:
        mu, error, ratio = product(problem)
        return (math.nan if problem.surface.boundary_friction > 0.1 else mu), error, ratio

    spreads = UncertaintyInput.none(boundary_friction=0.2, viscosity=0.1)
    found = contact_uncertainty(CONTACT.problem(), fails, spreads, OIL, jobs=1)
    assert [source.name for source in found.sources] == ["viscosity"]
    assert "boundary_friction" in found.notes[-1]


@pytest.mark.parametrize(
    ("surface", "ends"),
    [({"finish": "ground", "lay_angle": "25 deg"}, (1.766, 2.089)), ({"peklenik_number": 3.0}, (1.0, 9.0))],
)
def test_range_of_the_peklenik_number(
    monkeypatch: pytest.MonkeyPatch, surface: dict[str, Any], ends: tuple[float, float]
) -> None:
    """That of a finish by its lay ratio of 3 to 9 at the angle of the marks, a given one by a factor of 3."""
    given: list[Any] = []
    monkeypatch.setattr("ehl.uncertainty.contact_design.contact_uncertainty", lambda *parts: given.append(parts))
    CONTACT.replace(**surface).uncertainty()
    ((problem, _, spreads, oil, *_),) = given
    inputs = {entry.name: entry for entry in uncertain_contact_inputs(problem, spreads, oil, 0.5)}
    moved = [inputs["peklenik_number"].moved(problem, z).surface for z in (-score_of(0.9), score_of(0.9))]
    assert [one.peklenik_number for one in moved] == pytest.approx(ends, abs=1e-3)
    if "finish" not in surface:
        assert {one.correlation_length for one in moved} == {problem.surface.correlation_length}
