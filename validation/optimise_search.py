"""Search of `optimise` against random search with ten times the points, at fixed blank, on five pairs.

    python validation/optimise_search.py [--evaluations 100] [--times 10] [--pairs NAME ...] [--store FOLDER]

Start: shipped targets with relief. Objective: loss. Limits: pressure, loaded transmission error, edge load and root
stresses of the start; aligned pair, mesh of the search, bounds of `optimise`, offset and blank fixed.

The random search draws points evenly between the same bounds. An approximate model selects those that are computed
exactly (`NEAR`): on the contact lines of the start only the gap changes, by ease-off and relief; the load is solved
again, the loss is that of constant friction (20 ms instead of 1 s a point).

Printed: change of the loss by the best exact point within the limits, number of such points, processor time; number of
points of the search within the limits that the approximate model would select.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from common import command_line

import efficiency
from efficiency.ltca.limits import edge_load
from efficiency.ltca.load_distribution import distribute_load
from efficiency.machine_settings.conjugate import target_relief
from efficiency.machine_settings.inputs import SettingsInput
from efficiency.optimisation.evaluation import Evaluation, allowed_of, evaluate, settings_of, targets_of
from efficiency.optimisation.optimise import SEARCH_GRID, load_start, make_problem, search_task
from efficiency.optimisation.problem import SearchProblem
from efficiency.pair import GearPair

PAIRS = (
    "fh_spiral_bevel_12x37_relieved",
    "fh_hypoid_9x34_relieved",
    "fm_hypoid_13x42_relieved",
    "fm_hypoid_13x37_relieved",
    "fh_hypoid_9x34_offset_10_relieved",
)
# factor on each limit, and addition to the share on edges, up to which a point of the random search is computed exactly
NEAR = {"power_loss": 1.02, "pressure_hertz_max": 1.05, "transmission_error_loaded": 1.15}
NEAR_EDGES = 3e-3
EXACT = 12  # most exact computations of the random search
Figures = dict[str, float]


class ApproximateModel:
    """Figures of a point relative to the start, from the contact lines of the start."""

    def __init__(self, problem: SearchProblem) -> None:
        self.problem = problem
        design = settings_of(problem, {}).design
        mesh = GearPair(design).mesh(problem.duty[0].side, *SEARCH_GRID)
        self.torque, self.teeth, self.elastic = problem.duty[0].torque, mesh.grids.teeth, mesh.grids.elastic_fine
        flanks = design.flanks()
        self.gear, self.pinion = flanks.blank("gear"), flanks.blank("pinion")
        clearance = self.gear.mean_dedendum - self.pinion.mean_addendum
        self.places = []
        for elastic in self.elastic:
            p = elastic.position
            u = p.face_gear - 0.5 * self.gear.face_width
            h, u_pinion = p.height_gear + self.gear.root(u), p.face_pinion - 0.5 * self.pinion.face_width
            low = self.gear.root(u) + clearance
            y = 2.0 * (h - low) / (self.gear.tip(u) - low) - 1.0
            h_pinion = p.height_pinion + self.pinion.root(u_pinion)
            self.places.append((2.0 * u / self.gear.face_width, y, u, h, u_pinion, h_pinion))
        self.own = self._relief(problem.start)
        self.start = self._figures([np.zeros_like(own) for own in self.own])

    def _relief(self, targets: SettingsInput) -> list[Any]:
        return [
            target_relief(targets.targets.drive, x, y)
            + targets.gear.edge_relief.depth(self.gear, u, h)
            + targets.pinion.edge_relief.depth(self.pinion, u_pinion, h_pinion)
            for x, y, u, h, u_pinion, h_pinion in self.places
        ]

    def _figures(self, changes: Sequence[Any]) -> Figures | None:
        cycle = []
        for elastic, change in zip(self.elastic, changes, strict=True):
            p = elastic.position
            closing = (p.gap + change) / p.lever_gear - p.transmission_error
            error, gap = -float(closing.min()), (closing - closing.min()) * p.lever_gear
            cycle.append(replace(elastic, position=replace(p, gap=gap, transmission_error=error)))
        load = distribute_load(cycle, self.teeth, self.torque)
        if load.reason:
            return None
        sliding = sum(
            float(q.force @ np.hypot(q.position.sliding_along, q.position.sliding_across)) for q in load.positions
        )
        return {
            "power_loss": sliding,
            "pressure_hertz_max": load.pressure_hertz_max,
            "transmission_error_loaded": float(np.ptp(load.transmission_error)),
            "edge_load_share": edge_load(load, self.teeth).share,
        }

    def __call__(self, values: dict[str, float]) -> Figures | None:
        """Figures over those of the start; the share on edges itself; None without a load distribution."""
        new = self._relief(targets_of(self.problem, values))
        found = self._figures([a - b for a, b in zip(new, self.own, strict=True)])
        if found is None or self.start is None:
            return None
        return {k: x if k == "edge_load_share" else x / self.start[k] for k, x in found.items()}


def is_near(about: Figures | None, edges: float) -> bool:
    """Whether approximate figures are near enough to the limits for an exact computation."""
    return bool(about) and about["edge_load_share"] < edges + NEAR_EDGES and all(about[k] < x for k, x in NEAR.items())


def gain(points: Sequence[Evaluation], first: Evaluation, allowed: Figures) -> tuple[float, int]:
    """Change of the loss by the best point within the limits, and number of such points besides the start."""
    good = [p for p in points if p.feasible(allowed)]
    best = min([first, *good], key=lambda p: p.figures["power_loss"])
    return best.figures["power_loss"] / first.figures["power_loss"] - 1.0, len(good)


def compare(name: str, evaluations: int, times: int, store: Path | None) -> str:
    """Both searches on one pair, as a row of the table."""
    start, clock = load_start(name), time.process_time()
    problem = make_problem(start, None, ["power_loss"], None, None, {}, None, "mean", "drive", None, None)
    task = search_task(problem, settings_of(problem, {}))
    first = evaluate(task)
    allowed = allowed_of(problem, first)
    model, size = ApproximateModel(problem), len(problem.variables)
    edges = allowed["edge_load_share"]
    places = np.random.default_rng(7).random((times * evaluations, size))
    drawn = []
    for place in places:
        values = problem.values_at(place)
        if (about := model(values)) and is_near(about, edges):
            drawn.append((about["power_loss"], values))
    drawn.sort(key=lambda row: row[0])
    exact = [evaluate(replace(task, values=values)) for _, values in drawn[:EXACT]]
    (random, near), spent = gain(exact, first, allowed), time.process_time() - clock
    clock, kept = time.process_time(), None if store is None else store / f"{name}.jsonl"
    settings: dict[str, Any] = {"objectives": ["power_loss"], "misalignment": {}, "evaluations": evaluations}
    found = efficiency.optimise(start, **settings, check=0, jobs=1, store=kept)
    (one, many), searched = gain(found.evaluations[1:], first, allowed), time.process_time() - clock
    good = [e for e in found.evaluations[1:] if e.feasible(allowed)]
    recognised = sum(is_near(model(e.variables), edges) for e in good)
    return (
        f"| `{name}` | {100.0 * one:+.1f} % | {many} of {evaluations} | {searched:.0f} s | {100.0 * random:+.1f} % "
        f"| {near} of {len(places)}, {len(drawn)} near | {spent:.0f} s "
        f"| {recognised} of {len(good)} |"
    )


def main(argv: Sequence[str] | None = None) -> None:
    """Print a row for each pair."""
    parser = command_line(__doc__)
    parser.add_argument("--evaluations", type=int, default=100)
    parser.add_argument("--times", type=int, default=10)
    parser.add_argument("--pairs", nargs="+", default=PAIRS)
    parser.add_argument("--store", type=Path, default=None, help="folder of the evaluations of the search")
    arguments = parser.parse_args(argv)
    print(
        "| pair | search | within limits | time | random search | within limits | time | selected |"
        "\n|---|---|---|---|---|---|---|---|"
    )
    for name in arguments.pairs:
        print(compare(name, arguments.evaluations, arguments.times, arguments.store), flush=True)


if __name__ == "__main__":
    main()
