"""Averaging window of a transient run: blocks of steps, their cost, and the errors of their mean by batch means."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.special import stdtrit

from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError
from ehl.line_contact import LineContact
from ehl.rough._kernels.march import FILM_MEAN, ITERATIONS, MU_FLUID, SHARE
from ehl.rough.accuracy import BATCH, FRONT_STARTUP
from ehl.rough.run import TransientRun
from ehl.rough.surfaces import RoughSurfaces

MIN_BATCHES = 5  # batches below which no interval is given
ONE_DRAW = 1.645  # half width of the 90 % interval of a normal variable over its standard deviation
# tuned: largest correlation of neighbours in the correction; 90 % intervals cover 88 to 90 %
# (tests/unit/ehl/test_error_bars.py)
MAX_CORRELATION = 0.8
CORRECTION_MAX = 0.1 / 3.0  # of the mean, reached at a difference of 10 % between two meshes


def batch_means(series: FloatArray, batch: int, confidence: float = 0.90) -> tuple[float, float]:
    """Mean and half width of its confidence interval.

    Half batches are merged while their correlation exceeds 0.2 and 10 of them remain. The remaining correlation r is
    corrected for its bias, r + (1 + 3 r)/n (Kendall 1954), and treated as a first-order autoregression: the variance of
    the mean grows by (1 + r)/(1 - r), and the degrees of freedom of Student's t decrease by the same factor. A run
    that stops at a required interval favours intervals that are narrow by chance. Without the correction 90 % intervals
    covered 83 to 86 % instead of 88 to 90 %.

    series (n,): one value per step, after the start-up.
    batch: steps of the smallest batch; several correlation lengths of the series.
    confidence: nominal coverage.
    Returns: mean: mean of the whole series; half_width: nan with fewer than 5 batches.
    """
    mean = float(np.mean(series))
    count = series.size // max(batch, 1)
    if count < MIN_BATCHES:
        return mean, math.nan
    size = max(batch // 2, 1)
    count = series.size // size
    means = series[series.size - count * size :].reshape(count, size).mean(axis=1)
    return mean, interval_of_means(means, confidence)


def interval_of_means(means: FloatArray, confidence: float = 0.90) -> float:
    """Half width of the interval of the mean of equal parts of a correlated series (`batch_means`).

    means (n,): means of the parts in their order.
    confidence: nominal coverage.
    Returns: half width; inf with fewer than 3 parts.
    """
    if means.size < 3:
        return math.inf
    while means.size >= 4 * MIN_BATCHES and neighbour_correlation(means) > 0.2:
        means = means[means.size % 2 :].reshape(-1, 2).mean(axis=1)
    found = max(neighbour_correlation(means), 0.0)
    correlation = min(found + (1.0 + 3.0 * found) / means.size, MAX_CORRELATION)
    inflation = (1.0 + correlation) / (1.0 - correlation)
    spread = float(np.std(means, ddof=1)) * math.sqrt(inflation / means.size)
    freedom = max(means.size / inflation - 1.0, 2.0)
    return float(stdtrit(freedom, 0.5 + 0.5 * confidence)) * spread


def richardson(coarse: float, fine: float) -> tuple[float, float]:
    """Richardson extrapolation of a mean from a mesh and one of twice its spacing, and the discretisation error.

    For a second-order scheme a third of the signed difference of the two means is the error of the fine one. It is
    added as a correction and kept as error, as the order is lower near the boundary regime. The correction is bounded
    by `CORRECTION_MAX`; the rest counts as error too.
    """
    third = (fine - coarse) / 3.0
    most = CORRECTION_MAX * abs(fine)
    correction = min(max(third, -most), most)
    return fine + correction, abs(third) + 2.0 * abs(third - correction)


def neighbour_correlation(values: FloatArray) -> float:
    """Correlation of each value with the next; 0 for a constant series."""
    centred = values - values.mean()
    power = float(centred @ centred)
    return float(centred[1:] @ centred[:-1]) / power if power > 0.0 else 0.0


# work of a step: (nodes + 100)(iterations + 1.5), times 100 ns within a factor of 1.5 over 40 contacts with heat
STEP_NODES, STEP_ITERATIONS = 100.0, 1.5
FILM_JUMP = 5.0  # mean film of a step over its median above which the step counts as diverged
MAX_MEDIAN_FILM = 10.0  # upper bound of the median film, in film units, unless most steps diverged
FLUX_SAMPLES = 20  # samples of the mean heat flux
LIMIT = 4.0  # bounds of the work of a window
PIECE = 32  # steps of a start-up between two looks at the work
MAX_REPEATS = 3  # of a block with a diverged step
MIN_EXCHANGES = 4  # batches


@dataclass
class Window:
    """Records of one run: all steps, and the mean profiles since the start-up."""

    run: TransientRun
    batch: float = BATCH  # travel of a batch of the mean [b]
    bound: float = math.inf  # work from which on no block is repeated, and `LIMIT` times which ends the run
    started: list[FloatArray] = field(default_factory=list)
    recorded: list[FloatArray] = field(default_factory=list)
    sums: list[FloatArray] = field(default_factory=list)  # of the profiles, by block
    exchanges: list[FloatArray] = field(default_factory=list)  # of the side flow per step, by block and batch
    numbers: list[int] = field(default_factory=list)  # of the blocks along the travel, the same on every mesh
    rolled: float = 0.0  # travel of the blocks [b]
    passed: int = 0  # blocks computed, including discarded ones
    repeats: int = 0
    steps: int = 0  # including steps that are not averaged
    iterations: float = 0.0
    # cache of `parts`
    _means: dict[tuple[int, int], tuple[FloatArray, FloatArray]] = field(default_factory=dict, repr=False)

    @property
    def work(self) -> float:
        """Work of all steps so far, in node-iterations."""
        return (self.run.problem.x.size + STEP_NODES) * (self.iterations + STEP_ITERATIONS * self.steps)

    @property
    def rate(self) -> float:
        """Work per b of travel of the steps so far."""
        return self.work * self.run.problem.units.steps_per_half_width / max(self.steps, 1)

    def branch(self) -> Window:
        """Another window that continues from the state and the work of this one, without its averages."""
        run = self.run.branch(self.run.problem)
        before = [*self.started]
        return Window(run, self.batch, self.bound, started=before, steps=self.steps, iterations=self.iterations)

    def _steps(self, travel: float) -> int:
        return max(1, round(travel * self.run.problem.units.steps_per_half_width))

    def _march(self, steps: int) -> tuple[FloatArray, FloatArray]:
        """Advance by some steps. Raises `ConvergenceError`: "work_limit": far more work than a contact takes."""
        records, profiles = self.run.advance(steps)
        self.steps += len(records)
        self.iterations += float(records[:, ITERATIONS].sum())
        if self.work > LIMIT * self.bound:
            detail = f"{self.work:.2g} node-iterations; smoother surfaces or thicker films require less"
            raise ConvergenceError("work_limit", detail)
        return records, profiles

    def start(self, travel: float) -> None:
        """Advance without averaging."""
        left = self._steps(travel)
        records: list[FloatArray] = []
        while left > 0:
            records.append(self._march(min(PIECE, left))[0])
            left -= len(records[-1])
        self.started.append(np.concatenate(records))

    def mean_flux(self, travel: float) -> FloatArray:
        """Advance without recording; return the mean heat flux into both surfaces (2, n) [W/m2]."""
        flux = np.zeros_like(self.run.state.flux_into)
        for _ in range(FLUX_SAMPLES):
            self.start(travel / FLUX_SAMPLES)
            flux += self.run.state.flux_into / FLUX_SAMPLES
        return flux

    def roll(self, travel: float) -> None:
        """Advance by a block and average."""
        batches = max(1, round(travel / BATCH))
        pieces = [self._advance(travel / batches) for _ in range(batches)]
        self.recorded.append(np.concatenate([records for records, _, _ in pieces]))
        self.sums.append(np.sum([profiles * len(records) for records, profiles, _ in pieces], axis=0))
        self.exchanges.append(np.array([exchange for _, _, exchange in pieces]))

    def block(self, travel: float) -> None:
        """Advance by one block of the window; a block with a diverged step is discarded and repeated further on."""
        while True:
            self.roll(travel)
            self.passed += 1
            if self.repeats >= MAX_REPEATS or self.work > self.bound or not self.astray():
                break
            self.repeat()
            skipped = math.ceil(FRONT_STARTUP / travel)
            self.start(skipped * travel - FRONT_STARTUP)
            self.passed += skipped
        self.numbers.append(self.passed - 1)
        self.rolled += travel

    def records_of(self, numbers: Sequence[int]) -> FloatArray:
        """Steps of some blocks."""
        return np.concatenate([self.recorded[self.numbers.index(number)] for number in numbers])

    def pieces(self, numbers: Sequence[int], length: float) -> list[int]:
        """Number of parts of about this length [b] in each of some blocks."""
        per_length = length * self.run.problem.units.steps_per_half_width
        return [max(1, round(len(self._block(number)) / per_length)) for number in numbers]

    def parts(self, numbers: Sequence[int], pieces: Sequence[int]) -> FloatArray:
        """Mean friction of parts of some blocks, each divided into the number of `pieces` given for it.

        The numbers are an argument since rounding could otherwise divide a block differently on two meshes.
        """
        return np.concatenate([self._parts(number, count) for number, count in zip(numbers, pieces, strict=True)])

    def _parts(self, number: int, count: int) -> FloatArray:
        block, means = self._means.get((number, count), (None, np.zeros(0)))
        if block is not self._block(number):
            block = self._block(number)
            means = np.array([float(part.mean()) for part in np.array_split(self._friction_of(block), count)])
            self._means[number, count] = block, means
        return means

    def _block(self, number: int) -> FloatArray:
        return self.recorded[self.numbers.index(number)]

    def _friction_of(self, records: FloatArray) -> FloatArray:
        if self.run.problem.model.fluid.sliding == 0.0:
            return np.zeros(len(records))
        return np.asarray(records[:, MU_FLUID] + self.run.problem.model.contact.friction * records[:, SHARE])

    def _advance(self, travel: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        before = self.run.macroscopic.total_exchange.copy()
        records, profiles = self._march(self._steps(travel))
        return records, profiles, (self.run.macroscopic.total_exchange - before) / len(records)

    def astray(self) -> bool:
        """Whether a step of the last block diverged (`film_jumped`)."""
        return film_jumped(self.recorded[-1][:, FILM_MEAN], self.column(FILM_MEAN), self.roughness)

    @property
    def roughness(self) -> float:
        """Composite Rq, film units."""
        surfaces = self.run.problem.model.surfaces
        return math.hypot(*(float(np.std(p)) if p.size else 0.0 for p in (surfaces.profile_1, surfaces.profile_2)))

    def repeat(self) -> None:
        """Discard the last block and restart after one transit of the contact; the surfaces move on as well."""
        self.started.append(self.recorded.pop())
        self.sums.pop()
        self.exchanges.pop()
        self.start(FRONT_STARTUP)
        self.repeats += 1

    @property
    def profiles(self) -> FloatArray:
        """Mean profiles of the window."""
        return np.asarray(np.sum(self.sums, axis=0) / len(self.records))

    @property
    def records(self) -> FloatArray:
        """Steps of the window."""
        return np.concatenate(self.recorded)

    @property
    def everything(self) -> FloatArray:
        """All steps of a run, start-up included."""
        return np.concatenate([*self.started, *self.recorded])

    def column(self, column: int) -> FloatArray:
        """One column of the records."""
        return np.concatenate([block[:, column] for block in self.recorded])

    def friction_since(self, step: int) -> FloatArray:
        """mu of every step from `step` on, of start-up and window."""
        return self._friction_of(self.everything[step:])

    def friction(self) -> FloatArray:
        """mu of every step of the window; zero without sliding."""
        return np.concatenate([self._friction_of(block) for block in self.recorded])

    def interval(self) -> tuple[float, float]:
        """mu and the half width of its 90 % interval.

        With too few batches the whole window counts as one draw from a distribution with its standard deviation.
        """
        friction = self.friction()
        mean, half_width = batch_means(friction, round(self.batch * self.run.problem.units.steps_per_half_width))
        return mean, half_width if math.isfinite(half_width) else ONE_DRAW * float(np.std(friction))


def film_jumped(part: FloatArray, films: FloatArray, roughness: float) -> bool:
    """Whether a step diverged: its mean film is not finite, or many times the median and the composite Rq.

    The Rq (in film units) is included as a valley as wide as the contact may hold a thick film.
    """
    usual = min(max(float(np.median(films)), roughness), MAX_MEDIAN_FILM)
    return not bool(part.max() <= FILM_JUMP * usual)


def net_exchange(window: Window) -> float:
    """Largest running sum of the mean exchange along x over the throughput [-].

    The macroscopic pressure compensates every surplus, so that the sum over time fluctuates about a line. The slope of
    this line is the mean exchange, free of end effects of the window.
    """
    run = window.run
    middle = slice(run.problem.model.contact.middle_first, run.problem.model.contact.middle_last)
    sums = np.cumsum(np.concatenate(window.exchanges), axis=1) / float(run.state.mass[middle].mean())
    count = len(sums)
    if count < MIN_EXCHANGES:
        return float(np.abs(sums.mean(axis=0)).max())
    total = np.vstack([np.zeros(sums.shape[1]), np.cumsum(sums, axis=0)])
    moment = np.arange(count + 1) - 0.5 * count
    slope = moment @ total / float(moment @ moment)
    return float(np.abs(slope).max())


def realisation_error(window: Window, surfaces: RoughSurfaces, contact: LineContact, statistical: float) -> float:
    """Half width of the 90 % interval of mu over other realisations of the same surfaces, over mu (own work).

    The interval of the time mean counts the whole travel T as new roughness. Surface i contributes only
    l_i = T |u_i|/u_r + lc, at most its period. The variance grows by the mean of T/l_i, weighted with the variances of
    the heights.
    """
    rough = [
        (p, u)
        for p, u in zip((surfaces.profile_1, surfaces.profile_2), (contact.speed_1, contact.speed_2), strict=True)
        if p and p.rms
    ]
    travel = len(window.records) / window.run.problem.units.steps_per_half_width
    growth = 0.0
    for profile, speed in rough:
        seen = travel * abs(speed) / contact.speed_entrainment + profile.correlation_length / contact.half_width
        growth += (profile.rms / surfaces.rms) ** 2 * travel / min(seen, profile.length / contact.half_width)
    return statistical * math.sqrt(max(growth, 1.0)) if rough else 0.0
