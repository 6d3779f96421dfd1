"""One family fitted to rows: its coefficients and, where asked for, the Gaussian process on what they leave."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
import pandas as pd

from ehl.io.errors import InputError
from regression.data.dataset import columns
from regression.fitting.coefficients import Coefficients, fit_coefficients
from regression.fitting.noise import statistical_variance
from regression.fitting.scores import computed_friction
from regression.friction.conditions import Array
from regression.friction.families import Family
from regression.friction.formula import corrected
from regression.friction.gaussian_process import GpResidual, fit_residual

# of the process beside the variables of the box: sliding across the line makes films between rough surfaces of its own
_MORE_INPUTS = ("slide_to_roll", "correlation_length", "film_ratio_formula")


@dataclass(frozen=True)
class FittedForm:
    """A family with the numbers found for it.

    Parameters
    ----------
    family : Family
    coefficients : Coefficients
    residual : GpResidual or None
        Correction of ln mu on top.
    """

    family: Family
    coefficients: Coefficients
    residual: GpResidual | None

    def friction(self, frame: pd.DataFrame) -> tuple[Array, Array | None]:
        """mu of every row, and the residual's standard deviation of ln mu (None without residual)."""
        table, mu_b = columns(frame), boundary_friction_of(frame)
        mu = np.exp(self.family.log_mu(table, self.coefficients.values, cast("float", mu_b)))
        return (mu, None) if self.residual is None else corrected(mu, self.residual, table, mu_b)


def fit_form(
    family: Family, frame: pd.DataFrame, *, gaussian_process: bool = False, start: GpResidual | None = None
) -> FittedForm:
    """Fit a family to the rows of a dataset, the coefficients first, then the process on their residual.

    Parameters
    ----------
    family : Family
    frame : DataFrame
        Usable rows.
    gaussian_process : bool
        Add the process.
    start : GpResidual, optional
        Where the search for its length scales begins.

    Raises
    ------
    InputError
        Several boundary frictions, and the family does not take it as an input; or too few dimensions.
    ConvergenceError
        The nonlinear fit did not settle.
    """
    mu_b = boundary_friction_of(frame)
    if family.design is not None and isinstance(mu_b, np.ndarray):
        values = sorted({float(value) for value in mu_b})
        hint = "Fit a family that takes it as an input, or one boundary friction at a time."
        raise InputError("boundary_friction", values, f"one value for all cases of family {family.name}", hint)
    # the families compute with arrays of boundary friction as with one number
    coefficients = fit_coefficients(family, frame, cast("float", mu_b))
    form = FittedForm(family, coefficients, None)
    if not gaussian_process:
        return form
    rest = np.log(computed_friction(frame) / form.friction(frame)[0])
    inputs = tuple(dict.fromkeys((*family.box, *_MORE_INPUTS)))
    process = fit_residual(columns(frame), rest, statistical_variance(frame), inputs, start=start)
    return FittedForm(family, coefficients, process)


def boundary_friction_of(frame: pd.DataFrame) -> float | Array:
    """The boundary friction of the rows: one number, or a column where there are several."""
    values = frame["boundary_friction"].to_numpy(dtype=float)
    return float(values[0]) if np.ptp(values) == 0.0 else values
