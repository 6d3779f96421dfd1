"""The plan of a sweep: which contacts are solved (`mixed-ehl sweep PLAN.toml`).

A variable is a range (sampled by Sobol or a Latin hypercube), a list or the levels of a range (full factorial), one
value, or a column of a table; lists multiply the sampled points. Constraints skip what no gear has.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from ehl import inputs as case_inputs
from ehl.contact import Contact
from ehl.inputs import ModelInput, SolidInput, SurfaceInput
from ehl.io.errors import InputError
from ehl.io.table_files import Column, read_columns
from ehl.io.units import ValueRange
from ehl.io.validation import InputModel, read_toml, validate
from ehl.material import Material, effective_modulus
from regression.plan.axes import EXCLUSIVE, REQUIRED, VARIABLES, Axis, Variables, levels_of, quantity_of
from regression.plan.constraints import Constraints
from regression.plan.sampling import Array

if TYPE_CHECKING:
    from regression.plan.points import PlanPoints

MAX_CASES = 1_000_000
# 2^d corner points; beyond this a plan asks for more corners than samples
MAX_CORNER_VARIABLES = 10
# what a table of points may hold; the oil is a text
QUANTITIES: dict[str, ValueRange | None] = {**{n: quantity_of(a) for n, a in VARIABLES.items()}, "oil": None}


def _read_columns(value: Any) -> dict[str, Column]:
    return read_columns(value, QUANTITIES)


class Sampling(InputModel):
    """How ranges are filled, whether the corners of the box are added, and how many roughness profiles a point meets.

    Parameters
    ----------
    method : {"sobol", "latin_hypercube", "factorial"}
        Filling of the ranges; factorial crosses `levels` of each.
    size : int
        Points in the ranges: a power of two for Sobol without constraints.
    levels : int
        Of every range in a factorial plan that does not state its own.
    seed : int
        Of the sequence.
    corners : bool or int
        Add the corners of the box, all or so many of them; they are kept out of the fit.
    realisations : int
        Roughness profiles per point, each a case of its own (deterministic roughness only).
    same_profile : bool
        All points meet the profiles of the same seeds; otherwise every point has its own.
    """

    method: Literal["sobol", "latin_hypercube", "factorial"] = "sobol"
    size: Annotated[int, Field(ge=1, le=MAX_CASES)] | None = None
    levels: Annotated[int, Field(ge=2, le=1000)] | None = None
    seed: Annotated[int, Field(ge=0)] = 1
    corners: bool | Annotated[int, Field(ge=1)] = False
    realisations: Annotated[int, Field(ge=1, le=1000)] = 1
    same_profile: bool = False


class Adaptive(InputModel):
    """Batches of further points where a surrogate knows least (`mixed-ehl sweep --adaptive`).

    Parameters
    ----------
    batch : int
        Points added at a time.
    budget : int
        Cases in all, those of the plan included.
    gain : float
        The sweep ends when two batches together lower the cross-validated error by less than this part of it.
    weight : str
        Column whose product with the surrogate's variance is sought; `pressure_velocity` is p_h times the sliding
        speed, to which the power loss of a gear is proportional; `uniform` is none.
    """

    batch: Annotated[int, Field(ge=1, le=4096)] = 64
    budget: Annotated[int, Field(ge=1, le=MAX_CASES)] = 1024
    gain: Annotated[float, Field(gt=0.0, lt=1.0)] = 0.05
    weight: Literal["pressure_velocity", "speed_sliding", "load_per_length", "uniform"] = "pressure_velocity"


class Plan(InputModel):
    """A sweep: the content of a plan file."""

    name: str = Field(min_length=1, max_length=100)
    description: str = ""
    sampling: Sampling = Sampling()
    variables: Variables = Variables()
    table: Annotated[dict[str, Column], BeforeValidator(_read_columns)] = Field(default_factory=dict)
    constraints: Constraints = Constraints()
    adaptive: Adaptive = Adaptive()
    lubricant: dict[str, Any]
    solid_1: SolidInput = SolidInput()
    solid_2: SolidInput = SolidInput()
    effective_modulus: case_inputs.Modulus | None = None
    surface: SurfaceInput = SurfaceInput()
    model: ModelInput = ModelInput()

    @model_validator(mode="after")
    def _whole(self) -> Self:
        self._check_names()
        self._check_sampling()
        if "oil" in self.lubricant and "temperature_oil" not in {*self.lubricant, *self.axes, *self.table}:
            raise InputError("variables.temperature_oil", None, "the oil temperature, a value or a range")
        # both ends of every axis and every row of a table go through the case model, so that a bad plan fails at once
        rows = len(next(iter(self.table.values()), ("",)))
        for oil in self.oils or (None,):
            for end in (0, -1):
                ends = {name: axis.values[end] for name, axis in self.axes.items()}
                for row in range(rows if end == 0 else 1):
                    self.case({**ends, **self._row(row)}, oil=self._row_oil(row) or oil)
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
        taken = {"roughness_rms_1", "roughness_rms_2", "profile_1", "profile_2"} | (given & set(TABLE_OF))
        for name in sorted(taken & self.surface.model_fields_set):
            allowed = f"{name} of [variables]" if name in given else "roughness_rms, roughness_rms_1 or roughness_rms_2"
            raise InputError(f"surface.{name}", getattr(self.surface, name), f"{allowed} of [variables]")
        if "seed" in self.surface.model_fields_set and self.model.roughness == "load_sharing":
            raise InputError("surface.seed", self.surface.seed, "a seed only with model.roughness = 'deterministic'")

    def _check_sampling(self) -> None:
        sampling = self.sampling
        sampled = [name for name, axis in self.axes.items() if axis.sampled]
        size = sampling.size
        if sampled and self.table:
            raise InputError(f"variables.{sampled[0]}", "a range", "lists and values beside a [table]")
        if sampled and size is None:
            raise InputError("sampling.size", None, "the number of points for " + ", ".join(sampled))
        if size is not None and not sampled:
            raise InputError("sampling.size", size, "no size where no variable is a range")
        power = size is None or size & (size - 1) == 0
        if size is not None and not power and sampling.method == "sobol" and not self.constraints.windows:
            below = 1 << (size.bit_length() - 1)
            raise InputError("sampling.size", size, f"a power of two such as {below} or {2 * below}")
        if sampling.corners and not 1 <= len(sampled) <= MAX_CORNER_VARIABLES:
            raise InputError(
                "sampling.corners",
                sampling.corners,
                f"1 to {MAX_CORNER_VARIABLES} ranges; this plan has {len(sampled)}",
            )
        if sampling.levels is not None and sampling.method != "factorial":
            raise InputError("sampling.levels", sampling.levels, "levels only with method = 'factorial'")
        if sampling.realisations > 1 and self.model.roughness == "load_sharing":
            hint = "Load sharing knows Rq alone."
            raise InputError(
                "sampling.realisations", sampling.realisations, "1 unless model.roughness = 'deterministic'", hint
            )

    @cached_property
    def axes(self) -> dict[str, Axis]:
        """The variables; in a factorial plan the ranges are levels."""
        axes = self.variables.axes
        if self.sampling.method != "factorial":
            return axes
        if self.sampling.levels is None and any(axis.sampled for axis in axes.values()):
            raise InputError("sampling.levels", None, "the number of levels of each range")
        return {
            name: Axis(values=levels_of(axis, self.sampling.levels or 2), scale=axis.scale) if axis.sampled else axis
            for name, axis in axes.items()
        }

    @cached_property
    def oils(self) -> tuple[str, ...]:
        """Names of the oil cards; empty where the lubricant is given by numbers."""
        if "oil" in self.table:
            return tuple(dict.fromkeys(str(oil) for oil in self.table["oil"]))
        oil = self.lubricant.get("oil")
        if oil is None:
            return ()
        names = tuple(str(name) for name in oil) if isinstance(oil, (list, tuple)) else (str(oil),)
        if not names or len(set(names)) < len(names):
            raise InputError("lubricant.oil", oil, "a name, or a list of different names")
        return names

    @property
    def oil(self) -> str | None:
        """Name of the oil card; None where there are several or the lubricant is given by numbers."""
        return self.oils[0] if len(self.oils) == 1 else None

    @cached_property
    def count(self) -> int:
        """Number of cases."""
        if self.constraints.windows:
            return len(self.points)
        axes = self.axes.values()
        sampled = sum(axis.sampled for axis in axes)
        corners = min(self.sampling.corners, 2**sampled) if type(self.sampling.corners) is int else 2**sampled
        points = (self.sampling.size or 1) + (corners if self.sampling.corners else 0)
        for axis in axes:
            points *= 1 if axis.sampled else len(axis.values)
        if self.table:
            points *= len(next(iter(self.table.values())))
        return points * (1 if "oil" in self.table else max(len(self.oils), 1)) * self.sampling.realisations

    @property
    def plan_hash(self) -> str:
        """Hash of everything that decides the cases and their results."""
        content = self.model_dump(mode="json", exclude={"name", "description", "adaptive"})
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    @cached_property
    def points(self) -> PlanPoints:
        """All points, in a fixed order: by oil, list, origin, number and realisation."""
        from regression.plan.points import plan_points

        return plan_points(self)

    @cached_property
    def columns(self) -> dict[str, Array]:
        """The columns of numbers of the table."""
        return {name: np.array(cells, dtype=float) for name, cells in self.table.items() if name != "oil"}

    @property
    def modulus(self) -> float:
        """Effective modulus E' [Pa]."""
        return self.effective_modulus or effective_modulus(*self.bodies)

    @property
    def bodies(self) -> tuple[Material, Material]:
        """Both bodies."""
        return self.solid_1.body(), self.solid_2.body()

    def cases(self) -> Iterator[tuple[str, Contact]]:
        """Origin and case of every point of the plan, in a fixed order."""
        for index, origin in enumerate(self.points.origin):
            yield origin, self.case_at(index)

    def case_at(self, index: int) -> Contact:
        """The case of one point of `points`."""
        points = self.points
        seed = None if points.seed is None else int(points.seed[index])
        return self.case(points.values(index), oil=points.oils[index], seed=seed)

    def _row(self, row: int) -> dict[str, float]:
        return {name: float(column[row]) for name, column in self.columns.items()}

    def _row_oil(self, row: int) -> str | None:
        return str(self.table["oil"][row]) if "oil" in self.table else None

    def case(self, values: Mapping[str, float], *, oil: str | None = None, seed: int | None = None) -> Contact:
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
            "lubricant": {**self.lubricant, **({} if oil is None else {"oil": oil})},
            "surface": self.surface.model_dump(exclude_unset=True) | ({} if seed is None else {"seed": seed}),
        }
        for name, value in v.items():
            tables[TABLE_OF[name]][name] = value
        if self.effective_modulus is not None:
            tables["contact"]["effective_modulus"] = self.effective_modulus
        bodies = {"solid_1": self.solid_1, "solid_2": self.solid_2, "model": self.model}
        return validate(Contact, {**tables, **bodies})


