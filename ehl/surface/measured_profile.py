"""Checks, levelling and filtering of measured roughness profiles."""

import math
from pathlib import Path

import numpy as np
import scipy

from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.units import UNITS, parse_quantity
from ehl.surface.profile_file import MeasuredHeights, read_heights
from ehl.surface.roughness import RoughProfile

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
        raise InputError("cutoff_short", cutoff_short, f"{2 * step:.3g} to {length / 8:.3g} m for this profile")
    if cutoff_long is not None and not 2.0 * cutoff_short <= cutoff_long <= length:
        raise InputError("cutoff_long", cutoff_long, f"{2 * cutoff_short:.3g} to {length:.3g} m for this profile")
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
    note = f"line {chosen + 1} of {len(rms)} of a map, with the median Rq; 90 % have {low:.3g} to {high:.3g} um"
    return found.heights[chosen], (note,)


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
