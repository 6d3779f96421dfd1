"""Compiled loops of the steady heat balance."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from ehl.compile._kernels import bits_of_float, factored, product, solve_factored
from ehl.compile.compiler import INTERNAL_KERNEL, KERNEL, kernel
from ehl.fluid._kernels import limited_stress
from ehl.fluid.rheology import LOG_STRESS_MAX, STRESS_FLOOR, ShearNumbers

# cells of the table of Bessel functions: so many in each doubling of r, from 2^LOWEST to 2^HIGHEST
PER_DOUBLING = 16
LOWEST, HIGHEST = -30, 30
CELL_BITS = 48  # of a double, behind exponent and number of its cell
CELL_REST, CELL_UNIT = 2**CELL_BITS - 1, 2.0 ** (1 - CELL_BITS)
FIRST_CELL = (1023 + LOWEST) * PER_DOUBLING
NO_MORE_AHEAD = 25.0  # exp(-2 r) is negligible compared with 1
EULER_GAMMA = 0.5772156649015329

# polynomials in S of `rise_share`, fitted to the closed form within 0.3 % (this work)
RISE_ABOVE, RISE_BELOW = (2.0 / 3.0, 0.16033, 0.08278, 0.02932), (1.0, 0.04341, 0.08346, 0.01466)
# polynomials in S of `along_share` and `across_share`, fitted to closed form and quadrature within 0.07 % up to S = 300
# (this work); slopes at 0 and limits are exact
ALONG_ABOVE, ALONG_BELOW = (1.0, 0.12415, 0.061645, 0.04057), (1.0, 0.2574833, 0.13389, 0.0393, 0.0270467)
ACROSS_ABOVE, ACROSS_BELOW = (1.0, 0.28137, -0.02415, 0.05596), (1.0, 0.5480367, 0.13343, 0.14579, -0.0108, 0.0226794)
# rise at mid-film by the heat q of the pressure-driven flow over q h/(8 k), and its mean, over that at mid-film
MID_FILM_BY_FLOW, MEAN_BY_FLOW = 0.5, 0.8
# of `flow_heat_share`: slope and curvature at zero, and the heat at which the parabola turns
FLOW_SLOPE, FLOW_BEND = -8.0 / 35.0, 0.1336
FLOW_TURN = -0.5 * FLOW_SLOPE / FLOW_BEND
VISCOSITY_POLE = 150.0  # K: temperature at which most laws would have a pole of ln(eta)
LOG_STRESS_MIN = -300.0
MOST_LOSS = 0.2  # per kelvin, of the slope of ln(eta) in temperature
KEPT_MATRIX = 0.25  # a residual below this share of the one before: the matrix serves once more
HALVINGS = 12
FIRST_MODE = 96.0 / math.pi**4  # share of cos(pi y/h) in the mean rise of a film by even heat


@njit(**INTERNAL_KERNEL)
def rise_share(heat):
    """Rise of the temperature at which the film has its effective viscosity, over that of mid-film under even heat.

    Energy equation across a film of one shear stress, with a viscosity that falls as exp(-beta T): for the even rise
    r = q h/(8 k) at mid-film, ``heat`` S = beta r = a tanh a, the share is ln(sinh 2a/(2a))/S. It is 2/3, the mean of
    the parabola, for little heat, and 2 for much heat, which is freed at mid-film.
    """
    (a, b, c, d), (e, f, g, k) = RISE_ABOVE, RISE_BELOW
    s = max(heat, 0.0)
    return (a + s * (b + s * (c + s * d))) / (e + s * (f + s * (g + s * k)))


@njit(**INTERNAL_KERNEL)
def along_share(heat):
    """Share A of the mobility along the sliding, (3/(2 S)) (1 - 2a/sinh 2a), with S as in `rise_share`.

    The heat of the shear changes the mobility of the film. With m and m' the mobilities along and across the sliding
    at the film temperature, they are A m + (A - B) m' and B m', B of `across_share`. Across the sliding the flow sees
    the fluidity with the weight 12 (y/h)^2, and the film is colder near the walls (Dowson 1962). Along the sliding the
    pressure gradient also moves the heat towards the wall with the larger stress. This odd part of the temperature
    cancels the former for a Newtonian film and little heat: 2A - B = 1 + O(S^2) (this work).
    """
    (a, b, c, d), (e, f, g, k, m) = ALONG_ABOVE, ALONG_BELOW
    s = max(heat, 0.0)
    return (a + s * (b + s * (c + s * d))) / (e + s * (f + s * (g + s * (k + s * m))))


@njit(**INTERNAL_KERNEL)
def across_share(heat):
    """Share B of the mobility across the sliding: mean of 12 (y/h)^2 with the weight 1/eta(y), see `along_share`.

    It is 1 - 4 S/15 for little heat, as the flow sees 2/5 and the shear 2/3 of the rise at mid-film.
    """
    (a, b, c, d), (e, f, g, k, m, n) = ACROSS_ABOVE, ACROSS_BELOW
    s = max(heat, 0.0)
    return (a + s * (b + s * (c + s * d))) / (e + s * (f + s * (g + s * (k + s * (m + s * n)))))


@njit(**INTERNAL_KERNEL)
def flow_heat_share(heat):
    """ln of the share of both mobilities by the heat of the pressure-driven flow; ``heat`` R = beta q h/(16 k).

    The heat grows as y^2 from mid-film, so the rise is a quartic: its mean is 4/5 of q h/(16 k), and with the weight
    12 (y/h)^2 of the flow it is 4/7. The film temperature contains the former. The term in R^2 is that of an
    exponential viscosity, whose heat moves towards mid-film (this work; within 0.005 up to R = 0.5).
    """
    r = min(heat, FLOW_TURN)
    return r * (FLOW_SLOPE + FLOW_BEND * r)


@njit(**INTERNAL_KERNEL)
def _scaled_bessel(r, table):
    """exp(r) K0(r) and r exp(r) K1(r)."""
    # the bits of a double begin with its exponent; the next four say in which sixteenth of its doubling it lies
    bits = bits_of_float(r)
    cell = (bits >> CELL_BITS) - FIRST_CELL
    if cell < 0:
        return (1.0 + r) * (-math.log(0.5 * r) - EULER_GAMMA), 1.0 + r
    if cell >= table.shape[0]:
        root = math.sqrt(0.5 * math.pi / r)
        return root * (1.0 - 0.125 / r), root * (r + 0.375)
    t = (bits & CELL_REST) * CELL_UNIT - 1.0
    row = table[cell]
    k0, k1 = row[0, 0], row[0, 1]
    for power in range(1, row.shape[0]):
        k0 = k0 * t + row[power, 0]
        k1 = k1 * t + row[power, 1]
    return k0, k1


@kernel(**KERNEL)
def moving_kernel(place, table):
    """Jaeger's kernel exp(z) K0(|z|) times the hat functions of the nodes, integrated; z = place_i - place_j.

    From the integrals from 0 to z of exp(t) K0(|t|) and of t exp(t) K0(|t|), which have closed forms.
    """
    n = place.size
    zeroth = np.zeros((n, n))
    first = np.zeros((n, n))
    for i in range(1, n):
        for j in range(i):
            r = place[i] - place[j]
            k0, rk1 = _scaled_bessel(r, table)
            rk0 = r * k0
            # behind the source exp(z) K is exp(r) K, ahead of it exp(-2 r) exp(r) K
            zeroth[i, j] = rk0 + rk1 - 1.0
            first[i, j] = (r * (rk0 + rk1) - rk1 + 1.0) / 3.0
            decay = math.exp(-2.0 * r) if r < NO_MORE_AHEAD else 0.0
            zeroth[j, i] = -(decay * (rk0 - rk1) + 1.0)
            first[j, i] = (decay * (r * (rk0 - rk1) - rk1) + 1.0) / 3.0
    share = np.empty(n - 1)
    for j in range(n - 1):
        share[j] = 1.0 / (place[j + 1] - place[j])
    matrix = np.zeros((n, n))
    for i in range(n):
        for j in range(n - 1):
            i0 = zeroth[i, j] - zeroth[i, j + 1]
            i1 = first[i, j] - first[i, j + 1]
            matrix[i, j] += (i1 - (place[i] - place[j + 1]) * i0) * share[j]
            matrix[i, j + 1] = ((place[i] - place[j]) * i0 - i1) * share[j]
    return matrix


@njit(**INTERNAL_KERNEL)
def _slope(x, y, out):
    """dy/dx on uneven nodes, second order, at the ends too."""
    n = x.size
    for i in range(1, n - 1):
        a = x[i] - x[i - 1]
        b = x[i + 1] - x[i]
        out[i] = (a * a * (y[i + 1] - y[i]) + b * b * (y[i] - y[i - 1])) / (a * b * (a + b))
    a, b = x[1] - x[0], x[2] - x[1]
    out[0] = -(2.0 * a + b) / (a * (a + b)) * y[0] + (a + b) / (a * b) * y[1] - a / (b * (a + b)) * y[2]
    a, b = x[n - 2] - x[n - 3], x[n - 1] - x[n - 2]
    out[n - 1] = b / (a * (a + b)) * y[n - 3] - (a + b) / (a * b) * y[n - 2] + (2.0 * b + a) / (b * (a + b)) * y[n - 1]


@njit(**INTERNAL_KERNEL)
def _weights_of_cell(step, length):
    """What is kept of the heat in a film over a cell, and weights of the values at its end, its begin and their change.

    Exact solution of dw/dx + w/l = q for g = l q linear over the cell, r = step/l: w = exp(-r) w0 + a g + b g0 with
    a = 1 - f, b = f - exp(-r), f = (1 - exp(-r))/r; series where r is small.
    """
    r = step / length
    passed = -math.expm1(-r)
    mean = passed / r if r > 1e-300 else 1.0
    if r < 1e-3:
        return 1.0 - passed, r * (0.5 - r * (1.0 / 6.0 - r / 24.0)), r * (0.5 - r * (1.0 / 3.0 - r / 8.0)), mean
    return 1.0 - passed, 1.0 - mean, mean - (1.0 - passed), mean


@kernel(**KERNEL)
def flow_heat(x, pressure, film, density, length, speed):
    """Heat of the pressure-driven flow where it reaches the walls: the film convects it while it conducts.

    d(l Q)/dx = q - Q with ``length`` l = C h/(12 k), C = rho c u_r h*. The gradient in the inlet is taken from ln p
    over ln|x|, since the pressure there nears a power of x on a coarse mesh. What is left at the exit goes with the
    oil.
    """
    n = x.size
    slope = np.empty(n)
    _slope(x, pressure, slope)
    top = 0.0
    for i in range(n):
        top = max(top, pressure[i])
    count = 0
    inlet = np.empty(n, np.int64)
    highest = 0.0
    for i in range(n):
        highest = max(highest, pressure[i])
        if not (x[i] < 0.0 and highest < 0.1 * top):
            break
        if pressure[i] > 0.0:
            inlet[count] = i
            count += 1
    if count > 3:
        distance = np.empty(count)
        log_pressure = np.empty(count)
        power = np.empty(count)
        for k in range(count):
            distance[k] = math.log(-x[inlet[k]])
            log_pressure[k] = math.log(pressure[inlet[k]])
        _slope(distance, log_pressure, power)
        for k in range(count):
            slope[inlet[k]] = pressure[inlet[k]] / x[inlet[k]] * power[k]
    heat = np.zeros(n)
    stored, last = 0.0, 0.0
    for i in range(n):
        # the flow of this very mesh (density 1 at the exit): in the contact h - h* is a small difference
        steady = length[i] * max(speed * (film[i] - film[n - 1] / density[i]) * slope[i], 0.0)
        if i > 0:
            left, here, before, _ = _weights_of_cell(x[i] - x[i - 1], 0.5 * (length[i] + length[i - 1]))
            stored = left * stored + here * steady + before * last
        last = steady
        heat[i] = stored / length[i] if pressure[i] > 0.0 else 0.0
    return heat


class Walls(NamedTuple):
    """Both surfaces: conduction in them, and through the film that parts them."""

    matrix_1: np.ndarray
    matrix_2: np.ndarray
    factors: np.ndarray  # of I + k/h (A1 + A2), transposed
    pivots: np.ndarray
    conductance: np.ndarray  # k/h
    mean: float  # of both bulk temperatures
    difference: float  # bulk temperature of body 2 less that of body 1


@kernel(**KERNEL)
def conduct(matrix_1, matrix_2, conductance, factors, pivots, weights):
    """Fill factors and pivots of `Walls`, and the weights w of `heat_balance`.

    The mean surface temperature rises by about w_i (A1 + A2)_ij per heat, exactly for bodies whose rises have a
    constant ratio.
    """
    first, second = 0.0, 0.0
    for i in range(conductance.size):
        row, one, other = factors[i], 0.0, 0.0
        for j in range(conductance.size):
            row[j] = conductance[i] * (matrix_1[i, j] + matrix_2[i, j])
            one += matrix_1[i, j]
            other += matrix_2[i, j]
        row[i] += 1.0
        weights[i] = conductance[i] * (one + other)
        first += one
        second += other
    share = (first - second) / (first + second)
    for i in range(conductance.size):
        weights[i] = 0.25 * (1.0 - share * share * weights[i] / (1.0 + weights[i]))
    factored(factors, pivots)


# of a film at its nodes: ln(|v_s|/h), derivative of the film's rise by its heat, heat that is not of shear and what it
# adds to the film temperature (surfaces apart); surface temperature, heat times that derivative and film temperature at
# which ln(eta), its slope in temperature and the relative fall of this slope per kelvin are known, and by how much the
# film temperature follows a change of the first two as that slope changes
PRESSURE, LOG_RATE, RESISTANCE, SOURCE, RAISED, WALL, TANGENT, TEMPERATURE = range(8)
LOG_ETA, BY_TEMPERATURE, LOSS, FOLLOWED = range(8, 12)
# of the convection of heat along the nodes: see `fill_convection`
KEPT, HERE, BEFORE, LAGGED, ROWS = range(12, 17)


class Film(NamedTuple):
    """A film at given pressure, with ln(eta) near some temperatures."""

    nodes: np.ndarray  # rows as named above
    speed: float
    law: ShearNumbers
    ambient: float  # limit that cuts the stress off: ambient + slope p; infinite slope for none
    slope: float
    rise: tuple[tuple[float, ...], ...]  # polynomials of `effective_rise`


@kernel(**KERNEL)
def fill_convection(nodes, x, length, wall, capacity):
    """Rows of `conducted` for a film that convects its heat.

    Conduction across the film in modes cos((2 n + 1) pi y/h). The first decays over C h/(pi^2 k) and has the share
    `FIRST_MODE` of the mean rise by even heat; the others follow at once. ``length`` is C h/(12 k),
    ``wall`` the mean surface temperature: the film lags behind its change.
    """
    nodes[KEPT, 0], nodes[HERE, 0], nodes[BEFORE, 0], nodes[LAGGED, 0] = 0.0, FIRST_MODE, 0.0, 0.0
    for i in range(1, x.size):
        middle, slimmer = 6.0 / math.pi**2 * (length[i] + length[i - 1]), length[i - 1] / length[i]
        left, here, before, change = _weights_of_cell(x[i] - x[i - 1], middle)
        nodes[KEPT, i], nodes[HERE, i] = left * slimmer, FIRST_MODE * here
        nodes[BEFORE, i] = FIRST_MODE * slimmer * before
        cooled = FIRST_MODE * math.pi**2 / 12.0 * capacity / length[i] * change * (wall[i] - wall[i - 1])
        nodes[LAGGED, i] = nodes[KEPT, i] * nodes[LAGGED, i - 1] - cooled


@kernel(**KERNEL)
def conducted(film, freed, heat):
    """Fill ``heat``, whose local conduction gives the film the mean rise of the convected heat ``freed``."""
    nodes, carried, before = film.nodes, 0.0, 0.0
    for i in range(freed.size):
        carried = nodes[KEPT, i] * carried + nodes[HERE, i] * freed[i] + nodes[BEFORE, i] * before
        before = freed[i]
        heat[i] = carried + (1.0 - FIRST_MODE) * freed[i] + nodes[LAGGED, i]


@njit(**INTERNAL_KERNEL)
def add_convection(film, i, response, heat, factor, row):
    """Add to a row the derivatives by ln(tau) of ``factor`` times the `conducted` heat of node i.

    ``response`` holds those of the first mode at the node before, and is moved to this one.
    """
    nodes = film.nodes
    for j in range(i):
        response[j] *= nodes[KEPT, i]
    if i > 0:
        response[i - 1] += nodes[BEFORE, i]
    response[i] = nodes[HERE, i]
    for j in range(i + 1):
        row[j] += factor * response[j] * heat[j]
    row[i] += factor * (1.0 - FIRST_MODE) * heat[i]


@kernel(**KERNEL)
def effective_rise(heat, polynomials):
    """`rise_share` of S = beta r, and the derivative of its product with the rise r by r."""
    (a, b, c, d), (e, f, g, k) = polynomials
    s = max(heat, 0.0)
    below = e + s * (f + s * (g + s * k))
    share = (a + s * (b + s * (c + s * d))) / below
    by_above, by_below = b + s * (2.0 * c + s * (3.0 * d)), f + s * (2.0 * g + s * (3.0 * k))
    return share, share + s * (by_above - share * by_below) / below


@njit(**INTERNAL_KERNEL)
def warmed(film, resistance, wall, even):
    """Film temperature at a surface temperature and an even rise: one step of Newton's method.

    The even rise is r = q h/(8 k) with the ``resistance`` h/(8 k). ln(eta) at the new temperature is still to be found.
    """
    nodes = film.nodes
    for i in range(wall.size):
        share, growth = effective_rise(-nodes[BY_TEMPERATURE, i] * even[i], film.rise)
        followed = 1.0 / (1.0 + even[i] * (growth - share) * nodes[LOSS, i])
        nodes[TEMPERATURE, i] += followed * (wall[i] + even[i] * share - nodes[TEMPERATURE, i])
        nodes[FOLLOWED, i], nodes[WALL, i] = followed, wall[i]
        nodes[RESISTANCE, i], nodes[TANGENT, i] = growth * resistance[i], growth * even[i]


@kernel(**KERNEL)
def modulus_viscosity(nodes, log_inlet, numbers):
    """ln(eta), slope and its fall at the film temperature by the numbers of `ehl.fluid.viscosity.ModulusLaw`."""
    a1, a2, b1, b2, inlet = numbers[0], numbers[1], numbers[2], numbers[3], numbers[4]
    rise, shift, beta, last, kelvin = numbers[5], numbers[6], numbers[7], numbers[8], numbers[9]
    for i in range(nodes.shape[1]):
        p, first = nodes[PRESSURE, i], 0.0
        for ahead in range(2):
            temperature = nodes[TEMPERATURE, i] + ahead
            celsius = temperature - kelvin
            low, stiffening = a1 + a2 * celsius, b1 + b2 * celsius
            inside = min(p, last * low / max(-stiffening, 1e-30))
            modulus = low + stiffening * inside
            slope = low / (modulus * modulus)
            grown = inside / modulus + slope * (p - inside)
            vogel = celsius + shift
            if p > inside:
                bent = min(stiffening, -1e-30)
                fall = slope * p * (b2 / bent - a2 / low) - grown * b2 / bent
            else:
                fall = -inside * (a2 + b2 * inside) / (modulus * modulus)
            decay = rise / (vogel * vogel) + beta - fall
            if ahead == 0:
                first = decay
                thinning = rise / vogel - rise / (inlet - kelvin + shift) - beta * (temperature - inlet)
                nodes[LOG_ETA, i], nodes[BY_TEMPERATURE, i] = log_inlet + (grown + thinning), -decay
            else:
                nodes[LOSS, i] = min(max(1.0 - decay / first, 0.0), MOST_LOSS) if first > 0.0 else 0.0


@njit(**INTERNAL_KERNEL)
def wall_temperature(walls, heat, into_1, work, out):
    """Mean surface temperature under a heat that both surfaces share, and the part of the heat that body 1 takes.

    With heat freed evenly across the film q1 = q/2 + k/h (T2 - T1), T1 = A1 q1 and T2 = A2 (q - q1) above the bulk.
    """
    product(walls.matrix_2, heat, out)
    for i in range(heat.size):
        into_1[i] = 0.5 * heat[i] + walls.conductance[i] * (walls.difference + out[i])
    solve_factored(walls.factors, walls.pivots, into_1)
    for i in range(heat.size):
        work[i] = heat[i] - into_1[i]
    product(walls.matrix_2, work, out)
    product(walls.matrix_1, into_1, work)
    for i in range(heat.size):
        out[i] = walls.mean + 0.5 * (work[i] + out[i])


@kernel(**KERNEL)
def divided(walls, heat):
    """Heat into body 1 and both surface temperatures above those of the bodies, as in `wall_temperature`."""
    found = np.empty((4, heat.size))
    into_1, rise_1, rise_2, work = found[0], found[1], found[2], found[3]
    wall_temperature(walls, heat, into_1, work, rise_2)
    for i in range(heat.size):
        work[i] = heat[i] - into_1[i]
    product(walls.matrix_1, into_1, rise_1)
    product(walls.matrix_2, work, rise_2)
    return into_1, rise_1, rise_2


@njit(**INTERNAL_KERNEL)
def film_stress(film, i, temperature_change):
    """ln(tau), its derivative by the temperature, and ln(eta) at a node.

    ln(eta) is taken along a hyperbola with the slope known and its pole at `VISCOSITY_POLE`.
    """
    nodes = film.nodes
    reach = max(nodes[TEMPERATURE, i] - VISCOSITY_POLE, 50.0)
    held = max(temperature_change, -0.5 * reach)
    shrink = reach / (reach + held)
    slope = nodes[BY_TEMPERATURE, i] * shrink * shrink
    log_eta = nodes[LOG_ETA, i] + nodes[BY_TEMPERATURE, i] * held * shrink + slope * (temperature_change - held)
    log_stress, growth, _ = limited_stress(log_eta + nodes[LOG_RATE, i], nodes[PRESSURE, i], film.law)
    log_stress = min(log_stress, LOG_STRESS_MAX)
    if math.isfinite(film.slope):
        limit = math.log(max(film.ambient + film.slope * nodes[PRESSURE, i], STRESS_FLOOR))
        if log_stress > limit:
            log_stress, growth = limit, 0.0
    return max(log_stress, LOG_STRESS_MIN), slope * growth, log_eta


@kernel(**KERNEL)
def stresses(film):
    """Shear stress of a film at its temperatures, zero without pressure or speed."""
    found = np.zeros(film.nodes.shape[1])
    for i in range(found.size):
        if film.nodes[PRESSURE, i] > 0.0 and film.speed > 0.0:
            found[i] = math.exp(film_stress(film, i, 0.0)[0])
    return found


@njit(**INTERNAL_KERNEL)
def heat_balance(
    walls, film, weights, surface, log_stress, tolerance, most, wall, log_eta, into_1, matrix, pivots, rows
):
    """Newton's method for ln(tau) = ln(tau(p, h, T(tau))) on all nodes under pressure.

    ``surface`` is the rise of the mean surface temperature per heat, for the matrix alone; where it is empty, that of
    `conduct` with its ``weights``. A matrix that shortens the residual to a quarter is kept. ``log_stress`` is where it
    starts and ends; surface temperature, ln(eta) and heat into body 1 are left in ``wall``, ``log_eta`` and ``into_1``;
    the last three are work. Returns whether the residual is below the tolerance, and the number of matrices.
    """
    n, nodes = log_stress.size, film.nodes
    trial, stress, heat, work, value = rows[0], rows[1], rows[2], rows[3], rows[4]
    slope, step, new_value, new_slope, sheared = rows[5], rows[6], rows[7], rows[8], rows[9]
    for i in range(n):
        # the value and slope of nodes without pressure are never written
        trial[i], new_slope[i] = log_stress[i], 0.0
    length, norm, matrices, halvings = 1.0, math.inf, 0, 0
    kept = False
    # one place for each long function: put in at several, they would take twice as long to compile
    while True:
        for i in range(n):
            stress[i] = film.speed * math.exp(trial[i]) if nodes[PRESSURE, i] > 0.0 else 0.0
        conducted(film, stress, sheared)
        for i in range(n):
            heat[i] = sheared[i] + nodes[SOURCE, i]
        wall_temperature(walls, heat, into_1, work, wall)
        new_norm = 0.0
        for i in range(n):
            wall[i] += nodes[RAISED, i]
            new_value[i] = 0.0
            if nodes[PRESSURE, i] > 0.0:
                rise = nodes[RESISTANCE, i] * sheared[i]
                change = wall[i] - nodes[WALL, i] + (rise - nodes[TANGENT, i])
                law, new_slope[i], log_eta[i] = film_stress(film, i, nodes[FOLLOWED, i] * change)
                new_slope[i] *= nodes[FOLLOWED, i]
                new_value[i] = trial[i] - law
                # not finite counts as infinite
                size = abs(new_value[i])
                new_norm = max(new_norm, size) if size < math.inf else math.inf
        good = new_norm < (1.0 - 0.1 * length) * norm or new_norm < 0.1 * tolerance or matrices == 0
        if not good and kept:
            pass  # a fresh matrix where the last one came from
        elif not good and halvings < HALVINGS:
            halvings += 1
            length *= 0.5
            for i in range(n):
                trial[i] = log_stress[i] + length * step[i]
            continue
        else:
            kept = new_norm < KEPT_MATRIX * norm and length == 1.0 and matrices > 0
            norm = new_norm
            for i in range(n):
                log_stress[i], value[i], slope[i] = trial[i], new_value[i], new_slope[i]
            if norm < 0.1 * tolerance:
                return True, matrices
            if not norm < math.inf:
                return False, matrices
        kept = kept and good
        if not kept:
            if matrices == most:
                return False, matrices
            matrices += 1
            for i in range(n):
                heat[i], work[i] = film.speed * math.exp(log_stress[i]), 0.0
            for i in range(n):
                row, by_heat = matrix[i], -slope[i] * weights[i]
                if surface.size > 0:
                    for j in range(n):
                        row[j] = -slope[i] * surface[i, j] * heat[j]
                else:
                    for j in range(n):
                        row[j] = by_heat * (walls.matrix_1[i, j] + walls.matrix_2[i, j]) * heat[j]
                add_convection(film, i, work, heat, -slope[i] * nodes[RESISTANCE, i], row)
                row[i] += 1.0
            if not factored(matrix, pivots):
                return False, matrices
        largest = 0.0
        for i in range(n):
            step[i] = -value[i]
        solve_factored(matrix, pivots, step)
        for i in range(n):
            largest = max(largest, abs(step[i]))
        length, halvings = min(1.0, 3.0 / max(largest, 1e-300)), 0
        for i in range(n):
            trial[i] = log_stress[i] + length * step[i]


# rows of the work of `balanced`; the first stress is in that of the even rise
LOG_STRESS, FIRST_LOG_STRESS, EVEN, SURFACE, NEW_EVEN, NEW_SURFACE, NEW_LOG_ETA, INTO_1, WORK_ROWS = range(9)
# where it continues, and what it waits for when it returns: ln(eta) at the first temperature, at that of a linear law,
# and at that of its solution; a matrix with the exact conduction; nothing, in balance or not
BEGUN, FIRST, LINEAR, SOLVED, EXACT, BALANCED, FAILED = range(7)
MOST_RISE = 500.0  # K, by the stress of an isothermal initial guess, which may be arbitrarily large
PATIENCE = 10  # matrices with the approximate conduction before the exact one is used


@njit(**INTERNAL_KERNEL)
def even_rise(film, resistance, log_stress, work, rise):
    """Rise q h/(8 k) of mid-film by the conducted heat of a stress."""
    for i in range(resistance.size):
        work[i] = film.speed * math.exp(log_stress[i]) if film.nodes[PRESSURE, i] > 0.0 else 0.0
    conducted(film, work, rise)
    for i in range(resistance.size):
        rise[i] *= resistance[i]


@njit(**INTERNAL_KERNEL)
def prepare(walls, film, weights, resistance, work):
    """First ln(tau) and temperature of a film from a bounded stress; no heat where there is no pressure."""
    nodes = film.nodes
    for i in range(resistance.size):
        nodes[SOURCE, i] = nodes[SOURCE, i] if nodes[PRESSURE, i] > 0.0 else 0.0
        nodes[RAISED, i] = MEAN_BY_FLOW * MID_FILM_BY_FLOW * resistance[i] * nodes[SOURCE, i]
        alone = weights[i] * (walls.matrix_1[i, i] + walls.matrix_2[i, i]) + resistance[i]
        bounded = min(work[EVEN, i], MOST_RISE / max(film.speed * alone, 1e-300))
        work[FIRST_LOG_STRESS, i] = math.log(max(bounded, 1e-130))
        work[LOG_STRESS, i] = work[FIRST_LOG_STRESS, i]
    even_rise(film, resistance, work[LOG_STRESS], work[INTO_1], work[EVEN])
    for i in range(resistance.size):
        nodes[TEMPERATURE, i] = work[SURFACE, i] + work[EVEN, i]


@kernel(**KERNEL)
def balanced(walls, film, weights, exact, resistance, numbers, log_inlet, tolerance, most, work, progress):
    """Heat balance with the law of the oil: `heat_balance` with ln(eta) linearised at one temperature after another.

    ``numbers`` of `modulus_viscosity`; for any other law they are empty, and the caller fills in what is returned.
    ``exact`` is the rise of the mean surface temperature per heat, or empty. ``progress`` holds where this continues,
    iterations and the last error of the linear law.
    """
    nodes, n = film.nodes, resistance.size
    even, wall, new_wall = work[EVEN], work[SURFACE], work[NEW_SURFACE]
    matrix, pivots, rows = np.empty((n, n)), np.empty(n, np.int32), np.zeros((10, n))
    while True:
        stage = int(progress[0])
        if stage == BEGUN:
            prepare(walls, film, weights, resistance, work)
            progress[0] = FIRST
        elif stage == FIRST:
            warmed(film, resistance, wall, even)
            progress[0] = LINEAR
        elif stage == LINEAR:
            left = int(most - progress[1])
            if left <= 0:
                return FAILED
            done, matrices = heat_balance(
                walls, film, weights, exact, work[LOG_STRESS], tolerance,
                left if exact.size > 0 else min(left, PATIENCE), new_wall, work[NEW_LOG_ETA], work[INTO_1],
                matrix, pivots, rows,
            )  # fmt: skip
            progress[1] += max(matrices, 1)
            if not done:
                for i in range(n):
                    work[LOG_STRESS, i] = work[FIRST_LOG_STRESS, i]
                return FAILED if exact.size > 0 else EXACT
            even_rise(film, resistance, work[LOG_STRESS], work[INTO_1], work[NEW_EVEN])
            warmed(film, resistance, new_wall, work[NEW_EVEN])
            progress[0] = SOLVED
        else:
            missed = 0.0
            for i in range(n):
                if nodes[PRESSURE, i] > 0.0:
                    miss = abs(nodes[LOG_ETA, i] - work[NEW_LOG_ETA, i])
                    missed = max(missed, miss) if miss < math.inf else math.inf
            share = 1.0 if missed < tolerance or missed < 0.9 * progress[2] else 0.5
            progress[0], progress[2] = LINEAR, missed
            for i in range(n):
                wall[i] += share * (new_wall[i] - wall[i])
                even[i] += share * (work[NEW_EVEN, i] - even[i])
            if missed < tolerance:
                return BALANCED
            if share == 1.0:
                continue
            warmed(film, resistance, wall, even)
        if numbers.size == 0:
            return stage
        modulus_viscosity(nodes, log_inlet, numbers)
