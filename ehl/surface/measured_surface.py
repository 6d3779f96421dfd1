"""Measured profiles and maps: checks, levelling, filters, and roughness parameters between cut-offs."""

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
from ehl.common.units import UNITS, ValueRange, parse_quantity
from ehl.surface.profile_file import MeasuredHeights, read_heights
from ehl.surface.roughness import RoughProfile, measured_correlation_length, moments

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
# ISO 16610-21: 50 % transmission at the cut-off wavelength
GAUSSIAN_CONSTANT = math.sqrt(math.log(2.0) / math.pi)
# range of technical surfaces (own choice); values outside usually have a wrong unit
RMS_RANGE, MAX_SLOPE, SLOPE_CUTOFF = (2e-9, 2e-5), 0.5, 2.5e-6


def detrended(heights: FloatArray, order: int = 2) -> FloatArray:
    """Heights minus their least-squares polynomial: order 1 removes a tilt, 2 the form of a flank, cylinder or ball."""
    place = np.linspace(-1.0, 1.0, len(heights))
    return np.asarray(heights - np.polynomial.Polynomial.fit(place, heights, order)(place))


def gaussian_mean_line(heights: FloatArray, spacing: float, cutoff: float) -> FloatArray:
    """Mean line of the Gaussian profile filter, with 50 % transmission at the cut-off wavelength.

    Weights exp(-pi (x/(a lambda_c))^2)/(a lambda_c), a = sqrt(ln 2/pi) (ISO 16610-21). At the ends the weights
    are normalised by their sum inside of the profile.

    heights (n,): heights, equidistant [m].
    spacing, cutoff: [m].
    """
    n = len(heights)
    reach = min(n - 1, math.ceil(1.2 * cutoff / spacing))
    place = spacing * np.arange(-reach, reach + 1)
    weight = np.exp(-math.pi * (place / (GAUSSIAN_CONSTANT * cutoff)) ** 2)
    smoothed, inside = (scipy.signal.fftconvolve(values, weight)[reach : reach + n] for values in (heights, np.ones(n)))
    return np.asarray(smoothed / inside)


def joined_ends(heights: FloatArray, overlap: int) -> FloatArray:
    """Periodic profile, shorter by `overlap` samples, with the end blended into the beginning.

    The weights cos and sin preserve the RMS of uncorrelated heights.
    """
    phase = 0.5 * math.pi * (np.arange(overlap) + 0.5) / overlap
    joined = heights[: len(heights) - overlap].copy()
    joined[:overlap] = np.sin(phase) * heights[:overlap] + np.cos(phase) * heights[len(heights) - overlap :]
    return np.asarray(joined)


