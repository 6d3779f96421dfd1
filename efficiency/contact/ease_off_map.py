"""Ease-off given as a table of points: a CSV file with the columns ``length,depth,ease_off``.

length runs from -1 at the toe to 1 at the heel, depth from -1 to 1 over the working depth of the gear (see
`EaseOffTarget`), ease_off in um is material missing on the pinion. Lines that start with # are skipped. A polynomial
goes through the points by least squares; its degree is the one that predicts left-out points best.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from ehl.io.errors import InputError

FloatArray = NDArray[np.float64]

COLUMNS = "length,depth,ease_off"
_MIN_POINTS, _HIGHEST = 6, 10


@dataclass(frozen=True)
class EaseOffMap:
    """Smooth ease-off through a table.

    Attributes
    ----------
    coefficients : (n, m) array
        Chebyshev coefficients over length and depth [m].
    error : float
        Greatest distance by which the surface through all other points misses a point [m].
    """

    coefficients: FloatArray
    error: float

    def __call__(self, length: FloatArray, depth: FloatArray) -> FloatArray:
        """Relief [m] at points of the gear flank."""
        return np.asarray(chebyshev.chebval2d(length, depth, self.coefficients), np.float64)


def read_ease_off_map(path: Path) -> EaseOffMap:
    """Read a table of ease-off.

    Raises
    ------
    InputError
        Naming the line that cannot be used.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError("ease_off.map", str(path), "a readable CSV file", f"{error}.") from None
    rows = [(k + 1, line.strip()) for k, line in enumerate(lines) if line.strip() and not line.startswith("#")]
    if not rows or rows[0][1].replace(" ", "") != COLUMNS:
        raise InputError(f"{path}, first line", rows[0][1][:60] if rows else "nothing", COLUMNS)
    table = []
    for number, line in rows[1:]:
        try:
            values = [float(text) for text in line.split(",")]
        except ValueError:
            raise InputError(f"{path}, line {number}", line[:60], "three finite numbers") from None
        if len(values) != 3 or not np.isfinite(values).all():
            raise InputError(f"{path}, line {number}", line[:60], "three finite numbers")
        if max(abs(values[0]), abs(values[1])) > 1.5 or abs(values[2]) > 1000.0:
            raise InputError(
                f"{path}, line {number}", line[:60], "length and depth from -1.5 to 1.5, ease-off to 1000 um"
            )
        table.append(values)
    if len(table) < _MIN_POINTS:
        raise InputError("ease_off.map", f"{path} with {len(table)} points", f"at least {_MIN_POINTS} points")
    length, depth, relief = np.array(table).T
    return _fit(str(path), length, depth, relief * 1e-6)


def _fit(path: str, length: FloatArray, depth: FloatArray, relief: FloatArray) -> EaseOffMap:
    best: EaseOffMap | None = None
    for degree in range(1, _HIGHEST + 1):
        kept = np.add.outer(np.arange(degree + 1), np.arange(degree + 1)) <= degree
        matrix = np.asarray(chebyshev.chebvander2d(length, depth, [degree, degree]))[:, kept.ravel()]
        basis, triangle = np.linalg.qr(matrix)
        if 1.2 * matrix.shape[1] > length.size or np.abs(np.diag(triangle)).min() < 1e-8 * np.abs(triangle).max():
            break
        rest = relief - basis @ (basis.T @ relief)
        missed = float(np.abs(rest / (1.0 - np.sum(basis**2, axis=1)).clip(1e-3)).max())
        if best is None or missed < 0.9 * best.error:
            coefficients = np.zeros(kept.shape)
            coefficients[kept] = np.linalg.solve(triangle, basis.T @ relief)
            best = EaseOffMap(coefficients, missed)
    if best is None:
        raise InputError("ease_off.map", path, "points spread over length and depth")
    return best
