"""What a notebook shows of every public object fits on a screen."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from samples import STEEL
from small_plans import GEAR_VARIABLES

import ehl
import regression
from ehl.io.validation import validate

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
}


@pytest.mark.parametrize("name", OBJECTS)
def test_repr_is_short(name: str) -> None:
    text = repr(OBJECTS[name]())
    assert len(text) < LIMIT, f"{len(text)} characters: {text[:200]}"
    assert str(Path.cwd()) not in text
