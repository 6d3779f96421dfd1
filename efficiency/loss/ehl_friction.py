"""Friction by solving the lubricated contact itself, at every point of the mesh or at enough to interpolate the others.

The points of a mesh are a smooth two-parameter family of conditions, so some solutions, spread as far apart as
possible, carry the whole of it; the last of them are first predicted by the others, which measures the error. They are
solved along paths on which each starts the next: at most 320 of them, 80 by the deterministic rough solver.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from efficiency.loss.lubrication import SolvedFriction
from ehl.contact import LineContact
from ehl.errors import InputError
from ehl.inputs import ModelInput, SurfaceInput
from ehl.lubricant import Lubricant
from ehl.material import Material, load_material
from ehl.oil import Oil
from ehl.solve import ContactResult, solve_contact
from ehl.state import ContactState
from regression.friction_models import FrictionFlag

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Scene = tuple[LineContact, Lubricant, SurfaceInput, tuple[float, float]]

# contacts solved for a mesh: of the smooth film (load sharing adds nothing to its cost), of the rolling rough surfaces
POINTS, POINTS_DETERMINISTIC, HELD_OUT = 320, 80, 16
FEWEST_PER_JOB = 12  # contacts below which a worker process does not pay
# interval of the interpolation, in RMS errors at the held-out points
_WIDTH = 2.0
# slide-to-roll ratio below which friction is nearly proportional to it
_LINEAR_SLIDING = 0.05
# what is kept of each solution beside its error
_KEPT = ("friction_coefficient", "film_central", "film_ratio", "temperature_flash", "rolling_traction")


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
    """

    name: str
    smooth: bool = False
    points: int | None = None
    jobs: int | None = None
    bodies: tuple[Material, Material] = field(default_factory=lambda: (load_material("steel"),) * 2)
    model: ModelInput = field(default_factory=lambda: ModelInput(accuracy="fast"))
    boundary_friction: float = 0.10

    @property
    def solves_contacts(self) -> bool:
        """Each value is costly: nobody should ask for more of them than needed."""
        return True

    def evaluate(self, state: ContactState, oil: Oil) -> SolvedFriction:
        """Friction at every point.

        Where points are interpolated, `lower` and `upper` are two RMS errors of the prediction of held-out contacts
        away, weighted with their sliding power; where all are solved, the solver's own error. A contact that does not
        converge leaves nan at the points next to it, flagged; one that is only unsettled counts with its error.
        """
        place = _coordinates(state)
        power = state.load_per_length * state.speed_sliding
        if self.points is None or state.size <= self.points:
            chosen = np.arange(state.size)
        else:
            chosen = _spread(place, power, self.points)
        values, error = self._solve(state, oil, chosen, place)
        if chosen.size == state.size:
            estimate, spread = values, error
        else:
            estimate, spread = _interpolate(place, chosen, values, power)
        mu, film, thinness, hot, rolling = estimate
        flag = np.where(np.isfinite(mu), FrictionFlag.OK, FrictionFlag.NOT_CONVERGED).astype(np.int8)
        ratio = np.full(mu.shape, np.inf)
        np.divide(1.0, thinness, out=ratio, where=thinness != 0.0)
        return SolvedFriction(mu, np.maximum(mu - spread, 0.0), mu + spread, flag, film, ratio, hot, rolling)

    def _solve(
        self, state: ContactState, oil: Oil, chosen: IntArray, place: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Values at chosen points (5, n) and the absolute error of mu, nan where a contact failed.

        Neighbours start each other. The film ratio comes as its inverse, which is finite.
        """
        found = np.full((len(_KEPT) + 1, chosen.size), np.nan)
        order = np.array(_chain(place[chosen]))
        jobs = max(1, min(self.jobs or _cores(), chosen.size // FEWEST_PER_JOB))
        parts = np.array_split(order, jobs)
        tasks = [[self._contact(state, oil, int(at)) for at in chosen[part]] for part in parts]
        if jobs == 1:
            solved = [_solve_chain(tasks[0], self.model, self.bodies)]
        else:
            from joblib import Parallel, delayed, parallel_config

            with parallel_config(backend="loky", inner_max_num_threads=1):
                solved = Parallel(n_jobs=jobs)(delayed(_solve_chain)(task, self.model, self.bodies) for task in tasks)
        for part, values in zip(parts, solved, strict=True):
            found[:, part] = values
        return found[:-1], found[-1]

    def _contact(self, state: ContactState, oil: Oil, at: int) -> Scene:
        rms = (0.0, 0.0) if self.smooth else (float(state.roughness_rms_1[at]), float(state.roughness_rms_2[at]))
        surface = SurfaceInput(
            roughness_rms_1=rms[0],
            roughness_rms_2=rms[1],
            correlation_length=float(state.correlation_length[at]),
            boundary_friction=self.boundary_friction,
        )
        bulk = float(state.temperature_bulk_1[at]), float(state.temperature_bulk_2[at])
        return _line(state, at), oil.at(float(state.temperature_oil[at])), surface, bulk


def _cores() -> int:
    from joblib import cpu_count

    return int(cpu_count())


def _solve_chain(scenes: list[Scene], model: ModelInput, bodies: tuple[Material, Material]) -> FloatArray:
    """The kept values and the absolute error of mu, shape (6, n), of contacts of which each starts the next."""
    found = np.full((len(_KEPT) + 1, len(scenes)), np.nan)
    before: ContactResult | None = None
    for k, (line, lubricant, surface, bulk) in enumerate(scenes):
        result = solve_contact(line, lubricant, surface, model, bodies, bulk, before)
        if result.status != "failed":
            before = result
            mu, film, ratio, hot, rolling = (float(getattr(result, name)) for name in _KEPT)
            found[:, k] = mu, film, 1.0 / ratio, hot, rolling, abs(mu) * result.friction_error
    return found


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
    steel = load_material("steel")
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


def _coordinates(state: ContactState) -> FloatArray:
    """What friction depends on, scaled to a range of 1 each; what is the same at all points is left out."""
    columns = np.column_stack(
        [
            np.log(state.pressure_hertz),
            np.log(state.radius_equivalent),
            np.log(state.speed_entrainment),
            np.arcsinh(state.slide_to_roll / _LINEAR_SLIDING),
            np.arcsinh(state.speed_sliding_lengthwise / state.speed_entrainment / _LINEAR_SLIDING),
            state.temperature_oil,
            state.temperature_bulk_1,
            state.temperature_bulk_2,
            state.roughness_rms,
            state.correlation_length,
        ]
    )
    width = np.ptp(columns, axis=0)
    varies = width > 1e-9 * np.abs(columns).max(axis=0)
    if not varies.any():
        return np.zeros((state.size, 1))
    return np.asarray((columns[:, varies] - columns[:, varies].min(axis=0)) / width[varies])


def _spread(place: FloatArray, power: FloatArray, count: int) -> IntArray:
    """Points one by one as far from all earlier ones as possible, sooner where there is more sliding power."""
    # the fourth root keeps points without power, which matter only to plots, at a few of the lot
    favour = np.maximum(power / max(float(power.max()), 1e-300), 1e-6) ** 0.25
    chosen = [int(np.argmin(np.sum((place - place.mean(axis=0)) ** 2, axis=1)))]
    distance = np.sum((place - place[chosen[0]]) ** 2, axis=1)
    while len(chosen) < count and distance.max() > 0.0:
        chosen.append(int(np.argmax(distance * favour)))
        distance = np.minimum(distance, np.sum((place - place[chosen[-1]]) ** 2, axis=1))
    return np.array(chosen)


def _chain(place: FloatArray) -> list[int]:
    """An order in which each point is the nearest of those left to the one before."""
    left = np.ones(len(place), bool)
    order = [0]
    left[0] = False
    while left.any():
        distance = np.sum((place - place[order[-1]]) ** 2, axis=1)
        order.append(int(np.argmin(np.where(left, distance, np.inf))))
        left[order[-1]] = False
    return order


def _interpolate(
    place: FloatArray, chosen: IntArray, values: FloatArray, weight: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Thin-plate spline through the solved points (5, n), and the interval of mu from predicting the last of them.

    The error is weighted with the sliding power of the points: where there is none friction does not matter.
    """
    from scipy.interpolate import RBFInterpolator

    known = np.isfinite(values[0])
    needed = place.shape[1] + 2
    if np.count_nonzero(known) < HELD_OUT + needed:
        return np.full((len(values), len(place)), np.nan), np.full(len(place), np.nan)
    solved, found = chosen[known], values[:, known].T

    def spline(count: int, where: FloatArray) -> FloatArray:
        return np.asarray(RBFInterpolator(place[solved[:count]], found[:count])(where))

    kept = solved.size - HELD_OUT
    wrong = spline(kept, place[solved[kept:]])[:, 0] - found[kept:, 0]
    estimate = np.clip(spline(solved.size, place), np.minimum(found.min(axis=0), 0.0), found.max(axis=0)).T
    if not known.all():
        nearest = np.argmin(np.sum((place[:, None, :] - place[chosen][None, :, :]) ** 2, axis=2), axis=1)
        estimate[:, ~known[nearest]] = np.nan
    total = float(weight[solved[kept:]].sum())
    mean_square = float(np.sum(weight[solved[kept:]] * wrong**2)) / total if total > 0.0 else float(np.mean(wrong**2))
    return estimate, np.full(len(place), _WIDTH * math.sqrt(mean_square))
