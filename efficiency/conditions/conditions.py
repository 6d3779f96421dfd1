"""Operating conditions of a gear pair: names, units and ranges, and the friction model."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence, Sized
from dataclasses import dataclass, replace
from typing import Any, TypedDict, get_args

from pydantic import BaseModel

from efficiency.contact.gear_flanks import Side
from efficiency.design.design import MISALIGNMENTS, MemberInput, Misalignment, PairDesign
from efficiency.loss.efficiency_result import Bulk, LoadBalance
from efficiency.loss.kinematics import OPERATION_LIMITS, TEXTURE, Driver, Operation
from ehl.common.errors import InputError, check_choice
from ehl.common.quantities import Quantity, quantities
from ehl.common.units import ValueRange, is_list
from ehl.common.validation import value_range_of
from ehl.fluid.oil import Oil
from regression.formula import ANY_OIL, friction_model, shipped_formulas
from regression.friction.models import FrictionModel

# sorted by the computing time of a change, the largest first
GEOMETRY_AXES = ("design", "side", *MISALIGNMENTS)
AXES = (
    *(*GEOMETRY_AXES, "torque", "oil", "speed", "temperature", "driver"),
    *("roughness_rms_each", "roughness_rms_pinion", "roughness_rms_gear", "correlation_length", "peklenik_number"),
)
QUANTITIES: dict[str, ValueRange] = {
    **OPERATION_LIMITS,
    **{name: value_range_of(MemberInput, "roughness_rms") for name in AXES if name.startswith("roughness_rms")},
    **TEXTURE,
    **{name: value_range_of(Misalignment, name) for name in MISALIGNMENTS},
}
_WORDS: dict[str, tuple[str, ...]] = {
    "side": get_args(Side),
    "driver": get_args(Driver),
    "load_balance": get_args(LoadBalance),
    "bulk": get_args(Bulk),
}

MAX_POINTS = 200_000  # operating points of a map, a grid or a study
Friction = FrictionModel | str
Value = float | str
Values = Value | Sequence[Value]


class HeldValues(TypedDict, total=False):
    """Keywords of conditions other than speed and temperature: numbers in SI units, or text with a unit."""

    oil: str | Oil
    driver: Driver
    roughness_rms_each: Value
    roughness_rms_pinion: Value
    roughness_rms_gear: Value
    correlation_length: Value
    peklenik_number: Value
    load_balance: LoadBalance | None
    bulk: Bulk | None


class ConditionValues(HeldValues, total=False):
    """Keywords of one operating condition of a loaded mesh."""

    speed: Value
    temperature: Value


class PairConditionValues(ConditionValues, total=False):
    """Keywords of one condition of a gear pair, including flanks, torque and misalignment."""

    side: Side
    torque: Value
    E: Value
    P: Value
    G: Value
    shaft_angle_error: Value


class MeshAxes(TypedDict, total=False):
    """Keywords of conditions of a mesh, each with one or several values."""

    torque: Values
    speed: Values
    temperature: Values
    oil: str | Oil | Sequence[str | Oil]
    driver: Driver | Sequence[Driver]
    roughness_rms_each: Values
    roughness_rms_pinion: Values
    roughness_rms_gear: Values
    correlation_length: Values
    peklenik_number: Values
    load_balance: LoadBalance | None
    bulk: Bulk | None


class PairAxes(MeshAxes, total=False):
    """Keywords of conditions of a gear pair, each with one or several values."""

    design: Any
    side: Side | Sequence[Side]
    E: Values
    P: Values
    G: Values
    shaft_angle_error: Values


@dataclass(frozen=True)
class Conditions:
    """Operating conditions of a loaded mesh."""

    operation: Operation  # speed, oil temperature, roughness and texture of the flanks, driving member
    oil: Oil
    load_balance: LoadBalance = "frictional"  # forces in the torque balance: normal and friction, or only normal ones
    bulk: Bulk = "estimate"  # bulk temperature of the teeth: estimated from the loss, or the oil temperature

    @classmethod
    def of(cls, design: PairDesign, given: Mapping[str, Any]) -> Conditions:
        """Conditions from the keywords of `ConditionValues`; those of the design if not given or None.

        Raises `InputError`: an unknown name or an invalid value.
        """
        values: dict[str, Any] = {}
        for name, value in given.items():
            refuse_composite(name, value)
            check_choice("condition", name, sorted(ConditionValues.__optional_keys__))
            if value is not None:
                values[name] = checked(name, value)
        options = {name: values.pop(name) for name in ("load_balance", "bulk") if name in values}
        oil = values.pop("oil", design.operation.oil)
        if "roughness_rms_each" in values:
            each = values.pop("roughness_rms_each")
            values = {"roughness_rms_pinion": each, "roughness_rms_gear": each} | values
        own = design.running(design.operation.speed, design.operation.temperature, design.operation.driver)
        return cls(replace(own, **values), oil if isinstance(oil, Oil) else Oil.load(oil), **options)


def level_quantity(name: str) -> Quantity:
    """Quantity of a condition: misalignments by their letters, the roughness that of each flank."""
    known = quantities()
    return known.get(f"misalignment.{name}") or known[name]


def checked(name: str, value: Any) -> Any:
    """A condition in SI units.

    Raises `InputError`: a text without its unit, a value out of range, or an unknown option.
    """
    if name in QUANTITIES:
        return QUANTITIES[name].check_given(value, name)
    if name in _WORDS:
        word = str(value).casefold()
        check_choice(name, word, _WORDS[name])
        return word
    if name == "oil" and isinstance(value, str):
        Oil.load(value)
    return value


def axis_values(name: str, values: Any, limits: ValueRange | None = None) -> list[Any]:
    """Values of an axis in SI units.

    name: one of `AXES`.
    values: numbers in SI units, texts with a unit, a list ``"a, b, c unit"`` or a range ``"from:to:number unit"``.
    limits: range of the values instead of that of `QUANTITIES`.
    Raises `InputError`: an invalid format or a value out of range.
    """
    refuse_composite(name, values)
    limits = limits or QUANTITIES.get(name)
    if limits is not None and isinstance(values, str):
        return list(limits.check_list(values, name))
    given = list(values) if _several(name, values) else [values]
    check_size({name: given})
    return [checked(name, value) if limits is None else limits.check_given(value, name) for value in given]


def check_size(axes: Mapping[str, Sized]) -> None:
    """Raise an `InputError` for an axis without values, and for more than `MAX_POINTS` combinations."""
    for name, values in axes.items():
        if not len(values):
            raise InputError(name, "no value", "at least one value")
    count = math.prod(map(len, axes.values()))
    if count > MAX_POINTS:
        raise InputError(", ".join(axes), f"{count} operating points", f"at most {MAX_POINTS}")


def split_axes(given: Mapping[str, Any], allowed: Sequence[str] = AXES) -> tuple[dict[str, list[Any]], dict[str, Any]]:
    """Axes with lists of values, and conditions with one value; all in SI units.

    Raises `InputError`: an unknown axis or an invalid value.
    """
    axes: dict[str, list[Any]] = {}
    held: dict[str, Any] = {}
    for name, value in given.items():
        refuse_composite(name, value)
        if name in ("load_balance", "bulk"):
            held[name] = None if value is None else checked(name, value)
            continue
        check_choice("axis", name, allowed)
        if _several(name, value):
            axes[name] = axis_values(name, value)
        else:
            held[name] = checked(name, value)
    if "roughness_rms_each" in given and {"roughness_rms_pinion", "roughness_rms_gear"} & given.keys():
        raise InputError("roughness_rms_each", given["roughness_rms_each"], "not together with that of one member")
    return axes, held


def _several(name: str, value: Any) -> bool:
    if isinstance(value, str):
        return name in QUANTITIES and is_list(value)
    return isinstance(value, Iterable) and not isinstance(value, BaseModel)


def refuse_composite(name: str, value: Any) -> None:
    """Raise an `InputError` for `roughness_rms`, the composite Rq; gears need the Rq of each flank."""
    if name == "roughness_rms":
        allowed = "roughness_rms_each (Rq of both flanks), or roughness_rms_pinion and roughness_rms_gear"
        raise InputError(name, value, allowed, "roughness_rms is the composite Rq of two surfaces.")


def default_friction(oil: str) -> str:
    """The formula shipped for an oil; otherwise the one fitted to all shipped oils."""
    shipped = shipped_formulas(oil)
    return shipped[0] if shipped else ANY_OIL


def resolve_friction(friction: Friction | None, design: PairDesign, oil: Any = None) -> FrictionModel:
    """Friction model from a model, a fitted formula, or a name.

    friction: solved contacts (``ehl``, ``ehl:smooth``...) or any name of `regression.friction_model`; default:
        `default_friction` of the oil.
    design: design with the materials of both members and the oil.
    oil: oil instead of that of the design; the first one of a list.
    """
    if friction is None:
        first = design.operation.oil if oil is None else oil
        first = next(iter(first)) if isinstance(first, (list, tuple)) else first
        friction = default_friction(str(getattr(first, "name", first)).partition(",")[0].strip())
    if isinstance(friction, FrictionModel):
        return friction
    friction = str(friction)
    if friction.partition(":")[0] == "ehl":
        from efficiency.loss.ehl_friction import ehl_friction

        bodies = design.pinion.elastic_material(), design.gear.elastic_material()
        return ehl_friction(friction, bodies, design.surface_skewness())
    return friction_model(friction)
