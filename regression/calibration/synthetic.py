"""Synthetic measurements: friction by the solver with known parameters, and noise. Never a measurement.

A test can be judged before it is run: write its conditions, make synthetic friction, calibrate.
"""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np

from ehl import __version__
from ehl.io.errors import ConvergenceError, InputError
from ehl.io.units import ValueRange
from ehl.quantities import si_unit
from regression.calibration.calibrate import all_values, solver_of
from regression.calibration.measurement import CONDITIONS, SYNTHETIC, Measurement
from regression.calibration.parameters import PARAMETERS
from regression.calibration.setup import CalibrationSetup


def synthetic(
    planned: Measurement, setup: CalibrationSetup, seed: int, *, truth: dict[str, float] | None = None, jobs: int = 1
) -> Measurement:
    """Friction of the planned rows by the solver, with Gaussian noise of the standard deviation [noise] states.

    Parameters
    ----------
    planned : Measurement
        Conditions; its friction is not used.
    setup : CalibrationSetup
    seed : int
        Of the noise.
    truth : dict, optional
        Values of parameters in place of those of card and setup, SI.
    jobs : int
        Worker processes.

    Raises
    ------
    InputError
        No noise is stated, or a parameter of `truth` is none of this model.
    ConvergenceError
        The solver failed on a row.
    """
    if not setup.noise.stated:
        raise InputError("noise", None, "absolute or relative, the standard deviation of the synthetic noise")
    values = true_values(planned, setup, truth or {})
    solver = solver_of(planned, setup, jobs)
    parts = solver.parts([values])[0]
    failed = np.flatnonzero(np.isnan(parts).any(axis=1))
    if failed.size:
        raise ConvergenceError("failed_rows", f"rows {', '.join(str(i + 1) for i in failed)} of {planned.name}")
    mu = solver.friction(solver.transformed(parts), values)
    sigma = np.hypot(setup.noise.absolute or 0.0, (setup.noise.relative or 0.0) * mu)
    noisy = mu + sigma * np.random.default_rng(seed).standard_normal(mu.size)
    return replace(planned, friction=noisy, uncertainty=np.full(mu.size, np.nan))


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
            raise InputError("--true", name, "one of " + ", ".join(values))
    return values | truth


def parse_true(texts: list[str]) -> dict[str, float]:
    """Values given as ``NAME=VALUE``, with a unit where the parameter has one.

    Raises
    ------
    InputError
        There is no such parameter, or the value cannot be read or is out of its range.
    """
    values = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals or name not in PARAMETERS:
            raise InputError("--true", text, "NAME=VALUE with a name out of " + ", ".join(PARAMETERS))
        parameter = PARAMETERS[name]
        quantity = ValueRange(si_unit(name), ge=parameter.low, le=parameter.high)
        values[name] = quantity.check(value, f"--true {name}", bare=not si_unit(name))
    return values


def write_synthetic(made: Measurement, setup: CalibrationSetup, seed: int, truth: dict[str, float], path: Path) -> None:
    """Write a synthetic measurement as CSV; its first lines say what it is.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    values = ", ".join(f"{name} {value:.6g}" for name, value in true_values(made, setup, truth).items())
    text = io.StringIO()
    text.write(f"{SYNTHETIC}, no measurement: friction computed by ehl {__version__} for {setup.oil} with noise, ")
    text.write(f"seed {seed}\n# by mixed-ehl calibrate --synthetic; parameters (SI): {values}\n")
    writer = csv.writer(text, lineterminator="\n")
    names = [name for name in CONDITIONS if name in made.columns and np.ptp(made.columns[name]) > 0.0]
    names += [name for name in made.columns if name not in names and name not in setup.conditions.given()]
    shown = [f"{name} [{CONDITIONS[name].unit}]" if CONDITIONS[name].unit else name for name in names]
    writer.writerow(["curve", *shown, "friction_coefficient"])
    for i in range(made.size):
        numbers = [f"{made.columns[name][i]:.8g}" for name in names]
        writer.writerow([made.curve[i], *numbers, f"{made.friction[i]:.6f}"])
    try:
        path.write_text(text.getvalue(), encoding="utf-8")
    except OSError as error:
        raise InputError("--synthetic", str(path), "a writable path", f"{error.strerror}.") from None
