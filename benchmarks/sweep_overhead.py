"""What a sweep costs beside its cases: overhead per case, and how busy the cores are.

    python benchmarks/sweep_overhead.py [--cases 256] [--milliseconds 50] [--jobs 1 2] [--dask] [--csv FILE]

Overhead: cases that take no time, wall time and CPU time of the parent over their number. Efficiency: cases that work
(not sleep) for as long as the estimate of the default plan spreads, so that long and short ones mix; CPU time of the
cases over workers times wall time, start of the workers left out. Wall times depend on what else the machine does: run
it on a quiet one.
"""

from __future__ import annotations

import argparse
import csv
import os
import tempfile
import time
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path

from ehl.inputs import Case
from regression.cost import case_seconds
from regression.dask_workers import dask_executor
from regression.evaluators import Outputs
from regression.executors import Executor
from regression.plan import Plan, load_plan
from regression.sweep import sweep


def nothing(case: Case) -> Outputs:
    """A case that takes no time."""
    return {"friction_coefficient": 0.05}


def busy(case: Case, seconds: dict[float, float]) -> Outputs:
    """A case that keeps its core busy for as long as it should."""
    end = time.thread_time() + seconds[case.contact.pressure_hertz or 0.0]
    while time.thread_time() < end:
        pass
    return {"friction_coefficient": 0.05}


def run(plan: Plan, evaluate: partial[Outputs], jobs: int, dask: bool) -> tuple[float, float]:
    """Sweep with warm workers; wall time and CPU time of the parent."""
    where: AbstractContextManager[Executor | None] = dask_executor(f"local:{jobs}") if dask else nullcontext(None)
    with tempfile.TemporaryDirectory() as folder, where as executor:
        # the first sweep starts the workers and imports what they need
        sweep(plan, Path(folder) / "warm", evaluate=nothing, jobs=jobs, executor=executor, shard=(1, plan.count // 8))
        clock, cpu = time.perf_counter(), time.process_time()
        sweep(plan, Path(folder) / "run", evaluate=evaluate, jobs=jobs, executor=executor)
        return time.perf_counter() - clock, time.process_time() - cpu


def main() -> None:
    """Measure overhead and efficiency."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=256)
    parser.add_argument("--milliseconds", type=float, default=50.0, help="mean length of a busy case")
    parser.add_argument("--jobs", type=int, nargs="*", default=[1, 2])
    parser.add_argument("--dask", action="store_true", help="dask workers in place of joblib's")
    parser.add_argument("--csv", type=Path, default=Path("sweep_overhead.csv"))
    options = parser.parse_args()
    plan = load_plan("gear_default", [f"sampling.size={options.cases}", "sampling.corners=false"])
    cost = case_seconds(plan)
    seconds = cost * (1e-3 * options.milliseconds / cost.mean())
    lengths = dict(zip(plan.points.columns["pressure_hertz"].tolist(), seconds.tolist(), strict=True))
    load = os.getloadavg()[0]
    longest = 1e3 * seconds.max()
    print(f"{plan.count} cases, {options.milliseconds:g} ms in the mean, longest {longest:.0f} ms; load {load:.1f}")
    with options.csv.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["workers", "jobs", "overhead [ms]", "CPU of the parent [ms]", "efficiency", "load before"])
        for jobs in options.jobs:
            empty, parent = (1e3 * x / plan.count for x in run(plan, partial(nothing), jobs, options.dask))
            wall, _ = run(plan, partial(busy, seconds=lengths), jobs, options.dask)
            efficiency = seconds.sum() / (jobs * wall)
            kind = "dask" if options.dask else "joblib" if jobs > 1 else "this process"
            writer.writerow([kind, jobs, f"{empty:.3f}", f"{parent:.3f}", f"{efficiency:.4f}", f"{load:.2f}"])
            words = f"{empty:.2f} ms per case ({parent:.2f} ms CPU of the parent)"
            print(f"{jobs} x {kind}: {words}, efficiency {100.0 * efficiency:.1f} %", flush=True)


if __name__ == "__main__":
    main()
