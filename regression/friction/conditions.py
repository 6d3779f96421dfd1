"""Local conditions: all variables of friction formulas by name, from a contact state and an oil.

The sweep stores the same names for each case, so that fit and evaluation of a formula have the same input table.
"""

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehl import inputs
from ehl.common.arrays import IntArray
from ehl.common.errors import InputError, near
from ehl.common.quantities import si_units
from ehl.common.units import ValueRange, value_range
from ehl.fluid.density import dowson_higginson_1966
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.fluid.rheology import stress_at
from ehl.fluid.viscosity import Temperature
from ehl.line_contact import gupta_1992, half_width_of_pressure, hertz_load, moes_film
from ehl.material import Material, effective_modulus
from ehl.state import ContactState
from ehl.surface.finish import Finish
from ehl.surface.roughness import EP_FILM

Array = NDArray[np.float64]
Conditions = Mapping[str, Array]

# stored oil properties of each case at inlet temperature
LUBRICANT_UNITS = si_units(
    (
        *("viscosity_inlet", "viscosity_kinematic", "viscosity_mean_pressure"),
        *("pressure_viscosity", "pressure_viscosity_film", "eyring_stress"),
        *("limiting_shear_coefficient", "temperature_viscosity", "thermal_conductivity"),
    )
)
STATE_UNITS = si_units(
    (
        *("pressure_hertz", "radius_equivalent", "effective_modulus", "speed_entrainment"),
        *("slide_to_roll", "speed_sliding_lengthwise", "temperature_oil", "roughness_rms_1"),
        *("roughness_rms_2", "correlation_length", "peklenik_number"),
    )
)
DERIVED_UNITS = si_units(
    (
        *("load_per_length", "half_width", "speed_sum", "speed_sliding"),
        *("slide_to_roll_total", "roughness_rms", "film_formula", "film_ratio_formula"),
    )
)
UNITS: dict[str, str] = {**STATE_UNITS, **LUBRICANT_UNITS, **DERIVED_UNITS}


def lubricant_columns(lubricant: Lubricant, pressure_hertz: Array) -> dict[str, Array | float]:
    """Stored oil properties of a case at inlet temperature, with the names of `LUBRICANT_UNITS`.

    `viscosity_mean_pressure`, an Eyring stress that depends on pressure, and the limiting stress over pressure are
    those at the mean Hertz pressure of the line contact, pi p_h/4.

    lubricant: from `Oil.at`; its fields may be arrays.
    pressure_hertz: maximum Hertz pressure [Pa].
    """
    mean_pressure = 0.25 * np.pi * pressure_hertz
    stress = lubricant.eyring_stress
    return {
        "viscosity_inlet": lubricant.viscosity_inlet,
        "viscosity_kinematic": lubricant.viscosity_inlet / lubricant.density,
        "viscosity_mean_pressure": lubricant.viscosity(mean_pressure),
        "pressure_viscosity": lubricant.alpha,
        "pressure_viscosity_film": lubricant.pressure_viscosity_film,
        "eyring_stress": stress_at(stress, mean_pressure),
        "limiting_shear_coefficient": lubricant.limiting_shear_coefficient
        + lubricant.limiting_shear_ambient / np.maximum(mean_pressure, 1.0),
        "temperature_viscosity": lubricant.temperature_viscosity,
        "thermal_conductivity": lubricant.thermal_conductivity,
    }


def lubricant_row(lubricant: Lubricant, pressure_hertz: float) -> dict[str, float]:
    """`lubricant_columns` of one contact."""
    return {name: float(value) for name, value in lubricant_columns(lubricant, np.asarray(pressure_hertz)).items()}


# inputs of a contact point with unit and range, in the order of `mixed-ehl mu`
POINT: dict[str, ValueRange] = {
    "pressure_hertz": value_range(inputs.Pressure),
    "radius_equivalent": value_range(inputs.Radius),
    "speed_entrainment": value_range(inputs.Speed),
    "slide_to_roll": value_range(inputs.SlideToRoll),
    "temperature_oil": value_range(Temperature),
    "roughness_rms": value_range(inputs.Rms),
    "speed_sliding_lengthwise": value_range(inputs.SlidingSpeed),
    "correlation_length": value_range(inputs.Length),
    "peklenik_number": value_range(inputs.PeklenikNumber),
    "effective_modulus": value_range(inputs.Modulus),
}
_COUNTER_ROLLING = 2.0  # slide-to-roll ratio at which one surface is stationary
_NEEDED = ("pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll", "temperature_oil")


