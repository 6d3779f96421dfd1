"""Constraints of a plan: combinations of its variables that do not occur in gears are skipped.

Each is a window on one quantity that follows from a point by a closed formula.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator

from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel
from ehl.fluid.viscosity import TEMPERATURE_RANGE
from ehl.inputs import LoadPerLength, SlidingSpeed
from ehl.line_contact import half_width_of_pressure, hertz_load
from ehl.material import Material
from regression.friction.conditions import MIN_ROUGHNESS
from regression.plan.axes import read_ends, value_range_of

FLASH_FRICTION = 0.05  # friction coefficient of the flash temperature constraint (Coleman's constant)


class ConstraintWindow(InputModel):
    """Allowed range of a quantity, from `low` to `high`; None means no limit."""

    low: float | None = None
    high: float | None = None

    def holds(self, values: FloatArray) -> NDArray[np.bool_]:
        """Whether each value lies inside."""
        inside = np.ones(values.shape, dtype=bool)
        if self.low is not None:
            inside &= values >= self.low
        if self.high is not None:
            inside &= values <= self.high
        return inside


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


def _window(quantity: ValueRange) -> Any:
    return Annotated[ConstraintWindow, BeforeValidator(partial(_read_window, quantity=quantity))]


class Constraints(InputModel):
    """Windows that every point must satisfy."""

    # lambda by the film formula of `regression.friction.conditions.derive` [-]
    film_ratio: _window(ValueRange("", ge=0.0)) | None = None  # type: ignore[valid-type]
    # w' [N/m]
    load_per_length: _window(value_range_of(LoadPerLength)) | None = None  # type: ignore[valid-type]
    # Hertz half-width b [m]
    half_width: _window(ValueRange("m", ge=0.0, le=1.0)) | None = None  # type: ignore[valid-type]
    # correlation length over b and over the composite Rq [-]
    correlation_over_width: _window(ValueRange("", ge=0.0)) | None = None  # type: ignore[valid-type]
    correlation_over_rms: _window(ValueRange("", ge=0.0)) | None = None  # type: ignore[valid-type]
    # length of the sliding vector [m/s]
    speed_sliding: _window(ValueRange("m/s", ge=0.0, le=value_range_of(SlidingSpeed).le)) | None = None  # type: ignore[valid-type]
    # sliding speed over the entrainment speed [-]
    slide_to_roll_total: _window(ValueRange("", ge=0.0)) | None = None  # type: ignore[valid-type]
    # p_h times `speed_sliding` [W/m^2]
    pressure_velocity: _window(ValueRange("W/m^2", ge=0.0)) | None = None  # type: ignore[valid-type]
    # oil temperature plus Blok's flash temperature with mu = 0.05 [K]
    temperature_flash: _window(ValueRange("K", ge=TEMPERATURE_RANGE[0], le=3000.0)) | None = None  # type: ignore[valid-type]

    @property
    def windows(self) -> dict[str, ConstraintWindow]:
        """The windows given."""
        given = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: window for name, window in given.items() if window is not None}

    @property
    def need_oil(self) -> bool:
        """Whether a constraint depends on properties of the oil."""
        return self.film_ratio is not None


def flash_temperature_blok(
    load: FloatArray,
    sliding: FloatArray,
    speed: FloatArray,
    slide_to_roll: FloatArray,
    half_width: FloatArray,
    bodies: tuple[Material, Material],
) -> FloatArray:
    """Largest flash temperature rise of a band contact with mu = `FLASH_FRICTION` [K].

    1.11 mu w' |v_s| / ((e1 sqrt|u1| + e2 sqrt|u2|) sqrt(2 b)), e the thermal effusivity (Blok 1963, fast moving
    sources; for equal bodies the well-known form with sqrt(u1) - sqrt(u2)). A surface at rest takes no heat.
    """
    u1, u2 = np.abs(speed * (1.0 + 0.5 * slide_to_roll)), np.abs(speed * (1.0 - 0.5 * slide_to_roll))
    e1, e2 = (body.thermal_effusivity for body in bodies)
    return np.asarray(
        1.11 * FLASH_FRICTION * load * sliding / ((e1 * np.sqrt(u1) + e2 * np.sqrt(u2)) * np.sqrt(2.0 * half_width))
    )


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
    rise = flash_temperature_blok(load, sliding, speed, ratio, half_width, bodies)
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
