"""Timed benchmarks: name, CPU seconds, and the error of the result next to them.

``python -m benchmarks [NAME ...]`` runs all or some, ``check`` only lists them. Times are CPU seconds of one core, the
least of ``--repeats`` runs after one that compiles and imports; rows are appended to benchmarks/out/timed.csv with the
version, to be compared over time. Every error is a relative one against a finer computation, or the one stated.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from benchmarks.timed import TIMED, Timed

OUT = Path(__file__).with_name("out") / "timed.csv"


def measure(benchmark: Timed, repeats: int) -> tuple[float, float]:
    """Least CPU seconds and the error of the result."""
    task = benchmark.setup()
    result, seconds = task(), []
    for _ in range(repeats):
        started = time.process_time()
        result = task()
        seconds.append(time.process_time() - started)
    return min(seconds, default=0.0), benchmark.error(result)


def main() -> int:
    """Run and print the benchmarks named."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", choices=[*TIMED, "check", []], metavar="NAME")
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    if options.names == ["check"]:
        for name, benchmark in TIMED.items():
            print(f"{name:18} {benchmark.about}")
        return 0
    OUT.parent.mkdir(exist_ok=True)
    new = not OUT.exists()
    with OUT.open("a", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        if new:
            writer.writerow(["date", "version", "benchmark", "seconds", "error"])
        for name in options.names or TIMED:
            seconds, error = measure(TIMED[name], options.repeats)
            print(f"{name:18} {seconds:10.4f} s   error {error:.2e}   {TIMED[name].about}", flush=True)
            day = datetime.now(UTC).date().isoformat()
            writer.writerow([day, version("mixed-ehl"), name, f"{seconds:.5g}", f"{error:.3g}"])
    return 0


if __name__ == "__main__":
    sys.exit(main())
