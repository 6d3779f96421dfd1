"""A sweep, also on a real dask cluster: every case ends as a row; crashes, fallbacks, time caps, order and progress."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import Mock

import numpy as np
import pandas as pd
import pytest
from refusals import refuses
from small_plans import sweep_plan

from ehl.common import dask_workers
from ehl.common.dask_workers import ClusterLost, DaskCluster, dask_executor
from ehl.common.data import data_path
from ehl.common.errors import ConvergenceError
from ehl.common.journal import Journal
from ehl.common.progress import Progress
from ehl.common.runner import MAX_CRASHES, AllWorkersCrashed, Numbered, WorkersCrashed, checked_jobs, run_tasks
from ehl.common.validation import validate
from ehl.contact import Contact
from ehl.inputs import ModelInput
from regression.data.dataset import load_dataset, run_status
from regression.data.result_files import merge
from regression.plan.cost import contact_seconds
from regression.plan.plan import Plan
from regression.sweeping.evaluators import CaseRunner, CaseTask, Outputs, case_key, fallback_settings, published_outputs
from regression.sweeping.slurm import slurm_script
from regression.sweeping.sweep import sweep_shard

XU = partial(published_outputs, name="xu_kahraman_2007")


def make_plan(**model: Any) -> Plan:
    return validate(Plan, sweep_plan("sweep", **model))


@pytest.fixture
def plan() -> Plan:
    return make_plan()


@dataclass
class Fragile:
    """Workers that die at some cases, and take all that is in flight with them."""

    deadly: set[float]
    depth: int = 4
    handed_out: list[int] = field(default_factory=list)

    def __call__(self, tasks: Iterator[Numbered], work: Any, time_cap: float | None = None) -> Iterator[Numbered]:
        waiting: list[Numbered] = []
        for task in tasks:
            waiting.append(task)
            if len(waiting) == self.depth:
                yield self._work(*waiting.pop(0), work)
        for task in waiting:
            yield self._work(*task, work)

    def _work(self, number: int, task: CaseTask, work: Any) -> Numbered:
        self.handed_out.append(number)
        if task.case.contact.slide_to_roll in self.deadly:
            raise WorkersCrashed
        return number, work(task)


def ratios(plan: Plan) -> list[float]:
    return [case.contact.slide_to_roll for _, case in plan.cases()]


@pytest.mark.parametrize("count", [1, 3, MAX_CRASHES + 2])
def test_only_the_cases_that_kill_are_lost(plan: Plan, tmp_path: Path, count: int) -> None:
    deadly = set(ratios(plan)[1 : 2 * count : 2])
    report = sweep_shard(plan, tmp_path, evaluate=XU, executor=Fragile(deadly))
    frame = load_dataset(tmp_path).frame
    assert set(frame[frame["reason"] == "worker_lost"]["slide_to_roll"]) == deadly
    assert report.reasons_failed == {"worker_lost": len(deadly)}
    assert report.converged == 16 - len(deadly)
    assert report.restarts > len(deadly)


def test_workers_that_always_die_end_the_sweep_and_blame_no_case(plan: Plan, tmp_path: Path) -> None:
    executor = Fragile(set(ratios(plan)))
    with pytest.raises(AllWorkersCrashed) as caught:
        sweep_shard(plan, tmp_path, evaluate=XU, executor=executor)
    assert caught.value.exit_code == 1
    assert len(executor.handed_out) < 16
    # a few that all kill are recorded
    report = sweep_shard(plan, tmp_path / "few", evaluate=XU, executor=executor, shard=(2, 8))
    assert report.reasons_failed == {"worker_lost": 2}
    assert sweep_shard(plan, tmp_path, evaluate=XU).converged == 16


def needs(accuracy: str, seen: list[str] | None = None) -> Any:
    def evaluate(case: Contact) -> Outputs:
        if seen is not None:
            seen.append(case.model.accuracy)
        if case.model.accuracy != accuracy:
            raise ConvergenceError("diverged")
        return XU(case)

    return evaluate


def test_the_ladder_of_safer_settings() -> None:
    case = make_plan(accuracy="fast").case_at(0)
    steps = [setting for step in range(6) if (setting := fallback_settings(case, step))]
    ladder = [(safer.model.accuracy, safer.model.shortcuts) for safer, _ in steps]
    assert ladder == [("fast", "auto"), ("standard", "auto"), ("reference", "auto"), ("reference", "off")]
    assert steps[0][1] == ""
    assert steps[3][1] == "accuracy=reference shortcuts=off"
    safest = make_plan(accuracy="reference", shortcuts="off").case_at(0)
    assert fallback_settings(safest, 0) == (safest, "")
    assert fallback_settings(safest, 1) is None


def test_retrying_failed_cases_goes_on_where_the_ladder_ended(tmp_path: Path) -> None:
    plan = make_plan(accuracy="fast")
    assert sweep_shard(plan, tmp_path, evaluate=needs("reference"), retries=1).failed == 16
    failed = run_status(tmp_path).failed
    assert {(case.reason, case.attempts) for case in failed} == {("diverged", 2)}
    assert failed[0].conditions["roughness_rms"] == pytest.approx(0.4e-6)
    seen: list[str] = []
    again = sweep_shard(plan, tmp_path, evaluate=needs("reference", seen), retries=1, retry_failed=True)
    assert (again.converged, again.failed, again.fallback) == (16, 0, 16)
    assert set(seen) == {"reference"}
    frame = load_dataset(tmp_path).frame
    assert set(zip(frame["attempts"], frame["setting"], strict=True)) == {(3.0, "accuracy=reference")}
    assert run_status(tmp_path).failed == ()


def test_a_case_with_nothing_left_to_try_keeps_its_reason(tmp_path: Path) -> None:
    plan = make_plan(accuracy="reference", shortcuts="off")
    assert sweep_shard(plan, tmp_path, evaluate=needs("fast"), retries=3).reasons_failed == {"diverged": 16}
    again = sweep_shard(plan, tmp_path, evaluate=XU, retry_failed=True)
    assert (again.resumed, again.converged) == (16, 0)
    assert {case.attempts for case in run_status(tmp_path).failed} == {1}
    # physical failures are not tried again
    hot = Mock(side_effect=ConvergenceError("too_hot"))
    row = CaseRunner(hot, None, 3)(CaseTask("k", "sobol", make_plan(accuracy="fast").case_at(0)))
    assert (row["reason"], row["attempts"], hot.call_count) == ("too_hot", 1, 1)


@pytest.mark.skipif(sys.gettrace() is not None, reason="does not end in a traced thread of Python 3.11")
def test_the_cap_holds_in_a_thread_and_ends_with_the_case() -> None:
    case = make_plan().case_at(0)
    rows: list[dict[str, Any]] = []

    def hang(case: Contact) -> Outputs:
        end = time.monotonic() + 30.0
        while time.monotonic() < end:
            pass
        return XU(case)

    def worker() -> None:
        rows.append(CaseRunner(hang, 0.1)(CaseTask("a", "sobol", case)))
        # nothing of the first cap reaches the next case
        rows.extend(CaseRunner(XU, 10.0)(CaseTask("b", "sobol", case)) for _ in range(50))
        time.sleep(1.2)

    thread = threading.Thread(target=worker)
    thread.start()
    thread.join()
    assert [row["reason"] for row in rows] == ["time_cap"] + [""] * 50


def test_a_retry_out_of_time_leaves_the_reason_of_the_solver() -> None:
    def slow_retry(case: Contact) -> Outputs:
        if case.model.accuracy == "fast":
            raise ConvergenceError("mesh_budget")
        time.sleep(30.0)
        return XU(case)

    row = CaseRunner(slow_retry, 0.1, 1)(CaseTask("k", "sobol", make_plan(accuracy="fast").case_at(0)))
    assert (row["status"], row["reason"], row["attempts"]) == ("failed", "mesh_budget", 2)


def test_long_cases_come_first_and_the_rest_of_the_time_follows_their_cost(tmp_path: Path) -> None:
    changes = ["sampling.size=32", "constraints.film_ratio.high=2"]
    plan = Plan.from_file("gear", changes)
    cost = dict(zip(plan.points.columns["pressure_hertz"], plan.case_seconds()[0], strict=True))
    order: list[float] = []

    def evaluate(case: Contact) -> Outputs:
        order.append(cost[case.contact.pressure_hertz or 0.0])
        return XU(case)

    seen: list[Progress] = []
    sweep_shard(plan, tmp_path, evaluate=evaluate, progress=seen.append)
    assert order == sorted(order, reverse=True)
    assert max(order) > 3.0 * min(order)
    assert seen[0].seconds_left is None
    assert seen[-1].seconds_left == pytest.approx(0.0, abs=1e-12)
    assert all(p.seconds_left > 0.0 for p in seen[1:-1] if p.seconds_left is not None)


def test_estimate_of_a_plan() -> None:
    def estimate(*changes: str) -> Any:
        return Plan.from_file("gear", changes).estimate()

    fast, standard = estimate(), estimate("model.accuracy=standard")
    assert (fast.cases, 400 < fast.rough < 512) == (512, True)
    assert standard.seconds > 2.0 * fast.seconds
    assert (fast.wall(2), fast.wall(10**6)) == (fast.seconds / 2.0, fast.longest)
    windows = ("constraints.film_ratio={high=1e9}", "constraints.correlation_over_rms={high=1e9}")
    smooth = estimate('variables.roughness_rms="1 nm"', *windows)
    assert smooth.rough < 0.05 * fast.rough
    assert smooth.seconds < 0.5 * fast.seconds
    # more correlation lengths in the contact take more nodes and more steps
    rough = 'variables.roughness_rms="0.3 um"'
    plans = [Plan.from_file("gear", [rough, f'variables.correlation_length="{um} um"']) for um in (20, 100)]
    short, long = (np.median(plan.case_seconds()[0]) for plan in plans)
    assert short > 1.3 * long


def test_the_estimate_of_extreme_contacts_is_limited() -> None:
    """Beyond the fitted range the form gave years; the solver ends within its work."""
    frame = load_dataset("gear_75w90").frame.head(64)
    table = {column: frame[column].to_numpy(dtype=float) for column in frame.select_dtypes("number")}
    table["correlation_length"] = 1e-4 * table["correlation_length"]
    seconds, rough = contact_seconds(ModelInput(accuracy="fast"), table)
    assert rough.any()
    assert 10.0 < seconds.max() < 20.0


def test_no_more_workers_than_cases_or_processors(plan: Plan, tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setattr("joblib.externals.loky.cpu_count", lambda: 12)
    monkeypatch.setenv("SLURM_CPUS_PER_TASK", "3")
    assert [checked_jobs(jobs) for jobs in (None, 1, 3, 8)] == [3, 1, 3, 3]
    sweep_shard(plan, tmp_path, evaluate=XU, shard=(1, 16))
    # one case is left of this shard: no process is started for it
    report = sweep_shard(plan, tmp_path, evaluate=XU, shard=(2, 16), jobs=8)
    assert (report.converged, report.workers) == (1, 1)


@dataclass(frozen=True)
class Square:
    value: int
    parent: int

    @property
    def key(self) -> str:
        return f"value={self.value}"


def square(task: Square) -> dict[str, int]:
    if task.value == 3 and os.getpid() != task.parent:
        os._exit(1)
    return {"square": task.value**2}


def test_rows_come_in_the_order_of_the_tasks_and_the_journal_resumes(tmp_path: Path) -> None:
    tasks = [Square(value, os.getpid()) for value in (5, 3, 2, 4, 2)]
    with Journal(tmp_path / "rows.jsonl") as journal:
        crashed = {"square": -1}
        found = run_tasks(tasks, square, jobs=2, journal=journal, crashed=lambda task: crashed)
        assert [row["square"] for row in found] == [25, -1, 4, 16, 4]
    with Journal(tmp_path / "rows.jsonl") as journal:
        again = run_tasks([*tasks, Square(6, 0)], square, jobs=1, journal=journal)
        assert [row["square"] for row in again] == [25, -1, 4, 16, 4, 36]
        assert len(journal.reused) == 4
    assert list(run_tasks([1, 2, 3], abs, jobs=1)) == [1, 2, 3]
    assert list(run_tasks([], abs)) == []


def some_fail(case: Contact) -> Outputs:
    if case.contact.slide_to_roll > 0.8:
        raise ConvergenceError("diverged")
    if case.contact.slide_to_roll > 0.6:
        raise ZeroDivisionError
    unsettled = {"status": "unsettled", "reason": "interval"} if case.contact.slide_to_roll > 0.4 else {}
    return {**XU(case), **unsettled}


def test_results_resume_and_progress(plan: Plan, tmp_path: Path) -> None:
    seen: list[Progress] = []
    first = sweep_shard(plan, tmp_path, evaluate=XU, progress=seen.append)
    assert (first.total, first.resumed, first.converged, first.failed, first.workers) == (16, 0, 16, 0, 1)
    assert [p.done for p in seen] == list(range(17))
    assert seen[-1] == Progress("cases", 16, 16, 0.0)
    frame = load_dataset(tmp_path).frame
    assert first.seconds_cpu == pytest.approx(frame["seconds_cpu"].sum())
    assert 0.0 < first.occupancy < 1.0
    assert first.occupancy == pytest.approx(frame["seconds"].sum() / first.seconds)
    again = sweep_shard(plan, tmp_path, evaluate=XU)
    assert (again.resumed, again.converged, again.occupancy) == (16, 0, None)
    status = run_status(tmp_path)
    assert (status.complete, status.shards[0].converged) == (True, 16)
    assert (status.longest, status.seconds) == (frame["seconds_cpu"].max(), pytest.approx(first.seconds_cpu))
    merge(tmp_path, tmp_path / "merged.h5")  # a copy of the same cases
    assert run_status(tmp_path).seconds == pytest.approx(first.seconds_cpu)


def test_rows_hold_inputs_results_and_provenance(plan: Plan, tmp_path: Path) -> None:
    sweep_shard(plan, tmp_path, evaluate=XU)
    dataset = load_dataset(tmp_path)
    assert dataset.frame["key"].is_monotonic_increasing
    assert (dataset.plan_name, dataset.oil, dataset.planned) == ("sweep", "fva3", 16)
    names = ["pressure_hertz", "slide_to_roll", "viscosity_inlet", "friction_coefficient", "roughness_rms"]
    for _, case in plan.cases():
        row = dataset.frame.set_index("key").loc[case_key(case, dataset.solver_version)]
        wanted = [case.contact.pressure_hertz, case.contact.slide_to_roll, case.lubricant.lubricant().viscosity_inlet]
        wanted += [XU(case)["friction_coefficient"], 0.4e-6]
        assert row[names].tolist() == pytest.approx(wanted, rel=1e-12)


def test_failures_are_rows_with_reasons(plan: Plan, tmp_path: Path) -> None:
    report = sweep_shard(plan, tmp_path, evaluate=some_fail)
    dataset = load_dataset(tmp_path)
    counted = pd.cut(dataset.frame["slide_to_roll"], [0.0, 0.4, 0.6, 0.8, 1.0], labels=False)
    reasons = np.array(["", "interval", "error:ZeroDivisionError", "diverged"])
    assert dataset.frame["reason"].tolist() == reasons[counted].tolist()
    assert dataset.frame["friction_coefficient"].isna().equals(counted > 1)
    counts = np.bincount(counted).tolist()
    assert report.reasons_failed == dict(zip(reasons[2:], counts[2:], strict=True))
    assert (report.converged, report.unsettled, report.failed) == (counts[0], counts[1], counts[2] + counts[3])
    assert report.reasons_unsettled == {"interval": counts[1]}
    assert run_status(tmp_path).shards[0].unsettled == counts[1] > 0
    assert len(dataset.converged) == counts[0] + counts[1]


def test_the_cap_holds_where_its_exception_is_swallowed(plan: Plan) -> None:
    _, case = next(plan.cases())

    def swallow_once(case: Contact) -> Outputs:
        with contextlib.suppress(BaseException):
            time.sleep(60.0)
        time.sleep(60.0)
        return {}

    def break_on_it(case: Contact) -> Outputs:
        try:
            time.sleep(60.0)
        except BaseException:
            raise RuntimeError from None
        return {}

    for evaluate in (swallow_once, break_on_it):
        assert CaseRunner(evaluate, 0.05)(CaseTask("k", "sobol", case))["reason"] == "time_cap"


def test_ctrl_c_ends_between_two_cases(plan: Plan, tmp_path: Path) -> None:
    def press(progress: Progress) -> None:
        if progress.done == 3:
            signal.raise_signal(signal.SIGINT)

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        sweep_shard(plan, tmp_path, evaluate=XU, progress=press)
    assert signal.getsignal(signal.SIGINT) is before
    assert sweep_shard(plan, tmp_path, evaluate=XU).resumed == 3


def test_failed_cases_on_disk_count_in_every_call_and_in_every_division_into_shards(plan: Plan, tmp_path: Path) -> None:
    reports = [sweep_shard(plan, tmp_path, evaluate=some_fail, retries=0, shard=(k, 2)) for k in (1, 2)]
    failed = sum(report.failed for report in reports)
    assert 0 < failed == sum(report.unanswered for report in reports)
    again = sweep_shard(plan, tmp_path, evaluate=some_fail, retries=0)
    assert (again.resumed, again.failed, again.unanswered) == (16, 0, failed)
    assert again.reasons_failed == dict(sum((Counter(report.reasons_failed) for report in reports), Counter()))
    # retried as one run: only what failed is computed, from the settings not tried yet
    solved = sweep_shard(plan, tmp_path, evaluate=XU, retry_failed=True)
    assert (solved.converged, solved.unanswered) == (failed, 0)
    assert sweep_shard(plan, tmp_path, evaluate=XU, shard=(1, 2)).unanswered == 0


def test_key_follows_input_seed_and_version(plan: Plan) -> None:
    _, case = next(plan.cases())
    seed = case.model_copy(update={"surface": case.surface.model_copy(update={"seed": 2})})
    keys = {case_key(case, "1"), case_key(case, "2"), case_key(seed, "1")}
    assert len(keys) == 3
    assert case_key(Contact.model_validate(case.model_dump(exclude_none=True)), "1") in keys
    # a task never raises
    row = CaseRunner(XU, None)(CaseTask("k", "sobol", case.model_copy(update={"contact": None})))
    assert (row["status"], row["reason"].partition(":")[0]) == ("failed", "error")


def test_slurm(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    Path("my plan.toml").write_text(data_path("plans", "demo.toml").read_text(encoding="utf-8"), encoding="utf-8")
    changes = {"changes": ["lubricant.oil=fva3"], "formula": "xu_kahraman_2007", "time_cap": 30, "retry_failed": True}
    script = slurm_script("my plan.toml", "runs/a b", 12, jobs=3, **changes)
    options = "--set lubricant.oil=fva3 --with xu_kahraman_2007 --time-cap '30 s' --retries 1 --retry-failed"
    command = f"mixed-ehl sweep 'my plan.toml' {options} -o 'runs/a b'"
    for part in ("--array=1-12", "--cpus-per-task=3", command, '--shard "${SLURM_ARRAY_TASK_ID}/12"'):
        assert part in script
    assert "/tmp" not in script  # a folder that another user of the node could make first
    with refuses("lubricant.oil"):
        slurm_script("my plan.toml", "run", 2, changes=["lubricant.oil=nothing"])


@pytest.fixture(scope="module")
def _untraced_workers() -> Iterator[None]:
    """Coverage does not trace workers: two traced threads can wait for each other without end in CPython 3.11."""
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("COVERAGE_PROCESS_CONFIG", raising=False)
        yield


@pytest.fixture(scope="module")
def cluster(_untraced_workers: None) -> Iterator[Any]:
    with dask_executor("local:2") as executor:
        yield executor


def test_a_cluster_gives_the_data_of_one_process_and_resumes(plan: Plan, tmp_path: Path, cluster: Any) -> None:
    report = sweep_shard(plan, tmp_path / "dask", evaluate=XU, executor=cluster)
    assert (report.converged, report.restarts) == (16, 0)
    sweep_shard(plan, tmp_path / "one", evaluate=XU)
    assert load_dataset(tmp_path / "dask").data_hash == load_dataset(tmp_path / "one").data_hash
    assert sweep_shard(plan, tmp_path / "dask", evaluate=XU, executor=cluster).resumed == 16


def test_a_case_that_always_kills_its_worker_is_lost(plan: Plan, tmp_path: Path, cluster: Any) -> None:
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
    # the thread of a worker receives no alarm signal; the time cap holds nevertheless
    assert frame.loc[[deadly, slow], "reason"].tolist() == ["worker_lost", "time_cap"]
    assert frame.loc[slow, "seconds"] < 30.0
    assert report.converged == 14


@pytest.mark.parametrize("stage", ["with its first case", "with its result in hand", "with the last case"])
def test_a_worker_that_dies_once_costs_no_case(plan: Plan, tmp_path: Path, cluster: Any, stage: str) -> None:
    sides = sorted(case.contact.slide_to_roll for _, case in plan.cases())
    done, victim = str(tmp_path / "done"), sides[-1] if "last" in stage else sides[0]

    def evaluate(case: Contact) -> Outputs:
        if case.contact.slide_to_roll == victim and not os.path.exists(done):
            Path(done).touch()
            if "result" in stage:
                # after the result, while it may be in transit
                threading.Timer(0.02, os.kill, (os.getpid(), signal.SIGKILL)).start()
            else:
                os.kill(os.getpid(), signal.SIGKILL)
        return XU(case)

    report = sweep_shard(plan, tmp_path / "dask", evaluate=evaluate, executor=cluster)
    assert report.converged == 16
    assert os.path.exists(done)
    sweep_shard(plan, tmp_path / "one", evaluate=XU)
    assert load_dataset(tmp_path / "dask").data_hash == load_dataset(tmp_path / "one").data_hash


def test_another_version(plan: Plan, tmp_path: Path, cluster: Any, monkeypatch: pytest.MonkeyPatch) -> None:
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


@pytest.mark.usefixtures("_untraced_workers")
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


@pytest.mark.usefixtures("_untraced_workers")
@pytest.mark.parametrize("address", ["local:none", "local:0", "tcp://127.0.0.1:1", "nofile.json", "nonsense://x"])
def test_bad_addresses(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_workers, "CONNECT", 1)
    with refuses("dask"), dask_executor(address):
        pass
    monkeypatch.setitem(sys.modules, "distributed", None)
    with refuses("dask"), dask_executor("local:1"):
        pass
