"""Random contacts over the whole accepted range, solved to the end with a budget of work.

    python -m validation contact_campaign --count 100000 --rough 2000 --out campaign.jsonl

Temperature, pressure, speeds, slide-to-roll ratio, radius, roughness and lay over the ranges of the input check; half
of them slide along the contact line; all oils. Prints outcomes, and each input with a traceback, above the budget
of processor time, or with an impossible result. Some results, chosen by a hash of their inputs, are compared with
solutions at accuracy "reference" by both stated errors.
"""

from __future__ import annotations

import json
import math
import random
import signal
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, get_args

import numpy as np
from common import command_line

from ehl import Contact, InputError, shipped
from ehl.common.runner import run_tasks
from ehl.fluid.viscosity import TEMPERATURE_RANGE
from ehl.inputs import PeklenikNumber, Pressure, Radius, Rms, SlideToRoll, SlidingSpeed, Speed
from ehl.result import ContactResult
from ehl.validity import STRENGTH_AMBIENT, STRENGTH_SLOPE

BUDGET = 60.0  # processor time of a contact, accuracy "fast" [s]
STOPPED = 180.0  # processor time at which a contact is ended [s]
CHUNK = 256  # smooth contacts between two reports
COMPARED = {False: 0.01, True: 0.02}  # share of the answers, smooth and rough, that are solved at "reference"
SMALLEST_SLIP = 1e-6  # of a logarithmic scale [-]


def _accepted(field: Any) -> tuple[float, float]:
    """Lowest and highest value of an input."""
    found = get_args(field)[1]
    return float(found.ge), float(found.le)


def _logarithmic(low: float, high: float, share: float) -> float:
    return float(low * (high / low) ** share)


def inputs(count: int, seed: int, *, rough: bool, skip: int = 0) -> Iterator[dict[str, Any]]:
    """Keywords of random contacts, each by its number."""
    oils = shipped("oils")
    for number in range(skip, skip + count):
        a = np.random.default_rng([seed, number]).random(11)
        # pure rolling and no sliding along the line are cases of their own; else either sign
        slip = _logarithmic(SMALLEST_SLIP, _accepted(SlideToRoll)[1], abs(2.2 * a[4] - 1.1) / 1.1)
        along = _logarithmic(SMALLEST_SLIP, _accepted(SlidingSpeed)[1], 2.0 * a[6] - 1.0)
        found: dict[str, Any] = {
            "oil": oils[int(a[0] * len(oils))],
            "temperature_oil": TEMPERATURE_RANGE[0] + (TEMPERATURE_RANGE[1] - TEMPERATURE_RANGE[0]) * a[1],
            "pressure_hertz": _logarithmic(*_accepted(Pressure), a[2]),
            "speed_entrainment": _logarithmic(*_accepted(Speed), a[3]),
            "slide_to_roll": 0.0 if a[4] < 0.05 else math.copysign(slip, a[4] - 0.5),
            "radius_equivalent": _logarithmic(*_accepted(Radius), a[5]),
            "speed_sliding_lengthwise": along if a[6] > 0.5 else 0.0,
            "accuracy": "fast",
        }
        if rough:
            low, high = _accepted(PeklenikNumber)
            rms = _logarithmic(1e-9, _accepted(Rms)[1], a[7])
            first = min(1.0, max(0.0, 1.2 * a[8] - 0.1))
            found |= {"roughness_rms_1": rms * math.sqrt(first), "roughness_rms_2": rms * math.sqrt(1.0 - first)}
            found |= {"peklenik_number": _logarithmic(low, high, a[9]) if a[9] < 0.5 else 1.0}
            if a[10] > 0.5:
                found["correlation_length"] = _logarithmic(1e-6, 1e-3, 2.0 * a[10] - 1.0)
        yield {name: value if isinstance(value, str) else float(value) for name, value in found.items()}


def impossible(result: ContactResult) -> str:
    """What no answer may be; empty where it is none of it."""
    assert result.problem is not None
    line = result.problem.line
    numbers = (result.friction_coefficient, result.film_central, result.film_min, result.pressure_max)
    errors = (result.friction_error, result.film_error)
    if not all(map(math.isfinite, (*numbers, *errors))) or min(*numbers, *errors) < 0.0:
        return "numbers"
    if max(result.film_central, result.film_min) > 0.1 * line.radius_equivalent:
        return "film"
    if not 0.0 <= result.asperity_load_share <= 1.0 + 1e-9:
        return "load share"
    width = result.film.x_exit - result.film.x_inlet if result.film is not None else 2.0 * line.half_width
    most = STRENGTH_SLOPE + STRENGTH_AMBIENT * width / line.load_per_length + result.problem.surface.boundary_friction
    if result.friction_coefficient * (1.0 - min(result.friction_error, 1.0)) > 1.2 * most:
        return "friction"
    return ""


