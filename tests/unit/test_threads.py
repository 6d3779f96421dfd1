"""Every public computation runs with one thread of the linear algebra, and leaves the threads of its caller."""

import inspect
import os
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import efficiency
import ehl
import regression
from efficiency.conditions.duty import DutyRow
from ehl.common.runner import run_tasks
from ehl.common.threads import single_thread

SEVERAL = 3
DESIGN, TARGETS = "fm_spiral_bevel_14x39", "fh_spiral_bevel_12x37"
PAIR = efficiency.load(DESIGN)
AXLE = efficiency.Axle("truck_hypoid", grid=(4, 9))
MODEL = "xu_kahraman_2007"
POINT = {"pressure_hertz": 1e9, "radius_equivalent": 0.01, "effective_modulus": 226e9, "speed_entrainment": 5.0}
POINT |= {"slide_to_roll": 0.2, "temperature_oil": 363.15}
CONTACT = ehl.Contact(
    viscosity_inlet=0.04,
    pressure_viscosity="18 1/GPa",
    pressure_hertz="1 GPa",
    radius_equivalent="10 mm",
    speed_entrainment="5 m/s",
    slide_to_roll=0.2,
    thermal="off",
    accuracy="fast",
)
STATE = ehl.ContactState.of(**POINT, roughness_rms_1=3e-7, roughness_rms_2=3e-7)


class Reached(BaseException):
    """The function inside of a computation has been called; nothing on the way catches it."""


def threads() -> set[int]:
    """Numbers of threads of all libraries of linear algebra."""
    return {part["num_threads"] for part in threadpool_info() if part["user_api"] == "blas"}


def mesh() -> efficiency.Mesh:
    return PAIR.mesh("drive", 4, 9)


def loaded() -> efficiency.LoadedMesh:
    return mesh().load(200.0)


def result() -> efficiency.EfficiencyResult:
    return loaded().efficiency(MODEL)


