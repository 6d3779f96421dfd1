"""One implicit time step of the Reynolds equation with cavitation, asperity contact and load, by Newton's method.

Reynolds  m0 + w [d/dx (f dp/dx) - k (p - P)] = rho h   where p > 0; else p = 0 and the gap is not full
contact   h >= h_boundary,  p_c >= 0,  one of them an equality
hardness  p + p_c <= H; a node at the cap keeps its pressures and releases its gap or mass
load      sum of p + p_c given

m0 is the upstream mass, which the Couette flow carries along the characteristic, f dp/dx the Poiseuille flow, k (p - P)
the side flow. Cavitation conserves mass (JFO conditions, as in the algorithm of Elrod-Adams): fluid pressure and
missing mass, like contact pressure and gap, are complementarity conditions, solved with active sets of nodes.
"""

from __future__ import annotations

from numba import njit

from ehl.compile.compiler import FAST_INTERNAL_KERNEL, FAST_KERNEL, kernel
from ehl.rough._kernels.fluid import density_rows, refresh_rows
from ehl.rough._kernels.quasi_separable import CONTACT, FLUID, exponential_product, factor_and_solve
from ehl.rough._kernels.records import CAPPED, RIGID_APPROACH
from ehl.rough._kernels.vectors import LANES, load, store, where_above

NEWTON, PICARD, FROZEN = range(3)  # full derivatives; relaxed lagged fluidity; fluidity of the start
# how a step was solved, in the order tried, and what each stage starts with: mode, relaxation, iterations allowed;
# the relaxed stage goes on from where Newton stalled and alternates between the two
PLAIN, RELAXED, CONTINUED, SLOW, LAGGED, UNCONVERGED = range(6)
STAGE_MODE = (NEWTON, PICARD, NEWTON, PICARD, FROZEN)
STAGE_RELAXATION = (1.0, 0.5, 1.0, 0.2, 1.0)
STAGE_LIMIT = (30, 90, 30, 150, 60)
PRESSURE_STEP = (0.4, 0.8)  # an iteration changes p by at most 0.4 + 0.8 p
PICARD_TURN = 16  # Picard iterations before Newton is tried again
FIRST_TURN = 3  # of the first turn at least, if the sets have settled; each turn is twice as long
STALL = 10  # Newton has stalled after so many iterations without a residual 30 % below its best
# The flow of a pocket at its outlet has a maximum over its pressure, as the fluidity decreases with it. Beyond, Newton
# leads away from the solution, where the pocket lifts its walls. The derivative of a flow by the fluidity is therefore
# at most this part of the fluidity, which affects the way but not the solution (tuned on 38 contacts; flat)
MONOTONE = 0.8
LOAD_TOLERANCE = 1e-6


@njit(**FAST_INTERNAL_KERNEL)
def film_response(state, step, work, model):
    """Gap under the present pressures; returns their sum."""
    total = work.total
    load = 0.0
    for i in range(total.size):
        q = state.fluid_pressure[i] + state.contact_pressure[i]
        total[i] = q
        load += q
    exponential_product(total, model.elastic.weights, model.elastic.ratios, work.response)
    level = state.scalars[RIGID_APPROACH]
    for i in range(total.size):
        state.film[i] = level + step.gap[i] + work.response[i]
    return load


@njit(**FAST_INTERNAL_KERNEL)
def poiseuille_flow(state, step, work, model, mode, relaxation, start, repeat):
    """Fluidity between the nodes and the Poiseuille flow it carries.

    Newton uses the present fluidity and its derivatives; Picard the geometric mean of the old and the present one,
    moved once per iteration; the frozen mode the one of the start.
    """
    p = state.fluid_pressure
    h = state.film
    half = work.half
    used = work.fluidity
    n = p.size
    if mode == NEWTON or start or (mode == PICARD and not repeat):
        for k in range(0, n - 1, LANES):
            i = min(k, n - 1 - LANES)
            store(half.film, i, 0.5 * (load(h, i) + load(h, i + 1)))
            store(half.pressure, i, max(0.5 * (load(p, i) + load(p, i + 1)), 0.0))
            store(half.thermal, i, 0.5 * (load(step.thermal, i) + load(step.thermal, i + 1)))
            store(half.along_share, i, 0.5 * (load(step.along_share, i) + load(step.along_share, i + 1)))
            store(half.across_share, i, 0.5 * (load(step.across_share, i) + load(step.across_share, i + 1)))
        fluid = model.fluid
        refresh_rows(half, model.contact.boundary, fluid, fluid.along, fluid.flux, 0, n - 1, start)
        if mode == PICARD and not start:
            for i in range(n - 1):
                used[i] = used[i] * (half.f[i] / used[i]) ** relaxation if used[i] > 0.0 else half.f[i]
        else:
            for i in range(n - 1):
                used[i] = half.f[i]
    derivative = 0.5 if mode == NEWTON else 0.0
    for k in range(0, n - 1, LANES):
        i = min(k, n - 1 - LANES)
        rise = load(p, i + 1) - load(p, i)
        store(work.flow, i, load(used, i) * rise)
        store(work.flow_by_film, i, load(half.by_film, i) * (derivative * rise))
        most = MONOTONE * load(used, i)
        by_pressure = load(half.by_pressure, i) * (derivative * rise)
        store(work.flow_by_pressure, i, max(min(by_pressure, most), -1.0 * most))
    used[n - 1] = work.flow[n - 1] = work.flow_by_film[n - 1] = work.flow_by_pressure[n - 1] = 0.0


