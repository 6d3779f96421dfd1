"""A fitted formula as a list of assignments: local conditions in, friction with its interval and flag out.

Functions over stored numbers: the networks and the guard of a formula as loops, each with several results.

networks  part that counts, mean outputs of the networks, their variances and covariance, of logarithms of their inputs
guard     distance to the nearest stored case, length of z, least margin of pairs of variables, of logarithms
"""

import itertools
import re
from collections import Counter
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ehl.common.errors import InputError, same_name
from ehl.fluid.oil import Oil
from ehl.fluid.viscosity import TEMPERATURE_RANGE
from regression.export import record
from regression.export.record import NotRecordable, Value
from regression.friction.conditions import LUBRICANT_UNITS, STATE_UNITS, derived_conditions, lubricant_columns
from regression.friction.data_cloud import STEP, DataCloud
from regression.friction.fitted import FittedFormula, flags_of, friction_of_form
from regression.friction.models import FrictionFlag
from regression.friction.network import FADE, Network

Rows = Sequence[Sequence[float]]
RESULTS = {"networks": 6, "guard": 3}


@dataclass(frozen=True)
class DataFunction:
    """A function of several logarithms over stored numbers."""

    name: str  # one of `RESULTS`
    arrays: dict[str, Rows]  # rows of numbers by name
    sizes: dict[str, float]  # words of the loops that stand for a number

    def loop(self, suffix: str) -> str:
        """The loop of a language with the numbers of this function, from the file with that end of its name."""
        text = Path(__file__).with_name(f"{self.name}{suffix}").read_text(encoding="utf-8")
        for name, number in self.sizes.items():
            text = re.sub(rf"(?<![A-Za-z_]){name}", repr(number), text)
        return f"\n{text}"


class DataValue(Value):
    """The results of a `DataFunction` at recorded logarithms."""

    def __init__(self, function: DataFunction, logarithms: Sequence[Value]) -> None:
        super().__init__(function.name, tuple(logarithms))
        self.function = function
        self.name = f"{function.name}_at"

    def __iter__(self) -> Iterator[Value]:
        return (Value("item", (self,), float(place)) for place in range(RESULTS[self.function.name]))


def network_statistics(network: Network) -> Callable[[list[Any]], list[Any]]:
    """As `regression.friction.network.Network.statistics` of recorded logarithms."""
    size, units = len(network.variables), network.units
    # of each layer a row of all networks for each input, then one of the biases
    ends = (0, units, 2 * units, 2 * units + 2)
    names = ("first", "second", "last")
    function = DataFunction(
        "networks",
        {"scales": (network.mean, network.scale, network.low, network.high)}
        | {
            name: list(zip(*(row for rows in network.members for row in rows[start:end]), strict=True))
            for name, (start, end) in zip(names, pairwise(ends), strict=True)
        },
        {
            "STEP": network.step,
            "SIZE": size,
            "UNITS": units,
            "MEMBERS": len(network.members),
            "FADE": FADE,
            "WIDTH": len(network.members) * units,
        },
    )
    return lambda logarithms: list(DataValue(function, logarithms))


def guard(cloud: DataCloud, logarithms: list[Any]) -> list[Any]:
    """Distance to the nearest stored case, length of z, and least margin of pairs of variables."""
    arrays: dict[str, Rows] = {
        "scales": (cloud.mean, cloud.scale),
        "whitening": cloud.whitening,
        "cases": list(zip(*cloud.points, strict=True)),
        "limits": cloud.limits,
    }
    sizes = {"STEP": STEP, "SIZE": len(logarithms), "CASES": len(cloud.points), "PAIRS": len(cloud.limits)}
    return list(DataValue(DataFunction("guard", arrays, sizes), logarithms))


