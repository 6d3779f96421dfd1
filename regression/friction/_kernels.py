"""Root and exponential of a Gaussian process's covariances in one pass that the compiler can vectorise."""

from __future__ import annotations

import math

from ehl.compile.compiler import KERNEL, kernel

FARTHEST = 32.0  # k is below 1e-11 there


@kernel(**KERNEL, fastmath={"reassoc", "contract", "arcp", "nsz"})
def matern_of_squares(squares):
    """In place of squared distances a^2 the covariances (1 + a + a^2/3) exp(-a), within 1e-11 of the largest, 1.

    exp(-a) is the Taylor polynomial of exp(-a/64) of degree 7, squared six times.
    """
    for i in range(squares.shape[0]):
        row = squares[i]
        for j in range(row.size):
            a = min(math.sqrt(max(row[j], 0.0)), FARTHEST)
            y = a * (-1 / 64)
            e = 1.0 + y * (1.0 + y * (1 / 2 + y * (1 / 6 + y * (1 / 24 + y * (1 / 120 + y * (1 / 720 + y / 5040))))))
            e *= e
            e *= e
            e *= e
            e *= e
            e *= e
            e *= e
            row[j] = (1.0 + a * (1.0 + a * (1 / 3))) * e
