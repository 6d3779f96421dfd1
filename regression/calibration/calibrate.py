"""Calibration of oil and surface parameters: from a measured table and a setup to values and intervals.

Each row becomes a contact. Parameters are fitted from start values; those that are not identifiable are held, and the
search is repeated. Intervals follow from standard errors or profiles.
"""

from __future__ import annotations

import datetime
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ehl.common.arrays import FloatArray, finite_or_none
from ehl.common.errors import InputError, MixedEhlError
from ehl.common.pages import Reportable
from ehl.common.progress import ProgressCallback, counted, progress_to
from ehl.common.quantities import percent, quantity, si_unit
from ehl.common.runner import checked_jobs
from ehl.common.threads import one_thread
from ehl.common.units import KELVIN
from ehl.common.validation import read_toml, validate
from ehl.fluid.oil import Oil
from regression.calibration import robust
from regression.calibration.determination import (
    DETERMINED,
    determination_of,
    intervals_by_errors,
    least_identifiable,
    profile_intervals,
    why_not_identifiable,
)
from regression.calibration.measurement import Measurement, read_measurement
from regression.calibration.prediction import FrictionSolver, contact_groups, line_pressure
from regression.calibration.robust import Noise, noise_of
from regression.calibration.search import Fit, Target, best_start, bounds_of, search
from regression.calibration.setup import RISING, SURFACE, CalibrationSetup, start_values

if TYPE_CHECKING:
    import pandas as pd

PROFILE_CALLS = 6000  # largest number of smooth solutions for which profiles are computed by default
MAX_MISFIT = 0.1  # without stated noise: RMS over mean friction above which the misfit is an error of the model
# RMS over mean friction above which the model does not describe the rows: a card on request only
NO_MODEL = 0.5
EXCLUDED_GAIN = 3.84  # loss of fit above which the data exclude a held value, chi-square of one degree, 95 %


class NotIdentifiable(MixedEhlError):
    """The solver fails on too many rows for an identification."""


class MisfitTooLarge(MixedEhlError):
    """The model does not describe the rows; a card is written on request only (`force`)."""


