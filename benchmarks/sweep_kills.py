"""What is lost when a sweep is killed: parent, workers, dask workers, full disks, corrupt files, two writers at once.

    python benchmarks/sweep_kills.py [--rounds 10] [--csv sweep_kills.csv]

Every round kills at a random moment, resumes, and compares data hash and formula coefficients with an undisturbed run,
bit for bit. The full disk is a real file system of a few hundred kilobytes where the system lets us mount one (root, or
user name spaces), otherwise a limit on the file size. Prints a table, writes it as CSV.
"""

from __future__ import annotations

import csv
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from common import command_line

from ehl.common.errors import InputError, MixedEhlError
from ehl.contact import Contact
from regression.data.dataset import load_dataset, run_status
from regression.fitting.fit import fit_formula
from regression.plan.plan import Plan
from regression.sweeping.dask_workers import dask_executor
from regression.sweeping.evaluators import Outputs, published_outputs
from regression.sweeping.sweep import sweep_shard

NAME = "arana_2019"
SIZE = 256
PLAN = f"""
name = "kills"
[sampling]
size = {SIZE}
[variables]
pressure_hertz = {{ low = "0.4 GPa", high = "1.6 GPa" }}
radius_equivalent = {{ low = "8 mm", high = "40 mm", scale = "log" }}
speed_entrainment = {{ low = "1 m/s", high = "15 m/s", scale = "log" }}
slide_to_roll = {{ low = 0.02, high = 1.2, scale = "log" }}
temperature_oil = {{ low = "60 degC", high = "120 degC" }}
roughness_rms = {{ low = "0.2 um", high = "0.6 um", scale = "log" }}
[lubricant]
oil = "fva3"
"""
# a sweep whose cases take a few milliseconds each, so that a kill comes in its midst
CHILD = """
import sys, time
from functools import partial
from pathlib import Path
from regression.sweeping.evaluators import published_outputs
from regression.plan.plan import Plan
from regression.sweeping.sweep import sweep_shard

plan, run, jobs, flush, pause = sys.argv[1:]

def show(progress):
    print(progress.done, flush=True)
    time.sleep(float(pause))

evaluate = partial(published_outputs, name="arana_2019")
sweep_shard(Plan.from_file(plan), Path(run), evaluate=evaluate, version="arana_2019", jobs=int(jobs),
      flush_every=int(flush), progress=show)
"""
EVALUATE = partial(published_outputs, name=NAME)
Outcome = tuple[str, str]


class Bench:
    """Folder, plan and the undisturbed run all others are compared with."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.folder, self.random = folder, random.Random(seed)
        self.path = folder / "plan.toml"
        self.path.write_text(PLAN)
        self.plan: Plan = Plan.from_file(self.path)
        sweep_shard(self.plan, folder / "whole", evaluate=EVALUATE, version=NAME)
        self.whole = load_dataset(folder / "whole")
        self.formula = fit_formula(self.whole, "power_law").to_json()

    def run(self, name: str) -> Path:
        run = self.folder / name
        shutil.rmtree(run, ignore_errors=True)
        return run

    def child(self, run: Path, jobs: int, flush: int, pause: float = 0.005) -> subprocess.Popen[str]:
        command = [sys.executable, "-c", CHILD, str(self.path), str(run), str(jobs), str(flush), str(pause)]
        return subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
        )

    def resumed(self, run: Path) -> str:
        """Resume a run; how it compares with the undisturbed one."""
        report = sweep_shard(self.plan, run, evaluate=EVALUATE, version=NAME)
        data = load_dataset(run)
        same = data.data_hash == self.whole.data_hash
        fitted = fit_formula(data, "power_law").to_json() == self.formula
        kept = f"{report.resumed} kept" + (f", {report.recovered} recovered" if report.recovered is not None else "")
        return f"{'identical' if same and fitted else 'DIFFERENT'} ({kept})"


def wait_until(process: subprocess.Popen[str], cases: int) -> int:
    """Read the child's progress until it has done so many cases."""
    assert process.stdout is not None
    done = 0
    for line in process.stdout:
        done = int(line)
        if done >= cases:
            break
    return done


def kill_parent(bench: Bench) -> Outcome:
    """SIGKILL of the process that writes, with workers."""
    run = bench.run("parent")
    with bench.child(run, bench.random.choice([1, 2]), bench.random.choice([1, 3, 16])) as process:
        done = wait_until(process, bench.random.randint(5, SIZE - 20))
        process.kill()
    kept = run_status(run).finished
    time.sleep(1.5)
    return f"killed at {done}, {kept} on disk", bench.resumed(run)


