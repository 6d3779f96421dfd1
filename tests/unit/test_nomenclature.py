"""Keys and results are in the table of quantities, constants state their basis, laws and standards have references."""

import ast
import dataclasses
import pkgutil
import runpy
import tomllib
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

import pytest
from pydantic import BaseModel

import efficiency
import efficiency.axle.bearings
import ehl
from efficiency.axle.axle_input import MethodsInput
from ehl.common.data import Citation, _sentences, data_path
from ehl.common.quantities import quantities
from regression.calibration.measurement import COLUMNS
from regression.data.result_files import NUMBER_UNITS
from regression.friction.conditions import UNITS
from regression.friction.published_registry import PUBLISHED
from regression.plan.sampling import VARIABLES, WINDOWS

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


def test_every_column_is_listed_with_its_unit() -> None:
    assert {*UNITS, *NUMBER_UNITS, *COLUMNS, *VARIABLES, *WINDOWS} <= NAMES
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


ENTRIES = tomllib.loads(data_path("references.toml").read_text(encoding="utf-8"))
CITED = {use for entry in ENTRIES.values() for use in entry["uses"]}


def test_every_law_formula_and_method_has_its_reference() -> None:
    used = {use for name in ehl.shipped("oils") for use in ehl.Oil.load(name).lubricant(353.15).references()}
    used |= {use for model in PUBLISHED.values() for use in model.references()}
    methods = MethodsInput.model_fields.items()
    assert used | {f"{kind}:{name}" for kind, field in methods for name in get_args(field.annotation)} <= CITED


def test_a_pair_and_a_map():
    mesh = efficiency.load("fm_spiral_bevel_14x39").mesh(positions=4, points_per_line=9)
    constant = mesh.load("300 N m").efficiency("constant:0.05", speed="1500 rpm").citation()
    grid = mesh.over("xu_kahraman_2007", torque="200, 300 N m", speed=["500 rpm"]).citation()
    assert {"kolivand_2010", "iso_23509"} <= {*constant.entries}
    assert {*grid.entries} - {*constant.entries} == {"xu_kahraman_2007"}


def test_an_axle_and_loss_maps():
    """They cite what their points cite, with the laws of the oil."""
    laws = ehl.Oil.load("75w90").lubricant(353.15).references()
    axle = efficiency.Axle("truck_hypoid", grid=(4, 9))
    found = axle.map("100, 200 N m", "1500 rpm", "80 degC", "xu_kahraman_2007")
    loss_map = axle.pair.loss_map("100 N m", "500 rpm", "xu_kahraman_2007", grid=(4, 9))
    for result in (found, found.loss_map(), loss_map, axle.at("0 N m", "500 rpm", "80 degC")):
        assert laws <= result.references()
        result.citation()
    assert "friction:xu_kahraman_2007" in found.loss_map().references() & loss_map.references()
    assert {"bearings:skf", "churning:changenet_velex", "seals:linke"} <= found.loss_map().references()


def test_text_and_bibtex_citation_and_licence() -> None:
    found = Citation.of(CITED)
    assert [*found.entries] == [*ENTRIES]
    assert found.text.count("\n") + 1 == found.bibtex.count("\n@") + 1 == len(ENTRIES)
    assert "@phdthesis{roelands_1966,\n  author = {Roelands, C. J. A.},\n" in found.bibtex
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8").splitlines()
    assert f"version: {project['version']}" in citation
    assert f"license: {project['license']}" in citation
    [licence] = project["license-files"]
    assert (ROOT / licence).read_text(encoding="utf-8").startswith("BSD 3-Clause License")


RAISED = {"ConvergenceError", "NewtonFailure"}
LISTS = {"REASONS", "Reason", "FALLBACKS", "FINAL_REASONS", "TIME_CAP", "WORKER_CRASHED"}


def reasons() -> set[str]:
    """Codes of errors, of the lists of reasons, and of `reason=` arguments."""
    found: set[str] = set()
    for path in (path for package in ("ehl", "regression", "efficiency") for path in (ROOT / package).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            parts: list[ast.expr] = []
            if isinstance(node, ast.Call):
                parts = [keyword.value for keyword in node.keywords if keyword.arg == "reason"]
                parts += node.args[:1] if getattr(node.func, "id", "") in RAISED else []
            elif isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") in LISTS:
                parts = [each for each in ast.walk(node.value) if isinstance(each, ast.Constant)]
            found |= {p.value for p in parts if isinstance(p, ast.Constant) and isinstance(p.value, str)}
    return {text.partition(":")[0] for text in found if text}


def test_every_reason_has_a_sentence() -> None:
    assert len(reasons()) > 50
    assert not reasons() - _sentences().keys()
    assert all(" " in sentence for sentence in _sentences().values())