@njit(**FAST_INTERNAL_KERNEL)
def add_side_flow(state, step, macro, work, model, mode, start):
    """Side flow: exchange with the macroscopic pressure, what leaves each node and its derivatives.

    Two halves in series: the pocket's own gap, then the typical gap at this place.  A starved pocket conducts with
    its filled part only.
    """
    node = work.node
    slopes = 1.0 if mode == NEWTON else 0.0
    first, outlet = model.side_flow.first, model.contact.outlet
    begin = max(first - 1, 0)  # `isotropic_outflow` needs the node ahead of the first
    for k in range(begin, outlet, LANES):
        i = min(k, outlet - LANES)
        store(node.film, i, load(state.film, i))
        store(node.pressure, i, 0.5 * (max(load(state.fluid_pressure, i), 0.0) + load(macro.pressure, i)))
        store(node.thermal, i, load(step.thermal, i))
        store(node.along_share, i, load(step.along_share, i))
        store(node.across_share, i, load(step.across_share, i))
    across, lateral = 1.0 - model.fluid.along, model.fluid.flux_lateral
    refresh_rows(node, model.contact.boundary, model.fluid, across, lateral, begin, outlet, start)
    for j in range(first, outlet, LANES):
        i = min(j, outlet - LANES)
        p, h, mass = load(state.fluid_pressure, i), load(state.film, i), load(step.upstream_mass, i)
        k, typical = load(node.f, i), load(macro.typical, i)
        part = where_above(typical, 0.0, 2.0 * typical / (k + typical), 1.0)
        filled = where_above(p, 0.0, 1.0, where_above(h, mass, max(mass, 0.0) / h, 1.0))
        outflow = load(state.outflow, i)
        k = k * part * outflow * filled
        excess = p - load(macro.pressure, i)
        steepness = slopes * outflow * excess * where_above(typical, 0.0, 0.5 * part * part, 1.0)
        by_pressure = max(k + 0.5 * steepness * load(node.by_pressure, i), 0.1 * k)
        store(work.exchange, i, k)
        store(work.outward, i, k * excess)
        store(work.outward_by_film, i, steepness * filled * load(node.by_film, i))
        store(work.outward_by_pressure, i, where_above(p, 0.0, by_pressure, k))


@kernel(**FAST_KERNEL)
def assemble(state, step, macro, work, model, mode, relaxation, start, repeat):
    """Residuals and the bands of the Newton matrix at every node.

    ``start`` marks the first assembly of a solve, ``repeat`` a second one within the same iteration.
    """
    poiseuille_flow(state, step, work, model, mode, relaxation, start, repeat)
    p = state.fluid_pressure
    h = state.film
    band = work.band
    flow = work.flow
    f = work.fluidity
    by_film = work.flow_by_film
    by_pressure = work.flow_by_pressure
    weight = step.weight
    n = p.size
    source, mass, gap = work.source, work.residual[0], work.residual[1]
    left, centre, right, film_left, film_here, film_right = band[0], band[1], band[2], band[3], band[4], band[5]
    density, density_slope = work.density, work.density_slope
    density_rows(p, model.fluid.table, density, density_slope)
    side = model.fluid.flux_lateral > 0.0
    if side:
        add_side_flow(state, step, macro, work, model, mode, start)
    # node 0 is given; the rows of the others
    for k in range(1, n, LANES):
        i = min(k, n - LANES)
        w = load(weight, i)
        f_left, f_right = load(f, i - 1), load(f, i)
        film_before, film_after = load(by_film, i - 1), load(by_film, i)
        by_before, by_after = load(by_pressure, i - 1), load(by_pressure, i)
        rho, h = load(density, i), load(state.film, i)
        net = (load(flow, i) - load(flow, i - 1)) * w
        a = film_before * w
        b = (film_before - film_after) * w + rho
        c = -1.0 * film_after * w
        d = (f_right + f_left - by_after + by_before) * w + load(density_slope, i) * h
        if side:
            net = net - w * load(work.outward, i)
            b = b + w * load(work.outward_by_film, i)
            d = d + w * load(work.outward_by_pressure, i)
        store(source, i, net)
        store(left, i, (by_before - f_left) * w)
        store(centre, i, d)
        store(right, i, -1.0 * (f_right + by_after) * w)
        store(film_left, i, a)
        store(film_here, i, b)
        store(film_right, i, c)
        store(mass, i, load(step.upstream_mass, i) + net - rho * h)
        store(work.unit, i, a + b + c)
        store(gap, i, model.contact.boundary - h)
    source[0] = flow[0]
    mass[0] = gap[0] = 0.0


