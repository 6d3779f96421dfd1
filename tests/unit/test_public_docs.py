"""Docstrings of the public interface: complete after numpydoc, and their examples run; objects in notebooks and copies.

Functions and classes that a package exports are held to all of `COMPLETE`; their methods to `DOCUMENTED`, as one line
says all there is to say of `to_dict`. Input models take their fields as keywords: those are in the table of inputs.
"""

import copy
import doctest
import importlib
import inspect
import json
import pickle
import re
import tempfile
import types
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path
from typing import Any

import pytest
from contacts import gear_state
from numpydoc.validate import validate as examined
from pydantic import BaseModel
from samples import STEEL, contact_case
from small_plans import gear_plan

import efficiency
import ehl
import regression
from efficiency.conditions.duty import DutyRow
from efficiency.contact.relief import FlankDeviation
from efficiency.design.design import load_design
from efficiency.design.shaft_input import Deflection, StiffnessInput
from efficiency.studies.parameter_study import Levels
from ehl.common.validation import validate

PACKAGES = ("ehl", "regression", "efficiency")
DOCUMENTED = {
    "GL03",  # double blank lines
    "GL08",  # no docstring
    "SS01",  # no summary
    "SS03",  # summary without full stop
    "PR02",  # unknown parameters documented
    "PR03",  # parameters in another order
    "PR04",  # parameter without type
}
COMPLETE = DOCUMENTED | {
    "GL07",  # sections out of order
    "PR01",  # parameters not documented
    "PR07",  # parameter without description
    "RT01",  # no Returns
    "YD01",  # no Yields
}
FIELDS = {"PR01", "PR02", "PR03"}  # of input models, whose signature is made of their fields


def public() -> Iterator[tuple[str, Any]]:
    """Every public name of the packages, and the public methods of public classes."""
    for package in PACKAGES:
        module = importlib.import_module(package)
        for name in module.__all__:
            thing = getattr(module, name)
            if isinstance(thing, str | types.ModuleType):
                continue
            yield f"{package}.{name}", thing
            if inspect.isclass(thing):
                for key, member in inspect.getmembers(thing):
                    target = member.fget if isinstance(member, property) else member
                    # not inherited from pydantic, pandas or the standard library
                    own = str(getattr(target, "__module__", "")).split(".")[0] in PACKAGES
                    if callable(target) and own and not key.startswith("_"):
                        yield f"{package}.{name}.{key}", member


PUBLIC = dict(public())
# what a reader of an example has imported
EXPORTED = {name.rpartition(".")[2]: thing for name, thing in PUBLIC.items() if name.count(".") == 1} | {
    package: importlib.import_module(package) for package in PACKAGES
}


def path_of(name: str) -> str:
    """Where the object is defined, as numpydoc imports it; methods by their class."""
    thing = PUBLIC[name]
    parent = PUBLIC.get(name.rpartition(".")[0])
    if parent is not None and inspect.isclass(parent):
        for cls in parent.__mro__:
            if name.rpartition(".")[2] in vars(cls):
                return f"{cls.__module__}.{cls.__qualname__}.{name.rpartition('.')[2]}"
    return f"{thing.__module__}.{thing.__qualname__}"


@pytest.mark.parametrize("package", PACKAGES)
def test_docstrings_of_a_package_are_complete(package: str) -> None:
    assert 5 <= len(importlib.import_module(package).__all__) <= 23
    for name in (name for name in PUBLIC if name.startswith(f"{package}.")):
        checked = COMPLETE if name.count(".") == 1 else DOCUMENTED
        if inspect.isclass(PUBLIC[name]) and issubclass(PUBLIC[name], BaseModel):
            checked = checked - FIELDS
        assert not [f"{code} {text}" for code, text in examined(path_of(name))["errors"] if code in checked], name


@pytest.mark.usefixtures("small_search")
@pytest.mark.parametrize("name", [name for name in PUBLIC if name.count(".") == 1])
def test_docstring_has_an_example_that_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    thing = PUBLIC[name]
    if inspect.isclass(thing) and issubclass(thing, Exception):
        return
    finder = doctest.DocTestFinder(recurse=inspect.isclass(thing), exclude_empty=True)
    tests = [test for test in finder.find(thing, name, globs=EXPORTED) if test.examples]
    assert tests, "no Examples section"
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    output: list[str] = []
    for test in tests:
        runner.run(test, out=output.append)
    assert runner.failures == 0, "".join(output)


def test_types_of_public_names_are_checked() -> None:
    """`mypy` of the gate checks the stubs strictly: a name is Any only where its module is left out of that."""
    for package in PACKAGES:
        module = importlib.import_module(package)
        for thing in (getattr(module, name) for name in module.__all__):
            defined = "ehl" if isinstance(thing, str) else thing.__module__
            assert defined.partition(".")[0] in PACKAGES
            assert not re.search(r"_kernels|ehl\.compile", defined)


LIMIT = 1500  # characters
FOLDER = tempfile.TemporaryDirectory()  # removed at exit
BEVEL = "fm_spiral_bevel_14x39"
SHAFT = {"reference_point": 0.1, "shaft_diameter": 0.06, "bearings": [{"position": 0.15, "radial": 4e8, "axial": 2e8},
         {"position": 0.23, "radial": 3e8}]}  # fmt: skip
MOVED = ("deflection", "stiffness", "flank_deviation")
ONE_POINT = ((200.0,), (100.0,), (360.0,), (4e-7,))
CONTACT = contact_case(lubricant={"oil": "75w90", "temperature_oil": 363.15}, model={"thermal": "off"})

# computed once, and by the first test that needs them
result = cache(lambda: CONTACT.solve())
plan = cache(lambda: regression.Plan.from_dict(gear_plan("small", {"size": 64, "seed": 1})))
run = cache(lambda: regression.sweep(plan(), FOLDER.name, jobs=1, formula="xu_kahraman_2007"))
mesh = cache(lambda: efficiency.load("fm_hypoid_13x42").mesh(positions=4, points_per_line=9))
gear_result = cache(lambda: mesh().load("250 N m").efficiency("75w90"))
spur = cache(lambda: efficiency.load("fzg_c14"))
axle = cache(lambda: efficiency.Axle("eaxle_helical", grid=(4, 9)))


def state(count: int = 500) -> ehl.ContactState:
    return gear_state(pressure_hertz=[1e9] * count, roughness_rms_1=0.0, roughness_rms_2=0.0)


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


OBJECTS: dict[str, Callable[[], Any]] = {
    "ehl.Contact": lambda: CONTACT,
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
