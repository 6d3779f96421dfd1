"""Rerun a random 1 % of every shipped dataset, whatever a case costs: friction now against friction stored.

    python validation/rerun_datasets.py [SHARE]

Prints one line per case and writes out/rerun_datasets.csv. The test suite does the same with the cheap ones alone.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

from common import OUT, command_line, write_rows

from regression.data.dataset import dataset_names, dataset_plan, load_dataset
from regression.sweeping.rerun import SHARE, rerun


def main(argv: Sequence[str] | None = None) -> None:
    """Rerun, print and write."""
    parser = command_line(__doc__)
    parser.add_argument("share", nargs="?", type=float, default=SHARE)
    share = parser.parse_args(argv).share
    rows = []
    for name in dataset_names():
        clock = time.perf_counter()
        for case in rerun(load_dataset(name), dataset_plan(name), share=share):
            seconds, clock = time.perf_counter() - clock, time.perf_counter()
            within = case.difference <= max(case.error, 0.004)
            rows.append(
                {
                    "dataset": name, "key": case.key[:12], "stored": case.stored, "computed": case.computed,
                    "difference": case.difference, "stated_error": case.error, "within": within, "seconds": seconds,
                }
            )  # fmt: skip
            print(
                f"{name} {case.key[:12]} mu {case.stored:.5f} now {case.computed:.5f}: {case.difference:.3%}, "
                f"stated error {case.error:.2%}, {seconds:.1f} s{'' if within else '  BEYOND IT'}",
                flush=True,
            )
    beyond = sum(not row["within"] for row in rows)
    largest = max(row["difference"] for row in rows)
    print(f"{len(rows)} cases, {beyond} beyond their stated error, largest difference {largest:.3%}")
    write_rows(OUT / "rerun_datasets.csv", rows)


if __name__ == "__main__":
    main()
