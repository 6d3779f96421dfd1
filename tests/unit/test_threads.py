"""Threads of the linear algebra in every public computation; containers, clusters and settings of other programs."""

import inspect
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pytest
from samples import contact_case
from small_plans import sweep_plan
from threadpoolctl import threadpool_info, threadpool_limits

import efficiency
import ehl
import regression
from ehl import Oil
from ehl.common.figures import new_figure
from ehl.common.files import toml_text
from ehl.common.runner import _quotas, granted_workers, run_tasks
from ehl.common.sections import Picture
from ehl.common.threads import one_thread, single_thread

SEVERAL = 3
DESIGN = "fm_spiral_bevel_14x39"
PAIR = efficiency.load(DESIGN)
MODEL = "xu_kahraman_2007"
CONTACT = contact_case(model={"thermal": "off", "accuracy": "fast"})


class Reached(BaseException):
    """The function inside of a computation has been called; nothing on the way catches it."""


def threads() -> set[int]:
    """Numbers of threads of all libraries of linear algebra."""
    return {part["num_threads"] for part in threadpool_info() if part["user_api"] == "blas"}


def loaded() -> efficiency.LoadedMesh:
    return PAIR.mesh("drive", 4, 9).load(200.0)


# computations that are decorated further inside, and one that is decorated itself: what is made, what is called with it
# and a function inside of that
COMPUTATIONS: dict[str, tuple[Callable[[], Any], Callable[[Any], Any], str]] = {
    "Contact.solve": (lambda: CONTACT, lambda c: c.solve(), "ehl.solve._solve"),
    "Contact.uncertainty": (lambda: CONTACT, lambda c: c.uncertainty(jobs=1), "ehl.solve._solve"),
    "solve_path": (lambda: [CONTACT] * 2, lambda c: ehl.solve_path(c), "ehl.solve._solve"),
    "GearPair.mesh": (lambda: efficiency.load(DESIGN), lambda p: p.mesh("coast"), "efficiency.mesh.elastic_teeth"),
    "GearPair.compare": (
        *(lambda: PAIR, lambda p: p.compare([MODEL], grid=(4, 9)), "efficiency.loss.compare.compare_models"),
    ),
    "GearPair.plot_contact": (lambda: PAIR, lambda p: p.plot_contact(), "efficiency.geometry.pair_geometry.flank_pair"),
    "EfficiencyResult.strength": (
        *(lambda: loaded().efficiency(MODEL), lambda r: r.strength, "efficiency.mesh.kept_of_design"),
    ),
    "LoadedMesh.efficiency": (loaded, lambda m: m.efficiency(MODEL), "efficiency.mesh.solve_friction"),
}
# public functions and methods that read, write or describe
OTHERS = {
    "measured_surface",
    *("load", "cylindrical", "new_file", "new_questions", "import_design", "doctor", "warmup", "serve_app"),
    *("shipped", "quantity", "load_dataset", "friction_model", "published", "slurm_script"),
    "Axle.with_methods",
    *("GearPair.check", "GearPair.misaligned", "GearPair.finished", "GearPair.sharing_bodies"),
    "LoadedMesh.write_load",
    *(f"EfficiencyResult.{name}" for name in ("with_inputs", "value", "scalars", "to_dict")),
    *("EfficiencyResult.to_frame", "EfficiencyResult.references"),
}


@pytest.mark.parametrize("name", COMPUTATIONS)
def test_one_thread_inside_those_of_the_caller_after(name, monkeypatch, tmp_path):
    make, call, inner = COMPUTATIONS[name]
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MIXED_EHL_CACHE", "off")
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


# code that the decorator gives every function
DECORATED = one_thread(lambda: None).__code__


def decorated(function: Any) -> bool:
    """Whether a function, below what wraps it, is decorated with `one_thread`."""
    return inspect.unwrap(function, stop=lambda part: part.__code__ is DECORATED).__code__ is DECORATED


