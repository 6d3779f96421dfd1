"""`FittedFormula`: equation, coefficients, errors, range and JSON file of a fitted friction formula."""

import hashlib
import json
import math
import re
from collections.abc import Mapping
from functools import lru_cache
from os import PathLike
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar, Unpack, cast

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, PrivateAttr, model_validator

from ehl.common.data import data_names, data_path, named_file
from ehl.common.errors import InputError, check_choice
from ehl.common.files import parse_json, read_text, write_file
from ehl.common.quantities import quantity
from ehl.common.threads import one_thread
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel, validate
from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.friction.conditions import UNITS, Array, Conditions, PointConditions, before_variation, conditions_of
from regression.friction.data_cloud import CloudDistance, DataCloud
from regression.friction.error_tables import Band, ErrorInterval, Finite, NoiseFloor, Scores
from regression.friction.families import Family, family_named
from regression.friction.models import FrictionEstimate, FrictionFlag, FrictionModel
from regression.friction.network import Evaluate, Network
from regression.friction.oil_cards import OilIdentity

_ALLOWED = "a formula file of `mixed-ehl fit RUN -o FILE.json`"
FORMULA_SCHEMA = 5
_SMALLEST = 1e-300  # below all values of variables
RANGE_TOLERANCE = 1e-3  # relative tolerance of the range, as the cases of a plan do not reach its ends
NETWORK = "network"  # the form `short` with its networks, as a family of fits and tables
THICK_FILM = 2.0  # lambda above which mu is that of the film for any roughness
_FRICTION = ValueRange("", ge=0.0, le=1.0)
Friction = Annotated[float, _FRICTION]
_Fitted = TypeVar("_Fitted", bound="FittedFormula")


class DataIdentity(InputModel):
    """Origin of the fitted data."""

    hash: str
    plan: str
    plan_hash: str
    solver_version: str
    count: int
    used: int
    excluded: dict[str, int]
    tuned: str | None = None  # shipped formula of other oils, whose networks were tuned to these data


