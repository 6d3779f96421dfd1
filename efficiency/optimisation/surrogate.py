"""Selection of the next points: Gaussian process of each figure, expected improvement of weighted objectives.

Each figure has its own process (scikit-learn, Matern 5/2, a length scale for each variable). Each point of a batch
maximises the expected improvement of an augmented Chebyshev sum

    g = max_j w_j f_j + 0.05 sum_j w_j f_j

of the objectives f_j, scaled to 0 and 1 at the ends of the front (Knowles 2006, ParEGO). The expectation is taken over
normal draws that meet the limits. The weights differ from point to point, so that a batch covers the whole front. The
predicted figures of a point are used as data for the next points of the batch. A further process over 1 and -1 models
feasibility (least-squares classification, Rasmussen & Williams 2006, section 6.5).
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm, qmc

from ehl.common.arrays import FloatArray

_AUGMENTED = 0.05
_DRAWS = 64
# least distance to known points; smallest relevant expected improvement; weights tried below it
_APART, _NOTHING, _TURNS = 2e-3, 1e-5, 4
_FIRST_WIDTHS = 0.6, 0.25
# candidates: anywhere, and near points of the front
_ANYWHERE, _NEAR = 512, 512
_STEPS = (0.2, 0.06, 0.02)
# standard deviation of the values 1 and -1 of the feasibility process (this work)
_MADE_SD = 0.3
_NOISE, _SCALES = (1e-8, 1e-1), (0.05, 20.0)
_MAX_ITERATIONS = 25


@dataclass
class Processes:
    """Gaussian processes of all transformed figures and of feasibility over the unit cube."""

    dimension: int
    limits: FloatArray  # (m,) of the figures, infinite for those without a limit
    objectives: int  # number of the objectives, which are the first figures
    seed: int  # of the random numbers
    _models: list[Any] = field(default_factory=list)
    _made: Any = None

    def fit(self, inputs: FloatArray, values: FloatArray, failed: FloatArray, *, scales: bool) -> None:
        """Fit to points with a result (n, d), their transformed figures (n, m) and points without one (k, d).

        Length scales and noise are fitted only with `scales`, starting from the previous ones.
        """
        last = self._models or [None] * self.limits.size
        self._models = [self._process(inputs, v, old, scales=scales) for v, old in zip(values.T, last, strict=True)]
        if len(failed):
            made = np.concatenate([np.ones(len(inputs)), -np.ones(len(failed))])
            self._made = self._process(
                np.vstack([inputs, failed]), made, self._made, scales=scales or self._made is None
            )

    def _process(self, inputs: FloatArray, values: FloatArray, last: Any, *, scales: bool) -> Any:
        from sklearn.exceptions import ConvergenceWarning
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

        kernel = ConstantKernel(1.0, (1e-2, 1e3)) * Matern(np.ones(self.dimension), _SCALES, nu=2.5)
        kernel = kernel + WhiteKernel(1e-4, _NOISE)
        if last is not None:
            kernel = kernel.clone_with_theta(last.kernel_.theta)
        model = GaussianProcessRegressor(kernel, optimizer=_few_steps if scales else None, normalize_y=True)
        with warnings.catch_warnings():
            # a length scale at its bound: the variable has no effect on the figure
            warnings.simplefilter("ignore", ConvergenceWarning)
            model.fit(inputs, values)
        return model

    def predict(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Means and standard deviations of all figures at points, (n, m) each."""
        found = [model.predict(points, return_std=True) for model in self._models]
        return np.stack([mean for mean, _ in found], axis=1), np.stack([sd for _, sd in found], axis=1)

    def success(self, points: FloatArray) -> FloatArray:
        """Probability of feasibility."""
        if self._made is None:
            return np.ones(len(points))
        mean, sd = self._made.predict(points, return_std=True)
        return np.asarray(norm.cdf(mean / np.hypot(sd, _MADE_SD)))

    def next_points(
        self, known: FloatArray, values: FloatArray, failed: FloatArray, *, count: int, number: int, scales: bool
    ) -> FloatArray:
        """The next batch (count, d); the processes are fitted here.

        Arguments as in `fit`. The `number` of evaluations so far determines the weights.
        """
        points, figures, seed = known, values, self.seed
        rng = np.random.default_rng([seed, number])
        draws = norm.ppf(qmc.Sobol(values.shape[1], seed=seed).random(_DRAWS))
        taken: list[FloatArray] = []
        for k in range(number, number + count):
            self.fit(points, figures, failed, scales=scales and k == number)
            for turn in range(_TURNS if self.objectives > 1 else 1):
                # without expected improvement, other weights are tried
                weights = _drawn(self.objectives, k, seed, turn) if turn else weights_of(self.objectives, k, seed)
                worth_of = partial(self._improvement, figures, weights, draws)
                candidate, worth = _best_candidate(points, self._centres(points, figures, weights), worth_of, rng)
                if worth > _NOTHING or not self._within(figures).any():
                    break
            mean, _ = self.predict(candidate[None])
            points, figures = np.vstack([points, candidate]), np.vstack([figures, mean])
            taken.append(candidate)
        return np.array(taken)

    def _within(self, figures: FloatArray) -> NDArray[np.bool_]:
        return np.asarray(np.all(figures <= self.limits, axis=-1))

    def _centres(self, points: FloatArray, figures: FloatArray, weights: FloatArray) -> FloatArray:
        """Centres of the local candidates: the best points by these weights, or those nearest to the limits."""
        kept, bounded = self._within(figures), np.isfinite(self.limits)
        if kept.any():
            cost = np.where(kept, _sum(_scaled(figures, figures[kept], weights.size), weights), np.inf)
        else:
            cost = np.maximum(figures - self.limits, 0.0, where=bounded, out=np.zeros_like(figures)).sum(axis=1)
        return points[np.argsort(cost, kind="stable")[: max(3, min(6, int(kept.sum())))]]

    def _improvement(
        self, figures: FloatArray, weights: FloatArray, draws: FloatArray, candidates: FloatArray
    ) -> FloatArray:
        """Expected improvement of the sum over draws within the limits; of the excess if no point is within."""
        mean, sd = self.predict(candidates)
        drawn = mean[:, None, :] + sd[:, None, :] * draws
        kept, bounded = self._within(figures), np.isfinite(self.limits)
        excess = np.maximum(drawn[..., bounded] - self.limits[bounded], 0.0).sum(axis=-1)
        if not kept.any():
            return np.asarray(-excess.mean(axis=1) + np.log(self.success(candidates)))
        count = weights.size
        best = float(_sum(_scaled(figures[kept], figures[kept], count), weights).min())
        gain = np.maximum(best - _sum(_scaled(drawn, figures[kept], count), weights), 0.0)
        expected = np.where(excess <= 0.0, gain, 0.0).mean(axis=1) * self.success(candidates)
        # if no draw improves, the candidate with the nearest mean
        nearest = _sum(_scaled(mean, figures[kept], count), weights) - best
        return np.asarray(np.where(expected > 0.0, expected, -1e-9 * np.maximum(nearest + excess.mean(axis=1), 1e-6)))


