"""Result of an optimisation: all points, the Pareto front, and the candidates checked on the full mesh."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from efficiency.machine_settings.settings_result import SettingsResult
from efficiency.optimisation.evaluation import Evaluation, settings_of
from efficiency.optimisation.problem import SearchProblem
from ehl.common.arrays import FloatArray, finite_or_none
from ehl.common.pages import Reportable, StatusOfReason
from ehl.uncertainty.result import Change, combined

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class Candidate:
    """A point of the front after its check: full mesh, own elastic bodies, all states."""

    name: str  # name of its design
    point: Evaluation  # result of the search
    exact: Evaluation  # result on the full mesh, with the interval of the loss
    start: Evaluation  # the start on the full mesh
    allowed: dict[str, float]  # limits, with the values of the start on the full mesh

    def change(self, name: str) -> float:
        """Relative change of a figure against the start; nan if the start has none [-]."""
        old = self.start.figures.get(name, math.nan)
        return self.exact.figures.get(name, math.nan) / old - 1.0 if old else math.nan

    @property
    def holds(self) -> bool:
        """Whether the checked figures are within all limits."""
        return self.exact.feasible(self.allowed)

    @property
    def gain(self) -> float:
        """Relative reduction of the loss [-]."""
        return -self.change("power_loss")

    @property
    def gain_interval(self) -> tuple[float, float]:
        """90 % interval of the gain of the aligned pair, with fully correlated errors before and after."""
        if not self.exact.losses or not self.start.losses:
            return math.nan, math.nan
        new, old = self.exact.losses, self.start.losses
        ratio = math.log(new["aligned"][0] / old["aligned"][0])
        changes = []
        for name in (name for name in new if name in old and name not in ("aligned", "interval")):
            below, above = (
                math.log(after / before) - ratio for after, before in zip(new[name], old[name], strict=True)
            )
            changes.append(Change(name, group="", sd=math.nan, below=below, above=above))
        low, high = (float(end) for end in combined(changes))
        return 1.0 - math.exp(ratio + high), 1.0 - math.exp(ratio + low)

    @property
    def solved_gain(self) -> tuple[float, float]:
        """Gain of the aligned pair with the friction model of the check, and its error [-]; nan without a check."""
        if not self.exact.solved or not self.start.solved:
            return math.nan, math.nan
        (new, new_error), (old, old_error) = self.exact.solved, self.start.solved
        return 1.0 - new / old, new / old * math.hypot(new_error / new, old_error / old)

    @property
    def verdict(self) -> str:
        """Whether the limits are met and whether the gain exceeds the uncertainty of friction, in words."""
        if self.exact.reason:
            return self.exact.reason
        above = [f"{name} {100.0 * share:+.1f} %" for name, share in self.exact.excess(self.allowed).items()]
        if above:
            return "above the limit: " + ", ".join(above)
        low, _ = self.gain_interval
        return "gain certain at 90 %" if low > 0.0 else "gain smaller than the uncertainty of friction"


def best_of(candidates: Sequence[Candidate], first: str) -> Candidate | None:
    """The candidate within all limits with the lowest figure `first`; None if none is better than the start."""
    better = [c for c in candidates if c.holds and c.exact.figures[first] < c.start.figures[first]]
    return min(better, key=lambda candidate: candidate.exact.figures[first], default=None)


@dataclass(frozen=True, repr=False)
class Optimisation(StatusOfReason, Reportable):
    """Result of an optimisation; SI units."""

    presenter = "efficiency.optimisation.report:optimisation"
    file_name = "optimise"

    name: str  # name of the initial targets
    problem: SearchProblem  # variables, objectives, limits, duty, states, friction
    start: Evaluation  # the start on the mesh of the search
    allowed: dict[str, float]  # limits on that mesh
    evaluations: tuple[Evaluation, ...]  # all points, the start first
    candidates: tuple[Candidate, ...]  # checked points in their order
    search_states: tuple[dict[str, float], ...]  # states of the search; the check uses all states of the problem
    notes: tuple[str, ...]  # notes on the run
    gain_split: dict[str, float]  # gain of the best candidate by kind of variable; empty for one kind
    # seed of the random numbers; worker processes; evaluations read from an earlier run
    seed: int
    jobs: int
    reused: int
    seconds: float  # wall time

    @property
    def front(self) -> tuple[Evaluation, ...]:
        """Non-dominated points within all limits, in the order of the first objective."""
        return front_of(self.evaluations, self.problem.objectives, self.allowed)

    @property
    def best(self) -> Candidate | None:
        """The checked point within all limits with the best first objective; None if none is better than the start."""
        return best_of(self.candidates, self.problem.objectives[0])

    @property
    def reason(self) -> str:
        """That no checked point is within the limits and better than the start; empty otherwise."""
        if self.best is not None:
            return ""
        first, count = self.problem.objectives[0], len(self.evaluations) - 1
        better = sum(point.figures[first] < self.start.figures[first] for point in self.front)
        if better and not self.candidates:
            return f"{better} better points within the limits on the mesh of the search, none was checked"
        return f"none of {count} points is better within the limits"

    def settings(self, candidate: Candidate) -> SettingsResult:
        """Machine settings and design of a candidate."""
        return settings_of(self.problem, candidate.point.variables, candidate.name)

    def _write_all(self, folder: Path, **options: Any) -> list[Path]:
        from efficiency.optimisation.report import write_designs

        return [*super()._write_all(folder, **options), *write_designs(self, folder)]

    def to_frame(self) -> pandas.DataFrame:
        """One row per evaluation, SI units."""
        from efficiency.optimisation.report import evaluations_table

        return evaluations_table(self).to_frame()

    def to_dict(self) -> dict[str, Any]:
        """Content for JSON; not-a-number becomes None."""
        best = self.best
        front = {point.key for point in self.front}
        rows = [
            {"variables": e.variables, "figures": e.figures, "status": state_of(e, self.allowed), "reason": e.reason}
            | {"front": e.key in front}
            for e in self.evaluations
        ]
        checked = [
            {"name": c.name, "variables": c.point.variables, "figures": c.exact.figures}
            | {name: getattr(c, name) for name in ("gain", "gain_interval", "solved_gain", "holds", "verdict")}
            for c in self.candidates
        ]
        names = ("name", "status", "reason", "gain_split", "notes", "seed", "reused", "seconds")
        head = {name: getattr(self, name) for name in names} | {
            "best": best.name if best else None,
            "objectives": self.problem.objectives,
            "limits": self.allowed,
            "friction_model": self.problem.friction,
            "oil": self.problem.oil,
            "states": self.problem.states,
            "start": {"variables": self.problem.start_values, "figures": self.start.figures},
            "candidates": checked,
            "evaluations": rows,
        }
        plain: dict[str, Any] = finite_or_none(head)
        return plain

    def __repr__(self) -> str:
        best, count = self.best, len(self.evaluations)
        found = self.reason if best is None else f"loss {100.0 * best.change('power_loss'):+.1f} % ({best.name})"
        return f"Optimisation({self.name}: {count} evaluations, {len(self.front)} on the front, {found})"


def state_of(point: Evaluation, allowed: Mapping[str, float]) -> str:
    """``feasible``, ``limit`` (one is exceeded), or ``failed``."""
    return "failed" if point.reason else "feasible" if point.feasible(allowed) else "limit"


def front_of(
    points: Sequence[Evaluation], objectives: Sequence[str], allowed: Mapping[str, float]
) -> tuple[Evaluation, ...]:
    """Non-dominated points among those within the limits, in the order of the first objective."""
    kept = list({p.key: p for p in points if p.feasible(allowed)}.values())
    if not kept:
        return ()
    values = np.array([[p.figures[name] for name in objectives] for p in kept])
    chosen = [kept[k] for k in np.flatnonzero(non_dominated(values))]
    return tuple(sorted(chosen, key=lambda p: p.figures[objectives[0]]))


def non_dominated(points: FloatArray) -> NDArray[np.bool_]:
    """Mask (n,) of non-dominated points among n points (n, m); of equal points the first one counts."""
    keep = np.ones(len(points), dtype=bool)
    for k, point in enumerate(points):
        as_good = np.all(points <= point, axis=1)
        better = np.any(points < point, axis=1)
        same_before = np.all(points[:k] == point, axis=1).any()
        keep[k] = not (as_good & better).any() and not same_before
    return keep


def spread_out(points: FloatArray, count: int) -> list[int]:
    """Indices of the best point in each figure, then of the points farthest from those selected (maximin)."""
    span = np.ptp(points, axis=0)
    scaled = (points - points.min(axis=0)) / np.where(span > 0.0, span, 1.0)
    taken = list(dict.fromkeys(int(np.argmin(points[:, j])) for j in range(points.shape[1])))[:count]
    while len(taken) < min(count, len(points)):
        distance = np.min(np.linalg.norm(scaled[:, None] - scaled[taken][None], axis=2), axis=1)
        taken.append(int(np.argmax(distance)))
    return taken
