"""What a notebook shows of every public object fits on a screen."""

import tomllib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from samples import STEEL
from small_plans import GEAR_VARIABLES

import efficiency
import ehl
import regression
from ehl.common.validation import validate

LIMIT = 1500  # characters


@cache
def contact() -> ehl.Contact:
    return ehl.Contact(
        oil="75w90", temperature_oil="90 degC", pressure_hertz="1.2 GPa", radius_equivalent="15 mm",
        speed_entrainment="5 m/s", slide_to_roll=0.2, thermal="off",
    )  # fmt: skip


@cache
def result() -> ehl.ContactResult:
    return contact().solve()


def state(count: int = 500) -> ehl.ContactState:
    return ehl.ContactState.of(
        pressure_hertz=[1e9] * count, radius_equivalent=0.01, effective_modulus=226e9, speed_entrainment=2.0
    )


def plan() -> regression.Plan:
    text = 'name = "small"\n[sampling]\nsize = 64\nseed = 1\n' + GEAR_VARIABLES
    return validate(regression.Plan, tomllib.loads(text))


@cache
def mesh() -> efficiency.Mesh:
    return efficiency.load("fm_hypoid_13x42").mesh(positions=4, points_per_line=9)


@cache
def gear_result() -> efficiency.EfficiencyResult:
    return mesh().load("250 N m").efficiency("75w90")


OBJECTS: dict[str, Callable[[], Any]] = {
    "ehl.Contact": contact,
    "ehl.ContactResult": result,
    "ehl.ContactResult.table": lambda: result().table(),
    "ehl.ContactState": state,
    "ehl.PathResult": lambda: ehl.solve_path(state(3), ehl.Oil.load("75w90")),
    "ehl.Oil": lambda: ehl.Oil.load("75w90"),
    "ehl.Lubricant": lambda: ehl.Oil.load("75w90").at(363.15),
    "ehl.Material": lambda: STEEL,
    "ehl.quantity": lambda: ehl.quantity("pressure_hertz"),
    "regression.Plan": plan,
    "regression.Formula": lambda: regression.friction_model("75w90"),
    "regression.friction_model": lambda: regression.friction_model("xu_kahraman_2007"),
    "regression.published": lambda: regression.published(),
    "efficiency.GearPair": lambda: efficiency.load("fm_hypoid_13x42"),
    "efficiency.Mesh": mesh,
    "efficiency.LoadedMesh": lambda: mesh().load("250 N m"),
    "efficiency.EfficiencyResult": gear_result,
    "efficiency.EfficiencyResult.uncertainty": lambda: gear_result().uncertainty(),
    "efficiency.Grid": lambda: mesh().over("75w90", torque="250 N m", speed=["500 rpm", "1500 rpm"]),
    "efficiency.LoadedMesh.compare": lambda: mesh().load("250 N m").compare(["constant:0.05", "75w90"]),
    "efficiency.blank": lambda: efficiency.blank("iso23509_f4"),
}


@pytest.mark.parametrize("name", OBJECTS)
def test_repr_is_short(name: str) -> None:
    text = repr(OBJECTS[name]())
    assert len(text) < LIMIT, f"{len(text)} characters: {text[:200]}"
    assert str(Path.cwd()) not in text


RESULTS = (
    "ehl.ContactResult", "ehl.PathResult", "regression.Formula", "efficiency.EfficiencyResult",
    "efficiency.EfficiencyResult.uncertainty", "efficiency.Grid",
    "efficiency.LoadedMesh.compare", "efficiency.blank",
)  # fmt: skip


@pytest.mark.parametrize("name", RESULTS)
def test_a_notebook_shows_a_table(name: str) -> None:
    assert "<table" in OBJECTS[name]()._repr_html_()