GRID = {"grid": (4, 9)}
DUTY = [DutyRow(200.0, 125.0, 363.15, 1.0)]
# what is called, after what is made for it, and a function inside of it
COMPUTATIONS: dict[str, tuple[Callable[[], Any], Callable[[Any], Any], str]] = {
    "Contact.solve": (lambda: CONTACT, lambda c: c.solve(), "ehl.solve._solve"),
    "Contact.uncertainty": (lambda: CONTACT, lambda c: c.uncertainty(jobs=1), "ehl.solve._solve"),
    "solve_path": (lambda: [CONTACT] * 2, lambda c: ehl.solve_path(c), "ehl.solve._solve"),
    "Formula.mu": (
        lambda: regression.friction_model("75w90"),
        lambda f: f.mu(STATE, oil="75w90"),
        "regression.friction.fitted.friction_of_form",
    ),
    "Formula.uncertainty": (
        lambda: regression.friction_model("75w90"),
        lambda f: f.uncertainty(STATE, oil="75w90"),
        "regression.friction.fitted.friction_of_form",
    ),
    "fit": (
        lambda: "gear_fva3",
        lambda d: regression.fit(d, "power_law"),
        "regression.fitting.cross_validation.fit_form",
    ),
    "sweep": (
        lambda: regression.Plan.from_file("demo"),
        lambda plan: regression.sweep(plan, "nowhere"),
        "regression.sweeping.run.sweep_shard",
    ),
    "operating_range": (
        lambda: [regression.WeightedPoints(STATE, np.ones(1), ehl.Oil.load("fva3"))],
        regression.operating_range,
        "regression.plan.operating_range.conditions_of",
    ),
    "calibrate": (
        lambda: None,
        lambda _: regression.calibrate("none.csv", None),
        "regression.calibration.calibrate.setup_of",
    ),
    "blank": (lambda: "iso23509_f4", efficiency.blank, "efficiency.blanks.pair.load_blank"),
    "settings": (lambda: TARGETS, efficiency.settings, "efficiency.machine_settings.solve._fit"),
    "machine_corrections": (
        lambda: DESIGN,
        lambda d: efficiency.machine_corrections(d, ["none.csv"]),
        "efficiency.machine_settings.correction.read_point_grid",
    ),
    "sized_for_load": (
        lambda: TARGETS,
        efficiency.sized_for_load,
        "efficiency.optimisation.load_sizing.machine_settings",
    ),
    "optimise": (lambda: TARGETS, efficiency.optimise, "efficiency.optimisation.optimise.make_problem"),
    "study": (
        lambda: DESIGN,
        lambda d: efficiency.study([d], MODEL, jobs=1, **GRID),
        "efficiency.studies.parameter_study._solve",
    ),
    "demo": (lambda: "nowhere", efficiency.demo, "efficiency.studies.demonstration.make_folder"),
    "GearPair.mesh": (
        lambda: efficiency.load(DESIGN),
        lambda p: p.mesh("coast", 4, 9),
        "efficiency.mesh.elastic_teeth",
    ),
    "GearPair.at": (lambda: PAIR, lambda p: p.at(MODEL, **GRID), "efficiency.mesh.solve_balanced"),
    "GearPair.over": (lambda: PAIR, lambda p: p.over(MODEL, **GRID), "efficiency.mesh.solve_balanced"),
    "GearPair.duty": (lambda: PAIR, lambda p: p.duty(DUTY, MODEL, **GRID), "efficiency.mesh.solve_balanced"),
    "GearPair.duty_points": (lambda: PAIR, lambda p: p.duty_points(DUTY, **GRID), "efficiency.pair.loaded_points"),
    "GearPair.loss_map": (
        lambda: PAIR,
        lambda p: p.loss_map(100.0, 100.0, MODEL, **GRID),
        "efficiency.mesh.solve_balanced",
    ),
    "GearPair.axle_test": (
        lambda: PAIR,
        lambda p: p.axle_test("tandem", MODEL, **GRID),
        "efficiency.mesh.solve_balanced",
    ),
    "Axle.at": (lambda: AXLE, lambda a: a.at(200.0, 150.0, 353.15, MODEL), "efficiency.mesh.solve_balanced"),
    "Axle.map": (lambda: AXLE, lambda a: a.map(200.0, 150.0, 353.15, MODEL), "efficiency.mesh.solve_balanced"),
    "Axle.duty": (lambda: AXLE, lambda a: a.duty(DUTY, MODEL), "efficiency.mesh.solve_balanced"),
    "Axle.axle_test": (lambda: AXLE, lambda a: a.axle_test("tandem", MODEL), "efficiency.mesh.solve_balanced"),
    "GearPair.compare": (lambda: PAIR, lambda p: p.compare([MODEL], **GRID), "efficiency.mesh.compare_models"),
    "GearPair.geometry": (lambda: PAIR, lambda p: p.geometry(), "efficiency.geometry.pair_geometry.flank_pair"),
    "GearPair.misalignment": (
        lambda: PAIR,
        lambda p: p.misalignment(E=[0.0]),
        "efficiency.geometry.misalignment.misalignment_study",
    ),
    "GearPair.plot_contact": (lambda: PAIR, lambda p: p.plot_contact(), "efficiency.geometry.pair_geometry.flank_pair"),
    "GearPair.export": (
        lambda: PAIR,
        lambda p: p.export("nowhere", ("summary",)),
        "efficiency.output.files.export_design",
    ),
    "Mesh.of": (lambda: PAIR.design, lambda d: efficiency.Mesh.of(d, "drive", 4, 9), "efficiency.mesh.flank_pair"),
    "Mesh.load": (mesh, lambda m: m.load(123.0), "efficiency.mesh.load_grids"),
    "Mesh.load_from": (mesh, lambda m: m.load_from("none.csv"), "efficiency.mesh.read_load"),
    "Mesh.root_teeth": (mesh, lambda m: m.root_teeth(), "efficiency.mesh.root_tooth"),
    "Mesh.over": (mesh, lambda m: m.over(MODEL), "efficiency.mesh.solve_balanced"),
    "Mesh.map": (mesh, lambda m: m.map(MODEL), "efficiency.mesh.solve_balanced"),
    "LoadedMesh.efficiency": (loaded, lambda m: m.efficiency(MODEL), "efficiency.mesh.solve_balanced"),
    "LoadedMesh.compare": (loaded, lambda m: m.compare([MODEL]), "efficiency.mesh.compare_models"),
    "LoadedMesh.solve": (
        result,
        lambda r: r.source.solve(r.model, r.operation, r.card),
        "efficiency.mesh.solve_balanced",
    ),
    "LoadedMesh.strength_of": (result, lambda r: r.source.strength_of(r), "efficiency.mesh.rate_strength"),
    "EfficiencyResult.uncertainty": (
        result,
        lambda r: r.uncertainty(),
        "efficiency.loss.uncertainty.efficiency_uncertainty",
    ),
    "EfficiencyResult.strength": (result, lambda r: r.strength, "efficiency.mesh.rate_strength"),
}
# public functions and methods that read, write or describe
OTHERS = {
    "measured_surface",
    *("load", "cylindrical", "new_file", "new_questions", "import_design", "doctor", "warmup", "serve_app"),
    *("shipped", "quantity", "load_dataset", "friction_model", "published", "slurm_script"),
    *("GearPair.check", "GearPair.misaligned", "GearPair.finished", "GearPair.sharing_bodies"),
    "LoadedMesh.write_load",
    *("EfficiencyResult.with_inputs", "EfficiencyResult.scalars", "EfficiencyResult.to_dict"),
    "EfficiencyResult.to_frame",
}


