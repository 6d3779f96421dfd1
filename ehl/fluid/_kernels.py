"""The table of viscosity and density and the shear laws at one point, for the compiled loops of both solvers.

Stresses are taken in logarithms: the viscosity of a stiff oil under pressure leaves the range of doubles.
"""

from __future__ import annotations

import math

import numpy as np

from ehl.compile.compiler import KERNEL, kernel

# compiled loops that lie on disk look for the record of numbers here
from ehl.fluid.lookup import LawTable  # noqa: F401
from ehl.fluid.rheology import CARREAU, EYRING, LARGE, NEWTONIAN, ShearNumbers  # noqa: F401

LOG_TWO = math.log(2.0)
STIFF = 300.0  # of a stress over tau0: beyond it the law is a limit


@kernel(**KERNEL)
def inlet_laws(p, table):
    """ln(eta/eta0), rho/rho0 and their slopes in p at the inlet temperature; on along the tangent at both ends."""
    root = math.sqrt(max(p, 0.0) + table.shift)
    place = (root - table.root) * table.rate
    x = min(place, float(table.row.shape[0]))
    cell = min(int(x), table.row.shape[0] - 1)
    x -= cell
    a = table.row[cell]
    growth = 0.5 * table.rate / root
    slope = a[1] + x * (2.0 * a[2] + 3.0 * x * a[3])
    density_slope = a[5] + x * (2.0 * a[6] + 3.0 * x * a[7])
    beyond = place - cell - x + min(p, 0.0) * growth
    value = a[0] + x * (a[1] + x * (a[2] + x * a[3])) + slope * beyond
    density = a[4] + x * (a[5] + x * (a[6] + x * a[7])) + density_slope * beyond
    return value, slope * growth, density, density_slope * growth


@kernel(**KERNEL)
def stress_scale(p, law):
    """Stress scale (tau0 of Ree-Eyring, G of Carreau) over the reference, and d ln/dp."""
    if law.rise == 0.0:
        return law.low, 0.0
    bend = math.tanh(law.steepness * (p / law.centre - 1.0))
    value = law.low + 0.5 * law.rise * (1.0 + bend)
    return value, 0.5 * law.rise * (1.0 - bend * bend) * law.steepness / (law.centre * value)


@kernel(**KERNEL)
def share_and_root(log_x):
    """x^2/(1 + x^2) and ln(1 + x^2)."""
    if log_x > LARGE:
        return 1.0, 2.0 * log_x
    square = math.exp(2.0 * log_x)
    return square / (1.0 + square), math.log1p(square)


@kernel(**KERNEL)
def flow_curve(log_x, law):
    """The law's curve T(x), x = eta rate/scale, T = stress/scale: ln T and d ln T/d ln x."""
    if law.kind == NEWTONIAN:
        return log_x, 1.0
    if law.kind == EYRING and log_x > LARGE:
        angle = log_x + LOG_TWO
        return math.log(angle), 1.0 / angle
    if law.kind == EYRING:
        x = math.exp(log_x)
        if x < 1e-4:
            return log_x - x * x / 6.0, 1.0 - x * x / 3.0
        angle = math.asinh(x)
        return math.log(angle), x / (math.sqrt(1.0 + x * x) * angle)
    share, root = share_and_root(log_x)
    return log_x - 0.5 * (1.0 - law.exponent) * root, 1.0 - (1.0 - law.exponent) * share


@kernel(**KERNEL)
def fluidity_along(log_x, law):
    """ln of the fluidity along the sliding over 1/eta, -ln T'(x), and its d/d ln x."""
    if law.kind == NEWTONIAN:
        return 0.0, 0.0
    share, root = share_and_root(log_x)
    if law.kind == EYRING:
        return 0.5 * root, share
    # T' = (1 + x^2)^((n - 1)/2) slope
    slope = 1.0 - (1.0 - law.exponent) * share
    by_x = (1.0 - law.exponent) * share * (1.0 + 2.0 * (1.0 - share) / slope)
    return 0.5 * (1.0 - law.exponent) * root - math.log(slope), by_x


@kernel(**KERNEL)
def limited_stress(log_viscous, p, law):
    """ln of the shear stress over the reference, with d/d ln eta and d/dp at fixed eta, film and speed.

    ``log_viscous`` is ln of eta |v_s|/h over the reference.  The limit is the smooth one of Bair and Winer (1979),
    tau = tau_L (1 - exp(-tau_free/tau_L)); one that cuts the traction off is the caller's.
    """
    scale, scale_p = stress_scale(p, law)
    log_free, curve = flow_curve(log_viscous - math.log(scale), law)
    log_free += math.log(scale)
    free_p = scale_p * (1.0 - curve)
    if not law.smooth:
        return log_free, curve, free_p
    limit = law.ambient + law.slope * max(p, 0.0)
    log_limit = math.log(max(limit, 1e-300))
    limit_p = law.slope / limit if limit > 0.0 else 0.0
    ratio = math.exp(min(log_free - log_limit, 5.0))  # exp(-148) is nothing
    rest = -math.expm1(-ratio)
    weight = ratio * math.exp(-ratio) / rest
    return log_limit + math.log(rest), weight * curve, weight * free_p + (1.0 - weight) * limit_p


