"""Search of `optimise` against random search: loss at fixed blank, ease-off and relief free, on five pairs.

    python validation/optimise_search.py [--evaluations 120] [--times 10] [--jobs 2] [--pairs NAME ...]

Start: shipped targets with relief. Objective: loss. Limits: pressure, loaded transmission error, edge load and root
stresses of the start; aligned pair, mesh of the search. The random search draws points evenly between the same bounds.
Printed: change of the loss by the best point within the limits of each, number of feasible points, processor time.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from common import command_line

import efficiency
from efficiency.optimisation.evaluation import Evaluation, allowed_of, evaluate_all
from efficiency.optimisation.optimise import load_start, make_problem, search_task, settings_of
from ehl.common.journal import Journal
from ehl.common.runner import local_executor

PAIRS = (
    "fm_hypoid_13x42_relieved",
    "fm_hypoid_13x37_relieved",
    "fh_hypoid_9x34_relieved",
    "fh_hypoid_9x34_offset_10_relieved",
    "fh_spiral_bevel_12x37_relieved",
)


def gain(points: Sequence[Evaluation], first: Evaluation, allowed: dict[str, float]) -> tuple[float, int]:
    """Change of the loss by the best point within the limits, and number of such points besides the start."""
    good = [p for p in points if p.feasible(allowed)]
    best = min([first, *good], key=lambda p: p.figures["power_loss"])
    return best.figures["power_loss"] / first.figures["power_loss"] - 1.0, len(good)


def compare(name: str, evaluations: int, times: int, jobs: int) -> str:
    """Both searches on one pair, as a row of the table."""
    start = load_start(name)
    options: dict[str, Any] = {"objectives": ["power_loss"], "misalignment": {}, "evaluations": evaluations}
    clock = time.perf_counter()
    found = efficiency.optimise(start, **options, check=0, jobs=jobs)
    searched = time.perf_counter() - clock
    first = found.start
    problem = make_problem(start, None, ["power_loss"], None, None, {}, None, "mean", "drive", None, None)
    allowed = allowed_of(problem, first)
    task = search_task(problem, settings_of(problem, {}))
    places = np.random.default_rng(7).random((times * evaluations, len(problem.variables)))
    tasks = [replace(task, values=problem.values_at(place)) for place in places]
    clock = time.perf_counter()
    with Journal(None, field="output") as journal:
        drawn = partial(evaluate_all, executor=local_executor(jobs), journal=journal)(tasks)
    random = time.perf_counter() - clock
    (one, many), (other, more) = gain(found.evaluations[1:], first, allowed), gain(drawn, first, allowed)
    return (
        f"| `{name}` | {100.0 * one:+.1f} % | {many} of {evaluations} | {searched:.0f} s "
        f"| {100.0 * other:+.1f} % | {more} of {len(drawn)} | {random:.0f} s |"
    )


def main(argv: Sequence[str] | None = None) -> None:
    """Print a row for each pair."""
    parser = command_line(__doc__)
    parser.add_argument("--evaluations", type=int, default=120)
    parser.add_argument("--times", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--pairs", nargs="+", default=PAIRS)
    arguments = parser.parse_args(argv)
    print(
        "| pair | search | within limits | time | random search | within limits | time |\n|---|---|---|---|---|---|---|"
    )
    for name in arguments.pairs:
        print(compare(name, arguments.evaluations, arguments.times, arguments.jobs), flush=True)


if __name__ == "__main__":
    main()
