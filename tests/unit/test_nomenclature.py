"""Keys and results are in the table of quantities, constants state their basis, the field's words are in the code."""

import dataclasses
import pkgutil
import runpy
import typing
from collections.abc import Iterator
from pathlib import Path

import pytest
from pydantic import BaseModel

from ehl.common.quantities import quantities
from regression.calibration.measurement import COLUMNS
from regression.data.result_files import NUMBER_UNITS
from regression.friction.conditions import UNITS

ROOT = Path(__file__).resolve().parents[2]
NAMES = {part for name in quantities() for part in name.split(".")}


def models_in(annotation: object) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in typing.get_args(annotation):
        yield from models_in(argument)


def keys(model: type[BaseModel], seen: set[type[BaseModel]]) -> Iterator[str]:
    if model not in seen:
        seen.add(model)
        for name, info in model.model_fields.items():
            yield name
            for inner in models_in(info.annotation):
                yield from keys(inner, seen)


INPUTS = """
ehl.Contact ehl.Oil ehl.Material regression.Plan regression.Formula regression.calibration.setup.CalibrationSetup
efficiency.design.design.Design efficiency.axle.axle_input.AxleInput efficiency.blanks.inputs.PairBlankInput
efficiency.machine_settings.inputs.SettingsInput
"""
RESULTS = """
ehl.ContactResult ehl.ContactState regression.calibration.calibrate.Calibration
regression.calibration.calibrate.ParameterEstimate efficiency.EfficiencyResult
efficiency.loss.compare.Comparison efficiency.loss.compare.ComparisonRow
efficiency.geometry.pair_geometry.PairGeometry efficiency.geometry.pair_geometry.SideGeometry
efficiency.geometry.pair_geometry.FlankSummary efficiency.geometry.misalignment.MisalignmentPoint
efficiency.geometry.misalignment.MisalignmentStudy efficiency.studies.parameter_study.Study
efficiency.studies.parameter_study.StudyPoint efficiency.vehicle.loss_map.LossPoint
efficiency.vehicle.axle_test.AxleTestRow efficiency.axle.result.AxlePoint
"""


@pytest.mark.parametrize("name", INPUTS.split())
def test_every_key_of_an_input_is_listed(name: str) -> None:
    assert set(keys(pkgutil.resolve_name(name), set())) <= NAMES


@pytest.mark.parametrize("name", RESULTS.split())
def test_every_result_is_listed(name: str) -> None:
    assert {field.name for field in dataclasses.fields(pkgutil.resolve_name(name)) if field.compare} <= NAMES


def test_every_column_is_listed() -> None:
    assert set(UNITS) | set(NUMBER_UNITS) | set(COLUMNS) <= NAMES


def test_units_of_dataset_columns_are_those_of_the_table() -> None:
    for name, unit in {**UNITS, **NUMBER_UNITS}.items():
        assert quantities()[name].unit == unit


def test_every_tuned_constant_states_its_basis() -> None:
    """The page is made from the comments of the source."""
    page = runpy.run_path(str(ROOT / "docs" / "make_constants.py"))["page"]()
    rows = [line.split(" | ") for line in page.splitlines() if line.startswith("| `")]
    assert sum(row[0].startswith("| `ehl/") for row in rows) > 20
    for module, name, value, basis in rows:
        assert len(basis) > 10, (module, name)
        assert value, (module, name)


# words of the field that lead to the code of a folder
WORDS = {
    "ehl": "half-space, boundary friction, Moes, Hertz",
    "ehl/smooth ehl/rough": "Reynolds equation, Poiseuille, Couette, cavitation",
    "ehl/rough ehl/surface": "JFO, Elrod-Adams, side flow, complementarity, asperity, Peklenik, correlation length",
    "ehl/fluid": "Ree-Eyring, Carreau, limiting shear stress, Roelands, Barus, Walther, Dowson-Higginson",
    "ehl/heat efficiency/loss": "flash temperature, Peclet, Jaeger, Blok, Coleman, Buckingham",
    "regression": "load sharing, film ratio, Sobol, conformal, convex hull, cross-validation, neural networks",
    "efficiency/contact efficiency/ltca": "ease-off, Litvin, TCA, LTCA, contact pattern, transmission error, Weber",
    "efficiency/blanks efficiency/cutting": "undercut, hypoid offset, spiral angle, cradle, tilt, swivel",
}


@pytest.mark.parametrize("places", WORDS)
def test_words_are_found_where_it_is_computed(places: str) -> None:
    files = [file for place in places.split() for file in sorted((ROOT / place).rglob("*.py"))]
    # a term may be broken over two lines of a docstring
    text = " ".join(" ".join(file.read_text(encoding="utf-8") for file in files).lower().split())
    assert [word for word in WORDS[places].split(", ") if word.lower() not in text] == []
