"""The time loop: one call advances a number of steps and records what each of them gave."""

from __future__ import annotations

from numba import njit

from ehl.compile.compiler import FAST_INTERNAL_KERNEL, FAST_KERNEL, kernel
from ehl.rough._kernels.fluid import strain_film
from ehl.rough._kernels.heat import film_factors, recall_surfaces, shear_and_temperature, store_fluxes
from ehl.rough._kernels.motion import carry_mass, move_surfaces, predict, settle_mass, weigh_prediction
from ehl.rough._kernels.newton import (
    CONTINUED,
    PLAIN,
    UNCONVERGED,
    film_response,
    keep_mean_film,
    middle_film,
    solve_step,
)
from ehl.rough._kernels.records import AGE, CAPPED, CHANGES_TIMES_ERRORS, RIGID_APPROACH, RIGID_APPROACH_OLD, TRAVEL
from ehl.rough._kernels.side_flow import accumulate, isotropic_outflow, update_mean_total, update_pressure

# columns of the record of a step
(
    MU_FLUID,
    SHARE,
    FILM_MEAN,
    FILM_MIN,
    PRESSURE_MAX,
    TEMPERATURE_MAX,
    FLASH_MAX,
    CONTACT_NODES,
    CAPPED_NODES,
    ITERATIONS,
    STAGE,
    MACRO_LOAD,
    HEAT_RATE,
    COLUMNS,
) = range(14)

DONE, PART, SPENT, GOOD_APPROACH, STAGE_NOW = range(
    5
)  # of Saved.path: way done, next part, iterations, level of the last good point
CONTINUATION_LIMIT = 200  # iterations of all partial steps together
MIN_PART = 1.0 / 64.0
COLDEST = -1e3  # K


@njit(**FAST_INTERNAL_KERNEL)
def copy_pressures(state, fluid, contact):
    """Keep a copy of both pressures."""
    for i in range(fluid.size):
        fluid[i] = state.fluid_pressure[i]
        contact[i] = state.contact_pressure[i]


@njit(**FAST_INTERNAL_KERNEL)
def restore_pressures(state, fluid, contact, level):
    """Return to a copy."""
    for i in range(fluid.size):
        state.fluid_pressure[i] = fluid[i]
        state.contact_pressure[i] = contact[i]
    state.scalars[RIGID_APPROACH] = level


@njit(**FAST_INTERNAL_KERNEL)
def copy_step(source, target):
    """Copy the known side of a step."""
    for i in range(source.gap.size):
        target.gap[i] = source.gap[i]
        target.upstream_mass[i] = source.upstream_mass[i]
        target.weight[i] = source.weight[i]
        target.thermal[i] = source.thermal[i]
        target.along_share[i] = source.along_share[i]
        target.across_share[i] = source.across_share[i]


@njit(**FAST_INTERNAL_KERNEL)
def blend_step(step, saved, here):
    """The problem a fraction ``here`` of the way from the last step's problem to this one."""
    last = saved.last_step
    target = saved.target_step
    for i in range(step.gap.size):
        step.gap[i] = last.gap[i] + here * (target.gap[i] - last.gap[i])
        step.upstream_mass[i] = last.upstream_mass[i] + here * (target.upstream_mass[i] - last.upstream_mass[i])
        step.weight[i] = last.weight[i] + here * (target.weight[i] - last.weight[i])
        step.thermal[i] = last.thermal[i] + here * (target.thermal[i] - last.thermal[i])
        step.along_share[i] = last.along_share[i] + here * (target.along_share[i] - last.along_share[i])
        step.across_share[i] = last.across_share[i] + here * (target.across_share[i] - last.across_share[i])


@njit(**FAST_INTERNAL_KERNEL)
def follow_path(state, step, saved, converged, iterations):
    """One decision of the continuation after a partial solve; returns whether it goes on.

    Geometry, mass and temperature are blended linearly from the last step to this one; the last part is the step
    itself, so nothing is approximated, only the way there differs.
    """
    path = saved.path
    if converged:
        path[DONE] = min(path[DONE] + path[PART], 1.0)
        path[GOOD_APPROACH] = state.scalars[RIGID_APPROACH]
        copy_pressures(state, saved.path_fluid, saved.path_contact)
        if iterations < 8:
            path[PART] *= 2.0
    else:
        restore_pressures(state, saved.path_fluid, saved.path_contact, path[GOOD_APPROACH])
        path[PART] *= 0.5
    path[SPENT] += iterations
    if path[DONE] >= 1.0 or path[PART] < MIN_PART or path[SPENT] > CONTINUATION_LIMIT:
        copy_step(saved.target_step, step)
        return False
    blend_step(step, saved, min(path[DONE] + path[PART], 1.0))
    return True


@njit(**FAST_INTERNAL_KERNEL)
def solve_with_fallbacks(state, step, saved, macro, work, model, last_level):
    """Newton; then Picard and Newton in turns, continuation, slow Picard, and last the fluidity of the prediction.

    Returns iterations and the stage that succeeded.  Only the lagged stage changes the discrete problem.
    """
    path = saved.path
    total = 0
    path[STAGE_NOW] = PLAIN
    while path[STAGE_NOW] < UNCONVERGED:
        stage = int(path[STAGE_NOW])  # not a literal, or the solver would be compiled once per value
        iterations, converged = solve_step(state, step, macro, work, model, stage)
        total += iterations
        if stage == CONTINUED:
            if follow_path(state, step, saved, converged, iterations):
                continue
            converged = path[DONE] >= 1.0
        if converged:
            return total, stage
        stage += 1
        if stage == CONTINUED and state.scalars[AGE] < 0.5:
            stage += 1
        path[STAGE_NOW] = stage
        if stage >= CONTINUED:
            restore_pressures(state, saved.last_fluid, saved.last_contact, last_level)
        if stage == CONTINUED:
            path[DONE], path[PART], path[SPENT], path[GOOD_APPROACH] = 0.0, 0.25, 0.0, last_level
            copy_pressures(state, saved.path_fluid, saved.path_contact)
            copy_step(step, saved.target_step)
            blend_step(step, saved, path[PART])
    film_response(state, step, work, model)
    for i in range(step.gap.size):
        work.source[i] = 0.0
    return total, UNCONVERGED


