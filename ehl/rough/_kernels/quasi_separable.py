"""Sums of exponentials along a line of nodes: the O(N) product, and the exact O(N) solution of the Newton system.

Of the latter:

Each node carries up to two unknowns, the increments of fluid pressure f and contact pressure c, and as many rows:

    row f:  left f_{i-1} + centre f_i + right f_{i+1} + a h_{i-1} + b h_i + c h_{i+1}
    row c:  h_i
    with h = K (f + c),  K_d = sum_m w_m phi_m^d

Below the diagonal the matrix is a product of generators (two-sided: row generator, powers of phi, column generator),
and so it is above.  Block elimination keeps that structure: all earlier nodes act on the next one through one small
matrix ``schur`` (modes x modes) and through the fluid pressure of the direct neighbour (the tridiagonal part).  One
sweep factors and reduces two right-hand sides, one sweep back substitutes.  Nothing is neglected.

Each node waits for the last one. To keep that chain short, what the direct neighbour adds is kept apart from what all
earlier nodes do (``rest``): the latter is ready while the neighbour's pivot is still being inverted.
"""

from __future__ import annotations

from numba import njit

from ehl.compile.compiler import FAST_INTERNAL_KERNEL, FAST_KERNEL, kernel
from ehl.rough._kernels.vectors import four, lane, load, part, store, total, totals

FLUID = 1
CONTACT = 2
MODES = 4  # of the Jacobian: what a quad holds
BLOCK = 12  # modes of one pass, three quads


@kernel(**FAST_KERNEL)
def exponential_product(q, weights, ratios, out):
    """out_i = sum_j K_|i-j| q_j with K_d = sum_m weights_m ratios_m^d."""
    n = q.size
    for i in range(n):
        out[i] = 0.0
    for begin in range(0, weights.size, BLOCK):
        w0, w1, w2 = part(weights, begin), part(weights, begin + 4), part(weights, begin + 8)
        r0, r1, r2 = part(ratios, begin), part(ratios, begin + 4), part(ratios, begin + 8)
        s0, s1, s2 = four(0.0), four(0.0), four(0.0)
        t0, t1, t2 = s0, s1, s2
        # both sweeps in one loop: the two recursions are independent and fill each other's waiting time
        right = 0.0
        for i in range(n):
            j = n - 1 - i
            s0, s1, s2 = r0 * s0 + q[i], r1 * s1 + q[i], r2 * s2 + q[i]
            t0, t1, t2 = r0 * (t0 + right), r1 * (t1 + right), r2 * (t2 + right)
            out[i] += total(w0 * s0 + w1 * s1 + w2 * s2)
            out[j] += total(w0 * t0 + w1 * t1 + w2 * t2)
            right = q[j]


@njit(**FAST_INTERNAL_KERNEL)
def row_times(row, m0, m1, m2, m3):
    """row M for the matrix with the rows m0 .. m3."""
    return (lane(row, 0) * m0 + lane(row, 1) * m1) + (lane(row, 2) * m2 + lane(row, 3) * m3)


