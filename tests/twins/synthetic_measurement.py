"""Synthetic measurements: friction by the solver with known parameters, and noise."""

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ehl import __version__
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.files import write_file
from ehl.common.quantities import si_unit
from ehl.common.runner import checked_jobs
from ehl.common.table_reader import harmless
from ehl.common.units import ValueRange
from regression.calibration.calibrate import all_values, setup_of, solver_of
from regression.calibration.measurement import CONDITIONS, SYNTHETIC, Measurement, read_measurement
from regression.calibration.setup import PARAMETERS, CalibrationSetup


def synthetic_measurement(
    conditions: Measurement | str | PathLike[str],
    setup: CalibrationSetup | str | PathLike[str] | Mapping[str, Any],
    path: str | PathLike[str] | None = None,
    *,
    true: Mapping[str, float | str] | None = None,
    seed: int = 1,
    parameters: Sequence[str] | None = None,
    oil: str | None = None,
    jobs: int | None = None,
) -> Measurement:
    """Friction of a planned test by the solver, with Gaussian noise of the standard deviation that [noise] states.

    Parameters
    ----------
    conditions : Measurement, str or path
        Conditions of the test, as `calibrate` takes them; friction is not needed and not used.
    setup : CalibrationSetup, str or path, or mapping
        As of `calibrate`.
    path : str or path, optional
        CSV file to write; its first lines say that it is synthetic.
    true : mapping, optional
        Values of parameters in place of those of card and setup: SI, or text with a unit.
    seed : int
        Of the noise.
    parameters : sequence of str, optional
        As of `calibrate`.
    oil : str, optional
        As of `calibrate`.
    jobs : int, optional
        Worker processes, one thread each; all processors if None.

    Returns
    -------
    Measurement
        The conditions with synthetic friction.

    Raises
    ------
    InputError
        No noise is stated, a parameter of `true` is none of this model, or the file cannot be written.
    ConvergenceError
        The solver failed on a row.
    """
    setup = setup_of(setup, parameters, oil)
    truth = {name: _checked(name, value) for name, value in (true or {}).items()}
    if isinstance(conditions, Measurement):
        planned = conditions
    else:
        planned = read_measurement(Path(conditions), setup.conditions.given(), friction=False)
    if not setup.noise.stated:
        raise InputError("noise", None, "absolute or relative, the standard deviation of the synthetic noise")
    values = true_values(planned, setup, truth)
    solver = solver_of(planned, setup, checked_jobs(jobs))
    parts = solver.parts([values])[0]
    failed = np.flatnonzero(np.isnan(parts).any(axis=1))
    if failed.size:
        raise ConvergenceError("failed_rows", f"rows {', '.join(str(i + 1) for i in failed)} of {planned.name}")
    mu = solver.friction(solver.transformed(parts), values)
    sigma = np.hypot(setup.noise.absolute or 0.0, (setup.noise.relative or 0.0) * mu)
    noisy = mu + sigma * np.random.default_rng(seed).standard_normal(mu.size)
    made = replace(planned, friction=noisy, uncertainty=np.full(mu.size, np.nan))
    if path is not None:
        write_synthetic(made, setup, seed, values, Path(path))
    return made


def true_values(planned: Measurement, setup: CalibrationSetup, truth: dict[str, float]) -> dict[str, float]:
    """Values of all parameters behind synthetic friction, SI.

    Raises
    ------
    InputError
        A name is no parameter of this model.
    """
    values = all_values(planned, setup)
    for name in truth:
        if name not in values:
            raise InputError("true", name, "one of " + ", ".join(values))
    return values | truth


def _checked(name: str, value: float | str) -> float:
    """Value of a parameter, SI; a text needs its unit where the parameter has one."""
    if name not in PARAMETERS:
        raise InputError("true", name, "one of " + ", ".join(PARAMETERS))
    parameter, unit = PARAMETERS[name], si_unit(name)
    quantity = ValueRange(unit, ge=parameter.low, le=parameter.high)
    return quantity.check(value, name, bare=not (unit and isinstance(value, str)))


def write_synthetic(
    made: Measurement, setup: CalibrationSetup, seed: int, values: dict[str, float], path: Path
) -> None:
    """Write a synthetic measurement as CSV; its first lines say what it is.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    shown_values = ", ".join(f"{name} {value:.6g}" for name, value in values.items())
    text = io.StringIO()
    text.write(f"{SYNTHETIC}, no measurement: friction computed by ehl {__version__} for {setup.oil} with noise, ")
    text.write(f"seed {seed}\n# parameters (SI): {shown_values}\n")
    writer = csv.writer(text, lineterminator="\n")
    names = [name for name in CONDITIONS if name in made.columns and np.ptp(made.columns[name]) > 0.0]
    names += [name for name in made.columns if name not in names and name not in setup.conditions.given()]
    shown = [f"{name} [{CONDITIONS[name].unit}]" if CONDITIONS[name].unit else name for name in names]
    writer.writerow(["curve", *shown, "friction_coefficient"])
    for i in range(made.size):
        numbers = [f"{made.columns[name][i]:.8g}" for name in names]
        writer.writerow([harmless(made.curve[i]), *numbers, f"{made.friction[i]:.6f}"])
    write_file(path, text.getvalue())
