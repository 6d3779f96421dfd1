"""Check of points on the full mesh with their own elastic bodies in all states, and correction of the search.

The search uses a coarse mesh and, where only the ease-off is varied, the bodies of the start. Its best points are
checked during the search, and their errors correct the figures of neighbouring points.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from efficiency.mesh import POINTS_PER_LINE, POSITIONS
from efficiency.optimisation.evaluation import Evaluation, EvaluationTask, allowed_of, evaluate_all
from efficiency.optimisation.problem import PARTS, SearchProblem
from efficiency.optimisation.result import Candidate, front_of, spread_out
from ehl.common.arrays import FloatArray
from ehl.common.data import reason_text
from ehl.common.journal import Journal
from ehl.common.quantities import quantities
from ehl.common.runner import this_process

Evaluate = Callable[[list[EvaluationTask]], list[Evaluation]]

CHECK_GRID = (POSITIONS, POINTS_PER_LINE)
"""Positions and points per line of a check."""
# relative margin of the search below the limits, before and after points were checked (this work)
_MARGIN, _MARGIN_CHECKED = 0.015, 0.0075
# maximum number of checks until a point is within the limits
_ROUNDS = 3
# largest correction of a figure; smallest correction with a note
_MOST, _WORTH_A_NOTE = 0.1, 5e-4
# squared distance in the cube of the variables below which points are equal
_SAME = 1e-9


@dataclass(frozen=True)
class Correction:
    """Errors of the limited figures of the search, from the points that were checked.

    The error is the logarithm of exact over computed figure, each relative to its limit. Between checked points it is
    the mean weighted by the inverse square of the distance in the cube of the variables (Shepard, Proc. 23rd ACM Nat.
    Conf. (1968) 517).

    `allowed` are the limits on the mesh of the search; `known` has position and errors of each checked point, by key.
    """

    problem: SearchProblem
    allowed: dict[str, float]
    known: Mapping[str, tuple[FloatArray, FloatArray]] = field(default_factory=dict)

    def __call__(self, point: Evaluation) -> Evaluation:
        """The point with its figures corrected to the full mesh."""
        if not self.known or point.reason:
            return point
        places, errors = (np.array(part) for part in zip(*self.known.values(), strict=True))
        weights = 1.0 / (((self.problem.places_of([point.variables]) - places) ** 2).sum(axis=1) + _SAME)
        factors = np.exp(weights @ errors / weights.sum())
        corrected = {name: point.figures[name] * float(f) for name, f in zip(self.allowed, factors, strict=True)}
        return replace(point, figures=point.figures | corrected)

    @property
    def limits(self) -> dict[str, float]:
        """Limits of the search, with a margin."""
        margin = _MARGIN_CHECKED if self.known else _MARGIN
        return {name: value * (1.0 - margin) for name, value in self.allowed.items()}

    def updated(self, point: Evaluation, exact: Evaluation, limited: Mapping[str, float]) -> Correction:
        """The correction with another checked point; `limited` are the limits of the check."""
        errors = np.array([self._error(name, point, exact, limited) for name in self.allowed])
        (place,) = self.problem.places_of([point.variables])
        return replace(self, known={**self.known, point.key: (place, errors)})

    def _error(self, name: str, point: Evaluation, exact: Evaluation, limited: Mapping[str, float]) -> float:
        """Error of one figure; zero for edge loads, which may vanish."""
        old, new = (e.figures[name] / limit for e, limit in ((point, self.allowed[name]), (exact, limited[name])))
        if name == "edge_load_share" or not (0.0 < old < math.inf and 0.0 < new < math.inf):
            return 0.0
        return math.log(min(max(new / old, 1.0 - _MOST), 1.0 + _MOST))

    @property
    def notes(self) -> list[str]:
        """Figures that the search underestimated; empty if the errors are small."""
        if not self.known:
            return []
        worst = np.expm1(np.max([errors for _, errors in self.known.values()], axis=0))
        low = ", ".join(
            f"{quantities()[name].label} {100.0 * share:.1f} %"
            for name, share in zip(self.allowed, worst, strict=True)
            if share > _WORTH_A_NOTE
        )
        return [f"underestimated by the coarse search mesh, corrected near the best points: {low}"] if low else []


def exact_task(task: EvaluationTask) -> EvaluationTask:
    """The task on the full mesh, with own bodies, in all states."""
    return replace(task, states=task.problem.states, grid=CHECK_GRID, bodies="", interval=True)


def check_best(
    task: EvaluationTask, points: Sequence[Evaluation], correction: Correction, evaluate: Evaluate
) -> Correction:
    """The correction by start and best point so far; unchanged if no point is within the limits or the check fails."""
    start, *others = points
    within = [p for p in others if correction(p).feasible(correction.limits)]
    if not within:
        return correction
    best = min(within, key=lambda p: p.figures[task.problem.objectives[0]])
    exact = exact_task(task)
    before, after = evaluate([exact, replace(exact, values=best.variables)])
    if before.reason or after.reason:
        return correction
    limited = allowed_of(task.problem, before)
    return correction.updated(start, before, limited).updated(best, after, limited)


def check_front(
    task: EvaluationTask, points: Sequence[Evaluation], correction: Correction, count: int, evaluate: Evaluate
) -> tuple[tuple[Candidate, ...], str]:
    """Checked points of the front, or of others if none of them is within the limits; the reason if there is none."""
    problem, allowed, exact = task.problem, correction.allowed, exact_task(task)
    if not front_of(points[1:], problem.objectives, allowed):
        return (), "no point of the search is within all limits"
    (start,) = evaluate([exact])
    if start.reason:
        return (), f"the start on the full mesh: {reason_text(start.reason)}"
    limited = allowed_of(problem, start)
    candidates: dict[str, Candidate] = {}
    for _ in range(_ROUNDS):
        left = [p for p in points[1:] if p.key not in candidates]
        corrected = [correction(p) for p in left]
        tried = ((corrected, correction.limits), (corrected, allowed), (left, allowed))
        chosen = next((found for near, limits in tried if (found := _chosen(problem, near, limits, count))), [])
        found = evaluate([replace(exact, values=p.variables) for p in chosen])
        for seen, checked in zip(chosen, found, strict=True):
            point = next(p for p in left if p.key == seen.key)
            name = f"{problem.start.name}_optimum_{len(candidates) + 1}"
            candidates[point.key] = Candidate(name, point, checked, start, limited)
            if not checked.reason:
                correction = correction.updated(point, checked, limited)
        if any(c.holds for c in candidates.values()):
            break
    return tuple(candidates.values()), ""


def _chosen(
    problem: SearchProblem, points: Sequence[Evaluation], allowed: Mapping[str, float], count: int
) -> list[Evaluation]:
    """Points to check: spread over the front; if the front is short, also the next best in the first objective."""
    front = front_of(points, problem.objectives, allowed)
    if len(front) >= count:
        values = np.array([[p.figures[name] for name in problem.objectives] for p in front])
        return [front[k] for k in sorted(spread_out(values, count))]
    on_front = {p.key for p in front}
    others = {p.key: p for p in points if p.feasible(allowed) and p.key not in on_front}
    first = problem.objectives[0]
    return [*front, *sorted(others.values(), key=lambda p: p.figures[first])][:count]


def gain_split(task: EvaluationTask, best: Candidate | None, evaluate: Evaluate) -> dict[str, float]:
    """Gain of the best candidate by `PARTS`, which take its values one after the other; the gains add up to the whole.

    A part within which a point cannot be computed has the gain nan; empty for fewer than two parts.
    """
    problem = task.problem
    named = {v.name for v in problem.variables}
    parts = {part: names for part, all_of in PARTS.items() if (names := named & set(all_of))}
    if best is None or len(parts) < 2:
        return {}
    points = [dict(problem.start_values)]
    for names in parts.values():
        points.append(points[-1] | {name: best.point.variables[name] for name in names})
    between = evaluate([replace(exact_task(task), values=values, interval=False) for values in points[1:-1]])
    losses = [e.figures["power_loss"] if not e.reason else math.nan for e in (best.start, *between, best.exact)]
    return {part: (losses[k] - losses[k + 1]) / losses[0] for k, part in enumerate(parts)}


def check_solved(
    task: EvaluationTask, candidates: tuple[Candidate, ...], solved: str, journal: Journal
) -> tuple[tuple[Candidate, ...], str]:
    """The best candidate and the start computed with a friction model that solves contacts; the reason of failure."""
    held = [c for c in candidates if c.holds]
    if not held:
        return candidates, ""
    best = min(held, key=lambda c: c.exact.figures[task.problem.objectives[0]])
    exact = replace(exact_task(task), interval=False, solved=solved)
    # solved contacts start their own processes
    before, after = evaluate_all([replace(exact, values=v) for v in ({}, best.point.variables)], this_process, journal)
    if before.reason or after.reason:
        return candidates, f"check with {solved}: {reason_text(before.reason or after.reason)}"
    checked = replace(
        best, exact=replace(best.exact, solved=after.solved), start=replace(best.start, solved=before.solved)
    )
    return tuple(checked if c is best else c for c in candidates), ""