MEANING: dict[str, str] = {
    "pressure_hertz": "maximum Hertz pressure",
    "radius_equivalent": "equivalent radius normal to the contact line",
    "effective_modulus": "E' with 2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2; steel on steel 2.26e11 Pa",
    "speed_entrainment": "mean surface velocity across the contact line, positive",
    "slide_to_roll": "sliding across the contact line over speed_entrainment",
    "speed_sliding_lengthwise": "sliding along the contact line, 0 for cylindrical gears",
    "temperature_oil": "oil temperature at the inlet",
    "correlation_length": "correlation length of the roughness of either surface, across the contact line",
    "peklenik_number": "correlation length along the contact line over that across it; 1 is isotropic",
    "roughness_rms": "composite Rq of both surfaces, sqrt(Rq1^2 + Rq2^2)",
    "viscosity_inlet": "dynamic viscosity at ambient pressure and temperature_oil",
    "viscosity_kinematic": "kinematic viscosity at ambient pressure and temperature_oil",
    "viscosity_mean_pressure": "dynamic viscosity at the mean pressure pi/4 pressure_hertz and temperature_oil",
    "pressure_viscosity": "d ln eta/dp at ambient pressure",
    "pressure_viscosity_film": "alpha_film, the pressure-viscosity coefficient of film formulas",
    "eyring_stress": "Eyring stress",
    "limiting_shear_coefficient": "limiting shear stress over pressure",
    "temperature_viscosity": "-d ln eta/dT at ambient pressure",
    "thermal_conductivity": "thermal conductivity of the oil",
}
OUTPUTS = ("mu", "lower", "upper", "flag")
_RECORDED = ("regression.", "ehl.")
_LONGEST = 60  # operations in one expression, from which on a value used once keeps its name


@dataclass(frozen=True)
class Program:
    """A formula ready to be printed."""

    formula: FittedFormula  # what is exported
    oil: str | None  # the card whose laws are written into the program; None where the oil's properties are arguments
    arguments: tuple[str, ...]  # names of the numbers the caller gives, in SI units, in the order of the call
    coefficients: tuple[Value, ...]  # the fitted numbers that are used
    steps: tuple[Value, ...]  # the named values in the order they are computed, those of `OUTPUTS` last

    @property
    def data_functions(self) -> tuple[DataFunction, ...]:
        """The functions over stored numbers it calls."""
        values = sorted(reached(self.steps), key=lambda value: value.serial)
        return tuple(value.function for value in values if isinstance(value, DataValue))

    @property
    def operations(self) -> frozenset[str]:
        """Every operation the program uses."""
        return frozenset(value.operation for value in reached(self.steps))


def program_of(
    formula: FittedFormula, *, oil: str | None = None, oil_arguments: bool = False, guard: bool = True
) -> Program:
    """Record a formula."""
    card = None if oil_arguments else _card(formula, oil)
    try:
        with record.local_names(_RECORDED):
            outputs = _outputs(formula, card, guard)
    except (NotRecordable, KeyError) as error:
        hint = f"It cannot be exported: {error}."
        raise InputError("family", formula.family, "a family of ufuncs and arithmetic", hint) from None
    _shared(outputs)
    used = sorted(reached(outputs), key=lambda value: value.serial)
    names = {value.name for value in used if value.operation == "argument"}
    known = (*STATE_UNITS, "roughness_rms", *LUBRICANT_UNITS)
    arguments = tuple(name for name in known if name in names)
    coefficients = tuple(value for value in used if value.operation == "coefficient")
    return Program(formula, card.name if card else None, arguments, coefficients, _named_steps(outputs))


def _card(formula: FittedFormula, oil: str | None) -> Oil:
    names = [identity.name for identity in formula.oils if identity.name is not None]
    if oil is not None:
        oil = same_name(oil, names)
        if names and oil not in names:
            raise InputError("oil", oil, "one of " + ", ".join(names), "The formula was fitted to no other oil.")
        return Oil.load(oil)
    if len(names) == 1:
        return Oil.load(names[0])
    allowed = "one of " + ", ".join(names) if names else "the name of an oil card"
    hint = "Name the card, or pass the oil's properties as arguments (oil_arguments, --oil-arguments)."
    raise InputError("oil", None, allowed, hint)