@kernel(**FAST_KERNEL)
def factor_and_solve(first, last, kind, band, weights, ratios, rhs_f, rhs_c, unit_f, sol, work):
    """Solve for nodes first .. last-1, with the right-hand sides (rhs_f, rhs_c) and (unit_f, 1).

    kind: bit FLUID: row and unknown f are present; bit CONTACT: row and unknown c are present.
    band (6, n): left, centre, right, a, b, c of the rows f.
    sol (4, n): out: f and c of the first right-hand side, then of the second; entries of absent unknowns are stale.
    work: scratch: the inverted diagonal block (of a fluid node alone: pivot, sum of its generator) and the right
        generators of each node.
    """
    left, centre, right, ca, cb, cc = band[0], band[1], band[2], band[3], band[4], band[5]
    w, ph = load(weights, 0), load(ratios, 0)
    near, far = w * ph, w * ph * ph
    ph_0, ph_1, ph_2, ph_3 = lane(ph, 0) * ph, lane(ph, 1) * ph, lane(ph, 2) * ph, lane(ph, 3) * ph
    sum0, sum1 = total(w), total(near)
    none = four(0.0)
    schur_0, schur_1, schur_2, schur_3 = none, none, none, none
    # earlier solution parts seen through the modes, both right-hand sides
    state_1, state_2 = none, none
    from_left = none  # what the neighbour's fluid unknown adds to the modes' columns
    to_right = none  # what the modes add to this node's fluid column through the neighbour
    cross = 0.0
    # the neighbour: its inverted pivot, what it sees of the modes, what it acts on, its reduced right-hand sides
    inv, seen, acts, y1, y2 = 1.0, none, 0.0, 0.0, 0.0
    # row sums of schur (with to_right) and states as far as they are not the neighbour's
    rest, rest_1, rest_2 = none, none, none
    for i in range(first, last):
        k = kind[i] & 3
        old_0, old_1, old_2, old_3 = ph_0 * schur_0, ph_1 * schur_1, ph_2 * schur_2, ph_3 * schur_3
        if k == FLUID:
            al, be, ga, tl, tu = ca[i], cb[i], cc[i], left[i], right[i]
            row = al * w + be * near + ga * far
            reach = inv * (tl + total(row * seen))
            column = rest + (inv * acts) * seen
            pivot = centre[i] + (al + ga) * sum1 + be * sum0 - total(row * rest) - acts * reach
            y1 = rhs_f[i] - total(row * rest_1) - y1 * reach
            y2 = unit_f[i] - total(row * rest_2) - y2 * reach
            g = (
                ga * w
                + be * near
                + al * far
                - ph * (tl * from_left + row_times(row, schur_0, schur_1, schur_2, schur_3))
            )
            sum_g = total(g)
            inv = 1.0 / pivot
            seen = 1.0 - ph * column
            acts = sum_g + tu
            b = inv * seen
            rest, rest_1, rest_2 = totals(old_0, old_1, old_2, old_3), ph * state_1, ph * state_2
            schur_0 = old_0 + lane(b, 0) * g
            schur_1 = old_1 + lane(b, 1) * g
            schur_2 = old_2 + lane(b, 2) * g
            schur_3 = old_3 + lane(b, 3) * g
            state_1 = rest_1 + y1 * b
            state_2 = rest_2 + y2 * b
            to_right = tu * b
            from_left = inv * g
            cross = inv * tu
            work[i, 0] = inv
            work[i, 1] = sum_g
            store(work[i], 4, g)
            sol[0, i] = y1
            sol[2, i] = y2
            continue
        if k == 0:
            schur_0, schur_1, schur_2, schur_3 = old_0, old_1, old_2, old_3
            state_1 = ph * state_1
            state_2 = ph * state_2
            from_left = none
            to_right = none
            cross, y1, y2 = 0.0, 0.0, 0.0
        else:
            # a node in contact: 2 x 2 block, its fluid row and column blanked if the node is dry
            wet = 1.0 if k & FLUID else 0.0
            al, be, ga, tl, tu = wet * ca[i], wet * cb[i], wet * cc[i], wet * left[i], wet * right[i]
            row = al * w + be * near + ga * far
            elim = tl * from_left + row_times(row, schur_0, schur_1, schur_2, schur_3)
            elim_c = row_times(near, schur_0, schur_1, schur_2, schur_3)
            column = totals(schur_0, schur_1, schur_2, schur_3)
            y1 = wet * rhs_f[i] - total(row * state_1) - tl * (inv * y1)
            y2 = wet * unit_f[i] - total(row * state_2) - tl * (inv * y2)
            v1 = rhs_c[i] - total(near * state_1)
            v2 = 1.0 - total(near * state_2)
            u01 = (al + ga) * sum1 + be * sum0 - total(elim)
            u11 = sum0 - total(elim_c)
            u00 = (centre[i] if wet > 0.0 else 1.0) + u01 - total(row * to_right) - tl * cross
            u10 = wet * (u11 - total(near * to_right))
            det = 1.0 / (u00 * u11 - u01 * u10)
            i00, i01, i10, i11 = u11 * det, -u01 * det, -u10 * det, u00 * det
            work[i, 0], work[i, 1], work[i, 2], work[i, 3] = i00, i01, i10, i11
            sol[0, i], sol[1, i], sol[2, i], sol[3, i] = y1, v1, y2, v2
            seen_f = wet * (1.0 - ph * (column + to_right))
            seen_c = 1.0 - ph * column
            b0 = i00 * seen_f + i10 * seen_c
            b1 = i01 * seen_f + i11 * seen_c
            g = ga * w + be * near + al * far - ph * elim
            g_c = near - ph * elim_c
            store(work[i], 4, g)
            store(work[i], 4 + MODES, g_c)
            schur_0 = old_0 + lane(b0, 0) * g + lane(b1, 0) * g_c
            schur_1 = old_1 + lane(b0, 1) * g + lane(b1, 1) * g_c
            schur_2 = old_2 + lane(b0, 2) * g + lane(b1, 2) * g_c
            schur_3 = old_3 + lane(b0, 3) * g + lane(b1, 3) * g_c
            state_1 = ph * state_1 + y1 * b0 + v1 * b1
            state_2 = ph * state_2 + y2 * b0 + v2 * b1
            to_right = tu * b0
            from_left = wet * (i00 * g + i01 * g_c)
            cross = wet * i00 * tu
            y1, y2 = wet * (i00 * y1 + i01 * v1), wet * (i00 * y2 + i01 * v2)
        # nothing kept apart for the next node but the direct coupling
        inv, seen, acts = 1.0, none, cross + total(from_left)
        rest, rest_1, rest_2 = totals(schur_0, schur_1, schur_2, schur_3) + to_right, state_1, state_2
    back_substitute(first, last, kind, right, ratios, sol, work)


