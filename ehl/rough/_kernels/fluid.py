"""Lubricant laws over rows of points: viscosity and density from the table of the laws (`ehl.fluid.lookup`), fluidity
in either direction, shear stress with temperature.

Loops are short and write one row each so that they vectorise.
"""

from __future__ import annotations

import math

from numba import njit

from ehl.compile.compiler import FAST_INTERNAL_KERNEL, FAST_KERNEL, kernel
from ehl.fluid._kernels import inlet_laws, limited_stress, log_mobility, stress_after, stress_scale
from ehl.fluid.rheology import NEWTONIAN
from ehl.rough._kernels.vectors import (
    LANES,
    any_above,
    exp,
    four,
    lane,
    load,
    log,
    store,
    transposed,
    where_above,
    whole_parts,
)

LOG_VISCOSITY_MAX = 80.0  # of eta/eta0; every law is clamped there
BALANCE_LIMIT = 16
BALANCE_TOLERANCE = 0.4  # K; Newton's next change would be half d ln eta/dT of its square, below 0.005 K
LINEAR = 1e30  # stress scale of a Newtonian film
SMALL = 1e-2  # of x, below which sinh S/S is its series
STEP_MAX = 60.0  # of the exponent of the step of tau0: beyond it the step is complete
KEPT = 1e-4  # relative change of the fluidity up to which it is linear, with an error below 1e-6
KINK = 20.0  # times smaller where the limiting stress or the bracket breaks Newton's rule


@kernel(**FAST_KERNEL)
def temperature_place(temperature, table):
    """Where a temperature lies in the sheet of the table."""
    place = table.warmth * (temperature - table.coldest) / (temperature - table.pole)
    return min(max(place, 0.0), float(table.sheet.shape[1]))


@njit(**FAST_INTERNAL_KERNEL)
def pressure_places(p, table, place, growth):
    """Where pressures lie in the row of the table, and how that grows with pressure."""
    for i in range(p.size):
        root = math.sqrt(p[i] + table.shift)
        place[i] = table.rate * (root - table.root)
        growth[i] = 0.5 * table.rate / root


@njit(**FAST_INTERNAL_KERNEL)
def pressure_place(p, table):
    """Where a pressure, or four, lies in the row of the table, and how that grows with pressure."""
    root = math.sqrt(p + table.shift)
    return table.rate * (root - table.root), 0.5 * table.rate / root


@njit(**FAST_INTERNAL_KERNEL)
def cubic(c, x):
    """Value and slope of cubics."""
    c0, c1, c2, c3 = c
    return c0 + x * (c1 + x * (c2 + x * c3)), c1 + x * (2.0 * c2 + 3.0 * x * c3)


@njit(**FAST_INTERNAL_KERNEL)
def cells_of(place, count):
    """Place inside of its cell, way beyond the last one, and number of the cell, of four places."""
    x = min(max(place, 0.0), float(count))
    whole, c0, c1, c2, c3 = whole_parts(min(x, count - 1.0))
    return x - whole, place - x, (c0, c1, c2, c3)


@njit(**FAST_INTERNAL_KERNEL)
def row_cubics(table, cells, first):
    """Coefficients ``first`` to ``first`` + 3 of four cells of the row."""
    c0, c1, c2, c3 = cells
    row = table.row
    return transposed(
        load(row, 8 * c0 + first), load(row, 8 * c1 + first), load(row, 8 * c2 + first), load(row, 8 * c3 + first)
    )


@njit(**FAST_INTERNAL_KERNEL)
def sheet_cell(sheet, cell, warm, t):
    """Coefficients of the cubic over pressure at a temperature in a cell."""
    first = 16 * (cell * sheet.shape[1] + warm)
    high = load(sheet, first + 8) + t * load(sheet, first + 12)
    return load(sheet, first) + t * (load(sheet, first + 4) + t * high)


