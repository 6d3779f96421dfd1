"""Points of a plan: scrambled Sobol in the ranges, corners of the box, full factorial over the lists."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

Array = NDArray[np.float64]


class AxisLike(Protocol):
    """What sampling needs of a plan's axis: the ends of a range, or the values it takes."""

    @property
    def values(self) -> tuple[float, ...]:
        """Ends of the range, or all values."""
        ...

    @property
    def sampled(self) -> bool:
        """Whether the values are the ends of a range."""
        ...

    @property
    def scale(self) -> str:
        """``linear`` or ``log``."""
        ...


def sobol_unit(dimension: int, size: int, seed: int) -> Array:
    """Scrambled Sobol points in the unit cube, shape (size, dimension); `size` is a power of two.

    The same seed gives the same points; a longer sequence of one seed begins with the shorter one.
    """
    engine = qmc.Sobol(dimension, scramble=True, rng=np.random.default_rng(seed))
    return np.asarray(engine.random(size))


def corner_unit(dimension: int) -> Array:
    """The 2^dimension corners of the unit cube."""
    return np.array(list(itertools.product((0.0, 1.0), repeat=dimension)))


def to_range(unit: Array, low: float, high: float, scale: str) -> Array:
    """Map [0, 1] to a range, linearly or in the logarithm; the ends are met exactly."""
    if scale == "log":
        value = np.exp(np.log(low) + unit * (np.log(high) - np.log(low)))
    else:
        value = low + unit * (high - low)
    return np.asarray(np.where(unit == 0.0, low, np.where(unit == 1.0, high, np.clip(value, low, high))))


def plan_points(
    axes: Mapping[str, AxisLike], size: int | None, seed: int, corners: bool
) -> Iterator[tuple[str, dict[str, float]]]:
    """Origin and values of every case.

    Parameters
    ----------
    axes : mapping
        Variable to axis.
    size : int or None
        Number of Sobol points; None where no axis is a range.
    seed : int
        Of the scrambling.
    corners : bool
        Add the corners of the box of all ranges.

    Yields
    ------
    tuple
        ("sobol" | "corner" | "lattice", values by variable).
    """
    ranges = [name for name, axis in axes.items() if axis.sampled]
    lists = [name for name, axis in axes.items() if not axis.sampled]
    levels = [dict(zip(lists, values, strict=True)) for values in itertools.product(*(axes[n].values for n in lists))]
    blocks: list[tuple[str, Array]] = []
    if ranges and size is not None:
        blocks.append(("sobol", sobol_unit(len(ranges), size, seed)))
        if corners:
            blocks.append(("corner", corner_unit(len(ranges))))
    else:
        blocks.append(("lattice", np.zeros((1, 0))))
    for origin, unit in blocks:
        columns = [
            to_range(unit[:, i], axes[name].values[0], axes[name].values[1], axes[name].scale)
            for i, name in enumerate(ranges)
        ]
        for fixed in levels:
            for row in range(unit.shape[0]):
                yield origin, {**fixed, **{name: float(columns[i][row]) for i, name in enumerate(ranges)}}
