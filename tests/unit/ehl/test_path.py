"""Many neighbouring contacts: order, warm starts, failures that stay alone."""

from types import SimpleNamespace
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
from contacts import gear_state
from refusals import refuses
from samples import CONTACT

import ehl
from ehl import sequence as module
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.inputs import ContactProblem, ModelInput, SurfaceInput
from ehl.line_contact import LineContact
from ehl.result import ContactResult
from ehl.sequence import solve_path
from ehl.state import ContactState

OIL = Oil.load("fva3")


def states(count: int) -> ContactState:
    """Conditions of a smooth two-parameter family, as over a flank."""
    a, b = np.random.default_rng(4).uniform(-1.0, 1.0, (2, count))
    moving = {"speed_entrainment": 3.0 * np.exp(0.5 * a), "slide_to_roll": 0.5 * b, "temperature_oil": 360.0 + 10.0 * a}
    shape = {"pressure_hertz": 1e9 * np.exp(0.5 * a - 0.2 * b**2), "radius_equivalent": 0.012 * np.exp(0.2 * b)}
    return gear_state(**moving, **shape, roughness_rms_1=0.0, roughness_rms_2=0.0)


def line(pressure: float = 1e9, **changes: Any) -> LineContact:
    values = {"radius_equivalent": 0.01, "effective_modulus": 226e9, "speed_entrainment": 3.0, "slide_to_roll": 0.1}
    return LineContact.from_pressure(pressure_hertz=pressure, **(values | changes))


@pytest.mark.parametrize(("accuracy", "allowed"), [("reference", 1e-6), ("standard", 5e-5)])
def test_warm_equals_cold(accuracy: Any, allowed: float) -> None:
    # the mesh is graded by the way the solution came about; its error, not the start, sets the difference
    model, state = ModelInput(thermal="off", accuracy=accuracy), states(5)
    cold, warm = (solve_path(state, OIL, model=model, warm=start) for start in (False, True))
    assert (cold.warm, warm.warm, warm.fallbacks) == (0, 4, 0)
    assert warm.status == ("converged",) * 5
    for name in ("friction_coefficient", "film_central", "film_min"):
        difference = np.abs(warm.values(name) / cold.values(name) - 1.0)
        assert np.all(difference < np.minimum(allowed, 0.5 * warm.values("film_error")))
    pressures = [result.film.pressure.max() for result in warm.results if result.film is not None]
    assert np.argsort(pressures).tolist() == np.argsort(state.pressure_hertz).tolist()
    assert sum(r.iterations for r in warm.results) < sum(r.iterations for r in cold.results)


@pytest.fixture
def solver(monkeypatch: pytest.MonkeyPatch) -> Mock:
    found = Mock(side_effect=lambda problem, start=None: solved(problem.line))
    monkeypatch.setattr(module, "solve_contact", found)
    return found


def solved(contact: LineContact, *fallbacks: str) -> ContactResult:
    film: Any = SimpleNamespace(fallbacks=fallbacks)
    return ContactResult("converged", "", friction_coefficient=contact.pressure_hertz / 1e10, isothermal=film)


@pytest.mark.usefixtures("solver")
def test_each_starts_from_its_nearest_neighbour() -> None:
    pressures = [0.5e9, 1.6e9, 0.8e9, 1.0e9, 1.25e9]
    path = solve_path([line(p) for p in pressures], Lubricant(0.02, 16e-9))
    assert path.values("friction_coefficient") == pytest.approx([p / 1e10 for p in pressures])
    assert path.order[0] == 3
    assert path.origin.tolist() == [2, 4, 3, -1, 3]


def test_a_start_that_leads_nowhere_is_counted_and_left_out(solver: Mock) -> None:
    def answer(problem: ContactProblem, start: ContactResult | None = None) -> ContactResult:
        contact = problem.line
        if start is None or contact.pressure_hertz < 0.7e9:
            return solved(contact)
        return solved(contact, "neighbour_too_far") if contact.pressure_hertz < 0.9e9 else ContactResult("failed", "x")

    solver.side_effect = answer
    path = solve_path([line(p) for p in (0.6e9, 0.85e9, 1.0e9, 1.2e9, 1.25e9)], Lubricant(0.02, 16e-9))
    assert path.status == ("converged",) * 5
    assert path.warm == 1
    assert path.fallbacks == 3
    # only what failed altogether is solved a second time: 0.85 GPa went back to a cold start by itself
    assert solver.call_count == 7


def test_failures_stay_alone(solver: Mock) -> None:
    def answer(problem: ContactProblem, start: ContactResult | None = None) -> ContactResult:
        high = problem.line.pressure_hertz > 2e9
        return ContactResult("failed", "path_stalled") if high else solved(problem.line)

    solver.side_effect = answer
    contacts = [line(0.9e9), line(2.1e9), line(speed_entrainment=-1.0), line(1.1e9), line(1.2e9, slide_to_roll=np.nan)]
    path = solve_path(contacts, Lubricant(0.02, 16e-9))
    assert path.status == ("converged", "failed", "failed", "converged", "failed")
    assert [result.reason for result in path.results] == ["", "path_stalled", "refused", "", "refused"]
    assert "speed_entrainment" in path.messages[2]
    assert np.isnan(path.values("friction_coefficient")).tolist() == [False, True, True, False, True]


@pytest.mark.usefixtures("solver")
def test_bad_state_values_are_refused_one_by_one() -> None:
    state = gear_state(temperature_oil=[350.0, 900.0, 360.0], roughness_rms_1=[1e-7, 1e-7, 1.0])
    path = solve_path(state, OIL, surface=SurfaceInput(boundary_friction=0.08), model=ModelInput(thermal="off"))
    assert path.status == ("converged", "failed", "failed")
    assert "temperature_oil" in path.messages[1]
    assert "roughness_rms_1" in path.messages[2]


def test_contacts_are_contacts_and_lubricants_must_match() -> None:
    contact = ehl.Contact(oil="fva3", temperature=353.15, **CONTACT)
    assert len(solve_path(contact.replace(speed_entrainment=speed) for speed in (3.0, 4.0)).results) == 2
    for wrong in (contact, [1e9], "contact.toml"):
        with refuses("contacts"):
            solve_path(wrong)  # type: ignore[arg-type]
    assert solve_path([], Lubricant(0.02, 16e-9)).results == ()
    for contacts, oil in (([line(), line()], [Lubricant(0.02, 16e-9)]), ([line()], OIL)):
        with refuses("lubricant"):
            solve_path(contacts, oil)
