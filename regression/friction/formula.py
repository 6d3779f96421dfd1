"""A fitted friction formula with everything needed to use and to judge it, and its JSON file."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, cast

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from ehl.common.errors import InputError
from ehl.common.files import parse_json, read_text, write_file
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel, validate
from regression.friction.conditions import UNITS, Array, Conditions
from regression.friction.data_cloud import DataCloud, Extrapolation
from regression.friction.error_tables import Band, Finite, Interval, NoiseFloor, Scores
from regression.friction.families import Family, family_named
from regression.friction.gaussian_process import GpResidual, Sums, corrected_parts

_ALLOWED = "a formula file as `mixed-ehl fit RUN -o FILE.json` writes it"
FORMULA_SCHEMA = 3
# of either end: the cases of a plan end a little inside of its box
_SMALLEST = 1e-300  # below any value a variable can have
RANGE_TOLERANCE = 1e-3
THICK_FILM = 2.0  # lambda from which mu is that of the film, whatever the roughness

Friction = Annotated[float, ValueRange("", ge=0.0, le=1.0)]


class OilIdentity(InputModel):
    """An oil the data were computed for; `card_hash` is None where it is not known."""

    name: str | None = None
    card_hash: str | None = None


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
    extrapolation : array of int
        `regression.friction.data_cloud.Extrapolation`: inside, near or far from the fitted cases.
    undefined : array of bool
        No finite positive value; mu and its interval are nan.
    """

    mu: Array
    lower: Array
    upper: Array
    outside: NDArray[np.bool_]
    extrapolation: NDArray[np.int8]
    undefined: NDArray[np.bool_]


