"""Effect of uncertain inputs on the friction of a model: each input is varied alone, at all contact points together.

The model is evaluated at both ends of the interval of each input. Inputs that a fitted formula does not contain
(boundary film, bulk temperature, lay where the data have a single one) use slopes of solved contacts, with a note; a
boundary film changes the asperity load share of formulas that have one.
"""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ehl.fluid.oil import Oil
from ehl.fluid.oil_laws import VARIABLES
from ehl.fluid.viscosity import TEMPERATURE_RANGE
from ehl.inputs import SurfaceInput
from ehl.state import ContactState
from ehl.uncertainty.contact_design import FILMS, THICK, UncertainInput, shifted
from ehl.uncertainty.result import LEVEL, Change, InputUncertainty, score_of
from ehl.uncertainty.spread import (
    DEFAULT,
    FILM_TO_SHARE,
    GROUPS,
    LATERAL_CAUSE,
    SURFACE,
    Spread,
    UncertaintyInput,
    lateral_spread,
    stated_change,
)
from regression.friction.conditions import Array, conditions_of
from regression.friction.fitted import FittedFormula
from regression.friction.models import ConstantFriction, FrictionModel, joined
from regression.friction.network import FILM_POWER

STATED = "slopes of solved contacts over the film ratio, not of this model"
STATED_SHARE = "slopes of the asperity load share of solved contacts over the film ratio"
FORMULA = "friction formula"
TWO_SIGMA = math.erf(math.sqrt(2.0))  # level of models that state an interval without a level
_NOTHING = 1e-9  # largest change of ln mu of a model that does not contain an input


def boundary_friction_of(model: FrictionModel) -> float:
    """mu_b of a friction model [-]; nan if it has none."""
    return float(getattr(model, "boundary_friction", math.nan))


def _with(model: FrictionModel, field: str, value: float) -> FrictionModel:
    """Copy of a model with another value of a field."""
    if isinstance(model, FittedFormula):
        return model.model_copy(update={field: value})
    held: Any = model
    changed: FrictionModel = replace(held, **{field: value})
    return changed


def friction_of(model: FrictionModel, state: ContactState, oil: Oil) -> Array:
    """Friction coefficients at contact points, without interval and flag [-]."""
    return model.coefficient(conditions_of(state, oil), oil)


Case = tuple[FrictionModel, ContactState, Oil]
Moving = Callable[[Spread, Case, float], Case]  # the case with an input of this spread shifted by standard deviations


def friction_of_cases(cases: Sequence[Case]) -> list[Array]:
    """`friction_of` several cases; the points of those with the same fitted formula are evaluated together."""
    if not all(isinstance(model, FittedFormula) for model, _, _ in cases):
        return [friction_of(*case) for case in cases]
    keys = [(id(model), id(oil), id(state)) for model, state, oil in cases]
    by_key, found = dict(zip(keys, cases, strict=True)), dict[tuple[int, int, int], Array]()
    # in the order in which models and oils appear, so that equal cases are evaluated in equal blocks
    models, oils = ({key[part]: place for place, key in reversed(list(enumerate(by_key)))} for part in (0, 1))
    ordered = sorted(by_key, key=lambda key: (models[key[0]], oils[key[1]]))
    for _, of_model in itertools.groupby(ordered, lambda key: key[0]):
        some = list(of_model)
        tables = []
        for _, of_oil in itertools.groupby(some, lambda key: key[1]):
            same = [by_key[key] for key in of_oil]
            tables.append(conditions_of(joined([state for _, state, _ in same]), same[0][2]))
        table = {name: np.concatenate([np.ravel(each[name]) for each in tables]) for name in tables[0]}
        states = [by_key[key][1] for key in some]
        parts = np.split(by_key[some[0]][0].coefficient(table, by_key[some[0]][2]), np.cumsum([s.size for s in states]))
        found |= {key: part.reshape(s.pressure_hertz.shape) for key, part, s in zip(some, parts, states, strict=False)}
    return [found[key] for key in keys]


