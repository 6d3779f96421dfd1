"""Work of the meshes of a rough contact: start-up, number of meshes, and which one is extended, by numbers."""

import math
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from refusals import fails

from ehl.rough.accuracy import RunPlan
from ehl.rough.multilevel import MeshLevels, affordable, least_levels, least_work, start_up

# one block of 4 b, 12 to 96 b on the coarsest mesh and 8 b on finer ones; start-up of 2.9 b and 1.5 b on each mesh
PLAN = RunPlan(0.01, 0.05, 12.0, 96.0, 2.9, 1.5, boundary_study=False, block=4.0, window_fine=8.0, budget=1e4)


@pytest.mark.parametrize(
    ("inlet", "levels", "least", "work"),
    [
        (math.inf, 4, 2, 5.5 + 3.4 * 5.5),
        (0.1, 4, 3, 7.0 + 3.4 * 7.0 + 3.4**2 * 5.5),  # 0.35 of the inlet is finer than four spacings, not than two
        (0.08 / 0.7, 4, 2, 24.2),
        (0.01, 3, 3, 94.38),
    ],
)
def test_smallest_number_of_meshes_and_their_work(inlet: float, levels: int, least: int, work: float) -> None:
    plan = replace(PLAN, inlet=inlet)
    assert least_levels(plan, levels) == least
    assert least_work(plan, 10.0, 2.0, levels) == pytest.approx(20.0 + 10.0 * work)


@pytest.mark.parametrize(
    ("budget", "count"), [(5745.5, 4), (5745.4, 3), (886.2, 3), (886.0, 2), (0.0, 2), (math.inf, 4)]
)
def test_number_of_meshes_within_a_budget(budget: float, count: int) -> None:
    """150 of work and, for four, 165 + 425 + 1271.6 + 3733.88; for three 150 + 374 + 1098.2, within two budgets."""
    coarsest: Any = SimpleNamespace(work=100.0, rate=10.0)
    assert affordable(replace(PLAN, budget=budget), coarsest, 4, 50.0) == count


@dataclass
class Rolled:
    """A window that only counts."""

    rate: float  # work per b
    rolled: float = 0.0
    work: float = 0.0
    blocks: list[float] = field(default_factory=list)

    def block(self, travel: float) -> None:
        self.blocks.append(travel)
        self.rolled += travel
        self.work += self.rate * travel


class Counted(MeshLevels):
    """mu 0.05 with variances that fall with the travel: of the coarsest mesh and of each difference."""

    spreads: tuple[float, ...] = (0.0, 0.0)
    change = 0.0

    def half_widths(self) -> list[float]:
        return [math.sqrt(s / w.rolled) if w.rolled else 0.0 for s, w in zip(self.spreads, self.windows, strict=True)]

    def interval(self) -> tuple[float, float]:
        return 0.05, math.hypot(*self.half_widths())

    def friction(self) -> float:
        return 0.05

    def differences(self, level: int) -> Any:
        assert level == len(self.windows) - 1
        return np.array([self.change])


def counted(plan: RunPlan, spreads: tuple[float, ...], rolled: tuple[float, ...] = (0.0, 0.0), **more: Any) -> Counted:
    windows: Any = [Rolled(10.0 * 4.0**k, travel, 10.0 * 4.0**k * travel) for k, travel in enumerate(rolled)]
    found = Counted(windows, plan, **more)
    found.spreads = spreads
    return found


# the interval is 5 % of 0.05 where the sum of spread over travel is 6.25e-6
@pytest.mark.parametrize(
    ("spreads", "change", "travels"),
    [
        ((7.4e-5, 0.0), {}, (12.0, 8.0)),
        ((7.6e-5, 0.0), {}, (16.0, 8.0)),
        ((7.4e-5, 5.1e-5), {}, (32.0, 16.0)),  # the largest gain per work: of six blocks four on the coarse mesh first
        ((9e-4, 0.0), {}, (96.0, 8.0)),  # full
        ((2e-4, 0.0), {"budget": 600.0}, (28.0, 8.0)),  # the budget ends it
        ((2e-4, 0.0), {"budget": 640.0}, (32.0, 8.0)),
        ((2e-4, 0.0), {"budget": 640.0, "reserved": 41.0}, (24.0, 8.0)),
        ((8e-4, 0.0), {"budget": 600.0}, (52.0, 8.0)),  # within two budgets the interval is 8 %
        ((2e-1, 0.0), {"budget": 1000.0}, (40.0, 8.0)),  # unlikely to settle: three quarters of it
        ((2e-1, 0.0), {"budget": 270.0}, (12.0, 4.0)),  # the shortest window of a finer mesh is one block
        ((2e-2, 0.0), {"budget": 1000.0}, (200.0, 8.0)),  # within eight budgets the interval is 20 %
        ((2e-2, 0.0), {"budget": 1e9, "reserved": 4e8 - 1e3}, (96.0, 8.0)),  # no more than 4e8 for that
        ((2e-2, 0.0), {"window_max": 12.0, "window_min": 10.0}, (12.0, 8.0)),
        ((2e-2, 0.0), {"window_max": 10.0, "window_min": 10.0, "budget": 0.0}, (10.0, 10.0)),
    ],
)
def test_travel_of_each_mesh(spreads: tuple[float, ...], change: dict[str, float], travels: tuple[float, ...]) -> None:
    reserved = change.pop("reserved", 0.0)
    levels = counted(replace(PLAN, **change), spreads, reserved=reserved)  # type: ignore[arg-type]
    levels.roll()
    assert tuple(window.rolled for window in levels.windows) == travels
    if levels.plan.window_max == levels.plan.window_min:
        assert [window.blocks for window in levels.windows] == [[4.0, 4.0, 2.0]] * 2  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("change", "budget", "needed"),
    [(0.006, 442.0, True), (-0.006, 442.0, True), (0.0049, 442.0, False), (0.006, 440.0, False)],
)
def test_a_finer_mesh_where_two_differ(change: float, budget: float, needed: bool) -> None:
    """120 + 320 of work so far, 3.4 x 40 x (1.5 + 8) = 1292 for another mesh, twice the budget at most: 881."""
    levels = counted(replace(PLAN, budget=2.0 * budget), (0.0, 0.0), (12.0, 8.0))
    levels.change = change
    levels.windows[0].work, levels.windows[1].work = 120.0, 352.0  # type: ignore[misc]
    assert levels.finer_needed() is needed


