"""Cost and error of random rough contacts of the gear range, of two states of the program.

``python benchmarks/contact_cost.py run OUT.csv --accuracy standard --count 40`` solves contacts of the plan
``gear_default`` with the program that is on the path (run it with PYTHONPATH at another checkout for another state);
``--random 1`` draws them with that seed in place of evenly picked ones. ``... inputs CONTACTS.json`` writes the same
contacts for the program of a6079eb, which reads them by ``... earlier CONTACTS.json OUT.csv`` (PYTHONPATH at it).
``... truth OUT.csv --seeds 8`` solves rough ones among them with eight profiles each and writes their means.
``python benchmarks/contact_cost.py compare BEFORE.csv AFTER.csv`` prints processor times, their ratio and statuses;
``... compare BEFORE.csv AFTER.csv --truth TRUTH.csv`` takes a finer run of the same contacts for the truth and prints
true errors beside the stated ones. ``... stored OUT.csv`` solves two of every five contacts of the shipped dataset
`gear_75w90` and prints deviation, errors and processor times beside those of the stored rows.
"""

from __future__ import annotations

import csv
import importlib
import json
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from common import command_line

if TYPE_CHECKING:
    import ehl

FIELDS = (
    "friction_coefficient", "friction_error", "mesh_error", "statistical_error", "asperity_load_share", "film_central",
)  # fmt: skip
RUN_FIELDS = ("nodes", "steps", "travel", "iterations_per_step", "subgrid_error", "net_exchange", "repeats")


def contacts(
    count: int, accuracy: str, seed: int | None = None, draw: int | None = None
) -> Iterator[tuple[int, ehl.Contact]]:
    """Contacts of the shipped plan and their numbers, evenly picked or drawn; another seed gives other roughness."""
    from regression.plan.plan import Plan

    cases = [case for _, case in Plan.from_file("gear_default").cases()]
    picked = [round(i) for i in np.linspace(0, len(cases) - 1, count)]
    if draw is not None:
        picked = [int(i) for i in np.random.default_rng(draw).choice(len(cases), count, replace=False)]
    for i in picked:
        case = cases[i].replace(accuracy=accuracy)
        yield i, case if seed is None else case.replace(seed=seed + i)


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


def inputs(out: Path, cases: Iterator[tuple[int, ehl.Contact]]) -> None:
    """The contacts as the program of a6079eb reads them, with the boundary film that rough ones have today."""
    found = []
    for number, case in cases:
        given = case.model_dump(exclude_unset=True)
        given["surface"]["boundary_film"] = case.surface.generated_boundary_film
        found.append({"case": number, "input": given})
    out.write_text(json.dumps(found))


def earlier(source: Path, out: Path) -> None:
    """Solve them with that program."""
    case_of: Any = importlib.import_module("ehl.inputs").Case
    solve_case: Any = importlib.import_module("ehl.solve").solve_case
    found, given_cases = [], json.loads(source.read_text())
    solve_case(case_of(**given_cases[0]["input"]))  # compiles or loads
    for given in given_cases:
        clock = time.process_time()
        result = solve_case(case_of(**given["input"]))
        row = {"case": given["case"], "seconds": time.process_time() - clock}
        found.append(
            row | {k: getattr(result, k) for k in ("status", "reason", "friction_coefficient", "friction_error")}
        )
        pd.DataFrame(found).to_csv(out, index=False)


def truth(out: Path, cases: Iterator[tuple[int, ehl.Contact]], seeds: int) -> None:
    """Mean over roughness profiles, its own among them, and the half width of its 95 % interval over it."""
    found = []
    for number, case in cases:
        profiles = [case, *(case.replace(seed=100_000 + 1000 * k + number) for k in range(1, seeds))]
        values = [profile.solve().friction_coefficient for profile in profiles]
        mean = float(np.mean(values))
        spread = 1.96 * float(np.std(values, ddof=1)) / (len(values) ** 0.5 * abs(mean)) if mean else 0.0
        found.append({"case": number, "friction_coefficient": mean, "friction_error": spread})
        pd.DataFrame(found).to_csv(out, index=False)


def stored(out: Path, name: str = "gear_75w90") -> None:
    """Solve a share of a shipped dataset and compare with its rows; corners are left out."""
    from regression.data.dataset import dataset_plan, load_dataset
    from regression.sweeping.rerun import row_of

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
    true = pd.read_csv(truth).set_index("case")
    true = true.loc[true.index.intersection(common)]
    for name, value, stated in zip(
        ("before", "after"), [v.loc[true.index] for v in mu], [e.loc[true.index] for e in error], strict=True
    ):
        off = (value / true["friction_coefficient"] - 1.0).abs()
        covered = off <= np.hypot(stated, true["friction_error"])
        print(f"{name}: true error median {off.median():.2e}, 90 % {off.quantile(0.9):.2e}; stated median ", end="")
        print(f"{stated.median():.2e}; inside {covered.sum()} of {len(covered)}")


def main(argv: Sequence[str] | None = None) -> None:
    """Run or compare."""
    parser = command_line(__doc__)
    parser.add_argument("what", choices=("run", "inputs", "earlier", "truth", "compare", "stored"))
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--accuracy", default="standard")
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--only", type=int, nargs="*")
    parser.add_argument("--seed", type=int)
    parser.add_argument("--random", type=int)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--truth", type=Path)
    options = parser.parse_args(argv)
    if options.what == "compare":
        compare(options.files[0], options.files[1], options.truth)
        return
    if options.what == "stored":
        stored(options.files[0])
        return
    if options.what == "earlier":
        earlier(*options.files)
        return
    cases = contacts(options.count, options.accuracy, options.seed, options.random)
    cases = ((number, case) for number, case in cases if not options.only or number in options.only)
    if options.what != "run":
        (inputs if options.what == "inputs" else partial(truth, seeds=options.seeds))(options.files[0], cases)
        return
    next(contacts(1, "fast"))[1].solve()  # compiles or loads
    with options.files[0].open("w", newline="") as file:
        writer: csv.DictWriter[str] | None = None
        for number, case in cases:
            row = solve(number, case)
            if writer is None:
                writer = csv.DictWriter(file, list(row))
                writer.writeheader()
            writer.writerow(row)
            file.flush()


if __name__ == "__main__":
    main()
