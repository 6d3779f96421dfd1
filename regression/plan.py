"""The plan of a sweep: which contacts are solved (`mixed-ehl sweep PLAN.toml`).

A variable is a range (sampled by Sobol), a list (full factorial) or one value; lists multiply the sampled points.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from functools import cached_property, partial
from pathlib import Path
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import BeforeValidator, Field, model_validator

from ehl import inputs as case_inputs
from ehl.errors import InputError
from ehl.inputs import Case, ModelInput, SolidInput, SurfaceInput
from ehl.oil import Temperature
from ehl.units import Quantity
from ehl.validation import InputModel, read_toml, validate

MAX_CASES = 1_000_000
MAX_LEVELS = 1000
# 2^d corner points; beyond this a plan asks for more corners than samples
MAX_CORNER_VARIABLES = 10


class Axis(InputModel):
    """One variable of a plan: a sampled range, or the values it takes."""

    values: tuple[float, ...]
    sampled: bool = False
    scale: Literal["linear", "log"] = "linear"


def _quantity(annotation: Any) -> Quantity:
    return next(part for part in get_args(annotation)[1:] if isinstance(part, Quantity))


def _read_axis(value: Any, quantity: Quantity) -> Axis:
    """The axis a user wrote: a value, a list, or a table with low, high and scale."""
    if isinstance(value, Axis):
        return value
    if isinstance(value, list):
        if not 1 <= len(value) <= MAX_LEVELS:
            raise InputError("values", f"list of {len(value)}", f"a list of 1 to {MAX_LEVELS} values")
        values = tuple(quantity.check(item, f"values[{i}]") for i, item in enumerate(value))
        if len(set(values)) < len(values):
            raise InputError("values", value, "a list of different values")
        return Axis(values=values)
    if not isinstance(value, dict):
        return Axis(values=(quantity.check(value, "value"),))
    unknown = sorted(set(value) - {"low", "high", "scale"})
    if unknown:
        raise InputError(unknown[0], value[unknown[0]], "low, high and scale")
    low, high = (quantity.check(value[key], key) if key in value else None for key in ("low", "high"))
    if low is None or high is None:
        raise InputError("low" if low is None else "high", None, "both ends of the range")
    scale = value.get("scale", "linear")
    if scale not in ("linear", "log"):
        raise InputError("scale", scale, "linear or log")
    if not low < high:
        raise InputError(
            "high", value["high"], f"above low = {value['low']!r}", "For one value write it without table."
        )
    if scale == "log" and low <= 0.0:
        raise InputError("low", value["low"], "above zero with scale = 'log'")
    return Axis(values=(low, high), sampled=True, scale=scale)


def _axis(annotation: Any) -> Any:
    return Annotated[Axis, BeforeValidator(partial(_read_axis, quantity=_quantity(annotation)))]


class Variables(InputModel):
    """The variables of a plan; what is not given keeps the default of the case."""

    pressure_hertz: _axis(case_inputs.Pressure)  # type: ignore[valid-type]
    radius_equivalent: _axis(case_inputs.Radius)  # type: ignore[valid-type]
    speed_entrainment: _axis(case_inputs.Speed)  # type: ignore[valid-type]
    slide_to_roll: _axis(case_inputs.SlideToRoll)  # type: ignore[valid-type]
    speed_sliding_lengthwise: _axis(case_inputs.SlidingSpeed) | None = None  # type: ignore[valid-type]
    lengthwise_to_roll: _axis(case_inputs.SlideToRoll) | None = None  # type: ignore[valid-type]
    temperature_oil: _axis(Temperature) | None = None  # type: ignore[valid-type]
    roughness_rms: _axis(case_inputs.Rms) | None = None  # type: ignore[valid-type]
    roughness_rms_1: _axis(case_inputs.Rms) | None = None  # type: ignore[valid-type]
    roughness_rms_2: _axis(case_inputs.Rms) | None = None  # type: ignore[valid-type]
    viscosity_inlet: _axis(case_inputs.Viscosity) | None = None  # type: ignore[valid-type]
    pressure_viscosity: _axis(case_inputs.PressureViscosity) | None = None  # type: ignore[valid-type]
    eyring_stress: _axis(case_inputs.Stress) | None = None  # type: ignore[valid-type]

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        for one, other in (
            ("lengthwise_to_roll", "speed_sliding_lengthwise"),
            ("roughness_rms", "roughness_rms_1"),
            ("roughness_rms", "roughness_rms_2"),
        ):
            if getattr(self, one) is not None and getattr(self, other) is not None:
                raise InputError(one, "given", f"only one of {one} and {other}")
        return self

    @cached_property
    def axes(self) -> dict[str, Axis]:
        """The variables given, in the order of this class."""
        given = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: axis for name, axis in given.items() if axis is not None}


class Sampling(InputModel):
    """How ranges are filled: a scrambled Sobol sequence, and the corners of the box if wanted."""

    size: Annotated[int, Field(ge=1, le=MAX_CASES)] | None = None
    seed: Annotated[int, Field(ge=0)] = 1
    corners: bool = False


class Plan(InputModel):
    """A sweep: the content of a plan file."""

    name: str = Field(min_length=1, max_length=100)
    description: str = ""
    sampling: Sampling = Sampling()
    variables: Variables
    lubricant: dict[str, Any]
    solid_1: SolidInput = SolidInput()
    solid_2: SolidInput = SolidInput()
    effective_modulus: case_inputs.Modulus | None = None
    surface: SurfaceInput = SurfaceInput()
    model: ModelInput = ModelInput()

    @model_validator(mode="after")
    def _whole(self) -> Self:
        axes = self.variables.axes
        sampled = [name for name, axis in axes.items() if axis.sampled]
        if sampled and self.sampling.size is None:
            raise InputError("sampling.size", None, "the number of Sobol points for " + ", ".join(sampled))
        size = self.sampling.size
        if size is not None and not sampled:
            raise InputError("sampling.size", size, "no size where no variable is a range")
        if size is not None and size & (size - 1):
            below = 1 << (size.bit_length() - 1)
            raise InputError("sampling.size", size, f"a power of two such as {below} or {2 * below}")
        if self.sampling.corners and not 1 <= len(sampled) <= MAX_CORNER_VARIABLES:
            raise InputError(
                "sampling.corners", True, f"1 to {MAX_CORNER_VARIABLES} ranges; this plan has {len(sampled)}"
            )
        if self.count > MAX_CASES:
            raise InputError("variables", f"{self.count} cases", f"at most {MAX_CASES} cases")
        for name in set(self.lubricant) & set(axes):
            raise InputError(f"lubricant.{name}", self.lubricant[name], f"either lubricant.{name} or variables.{name}")
        if "oil" in self.lubricant and "temperature_oil" not in {*self.lubricant, *axes}:
            raise InputError("variables.temperature_oil", None, "the oil temperature, a value or a range")
        for name in ("roughness_rms_1", "roughness_rms_2", "profile_1", "profile_2"):
            if name in self.surface.model_fields_set:
                allowed = "roughness_rms, roughness_rms_1 or roughness_rms_2 of [variables]"
                raise InputError(f"surface.{name}", getattr(self.surface, name), allowed)
        # both ends of every axis go through the case model, so that a bad plan fails before the sweep
        for end in (0, -1):
            self.case({name: axis.values[end] for name, axis in axes.items()})
        return self

    @cached_property
    def count(self) -> int:
        """Number of cases."""
        axes = self.variables.axes.values()
        sampled = sum(axis.sampled for axis in axes)
        points = (self.sampling.size or 1) + (2**sampled if self.sampling.corners else 0)
        for axis in axes:
            points *= 1 if axis.sampled else len(axis.values)
        return points

    @property
    def plan_hash(self) -> str:
        """Hash of everything that decides the cases and their results."""
        content = self.model_dump(mode="json", exclude={"name", "description"})
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    @property
    def oil(self) -> str | None:
        """Name of the oil card; None where the lubricant is given by numbers."""
        return self.lubricant.get("oil")

    def points(self) -> Iterator[tuple[str, dict[str, float]]]:
        """Origin (sobol, corner, lattice) and values of every case, in a fixed order."""
        from regression.sampling import plan_points

        return plan_points(self.variables.axes, self.sampling.size, self.sampling.seed, self.sampling.corners)

    def cases(self) -> Iterator[tuple[str, Case]]:
        """Origin and case of every point of the plan, in a fixed order."""
        for origin, values in self.points():
            yield origin, self.case(values)

    def case(self, values: dict[str, float]) -> Case:
        """The case at one point.

        Raises
        ------
        InputError
            A fixed figure of the plan is not one a case accepts.
        """
        v = dict(values)
        along = v.pop("lengthwise_to_roll", None)
        if along is not None:
            v["speed_sliding_lengthwise"] = along * v["speed_entrainment"]
        composite = v.pop("roughness_rms", None)
        if composite is not None:
            v["roughness_rms_1"] = v["roughness_rms_2"] = composite / 2.0**0.5
        tables: dict[str, dict[str, Any]] = {
            "contact": {},
            "lubricant": dict(self.lubricant),
            "surface": self.surface.model_dump(exclude_unset=True),
        }
        for name, value in v.items():
            tables[_TABLE_OF[name]][name] = value
        if self.effective_modulus is not None:
            tables["contact"]["effective_modulus"] = self.effective_modulus
        bodies = {"solid_1": self.solid_1, "solid_2": self.solid_2, "model": self.model}
        return validate(Case, {**tables, **bodies})


_TABLE_OF = {
    "pressure_hertz": "contact",
    "radius_equivalent": "contact",
    "speed_entrainment": "contact",
    "slide_to_roll": "contact",
    "speed_sliding_lengthwise": "contact",
    "temperature_oil": "lubricant",
    "viscosity_inlet": "lubricant",
    "pressure_viscosity": "lubricant",
    "eyring_stress": "lubricant",
    "roughness_rms_1": "surface",
    "roughness_rms_2": "surface",
}


def load_plan(path: str | Path) -> Plan:
    """Read and check a plan file; the name of a shipped plan (``demo``) serves too.

    Raises
    ------
    InputError
        Naming field, value and allowed range.
    """
    from ehl._data import data_names, data_path

    if str(path) in data_names("plans"):
        path = data_path("plans", f"{path}.toml")
    return validate(Plan, read_toml(path))