class FittedFormula(InputModel):
    """A fitted friction formula: the content of a formula file.

    What schema 1 did not know is None there: `residual`, `cloud`, `paths`, `unseen`, `nested`, `noise`. With
    `film_residual` the first process corrects the logit of the asperity load share, the second ln of the friction of
    the film.
    """

    schema_version: int = Field(alias="schema")
    writer: str
    family: str
    equation: str
    coefficients: dict[str, Finite]
    standard_errors: dict[str, Finite]
    dropped: dict[str, str]
    variance_inflation: dict[str, Finite]
    condition_number: Finite
    boundary_friction: Friction
    boundary_friction_range: tuple[Friction, Friction] | None = None
    ranges: dict[str, tuple[Finite, Finite]]
    units: dict[str, str]
    oils: tuple[OilIdentity, ...]
    fit: Scores
    validation: Scores
    corners: Scores | None
    paths: Scores | None = None
    unseen: Scores | None = None
    unseen_bands: tuple[Band, ...] = ()
    nested: Scores | None = None
    folds: int
    bands: tuple[Band, ...]
    interval: Interval
    noise_floor: Finite
    noise: NoiseFloor | None = None
    data: DataIdentity
    cloud: DataCloud | None = None
    residual: GpResidual | None = None
    film_residual: GpResidual | None = None

    @model_validator(mode="after")
    def _consistent(self) -> FittedFormula:
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
        if self.interval.normalised and self.residual is None:
            raise InputError("interval.normalised", True, "false where there is no Gaussian-process residual")
        if self.film_residual is not None and (self.residual is None or family.parts is None):
            allowed = "a second process only beside the first, of a family that gives both parts of mu"
            raise InputError("film_residual", self.family, allowed)
        return self

    @property
    def form(self) -> Family:
        """The family this formula belongs to."""
        return family_named(self.family)

    @property
    def processes(self) -> tuple[GpResidual, ...]:
        """The Gaussian processes: none, one of ln mu, or those of the share and of the film."""
        if self.residual is None:
            return ()
        return (self.residual,) if self.film_residual is None else (self.residual, self.film_residual)

    @property
    def name(self) -> str:
        """The family, with the residual if there is one, for tables."""
        return self.family if self.residual is None else f"{self.family} + GP"

    @property
    def oil(self) -> OilIdentity:
        """The oil of a formula of one oil; nameless where there are several, or none by name."""
        return self.oils[0] if len(self.oils) == 1 else OilIdentity()

    def with_roughness_in_range(self, conditions: Conditions) -> Conditions:
        """Conditions with the roughness moved into its range where films are so thick that it leaves friction alone.

        So smooth contacts (Rq = 0) are within the range: above lambda 2 mu is that of the film.
        """
        # here and below ufuncs only: `regression.export` records them
        thick = conditions["film_ratio_formula"] >= THICK_FILM
        moved = dict(conditions)
        for name, (low, high) in self.ranges.items():
            if name == "roughness_rms":
                moved[name] = np.where(thick, np.maximum(conditions[name], low), conditions[name])
            elif name in ("correlation_length", "peklenik_number"):
                moved[name] = np.where(thick, np.minimum(np.maximum(conditions[name], low), high), conditions[name])
        return moved

    def beyond(self, conditions: Conditions) -> list[tuple[str, float, float]]:
        """Variables that lie outside their ranges at one point: name, value and the limit it passes, SI units."""
        moved, found = self.with_roughness_in_range(conditions), []
        for name, (low, high) in self.ranges.items():
            value = float(np.ravel(moved[name])[0])
            if not low - RANGE_TOLERANCE * abs(low) <= value <= high + RANGE_TOLERANCE * abs(high):
                found.append((name, value, low if value < low else high))
        return found

    def outside(self, conditions: Conditions) -> NDArray[np.bool_]:
        """Where at least one variable lies outside its range."""
        conditions = self.with_roughness_in_range(conditions)
        result = np.zeros_like(conditions["pressure_hertz"], dtype=bool)
        for name, (low, high) in self.ranges.items():
            below, above = low - RANGE_TOLERANCE * abs(low), high + RANGE_TOLERANCE * abs(high)
            result = result | (conditions[name] < below) | (conditions[name] > above)
        return result

    def excess(self, conditions: Conditions) -> Array:
        """ln of the factor by which variables leave their ranges, all factors together; 0 inside."""
        result: Any = 0.0
        conditions = self.with_roughness_in_range(conditions)
        for name, (low, high) in self.ranges.items():
            value = np.maximum(conditions[name], _SMALLEST)
            if low > 0.0:
                result = result + np.maximum(np.log(low / value), 0.0)
            if high > 0.0:
                result = result + np.maximum(np.log(value / high), 0.0)
        return np.asarray(result) if isinstance(result, float) else cast("Array", result)

    def with_minimum_sliding(self, conditions: Conditions) -> tuple[Conditions, Array]:
        """Conditions with at least the smallest sliding of the data, and the factor mu falls to 0 with below it."""
        smallest = self.ranges.get("slide_to_roll_total", (0.0, 0.0))[0]
        total = conditions["slide_to_roll_total"]
        if smallest <= 0.0:
            return conditions, np.ones_like(total)
        sliding_ratio = np.maximum(total, smallest)
        sliding = sliding_ratio * np.absolute(conditions["speed_entrainment"])
        table = {**conditions, "slide_to_roll_total": sliding_ratio, "speed_sliding": sliding}
        return table, np.minimum(total / smallest, 1.0)

    def log_width(
        self,
        film_ratio: Array,
        deviation: Array | None,
        outside: NDArray[np.bool_],
        excess: Array,
        near: NDArray[np.bool_],
        far: NDArray[np.bool_],
    ) -> Array:
        """Half width of the interval of ln mu, widened where a point is extrapolated or outside the range.

        Outside the range the interval is as wide as near the data, times the factor by which variables leave their
        ranges, up to the greatest error of all cases (ours; checked by `validation/input_uncertainty.py --outside`).
        """
        width = self.interval.width(film_ratio, deviation)
        width = np.where(near | outside, np.maximum(width, self.interval.near), width)
        largest = np.maximum(width, self.interval.largest)
        return np.where(far, largest, np.where(outside, np.minimum(width + excess, largest), width))

    def extrapolation(self, conditions: Conditions) -> NDArray[np.int8]:
        """`regression.friction.data_cloud.Extrapolation` of every point; all inside where the file holds no cloud."""
        if self.cloud is None:
            return np.zeros(np.shape(conditions["pressure_hertz"]), dtype=np.int8)
        return self.cloud.extrapolation(self.with_roughness_in_range(conditions))

    def evaluate(self, conditions: Conditions, boundary_friction: float | None = None) -> FormulaValue:
        """Friction at many points.

        Below the least sliding of the data mu falls linearly to 0 with it: the form itself may be infinite there.

        Parameters
        ----------
        conditions : mapping
            The variables of `regression.friction.conditions.UNITS` as arrays of one shape.
        boundary_friction : float, optional
            In place of the formula's own; only families that take it as an input notice.

        Returns
        -------
        FormulaValue
        """
        outside, extrapolation = self.outside(conditions), self.extrapolation(conditions)
        mu, deviation = self._values(conditions, boundary_friction, (None, None))
        undefined = np.isnan(mu)
        near, far = extrapolation >= Extrapolation.NEAR, extrapolation == Extrapolation.FAR
        excess = self.excess(conditions)
        width = self.log_width(conditions["film_ratio_formula"], deviation, outside, excess, near, far)
        return FormulaValue(mu, mu * np.exp(-width), mu * np.exp(width), outside, extrapolation, undefined)

    def coefficient(self, conditions: Conditions, boundary_friction: float | None = None) -> Array:
        """mu as in `evaluate`, without its interval and the guard of its range.

        Parameters
        ----------
        conditions, boundary_friction
            As in `evaluate`.
        """
        means = tuple(process.mean_alone for process in self.processes)
        return self._values(conditions, boundary_friction, (*means, None, None)[:2])[0]

    def _values(
        self, conditions: Conditions, boundary_friction: float | None, sums: tuple[Sums | None, ...]
    ) -> tuple[Array, Array | None]:
        """mu, and the deviation of its logarithm by the processes."""
        table, ramp = self.with_minimum_sliding(conditions)
        shape = np.shape(ramp)
        flat = {name: np.ravel(values) for name, values in table.items()}
        mu_b = self.boundary_friction if boundary_friction is None else boundary_friction
        mu, deviation = self.friction(flat, mu_b, sums)
        mu = mu.reshape(shape)
        # 0 is an exponential that fell below the range of numbers
        undefined = ~(np.isfinite(mu) & (mu > 0.0))
        mu = np.where(undefined, np.nan, mu * ramp)
        return mu, None if deviation is None else deviation.reshape(shape)

    def friction(
        self, table: Conditions, boundary_friction: float | Array, sums: tuple[Sums | None, ...] = (None, None)
    ) -> tuple[Array, Array | None]:
        """mu by the form and its residual, and the residual's standard deviation of ln mu (None without residual).

        Parameters
        ----------
        table : mapping
            Columns of shape (n,), with sliding.
        boundary_friction : float or array of shape (n,)
        sums : tuple of callable, optional
            As of `GpResidual.correction`, of each process.
        """
        return corrected_form(self.form, self.coefficients, self.processes, table, boundary_friction, sums)

    def to_text(self) -> str:
        """The equation and its coefficients, to read and to type in."""
        lines = [f"{self.family}: {self.form.title}", self.equation, ""]
        for term in self.form.terms:
            note = f"  ({self.dropped[term]})" if term in self.dropped else ""
            error = self.standard_errors.get(term)
            spread = f" +- {error:.3g}" if error is not None and not note else ""
            lines.append(f"  {term} = {self.coefficients[term]:.9g}{spread}{note}")
        for process, what in zip(self.processes, PROCESS_WORDS[len(self.processes)], strict=True):
            inputs = ", ".join(process.variables)
            lines += ["", f"{what}, r a Gaussian process of {len(process.points)} points in {inputs}"]
        lines += ["", "range:"]
        lines += [f"  {name}: {low:.6g} to {high:.6g} {UNITS[name]}" for name, (low, high) in self.ranges.items()]
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """The file's content, with its checksum."""
        content = self.model_dump(mode="json", by_alias=True)
        return {**content, "checksum": _checksum(content)}

    def to_json(self) -> str:
        """The file's text; numbers keep all their digits."""
        return formula_text(self)

    def save(self, path: str | Path) -> None:
        """Write the formula file.

        Raises
        ------
        InputError
            The file cannot be written.
        """
        write_file(Path(path), self.to_json(), "formula file")