TABLE_OF = {
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
    "correlation_length": "surface",
    "peklenik_number": "surface",
    "boundary_film": "surface",
    "boundary_friction": "surface",
}


def load_plan(path: str | Path, changes: Sequence[str] = ()) -> Plan:
    """Read and check a plan file; the name of a shipped plan (``demo``) serves too.

    Parameters
    ----------
    path : str or Path
        The file; a table it names lies beside it.
    changes : sequence of str
        Entries to put in place of the file's, as ``lubricant.oil=fva3`` or ``sampling.size=64``.

    Raises
    ------
    InputError
        Naming field, value and allowed range.
    """
    from ehl.io.data import data_names, data_path

    if str(path) in data_names("plans"):
        path = data_path("plans", f"{path}.toml")
    content = read_toml(path)
    if not content:
        hint = "Copy a shipped plan, or see docs/sweep.md."
        raise InputError("file", str(path), "a plan with name, [variables], [sampling] and [lubricant]", hint)
    for change in changes:
        _apply(content, change)
    table = content.get("table")
    if isinstance(table, dict) and isinstance(table.get("file"), str):
        content["table"] = {**table, "file": str(Path(path).parent / table["file"])}
    return validate(Plan, content)


def _apply(content: dict[str, Any], change: str) -> None:
    import tomllib

    key, equals, text = change.partition("=")
    *tables, name = (part.strip() for part in key.split("."))
    if not equals or not name or not all(tables):
        raise InputError("--set", change, "KEY=VALUE such as lubricant.oil=fva3")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        # a bare word is a text
        value = text.strip()
    place = content
    for table in tables:
        place = place.setdefault(table, {})
        if not isinstance(place, dict):
            raise InputError("--set", change, f"a key of a table; {table} is none")
    place[name] = value
