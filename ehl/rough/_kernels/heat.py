"""Flash temperatures from memory grids that move with each surface, and the film temperature between them.

A point of surface i that has received the flux q_i(t') is warmer by
int q_i(t')/sqrt(t - t') dt'/sqrt(pi rho c k).  The root is a sum of exponentials in time, so a point remembers one
number per mode.  The grids belong to the surfaces: nothing is interpolated in the memory itself, whatever the speed.
"""

from __future__ import annotations

from numba import njit

from ehl.compile.compiler import FAST_INTERNAL_KERNEL, FAST_KERNEL, kernel
from ehl.heat._kernels import (
    MEAN_BY_FLOW,
    MID_FILM_BY_FLOW,
    across_share,
    along_share,
    flow_heat_share,
    rise_share,
)
from ehl.rough._kernels.fluid import balanced_shear_row, isothermal_shear_row, temperature_place
from ehl.rough._kernels.vectors import exp, log


@njit(**FAST_INTERNAL_KERNEL)
def film_factors(state, step, model):
    """Places of the film temperatures of the last step in the table of the viscosity, and shares of the mobilities."""
    for i in range(step.thermal.size):
        step.thermal[i] = temperature_place(state.temperature[i], model.fluid.table)
    for i in range(step.thermal.size):
        step.along_share[i], step.across_share[i] = state.along_share[i], state.across_share[i]


@njit(**FAST_INTERNAL_KERNEL)
def recall_surfaces(state, work, model):
    """Move both memory grids by one step and read the temperature rise the past fluxes leave at the nodes."""
    heat = model.heat
    modes = heat.ratios.size
    slots = state.memory.shape[2]
    n = state.film.size
    sums, line = work.heat.sums, work.heat.line
    for s in range(2):
        memory = state.memory[s]
        entering = state.entering[s]
        base = state.memory_base[s]
        offset = state.memory_offset[s] + (heat.nodes_per_step_1 if s == 0 else heat.nodes_per_step_2)
        while offset >= 1.0:
            offset -= 1.0
            base = (base - 1) % slots
            entering[base] = 0.0
            for m in range(modes):
                memory[m, base] = 0.0
        while offset < 0.0:
            offset += 1.0
            entering[base] = 0.0
            for m in range(modes):
                memory[m, base] = 0.0
            base = (base + 1) % slots
        state.memory_base[s] = base
        state.memory_offset[s] = offset
        bulk = heat.bulk_1 if s == 0 else heat.bulk_2
        for k in range(slots):
            sums[k] = bulk
        for m in range(modes):
            row = memory[m]
            ratio = heat.ratios[m]
            weight = heat.weights[s, m]
            for k in range(slots):
                value = ratio * (row[k] + weight * entering[k])
                row[k] = value
                sums[k] += value
        # slot k of the ring sits at node k - 1 + offset; node i lies between slots i and i + 1
        for k in range(slots - base):
            line[k] = sums[base + k]
        for k in range(base):
            line[slots - base + k] = sums[k]
        rise = state.surface_temperature[s]
        for i in range(n):
            rise[i] = offset * line[i] + (1.0 - offset) * line[i + 1]


@njit(**FAST_INTERNAL_KERNEL)
def store_fluxes(state, work):
    """Keep the fluxes of this step by the points they entered at; the next recall adds them to the memory."""
    slots = state.memory.shape[2]
    n = state.film.size
    line = work.heat.line
    for s in range(2):
        flux = state.flux_into[s]
        offset = state.memory_offset[s]
        base = state.memory_base[s]
        for k in range(slots):
            line[k] = 0.0
        for i in range(n - 1):
            line[i + 1] = (1.0 - offset) * flux[i] + offset * flux[i + 1]
        entering = state.entering[s]
        for k in range(slots - base):
            entering[base + k] = line[k]
        for k in range(base):
            entering[k] = line[slots - base + k]


@njit(**FAST_INTERNAL_KERNEL)
def instant_rise(model, s):
    """Temperature rise per unit flux of the current step, K m2/W."""
    total = 0.0
    for m in range(model.heat.ratios.size):
        total += model.heat.weights[s, m]
    return total


