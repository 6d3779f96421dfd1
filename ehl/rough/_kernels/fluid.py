"""Lubricant laws over rows of points: viscosity, fluidity in either direction, shear stress with temperature.

Loops are short and write one row each so that they vectorise.
"""

from __future__ import annotations

import math

from numba import njit

from ehl.fluid._kernels import limited_stress, log_mobility
from ehl.rough._kernels.elasticity import FLAGS, INTERNAL
from ehl.rough._kernels.elementary import exp, log

BARUS, ROELANDS, MODULUS = range(3)
LOG_VISCOSITY_MAX = 80.0  # of eta/eta0; every law is clamped there
ROELANDS_ZERO = 138.0  # [K]
BALANCE_LIMIT = 16
BALANCE_TOLERANCE = 0.4  # K; Newton's next change would be half d ln eta/dT of its square, below 0.005 K
KINK = 20.0  # times smaller where the limiting stress or the bracket breaks Newton's rule


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def thermal_factor(temperature, fluid):
    """How temperature enters the viscosity: a factor of the exponent for Roelands, a summand for Barus.

    The modulus law takes the temperature rise itself: its stiffness under pressure depends on temperature too.
    """
    if fluid.law == ROELANDS:
        return exp(-fluid.slope * log((temperature - ROELANDS_ZERO) / (fluid.temperature - ROELANDS_ZERO)))
    rise = temperature - fluid.temperature
    return rise if fluid.law == MODULUS else -fluid.slope * rise


@njit(**INTERNAL)
def isothermal_exponent(p, fluid):
    """ln(eta/eta0) at the inlet temperature, p >= 0."""
    if fluid.law == ROELANDS:
        return fluid.c0 * (exp(fluid.c2 * log(1.0 + p * fluid.c1)) - 1.0)
    if fluid.law == BARUS:
        return fluid.c0 * p
    return p / (fluid.c0 + fluid.c1 * p)


@njit(**INTERNAL)
def viscosity_rows(rows, fluid):
    """Fill exponent ln(eta/eta0), its pressure slope and the mobility eta0/eta from pressure and temperature factor."""
    p = rows.pressure
    thermal = rows.thermal
    exponent = rows.exponent
    slope = rows.slope
    mobility = rows.mobility
    n = p.size
    if fluid.law == ROELANDS:
        for i in range(n):
            exponent[i] = fluid.c0 * exp(fluid.c2 * log(1.0 + fluid.c1 * p[i])) * thermal[i] - fluid.c0
        for i in range(n):
            slope[i] = (exponent[i] + fluid.c0) * fluid.c2 * fluid.c1 / (1.0 + fluid.c1 * p[i])
    elif fluid.law == BARUS:
        for i in range(n):
            exponent[i] = fluid.c0 * p[i] + thermal[i]
        for i in range(n):
            slope[i] = fluid.c0
    else:
        for i in range(n):
            stiffness = fluid.c0 + fluid.c0_rise * thermal[i] + (fluid.c1 + fluid.c1_rise * thermal[i]) * p[i]
            exponent[i] = p[i] / stiffness - fluid.slope * thermal[i] / (1.0 + fluid.slope_bend * thermal[i])
        for i in range(n):
            start = fluid.c0 + fluid.c0_rise * thermal[i]
            stiffness = start + (fluid.c1 + fluid.c1_rise * thermal[i]) * p[i]
            slope[i] = start / (stiffness * stiffness)
    for i in range(n):
        if exponent[i] > LOG_VISCOSITY_MAX:
            exponent[i] = LOG_VISCOSITY_MAX
            slope[i] = 0.0
    for i in range(n):
        mobility[i] = exp(-exponent[i])


@njit(**INTERNAL)
def scale_row(p, shear, scale):
    """tau0 over the reference stress."""
    if shear.rise == 0.0:
        for i in range(p.size):
            scale[i] = shear.low
        return
    for i in range(p.size):
        # 1 + tanh y = 2/(1 + exp(-2 y))
        scale[i] = shear.low + shear.rise / (1.0 + exp(-2.0 * shear.steepness * (p[i] / shear.centre - 1.0)))