@njit(**FAST_INTERNAL_KERNEL)
def sheet_cubics(sheet, cells, thermal):
    """The same of four nodes."""
    whole, w0, w1, w2, w3 = whole_parts(min(thermal, sheet.shape[1] - 1.0))
    t = thermal - whole
    c0, c1, c2, c3 = cells
    return transposed(
        sheet_cell(sheet, c0, w0, lane(t, 0)),
        sheet_cell(sheet, c1, w1, lane(t, 1)),
        sheet_cell(sheet, c2, w2, lane(t, 2)),
        sheet_cell(sheet, c3, w3, lane(t, 3)),
    )


@kernel(**FAST_KERNEL)
def density_rows(p, table, density, slope):
    """rho/rho0 at pressures, at least four, and its pressure slope."""
    for k in range(0, p.size, LANES):
        i = min(k, p.size - LANES)
        place, growth = pressure_place(max(load(p, i), 0.0), table)
        x, beyond, cells = cells_of(place, table.row.shape[0])
        value, by_place = cubic(row_cubics(table, cells, 4), x)
        store(density, i, value + by_place * beyond)
        store(slope, i, by_place * growth)


@njit(**FAST_INTERNAL_KERNEL)
def viscosity_rows(rows, fluid, count):
    """Fill exponent ln(eta/eta0), its pressure slope and density from pressure and temperature at the listed points."""
    table = fluid.table
    ratio = table.sheet.shape[0] / table.row.shape[0]
    for k in range(count):
        i = rows.listed[k]
        place, growth = pressure_place(load(rows.pressure, i), table)
        x, beyond, cells = cells_of(place, table.row.shape[0])
        density, rise = cubic(row_cubics(table, cells, 4), x)
        store(rows.density, i, density)
        store(rows.density_slope, i, rise * growth * (2.0 - density))  # near enough to the division for `KEPT`
        if fluid.heated:
            x, beyond, cells = cells_of(place * ratio, table.sheet.shape[0])
            exponent, slope = cubic(sheet_cubics(table.sheet, cells, load(rows.thermal, i)), x)
            growth = growth * ratio
        else:
            exponent, slope = cubic(row_cubics(table, cells, 0), x)
        exponent = exponent + slope * beyond
        store(rows.slope, i, where_above(LOG_VISCOSITY_MAX, exponent, slope * growth, 0.0))
        store(rows.exponent, i, min(exponent, LOG_VISCOSITY_MAX))


@njit(**FAST_INTERNAL_KERNEL)
def scale_row(p, shear, scale):
    """tau0 over the reference stress."""
    if shear.rise == 0.0:
        for i in range(p.size):
            scale[i] = shear.low
        return
    for i in range(p.size):
        # 1 + tanh y = 2/(1 + exp(-2 y))
        scale[i] = shear.low + shear.rise / (1.0 + exp(-2.0 * shear.steepness * (p[i] / shear.centre - 1.0)))


@njit(**FAST_INTERNAL_KERNEL)
def along_and_across(rows, along, i):
    """Weights of the mobilities along and across the sliding in four of the rows (`ehl.heat._kernels.along_share`)."""
    share, across = load(rows.along_share, i), load(rows.across_share, i)
    return along * share, along * (share - across) + (1.0 - along) * across


@njit(**FAST_INTERNAL_KERNEL)
def newtonian_rows(rows, boundary, along, scale, count):
    """Fluidity of a Newtonian film."""
    for k in range(count):
        i = rows.listed[k]
        film = load(rows.film, i)
        h = max(film, boundary)
        first, second = along_and_across(rows, along, i)
        part = scale * (first + second) * load(rows.density, i) * exp(-1.0 * load(rows.exponent, i)) * h * h
        f = part * h
        store(rows.known_f, i, f)
        store(rows.by_film, i, where_above(film, boundary, 3.0 * part, 0.0))
        store(rows.by_pressure, i, -1.0 * f * load(rows.slope, i))


