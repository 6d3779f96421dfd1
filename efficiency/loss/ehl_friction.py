"""Friction by solving the lubricated contact itself, at enough points of the mesh to interpolate the others.

The points of a mesh are a smooth two-parameter family of conditions, so a few dozen solutions, spread as far apart as
possible, carry the whole of it; the last of them are first predicted by the others, which measures the error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ehl.contact import LineContact
from ehl.errors import InputError
from ehl.inputs import ModelInput, SurfaceInput
from ehl.material import Material, load_material
from ehl.oil import Oil
from ehl.solve import ContactResult, solve_contact
from ehl.state import ContactState
from regression.friction_models import FrictionEstimate, FrictionFlag

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

POINTS, HELD_OUT = 80, 16
# interval of the interpolation, in RMS errors at the held-out points
_WIDTH = 2.0
# slide-to-roll ratio below which friction is nearly proportional to it
_LINEAR_SLIDING = 0.05


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
    bodies : tuple of Material
        Pinion and gear.
    model : ModelInput
        Physics and accuracy of each contact.
    """

    name: str
    smooth: bool = False
    points: int | None = POINTS
    bodies: tuple[Material, Material] = field(default_factory=lambda: (load_material("steel"),) * 2)
    model: ModelInput = field(default_factory=lambda: ModelInput(accuracy="fast"))

    def evaluate(self, state: ContactState, oil: Oil) -> FrictionEstimate:
        """Friction at every point.

        Where points are interpolated, `lower` and `upper` are two RMS errors of the prediction of held-out contacts
        away, weighted with their sliding power; where all are solved, the solver's own error. A contact that does not
        converge leaves nan at the points next to it, flagged.
        """
        place = _coordinates(state)
        power = state.load_per_length * state.speed_sliding
        if self.points is None or state.size <= self.points:
            chosen = np.arange(state.size)
        else:
            chosen = _spread(place, power, self.points)
        mu, error = self._solve(state, oil, chosen, place)
        if chosen.size == state.size:
            estimate, spread = mu, error
        else:
            estimate, spread = _interpolate(place, chosen, mu, power)
        flag = np.where(np.isfinite(estimate), FrictionFlag.OK, FrictionFlag.NOT_CONVERGED).astype(np.int8)
        return FrictionEstimate(estimate, np.maximum(estimate - spread, 0.0), estimate + spread, flag)

    def _solve(
        self, state: ContactState, oil: Oil, chosen: IntArray, place: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Friction at chosen points and its absolute error, nan where it failed; neighbours start each other."""
        mu, error = np.full(chosen.size, np.nan), np.full(chosen.size, np.nan)
        before: ContactResult | None = None
        for k in _chain(place[chosen]):
            at = int(chosen[k])
            temperature = float(state.temperature_oil[at])
            result = solve_contact(
                _contact(state, at),
                oil.at(temperature),
                self._surface(state, at),
                self.model,
                self.bodies,
                (temperature, temperature),
                before,
            )
            if result.status == "converged":
                before = result
                mu[k] = result.friction_coefficient
                error[k] = abs(result.friction_coefficient) * result.friction_error
        return mu, error

    def _surface(self, state: ContactState, at: int) -> SurfaceInput:
        if self.smooth:
            return SurfaceInput()
        return SurfaceInput(
            roughness_rms_1=float(state.roughness_rms_1[at]), roughness_rms_2=float(state.roughness_rms_2[at])
        )


def ehl_friction(spec: str, bodies: tuple[Material, Material] | None = None) -> EhlFriction:
    """The model of a name: ``ehl``, ``ehl:smooth``, each also with ``:all`` for no interpolation.

    Raises
    ------
    InputError
        Another word after the colon.
    """
    words = spec.split(":")
    if words[0] != "ehl" or not set(words[1:]) <= {"smooth", "all"}:
        raise InputError("friction model", spec, "ehl, ehl:smooth, ehl:all or ehl:smooth:all")
    steel = load_material("steel")
    points = None if "all" in words else POINTS
    return EhlFriction(spec, "smooth" in words, points, bodies or (steel, steel))


def _contact(state: ContactState, at: int) -> LineContact:
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
            state.roughness_rms,
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
    place: FloatArray, chosen: IntArray, mu: FloatArray, weight: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Thin-plate spline through the solved points, and its interval from predicting the last of them.

    The error is weighted with the sliding power of the points: where there is none friction does not matter.
    """
    from scipy.interpolate import RBFInterpolator

    known = np.isfinite(mu)
    needed = place.shape[1] + 2
    if np.count_nonzero(known) < HELD_OUT + needed:
        nothing = np.full(len(place), np.nan)
        return nothing, nothing
    solved, values = chosen[known], mu[known]

    def spline(count: int, where: FloatArray) -> FloatArray:
        return np.asarray(RBFInterpolator(place[solved[:count]], values[:count])(where))

    kept = solved.size - HELD_OUT
    wrong = spline(kept, place[solved[kept:]]) - values[kept:]
    estimate = np.maximum(spline(solved.size, place), 0.0)
    if not known.all():
        nearest = np.argmin(np.sum((place[:, None, :] - place[chosen][None, :, :]) ** 2, axis=2), axis=1)
        estimate[~known[nearest]] = np.nan
    total = float(weight[solved[kept:]].sum())
    mean_square = float(np.sum(weight[solved[kept:]] * wrong**2)) / total if total > 0.0 else float(np.mean(wrong**2))
    return estimate, np.full(len(place), _WIDTH * math.sqrt(mean_square))