def uncertain_inputs(
    model: FrictionModel, state: ContactState, oil: Oil, spreads: UncertaintyInput, *, warm_inlet: bool = False
) -> list[UncertainInput[Case]]:
    """Every uncertain input of a case."""

    rms = ("roughness_rms_1", "roughness_rms_2")
    bulk = ("temperature_bulk_1", "temperature_bulk_2", *(("temperature_oil",) if warm_inlet else ()))

    def of_state(*fields: str) -> Moving:
        def moved(spread: Spread, case: Case, z: float) -> Case:
            values = {field: np.asarray(spread.at(getattr(case[1], field), z)) for field in fields}
            if fields == bulk:  # laws of oils end there
                values = {field: np.clip(value, *TEMPERATURE_RANGE) for field, value in values.items()}
            return case[0], replace(case[1], **values), case[2]

        return moved

    def of_oil(name: str) -> Moving:
        return lambda spread, case, z: (*case[:2], varied_oil(case[2], name, spread.sd, z))

    def of_model(field: str, value: float, least: float, most: float) -> Moving:
        return lambda spread, case, z: (_with(case[0], field, min(max(spread.at(value, z), least), most)), *case[1:])

    def laid(_: Spread, case: Case, z: float) -> Case:
        length, gamma = spreads.lay_moved(case[1].correlation_length, case[1].peklenik_number, z)
        return case[0], replace(case[1], correlation_length=length, peklenik_number=gamma), case[2]

    def conducting(spread: Spread, case: Case, z: float) -> Case:
        held: Any = case[0]
        if not hasattr(held, "bodies"):  # a formula uses stated slopes only
            return case
        bodies = tuple(
            body.model_copy(update={"thermal_conductivity": spread.at(body.thermal_conductivity, z)})
            for body in held.bodies
        )
        return replace(held, bodies=bodies), *case[1:]

    moving: dict[str, Moving] = {name: of_oil(name) for name in VARIABLES}
    moving |= {"roughness_rms": of_state(*rms)} if spreads.shared_rms else {name: of_state(name) for name in rms}
    moving |= {"correlation_length": of_state("correlation_length"), "peklenik_number": laid}
    mu_b = boundary_friction_of(model)
    if np.isfinite(mu_b):
        moving["boundary_friction"] = of_model("boundary_friction", mu_b, 0.0, 1.0)
    moving["boundary_film"] = lambda spread, case, z: case
    if hasattr(model, "boundary_film"):
        film = SurfaceInput(boundary_film=model.boundary_film).film_of_contact
        moving["boundary_film"] = of_model("boundary_film", film, *FILMS)
    moving |= {"temperature_bulk": of_state(*bulk), "conductivity_solid": conducting}
    found = []
    for name, moved in moving.items():
        of = "roughness_rms" if name in rms else name
        if not (spread := spreads.spread(of, oil)).known:
            found.append(UncertainInput(name, of, spread, partial(moved, spread)))
    return found


def varied_oil(oil: Oil, name: str, sd: float, score: float) -> Oil:
    """Copy of an oil with one property changed by `score` standard deviations of its logarithm."""
    known = oil.uncertainty.model_copy(update={name: sd})
    return oil.model_copy(update={"uncertainty": known}).varied(**{name: score})


@dataclass(frozen=True)
class FrictionChanges:
    """Effect of uncertain inputs on the friction at every point.

    each: change of ln mu with each input alone at the ends of its interval, for inputs that have an effect. The last
        entry is the error of the formula, if it states one.
    together: change of ln mu with several inputs changed at once. Its argument holds, for each case, the scores by
        name, in units of the score of the level; the second one selects points.
    """

    each: list[Change]
    together: Callable[..., list[Array]]


