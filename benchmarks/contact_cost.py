"""Cost and error of random rough contacts of the gear range, of two states of the program.

``python benchmarks/contact_cost.py run OUT.csv --accuracy standard --count 40`` solves contacts of the plan
``gear_default`` with the program that is on the path (run it with PYTHONPATH at another checkout for another state).
``python benchmarks/contact_cost.py compare BEFORE.csv AFTER.csv`` prints processor times, their ratio and statuses;
``... compare BEFORE.csv AFTER.csv --truth TRUTH.csv`` takes a finer run of the same contacts for the truth and prints
true errors beside the stated ones. ``... stored OUT.csv`` solves two of every five contacts of the shipped dataset
`gear_75w90` and prints deviation, errors and processor times beside those of the stored rows.
"""

from __future__ import annotations

import csv
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from common import command_line

import ehl
from regression.data.dataset import dataset_plan, load_dataset
from regression.plan.plan import Plan
from regression.sweeping.rerun import row_of

FIELDS = (
    "friction_coefficient", "friction_error", "mesh_error", "statistical_error", "asperity_load_share", "film_central",
)  # fmt: skip
RUN_FIELDS = ("nodes", "steps", "travel", "iterations_per_step", "subgrid_error", "net_exchange", "repeats")


def contacts(count: int, accuracy: str, seed: int | None = None) -> Iterator[ehl.Contact]:
    """Contacts of the shipped plan, evenly picked; another seed gives them other roughness."""
    cases = [case for _, case in Plan.from_file("gear_default").cases()]
    for case in [cases[round(i)] for i in np.linspace(0, len(cases) - 1, count)]:
        case = case.replace(accuracy=accuracy)
        yield case if seed is None else case.replace(seed=seed)


def solve(number: int, case: ehl.Contact) -> dict[str, float | str]:
    """One row: processor seconds, status, results and what the run took."""
    clock = time.process_time()
    result = case.solve()
    row: dict[str, float | str] = {"case": number, "seconds": time.process_time() - clock}
    row |= {"status": result.status, "reason": result.reason}
    row |= {name: float(getattr(result, name)) for name in FIELDS}
    run = result.transient
    row |= {name: float(getattr(run, name)) if run else 0.0 for name in RUN_FIELDS}
    row["film_ratio"] = float(result.film_ratio)
    return row


def stored(out: Path, name: str = "gear_75w90") -> None:
    """Solve a share of a shipped dataset and compare with its rows; corners are left out."""
    dataset, plan = load_dataset(name), dataset_plan(name)
    found = []
    count = plan.sampling.size
    for number in sorted({*range(0, count, 5), *range(2, count, 5)}):
        case = plan.case_at(number)
        row = row_of(dataset, case)
        if row["status"] == "failed":
            continue
        result = solve(number, case)
        then = {f"stored_{k}": row[k] for k in ("friction_coefficient", "friction_error", "seconds_cpu", "status")}
        found.append(result | then)
        pd.DataFrame(found).to_csv(out, index=False)
    frame = pd.DataFrame(found)
    off = (frame["friction_coefficient"] / frame["stored_friction_coefficient"] - 1.0).abs()
    both = np.hypot(frame["friction_error"], frame["stored_friction_error"])
    print(f"{len(frame)} contacts; deviation median {off.median():.2%}, 90 % {off.quantile(0.9):.2%}")
    print(f"inside both stated errors {(off <= both).mean():.1%}, inside the new one ", end="")
    print(f"{(off <= frame.friction_error).mean():.1%}")
    for words, error, seconds in (
        ("stored", frame["stored_friction_error"], frame["stored_seconds_cpu"]),
        ("now", frame["friction_error"], frame["seconds"]),
    ):
        print(f"{words}: stated error median {error.median():.1%}, 90 % {error.quantile(0.9):.1%}; ", end="")
        print(f"{seconds.sum():.0f} s, median {seconds.median():.2f}, ", end="")
        print(f"95 % {seconds.quantile(0.95):.2f}, largest {seconds.max():.1f} s")


def compare(before: Path, after: Path, truth: Path | None) -> None:
    """Print both states of the program side by side."""
    frames = [pd.read_csv(path, keep_default_na=False).set_index("case") for path in (before, after)]
    common = frames[0].index.intersection(frames[1].index)
    frames = [frame.loc[common] for frame in frames]
    for name, frame in zip(("before", "after"), frames, strict=True):
        seconds = frame["seconds"]
        print(f"{name}: {len(frame)} contacts, {seconds.sum():.1f} s; median {seconds.median():.2f} s, ", end="")
        print(f"95 % {seconds.quantile(0.95):.2f} s, largest {seconds.max():.2f} s")
        print("  ", dict(Counter(f"{s} {r}".strip() for s, r in zip(frame["status"], frame["reason"], strict=True))))
    print(f"sum after/before {frames[1]['seconds'].sum() / frames[0]['seconds'].sum():.2f}")
    mu = [frame["friction_coefficient"].astype(float) for frame in frames]
    error = [frame["friction_error"].astype(float) for frame in frames]
    change = (mu[1] / mu[0] - 1.0).abs()
    print(f"change of mu: median {change.median():.2e}, largest {change.max():.2e}; inside both stated errors ", end="")
    print(f"{(change <= np.hypot(error[0], error[1])).sum()} of {len(change)}")
    if truth is None:
        return
    true = pd.read_csv(truth).set_index("case").loc[common]
    for name, value, stated in zip(("before", "after"), mu, error, strict=True):
        off = (value / true["friction_coefficient"] - 1.0).abs()
        covered = off <= np.hypot(stated, true["friction_error"])
        print(f"{name}: true error median {off.median():.2e}, 90 % {off.quantile(0.9):.2e}; stated median ", end="")
        print(f"{stated.median():.2e}; inside {covered.sum()} of {len(covered)}")


def main(argv: Sequence[str] | None = None) -> None:
    """Run or compare."""
    parser = command_line(__doc__)
    parser.add_argument("what", choices=("run", "compare", "stored"))
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--accuracy", default="standard")
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--only", type=int, nargs="*")
    parser.add_argument("--seed", type=int)
    parser.add_argument("--truth", type=Path)
    options = parser.parse_args(argv)
    if options.what == "compare":
        compare(options.files[0], options.files[1], options.truth)
        return
    if options.what == "stored":
        stored(options.files[0])
        return
    with options.files[0].open("w", newline="") as file:
        writer: csv.DictWriter[str] | None = None
        for number, case in enumerate(contacts(options.count, options.accuracy, options.seed)):
            if options.only and number not in options.only:
                continue
            row = solve(number, case)
            if writer is None:
                writer = csv.DictWriter(file, list(row))
                writer.writeheader()
            writer.writerow(row)
            file.flush()


if __name__ == "__main__":
    main()
