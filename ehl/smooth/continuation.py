"""First solution of a contact: by continuation from an easy contact, or from a neighbouring result."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ehl.fluid.rheology import NEWTONIAN
from ehl.smooth import _kernels
from ehl.smooth.mesh import Features, features_of, grade
from ehl.smooth.newton import Level, NewtonFailure, NodeGrid, Unknowns, solve_level
from ehl.smooth.scaling import ScaledContact

EASY_LOG_VISCOSITY = 2.0
EASY_SHEAR = (0.03, 0.1)  # range of shear numbers at the start, where the contact has any: no sharp spike on the way
EASY_LOADS = (2.0, 10.0)  # range of Moes load numbers the path may start at
MAX_ITERATIONS = 150  # of one path; plain contacts take 10 to 60
# tuned: 511 of 512 contacts of the gear range and of a far wider one are solved on 49 nodes, all on 97, which is the
# second try; thin films, and rounded spikes, whose rounding is judged on the mesh of the path, begin with it
PATH_NODES, HARD_NODES = 49, 97
THIN_FILM_LOADS = (1.0e3, 5.0e3)  # Moes load numbers M


@dataclass
class PathReport:
    """Work of the continuation."""

    iterations: int = 0

    def solved(self, grid: NodeGrid, scaled: ScaledContact, start: Unknowns, max_iterations: int = 40) -> Level:
        """Solution on a grid; its iterations count, also those of a failure."""
        try:
            level = solve_level(grid, scaled, start, tolerance=1e-4, max_iterations=max_iterations)
        except NewtonFailure as failure:
            self.iterations += failure.iterations
            raise
        self.iterations += level.iterations
        return level


def refined(nodes: int, scaled: ScaledContact) -> int:
    """Nodes for a contact: very thin films (high load) require a mesh twice or four times as fine."""
    doublings = sum(scaled.moes_load > load for load in THIN_FILM_LOADS)
    return int((nodes - 1) * 2**doublings + 1)


def grid_for(features: Features, nodes: int) -> NodeGrid:
    """Grid with the given number of nodes, graded for the features."""
    grading = grade(features)
    return NodeGrid.of(grading, grading.points(2 * nodes - 1))


def transfer(level: Level, grid: NodeGrid) -> Unknowns:
    """Unknowns of a level interpolated to another grid (monotone cubic)."""
    stretch = (level.x[-1] - grid.grading.x_in) / (grid.grading.x_exit - grid.grading.x_in)
    pressure = _kernels.moved_pressure(level.x, level.unknowns.pressure, grid.nodes, grid.grading.x_in, stretch)
    # the film constant contains ln(stretch) of its grid
    h00 = level.unknowns.h00 + 0.5 * math.log(stretch / level.unknowns.stretch)
    return Unknowns(pressure, h00, level.unknowns.flow, stretch)


def features_of_level(level: Level) -> Features:
    """Features the mesh of the next solution should resolve."""
    return features_of(level.x, level.unknowns.pressure, level.unknowns.flow)


def easy_start(scaled: ScaledContact, nodes: int, report: PathReport) -> tuple[Level, ScaledContact]:
    """Start of the path with nearly constant viscosity and moderate load; it converges from the Hertz pressure."""
    load = min(max(scaled.moes_load, EASY_LOADS[0]), EASY_LOADS[1])
    lam = 3.0 * math.pi**2 / (8.0 * load**2)
    stiffness = min(1.0, EASY_LOG_VISCOSITY / max(scaled.log_viscosity, 1e-12))
    shear = min(scaled.gamma, EASY_SHEAR[1])
    if scaled.gamma > 0.0 and (scaled.shear.plain or scaled.shear.kind != NEWTONIAN):
        shear = max(shear, EASY_SHEAR[0])
    easy = scaled.easier(lam, stiffness, shear)
    grid = _easy_grid(nodes)
    pressure = np.sqrt(np.clip(1.0 - grid.nodes**2, 0.0, None))
    centre = int(np.argmin(np.abs(grid.nodes)))
    flow = 1.2 / load
    start = Unknowns(pressure, flow + float(grid.kernel[centre] @ pressure) / math.pi, flow, 1.0)
    return report.solved(grid, easy, start), easy


@lru_cache(maxsize=4)
def _easy_grid(nodes: int) -> NodeGrid:
    return grid_for(Features(0.3, 1.15, -1.0, 0.4, 0.9, 0.3), nodes)


def between(easy: ScaledContact, scaled: ScaledContact, t: float) -> ScaledContact:
    """Scaled contact at a fraction of the path, straight in (ln lambda, viscosity exponent, ln gamma).

    Towards thick films (increasing lambda) the pressure decreases along the path. Lambda then changes first, so that
    the viscosity increases at low pressure only.
    """
    if t >= 1.0:
        return scaled
    t_lam, t_oil = (min(1.0, 2.0 * t), max(0.0, 2.0 * t - 1.0)) if scaled.lam > easy.lam else (t, t)
    lam = easy.lam ** (1.0 - t_lam) * scaled.lam**t_lam
    ratio = easy.log_viscosity / scaled.log_viscosity if scaled.log_viscosity > 0.0 else 1.0
    gamma = easy.gamma ** (1.0 - t_oil) * scaled.gamma**t_oil
    return scaled.easier(lam, ratio + (1.0 - ratio) * t_oil, gamma)


def _predicted(now: Unknowns, before: Unknowns, factor: float) -> Unknowns:
    return Unknowns(
        np.maximum(now.pressure + factor * (now.pressure - before.pressure), 0.0),
        now.h00 + factor * (now.h00 - before.h00),
        now.flow * (now.flow / before.flow) ** factor,
        now.stretch + factor * (now.stretch - before.stretch),
    )


def cold_path(scaled: ScaledContact, nodes: int, report: PathReport) -> Level:
    """Solution on a coarse grid by continuation from the easy contact; thicker films on the way have fewer nodes.

    Raises `NewtonFailure`: "path_stalled" if the step becomes too small, "path_limit" after too many iterations.
    """
    spent = report.iterations
    coarse = min(nodes, 2 * HARD_NODES - 1)
    level, easy = easy_start(scaled, coarse, report)
    t, before, t_before = 0.0, None, 0.0
    step, tries, shortened = 0.34, 0, False
    while t < 1.0:
        # a try that has no iterations is work as well
        tries += 1
        if report.iterations - spent > MAX_ITERATIONS or tries > MAX_ITERATIONS:
            raise NewtonFailure("path_limit", report.iterations)
        goal = min(1.0, t + step)
        if goal > 0.97 and not shortened:
            goal = 1.0
        features, target = features_of_level(level), between(easy, scaled, goal)
        grid, size = level.grid, min(nodes, max(coarse, refined(HARD_NODES, target)))
        if size != grid.nodes.size or not features.close_to(level.features):
            grid = grid_for(features, size)
        start = transfer(level, grid) if grid is not level.grid else level.unknowns
        if before is not None:
            old = transfer(before, grid) if grid is not before.grid else before.unknowns
            start = _predicted(start, old, (goal - t) / (t - t_before))
        try:
            new = report.solved(grid, target, start, 14)
        except NewtonFailure as failure:
            step, shortened = 0.4 * (goal - t), True
            before = None if failure.reason == "start_infeasible" else before
            if step < 2e-4:
                raise NewtonFailure("path_stalled", report.iterations) from None
            continue
        before, t_before = level, t
        level, t, shortened = new, goal, False
        step *= 2.0 if new.iterations <= 4 else (1.3 if new.iterations <= 7 else 0.8)
    return level


def from_neighbour(neighbour: Level, scaled: ScaledContact, report: PathReport) -> Level:
    """Solution on the grid of a neighbouring contact, with its unknowns as the initial guess."""
    return report.solved(neighbour.grid, scaled, neighbour.unknowns, 12)
