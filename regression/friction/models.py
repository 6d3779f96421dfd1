"""Interface and result of all friction models, and the constant friction coefficient.

Published formulas are in `published_registry`, fitted ones in `formula`, solved contacts in the package `efficiency`.

Friction at several sets of contact points by one evaluation of a model.

An evaluation has a fixed cost of 0.7 ms, as much as 500 points of a fitted formula; a mesh position range has 100 to
1200 points. A run is a generator that yields the points whose friction it requires. All runs advance in step, and the
points of one step are evaluated together.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Generator, Sequence
from dataclasses import dataclass, fields
from enum import IntEnum
from typing import TYPE_CHECKING, Any, TypeVar, Unpack

import numpy as np
from numpy.typing import NDArray

from ehl.common.arrays import finite_or_none
from ehl.common.data import data_names
from ehl.common.errors import InputError
from ehl.common.pages import TableResult
from ehl.common.table import Table
from ehl.common.threads import one_thread
from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.friction.conditions import Array, Conditions, PointConditions, conditions_of, contact_points

if TYPE_CHECKING:
    from ehl.uncertainty.result import InputUncertainty
    from ehl.uncertainty.spread import UncertaintyInput

COLEMAN_FRICTION = 0.05  # as cited by Kolivand, Li & Kahraman (2010)


class FrictionFlag(IntEnum):
    """Quality of one friction value: the largest flag that applies."""

    OK = 0
    OTHER_CARD = 1  # the card of the oil has changed since the data of the formula were computed
    OTHER_OIL = 2  # the formula was fitted to another oil
    EXTRAPOLATED_NEAR = 3  # within the range of every variable, but outside the distribution of the fitted cases
    EXTRAPOLATED_FAR = 4  # within the range of every variable, but far from all fitted cases
    OUTSIDE_RANGE = 5  # at least one variable lies outside the stated range
    PREDICTED = 6  # the nearest contact could not be solved and is predicted from the others
    NOT_CONVERGED = 7  # the solver did not converge
    UNDEFINED = 8  # the formula has no positive value; mu is nan


@dataclass(frozen=True)
class FrictionEstimate(TableResult):
    """Friction coefficients of many contact points.

    Parameters
    ----------
    mu : array
        Friction coefficient [-] in the shape of the state; nan if undefined.
    lower, upper : array
        Interval of the error of the model [-]; nan if unknown.
    flag : array of int
        `FrictionFlag` of every point.
    """

    mu: Array
    lower: Array
    upper: Array
    flag: NDArray[np.int8]

    def to_dict(self) -> dict[str, Any]:
        """Friction coefficient, lower and upper limit, and flag as text, for JSON; nan becomes None."""
        numbers = {"friction_coefficient": self.mu, "friction_lower": self.lower, "friction_upper": self.upper}
        plain = {name: finite_or_none(np.asarray(values).tolist()) for name, values in numbers.items()}
        words = np.array([flag.name.lower() for flag in FrictionFlag], dtype=object)
        return {**plain, "flag": words[self.flag].tolist() if np.ndim(self.flag) else words[int(self.flag)]}

    def table(self) -> Table:
        """One row per point, with the columns of `to_dict`."""
        return Table.from_columns({name: np.ravel(np.array(values)) for name, values in self.to_dict().items()})

    def __repr__(self) -> str:
        if np.size(self.mu) == 1:
            flag = FrictionFlag(int(np.ravel(self.flag)[0])).name.lower().replace("_", " ")
            interval = f" ({float(self.lower):.4g} to {float(self.upper):.4g})" if np.isfinite(self.lower) else ""
            return f"mu = {float(self.mu):.4g}{interval}, {flag}"
        numbers, counts = np.unique(self.flag, return_counts=True)
        flags = ", ".join(
            f"{count} {FrictionFlag(number).name.lower().replace('_', ' ')}"
            for number, count in zip(numbers.tolist(), counts.tolist(), strict=True)
        )
        finite = self.mu[np.isfinite(self.mu)]
        ends = f"{finite.min():.4g} to {finite.max():.4g}" if finite.size else "undefined"
        return f"mu of {np.size(self.mu)} points: {ends}; {flags}"


class FrictionModel(ABC):
    """A model of the friction coefficient at contact points, with interval and flag."""

    if TYPE_CHECKING:  # a field in some models, a property in others

        @property
        def name(self) -> str:
            """Specification of the model, for tables and reports."""

    @property
    def title(self) -> str:
        """Name in pages and figures: author and year, "constant 0.05", or "formula 75w90"."""
        from regression.friction.published_registry import model_label

        return model_label(self.name)

    @property
    def solves_contacts(self) -> bool:
        """Whether each value is the solution of a contact, which takes seconds."""
        return False

    @property
    def uses_texture(self) -> bool:
        """Whether mu depends on the Peklenik number of the roughness."""
        return False

    def references(self) -> set[str]:
        """Uses of `data/references.toml`: the solved contacts that the model is or was fitted to."""
        return {"contact", "heat", "rough contact"}

    @abstractmethod
    def evaluate(self, conditions: Conditions, oil: Oil) -> FrictionEstimate:
        """Friction at contact points: `regression.friction.conditions.conditions_of` the points."""

    def coefficient(self, conditions: Conditions, oil: Oil) -> Array:
        """mu as in `evaluate`, without interval and flag if they take time [-]."""
        return self.evaluate(conditions, oil).mu

    def default_oil(self) -> str:
        """Name of the default oil card; `InputError` if the model is not for a single oil."""
        raise InputError("oil", None, "one of " + ", ".join(data_names("oils")))

    @one_thread
    def mu(
        self, state: ContactState | None = None, *, oil: Oil | str | None = None, **conditions: Unpack[PointConditions]
    ) -> FrictionEstimate:
        """Friction coefficient at contact points.

        Parameters
        ----------
        state : ContactState, optional
            Contact points, alternatively to the keywords below.
        oil : Oil or str, optional
            Oil card or its name; default: that of a fitted formula.
        **conditions : float, str or array
            `pressure_hertz`, `radius_equivalent`, `speed_entrainment`, `slide_to_roll`, `temperature`; optional:
            `roughness_rms` (composite of both surfaces, default 0), `speed_sliding_lengthwise` (0),
            `correlation_length` (40 Rq), `peklenik_number` (1) and `effective_modulus` (steel on steel). SI numbers,
            strings with unit, or broadcastable arrays of them. `finish`, `finish_state`: as in `ehl.Contact`, default
            values of the roughness.

        Raises
        ------
        InputError
            A value is missing, has no unit or a wrong one, or is out of range; or there is no such oil.

        Examples
        --------
        >>> import regression
        >>> model = regression.friction_model("xu_kahraman_2007")
        >>> point = {"pressure_hertz": "1.2 GPa", "radius_equivalent": "15 mm", "speed_entrainment": "5 m/s"}
        >>> model.mu(**point, slide_to_roll=0.2, temperature="90 degC", roughness_rms="0.4 um", oil="75w90")
        mu = 0.01874, ok
        """
        state, card = self._points(state, oil, conditions)
        return self.evaluate(conditions_of(state, card), card)

    def _points(
        self, state: ContactState | None, oil: Oil | str | None, conditions: PointConditions
    ) -> tuple[ContactState, Oil]:
        """Contact points and oil card of the arguments of `mu`."""
        if state is None:
            state = contact_points(**conditions)
        elif conditions:
            raise InputError("conditions", ", ".join(conditions), "either a state or keywords")
        name = self.default_oil() if oil is None else oil
        return state, Oil.load(name) if isinstance(name, str) else name

    @one_thread
    def uncertainty(
        self,
        state: ContactState | None = None,
        *,
        oil: Oil | str | None = None,
        spreads: UncertaintyInput | None = None,
        level: float = 0.90,
        **conditions: Unpack[PointConditions],
    ) -> InputUncertainty:
        """Interval of the friction coefficient of one contact point, as in `mu`, by the uncertainty of the inputs.

        Parameters
        ----------
        spreads : UncertaintyInput, optional
            Standard deviations of the inputs; default: from oil card and additives.
        level : float
            Coverage of the interval [-].

        Raises
        ------
        InputError
            As in `mu`; there is more than one point; or the level is not between 0 and 1.

        Examples
        --------
        >>> import regression
        >>> point = {"pressure_hertz": "1.2 GPa", "radius_equivalent": "15 mm", "speed_entrainment": "5 m/s"}
        >>> found = regression.friction_model("75w90").uncertainty(
        ...     **point, slide_to_roll=0.2, temperature="90 degC", roughness_rms="0.4 um")
        >>> found.low < found.value < found.high
        True
        """
        from ehl.uncertainty.spread import DEFAULT
        from regression.friction.uncertainty import point_uncertainty

        state, card = self._points(state, oil, conditions)
        if state.size != 1:
            raise InputError("state", f"{state.size} points", "one contact point")
        rough = float(np.ravel(state.roughness_rms)[0]) > 0.0
        surface: dict[str, Any] = {
            name: float(np.ravel(getattr(state, name))[0])
            for name in ("correlation_length", "peklenik_number")
            if name in conditions
        }
        if rough and (finish := conditions.get("finish")) is not None:
            given = float(np.ravel(state.roughness_rms_1)[0]) if "roughness_rms" in conditions else None
            state_of_finish = conditions.get("finish_state", "run_in")
            surface |= {"finish": finish, "finish_state": state_of_finish, "roughness_rms": given}
        elif surface:
            surface["roughness_rms"] = 1e-6
        found = spreads or DEFAULT
        if surface:
            found = found.with_surface_of(DEFAULT.of_surface(**surface))
        return point_uncertainty(self, state, card, found, level)


@dataclass(frozen=True)
class ConstantFriction(FrictionModel):
    """A constant friction coefficient; 0.05 is Coleman's value."""

    value: float

    @property
    def name(self) -> str:
        """``constant:VALUE``."""
        return f"constant:{self.value:g}"

    def default_oil(self) -> str:
        """An arbitrary oil, on which the constant does not depend."""
        return "fva3"

    def references(self) -> set[str]:
        """None."""
        return set()

    def evaluate(self, conditions: Conditions, oil: Oil) -> FrictionEstimate:
        """The constant at every point."""
        mu = np.full(np.shape(conditions["pressure_hertz"]), self.value)
        return FrictionEstimate(mu, mu.copy(), mu.copy(), np.zeros(mu.shape, dtype=np.int8))


