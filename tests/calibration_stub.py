"""A friction law of one line in place of the contact solver, so that statistics of calibration take seconds.

Setups and measurements in memory.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.fluid.oil import Oil
from ehl.line_contact import moes_1992
from regression.calibration.measurement import Measurement
from regression.calibration.prediction import FrictionSolver, FrozenFilm
from regression.calibration.setup import CalibrationSetup, card_with, lubricant_of


class OneLineSolver(FrictionSolver):
    """tau = min(tau0 asinh(eta u_s/(tau0 h)), Lambda p) at the mean pressure, isothermal, h by Moes (1992).

    Asperities of rough rows carry the share exp(-h/h_boundary), the film the rest.
    """

    def parts(self, sets: Sequence[Mapping[str, float]], rows: Any = None) -> FloatArray:
        out = np.full((len(sets), self.roughness.size, 3), np.nan)
        for k, values in enumerate(sets):
            films: list[FrozenFilm] = []
            card = card_with(Oil.load(self.setup.oil), values, self.temperature)
            for group in self.groups:
                for row, contact, temperature in zip(group.rows, group.contacts, group.temperatures, strict=True):
                    oil = lubricant_of(card, temperature, rising=self.setup.rising)
                    m, length = contact.moes_groups(oil)
                    speed, _, _ = contact.dowson_groups(oil)
                    film = moes_1992(m, length) * contact.radius_equivalent * (2.0 * speed) ** 0.5
                    mean = np.array([0.25 * np.pi * contact.pressure_hertz])
                    stress = oil.shear_stress(mean, np.array([film]), contact.speed_sliding)
                    share = float(np.exp(-film / values.get("boundary_film", 2e-8))) if self.roughness[row] else 0.0
                    out[k, row] = (1.0 - share) * float(stress[0] / mean[0]), share, 0.0
                    rest = np.log(np.array([contact.speed_sliding / film]))
                    films.append(FrozenFilm(mean, rest, 1.0 / mean, math.log(contact.film_moes(oil))))
            if k == 0:
                self.films = dict(enumerate(films))
        self.calls += len(sets) * self.roughness.size
        return out


def setup_with(
    parameters: Sequence[str] = ("eyring_stress", "boundary_friction"), **changes: object
) -> CalibrationSetup:
    """Setup of a point contact, fast."""
    content = {"oil": "fva3", "specimens": {"geometry": "point"}, "model": {"accuracy": "fast"}}
    return CalibrationSetup.model_validate(content | {"parameters": list(parameters)} | changes)


def measured(load: str, /, friction: float = math.nan, curves: Sequence[str] = (), **columns: Any) -> Measurement:
    """Rows of a table; a single number of a column is that of all rows."""
    values = dict(zip(columns, map(np.array, np.broadcast_arrays(*columns.values())), strict=True))
    n = values[load].size
    rows = np.full(n, friction), np.full(n, math.nan), tuple(curves) or ("a",) * n, tuple(range(2, n + 2))
    return Measurement("made.csv", "0" * 64, values, load, *rows)
