"""Lubricant laws over rows of points: viscosity and density from the table of the laws (`ehl.fluid.lookup`), fluidity
in either direction, shear stress with temperature.

Loops are short and write one row each so that they vectorise.
"""

from __future__ import annotations

import math

from numba import njit

from ehl.compile._kernels import log
from ehl.compile.compiler import FAST_INTERNAL_KERNEL, FAST_KERNEL, kernel
from ehl.fluid._kernels import inlet_laws, limited_stress, log_mobility, stress_after, stress_scale
from ehl.fluid.rheology import NEWTONIAN
from ehl.rough._kernels.vectors import exp

LOG_VISCOSITY_MAX = 80.0  # of eta/eta0; every law is clamped there
BALANCE_LIMIT = 16
BALANCE_TOLERANCE = 0.4  # K; Newton's next change would be half d ln eta/dT of its square, below 0.005 K
LINEAR = 1e30  # stress scale of a Newtonian film
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


@kernel(**FAST_KERNEL)
def density_rows(p, table, place, growth, density, slope):
    """rho/rho0 and its pressure slope; ``place`` and ``growth`` are scratch."""
    pressure_places(p, table, place, growth)
    top = float(table.row.shape[0])
    last = table.row.shape[0] - 1
    for i in range(p.size):
        x = min(place[i], top)
        cell = min(int(x), last)
        x -= cell
        a = table.row[cell]
        by_place = a[5] + x * (2.0 * a[6] + 3.0 * x * a[7])
        density[i] = a[4] + x * (a[5] + x * (a[6] + x * a[7])) + by_place * (place[i] - cell - x)
        slope[i] = by_place * growth[i]


@njit(**FAST_INTERNAL_KERNEL)
def inlet_viscosity_rows(rows, table):
    """Viscosity exponent, its slope in the place and density from the row of the table."""
    place, exponent, slope, density = rows.place, rows.exponent, rows.slope, rows.density
    top = float(table.row.shape[0])
    last = table.row.shape[0] - 1
    for i in range(place.size):
        x = min(place[i], top)
        cell = min(int(x), last)
        x -= cell
        a = table.row[cell]
        beyond = place[i] - cell - x
        slope[i] = a[1] + x * (2.0 * a[2] + 3.0 * x * a[3])
        exponent[i] = a[0] + x * (a[1] + x * (a[2] + x * a[3])) + slope[i] * beyond
        density[i] = a[4] + x * (a[5] + x * (a[6] + x * a[7]))


@njit(**FAST_INTERNAL_KERNEL)
def heated_viscosity_rows(rows, table):
    """The same with the viscosity exponent from the sheet, at the temperature places ``rows.thermal``."""
    place, thermal = rows.place, rows.thermal
    exponent, slope, density = rows.exponent, rows.slope, rows.density
    top = float(table.row.shape[0])
    last = table.row.shape[0] - 1
    cells = table.sheet.shape[0]
    share = cells / top
    for i in range(place.size):
        x = min(place[i], top)
        cell = min(int(x), last)
        x -= cell
        a = table.row[cell]
        density[i] = a[4] + x * (a[5] + x * (a[6] + x * a[7]))
    for i in range(place.size):
        whole = place[i] * share
        x = min(whole, float(cells))
        cell = min(int(x), cells - 1)
        x -= cell
        warm = min(int(thermal[i]), table.sheet.shape[1] - 1)
        t = thermal[i] - warm
        a = table.sheet[cell, warm]
        t2 = t * t
        t3 = t2 * t
        c0 = a[0] + t * a[4] + t2 * a[8] + t3 * a[12]
        c1 = a[1] + t * a[5] + t2 * a[9] + t3 * a[13]
        c2 = a[2] + t * a[6] + t2 * a[10] + t3 * a[14]
        c3 = a[3] + t * a[7] + t2 * a[11] + t3 * a[15]
        by_place = c1 + x * (2.0 * c2 + 3.0 * x * c3)
        exponent[i] = c0 + x * (c1 + x * (c2 + x * c3)) + by_place * (whole - cell - x)
        slope[i] = by_place * share


@njit(**FAST_INTERNAL_KERNEL)
def viscosity_rows(rows, fluid):
    """Fill exponent ln(eta/eta0), its pressure slope, mobility eta0/eta and density from pressure and temperature."""
    exponent, slope, growth, mobility = rows.exponent, rows.slope, rows.growth, rows.mobility
    pressure_places(rows.pressure, fluid.table, rows.place, growth)
    if fluid.heated:
        heated_viscosity_rows(rows, fluid.table)
    else:
        inlet_viscosity_rows(rows, fluid.table)
    for i in range(exponent.size):
        slope[i] = slope[i] * growth[i] if exponent[i] < LOG_VISCOSITY_MAX else 0.0
    for i in range(exponent.size):
        exponent[i] = min(exponent[i], LOG_VISCOSITY_MAX)
    for i in range(exponent.size):
        mobility[i] = exp(-exponent[i])


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
def scale_rows(rows, shear):
    """tau0 over the reference stress, and d ln/dp of it: a logistic step."""
    p, scale, slope = rows.pressure, rows.scale, rows.scale_slope
    scale_row(p, shear, scale)
    if shear.rise == 0.0:
        for i in range(p.size):
            slope[i] = 0.0
        return
    rate = 2.0 * shear.steepness / shear.centre
    for i in range(p.size):
        share = (scale[i] - shear.low) / shear.rise
        slope[i] = rate * shear.rise * share * (1.0 - share) / scale[i]


