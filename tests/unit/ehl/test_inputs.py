import copy
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from pydantic import BaseModel
from refusals import refuses
from samples import CONTACT

from efficiency.design.design import Design
from ehl.common.validation import locate_field, looks_like, validate
from ehl.contact import Contact
from ehl.fluid.lubricant_inputs import DirectLubricant, OilLubricant
from ehl.fluid.oil import Oil
from ehl.inputs import SurfaceInput
from ehl.material import Material
from ehl.surface.measured_surface import load_profile
from regression.formula import Formula

BASE: dict[str, Any] = {
    "contact": CONTACT | {"radius_equivalent": "10 mm", "effective_modulus": "226.4 GPa"},
    "lubricant": {"viscosity_inlet": 0.04, "pressure_viscosity": "18 1/GPa", "eyring_stress": "5 MPa"},
}


CARD = {"oil": "fva3", "temperature_oil": "80 degC"}


def changed(change: Callable[[dict[str, Any]], object]) -> dict[str, Any]:
    content = copy.deepcopy(BASE)
    change(content)
    return content


def test_oil_and_solids() -> None:
    elastic = {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
    solids = {"solid_1": elastic | {"temperature_bulk": "95 degC"}, "solid_2": {"material": "steel"}}
    content = changed(lambda c: c["contact"].pop("effective_modulus")) | {"lubricant": CARD} | solids
    case = validate(Contact, content)
    assert isinstance(case.lubricant, OilLubricant)
    assert case.effective_modulus == pytest.approx(2.0 / ((1 - 0.09) / 210e9 + (1 - 0.09) / 206e9))
    assert case.bulk_temperatures() == (pytest.approx(368.15), pytest.approx(353.15))


@pytest.mark.parametrize(
    ("change", "field"),
    [
        (lambda c: c["contact"].pop("radius_equivalent"), "contact.radius_equivalent"),
        (lambda c: c["contact"].update(radius_equivalent=float("nan")), "contact.radius_equivalent"),
        (lambda c: c["contact"].update(load_per_length=1e5), "contact.pressure_hertz"),
        (lambda c: c["contact"].pop("pressure_hertz"), "contact.pressure_hertz"),
        (lambda c: c["contact"].update(speed_entrainment=0), "contact.speed_entrainment"),
        (lambda c: c["contact"].update(effective_modulus=1e9, pressure_hertz=2e9), "contact.pressure_hertz"),
        (lambda c: c["contact"].update(speed_entrainment=100.0, slide_to_roll=150.0), "contact.slide_to_roll"),
        (lambda c: c["contact"].update(effective_modulus=[]), "contact.effective_modulus"),
        (lambda c: c["lubricant"].update(viscosity_inlet="5 MPa"), "lubricant.viscosity_inlet"),
        (lambda c: c["lubricant"].pop("pressure_viscosity"), "lubricant.pressure_viscosity"),
        (lambda c: c["lubricant"].update(density_coefficients=[1]), "lubricant.density_coefficients.1"),
        (lambda c: c["lubricant"].update(foo=1), "lubricant.foo"),
        (lambda c: c.update(lubricant=CARD | {"foo": 1}), "lubricant.foo"),
        (lambda c: c.update(lubricant=CARD | {"temperature_oil": 80}), "lubricant.temperature_oil"),
        (lambda c: c.update(lubricant={"oil": "fva3"}), "lubricant.temperature_oil"),
        (lambda c: c.update(solid_1={"youngs_modulus": 2e11}), "contact.effective_modulus"),
        (lambda c: c.update(surface={"profile_1": "x.csv", "roughness_rms_1": 3e-7}), "surface.roughness_rms_1"),
        (lambda c: c.update(surface={"roughness_rms": 3e-7, "roughness_rms_2": 3e-7}), "surface.roughness_rms"),
        (lambda c: c.update(surface={"roughness_rms": "25 um"}), "surface.roughness_rms"),
        (lambda c: c.update(surface={"seed": 1.5}), "surface.seed"),
        (lambda c: c.update(surface={"seed": True}), "surface.seed"),
        (lambda c: c["lubricant"].update(density_coefficients=[True, 1.7e-9]), "lubricant.density_coefficients"),
        (lambda c: c.update(surface={"peklenik_number": 0.1}), "surface.peklenik_number"),
        (lambda c: c.update(surface={"profile_1": 3}), "surface.profile_1"),
        (lambda c: c.update(contact=3), "contact"),
        (lambda c: c.update(surface="ground"), "surface"),
        (lambda c: c.pop("lubricant"), "lubricant"),
    ],
)
def test_bad_input_names_its_field(change: Callable[[dict[str, Any]], object], field: str) -> None:
    with refuses(field) as caught:
        validate(Contact, changed(change))
    assert not re.search(r"Input should|instance of|Input tag|\.card|\.direct", str(caught.value))


@pytest.mark.parametrize("content", [b"a = 1\x00\x01", b"[contact", b"contact = 1\ncontact = 2", None, "folder"])
def test_unreadable_files(tmp_path: Path, content: bytes | str | None) -> None:
    path = tmp_path if content == "folder" else tmp_path / "case.toml"
    if isinstance(content, bytes):
        path.write_bytes(content)
    with refuses("file"):
        Contact.from_file(path)


def test_a_measured_profile_is_read_in_the_units_of_the_input(tmp_path: Path) -> None:
    x = np.arange(0.0, 2e-3, 1e-6)
    heights = 3e-7 * np.sin(2.0 * np.pi * x / 50e-6)
    path = tmp_path / "profile.csv"
    np.savetxt(path, np.column_stack((x * 1e3, heights * 1e9)), delimiter=",")
    units = {"profile_unit_x": "mm", "profile_unit_height": "nm"}
    surface = validate(SurfaceInput, {"profile_1": str(path), "detrend": 1, "cutoff_long": None, **units})
    found = load_profile(path, cutoff_short=surface.cutoff_short, **surface.profile_reading)
    assert found.rms == pytest.approx(3e-7 / np.sqrt(2.0), rel=0.05)
    assert surface.measured


@pytest.mark.parametrize(
    ("table", "key", "value", "keys"),
    [
        ("contact", "radius_1", "40 mm", "radius_equivalent"),
        ("contact", "R2", "40 mm", "radius_equivalent"),
        ("contact", "speed_2", "4 m/s", "speed_entrainment slide_to_roll"),
        ("contact", "load", "2 kN", "load_per_length"),
        ("contact", "pressure_mean", "1 GPa", "maximum 4/pi"),
        ("surface", "Ra", "0.4 um", "roughness_rms_1"),
        ("surface", "Rq", "0.4 um", "roughness_rms_1"),
        ("surface", "roughness_rms_1", "Ra 0.4 um", "Rq"),
    ],
)
def test_quantities_of_a_rig_are_refused_with_what_to_give(table: str, key: str, value: str, keys: str) -> None:
    given = copy.deepcopy(BASE) | {"surface": {}}
    given[table][key] = value
    with refuses(f"{table}.{key}") as caught:
        Contact(**given)
    hint = caught.value.hint.partition("Known keys")[0]
    assert all(word in hint for word in keys.split())


@pytest.mark.parametrize(
    ("model", "loc", "path", "words"),
    [
        (Contact, ("lubricant", "card", "temperature_oil"), "lubricant.temperature_oil", "-40 degC"),
        (Contact, ("lubricant", "direct", "density"), "lubricant.density", "at least 500 kg/m^3"),
        (Contact, ("contact", "effective_modulus"), "contact.effective_modulus", "at most 2000 GPa"),
        (Material, ("hardness",), "hardness", "at most 100 GPa"),
        (Formula, ("schema",), "schema", "a whole number"),
        (Formula, ("ranges", "pressure_hertz", 1), "ranges.pressure_hertz.1", "a number without unit"),
        (Formula, ("bands",), "bands", "a list"),
        (Formula, ("corners",), "corners", "a table [corners] with count"),
        (Formula, ("units",), "units", "a table [units]"),
    ],
)
def test_place_and_words(model: type[BaseModel], loc: tuple[str | int, ...], path: str, words: str) -> None:
    place = locate_field(model, loc)
    assert ".".join(place.path) == path
    assert words in place.expected
    cutter = locate_field(Design, ("pinion", "concave", "cut", "cutter", "face_milling", "type"))
    assert ".".join(cutter.path) == "pinion.concave.cutter.type"


class Round(BaseModel):
    kind: Literal["round"]


class Anything(BaseModel):
    shape: Round | int
    rest: list  # type: ignore[type-arg]


def test_places_below_unions_and_lists_of_anything() -> None:
    assert locate_field(Contact, ("lubricant", "card", "colour")).owner is OilLubricant
    assert locate_field(Contact, ("lubricant", "direct", "colour")).owner is DirectLubricant
    assert locate_field(Contact, ("lubricant", "direct", "colour")).expected == ""
    assert locate_field(Anything, ("shape", "round", "kind")).owner is Round
    assert locate_field(Anything, ("shape", "square")).owner is not Round
    assert locate_field(Anything, ("rest", 0, "key")).path == ("rest", "0", "key")
    card = Oil.load("75w90").model_dump(mode="json", exclude_none=True, by_alias=True)
    with refuses("pressure_viscosity.law") as caught:
        validate(Oil, card | {"pressure_viscosity": {"law": "god"}})
    assert "'gold'" in caught.value.allowed


def test_formats_that_are_no_toml() -> None:
    kinds = [looks_like(text) for text in ("{}", " <html>", "a,b\n1,2\n", "x")]
    assert kinds[3] == ""
    assert len(set(kinds)) == 4
