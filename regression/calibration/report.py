"""Sections and figure of a calibration, and its oil card with a record of the origin of the values."""

from __future__ import annotations

import datetime
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ehl import SOLVER
from ehl.common.figures import new_figure
from ehl.common.notes import Note
from ehl.common.quantities import axis_label, plus_minus, quantity, to_display
from ehl.common.sections import Head, KeyFigures, MainResult, Medium, Notes, Picture, Section, Text
from ehl.common.table import Column, Table
from ehl.fluid.oil import CalibratedValue, CalibrationRecord, Oil
from ehl.uncertainty.result import score_of
from regression.calibration.calibrate import Calibration, reference_temperature
from regression.calibration.measurement import Measurement
from regression.calibration.setup import RISING, SURFACE, card_with

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# standard deviation of the card for each fitted value of the oil
OF_CARD = {
    **dict.fromkeys(("eyring_stress", *RISING), "eyring_stress"),
    "limiting_shear_coefficient": "limiting_shear",
    "pressure_viscosity": "pressure_viscosity",
}


def calibrated_card(name: str, result: Calibration, date: datetime.date) -> Oil:
    """The card with the calibrated values and their record.

    Undetermined values remain those of the initial card unless the data exclude them.
    """
    measurement, setup = result.measurement, result.setup
    base = Oil.load(setup.oil)
    moved = set(setup.parameters)
    if set(RISING) & moved:
        moved |= set(RISING)
    oil_values = {name: value for name, value in result.values.items() if name in moved and name not in SURFACE}
    card = card_with(base, oil_values, reference_temperature(measurement))
    used = [i for i in range(measurement.size) if measurement.row_numbers[i] not in result.excluded]
    stress, specimens, geometry = "rising" if setup.rising else "constant", setup.specimens, "line contact"
    if specimens.geometry == "point":
        geometry = f"point contact, solved as a line contact of the same {specimens.match.replace('_', ' ')}"
    record = CalibrationRecord(
        file=measurement.name,
        file_hash=measurement.file_hash,
        date=date.isoformat(),
        solver_version=SOLVER,
        card=setup.oil,
        model=f"{setup.model.accuracy}, thermal {setup.model.thermal}, {stress} Eyring stress",
        geometry=geometry,
        coating=specimens.coating,
        rows_used=len(used),
        rows_excluded=len(result.excluded),
        outliers=result.outliers,
        noise=result.noise,
        fitted={
            estimate.name: CalibratedValue(**{name: getattr(estimate, name) for name in CalibratedValue.model_fields})
            for estimate in result.parameters
            if estimate.name in result.fitted
        },
        undetermined=tuple(e.name for e in result.parameters if e.status == "undetermined"),
        held={e.name: e.held for e in result.parameters if e.status == "undetermined"},
        conditions={
            column: (float(values[used].min()), float(values[used].max()))
            for column, values in measurement.columns.items()
        },
        surface={key: result.values[key] for key in SURFACE if key in result.values},
    )
    words = f"calibrated from {measurement.name} ({len(used)} rows) on {date.isoformat()}, initial card {setup.oil}"
    if not result.misfit_credible:
        words += f"; wide intervals: {result.misfit_words()}"
    changes = {
        "uncertainty": base.uncertainty.model_copy(update=_deviations(base, record.fitted)),
        "name": name,
        "description": f"{base.description}; {words}".removeprefix("; "),
        "source": f"{', '.join(result.fitted)} {words}; all other values: {base.source}",
        "calibration": record,
    }
    return card.model_copy(update=changes)


def _deviations(base: Oil, fitted: Mapping[str, CalibratedValue]) -> dict[str, float]:
    """Standard deviations of the oil where the intervals are wider than those of the initial card."""
    found: dict[str, float] = {}
    for name, value in fitted.items():
        if (own := OF_CARD.get(name)) is not None:
            sd = math.log(value.interval_high / value.interval_low) / (2.0 * score_of(0.95))
            found[own] = min(max(sd, getattr(base.uncertainty, own), found.get(own, 0.0)), 1.0)
    return found


# possible abscissae of a curve
_OVER = ("slide_to_roll", "speed_entrainment", "pressure_hertz", "load", "load_per_length", "temperature_oil")
MAX_LABELS = 10
CAPTION = "Points: measured; lines: computed. Below: residuals over the noise; outliers are circled."


