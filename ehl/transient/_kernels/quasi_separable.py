"""Exact O(N) solution of the Newton system.

Each node carries up to two unknowns, the increments of fluid pressure f and contact pressure c, and as many rows:

    row f:  left f_{i-1} + centre f_i + right f_{i+1} + a h_{i-1} + b h_i + c h_{i+1}
    row c:  h_i
    with h = K (f + c),  K_d = sum_m w_m phi_m^d

Below the diagonal the matrix is a product of generators (two-sided: row generator, powers of phi, column generator),
and so it is above.  Block elimination keeps that structure: all earlier nodes act on the next one through one small
matrix ``schur`` (modes x modes) and through the fluid pressure of the direct neighbour (the tridiagonal part).  One
sweep factors and reduces two right-hand sides, one sweep back substitutes.  Nothing is neglected.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ehl.transient._kernels.elasticity import FLAGS, INTERNAL

FLUID = 1
CONTACT = 2
MODES = 4  # of the Jacobian; a compile-time constant so that the inner loops unroll


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def factor_and_solve(first, last, kind, band, weights, ratios, rhs_f, rhs_c, unit_f, sol, work):
    """Solve for nodes first .. last-1, with the right-hand sides (rhs_f, rhs_c) and (unit_f, 1).

    Parameters
    ----------
    kind : int64 array
        Bit FLUID: row and unknown f are present; bit CONTACT: row and unknown c are present.
    band : float64 array (6, n)
        left, centre, right, a, b, c of the rows f.
    sol : float64 array (4, n)
        Out: f and c of the first right-hand side, then of the second; entries of absent unknowns are stale.
    work : float64 array (n, 4 + 2 MODES)
        Scratch: the inverted diagonal block and the right generators of each node.
    """
    left, centre, right, ca, cb, cc = band[0], band[1], band[2], band[3], band[4], band[5]
    sum0 = 0.0
    sum1 = 0.0
    for m in range(MODES):
        sum0 += weights[m]
        sum1 += weights[m] * ratios[m]
    schur = np.zeros((MODES, MODES))
    state = np.zeros((2, MODES))  # earlier solution parts seen through the modes, both right-hand sides
    row = np.zeros(MODES)
    row_c = np.zeros(MODES)
    elim = np.zeros(MODES)
    elim_c = np.zeros(MODES)
    from_left = np.zeros(MODES)  # what the neighbour's fluid unknown adds to the modes' columns
    to_right = np.zeros(MODES)  # what the modes add to this node's fluid column through the neighbour
    column = np.zeros(MODES)
    cross = 0.0
    left_1 = 0.0
    left_2 = 0.0
    for i in range(first, last):
        k = kind[i] & 3
        if k == 0:
            for m in range(MODES):
                state[0, m] *= ratios[m]
                state[1, m] *= ratios[m]
                from_left[m] = 0.0
                to_right[m] = 0.0
                for j in range(MODES):
                    schur[m, j] *= ratios[m] * ratios[j]
            cross = left_1 = left_2 = 0.0
            continue
        if k == FLUID:
            al, be, ga, tl, tu = ca[i], cb[i], cc[i], left[i], right[i]
            y1 = rhs_f[i] - tl * left_1
            y2 = unit_f[i] - tl * left_2
            own = centre[i] + (al + ga) * sum1 + be * sum0 - tl * cross
            for m in range(MODES):
                r = weights[m] * (al + ratios[m] * (be + ratios[m] * ga))
                row[m] = r
                elim[m] = tl * from_left[m]
                y1 -= r * state[0, m]
                y2 -= r * state[1, m]
                own -= r * to_right[m]
            for m in range(MODES):
                r = row[m]
                acc = to_right[m]
                for j in range(MODES):
                    p = schur[m, j]
                    elim[j] += r * p
                    acc += p
                column[m] = acc
            for m in range(MODES):
                own -= elim[m]
            inv = 1.0 / own
            work[i, 0] = inv
            sol[0, i] = y1
            sol[2, i] = y2
            for m in range(MODES):
                ph = ratios[m]
                b = (1.0 - ph * column[m]) * inv
                g = weights[m] * (ga + ph * (be + ph * al)) - elim[m] * ph
                column[m] = b
                work[i, 4 + m] = g
                to_right[m] = b * tu
                from_left[m] = inv * g
                state[0, m] = ph * state[0, m] + b * y1
                state[1, m] = ph * state[1, m] + b * y2
            for m in range(MODES):
                b = column[m]
                ph = ratios[m]
                for j in range(MODES):
                    schur[m, j] = ph * ratios[j] * schur[m, j] + b * work[i, 4 + j]
            cross = inv * tu
            left_1 = inv * y1
            left_2 = inv * y2
            continue
        # a node in contact: 2 x 2 block, its fluid row and column blanked if the node is dry
        wet = 1.0 if k & FLUID else 0.0
        al, be, ga, tl, tu = wet * ca[i], wet * cb[i], wet * cc[i], wet * left[i], wet * right[i]
        kappa = (al + ga) * sum1 + be * sum0
        y1 = wet * rhs_f[i] - tl * left_1
        y2 = wet * unit_f[i] - tl * left_2
        v1 = rhs_c[i]
        v2 = 1.0
        u00 = (centre[i] if wet > 0.0 else 1.0) + wet * kappa - tl * cross
        u01 = kappa
        u10 = wet * sum0
        u11 = sum0
        for m in range(MODES):
            row[m] = weights[m] * (al + ratios[m] * (be + ratios[m] * ga))
            row_c[m] = weights[m] * ratios[m]
            elim[m] = tl * from_left[m]
            elim_c[m] = 0.0
            y1 -= row[m] * state[0, m]
            y2 -= row[m] * state[1, m]
            v1 -= row_c[m] * state[0, m]
            v2 -= row_c[m] * state[1, m]
            u00 -= row[m] * to_right[m]
            u10 -= wet * row_c[m] * to_right[m]
        for m in range(MODES):
            acc = 0.0
            for j in range(MODES):
                p = schur[m, j]
                elim[j] += row[m] * p
                elim_c[j] += row_c[m] * p
                acc += p
            column[m] = acc
        for m in range(MODES):
            u00 -= wet * elim[m]
            u01 -= elim[m]
            u10 -= wet * elim_c[m]
            u11 -= elim_c[m]
        det = 1.0 / (u00 * u11 - u01 * u10)
        i00, i01, i10, i11 = u11 * det, -u01 * det, -u10 * det, u00 * det
        work[i, 0], work[i, 1], work[i, 2], work[i, 3] = i00, i01, i10, i11
        sol[0, i], sol[1, i], sol[2, i], sol[3, i] = y1, v1, y2, v2
        for m in range(MODES):
            ph = ratios[m]
            b_f = wet * (1.0 - ph * (column[m] + to_right[m]))
            b_c = 1.0 - ph * column[m]
            b0 = b_f * i00 + b_c * i10
            b1 = b_f * i01 + b_c * i11
            g0 = weights[m] * (ga + ph * (be + ph * al)) - elim[m] * ph
            g1 = weights[m] * ph - elim_c[m] * ph
            work[i, 4 + m] = g0
            work[i, 4 + MODES + m] = g1
            state[0, m] = ph * state[0, m] + b0 * y1 + b1 * v1
            state[1, m] = ph * state[1, m] + b0 * y2 + b1 * v2
            row[m] = b0
            row_c[m] = b1
            to_right[m] = b0 * tu
            from_left[m] = wet * (i00 * g0 + i01 * g1)
        for m in range(MODES):
            for j in range(MODES):
                schur[m, j] = (
                    ratios[m] * ratios[j] * schur[m, j] + row[m] * work[i, 4 + j] + row_c[m] * work[i, 4 + MODES + j]
                )
        cross = wet * i00 * tu
        left_1 = wet * (i00 * y1 + i01 * v1)
        left_2 = wet * (i00 * y2 + i01 * v2)
    back_substitute(first, last, kind, right, ratios, sol, work, state)


@njit(**INTERNAL)
def back_substitute(first, last, kind, right, ratios, sol, work, state):
    """The backward sweep: ``state`` now gathers the later unknowns."""
    for m in range(MODES):
        state[0, m] = 0.0
        state[1, m] = 0.0
    next_1 = 0.0  # fluid unknown of the right neighbour
    next_2 = 0.0
    for i in range(last - 1, first - 1, -1):
        k = kind[i] & 3
        total_1 = 0.0
        total_2 = 0.0
        if k == FLUID:
            y1 = sol[0, i] - right[i] * next_1
            y2 = sol[2, i] - right[i] * next_2
            for m in range(MODES):
                y1 -= work[i, 4 + m] * state[0, m]
                y2 -= work[i, 4 + m] * state[1, m]
            total_1 = next_1 = sol[0, i] = work[i, 0] * y1
            total_2 = next_2 = sol[2, i] = work[i, 0] * y2
        elif k == 0:
            next_1 = next_2 = 0.0
        else:
            wet = k & FLUID
            y1 = sol[0, i] - (right[i] * next_1 if wet else 0.0)
            y2 = sol[2, i] - (right[i] * next_2 if wet else 0.0)
            v1 = sol[1, i]
            v2 = sol[3, i]
            for m in range(MODES):
                y1 -= work[i, 4 + m] * state[0, m]
                y2 -= work[i, 4 + m] * state[1, m]
                v1 -= work[i, 4 + MODES + m] * state[0, m]
                v2 -= work[i, 4 + MODES + m] * state[1, m]
            sol[1, i] = work[i, 2] * y1 + work[i, 3] * v1
            sol[3, i] = work[i, 2] * y2 + work[i, 3] * v2
            total_1 = sol[1, i]
            total_2 = sol[3, i]
            next_1 = next_2 = 0.0
            if wet:
                next_1 = sol[0, i] = work[i, 0] * y1 + work[i, 1] * v1
                next_2 = sol[2, i] = work[i, 0] * y2 + work[i, 1] * v2
                total_1 += next_1
                total_2 += next_2
        for m in range(MODES):
            state[0, m] = ratios[m] * state[0, m] + total_1
            state[1, m] = ratios[m] * state[1, m] + total_2