def friction_changes(
    model: FrictionModel,
    state: ContactState,
    oil: Oil,
    spreads: UncertaintyInput = DEFAULT,
    level: float = LEVEL,
    *,
    warm_inlet: bool = False,
    evaluate: Callable[[list[Case]], list[Array]] | None = None,
) -> FrictionChanges:
    """Change of ln mu at every point with the inputs at the ends of their intervals.

    model: evaluated twice for each input.
    state: contact points; an input changes in the same way at all of them.
    oil: oil card.
    spreads: standard deviations of the inputs.
    level: probability of the interval of each input [-].
    warm_inlet: whether the oil enters the contact at the temperature of the bodies.
    evaluate: friction of many cases, for parallel computation.
    Raises `InputError`: the level is not between 0 and 1.
    """
    score = score_of(level)
    if isinstance(model, ConstantFriction):
        return FrictionChanges([], lambda scores, at=...: [])
    fitted, solving = isinstance(model, FittedFormula), model.solves_contacts
    ratio = conditions_of(state, oil)["film_ratio_formula"]
    inputs = uncertain_inputs(model, state, oil, spreads, warm_inlet=warm_inlet)
    if solving and np.all(ratio > THICK):
        inputs = [entry for entry in inputs if entry.input not in SURFACE]

    friction = evaluate or friction_of_cases
    nominal: Case = (model, state, oil)
    start, *ends = friction([nominal, *(entry.moved(nominal, z) for entry in inputs for z in (-score, score))])
    parts = _parts(model, state, oil, start) if isinstance(model, FittedFormula) else None
    found: list[Change] = []
    model_inputs: list[UncertainInput[Case]] = []
    # terms of ln mu proportional to the score of an input: below, above
    added: dict[str, tuple[Array, Array]] = {}
    for entry, below, above in zip(inputs, ends[::2], ends[1::2], strict=True):
        low, high = _log_ratio(below, start), _log_ratio(above, start)
        note = entry.spread.source
        nothing = max(np.abs(low).max(initial=0.0), np.abs(high).max(initial=0.0)) < _NOTHING
        if not nothing:
            model_inputs.append(entry)
        if fitted and (nothing or entry.input in _BESIDE):
            stated, of = stated_change(entry.input, entry.spread, ratio, score), STATED
            if entry.input == "boundary_film" and parts is not None:
                stated, of = (
                    _by_load_share(parts, stated_change(FILM_TO_SHARE, entry.spread, ratio, score)),
                    STATED_SHARE,
                )
            if stated is not None:
                added[entry.name] = stated
                low, high, note, nothing = low + stated[0], high + stated[1], f"{note}; {of}", False
        if not nothing:
            found.append(Change(entry.name, GROUPS[entry.input], entry.spread.sd, low, high, note))
    for change in (
        *_formula_error(model, state, oil, score),
        *_lateral_error(spreads, ratio, score, fitted or solving),
    ):
        added[change.name] = change.below, change.above
        found.append(change)

    of_oil = [entry for entry in model_inputs if entry.input in VARIABLES]
    of_model = [entry for entry in model_inputs if entry.input in ("boundary_friction", "boundary_film")]
    of_state = [entry for entry in model_inputs if entry not in (*of_oil, *of_model)]
    held: dict[tuple[tuple[str, float], ...], Case] = {}

    def part(some: Sequence[UncertainInput[Case]], each: Mapping[str, float]) -> Case:
        """The case with the inputs of the model or of the oil shifted; equal ones are one object, evaluated at once."""
        key = tuple((entry.name, each.get(entry.name, 0.0)) for entry in some)
        if key not in held:
            held[key] = shifted(nominal, some, score, each)
        return held[key]

    def together(scores: Sequence[Mapping[str, float]], at: Any = ...) -> list[Array]:
        local, before = state.at(at), start[at]
        cases = []
        for each in scores:
            case = part(of_model, each)[0], local, part(of_oil, each)[2]
            cases.append(shifted(case, of_state, score, each))
        found = friction(cases)
        # if a point has a value in the nominal case only, the change is not defined
        changes = [np.where(np.isfinite(mu) | ~np.isfinite(before), _log_ratio(mu, before), np.nan) for mu in found]
        for change, each, (moved, there, card) in zip(changes, scores, cases, strict=True):
            for name, (below, above) in added.items():
                size = each.get(name, 0.0)
                change += size * above[at] if size > 0.0 else -size * below[at]
            mu_b = boundary_friction_of(moved)
            least = np.maximum(_log_ratio(np.full_like(before, mu_b), before), 0.0)
            if np.isfinite(mu_b) and np.any(change > least):  # upper bound of the friction of film and asperities
                limit = np.maximum(mu_b, conditions_of(there, card)["limiting_shear_coefficient"])
                np.minimum(change, np.maximum(_log_ratio(limit, before), 0.0), out=change)
        return changes

    return FrictionChanges(found, together)