@njit(**FAST_INTERNAL_KERNEL)
def write_record(record, state, macro, work, model):
    """Friction, films, pressures and temperatures of the step."""
    contact = model.contact
    shear = 0.0
    strained = 0.0
    carried = 0.0
    lowest = 1e30
    highest = 0.0
    touching = 0.0
    capped = 0.0
    hottest = 0.0
    flash = COLDEST if model.heat.on else 0.0
    macroscopic = 0.0
    heat_in = 0.0
    for i in range(1, state.film.size):
        p = state.fluid_pressure[i]
        c = state.contact_pressure[i]
        macroscopic += macro.pressure[i]
        if p + c > 0.0:
            shear += state.shear[i]
            strained += state.strained[i]
            carried += c
            lowest = min(lowest, max(state.film[i], contact.boundary))
            highest = max(highest, p + c)
            if c > 0.0:
                touching += 1.0
            if model.heat.on:
                hottest = max(hottest, state.temperature[i])
                flash = max(flash, state.surface_temperature[0, i], state.surface_temperature[1, i])
        if work.kind[i] & CAPPED:
            capped += 1.0
        if model.heat.on:
            heat_in += state.flux_into[0, i] + state.flux_into[1, i]
    shear += model.strain.counted * (strained - shear)
    film = 0.0
    for i in range(contact.middle_first, contact.middle_last):
        film += max(state.film[i], contact.boundary)
    record[MU_FLUID] = (shear + contact.wedge_shear) / contact.full_load
    record[SHARE] = carried / contact.full_load
    record[FILM_MEAN] = film / (contact.middle_last - contact.middle_first)
    record[FILM_MIN] = lowest
    record[PRESSURE_MAX] = highest
    record[TEMPERATURE_MAX] = hottest
    record[FLASH_MAX] = flash
    record[CONTACT_NODES] = touching
    record[CAPPED_NODES] = capped
    record[MACRO_LOAD] = macroscopic / contact.full_load
    record[HEAT_RATE] = heat_in


@kernel(**FAST_KERNEL)
def march(steps, state, step, saved, macro, work, model, records, profiles):
    """Advance ``steps`` time steps; fills records[:steps] and adds to the profile sums (6, n).

    profiles: fluid pressure, contact pressure, macroscopic pressure, film, film temperature, warmer surface's rise.
    """
    n = state.film.size
    scalars = state.scalars
    for k in range(steps):
        copy_step(step, saved.last_step)
        copy_pressures(state, saved.last_fluid, saved.last_contact)
        last_level = scalars[RIGID_APPROACH]
        scalars[TRAVEL] += 1.0
        move_surfaces(step.gap, scalars[TRAVEL], model.surfaces)
        if model.side_flow.on:
            for i in range(n):
                step.gap[i] += macro.deflection[i]
        carry_mass(state, step.upstream_mass, step.weight)
        if model.heat.on:
            film_factors(state, step, model)
        mean = middle_film(state, model.contact)
        predict(state, saved.last_fluid, saved.last_contact)
        if scalars[AGE] > 0.5:
            keep_mean_film(state, step, work, model, mean)
        iterations, stage = solve_with_fallbacks(state, step, saved, macro, work, model, last_level)
        if scalars[AGE] < 1.5:
            scalars[RIGID_APPROACH_OLD] = scalars[RIGID_APPROACH]
            for i in range(n):
                state.fluid_pressure_old[i] = state.fluid_pressure[i]
                state.contact_pressure_old[i] = state.contact_pressure[i]
        elif stage == PLAIN:
            weigh_prediction(state)
        else:
            scalars[CHANGES_TIMES_ERRORS] = 0.0  # where Newton fails, the second prediction is no better
        scalars[AGE] += 1.0
        settle_mass(state, step, work, model, stage != UNCONVERGED)
        if model.heat.on:
            recall_surfaces(state, work, model)
        shear_and_temperature(state, work, model)
        if model.heat.on:
            store_fluxes(state, work)
        if model.strain.counted > 0.0:
            strain_film(state, model)
        if model.side_flow.on and stage != UNCONVERGED:
            if accumulate(state, macro, work, model):
                update_pressure(macro, work, model)
                update_mean_total(macro, work, model)
            isotropic_outflow(state, macro, work, model)
        write_record(records[k], state, macro, work, model)
        records[k, ITERATIONS] = iterations
        records[k, STAGE] = stage
        for i in range(n):
            profiles[0, i] += state.fluid_pressure[i]
            profiles[1, i] += state.contact_pressure[i]
            profiles[2, i] += macro.pressure[i]
            profiles[3, i] += state.film[i]
            profiles[4, i] += state.temperature[i]
            profiles[5, i] += max(state.surface_temperature[0, i], state.surface_temperature[1, i])
