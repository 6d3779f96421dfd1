"""The friction formula a user holds: a fitted formula with its use, export, report and figures; friction by name."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ehl.fluid.oil import Oil
from ehl.io.data import data_names, data_path
from ehl.io.errors import InputError
from ehl.io.units import ValueRange
from ehl.state import ContactState
from regression.friction.conditions import UNITS, Conditions, conditions_of
from regression.friction.data_cloud import Extrapolation
from regression.friction.formula import FittedFormula, load_formula
from regression.friction.models import (
    COLEMAN_FRICTION,
    ConstantFriction,
    FrictionEstimate,
    FrictionFlag,
    FrictionModel,
    PublishedFriction,
)
from regression.friction.oil_cards import card_hash
from regression.friction.published_registry import PUBLISHED


@dataclass(frozen=True)
class Formula:
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

    formula: FittedFormula
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


def formula_friction(spec: str) -> Formula:
    """A shipped formula, or a formula file.

    Raises
    ------
    InputError
        Neither exists, or the file is no formula.
    """
    if spec in shipped_formulas():
        return Formula(load_formula(data_path("formulas", f"{spec}.json")), spec)
    path = Path(spec)
    if path.suffix == ".json" or path.is_file():
        return Formula(load_formula(path), path.name)
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
