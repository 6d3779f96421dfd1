"""The plan of a sweep (`mixed-ehl sweep PLAN.toml`): the contacts that are solved, and their computation time.

A variable is a range (sampled by a Sobol sequence or a Latin hypercube), a list or the levels of a range (full
factorial), one value, or a column of a table. Every value of a list is combined with all sampled points. Constraints
exclude combinations that do not occur in gears.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, model_validator

from ehl import inputs as case_inputs
from ehl.common.arrays import FloatArray, IntArray
from ehl.common.data import data_names, named_file
from ehl.common.errors import InputError, same_name
from ehl.common.files import parse_json, parse_toml
from ehl.common.pages import Reportable
from ehl.common.progress import counted
from ehl.common.sections import Head, Medium, Section
from ehl.common.table import Table
from ehl.common.table_reader import Column, read_columns
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel, Name, read_toml, validate
from ehl.contact import KEYWORDS, Contact
from ehl.fluid.lubricant_inputs import DirectLubricant, OilLubricant
from ehl.inputs import ModelInput, SolidInput, SurfaceInput
from ehl.material import Material, effective_modulus
from ehl.surface.finish import default_correlation_length
from regression.friction.conditions import LUBRICANT_UNITS, derive, lubricant_columns
from regression.plan.cost import ALLOWED_TIME_CAP, CostEstimate, contact_seconds
from regression.plan.sampling import (
    EXCLUSIVE,
    REQUIRED,
    VARIABLES,
    WINDOWS,
    Accept,
    BoxSampler,
    Constraints,
    ConstraintWindow,
    PlanAxis,
    PointBlock,
    Variables,
    constrained_quantities,
    filtered,
    lattice,
)

if TYPE_CHECKING:
    import pandas as pd

MAX_CASES = 1_000_000
MAX_DRAWN = 10  # largest number of points before the constraints are applied, over MAX_CASES
MAX_CORNER_VARIABLES = 10  # d ranges have 2^d corners
# columns of a table of points; the oil is a text
QUANTITIES: dict[str, ValueRange | None] = {**VARIABLES, "oil": None}
Columns = Annotated[dict[str, Column], BeforeValidator(partial(read_columns, quantities=QUANTITIES))]


class Sampling(InputModel):
    """Sampling of the ranges, corners of the box, and number of roughness profiles of each point."""

    # factorial combines all `levels` of the ranges
    method: Literal["sobol", "latin_hypercube", "factorial"] = "sobol"
    # points in the ranges: a power of two for Sobol without constraints
    size: Annotated[int, Field(ge=1, le=MAX_CASES)] | None = None
    # in a factorial plan, levels of every range that does not state its own
    levels: Annotated[int, Field(ge=2, le=1000)] | None = None
    seed: Annotated[int, Field(ge=0)] = 1  # of the sequence
    # add all corners of the box, or a number of them; the fit excludes them
    corners: bool | Annotated[int, Field(ge=1)] = False
    realisations: Annotated[int, Field(ge=1, le=1000)] = 1  # roughness profiles per point, each a separate case
    same_profile: bool = False  # the profiles of all points have the same seeds; otherwise they differ


@dataclass(frozen=True)
class PlanPoints:
    """All points of a plan, in a fixed order."""

    origin: tuple[str, ...]  # sobol, latin, corner, lattice or table
    columns: dict[str, FloatArray]  # values of the variables, SI
    oils: tuple[str | None, ...]  # oil card of each point; None where the lubricant is given by numbers
    seed: IntArray  # of the roughness of each point
    rejected: dict[str, float]  # name of each constraint to the share of the drawn points outside of it

    def __len__(self) -> int:
        return len(self.origin)


class Plan(InputModel, Reportable):
    """The contacts that a sweep solves: the content of a plan file.

    Create a plan with `from_file` or `from_dict`, which check both ends of every range; docs/sweep.md describes the
    entries.

    Parameters
    ----------
    name, description : str
        Name and description of the plan.
    sampling : Sampling
        Sampling of the ranges.
    variables : dict of str to PlanAxis
        Ranges, lists and values, SI.
    table : dict of str to tuple
        Columns of individual points, SI.
    constraints : dict of str to ConstraintWindow
        Windows that every point must satisfy.
    lubricant : dict
        Oil card or cards, or a lubricant by numbers.
    solid_1, solid_2 : SolidInput
        The bodies.
    effective_modulus : float, optional
        Replaces the modulus of the bodies [Pa].
    surface : SurfaceInput
        Roughness parameters that are constant in the plan.
    model : ModelInput
        Model and accuracy of the contact solver.

    Examples
    --------
    >>> from regression import Plan
    >>> plan = Plan.from_file("demo")
    >>> plan.count
    48
    >>> list(plan.to_frame().columns[:3])
    ['origin', 'oil', 'seed']
    >>> plan.estimate().cases
    48
    """

    name: Name
    description: str = ""
    sampling: Sampling = Sampling()
    variables: Variables = Field(default_factory=dict)
    table: Columns = Field(default_factory=dict)
    constraints: Constraints = Field(default_factory=dict)
    lubricant: dict[str, Any]
    solid_1: SolidInput = SolidInput()
    solid_2: SolidInput = SolidInput()
    effective_modulus: case_inputs.Modulus | None = None
    surface: SurfaceInput = SurfaceInput()
    model: ModelInput = ModelInput()

    @classmethod
    def from_file(cls, path: str | Path, changes: Sequence[str] = ()) -> Plan:
        """Read and check a plan file.

        Parameters
        ----------
        path : str or Path
            The file, or the name of a shipped plan (``demo``). The path of a table is relative to the folder of the
            plan.
        changes : sequence of str
            Entries that replace those of the file, such as ``lubricant.oil=fva3`` or ``sampling.size=64``.

        Raises
        ------
        InputError
            An entry is missing, unknown or invalid.

        Examples
        --------
        >>> from regression import Plan
        >>> Plan.from_file("demo", ["lubricant.oil=fva3"]).oils
        ('fva3',)
        """
        path = named_file("file", "plans", path)
        content = read_toml(path, "plan")
        if not content:
            hint = "Copy a shipped plan, or see docs/sweep.md."
            raise InputError("file", str(path), "a plan with name, [variables], [sampling] and [lubricant]", hint)
        for change in changes:
            _apply(content, change)
        table = content.get("table")
        if isinstance(table, dict) and isinstance(table.get("file"), str):
            content["table"] = {**table, "file": str(path.parent / table["file"])}
        return validate(cls, content)

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> Plan:
        """Check a plan given as the tables of a plan file; values are SI numbers or texts with a unit.

        Raises
        ------
        InputError
            An entry is missing, unknown or invalid.

        Examples
        --------
        >>> from regression import Plan
        >>> plan = Plan.from_dict({
        ...     "name": "speeds",
        ...     "variables": {
        ...         "pressure_hertz": "1 GPa", "radius_equivalent": "10 mm", "slide_to_roll": 0.1,
        ...         "speed_entrainment": ["2 m/s", "4 m/s", "8 m/s"], "temperature_oil": "80 degC",
        ...     },
        ...     "lubricant": {"oil": "fva3"},
        ... })
        >>> plan.to_frame()["speed_entrainment"].tolist()
        [2.0, 4.0, 8.0]
        """
        return validate(cls, dict(content))

    @classmethod
    def from_json(cls, text: str) -> Plan:
        """Read a plan stored in a result file: validated values in SI units, with all defaults."""
        stored = parse_json(text, "plan", "of a result file")
        content = {key: value for key, value in stored.items() if value not in (None, {})}
        for key, field in cls.model_fields.items():
            if isinstance(field.default, InputModel):
                defaults = json.loads(field.default.model_dump_json())
                content[key] = {k: v for k, v in stored.get(key, {}).items() if v != defaults.get(k)}
        for key, kind in (("variables", PlanAxis), ("constraints", ConstraintWindow)):
            given = {name: entry for name, entry in stored.get(key, {}).items() if entry is not None}
            content[key] = {name: validate(kind, entry, f"plan.{key}.{name}") for name, entry in given.items()}
        return validate(cls, content)

    @model_validator(mode="after")
    def _checked(self) -> Self:
        self._check_names()
        self._check_sampling()
        if "oil" in self.lubricant and "temperature_oil" not in {*self.lubricant, *self.axes, *self.table}:
            raise InputError("variables.temperature_oil", None, "the oil temperature, a value or a range")
        if self._count_unconstrained > MAX_DRAWN * MAX_CASES:
            cases = f"{self._count_unconstrained:,} cases"
            hint = f"A plan with [constraints] may have {MAX_DRAWN * MAX_CASES} before they are applied."
            raise InputError("variables", cases, f"at most {MAX_CASES} cases", hint)
        # cases at both ends of every axis and for every row of a table are validated, so that errors appear at once
        for oil in self.oils or (None,):
            for end in (0, -1):
                ends = {name: axis.values[end] for name, axis in self.axes.items()}
                for row in range(self._rows if end == 0 else 1):
                    values = {name: float(column[row]) for name, column in self.columns.items()}
                    self.case({**ends, **values}, oil=self._oils_of([row], oil)[0])
        if self.count > MAX_CASES:
            raise InputError("variables", f"{self.count} cases", f"at most {MAX_CASES} cases")
        if self.count == 0:
            hint = "Widen the windows."
            raise InputError("constraints", "no case inside", "windows that leave at least one case", hint)
        return self

    def _check_names(self) -> None:
        given = {*self.axes, *self.table}
        for name in REQUIRED:
            if name not in given:
                raise InputError(f"variables.{name}", None, "a range, a list or a value, or a column of [table]")
        for name in set(self.table) & set(self.axes):
            raise InputError(f"variables.{name}", "given", f"{name} either in [variables] or in [table]")
        for one, other in EXCLUSIVE:
            if {one, other} <= given:
                raise InputError(f"variables.{one}", "given", f"only one of {one} and {other}")
        for name in sorted(set(self.lubricant) & given):
            raise InputError(f"lubricant.{name}", self.lubricant[name], f"either lubricant.{name} or variables.{name}")
        taken = {"roughness_rms_1", "roughness_rms_2", "profile_1", "profile_2"} | given
        for name in sorted(taken & self.surface.model_fields_set):
            allowed = f"{name} of [variables]" if name in given else "roughness_rms, roughness_rms_1 or roughness_rms_2"
            raise InputError(f"surface.{name}", getattr(self.surface, name), f"{allowed} of [variables]")

    def _check_sampling(self) -> None:
        sampling = self.sampling
        sampled = [name for name, axis in self.axes.items() if axis.sampled]
        size = sampling.size
        if sampled and self.table:
            raise InputError(f"variables.{sampled[0]}", "a range", "lists and values together with a [table]")
        if sampled and size is None:
            raise InputError("sampling.size", None, "the number of points for " + ", ".join(sampled))
        if size is not None and not sampled:
            raise InputError("sampling.size", size, "no size if no variable is a range")
        power = size is None or size & (size - 1) == 0
        if size is not None and not power and sampling.method == "sobol" and not self.constraints:
            below = 1 << (size.bit_length() - 1)
            raise InputError("sampling.size", size, f"a power of two such as {below} or {2 * below}")
        if sampling.corners and not 1 <= len(sampled) <= MAX_CORNER_VARIABLES:
            allowed = f"1 to {MAX_CORNER_VARIABLES} ranges; this plan has {len(sampled)}"
            raise InputError("sampling.corners", sampling.corners, allowed)
        if sampling.levels is not None and sampling.method != "factorial":
            raise InputError("sampling.levels", sampling.levels, "levels only with method = 'factorial'")

    @cached_property
    def axes(self) -> dict[str, PlanAxis]:
        """The variables; in a factorial plan every range is replaced by its levels."""
        axes = self.variables
        if self.sampling.method != "factorial":
            return axes
        if self.sampling.levels is None and any(axis.sampled for axis in axes.values()):
            raise InputError("sampling.levels", None, "the number of levels of each range")
        return {name: axis.levelled(self.sampling.levels or 2) for name, axis in axes.items()}

    @cached_property
    def oils(self) -> tuple[str, ...]:
        """Names of the oil cards; empty if the lubricant is given by numbers."""
        if "oil" in self.table:
            return tuple(dict.fromkeys(str(oil) for oil in self.table["oil"]))
        oil = self.lubricant.get("oil")
        if oil is None:
            return ()
        names = tuple(oil) if isinstance(oil, (list, tuple)) else (oil,)
        if names and all(isinstance(name, str) for name in names):
            names = tuple(same_name(name, data_names("oils")) for name in names)
            if len(set(names)) == len(names):
                return names
        raise InputError("lubricant.oil", oil, "a name, or a list of different names")

    @cached_property
    def count(self) -> int:
        """Number of cases."""
        return len(self.points) if self.constraints else self._count_unconstrained

    @property
    def _count_unconstrained(self) -> int:
        axes, corners = self.axes.values(), self.sampling.corners
        most: int = 2 ** sum(axis.sampled for axis in axes)
        points = (self.sampling.size or 1) + (most if corners is True else min(corners, most))
        lists = math.prod(len(axis.values) for axis in axes if not axis.sampled)
        oils = 1 if "oil" in self.table else max(len(self.oils), 1)
        return points * lists * self._rows * oils * self.sampling.realisations

    @property
    def _rows(self) -> int:
        """Rows of the table; 1 without a table."""
        return len(next(iter(self.table.values()), ("",)))

    @property
    def plan_hash(self) -> str:
        """Hash of all entries that influence the cases and their results."""
        content = self.model_dump(mode="json", exclude={"name", "description"})
        for key, names in (("variables", VARIABLES), ("constraints", WINDOWS)):
            content[key] = dict.fromkeys(names) | content[key]
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    @cached_property
    def points(self) -> PlanPoints:
        """All points, in a fixed order: by oil, list, origin, number and realisation."""
        origin: list[str] = []
        oils: list[str | None] = []
        columns: dict[str, list[FloatArray]] = {name: [] for name in (*self.axes, *self.columns)}
        numbers: list[IntArray] = []
        rejected: Counter[str] = Counter()
        for oil in (None,) if "oil" in self.table else self.oils or (None,):
            for fixed in lattice(self.axes):
                for block in self._blocks(self._constraint_filter(fixed, oil, rejected)):
                    n = block.number.size
                    origin += [block.origin] * n
                    oils += self._oils_of(block.number, oil)
                    numbers.append(block.number)
                    for name, parts in columns.items():
                        parts.append(block.columns[name] if name in block.columns else np.full(n, fixed[name]))
        repeat, number = self.sampling.realisations, np.concatenate(numbers)
        own = np.zeros_like(number) if self.sampling.same_profile else number
        return PlanPoints(
            tuple(o for o in origin for _ in range(repeat)),
            {name: np.repeat(np.concatenate(parts), repeat) for name, parts in columns.items()},
            tuple(o for o in oils for _ in range(repeat)),
            np.asarray(self.surface.seed + (own[:, None] * repeat + np.arange(repeat)).ravel()),
            {name: count / rejected["drawn"] for name, count in rejected.items() if name != "drawn"},
        )

    def _blocks(self, accept: Accept) -> Iterator[PointBlock]:
        sampler = BoxSampler(self.axes, self.sampling.method, self.sampling.seed)
        if self.table:
            yield filtered("table", self.columns, np.arange(self._rows), accept)
        elif sampler.ranges:
            assert self.sampling.size is not None
            yield sampler.inside(self.sampling.size, accept)
            if self.sampling.corners:
                yield sampler.corners(None if self.sampling.corners is True else int(self.sampling.corners), accept)
        else:
            yield filtered("lattice", {}, np.arange(1), accept)

    def _oils_of(self, rows: Iterable[int], oil: str | None) -> list[str | None]:
        """Oil card of each point: that of its row of the table, otherwise `oil`."""
        return [str(self.table["oil"][row]) if "oil" in self.table else oil for row in rows]

    def _constraint_filter(self, fixed: Mapping[str, float], oil: str | None, rejected: Counter[str]) -> Accept:
        """Function that selects points inside all windows of the constraints.

        `rejected` counts the points outside of each window, and all points under ``drawn``.
        """

        def accept(columns: dict[str, FloatArray], number: IntArray) -> NDArray[np.bool_]:
            values = {**{name: np.full(number.size, value) for name, value in fixed.items()}, **columns}
            quantities = self.constrained(values, self._oils_of(number, oil)) if self.constraints else {}
            passed = np.ones(number.size, dtype=bool)
            for name, window in self.constraints.items():
                inside = window.holds(quantities[name])
                rejected[name] += int(np.count_nonzero(~inside))
                passed &= inside
            rejected["drawn"] += number.size
            return passed

        return accept

    def constrained(self, columns: Mapping[str, FloatArray], oils: Sequence[str | None]) -> dict[str, FloatArray]:
        """The quantities of `Constraints` at given values of the variables."""
        needs_oil = "film_ratio" in self.constraints
        ratio = self.conditions(columns, oils)["film_ratio_formula"] if needs_oil else None
        return constrained_quantities(self._state_columns(columns, len(oils)), self.bodies, ratio)

    def conditions(self, columns: Mapping[str, FloatArray], oils: Sequence[str | None]) -> dict[str, FloatArray]:
        """All variables of formulas at given values of the variables of the plan."""
        return derive({**self._state_columns(columns, len(oils)), **self._lubricant_columns(columns, oils)})

    def _state_columns(self, columns: Mapping[str, FloatArray], size: int) -> dict[str, FloatArray]:
        """Columns of `regression.friction.conditions.STATE_UNITS` from the values of the variables."""
        given = self.lubricant.get("temperature_oil", 353.15)
        temperature = VARIABLES["temperature_oil"].check(given, "lubricant.temperature_oil")
        table = {
            "effective_modulus": np.full(size, self.effective_modulus or effective_modulus(*self.bodies)),
            "speed_sliding_lengthwise": np.zeros(size),
            "temperature_oil": np.full(size, temperature),
            "roughness_rms_1": np.zeros(size),
            "roughness_rms_2": np.zeros(size),
            **_expanded(columns),
        }
        if "correlation_length" in self.surface.model_fields_set:
            table["correlation_length"] = np.full(size, self.surface.correlation_length)
        elif "correlation_length" not in table:
            table["correlation_length"] = default_correlation_length(table["roughness_rms_1"], table["roughness_rms_2"])
        if "peklenik_number" not in table:
            table["peklenik_number"] = np.full(size, self.surface.peklenik_number)
        return table

    def _lubricant_columns(
        self, columns: Mapping[str, FloatArray], oils: Sequence[str | None]
    ) -> dict[str, FloatArray]:
        """Columns of `regression.friction.conditions.LUBRICANT_UNITS` at the points."""
        names = [name for name in columns if name in DirectLubricant.model_fields and name != "temperature_oil"]
        # groups of points that differ in temperature only
        groups: dict[tuple[Any, ...], list[int]] = {}
        for i, oil in enumerate(oils):
            groups.setdefault((oil, *(float(columns[name][i]) for name in names)), []).append(i)
        temperature = columns.get("temperature_oil")
        found = {name: np.empty(len(oils)) for name in LUBRICANT_UNITS}
        for (oil, *values), rows in groups.items():
            content = {**self.lubricant, **dict(zip(names, values, strict=True))}
            if oil is not None:
                content["oil"] = oil
            for part in [rows] if "oil" in content else [[row] for row in rows]:
                if temperature is not None:
                    content["temperature_oil"] = float(temperature[part[0]])
                if "oil" in content:
                    given = validate(OilLubricant, content, "lubricant")
                    lubricant = given.lubricant(None if temperature is None else temperature[part])
                else:
                    lubricant = validate(DirectLubricant, content, "lubricant").lubricant()
                for name, column in lubricant_columns(lubricant, columns["pressure_hertz"][part]).items():
                    found[name][part] = column
        return found

    def case_seconds(self) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Estimated processor time of every case of `points` [s], and which of them are transient rough contacts."""
        return contact_seconds(self.model, self.conditions(self.points.columns, self.points.oils))

    def estimate(self, time_cap: float | str | None = None) -> CostEstimate:
        """Estimated computation time of the plan; cases stop after `time_cap` [s], if given.

        Examples
        --------
        >>> from regression import Plan
        >>> cost = Plan.from_file("gear").estimate()
        >>> cost.cases
        512
        >>> cost.wall(jobs=4) < cost.seconds
        True
        """
        seconds, rough = self.case_seconds()
        seconds = np.minimum(
            seconds, np.inf if time_cap is None else ALLOWED_TIME_CAP.check_given(time_cap, "time_cap")
        )
        return CostEstimate(
            self.name,
            self.model.accuracy,
            len(seconds),
            int(np.count_nonzero(rough)),
            float(seconds.sum()),
            float(seconds.max()),
            self.points.rejected,
        )

    def to_frame(self) -> pd.DataFrame:
        """One row per case, in the order of the plan: origin, oil, seed of the roughness, and variables in SI units."""
        import pandas as pd

        points = self.points
        return pd.DataFrame({"origin": points.origin, "oil": points.oils, "seed": points.seed, **points.columns})

    def __repr__(self) -> str:
        varied = ", ".join(name for name, axis in self.axes.items() if axis.sampled or len(axis.values) > 1)
        words = f"{', '.join(self.oils) or 'a lubricant by numbers'}; over {varied or 'a table of points'}"
        return f"Plan {self.name!r}: {counted(self.count, 'case')}, accuracy {self.model.accuracy}; {words}"

    __str__ = __repr__

    def to_dict(self) -> dict[str, Any]:
        """All entries in SI units, with their defaults, as stored with results (`from_json`)."""
        return self.model_dump(mode="json")

    def sections(self, medium: Medium = "page", *args: Any, **options: Any) -> list[Section]:
        """Ends and number of values of each variable."""
        columns = {**{name: axis.values for name, axis in self.axes.items()}, **self.table}
        sampled = {name: axis.scale for name, axis in self.axes.items() if axis.sampled}
        rows = (
            ("low", *(min(values) for values in columns.values())),
            ("high", *(max(values) for values in columns.values())),
            ("values", *(f"{sampled[name]} range" if name in sampled else len(v) for name, v in columns.items())),
        )
        table = Table(("", *columns), rows, title=repr(self), vertical=True)
        return [Section("", [Head(table.title), table])]

    @cached_property
    def columns(self) -> dict[str, FloatArray]:
        """The numeric columns of the table."""
        return {name: np.array(cells, dtype=float) for name, cells in self.table.items() if name != "oil"}

    @property
    def bodies(self) -> tuple[Material, Material]:
        """Both bodies."""
        return self.solid_1.body(), self.solid_2.body()

    def cases(self) -> Iterator[tuple[str, Contact]]:
        """Origin and contact of every point of the plan, in a fixed order."""
        for index, origin in enumerate(self.points.origin):
            yield origin, self.case_at(index)

    def case_at(self, index: int) -> Contact:
        """The contact of one point of `points`."""
        points = self.points
        values = {name: float(column[index]) for name, column in points.columns.items()}
        return self.case(values, oil=points.oils[index], seed=int(points.seed[index]))

    def case(self, values: Mapping[str, float], *, oil: str | None = None, seed: int | None = None) -> Contact:
        """The contact at `values` of the variables [SI], with one of several oils and the seed of its roughness.

        Raises
        ------
        InputError
            A constant value of the plan is invalid in a case.
        """
        tables: dict[str, dict[str, Any]] = {
            "contact": {},
            "lubricant": {**self.lubricant, **({} if oil is None else {"oil": oil})},
            "surface": self.surface.model_dump(exclude_unset=True) | ({} if seed is None else {"seed": seed}),
        }
        for name, value in _expanded(values).items():
            tables[KEYWORDS[name][0]][name] = value
        if self.effective_modulus is not None:
            tables["contact"]["effective_modulus"] = self.effective_modulus
        bodies = {"solid_1": self.solid_1, "solid_2": self.solid_2, "model": self.model}
        return validate(Contact, {**tables, **bodies})


def _expanded(values: Mapping[str, Any]) -> dict[str, Any]:
    """Values with lengthwise sliding and Rq of both surfaces instead of the ratio and the composite Rq."""
    found = dict(values)
    if "lengthwise_to_roll" in found:
        found["speed_sliding_lengthwise"] = found.pop("lengthwise_to_roll") * found["speed_entrainment"]
    if "roughness_rms" in found:
        found["roughness_rms_1"] = found["roughness_rms_2"] = found.pop("roughness_rms") / 2.0**0.5
    return found


def _apply(content: dict[str, Any], change: str) -> None:
    key, equals, text = change.partition("=")
    *tables, name = (part.strip() for part in key.split("."))
    if not equals or not name or not all(tables):
        raise InputError("changes", change, "KEY=VALUE such as lubricant.oil=fva3")
    try:
        value = parse_toml(f"value = {text}", "changes", change)["value"]
    except InputError:
        value = text.strip()  # text without quotes
    target = content
    for table in tables:
        target = target.setdefault(table, {})
        if not isinstance(target, dict):
            raise InputError("changes", change, f"a key of a table; {table} is not a table")
    target[name] = value