class Started:
    """The coarsest mesh of a start-up, of five steps per half-width and 10 of work per b."""

    def __init__(self, thermal: bool) -> None:
        settings, units = SimpleNamespace(thermal=thermal), SimpleNamespace(steps_per_half_width=5)
        self.problem = SimpleNamespace(settings=settings, units=units)
        self.run, self.batch, self.steps, self.work = self, 2.0, 0, 0.0
        self.pieces: list[float] = []
        self.warmed: list[tuple[str, float]] = []

    def start(self, travel: float) -> None:
        self.pieces.append(travel)
        self.steps += round(5 * travel)
        self.work += 10.0 * travel

    @property
    def travel(self) -> float:
        return self.steps / 5

    def branch(self, problem: RunPlan) -> "Started":
        assert problem.reduced
        return self

    def mean_flux(self, travel: float) -> Any:
        self.warmed.append(("flux", travel))
        return np.array([1.0 * len(self.warmed)])

    def preheat(self, travel: float, flux: Any) -> None:
        assert flux[0] == len(self.warmed)
        self.warmed.append(("heat", travel))


@pytest.mark.parametrize(
    ("change", "thermal", "pieces", "warming"),
    [
        ({"window_max": 12.0}, False, [10.0], 0.0),
        ({"window_max": 12.0, "give_up": 1e9}, True, [10.0], 0.0),
        ({}, False, [2.8, 2.8, 2.8, 1.6], 0.0),
        ({"give_up": 343.0}, False, [0.4, 2.8, 2.8, 2.8, 1.2], 0.0),
        ({"give_up": 341.0}, False, [0.4], None),  # 4 + 96 to go, and 242 of two meshes
        ({"settling": 4.5}, True, [2.8, 2.8, 2.8, 2.8, 1.8], 13.0),  # 3 b more until the bodies are warm
        ({"settling": 4.5}, False, [2.8, 2.8, 2.8, 1.6], 0.0),
        ({"settling": 4.5, "preheating": 3.0}, True, [2.8, 2.8, 2.8, 1.6], 3.0),
        ({"bound": 341.0}, False, [2.8, 0.2], 0.0),  # 28 + 72 + 242 of two meshes is above: the start-up becomes 3 b
        ({"bound": 343.0}, False, [2.8, 2.8, 2.8, 1.6], 0.0),
        ({"bound": 341.0, "reduced": True}, False, [2.8, 2.8, 2.8, 1.6], 0.0),
    ],
)
def test_start_up(
    monkeypatch: pytest.MonkeyPatch, change: dict[str, Any], thermal: bool, pieces: list[float], warming: float | None
) -> None:
    def shortened(plan: RunPlan, length: float) -> RunPlan:
        assert length == 0.07
        return replace(plan, startup=3.0, batch=1.0, reduced=True)

    monkeypatch.setattr("ehl.rough.multilevel.reduced_plan", shortened)
    window: Any = Started(thermal)
    given = replace(PLAN, startup=10.0, **change)
    with fails("mesh_budget") if warming is None else nullcontext():
        plan, flux, travel = start_up(window, given, 4, 0.07, lambda plan: plan)  # type: ignore[arg-type, return-value]
    assert window.pieces == pytest.approx(pieces)
    if warming is None:
        return
    assert travel == pytest.approx(warming)
    assert plan.reduced is (given.reduced or given.bound < 342.0)
    assert window.batch == plan.batch
    rounds = [("flux", 0.5), ("heat", 3.0)] * 2 if given.preheating else []
    assert window.warmed == [*rounds, ("flux", 0.5)] * (warming > 0.0)
    assert (flux is None) is (warming == 0.0)
