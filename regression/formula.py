"""The formula file: a fitted friction formula with everything needed to use and to judge it, as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from ehl.errors import InputError
from ehl.units import Quantity
from ehl.validation import InputModel, validate
from regression.conditions import UNITS, Array, Conditions
from regression.families import Family, family_named

FORMULA_SCHEMA = 1
# ranges are met by numbers that went through unit conversion and roots
_RANGE_TOLERANCE = 1e-6

Finite = Annotated[float, Quantity("")]
Width = Annotated[float, Quantity("", ge=0.0)]


class OilIdentity(InputModel):
    """The oil the data were computed for; `name` is None for a lubricant given by numbers."""

    name: str | None = None
    card_hash: str | None = None


class WorstCase(InputModel):
    """The case with the largest relative error."""

    key: str
    relative_error: Finite
    conditions: dict[str, Finite]


class Scores(InputModel):
    """Errors of predicted against computed friction; relative ones are (predicted - computed)/computed."""

    count: int
    r2: Finite
    r2_log: Finite
    rmse: Finite
    mape: Finite
    p95: Finite
    largest: Finite
    bias: Finite
    worst: WorstCase


class Band(InputModel):
    """Cross-validated errors within one band of one variable."""

    variable: str
    low: Finite
    high: Finite
    count: int
    mape: Finite
    p95: Finite
    bias: Finite


class WidthBand(InputModel):
    """Half width of the interval within one band of `film_ratio_formula` (low <= value < high).

    `coverage` is the share of the band's held-out cases that lie within widths calibrated on the other folds; None in
    files written before it was measured.
    """

    low: Finite
    high: Finite | None
    count: int
    log_width: Width
    coverage: Annotated[float, Quantity("", ge=0.0, le=1.0)] | None = None

    @model_validator(mode="after")
    def _ordered(self) -> WidthBand:
        if self.high is not None and self.high <= self.low:
            raise InputError("high", self.high, f"above the low end {self.low:.6g}")
        return self


class Interval(InputModel):
    """Interval of the cross-validated error of ln mu: mu exp(-w) to mu exp(+w).

    `log_width` covers the share `level` of all held-out cases, that of a band the same share of the cases in it;
    `largest` is the greatest error of all and is used outside the range.
    """

    level: Annotated[float, Quantity("", gt=0.0, lt=1.0)]
    log_width: Width
    largest: Width
    bands: tuple[WidthBand, ...] = ()

    def width(self, conditions: Conditions) -> Array:
        """Half width at every point, by its band; that of all cases where no band holds it."""
        ratio = np.asarray(conditions["film_ratio_formula"], dtype=float)
        width = np.full(ratio.shape, self.log_width)
        for band in self.bands:
            inside = (ratio >= band.low) & (True if band.high is None else ratio < band.high)
            width = np.where(inside, band.log_width, width)
        return width


class DataIdentity(InputModel):
    """Where the numbers come from."""

    hash: str
    plan: str
    plan_hash: str
    solver_version: str
    count: int
    used: int
    excluded: dict[str, int]


@dataclass(frozen=True)
class FormulaValue:
    """A formula at many points.

    Parameters
    ----------
    mu, lower, upper : array
        Friction coefficient and its interval [-].
    outside : array of bool
        At least one variable lies outside the range of the data.
    undefined : array of bool
        No finite positive value; mu and its interval are nan.
    """

    mu: Array
    lower: Array
    upper: Array
    outside: NDArray[np.bool_]
    undefined: NDArray[np.bool_]


class Formula(InputModel):
    """A fitted friction formula: the content of a formula file."""

    schema_version: int = Field(alias="schema")
    writer: str
    family: str
    equation: str
    coefficients: dict[str, Finite]
    standard_errors: dict[str, Finite]
    dropped: dict[str, str]
    variance_inflation: dict[str, Finite]
    condition_number: Finite
    boundary_friction: Annotated[float, Quantity("", ge=0.0, le=1.0)]
    ranges: dict[str, tuple[Finite, Finite]]
    units: dict[str, str]
    oil: OilIdentity
    fit: Scores
    validation: Scores
    corners: Scores | None
    folds: int
    bands: tuple[Band, ...]
    interval: Interval
    noise_floor: Finite
    data: DataIdentity

    @model_validator(mode="after")
    def _consistent(self) -> Formula:
        family = family_named(self.family)
        for term in family.terms:
            if term not in self.coefficients:
                raise InputError(f"coefficients.{term}", None, "a number")
        for term in self.coefficients:
            if term not in family.terms:
                raise InputError(f"coefficients.{term}", term, "one of " + ", ".join(family.terms))
        if self.equation != family.equation:
            hint = "The program computes its own equation whatever the file says: fit the formula again."
            raise InputError("equation", self.equation, f"that of family {family.name}: {family.equation}", hint)
        for name, (low, high) in self.ranges.items():
            if name not in UNITS:
                raise InputError(f"ranges.{name}", name, "one of " + ", ".join(UNITS))
            if low > high:
                unit = UNITS[name] or "1"
                raise InputError(f"ranges.{name}", [low, high], f"the lower end first, then the upper one, in {unit}")
        for name, unit in self.units.items():
            if unit != UNITS.get(name):
                allowed = repr(UNITS[name]) if name in UNITS else "a unit of one of " + ", ".join(UNITS)
                raise InputError(f"units.{name}", unit, allowed, "The numbers of the file are in SI units.")
        return self

    @property
    def form(self) -> Family:
        """The family this formula belongs to."""
        return family_named(self.family)

    def outside(self, conditions: Conditions) -> NDArray[np.bool_]:
        """Where at least one variable lies outside its range."""
        result = np.zeros(np.shape(conditions["pressure_hertz"]), dtype=bool)
        for name, (low, high) in self.ranges.items():
            slack = _RANGE_TOLERANCE * max(abs(low), abs(high))
            result |= (conditions[name] < low - slack) | (conditions[name] > high + slack)
        return result

    def evaluate(self, conditions: Conditions) -> FormulaValue:
        """Friction at many points.

        Below the least sliding of the data mu falls linearly to 0 with it: the form itself may be infinite there.

        Parameters
        ----------
        conditions : mapping
            The variables of `regression.conditions.UNITS` as arrays of one shape.

        Returns
        -------
        FormulaValue
        """
        outside = self.outside(conditions)
        least = self.ranges.get("slide_to_roll_total", (0.0, 0.0))[0]
        table, ramp = _with_least_sliding(conditions, least)
        shape = np.shape(outside)
        flat = {name: np.ravel(values) for name, values in table.items()}
        with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
            mu = np.exp(self.form.log_mu(flat, self.coefficients, self.boundary_friction)).reshape(shape)
        # 0 is an exponential that fell below the range of numbers
        undefined = ~(np.isfinite(mu) & (mu > 0.0))
        mu = np.where(undefined, np.nan, mu * ramp)
        width = np.where(outside, self.interval.largest, self.interval.width(conditions))
        return FormulaValue(mu, mu * np.exp(-width), mu * np.exp(width), outside, undefined)

    def to_text(self) -> str:
        """The equation and its coefficients, to read and to type in."""
        lines = [f"{self.family}: {self.form.title}", self.equation, ""]
        for term in self.form.terms:
            note = f"  ({self.dropped[term]})" if term in self.dropped else ""
            error = self.standard_errors.get(term)
            spread = f" +- {error:.3g}" if error is not None and not note else ""
            lines.append(f"  {term} = {self.coefficients[term]:.9g}{spread}{note}")
        lines += ["", "range:"]
        lines += [f"  {name}: {low:.6g} to {high:.6g} {UNITS[name]}" for name, (low, high) in self.ranges.items()]
        return "\n".join(lines)

    def to_json(self) -> str:
        """The file's text; numbers keep all their digits."""
        content = self.model_dump(mode="json", by_alias=True)
        return json.dumps(content, indent=2, allow_nan=False) + "\n"

    def save(self, path: str | Path) -> None:
        """Write the formula file.

        Raises
        ------
        InputError
            The file cannot be written.
        """
        try:
            Path(path).write_text(self.to_json(), encoding="utf-8")
        except OSError as error:
            raise InputError("formula file", str(path), "a writable path", f"{error.strerror}.") from None