@njit(**FAST_INTERNAL_KERNEL)
def stress_rows(rows, boundary, fluid, scale, count):
    """Ree-Eyring film: x = eta u_s/(tau0 h), scale rho h^3/eta, 1/h (0 below the boundary film) and d ln tau0/dp.

    tau0 is the logistic step of `scale_row`. Divisions are combined, as they cost most.
    """
    shear = fluid.shear
    rate = 2.0 * shear.steepness / shear.centre
    for k in range(count):
        i = rows.listed[k]
        film = load(rows.film, i)
        h = max(film, boundary)
        viscosity = exp(load(rows.exponent, i))
        step = four(0.0)
        if shear.rise > 0.0:
            step = exp(min(2.0 * shear.steepness - rate * load(rows.pressure, i), STEP_MAX))
        whole = 1.0 + step
        stress = shear.low * whole + shear.rise  # tau0 times whole
        thick = h * stress
        low = viscosity * whole
        inverse = 1.0 / (thick * low)
        store(rows.rate, i, fluid.sliding * low * low * inverse)
        store(rows.viscous, i, scale * load(rows.density, i) * h * h * h * thick * whole * inverse)
        store(rows.per_film, i, where_above(film, boundary, stress * low * inverse, 0.0))
        store(rows.stress_slope, i, rate * shear.rise * step * viscosity * h * inverse)


@njit(**FAST_INTERNAL_KERNEL)
def eyring_rows(rows, along, count):
    """Fluidity from `stress_rows`: 1/eta (first cosh S + second sinh S/S), S = asinh x, see `along_and_across`."""
    for k in range(count):
        i = rows.listed[k]
        x = load(rows.rate, i)
        base = load(rows.viscous, i)
        root = math.sqrt(1.0 + x * x)
        angle = max(log(x + root), 1e-3)
        both = 1.0 / (angle * root)
        ratio = x * both * root
        by_x = (1.0 - ratio * both * angle) * both * root
        ratio = where_above(x, SMALL, ratio, 1.0 + x * x * (1.0 / 6.0))
        by_x = where_above(x, SMALL, by_x, x * (1.0 / 3.0))
        first, second = along_and_across(rows, along, i)
        f = base * (first * root + second * ratio)
        thinning = base * x * (first * x * both * angle + second * by_x)  # df/d ln x at constant base
        store(rows.known_f, i, f)
        store(rows.by_film, i, (3.0 * f - thinning) * load(rows.per_film, i))
        store(rows.by_pressure, i, load(rows.slope, i) * (thinning - f) - load(rows.stress_slope, i) * thinning)


@njit(**FAST_INTERNAL_KERNEL)
def other_rows(rows, boundary, fluid, along, scale, count):
    """Fluidity of any shear law (`ehl.fluid.rheology`)."""
    film = rows.film
    for k in range(count):
        for i in range(rows.listed[k], rows.listed[k] + LANES):
            h = max(film[i], boundary)
            p = rows.pressure[i]
            share, other = rows.along_share[i], rows.across_share[i]
            rows.known_f[i] = rows.by_film[i] = rows.by_pressure[i] = 0.0
            for across in range(2):
                weight = along * (share - other) + (1.0 - along) * other if across else along * share
                if weight == 0.0:
                    continue
                log_f, by_eta, by_h, by_p = log_mobility(
                    rows.exponent[i], fluid.sliding, h, p, 1.0 - across, fluid.shear
                )
                f = weight * scale * rows.density[i] * h * h * h * exp(log_f)
                rows.known_f[i] += f
                rows.by_film[i] += f * (3.0 + by_h) / h if film[i] > boundary else 0.0
                rows.by_pressure[i] += f * (rows.slope[i] * by_eta + by_p)


