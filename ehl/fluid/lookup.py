"""Tables of ln(eta/eta0) and rho/rho0 for the compiled solvers, computed from the laws at the start of a contact.

Piecewise cubics with continuous slopes: one row of cells over pressure at the inlet temperature for viscosity and
density, and one sheet of cells over pressure and temperature for the viscosity of the heated film. The cost of the
solvers is the same for every law. Error of ln(eta/eta0), where it is below 15, tested for every law and card: along the
row below 1e-7, on the sheet below 1e-6 from 263 to 500 K and up to 2.5 GPa. Laws with a pole or kink in that range
reach 1e-6 and 8e-6, the original Yasutomi form 2e-5. Both tables take about 30 milliseconds, once per lubricant.

Cells are equidistant in sqrt(p + p1), of which a Barus law is a polynomial and a Roelands law a power without pole, and
in (T - T1)/(T - T2), of which laws that decrease with the reciprocal of a temperature are polynomials; for laws linear
in T, T2 is far below. Above its last cell the row is continued by its tangent. Beyond the last temperatures, and where
a law no longer increases with pressure, the viscosity is constant, so that it is defined for every iterate.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.fluid.density import Compression
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.viscosity import PressureLaw

PRESSURE_SHIFT = 5e7  # p1: near the smallest pressure at which a law bends, K0/(1 + K0') of hot oil [Pa]
PRESSURE_TOP = 10e9  # [Pa]
ROW_CELLS, SHEET_CELLS, TEMPERATURE_CELLS = 256, 192, 128
TEMPERATURE_ENDS = (223.15, 1500.0)  # [K]
TEMPERATURE_POLES = (180.0, 100.0, -300.0, -1e6)  # T2: the one with the smallest error for the law [K]
LARGEST_TEMPERATURE = 520.0  # up to it T2 is chosen by the error [K]
MIDDLE_TEMPERATURE = 350.0  # where every law is valid [K]
LARGEST_LOG = 200.0  # above it, and beyond a pole of a law, the table is continued along the last slope
# slope per cell at the first and the second of five neighbouring nodes
_SLOPES = np.array([[-25.0, 48.0, -36.0, 16.0, -3.0], [-3.0, -10.0, 18.0, -6.0, 1.0]]) / 12.0


class LawTable(NamedTuple):
    """Numbers for the compiled loops; pressures in the unit of the solver, temperatures in K."""

    row: FloatArray  # (cells, 8): cubics of ln(eta/eta0) and rho/rho0 at the inlet temperature
    sheet: FloatArray  # (cells, temperature cells, 16): entry 4 j + i belongs to T-coordinate^j p-coordinate^i
    shift: float  # p1; place in the row: rate (sqrt(p + p1) - sqrt(p1))
    root: float
    rate: float
    coldest: float  # T1; place in the sheet: warmth (T - T1)/(T - T2)
    pole: float  # T2
    warmth: float


def law_table(lubricant: Lubricant, pressure_unit: float, heated: bool) -> LawTable:
    """The table of a lubricant for pressures in a unit.

    pressure_unit: [Pa].
    heated: whether the sheet over temperature is needed; without it there is one empty cell.
    """
    law = lubricant.pressure_law
    sheet, pole = _sheet(law) if heated else (np.zeros((1, 1, 16)), TEMPERATURE_POLES[0])
    cold, warm = TEMPERATURE_ENDS
    root = math.sqrt(PRESSURE_SHIFT / pressure_unit)
    length = math.sqrt((PRESSURE_TOP + PRESSURE_SHIFT) / pressure_unit) - root
    return LawTable(
        row=_row(law, lubricant.compression),
        sheet=sheet,
        shift=PRESSURE_SHIFT / pressure_unit,
        root=root,
        rate=ROW_CELLS / length,
        coldest=cold,
        pole=pole,
        warmth=TEMPERATURE_CELLS * (warm - pole) / (warm - cold),
    )


@lru_cache(maxsize=64)
def _row(law: PressureLaw, density: Compression) -> FloatArray:
    """Cubics over pressure at the inlet temperature, shape (cells, 8)."""
    pressure = _pressures(ROW_CELLS)
    with np.errstate(all="ignore"):
        viscosity = _continued(law.log_ratio(pressure))
    return np.hstack([_cubics(viscosity), _cubics(density.ratio(pressure))])


@lru_cache(maxsize=8)
def _sheet(law: PressureLaw) -> tuple[FloatArray, float]:
    """Bicubics over pressure and temperature, shape (cells, temperature cells, 16), and the pole T2."""
    pole = min(TEMPERATURE_POLES, key=lambda pole: _temperature_error(law, pole))
    with np.errstate(all="ignore"):
        values = _held(_continued(law.log_ratio(_pressures(SHEET_CELLS)[:, None], _temperatures(pole))), pole)
    along = _cubics(values)  # pressure cell, temperature node, power of p
    both = _cubics(np.moveaxis(along, 1, 0))  # temperature cell, pressure cell, power of p, power of T
    return np.ascontiguousarray(both.transpose(1, 0, 3, 2)).reshape(SHEET_CELLS, TEMPERATURE_CELLS, 16), pole


def _temperature_error(law: PressureLaw, pole: float) -> float:
    """Largest error at the middles of the temperature cells, over a few pressures."""
    pressure = np.array([0.0, 0.1e9, 0.5e9, 1.5e9, 2.5e9])
    with np.errstate(all="ignore"):
        values = _continued(law.log_ratio(pressure[:, None], _temperatures(pole)))
        wanted = law.log_ratio(pressure[:, None], _temperatures(pole, 0.5))
    found = _cubics(values.T) @ 0.5 ** np.arange(4)
    used = (np.abs(wanted) < 15.0) & (_temperatures(pole, 0.5) < LARGEST_TEMPERATURE)
    return float(np.max(np.abs(found.T - wanted), where=used, initial=0.0))


def _pressures(cells: int) -> FloatArray:
    low, high = math.sqrt(PRESSURE_SHIFT), math.sqrt(PRESSURE_TOP + PRESSURE_SHIFT)
    return np.asarray(np.linspace(low, high, cells + 1) ** 2 - PRESSURE_SHIFT)


def _temperatures(pole: float, middle: float = 0.0) -> FloatArray:
    """Temperatures at the nodes, or inside of the cells."""
    cold, warm = TEMPERATURE_ENDS
    place = np.arange(TEMPERATURE_CELLS + (1 if middle == 0.0 else 0)) + middle
    share = place / TEMPERATURE_CELLS * (warm - cold) / (warm - pole)
    return np.asarray((cold - pole * share) / (1.0 - share))


def _continued(values: FloatArray) -> FloatArray:
    """Values over pressure (axis 0), continued along the last slope from where a law leaves its range."""
    rising = np.diff(values, axis=0, prepend=-math.inf) >= 0.0
    good = np.logical_and.accumulate(rising & (np.abs(values) < LARGEST_LOG), axis=0)
    last = np.maximum(good.sum(axis=0) - 1, 1)
    index = np.arange(values.shape[0]).reshape((-1,) + (1,) * (values.ndim - 1))
    top = np.take_along_axis(values, np.expand_dims(last, 0), axis=0)
    slope = top - np.take_along_axis(values, np.expand_dims(last - 1, 0), axis=0)
    return np.where(good, values, top + slope * (index - last))


def _held(values: FloatArray, pole: float) -> FloatArray:
    """Values over pressure and temperature, constant beyond the temperatures at which a law does not increase."""
    right = np.isfinite(values).all(axis=0) & (np.diff(values, axis=0) >= 0.0).all(axis=0)
    right &= values[1] - values[0] < 1.0  # alpha above 150 1/GPa: a solid
    middle = int(np.searchsorted(_temperatures(pole), MIDDLE_TEMPERATURE))
    wrong = np.flatnonzero(~right)
    low = int(max(wrong[wrong < middle], default=-1)) + 1
    high = int(min(wrong[wrong >= middle], default=right.size)) - 1
    return np.asarray(values[:, np.clip(np.arange(right.size), low, max(high, low))])


def _cubics(values: FloatArray) -> FloatArray:
    """Coefficients of the cubics between nodes along axis 0, in a new last axis; slopes by five-point differences."""
    slope = np.empty_like(values)
    slope[2:-2] = 8.0 / 12.0 * (values[3:-1] - values[1:-3]) - (values[4:] - values[:-4]) / 12.0
    for k in (0, 1):
        slope[k] = np.tensordot(_SLOPES[k], values[:5], 1)
        slope[-1 - k] = -np.tensordot(_SLOPES[k], values[:-6:-1], 1)
    low, high, rise = slope[:-1], slope[1:], values[1:] - values[:-1]
    return np.stack([values[:-1], low, 3.0 * rise - 2.0 * low - high, low + high - 2.0 * rise], axis=-1)
