"""The sweep: every case ends as a row, whatever happens to it, to its worker or to the process."""

import contextlib
import os
import signal
import time
from collections import Counter
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from refusals import refuses
from small_plans import sweep_plan

from ehl.common.data import data_path
from ehl.common.errors import ConvergenceError
from ehl.common.progress import Progress
from ehl.common.runner import granted_workers
from ehl.common.validation import validate
from ehl.contact import Contact
from ehl.inputs import SurfaceInput
from regression.data.dataset import load_dataset, run_status
from regression.plan.plan import Plan
from regression.sweeping.evaluators import CaseRunner, CaseTask, Outputs, case_key, published_outputs, solve_outputs
from regression.sweeping.slurm import slurm_script
from regression.sweeping.sweep import sweep_shard

XU = partial(published_outputs, name="xu_kahraman_2007")


@pytest.fixture
def plan() -> Plan:
    return validate(Plan, sweep_plan("sweep"))


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
    assert status.longest == frame["seconds_cpu"].max()


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


def test_a_lost_worker_costs_its_case_and_nothing_else(plan: Plan, tmp_path: Path) -> None:
    deadly_ratio = max(case.contact.slide_to_roll for _, case in plan.cases())

    # a local function: workers get it by value, they cannot import this module
    def some_kill_their_worker(case: Contact) -> Outputs:
        if case.contact.slide_to_roll == deadly_ratio:
            os.kill(os.getpid(), signal.SIGKILL)
        return XU(case)

    report = sweep_shard(plan, tmp_path, evaluate=some_kill_their_worker, jobs=2)
    frame = load_dataset(tmp_path).frame
    deadly = frame["slide_to_roll"] == deadly_ratio
    assert deadly.sum() == 1
    assert set(frame[deadly]["reason"]) == {"worker_lost"}
    assert (frame[~deadly]["status"] == "converged").all()
    assert len(frame) == 16
    assert report.restarts >= 2


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


def test_the_solver_gives_every_column(plan: Plan) -> None:
    _, case = next(plan.cases())
    smooth = case.model_copy(update={"surface": SurfaceInput()})
    row = CaseRunner(solve_outputs, None)(CaseTask("k", "sobol", smooth))
    assert row["status"] == "converged"
    assert row["friction_coefficient"] == pytest.approx(row["friction_fluid"] + row["friction_asperity"], rel=1e-12)
    assert 0.0 < row["friction_error"] < 0.05


def test_slurm(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("joblib.externals.loky.cpu_count", lambda: 12)
    for name, workers in (("SLURM_CPUS_PER_TASK", 7), ("OMP_THREAD_LIMIT", 3)):
        monkeypatch.setenv(name, str(workers))
        assert granted_workers() == workers
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
