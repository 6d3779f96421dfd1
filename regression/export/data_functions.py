"""Functions over stored numbers: the Gaussian process and the guard of a formula as sums and minima over rows.

gp_mean        sum_j w_j m(|x - z_j|), m(r) = (1 + a + a^2/3) exp(-a), a = sqrt(5) r; coordinates over length scales
gp_reduction   sum_i (sum_j m(|x - z_j|) B_ij)^2, what the stored points take off the variance of the process
case_distance  least distance of z to the stored cases
hull_margin    least margin of (x_i, x_k) to the edges of the convex hulls, negative outside
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from regression.export.record import Value
from regression.friction.conditions import Array
from regression.friction.data_cloud import DataCloud
from regression.friction.gaussian_process import GpResidual

NAMES = ("gp_mean", "gp_reduction", "case_distance", "hull_margin")


@dataclass(frozen=True)
class DataFunction:
    """A function of several coordinates over stored rows.

    Parameters
    ----------
    name : str
        One of `NAMES`.
    rows : array, shape (m, c)
        gp_mean: z/l and weight. gp_reduction: z/l and row B_i. case_distance: z. hull_margin: those of
        `regression.friction.data_cloud.DataCloud.half_planes`.
    size : int
        Number of coordinates.
    """

    name: str
    rows: Array
    size: int


class DataValue(Value):
    """The value of a `DataFunction` at recorded coordinates."""

    def __init__(self, function: DataFunction, coordinates: list[Value]) -> None:
        super().__init__(function.name, tuple(coordinates))
        self.function = function


def gp_mean(residual: GpResidual, scaled: list[Any]) -> Any:
    """Mean of the process; `scaled` are the coordinates over the length scales."""
    rows = np.column_stack([_scaled_points(residual), residual.variance * np.array(residual.weights)])
    return DataValue(DataFunction("gp_mean", rows, len(scaled)), scaled)


def gp_reduction(residual: GpResidual, scaled: list[Any]) -> Any:
    """What the stored points take off the variance of the process."""
    count = len(residual.alpha)
    rows = np.column_stack([_scaled_points(residual)[:count], residual.variance * residual.root])
    return DataValue(DataFunction("gp_reduction", rows, len(scaled)), scaled)


def _scaled_points(residual: GpResidual) -> Array:
    return np.asarray(np.array(residual.points) / np.array(residual.length_scales))


def case_distance(cloud: DataCloud, whitened: list[Any]) -> Any:
    """Distance to the nearest stored case."""
    return DataValue(DataFunction("case_distance", np.array(cloud.points), len(whitened)), whitened)


def hull_margin(cloud: DataCloud, logarithms: list[Any]) -> Any:
    """Least margin to the edges of all hulls; `logarithms` in the order of the cloud's variables."""
    return DataValue(DataFunction("hull_margin", cloud.half_planes, len(logarithms)), logarithms)