def prepared_profile(
    x: FloatArray,
    heights: FloatArray,
    *,
    cutoff_long: float | None,
    cutoff_short: float,
    detrend_order: int = 2,
) -> RoughProfile:
    """Level, filter and resample a measured profile, and join its ends over a tenth of the length.

    The spacing of the result is a fifth of the short cut-off, at least the measured one.

    x, heights (n,): uniform positions and heights [m].
    cutoff_long: lambda_c: longer waves (form and waviness) are removed [m]; None keeps them.
    cutoff_short: lambda_s: shorter waves are removed [m].
    detrend_order: order of the polynomial that is subtracted first.
    Raises `InputError`: a cut-off is out of range for the length and the spacing of the profile.
    """
    step, length = float(x[1] - x[0]), float(x[-1] - x[0])
    if not 2.0 * step <= cutoff_short <= length / 8.0:
        raise InputError("cutoff_short", f"{1e6 * cutoff_short:.3g} um", _window(2.0 * step, length / 8.0))
    if cutoff_long is not None and not 2.0 * cutoff_short <= cutoff_long <= length:
        raise InputError("cutoff_long", f"{1e6 * cutoff_long:.3g} um", _window(2.0 * cutoff_short, length))
    kept = gaussian_mean_line(detrended(heights, detrend_order), step, cutoff_short)
    if cutoff_long is not None:
        kept = kept - gaussian_mean_line(kept, step, cutoff_long)
    kept = kept - np.mean(kept)
    target = max(step, cutoff_short / 5.0)
    if abs(target / step - 1.0) > 1e-6:
        ends = step * (len(kept) - 1)
        place = np.minimum(np.arange(0.0, ends * (1.0 + 1e-12), target), ends)
        kept = scipy.interpolate.CubicSpline(step * np.arange(len(kept)), kept)(place)
        kept, step = kept - np.mean(kept), target
    return RoughProfile.of(joined_ends(kept, len(kept) // 10), step, cutoff=cutoff_short)


def profile_points(
    path: str | Path, *, unit_x: str = "", unit_height: str = ""
) -> tuple[MeasuredHeights, FloatArray, tuple[str, ...]]:
    """Heights of a file [m] with gaps and spikes interpolated, of a map those of one line, and notes.

    `require_plausible` describes the accepted range.
    """
    found = read_heights(path, unit_x=unit_x, unit_height=unit_height).cleaned()
    heights, notes = typical_line(found)
    require_plausible(Path(path).name, found.spacing, heights, found.unit)
    return found, heights, (*found.notes, *notes)


def typical_line(found: MeasuredHeights) -> tuple[FloatArray, tuple[str, ...]]:
    """The line of a map with the median Rq of all lines after removal of the form, and a note on it."""
    if not found.is_map:
        return found.heights[0], ()
    rms = np.array([np.std(detrended(line)) for line in found.heights])
    chosen = int(np.argsort(rms)[len(rms) // 2])
    low, high = 1e6 * np.quantile(rms, (0.05, 0.95))
    note = f"line {chosen + 1} of {len(rms)} of a map, with the median Rq; 90 % have {low:.3g} to {high:.3g} um raw"
    return found.heights[chosen], (note,)


def _window(low: float, high: float) -> str:
    return f"{1e6 * low:.3g} to {1e6 * high:.3g} um for a profile of this length and spacing; state another cut-off"


def require_plausible(name: str, step: float, heights: FloatArray, unit: str) -> None:
    """Check that heights are those of a technical surface; a wrong unit is the usual cause if they are not.

    name: name of the file.
    step, heights (n,): distance of the points and heights [m].
    unit: unit in which the heights were read.
    Raises `InputError`: Rq without the form is not 2 nm to 20 um, or the RMS slope of waves longer than 2.5 um exceeds
        0.5.
    """
    level = detrended(heights)
    rms = float(np.std(level))
    slope = float(np.std(np.diff(gaussian_mean_line(level, step, max(SLOPE_CUTOFF, 2.0 * step))))) / step
    if RMS_RANGE[0] <= rms <= RMS_RANGE[1] and slope <= MAX_SLOPE:
        return
    others = ("nm", "um", "mm", "m")
    factors = {one: UNITS[one][1] / parse_quantity(f"1 {unit}", "m") for one in others}
    meant = [
        one
        for one, factor in factors.items()
        if factor != 1.0 and RMS_RANGE[0] <= factor * rms <= RMS_RANGE[1] and factor * slope <= MAX_SLOPE
    ]
    hint = f" Are the heights in {' or '.join(meant)}?" if meant else " Check the units of positions and heights."
    allowed = f"Rq of 2 nm to 20 um and an RMS slope up to {MAX_SLOPE:g}"
    given = f"{name}: Rq {rms:.3g} m, RMS slope {slope:.3g}"
    raise InputError("profile", given, allowed, f"The heights were read in {unit}.{hint}")


def load_profile(
    path: str | Path,
    *,
    cutoff_long: float | None,
    cutoff_short: float,
    unit_x: str = "",
    unit_height: str = "",
    detrend: int = 2,
) -> RoughProfile:
    """A measured profile from a text or instrument file (`read_heights`), checked and prepared (`prepared_profile`)."""
    found, heights, _ = profile_points(path, unit_x=unit_x, unit_height=unit_height)
    return prepared_profile(found.x, heights, cutoff_long=cutoff_long, cutoff_short=cutoff_short, detrend_order=detrend)


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
            Column("lay_angle", label="angle of the lay to x"),
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