@dataclass(frozen=True)
class ParameterEstimate:
    """One parameter after the calibration, in SI units."""

    name: str
    unit: str
    # "determined" (95 % interval within a factor of 1.5 and a credible misfit), "weak" (within a factor of 3, or the
    # misfit is not credible), "undetermined" (held)
    status: str
    value: float  # fitted value; nan if undetermined
    standard_error: float  # of ln(value) [-]; nan if undetermined
    # 95 % interval; nan if undetermined
    interval_low: float
    interval_high: float
    held: float  # value of an undetermined parameter; nan otherwise
    start: float  # of the card or the setup
    note: str


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Reportable):
    """Result of `regression.calibrate` in SI units, with the names of docs/nomenclature.md."""

    parameters: tuple[ParameterEstimate, ...]
    correlation: tuple[tuple[float, ...], ...]  # of ln(value) of the fitted parameters, in the order of `fitted`
    fitted: tuple[str, ...]
    # median standard deviation of mu [-]: used and stated; the latter is nan without stated noise
    noise: float
    noise_stated: float
    chi_square: float  # over its expectation with the stated noise; nan if the noise was estimated
    misfit: float  # RMS of computed minus measured mu [-]
    # whether the residuals agree with the stated noise (p >= 0.01); without stated noise, whether the misfit is at most
    # `MAX_MISFIT` of the mean mu. If not, it counts as one common error of all rows, and the intervals are wide
    misfit_credible: bool
    # numbers of rows in the file, counted from 1
    outliers: tuple[int, ...]
    excluded: tuple[int, ...]
    friction_computed: tuple[float, ...]  # mu of all rows by the solver; nan for failed rows
    solver_error: float  # largest relative numerical error of the solver
    profiled: bool  # intervals from profiles on the solver (True) or from standard errors (False)
    values: dict[str, float]  # values of all parameters
    notes: tuple[str, ...]
    iterations: int
    solver_calls: int
    seconds: float
    measurement: Measurement  # measured data
    setup: CalibrationSetup  # known inputs and fitted parameters

    presenter = "regression.calibration.report:calibration"

    def card(self, name: str, *, force: bool = False) -> Oil:
        """The oil card with the calibrated values and a record of their origin.

        name: name of the new card.
        force: return a card although the model does not describe the rows.
        Returns: card; values that are not identifiable remain those of the initial card unless the data exclude them.
            With a misfit that is not credible it has wide intervals and a remark in its description.
        Raises `MisfitTooLarge`: the misfit exceeds half of the mean friction.
        """
        from regression.calibration.report import calibrated_card

        if self.misfit_share > NO_MODEL and not force:
            hint = "Use --force (in Python force=True) to write it nevertheless."
            raise MisfitTooLarge(f"no card written: {self.misfit_words()}. {hint}")
        return calibrated_card(name, self, datetime.date.today())

    @property
    def misfit_share(self) -> float:
        """Misfit over the mean friction of the rows [-]."""
        used = [number not in self.excluded for number in self.measurement.row_numbers]
        return self.misfit / float(np.mean(np.abs(self.measurement.friction[used])))

    def misfit_words(self) -> str:
        """The misfit compared with the noise, as text."""
        if not math.isnan(self.noise_stated) and self.misfit_share <= NO_MODEL:
            ratio = math.sqrt(self.chi_square)
            return f"the residuals are {ratio:.2g} times the stated noise, a significant difference (p < 0.01)"
        limit = NO_MODEL if self.misfit_share > NO_MODEL else MAX_MISFIT
        most = f"the limit is {100.0 * limit:g} %{'' if limit == NO_MODEL else ' without stated noise'}"
        return f"the misfit (RMS) is {percent(self.misfit_share)} of the mean friction; {most}"

    def save_card(self, path: str | PathLike[str], *, force: bool = False) -> Oil:
        """Write the `card`, named by the stem of the path (.toml), and return it; `InputError` if that fails."""
        from ehl.fluid.oil_sheet import write_card

        card = self.card(Path(path).stem, force=force)
        write_card(card, Path(path), "Written by mixed-ehl calibrate")
        return card

    def use_lines(self, path: str | PathLike[str]) -> list[str]:
        """Lines of an input file for the card at this path and the calibrated surface values."""
        law = '  eyring_stress_law = "pressure"' if self.setup.rising else ""
        surface = [f"{name} = {self.values[name]:.4g}" for name in SURFACE if name in self.fitted]
        return [f'[lubricant]  oil = "{Path(path)}"{law}', *(["[surface]  " + "  ".join(surface)] if surface else [])]

    def to_frame(self) -> pd.DataFrame:
        """One row per parameter: name, unit, status, value, standard error of ln(value), 95 % interval, note."""
        import pandas as pd

        return pd.DataFrame([asdict(estimate) for estimate in self.parameters])

    def __repr__(self) -> str:
        lines = [
            f"Calibration of {', '.join(self.fitted)}: misfit {self.misfit:.2g} of mu (RMS), noise {self.noise:.2g}"
        ]
        for estimate in self.parameters:
            value = estimate.held if math.isnan(estimate.value) else estimate.value
            lines.append(f"  {estimate.name} = {value:.4g} {estimate.unit} {estimate.status}: {estimate.note}"[:160])
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Numbers and notes for JSON in SI units; nan becomes None."""
        names = (item.name for item in fields(self) if item.name not in ("measurement", "setup"))
        content: dict[str, Any] = finite_or_none({name: getattr(self, name) for name in names})
        for parameter in content["parameters"]:
            parameter["verdict"] = parameter.pop("note")  # the key of files
        return content


def reference_temperature(measurement: Measurement) -> float:
    """Reference temperature of `pressure_viscosity`: the mean oil temperature of the rows, rounded to 1 K [K]."""
    return round(float(np.mean(measurement.columns["temperature_oil"])) - KELVIN) + KELVIN


def all_values(measurement: Measurement, setup: CalibrationSetup) -> dict[str, float]:
    """Values of all parameters before the fit: those of the card and of [surface]."""
    values = start_values(Oil.load(setup.oil), reference_temperature(measurement), rising=setup.rising)
    values["boundary_friction"] = setup.surface.boundary_friction
    if setup.surface.boundary_film is not None or "boundary_film" in setup.parameters:
        values["boundary_film"] = setup.surface.boundary_film or 20e-9
    return values


def solver_of(measurement: Measurement, setup: CalibrationSetup, jobs: int | None) -> FrictionSolver:
    """The contact solver for the rows of a measurement."""
    groups = contact_groups(measurement, setup)
    roughness = measurement.columns["roughness_rms"]
    return FrictionSolver(setup, groups, roughness, reference_temperature(measurement), jobs)


def check_information(measurement: Measurement, setup: CalibrationSetup) -> None:
    """Check that the rows contain information on the parameters."""
    c = measurement.columns
    if len(setup.parameters) >= measurement.size:
        hint = "Measure more rows, or fit fewer parameters."
        allowed = f"more than {counted(len(setup.parameters), 'row')}"
        raise InputError(measurement.name, counted(measurement.size, "row"), allowed, hint)
    if not (c["slide_to_roll"] != 0.0).any():
        raise InputError(f"{measurement.name}, column slide_to_roll", 0.0, "sliding", "Pure rolling has no friction.")
    for name in SURFACE:
        if name in setup.parameters and not (c["roughness_rms"] > 0.0).any():
            hint = "Give roughness_rms as a column or under [conditions], or remove the parameter."
            raise InputError("parameters", name, "parameters of smooth contacts, as no roughness is given", hint)
    pressure = line_pressure(measurement, setup)
    if set(setup.parameters) >= set(RISING) and np.ptp(pressure) < 0.1 * pressure.mean():
        hint = "Measure at a second pressure, or fit eyring_stress alone."
        raise InputError("parameters", "stress_slope", "parameters that can be identified at one pressure", hint)


def target_of(measurement: Measurement, setup: CalibrationSetup) -> Target:
    """The measured friction with its standard deviations, without rows of pure rolling."""
    mu = measurement.friction
    noise, given = setup.noise, bool(np.isfinite(measurement.uncertainty).any())
    if given and noise.model_fields_set:
        raise InputError("noise", "given", "either [noise] or the column friction_uncertainty")
    if given:
        sigma = measurement.uncertainty
    elif noise.stated:
        sigma = np.hypot(noise.absolute or 0.0, (noise.relative or 0.0) * np.abs(mu))
    else:
        sigma = np.abs(mu) if noise.estimate == "relative" else np.ones_like(mu)
    floor = 1e-3 * float(np.median(sigma))
    return Target(mu, np.maximum(sigma, floor), measurement.columns["slide_to_roll"] != 0.0, given or noise.stated)


@one_thread
def calibrate(
    measurement: Measurement | str | PathLike[str],
    setup: CalibrationSetup | str | PathLike[str] | Mapping[str, Any],
    *,
    parameters: Sequence[str] | str | None = None,
    oil: str | None = None,
    jobs: int | None = None,
    profile: bool | None = None,
    progress: ProgressCallback | None = None,
) -> Calibration:
    """Fit oil and surface parameters to measured friction.

    Parameters
    ----------
    measurement : Measurement, str or path
        Measured friction: a CSV or XLSX file with one row per value and units in the header, or the result of
        `regression.calibration.measurement.read_measurement`.
    setup : CalibrationSetup, str or path, or mapping
        Oil, parameters, specimens and common conditions: a TOML file, or its content.
    parameters : str or sequence of str, optional
        Fitted parameters, instead of those of the setup: `eyring_stress`, `stress_low`, `stress_slope`,
        `limiting_shear_coefficient`, `pressure_viscosity`, `boundary_film`, `boundary_friction`.
    oil : str, optional
        Initial oil card, instead of that of the setup.
    jobs : int, optional
        Worker processes with one thread each; default: all available cores.
    profile : bool, optional
        Whether intervals are profiles on the solver; default: if the cost is low (`PROFILE_CALLS`).
    progress : callable, optional
        Called with a `Progress` in each round of the search.

    Returns
    -------
    Calibration
        Values with intervals; `card` returns an oil card with them.

    Raises
    ------
    InputError
        The rows contain no information on a parameter, or a condition is out of range.
    NotIdentifiable
        The solver fails on most rows.
    ConvergenceError
        The search did not converge.

    Examples
    --------
    >>> found = calibrate("friction.csv", "calibration.toml")  # doctest: +SKIP
    >>> found.card("my_oil").at(353.15).eyring_stress  # doctest: +SKIP
    6.1e6
    """
    setup = setup_of(setup, parameters, oil)
    if not isinstance(measurement, Measurement):
        fixed = setup.conditions.model_dump(exclude_none=True)
        measurement = read_measurement(Path(measurement), fixed, roughness_rms=setup.roughness_rms)
    clock = time.perf_counter()
    check_information(measurement, setup)
    solver = solver_of(measurement, setup, checked_jobs(jobs))
    start = all_values(measurement, setup)
    target = target_of(measurement, setup)
    target = _solvable(solver, start, target)

    names = setup.parameters
    with progress_to(progress):
        fit = search(solver, best_start(solver, start, names, target), names, target)
        rounds, stated = fit.rounds, _noise(fit, target)
        if stated.larger_than_stated:
            target = replace(target, stated=False)
            fit = search(solver, fit.values, names, target)
            rounds += fit.rounds
        not_identifiable: dict[str, tuple[str, float]] = {}
        while True:
            noise = _noise(fit, target)
            found = determination_of(fit, target, noise, measurement.curve)
            intervals = intervals_by_errors(fit, noise, found)
            worst = least_identifiable(fit, found, noise.quantile * found.errors)
            cheap = not solver.roughness.any() and 4 * len(names) * int(target.rows.sum()) <= PROFILE_CALLS
            profiled = worst is None and (cheap if profile is None else profile)
            if profiled:
                intervals = profile_intervals(solver, fit, target, noise, found)
                worst = least_identifiable(fit, found, 0.5 * np.ptp(intervals, axis=1))
            if worst is None or len(names) == 1:
                break
            why = why_not_identifiable(worst, fit, found, noise.quantile, intervals[names.index(worst)])
            names = tuple(name for name in names if name != worst)
            fit, held, more = _refit_without(worst, start[worst], fit, names, solver, target, noise)
            rounds += more
            not_identifiable[worst] = (why, held)
        # a single remaining parameter is not held, even if its interval is wide
        only = "" if worst is None else why_not_identifiable(worst, fit, found, noise.quantile, intervals[0])

    misfit = float(np.sqrt(np.mean((fit.friction - target.friction)[target.rows] ** 2)))
    mean = float(np.mean(np.abs(target.friction[target.rows])))
    credible = misfit <= MAX_MISFIT * mean if math.isnan(stated.chi_square) else not stated.larger_than_stated
    estimates = []
    # a misfit that is no noise is one error of all rows: more rows do not make the value more certain
    wider = 1.0 if credible else max(math.sqrt(target.rows.sum()) / found.widening, 1.0)
    for name in setup.parameters:
        if name in not_identifiable:
            why, held = not_identifiable[name]
            estimates.append(_not_identifiable(name, why, held, start[name]))
        else:
            j = names.index(name)
            error = wider * float(found.errors[j])
            value = math.log(fit.values[name])
            limits = np.clip(value + wider * (intervals[j] - value), *bounds_of((name,)))
            estimates.append(_estimate(name, fit, error, limits, start[name], only, credible=credible))
    scale = noise.scale * target.sigma
    far = target.rows & (np.abs(fit.friction - target.friction) > robust.FAR * scale)
    errors = solver.parts([fit.values], target.rows)[0, target.rows, 2]
    return Calibration(
        parameters=tuple(estimates),
        correlation=tuple(tuple(float(value) for value in row) for row in found.correlation),
        fitted=names,
        noise=float(np.median(scale[target.rows])),
        noise_stated=math.nan if math.isnan(stated.chi_square) else float(np.median(target.sigma[target.rows])),
        chi_square=stated.chi_square,
        misfit=misfit,
        misfit_credible=credible,
        outliers=tuple(measurement.row_numbers[i] for i in np.flatnonzero(far)),
        excluded=tuple(measurement.row_numbers[i] for i in np.flatnonzero(~target.rows)),
        friction_computed=tuple(float(mu) for mu in fit.friction),
        solver_error=float(np.nanmax(errors)),
        profiled=profiled,
        values=fit.values,
        notes=measurement.notes + _notes(setup, stated, float(noise.scale), found.widening, tuple(not_identifiable)),
        iterations=rounds,
        solver_calls=solver.calls,
        seconds=time.perf_counter() - clock,
        measurement=measurement,
        setup=setup,
    )


def setup_of(
    setup: CalibrationSetup | str | PathLike[str] | Mapping[str, Any],
    parameters: Sequence[str] | str | None = None,
    oil: str | None = None,
) -> CalibrationSetup:
    """A setup from a file or its content, with other parameters or another oil; errors as in `calibrate`."""
    if isinstance(setup, CalibrationSetup):
        setup = setup.model_dump(exclude_unset=True)
    names = [parameters] if isinstance(parameters, str) else list(parameters or ())
    given = {name: value for name, value in {"parameters": names, "oil": oil}.items() if value}
    if isinstance(setup, Mapping):
        return validate(CalibrationSetup, {**setup, **given}, "setup")
    path = Path(setup)
    return validate(CalibrationSetup, read_toml(path, "setup") | given, path.name)


def _solvable(solver: FrictionSolver, values: dict[str, float], target: Target) -> Target:
    """The target without the rows on which the solver fails."""
    found = np.isfinite(solver.parts([values], target.rows)[0]).all(axis=1)
    rows = target.rows & found
    if rows.sum() < max(3, 0.5 * target.rows.sum()):
        raise NotIdentifiable(
            f"the solver fails on {int((target.rows & ~found).sum())} of {int(target.rows.sum())} rows with the values "
            "of the card: check the units of pressures, speeds and temperatures"
        )
    return replace(target, rows=rows)


def _noise(fit: Fit, target: Target) -> Noise:
    residuals = target.residuals(fit.friction)
    return noise_of(residuals, len(fit.names), stated=target.stated, tuned_to=fit.scale)


def _refit_without(
    name: str, card: float, fit: Fit, names: tuple[str, ...], solver: FrictionSolver, target: Target, noise: Noise
) -> tuple[Fit, float, int]:
    """The fit with one parameter held at the value of the card, or at its fitted value if the data exclude that."""
    rounds, limit = 0, EXCLUDED_GAIN / robust.DEVIANCE
    before = robust.loss(target.residuals(fit.friction) / noise.scale)
    best = fit.values[name]
    for held in dict.fromkeys((card, best)):
        again = search(solver, {**fit.values, name: held}, names, target) if names else fit
        rounds += again.rounds if names else 0
        after = robust.loss(target.residuals(again.friction) / noise.scale)
        if after - before <= limit or held == best:
            break
    return again, held, rounds


def _estimate(
    name: str, fit: Fit, error: float, interval: FloatArray, start: float, why: str, *, credible: bool
) -> ParameterEstimate:
    low, high = map(math.exp, interval)
    narrow = 0.5 * np.ptp(interval) <= DETERMINED
    status = "determined" if narrow and credible else "weak"
    below, above = (_change(end / fit.values[name]) for end in (low, high))
    words = f"95 % interval {below} to {above}"
    if not narrow:
        words += "; weakly identified: use the interval rather than the value"
    if why:
        words += f"; not identifiable from these rows: {why}"
    if not credible:
        words += "; the misfit is not credible and was taken as one error of all rows"
    return ParameterEstimate(name, si_unit(name), status, fit.values[name], error, low, high, math.nan, start, words)


def _change(factor: float) -> str:
    """A change in per cent, or as a factor if large."""
    percent = 100.0 * (factor - 1.0)
    return f"{factor:.2g} times the value" if percent > 99.5 else f"{percent:+.{0 if abs(percent) >= 10.0 else 1}f} %"


def _not_identifiable(name: str, why: str, held: float, start: float) -> ParameterEstimate:
    nan = math.nan
    shown = quantity(name).text(held)
    where = "the initial value" if held == start else "the fitted value, as the data exclude the value of the card"
    words = f"not identifiable from these rows: {why}. Held at {shown}, {where}"
    return ParameterEstimate(name, si_unit(name), "undetermined", nan, nan, nan, nan, held, start, words)


def _notes(
    setup: CalibrationSetup, stated: Noise, scale: float, widening: float, not_identifiable: tuple[str, ...]
) -> tuple[str, ...]:
    alike = "largest (Hertz)" if setup.specimens.match == "hertz_pressure" else "mean"
    notes = (
        (
            setup.specimens.geometry == "point",
            f"The solver is for line contacts: each point contact was replaced by a line contact of the same radius "
            f"along the motion and the same {alike} pressure. The fitted values include the effects of side leakage "
            "and of the pressure profile across the motion.",
        ),
        (setup.specimens.coating, "Elasticity and heat conduction of the coating are not modelled."),
        (
            stated.larger_than_stated,
            f"The residuals are {scale:.2g} times the stated noise: the model does not describe the data within it. "
            "Intervals use the residuals.",
        ),
        (
            widening > 1.0,
            "Residuals are correlated along the curves: the model differs systematically from the data. Standard "
            f"errors and intervals are therefore increased by a factor of {widening:.2g}.",
        ),
        (
            not_identifiable,
            f"Values are conditional on the held parameters ({', '.join(not_identifiable)}); intervals do not include "
            "their effect.",
        ),
        (math.isnan(stated.chi_square), "The noise was estimated from the residuals."),
    )
    return tuple(text for holds, text in notes if holds)
