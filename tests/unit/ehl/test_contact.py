"""`ehl.Contact` and `ContactResult`: keywords, files, changes, tables and pages."""

import inspect
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from pages import read_page
from refusals import refuses
from samples import CONTACT

import ehl
from ehl.common.data import reason_text
from ehl.contact import KEYWORDS, ContactKeywords
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
    assert contact.model_dump() == ehl.Contact.from_dict(tables).model_dump()
    assert contact.surface.roughness_rms == pytest.approx(0.4e-6)
    assert ehl.Contact.from_dict(contact.to_dict()) == contact


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
        ({"solid_1": {"E": 1.0}}, "solid_1.E"),
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
    again = ehl.Contact.from_dict(json.loads(json.dumps(contact.to_dict())))
    assert again == contact
    assert again.lubricant.oil.factors == thin.factors
    by_object, by_name = (ehl.Contact(**GIVEN | {"oil": oil}).problem() for oil in (ehl.Oil.load("fva3"), "fva3"))
    assert by_object.lubricant == by_name.lubricant
