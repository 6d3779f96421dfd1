"""Every public object shows on a screen in a notebook, and is the same after pickle, copy and deepcopy."""

import copy
import json
import pickle
import tempfile
import tomllib
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import pytest
from samples import STEEL
from small_plans import GEAR_VARIABLES

import efficiency
import ehl
import regression
from efficiency.conditions.duty import DutyRow
from efficiency.contact.relief import FlankDeviation
from efficiency.design.design import load_design
from efficiency.design.shaft_input import Deflection, StiffnessInput
from efficiency.studies.parameter_study import Levels
from ehl.common.validation import validate

LIMIT = 1500  # characters
FOLDER = tempfile.TemporaryDirectory()  # removed at exit
BEVEL = "fm_spiral_bevel_14x39"
SHAFT = {"reference_point": 0.1, "shaft_diameter": 0.06, "bearings": [{"position": 0.15, "radial": 4e8, "axial": 2e8},
         {"position": 0.23, "radial": 3e8}]}  # fmt: skip
MOVED = ("deflection", "stiffness", "flank_deviation")
ONE_POINT = ((200.0,), (100.0,), (360.0,), (4e-7,))


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


@cache
def moved_mesh(kind: str) -> efficiency.Mesh:
    """A mesh with displacements under load, of stated shafts, or with deviations of the flanks."""
    design = load_design("fm_spiral_bevel_14x39_relieved")
    tables: dict[str, Any] = {
        "deflection": validate(Deflection, {"E": "-40 um", "P": "30 um", "torque": "300 N m"}),
        "stiffness": validate(StiffnessInput, {"pinion": SHAFT, "gear": SHAFT}),
        "flank_deviation": FlankDeviation(lengthwise_crowning=1e-5),
    }
    changed = design.assembly.model_copy(update={kind: tables[kind]})
    pair = efficiency.GearPair(design.model_copy(update={"assembly": changed}))
    return pair.mesh(positions=4, points_per_line=9)


@cache
def spur() -> efficiency.GearPair:
    return efficiency.load("fzg_c14")


@cache
def axle() -> efficiency.Axle:
    return efficiency.Axle("eaxle_helical", grid=(4, 9))


@cache
def run() -> regression.Run:
    return regression.sweep(plan(), FOLDER.name, jobs=1, formula="xu_kahraman_2007")


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
    "efficiency.EfficiencyResult.strength": lambda: gear_result().strength,
    **{f"efficiency.LoadedMesh, {kind}": partial(lambda kind: moved_mesh(kind).load(), kind) for kind in MOVED},
    "efficiency.GearPair.misalignment": lambda: efficiency.load(BEVEL).misalignment(E=["0 mm", "0.05 mm"]),
    "efficiency.GearPair.loss_map": lambda: efficiency.load(BEVEL).loss_map([100.0, 200.0], [50.0, 90.0], grid=(4, 9)),
    "efficiency.GearPair.duty": lambda: efficiency.load(BEVEL).duty([DutyRow(100.0, 90.0, 360.0, 1.0)], grid=(4, 9)),
    "efficiency.study": lambda: efficiency.study(
        [BEVEL], "75w90", Levels(*ONE_POINT, P=(0.0,), G=(0.0,), shaft_angle_error=(0.0,)), grid=(4, 9), jobs=1
    ),
    "efficiency.CylindricalPair": spur,
    "efficiency.CylindricalPair.mesh": lambda: spur().mesh(positions=4, points_per_line=9).load(),
    "efficiency.CylindricalPair.at": lambda: spur().at("75w90", grid=(4, 9)),
    "efficiency.Axle": axle,
    "efficiency.Axle.at": lambda: axle().at(50.0, 100.0, 350.0, "75w90"),
    "regression.Run": run,
    "regression.Dataset": lambda: run().dataset(),
    "regression.fit": lambda: regression.fit(run(), "power_law"),
}


@pytest.mark.parametrize("name", OBJECTS)
def test_copies_are_the_same(name: str) -> None:
    one = OBJECTS[name]()
    assert len(repr(one)) < LIMIT
    for copied in (copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))):
        other = copied(one)
        assert type(other) is type(one)
        assert repr(other) == repr(one)
        if hasattr(one, "to_dict"):
            assert json.dumps(other.to_dict(), default=str) == json.dumps(one.to_dict(), default=str)
        if isinstance(one, efficiency.Mesh | efficiency.LoadedMesh):  # also compute the same
            again, first = (x.load() if isinstance(x, efficiency.Mesh) else x for x in (other, one))
            assert again.efficiency("constant:0.05").power_loss == first.efficiency("constant:0.05").power_loss


@pytest.mark.parametrize(
    "name", ["ehl.ContactResult", "ehl.PathResult", "regression.Formula", "efficiency.Grid", "efficiency.blank"]
)
def test_a_notebook_shows_a_table(name: str) -> None:
    assert "<table" in OBJECTS[name]()._repr_html_()