@njit(**FAST_INTERNAL_KERNEL)
def update_sets(state, work, model, compliance):
    """Update the active sets of the complementarity conditions; returns changes and the largest residual."""
    contact = model.contact
    tolerance = contact.tolerance
    p = state.fluid_pressure
    c = state.contact_pressure
    changes = 0
    largest = 0.0
    for i in range(1, p.size):
        old = work.kind[i]
        kind = old
        mass = work.residual[0, i]
        gap = work.residual[1, i]
        if kind & CAPPED:
            if c[i] > 0.0:
                if gap < -tolerance:
                    kind = CONTACT | (FLUID if p[i] > 0.0 else 0)
            elif mass < -tolerance:
                kind = FLUID
        elif p[i] + c[i] > contact.cap * (1.0 + 1e-9):
            kind = CAPPED
        else:
            if kind & FLUID:
                if p[i] <= 0.0:
                    kind &= CONTACT
            elif mass > tolerance and i < contact.outlet:
                kind |= FLUID
            if kind & CONTACT:
                if c[i] <= 0.0:
                    kind &= FLUID
            elif gap > tolerance:
                kind |= CONTACT
        if kind != old:
            changes += 1
            work.kind[i] = kind
        if kind & FLUID:
            # in units of film: a stiff node's mass residual is a tiny pressure change
            unit = 1.0 + work.band[1, i] * compliance
            if not abs(mass) <= largest * unit:
                largest = abs(mass) / unit
        if kind & CONTACT:
            largest = max(largest, abs(gap))
    return changes, largest


@njit(**FAST_INTERNAL_KERNEL)
def hand_over(state, work, model):
    """Make pressures agree with the sets; returns the number of nodes touched.

    A node that leaves one set hands its (negative) share to the other so that total pressure and gap stay put:
    clipping it instead makes limit cycles.
    """
    p = state.fluid_pressure
    c = state.contact_pressure
    cap = model.contact.cap
    touched = 0
    for i in range(1, p.size):
        kind = work.kind[i]
        if kind & CAPPED:
            if p[i] + c[i] != cap:
                p[i] = min(max(p[i], 0.0), cap)
                c[i] = cap - p[i] if c[i] > 0.0 else 0.0
                if c[i] == 0.0:
                    p[i] = cap
                touched += 1
            continue
        if not kind & FLUID and p[i] != 0.0:
            if kind & CONTACT:
                c[i] += p[i]
            p[i] = 0.0
            touched += 1
        if not kind & CONTACT and c[i] != 0.0:
            if kind & FLUID:
                p[i] = max(p[i] + c[i], 0.0)
            c[i] = 0.0
            touched += 1
    return touched


@njit(**FAST_INTERNAL_KERNEL)
def keep_mean_film(state, step, work, model, mean):
    """Shift the approach of the bodies so that the predicted pressures leave the mean film where it was."""
    film_response(state, step, work, model)
    state.scalars[RIGID_APPROACH] += mean - middle_film(state, model.contact)


@njit(**FAST_INTERNAL_KERNEL)
def middle_film(state, contact):
    """Mean gap over the middle of the contact."""
    total = 0.0
    for i in range(contact.middle_first, contact.middle_last):
        total += state.film[i]
    return total / (contact.middle_last - contact.middle_first)