@njit(**FAST_INTERNAL_KERNEL)
def shear_and_temperature(state, work, model):
    """Film shear stress everywhere; with heat on also film temperature, surface temperatures and fluxes.

    Partition by the conductance k_f/h of the film: q1 = q/2 + (k_f/h)(T2 - T1).  The film is warmer than the mean of
    the surfaces by q h/(8 k_f) times the `rise_share` of the last step, which changes slowly, with the convected part q
    of tau u_s, and by q h/(20 k_f) through the heat q of the pressure-driven flow, which is freed near the walls.  The
    shares of the mobilities are those of `ehl.heat.traction.flow_shares`.
    """
    heat = model.heat
    fluid = model.fluid
    contact = model.contact
    film = state.film
    p = state.fluid_pressure
    c = state.contact_pressure
    if not heat.on:
        isothermal_shear_row(film, p, contact.boundary, fluid, state.shear)
        return
    rows = work.heat
    n = film.size
    power = heat.pressure_unit * heat.speed
    a1 = instant_rise(model, 0)
    a2 = instant_rise(model, 1)
    rise_1, rise_2 = state.surface_temperature[0], state.surface_temperature[1]
    conductance, jump, rub, base, resistance = rows.conductance, rows.jump, rows.rub, rows.base, rows.resistance
    for i in range(n):
        h = max(film[i], contact.boundary)
        full = p[i] + c[i] > 0.0 or state.mass[i] > 0.5 * h
        growth = 1.0 + heat.conductivity_rise * p[i] / (1.0 + heat.conductivity_bend * p[i])
        k = heat.conductivity * growth / (h * heat.film_unit)
        conductance[i] = k if full else 0.0
    for i in range(n):
        jump[i] = (rise_2[i] - rise_1[i]) / (1.0 + conductance[i] * (a1 + a2))
    for i in range(n):
        rub[i] = contact.friction * c[i] * power + heat.rolling[i] + heat.convected[i]
    for i in range(n):
        # rise of the surfaces' mean per unit of heat: T_s = rise_s + a_s q_s
        share = conductance[i] / (1.0 + conductance[i] * (a1 + a2))
        resistance[i] = 0.25 * (a1 + a2) - 0.25 * share * (a1 - a2) * (a1 - a2)
    for i in range(n):
        mean = fluid.temperature + 0.5 * (rise_1[i] + rise_2[i])
        base[i] = mean + 0.5 * (a1 - a2) * conductance[i] * jump[i] + resistance[i] * rub[i]
    for i in range(n):
        rise = 0.125 * heat.rolling[i] / conductance[i] if conductance[i] > 0.0 else 0.0
        base[i] += MEAN_BY_FLOW * MID_FILM_BY_FLOW * rise
    for i in range(n):
        film_part = state.rise_share[i] * 0.125 / conductance[i] if p[i] > 0.0 else 0.0
        base[i] += film_part * heat.convected[i]
        resistance[i] = (resistance[i] + film_part) * power * heat.kept[i] if p[i] > 0.0 else 0.0
    balanced_shear_row(rows, film, p, contact.boundary, fluid, state.temperature, state.shear)
    for i in range(n):
        even = heat.kept[i] * power * state.shear[i] + heat.convected[i]
        warmed = rows.decay[i] * (0.125 / conductance[i]) * even if p[i] > 0.0 else 0.0
        state.rise_share[i] = rise_share(warmed)
        state.along_share[i] = along_share(warmed)
        state.across_share[i] = across_share(warmed)
    for i in range(n):
        rise = 0.125 * heat.rolling[i] / conductance[i] if p[i] > 0.0 else 0.0
        by_flow = exp(flow_heat_share(MID_FILM_BY_FLOW * rows.decay[i] * rise))
        state.along_share[i] *= by_flow
        state.across_share[i] *= by_flow
    share_heat(state, rows, heat.kept, power, a1, a2)


@njit(**FAST_INTERNAL_KERNEL)
def share_heat(state, rows, kept, power, a1, a2):
    """Split the heat between the surfaces and add its instant rise."""
    into_1, into_2 = state.flux_into[0], state.flux_into[1]
    rise_1, rise_2 = state.surface_temperature[0], state.surface_temperature[1]
    for i in range(into_1.size):
        heat = kept[i] * state.shear[i] * power + rows.rub[i]
        k = rows.conductance[i]
        crossing = k * (rows.jump[i] + 0.5 * (a2 - a1) * heat / (1.0 + k * (a1 + a2)))
        into_1[i] = 0.5 * heat + crossing
        into_2[i] = 0.5 * heat - crossing
    for i in range(into_1.size):
        rise_1[i] += a1 * into_1[i]
    for i in range(into_2.size):
        rise_2[i] += a2 * into_2[i]


@njit(**FAST_INTERNAL_KERNEL)
def log_or_floor(value):
    """ln of a positive number, held above -69 so that averages of logarithms stay finite."""
    return log(min(max(value, 1e-30), 1e30))


@kernel(**FAST_KERNEL)
def preheat(steps, flux, state, work, model):
    """Roll the surfaces through the flux (2, n) for a number of steps, from their bulk temperatures."""
    for body in range(2):
        for i in range(flux.shape[1]):
            state.flux_into[body, i] = flux[body, i]
        for i in range(state.entering.shape[1]):
            state.entering[body, i] = 0.0
            for mode in range(state.memory.shape[1]):
                state.memory[body, mode, i] = 0.0
    for _ in range(steps):
        store_fluxes(state, work)
        recall_surfaces(state, work, model)
    store_fluxes(state, work)
