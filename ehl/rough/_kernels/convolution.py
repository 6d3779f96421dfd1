"""Elastic response by the exactly integrated kernel: a zero-padded convolution by fast Fourier transform.

The transforms leave the frequencies in bit-reversed order, which a product with a spectrum stored in the same order
does not mind.  The padded kernel is even, so its spectrum is real.
"""

from __future__ import annotations

from numba import njit

from ehl.compile.compiler import kernel
from ehl.rough._kernels.elasticity import INTERNAL, PUBLIC


@kernel(**PUBLIC)
def forward_transform(real, imag, cosines, sines):
    """Radix-2 transform in place, decimation in frequency: natural order in, bit-reversed order out.

    ``cosines`` and ``sines`` hold the angles of every stage one after the other, those of the longest first.
    """
    size = real.size
    half = size // 2
    table = 0
    while half >= 1:
        for start in range(0, size, 2 * half):
            for j in range(half):
                a = start + j
                b = a + half
                re = real[a] - real[b]
                im = imag[a] - imag[b]
                real[a] += real[b]
                imag[a] += imag[b]
                c = cosines[table + j]
                s = sines[table + j]
                real[b] = re * c + im * s
                imag[b] = im * c - re * s
        table += half
        half //= 2


@kernel(**PUBLIC)
def inverse_transform(real, imag, cosines, sines):
    """The reverse, without the division by the size: bit-reversed order in, natural order out."""
    size = real.size
    half = 1
    table = size - 2
    while half < size:
        for start in range(0, size, 2 * half):
            for j in range(half):
                a = start + j
                b = a + half
                c = cosines[table + j]
                s = sines[table + j]
                re = real[b] * c - imag[b] * s
                im = imag[b] * c + real[b] * s
                real[b] = real[a] - re
                imag[b] = imag[a] - im
                real[a] += re
                imag[a] += im
        half *= 2
        table -= half


@kernel(**PUBLIC)
def exact_product(q, spectrum, cosines, sines, real, imag, out):
    """out_i = sum_j K_|i-j| q_j without periodic images; ``spectrum`` carries the division by the size."""
    n = q.size
    for i in range(n):
        real[i] = q[i]
    for i in range(n, real.size):
        real[i] = 0.0
    for i in range(imag.size):
        imag[i] = 0.0
    forward_transform(real, imag, cosines, sines)
    for i in range(real.size):
        real[i] *= spectrum[i]
    for i in range(real.size):
        imag[i] *= spectrum[i]
    inverse_transform(real, imag, cosines, sines)
    for i in range(n):
        out[i] = real[i]


@njit(**INTERNAL)
def correct_film(state, work, elastic):
    """Give the film the exactly integrated kernel; returns by how much that moved it.

    The solver's film is that of the sum of exponentials plus a known correction, kept from the last call: the new one
    is what the present pressures leave between both operators.
    """
    exact_product(work.total, elastic.spectrum, elastic.cosines, elastic.sines, work.wave[0], work.wave[1], work.exact)
    largest = 0.0
    for i in range(work.total.size):
        change = work.exact[i] - work.response[i] - work.correction[i]
        work.correction[i] += change
        state.film[i] += change
        largest = max(largest, abs(change))
    return largest