@njit(**FAST_INTERNAL_KERNEL)
def back_substitute(first, last, kind, right, ratios, sol, work):
    """The backward sweep: the states now gather the later unknowns, the direct neighbour's again apart."""
    ph = load(ratios, 0)
    none = four(0.0)
    rest_1, rest_2 = none, none
    next_1, next_2 = 0.0, 0.0  # fluid unknown of the right neighbour
    both_1, both_2 = 0.0, 0.0  # with its contact unknown
    for i in range(last - 1, first - 1, -1):
        k = kind[i] & 3
        if k == FLUID:
            g = load(work[i], 4)
            inv, sum_g = work[i, 0], work[i, 1]
            pull = right[i]
            here_1 = inv * (sol[0, i] - total(g * rest_1) - sum_g * both_1 - pull * next_1)
            here_2 = inv * (sol[2, i] - total(g * rest_2) - sum_g * both_2 - pull * next_2)
            rest_1 = ph * (rest_1 + both_1)
            rest_2 = ph * (rest_2 + both_2)
            sol[0, i] = here_1
            sol[2, i] = here_2
            next_1, next_2, both_1, both_2 = here_1, here_2, here_1, here_2
            continue
        rest_1 = rest_1 + both_1
        rest_2 = rest_2 + both_2
        both_1, both_2 = 0.0, 0.0
        if k > 0:
            wet = 1.0 if k & FLUID else 0.0
            g, g_c = load(work[i], 4), load(work[i], 4 + MODES)
            y1 = sol[0, i] - total(g * rest_1) - wet * right[i] * next_1
            y2 = sol[2, i] - total(g * rest_2) - wet * right[i] * next_2
            v1 = sol[1, i] - total(g_c * rest_1)
            v2 = sol[3, i] - total(g_c * rest_2)
            sol[0, i] = wet * (work[i, 0] * y1 + work[i, 1] * v1)
            sol[2, i] = wet * (work[i, 0] * y2 + work[i, 1] * v2)
            sol[1, i] = work[i, 2] * y1 + work[i, 3] * v1
            sol[3, i] = work[i, 2] * y2 + work[i, 3] * v2
            next_1, next_2 = sol[0, i], sol[2, i]
            both_1, both_2 = sol[0, i] + sol[1, i], sol[2, i] + sol[3, i]
        else:
            next_1, next_2 = 0.0, 0.0
        rest_1 = ph * rest_1
        rest_2 = ph * rest_2
