"""Friction at several sets of contact points by one evaluation of a model.

An evaluation has a fixed cost of 0.7 ms, as much as 500 points of a fitted formula; a mesh position range has 100 to
1200 points. A run is a generator that yields the points whose friction it requires. All runs advance in step, and the
points of one step are evaluated together.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass, fields
from typing import TypeVar

import numpy as np

from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.friction.conditions import Conditions, conditions_of
from regression.friction.models import FrictionEstimate, FrictionModel


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
