"""A sweep on a real dask cluster of processes: the same data, deadly cases found, time caps kept, clear words."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest
from refusals import refuses
from small_plans import sweep_plan

from ehl.common import dask_workers
from ehl.common.dask_workers import ClusterLost, DaskCluster, dask_executor
from ehl.common.progress import Progress
from ehl.common.runner import Executor
from ehl.common.validation import validate
from ehl.contact import Contact
from regression.data.dataset import load_dataset
from regression.plan.plan import Plan
from regression.sweeping.evaluators import CaseRunner, CaseTask, Outputs, published_outputs
from regression.sweeping.sweep import sweep_shard

XU = partial(published_outputs, name="xu_kahraman_2007")


@pytest.fixture(scope="module", autouse=True)
def _untraced_workers() -> Iterator[None]:
    """Coverage does not trace workers: two traced threads can wait for each other without end in CPython 3.11."""
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("COVERAGE_PROCESS_CONFIG", raising=False)
        yield


@pytest.fixture(scope="module")
def cluster(_untraced_workers: None) -> Iterator[Executor]:
    with dask_executor("local:2") as executor:
        yield executor


@pytest.fixture
def plan() -> Plan:
    return validate(Plan, sweep_plan("dask"))


def test_a_cluster_gives_the_data_of_one_process_and_resumes(plan: Plan, tmp_path: Path, cluster: Executor) -> None:
    report = sweep_shard(plan, tmp_path / "dask", evaluate=XU, executor=cluster)
    assert (report.converged, report.restarts) == (16, 0)
    sweep_shard(plan, tmp_path / "one", evaluate=XU)
    assert load_dataset(tmp_path / "dask").data_hash == load_dataset(tmp_path / "one").data_hash
    assert sweep_shard(plan, tmp_path / "dask", evaluate=XU, executor=cluster).resumed == 16


def test_a_case_that_always_kills_its_worker_is_lost(plan: Plan, tmp_path: Path, cluster: Executor) -> None:
    slow, deadly = sorted(case.contact.slide_to_roll for _, case in plan.cases())[-2:]

    # a local function: workers get it by value, they cannot import this module
    def evaluate(case: Contact) -> Outputs:
        if case.contact.slide_to_roll == deadly:
            os.kill(os.getpid(), signal.SIGKILL)
        if case.contact.slide_to_roll == slow:
            end = time.monotonic() + 60.0
            while time.monotonic() < end:
                pass
        return XU(case)

    report = sweep_shard(plan, tmp_path, evaluate=evaluate, executor=cluster, time_cap=0.3)
    frame = load_dataset(tmp_path).frame.set_index("slide_to_roll")
    # in the thread of a worker no alarm clock rings, and the cap holds all the same
    assert frame.loc[[deadly, slow], "reason"].tolist() == ["worker_lost", "time_cap"]
    assert frame.loc[slow, "seconds"] < 30.0
    assert report.converged == 14


@pytest.mark.parametrize("stage", ["with its first case", "with its result in hand", "with the last case"])
def test_a_worker_that_dies_once_costs_no_case(plan: Plan, tmp_path: Path, cluster: Executor, stage: str) -> None:
    sides = sorted(case.contact.slide_to_roll for _, case in plan.cases())
    done, victim = str(tmp_path / "done"), sides[-1] if "last" in stage else sides[0]

    def evaluate(case: Contact) -> Outputs:
        if case.contact.slide_to_roll == victim and not os.path.exists(done):
            Path(done).touch()
            if "result" in stage:
                # after the answer, while it may be on its way
                threading.Timer(0.02, os.kill, (os.getpid(), signal.SIGKILL)).start()
            else:
                os.kill(os.getpid(), signal.SIGKILL)
        return XU(case)

    report = sweep_shard(plan, tmp_path / "dask", evaluate=evaluate, executor=cluster)
    assert report.converged == 16
    assert os.path.exists(done)
    sweep_shard(plan, tmp_path / "one", evaluate=XU)
    assert load_dataset(tmp_path / "dask").data_hash == load_dataset(tmp_path / "one").data_hash


def test_another_version(plan: Plan, tmp_path: Path, cluster: Executor, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_workers, "__version__", "9.9")
    with refuses("dask"):
        sweep_shard(plan, tmp_path, evaluate=XU, executor=cluster)


# a client whose cluster has no workers, or no scheduler any more
@pytest.mark.parametrize("status", ["running", "closed"])
def test_a_cluster_that_is_gone_is_said(plan: Plan, status: str) -> None:
    _, case = next(plan.cases())
    cluster = DaskCluster(SimpleNamespace(status=status, nthreads=dict), worker_timeout=0.0)
    rows = cluster(iter([(0, CaseTask("k", "sobol", case))]), CaseRunner(XU), None)
    with pytest.raises(ClusterLost):
        next(iter(rows))


def test_a_killed_scheduler_is_said_and_the_rest_is_resumed(plan: Plan, tmp_path: Path) -> None:
    """Scheduler and worker are processes of their own; kill -9 of the scheduler keeps every finished case."""
    place, run = tmp_path / "scheduler.json", tmp_path / "run"
    options = ["--scheduler-file", str(place), "--no-dashboard"]

    def started(module: str, *more: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.{module}", *options, *more]
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def evaluate(case: Contact) -> Outputs:
        time.sleep(0.3)
        return XU(case)

    def seen(progress: Progress) -> None:
        if progress.done >= 3:
            scheduler.kill()

    scheduler, worker = started("dask_scheduler", "--port", "0"), started("dask_worker", "--nworkers", "1")

    try:
        end = time.monotonic() + 120.0
        while not place.exists() and time.monotonic() < end:
            time.sleep(0.1)
        with dask_executor(str(place)) as executor:
            with pytest.raises(ClusterLost) as lost:
                sweep_shard(plan, run, evaluate=evaluate, executor=executor, progress=seen)
            assert lost.value.exit_code == 1
    finally:
        for process in (scheduler, worker):
            process.kill()
            process.wait()
    report = sweep_shard(plan, run, evaluate=XU)
    assert report.resumed >= 3
    sweep_shard(plan, tmp_path / "one", evaluate=XU)
    assert load_dataset(run).data_hash == load_dataset(tmp_path / "one").data_hash


@pytest.mark.parametrize("address", ["local:none", "local:0", "tcp://127.0.0.1:1", "nofile.json", "nonsense://x"])
def test_bad_addresses(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_workers, "CONNECT", 1)
    with refuses("dask"), dask_executor(address):
        pass
    monkeypatch.setitem(sys.modules, "distributed", None)
    with refuses("dask"), dask_executor("local:1"):
        pass