# what processes do, by how many there are
PROCESS_WORDS: dict[int, tuple[str, ...]] = {
    0: (),
    1: ("mu times exp(r)",),
    2: ("X/(1 - X) times exp(r)", "friction of the film over (1 - X)^1.5 times exp(r)"),
}


def corrected_form(
    form: Family,
    coefficients: Mapping[str, float],
    processes: tuple[GpResidual, ...],
    table: Conditions,
    boundary_friction: float | Array,
    sums: tuple[Sums | None, ...] = (None, None),
) -> tuple[Array, Array | None]:
    """Friction of a form corrected by its Gaussian processes, and the standard deviation of ln mu.

    The correction raises no friction above the greater of boundary friction and limiting shear: the bound of the
    physics holds by construction wherever the form keeps it.

    Parameters
    ----------
    form, coefficients
        The family and its numbers.
    processes : tuple of GpResidual
        As of `FittedFormula.processes`.
    table, boundary_friction
        As of `FittedFormula.friction`.
    sums : tuple of callable, optional
        As of `GpResidual.correction`, of each process.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        if len(processes) == 2 and form.parts is not None:
            # [()] gives what is recorded for an export, and of arrays the array
            share, film = (np.asarray(part)[()] for part in form.parts(table, coefficients))
            mu = share * boundary_friction + film
            found, variance = corrected_parts(
                share, film, (processes[0], processes[1]), table, boundary_friction, (sums[0], sums[1])
            )
        else:
            mu = np.exp(form.log_mu(table, coefficients, cast("float", boundary_friction)))
            if not processes:
                return mu, None
            correction, variance = processes[0].correction(table, sums[0])
            found, variance = mu * np.exp(correction), variance + processes[0].noise
        bound = np.maximum(np.maximum(boundary_friction, table["limiting_shear_coefficient"]), mu)
        return np.minimum(found, bound), np.sqrt(variance)


def formula_text(formula: FittedFormula) -> str:
    """JSON with a checksum; numbers keep all their digits, rows of numbers stand on one line."""
    text = json.dumps(formula.to_dict(), indent=2, allow_nan=False)
    numbers = re.compile(r"\[\s+((?:-?[\d.][\w.+-]*,\s+)*-?[\d.][\w.+-]*)\s+\]")
    return numbers.sub(lambda found: "[" + re.sub(r"\s+", " ", found[1]) + "]", text) + "\n"


def load_formula(path: str | Path) -> FittedFormula:
    """Read a formula file of this or an earlier schema.

    Raises
    ------
    InputError
        The file does not exist, is no formula file, was damaged or edited, or was written with a newer schema.
    """
    path = Path(path)
    return _read(str(path), read_text(path, "formula file", _ALLOWED))


@lru_cache(maxsize=8)
def _read(name: str, text: str) -> FittedFormula:
    """Formula of a file's text; kept, since checks and checksum cost more than an evaluation."""
    path = Path(name)
    content = parse_json(text, "formula file", name, _ALLOWED)
    if not isinstance(content, dict) or not isinstance(content.get("schema"), int):
        raise InputError("formula file", name, _ALLOWED, "It holds no schema number.")
    schema = content["schema"]
    if schema > FORMULA_SCHEMA:
        raise InputError(
            f"{path.name}.schema",
            schema,
            f"at most {FORMULA_SCHEMA}",
            f"It was written by the newer version {content.get('writer', 'unknown')}; update mixed-ehl to read it.",
        )
    if schema < 2:
        return validate(FittedFormula, _from_schema_1(content), path.name)
    stated = content.pop("checksum", None)
    formula = validate(FittedFormula, content if schema > 2 else _from_schema_2(content), path.name)
    if stated != _checksum(content):
        hint = "It was edited by hand or damaged, and its errors speak for other numbers: fit it again."
        raise InputError(f"{path.name}.checksum", stated, "the checksum of the file's content", hint)
    return formula


def _from_schema_1(content: dict[str, Any]) -> dict[str, Any]:
    """Schema 1 knew one oil, and neither residual, cloud of cases, gear paths nor repeated realisations."""
    oil = content.get("oil")
    named = isinstance(oil, dict) and oil.get("name") is not None
    rest = {name: value for name, value in content.items() if name != "oil"}
    return {**rest, "schema": FORMULA_SCHEMA, "oils": [oil] if named else []}


def _from_schema_2(content: dict[str, Any]) -> dict[str, Any]:
    """Schema 2 knew one process at most, and stored its points before they were divided by the length scales."""
    process = content.get("residual")
    if not isinstance(process, dict):
        return {**content, "schema": FORMULA_SCHEMA}
    try:
        points = (np.array(process["points"]) / np.array(process["length_scales"])).tolist()
    except (KeyError, TypeError, ValueError):
        points = None  # the check of the fields says what is wrong
    return {**content, "schema": FORMULA_SCHEMA, "residual": {**process, "points": points}}


def _checksum(content: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