def _with_least_sliding(conditions: Conditions, least: float) -> tuple[Mapping[str, Array], Array]:
    total = conditions["slide_to_roll_total"]
    if least <= 0.0:
        return conditions, np.ones(np.shape(total))
    floored = np.maximum(total, least)
    table = dict(conditions)
    table["slide_to_roll_total"] = floored
    table["speed_sliding"] = floored * np.abs(conditions["speed_entrainment"])
    return table, np.minimum(total / least, 1.0)


def load_formula(path: str | Path) -> Formula:
    """Read a formula file.

    Raises
    ------
    InputError
        The file does not exist, is no formula file, was damaged, or was written with a newer schema.
    """
    path = Path(path)
    allowed = "a formula file written by `mixed-ehl fit`"
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError("formula file", str(path), allowed, "The file does not exist.") from None
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise InputError("formula file", str(path), allowed, f"It could not be read: {error}.") from None
    if not isinstance(content, dict) or not isinstance(content.get("schema"), int):
        raise InputError("formula file", str(path), allowed, "It holds no schema number.")
    if content["schema"] > FORMULA_SCHEMA:
        raise InputError(
            f"{path.name}.schema",
            content["schema"],
            f"at most {FORMULA_SCHEMA}",
            f"It was written by the newer version {content.get('writer', 'unknown')}; update mixed-ehl to read it.",
        )
    return validate(Formula, content, path.name)
