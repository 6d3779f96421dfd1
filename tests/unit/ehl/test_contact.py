"""`ehl.Contact` and `ContactResult`: keywords, files, changes, pages; many neighbouring contacts."""

import inspect
import json
import math
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
from contacts import gear_state, line_contact
from matplotlib.figure import Figure
from pages import read_page
from refusals import refuses
from samples import CONTACT

import ehl
from ehl import sequence as module
from ehl.common.data import reason_text
from ehl.contact import KEYWORDS, ContactKeywords
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.inputs import ContactProblem, ModelInput, SurfaceInput
from ehl.line_contact import LineContact
from ehl.result import ContactResult
from ehl.sequence import solve_path
from ehl.state import ContactState
from ehl.uncertainty.result import Change, InputUncertainty

GIVEN: dict[str, Any] = CONTACT | {"oil": "75w90", "temperature": "90 degC", "pressure_hertz": "1.2 GPa"}
GIVEN |= {"roughness_rms": "0.4 um", "finish": "ground", "accuracy": "fast"}


@pytest.fixture(scope="module")
def result() -> ehl.ContactResult:
    return ehl.Contact(**GIVEN).solve()


def test_keywords_and_tables_say_the_same() -> None:
    tables = {
        "contact": CONTACT | {"pressure_hertz": 1.2e9, "radius_equivalent": "15 mm"},
        "lubricant": {"oil": "75w90", "temperature_oil": 363.15},
        "surface": {"finish": "ground", "roughness_rms_1": 0.4e-6 / 2.0**0.5, "roughness_rms_2": 0.4e-6 / 2.0**0.5},
        "model": {"accuracy": "fast"},
    }
    contact = ehl.Contact(**GIVEN)
    assert contact.model_dump() == ehl.Contact(**tables).model_dump()
    assert contact.surface.roughness_rms == pytest.approx(0.4e-6)
    assert ehl.Contact(**contact.to_dict()) == contact


def test_every_key_of_the_file_is_a_keyword_of_the_signature() -> None:
    assert set(inspect.signature(ehl.Contact).parameters) == {*KEYWORDS, "solid_1", "solid_2"}
    assert set(ContactKeywords.__annotations__) == {*KEYWORDS, *ehl.Contact.model_fields}


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"temperature": "500 degC"}, "temperature"),
        ({"load_per_length": 1e5}, "pressure_hertz"),
        ({"pressure_herz": 1e9}, "pressure_herz"),
        ({"oil": "whale"}, "oil"),
        ({"oil": {"name": "mine"}}, "oil.source"),
        ({"oil": 3}, "oil"),
        ({"oil": ["fva3"]}, "oil"),
        ({"solid_1": {"youngs_modulus": 1.0}}, "solid_1.youngs_modulus"),
        ({"roughness_rms_1": "0.2 um"}, "roughness_rms"),
        ({"oil": None, "temperature": None, "finish": None, "roughness_rms": None}, "oil"),
        ({"temperature_oil": "80 degC"}, "temperature_oil"),
    ],
)
def test_errors_name_the_keyword(change: dict[str, Any], field: str) -> None:
    given = {name: value for name, value in (GIVEN | change).items() if value is not None}
    with refuses(field):
        ehl.Contact(**given)


@pytest.mark.parametrize("kind", [np.float32, np.int64, Path])
def test_scalars_of_numpy_and_paths_of_cards(tmp_path: Path, kind: Any) -> None:
    card = tmp_path / "card.toml"
    ehl.Oil.load("fva3").save(card)
    change = {"oil": kind(card)} if kind is Path else {"speed_entrainment": kind(4)}
    plain = {"oil": str(card), "speed_entrainment": 4.0}
    assert ehl.Contact(**(GIVEN | plain | change)).problem() == ehl.Contact(**(GIVEN | plain)).problem()


