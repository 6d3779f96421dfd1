"""Friction models behind one interface: constant, published formula, fitted formula file."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.friction.conditions import Array, conditions_of
from regression.friction.published_registry import PublishedFormula, evaluate_published

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
