"""Functions over stored numbers: the Gaussian process and the guard of a formula as sums and minima over rows.

gp_mean        sum_j w_j m(|x - z_j|), m(r) = (1 + a + a^2/3) exp(-a), a = sqrt(5) r; coordinates over length scales
gp_reduction   sum_i (sum_j m(|x - z_j|) B_ij)^2, what the stored points take off the variance of the process
case_distance  least distance of z to the stored cases
film_...       the same of a second process
hull_margin    least margin of (x_i, x_k) to the edges of the convex hulls, negative outside
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from regression.export.record import Value
from regression.friction.conditions import Array
from regression.friction.data_cloud import DataCloud
from regression.friction.gaussian_process import GpResidual

NAMES = ("gp_mean", "gp_reduction", "film_mean", "film_reduction", "case_distance", "hull_margin")


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

    @property
    def kind(self) -> str:
        """The name of the loop: a second process is computed as the first."""
        return self.name.replace("film_", "gp_")

    def code(self, loops: Mapping[str, str]) -> str:
        """The loop of this function in a language, of those by kind."""
        text = loops[self.kind]
        return text.replace(self.kind, self.name).replace(self.kind.upper(), self.name.upper())


class DataValue(Value):
    """The value of a `DataFunction` at recorded coordinates."""

    def __init__(self, function: DataFunction, coordinates: list[Value]) -> None:
        super().__init__(function.name, tuple(coordinates))
        self.function = function


def process_sums(residual: GpResidual, name: str) -> Callable[[list[Any]], tuple[Any, Any]]:
    """Mean of a process and what its points take off its variance, of coordinates over the length scales.

    `name` is "gp" or, of a second process, "film".
    """
    points, count = np.array(residual.points), len(residual.alpha)
    mean = np.column_stack([points, residual.variance * np.array(residual.weights)])
    reduction = np.column_stack([points[:count], residual.variance * residual.root])

    def sums(scaled: list[Any]) -> tuple[Any, Any]:
        size = len(scaled)
        return (
            DataValue(DataFunction(f"{name}_mean", mean, size), scaled),
            DataValue(DataFunction(f"{name}_reduction", reduction, size), scaled),
        )

    return sums


def case_distance(cloud: DataCloud, whitened: list[Any]) -> Any:
    """Distance to the nearest stored case."""
    return DataValue(DataFunction("case_distance", np.array(cloud.points), len(whitened)), whitened)


def hull_margin(cloud: DataCloud, logarithms: list[Any]) -> Any:
    """Least margin to the edges of all hulls; `logarithms` in the order of the cloud's variables."""
    return DataValue(DataFunction("hull_margin", cloud.half_planes, len(logarithms)), logarithms)