def test_replace_checks_again_and_can_take_away() -> None:
    contact = ehl.Contact(**GIVEN)
    assert contact.replace(temperature="80 degC").lubricant.temperature_oil == pytest.approx(353.15)
    assert contact.replace(roughness_rms="0.2 um").surface.roughness_rms == pytest.approx(0.2e-6)
    assert contact.replace(pressure_hertz=None, load_per_length=4e5).line_contact().load_per_length == 4e5
    with refuses("contact.slide_to_roll"):
        contact.replace(slide_to_roll=1e9)


def test_figure_and_page(result: ehl.ContactResult, tmp_path: Path) -> None:
    result.write(plot=tmp_path / "contact.png")
    assert (tmp_path / "contact.png").stat().st_size > 10_000
    axes = Figure().add_subplot()
    assert result.plot(axes) is axes
    assert result.to_frame().iloc[0]["friction_coefficient"] == result.friction_coefficient
    # the interval by the inputs stands next to the error of the solver
    mu = result.friction_coefficient
    changes = [Change("viscosity", "oil", 0.1, -0.2, 0.2)]
    known = InputUncertainty.of("friction_coefficient", mu, changes, lambda ln: mu * math.exp(ln))
    answer, *_ = read_page(result.report(tmp_path / "contact.html", uncertainty=known)).sections
    shown = re.search(r"0\.\d+", answer)
    assert shown
    assert float(shown[0]) == pytest.approx(mu, rel=0.3 * result.friction_error)
    for number in (f"± {100.0 * result.friction_error:.2g} %", f"{known.low:.3g} to {known.high:.3g}"):
        assert number in answer


def test_failed_results_have_a_page_and_no_figure(tmp_path: Path) -> None:
    failed = ehl.ContactResult("failed", "path_stalled")
    assert reason_text("path_stalled") in read_page(failed.report(tmp_path / "failed.html")).sections[0]
    with refuses("plot"):
        failed.plot()


def test_an_oil_object_is_as_good_as_its_name() -> None:
    thin = ehl.Oil.load("fva3").varied(viscosity=-1.0)
    contact = ehl.Contact(**GIVEN | {"oil": thin})
    assert contact.replace(slide_to_roll=0.1).lubricant.oil == thin
    again = ehl.Contact(**json.loads(json.dumps(contact.to_dict())))
    assert again == contact
    assert again.lubricant.oil.factors == thin.factors
    by_object, by_name = (ehl.Contact(**GIVEN | {"oil": oil}).problem() for oil in (ehl.Oil.load("fva3"), "fva3"))
    assert by_object.lubricant == by_name.lubricant


OIL = Oil.load("fva3")


def states(count: int) -> ContactState:
    """Conditions of a smooth two-parameter family, as over a flank."""
    a, b = np.random.default_rng(4).uniform(-1.0, 1.0, (2, count))
    moving = {"speed_entrainment": 3.0 * np.exp(0.5 * a), "slide_to_roll": 0.5 * b, "temperature_oil": 360.0 + 10.0 * a}
    shape = {"pressure_hertz": 1e9 * np.exp(0.5 * a - 0.2 * b**2), "radius_equivalent": 0.012 * np.exp(0.2 * b)}
    return gear_state(**moving, **shape, roughness_rms_1=0.0, roughness_rms_2=0.0)


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
    path = solve_path([line_contact(pressure_hertz=p) for p in pressures], Lubricant(0.02, 16e-9))
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
    contacts = [line_contact(pressure_hertz=p) for p in (0.6e9, 0.85e9, 1.0e9, 1.2e9, 1.25e9)]
    path = solve_path(contacts, Lubricant(0.02, 16e-9))
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
    changes = [{"pressure_hertz": p} for p in (0.9e9, 2.1e9, 1e9, 1.1e9, 1.2e9)]
    changes[2], changes[4] = {"speed_entrainment": -1.0}, {"slide_to_roll": np.nan}
    path = solve_path([line_contact(**change) for change in changes], Lubricant(0.02, 16e-9))
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
    for contacts, oil in (([line_contact()] * 2, [Lubricant(0.02, 16e-9)]), ([line_contact()], OIL)):
        with refuses("lubricant"):
            solve_path(contacts, oil)