@pytest.mark.parametrize("name", COMPUTATIONS)
def test_one_thread_inside_and_those_of_the_caller_after(
    name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    make, call, inner = COMPUTATIONS[name]
    monkeypatch.chdir(tmp_path)
    argument, found = make(), []

    def reached(*arguments: Any, **options: Any) -> Any:
        found.append(threads())
        raise Reached

    module, _, function = inner.rpartition(".")
    monkeypatch.setattr(import_module(module), function, reached)
    with threadpool_limits(SEVERAL, "blas"):
        with pytest.raises(Reached):
            call(argument)
        assert threads() == {SEVERAL}
    assert found == [{1}]


def test_every_public_computation_is_in_the_table() -> None:
    classes = (
        efficiency.Axle,
        efficiency.GearPair,
        efficiency.Mesh,
        efficiency.LoadedMesh,
        efficiency.EfficiencyResult,
    )
    public = {
        name
        for package in (ehl, regression, efficiency)
        for name in package.__all__
        if inspect.isfunction(getattr(package, name))
    }
    for made in classes:
        own = [(name, part) for name, part in vars(made).items() if not name.startswith("_")]
        public |= {f"{made.__name__}.{n}" for n, part in own if inspect.isfunction(getattr(part, "__func__", part))}
    assert public - OTHERS - COMPUTATIONS.keys() == set()


def _threads_of_task(task: int) -> set[int]:
    return threads()


@pytest.mark.parametrize("jobs", [1, 2])
def test_one_thread_in_every_task(jobs: int) -> None:
    with threadpool_limits(SEVERAL, "blas"):
        assert list(run_tasks([1, 2, 3], _threads_of_task, jobs=jobs)) == [{1}] * 3
        assert threads() == {SEVERAL}


def test_blocks_inside_of_each_other_and_a_library_loaded_meanwhile() -> None:
    """The BLAS of SciPy, loaded inside of a computation, has one thread there and those of NumPy afterwards."""
    code = """
from threadpoolctl import threadpool_info, threadpool_limits
import numpy
from ehl.common.threads import single_thread
def threads():
    return [part["num_threads"] for part in threadpool_info() if part["user_api"] == "blas"]
threadpool_limits(3)
with single_thread():
    with single_thread():
        import scipy.linalg
        print(*threads())
    print(*threads())
print(*threads())
"""
    surrounding = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    run = subprocess.run([sys.executable, "-c", code], env=surrounding, capture_output=True, text=True, check=True)
    assert run.stdout.split("\n")[:3] in (["1 1", "1 1", "3 3"], ["1", "1", "3"])


def test_variables_are_those_of_before() -> None:
    before = dict(os.environ)
    with single_thread():
        assert os.environ["OPENBLAS_NUM_THREADS"] == "1"
    assert dict(os.environ) == before