@njit(**FAST_INTERNAL_KERNEL)
def list_changed(rows, boundary, first, last, everything):
    """List the points, in fours, whose film or pressure has changed the fluidity by more than `KEPT`."""
    count = 0
    for k in range(first, last, LANES):
        i = min(k, last - LANES)
        rows.listed[count] = i
        if everything:
            count += 1
            continue
        f, h = load(rows.known_f, i), max(load(rows.film, i), boundary)
        by_pressure = load(rows.by_pressure, i) * (load(rows.pressure, i) - load(rows.known_pressure, i))
        change = 3.0 * f * abs(h - load(rows.known_film, i)) + h * abs(by_pressure)
        count += any_above(change, KEPT * f * h)
    return count


@njit(**FAST_INTERNAL_KERNEL)
def refresh_rows(rows, boundary, fluid, along, scale, first, last, everything):
    """`fluidity_rows` of the points ``first`` to ``last`` - 1, at least four.

    Without ``everything`` points with a small change since their last evaluation get the linear one (`KEPT`): the
    iteration soon changes a few points only.
    """
    count = list_changed(rows, boundary, first, last, everything)
    viscosity_rows(rows, fluid, count)
    if fluid.sliding > 0.0 and not fluid.short:
        other_rows(rows, boundary, fluid, along, scale, count)
    elif not fluid.eyring or fluid.sliding == 0.0:
        newtonian_rows(rows, boundary, along, scale, count)
    else:
        stress_rows(rows, boundary, fluid, scale, count)
        eyring_rows(rows, along, count)
    for k in range(count):
        i = rows.listed[k]
        store(rows.known_film, i, max(load(rows.film, i), boundary))
        store(rows.known_pressure, i, load(rows.pressure, i))
    for k in range(first, last, LANES):
        i = min(k, last - LANES)
        by_film = load(rows.by_film, i) * (max(load(rows.film, i), boundary) - load(rows.known_film, i))
        f = load(rows.known_f, i)
        slope = load(rows.by_pressure, i) + f * load(rows.density_slope, i)
        store(rows.f, i, f + by_film + slope * (load(rows.pressure, i) - load(rows.known_pressure, i)))


@kernel(**FAST_KERNEL)
def fluidity_rows(rows, boundary, fluid, along, scale):
    """scale rho h^3/eta_effective and its derivatives by h and p, from film, pressure and temperature.

    Mobilities in two directions: that of Ree-Eyring films is in `eyring_rows`, those of other laws in
    `ehl.fluid.rheology`.  The film is at least the boundary film.
    """
    refresh_rows(rows, boundary, fluid, along, scale, 0, rows.film.size, True)


@kernel(**FAST_KERNEL)
def isothermal_shear_row(film, p, boundary, fluid, tau):
    """Film shear stress over p_h at the inlet temperature wherever the fluid carries pressure."""
    n = p.size
    sliding = max(fluid.sliding, 1e-300)
    for i in range(n):
        tau[i] = inlet_laws(p[i], fluid.table)[0]
    for i in range(n):
        tau[i] = min(tau[i], LOG_VISCOSITY_MAX) + log(sliding / max(film[i], boundary))
    if not fluid.short or fluid.shear.rise > 0.0:
        for i in range(n):
            tau[i] = fluid.stress * exp(limited_stress(tau[i], p[i], fluid.shear)[0])
    elif fluid.eyring:
        for i in range(n):
            x = exp(min(tau[i], 30.0))
            tau[i] = fluid.stress * (max(tau[i] - 30.0, 0.0) + log(x + math.sqrt(1.0 + x * x)))
    else:
        for i in range(n):
            tau[i] = exp(min(tau[i], 60.0))
    for i in range(n):
        tau[i] = min(tau[i], fluid.limit_ambient + fluid.limit * p[i]) if p[i] > 0.0 else 0.0


@njit(**FAST_INTERNAL_KERNEL)
def sheet_slope_cell(sheet, cell, warm, t):
    """`sheet_cell` of the derivative by the temperature."""
    first = 16 * (cell * sheet.shape[1] + warm)
    return load(sheet, first + 4) + t * (2.0 * load(sheet, first + 8) + 3.0 * t * load(sheet, first + 12))


