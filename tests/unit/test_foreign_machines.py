"""Containers, clusters and settings of other programs: what the machine grants, and what it lacks."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pytest
from small_plans import sweep_plan

from ehl import Oil
from ehl.common.figures import new_figure
from ehl.common.files import toml_text
from ehl.common.runner import _quotas, granted_workers
from ehl.common.sections import Picture

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

    told, warned = output("sweep", plan, "-o", run, "--jobs", "2")
    assert "16 converged" in told
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
    monkeypatch.setenv("SLURM_CPUS_ON_NODE", "3")
    assert granted_workers() == 3


def test_figures_do_not_depend_on_a_matplotlibrc(mixed_ehl: Any, tmp_path: Path) -> None:
    for name, settings in (("own", {}), ("foreign", {"text.usetex": True, "font.size": 30.0, "axes.grid": True})):
        with mpl.rc_context(settings):
            assert mixed_ehl("oil", "75w90", "--plot", tmp_path / f"{name}.png").code == 0
            assert Picture(lambda: new_figure(3.0 + 0.1 * mpl.rcParams["font.size"]), "").figure().get_figwidth() == 4.0
            assert Oil.load("75w90").plot().title.get_usetex() is False
    assert (tmp_path / "own.png").read_bytes() == (tmp_path / "foreign.png").read_bytes()
