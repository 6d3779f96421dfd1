"""References of results: every law, formula and standard in use has an entry, every entry a use."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import get_args

import pytest

import efficiency
import ehl
from efficiency.axle.axle_input import MethodsInput
from ehl.common.data import data_path
from ehl.common.references import Citation
from regression.friction.published_registry import PUBLISHED

ENTRIES = tomllib.loads(data_path("references.toml").read_text(encoding="utf-8"))
CITED = {use for entry in ENTRIES.values() for use in entry["uses"]}


@pytest.mark.parametrize("name", ehl.shipped("oils"))
def test_laws_of_oils(name):
    oil = ehl.Oil.load(name)
    assert oil.lubricant(353.15).references() <= CITED


def test_published_formulas():
    assert {use for model in PUBLISHED.values() for use in model.references()} <= CITED


def test_methods_of_axles():
    methods = MethodsInput.model_fields.items()
    assert {f"{kind}:{name}" for kind, field in methods for name in get_args(field.annotation)} <= CITED


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


def test_text_and_bibtex():
    found = Citation.of(CITED)
    assert [*found.entries] == [*ENTRIES]
    assert found.text.count("\n") + 1 == found.bibtex.count("\n@") + 1 == len(ENTRIES)
    assert "@phdthesis{roelands_1966,\n  author = {Roelands, C. J. A.},\n" in found.bibtex


def test_citation_and_licence_are_those_of_the_package() -> None:
    root = Path(__file__).resolve().parents[2]
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = (root / "CITATION.cff").read_text(encoding="utf-8").splitlines()
    assert f"version: {project['version']}" in citation
    assert f"license: {project['license']}" in citation
    [licence] = project["license-files"]
    assert (root / licence).read_text(encoding="utf-8").startswith("BSD 3-Clause License")