@njit(**INTERNAL)
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


@njit(**INTERNAL)
def sinh_ratio(x):
    """sinh(S)/S of S = asinh(x) > 0, and its derivative by x."""
    if x < 1e-2:
        return 1.0 + x * x / 6.0, x / 3.0
    root = math.sqrt(1.0 + x * x)
    s = log(x + root)
    value = x / s
    return value, (1.0 - value / root) / s


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def fluidity_rows(rows, boundary, fluid, along, scale):
    """scale rho h^3/eta_effective and its derivatives by h and p, from film, pressure and temperature factor.

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
    rise = fluid.density_rise
    bend = fluid.density_bend
    for i in range(n):
        h = max(film[i], boundary)
        f[i] = scale * (1.0 + rise * p[i] / (1.0 + bend * p[i])) * h * h * h
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


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def isothermal_shear_row(film, p, boundary, fluid, tau):
    """Film shear stress over p_h at the inlet temperature wherever the fluid carries pressure."""
    n = p.size
    sliding = max(fluid.sliding, 1e-300)
    if fluid.law == ROELANDS:
        for i in range(n):
            tau[i] = fluid.c0 * (exp(fluid.c2 * log(1.0 + fluid.c1 * p[i])) - 1.0)
    else:
        for i in range(n):
            tau[i] = isothermal_exponent(p[i], fluid)
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
        tau[i] = min(tau[i], fluid.limit * p[i]) if p[i] > 0.0 else 0.0


@njit(**INTERNAL)
def heated_shear_row(cold, rate, scale, p, fluid, temperature, tau, slope):
    """Shear stress at given film temperatures and its derivative by them."""
    n = p.size
    if fluid.law == ROELANDS:
        for i in range(n):
            tau[i] = (cold[i] + fluid.c0) * thermal_factor(temperature[i], fluid) - fluid.c0
        for i in range(n):
            slope[i] = -(tau[i] + fluid.c0) * fluid.slope / (temperature[i] - ROELANDS_ZERO)
    elif fluid.law == MODULUS:
        for i in range(n):
            rise = temperature[i] - fluid.temperature
            stiffening = fluid.c0_rise + fluid.c1_rise * p[i]
            stiffness = fluid.c0 + fluid.c1 * p[i] + stiffening * rise
            bend = 1.0 + fluid.slope_bend * rise
            tau[i] = p[i] / stiffness - fluid.slope * rise / bend
            slope[i] = -p[i] * stiffening / (stiffness * stiffness) - fluid.slope / (bend * bend)
    else:
        for i in range(n):
            tau[i] = cold[i] - fluid.slope * (temperature[i] - fluid.temperature)
        for i in range(n):
            slope[i] = -fluid.slope
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
        limit = fluid.limit * max(p[i], 0.0)
        slope[i] = slope[i] if tau[i] < limit else 0.0
        tau[i] = min(tau[i], limit)


@njit(**INTERNAL)
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


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def balanced_shear_row(rows, film, p, boundary, fluid, temperature, tau):
    """Shear stress and film temperature of T = base + resistance tau(p, h, T) at every node.

    ``rows.base`` in K, ``rows.resistance`` in K per p_h of stress; ``temperature`` holds the start and the result.
    Newton inside a bracket that closes with every evaluation; an explicit lag would oscillate. Nodes at the ends of the
    row that have settled, most of the inlet, are left out of the further turns.
    """
    n = p.size
    base, resistance = rows.base, rows.resistance
    sliding = max(fluid.sliding, 1e-300)
    for i in range(n):
        rows.cold[i] = isothermal_exponent(p[i], fluid)
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
            rows.cold[at], rows.rate[at], rows.scale[at], p[at], fluid, temperature[at], tau[at], rows.slope[at]
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
        if tau[i] > fluid.limit * max(p[i], 0.0):
            tau[i] = fluid.limit * max(p[i], 0.0)
            temperature[i] = base[i] + resistance[i] * tau[i]
