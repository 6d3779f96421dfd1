"""Operating conditions of a gear pair: their names, units and ranges, and the friction model they are computed with."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypedDict

from pydantic import BaseModel

from efficiency.contact.gear_flanks import Side
from efficiency.design.design import MemberInput, Misalignment, PairDesign
from efficiency.loss.efficiency_result import Bulk, LoadBalance
from efficiency.loss.kinematics import OPERATION_LIMITS, TEXTURE, Driver, Operation
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import value_range_of
from ehl.fluid.oil import Oil
from regression.formula import ANY_OIL, friction_model, shipped_formulas
from regression.friction.models import FrictionModel

MISALIGNMENTS = tuple(Misalignment.model_fields)
# from the one that costs most to change to the one that costs least
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
    "side": ("drive", "coast"),
    "driver": ("pinion", "gear"),
    "load_balance": ("frictional", "frictionless"),
    "bulk": ("estimate", "oil"),
}

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
    """Keywords of one condition of a gear pair: flanks, torque and misalignment as well."""

    side: Side
    torque: Value
    E: Value
    P: Value
    G: Value
    shaft_angle_error: Value


class MeshAxes(TypedDict, total=False):
    """Keywords of conditions of a mesh, each one value or several."""

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
    """Keywords of conditions of a gear pair, each one value or several."""

    design: Any
    side: Side | Sequence[Side]
    E: Values
    P: Values
    G: Values
    shaft_angle_error: Values


@dataclass(frozen=True)
class Conditions:
    """Operating conditions of a loaded mesh, SI units; None leaves a condition to the design.

    Parameters
    ----------
    speed : float, optional
        Of the pinion [rad/s].
    temperature : float, optional
        Of the oil [K].
    oil : str or Oil, optional
        Name of a card, or the card.
    driver : {"pinion", "gear"}, optional
        Member the power comes from.
    roughness_rms_pinion, roughness_rms_gear : float, optional
        Rq of the flanks [m].
    correlation_length, peklenik_number : float, optional
        Texture of the flanks [m], [-].
    load_balance : {"frictional", "frictionless"}, optional
        Whether friction helps to carry the torque (default), or the normal forces carry it alone, as in the paper.
        Forces of a file are taken as they are.
    bulk : {"estimate", "oil"}, optional
        Bulk temperature of the teeth: estimated from the loss (default), or that of the oil.
    """

    speed: float | None = None
    temperature: float | None = None
    oil: str | Oil | None = None
    driver: Driver | None = None
    roughness_rms_pinion: float | None = None
    roughness_rms_gear: float | None = None
    correlation_length: float | None = None
    peklenik_number: float | None = None
    load_balance: LoadBalance | None = None
    bulk: Bulk | None = None

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Conditions:
        """Conditions from the keywords of `ConditionValues`.

        Raises
        ------
        InputError
            An unknown name, or a value that cannot be used.
        """
        known = [*(f.name for f in fields(cls)), "roughness_rms_each"]
        values: dict[str, Any] = {}
        for name, value in given.items():
            refuse_composite(name, value)
            if name not in known:
                raise InputError("condition", name, "one of " + ", ".join(sorted(known)))
            if value is not None:
                values[name] = checked(name, value)
        both = values.pop("roughness_rms_each", None)
        each = {} if both is None else {"roughness_rms_pinion": both, "roughness_rms_gear": both}
        return cls(**each | values)

    def card(self, design: PairDesign) -> Oil:
        """The oil card."""
        oil = self.oil or design.operation.oil
        return oil if isinstance(oil, Oil) else Oil.load(oil)

    def operation(self, design: PairDesign) -> Operation:
        """How a design runs under them."""
        own = design.running(design.operation.speed, design.operation.temperature, design.operation.driver)
        names = [f.name for f in fields(self) if f.name not in ("oil", "load_balance", "bulk")]
        return replace(own, **{name: getattr(self, name) for name in names if getattr(self, name) is not None})


def checked(name: str, value: Any) -> Any:
    """A condition in SI units.

    Raises
    ------
    InputError
        A text without its unit, a value out of range, an unknown word.
    """
    if name in QUANTITIES:
        return QUANTITIES[name].check(value, name, bare=not isinstance(value, str))
    if name in _WORDS and value not in _WORDS[name]:
        raise InputError(name, value, " or ".join(_WORDS[name]))
    if name == "oil" and isinstance(value, str):
        Oil.load(value)
    return value


def axis_values(name: str, values: Any) -> list[Any]:
    """Values of an axis in SI units.

    Parameters
    ----------
    name : str
        One of `AXES`.
    values : float, str or sequence
        Numbers in SI units, texts with a unit, a list ``"a, b, c unit"`` or a range ``"from:to:number unit"``.

    Raises
    ------
    InputError
        None of these, or a value out of range.
    """
    refuse_composite(name, values)
    if name in QUANTITIES and isinstance(values, str):
        return list(QUANTITIES[name].check_list(values, name))
    return [checked(name, value) for value in (values if _several(name, values) else [values])]


def split_axes(given: Mapping[str, Any], allowed: Sequence[str] = AXES) -> tuple[dict[str, list[Any]], dict[str, Any]]:
    """Axes, which have a list of values, and conditions with one value; all in SI units.

    Raises
    ------
    InputError
        An unknown axis, a value that cannot be used.
    """
    axes: dict[str, list[Any]] = {}
    held: dict[str, Any] = {}
    for name, value in given.items():
        refuse_composite(name, value)
        if name in ("load_balance", "bulk"):
            held[name] = None if value is None else checked(name, value)
        elif name not in allowed:
            raise InputError("axis", name, "one of " + ", ".join(allowed))
        elif _several(name, value):
            axes[name] = axis_values(name, value)
        else:
            held[name] = checked(name, value)
    if "roughness_rms_each" in given and {"roughness_rms_pinion", "roughness_rms_gear"} & given.keys():
        raise InputError("roughness_rms_each", given["roughness_rms_each"], "not with that of pinion or gear")
    return axes, held


def _several(name: str, value: Any) -> bool:
    if isinstance(value, str):
        return name in QUANTITIES and ("," in value or ":" in value)
    return isinstance(value, Iterable) and not isinstance(value, BaseModel)


def refuse_composite(name: str, value: Any) -> None:
    """`InputError` for `roughness_rms`: the composite Rq of a contact, where gears need that of each flank."""
    if name == "roughness_rms":
        allowed = "roughness_rms_each (Rq of both flanks), or roughness_rms_pinion and roughness_rms_gear"
        raise InputError(name, value, allowed, "roughness_rms is the composite Rq of two surfaces.")


def default_friction(oil: str) -> str:
    """The formula shipped for an oil, else the one fitted to all shipped oils."""
    shipped = shipped_formulas(oil)
    return shipped[0] if shipped else ANY_OIL


def resolve_friction(friction: Friction | None, design: PairDesign, oil: Any = None) -> FrictionModel:
    """A friction model, a fitted formula, or the model of that name.

    Parameters
    ----------
    friction : FrictionModel or str, optional
        Solved contacts (``ehl``, ``ehl:smooth``...) or any name of `regression.friction_model`; `default_friction` of
        the oil if not given.
    design : PairDesign
        Gives the materials of both members and the oil.
    oil : Oil or str, or a list of them, optional
        In place of that of the design; the first of several.
    """
    if friction is None:
        first = design.operation.oil if oil is None else oil
        first = next(iter(first)) if isinstance(first, (list, tuple)) else first
        friction = default_friction(str(getattr(first, "name", first)).partition(",")[0].strip())
    if not isinstance(friction, str):
        return friction
    if friction.partition(":")[0] == "ehl":
        from efficiency.loss.ehl_friction import ehl_friction

        bodies = design.pinion.elastic_material(), design.gear.elastic_material()
        return ehl_friction(friction, bodies, design.surface_skewness())
    return friction_model(friction)