class PointConditions(TypedDict, total=False):
    """Keywords of contact points: SI numbers, strings with unit, or broadcastable arrays of them."""

    pressure_hertz: ArrayLike
    radius_equivalent: ArrayLike
    speed_entrainment: ArrayLike
    slide_to_roll: ArrayLike
    temperature: ArrayLike
    temperature_oil: ArrayLike
    roughness_rms: ArrayLike
    speed_sliding_lengthwise: ArrayLike
    correlation_length: ArrayLike
    peklenik_number: ArrayLike
    effective_modulus: ArrayLike
    finish: str
    finish_state: str


def contact_points(**conditions: Unpack[PointConditions]) -> ContactState:
    """Contact points from SI numbers, strings with unit, or arrays of them, with the names of `POINT`.

    `temperature` is a synonym of `temperature_oil`. Both surfaces have equal shares of the composite roughness. The
    default of `effective_modulus` is that of steel bodies, which have the oil temperature. A `finish` with its
    `finish_state` ("run_in") gives default values of Rq, correlation length and Peklenik number, as in `ehl.Contact`.
    """
    finish, finish_state = conditions.pop("finish", None), conditions.pop("finish_state", "run_in")
    if finish is not None:
        if not isinstance(finish, str):
            raise InputError("finish", finish, "one name for all points, such as 'ground', or a FILE.toml")
        named = Finish.load(finish, finish_state)
        defaults: PointConditions = {
            "roughness_rms": named.roughness_rms.value * np.sqrt(2.0),
            "peklenik_number": max(named.lay_ratio.value, 1.0 / 3.0),
        }
        conditions = {**defaults, **conditions}
    if {"temperature", "temperature_oil"} <= conditions.keys():
        raise InputError("temperature", conditions["temperature"], "not together with temperature_oil")
    values = {"temperature_oil" if name == "temperature" else name: value for name, value in conditions.items()}
    for name in values:
        if name not in POINT:
            known = (*POINT, "finish", "finish_state")
            raise InputError(name, values[name], "one of " + ", ".join(known), near(name, known))
    for name in _NEEDED:
        if name not in values:
            raise InputError(name, None, POINT[name].expected())
    state = {name: _checked(name, value) for name, value in values.items()}
    _check_shapes({name: numbers.shape for name, numbers in state.items() if numbers.shape})
    if (fastest := float(np.abs(state["slide_to_roll"]).max(initial=0.0))) > _COUNTER_ROLLING:
        hint = "Above 2 the surfaces move in opposite directions, beyond the validity of the friction models."
        raise InputError("slide_to_roll", fastest, "-2 to 2", hint)
    rough = state.pop("roughness_rms", np.array(0.0)) / np.sqrt(2.0)
    if finish is not None:
        state.setdefault("correlation_length", named.length_at(rough))
    steel = Material.load("steel")
    state.setdefault("effective_modulus", np.array(effective_modulus(steel, steel)))
    return ContactState.of(**state, roughness_rms_1=rough, roughness_rms_2=rough)


def _check_shapes(shapes: Mapping[str, tuple[int, ...]]) -> None:
    try:
        empty = 0 in np.broadcast_shapes(*shapes.values())
    except ValueError:
        empty = True
    if empty:
        raise InputError(", ".join(shapes), tuple(shapes.values()), "arrays of one shape with at least one point")


def _checked(name: str, value: Any) -> Array:
    given = np.asarray(value, dtype=object)  # numbers and texts as they are
    numbers = [POINT[name].check(entry, name, bare=not isinstance(entry, str)) for entry in given.ravel().tolist()]
    return np.array(numbers).reshape(given.shape)