def plot_calibration(result: Calibration, ax: Axes | None = None) -> Axes:
    """Plot of measured points and computed lines with residuals below, one column for each abscissa."""
    from matplotlib import colormaps

    measurement = result.measurement
    curves: dict[str, list[tuple[str, list[int]]]] = {}
    for label in dict.fromkeys(measurement.curve):
        rows = [i for i, other in enumerate(measurement.curve) if other == label]
        curves.setdefault(_varies(measurement, rows), []).append((label, rows))
    computed = np.array(result.friction_computed)
    residual = (measurement.friction - computed) / result.noise
    if ax is None:
        figure = new_figure(5.4 * len(curves) + 0.8, 6.0)
        panels = list(figure.subplots(2, len(curves), sharex="col", squeeze=False, height_ratios=(3, 1)).T)
        figure.suptitle(f"{measurement.name}: measured points, computed lines", fontsize=10)
    else:
        panels = [(ax, None)]
    number_of = measurement.row_numbers
    for (above, below), (over, lines) in zip(panels, curves.items(), strict=False):
        x = to_display(over, np.abs(measurement.columns[over]))
        for number, (label, rows) in enumerate(lines):
            colour = colormaps["viridis"](0.9 * number / max(len(lines) - 1, 1))
            order = sorted((i for i in rows if number_of[i] not in result.excluded), key=lambda i: x[i])
            text = label if number < MAX_LABELS else "_"
            above.plot(x[order], measurement.friction[order], "o", ms=4, color=colour, label=text)
            above.plot(x[order], computed[order], "-", lw=1.2, color=colour)
            if below is not None:
                below.plot(x[order], residual[order], "o", ms=3, color=colour)
            far = [i for i in order if number_of[i] in result.outliers]
            above.plot(x[far], measurement.friction[far], "o", ms=10, mfc="none", mec="crimson", label="_")
        if over in ("slide_to_roll", "speed_entrainment"):
            above.set_xscale("log")
        above.set_ylabel("friction coefficient [-]")
        above.legend(frameon=False, fontsize=8)
        if below is None:
            above.set_xlabel(axis_label(over))
            continue
        below.axhline(0.0, color="black", lw=0.8)
        below.set(xlabel=axis_label(over), ylabel="measured - computed\nover noise [-]")
    main: Axes = panels[0][0]
    return main


def _varies(measurement: Measurement, rows: list[int]) -> str:
    """Quantity with the largest ratio of its extreme values along a curve."""

    def ratio(name: str) -> float:
        values = np.abs(measurement.columns[name][rows])
        values = values[values > 0.0]
        return float(values.max() / values.min()) if values.size else 1.0

    return max((name for name in _OVER if name in measurement.columns), key=ratio)


def parameter_table(result: Calibration) -> Table:
    """Fitted values with their intervals and start values."""
    how = "profile on the solver" if result.profiled else "standard errors"
    fields = {"value": "value", "lower limit": "interval_low", "upper limit": "interval_high", "start": "start"}
    rows = [(words, *(getattr(e, field) for e in result.parameters)) for words, field in fields.items()]
    return Table(
        ("", *(estimate.name for estimate in result.parameters)),
        [*rows, ("status", *(estimate.status for estimate in result.parameters))],
        title=f"calibrated parameters (95 % intervals by {how})",
        vertical=True,
    )


def calibration_sections(result: Calibration, medium: Medium) -> list[Section]:
    """Parameters with intervals, correlations, noise, outliers, measured and computed curves, cost."""
    tables = [parameter_table(result)]
    if len(result.fitted) > 1:
        labels = {name: quantity(name).label for name in result.fitted}
        heads = (Column(name, of="correlation", label=label, digits=2) for name, label in labels.items())
        rows = [(label, *row) for label, row in zip(labels.values(), result.correlation, strict=True)]
        tables.append(Table(["parameter", *heads], rows, title="correlation of the logarithms"))
    head, notes = Head("Calibration", result.measurement.name), Notes(_notes(result))
    if medium == "files":
        return [Section("", [head, *tables, notes])]
    tiles = []
    for e in result.parameters:
        if e.status == "determined":
            shown = quantity(e.name)
            interval = shown.span(e.interval_low, e.interval_high)
            tiles.append((shown.text(e.value, 3), f"{shown.label}, 95 % interval {interval}"))
    ratio = result.misfit / result.noise
    stated = "" if math.isnan(result.noise_stated) else f" (stated {result.noise_stated:.2g})"
    answer = MainResult(
        f"{len(tiles)} of {len(result.parameters)}",
        "parameters determined by these data",
        [
            (f"{result.misfit:.2g}", f"misfit of mu (RMS), {ratio:.2g} times the noise of {result.noise:.2g}{stated}"),
            (plus_minus(result.solver_error), "largest numerical error of the solver"),
        ],
    )
    cost = Text(
        f"Initial oil card: {result.setup.oil}. {result.solver_calls} contacts solved in {result.iterations} rounds, "
        f"{result.seconds:.1f} s."
    )
    if medium == "terminal":
        return [Section("", [*tables, answer, notes, cost])]
    curves = Picture(lambda: plot_calibration(result), CAPTION, "curves")
    return [
        Section("", [head, answer, *([KeyFigures(tiles)] if tiles else []), notes]),
        Section("Measured and computed", [curves]),
        Section("Parameters", tables),
        Section("How it was computed", [cost]),
    ]


def _notes(result: Calibration) -> list[Note]:
    """Notes of a calibration, the most severe first."""
    found = [] if result.misfit_credible else [Note("warning", f"no parameter is determined: {result.misfit_words()}")]
    found += [
        Note("warning", f"{quantity(e.name).label} is not determined: {e.note}")
        for e in result.parameters
        if e.status != "determined"
    ]
    kinds = {"outliers with reduced weight": result.outliers, "not used (no sliding or no solution)": result.excluded}
    rows = [f"{what}: rows {', '.join(map(str, rows))} of the file" for what, rows in kinds.items() if rows]
    return found + [Note("warning", text) for text in (*rows, *result.notes)]