@kernel(**KERNEL)
def log_mobility(log_eta, sliding, h, p, along, law):
    """ln of the mobility times eta0, with its derivatives by ln eta, ln h and p.

    A small pressure gradient on top of the shear flow sees the fluidity d rate/d tau along the sliding and rate/tau
    across it; ``along`` is the squared cosine between sliding and flow, ``sliding`` eta0 |v_s|/(reference unit film).

    With a smooth limit the fluidity along the sliding grows without bound, but the flow cannot: at most all of the
    sliding becomes slip at one wall, which adds |v_s| h/2.  What the limit adds is held there for a reference gradient,
    as resistances in series.
    """
    log_h = math.log(h)
    log_rate = math.log(sliding) - log_h
    across, across_eta, across_h, across_p = 0.0, 0.0, 0.0, 0.0
    if along < 1.0:
        log_tau, tau_eta, tau_p = limited_stress(log_eta + log_rate, p, law)
        across, across_eta, across_h, across_p = log_rate - log_tau, -tau_eta, tau_eta - 1.0, -tau_p
        if along == 0.0:
            return across, across_eta, across_h, across_p
    scale, scale_p = stress_scale(p, law)
    log_scale = math.log(scale)
    log_x = log_eta + log_rate - log_scale
    value, by_x = fluidity_along(log_x, law)
    value -= log_eta
    value_eta, value_h, value_p = by_x - 1.0, -by_x, -by_x * scale_p
    if law.smooth:
        limit = law.ambient + law.slope * max(p, 0.0)
        log_free, curve = flow_curve(log_x, law)
        ratio = math.exp(min(log_free + log_scale - math.log(limit), 5.0))
        if ratio > 1e-12:
            # what the limit adds to the free fluidity, a factor exp(ratio) - 1, held at the bound
            growth = ratio / -math.expm1(-ratio)  # d ln(exp(ratio) - 1)/d ln ratio
            ratio_p = scale_p * (1.0 - curve) - (law.slope / limit if p > 0.0 else 0.0)
            log_bound = math.log(law.plug) + log_rate - log_h
            added = value + ratio + math.log(-math.expm1(-ratio))
            excess = added - log_bound
            held = 1.0 / (1.0 + math.exp(-excess))  # 1 where the bound rules
            added -= math.log1p(math.exp(excess)) if excess < 30.0 else excess
            share = 1.0 / (1.0 + math.exp(value - added))  # of what is added in the whole
            value += math.log1p(math.exp(added - value)) if added - value < 30.0 else added - value
            value_eta += share * ((1.0 - held) * (value_eta + growth * curve) - value_eta)
            value_h += share * ((1.0 - held) * (value_h - growth * curve) - 2.0 * held - value_h)
            value_p += share * ((1.0 - held) * (value_p + growth * ratio_p) - value_p)
    if along == 1.0:
        return value, value_eta, value_h, value_p
    top = max(value, across)
    first = along * math.exp(value - top)
    second = (1.0 - along) * math.exp(across - top)
    total = first + second
    first /= total
    second /= total
    return (
        top + math.log(total),
        first * value_eta + second * across_eta,
        first * value_h + second * across_h,
        first * value_p + second * across_p,
    )


@kernel(**KERNEL)
def stress_after(upstream, final, scale, gain):
    """Stress after a piece of way on which a rigid law would add ``gain``, exactly for constant coefficients.

    d tau/ds = gain (1 - sinh(tau/scale)/sinh(final/scale)), s from 0 to 1: with y = exp(tau/scale) a Riccati equation.
    ``scale`` infinite is the Newtonian film: tau relaxes towards ``final`` exponentially.
    """
    if not final > 0.0:
        return 0.0
    end = final / scale
    if end < 1e-4:
        return final + (upstream - final) * math.exp(-gain / final)
    if end > STIFF:
        return min(upstream + gain, final)
    decay = gain / (scale * math.tanh(end))
    if decay > 700.0:
        return final
    small = math.exp(-2.0 * end)
    ratio = math.exp(min((upstream - final) / scale, 700.0))  # y over its final value
    # (y - y+)/(y - y-) decays; written so that neither end cancels
    keep = math.exp(-decay)
    rest = -math.expm1(-decay) + keep * (1.0 + small) / (ratio + small)
    left = keep * (ratio - 1.0) / (ratio + small)
    return max(final + scale * (math.log1p(left * small) - math.log(rest)), 0.0)


@kernel(**KERNEL)
def march_stress(final, scale, limit, gain):
    """`stress_after` from node to node along the motion; the stress enters at zero and never exceeds its limit."""
    stress = np.zeros_like(final)
    for i in range(1, final.size):
        stress[i] = min(stress_after(stress[i - 1], final[i], scale[i], gain[i]), limit[i])
    return stress