@njit(**FAST_INTERNAL_KERNEL)
def sinh_ratio(x):
    """sinh(S)/S of S = asinh(x) > 0, and its derivative by x."""
    if x < 1e-2:
        return 1.0 + x * x / 6.0, x / 3.0
    root = math.sqrt(1.0 + x * x)
    s = log(x + root)
    value = x / s
    return value, (1.0 - value / root) / s


@kernel(**FAST_KERNEL)
def fluidity_rows(rows, boundary, fluid, along, scale):
    """scale rho h^3/eta_effective and its derivatives by h and p, from film, pressure and temperature.

    The two-direction Eyring mobility is 1/eta (along cosh S + (1 - along) sinh S/S), S = asinh(eta u_s/(tau0 h)); other
    laws have theirs in `ehl.fluid.rheology`.  The film is at least the boundary film.
    """
    viscosity_rows(rows, fluid)
    film = rows.film
    p = rows.pressure
    mobility = rows.mobility
    slope = rows.slope
    f = rows.f
    by_film = rows.by_film
    by_pressure = rows.by_pressure
    tau0 = rows.scale
    tau0_slope = rows.scale_slope
    n = p.size
    for i in range(n):
        h = max(film[i], boundary)
        f[i] = scale * rows.density[i] * h * h * h
    sliding = fluid.sliding
    if sliding > 0.0 and not fluid.short:
        for i in range(n):
            h = max(film[i], boundary)
            log_f, by_eta, by_h, by_p = log_mobility(rows.exponent[i], sliding, h, p[i], along, fluid.shear)
            f[i] *= exp(log_f)
            by_film[i] = f[i] * (3.0 + by_h) / h if film[i] > boundary else 0.0
            by_pressure[i] = f[i] * (slope[i] * by_eta + by_p)
    elif not fluid.eyring or sliding == 0.0:
        for i in range(n):
            f[i] *= mobility[i]
        for i in range(n):
            by_film[i] = 3.0 * f[i] / film[i] if film[i] > boundary else 0.0
        for i in range(n):
            by_pressure[i] = -f[i] * slope[i]
    elif along == 1.0:
        # mobility cosh S = sqrt(mobility^2 + c^2), c = eta0 u_s/(tau0 h)
        scale_rows(rows, fluid.shear)
        for i in range(n):
            c = sliding / (max(film[i], boundary) * tau0[i])
            f[i] *= math.sqrt(mobility[i] * mobility[i] + c * c)
        for i in range(n):
            h = max(film[i], boundary)
            x = mobility[i] * h * tau0[i] / sliding
            part = 3.0 - 1.0 / (1.0 + x * x)
            by_film[i] = f[i] * part / h if film[i] > boundary else 0.0
        for i in range(n):
            x = mobility[i] * max(film[i], boundary) * tau0[i] / sliding
            by_pressure[i] = -f[i] * (slope[i] * x * x + tau0_slope[i]) / (1.0 + x * x)
    else:
        scale_rows(rows, fluid.shear)
        for i in range(n):
            h = max(film[i], boundary)
            x = sliding / (h * mobility[i] * tau0[i])
            root = math.sqrt(1.0 + x * x)
            ratio, by_x = sinh_ratio(x)
            total = along * root + (1.0 - along) * ratio
            log_slope = x * (along * x / root + (1.0 - along) * by_x) / total  # d ln(total)/d ln x
            f[i] *= mobility[i] * total
            by_film[i] = f[i] * (3.0 - log_slope) / h if film[i] > boundary else 0.0
            by_pressure[i] = -f[i] * (slope[i] * (1.0 - log_slope) + tau0_slope[i] * log_slope)


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
def heated_shear_row(place, rate, scale, p, fluid, temperature, tau, slope, decay):
    """Shear stress at given film temperatures, its derivative by them and -d ln(eta)/dT."""
    n = p.size
    table = fluid.table
    sheet = table.sheet
    cells, warmths = sheet.shape[0], sheet.shape[1]
    for i in range(n):
        tau[i] = temperature_place(temperature[i], table)
    for i in range(n):
        distance = temperature[i] - table.pole
        inside = 0.0 < tau[i] < warmths
        slope[i] = table.warmth * (table.coldest - table.pole) / (distance * distance) if inside else 0.0
    for i in range(n):
        x = min(place[i], float(cells))
        cell = min(int(x), cells - 1)
        x -= cell
        warm = min(int(tau[i]), warmths - 1)
        t = tau[i] - warm
        a = sheet[cell, warm]
        # on along the tangent in pressure beyond the last cell
        x2, x3 = x * x, x * x * x
        beyond = place[i] - cell - x
        one, two, three = x + beyond, x2 + 2.0 * x * beyond, x3 + 3.0 * x2 * beyond
        c0 = a[0] + one * a[1] + two * a[2] + three * a[3]
        c1 = a[4] + one * a[5] + two * a[6] + three * a[7]
        c2 = a[8] + one * a[9] + two * a[10] + three * a[11]
        c3 = a[12] + one * a[13] + two * a[14] + three * a[15]
        tau[i] = c0 + t * (c1 + t * (c2 + t * c3))
        slope[i] *= c1 + t * (2.0 * c2 + 3.0 * t * c3)
        decay[i] = -slope[i]
    for i in range(n):
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
