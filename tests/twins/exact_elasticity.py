"""The exactly integrated elastic kernel by zero-padded FFT, against the sums of exponentials of the solver."""

from typing import Any

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from ehl.rough.exponential_sums import kernel_constant, log_coefficients, range_of


class LogConvolution:
    """Product with the kernel of an n-node line, without periodic images."""

    def __init__(self, n: int) -> None:
        self.n = n
        coefficients = log_coefficients(n) + kernel_constant(range_of(n))
        self._length = next_fast_len(2 * n, real=True)
        row = np.zeros(self._length)
        row[:n] = coefficients
        row[self._length - n + 1 :] = coefficients[:0:-1]
        self._transform = rfft(row)

    def apply(self, q: Any) -> np.ndarray:
        """``K q``, shape (n,)."""
        return np.asarray(irfft(self._transform * rfft(q, self._length), self._length)[: self.n])


def elastic_error(run: Any) -> float:
    """Largest deviation of the elastic operator of a run from the exact one, over the boundary film.

    A rigid shift does not count: the approach of the bodies takes it up.
    """
    model = run.problem.model
    total = run.state.fluid_pressure + run.state.contact_pressure
    reference = LogConvolution(total.size).apply(total) * run.problem.deflection
    difference = (run.elastic_response(total) - reference)[: model.contact.outlet]
    return float(0.5 * np.ptp(difference)) / model.contact.boundary