def _few_steps(objective: Any, start: FloatArray, bounds: Any) -> tuple[FloatArray, float]:
    from scipy.optimize import minimize

    found = minimize(objective, start, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": _MAX_ITERATIONS})
    return np.asarray(found.x), float(found.fun)


def first_points(dimension: int, count: int, seed: int, start: FloatArray) -> FloatArray:
    """Initial sample about the start: half within 0.6 of the bounds, half within 0.25 (scrambled Sobol sequence).

    The limits refer to the start, so feasible points are most likely near it.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # a count that is no power of two
        points = qmc.Sobol(dimension, seed=seed).random(count)
    width = np.where(np.arange(count) % 2 == 0, *_FIRST_WIDTHS)[:, None]
    return np.asarray(np.clip(start + width * (points - 0.5), 0.0, 1.0))


def weights_of(objectives: int, number: int, seed: int) -> FloatArray:
    """Weights of the point with that number: the first objective alone for every other point.

    The remaining points alternate between each other objective alone and weights drawn from the simplex.
    """
    if number % 2 == 0 or objectives == 1:
        return np.asarray(np.eye(objectives)[0])
    turn = (number // 2) % (2 * (objectives - 1))
    if turn % 2 == 0:
        return np.asarray(np.eye(objectives)[1 + turn // 2])
    return _drawn(objectives, number, seed, 0)


def _drawn(objectives: int, number: int, seed: int, turn: int) -> FloatArray:
    """Random weights, uniform over the simplex."""
    drawn = np.random.default_rng([seed, number, turn]).exponential(size=objectives)
    return np.asarray(drawn / drawn.sum())


def _scaled(figures: FloatArray, within: FloatArray, count: int) -> FloatArray:
    """Objectives scaled to 0 and 1 at the ends of the points within the limits."""
    low, high = within[:, :count].min(axis=0), within[:, :count].max(axis=0)
    return np.asarray((figures[..., :count] - low) / np.maximum(high - low, 1e-3))


def _sum(scaled: FloatArray, weights: FloatArray) -> FloatArray:
    return np.asarray((scaled * weights).max(axis=-1) + _AUGMENTED * (scaled * weights).sum(axis=-1))


def _best_candidate(
    points: FloatArray, centres: FloatArray, worth_of: Callable[[FloatArray], FloatArray], rng: np.random.Generator
) -> tuple[FloatArray, float]:
    """The candidate with the largest expected improvement, and this improvement; known points are excluded."""
    dimension = points.shape[1]
    best: FloatArray | None = None
    top = -np.inf
    for turn, step in enumerate(_STEPS):
        # only some variables are moved, because figures depend on few of them at a time
        base = centres[rng.integers(len(centres), size=_NEAR)]
        moved = rng.random((_NEAR, dimension)) < max(0.35, 1.0 / dimension)
        near = np.clip(base + step * moved * rng.standard_normal((_NEAR, dimension)), 0.0, 1.0)
        candidates = np.vstack([rng.random((_ANYWHERE, dimension)), near]) if turn == 0 else near
        worth = worth_of(candidates)
        apart = np.linalg.norm(candidates[:, None] - points[None], axis=2).min(axis=1)
        worth = np.where(apart > _APART, worth, -np.inf)
        first = int(np.argmax(worth))
        if worth[first] > top:
            top, best = float(worth[first]), candidates[first]
        assert best is not None
        centres = np.vstack([best, candidates[np.argsort(-worth, kind="stable")[:4]]])
    assert best is not None
    return best, top


def transformed(name: str, values: FloatArray) -> FloatArray:
    """A figure transformed for its process: root of shares, scaled temperatures, logarithm of the others."""
    if name == "temperature_flash":
        return np.asarray(values / 100.0)
    if name == "edge_load_share":
        return np.asarray(np.sqrt(np.maximum(values, 0.0)))
    return np.asarray(np.log(np.maximum(values, 1e-12)))


def table_of(figures: Sequence[dict[str, float]], names: Sequence[str]) -> FloatArray:
    """Transformed figures, (n, m)."""
    rows = [[point[name] for name in names] for point in figures]
    raw = np.array(rows, dtype=np.float64).reshape(len(rows), len(names))
    return np.stack([transformed(name, raw[:, k]) for k, name in enumerate(names)], axis=1)
