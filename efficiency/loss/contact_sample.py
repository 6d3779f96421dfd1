"""Which contacts of a mesh are solved, and what they say of all its points, with the error of it.

Friction over a mesh is a smooth function of few local conditions. Contacts are solved where these are spread widest; a
thin-plate spline by them gives all points, and what it misses shows where each contact is predicted by the others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ehl.common.arrays import FloatArray, IntArray
from ehl.state import ContactState

# share of the sliding power that the most lightly loaded points hold together, of which none is solved
LIGHT_SHARE = 1e-3
# slide-to-roll ratio below which friction is nearly proportional to it
_LINEAR_SLIDING = 0.05
# contacts beyond the terms of the plane that a prediction takes
_SPARE = 8
# how far a spline may pass by contacts that scatter: from through all of them to nearly a plane
_SMOOTHING = (0.0, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1, 3e-1, 1.0)


def coordinates(state: ContactState) -> FloatArray:
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
            state.peklenik_number,
        ]
    )
    width = np.ptp(columns, axis=0)
    varies = width > 1e-9 * np.abs(columns).max(axis=0)
    if not varies.any():
        return np.zeros((state.size, 1))
    return np.asarray((columns[:, varies] - columns[:, varies].min(axis=0)) / width[varies])


def worth_solving(state: ContactState, power: FloatArray) -> IntArray:
    """All points but the most lightly loaded, which hold `LIGHT_SHARE` of the sliding power.

    Ends of contact lines narrower than the waves of the roughness: hard to solve, and nothing depends on them.
    """
    order = np.argsort(state.load_per_length, kind="stable")
    light = np.cumsum(power[order]) <= LIGHT_SHARE * power.sum()
    return np.sort(order[~light]) if power.sum() > 0.0 else np.arange(state.size)


def spread(place: FloatArray, power: FloatArray, count: int) -> IntArray:
    """Points one by one as far from all earlier ones as possible, sooner where there is more sliding power."""
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
    """Further points, one by one where the loss is least certain: far from all contacts, next to one of large part.

    place, power: of all points.
    able, contacts: points that may be solved, and those that were.
    parts: what each contact adds to the uncertainty of the loss.
    count: most points.
    """
    left = np.setdiff1d(able, contacts)
    square = _square_distance(place[left], place[contacts])
    distance = square.min(axis=1)
    # a point that was added answers for its neighbourhood: nothing is known of it yet
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
    """Points without power, which matter only to plots, are kept at a few of the lot by the fourth root."""
    return np.asarray(np.maximum(power / max(float(power.max()), 1e-300), 1e-6) ** 0.25)


def nearest(place: FloatArray, contacts: FloatArray) -> IntArray:
    """Number of the contact next to each point."""
    return np.asarray(np.argmin(_square_distance(place, contacts), axis=1))


def remoteness(place: FloatArray, contacts: FloatArray) -> FloatArray:
    """Distance of each point to the next contact, over the largest one of a contact to its next; at least 1."""
    between = _square_distance(contacts, contacts)
    np.fill_diagonal(between, np.inf)
    square = _square_distance(place, contacts).min(axis=1) / between.min(axis=1).max()
    return np.asarray(np.sqrt(np.maximum(square, 1.0)))


@dataclass(frozen=True)
class Prediction:
    """Values at all points from those of the contacts."""

    values: FloatArray  # within the range of the contacts' own; the first, friction, down to 0
    weights: FloatArray  # of each contact in the value of a point
    missed: FloatArray  # first value of each contact less what the others predict there


def fewest(dimensions: int) -> int:
    """Least number of contacts by which others are predicted, in so many coordinates."""
    return dimensions + 1 + _SPARE


def predict(place: FloatArray, contacts: FloatArray, found: FloatArray, weight: FloatArray) -> Prediction | None:
    """Thin-plate spline by the contacts, as smooth as predicts them best from each other; None where they are too few.

    place (n, d): coordinates of all points.
    contacts (m, d): coordinates of the contacts.
    found (k, m): their values; the first decides on the smoothness.
    weight (m,): what an error of each contact counts.

    Notes
    -----
    With the matrix A of kernel and plane, smoothing on its diagonal, the coefficients of the kernel are c = A^-1 f, and
    the contact i left out is missed by c_i/(A^-1)_ii (Rippa 1999, Adv. Comput. Math. 11, from memory, without smoothing
    and plane; with them the same block elimination holds).
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
        # contacts on a plane of less dimensions leave terms of it open: the least ones are taken
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
