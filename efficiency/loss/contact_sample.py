"""Selection of the contacts of a mesh that are solved, and prediction of friction at all points with its error.

Friction over a mesh is a smooth function of few local conditions. Contacts are selected so that they spread widely over
these conditions. A thin-plate spline predicts all points; leave-one-out prediction of each contact gives its error.
"""

from dataclasses import dataclass

import numpy as np

from ehl.common.arrays import FloatArray, IntArray
from ehl.state import ContactState

# share of the sliding power of the most lightly loaded points, which are not solved
LIGHT_SHARE = 1e-3
# slide-to-roll ratio below which friction is nearly proportional to it
_LINEAR_SLIDING = 0.05
# least number of contacts in excess of the terms of the plane
_SPARE = 8
# smoothing of the spline: from interpolation of all contacts to nearly a plane
_SMOOTHING = (0.0, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1, 3e-1, 1.0)


def coordinates(state: ContactState) -> FloatArray:
    """Variables of friction, each scaled to a range of 1; variables that are constant over the mesh are omitted."""
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
            state.peklenik_number,
        ]
    )
    width = np.ptp(columns, axis=0)
    varies = width > 1e-9 * np.abs(columns).max(axis=0)
    if not varies.any():
        return np.zeros((state.size, 1))
    return np.asarray((columns[:, varies] - columns[:, varies].min(axis=0)) / width[varies])


def worth_solving(state: ContactState, power: FloatArray) -> IntArray:
    """All points except the most lightly loaded ones, which have `LIGHT_SHARE` of the sliding power.

    The excluded ends of contact lines are narrower than the waves of the roughness: hard to solve and insignificant.
    """
    order = np.argsort(state.load_per_length, kind="stable")
    light = np.cumsum(power[order]) <= LIGHT_SHARE * power.sum()
    return np.sort(order[~light]) if power.sum() > 0.0 else np.arange(state.size)


def spread(place: FloatArray, power: FloatArray, count: int) -> IntArray:
    """Points selected one by one, each as far as possible from the earlier ones, weighted with the sliding power."""
    favour = _favour(power)
    chosen = [int(np.argmin(np.sum((place - place.mean(axis=0)) ** 2, axis=1)))]
    distance = np.sum((place - place[chosen[0]]) ** 2, axis=1)
    while len(chosen) < count and distance.max() > 0.0:
        chosen.append(int(np.argmax(distance * favour)))
        distance = np.minimum(distance, np.sum((place - place[chosen[-1]]) ** 2, axis=1))
    return np.array(chosen)


def divide(
    place: FloatArray, power: FloatArray, able: IntArray, contacts: IntArray, parts: FloatArray, count: int
) -> IntArray:
    """Further points, selected one by one: far from all contacts and near a contact with a large error of the loss.

    place, power: coordinates and sliding power of all points.
    able, contacts: points that may be solved, and solved points.
    parts: contribution of each contact to the uncertainty of the loss.
    count: maximum number of points.
    """
    left = np.setdiff1d(able, contacts)
    square = _square_distance(place[left], place[contacts])
    distance = square.min(axis=1)
    # the weight around an added point becomes zero, because its error is not yet available
    worth = parts[square.argmin(axis=1)] * _favour(power)[left]
    chosen: list[int] = []
    while len(chosen) < count and (distance * worth).max(initial=0.0) > 0.0:
        best = int(np.argmax(distance * worth))
        chosen.append(int(left[best]))
        square = np.sum((place[left] - place[left[best]]) ** 2, axis=1)
        worth[square < distance] = 0.0
        distance = np.minimum(distance, square)
    return np.array(chosen, dtype=int)


def _favour(power: FloatArray) -> FloatArray:
    """Weight of a point by its sliding power; the fourth root retains a few points without power, for plots."""
    return np.asarray(np.maximum(power / max(float(power.max()), 1e-300), 1e-6) ** 0.25)


def nearest(place: FloatArray, contacts: FloatArray) -> IntArray:
    """Index of the contact nearest to each point."""
    return np.asarray(np.argmin(_square_distance(place, contacts), axis=1))


def remoteness(place: FloatArray, contacts: FloatArray) -> FloatArray:
    """Distance of each point to the nearest contact over the largest distance between neighbours, at least 1 [-]."""
    between = _square_distance(contacts, contacts)
    np.fill_diagonal(between, np.inf)
    square = _square_distance(place, contacts).min(axis=1) / between.min(axis=1).max()
    return np.asarray(np.sqrt(np.maximum(square, 1.0)))


@dataclass(frozen=True)
class Prediction:
    """Predicted values at all points."""

    values: FloatArray  # within the range of the contacts; the first value, friction, may decrease to 0
    weights: FloatArray  # weight of each contact in the value of each point
    missed: FloatArray  # leave-one-out error of the first value of each contact


def fewest(dimensions: int) -> int:
    """Minimum number of contacts for a prediction with a number of coordinates."""
    return dimensions + 1 + _SPARE


def predict(place: FloatArray, contacts: FloatArray, found: FloatArray, weight: FloatArray) -> Prediction | None:
    """Thin-plate spline through the contacts with cross-validated smoothing; None if there are too few contacts.

    place (n, d): coordinates of all points.
    contacts (m, d): coordinates of the contacts.
    found (k, m): their values; the first one determines the smoothing.
    weight (m,): weight of the error of each contact.

    Notes
    -----
    With the matrix A of kernel and plane, and the smoothing on its diagonal, the coefficients of the kernel are
    c = A^-1 f. The leave-one-out error of contact i is c_i/(A^-1)_ii (Rippa 1999, Adv. Comput. Math. 11, unverified,
    without smoothing and plane; with them the same block elimination holds).
    """
    count, dimensions = contacts.shape
    if count < fewest(dimensions):
        return None
    matrix = np.zeros((count + dimensions + 1,) * 2)
    plane = np.column_stack([np.ones(count), contacts])
    kernel = _thin_plate(contacts, contacts)
    matrix[:count, count:], matrix[count:, :count] = plane, plane.T
    best, least = None, np.inf
    for smoothing in _SMOOTHING:
        matrix[:count, :count] = kernel + smoothing * np.eye(count)
        # contacts in a subspace do not determine all terms of the plane: the minimum-norm solution is used
        inverse = np.linalg.pinv(matrix, rcond=1e-13, hermitian=True)[:, :count]
        missed = (inverse[:count] @ found[0]) / np.diag(inverse[:count])
        error = float(np.average(missed**2, weights=weight if weight.any() else None))
        if error < least:
            best, least = (inverse, missed), error
    if best is None:
        return None
    inverse, missed = best
    weights = np.column_stack([_thin_plate(place, contacts), np.ones(len(place)), place]) @ inverse
    low, high = found.min(axis=1), found.max(axis=1)
    low[0] = min(low[0], 0.0)
    values = np.clip(found @ weights.T, low[:, None], high[:, None])
    return Prediction(values, weights, missed)


def _thin_plate(one: FloatArray, other: FloatArray) -> FloatArray:
    """r^2 log r between the points of two sets."""
    square = _square_distance(one, other)
    return np.asarray(0.5 * square * np.log(np.where(square > 0.0, square, 1.0)))


def _square_distance(one: FloatArray, other: FloatArray) -> FloatArray:
    return np.asarray(np.sum((one[:, None, :] - other[None, :, :]) ** 2, axis=2))