def beyond(result: ContactResult, keywords: dict[str, Any]) -> str:
    """Where friction or film leave both stated errors of this answer and of one at accuracy "reference"."""
    exact = Contact(**keywords | {"accuracy": "reference"}).solve()
    if exact.status == "failed":
        return f"compared, reference failed ({exact.reason})"
    for name, error in (("friction_coefficient", "friction_error"), ("film_central", "film_error")):
        one, other = getattr(result, name), getattr(exact, name)
        allowed = one * getattr(result, error) + other * getattr(exact, error)
        if abs(one - other) > allowed + 1e-12:
            return f"Beyond the errors: {name} {one:.6g}, {other:.6g}, allowed {allowed:.3g} {keywords}"
    return "compared, within the errors"


def outcome(keywords: dict[str, Any], *, rough: bool) -> list[str]:
    """Status and reason of a contact, and its comparison; begins with a capital letter where something is wrong."""

    def stop(number: int, frame: object) -> None:
        raise TimeoutError

    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, STOPPED)
    found, clock = [], time.process_time()
    try:
        result = Contact(**keywords).solve()
        seconds = time.process_time() - clock
        if seconds > BUDGET:
            found.append(f"Over budget {seconds:.0f} s {keywords}")
        if result.status != "failed":
            if wrong := impossible(result):
                found.append(f"Impossible {wrong} {result!r} {keywords}")
            # the same contacts whatever is solved before
            if random.Random(repr(keywords)).random() < COMPARED[rough]:
                found.append(beyond(result, keywords))
        return [*found, f"{result.status} {result.reason}".strip()]
    except InputError as error:
        return [f"refused ({error.field})"]
    except TimeoutError:
        return [*found, f"Hang {keywords}"]
    except Exception as error:
        return [*found, f"Traceback {error!r} {keywords}"]
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def campaign(count: int, seed: int, *, rough: bool, skip: int = 0, jobs: int | None = None) -> dict[str, Any]:
    """Outcomes of contacts by their number, what is wrong, and the processor time where one process solves them."""
    clock = time.process_time()
    tasks = list(inputs(count, seed, rough=rough, skip=skip))
    rows = run_tasks(tasks, partial(outcome, rough=rough), jobs=jobs)
    texts = [text for row in rows for text in row]
    return {
        "rough": rough,
        "seed": seed,
        "first": skip,
        "count": count,
        "seconds": round(time.process_time() - clock, 1),
        "outcomes": Counter(text for text in texts if not text[0].isupper()),
        "faults": [text for text in texts if text[0].isupper()],
    }


def report(rows: Sequence[dict[str, Any]]) -> str:
    """Outcomes of all chunks, and each input where something is wrong."""
    lines = []
    for rough in (False, True):
        chunks = [row for row in rows if row["rough"] == rough]
        if number := sum(row["count"] for row in chunks):
            seconds = sum(row["seconds"] for row in chunks)
            lines.append(f"{'rough' if rough else 'smooth'} contacts: {number} in {seconds:.0f} s")
            counts = sum((Counter(row["outcomes"]) for row in chunks), Counter[str]())
            lines += [f"  {n:6d}  {text}" for text, n in counts.most_common()]
    return "\n".join([*lines, *(f"       1  {text}" for row in rows for text in row["faults"])])


def main(argv: Sequence[str] | None = None) -> None:
    """Run the campaign from the command line."""
    parser = command_line(__doc__)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--rough", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int)
    parser.add_argument("--out", type=Path, help="a line of JSON for each chunk of contacts; the same command resumes")
    options = parser.parse_args(argv)
    rows: list[dict[str, Any]] = []
    if options.out is not None and options.out.exists():
        rows = [json.loads(line) for line in options.out.read_text(encoding="utf-8").splitlines()]
    done = {
        rough: max((row["first"] + row["count"] for row in rows if row["rough"] == rough), default=0)
        for rough in (False, True)
    }
    chunks = max(1, math.ceil(options.count / CHUNK))
    for chunk in range(1, chunks + 1):
        for rough, whole in ((False, options.count), (True, options.rough)):
            until = whole * chunk // chunks
            if until > done[rough]:
                left = until - done[rough]
                rows.append(campaign(left, options.seed, rough=rough, skip=done[rough], jobs=options.jobs))
                done[rough] = until
                if options.out is not None:
                    with options.out.open("a", encoding="utf-8") as file:
                        file.write(json.dumps(rows[-1]) + "\n")
    print(report(rows))


if __name__ == "__main__":
    main()
