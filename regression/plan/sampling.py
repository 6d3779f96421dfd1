"""Points of a plan: Sobol or Latin hypercube in the ranges, corners of the box, full factorial, rows of a table."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from ehl.common.arrays import FloatArray, IntArray
from ehl.common.errors import InputError
from regression.plan.axes import PlanAxis

# maps values of the sampled variables and numbers of the points to a mask of accepted points
Accept = Callable[[dict[str, FloatArray], IntArray], NDArray[np.bool_]]

MAX_DRAWN = 64  # largest length of a Sobol sequence with constraints, over the requested size


@dataclass(frozen=True)
class PointBlock:
    """Points of one origin."""

    origin: str  # sobol, latin, corner, lattice or table
    columns: dict[str, FloatArray]  # values of every variable, SI
    number: IntArray  # of each point in its sequence, including rejected points; it determines the roughness seed


def sobol_unit(dimension: int, size: int, seed: int) -> FloatArray:
    """Scrambled Sobol points in the unit cube, shape (size, dimension); `size` is a power of two.

    The same seed gives the same points; a longer sequence with the same seed begins with the shorter one.
    """
    engine = qmc.Sobol(dimension, scramble=True, rng=np.random.default_rng(seed))
    return np.asarray(engine.random(size))


def latin_unit(dimension: int, size: int, seed: int) -> FloatArray:
    """A Latin hypercube in the unit cube, shape (size, dimension): one point per row of each axis."""
    return np.asarray(qmc.LatinHypercube(dimension, rng=np.random.default_rng(seed)).random(size))


def corner_unit(dimension: int, count: int | None = None, seed: int = 0) -> FloatArray:
    """The 2^dimension corners of the unit cube, or `count` of them drawn at random."""
    if count is None or count >= 2**dimension:
        return np.array(list(itertools.product((0.0, 1.0), repeat=dimension)))
    chosen = np.random.default_rng(seed).permutation(2**dimension)
    return np.array([[(int(c) >> k) & 1 for k in range(dimension)] for c in chosen], dtype=float)


def to_range(unit: FloatArray, low: float, high: float, scale: str) -> FloatArray:
    """Map [0, 1] to a range, linearly or in the logarithm; the ends are exact."""
    if scale == "log":
        value = np.exp(np.log(low) + unit * (np.log(high) - np.log(low)))
    else:
        value = low + unit * (high - low)
    return np.asarray(np.where(unit == 0.0, low, np.where(unit == 1.0, high, np.clip(value, low, high))))


def lattice(axes: Mapping[str, PlanAxis]) -> Iterator[dict[str, float]]:
    """Every combination of the values of the axes that are not sampled."""
    lists = {name: axis.values for name, axis in axes.items() if not axis.sampled}
    for levels in itertools.product(*lists.values()):
        yield dict(zip(lists, levels, strict=True))


class BoxSampler:
    """Points in the box of the sampled axes.

    axes: axes of the plan; only sampled axes are used.
    method: sobol or latin_hypercube.
    seed: seed of the sequence.
    """

    def __init__(self, axes: Mapping[str, PlanAxis], method: str, seed: int) -> None:
        self.ranges = {name: axis for name, axis in axes.items() if axis.sampled}
        self.method, self.seed = method, seed

    def columns(self, unit: FloatArray) -> dict[str, FloatArray]:
        """Values of the sampled variables at points of the unit cube."""
        ranges = enumerate(self.ranges.items())
        return {name: to_range(unit[:, i], axis.values[0], axis.values[1], axis.scale) for i, (name, axis) in ranges}

    def unit(self, columns: Mapping[str, FloatArray]) -> FloatArray:
        """Points of the unit cube from the values of the sampled variables; the inverse of `columns`."""
        unit = []
        for name, axis in self.ranges.items():
            low, high = axis.values
            value = np.asarray(columns[name], dtype=float)
            if axis.scale == "log":
                unit.append(np.log(value / low) / np.log(high / low))
            else:
                unit.append((value - low) / (high - low))
        return np.column_stack(unit)

    def inside(self, size: int, accept: Accept | None, first: int = 0) -> PointBlock:
        """`size` points that satisfy the constraints.

        A Sobol sequence starts at its point `first` and continues until there are enough points. A Latin hypercube
        cannot be continued, so that rejected points are lost.

        Raises `InputError`: the constraints accept less than 1/64 of the points.
        """
        dimension = len(self.ranges)
        if self.method == "latin_hypercube":
            columns = self.columns(latin_unit(dimension, size, self.seed))
            return filtered("latin", columns, np.arange(size), accept)
        engine = qmc.Sobol(dimension, scramble=True, rng=np.random.default_rng(self.seed))
        if first:
            engine.fast_forward(first)
        chunk = 1 << (size - 1).bit_length() if size > 1 else 1
        parts: list[PointBlock] = []
        found, drawn = 0, 0
        while found < size:
            if drawn >= MAX_DRAWN * max(size, 64):
                hint = "Widen the windows, or narrow the ranges."
                raise InputError("constraints", f"{found} of {drawn} points inside", "windows that accept 1/64", hint)
            number = np.arange(first + drawn, first + drawn + chunk)
            # chunks of a power of two keep the balance of the sequence
            part = filtered("sobol", self.columns(np.asarray(engine.random(chunk))), number, accept)
            parts.append(part)
            found, drawn = found + part.number.size, drawn + chunk
        columns = {name: np.concatenate([part.columns[name] for part in parts])[:size] for name in self.ranges}
        number = np.concatenate([part.number for part in parts])[:size]
        return PointBlock("sobol", columns, number)

    def corners(self, count: int | None, accept: Accept | None) -> PointBlock:
        """At most `count` corners of the box that satisfy the constraints."""
        unit = corner_unit(len(self.ranges), count, self.seed)
        block = filtered("corner", self.columns(unit), np.arange(len(unit)), accept)
        columns = {name: column[:count] for name, column in block.columns.items()}
        return PointBlock("corner", columns, block.number[:count])


def filtered(origin: str, columns: dict[str, FloatArray], number: IntArray, accept: Accept | None) -> PointBlock:
    """A block of the accepted points."""
    if accept is None:
        return PointBlock(origin, columns, number)
    inside = accept(columns, number)
    return PointBlock(origin, {name: column[inside] for name, column in columns.items()}, number[inside])
