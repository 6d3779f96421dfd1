"""Losses of an axle outside its mesh: a measured table, or a constant and a load-dependent torque of ours."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from efficiency.loss.kinematics import OPERATION_LIMITS
from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.quantities import quantity
from ehl.common.table_reader import read_table
from ehl.common.units import ValueRange

_TORQUE = float(OPERATION_LIMITS["torque"].le or 1e6)
_SPEED = float(OPERATION_LIMITS["speed"].le or 5e3)
SIGNED_TORQUE = ValueRange("N*m", ge=-_TORQUE, le=_TORQUE, hint="Below zero in coast.")
COLUMNS = {
    "torque": SIGNED_TORQUE,
    "speed": ValueRange("rad/s", ge=0.0, le=_SPEED),
    "torque_loss": ValueRange("N*m", ge=0.0, le=_TORQUE),
}
DRAG = ValueRange("N*m", ge=0.0, le=_TORQUE, hint="At the pinion shaft, of any speed.")
LOAD_SHARE = ValueRange("", ge=0.0, lt=0.5, hint="Torque lost in the bearings over the pinion torque.")
_SIMPLE = {"drag": DRAG, "load_share": LOAD_SHARE}


class AxleLosses(Protocol):
    """Torque lost outside the mesh, referred to the pinion shaft."""

    @property
    def description(self) -> str:
        """What it is, in one line."""

    def torque_loss(self, torque: float, speed: float) -> float:
        """At a signed pinion torque [N m] and a pinion speed [rad/s], [N m], never below zero."""


@dataclass(frozen=True)
class SimpleAxleLosses:
    """A constant drag and bearings that lose a share of the torque: T = drag + share |T1|. Ours.

    Examples
    --------
    >>> SimpleAxleLosses(2.0, 0.005).torque_loss(-300.0, 100.0)
    3.5
    """

    drag: float = 0.0  # of bearings, seals and oil [N m], at the pinion shaft
    load_share: float = 0.0  # load-dependent part [-]

    def __post_init__(self) -> None:
        DRAG.check(self.drag, "drag")
        LOAD_SHARE.check(self.load_share, "load_share")

    @property
    def description(self) -> str:
        """What it is, in one line."""
        return f"bearings and drag: {self.drag:.4g} N m + {100.0 * self.load_share:.4g} % of the pinion torque (ours)"

    def torque_loss(self, torque: float, speed: float) -> float:
        """At a signed pinion torque [N m] and any pinion speed, [N m]."""
        return self.drag + self.load_share * abs(torque)


@dataclass(frozen=True)
class TableAxleLosses:
    """Torque lost outside the mesh from a table over pinion torque and speed, bilinear between its points."""

    name: str  # of the file
    torque: FloatArray  # rising [N m], below zero in coast
    speed: FloatArray  # rising [rad/s]
    loss: FloatArray  # at the pinion shaft [N m]

    @property
    def description(self) -> str:
        """What it is, in one line."""
        return f"bearings and drag: table {self.name}"

    def torque_loss(self, torque: float, speed: float) -> float:
        """At a signed pinion torque [N m] and a pinion speed [rad/s], [N m].

        Raises `InputError`: outside the table: nothing is extrapolated.
        """
        for name, value, grid in (("torque", torque, self.torque), ("speed", speed, self.speed)):
            if not grid[0] * (1.0 - 1e-12) - 1e-9 <= value <= grid[-1] * (1.0 + 1e-12) + 1e-9:
                of = quantity(name)
                hint = "Add rows to the table, or leave the point out: nothing is extrapolated."
                raise InputError(f"{self.name}, {of.label}", of.text(value), of.span(grid[0], grid[-1]), hint)
        at_speed = [float(np.interp(speed, self.speed, row)) for row in self.loss]
        return float(np.interp(torque, self.torque, at_speed))


def resolve_axle(axle: AxleLosses | Path | str | Mapping[str, float | str] | None) -> AxleLosses | None:
    """Losses outside the mesh from a table file, or from `drag` and `load_share` of the simple model.

    Raises `InputError`: the file cannot be used, another name, a value out of range or without its unit.
    """
    if isinstance(axle, Path | str):
        return read_axle_losses(axle)
    if not isinstance(axle, Mapping):
        return axle
    for name in axle:
        if name not in _SIMPLE:
            raise InputError("axle", name, "drag and load_share")
    values = {k: _SIMPLE[k].check(v, k, bare=not isinstance(v, str) or k != "drag") for k, v in axle.items()}
    return SimpleAxleLosses(**values)


def read_axle_losses(path: Path | str) -> TableAxleLosses:
    """Table of losses outside the mesh: CSV or XLSX, columns torque, speed, torque_loss with units, a full grid.

    Raises `InputError`: the file cannot be read, or lacks a combination of torque and speed.
    """
    path = Path(path)
    found = read_table(path, COLUMNS, tuple(COLUMNS), bare=False, missing=True)
    torque, speed, loss = (np.array(found[name], dtype=np.float64) for name in COLUMNS)
    torques, i = np.unique(torque, return_inverse=True)
    speeds, j = np.unique(speed, return_inverse=True)
    grid = np.full((len(torques), len(speeds)), np.nan)
    grid[i, j] = loss
    if len(loss) != grid.size or np.isnan(grid).any():
        raise InputError(
            path.name,
            f"{len(loss)} rows for {len(torques)} torques and {len(speeds)} speeds",
            "each combination of torque and speed once",
        )
    return TableAxleLosses(path.name, torques, speeds, grid)