class FittedFormula(FrictionModel, InputModel):
    """A fitted friction formula with its errors, range and origin: the content of a formula file.

    `network`, `cloud`, `corners`, `paths`, `unseen`, `nested` and `noise` are None if they are not available.
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
    interval: ErrorInterval
    noise_floor: Finite
    noise: NoiseFloor | None = None
    data: DataIdentity
    cloud: DataCloud | None = None
    network: Network | None = None

    _name: str = PrivateAttr("")
    _refuse: bool = PrivateAttr(False)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        family = family_named(self.family)
        for term in family.terms:
            if term not in self.coefficients:
                raise InputError(f"coefficients.{term}", None, "a number")
        for term in self.coefficients:
            check_choice(f"coefficients.{term}", term, family.terms)
        if self.equation != family.equation:
            hint = "The equation of the program differs: fit the formula again."
            raise InputError("equation", self.equation, f"that of family {family.name}: {family.equation}", hint)
        for name, (low, high) in self.ranges.items():
            check_choice(f"ranges.{name}", name, UNITS)
            if low > high:
                unit = UNITS[name] or "1"
                raise InputError(f"ranges.{name}", [low, high], f"the lower end first, then the upper one, in {unit}")
        for name, unit in self.units.items():
            if unit != UNITS.get(name):
                allowed = repr(UNITS[name]) if name in UNITS else "a unit of one of " + ", ".join(UNITS)
                raise InputError(f"units.{name}", unit, allowed, "The numbers of the file are in SI units.")
        if self.interval.normalised and self.network is None:
            raise InputError("interval.normalised", True, "false without a network")
        if self.network is not None and family.parts is None:
            raise InputError("network", self.family, "a network only for a family with both parts of mu")
        return self

    @classmethod
    def load(cls, name: str | PathLike[str]) -> Self:
        """A shipped formula, or the formula of a file.

        Parameters
        ----------
        name : str or path
            One of ``ehl.shipped("formulas")``, or the path of a file.

        Raises
        ------
        InputError
            There is no such formula; or the file is no formula file, was changed, or is of another version.

        Examples
        --------
        >>> from regression import Formula
        >>> Formula.load("75w90").family
        'short'
        """
        path = named_file("formula", "formulas", Path(name), ".json")
        shown = path.stem if path.parent == data_path("formulas") else path.name
        formula: Self = _read(cls, str(path), read_text(path, "formula file", _ALLOWED))
        return formula.with_options(name=shown)

    def with_options(
        self, boundary_friction: float | None = None, *, refuse: bool = False, name: str | None = None
    ) -> Self:
        """The same formula with options.

        Parameters
        ----------
        boundary_friction : float, optional
            Friction coefficient of the asperities [-], instead of that of the data.
        refuse : bool
            Reject points outside the range or extrapolated points instead of flagging them.
        name : str, optional
            Name for tables and reports.

        Raises
        ------
        InputError
            Boundary friction is no input of the family, or it is out of range.
        """
        changes: dict[str, float] = {}
        if boundary_friction is not None:
            if self.form.design is not None:
                hint = "Its boundary friction is that of its data."
                raise InputError("boundary_friction", boundary_friction, "a family with this input", hint)
            changes["boundary_friction"] = _FRICTION.check(boundary_friction, "boundary_friction")
        formula = self.model_copy(update=changes)
        formula._refuse = refuse or self._refuse
        formula._name = self._name if name is None else name
        return formula

    @property
    def name(self) -> str:
        """The shipped name or the name of the file; `label` for a formula that was not loaded."""
        return self._name or self.label

    @property
    def label(self) -> str:
        """`NETWORK` for a formula with networks, else the family, for tables."""
        return self.family if self.network is None else NETWORK

    @property
    def form(self) -> Family:
        """Family of the formula."""
        return family_named(self.family)

    @property
    def uses_texture(self) -> bool:
        """Whether mu depends on the lay of the roughness, i.e. the data have more than one Peklenik number."""
        return "peklenik_number" in self.ranges

    def with_roughness_in_range(self, conditions: Conditions) -> Conditions:
        """Conditions with the roughness limited to its range for thick films, on whose friction it has no effect.

        Smooth contacts (Rq = 0) are therefore within the range. The film ratio follows the limited roughness.
        """
        # ufuncs only here and below, so that `regression.export` can record them
        thick = conditions["film_ratio_formula"] >= THICK_FILM
        moved = dict(conditions)
        for name, (low, high) in self.ranges.items():
            if name == "roughness_rms":
                moved[name] = np.where(thick, np.maximum(conditions[name], low), conditions[name])
                # that of a smooth contact is infinite
                ratio = np.minimum(
                    conditions["film_ratio_formula"], conditions["film_formula"] / np.maximum(moved[name], _SMALLEST)
                )
                moved["film_ratio_formula"] = np.where(thick, ratio, conditions["film_ratio_formula"])
            elif name in ("correlation_length", "peklenik_number"):
                moved[name] = np.where(thick, np.minimum(np.maximum(conditions[name], low), high), conditions[name])
        return moved

    def beyond(self, conditions: Conditions) -> list[tuple[str, float, float]]:
        """Variables outside their ranges at any point: name, smallest or largest value, exceeded limit; SI units."""
        moved, found = self.with_roughness_in_range(conditions), []
        for name, (low, high) in self.ranges.items():
            values = np.ravel(moved[name])
            value = float(values.max() if values.max() > high + RANGE_TOLERANCE * abs(high) else values.min())
            if not low - RANGE_TOLERANCE * abs(low) <= value <= high + RANGE_TOLERANCE * abs(high):
                found.append((name, value, low if value < low else high))
        return found

    def outside(self, conditions: Conditions) -> NDArray[np.bool_]:
        """Whether at least one variable lies outside its range."""
        conditions = self.with_roughness_in_range(conditions)
        result = np.zeros_like(conditions["pressure_hertz"], dtype=bool)
        for name, (low, high) in self.ranges.items():
            below, above = low - RANGE_TOLERANCE * abs(low), high + RANGE_TOLERANCE * abs(high)
            result = result | (conditions[name] < below) | (conditions[name] > above)
        return result

    def excess(self, conditions: Conditions) -> Array:
        """Logarithm of the product of the factors by which variables exceed their ranges; 0 inside."""
        factor: Any = 1.0
        conditions = self.with_roughness_in_range(conditions)
        for name, (low, high) in self.ranges.items():
            value = conditions[name]
            if high > 0.0:
                factor = factor * np.maximum(np.maximum(low / np.maximum(value, _SMALLEST), value / high), 1.0)
        return cast("Array", np.log(factor))

    def with_minimum_sliding(self, conditions: Conditions) -> tuple[Conditions, Array]:
        """Conditions with at least the smallest sliding of the data, and the factor that reduces mu to 0 below it."""
        smallest = self.ranges.get("slide_to_roll_total", (0.0, 0.0))[0]
        total = conditions["slide_to_roll_total"]
        if smallest <= 0.0:
            return conditions, np.ones_like(total)
        # both have a continuous slope at the smallest sliding of the data
        part = np.minimum(total / smallest, 1.0)
        sliding_ratio = np.maximum(total, 0.5 * smallest * (1.0 + part * part))
        sliding = sliding_ratio * np.absolute(conditions["speed_entrainment"])
        table = {**conditions, "slide_to_roll_total": sliding_ratio, "speed_sliding": sliding}
        return table, part * (2.0 - part)

    def log_width(
        self,
        film_ratio: Array,
        deviation: Array | None,
        outside: NDArray[np.bool_],
        excess: Array,
        near: NDArray[np.bool_],
        far: NDArray[np.bool_],
    ) -> Array:
        """Half width of the interval of ln mu, increased for extrapolated points and outside the range.

        Outside the range the interval of points near the data is multiplied by the factor by which variables exceed
        their ranges, up to the largest error of all cases (own choice, checked by
        `validation/input_uncertainty.py --outside`).
        """
        width = self.interval.width(film_ratio, deviation)
        width = np.where(near | outside, np.maximum(width, self.interval.near), width)
        largest = np.maximum(width, self.interval.largest)
        return np.where(far, largest, np.where(outside, np.minimum(width + excess, largest), width))

    def extrapolation(self, conditions: Conditions) -> NDArray[np.int8]:
        """`regression.friction.data_cloud.CloudDistance` of every point; all inside without a stored distribution."""
        if self.cloud is None:
            return np.zeros(np.shape(conditions["pressure_hertz"]), dtype=np.int8)
        return self.cloud.extrapolation(self.with_roughness_in_range(conditions))

    @one_thread
    def evaluate(self, conditions: Conditions, oil: Oil | None = None) -> FrictionEstimate:
        """Friction with the interval of the fit.

        Far outside the data the interval is the largest held-out error. For another oil it is at least that of oils
        that were held out, or else the largest error. Below the smallest sliding of the data mu decreases smoothly to
        0, where the form itself may be infinite. The card of the `oil` is compared with those of the data.

        Raises
        ------
        InputError
            The formula has the option `refuse`, and a point is outside the range or extrapolated.
        """
        outside, extrapolation = self.outside(conditions), self.extrapolation(conditions)
        near, far = extrapolation >= CloudDistance.NEAR, extrapolation == CloudDistance.FAR
        if self._refuse and np.any(outside | near):
            raise self._refused(conditions, outside | near)
        mu, deviation = self._values(conditions)
        width = self.log_width(conditions["film_ratio_formula"], deviation, outside, self.excess(conditions), near, far)
        lower, upper = mu * np.exp(-width), mu * np.exp(width)
        oil_flag = FrictionFlag.OK if oil is None else self.oil_flag(oil)
        if oil_flag == FrictionFlag.OTHER_OIL:
            widest = self.interval.largest if self.interval.other_oil is None else self.interval.other_oil
            lower, upper = np.minimum(lower, mu * np.exp(-widest)), np.maximum(upper, mu * np.exp(widest))
        flag = flags_of(oil_flag, near, far, outside, np.isnan(mu))
        return FrictionEstimate(mu, lower, upper, np.asarray(flag).astype(np.int8))

    @one_thread
    def coefficient(self, conditions: Conditions, oil: Oil | None = None) -> Array:
        """mu as in `evaluate`, without interval and range check [-]."""
        return self._values(conditions)[0]

    def _values(self, conditions: Conditions) -> tuple[Array, Array | None]:
        """mu, and the standard deviation of its logarithm by the networks."""
        table, ramp = self.with_minimum_sliding(self.with_roughness_in_range(conditions))
        shape = np.shape(ramp)
        flat = {name: np.ravel(values) for name, values in table.items()}
        mu, deviation = friction_of_form(self.form, self.coefficients, self.network, flat, self.boundary_friction)
        mu = mu.reshape(shape)
        # 0 is an underflow of the exponential
        undefined = ~(np.isfinite(mu) & (mu > 0.0))
        mu = np.where(undefined, np.nan, mu * ramp)
        return mu, None if deviation is None else deviation.reshape(shape)

    def to_text(self) -> str:
        """Equation and coefficients as text."""
        lines = [f"{self.family}: {self.form.title}", self.equation, ""]
        for term in self.form.terms:
            note = f"  ({self.dropped[term]})" if term in self.dropped else ""
            error = self.standard_errors.get(term)
            spread = f" +- {error:.3g}" if error is not None and not note else ""
            lines.append(f"  {term} = {self.coefficients[term]:.{9 if not (spread or note) else 4}g}{spread}{note}")
        if network := self.network:
            what = f"the mean of {len(network.members)} networks of 2 x {network.units} units"
            lines += ["", f"X/(1 - X) times exp(a), F/(1 - X)^1.5 times exp(b); a, b {what} in"]
            lines += [f"  {', '.join(network.variables)}"]
            lines += [f"  tuned from the networks of {self.data.tuned}"] if self.data.tuned else []
        lines += ["", "range:"]
        lines += [
            f"  {quantity(name).label}: {quantity(name).span(low, high)}" for name, (low, high) in self.ranges.items()
        ]
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Content of the formula file with its checksum, in SI units with the names of docs/nomenclature.md."""
        content = self.model_dump(mode="json", by_alias=True)
        return {**content, "checksum": _checksum(content)}

    def to_json(self) -> str:
        """Text of the formula file with all digits of numbers, and with rows of numbers on one line."""
        text = json.dumps(self.to_dict(), indent=2, allow_nan=False)
        numbers = re.compile(r"\[\s+((?:-?[\d.][\w.+-]*,\s+)*-?[\d.][\w.+-]*)\s+\]")
        return numbers.sub(lambda found: "[" + re.sub(r"\s+", " ", found[1]) + "]", text) + "\n"

    def save(self, path: str | PathLike[str]) -> None:
        """Write the formula file (JSON).

        Raises
        ------
        InputError
            The file cannot be written.
        """
        write_file(Path(path), self.to_json(), "formula file")

    def default_oil(self) -> str:
        """Name of the fitted oil.

        Raises
        ------
        InputError
            There are several oils, or the oil has no name.
        """
        names = [str(identity.name) for identity in self.oils if identity.name is not None]
        if len(names) == 1:
            return names[0]
        raise InputError("oil", None, f"one of {', '.join(names or data_names('oils'))}, or another oil")

    def range_note(
        self, state: ContactState | None = None, *, oil: Oil | str | None = None, **conditions: Unpack[PointConditions]
    ) -> str:
        """Note on the variables of one point, as in `mu`, outside the range of the data; otherwise an empty text."""
        parts = []
        for variable, value, limit in self.beyond(conditions_of(*self._points(state, oil, conditions))):
            entry, side = quantity(variable), "at least" if value < limit else "at most"
            parts.append(f"{entry.label} {entry.text(value, 3)} ({side} {entry.text(limit, 3)})")
        if not parts:
            return ""
        return f"outside the data of {self.name}: {', '.join(parts)}; the interval increases with the distance"

    def oil_note(self, oil: Oil) -> str:
        """Note if the formula was fitted to another oil or another card of it, or an empty text.

        Parameters
        ----------
        oil : Oil
            Oil card of the evaluation.
        """
        flag = self.oil_flag(oil)
        if flag == FrictionFlag.OTHER_CARD:
            return f"the card of {oil.name} has been changed since the data of {self.name} were computed"
        if flag == FrictionFlag.OK:
            return ""
        names = ", ".join(str(identity.name or "a lubricant without an oil card") for identity in self.oils)
        if self.interval.other_oil is None:
            width = "its largest error; the effect of the other oil is unknown"
        else:
            width = f"{100.0 * math.expm1(self.interval.other_oil):.0f} %, the error for held-out oils"
        return (
            f"friction model {self.name} was fitted to {names}, not to {oil.name}: its interval is at least {width}; "
            "fit a formula to this oil, or use the friction model ehl"
        )

    def oil_flag(self, oil: Oil) -> FrictionFlag:
        """Whether the formula was fitted to this oil, to another card of it, or to another oil."""
        found = [same for same in (identity.compared(oil) for identity in self.oils) if same is not None]
        if found or not self.oils:
            return FrictionFlag.OK if all(found[:1]) else FrictionFlag.OTHER_CARD
        return FrictionFlag.OTHER_OIL

    def _refused(self, conditions: Conditions, wrong: NDArray[np.bool_]) -> InputError:
        count = f"{int(np.sum(wrong))} of {wrong.size} points"
        for name, value, _ in self.beyond(conditions):
            where = "{:.6g} to {:.6g} ".format(*self.ranges[name]) + UNITS[name]
            return InputError(name, value, where.strip(), f"{count} lie outside the data of {self.name}.")
        hint = f"Each variable is within its range, but no case of {self.name} has a similar combination."
        return InputError("conditions", count, "points within the data", hint)


