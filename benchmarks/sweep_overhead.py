"""What a sweep costs beside its cases: overhead per case, and how busy two cores are.

    python benchmarks/sweep_overhead.py [--shard 1/16] [--empty 512] [--jobs 2] [--dask] [--csv FILE]
    python benchmarks/sweep_overhead.py --growth 1024 4096 24576

Overhead: cases that take no time, wall time and processor time of the parent over their number.

Efficiency: the same share of the default plan by one worker and by several, with the solver; workers are started and
compiled code is loaded before the clock runs. The first two of these figures mean something on a busy machine too:

- occupancy: time of the workers inside cases over workers times wall time. What is missing is waiting for the parent
  and idling at the end;
- slowing: processor time of the same cases one at a time, over that beside each other (memory, caches, clock rate);
- efficiency: wall time with one worker over workers times wall time with several. It needs a quiet machine, and is the
  product of the first two there.

Growth: memory and file of sweeps of cases that take no time, and of reading them back.
"""

from __future__ import annotations

import csv
import os
import resource
import tempfile
import time
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

from common import command_line

from ehl.contact import Contact
from regression.data.dataset import load_dataset
from regression.plan.plan import Plan
from regression.sweeping.dask_workers import dask_executor
from regression.sweeping.evaluators import Outputs
from regression.sweeping.executors import Executor
from regression.sweeping.sweep import sweep_shard

# share of the plan that starts workers and loads compiled code: enough cases for each worker to meet a rough one
WARM = 127
TEMPERATURES = 'variables.temperature_oil=["60 degC", "90 degC"]'


def nothing(case: Contact) -> Outputs:
    """A case that takes no time."""
    return {"friction_coefficient": 0.05}


def workers_of(jobs: int, dask: bool) -> AbstractContextManager[Executor | None]:
    """Where the cases are computed."""
    return dask_executor(f"local:{jobs}") if dask else nullcontext(None)


def overhead(plan: Plan, jobs: int, dask: bool) -> tuple[float, float]:
    """Wall time, and processor time of the parent, of a case that takes none [ms]."""
    with tempfile.TemporaryDirectory() as folder, workers_of(jobs, dask) as executor:
        sweep_shard(plan, Path(folder) / "warm", evaluate=nothing, jobs=jobs, executor=executor, shard=(1, 8))
        clock, cpu = time.perf_counter(), time.process_time()
        sweep_shard(plan, Path(folder) / "run", evaluate=nothing, jobs=jobs, executor=executor)
        wall, parent = time.perf_counter() - clock, time.process_time() - cpu
    return 1e3 * wall / plan.count, 1e3 * parent / plan.count


def solved(plan: Plan, shard: tuple[int, int], jobs: int, dask: bool) -> tuple[int, float, float, float]:
    """Cases, wall time, time inside cases and their processor time, by the solver [s]."""
    with tempfile.TemporaryDirectory() as folder, workers_of(jobs, dask) as executor:
        sweep_shard(plan, Path(folder) / "warm", jobs=jobs, executor=executor, shard=(WARM, WARM))
        report = sweep_shard(plan, Path(folder) / "run", jobs=jobs, executor=executor, shard=shard)
    return report.total, report.seconds, report.seconds_cases, report.seconds_cpu


def growth(cases: int) -> tuple[float, float, float]:
    """Memory a sweep takes at its peak above the start [MB], its file [MB], and seconds to read it back."""
    # a list of temperatures, since Sobol points come in powers of two
    plan = Plan.from_file("gear_default", [f"sampling.size={cases // 2}", "sampling.corners=false", TEMPERATURES])
    with tempfile.TemporaryDirectory() as folder:
        run = Path(folder) / "run"
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        sweep_shard(plan, run, evaluate=nothing)
        taken = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024.0
        size = sum(path.stat().st_size for path in run.glob("*.h5")) / 1e6
        clock = time.perf_counter()
        rows = len(load_dataset(run).frame)
        assert rows == plan.count, (rows, plan.count)
        return taken, size, time.perf_counter() - clock


def main(argv: Sequence[str] | None = None) -> None:
    """Measure overhead and efficiency."""
    parser = command_line(__doc__)
    parser.add_argument("--shard", default="1/16", help="share of the default plan that is solved")
    parser.add_argument("--empty", type=int, default=512, help="cases that take no time")
    parser.add_argument("--jobs", type=int, default=2, help="workers beside each other")
    parser.add_argument("--dask", action="store_true", help="dask workers in place of joblib's")
    parser.add_argument("--csv", type=Path, default=Path("sweep_overhead.csv"))
    parser.add_argument("--growth", type=int, nargs="+", help="numbers of cases; this alone")
    options = parser.parse_args(argv)
    for cases in options.growth or ():
        clock = time.perf_counter()
        memory, size, seconds = growth(cases)
        each = 1e6 * size / cases
        print(f"{cases} cases: {time.perf_counter() - clock:.1f} s, memory +{memory:.0f} MB, file {size:.1f} MB, "
              f"{each:.0f} bytes a case, read back in {seconds:.1f} s", flush=True)  # fmt: skip
    if options.growth:
        return
    number, shards = (int(part) for part in options.shard.split("/"))
    load = os.getloadavg()[0]
    print(f"load of the machine before: {load:.1f}")
    empty = Plan.from_file("gear_default", [f"sampling.size={options.empty}", "sampling.corners=false"])
    plan = Plan.from_file("gear_default")
    rows = []
    for jobs in dict.fromkeys((1, options.jobs)):
        dask = options.dask and jobs > 1
        kind = "dask" if dask else "joblib" if jobs > 1 else "this process"
        wall, parent = overhead(empty, jobs, dask)
        print(f"{jobs} x {kind}: overhead {wall:.2f} ms a case ({parent:.2f} ms CPU of the parent)", flush=True)
        cases, *seconds = solved(plan, (number, shards), jobs, dask)
        occupancy = seconds[1] / (jobs * seconds[0])
        words = f"{cases} cases of the default plan in {seconds[0]:.1f} s (CPU of the cases {seconds[2]:.1f} s)"
        print(f"{jobs} x {kind}: {words}, occupancy {100.0 * occupancy:.1f} %", flush=True)
        rows.append((kind, jobs, wall, parent, cases, *seconds, occupancy))
    alone, beside = rows[0], rows[-1]
    slowing, efficiency = alone[7] / beside[7], alone[5] / (beside[1] * beside[5])
    print(f"slowing {slowing:.3f}, parallel efficiency {100.0 * efficiency:.1f} % with {beside[1]} workers")
    with options.csv.open("w", newline="") as file:
        writer = csv.writer(file)
        names = ["workers", "jobs", "overhead [ms]", "CPU of the parent [ms]", "cases", "wall [s]", "in cases [s]"]
        writer.writerow([*names, "CPU of the cases [s]", "occupancy", "load before"])
        writer.writerows((*row[:2], *(f"{x:.4g}" for x in row[2:]), f"{load:.2f}") for row in rows)


if __name__ == "__main__":
    main()
