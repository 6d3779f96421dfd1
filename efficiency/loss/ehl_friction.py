"""Friction by solving the lubricated contact, at every point of the mesh or at enough points to predict the others.

A few contacts are solved first. More are added where the loss is least certain, until the random error is below the
tolerance. A failed contact is predicted by the others with their largest error.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from efficiency.loss import contact_sample as sample
from efficiency.loss.lubrication import SolvedFriction
from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.progress import report_progress
from ehl.common.runner import checked_jobs, run_tasks
from ehl.common.units import ValueRange
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.inputs import ContactProblem, ModelInput, SurfaceInput
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.solve import solve_contact
from ehl.state import ContactState
from ehl.surface.finish import FLANK_SKEWNESS
from ehl.warmup import prepare_workers
from regression.friction.conditions import Conditions, conditions_of, state_of
from regression.friction.models import FrictionFlag, FrictionModel
from regression.plan.cost import contact_seconds

IntArray = NDArray[np.int64]
Scene = tuple[LineContact, Lubricant, SurfaceInput, tuple[float, float]]

# maximum number of contacts of a mesh, of contacts solved first, of contacts added at once; maximum for `:sampled`
POINTS, FIRST, MORE, SAMPLED = 320, 24, 8, 80
# tolerance of the random error of the mean friction, with rough contacts (each has its own profile) and smooth ones
TOLERANCE, TOLERANCE_SMOOTH = 0.03, 0.002
# minimum work of a worker process, which takes two or three seconds to start [s]
MIN_SECONDS = 3.0
# share of the sliding power near failed contacts above which these points have no friction
MAX_FAILED = 0.1
# half width of the prediction interval in RMS leave-one-out errors
_WIDTH = 2.0
# results kept of each solution, in addition to its errors
_KEPT = ("friction_coefficient", "film_central", "film_ratio", "temperature_flash", "rolling_traction")


@dataclass(frozen=True)
class Solved:
    """Solved contacts of a mesh."""

    values: FloatArray  # (5, n) `_KEPT`, with the inverse of the film ratio, which is finite; nan for a failed contact
    scatter: FloatArray  # (n,) random error of mu (interval of its time mean) [-]
    bias: FloatArray  # (n,) error of the method [-]
    reasons: tuple[str, ...]  # reason of failure; empty for a solved contact

    def __add__(self, more: Solved) -> Solved:
        """These and further contacts."""
        return Solved(
            np.concatenate([self.values, more.values], axis=1),
            np.concatenate([self.scatter, more.scatter]),
            np.concatenate([self.bias, more.bias]),
            self.reasons + more.reasons,
        )


@dataclass(frozen=True)
class EhlFriction(FrictionModel):
    """The contact solver as a friction model."""

    name: str  # as given by the user
    smooth: bool = False  # neglect the roughness
    points: int | None = None  # maximum number of solved contacts; None solves every point
    # relative random error of the mean friction (two standard deviations): contacts are added until it is reached or
    # there are `points` contacts; with 0 all `points` are solved at once
    tolerance: float = 0.0
    jobs: int | None = None  # worker processes; None uses one per core
    bodies: tuple[Material, Material] = field(default_factory=lambda: (Material.load("steel"),) * 2)
    model: ModelInput = field(default_factory=lambda: ModelInput(accuracy="fast"))  # of each contact
    # mu_b of asperity contacts [-] and gap below which they are in contact [m]; default: of extreme-pressure additives
    boundary_friction: float | None = None
    skewness: float = FLANK_SKEWNESS  # of the heights of both flanks [-]
    boundary_film: float | None = None
    # of the roughness of the first contact, increased by one for each further contact: each has its own section of the
    # flanks, so that random effects of single profiles average out over a mesh
    seed: int = 1

    @property
    def solves_contacts(self) -> bool:
        """True: each value is expensive to compute."""
        return True

    @property
    def uses_texture(self) -> bool:
        """Whether the Peklenik number has an effect; it does with roughness."""
        return not self.smooth

    def evaluate(self, conditions: Conditions, oil: Oil) -> SolvedFriction:
        """Friction at every point.

        `lower` and `upper` differ by two RMS leave-one-out errors, weighted with the sliding power, and the numerical
        error of the solver. If all points are solved, only the error of the solver counts. A failed contact is
        predicted by the others. The points nearest to it are flagged; their interval is the largest prediction error,
        scaled with the distance to the contacts. If these points hold more than a tenth of the sliding power, or too
        few contacts remain, they have no friction. A contact that has not fully settled counts with its error.
        """
        state = state_of(conditions)
        place = sample.coordinates(state)
        power = state.load_per_length * state.speed_sliding
        if self.points is None or state.size <= (self.points if self.tolerance == 0.0 else FIRST):
            chosen = np.arange(state.size)
            return _friction(place, power, chosen, self._solve(state, oil, chosen, 0, chosen.size))
        least = sample.fewest(place.shape[1])
        if self.points < least:
            hint = f"With fewer contacts the friction at the other {state.size - self.points} points is not predicted."
            raise InputError("points", self.points, f"at least {least}, or None for all points", hint)
        able = sample.worth_solving(state, power)
        most = min(self.points, able.size)
        first = most if self.tolerance == 0.0 else min(FIRST, most)
        chosen = able[sample.spread(place[able], power[able], first)]
        solved = self._solve(state, oil, chosen, 0, chosen.size)
        while self.tolerance > 0.0 and chosen.size < most:
            error, parts = _left_open(place, power, chosen, solved)
            if error <= self.tolerance:
                break
            more = sample.divide(place, power, able, chosen, parts, min(MORE, most - chosen.size))
            if not more.size:
                break
            # the random error decreases with the square root of the number of contacts
            wanted = chosen.size * min((error / self.tolerance) ** 2, float(most))
            solved += self._solve(state, oil, more, chosen.size, min(most, max(math.ceil(wanted), chosen.size + MORE)))
            chosen = np.concatenate([chosen, more])
        return _friction(place, power, chosen, solved)

    def _solve(self, state: ContactState, oil: Oil, chosen: IntArray, done: int, total: int) -> Solved:
        """Solve the chosen points; `done` were solved before, `total` is the expected final number."""
        scenes = [self._contact(state, oil, int(at), self.seed + done + k) for k, at in enumerate(chosen)]
        table = {name: values[chosen] for name, values in conditions_of(state, oil).items()}
        table["correlation_length"] = state.correlation_length[chosen]
        if self.smooth:
            table["film_ratio_formula"] = np.full(chosen.size, np.inf)
        each = float(contact_seconds(self.model, table)[0].mean())
        worth = int(each * (done + chosen.size) / MIN_SECONDS)
        jobs = max(1, min(checked_jobs(self.jobs), worth, chosen.size))
        report_progress("contacts", done, total)
        found = []
        if jobs > 1:
            prepare_workers(rough=not self.smooth)
        # contacts are independent, so the result does not depend on the number of processes
        for one in run_tasks(scenes, partial(_solve_one, model=self.model, bodies=self.bodies), jobs=jobs):
            found.append(one)
            report_progress("contacts", done + len(found), total)
        values, errors, reasons = zip(*found, strict=True)
        scatter, bias = np.array(errors).T
        return Solved(np.array(values).T, scatter, bias, reasons)

    def _contact(self, state: ContactState, oil: Oil, at: int, seed: int) -> Scene:
        rms = (0.0, 0.0) if self.smooth else (float(state.roughness_rms_1[at]), float(state.roughness_rms_2[at]))
        chemistry = {"boundary_film": self.boundary_film, "boundary_friction": self.boundary_friction}
        surface = SurfaceInput(
            roughness_rms_1=rms[0],
            roughness_rms_2=rms[1],
            correlation_length=float(state.correlation_length[at]),
            peklenik_number=float(state.peklenik_number[at]),
            skewness=self.skewness,
            seed=seed,
            **{name: value for name, value in chemistry.items() if value is not None},
        )
        bulk = float(state.temperature_bulk_1[at]), float(state.temperature_bulk_2[at])
        line = LineContact.from_pressure(**line_conditions(state, at))
        return line, oil.at(float(state.temperature_oil[at])), surface, bulk


def _solve_one(
    scene: Scene, model: ModelInput, bodies: tuple[Material, Material]
) -> tuple[list[float], tuple[float, float], str]:
    """Values, errors and reason of failure of one contact, as in `Solved`.

    Contacts do not start from the solution of a neighbour. With heat this saved no time (0.93 to 1.06 of the time of
    the smooth solution over 80 contacts of two meshes), and a rough contact spends a tenth of its time there.
    """
    line, lubricant, surface, bulk = scene
    result = solve_contact(ContactProblem(line, lubricant, surface, model, bodies, bulk))
    if result.status == "failed":
        return [math.nan] * len(_KEPT), (math.nan, math.nan), result.reason
    mu, film, ratio, hot, rolling = (float(getattr(result, name)) for name in _KEPT)
    scatter = result.statistical_error
    # the error of mu is the root of the sum of the squares of both
    errors = abs(mu) * scatter, abs(mu) * math.sqrt(max(result.friction_error**2 - scatter**2, 0.0))
    return [mu, film, 1.0 / ratio, hot, rolling], errors, ""


def _left_open(place: FloatArray, power: FloatArray, chosen: IntArray, solved: Solved) -> tuple[float, FloatArray]:
    """Relative random error of the mean friction, and the contribution of each contact."""
    known = np.isfinite(solved.values[0])
    share = power / power.sum() if power.any() else np.full(power.size, 1.0 / power.size)
    contacts = chosen[known]
    prediction = (
        sample.predict(place, place[contacts], solved.values[:, known], share[contacts]) if known.any() else None
    )
    if prediction is None:
        return math.inf, np.ones(chosen.size)
    missed = np.abs((share @ prediction.weights) * prediction.missed)
    # the error around a failed contact is the largest error of the others
    parts = np.full(chosen.size, missed.max())
    parts[known] = missed
    mean = float(share @ prediction.values[0])
    return (_WIDTH * float(np.linalg.norm(missed)) / mean if mean > 0.0 else math.inf), parts


def _friction(place: FloatArray, power: FloatArray, chosen: IntArray, solved: Solved) -> SolvedFriction:
    """Friction at all points from the chosen ones."""
    size, every = len(place), chosen.size == len(place)
    known = np.isfinite(solved.values[0])
    doubtful = ~known[sample.nearest(place, place[chosen])]
    total = float(power.sum())
    # without sliding all points have equal weight
    share = power / total if total > 0.0 else np.full(size, 1.0 / size)

    values, half, chance = np.full((len(_KEPT), size), np.nan), np.full(size, np.nan), 0.0
    prediction = None
    if known.any() and not (every and known.all()):
        weight = share[chosen[known]]
        prediction = sample.predict(place, place[chosen[known]], solved.values[:, known], weight)
    if prediction is not None:
        square = prediction.missed**2
        reach = _WIDTH * math.sqrt(float(np.average(square, weights=weight if weight.any() else None)))
        worst = max(reach, math.sqrt(square.max())) * sample.remoteness(place, place[chosen[known]])
        values, half = prediction.values, np.where(doubtful, worst, reach)
        # random errors of different contacts are independent
        chance = _WIDTH * float(np.linalg.norm((share @ prediction.weights) * prediction.missed))
    if every:
        values, half = np.where(known, solved.values, values), np.where(known, solved.scatter, half)
        chance = float(np.linalg.norm((share * solved.scatter)[known]))
    if float(share[doubtful].sum()) > MAX_FAILED:
        values[:, doubtful] = np.nan
    bias = solved.bias[known][sample.nearest(place, place[chosen[known]])] if known.any() else np.full(size, np.nan)
    # errors of the method are those of all contacts alike, random ones are independent of them
    method = float((share * bias).sum())
    missing = math.hypot(chance, method) + float((share * half)[doubtful].sum())
    half = np.hypot(half, bias)

    mu, film, thinness, hot, rolling = values
    mean = float(share @ mu)
    flag = np.where(doubtful, FrictionFlag.PREDICTED, FrictionFlag.OK)
    flag = np.where(np.isfinite(mu), flag, FrictionFlag.NOT_CONVERGED).astype(np.int8)
    ratio = np.full(mu.shape, np.inf)
    np.divide(1.0, thinness, out=ratio, where=thinness != 0.0)
    return SolvedFriction(
        mu,
        np.maximum(mu - half, 0.0),
        mu + half,
        flag,
        film,
        ratio,
        hot,
        rolling,
        contacts=chosen.size,
        failed=dict(Counter(reason for reason in solved.reasons if reason)),
        mean_error=missing / mean if mean > 0.0 else math.nan,
        method_error=method / mean if mean > 0.0 else math.nan,
    )


def ehl_friction(
    spec: str, bodies: tuple[Material, Material] | None = None, skewness: float = FLANK_SKEWNESS
) -> EhlFriction:
    """Friction model by its name: ``ehl`` (transient solution with moving rough surfaces) or ``ehl:smooth``.

    Contacts are solved until the random error of the mean friction is below 3 % (``ehl``) or 0.2 % (``ehl:smooth``),
    at most 320. The other points are interpolated. Suffixes: ``:5%`` sets another error, ``:sampled`` solves at most
    80 contacts, ``:all`` solves every point.

    Raises `InputError`: an unknown suffix, or two suffixes that exclude each other.
    """
    words = spec.split(":")
    shares = [word for word in words[1:] if word.endswith("%")]
    wanted = set(words[1:]) - set(shares)
    clash = len(wanted & {"all", "sampled"}) + len(shares) > 1
    if words[0] != "ehl" or clash or not wanted <= {"smooth", "all", "sampled"}:
        allowed = "ehl or ehl:smooth, optionally with :all, :sampled or a share such as :5%"
        raise InputError("friction model", spec, allowed)
    steel = Material.load("steel")
    tolerance = TOLERANCE_SMOOTH if "smooth" in wanted else TOLERANCE
    if shares:
        tolerance = 0.01 * ValueRange("", gt=0.0, le=100.0).check(shares[0][:-1], "friction model")
    points = None if "all" in wanted else SAMPLED if "sampled" in wanted else POINTS
    return EhlFriction(spec, "smooth" in wanted, points, tolerance, bodies=bodies or (steel, steel), skewness=skewness)


def line_conditions(state: ContactState, at: int) -> dict[str, float]:
    """Keywords of a line contact at one point."""
    names = (
        *("radius_equivalent", "effective_modulus", "pressure_hertz", "speed_entrainment"),
        *("slide_to_roll", "speed_sliding_lengthwise"),
    )
    return {name: float(getattr(state, name)[at]) for name in names}
