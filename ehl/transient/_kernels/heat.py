"""Flash temperatures from memory grids that move with each surface, and the film temperature between them.

A point of surface i that has received the flux q_i(t') is warmer by
int q_i(t')/sqrt(t - t') dt'/sqrt(pi rho c k).  The root is a sum of exponentials in time, so a point remembers one
number per mode.  The grids belong to the surfaces: nothing is interpolated in the memory itself, whatever the speed.
"""

from __future__ import annotations

from numba import njit

from ehl.transient._kernels.elasticity import INTERNAL
from ehl.transient._kernels.elementary import log
from ehl.transient._kernels.fluid import (
    heated_shear_stress,
    isothermal_shear_row,
    thermal_factor,
)
from ehl.transient._kernels.quasi_separable import FLUID


@njit(**INTERNAL)
def film_factors(state, step, model):
    """Temperature factors of the viscosity from the film temperatures of the last step."""
    for i in range(step.thermal.size):
        step.thermal[i] = thermal_factor(state.temperature[i], model.fluid)


@njit(**INTERNAL)
def recall_surfaces(state, model):
    """Move both memory grids by one step and read the temperature rise the past fluxes leave at the nodes."""
    heat = model.heat
    modes = heat.ratios.size
    slots = state.memory.shape[1]
    n = state.film.size
    for s in range(2):
        memory = state.memory[s]
        base = state.memory_base[s]
        offset = state.memory_offset[s] + (heat.nodes_per_step_1 if s == 0 else heat.nodes_per_step_2)
        while offset >= 1.0:
            offset -= 1.0
            base = (base - 1) % slots
            for m in range(modes):
                memory[base, m] = 0.0
        while offset < 0.0:
            offset += 1.0
            for m in range(modes):
                memory[base, m] = 0.0
            base = (base + 1) % slots
        state.memory_base[s] = base
        state.memory_offset[s] = offset
        rise = state.surface_temperature[s]
        ahead = 0.0
        for k in range(slots):
            slot = k + base
            if slot >= slots:
                slot -= slots
            acc = 0.0
            for m in range(modes):
                value = memory[slot, m] * heat.ratios[m]
                memory[slot, m] = value
                acc += value
            # slot k sits at node k - 1 + offset; node i lies between slots i and i + 1
            if 0 < k <= n:
                rise[k - 1] = offset * ahead + (1.0 - offset) * acc
            ahead = acc


@njit(**INTERNAL)
def store_fluxes(state, model):
    """Add the fluxes of this step to the memory of the points they entered at."""
    heat = model.heat
    slots = state.memory.shape[1]
    n = state.film.size
    for s in range(2):
        offset = state.memory_offset[s]
        for k in range(1, min(n, slots)):
            flux = (1.0 - offset) * state.flux_into[s, k - 1] + offset * state.flux_into[s, k]
            if flux != 0.0:
                slot = k + state.memory_base[s]
                if slot >= slots:
                    slot -= slots
                for m in range(heat.ratios.size):
                    state.memory[s, slot, m] += heat.weights[s, m] * flux


@njit(**INTERNAL)
def instant_rise(model, s):
    """Temperature rise per unit flux of the current step, K m2/W."""
    total = 0.0
    for m in range(model.heat.ratios.size):
        total += model.heat.weights[s, m]
    return total


@njit(**INTERNAL)
def shear_and_temperature(state, step, work, model):
    """Film shear stress everywhere; with heat on also film temperature, surface temperatures and fluxes.

    Partition by the conductance k_f/h of the film: q1 = q/2 + (k_f/h)(T2 - T1).  The mid-layer is warmer than the
    mean of the surfaces by tau u_s h/(8 k_f) (parabolic profile).
    """
    heat = model.heat
    fluid = model.fluid
    contact = model.contact
    n = state.film.size
    unit = heat.pressure_unit
    if not heat.on:
        isothermal_shear_row(state.film, state.fluid_pressure, contact.boundary, fluid, state.shear)
        return
    a1 = instant_rise(model, 0)
    a2 = instant_rise(model, 1)
    for i in range(n):
        p = state.fluid_pressure[i]
        c = state.contact_pressure[i]
        h = max(state.film[i], contact.boundary)
        loaded = i > 0 and p + c > 0.0
        tau = 0.0
        rise_1 = state.surface_temperature[0, i]
        rise_2 = state.surface_temperature[1, i]
        conductance = heat.conductivity * (1.0 + heat.conductivity_rise * p) / (h * heat.film_unit)
        share = 1.0 / (1.0 + conductance * (a1 + a2))
        if loaded:
            rub = contact.friction * c * unit * heat.speed
            # T1 = rise_1 + a1 q1, T2 = rise_2 + a2 q2, q1 + q2 = q, q1 - q2 = 2 conductance (T2 - T1)
            by_flux = 0.5 * (0.5 * (a1 + a2) + share * conductance * (a2 - a1) * 0.5 * (a1 - a2))
            jump = share * (rise_2 - rise_1)
            base = fluid.temperature + 0.5 * (rise_1 + rise_2) + 0.5 * (a1 - a2) * conductance * jump + by_flux * rub
            if p > 0.0:
                per_flux = by_flux + 1.0 / (8.0 * conductance)
                tau, state.temperature[i] = heated_shear_stress(
                    h, p, base, per_flux * heat.speed * unit, state.temperature[i], fluid
                )
            else:
                state.temperature[i] = base
            flux = tau * unit * heat.speed + rub
            difference = jump + share * 0.5 * (a2 - a1) * flux
            q1 = 0.5 * flux + conductance * difference
            q2 = 0.5 * flux - conductance * difference
        else:
            state.temperature[i] = fluid.temperature + 0.5 * (rise_1 + rise_2)
            full = work.kind[i] & FLUID or state.mass[i] > 0.5 * h
            q1 = conductance * share * (rise_2 - rise_1) if full else 0.0
            q2 = -q1
        state.shear[i] = tau
        state.flux_into[0, i] = q1
        state.flux_into[1, i] = q2
        state.surface_temperature[0, i] = rise_1 + a1 * q1
        state.surface_temperature[1, i] = rise_2 + a2 * q2


@njit(**INTERNAL)
def log_or_floor(value):
    """ln of a positive number, held above -69 so that averages of logarithms stay finite."""
    return log(min(max(value, 1e-30), 1e30))
