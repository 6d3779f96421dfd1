"""Functions over stored numbers: the networks and the guard of a formula as loops, each with several results.

networks  part that counts, mean outputs of the networks, their variances and covariance, of logarithms of their inputs
guard     distance to the nearest stored case, length of z, least margin of pairs of variables, of logarithms
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from regression.export.record import Value
from regression.friction.data_cloud import DataCloud
from regression.friction.network import FADE, Network

Rows = Sequence[Sequence[float]]
RESULTS = {"networks": 6, "guard": 3}


@dataclass(frozen=True)
class DataFunction:
    """A function of several logarithms over stored numbers."""

    name: str  # one of `RESULTS`
    arrays: dict[str, Rows]  # rows of numbers by name
    sizes: dict[str, float]  # words of the loops that stand for a number

    def loop(self, suffix: str) -> str:
        """The loop of a language, from the file of that suffix next to this module."""
        text = Path(__file__).with_name(f"{self.name}{suffix}").read_text(encoding="utf-8")
        return self.filled(f"\n{text}")

    def filled(self, text: str) -> str:
        """The loop of a language with the numbers of this function in place of their words."""
        for name, number in self.sizes.items():
            text = re.sub(rf"(?<![A-Za-z_]){name}", repr(number), text)
        return text


class DataValue(Value):
    """The results of a `DataFunction` at recorded logarithms."""

    def __init__(self, function: DataFunction, logarithms: Sequence[Value]) -> None:
        super().__init__(function.name, tuple(logarithms))
        self.function = function
        self.name = f"{function.name}_at"

    def __iter__(self) -> Iterator[Value]:
        return (Value("item", (self,), float(place)) for place in range(RESULTS[self.function.name]))


def network_statistics(network: Network) -> Callable[[list[Any]], list[Any]]:
    """As `regression.friction.network.Network.statistics` of recorded logarithms."""
    size, units = len(network.variables), network.units
    # of each network rows of the inputs of a layer, then its biases; one layer after the other
    ends = (0, units, 2 * units, 2 * units + 2)
    layers = [[zip(*rows[start:end], strict=True) for start, end in pairwise(ends)] for rows in network.members]
    function = DataFunction(
        "networks",
        {
            "scales": (network.mean, network.scale, network.low, network.high),
            "weights": [[number for layer in member for row in layer for number in row] for member in layers],
        },
        {
            "STEP": network.step,
            "SIZE": size,
            "UNITS": units,
            "MEMBERS": len(network.members),
            "FADE": FADE,
            "FIRST": units * (size + 1),
            "SECOND": units * (size + 1) + units * (units + 1),
        },
    )
    return lambda logarithms: list(DataValue(function, logarithms))


def guard(cloud: DataCloud, logarithms: list[Any]) -> list[Any]:
    """Distance to the nearest stored case, length of z, and least margin of pairs of variables."""
    arrays: dict[str, Rows] = {
        "scales": (cloud.mean, cloud.scale),
        "whitening": cloud.whitening,
        "cases": list(zip(*cloud.points, strict=True)),
        "limits": cloud.limits,
    }
    sizes = {"STEP": cloud.step, "SIZE": len(logarithms), "CASES": len(cloud.points), "PAIRS": len(cloud.limits)}
    return list(DataValue(DataFunction("guard", arrays, sizes), logarithms))