def _outputs(formula: FittedFormula, oil: Oil | None, guarded: bool) -> tuple[Value, ...]:
    """Friction, interval and flag as `FittedFormula.evaluate` computes them."""
    table, within_laws = _conditions(oil)
    outside = formula.outside(table)
    floored, ramp = formula.with_minimum_sliding(formula.with_roughness_in_range(table))
    coefficients = {
        name: record.coefficient(re.sub(r"\W", "_", f"k_{name}"), value) for name, value in formula.coefficients.items()
    }
    boundary = record.coefficient("boundary_friction", formula.boundary_friction)
    network = formula.network
    statistics = None if network is None else network_statistics(network)
    friction, deviation = friction_of_form(formula.form, coefficients, network, floored, boundary, statistics)
    near, far = record.constant(0.0), record.constant(0.0)
    if formula.cloud is not None and guarded:
        cloud, limited = formula.cloud, formula.with_roughness_in_range(table)
        distance, length, margin = guard(cloud, [np.log(limited[name]) for name in cloud.variables])
        near, far = cloud.near_and_far(distance / cloud.radius, length, margin < 0.0)
    width = formula.log_width(table["film_ratio_formula"], deviation, outside, formula.excess(table), near, far)
    start = record.constant(FrictionFlag.OK if oil is None else formula.oil_flag(oil))
    defined = np.isfinite(friction) & (friction > 0.0) & within_laws
    mu = np.where(defined, friction * ramp, np.nan)
    flag = flags_of(start, near, far, outside, ~defined)
    outputs = (mu, mu * np.exp(-width), mu * np.exp(width), flag)
    values = tuple(record.value_of(value) for value in outputs)
    for name, value in zip(OUTPUTS, values, strict=True):
        value.name = name
    return values


def _conditions(oil: Oil | None) -> tuple[dict[str, Any], Any]:
    """Every variable a family may use, and whether the laws of the oil hold at the temperature."""
    table = {name: record.argument(name) for name in STATE_UNITS}
    # families use only the composite Rq
    table["roughness_rms_1"], table["roughness_rms_2"] = record.argument("roughness_rms"), record.constant(0.0)
    within_laws = record.constant(1.0)
    if oil is None:
        table |= {name: record.argument(name) for name in LUBRICANT_UNITS}
    else:
        temperature = table["temperature_oil"]
        columns = lubricant_columns(oil.lubricant(temperature), table["pressure_hertz"])
        table |= {name: record.value_of(value) for name, value in columns.items()}
        low, high = TEMPERATURE_RANGE
        within_laws = (temperature >= low) & (temperature <= high)
    derived = derived_conditions(table)
    table |= {name: record.value_of(value) for name, value in derived.items()}
    del table["roughness_rms_1"], table["roughness_rms_2"]
    for name, value in table.items():
        if value.operands and name != "roughness_rms":
            value.name = name
    return table, within_laws


def reached(outputs: tuple[Value, ...]) -> set[Value]:
    """The values that these are computed from, and themselves."""
    found: set[Value] = set()
    waiting = list(outputs)
    while waiting:
        value = waiting.pop()
        if value not in found:
            found.add(value)
            waiting.extend(value.operands)
    return found


def _named_steps(outputs: tuple[Value, ...]) -> tuple[Value, ...]:
    """The values that get a line of their own: those used more than once, and named ones that are long."""
    used = sorted(reached(outputs), key=lambda value: value.serial)
    uses = Counter(operand for value in used for operand in value.operands)
    # Fortran does not distinguish capitals from small letters
    taken = {value.name.lower() for value in used if not value.operands} | set(OUTPUTS)
    ends, sizes, steps = set(outputs), dict.fromkeys(used, 0), []
    for value in used:
        if not value.operands or value in ends:
            continue
        size = 1 + sum(sizes[operand] for operand in value.operands)
        if uses[value] == 1 and (size < _LONGEST or not value.name):
            sizes[value], value.name = size, ""
            continue
        wanted = value.name or "part"
        numbered = (f"{wanted}_{number}" for number in itertools.count(2))
        value.name = next(name for name in itertools.chain([wanted], numbered) if name.lower() not in taken)
        taken.add(value.name.lower())
        steps.append(value)
    return (*steps, *outputs)


def _shared(outputs: tuple[Value, ...]) -> None:
    """Let what is computed more than once be one value."""
    first: dict[Hashable, Value] = {}
    kept: dict[Value, Value] = {}
    for value in sorted(reached(outputs), key=lambda value: value.serial):
        value.operands = tuple(kept[operand] for operand in value.operands)
        own = value.name if not value.operands or value.name in OUTPUTS else ""
        key = (value.operation, repr(value.number), own, *map(id, value.operands))
        kept[value] = first.setdefault(key, value)
        kept[value].name = kept[value].name or value.name
