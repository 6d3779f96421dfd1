"""Variables of a plan, constraints, and points: Sobol, Latin hypercube, corners, full factorial, rows of a table.

A variable is a sampled range, the levels of a range, a list, or one value. Constraints exclude combinations that do not
occur in gears: each is a window on one quantity that follows from a point by a closed formula.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator
from scipy.stats import qmc

from ehl.common.arrays import FloatArray, IntArray
from ehl.common.errors import InputError, check_count, near
from ehl.common.units import ValueRange, value_range
from ehl.common.validation import InputModel, value_range_of
from ehl.fluid.lubricant_inputs import PressureViscosity, Stress, Viscosity
from ehl.fluid.viscosity import TEMPERATURE_RANGE
from ehl.inputs import LoadPerLength, SlidingSpeed, SurfaceInput
from ehl.line_contact import blok_1937, half_width_of_pressure, hertz_load
from ehl.material import Material
from regression.friction.conditions import MIN_ROUGHNESS, POINT

FLASH_FRICTION = 0.05  # friction coefficient of the flash temperature constraint (Coleman's constant)
MAX_LEVELS = 1000


class PlanAxis(InputModel):
    """One variable of a plan: a sampled range, or a list of values."""

    values: tuple[float, ...]
    sampled: bool = False
    scale: Literal["linear", "log"] = "linear"

    def levelled(self, count: int) -> PlanAxis:
        """Levels of the range, both ends exact; evenly spaced, on a log scale in the logarithm. A list is unchanged."""
        if not self.sampled:
            return self
        low, high = self.values
        if self.scale == "log":
            step = math.log(high / low) / (count - 1)
            inner = (low * math.exp(step * i) for i in range(1, count - 1))
        else:
            inner = (low + (high - low) * i / (count - 1) for i in range(1, count - 1))
        return PlanAxis(values=(low, *inner, high), scale=self.scale)


def read_ends(value: dict[str, Any], quantity: ValueRange) -> tuple[float | None, float | None]:
    """The ends of a range or window as numbers with low < high; None for an end that is not given."""
    low, high = (quantity.check(value[key], key) if key in value else None for key in ("low", "high"))
    if low is not None and high is not None and not low < high:
        bare = [key for key in ("low", "high") if quantity.unit and isinstance(value[key], (int, float))]
        hint = "Exchange the two ends." if low > high else "Give a single value without a table."
        if len(bare) == 1:
            hint = f"{bare[0]} = {value[bare[0]]!r} has no unit and is in {quantity.unit}."
        raise InputError("high", value["high"], f"above low = {value['low']!r}", hint)
    return low, high


def _read_axis(value: Any, quantity: ValueRange) -> PlanAxis:
    """An axis from a plan file: a value, a list, or a table with low, high, scale and optionally levels."""
    if isinstance(value, PlanAxis):
        return value
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        if not 1 <= len(value) <= MAX_LEVELS:
            raise InputError("values", f"list of {len(value)}", f"a list of 1 to {MAX_LEVELS} values")
        values = tuple(quantity.check(item, f"values[{i}]") for i, item in enumerate(value))
        if len(set(values)) < len(values):
            raise InputError("values", value, "a list of different values")
        return PlanAxis(values=values)
    if not isinstance(value, dict):
        return PlanAxis(values=(quantity.check(value, "value"),))
    keys = ("low", "high", "scale", "levels")
    unknown = sorted(set(value) - set(keys))
    if unknown:
        raise InputError(unknown[0], value[unknown[0]], "low, high, scale and levels", near(unknown[0], keys))
    low, high = read_ends(value, quantity)
    if low is None or high is None:
        raise InputError("low" if low is None else "high", None, "both ends of the range")
    scale = value.get("scale", "linear")
    if scale not in ("linear", "log"):
        raise InputError("scale", scale, "linear or log")
    if scale == "log" and low <= 0.0:
        raise InputError("low", value["low"], "above zero with scale = 'log'")
    axis = PlanAxis(values=(low, high), sampled=True, scale=scale)
    if "levels" not in value:
        return axis
    check_count("levels", value["levels"], 2, MAX_LEVELS)
    return axis.levelled(value["levels"])


REQUIRED = ("pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll")
# unit and range of every variable; the names are keys of a contact file, or ratios that exist in plans only
VARIABLES: dict[str, ValueRange] = {
    **{name: POINT[name] for name in (*REQUIRED, "speed_sliding_lengthwise")},
    "lengthwise_to_roll": POINT["slide_to_roll"],
    "temperature_oil": POINT["temperature_oil"],
    **dict.fromkeys(("roughness_rms", "roughness_rms_1", "roughness_rms_2"), POINT["roughness_rms"]),
    **{name: POINT[name] for name in ("correlation_length", "peklenik_number")},
    **{name: value_range_of(SurfaceInput, name) for name in ("boundary_film", "boundary_friction")},
    "viscosity_inlet": value_range(Viscosity),
    "pressure_viscosity": value_range(PressureViscosity),
    "eyring_stress": value_range(Stress),
}
EXCLUSIVE = (
    ("lengthwise_to_roll", "speed_sliding_lengthwise"),
    ("roughness_rms", "roughness_rms_1"),
    ("roughness_rms", "roughness_rms_2"),
)


def _read_each(
    value: Any, quantities: Mapping[str, ValueRange], read: Callable[[Any, ValueRange], Any]
) -> dict[str, Any]:
    """Entries of a table in the order of the quantities; `InputError` for all wrong ones together."""
    if not isinstance(value, dict):
        raise InputError("", value, "a table")
    found, problems = {}, list[InputError]()
    for name, entry in value.items():
        try:
            if name not in quantities:
                raise InputError("", entry, "one of " + ", ".join(quantities), near(name, quantities))
            found[name] = read(entry, quantities[name])
        except InputError as error:
            for p in error.problems:
                problems.append(InputError(f"{name}.{p.field}".rstrip("."), p.value, p.allowed, p.hint))
    if problems:
        raise InputError.of(problems)
    return {name: found[name] for name in quantities if name in found}


Variables = Annotated[dict[str, PlanAxis], BeforeValidator(partial(_read_each, quantities=VARIABLES, read=_read_axis))]
"""The variables of a plan; omitted variables keep the default of the case."""


class ConstraintWindow(InputModel):
    """Allowed range of a quantity, from `low` to `high`; None means no limit."""

    low: float | None = None
    high: float | None = None

    def holds(self, values: FloatArray) -> NDArray[np.bool_]:
        """Whether each value lies inside."""
        low, high = -np.inf if self.low is None else self.low, np.inf if self.high is None else self.high
        return (values >= low) & (values <= high)


def _read_window(value: Any, quantity: ValueRange) -> ConstraintWindow:
    if isinstance(value, ConstraintWindow):
        return value
    if not isinstance(value, dict) or not value:
        raise InputError("low", None, "a table with low, high or both")
    unknown = sorted(set(value) - {"low", "high"})
    if unknown:
        raise InputError(unknown[0], value[unknown[0]], "low and high")
    low, high = read_ends(value, quantity)
    return ConstraintWindow(low=low, high=high)


# units and allowed values of the constrained quantities
WINDOWS = {
    "film_ratio": ValueRange("", ge=0.0),  # lambda by the film formula of `regression.friction.conditions.derive` [-]
    "load_per_length": value_range(LoadPerLength),  # w' [N/m]
    "half_width": ValueRange("m", ge=0.0, le=1.0),  # Hertz half-width b [m]
    "correlation_over_width": ValueRange("", ge=0.0),  # correlation length over b [-]
    "correlation_over_rms": ValueRange("", ge=0.0),  # correlation length over the composite Rq [-]
    "speed_sliding": ValueRange("m/s", ge=0.0, le=value_range(SlidingSpeed).le),  # length of the sliding vector [m/s]
    "slide_to_roll_total": ValueRange("", ge=0.0),  # sliding speed over the entrainment speed [-]
    "pressure_velocity": ValueRange("W/m^2", ge=0.0),  # p_h times `speed_sliding` [W/m^2]
    # oil temperature plus Blok's flash temperature with mu = 0.05 [K]
    "temperature_flash": ValueRange("K", ge=TEMPERATURE_RANGE[0], le=3000.0),
}

Constraints = Annotated[
    dict[str, ConstraintWindow], BeforeValidator(partial(_read_each, quantities=WINDOWS, read=_read_window))
]
"""Windows that every point must satisfy."""


def constrained_quantities(
    table: Mapping[str, FloatArray], bodies: tuple[Material, Material], film_ratio: FloatArray | None
) -> dict[str, FloatArray]:
    """The quantities of `Constraints` at every point of a table of state columns.

    table: pressure_hertz, radius_equivalent, effective_modulus, speed_entrainment, slide_to_roll,
        speed_sliding_lengthwise, temperature_oil, roughness_rms_1, roughness_rms_2, correlation_length; arrays of one
        shape.
    film_ratio: lambda; None if no constraint uses it.
    """
    pressure, radius, speed = table["pressure_hertz"], table["radius_equivalent"], table["speed_entrainment"]
    half_width = half_width_of_pressure(pressure, radius, table["effective_modulus"])
    load = hertz_load(pressure, radius, table["effective_modulus"])
    ratio = table["slide_to_roll"]
    sliding = np.hypot(ratio * speed, table["speed_sliding_lengthwise"])
    rough = np.maximum(np.hypot(table["roughness_rms_1"], table["roughness_rms_2"]), MIN_ROUGHNESS)
    motions = (1.0 + 0.5 * ratio, 1.0 - 0.5 * ratio)
    carried = sum(b.thermal_effusivity * np.sqrt(np.abs(speed * m)) for b, m in zip(bodies, motions, strict=True))
    rise = blok_1937(FLASH_FRICTION * load * sliding, half_width, np.asarray(carried))
    quantities = {
        "load_per_length": load,
        "half_width": half_width,
        "correlation_over_width": table["correlation_length"] / half_width,
        "correlation_over_rms": table["correlation_length"] / rough,
        "speed_sliding": sliding,
        "slide_to_roll_total": sliding / speed,
        "pressure_velocity": pressure * sliding,
        "temperature_flash": table["temperature_oil"] + rise,
    }
    return quantities if film_ratio is None else {**quantities, "film_ratio": film_ratio}


# maps values of the sampled variables and numbers of the points to a mask of accepted points
Accept = Callable[[dict[str, FloatArray], IntArray], NDArray[np.bool_]]

MAX_DRAWN = 64  # largest length of a Sobol sequence with constraints, over the requested size


@dataclass(frozen=True)
class PointBlock:
    """Points of one origin."""

    origin: str  # sobol, latin, corner, lattice or table
    columns: dict[str, FloatArray]  # values of every variable, SI
    number: IntArray  # of each point in its sequence, including rejected points; it determines the roughness seed


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

    def inside(self, size: int, accept: Accept) -> PointBlock:
        """`size` points that satisfy the constraints.

        A Sobol sequence continues until there are enough points. A Latin hypercube cannot be continued, so that
        rejected points are lost.

        Raises `InputError`: the constraints accept less than 1/64 of the points.
        """
        dimension, random = len(self.ranges), np.random.default_rng(self.seed)
        if self.method == "latin_hypercube":
            columns = self.columns(np.asarray(qmc.LatinHypercube(dimension, rng=random).random(size)))
            return filtered("latin", columns, np.arange(size), accept)
        engine = qmc.Sobol(dimension, scramble=True, rng=random)
        chunk = 1 << (size - 1).bit_length() if size > 1 else 1
        parts, found, drawn = list[PointBlock](), 0, 0
        while found < size:
            if drawn >= MAX_DRAWN * max(size, 64):
                hint = "Widen the windows, or narrow the ranges."
                raise InputError("constraints", f"{found} of {drawn} points inside", "windows that accept 1/64", hint)
            number = np.arange(drawn, drawn + chunk)
            # chunks of a power of two keep the balance of the sequence
            part = filtered("sobol", self.columns(np.asarray(engine.random(chunk))), number, accept)
            parts.append(part)
            found, drawn = found + part.number.size, drawn + chunk
        columns = {name: np.concatenate([part.columns[name] for part in parts])[:size] for name in self.ranges}
        number = np.concatenate([part.number for part in parts])[:size]
        return PointBlock("sobol", columns, number)

    def corners(self, count: int | None, accept: Accept) -> PointBlock:
        """At most `count` corners of the box that satisfy the constraints."""
        unit = corner_unit(len(self.ranges), count, self.seed)
        block = filtered("corner", self.columns(unit), np.arange(len(unit)), accept)
        columns = {name: column[:count] for name, column in block.columns.items()}
        return PointBlock("corner", columns, block.number[:count])


def filtered(origin: str, columns: dict[str, FloatArray], number: IntArray, accept: Accept) -> PointBlock:
    """A block of the accepted points."""
    inside = accept(columns, number)
    return PointBlock(origin, {name: column[inside] for name, column in columns.items()}, number[inside])
