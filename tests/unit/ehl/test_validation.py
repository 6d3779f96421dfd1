"""Places in the input models: paths as a user wrote them, and what belongs there in words."""

from typing import Literal

import pytest
from pydantic import BaseModel

from efficiency.design.design import Design
from ehl.common.errors import InputError
from ehl.common.validation import expected_input, locate_field, looks_like, validate
from ehl.contact import Contact
from ehl.fluid.lubricant_inputs import DirectLubricant, OilLubricant
from ehl.fluid.oil import Oil
from ehl.material import Material
from regression.formula import Formula


@pytest.mark.parametrize(
    ("model", "loc", "path", "words"),
    [
        (Contact, ("lubricant", "card", "temperature_oil"), "lubricant.temperature_oil", "233.15 K"),
        (Contact, ("lubricant", "direct", "density"), "lubricant.density", "at least 500 kg/m^3"),
        (Contact, ("contact", "effective_modulus"), "contact.effective_modulus", "at most 2e+12 Pa"),
        (
            Design,
            ("pinion", "concave", "cut", "cutter", "face_milling", "type"),
            "pinion.concave.cutter.type",
            "face_milling",
        ),
        (Material, ("E",), "E", "at least 1e+06 Pa"),
        (Formula, ("schema",), "schema", "a whole number"),
        (Formula, ("ranges", "pressure_hertz", 1), "ranges.pressure_hertz.1", "a number without unit"),
        (Formula, ("bands", 3, "count"), "bands.3.count", "a whole number"),
        (Formula, ("bands",), "bands", "a list"),
        (Formula, ("corners",), "corners", "a table [corners] with count"),
        (Formula, ("units",), "units", "a table [units]"),
    ],
)
def test_place_and_words(model: type[BaseModel], loc: tuple[str | int, ...], path: str, words: str) -> None:
    place = locate_field(model, loc)
    assert ".".join(place.path) == path
    assert words in expected_input(place, path)


def test_owner_is_the_member_of_the_union_in_use() -> None:
    assert locate_field(Contact, ("lubricant", "card", "colour")).owner is OilLubricant
    assert locate_field(Contact, ("lubricant", "direct", "colour")).owner is DirectLubricant
    assert expected_input(locate_field(Contact, ("lubricant", "direct", "colour")), "") == ""


class Round(BaseModel):
    kind: Literal["round"]


class Anything(BaseModel):
    shape: Round | int
    rest: list  # type: ignore[type-arg]


def test_places_below_unions_and_lists_of_anything() -> None:
    assert locate_field(Anything, ("shape", "round", "kind")).owner is Round
    assert locate_field(Anything, ("shape", "square")).owner is not Round
    assert locate_field(Anything, ("rest", 0, "key")).path == ("rest", "0", "key")


def test_kinds_of_laws_are_listed() -> None:
    card = Oil.load("75w90").model_dump(mode="json", exclude_none=True, by_alias=True)
    with pytest.raises(InputError) as caught:
        validate(Oil, card | {"pressure_viscosity": {"law": "god"}})
    assert (caught.value.field, caught.value.value) == ("pressure_viscosity.law", "god")
    assert "'gold'" in caught.value.allowed


def test_formats_that_are_no_toml() -> None:
    kinds = [looks_like(text) for text in ("{}", " <html>", "a,b\n1,2\n", "x")]
    assert kinds[3] == ""
    assert len(set(kinds)) == 4
