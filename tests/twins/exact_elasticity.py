"""The exactly integrated elastic kernel as a Toeplitz matrix, against the sums of exponentials of the solver."""

from typing import Any

import numpy as np
from scipy.linalg import matmul_toeplitz

from ehl.rough.exponential_sums import kernel_constant, log_coefficients, range_of


def elastic_error(run: Any) -> float:
    """Largest deviation of the elastic operator of a run from the exact one, over the boundary film.

    A rigid shift does not count: the approach of the bodies takes it up.
    """
    model = run.problem.model
    total = run.state.fluid_pressure + run.state.contact_pressure
    coefficients = log_coefficients(total.size) + kernel_constant(range_of(total.size))
    reference = matmul_toeplitz(coefficients, total) * run.problem.deflection
    difference = (run.elastic_response(total) - reference)[: model.contact.outlet]
    return float(0.5 * np.ptp(difference)) / model.contact.boundary
