"""One implicit time step: mass conservation, two complementarity conditions and the load, solved together.

    mass     foot + w [d/dx f dp/dx - exchange (p - P)] = rho h      where p > 0, else p = 0 and the gap is not full
    contact  h >= h_boundary,  p_c >= 0,  one of them an equality
    cap      p + p_c <= hardness; a node at the cap keeps its pressures and lets its gap or mass go
    load     sum of p + p_c given
"""

from __future__ import annotations

from numba import njit

from ehl.transient._kernels.elasticity import FLAGS, exponential_product
from ehl.transient._kernels.fluid import fluidity
from ehl.transient._kernels.quasi_separable import CONTACT, FLUID, factor_and_solve
from ehl.transient._kernels.records import CAPPED, LEVEL

NEWTON, PICARD, FROZEN = range(3)  # full derivatives; relaxed lagged fluidity; fluidity of the start
PRESSURE_STEP = (0.4, 0.8)  # an iteration changes p by at most 0.4 + 0.8 p
PATIENCE = 12  # iterations after which a stalling residual cuts the step
LOAD_TOLERANCE = 1e-6


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def film_response(state, step, work, model):
    """Gap under the present pressures; returns their sum."""
    total = work.total
    load = 0.0
    for i in range(total.size):
        q = state.fluid_pressure[i] + state.contact_pressure[i]
        total[i] = q
        load += q
    exponential_product(total, model.elastic.weights, model.elastic.ratios, work.mode_state, work.response)
    level = state.scalars[LEVEL]
    for i in range(total.size):
        state.film[i] = level + step.gap[i] + work.response[i]
    return load


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def lateral_exchange(i, h, p, foot, thermal, macro, work, model):
    """Conductance between a pocket and the macroscopic pressure, and its derivatives by h and p.

    Two halves in series: the pocket's own gap, then the typical gap at this place.  A starved pocket conducts with
    its filled part only.
    """
    pressure = 0.5 * ((p if p > 0.0 else 0.0) + macro.pressure[i])
    own, by_h, by_p = fluidity(
        h, pressure, thermal, model.contact.boundary, model.fluid, 1.0 - model.fluid.along, model.fluid.flux_lateral
    )
    work.lateral[i] = own
    typical = macro.typical[i]
    if typical > 0.0:
        part = typical / (own + typical)
        own *= 2.0 * part
        by_h *= 2.0 * part * part
        by_p *= 2.0 * part * part
    if p <= 0.0 and foot < h:
        filled = max(foot, 0.0) / h
        own *= filled
        by_h *= filled
    return own, by_h, by_p


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def assemble(state, step, macro, work, model, mode, relaxation, start, keep_fluidity):
    """Residuals and the bands of the Newton matrix at every node.

    ``start`` marks the first assembly of a solve, ``keep_fluidity`` one that repeats an iteration.
    """
    fluid = model.fluid
    boundary = model.contact.boundary
    p = state.fluid_pressure
    h = state.film
    n = p.size
    band = work.band
    drained = fluid.flux_lateral > 0.0
    slopes = 1.0 if mode == NEWTON else 0.0
    flow = 0.0  # through the left half node, and its derivatives
    f_left = 0.0
    h_left = 0.0
    p_left = 0.0
    for i in range(n):
        flow_right = f_right = h_right = p_right = 0.0
        if i < n - 1:
            dp = p[i + 1] - p[i]
            if mode == NEWTON or start or (mode == PICARD and not keep_fluidity):
                f, f_h, f_p = fluidity(
                    0.5 * (h[i] + h[i + 1]),
                    0.5 * (p[i] + p[i + 1]),
                    0.5 * (step.thermal[i] + step.thermal[i + 1]),
                    boundary,
                    fluid,
                    fluid.along,
                    fluid.flux,
                )
                if mode == PICARD and not start and work.fluidity[i] > 0.0:
                    f = work.fluidity[i] * (f / work.fluidity[i]) ** relaxation
                work.fluidity[i] = f
            else:
                f = work.fluidity[i]
                f_h = 0.0
                f_p = 0.0
            flow_right = f * dp
            f_right = f
            h_right = 0.5 * f_h * dp * slopes
            p_right = 0.5 * f_p * dp * slopes
        pressure = p[i] if p[i] > 0.0 else 0.0
        d = 1.0 / (1.0 + fluid.density_bend * pressure)
        rho = 1.0 + fluid.density_rise * pressure * d
        w = step.weight[i]
        source = (flow_right - flow) * w
        band[0, i] = (p_left - f_left) * w
        band[1, i] = fluid.density_rise * d * d * h[i] + (f_right + f_left - p_right + p_left) * w
        band[2, i] = (-f_right - p_right) * w
        band[3, i] = h_left * w
        band[4, i] = rho + (h_left - h_right) * w
        band[5, i] = -h_right * w
        if drained and i < model.contact.outlet:
            k, k_h, k_p = lateral_exchange(i, h[i], p[i], step.foot[i], step.thermal[i], macro, work, model)
            work.exchange[i] = k
            excess = p[i] - macro.pressure[i]
            source -= w * k * excess
            if p[i] > 0.0:
                band[1, i] += w * max(k + 0.5 * slopes * k_p * excess, 0.1 * k)
            else:
                band[1, i] += w * k
            band[4, i] += w * slopes * k_h * excess
        work.source[i] = source
        work.residual[0, i] = step.foot[i] + source - rho * h[i]
        work.residual[1, i] = boundary - h[i]
        work.unit[i] = band[3, i] + band[4, i] + band[5, i]
        flow = flow_right
        f_left = f_right
        h_left = h_right
        p_left = p_right


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def update_sets(state, work, model, compliance):
    """Let nodes enter and leave the three sets; returns the number of changes and the largest residual."""
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
            largest = max(largest, abs(mass) / (1.0 + work.band[1, i] * compliance))
        if kind & CONTACT:
            largest = max(largest, abs(gap))
    return changes, largest


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
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


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def start_sets(state, work, model):
    """Node kinds of the predicted pressures; the inlet node and the outlet carry none."""
    p = state.fluid_pressure
    c = state.contact_pressure
    p[0] = 0.0
    c[0] = 0.0
    for i in range(p.size):
        if i >= model.contact.outlet:
            p[i] = 0.0
        kind = (FLUID if p[i] > 0.0 else 0) | (CONTACT if c[i] > 0.0 else 0)
        if work.kind[i] == CAPPED and p[i] + c[i] >= model.contact.cap:
            kind = CAPPED
        work.kind[i] = kind


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def apply_increment(state, work, model, load_error, damping, limit_step):
    """Border the two solutions with the load condition and move the unknowns."""
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
    step = damping / excess if limit_step else damping
    state.scalars[LEVEL] += step * rise
    for i in range(1, last):
        if kind[i] & FLUID:
            state.fluid_pressure[i] += step * sol[0, i]
        if kind[i] & CONTACT:
            state.contact_pressure[i] += step * sol[1, i]


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def solve_step(state, step, macro, work, model, mode, relaxation, limit):
    """Solve one step from the pressures in ``state``; returns iterations, success, largest residual."""
    elastic = model.elastic
    contact = model.contact
    n = state.film.size
    diagonal = 0.0
    for m in range(elastic.weights_newton.size):
        diagonal += elastic.weights_newton[m]
    compliance = 0.1 / diagonal
    start_sets(state, work, model)
    damping = 1.0
    previous = 1e30
    largest = 0.0
    iterations = 0
    converged = False
    start = True
    while iterations < limit:
        load = film_response(state, step, work, model)
        assemble(state, step, macro, work, model, mode, relaxation, start, False)
        start = False
        changes, largest = update_sets(state, work, model, compliance)
        if hand_over(state, work, model) > 0:
            load = film_response(state, step, work, model)
            assemble(state, step, macro, work, model, mode, relaxation, False, True)
        load_error = contact.load - load
        if not largest < 1e30:
            break
        if changes == 0 and largest < contact.tolerance and abs(load_error) < LOAD_TOLERANCE * contact.load:
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
        if iterations > PATIENCE and mode == NEWTON:
            damping = max(0.5 * damping, 0.08) if largest > 0.8 * previous else min(1.0, 1.8 * damping)
        previous = largest
        apply_increment(state, work, model, load_error, damping, mode == NEWTON)
    if not converged:
        for i in range(n):
            state.fluid_pressure[i] = max(state.fluid_pressure[i], 0.0)
            state.contact_pressure[i] = max(state.contact_pressure[i], 0.0)
    return iterations, converged, largest
