"""Lubricant laws at one point: viscosity, density, fluidity in both directions, shear stress with temperature."""

from __future__ import annotations

import math

from numba import njit

from ehl.transient._kernels.elasticity import FLAGS

ROELANDS = 1
LOG_VISCOSITY_MAX = 80.0  # of eta/eta0; every law is clamped there
ROELANDS_ZERO = 138.0  # [K]


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def thermal_factor(temperature, fluid):
    """How temperature enters `log_viscosity`: a factor for Roelands, a summand for the other laws."""
    if fluid.law == ROELANDS:
        return math.exp(
            -fluid.slope * math.log((temperature - ROELANDS_ZERO) / (fluid.temperature - ROELANDS_ZERO))
        )
    return -fluid.slope * (temperature - fluid.temperature)


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def log_viscosity(p, thermal, fluid):
    """ln(eta/eta0) and its derivative by the scaled pressure, p >= 0."""
    if fluid.law == ROELANDS:
        t = 1.0 + p * fluid.c1
        power = fluid.c0 * math.exp(fluid.c2 * math.log(t)) * thermal
        value = power - fluid.c0
        slope = power * fluid.c2 * fluid.c1 / t
    elif fluid.law == 0:
        value = fluid.c0 * p + thermal
        slope = fluid.c0
    else:
        d = 1.0 / (fluid.c0 + fluid.c1 * p)
        value = p * d + thermal
        slope = fluid.c0 * d * d
    if value > LOG_VISCOSITY_MAX:
        return LOG_VISCOSITY_MAX, 0.0
    return value, slope


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def density(p, fluid):
    """rho/rho0 and its derivative by the scaled pressure, p >= 0."""
    d = 1.0 / (1.0 + fluid.density_bend * p)
    return 1.0 + fluid.density_rise * p * d, fluid.density_rise * d * d


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def sinh_ratio(x):
    """sinh(S)/S of S = asinh(x), and its derivative by x."""
    if x < 1e-2:
        return 1.0 + x * x / 6.0, x / 3.0
    root = math.sqrt(1.0 + x * x)
    s = math.log(x + root)
    value = x / s
    return value, (1.0 - value / root) / s


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def fluidity(h, p, thermal, boundary, fluid, along, scale):
    """scale rho h^3/eta_effective and its derivatives by h and p.

    The two-direction Eyring mobility is 1/eta (along cosh S + (1 - along) sinh S/S), S = asinh(eta u_s/(tau0 h)).
    The film is at least the boundary film.
    """
    p = p if p > 0.0 else 0.0
    value, slope = log_viscosity(p, thermal, fluid)
    mobility = math.exp(-value)
    rho = 1.0 + fluid.density_rise * p / (1.0 + fluid.density_bend * p)
    free = h > boundary
    h = h if free else boundary
    g = scale * rho * h * h * h
    if not fluid.eyring:
        f = g * mobility
        return f, (3.0 * f / h if free else 0.0), -f * slope
    c = fluid.sliding / h
    # cosh part: mobility sqrt(1 + x^2) with x = c/mobility, written without the quotient
    root = math.sqrt(mobility * mobility + c * c)
    total = along * root
    by_c = along * c / root
    by_mobility = along * mobility / root
    if along < 1.0:
        ratio, ratio_x = sinh_ratio(c / mobility)
        across = 1.0 - along
        total += across * mobility * ratio
        by_c += across * ratio_x
        by_mobility += across * (ratio - c / mobility * ratio_x)
    f = g * total
    return f, (g * (3.0 * total - c * by_c) / h if free else 0.0), -g * by_mobility * mobility * slope


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def shear_stress(h, p, thermal, fluid):
    """Film shear stress over p_h and its derivative by ln eta, limited to Lambda p."""
    value, _ = log_viscosity(p, thermal, fluid)
    limit = fluid.limit * p
    log_x = value + math.log(max(fluid.sliding, 1e-300) / h)
    if not fluid.eyring:
        tau = math.exp(min(log_x, 60.0))
        slope = tau
    elif log_x > 30.0:
        tau = fluid.stress * (log_x + 0.6931471805599453)
        slope = fluid.stress
    else:
        x = math.exp(log_x)
        root = math.sqrt(1.0 + x * x)
        tau = fluid.stress * (math.log(x + root) if x > 1e-4 else x)
        slope = fluid.stress * x / root
    if tau > limit:
        return limit, 0.0
    return tau, slope


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def heated_shear_stress(h, p, base, resistance, start, fluid):
    """Shear stress and film temperature of T = base + resistance tau(p, h, T); resistance in K per p_h of stress.

    The balance is increasing in T, so Newton from below or above converges; an explicit lag would oscillate.
    """
    temperature = start if start > base else base
    tau = 0.0
    for _ in range(8):
        thermal = thermal_factor(temperature, fluid)
        tau, by_log = shear_stress(h, p, thermal, fluid)
        if fluid.law == ROELANDS:
            value, _ = log_viscosity(p, thermal, fluid)
            log_slope = -(value + fluid.c0) * fluid.slope / (temperature - ROELANDS_ZERO)
        else:
            log_slope = -fluid.slope
        change = -(temperature - base - resistance * tau) / (1.0 - resistance * by_log * log_slope)
        temperature += change
        if temperature < base:
            temperature = base
        if abs(change) < 0.01:
            break
    return tau, temperature
