"""Friction models behind one interface: constant, published formula, fitted formula file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ehl.fluid.oil import Oil
from ehl.io.data import data_names, data_path
from ehl.io.errors import InputError
from ehl.io.units import ValueRange
from ehl.state import ContactState
from regression.friction.conditions import UNITS, Array, Conditions, conditions_of
from regression.friction.data_cloud import Extrapolation
from regression.friction.formula import Formula, load_formula
from regression.friction.oil_cards import card_hash
from regression.friction.published_registry import PUBLISHED, PublishedFormula, evaluate_published

COLEMAN_FRICTION = 0.05  # as cited by Kolivand, Li & Kahraman (2010)


class FrictionFlag(IntEnum):
    """What is to be said of one friction value; the greatest that applies is given."""

    OK = 0
    OTHER_CARD = 1  # the card of the formula's oil has other figures now than when its data were computed
    OTHER_OIL = 2  # the formula was fitted to another oil
    EXTRAPOLATED_NEAR = 3  # within the range of every variable, but beside the cases the formula was fitted to
    EXTRAPOLATED_FAR = 4  # and with no such case near
    OUTSIDE_RANGE = 5  # at least one variable lies outside the stated range
    PREDICTED = 6  # the contact next to it could not be solved and is predicted by the others
    NOT_CONVERGED = 7  # a solver was asked and did not converge
    UNDEFINED = 8  # the formula has no positive value here; mu is nan


@dataclass(frozen=True)
class FrictionEstimate:
    """Friction coefficients of many contact points.

    Parameters
    ----------
    mu : array
        Friction coefficient [-], in the shape of the state; nan where there is none.
    lower, upper : array
        Interval of the model's own error [-]; NaN where the model states none.
    flag : array of int
        `FrictionFlag` of every point.
    """

    mu: Array
    lower: Array
    upper: Array
    flag: NDArray[np.int8]


@runtime_checkable
class FrictionModel(Protocol):
    """A friction coefficient at every contact point."""

    @property
    def name(self) -> str:
        """What the user asked for, for tables and reports."""
        ...

    def evaluate(self, state: ContactState, oil: Oil) -> FrictionEstimate:
        """Friction at every point of `state` lubricated by `oil`."""
        ...


@dataclass(frozen=True)
class ConstantFriction:
    """The same friction coefficient everywhere; 0.05 is Coleman's."""

    value: float

    @property
    def name(self) -> str:
        """``constant:VALUE``."""
        return f"constant:{self.value:g}"

    def evaluate(self, state: ContactState, oil: Oil) -> FrictionEstimate:
        """The constant, exactly, at every point."""
        shape = np.shape(state.pressure_hertz)
        mu = np.full(shape, self.value)
        return FrictionEstimate(mu, mu.copy(), mu.copy(), np.zeros(shape, dtype=np.int8))


@dataclass(frozen=True)
class PublishedFriction:
    """A formula of the registry, applied with the local conditions."""

    formula: PublishedFormula

    @property
    def name(self) -> str:
        """Registry name."""
        return self.formula.name

    def evaluate(self, state: ContactState, oil: Oil) -> FrictionEstimate:
        """Friction with the formula's own range as flag; no interval, the authors state none."""
        mu, outside, undefined = evaluate_published(self.formula, conditions_of(state, oil), oil.base)
        flag = np.where(outside, FrictionFlag.OUTSIDE_RANGE, FrictionFlag.OK)
        flag = np.where(undefined, FrictionFlag.UNDEFINED, flag)
        unknown = np.full_like(mu, np.nan)
        return FrictionEstimate(mu, unknown, unknown.copy(), flag.astype(np.int8))


