"""Uncertainty of an efficiency from its inputs: oil, roughness, boundary film and friction, bulk, formula.

Each input has one value for the whole flank and is set to both ends of its interval, one at a time. The loss is summed
again with the friction there, at the same load and sliding. The numerical error (mesh, number of contacts) is the
`efficiency_error` of the result and not part of the interval.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from efficiency.loss.contact_sample import coordinates, nearest, spread, worth_solving
from efficiency.loss.kinematics import LoadedPoints
from efficiency.loss.lubrication import bulk_spread
from efficiency.loss.power_loss import efficiency_of
from ehl.common.arrays import FloatArray
from ehl.common.runner import run_tasks
from ehl.fluid.oil import Oil
from ehl.state import ContactState
from ehl.uncertainty.result import Change, InputUncertainty, Together
from ehl.uncertainty.spread import UncertaintyInput
from regression.formula import ANY_OIL, Formula, shipped_formulas
from regression.friction.models import FrictionEstimate, FrictionModel
from regression.friction.uncertainty import FORMULA, Case, FrictionChanges, friction_changes, friction_of, missing

if TYPE_CHECKING:
    from efficiency.loss.efficiency_result import EfficiencyResult

# maximum number of contact points that represent a mesh
POINTS = 250
# of these, every n-th one gives the derivatives of the loss
SLOPE_POINTS = 5
# number of contacts of a mesh that are solved at both ends of every input
CONTACTS = 8
# standard deviation of ln(rolling loss): its formula is 0.82 to 1.03 of the smooth solver, viscosity 5 % (this work)
ROLLING = 0.12

LossChanges = tuple[list[Change], Together, Together | None]
"""Changes of ln(loss): with each input at the ends of its interval, with several inputs changed together, and the same
at fewer points for derivatives."""


@dataclass(frozen=True)
class LossSample:
    """Points that represent a mesh."""

    state: ContactState
    friction: FrictionEstimate
    power: FloatArray  # F |v_s| [W]

    @classmethod
    def of(cls, points: LoadedPoints, friction: FrictionEstimate, most: int = POINTS) -> LossSample:
        """Every n-th point, with n such that there are at most `most` points."""
        at = slice(None, None, max(1, math.ceil(points.force.size / most)))
        estimate = FrictionEstimate(friction.mu[at], friction.lower[at], friction.upper[at], friction.flag[at])
        return cls(points.state.at(at), estimate, (points.force * points.speed_sliding)[at])

    def mean(self, log_change: FloatArray, at: Any = ...) -> float:
        """Change of ln(loss) for changes of ln mu at each point, or at some of them."""
        mu, power = self.friction.mu[at], self.power[at]
        loss = np.where(np.isfinite(mu), mu, 0.0) * power
        total = float(loss.sum())
        return math.log(float(np.sum(loss * np.exp(log_change))) / total) if total > 0.0 else 0.0

    def changes(self, found: FrictionChanges, note: str = "", *, formula: bool = True) -> LossChanges:
        """Changes of ln(loss) by each input and by all together; `formula`: include the error of the formula."""
        each = []
        for change in found.each:
            below, above = self.mean(change.below), self.mean(change.above)
            if (formula or change.name != FORMULA) and (below != 0.0 or above != 0.0):
                each.append(replace(change, below=below, above=above, note=change.note + note))

        def together(scores: Sequence[Mapping[str, float]], at: Any = ...) -> list[float]:
            return [self.mean(change, at) for change in found.together(scores, at)]

        return each, together, lambda scores: together(scores, slice(None, None, SLOPE_POINTS))


def stand_in(model: FrictionModel, oil: Oil) -> tuple[FrictionModel, str]:
    """Formula that represents the friction of solved contacts, and the note on it."""
    name = (*shipped_formulas(oil.name), ANY_OIL)[0]
    found = Formula.load(name).with_options(getattr(model, "boundary_friction", None))
    other = "" if shipped_formulas(oil.name) else ", of another oil"
    return found, f"by the formula {name}{other}"


def _solved_changes(
    model: FrictionModel, points: LoadedPoints, oil: Oil, spreads: UncertaintyInput, level: float, warm_inlet: bool
) -> LossChanges:
    """Changes of ln(loss) by solving contacts at both ends of every input, with the same roughness.

    Each of the contacts, which are spread over the mesh, represents the loss of its neighbourhood.
    """
    changed: Any = model
    place, power = coordinates(points.state), points.force * points.speed_sliding
    able = worth_solving(points.state, power)
    chosen = able[spread(place[able], power[able], CONTACTS)]
    shares = np.bincount(nearest(place, place[chosen]), weights=power, minlength=chosen.size).astype(np.float64)
    alone, state = replace(changed, points=None, jobs=1), points.state.at(chosen)
    nominal: list[FloatArray] = []

    def evaluate(cases: list[Case]) -> list[FloatArray]:
        found = list(run_tasks(cases, _friction_of_case, jobs=changed.jobs))
        nominal.append(found[0])
        return found

    found = friction_changes(alone, state, oil, spreads, level, warm_inlet=warm_inlet, evaluate=evaluate)
    mu = nominal[0]
    sample = LossSample(state, FrictionEstimate(mu, mu, mu, np.zeros(mu.shape, np.int8)), shares)
    each, together, _ = sample.changes(found, f"; {chosen.size} contacts solved at both ends")
    return each, together, None


def _friction_of_case(case: Case) -> FloatArray:
    return friction_of(*case)


def efficiency_uncertainty(
    result: EfficiencyResult, spreads: UncertaintyInput | None, level: float, *, solved: bool
) -> InputUncertainty:
    """Interval of the efficiency from the uncertainty of the inputs; arguments of `EfficiencyResult.uncertainty`."""
    model, oil, operation, points = result.case.model, result.case.card, result.case.operation, result.points
    warm, spreads = operation.temperature_inlet is not None, operation.uncertainty if spreads is None else spreads
    spreads = spreads.with_surface_of(operation.uncertainty)
    if operation.temperature_inlet is not None:
        spreads = spreads.of_bulk(bulk_spread(operation.temperature_inlet - operation.temperature))
    sample = LossSample.of(points, result.friction)
    state = sample.state
    if solved and model.solves_contacts:
        each, together, slopes = _solved_changes(model, points, oil, spreads, level, warm)
    elif model.solves_contacts:
        formula, note = stand_in(model, oil)
        if getattr(model, "smooth", False):
            nothing = np.zeros_like(state.roughness_rms_1)
            state = replace(state, roughness_rms_1=nothing, roughness_rms_2=nothing)
        found = friction_changes(formula, state, oil, spreads, level, warm_inlet=warm)
        each, together, slopes = sample.changes(found, f"; {note}", formula=False)
    else:
        each, together, slopes = sample.changes(friction_changes(model, state, oil, spreads, level, warm_inlet=warm))

    def figure(ln: float) -> float:
        loss = result.power_loss * math.exp(ln)
        return efficiency_of(loss, result.conditions.torque, operation.speed, operation.driver)

    return InputUncertainty.of("efficiency", figure(0.0), each, figure, level, missing(model), together, slopes)