def state_across(values: Mapping[str, ArrayLike]) -> ContactState:
    """Contact points by `slide_to_roll_total`, across the contact line, and `roughness_rms`, in equal shares."""
    rest = {name: value for name, value in values.items() if name not in ("slide_to_roll_total", "roughness_rms")}
    rough = np.asarray(values.get("roughness_rms", 0.0)) / np.sqrt(2.0)
    sliding = values["slide_to_roll_total"]
    return ContactState.of(slide_to_roll=sliding, roughness_rms_1=rough, roughness_rms_2=rough, **rest)


def conditions_of(state: ContactState, oil: Oil) -> dict[str, Array]:
    """All variables of `UNITS`, and the bulk temperatures, at every contact point, in the shape of the state."""
    columns = {name: np.asarray(getattr(state, name), dtype=float) for name in STATE_UNITS}
    temperature = columns["temperature_oil"]
    shape, line = temperature.shape, temperature.reshape(-1)
    # the oil laws take most of the time: they are evaluated once for equal temperatures next to each other
    starts = np.concatenate([[0], np.flatnonzero(line[1:] != line[:-1]) + 1])
    if not shape or 2 * starts.size > line.size:
        lubricant = oil.at(temperature)
    else:
        lubricant = oil.at(line[starts])
        if starts.size > 1:
            lubricant = _repeated(lubricant, np.diff(starts, append=line.size), shape)
    figures = lubricant_columns(lubricant, columns["pressure_hertz"])
    more = {name: np.asarray(getattr(state, name)) for name in _BULK}
    more |= {_FACTOR + name: np.full(shape, getattr(oil.factors, factor)) for name, factor in _SHEAR.items()}
    return derive(columns | {name: np.broadcast_to(value, shape) for name, value in figures.items()}) | more


def before_variation(table: Conditions) -> Conditions:
    """The conditions with Eyring and limiting stress of the card before `Oil.varied`; the same table if not varied."""
    factors = {name: table.get(_FACTOR + name) for name in _SHEAR}
    changed = {
        name: table[name] / factor for name, factor in factors.items() if factor is not None and np.any(factor != 1.0)
    }
    return {**table, **changed} if changed else table


_BULK = ("temperature_bulk_1", "temperature_bulk_2")
_FACTOR = "factor_of_"
_SHEAR = {"eyring_stress": "eyring_stress", "limiting_shear_coefficient": "limiting_shear"}  # names in `InputFactors`


def _repeated(value: Any, counts: IntArray, shape: tuple[int, ...]) -> Any:
    """A lubricant at several temperatures with every property repeated, `counts` times at each temperature."""
    if isinstance(value, np.ndarray) and value.shape == counts.shape:
        return np.repeat(value, counts).reshape(shape)
    if isinstance(value, tuple):
        return tuple(_repeated(part, counts, shape) for part in value)
    if not is_dataclass(value) or isinstance(value, type):
        return value
    parts = {field.name: _repeated(getattr(value, field.name), counts, shape) for field in fields(value)}
    film = parts.pop("_alpha_film", None)
    found: Any = replace(value, **parts)
    return found if film is None else found.with_alpha_film(film)


def state_of(conditions: Conditions) -> ContactState:
    """The contact points of `conditions_of`."""
    return ContactState(**{field.name: conditions[field.name] for field in fields(ContactState)})


def derive(columns: Mapping[str, ArrayLike]) -> dict[str, Array]:
    """Table with the names of `STATE_UNITS` and `LUBRICANT_UNITS`, completed by the derived variables.

    `film_formula` is the isothermal, incompressible film of Moes (1992) with alpha_film, divided by the density ratio
    of Dowson & Higginson at p_h. `film_ratio_formula` is that film over the composite Rq. They replace the film of the
    solver in formulas.
    """
    table = {name: np.asarray(columns[name], dtype=float) for name in (*STATE_UNITS, *LUBRICANT_UNITS)}
    return table | derived_conditions(table)