@njit(**FAST_INTERNAL_KERNEL)
def start_sets(state, work, model):
    """Node kinds of the predicted pressures; the inlet node is given and the outlet carries no fluid pressure."""
    p = state.fluid_pressure
    c = state.contact_pressure
    p[0] = model.contact.inlet_pressure
    c[0] = 0.0
    for i in range(p.size):
        if i >= model.contact.outlet:
            p[i] = 0.0
        kind = (FLUID if p[i] > 0.0 and i > 0 else 0) | (CONTACT if c[i] > 0.0 else 0)
        if work.kind[i] == CAPPED and p[i] + c[i] >= model.contact.cap:
            kind = CAPPED
        work.kind[i] = kind


@njit(**FAST_INTERNAL_KERNEL)
def apply_increment(state, work, model, load_error, limit_step):
    """Load balance as the border of the system: move the unknowns, by at most `PRESSURE_STEP` if `limit_step`."""
    sol = work.solution
    kind = work.kind
    n = kind.size
    from_residual = 0.0
    from_level = 0.0
    last = 1
    for i in range(1, n):
        k = kind[i]
        if k & FLUID:
            from_residual += sol[0, i]
            from_level += sol[2, i]
        if k & CONTACT:
            from_residual += sol[1, i]
            from_level += sol[3, i]
        if k & 3:
            last = i + 1
    rise = (from_residual - load_error) / from_level
    excess = 1.0
    for i in range(1, last):
        if kind[i] & FLUID:
            sol[0, i] -= rise * sol[2, i]
            size = abs(sol[0, i]) / (PRESSURE_STEP[0] + PRESSURE_STEP[1] * max(state.fluid_pressure[i], 0.0))
            excess = max(excess, size)
        if kind[i] & CONTACT:
            sol[1, i] -= rise * sol[3, i]
    step = 1.0 / excess if limit_step else 1.0
    state.scalars[RIGID_APPROACH] += step * rise
    for i in range(1, last):
        if kind[i] & FLUID:
            state.fluid_pressure[i] += step * sol[0, i]
        if kind[i] & CONTACT:
            state.contact_pressure[i] += step * sol[1, i]


@njit(**FAST_INTERNAL_KERNEL)
def solve_step(state, step, macro, work, model, stage):
    """Solve one step from the pressures in ``state``; returns iterations and success.

    ``stage`` must be a run-time integer: a literal would be compiled once per value.
    """
    elastic = model.elastic
    contact = model.contact
    mode = STAGE_MODE[stage]
    relaxation = STAGE_RELAXATION[stage]
    n = state.film.size
    diagonal = 0.0
    for m in range(elastic.weights_newton.size):
        diagonal += elastic.weights_newton[m]
    compliance = 0.1 / diagonal
    start_sets(state, work, model)
    best = 1e30
    best_at = 0
    turn_at = 0
    turn = FIRST_TURN
    load = 0.0
    largest = 0.0
    changes = 0
    iterations = 0
    converged = False
    while iterations < STAGE_LIMIT[stage]:
        for attempt in range(2):
            load = film_response(state, step, work, model)
            assemble(state, step, macro, work, model, mode, relaxation, iterations + attempt == 0, attempt == 1)
            if attempt == 1:
                break
            changes, largest = update_sets(state, work, model, compliance)
            if (changes == 0 and iterations > 0) or hand_over(state, work, model) == 0:
                break
        load_error = contact.load - load
        if not largest < 1e30:
            break
        settled = changes == 0 and largest < contact.tolerance and abs(load_error) < LOAD_TOLERANCE * contact.load
        # errors of predictions that are left as they are would add up over the steps, each below the tolerance
        if settled and iterations > 0:
            converged = True
            break
        iterations += 1
        last = n
        while last > 2 and work.kind[last - 1] & 3 == 0:
            last -= 1
        factor_and_solve(
            1,
            last,
            work.kind,
            work.band,
            elastic.weights_newton,
            elastic.ratios_newton,
            work.residual[0],
            work.residual[1],
            work.unit,
            work.solution,
            work.block,
        )
        if largest < 0.7 * best:
            best = largest
            best_at = iterations
        elif mode == NEWTON and iterations - best_at >= STALL:
            if stage != RELAXED:
                break
            mode = PICARD
            turn_at = iterations
        picards = iterations - turn_at
        if mode == PICARD and stage == RELAXED and (picards >= PICARD_TURN or (changes == 0 and picards >= turn)):
            mode = NEWTON
            best = largest
            best_at = iterations
            turn *= 2
        apply_increment(state, work, model, load_error, mode == NEWTON)
    if not converged:
        for i in range(n):
            state.fluid_pressure[i] = max(state.fluid_pressure[i], 0.0)
            state.contact_pressure[i] = max(state.contact_pressure[i], 0.0)
    return iterations, converged
