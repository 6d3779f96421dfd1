"""Start of a time step: move the roughness, carry the mass with the Couette flow, predict the pressure."""

from __future__ import annotations

import math

from numba import njit

from ehl.compile.compiler import FAST_INTERNAL_KERNEL, FAST_KERNEL, kernel
from ehl.fluid._kernels import inlet_laws
from ehl.rough._kernels.quasi_separable import FLUID
from ehl.rough._kernels.records import (
    AGE,
    CAPPED,
    CHANGES_SQUARED,
    CHANGES_TIMES_ERRORS,
    RIGID_APPROACH,
    RIGID_APPROACH_OLD,
)

SAMPLES = 2  # profile samples per node spacing
MEAN_PRESSURE_RATE = 0.01  # per step, of the slow average the predictor treats as static
PREDICTION_RATE = 0.05  # per step, of the errors of the predictions
WEIGHT_MIN = 0.3  # smallest weight of the second prediction: with less it saves no iterations


@kernel(**FAST_KERNEL)
def sample_profile(profile, shift, sign, out):
    """Add ``sign`` times the profile moved by ``shift`` samples (cubic Lagrange between samples, periodic)."""
    size = profile.size
    if size == 0:
        return
    whole = math.floor(-shift)
    r = -shift - whole
    before = -r * (r - 1.0) * (r - 2.0) / 6.0
    here = (r + 1.0) * (r - 1.0) * (r - 2.0) / 2.0
    after = -(r + 1.0) * r * (r - 2.0) / 2.0
    beyond = (r + 1.0) * r * (r - 1.0) / 6.0
    j = int(whole % size)
    for i in range(out.size):
        j0 = j - 1 if j > 0 else size - 1
        j2 = j + 1 if j + 1 < size else 0
        j3 = j2 + 1 if j2 + 1 < size else 0
        out[i] += sign * (before * profile[j0] + here * profile[j] + after * profile[j2] + beyond * profile[j3])
        j += SAMPLES
        while j >= size:
            j -= size


@kernel(**FAST_KERNEL)
def move_surfaces(gap, travel, surfaces):
    """Rigid gap at a number of time steps of travel; roughness enters with the fluid, behind a smooth front."""
    n = gap.size
    for i in range(n):
        gap[i] = 0.0
    sample_profile(surfaces.profile_1, surfaces.shift_1 * travel, -1.0, gap)
    sample_profile(surfaces.profile_2, surfaces.shift_2 * travel, -1.0, gap)
    front = surfaces.front + travel * surfaces.spacing
    entered = front >= surfaces.x[n - 1] + surfaces.front_width
    for i in range(n):
        if not entered:
            s = (front - surfaces.x[i]) / surfaces.front_width
            s = min(max(s, 0.0), 1.0)
            gap[i] *= s * s * (3.0 - 2.0 * s)
        gap[i] += surfaces.parabola[i]


@njit(**FAST_INTERNAL_KERNEL)
def carry_mass(state, upstream_mass, weight):
    """Couette flow: mass at the upstream end of the characteristic, which moves with the entrainment speed.

    BDF2 along it, backward Euler at the start and where the film cavitates.
    """
    mass = state.mass
    old = state.mass_old
    n = mass.size
    second_order = state.scalars[AGE] > 1.5
    upstream_mass[0] = mass[0]
    weight[0] = 1.0
    for i in range(1, n):
        first = mass[i - 1]
        upstream_mass[i] = first
        weight[i] = 1.0
        if second_order and i > 1:
            value = (4.0 * first - old[i - 2]) / 3.0
            if 0.5 * first < value < 1.5 * first:
                upstream_mass[i] = value
                weight[i] = 2.0 / 3.0
    for i in range(n):
        old[i] = mass[i]


@njit(**FAST_INTERNAL_KERNEL)
def predict(state, fluid, contact):
    """Pressure of the new step, extrapolated from the last two.

    ``fluid`` and ``contact`` are the pressures of the last step. In the first prediction the mean stays, and the ripple
    moves with u_r and changes linearly. In the second one, of the fluid pressure, one part stays and the rest moves
    unchanged: thick films follow it. Its weight is the one that would have fitted the last steps best
    (`weigh_prediction`).
    """
    fluid_old = state.fluid_pressure_old
    contact_old = state.contact_pressure_old
    mean = state.mean_pressure
    n = fluid.size
    scalars = state.scalars
    for i in range(n):
        mean[i] += MEAN_PRESSURE_RATE * (fluid[i] - mean[i])
    if scalars[AGE] < 1.5:
        for i in range(n):
            fluid_old[i] = fluid[i]
            contact_old[i] = contact[i]
        scalars[RIGID_APPROACH_OLD] = scalars[RIGID_APPROACH]
        return
    weight = 0.0
    if scalars[CHANGES_SQUARED] > 0.0:
        weight = min(max(scalars[CHANGES_TIMES_ERRORS] / scalars[CHANGES_SQUARED], 0.0), 1.0)
        weight = weight if weight > WEIGHT_MIN else 0.0
    for i in range(2, n):
        p = 2.0 * (fluid[i - 1] - mean[i - 1]) - (fluid_old[i - 2] - mean[i - 2]) + mean[i]
        c = 2.0 * contact[i - 1] - contact_old[i - 2]
        change = fluid[i] + fluid[i - 1] - fluid_old[i - 1] - p
        state.predicted[i] = p
        state.change[i] = change
        state.fluid_pressure[i] = max(p + weight * change, 0.0) if fluid[i] > 0.0 or fluid[i - 1] > 0.0 else 0.0
        state.contact_pressure[i] = max(c, 0.0) if contact[i - 1] > 0.0 else 0.0
    for i in range(n):
        fluid_old[i] = fluid[i]
        contact_old[i] = contact[i]
    level = scalars[RIGID_APPROACH]
    scalars[RIGID_APPROACH] = 2.0 * level - scalars[RIGID_APPROACH_OLD]
    scalars[RIGID_APPROACH_OLD] = level


@njit(**FAST_INTERNAL_KERNEL)
def weigh_prediction(state):
    """Update the fit of the weight of the second prediction by a solved step; earlier steps are forgotten."""
    squares, products = 0.0, 0.0
    for i in range(2, state.change.size):
        change = state.change[i]
        squares += change * change
        products += change * (state.fluid_pressure[i] - state.predicted[i])
    scalars = state.scalars
    scalars[CHANGES_SQUARED] += PREDICTION_RATE * (squares - scalars[CHANGES_SQUARED])
    scalars[CHANGES_TIMES_ERRORS] += PREDICTION_RATE * (products - scalars[CHANGES_TIMES_ERRORS])


@njit(**FAST_INTERNAL_KERNEL)
def settle_mass(state, step, work, model, solved):
    """Mass after the step: what was carried plus what flowed in.

    In a full gap that is rho h up to the tolerance of the step. What is left over is carried on and not dropped: the
    next steps work it off, where dropping it would add up over the thousands of steps of a passage on a fine mesh.
    """
    boundary = model.contact.boundary
    fluid = model.fluid
    for i in range(state.mass.size):
        h = max(state.film[i], boundary)
        p = state.fluid_pressure[i]
        if i == 0 or (work.kind[i] & FLUID and not solved):
            state.mass[i] = h * inlet_laws(p, fluid.table)[2]
        else:
            carried = step.upstream_mass[i] + work.source[i]
            if not work.kind[i] & (CAPPED | FLUID):
                carried = min(carried, h)
            state.mass[i] = max(carried, 0.0)