def friction_of_form(
    form: Family,
    coefficients: Mapping[str, float],
    network: Network | None,
    table: Conditions,
    boundary_friction: float | Array,
    evaluate: Evaluate | None = None,
) -> tuple[Array, Array | None]:
    """mu by a closed form with its networks, and their standard deviation of ln mu (None without networks).

    The networks do not increase friction above the larger of boundary friction and limiting shear coefficient, unless
    the closed form exceeds it. Of an oil card with another Eyring or limiting stress (`Oil.varied`) they have those
    before the variation: in their data both are functions of the oil, so that the networks would be extrapolated.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        if network is None or form.parts is None:
            return np.exp(form.log_mu(table, coefficients, boundary_friction)), None
        # [()] gives the recorded expression of an export, and an array unchanged
        share, film = (np.asarray(part)[()] for part in form.parts(table, coefficients))
        card = before_variation(table)
        inputs = None if card is table else network.inputs(*form.parts(card, coefficients), card)
        found, deviation = network.corrected(share, film, table, boundary_friction, evaluate, inputs)
        limit = np.maximum(boundary_friction, table["limiting_shear_coefficient"])
        return np.minimum(found, np.maximum(limit, share * boundary_friction + film)), deviation


def flags_of(start: Any, near: Any, far: Any, outside: Any, undefined: Any) -> Any:
    """`FrictionFlag` of points: `start`, or the most severe of the following flags that applies."""
    warning = np.where(near, float(FrictionFlag.EXTRAPOLATED_NEAR), start)
    warning = np.where(far, float(FrictionFlag.EXTRAPOLATED_FAR), warning)
    warning = np.where(outside, float(FrictionFlag.OUTSIDE_RANGE), warning)
    return np.where(undefined, float(FrictionFlag.UNDEFINED), warning)


@lru_cache(maxsize=8)
def _read(model: type[_Fitted], name: str, text: str) -> _Fitted:
    """Formula from the text of a file, cached as checks and checksum take longer than an evaluation."""
    path = Path(name)
    content = parse_json(text, "formula file", name, _ALLOWED)
    if not isinstance(content, dict) or not isinstance(content.get("schema"), int):
        raise InputError("formula file", name, _ALLOWED, "It has no schema number.")
    if content["schema"] != FORMULA_SCHEMA:
        advice = "update mixed-ehl" if content["schema"] > FORMULA_SCHEMA else "fit it again"
        hint = f"It was written by version {content.get('writer', 'unknown')}: {advice}."
        raise InputError(f"{path.name}.schema", content["schema"], f"{FORMULA_SCHEMA}", hint)
    stated = content.pop("checksum", None)
    formula = validate(model, content, path.name)
    if stated != _checksum(content):
        hint = "The file was changed, so that its errors do not belong to its numbers: fit it again."
        raise InputError(f"{path.name}.checksum", stated, "the checksum of the content of the file", hint)
    return formula


def _checksum(content: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