@dataclass(frozen=True)
class FormulaFriction:
    """A fitted formula file.

    Parameters
    ----------
    formula : Formula
    name : str
        What the user asked for.
    boundary_friction : float or None
        In place of that the data were computed with; only families that take it as an input notice.
    refuse : bool
        Refuse points outside the range or beside the cases of the fit, in place of flagging them.
    """

    formula: Formula
    name: str
    boundary_friction: float | None = None
    refuse: bool = False

    def evaluate(self, state: ContactState, oil: Oil) -> FrictionEstimate:
        """Friction with the interval of the fit; outside its range and with another oil the widest error seen.

        Raises
        ------
        InputError
            With `refuse`: a point is outside the range or beside the cases of the fit.
        """
        conditions = conditions_of(state, oil)
        value = self.formula.evaluate(conditions, self.boundary_friction)
        beside = value.extrapolation >= Extrapolation.NEAR
        if self.refuse and np.any(value.outside | beside):
            raise self._refused(conditions, value.outside, beside)
        flag = np.full(np.shape(value.mu), self._oil_flag(oil))
        flag = np.where(beside, FrictionFlag.EXTRAPOLATED_NEAR, flag)
        flag = np.where(value.extrapolation == Extrapolation.FAR, FrictionFlag.EXTRAPOLATED_FAR, flag)
        flag = np.where(value.outside, FrictionFlag.OUTSIDE_RANGE, flag)
        flag = np.where(value.undefined, FrictionFlag.UNDEFINED, flag)
        lower, upper = value.lower, value.upper
        if self._oil_flag(oil) == FrictionFlag.OTHER_OIL:
            width = self.formula.interval.largest
            lower, upper = np.minimum(lower, value.mu * np.exp(-width)), np.maximum(upper, value.mu * np.exp(width))
        return FrictionEstimate(value.mu, lower, upper, flag.astype(np.int8))

    def _oil_flag(self, oil: Oil) -> FrictionFlag:
        if not self.formula.oils:
            return FrictionFlag.OK
        for identity in self.formula.oils:
            if identity.name == oil.name:
                known = identity.card_hash in (None, card_hash(oil))
                return FrictionFlag.OK if known else FrictionFlag.OTHER_CARD
        return FrictionFlag.OTHER_OIL

    def _refused(self, conditions: Conditions, outside: NDArray[np.bool_], beside: NDArray[np.bool_]) -> InputError:
        wrong = outside | beside
        for name, (low, high) in self.formula.ranges.items():
            there = np.ravel(conditions[name])[np.ravel(wrong)]
            if there.min() < low or there.max() > high:
                value = float(there.min() if there.min() < low else there.max())
                where = f"{low:.6g} to {high:.6g} {UNITS[name]}".strip()
                hint = f"{int(np.sum(wrong))} of {wrong.size} points lie outside the data of {self.name}."
                return InputError(name, value, where, hint)
        hint = f"Each variable is within its range, but no case of {self.name} has them together."
        return InputError("conditions", f"{int(np.sum(wrong))} of {wrong.size} points", "points among the data", hint)


def friction_model(spec: str) -> FrictionModel:
    """The friction model a user names.

    Parameters
    ----------
    spec : str
        ``constant:0.05`` or ``coleman``, which is that one, a name of the registry (``xu_kahraman_2007``), a shipped
        formula, or the path of a formula file; ``strict:`` before the last two refuses points outside the data.

    Raises
    ------
    InputError
        Nothing of that name exists (the message lists what does), the constant is no number within 0 to 1, or the
        file is no formula.
    """
    kind, colon, value = spec.partition(":")
    if spec == "coleman":
        return ConstantFriction(COLEMAN_FRICTION)
    if kind == "constant":
        if not colon:
            raise InputError("friction constant", None, "its value, as in constant:0.05")
        return ConstantFriction(ValueRange("", ge=0.0, le=1.0).check(value, "friction constant"))
    if kind == "strict" and colon:
        return replace(formula_friction(value), name=spec, refuse=True)
    if spec in PUBLISHED:
        return PublishedFriction(PUBLISHED[spec])
    return formula_friction(spec)


def formula_friction(spec: str) -> FormulaFriction:
    """A shipped formula, or a formula file.

    Raises
    ------
    InputError
        Neither exists, or the file is no formula.
    """
    if spec in shipped_formulas():
        return FormulaFriction(load_formula(data_path("formulas", f"{spec}.json")), spec)
    path = Path(spec)
    if path.suffix == ".json" or path.is_file():
        return FormulaFriction(load_formula(path), path.name)
    raise InputError("friction model", spec, friction_model_choices(), "Check the name or the path.")


def is_formula(spec: str) -> bool:
    """Whether a user names a formula: a shipped one, or a file by its suffix."""
    return spec in shipped_formulas() or Path(spec).suffix == ".json"


def shipped_formulas(oil: str | None = None) -> tuple[str, ...]:
    """Names of the fitted formulas that come with the program: all, or those fitted to one oil."""
    names = data_names("formulas", ".json")
    if oil is None:
        return names
    return tuple(
        name for name in names if oil in {o.name for o in load_formula(data_path("formulas", f"{name}.json")).oils}
    )


def friction_model_choices() -> str:
    """What `friction_model` accepts, in words."""
    names = ", ".join((*sorted(PUBLISHED), *shipped_formulas()))
    coleman = f"coleman (constant:{COLEMAN_FRICTION:g})"
    return f"constant:VALUE, {coleman}, one of {names}, or the path of a formula file (.json)"
