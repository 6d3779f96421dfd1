"""Rerun a random 1 % of every shipped dataset, whatever a case costs: friction now against friction stored.

    python benchmarks/rerun_datasets.py [SHARE]

Prints one line per case and writes out/rerun_datasets.csv. The test suite does the same with the cheap ones alone.
"""

from __future__ import annotations

import csv
import sys
import time
from pathlib import Path

from regression.data.dataset import dataset_names, dataset_plan, load_dataset
from regression.sweeping.rerun import SHARE, rerun


def main() -> None:
    share = float(sys.argv[1]) if len(sys.argv) > 1 else SHARE
    rows = []
    for name in dataset_names():
        clock = time.perf_counter()
        for case in rerun(load_dataset(name), dataset_plan(name), share=share):
            seconds, clock = time.perf_counter() - clock, time.perf_counter()
            within = case.difference <= max(case.error, 0.004)
            rows.append((name, case.key[:12], case.stored, case.computed, case.difference, case.error, within, seconds))
            print(
                f"{name} {case.key[:12]} mu {case.stored:.5f} now {case.computed:.5f}: {case.difference:.3%}, "
                f"stated error {case.error:.2%}, {seconds:.1f} s{'' if within else '  BEYOND IT'}",
                flush=True,
            )
    beyond = sum(not row[6] for row in rows)
    print(f"{len(rows)} cases, {beyond} beyond their stated error, largest difference {max(r[4] for r in rows):.3%}")
    out = Path(__file__).parent / "out"
    out.mkdir(exist_ok=True)
    with (out / "rerun_datasets.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("dataset", "key", "stored", "computed", "difference", "stated_error", "within", "seconds"))
        writer.writerows(rows)


if __name__ == "__main__":
    main()