@njit(**FAST_INTERNAL_KERNEL)
def heated_viscosity_row(place, temperature, table, exponent, slope):
    """ln(eta/eta0), at least four, at places of the pressure in the sheet and temperatures, and d/dT of it."""
    sheet = table.sheet
    warmths = float(sheet.shape[1])
    for k in range(0, place.size, LANES):
        i = min(k, place.size - LANES)
        x, beyond, (c0, c1, c2, c3) = cells_of(load(place, i), sheet.shape[0])
        degrees = load(temperature, i)
        per_distance = 1.0 / (degrees - table.pole)
        warmth = table.warmth * (degrees - table.coldest) * per_distance
        by_degree = table.warmth * (table.coldest - table.pole) * per_distance * per_distance
        inside = where_above(warmth, 0.0, where_above(warmths, warmth, by_degree, 0.0), 0.0)
        warmth = min(max(warmth, 0.0), warmths)
        whole, w0, w1, w2, w3 = whole_parts(min(warmth, warmths - 1.0))
        t = warmth - whole
        t0, t1, t2, t3 = lane(t, 0), lane(t, 1), lane(t, 2), lane(t, 3)
        value, by_place = cubic(
            transposed(
                sheet_cell(sheet, c0, w0, t0),
                sheet_cell(sheet, c1, w1, t1),
                sheet_cell(sheet, c2, w2, t2),
                sheet_cell(sheet, c3, w3, t3),
            ),
            x,
        )
        rise, rise_by_place = cubic(
            transposed(
                sheet_slope_cell(sheet, c0, w0, t0),
                sheet_slope_cell(sheet, c1, w1, t1),
                sheet_slope_cell(sheet, c2, w2, t2),
                sheet_slope_cell(sheet, c3, w3, t3),
            ),
            x,
        )
        # on along the tangent in pressure beyond the last cell
        store(exponent, i, value + beyond * by_place)
        store(slope, i, (rise + beyond * rise_by_place) * inside)


@njit(**FAST_INTERNAL_KERNEL)
def heated_shear_row(place, rate, scale, p, fluid, temperature, tau, slope, decay):
    """Shear stress at given film temperatures, its derivative by them and -d ln(eta)/dT."""
    n = p.size
    heated_viscosity_row(place, temperature, fluid.table, tau, slope)
    for i in range(n):
        decay[i] = -slope[i]
        tau[i] = min(tau[i], LOG_VISCOSITY_MAX) + rate[i]
    if not fluid.short:
        for i in range(n):
            log_stress, growth, _ = limited_stress(tau[i], p[i], fluid.shear)
            tau[i] = fluid.stress * exp(log_stress)
            slope[i] *= growth * tau[i]
    elif fluid.eyring:
        for i in range(n):
            x = exp(min(tau[i], 30.0))
            root = math.sqrt(1.0 + x * x)
            slope[i] *= fluid.stress * scale[i] * x / root
            tau[i] = fluid.stress * scale[i] * (max(tau[i] - 30.0, 0.0) + log(x + root))
    else:
        for i in range(n):
            tau[i] = exp(min(tau[i], 60.0))
        for i in range(n):
            slope[i] *= tau[i]
    for i in range(n):
        limit = fluid.limit_ambient + fluid.limit * p[i] if p[i] > 0.0 else 0.0
        slope[i] = slope[i] if tau[i] < limit else 0.0
        tau[i] = min(tau[i], limit)


