"""Re-grading, nested grids and Richardson extrapolation with error estimates."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.inputs import Accuracy
from ehl.smooth.continuation import PathReport, features_of_level, grid_for, refined, transfer
from ehl.smooth.mesh import grade
from ehl.smooth.newton import FilmShear, Level, NewtonFailure, NodeGrid, Numbers, Unknowns, numbers_of, solve_level
from ehl.smooth.scaling import ScaledContact

LevelSolver = Callable[[NodeGrid, Unknowns], Level]

# nodes of the coarsest nested grid, error estimate above which a finer grid is added, and the largest number of nodes
COARSEST: dict[str, int] = {"fast": 41, "standard": 49, "reference": 129}
TOLERANCE: dict[str, float] = {"fast": 5e-3, "standard": 2e-3, "reference": 2e-4}
MAX_NODES: dict[str, int] = {"fast": 500, "standard": 700, "reference": 2000}
UNDERSHOOT = 1e-4  # largest accepted negative pressure over p_h


@dataclass(frozen=True)
class GridLimit:
    """Richardson values of the outputs and their error estimates (absolute)."""

    values: FloatArray
    errors: FloatArray

    def relative(self) -> FloatArray:
        """Errors over the magnitude of the values; zero where both vanish."""
        return self.errors / np.maximum(np.abs(self.values), 1e-300)


# tuned: an error of order h^3 in the extrapolated value is 1/7 of its last change. The factor 2 on it, and the share of
# the last raw change (for changes that vanish by chance), were chosen on one Sobol set of contacts and checked on
# others (validation/smooth_accuracy.py). The share decreases with the sixth power of the number of nodes from its value
# on the grids 49, 97, 193
CHANGE_SHARE, RAW_SHARE, RAW_INTERVALS, RAW_BOUNDS = 2.0 / 7.0, 0.03, 48, (0.002, 0.1)
# tuned: with thermal effects the order is less regular; chosen on 128 contacts of the gear range and 128 of a far wider
# range
HOT_CHANGE_SHARE, HOT_RAW_SHARE = 0.8, 0.2
OBSERVED_RATIOS = (1.5, 4.0)  # of two changes: 2 is of first order, 4 of second
FLOOR = 5e-7  # relative error by the open parabolic inlet (compared with four times the length)


def extrapolate(levels: list[FloatArray], coarsest: int, *, hot: bool = False) -> GridLimit:
    """Second-order Richardson over grids n, 2n - 1, 4n - 3.

    The value is extrapolated from the two finest grids. Its error follows from the difference to the extrapolation from
    the two coarser ones.

    levels: outputs of the grids, coarse to fine; the last three are used.
    coarsest: nodes of the coarsest of these three.
    hot: whether each grid has its own heat balance.
    """
    coarse, middle, fine = levels[-3:]
    value = fine + (fine - middle) / 3.0
    before = middle + (middle - coarse) / 3.0
    least, most = RAW_BOUNDS
    change_share, share = CHANGE_SHARE, min(max(RAW_SHARE * (RAW_INTERVALS / (coarsest - 1)) ** 6, least), most)
    if hot:
        change_share, share = HOT_CHANGE_SHARE, HOT_RAW_SHARE
    change = np.abs(fine - middle)
    errors = change_share * np.abs(value - before) + share * change + FLOOR * np.abs(value)
    if not hot:
        # where the changes fall more slowly than of second order: the limit of the order observed
        ratio = np.abs(middle - coarse) / np.maximum(change, 1e-300)
        beyond = 1.0 / (np.clip(ratio, *OBSERVED_RATIOS) - 1.0) - 1.0 / 3.0
        errors = np.maximum(errors, beyond * change)
    return GridLimit(value, errors)


def settled(level: Level, report: PathReport) -> Level:
    """Re-grade until the mesh fits its solution."""
    for _ in range(4):
        features = features_of_level(level)
        if features.close_to(level.features):
            break
        grid = grid_for(features, level.x.size)
        level = solve_level(grid, level.scaled, transfer(level, grid), tolerance=1e-4)
        report.iterations += level.iterations
    return level


def nested(
    near: Level,
    shear: FilmShear,
    accuracy: Accuracy,
    report: PathReport,
    fallbacks: list[str],
    solve: LevelSolver | None = None,
) -> tuple[list[Level], GridLimit]:
    """Solutions on nested grids of one grading, at least three, until the error estimate is met.

    `solve` returns the thermal film on a grid from a guess of the film; without it the solution is isothermal.
    """
    scaled, nodes = near.scaled, refined(COARSEST[accuracy], near.scaled)
    # a thermal film on a mesh of this size that fits it needs no further heat balance
    fits = solve is not None and near.x.size == nodes
    grading = near.grid.grading if fits else grade(features_of_level(near))
    most = refined(MAX_NODES[accuracy], scaled)
    levels: list[Level] = []
    points = grading.points(8 * nodes - 7)  # of the third grid; they include those of the first two
    while True:
        stride = (points.size - 1) // (2 * nodes - 2)
        if fits:
            grid, fits = near.grid, False
        else:
            grid = NodeGrid.of(grading, points[::stride] if stride else grading.points(2 * nodes - 1))
        guess = transfer(levels[-1] if levels else near, grid)
        if len(levels) >= 2:
            guess = _corrected(levels, guess)
        nodes = 2 * nodes - 1
        try:
            level = solve(grid, guess) if solve else solve_level(grid, scaled, guess)
        except NewtonFailure as failure:
            report.iterations += failure.iterations
            if len(levels) >= 3:
                fallbacks.append("tolerance_not_met")
                break
            if nodes > most // 2:
                raise
            levels.clear()
            fallbacks.append("coarse_grid_dropped")
            continue
        report.iterations += level.iterations
        levels.append(level)
        if len(levels) >= 3:
            last = [np.array(numbers_of(level, shear)) for level in levels[-3:]]
            limit = extrapolate(last, levels[-3].x.size, hot=solve is not None)
            if np.all(limit.relative()[:3] < TOLERANCE[accuracy]):
                break
            if nodes > most:
                fallbacks.append("tolerance_not_met")
                break
    _check(levels[-1])
    return levels, limit


def rounding_errors(scaled: ScaledContact, near: Level, shear: FilmShear, report: PathReport) -> FloatArray:
    """Error of the outputs by the rounding of the spike, from a solution with three times the rounding."""
    if near.scaled.gamma == scaled.gamma:
        return np.zeros(len(Numbers._fields))
    more = solve_level(near.grid, scaled.rounded(3.0), near.unknowns, tolerance=1e-4)
    report.iterations += more.iterations
    return 2.0 * np.abs(np.subtract(numbers_of(more, shear), numbers_of(near, shear)))


def _check(level: Level) -> None:
    """Check the assumptions of the exit condition: no negative pressure, and a gap that opens at the exit."""
    if float(level.unknowns.pressure.min()) < -UNDERSHOOT:
        raise NewtonFailure("negative_pressure", 0)
    if level.rho[-2] * level.film[-2] > level.unknowns.flow * (1.0 + 1e-9):
        raise NewtonFailure("gap_closes_at_exit", 0)


def _corrected(levels: list[Level], guess: Unknowns) -> Unknowns:
    """Start on the third grid: the second solution plus a quarter of its change from the first."""
    first, second = levels[-2].unknowns, levels[-1].unknowns
    change = 0.25 * (second.pressure[::2] - first.pressure)
    coarse_index = np.arange(change.size) * 4.0
    pressure = guess.pressure + np.interp(np.arange(guess.pressure.size), coarse_index, change)
    return Unknowns(
        pressure,
        guess.h00 + 0.25 * (second.h00 - first.h00),
        guess.flow + 0.25 * (second.flow - first.flow),
        guess.stretch + 0.25 * (second.stretch - first.stretch),
    )