# asperity load share, friction of the asperities and of the film
Parts = tuple[Array, Array, Array]


def _parts(model: FittedFormula, state: ContactState, oil: Oil, mu: Array) -> Parts | None:
    """The parts of mu of a formula that has them: friction without boundary friction is that of the film."""
    if model.form.parts is None or model.boundary_friction <= 0.0:
        return None
    film = np.minimum(friction_of(_with(model, "boundary_friction", 0.0), state, oil), mu)
    asperities = mu - film
    return np.clip(asperities / model.boundary_friction, 1e-9, 1.0 - 1e-9), asperities, film


def _by_load_share(parts: Parts, changes: tuple[Array, Array] | None) -> tuple[Array, Array] | None:
    """Change of ln mu by changes of the logit of the asperity load share, below and above.

    The friction of the film follows the power `FILM_POWER` of its load share, as in the networks.
    """
    if changes is None:
        return None
    share, asperities, film = parts

    def moved(change: Array) -> Array:
        odds = share / (1.0 - share) * np.exp(change)
        new = odds / (1.0 + odds)
        changed = asperities * new / share + film * ((1.0 - new) / (1.0 - share)) ** FILM_POWER
        return _log_ratio(changed, asperities + film)

    return moved(changes[0]), moved(changes[1])


# a formula contains one of their effects at most: the temperature of the bodies acts in addition to that of the inlet
_BESIDE = ("temperature_bulk",)


def _log_ratio(changed: Array, start: Array) -> Array:
    """ln(changed/start); 0 where it is not defined."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.log(changed / start)
    return np.where(np.isfinite(ratio), ratio, 0.0)


def _formula_error(model: FrictionModel, state: ContactState, oil: Oil, score: float) -> list[Change]:
    """Interval of the model converted to the level of the score; empty for models that solve contacts or state none."""
    if model.solves_contacts:
        return []
    given = model.evaluate(conditions_of(state, oil), oil)
    level = model.interval.level if isinstance(model, FittedFormula) else TWO_SIGMA
    scale = score / score_of(level)
    below, above = (scale * _log_ratio(end, given.mu) for end in (given.lower, given.upper))
    if not (np.any(below) or np.any(above)):
        return []
    return [Change(FORMULA, "formula", math.nan, below, above, "error of the formula on held-out contacts")]


def _lateral_error(spreads: UncertaintyInput, film_ratio: Array, score: float, resolved: bool) -> list[Change]:
    """Error of the model of two-dimensional roughness in solved contacts and in formulas fitted to them."""
    spread = spreads.spread(LATERAL_CAUSE)
    change = score * np.where(film_ratio <= THICK, lateral_spread(film_ratio, spread.sd), 0.0)
    if not resolved or not np.any(change):
        return []
    return [Change(LATERAL_CAUSE, GROUPS[LATERAL_CAUSE], spread.sd, -change, change, spread.source)]


def point_uncertainty(
    model: FrictionModel, state: ContactState, oil: Oil, spreads: UncertaintyInput = DEFAULT, level: float = LEVEL
) -> InputUncertainty:
    """Interval of the friction coefficient of one contact point."""
    mu = float(np.ravel(friction_of(model, state, oil))[0])
    found = friction_changes(model, state, oil, spreads, level)
    changes = [
        replace(change, below=float(np.ravel(change.below)[0]), above=float(np.ravel(change.above)[0]))
        for change in found.each
    ]

    def together(scores: Sequence[Mapping[str, float]]) -> list[float]:
        return [float(np.ravel(change)[0]) for change in found.together(scores)]

    slopes = None if model.solves_contacts else together
    name, notes = "friction_coefficient", missing(model)
    return InputUncertainty.of(name, mu, changes, lambda ln: mu * float(np.exp(ln)), level, notes, together, slopes)


def missing(model: FrictionModel) -> tuple[str, ...]:
    """Sources of uncertainty that the interval of a model does not include."""
    if isinstance(model, FittedFormula) or model.solves_contacts:
        return ()
    return (f"the error of {model.name} itself is unknown and not included in the interval",)