def kill_worker(bench: Bench) -> Outcome:
    """SIGKILL of one of two workers: the sweep goes on by itself."""
    run = bench.run("worker")
    with bench.child(run, 2, 4) as process:
        done = wait_until(process, bench.random.randint(5, SIZE // 2))
        # loky starts trackers beside its workers: the workers are those that import numba
        listed = subprocess.run(["pgrep", "-P", str(process.pid), "-f", "popen_loky"], capture_output=True, text=True)
        workers = [int(pid) for pid in listed.stdout.split()]
        if workers:
            os.kill(bench.random.choice(workers), signal.SIGKILL)
        process.communicate(timeout=300)
        code = process.returncode
    lost = [case.reason for case in run_status(run).failed]
    return f"one of {len(workers)} workers killed at {done}, exit {code}, {len(lost)} lost", bench.resumed(run)


def dask_deadly_case(bench: Bench) -> Outcome:
    """A case that always kills its dask worker."""
    run = bench.run("dask_case")
    deadly = bench.random.choice([case.contact.slide_to_roll for _, case in bench.plan.cases()])

    def evaluate(case: Contact) -> Outputs:
        if case.contact.slide_to_roll == deadly:
            os.kill(os.getpid(), signal.SIGKILL)
        return published_outputs(case, NAME)

    with dask_executor("local:2") as executor:
        report = sweep_shard(bench.plan, run, evaluate=evaluate, version=NAME, executor=executor)
    sweep_shard(bench.plan, run, evaluate=EVALUATE, version=NAME, retry_failed=True)
    return f"{report.converged} converged, {report.reasons_failed}", bench.resumed(run)


def dask_dying_workers(bench: Bench) -> Outcome:
    """dask workers that die whatever they compute."""
    run = bench.run("dask_workers")

    def evaluate(case: Contact) -> Outputs:
        os.kill(os.getpid(), signal.SIGKILL)
        return published_outputs(case, NAME)

    try:
        with dask_executor("local:2") as executor:
            sweep_shard(bench.plan, run, evaluate=evaluate, version=NAME, executor=executor)
        words = "ended without a word"
    except MixedEhlError as error:
        words = str(error)[:60]
    return words, bench.resumed(run)


def full_disk(bench: Bench) -> Outcome:
    """A file system that fills up; then there is room again."""
    mount = bench.folder / "disk"
    mount.mkdir(exist_ok=True)
    size = bench.random.randint(700, 950)
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}k", "none", str(mount)], capture_output=True)
    if mounted.returncode:
        return full_by_limit(bench, size)
    try:
        with bench.child(mount / "run", 1, bench.random.choice([1, 4, 16]), 0.0) as process:
            _, words = process.communicate(timeout=300)
        subprocess.run(["mount", "-o", "remount,size=64m", str(mount)], check=True)
        said = "No space left" in words and process.returncode == 1
        return f"tmpfs of {size} kB, {'said so' if said else f'exit {process.returncode}'}", bench.resumed(
            mount / "run"
        )
    finally:
        subprocess.run(["umount", str(mount)], check=True)


def full_by_limit(bench: Bench, size: int) -> Outcome:
    """The same by a limit on the size of a file, where no file system can be mounted."""
    run = bench.run("limit")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size * 1000, before[1]))
    try:
        sweep_shard(bench.plan, run, evaluate=EVALUATE, version=NAME)
        words = "large enough"
    except InputError as error:
        words = "said so" if "Make room" in str(error) else str(error)[-60:]
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    return f"limit of {size} kB, {words}", bench.resumed(run)


def truncated(bench: Bench) -> Outcome:
    """A shard cut short anywhere."""
    run = bench.run("truncated")
    shutil.copytree(bench.folder / "whole", run)
    (path,) = run.glob("*.h5")
    length = bench.random.randint(1000, path.stat().st_size - 1)
    share = length / path.stat().st_size
    os.truncate(path, length)
    try:
        return f"cut to {100 * share:.0f} %", bench.resumed(run)
    except InputError as error:
        path.unlink()
        return f"cut to {100 * share:.0f} %: {str(error)[-50:]}", bench.resumed(run)


def two_writers(bench: Bench) -> Outcome:
    """Two sweeps of the same shard at once."""
    run = bench.run("writers")
    with bench.child(run, 1, 4, 0.05) as first:
        wait_until(first, 5)
        with bench.child(run, 1, 4) as second:
            _, words = second.communicate(timeout=300)
        first.communicate(timeout=300)
    refused = "Is the same shard running" in words
    return f"first exit {first.returncode}, second {'refused' if refused else 'NOT refused'}", bench.resumed(run)


KILLS: tuple[Callable[[Bench], Outcome], ...] = (
    kill_parent,
    kill_worker,
    dask_deadly_case,
    dask_dying_workers,
    full_disk,
    truncated,
    two_writers,
)


def main(argv: Sequence[str] | None = None) -> None:
    """Kill, resume, compare."""
    parser = command_line(__doc__)
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="*", choices=[kill.__name__ for kill in KILLS])
    parser.add_argument("--csv", type=Path, default=Path("sweep_kills.csv"))
    options = parser.parse_args(argv)
    with tempfile.TemporaryDirectory() as folder, options.csv.open("w", newline="") as file:
        bench = Bench(Path(folder), options.seed)
        writer = csv.writer(file)
        writer.writerow(["kill", "round", "what happened", "resumed", "seconds"])
        for kill in KILLS:
            if options.only and kill.__name__ not in options.only:
                continue
            for number in range(1, options.rounds + 1):
                clock = time.perf_counter()
                happened, resumed = kill(bench)
                seconds = time.perf_counter() - clock
                writer.writerow([kill.__name__, number, happened, resumed, f"{seconds:.1f}"])
                print(f"{kill.__name__:20} {number:3}  {happened:52}  {resumed}  {seconds:.1f} s", flush=True)


if __name__ == "__main__":
    main()
