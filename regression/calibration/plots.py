"""Measured and computed friction over what varies along each curve, and the residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from regression.calibration.calibrate import CalibrationResult
from regression.calibration.measurement import Measurement

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# what a curve may be drawn over: factor from SI, shift, label
_OVER = {
    "slide_to_roll": (1.0, 0.0, "|slide_to_roll| [-]"),
    "speed_entrainment": (1.0, 0.0, "speed_entrainment [m/s]"),
    "pressure_hertz": (1e-9, 0.0, "pressure_hertz [GPa]"),
    "load": (1.0, 0.0, "load [N]"),
    "load_per_length": (1e-3, 0.0, "load_per_length [N/mm]"),
    "temperature_oil": (1.0, -273.15, "temperature_oil [degC]"),
}
MAX_LABELS = 10


def plot_calibration(measurement: Measurement, result: CalibrationResult) -> Figure:
    """Points measured, lines computed; one column for each quantity curves are drawn over, residuals below."""
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    curves: dict[str, list[tuple[str, list[int]]]] = {}
    for label in dict.fromkeys(measurement.curve):
        rows = [i for i, other in enumerate(measurement.curve) if other == label]
        curves.setdefault(_varies(measurement, rows), []).append((label, rows))
    computed = np.array(result.friction_computed)
    residual = (measurement.friction - computed) / result.noise
    figure = Figure(figsize=(5.4 * len(curves) + 0.8, 6.0), layout="constrained")
    panels = figure.subplots(2, len(curves), sharex="col", squeeze=False, height_ratios=(3, 1))
    number_of = measurement.row_numbers
    for column, (over, lines) in enumerate(curves.items()):
        above, below = panels[0, column], panels[1, column]
        factor, shift, name = _OVER[over]
        x = factor * np.abs(measurement.columns[over]) + shift
        for number, (label, rows) in enumerate(lines):
            colour = colormaps["viridis"](0.9 * number / max(len(lines) - 1, 1))
            order = sorted((i for i in rows if number_of[i] not in result.excluded), key=lambda i: x[i])
            text = label if number < MAX_LABELS else "_"
            above.plot(x[order], measurement.friction[order], "o", ms=4, color=colour, label=text)
            above.plot(x[order], computed[order], "-", lw=1.2, color=colour)
            below.plot(x[order], residual[order], "o", ms=3, color=colour)
            far = [i for i in order if number_of[i] in result.outliers]
            above.plot(x[far], measurement.friction[far], "o", ms=10, mfc="none", mec="crimson", label="_")
        if over in ("slide_to_roll", "speed_entrainment"):
            above.set_xscale("log")
        above.set_ylabel("friction coefficient [-]")
        above.legend(frameon=False, fontsize=8)
        below.axhline(0.0, color="black", lw=0.8)
        below.set(xlabel=name, ylabel="table - computed\nover noise [-]")
    fitted = ", ".join(result.fitted)
    figure.suptitle(f"{measurement.name}: points of the table, lines computed with fitted\n{fitted}", fontsize=10)
    return figure


def _varies(measurement: Measurement, rows: list[int]) -> str:
    """What varies most along a curve, by ratio."""
    ratios = {}
    for name in _OVER:
        if name in measurement.columns:
            values = np.abs(measurement.columns[name][rows])
            values = values[values > 0.0]
            ratios[name] = float(values.max() / values.min()) if values.size else 1.0
    return max(ratios, key=lambda name: ratios[name])
