"""Variables of a plan: a sampled range, the levels of a range, a list, or one value."""

import math
from collections.abc import Callable, Mapping
from functools import cached_property, partial
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, create_model

from ehl.common.errors import InputError, check_count, near
from ehl.common.units import ValueRange, value_range
from ehl.common.validation import InputModel, value_range_of
from ehl.fluid.lubricant_inputs import PressureViscosity, Stress, Viscosity
from ehl.inputs import SurfaceInput
from regression.friction.conditions import POINT

MAX_LEVELS = 1000


class PlanAxis(InputModel):
    """One variable of a plan: a sampled range, or a list of values."""

    values: tuple[float, ...]
    sampled: bool = False
    scale: Literal["linear", "log"] = "linear"


def evenly_spaced(low: float, high: float, scale: str, count: int) -> tuple[float, ...]:
    """Levels from `low` to `high`, both exact; evenly spaced, on a log scale in the logarithm."""
    if scale == "log":
        step = math.log(high / low) / (count - 1)
        inner = (low * math.exp(step * i) for i in range(1, count - 1))
    else:
        inner = (low + (high - low) * i / (count - 1) for i in range(1, count - 1))
    return (low, *inner, high)


def read_ends(value: dict[str, Any], quantity: ValueRange) -> tuple[float | None, float | None]:
    """The ends of a range or window as numbers with low < high; None for an end that is not given."""
    low, high = (quantity.check(value[key], key) if key in value else None for key in ("low", "high"))
    if low is not None and high is not None and not low < high:
        hint = "Exchange the two ends." if low > high else "Give a single value without a table."
        raise InputError("high", value["high"], f"above low = {value['low']!r}", hint)
    return low, high


def _read_axis(value: Any, quantity: ValueRange) -> PlanAxis:
    """An axis from a plan file: a value, a list, or a table with low, high, scale and optionally levels."""
    if isinstance(value, PlanAxis):
        return value
    if isinstance(value, list):
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
    if "levels" not in value:
        return PlanAxis(values=(low, high), sampled=True, scale=scale)
    levels = value["levels"]
    check_count("levels", levels, 2, MAX_LEVELS)
    return PlanAxis(values=evenly_spaced(low, high, scale, levels), scale=scale)


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


def optional_fields(entry: type, read: Callable[..., Any], quantities: Mapping[str, ValueRange]) -> dict[str, Any]:
    """Fields of a model for `create_model`, one for each quantity: an entry that is read by a function, or None."""
    return {
        name: (Annotated[entry, BeforeValidator(partial(read, quantity=quantity))] | None, None)
        for name, quantity in quantities.items()
    }


class _Variables(InputModel):
    @cached_property
    def axes(self) -> dict[str, PlanAxis]:
        """The variables given, in the order of `VARIABLES`."""
        return {name: axis for name, axis in self if axis is not None}


if TYPE_CHECKING:
    Variables = _Variables
else:
    _AXES = optional_fields(PlanAxis, _read_axis, VARIABLES)
    Variables = create_model("Variables", __base__=_Variables, __module__=__name__, **_AXES)
    Variables.__doc__ = "The variables of a plan; omitted variables keep the default of the case."
