"""Friction by solving the lubricated contact itself, at every point of the mesh or at enough to predict the others.

Contacts are solved along paths on which each starts the next: at most 320 of a mesh, 80 by the deterministic rough
solver. A contact that cannot be solved is predicted by the others, as wrong as the worst of them would be.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from efficiency.loss.contact_sample import chain, coordinates, nearest, predict, remoteness, spread, worth_solving
from efficiency.loss.lubrication import SolvedFriction
from ehl.contact_result import ContactResult
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.inputs import ModelInput, SurfaceInput
from ehl.io.errors import InputError
from ehl.io.telling import tell
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.solve import solve_contact
from ehl.state import ContactState
from ehl.warmup import prepare_workers
from regression.friction.models import FrictionFlag

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Scene = tuple[LineContact, Lubricant, SurfaceInput, tuple[float, float]]

# contacts solved for a mesh: of the smooth film (load sharing adds nothing to its cost), of the rolling rough surfaces
POINTS, POINTS_DETERMINISTIC = 320, 80
# contacts below which a worker process does not pay, and parts of the work for each: contacts differ in cost
MIN_PER_JOB, PARTS_PER_JOB = 12, 4
# share of the sliding power next to contacts that failed, from which there is no friction
MAX_FAILED = 0.1
# interval of the prediction, in RMS errors of the contacts predicted by the others
_WIDTH = 2.0
# what is kept of each solution beside its errors
_KEPT = ("friction_coefficient", "film_central", "film_ratio", "temperature_flash", "rolling_traction")


@dataclass(frozen=True)
class Solved:
    """Contacts of a mesh as they were solved.

    Attributes
    ----------
    values : (5, n) array
        `_KEPT`, the film ratio as its inverse, which is finite; nan where a contact failed.
    scatter, bias : (n,) arrays
        Error of mu by chance (the interval of its mean over time) and of the method [-].
    reasons : tuple of str
        Why a contact failed; empty where it did not.
    """

    values: FloatArray
    scatter: FloatArray
    bias: FloatArray
    reasons: tuple[str, ...]


@dataclass(frozen=True)
class EhlFriction:
    """The contact solver as a friction model.

    Parameters
    ----------
    name : str
        What the user asked for.
    smooth : bool
        Leave the roughness out.
    points : int or None
        Most contacts that are solved; None solves every point.
    jobs : int or None
        Worker processes; None takes one per core.
    bodies : tuple of Material
        Pinion and gear.
    model : ModelInput
        Physics and accuracy of each contact.
    boundary_friction : float
        mu_b of asperity contacts [-].
    boundary_film : float, optional
        Gap at which asperities touch [m]; from the roughness where not given.
    seed : int
        Of the roughness of the first contact; the next ones count on. Each contact meets its own stretch of the flanks,
        so that what one profile does by chance averages out over a mesh.
    """

    name: str
    smooth: bool = False
    points: int | None = None
    jobs: int | None = None
    bodies: tuple[Material, Material] = field(default_factory=lambda: (Material.load("steel"),) * 2)
    model: ModelInput = field(default_factory=lambda: ModelInput(accuracy="fast"))
    boundary_friction: float = 0.10
    boundary_film: float | None = None
    seed: int = 1

    @property
    def solves_contacts(self) -> bool:
        """Each value is costly: nobody should ask for more of them than needed."""
        return True

    @property
    def uses_texture(self) -> bool:
        """Whether the Peklenik number has an effect: it steers the oil between rolling asperities."""
        return not self.smooth and self.model.roughness == "deterministic"

    def evaluate(self, state: ContactState, oil: Oil) -> SolvedFriction:
        """Friction at every point.

        `lower` and `upper` are two RMS errors of contacts predicted by the others away, weighted with their sliding
        power, and the solver's own error that is no chance; where all points are solved, the solver's own error. A
        contact that does not converge is predicted by the others, and the interval of the points next to it is the
        largest error of such a prediction, in proportion to the distance where no contact is near; they are flagged.
        Where those points hold more than a tenth of the sliding power, or too few contacts are left to predict with,
        they have no friction. A contact that is only unsettled counts with its error.
        """
        place = coordinates(state)
        power = state.load_per_length * state.speed_sliding
        if self.points is None or state.size <= self.points:
            chosen = np.arange(state.size)
        else:
            able = worth_solving(state, power)
            chosen = able[spread(place[able], power[able], self.points)]
        return _friction(place, power, chosen, self._solve(state, oil, chosen, chain(place[chosen])))

    def _solve(self, state: ContactState, oil: Oil, chosen: IntArray, path: IntArray) -> Solved:
        """The chosen points; the path is the order in which neighbours start each other."""
        jobs = max(1, min(self.jobs or _cores(), _cores(), path.size // MIN_PER_JOB))
        parts = 1 if jobs == 1 else min(PARTS_PER_JOB * jobs, path.size // MIN_PER_JOB)
        scenes = [self._contact(state, oil, int(at), self.seed + k) for k, at in enumerate(chosen)]
        tasks = [[scenes[k] for k in part] for part in np.array_split(path, parts)]
        if jobs == 1:
            found = [_solve_chain(tasks[0], self.model, self.bodies, telling=True)]
        else:
            from joblib import Parallel, delayed, parallel_config

            prepare_workers(rough=not self.smooth and self.model.roughness == "deterministic")
            with parallel_config(backend="loky", inner_max_num_threads=1):
                work = (delayed(_solve_chain)(task, self.model, self.bodies) for task in tasks)
                found, total = [], path.size
                tell("contacts", 0, total)
                for part in Parallel(n_jobs=jobs, return_as="generator")(work):
                    found.append(part)
                    tell("contacts", sum(len(reasons) for *_, reasons in found), total)
        order = np.argsort(path)
        values, scatter, bias = (np.concatenate([part[k] for part in found], axis=-1)[..., order] for k in range(3))
        reasons = [reason for part in found for reason in part[3]]
        return Solved(values, scatter, bias, tuple(reasons[k] for k in order))

    def _contact(self, state: ContactState, oil: Oil, at: int, seed: int) -> Scene:
        rms = (0.0, 0.0) if self.smooth else (float(state.roughness_rms_1[at]), float(state.roughness_rms_2[at]))
        surface = SurfaceInput(
            roughness_rms_1=rms[0],
            roughness_rms_2=rms[1],
            correlation_length=float(state.correlation_length[at]),
            peklenik_number=float(state.peklenik_number[at]),
            boundary_film=self.boundary_film,
            boundary_friction=self.boundary_friction,
            seed=seed,
        )
        bulk = float(state.temperature_bulk_1[at]), float(state.temperature_bulk_2[at])
        return _line(state, at), oil.at(float(state.temperature_oil[at])), surface, bulk


def _cores() -> int:
    from joblib import cpu_count

    return int(cpu_count())


def _solve_chain(
    scenes: list[Scene], model: ModelInput, bodies: tuple[Material, Material], *, telling: bool = False
) -> tuple[FloatArray, FloatArray, FloatArray, list[str]]:
    """What `Solved` holds, of contacts of which each starts the next."""
    values = np.full((len(_KEPT), len(scenes)), np.nan)
    scatter, bias = np.full((2, len(scenes)), np.nan)
    reasons = [""] * len(scenes)
    before: ContactResult | None = None
    for k, (line, lubricant, surface, bulk) in enumerate(scenes):
        if telling:
            tell("contacts", k, len(scenes))
        result = solve_contact(line, lubricant, surface, model, bodies, bulk, before)
        if result.status == "failed":
            reasons[k] = result.reason
            continue
        before = result
        mu, film, ratio, hot, rolling = (float(getattr(result, name)) for name in _KEPT)
        values[:, k] = mu, film, 1.0 / ratio, hot, rolling
        scatter[k] = abs(mu) * result.statistical_error
        bias[k] = abs(mu) * (result.friction_error - result.statistical_error)
    return values, scatter, bias, reasons


def _friction(place: FloatArray, power: FloatArray, chosen: IntArray, solved: Solved) -> SolvedFriction:
    """Friction at all points from the chosen ones."""
    size, every = len(place), chosen.size == len(place)
    known = np.isfinite(solved.values[0])
    doubtful = ~known[nearest(place, place[chosen])]
    total = float(power.sum())
    # where nothing slides all points count alike
    share = power / total if total > 0.0 else np.full(size, 1.0 / size)

    values, half, chance = np.full((len(_KEPT), size), np.nan), np.full(size, np.nan), 0.0
    prediction = None
    if known.any() and not (every and known.all()):
        weight = share[chosen[known]]
        prediction = predict(place, place[chosen[known]], solved.values[:, known], weight)
    if prediction is not None:
        square = prediction.missed**2
        reach = _WIDTH * math.sqrt(float(np.average(square, weights=weight if weight.any() else None)))
        worst = max(reach, math.sqrt(square.max())) * remoteness(place, place[chosen[known]])
        values, half = prediction.values, np.where(doubtful, worst, reach)
        # what the contacts miss by chance is independent of each other
        chance = _WIDTH * float(np.linalg.norm((share @ prediction.weights) * prediction.missed))
    if every:
        values, half = np.where(known, solved.values, values), np.where(known, solved.scatter, half)
        chance = float(np.linalg.norm((share * solved.scatter)[known]))
    if float(share[doubtful].sum()) > MAX_FAILED:
        values[:, doubtful] = np.nan
    bias = solved.bias[known][nearest(place, place[chosen[known]])] if known.any() else np.full(size, np.nan)
    missing = chance + float((share * half)[doubtful].sum() + (share * bias).sum())
    half = half + bias

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
    )


def ehl_friction(spec: str, bodies: tuple[Material, Material] | None = None) -> EhlFriction:
    """The model of a name: ``ehl`` (the rough surfaces rolled through), ``ehl:load_sharing`` or ``ehl:smooth``.

    They solve 80, 320 and 320 contacts and interpolate the others; ``:all`` at the end solves every point, ``:sampled``
    80 of them.

    Raises
    ------
    InputError
        Another word after the colon, or two that exclude each other.
    """
    words = spec.split(":")
    wanted = set(words[1:])
    clash = {"smooth", "load_sharing"} <= wanted or {"all", "sampled"} <= wanted
    if words[0] != "ehl" or clash or not wanted <= {"smooth", "load_sharing", "all", "sampled"}:
        raise InputError(
            "friction model", spec, "ehl, ehl:load_sharing or ehl:smooth, with :all or :sampled at the end"
        )
    steel = Material.load("steel")
    points = POINTS if wanted & {"smooth", "load_sharing"} and "sampled" not in wanted else POINTS_DETERMINISTIC
    model = ModelInput(accuracy="fast", roughness="load_sharing" if "load_sharing" in wanted else "deterministic")
    return EhlFriction(
        spec, "smooth" in wanted, None if "all" in wanted else points, bodies=bodies or (steel, steel), model=model
    )


def _line(state: ContactState, at: int) -> LineContact:
    return LineContact.from_pressure(
        radius_equivalent=float(state.radius_equivalent[at]),
        effective_modulus=float(state.effective_modulus[at]),
        pressure_hertz=float(state.pressure_hertz[at]),
        speed_entrainment=float(state.speed_entrainment[at]),
        slide_to_roll=float(state.slide_to_roll[at]),
        speed_sliding_lengthwise=float(state.speed_sliding_lengthwise[at]),
    )
