"""Random contacts over the whole accepted range, solved to the end with a budget of work.

    python -m validation contact_campaign --count 100000 --rough 2000 --jobs 8

-40 to 200 degC, 0.05 to 4 GPa, 1e-4 to 200 m/s, slide-to-roll ratio 0 to 200, R 0.5 mm to 1 m, Rq 0 to 5 um, all oils.
Prints outcomes, and each input with a traceback, more than the budget of processor time, or an impossible answer.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

from common import command_line
from scipy.stats import qmc

from ehl import Contact, InputError, shipped
from ehl.common.runner import run_tasks

BUDGET = {False: 10.0, True: 120.0}  # processor time of a smooth and of a rough contact, accuracy "fast" [s]


def inputs(count: int, seed: int, *, rough: bool) -> Iterator[dict[str, Any]]:
    """Keywords of contacts, a Sobol set."""
    oils = shipped("oils")
    for a in qmc.Sobol(7, seed=seed).random(count):
        found: dict[str, Any] = {
            "oil": oils[int(a[0] * len(oils))],
            "temperature_oil": 233.15 + 240.0 * a[1],
            "pressure_hertz": 5e7 * 80.0 ** a[2],
            "speed_entrainment": 1e-4 * 2e6 ** a[3],
            "slide_to_roll": 0.0 if a[4] < 0.1 else 10.0 ** (-3.0 + 5.3 * (a[4] - 0.1) / 0.9),
            "radius_equivalent": 5e-4 * 2000.0 ** a[5],
            "accuracy": "fast",
        }
        yield found | ({"roughness_rms": 5e-6 * a[6]} if rough else {})


def outcome(keywords: dict[str, Any], *, rough: bool) -> str:
    """Status and reason of a contact; begins with a capital letter where something is wrong."""
    clock = time.process_time()
    try:
        result = Contact(**keywords).solve()
    except InputError:
        return "refused"
    except Exception as error:
        return f"Traceback {error!r} {keywords}"
    seconds = time.process_time() - clock
    if seconds > BUDGET[rough]:
        return f"Over budget {seconds:.0f} s {keywords}"
    if result.status != "failed":
        line = result.problem.line if result.problem is not None else None
        assert line is not None
        numbers = (result.friction_coefficient, result.film_central, result.pressure_max)
        within = result.film_central <= 0.1 * line.radius_equivalent and 0.0 <= result.asperity_load_share <= 1.0 + 1e-9
        strong = result.friction_coefficient * (1.0 - min(result.friction_error, 1.0)) > 0.5
        if not all(map(math.isfinite, numbers)) or min(numbers) < 0.0 or not within or strong:
            return f"Impossible {result} {keywords}"
    return f"{result.status} {result.reason}".strip()


def campaign(count: int, seed: int, *, rough: bool, jobs: int | None = None) -> Counter[str]:
    """Outcomes of contacts by their number."""
    tasks = list(inputs(count, seed, rough=rough))
    return Counter(run_tasks(tasks, partial(outcome, rough=rough), jobs=jobs))


def main(argv: Sequence[str] | None = None) -> None:
    """Run the campaign from the command line."""
    parser = command_line(__doc__)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--rough", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int)
    options = parser.parse_args(argv)
    for count, rough in ((options.count, False), (options.rough, True)):
        if count:
            found = campaign(count, options.seed, rough=rough, jobs=options.jobs)
            print(f"{'rough' if rough else 'smooth'} contacts: {count}")
            for text, number in found.most_common():
                print(f"  {number:6d}  {text}")


if __name__ == "__main__":
    main()
