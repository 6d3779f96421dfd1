"""`ehl.Contact` and `ContactResult`: keywords, files, changes, tables and pages."""

import math
import re
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure
from pages import read_page
from refusals import refuses

import ehl
from ehl.common.data import reason_text
from ehl.contact import KEYWORDS, ContactKeywords
from ehl.uncertainty.result import Change, InputUncertainty

EXAMPLES = Path(__file__).resolve().parents[3] / "docs" / "examples"
GIVEN: dict[str, Any] = {
    "oil": "75w90",
    "temperature": "90 degC",
    "pressure_hertz": "1.2 GPa",
    "radius_equivalent": "15 mm",
    "speed_entrainment": "5 m/s",
    "slide_to_roll": 0.2,
    "roughness_rms": "0.4 um",
    "finish": "ground",
    "accuracy": "fast",
}


@pytest.fixture(scope="module")
def result() -> ehl.ContactResult:
    return ehl.Contact(**GIVEN).solve()


def test_every_public_name_is_there() -> None:
    assert {name for name in ehl.__all__ if getattr(ehl, name) is not None} == set(ehl.__all__)
    assert len(ehl.__all__) <= 19


def test_keywords_and_tables_say_the_same() -> None:
    tables = {
        "contact": {
            "pressure_hertz": 1.2e9,
            "radius_equivalent": "15 mm",
            "speed_entrainment": 5.0,
            "slide_to_roll": 0.2,
        },
        "lubricant": {"oil": "75w90", "temperature_oil": 363.15},
        "surface": {"finish": "ground", "roughness_rms_1": 0.4e-6 / 2.0**0.5, "roughness_rms_2": 0.4e-6 / 2.0**0.5},
        "model": {"accuracy": "fast"},
    }
    contact = ehl.Contact(**GIVEN)
    assert contact.model_dump() == ehl.Contact.from_dict(tables).model_dump()
    assert contact.surface.roughness_rms == pytest.approx(0.4e-6)
    assert ehl.Contact.from_dict(contact.to_dict()) == contact


def test_every_key_of_the_file_is_a_keyword_of_the_signature() -> None:
    import inspect

    assert set(inspect.signature(ehl.Contact).parameters) == {*KEYWORDS, "solid_1", "solid_2"}
    assert set(ContactKeywords.__annotations__) == {*KEYWORDS, *ehl.Contact.model_fields}


def test_bodies_by_name_table_or_material() -> None:
    steel = ehl.Contact(**GIVEN).effective_modulus
    for solid in ("steel", {"material": "steel"}, {"E": "206 GPa", "nu": 0.3}):
        assert ehl.Contact(**GIVEN, solid_1=solid).effective_modulus == pytest.approx(steel)
    brass = ehl.Material(youngs_modulus="100 GPa", poisson_ratio=0.35)
    assert ehl.Contact(**GIVEN, solid_2=brass).solid_2.body().youngs_modulus == 100e9


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"temperature": "500 degC"}, "temperature"),
        ({"pressure_hertz": "1 m"}, "pressure_hertz"),
        ({"radius_equivalent": -1.0}, "radius_equivalent"),
        ({"load_per_length": 1e5}, "pressure_hertz"),
        ({"pressure_herz": 1e9}, "pressure_herz"),
        ({"oil": "whale"}, "oil"),
        ({"solid_1": {"E": 1.0}}, "solid_1.E"),
    ],
)
def test_errors_name_the_keyword(change: dict[str, Any], field: str) -> None:
    with pytest.raises(ehl.InputError) as error:
        ehl.Contact(**(GIVEN | change))
    assert error.value.field == field


def test_missing_inputs_are_named() -> None:
    with refuses("oil"):
        ehl.Contact(pressure_hertz=1e9)
    with refuses("radius_equivalent"):
        ehl.Contact(oil="fva3", temperature=350.0)


def test_replace_checks_again_and_can_take_away() -> None:
    contact = ehl.Contact(**GIVEN)
    assert contact.replace(temperature="80 degC").lubricant.temperature_oil == pytest.approx(353.15)
    assert contact.replace(pressure_hertz=None, load_per_length=4e5).line_contact().load_per_length == 4e5
    with refuses("contact.slide_to_roll"):
        contact.replace(slide_to_roll=1e9)


def test_texts_are_short(result: ehl.ContactResult) -> None:
    contact = ehl.Contact.from_file(EXAMPLES / "contact_rough.toml")
    for record in (contact, result):
        assert len(repr(record)) < 1500
        assert record._repr_html_().startswith("<table>")
    assert "friction_coefficient=0.0" in repr(result)
    assert "failed: no_reason" in repr(ehl.ContactResult("failed", "no_reason"))


def test_frame_holds_inputs_and_results(result: ehl.ContactResult) -> None:
    row = result.to_frame().iloc[0]
    assert row["pressure_hertz"] == pytest.approx(1.2e9)
    assert row["friction_coefficient"] == result.friction_coefficient


def test_figure_and_page(result: ehl.ContactResult, tmp_path: Path) -> None:
    result.write(plot=tmp_path / "contact.png")
    assert (tmp_path / "contact.png").stat().st_size > 10_000
    axes = Figure().add_subplot()
    assert result.plot(axes) is axes
    assert axes.get_ylabel() == "pressure [GPa]"
    page = read_page(result.report(tmp_path / "contact.html"))
    shown = re.search(r"(0\.\d+) friction coefficient not computed", page.sections[0])
    assert shown
    assert float(shown[1]) == pytest.approx(result.friction_coefficient, rel=0.3 * result.friction_error)
    assert f"± {100.0 * result.friction_error:.2g} %" in page.sections[0]
    # the interval by the inputs stands next to the error of the solver
    mu = result.friction_coefficient
    known = InputUncertainty.of(
        "friction_coefficient", mu, [Change("viscosity", "oil", 0.1, -0.2, 0.2)], lambda ln: mu * math.exp(ln)
    )
    page = read_page(result.report(tmp_path / "contact.html", uncertainty=known))
    assert f"{known.low:.3g} to {known.high:.3g} 90 % interval" in page.sections[0]
    assert "Input uncertainty" in page.sections[2]


def test_failed_results_have_a_page_and_no_figure(tmp_path: Path) -> None:
    failed = ehl.ContactResult("failed", "path_stalled")
    page = read_page(failed.report(tmp_path / "failed.html"))
    assert "no answer" in page.sections[0]
    assert f"fault failed: {reason_text('path_stalled')}" in page.sections[0]
    with refuses("plot"):
        failed.plot()


def test_composite_and_each_roughness_together_are_refused() -> None:
    given = {
        "oil": "75w90", "temperature": "80 degC", "pressure_hertz": "1 GPa", "radius_equivalent": "15 mm",
        "speed_entrainment": "1 m/s", "roughness_rms": "0.4 um",
    }  # fmt: skip
    with pytest.raises(ehl.InputError) as error:
        ehl.Contact(**given, roughness_rms_1="0.2 um")
    assert error.value.field == "roughness_rms"
    rough = ehl.Contact(**given)
    assert rough.surface.roughness_rms == pytest.approx(0.4e-6)
    assert rough.replace(roughness_rms="0.2 um").surface.roughness_rms == pytest.approx(0.2e-6)
