"""Roughness parameters of a measured profile or map between cut-offs, along and across the lay."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy

from ehl.common.arrays import FloatArray, finite_or_none
from ehl.common.errors import InputError
from ehl.common.figures import BLUE, GREY, ORANGE, new_figure
from ehl.common.pages import TableResult
from ehl.common.table import Column, Table
from ehl.common.units import ValueRange
from ehl.surface.measured_profile import detrended, gaussian_mean_line, profile_points
from ehl.surface.profile_file import MeasuredHeights
from ehl.surface.roughness import measured_correlation_length, moments

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# ISO 4288, ISO 3274 (unverified): upper limit of Ra, long cut-off and short cut-off [m]
STANDARD_CUTOFFS = (
    (2e-8, 8e-5, 2.5e-6),
    (1e-7, 2.5e-4, 2.5e-6),
    (2e-6, 8e-4, 2.5e-6),
    (1e-5, 2.5e-3, 8e-6),
    (math.inf, 8e-3, 2.5e-5),
)
SPECTRUM_BINS = 24  # of equal width in the logarithm of the frequency, between the cut-offs
ISOTROPIC = 1.2  # ratio of the RMS slopes across and along below which no lay is stated (own choice)
_CUTOFF = ValueRange("m", gt=0.0, le=0.1)


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredSurface(TableResult):
    """Roughness of a measured profile or map; lengths in m.

    Parameters
    ----------
    name : str
        Name of the file.
    lines, points : int
        Number of lines, and of points of each line.
    cutoff_long, cutoff_short : float
        lambda_c, lambda_s.
    roughness_rms, skewness, kurtosis : float
        Rq, Rsk, Rku (of a map Sq, Ssk, Sku) between the cut-offs.
    rsm, rdq : float
        Mean spacing of profile elements and RMS slope [-], mean of the lines.
    correlation_length, correlation_length_along : float
        Lag of 1/e of the autocorrelation, for a map across and along the lay; the latter is nan for a profile.
    lay_angle : float
        Angle between lay and x of a map [rad]; nan for a profile or an isotropic map.
    missing, spikes : int
        Number of interpolated points.
    frequency, spectral_density : ndarray, shape (bins,)
        Spatial frequency 1/wavelength [1/m] between the cut-offs, and the one-sided power spectral density of the
        lines [m^3]: its integral over the frequency is Rq squared.
    notes : tuple of str
        Processing steps.
    x, raw, form, used : ndarray, shape (n,)
        Positions and heights of one line: as read, the removed polynomial, and the heights between the cut-offs.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import ehl
    >>> path = Path(tempfile.mkdtemp()) / "flank.csv"
    >>> heights = [k % 40 - 20 for k in range(2000)]
    >>> _ = path.write_text("x [um], z [nm]\\n" + "\\n".join(f"{k}, {10 * z}" for k, z in enumerate(heights)))
    >>> round(1e6 * ehl.measured_surface(path).rsm)
    40
    """

    name: str
    lines: int
    points: int
    cutoff_long: float
    cutoff_short: float
    roughness_rms: float
    skewness: float
    kurtosis: float
    rsm: float
    rdq: float
    correlation_length: float
    correlation_length_along: float
    lay_angle: float
    missing: int
    spikes: int
    frequency: FloatArray
    spectral_density: FloatArray
    notes: tuple[str, ...]
    x: FloatArray
    raw: FloatArray
    form: FloatArray
    used: FloatArray

    def table(self) -> Table:
        """One row."""
        columns = [
            Column("roughness_rms", label="Rq"),
            Column("skewness", label="Rsk"),
            Column("kurtosis", label="Rku"),
            Column("rsm", of="correlation_length", label="RSm"),
            Column("rdq", label="Rdq"),
            Column("correlation_length"),
            Column("correlation_length_along", of="correlation_length", label="correlation length along the lay"),
            Column("lay_angle"),
            Column("cutoff_short"),
            Column("cutoff_long"),
            Column("missing"),
            Column("spikes"),
        ]
        row = [finite_or_none(getattr(self, column.name)) for column in columns]
        return Table(columns, [row], title=self.name, vertical=True, name="profile", notes=self.notes)

    def to_dict(self) -> dict[str, Any]:
        """Single values and notes, for JSON."""
        return self.table().records()[0] | {"lines": self.lines, "points": self.points, "notes": list(self.notes)}

    def __repr__(self) -> str:
        return f"MeasuredSurface({self.name}: Rq {self.roughness_rms:.3g} m, RSm {self.rsm:.3g} m, Rdq {self.rdq:.3g})"

    def _plot(self, ax: Axes | None, **options: Any) -> Axes:
        if ax is None:
            above, ax = new_figure(7.6, 4.6).subplots(2, 1, sharex=True)
            above.plot(1e3 * self.x, 1e6 * self.raw, color=GREY, lw=0.8, label="as read")
            above.plot(1e3 * self.x, 1e6 * self.form, color=ORANGE, lw=1.2, label="form, removed")
            above.set_ylabel("height [µm]")
            above.legend(loc="best")
        ax.plot(1e3 * self.x, 1e6 * self.used, color=BLUE, lw=0.8, label="between the cut-offs")
        ax.set_xlabel("x [mm]")
        ax.set_ylabel("height [µm]")
        ax.legend(loc="best")
        return ax


def measured_surface(
    path: str | Path,
    *,
    unit_x: str = "",
    unit_height: str = "",
    detrend: int = 2,
    cutoff_long: float | str | None = None,
    cutoff_short: float | str | None = None,
) -> MeasuredSurface:
    """Roughness of a text or instrument file (`ehl.surface.profile_file.read_heights`).

    Parameters
    ----------
    path : str or Path
        File of the measurement.
    unit_x, unit_height : str
        Units, for a file that does not state them.
    detrend : int
        Order of the polynomial (form) that is removed.
    cutoff_long, cutoff_short : float or str, optional
        Cut-offs [m]; default: the table of ISO 4288 for the arithmetic mean height.

    Returns
    -------
    MeasuredSurface

    Raises
    ------
    InputError
        The file cannot be read, or its heights or a cut-off are not plausible.

    Examples
    --------
    >>> import ehl
    >>> ehl.measured_surface("flank.csv", unit_height="um").roughness_rms  # doctest: +SKIP
    2.8e-07
    """
    if not 1 <= detrend <= 8:
        raise InputError("detrend", detrend, "1 to 8")
    found, raw, read = profile_points(path, unit_x=unit_x, unit_height=unit_height)
    level = _levelled(found.heights, detrend)
    step, length = found.spacing, found.spacing * found.heights.shape[1]
    long = None if cutoff_long is None else _CUTOFF.check(cutoff_long, "cutoff_long")
    short = None if cutoff_short is None else _CUTOFF.check(cutoff_short, "cutoff_short")
    notes = list(read)
    if long is None or short is None:
        chosen = _standard_cutoffs(level, step, length / 5.0)
        if long is None and chosen[1] > length / 5.0:
            notes.append(f"long cut-off reduced to a fifth of the length; ISO 4288 requires {5e3 * chosen[1]:.3g} mm")
        long = min(chosen[1], length / 5.0) if long is None else long
        short = max(chosen[2], 2.0 * step) if short is None else short
    if not 2.0 * step <= short < 0.5 * long <= 0.5 * length:
        raise InputError("cutoff_short", short, f"{2.0 * step:.3g} m to half the long cut-off, {0.5 * long:.3g} m")
    used = _between(level, found, long, short)
    rms, skewness, kurtosis = moments((used - used.mean()).ravel())
    across, along, angle = _lay(used, found)
    spacing_of = [mean_spacing(line, step) for line in used]
    shown = int(np.argmin(np.abs(found.heights - raw).max(axis=1)))
    return MeasuredSurface(
        found.name,
        len(used),
        used.shape[1],
        long,
        short,
        rms,
        skewness,
        kurtosis,
        float(np.nanmean(spacing_of)) if np.isfinite(spacing_of).any() else math.nan,
        float(np.mean([rms_slope(line, step) for line in used])),
        across,
        along,
        angle,
        found.missing,
        found.spikes,
        *power_spectrum(used, step, short, long),
        tuple(notes),
        found.x,
        raw,
        found.heights[shown] - level[shown],
        used[shown],
    )


def _levelled(heights: FloatArray, order: int) -> FloatArray:
    """Heights of a profile or map minus their least-squares polynomial."""
    if len(heights) == 1:
        return detrended(heights[0], order)[None, :]
    y, x = np.meshgrid(*(np.linspace(-1.0, 1.0, n) for n in heights.shape), indexing="ij")
    terms = np.stack([x**i * y**j for i in range(order + 1) for j in range(order + 1 - i)], axis=-1).reshape(y.size, -1)
    fitted = terms @ np.linalg.lstsq(terms, heights.ravel(), rcond=None)[0]
    return np.asarray(heights - fitted.reshape(heights.shape))


def _standard_cutoffs(level: FloatArray, step: float, longest: float) -> tuple[float, float, float]:
    """Row of the longest cut-off whose Ra after filtering exceeds the limit of the previous row."""
    for below, row in zip(STANDARD_CUTOFFS[-2::-1], STANDARD_CUTOFFS[:0:-1], strict=True):
        cutoff = min(row[1], longest)
        if np.mean([np.mean(np.abs(line - gaussian_mean_line(line, step, cutoff))) for line in level]) > below[0]:
            return row
    return STANDARD_CUTOFFS[0]


def _between(level: FloatArray, found: MeasuredHeights, long: float, short: float) -> FloatArray:
    """Heights between the cut-offs; for a map with the areal Gaussian filter."""

    def smooth(heights: FloatArray, cutoff: float) -> FloatArray:
        along = np.array([gaussian_mean_line(line, found.spacing, cutoff) for line in heights])
        if not found.is_map:
            return along
        return np.array([gaussian_mean_line(line, found.spacing_lines, cutoff) for line in along.T]).T

    kept = smooth(level, short)
    return np.asarray(kept - smooth(kept, long))


def _lay(used: FloatArray, found: MeasuredHeights) -> tuple[float, float, float]:
    """Correlation length across and along the lay [m], and the angle of the lay to x [rad]."""
    if not found.is_map:
        return measured_correlation_length(used[0], found.spacing, periodic=False), math.nan, math.nan
    slope_y, slope_x = np.gradient(used, found.spacing_lines, found.spacing)
    tensor = np.array([[np.mean(a * b) for b in (slope_x, slope_y)] for a in (slope_x, slope_y)])
    power, directions = np.linalg.eigh(tensor)  # the lay has the smallest slope
    lay = math.remainder(math.atan2(directions[1, 0], directions[0, 0]), math.pi)
    lengths = [_correlation_length(used, found, lay + turn) for turn in (0.5 * math.pi, 0.0)]
    marked = power[1] > ISOTROPIC**2 * power[0]
    return lengths[0], lengths[1], lay if marked else math.nan


def _correlation_length(used: FloatArray, found: MeasuredHeights, angle: float) -> float:
    """Lag in one direction at which the areal autocorrelation falls to 1/e [m]; nan if it does not."""
    shape = tuple(scipy.fft.next_fast_len(2 * n) for n in used.shape)
    heights = used - used.mean()

    def correlate(values: FloatArray) -> FloatArray:
        return np.asarray(scipy.fft.irfft2(np.abs(scipy.fft.rfft2(values, shape)) ** 2, shape))

    counts = np.maximum(correlate(np.ones_like(heights)), 1.0)
    areal = correlate(heights) / counts
    areal = areal / areal[0, 0]
    step = min(found.spacing, found.spacing_lines)
    dy, dx = math.sin(angle) * step / found.spacing_lines, math.cos(angle) * step / found.spacing
    reach = min(used.shape[0] / (2.0 * abs(dy) + 1e-9), used.shape[1] / (2.0 * abs(dx) + 1e-9))
    lags = np.arange(int(reach))
    values = scipy.ndimage.map_coordinates(areal, [lags * dy, lags * dx], order=1, mode="grid-wrap")
    below = np.flatnonzero(values < math.exp(-1.0))
    if not len(below):
        return math.nan
    i = int(below[0])
    return float(step * (i - 1 + (values[i - 1] - math.exp(-1.0)) / (values[i - 1] - values[i])))


def power_spectrum(lines: FloatArray, spacing: float, short: float, long: float) -> tuple[FloatArray, FloatArray]:
    """Spatial frequency [1/m] and one-sided power spectral density [m^3] of lines, mean in bins between cut-offs.

    Periodograms with a Hann window, mean of all lines, as by `scipy.signal.periodogram`.

    lines: heights, shape (lines, n) [m].
    spacing, short, long: [m].
    """
    frequency, density = scipy.signal.periodogram(lines, 1.0 / spacing, "hann", detrend="constant")
    edges = np.geomspace(1.0 / long, 1.0 / short, SPECTRUM_BINS + 1)
    inside = np.digitize(frequency, edges)
    mean = density.mean(axis=0)
    filled = [k for k in range(1, SPECTRUM_BINS + 1) if (inside == k).any()]
    return tuple(np.array([values[inside == k].mean() for k in filled]) for values in (frequency, mean))  # type: ignore[return-value]


def rms_slope(heights: FloatArray, spacing: float) -> float:
    """Rdq of a profile by the seven-point derivative of ISO 4287 [-]."""
    z = heights
    slope = (z[6:] - 9.0 * z[5:-1] + 45.0 * z[4:-2] - 45.0 * z[2:-4] + 9.0 * z[1:-5] - z[:-6]) / (60.0 * spacing)
    return float(np.sqrt(np.mean(slope**2)))


def mean_spacing(heights: FloatArray, spacing: float) -> float:
    """RSm of a profile [m]; nan for fewer than two elements.

    Peak and valley of an element are at least 5 % of the total height above and below the mean line.
    """
    z = heights - heights.mean()
    least = 0.1 * float(np.ptp(z)) / 2.0
    state = np.where(z > least, 1, np.where(z < -least, -1, 0))
    signs = state[state != 0]
    places = np.flatnonzero(state != 0)
    rises = places[1:][(signs[1:] > 0) & (signs[:-1] < 0)]
    return float(spacing * (rises[-1] - rises[0]) / (len(rises) - 1)) if len(rises) > 1 else math.nan