@dataclass(frozen=True)
class Request:
    """Contact points whose friction is required; `whole`: with interval and flags, otherwise only the coefficient."""

    state: ContactState
    whole: bool = False


T = TypeVar("T")
Answer = tuple[Conditions, FrictionEstimate]
Run = Generator[Request, Answer, T]
"""A computation that yields requests, receives conditions and friction of their points, and returns its result."""


def solve_together(runs: Sequence[Run[T]], model: FrictionModel, oil: Oil, formula: FrictionModel) -> list[T]:
    """Results of runs with the same oil.

    model: friction with interval and flags; contacts are solved for each run by itself.
    formula: only coefficients; the model itself, or the formula that represents its solved contacts.
    """
    results: dict[int, T] = {}
    answers: dict[int, Answer | None] = dict.fromkeys(range(len(runs)))
    while answers:
        requests: dict[int, Request] = {}
        for number, answer in answers.items():
            try:
                requests[number] = next(runs[number]) if answer is None else runs[number].send(answer)
            except StopIteration as end:
                results[number] = end.value
        answers = {}
        for whole in (False, True):
            some = [number for number, request in requests.items() if request.whole == whole]
            groups = [[number] for number in some] if whole and model.solves_contacts else [some] if some else []
            for group in groups:
                states = [requests[number].state for number in group]
                answers |= zip(group, _friction(states, model if whole else formula, oil, whole), strict=True)
    return [results[number] for number in range(len(runs))]


def _friction(states: Sequence[ContactState], model: FrictionModel, oil: Oil, whole: bool) -> list[Answer]:
    table = conditions_of(joined(states), oil)
    if whole:
        found = model.evaluate(table, oil)
    else:
        mu = model.coefficient(table, oil)
        found = FrictionEstimate(mu, mu, mu, np.zeros(mu.shape, np.int8))
    if len(states) == 1:
        return [(table, found)]
    ends = np.cumsum([state.size for state in states])
    parts = [slice(end - state.size, end) for end, state in zip(ends, states, strict=True)]
    return [
        (
            {name: values[at] for name, values in table.items()},
            FrictionEstimate(found.mu[at], found.lower[at], found.upper[at], found.flag[at]),
        )
        for at in parts
    ]


def joined(states: Sequence[ContactState]) -> ContactState:
    """The points of several states, one after the other."""
    if len(states) == 1:
        return states[0]
    return ContactState(
        **{
            field.name: np.concatenate([np.ravel(getattr(s, field.name)) for s in states])
            for field in fields(ContactState)
        }
    )