def test_every_public_computation_has_one_thread() -> None:
    classes = (efficiency.Axle, efficiency.GearPair, efficiency.Mesh, efficiency.LoadedMesh)
    public = {
        name: getattr(package, name)
        for package in (ehl, regression, efficiency)
        for name in package.__all__
        if inspect.isfunction(getattr(package, name))
    }
    for made in (*classes, efficiency.EfficiencyResult):
        own = {n: getattr(part, "__func__", part) for n, part in vars(made).items() if not n.startswith("_")}
        public |= {f"{made.__name__}.{n}": part for n, part in own.items() if inspect.isfunction(part)}
    public |= {f"Formula.{name}": getattr(regression.Formula, name) for name in ("mu", "uncertainty")}
    assert [name for name in public.keys() - OTHERS - COMPUTATIONS.keys() if not decorated(public[name])] == []


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


TESTS = Path(__file__).parents[1]


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
@pytest.mark.parametrize("lacks", ["SEMAPHORES=ENOSYS", "SEMAPHORES=EACCES", "LOCKS=ENOLCK"])
def test_a_machine_without_semaphores_or_locks(lacks: str, tmp_path: Path) -> None:
    """Without semaphores a sweep runs in one process, with a note; without locks it runs as usual, and again."""
    library, plan, run = tmp_path / "bare.so", tmp_path / "plan.toml", tmp_path / "run"
    subprocess.run(["cc", f"-D{lacks}", "-shared", "-fPIC", "-o", library, TESTS / "bare_machine.c"], check=True)
    content = sweep_plan("serial", accuracy="fast")
    del content["variables"]["roughness_rms"]  # smooth contacts: milliseconds each
    plan.write_text(toml_text(content), encoding="utf-8")
    program = [sys.executable, "-c", "from efficiency.cli import main; main()"]

    def output(*arguments: Any) -> tuple[str, str]:
        environment = os.environ | {"LD_PRELOAD": str(library)}
        ended = subprocess.run([*program, *arguments], env=environment, capture_output=True, text=True)
        assert ended.returncode == 0, ended.stderr
        return ended.stdout, ended.stderr

    printed, warned = output("sweep", plan, "-o", run, "--jobs", "2")
    assert "16 converged" in printed
    assert ("semaphores" in warned) == lacks.startswith("SEMAPHORES")
    if lacks.startswith("LOCKS"):
        assert "16 found on disk" in output("sweep", plan, "-o", run, "--jobs", "2")[0]


def test_quotas_of_all_groups_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = tmp_path / "slurm" / "job"
    own.mkdir(parents=True)
    (tmp_path / "cpu.max").write_text("max 100000\n")
    (tmp_path / "slurm" / "cpu.max").write_text("150000 100000\n")
    (own / "cpu.max").write_text("50000 100000\n")
    groups = tmp_path / "cgroup"
    groups.write_text("1:cpu:/\n0::/slurm/job\n")
    assert list(_quotas(groups, tmp_path)) == [1, 2]
    assert list(_quotas(tmp_path / "none", tmp_path)) == []
    monkeypatch.setattr("joblib.externals.loky.cpu_count", lambda: 64)
    monkeypatch.setattr("ehl.common.runner._quotas", lambda *places: iter([8]))
    for name, workers in (("SLURM_CPUS_ON_NODE", 7), ("SLURM_CPUS_PER_TASK", 6), ("OMP_THREAD_LIMIT", 3)):
        monkeypatch.setenv(name, str(workers))
        assert granted_workers() == workers


def test_figures_do_not_depend_on_a_matplotlibrc(mixed_ehl: Any, tmp_path: Path) -> None:
    for name, settings in (("own", {}), ("foreign", {"text.usetex": True, "font.size": 30.0, "axes.grid": True})):
        with mpl.rc_context(settings):
            assert mixed_ehl("oil", "75w90", "--plot", tmp_path / f"{name}.png").code == 0
            assert Picture(lambda: new_figure(3.0 + 0.1 * mpl.rcParams["font.size"]), "").figure().get_figwidth() == 4.0
            assert Oil.load("75w90").plot().title.get_usetex() is False
    assert (tmp_path / "own.png").read_bytes() == (tmp_path / "foreign.png").read_bytes()
