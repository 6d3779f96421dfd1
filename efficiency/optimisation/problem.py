"""Optimisation problem: variables of ease-off and blank, figures to minimise or to limit, and states."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import product
from operator import mul
from typing import Any, Literal

import numpy as np

from efficiency.blanks.inputs import DepthTypeTwo, PairBlankInput, PressureAngles
from efficiency.conditions.conditions import level_quantity
from efficiency.conditions.duty import DutyRow
from efficiency.design.design import Misalignment
from efficiency.machine_settings.inputs import FlankTarget, MemberTargets, SettingsInput, Targets
from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError, check_choice
from ehl.common.quantities import Quantity, quantities
from ehl.common.units import ValueRange
from ehl.common.validation import value_range_of

Flanks = Literal["drive", "coast", "both"]
Over = Literal["mean", "worst"]
Bounds = tuple[float, float]

_AMOUNT = value_range_of(FlankTarget, "crowning_toe")
_RELIEF, _LEAST_RELIEF = ValueRange("m", gt=0.0, le=1e-3), 1e-8
# each variable, the keys of a flank target that it sets, and its allowed range
_TARGETS: dict[str, tuple[tuple[str, ...], ValueRange]] = {
    "lengthwise_crowning": (("crowning_toe", "crowning_heel"), _AMOUNT),
    "profile_crowning": (("relief_root", "relief_tip"), _AMOUNT),
    **{
        name: ((name,), value_range_of(FlankTarget, name))
        for name in (
            *("crowning_toe", "crowning_heel", "relief_root", "relief_tip"),
            *("bias", "twist", "contact_face", "contact_depth"),
        )
    },
}
# edges of both members with the relief that a variable sets
_EDGES = {"tip_relief": ("tip",), "end_relief": ("toe", "heel")}
# each variable of the blank and the table of the blank file that holds its key
_BLANK: dict[str, str] = {
    "spiral_angle": "",
    "hypoid_offset": "",
    "cutter_radius": "",
    "pressure_angle_drive": "pressure_angle",
    "pressure_angle_coast": "pressure_angle",
    "gear_addendum_factor": "depth",
    "depth_factor": "depth",
}
VARIABLES: dict[str, ValueRange] = {
    **{name: allowed for name, (_, allowed) in _TARGETS.items()},
    **dict.fromkeys(_EDGES, _RELIEF),
    "spiral_angle": value_range_of(PairBlankInput, "mean_spiral_angle_gear"),
    **{name: value_range_of(PairBlankInput, name) for name in ("hypoid_offset", "cutter_radius")},
    **{f"pressure_angle_{side}": value_range_of(PressureAngles, side) for side in ("drive", "coast")},
    **{name: value_range_of(DepthTypeTwo, name) for name in ("gear_addendum_factor", "depth_factor")},
}
GROUPS = ("ease_off", "blank")
"""Names of groups: the default variables of the ease-off, and those of the blank that the pair has."""
PARTS: dict[str, tuple[str, ...]] = {
    "crowning": (
        *("lengthwise_crowning", "profile_crowning", "crowning_toe", "crowning_heel", "relief_root", "relief_tip"),
        *("contact_face", "contact_depth"),
    ),
    "bias and twist": ("bias", "twist"),
    "edge relief": tuple(_EDGES),
    "blank": tuple(_BLANK),
}
"""Variables by what they change, in the order in which the gain is split."""
# limited by the installation space of the vehicle: varied only if named, not part of a group
_PACKAGE = ("hypoid_offset",)
_DEFAULT = ("lengthwise_crowning", "profile_crowning", "bias", "twist", "contact_face", "contact_depth")

# default bounds: amounts as multiples of the start with a minimum, slopes and positions about the start (this work)
_SHARES, _FLOOR, _RELIEF_SHARES = (0.25, 3.5), {"lengthwise_crowning": 20e-6, "profile_crowning": 6e-6}, (0.25, 3.0)
_BIAS, _PLACE, _MAX_PLACE = 0.8, 0.35, 0.6

# default bounds of the blank (this work): multiples of the start, or a distance to both sides of it
_BLANK_SHARES = {"hypoid_offset": (0.5, 1.1), "cutter_radius": (0.8, 1.4), "depth_factor": (0.85, 1.05)}
_BLANK_REACH = {
    "spiral_angle": math.radians(12.0),
    "pressure_angle_drive": math.radians(4.0),
    "pressure_angle_coast": math.radians(4.0),
    "gear_addendum_factor": 0.12,
}

BOX = {"E": 5e-5, "P": 5e-5}
"""Half widths of the default misalignment box [m]: bearings and housings of an axle (this work)."""
# most half widths of the fractional design of eight corners
_MAX_WIDTHS = 7
_SHIFTS = {name: value_range_of(Misalignment, name) for name in Misalignment.model_fields}

FIGURES = (
    *("power_loss", "pressure_hertz_max", "pressure_flank", "transmission_error_loaded", "edge_load_share"),
    *("root_stress_pinion", "root_stress_gear", "temperature_flash"),
)
"""Possible objectives and limits; all are to be minimised."""
OBJECTIVES = ("power_loss", "pressure_hertz_max", "transmission_error_loaded")
LIMITS = (
    *("pressure_hertz_max", "pressure_flank", "transmission_error_loaded", "edge_load_share"),
    *("root_stress_pinion", "root_stress_gear"),
)
EDGE_FREE = 1e-3
"""Share of the torque at edges that is negligible: threshold of the note of the strength."""

START = "start"


@dataclass(frozen=True)
class Variable:
    """One of `VARIABLES` with its bounds, SI."""

    name: str
    low: float
    high: float

    @property
    def quantity(self) -> Quantity:
        """Label and unit."""
        return variable_quantity(self.name)

    def at(self, place: float) -> float:
        """Value at a position from 0 to 1 between the bounds, rounded to the digits of a design file."""
        return round(self.low + place * (self.high - self.low), 10)

    def at_bound(self, value: float) -> str:
        """The bound within a hundredth of the range of a value; empty inside."""
        share = self.place(value)
        return "lower" if share < 0.01 else "upper" if share > 0.99 else ""

    def place(self, value: float) -> float:
        """Position of a value between the bounds, limited to 0 to 1."""
        return min(max((value - self.low) / (self.high - self.low), 0.0), 1.0)


def variable_quantity(name: str) -> Quantity:
    """Label and unit of a variable."""
    known = quantities()
    return known.get(f"optimise.{name}") or known[name]


def variables_of(
    start: SettingsInput, given: Mapping[str, Any] | Sequence[str] | None, flanks: Flanks
) -> list[Variable]:
    """Variables with their bounds, from names of `VARIABLES` or `GROUPS`, or names with bounds.

    Bounds are two values, a text ``"from:to unit"``, or None for the default bounds. Raises an `InputError` for an
    unknown variable, invalid bounds, or two variables that set the same key.
    """
    named = dict.fromkeys(given) | dict(given if isinstance(given, Mapping) else {}) if given else {"ease_off": None}
    names: dict[str, Any] = {}
    ease_off = [*_DEFAULT, *(edge for edge in _EDGES if _reliefs(start, edge))]
    of_blank = [n for n in _BLANK if n not in _PACKAGE and _stated(start, n)]
    groups = dict(zip(GROUPS, (ease_off, of_blank), strict=True))
    for name, bounds in named.items():
        if name in GROUPS and bounds is not None:
            raise InputError(name, bounds, "no bounds, because it is a group of variables", "List single variables.")
        names |= {one: named.get(one) if one in named else bounds for one in groups.get(name, [name])}
    found: list[Variable] = []
    taken: dict[str, str] = {}
    for name, bounds in names.items():
        if name not in VARIABLES:
            check_choice("variable", name, (*VARIABLES, *GROUPS))
        _take("variable", name, taken)
        if name in _BLANK:
            _blank_value(start, name)
        low, high = _default_bounds(start, name, flanks) if bounds is None else _given_bounds(name, bounds)
        found.append(Variable(name, low, high))
    if not found:
        raise InputError("variables", 0, "at least one of " + ", ".join(VARIABLES))
    return found


def _take(field: str, name: str, taken: dict[str, str]) -> None:
    """Add the keys that a variable sets; an `InputError` if another variable sets one of them."""
    for key in _TARGETS[name][0] if name in _TARGETS else _EDGES.get(name, (name,)):
        if key in taken:
            raise InputError(field, name, f"not together with {taken[key]}, which also sets {key}")
        taken[key] = name


def _blank_place(start: SettingsInput, name: str) -> tuple[Any, str]:
    """The table of the blank that holds a variable, and its key there."""
    blank = start.blank
    if name == "spiral_angle":
        return blank, "mean_spiral_angle_pinion" if blank.method == 1 else "mean_spiral_angle_gear"
    if name.startswith("pressure_angle"):
        return blank.pressure_angle, name.removeprefix("pressure_angle_")
    return (blank.depth if _BLANK[name] else blank), name


def _stated(start: SettingsInput, name: str) -> float | None:
    """Value of a variable in the blank; None or 0 if the blank does not state it."""
    table, key = _blank_place(start, name)
    return getattr(table, key, None)


def _blank_value(start: SettingsInput, name: str) -> float:
    """Value of a variable in the blank; `InputError` if the blank does not state it."""
    value = _stated(start, name)
    if not value:
        _, key = _blank_place(start, name)
        hint = f"Give {key} in the blank, or omit the variable."
        raise InputError("variable", name, "a value that the blank states", hint)
    return float(value)


def _given_bounds(name: str, bounds: Any) -> Bounds:
    allowed = VARIABLES[name]
    if isinstance(bounds, str):
        first, colon, last = bounds.partition(":")
        number, _, unit = last.strip().partition(" ")
        example = variable_quantity(name)
        if not colon or ":" in last:
            text = example.span(1e-5, 8e-5).replace(" to ", ":") if example.unit == "m" else "-0.3:0.3"
            raise InputError(name, bounds, f"'from:to unit' such as '{text}'")
        ends = [
            f"{part.strip()} {unit}".strip() if unit and " " not in part.strip() else part.strip()
            for part in (first, number)
        ]
        low, high = (allowed.check(end, name, bare=False) for end in ends)
    else:
        pair = tuple(bounds)
        if len(pair) != 2:
            raise InputError(name, bounds, "two values, the lower and the upper bound")
        low, high = (allowed.check_given(end, name) for end in pair)
    if not low < high:
        raise InputError(name, bounds if isinstance(bounds, str) else list(bounds), "a lower bound below the upper one")
    return low, high


def _default_bounds(start: SettingsInput, name: str, flanks: Flanks) -> Bounds:
    own = start_value(start, name, flanks)
    allowed = VARIABLES[name]
    most = 1.0 if allowed.le is None else allowed.le
    if name in _BLANK_SHARES:
        least, greatest = sorted(share * own for share in _BLANK_SHARES[name])
        return least, min(greatest, most)
    if name in _BLANK_REACH:
        reach = _BLANK_REACH[name]
        return max(own - reach, 0.05 if allowed.ge is None else allowed.ge), min(own + reach, most)
    if name in _EDGES:
        if not own:
            hint = f"State [pinion.edge_relief] and [gear.edge_relief] with {' and '.join(_EDGES[name])}."
            raise InputError(name, None, "its bounds, or relief in the initial targets", hint)
        return _RELIEF_SHARES[0] * own, min(_RELIEF_SHARES[1] * own, most)
    if name in ("contact_face", "contact_depth"):
        return max(own - _PLACE, -_MAX_PLACE), min(own + _PLACE, _MAX_PLACE)
    if name == "bias":
        return own - _BIAS, own + _BIAS
    if name == "twist":
        reach = max(start_value(start, "lengthwise_crowning", flanks), _FLOOR["lengthwise_crowning"])
        return max(own - reach, -most), min(own + reach, most)
    across = name in ("profile_crowning", "relief_root", "relief_tip")
    base = max(own, _FLOOR["profile_crowning" if across else "lengthwise_crowning"])
    return _SHARES[0] * base, min(_SHARES[1] * base, most)


def _sides(flanks: Flanks) -> tuple[str, ...]:
    return ("drive", "coast") if flanks == "both" else (flanks,)


def _reliefs(start: SettingsInput, name: str) -> list[float]:
    amounts = []
    for member in (start.pinion, start.gear):
        for edge in _EDGES[name]:
            relief = getattr(member.edge_relief, edge)
            if relief is not None:
                amounts.append(float(relief.amount))
    return amounts


def start_value(start: SettingsInput, name: str, flanks: Flanks) -> float:
    """Value of a variable at the start: the mean of the keys that it sets."""
    if name in _BLANK:
        return _blank_value(start, name)
    if name in _EDGES:
        values = _reliefs(start, name)
    else:
        values = [
            float(getattr(getattr(start.targets, side), key)) for side in _sides(flanks) for key in _TARGETS[name][0]
        ]
    return round(math.fsum(values) / len(values), 12) if values else 0.0


def with_values(start: SettingsInput, values: Mapping[str, float], flanks: Flanks, name: str = "") -> SettingsInput:
    """The targets with the variables at these values."""
    targets = start.targets
    own = {key: value for n, value in values.items() if n in _TARGETS for key in _TARGETS[n][0]}
    changed: dict[str, Any] = {}
    for side in _sides(flanks) if own else ():
        changed[side] = getattr(targets, side).model_copy(update={**own, "transmission_error": None})
    inner: dict[str, dict[str, float]] = {}
    for variable, value in values.items():
        if variable in _BLANK:
            inner.setdefault(_BLANK[variable], {})[_blank_place(start, variable)[1]] = value
    blank = inner.pop("", {}) | {t: getattr(start.blank, t).model_copy(update=keys) for t, keys in inner.items()}
    update = {"targets": targets.model_copy(update=changed), "blank": start.blank.model_copy(update=blank)}
    update |= _members(start, values)
    return start.model_copy(update=update | ({"name": name} if name else {}))


def _members(start: SettingsInput, values: Mapping[str, float], by: bool = False) -> dict[str, Any]:
    """Both members with the reliefs of these values, or with reliefs increased `by` them."""
    members = {"pinion": start.pinion, "gear": start.gear}
    for name, edges in _EDGES.items():
        if name in values:
            members = {which: _relieved(member, edges, values[name], by) for which, member in members.items()}
    return dict(members)


def _relieved(member: MemberTargets, edges: tuple[str, ...], amount: float, by: bool) -> MemberTargets:
    """A member with another relief amount, or with one increased `by` the amount."""
    relief = member.edge_relief
    parts = {}
    for edge in edges:
        own = getattr(relief, edge)
        if own is not None:
            new = min(max(own.amount + amount, _LEAST_RELIEF), _RELIEF.le or amount) if by else amount
            parts[edge] = own.model_copy(update={"amount": new})
    return member.model_copy(update={"edge_relief": relief.model_copy(update=parts)})


@dataclass(frozen=True)
class SearchProblem:
    """All inputs of a search except the seed."""

    start: SettingsInput  # initial targets
    variables: tuple[Variable, ...]
    flanks: Flanks  # flanks whose ease-off is varied
    objectives: tuple[str, ...]  # of `FIGURES`, the first one the most important
    limits: dict[str, float | str]  # upper limits of figures: a value, or `START` for the value of the start
    duty: tuple[DutyRow, ...]  # operating points
    # misalignments and manufacturing errors of the ease-off, added to those of the design; first the aligned pair
    states: tuple[dict[str, float], ...]
    over: Over  # whether the loss is the mean or the maximum over the states; other figures are the worst
    # friction model and oil card
    friction: str
    oil: str

    @property
    def figures(self) -> tuple[str, ...]:
        """Objectives and limits, each once."""
        return tuple(dict.fromkeys((*self.objectives, *self.limits)))

    @property
    def varies_blank(self) -> bool:
        """Whether the blank is varied, so that the elastic bodies change."""
        return any(variable.name in _BLANK for variable in self.variables)

    @property
    def start_values(self) -> dict[str, float]:
        """Variables at the start."""
        return {v.name: start_value(self.start, v.name, self.flanks) for v in self.variables}

    def places_of(self, points: Sequence[Mapping[str, float]]) -> FloatArray:
        """Positions of points in the unit cube between the bounds, (n, d)."""
        places = [[v.place(point[v.name]) for v in self.variables] for point in points]
        return np.array(places).reshape(len(points), len(self.variables))

    def values_at(self, place: FloatArray) -> dict[str, float]:
        """Variables at a position of the unit cube."""
        return {v.name: v.at(float(z)) for v, z in zip(self.variables, place, strict=True)}


def checked_limits(given: Mapping[str, Any] | None) -> dict[str, float | str]:
    """Validated limits: a value, or `START` for the value of the start; `InputError` for anything else."""
    found: dict[str, float | str] = {}
    for name, value in (dict.fromkeys(LIMITS, START) if given is None else given).items():
        if name not in FIGURES:
            raise InputError("limit", name, "one of " + ", ".join(FIGURES))
        if value in (START, "", None):
            found[name] = START
            continue
        unit = quantities()[name].unit
        example = "To keep the value of the start, give the name alone or 'start'."
        bounds = ValueRange(unit, ge=0.0, hint=example)
        found[name] = bounds.check_given(value, f"limit {name}")
    return found


def half_widths(box: Mapping[str, Any]) -> dict[str, float]:
    """Half widths of E, P, G [m] and shaft_angle_error [rad] that are not zero."""
    widths = {}
    for name, value in box.items():
        if name not in _SHIFTS:
            raise InputError("misalignment", name, "one of " + ", ".join(_SHIFTS))
        width = _SHIFTS[name].check_given(value, name)
        if width < 0.0:
            raise InputError(name, value, "a half width, zero or above", "The box extends to both sides.")
        if width > 0.0:
            widths[name] = width
    return widths


def box_states(
    box: Mapping[str, Any] | None, tolerance: Mapping[str, Any] | None = None
) -> tuple[dict[str, float], ...]:
    """The aligned pair as designed, and corners of a box of misalignments and manufacturing errors of the ease-off.

    With one or two half widths all corners; with three the half in which the product of the signs is one; with four to
    seven a two-level fractional factorial design of resolution III with eight corners. `box` holds half widths of E, P,
    G [m] and shaft_angle_error [rad], where zero omits one; `tolerance` holds those of variables of the ease-off.
    """
    widths = half_widths(BOX if box is None else box)
    taken: dict[str, str] = {}
    for name, value in (tolerance or {}).items():
        if name not in VARIABLES or name in _BLANK:
            raise InputError("tolerance", name, "one of " + ", ".join(n for n in VARIABLES if n not in _BLANK))
        _take("tolerance", name, taken)
        allowed = VARIABLES[name]
        half = ValueRange(allowed.unit, gt=0.0, le=allowed.le, hint="A half width: the error extends to both sides.")
        widths[name] = half.check_given(value, f"tolerance {name}")
    if len(widths) > _MAX_WIDTHS:
        hint = "Omit the least important ones; set a misalignment to '0 mm' to omit it."
        raise InputError("tolerance", ", ".join(widths), f"at most {_MAX_WIDTHS} half widths with misalignments", hint)
    corners = [_signs(base, len(widths)) for base in product((-1.0, 1.0), repeat=min(len(widths), 3))] if widths else []
    corners = [signs for signs in corners if len(signs) != 3 or reduce(mul, signs) > 0.0]
    return (
        dict.fromkeys(widths, 0.0),
        *(dict(zip(widths, map(mul, signs, widths.values()), strict=True)) for signs in corners),
    )


def _signs(base: tuple[float, ...], count: int) -> tuple[float, ...]:
    """Signs of a corner; those beyond the third are products of the first three."""
    if count <= len(base):
        return base
    a, b, c = base
    return (a, b, c, a * b * c, a * b, a * c, b * c)[:count]


def as_made(inputs: SettingsInput, state: Mapping[str, float], flanks: Flanks) -> SettingsInput:
    """Targets with the manufacturing errors of the ease-off of a state, limited to the allowed range."""
    errors = {name: value for name, value in state.items() if value and name not in _SHIFTS}
    if not errors:
        return inputs
    changed: dict[str, Any] = {}
    for side in _sides(flanks):
        target = getattr(inputs.targets, side)
        moved = {
            key: _within(getattr(target, key) + value, value_range_of(FlankTarget, key))
            for name, value in errors.items()
            for key in _TARGETS.get(name, ((),))[0]
        }
        if moved:
            changed[side] = target.model_copy(update=moved | {"transmission_error": None})
    targets: Targets = inputs.targets.model_copy(update=changed)
    return inputs.model_copy(update={"targets": targets, **_members(inputs, errors, by=True)})


def _within(value: float, allowed: ValueRange) -> float:
    low = allowed.ge if allowed.ge is not None else allowed.gt
    return min(max(value, -math.inf if low is None else low), math.inf if allowed.le is None else allowed.le)


def state_text(state: Mapping[str, float]) -> str:
    """Misalignment and manufacturing errors of the ease-off in words."""

    def one(name: str, value: float) -> str:
        if name in _SHIFTS:
            return f"{name} {level_quantity(name).text(value)}"
        return f"{variable_quantity(name).label} {'+' if value > 0.0 else ''}{variable_quantity(name).text(value)}"

    moved = [one(name, value) for name, value in state.items() if value]
    return ", ".join(moved) or "aligned"