def derived_conditions(table: Conditions) -> dict[str, Array]:
    """The variables of `DERIVED_UNITS` from the others, by ufuncs and arithmetic only."""
    pressure, radius, modulus = table["pressure_hertz"], table["radius_equivalent"], table["effective_modulus"]
    speed, along = table["speed_entrainment"], table["speed_sliding_lengthwise"]
    load = hertz_load(pressure, radius, modulus)
    sliding = np.hypot(table["slide_to_roll"] * speed, along)
    alpha = table["pressure_viscosity_film"]
    film = moes_film(table["viscosity_inlet"], np.abs(speed), load, radius, modulus, alpha)
    film = film / dowson_higginson_1966(pressure)
    rough = np.hypot(table["roughness_rms_1"], table["roughness_rms_2"])
    return {
        "load_per_length": load,
        "half_width": half_width_of_pressure(pressure, radius, modulus),
        "speed_sum": 2.0 * speed,
        "speed_sliding": sliding,
        "slide_to_roll_total": sliding / np.abs(speed),
        "roughness_rms": rough,
        "film_formula": film,
        "film_ratio_formula": film_over_roughness(film, rough),
    }


def film_over_roughness(film: Array, roughness: Array) -> Array:
    """Film ratio; infinite for smooth surfaces."""
    ratio: Array = np.divide(film, roughness, out=np.full_like(film, np.inf), where=roughness > 0.0)
    return ratio


# dimensionless groups of a rough, thermal line contact, in which friction varies more smoothly than in its inputs. They
# are positive and consist of ufuncs, so that `regression.export` can record them
MIN_ROUGHNESS = 1e-12  # [m]
_LEAST_ACROSS = 0.01  # sliding across the line below which friction does not depend on it


def flattening(c: Conditions) -> Array:
    """P = p_h lc/(0.5 E' Rq): Hertz pressure over the pressure that flattens the roughness."""
    return np.asarray(c["pressure_hertz"] * c["correlation_length"] / (0.5 * c["effective_modulus"] * _rough(c)))


def inlet_heating(c: Conditions) -> Array:
    """Film factor of inlet heating (`ehl.line_contact.gupta_1992`)."""
    loading = c["viscosity_inlet"] * c["temperature_viscosity"] * c["speed_entrainment"] ** 2
    return gupta_1992(loading / c["thermal_conductivity"], c["slide_to_roll_total"])


def _rough(c: Conditions) -> Array:
    return np.maximum(c["roughness_rms"], MIN_ROUGHNESS)


GROUPS: dict[str, Callable[[Conditions], Array]] = {
    "film_over_boundary_film": lambda c: c["film_formula"] / EP_FILM,
    "flattening": flattening,
    "correlation_over_width": lambda c: c["correlation_length"] / c["half_width"],
    "pressure_over_modulus": lambda c: c["pressure_hertz"] / c["effective_modulus"],
    "viscosity_exponent": lambda c: c["pressure_viscosity"] * c["pressure_hertz"],
    "shear_over_eyring": lambda c: c["viscosity_inlet"] * c["speed_sliding"] / (c["eyring_stress"] * _rough(c)),
    # rise of the surfaces by the Eyring stress, times the temperature coefficient of viscosity and their effusivity
    "flash": lambda c: (
        c["temperature_viscosity"]
        * c["eyring_stress"]
        * c["speed_sliding"]
        * np.sqrt(c["half_width"] / np.abs(c["speed_entrainment"]))
    ),
    "slide_across": lambda c: _LEAST_ACROSS + np.abs(c["slide_to_roll"]),
    # of the film: Newtonian over Eyring stress, heating by the Eyring stress, limiting stress over it, ln of the rise
    # of viscosity, thickness over the Hertz depth
    "film_strain": lambda c: (
        c["viscosity_mean_pressure"] * c["speed_sliding"] / (c["eyring_stress"] * c["film_formula"])
    ),
    "film_heating": lambda c: (
        c["temperature_viscosity"]
        * c["eyring_stress"]
        * c["speed_sliding"]
        * c["film_formula"]
        / c["thermal_conductivity"]
    ),
    "limit_over_eyring": lambda c: c["limiting_shear_coefficient"] * c["pressure_hertz"] / c["eyring_stress"],
    "viscosity_rise": lambda c: np.log(c["viscosity_mean_pressure"] / c["viscosity_inlet"]),
    "film_over_depth": lambda c: c["film_formula"] * c["radius_equivalent"] / c["half_width"] ** 2,
}
