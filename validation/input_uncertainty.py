"""Do the intervals by uncertain inputs hold what they promise? Synthetic truth: inputs drawn from their distributions.

Of each contact, and of each gear state, the nominal inputs give an interval by the formula of the oil; all inputs are
then drawn at random and the truth is solved with them, on roughness of its own. 85 to 95 % of the truths are to lie in
the 90 % intervals. Contacts lie within the data of the formula, or outside its range
(`--outside`).

    python validation/input_uncertainty.py --contacts 200 --rows contacts.csv      # about 5 s each
    python validation/input_uncertainty.py --gears 20 --rows gears.csv             # about 2 min each
"""

from __future__ import annotations

import csv
import itertools
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from common import command_line
from input_sensitivities import SKEWNESS, states

import efficiency
import ehl
from efficiency.loss.ehl_friction import EhlFriction
from ehl.fluid.oil import Oil
from ehl.inputs import ContactProblem
from ehl.solve import solve_contact
from ehl.uncertainty.contact_design import uncertain_contact_inputs
from ehl.uncertainty.spread import DEFAULT
from regression.formula import Formula
from regression.friction.conditions import contact_points
from regression.friction.models import FrictionFlag
from regression.friction.uncertainty import uncertain_inputs

DESIGNS = ("fm_hypoid_13x42", "fm_spiral_bevel_14x39", "fh_hypoid_9x34", "fh_spiral_bevel_12x37")
COLUMNS = ("number", "film_ratio", "value", "low", "high", "truth", "status")
BANDS = (0.0, 0.3, 1.0, math.inf)


def drawn_contact(problem: ContactProblem, oil: Oil, rng: np.random.Generator) -> ContactProblem:
    """The contact with every uncertain input drawn from its distribution, one after the other."""
    for entry in uncertain_contact_inputs(problem, DEFAULT, oil, 0.0):
        problem = entry.moved(problem, float(rng.normal()))
    return problem


def chosen(formula: Formula, oil: Oil, count: int, outside: bool) -> list[dict[str, float]]:
    """Contacts within the data of the formula, or outside its range."""
    flag = FrictionFlag.OUTSIDE_RANGE if outside else FrictionFlag.OK
    found = states(4 * count, oil.name)
    return [state for state in found if int(formula.mu(contact_points(**state), oil=oil).flag) == flag][:count]


def contacts(count: int, formula: Formula, oil: Oil, outside: bool) -> Iterator[tuple[object, ...]]:
    """Interval of the formula at nominal inputs, and the solved truth."""
    for number, state in enumerate(chosen(formula, oil, count, outside)):
        rng = np.random.default_rng(1000 + number)
        interval = formula.uncertainty(contact_points(**state), oil=oil)
        each = state["roughness_rms"] / math.sqrt(2.0)
        given = {name: value for name, value in state.items() if name != "roughness_rms"}
        rough = {"roughness_rms_1": each, "roughness_rms_2": each, "seed": 500 + number}
        contact = ehl.Contact(oil=oil.name, **given, **rough, skewness=SKEWNESS, accuracy="fast")
        p = drawn_contact(contact.problem(), oil, rng)
        truth = solve_contact(p)
        ends = interval.value, interval.low, interval.high
        yield number, truth.film_ratio, *ends, truth.friction_coefficient, truth.status


def gears(count: int, formula: Formula, oil: Oil, points: int) -> Iterator[tuple[object, ...]]:
    """The same of efficiencies, of shipped pairs at torques, speeds and temperatures about their own."""
    for number in range(count):
        rng = np.random.default_rng(2000 + number)
        pair = efficiency.load(DESIGNS[number % len(DESIGNS)])
        point = pair.design.operation
        torque, speed = (value * math.exp(rng.uniform(-1.0, 0.4)) for value in (point.torque, point.speed))
        loaded = pair.mesh(positions=8, points_per_line=15).load(torque)
        nominal = loaded.efficiency(formula, speed=speed, temperature=rng.uniform(323.0, 383.0), oil=oil)
        case: Any = EhlFriction("ehl", points=points, seed=7000 + 100 * number), nominal.points.state, oil
        for entry in uncertain_inputs(*case, pair.design.spreads()):
            case = entry.moved(case, float(rng.normal()))
        model, state, card = case
        operation = replace(
            nominal.case.operation,
            roughness_rms_pinion=float(state.roughness_rms_1[0]),
            roughness_rms_gear=float(state.roughness_rms_2[0]),
            correlation_length=float(np.median(state.correlation_length)),
            peklenik_number=float(np.median(state.peklenik_number)),
            temperature_bulk_pinion=float(state.temperature_bulk_1[0]),
            temperature_bulk_gear=float(state.temperature_bulk_2[0]),
        )
        truth = loaded.solve(model, operation, card)
        ratio = float(np.median(nominal.lubrication.film_ratio))
        ends = nominal.efficiency, nominal.efficiency_lower, nominal.efficiency_upper
        yield number, ratio, *ends, truth.efficiency, truth.status


def summary(path: Path) -> None:
    """Share inside, by band of the film ratio, and what lies below and above."""
    with path.open() as file:
        rows = [row for row in csv.DictReader(file) if row["status"] != "failed"]
    for low, high in [(0.0, math.inf), *itertools.pairwise(BANDS)]:
        mine = [row for row in rows if low <= float(row["film_ratio"]) < high]
        if mine:
            below = sum(float(row["truth"]) < float(row["low"]) for row in mine)
            above = sum(float(row["truth"]) > float(row["high"]) for row in mine)
            inside = 1.0 - (below + above) / len(mine)

            band = f"film ratio {low:g} to {high:g}"
            print(f"{band}: {100.0 * inside:.0f} % of {len(mine)} inside, {below} below, {above} above")


def main(argv: Sequence[str] | None = None) -> None:
    """Rows and their summary."""
    parser = command_line(__doc__)
    parser.add_argument("--contacts", type=int, default=0)
    parser.add_argument("--outside", action="store_true", help="contacts outside the range of the formula")
    parser.add_argument("--gears", type=int, default=0)
    parser.add_argument("--points", type=int, default=24, help="contacts solved of each mesh")
    parser.add_argument("--formula", default="75w90")
    parser.add_argument("--rows", type=Path, default=Path("uncertainty_rows.csv"))
    options = parser.parse_args(argv)
    formula = Formula.load(options.formula)
    oil = Oil.load(formula.default_oil())
    if options.contacts:
        found = contacts(options.contacts, formula, oil, options.outside)
    else:
        found = gears(options.gears, formula, oil, options.points)
    with options.rows.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        clock = time.perf_counter()
        for row in found:
            writer.writerow(row)
            file.flush()
            words = [f"{value:.4g}" if isinstance(value, float) else str(value) for value in row]
            print(*words, f"{time.perf_counter() - clock:.0f} s", flush=True)
    summary(options.rows)


if __name__ == "__main__":
    main()
