"""Multilevel mean of mu from runs of one contact on meshes of increasing fineness over the same roughness.

mu = mean on the coarsest mesh + mean difference of each mesh to the one before it + a third of the last difference,
the error of the finest mesh by Richardson extrapolation (`ehl.rough.averaging.richardson`). Both meshes of a
difference move over the same part of the surfaces, so that it converges in a fraction of the travel of mu itself. The
fine meshes therefore need short windows; the coarsest has a long one at a fraction of the cost (multilevel Monte Carlo,
Giles 2008, Oper. Res. 56, 607, with time means instead of samples).

Start-up of the coarsest mesh until roughness, macroscopic pressure and heat are settled, with bounded work.

The work is checked every few b. If even the shortest windows would exceed the bound of the plan, the run continues with
the reduced plan (`reduced_plan`), or ends if another model can replace it. Work is counted in iterations, not timed,
so that results do not depend on the machine.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.special import stdtrit

from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError
from ehl.rough._kernels.march import FILM_MEAN, SHARE
from ehl.rough.accuracy import FRONT_STARTUP, PER_SWEEP, SETTLING, RunPlan, reduced_plan
from ehl.rough.averaging import ONE_DRAW, Window, batch_means, interval_of_means, richardson
from ehl.rough.scaling import RunProblem

FIRST_LOOK = 0.3  # travel of the first check, before the roughness and most of the work [b]
WARMING_ROUNDS, WARMING_TRAVEL = 2, 0.5  # rounds of preheating; travel for its mean flux [b]


def start_up(
    window: Window, plan: RunPlan, levels: int, correlation_length: float, problem: Callable[[RunPlan], RunProblem]
) -> tuple[RunPlan, FloatArray | None, float]:
    """Advance the coarsest mesh until it is settled.

    window: of the coarsest mesh.
    levels: number of meshes of the accuracy.
    correlation_length: of the roughness [b].
    problem: returns the problem of the coarsest mesh for a plan.
    Returns: plan, reduced if its bound requires it; flux: mean heat flux into the surfaces for the finer meshes [W/m2],
    shape (2, n); warming: travel of their preheating [b].
    Raises `ConvergenceError`: "mesh_budget": the shortest run would take more than `plan.give_up`.
    """
    thermal = window.run.problem.settings.thermal
    bounded = plan.window_max > plan.window_min
    per_half_width = window.run.problem.units.steps_per_half_width
    wait = plan.settling - SETTLING if thermal and bounded and not plan.preheating else 0.0
    steps = round(plan.startup * per_half_width) + round(wait * per_half_width)
    look = round(FRONT_STARTUP * per_half_width) if bounded else steps
    first = round(FIRST_LOOK * per_half_width) if bounded and math.isfinite(plan.give_up) else look
    while window.steps < steps:
        before, piece = window.work, min(look if window.steps else first, steps - window.steps) / per_half_width
        window.start(piece)
        left = (steps - window.steps) / per_half_width
        rate = (window.work - before) / piece
        if bounded and not plan.reduced and window.work + least_work(plan, rate, left, levels) > plan.bound:
            plan = reduced_plan(plan, correlation_length)
            window.batch = plan.batch
            window.run = window.run.branch(problem(plan))
            steps = round(plan.startup * per_half_width)
            left = (steps - window.steps) / per_half_width
        if bounded and window.work + least_work(plan, rate, left, levels) > plan.give_up:
            raise ConvergenceError("mesh_budget", "a mesh that resolves the roughness takes more work than allowed")
    if plan.preheating:
        return plan, warmed(window, plan), plan.preheating
    if thermal and bounded:
        # the finer meshes are preheated by the flux of the coarsest over the same travel
        return plan, window.mean_flux(WARMING_TRAVEL), window.run.travel
    return plan, None, 0.0


def least_work(plan: RunPlan, rate: float, left: float, levels: int) -> float:
    """Work of the rest of the start-up and one block on the smallest number of meshes.

    rate: work per b of travel on the coarsest mesh.
    left: remaining travel of the start-up [b].
    levels: number of meshes of the accuracy.
    """
    least = least_levels(plan, levels)
    return rate * left + sum(
        rate * (4.0 * FINER_STEP) ** k * (SETTLING * (least - max(k, 1)) + plan.block) for k in range(least)
    )


def warmed(window: Window, plan: RunPlan) -> FloatArray:
    """Preheat the surfaces of a run by its mean heat flux, instead of a longer start-up; returns that flux."""
    for _ in range(WARMING_ROUNDS):
        flux = window.mean_flux(WARMING_TRAVEL)
        window.run.preheat(plan.preheating, flux)
    return window.mean_flux(WARMING_TRAVEL)


UNLIKELY = 1.5  # predicted interval at the end of the budget, over the tolerance, above which convergence is unlikely
SHARE_WITHOUT_HOPE = 0.75  # share of the budget for such a contact
ERROR_ALLOWED = 4.0  # error over the required tolerance above which a rough result is not converged
# budgets for an interval above the allowed one that this work is expected to settle, and its limit of about a minute
LONGER, LONGEST = 8.0, 4e8
SMALL_PART = 0.05  # share of the squared error below which a level is not extended
# difference of mu on two meshes above which a finer mesh than the budget permits is added, and the budgets for it and
# for all meshes but the finest
DIFFERENCE_ALLOWED, BUDGETS = 0.1, 2.0
# tuned: interval over the tolerance for which these budgets are used as well if they are expected to reach it. 63
# contacts of the plan `gear`, "fast": 90 % quantile of the error of mu 6.7 -> 5.7 %, processor time + 2 %
WIDE = 1.6
EXTRAPOLATED = 4.0 / 3.0  # weight of the finest difference in the extrapolated mean
# tuned on 384 points with eight profiles each (docs/validation_mixed.md): half width of a window of so many batches,
# over mu and the root of share (1 - share)
EXPECTED, EXPECTED_BATCHES = 0.15, 6.0
# tuned with validation/work_precision.py: iterations of a step over those on twice the spacing
FINER_STEP = 0.85


def in_common(finer: Window, coarser: Window) -> list[int]:
    """Blocks that both meshes have.

    Raises `ConvergenceError`: "film_jump": there is none, as the blocks of one mesh diverged repeatedly.
    """
    common = sorted(set(finer.numbers) & set(coarser.numbers))
    if not common:
        raise ConvergenceError("film_jump", "two meshes have no valid block in common")
    return common


@dataclass
class MeshLevels:
    """Windows of the same contact, the coarsest mesh first."""

    windows: list[Window]  # each mesh has half the spacing of the one before
    plan: RunPlan  # tolerance, windows and budget
    reserved: float = 0.0  # work reserved for the study of the boundary film
    _changes: dict[int, tuple[tuple[int, int], FloatArray]] = field(default_factory=dict, repr=False)
    _widths: tuple[list[int], list[float]] = field(default=([], []), repr=False)  # steps of the windows, `half_widths`

    @property
    def work(self) -> float:
        """Work of all meshes so far."""
        return sum(window.work for window in self.windows)

    @property
    def fine(self) -> Window:
        """The finest mesh."""
        return self.windows[-1]

    @property
    def even(self) -> bool:
        """Whether all meshes have the same blocks, so that the mean is that of the finest."""
        return all(window.numbers == self.fine.numbers for window in self.windows)

    @property
    def longest(self) -> Window:
        """The window with the longest travel, the finest of several with the same."""
        return max(reversed(self.windows), key=lambda window: round(window.rolled, 6))

    def differences(self, level: int) -> FloatArray:
        """Mean of mu on a mesh minus that on the one before, in parts of half a batch of their common travel."""
        finer, coarser = self.windows[level], self.windows[level - 1]
        rolled = len(finer.numbers), len(coarser.numbers)
        if level not in self._changes or self._changes[level][0] != rolled:
            common = in_common(finer, coarser)
            pieces = coarser.pieces(common, 0.5 * self.plan.batch)
            self._changes[level] = rolled, finer.parts(common, pieces) - coarser.parts(common, pieces)
        return self._changes[level][1]

    def mean(self, column: int, *, film: bool = False) -> float:
        """Time mean of a column of the records; of a film in m."""
        coarsest = self.windows[0]
        total = (coarsest.run.problem.units.film if film else 1.0) * float(coarsest.records[:, column].mean())
        for level in range(1, len(self.windows)):
            fine, coarse = self._pair(level, column, film)
            total = total + fine - coarse
        return total

    def friction(self) -> float:
        """mu, extrapolated."""
        return self._extrapolated()[0]

    def mesh_error(self) -> float:
        """Error of the extrapolated mu by mesh and time step."""
        return self._extrapolated()[1]

    def share(self) -> float:
        """Asperity load share, extrapolated like mu."""
        return self._limit(SHARE)[0]

    def film(self) -> tuple[float, float]:
        """Mean film [m], extrapolated, and its error by the mesh."""
        return self._limit(FILM_MEAN, film=True)

    def _extrapolated(self) -> tuple[float, float]:
        if self.even:
            mean = float(self.fine.friction().mean())
        else:
            mean = float(self.windows[0].friction().mean())
            mean += sum(float(self.differences(level).mean()) for level in range(1, len(self.windows)))
        return richardson(mean - float(self.differences(len(self.windows) - 1).mean()), mean)

    def _limit(self, column: int, *, film: bool = False) -> tuple[float, float]:
        """Mean of a column, extrapolated, and its error by the mesh."""
        mean, (fine, coarse) = self.mean(column, film=film), self._pair(-1, column, film)
        return richardson(mean - (fine - coarse), mean)

    def _pair(self, level: int, column: int, film: bool) -> tuple[float, float]:
        """Means of a column on a mesh and on the one before over their common travel; of a film in m."""
        finer, coarser = self.windows[level], self.windows[level - 1]
        common = in_common(finer, coarser)
        fine, coarse = (
            (window.run.problem.units.film if film else 1.0) * float(window.records_of(common)[:, column].mean())
            for window in (finer, coarser)
        )
        return fine, coarse

    def half_widths(self) -> list[float]:
        """Half widths of the 90 % intervals of the coarsest mean and of each difference, as they enter mu."""
        steps = [window.steps for window in self.windows]
        if self._widths[0] != steps:
            widths = [interval_of_means(self.differences(level)) for level in range(1, len(self.windows))]
            self._widths = steps, [self.windows[0].interval()[1], *widths[:-1], EXTRAPOLATED * widths[-1]]
        return self._widths[1]

    def interval(self) -> tuple[float, float]:
        """mu and the half width of its 90 % interval, including the drift after a shortened start-up."""
        mean, half_width = self._interval()
        return mean, math.hypot(half_width, self.drift())

    def stated(self) -> tuple[float, float]:
        """mu and the half width of its 90 % interval, widened where it is narrow by chance.

        Where asperities carry load, fluctuations are slow and skewed. Short windows then contain few independent
        values, and a run that ends at a required interval favours narrow ones. The squared half width is therefore the
        mean of the found and an expected one, weighted by their numbers of batches (empirical Bayes), if that is larger
        than the found one, and at most the required one. The expected one is that of independent patches with film or
        asperity contact: the variance of the load share s is proportional to s (1 - s) over the travel.
        The end of a run follows from `interval`.
        """
        mean, found = self.interval()
        if not math.isfinite(found):  # two meshes with too little common travel: one draw as in `Window.interval`
            found = ONE_DRAW * float(np.std(self.longest.friction()))
        share = min(max(self.share(), 0.0), 1.0)
        batches = self.longest.rolled / self.plan.batch
        expected = EXPECTED * mean * math.sqrt(share * (1.0 - share) * EXPECTED_BATCHES / batches)
        both = (batches * found**2 + EXPECTED_BATCHES * expected**2) / (batches + EXPECTED_BATCHES)
        return mean, max(found, min(math.sqrt(both), self.plan.tolerance * abs(mean)))

    def drift(self) -> float:
        """Part of the half width by a shortened start-up and window; 0 at their full length.

        The window counts as one draw of the block means on the coarsest mesh after the roughness has filled it. They
        contain slow changes and the drift of mu.
        """
        if not self.plan.reduced:
            return 0.0
        coarsest = self.windows[0]
        steps_per_half_width = coarsest.run.problem.units.steps_per_half_width
        mu = coarsest.friction_since(round(FRONT_STARTUP * steps_per_half_width))
        length = max(1, round(self.plan.block * steps_per_half_width))
        means = mu[mu.size % length :].reshape(-1, length).mean(axis=1)
        return float(stdtrit(means.size - 1, 0.95)) * float(np.std(means, ddof=1))

    def _interval(self) -> tuple[float, float]:
        """Interval with the covariance of mu and the first difference, which come from the same travel."""
        if self.even:
            common, last = self.fine.numbers, (EXTRAPOLATED - 1.0) * self.differences(len(self.windows) - 1)
            pieces = self.windows[-2].pieces(common, 0.5 * self.plan.batch)
            width = interval_of_means(self.fine.parts(common, pieces) + last)
            if not math.isfinite(width):  # too few parts: one draw as in `Window.interval`
                width = math.hypot(self.fine.interval()[1], ONE_DRAW * float(np.std(last)))
            return self.friction(), width
        widths = self.half_widths()
        total = sum(width**2 for width in widths)
        finer, coarser = self.windows[1], self.windows[0]
        common = in_common(finer, coarser)
        parts = coarser.parts(common, coarser.pieces(common, 0.5 * self.plan.batch))
        change = self.differences(1)
        if parts.std() > 0.0 and change.std() > 0.0:
            share = math.sqrt(len(common) / len(coarser.numbers))
            total += 2.0 * max(float(np.corrcoef(parts, change)[0, 1]), 0.0) * widths[0] * widths[1] * share
        return self.friction(), math.sqrt(total)

    def film_error(self) -> float:
        """Relative error of the mean film from the mesh and the 90 % interval of its time mean."""
        mean, mesh = self.film()
        window = self.longest
        film = window.run.problem.units.film * window.records[:, FILM_MEAN]
        _, half_width = batch_means(film, round(window.batch * window.run.problem.units.steps_per_half_width))
        if not math.isfinite(half_width):
            half_width = ONE_DRAW * float(np.std(film))
        return math.hypot(mesh, half_width) / mean

    def finer_needed(self) -> bool:
        """Whether the last two meshes differ much and a finer one needs at most twice the budget."""
        finer = 4.0 * FINER_STEP * self.fine.rate * (SETTLING + self.plan.window_fine) + self.work
        difference = abs(float(self.differences(len(self.windows) - 1).mean()))
        return difference > DIFFERENCE_ALLOWED * abs(self.friction()) and finer <= BUDGETS * self.plan.budget

    def roll(self) -> None:
        """Extend the windows until mu is within the tolerance, all windows are full or the budget is spent.

        Each block is computed on the mesh with the largest reduction of variance per work.
        """
        plan = self.plan
        budget = plan.budget - self.reserved
        shortest = [plan.window_min] + [plan.window_fine] * (len(self.windows) - 1)
        fixed = plan.window_max <= plan.window_min
        for window, travel in zip(self.windows, shortest, strict=True):
            wanted = plan.window_min if fixed else travel
            while window.rolled < wanted - 1e-9:
                if not fixed and window.rolled >= plan.block and self.work > budget:
                    break
                window.block(min(plan.block, wanted - window.rolled) if fixed else plan.block)
        if fixed:
            return
        if not self._can_settle(budget, UNLIKELY, plan.window_max):
            budget = max(SHARE_WITHOUT_HOPE * plan.budget - self.reserved, 0.0)
        self._extend(budget, 1.0, plan.window_max)
        twice = BUDGETS * plan.budget - self.reserved
        if self._can_settle(twice, WIDE, plan.window_max):
            self._extend(twice, WIDE, plan.window_max)
        longest, longer = LONGER * plan.window_max, min(LONGER * plan.budget, LONGEST) - self.reserved
        if self._settled(ERROR_ALLOWED) or self.drift() > ERROR_ALLOWED * plan.tolerance * abs(self.friction()):
            return
        if self._can_settle(longer, ERROR_ALLOWED, longest):
            self._extend(longer, ERROR_ALLOWED, longest)

    def _extend(self, budget: float, factor: float, longest: float) -> None:
        """Blocks until the interval is within a multiple of the tolerance, or work or windows are at their limit."""
        while not self._settled(factor):
            level = self._worthiest(longest)
            if level < 0 or self.work + self.plan.block * self.windows[level].rate > budget:
                return
            self.windows[level].block(self.plan.block)

    def _settled(self, factor: float) -> bool:
        mean, half_width = self.interval()
        return half_width <= factor * self.plan.tolerance * abs(mean)

    def _variances(self) -> list[float]:
        """Squared half widths by level."""
        return [width**2 for width in self.half_widths()]

    def _worthiest(self, longest: float) -> int:
        """Level whose next block reduces the squared error most per work; -1 if the relevant windows have the longest
        travel.
        """
        best, level, block = 0.0, -1, self.plan.block
        variances = self._variances()
        for i, window in enumerate(self.windows):
            if window.rolled > longest - block + 1e-9 or variances[i] < SMALL_PART * sum(variances):
                continue
            behind = i
            while behind > 0 and self.windows[behind - 1].rolled < window.rolled + block - 1e-9:
                behind -= 1  # a mesh is compared with the coarser one, which is extended first
            cost = sum(each.rate for each in self.windows[behind : i + 1])
            gain = variances[i] / (window.rolled + block) / cost
            if gain > best:
                best, level = gain, behind
        return level

    def _can_settle(self, budget: float, factor: float, longest: float) -> bool:
        """Whether the interval would be a multiple of the tolerance with an optimal use of the whole budget.

        For variances a/T and costs c per travel the optimum is T ~ sqrt(a/c); the variance is (sum sqrt(a c))^2/cost.
        """
        terms = [v * w.rolled * w.rate for v, w in zip(self._variances(), self.windows, strict=True)]
        spent = sum(w.rolled * w.rate for w in self.windows)
        affordable = max(budget - self.work, 0.0) + spent
        least = sum(math.sqrt(term) for term in terms) / math.sqrt(affordable)
        most = math.sqrt(self.half_widths()[0] ** 2 * self.windows[0].rolled / longest)
        return max(least, most) <= factor * self.plan.tolerance * abs(self.friction())


def least_levels(plan: RunPlan, levels: int) -> int:
    """Smallest number of meshes: two, one of which resolves the inlet."""
    least = 2
    while least < levels and plan.spacing * 2 ** (levels - least) > PER_SWEEP["fast"] * plan.inlet:
        least += 1
    return least


def affordable(plan: RunPlan, coarsest: Window, levels: int, reserved: float) -> int:
    """Largest number of meshes with the shortest windows within the budget, at least `least_levels`.

    All but the finest mesh may take `BUDGETS` budgets: two meshes that are both too coarse differ too little to state
    their error (at a film ratio of .013 mu was 15 % too low with a stated error of 5 %, with three meshes 5 and 7 %).
    Per travel the next finer mesh takes four times the work, times `FINER_STEP` because of fewer iterations.
    """
    least = least_levels(plan, levels)
    spent = coarsest.work + reserved
    for count in range(levels, least, -1):
        total = spent
        for k in range(count):
            travel = (plan.window_min if k == 0 else plan.window_fine) + SETTLING * (count - max(k, 1))
            total += coarsest.rate * (4.0 * FINER_STEP) ** k * travel
        if total <= (plan.budget if count == levels else BUDGETS * plan.budget):
            return count
    return least
