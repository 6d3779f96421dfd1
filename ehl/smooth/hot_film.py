"""Thermal film of a smooth contact on successive grids: fixed-point iteration of film and heat balance.

Each round computes the temperatures of the film, their effects on viscosity and mobility at the nodes with Anderson
mixing, and the film with these effects. A finer grid starts from the results of the coarser ones.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg.lapack import dgelss

from ehl.common.arrays import FloatArray
from ehl.fluid.lubricant import Lubricant
from ehl.heat._kernels import flow_heat
from ehl.heat.conduction import Matrices, surface_matrices
from ehl.heat.traction import Convection, FilmTemperature, film_temperature
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.smooth.continuation import HARD_NODES, features_of_level, grid_for, transfer
from ehl.smooth.newton import (
    FilmShear,
    Level,
    NewtonFactors,
    NewtonFailure,
    NodeGrid,
    Numbers,
    Unknowns,
    numbers_of,
    solve_level,
)
from ehl.smooth.scaling import Offset, ScaledContact

MAX_ROUNDS = 60
MAX_HALVINGS = 6
ACCEPTED_CHANGE = 0.1  # largest accepted change in the last round; it is noted and counted in the error
FIRST_ROUNDS = 10.0  # multiple of the tolerance on the first grid, which serves to grade the following ones
# tuned with tests/verification/ehl/test_thermal_steady.py: full steps overshoot by up to 70 % as thin films are heated
# less
RELAXATION = 0.65
# tuned with the same tests and test_cold_oil.py: thick films of cold oil overshoot by several full steps. If the
# residual grows, steps are shortened down to this share; they are lengthened if it falls by a third
SHORTEST, SHORTER, LONGER = 0.15, 0.6, 1.3
FALLING = 0.7
MEMORY = 4
MASS_RESIDUAL = 5e-4  # largest mass residual over the flow with the factors of an earlier round
# change of the mesh stretch over the tolerance up to which conduction matrices, which change by less, are reused
SAME_MESH = 0.5
# tuned with tests/verification/ehl/test_thermal_steady.py and 48 contacts of the gear range: error of friction and
# films over the change of ln(viscosity) extrapolated to a finer grid, and this error over the tolerance up to which the
# grid has no heat balance of its own
EXTRAPOLATION_ERROR, EXTRAPOLATED = 0.1, 5.0
# the changes of the rounds are taken to fall at least and at most by these factors
FALL = (0.2, 0.5)

Guess = tuple[FloatArray, FloatArray, FloatArray]


@dataclass(frozen=True)
class HeatModel:
    """Contact, oil and bodies for the heat balance of `ehl.heat.traction.film_temperature`."""

    contact: LineContact
    lubricant: Lubricant
    bodies: tuple[Material, Material]
    bulk: tuple[float, float]

    def matrices(self, level: Level) -> Matrices:
        """Conduction matrices on the nodes of a level."""
        return surface_matrices(level.x * self.contact.half_width, self.contact, self.bodies)

    def balance(self, level: Level, matrices: Matrices, guess: Guess | None, tolerance: float) -> FilmTemperature:
        """Heat balance with the film of a level, from stress, `walls` and `surfaces` of an earlier one."""
        contact, lubricant, b = self.contact, self.lubricant, self.contact.half_width
        pressure = contact.pressure_hertz * np.maximum(level.unknowns.pressure, 0.0)
        film = b * b / contact.radius_equivalent * level.film
        # the flow u_r h* is constant. Behind the pressure spike of a thick, fast film the heat
        # of the flow arises within a hundredth of l: with local conduction only the oil is heated by thousands of
        # kelvin, with convection by a few kelvin
        k_film = lubricant.film_conductivity(pressure, lubricant.thermal_conductivity)
        speed = contact.speed_entrainment
        capacity = lubricant.density * lubricant.heat_capacity * speed * film[-1]
        density = lubricant.density_ratio(pressure)
        x, length = level.x * b, capacity * film / (12.0 * k_film)
        heat = flow_heat(x, pressure, film, density, length, speed)
        surfaces = guess[2] if guess is not None else np.full(x.size, 0.5 * (self.bulk[0] + self.bulk[1]))
        return film_temperature(
            pressure, film, k_film, contact, lubricant, self.bulk, matrices, rolling_heat=heat, tolerance=tolerance,
            convection=Convection(x, length, capacity, surfaces), guess=guess[:2] if guess else None,
        )  # fmt: skip


class Mixer:
    """Anderson mixing of the effects of heat along x/b, on fixed nodes.

    Walker & Ni (2011), SIAM J. Numer. Anal. 49, 1715, with relaxation. Secants of earlier rounds are interpolated to
    other nodes.

    relaxation: share of the residual in the next step [-].
    part: part of that step after halving [-].
    """

    def __init__(self, used: Offset) -> None:
        self.used, self.relaxation, self.part, self._norm = used, RELAXATION, 1.0, math.inf
        self._before: tuple[FloatArray, FloatArray] | None = None  # offset and residual of the last round
        self._secants: list[tuple[FloatArray, FloatArray]] = []  # changes of both between rounds

    def on_nodes(self, x: FloatArray, *, finer: bool = False) -> Mixer:
        """The same on other nodes; on finer ones the first residual may exceed the last one."""
        moved, old = Mixer(self.used.moved(x)), self.used.x
        moved.relaxation, moved._norm = self.relaxation, math.inf if finer else self._norm
        moved._secants = [(_rows_at(x, old, a), _rows_at(x, old, b)) for a, b in self._secants]
        return moved

    def follow(self, found: Offset) -> None:
        """Compute the next offset from the result of the last one."""
        used = self.used.rows
        residual = found.moved(self.used.x).rows - used
        norm = math.sqrt(float(np.vdot(residual, residual)) / self.used.x.size)
        if norm > self._norm:
            self.relaxation, self._secants = max(SHORTER * self.relaxation, SHORTEST), []
        elif self._before is not None:
            secant = (used - self._before[0], residual - self._before[1])
            self._secants = [*self._secants[2 - MEMORY :], secant]
        if norm < FALLING * self._norm:
            self.relaxation = min(LONGER * self.relaxation, RELAXATION)
        self._before, self._norm, self.part = (used, residual), norm, 1.0
        mixed = used + self.relaxation * residual
        if self._secants:
            steps, changes = (np.array(part).reshape(-1, used.size).T for part in zip(*self._secants, strict=True))
            share = dgelss(changes, residual.ravel(), cond=1e-6)[1][: len(self._secants)]
            mixed -= ((steps + self.relaxation * changes) @ share).reshape(used.shape)
        self.used = Offset(self.used.x, mixed)

    def halve(self) -> None:
        """Halve the last step after a failed film solution."""
        assert self._before is not None
        self.part *= 0.5
        self.used = Offset(self.used.x, 0.5 * (self.used.rows + self._before[0]))


class HotFilm:
    """Solution of the thermal contact on successive grids.

    x: nodes of the last heat balance, in half-widths.
    found: last heat balance.
    change: relative change of friction and the larger one of both films in further rounds [-]: the change of the last
        round times f + f^2 + ..., with its ratio f to the one before.
    extrapolated: error of both by temperatures extrapolated to the last grid [-].
    rounds, iterations: rounds and Newton iterations of the film on all grids.
    """

    def __init__(self, model: HeatModel, scaled: ScaledContact, shear: FilmShear, tolerance: float) -> None:
        self.model, self.shear, self.tolerance = model, shear, tolerance
        self._scaled = scaled
        # on a step of Newton's method; the error is far smaller
        self._film_tolerance = self._heat_tolerance = 0.03 * tolerance
        self.found: FilmTemperature | None = None
        self.change, self._last = (math.inf, math.inf), math.inf
        self.extrapolated = 0.0
        self.rounds = self.iterations = 0
        self.x: FloatArray = np.zeros(0)
        self._mixer = Mixer(Offset.of(self.x, self.x))
        # change of the effects of heat between the last two grids
        self._trend: tuple[FloatArray, FloatArray] | None = None
        self._grids = 0
        self._level: Level | None = None  # that of the last grid
        self._matrices: tuple[NodeGrid, float, Matrices] | None = None
        self._factors: tuple[NodeGrid, NewtonFactors] | None = None

    def started(self, cold: Level, guess: Offset | None) -> Level:
        """Thermal film on a coarse grid graded for it, from the isothermal film and a guess of the offset."""
        grid, start = cold.grid, cold.unknowns
        if grid.nodes.size >= HARD_NODES:
            grid = NodeGrid.of(grid.grading, grid.nodes)
            start = transfer(cold, grid)
        x = _nodes(grid, start)
        mixer = Mixer(Offset.of(x, np.zeros(x.size)) if guess is None else guess.moved(x))
        try:
            level = self._film(grid, mixer, start)
        except NewtonFailure:
            if guess is None:
                raise
            return self.started(cold, None)
        return self._settled(level, mixer, FIRST_ROUNDS * self.tolerance, regraded=True)

    def solved(self, grid: NodeGrid, guess: Unknowns) -> Level:
        """Thermal film on a grid, from a guess of the film and the heat balance of the last grid."""
        spent = self.iterations
        if self._level is not None and grid is self._level.grid:
            self._grids, level = 1, self._settled(self._level, self._mixer, self.tolerance)
            return replace(level, iterations=self.iterations - spent)
        x = _nodes(grid, guess)
        mixer = self._mixer.on_nodes(x, finer=True)
        expected = mixer.used
        if self._trend is not None and self._grids >= 2:
            trend = 0.25 * _rows_at(x, *self._trend)
            mixer.used = Offset(x, expected.rows + trend)
            self.extrapolated = EXTRAPOLATION_ERROR * float(np.abs(trend).max())
            if self.extrapolated <= EXTRAPOLATED * self.tolerance:
                self._trend, self._grids = None, 0
                level = self._film(grid, mixer, guess)
                return replace(level, iterations=self.iterations - spent)
        self.extrapolated = 0.0
        grids, self._grids = self._grids, 0
        level = self._settled(self._film(grid, mixer, guess), mixer, self.tolerance)
        self._trend, self._grids = (x, self._mixer.used.rows - expected.rows), grids + 1
        return replace(level, iterations=self.iterations - spent)

    def _settled(self, level: Level, mixer: Mixer, tolerance: float, regraded: bool = False) -> Level:
        """Iterate until friction and film change by less than the tolerance, with regrading if requested."""
        numbers, guess = numbers_of(level, self.shear), self._guess_at(level.x)
        if level is not self._level:
            self.change, self._last = (math.inf, math.inf), math.inf
        elif max(self.change) <= tolerance:
            return level
        for _ in range(MAX_ROUNDS):
            self.rounds += 1
            found = self.model.balance(level, self._matrices_of(level), guess, self._heat_tolerance)
            effects = Offset.of(level.x, found.log_viscosity_offset, found.log_flow_shares)
            if not np.isfinite(effects.rows).all():
                raise NewtonFailure("not_finite", 0)
            if not found.converged:
                raise NewtonFailure("no_thermal_balance", 0)
            guess = found.stress, found.walls, found.surfaces
            mixer.follow(effects)
            heated = level.x
            try:
                level = self._next_film(level, mixer)
            except NewtonFailure:
                if max(self.change) > ACCEPTED_CHANGE:
                    raise
                # no further film solution exists near this one: accept it with the change that is left
                break
            before, numbers = numbers, numbers_of(level, self.shear)
            # changes scaled to a full step
            friction, films = _changes(before, numbers)
            whole = RELAXATION / (mixer.relaxation * mixer.part)
            change = whole * max(friction, films)
            fall = min(max(change / self._last, FALL[0]), FALL[1]) if 0.0 < self._last < math.inf else FALL[1]
            left, self._last = whole * fall / (1.0 - fall), change
            self.change = left * friction, left * films
            self.x, self._mixer, self.found = heated, mixer, found
            features = features_of_level(level) if regraded else level.features
            if not features.close_to(level.features):
                grid = grid_for(features, level.x.size)
                start = transfer(level, grid)
                mixer = mixer.on_nodes(_nodes(grid, start))
                level = self._film(grid, mixer, start)
                guess = self._guess_at(level.x)
                numbers = numbers_of(level, self.shear)
            elif max(self.change) <= tolerance:
                break
        if max(self.change) > ACCEPTED_CHANGE:
            raise NewtonFailure("thermal_rounds", 0)
        self._level = level
        return level

    def _film(self, grid: NodeGrid, mixer: Mixer, start: Unknowns) -> Level:
        if self._factors is None or self._factors[0] is not grid:
            self._factors = grid, NewtonFactors(grid)
        level = self._solved(self._factors[1], grid, mixer, start)
        if level.mass_residual > MASS_RESIDUAL:
            self._factors = grid, NewtonFactors(grid)
            level = self._solved(self._factors[1], grid, mixer, level.unknowns)
        return level

    def _next_film(self, level: Level, mixer: Mixer) -> Level:
        for _ in range(MAX_HALVINGS):
            try:
                return self._film(level.grid, mixer, level.unknowns)
            except NewtonFailure:
                mixer.halve()
        return self._film(level.grid, mixer, level.unknowns)

    def _solved(self, factors: NewtonFactors, grid: NodeGrid, mixer: Mixer, start: Unknowns) -> Level:
        scaled = replace(self._scaled, offset=mixer.used)
        try:
            level = solve_level(grid, scaled, start, tolerance=self._film_tolerance, factors=factors)
        except NewtonFailure as failure:
            self.iterations += failure.iterations
            raise
        self.iterations += level.iterations
        return level

    def _guess_at(self, x: FloatArray) -> Guess | None:
        """Interpolated stress and surface temperatures of the last heat balance."""
        if self.found is None:
            return None
        rows = self.found.stress, self.found.walls, self.found.surfaces
        stress, walls, surfaces = (np.interp(x, self.x, row) for row in rows)
        return stress, walls, surfaces

    def _matrices_of(self, level: Level) -> Matrices:
        stretch = level.unknowns.stretch
        if self._matrices is not None:
            grid, at, matrices = self._matrices
            if grid is level.grid and abs(stretch / at - 1.0) < SAME_MESH * self.tolerance:
                return matrices
        matrices = self.model.matrices(level)
        self._matrices = level.grid, stretch, matrices
        return matrices


def _rows_at(points: FloatArray, x: FloatArray, rows: FloatArray) -> FloatArray:
    """Rows over x, interpolated linearly."""
    return np.array([np.interp(points, x, row) for row in rows])


def _nodes(grid: NodeGrid, unknowns: Unknowns) -> FloatArray:
    return grid.grading.x_in + unknowns.stretch * (grid.nodes - grid.grading.x_in)


def _changes(before: Numbers, after: Numbers) -> tuple[float, float]:
    """Relative change of friction and the larger one of both films."""

    def change(a: float, b: float) -> float:
        return abs(a - b) / b if b > 0.0 else 0.0

    films = change(before.film_central, after.film_central), change(before.film_min, after.film_min)
    return change(before.friction, after.friction), max(films)