@njit(**FAST_INTERNAL_KERNEL)
def balance_turn(base, resistance, low, high, temperature, tau, slope, left, turn):
    """One turn of Newton's iteration inside a bracket; ``left`` receives what the balance is still off by."""
    n = base.size
    for i in range(n):
        # stress falls with temperature: what it would heat to lies on the other side of the solution
        opposite = base[i] + resistance[i] * tau[i]
        low[i] = max(low[i], min(temperature[i], opposite))
        high[i] = min(high[i], max(temperature[i], opposite))
    for i in range(n):
        newton = (base[i] + resistance[i] * tau[i] - temperature[i]) / (1.0 - resistance[i] * slope[i])
        # later on a step across the bracket would come back the same way
        width = high[i] - low[i]
        across = turn > 1 and abs(newton) > 0.9 * width and width * KINK > BALANCE_TOLERANCE
        change = 0.5 * (low[i] + high[i]) - temperature[i] if across else newton
        temperature[i] += change
        tau[i] += slope[i] * change
        left[i] = abs(newton) if slope[i] < 0.0 and not across else KINK * abs(newton)
    for i in range(n):
        left[i] = left[i] if resistance[i] > 0.0 else 0.0


@kernel(**FAST_KERNEL)
def balanced_shear_row(rows, film, p, boundary, fluid, temperature, tau):
    """Shear stress and film temperature of T = base + resistance tau(p, h, T) at every node.

    ``rows.base`` in K, ``rows.resistance`` in K per p_h of stress; ``temperature`` holds the start and the result.
    Newton inside a bracket that closes with every evaluation; an explicit lag would oscillate. Nodes at the ends of the
    row that have settled, most of the inlet, are left out of the further turns.
    """
    n = p.size
    base, resistance = rows.base, rows.resistance
    sliding = max(fluid.sliding, 1e-300)
    pressure_places(p, fluid.table, rows.place, rows.slope)
    share = fluid.table.sheet.shape[0] / fluid.table.row.shape[0]
    for i in range(n):
        rows.place[i] *= share
    for i in range(n):
        rows.rate[i] = log(sliding / max(film[i], boundary))
    if fluid.short and fluid.eyring:
        scale_row(p, fluid.shear, rows.scale)
        if fluid.shear.rise > 0.0:
            for i in range(n):
                rows.rate[i] -= log(rows.scale[i])
    for i in range(n):
        temperature[i] = max(temperature[i], base[i])
    for i in range(n):
        rows.low[i] = base[i]
        rows.high[i] = 1e6
    first = 0
    last = n
    for turn in range(BALANCE_LIMIT):
        first = max(min(first, last - LANES), 0)
        last = max(last, LANES)
        # slices, not a range of indices: those could be negative to the compiler, and nothing would vectorise
        at = slice(first, last)
        heated_shear_row(
            rows.place[at],
            rows.rate[at],
            rows.scale[at],
            p[at],
            fluid,
            temperature[at],
            tau[at],
            rows.slope[at],
            rows.decay[at],
        )
        balance_turn(
            base[at],
            resistance[at],
            rows.low[at],
            rows.high[at],
            temperature[at],
            tau[at],
            rows.slope[at],
            rows.left[at],
            turn,
        )
        while first < last and rows.left[first] < BALANCE_TOLERANCE:
            first += 1
        while last > first and rows.left[last - 1] < BALANCE_TOLERANCE:
            last -= 1
        if first == last:
            break
    for i in range(n):
        limit = fluid.limit_ambient + fluid.limit * p[i] if p[i] > 0.0 else 0.0
        if tau[i] > limit:
            tau[i] = limit
            temperature[i] = base[i] + resistance[i] * tau[i]


@njit(**FAST_INTERNAL_KERNEL)
def strain_film(state, model):
    """Shear stress with its elastic part: the film moves by one node in a step and takes its stress with it."""
    fluid, strain = model.fluid, model.strain
    p = state.fluid_pressure
    for i in range(p.size - 1, 0, -1):
        scale = LINEAR if fluid.shear.kind == NEWTONIAN else fluid.stress * stress_scale(p[i], fluid.shear)[0]
        gain = 1.0 / (strain.film * max(state.film[i], model.contact.boundary) + strain.bodies)
        stress = stress_after(state.strained[i - 1], state.shear[i], scale, gain)
        state.strained[i] = min(stress, fluid.limit_ambient + fluid.limit * max(p[i], 0.0))
    state.strained[0] = state.shear[0]
