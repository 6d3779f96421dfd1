"""Efficiency by the default friction model against solved contacts, at 24 operating points.

    python validation/operating_points.py            # ten minutes of one core; a stopped run resumes
    python validation/operating_points.py --table    # the rows that are there, into docs/friction_formula.md

Four states of six pairs: `rated` of the design, `fast` (16 000 rpm of the pinion, a quarter of its torque), `slow`
(100 rpm, rated torque, 120 degC) and `cool` (rated, 40 degC). The networks are fitted to other states of five of them
(`gear_pairs`). Where the stated error of the solved contacts exceeds 0.05 points, they are the mean of three draws of
all roughness profiles.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import cast

from common import OUT, command_line

import efficiency
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.ehl_friction import EhlFriction
from efficiency.loss.lubrication import SolvedFriction

PAIRS = (
    "fm_spiral_bevel_14x39_relieved", "fm_hypoid_13x42_relieved", "fh_hypoid_9x34_relieved",
    "fh_hypoid_9x34_offset_10_relieved", "fh_spiral_bevel_12x37_relieved", "eaxle_helical_23x75",
)  # fmt: skip
STATES: dict[str, tuple[float, float | None, float | None]] = {  # share of the torque, rpm and degC unless rated
    "rated": (1.0, None, None), "fast": (0.25, 16_000.0, None), "slow": (1.0, 100.0, 120.0), "cool": (1.0, None, 40.0),
}  # fmt: skip
SEEDS, ENOUGH = (1, 1001, 2001), 5e-4  # of the first roughness profile; error up to which one draw is enough
NAMES = ("pair", "state", "formula", "solved", "error", "inside", "outside")
PAGE, MARKERS = Path("docs/friction_formula.md"), ("<!-- points: begin -->", "<!-- points: end -->")


def error_of_mean(draws: Sequence[EfficiencyResult]) -> float:
    """Error of the mean efficiency of several draws [-].

    Only the random part of the error of the contacts is independent between draws. Errors of the grids, of the balance
    and of the method are common to all.
    """
    common = sum(d.errors.positions + d.errors.points + d.errors.balance for d in draws) / len(draws)
    method, chance = 0.0, 0.0
    for draw in draws:
        friction = cast("SolvedFriction", draw.friction)
        share = friction.method_error / friction.mean_error
        method += draw.errors.contacts * share / len(draws)
        chance += (draw.errors.contacts / len(draws)) ** 2 * (1.0 - share**2)
    return common + math.hypot(method, math.sqrt(max(chance, 0.0)))


def row(name: str, state: str) -> tuple[str, str, float, float, float, bool, float]:
    """A pair and a state: both efficiencies, the error of the solved one, whether both lie in each other's interval.

    Last: share of the sliding power outside the range of the formula.
    """
    pair = efficiency.load(name)
    at, (share, rpm, celsius) = pair.design.operation, STATES[state]
    loaded = pair.mesh().load(share * at.torque)
    speed = at.speed if rpm is None else rpm * math.pi / 30.0
    temperature = at.temperature if celsius is None else celsius + 273.15
    formula = loaded.efficiency(speed=speed, temperature=temperature)
    draws = []
    for seed in SEEDS:
        model = EhlFriction("ehl", points=48, tolerance=0.03, seed=seed)
        draws.append(loaded.efficiency(model, speed=speed, temperature=temperature))
        if draws[0].efficiency_error < ENOUGH:
            break
    solved = sum(found.efficiency for found in draws) / len(draws)
    error = error_of_mean(draws)
    inside = formula.inputs.low <= solved <= formula.inputs.high
    inside &= draws[0].inputs.low <= formula.efficiency <= draws[0].inputs.high
    return name, state, formula.efficiency, solved, error, inside, formula.outside_range_share


def table(path: Path) -> str:
    """Deviation of the formula by pair and state [percentage points], and the error of the solved contacts."""
    with path.open(encoding="utf-8") as file:
        rows = {(r["pair"], r["state"]): r for r in csv.DictReader(file)}
    lines = ["| pair | " + " | ".join(STATES) + " |", "|" + "---|" * (len(STATES) + 1)]
    for name in PAIRS:
        cells = []
        for state in STATES:
            found = rows.get((name, state))
            if found is None:
                cells.append("-")
                continue
            one, two, error = (100.0 * float(found[key]) for key in ("formula", "solved", "error"))
            mark = "" if found["inside"] == "True" else " (outside)"
            cells.append(f"{two:.2f} %: {one - two:+.2f} (±{error:.2f}){mark}")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Compute what is missing, and write the table of the page."""
    parser = command_line(__doc__)
    parser.add_argument("--table", action="store_true", help="only write the table")
    parser.add_argument("--out", type=Path, default=OUT / "operating_points.csv")
    given = parser.parse_args(arguments)
    given.out.parent.mkdir(parents=True, exist_ok=True)
    if not given.table:
        there: set[tuple[str, str]] = set()
        if given.out.exists():
            with given.out.open(encoding="utf-8") as file:
                there = {(r["pair"], r["state"]) for r in csv.DictReader(file)}
        with given.out.open("a", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            if not there:
                writer.writerow(NAMES)
            for name in PAIRS:
                for state in STATES:
                    if (name, state) not in there:
                        writer.writerow(found := row(name, state))
                        file.flush()
                        print(*found, flush=True)
    text = table(given.out)
    print(text)
    page = PAGE.read_text(encoding="utf-8")
    start, end = (page.index(marker) for marker in MARKERS)
    PAGE.write_text(page[: start + len(MARKERS[0])] + "\n" + text + "\n" + page[end:], encoding="utf-8")


if __name__ == "__main__":
    main()
