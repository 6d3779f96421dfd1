"""Measured rough profiles: reading, checking, levelling and filtering with stated cut-offs."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from ehl.common.errors import InputError
from ehl.common.files import read_bytes, read_text
from ehl.common.units import parse_quantity
from ehl.surface.roughness import RoughProfile

FloatArray = NDArray[np.float64]

MIN_POINTS = 64
# ISO 16610-21: half the amplitude passes at the cut-off wavelength
GAUSSIAN_CONSTANT = math.sqrt(math.log(2.0) / math.pi)
# relative; larger steps than this are resampled
UNIFORM_SPACING = 1e-3


def read_profile(
    path: str | Path, *, unit_x: str = "", unit_height: str = ""
) -> tuple[FloatArray, FloatArray, tuple[str, ...]]:
    """Positions and heights from a text file of two columns.

    Columns are parted by comma, semicolon, tab or blanks; with semicolons the decimal comma is understood. Lines that
    begin with ``#`` and the header may carry the units, as in ``x [mm], height [um]``.

    Parameters
    ----------
    path : str or Path
    unit_x, unit_height : str
        Units such as "mm" and "um"; they win over the header. Without either the file is refused.

    Returns
    -------
    x, heights : ndarray, shape (n,)
        [m]; x increasing and uniform.
    notes : tuple of str
        What had to be done (resampling).

    Raises
    ------
    InputError
        The file is missing, unreadable or not two columns; a value is missing or not finite; there are fewer than
        64 points; positions do not increase; a unit is missing or not a length.
    """
    path = Path(path)
    name = str(path)
    text = read_text(path, "profile", "an existing file of text with two columns")
    rows, units = _parse(text, name)
    if len(rows) < MIN_POINTS:
        raise InputError("profile", name, f"at least {MIN_POINTS} points", f"The file has {len(rows)}.")
    data = np.array(rows)
    bad = np.flatnonzero(~np.all(np.isfinite(data), axis=1))
    if len(bad):
        raise InputError(
            "profile",
            name,
            "finite numbers",
            f"{len(bad)} of {len(data)} points are missing or not finite, first point {bad[0] + 1}.",
        )
    x = data[:, 0] * _scale(unit_x or units[0], "unit_x", name)
    heights = data[:, 1] * _scale(unit_height or units[1], "unit_height", name)
    if x[0] > x[-1]:
        x, heights = x[::-1], heights[::-1]
    backward = np.flatnonzero(np.diff(x) <= 0.0)
    if len(backward):
        raise InputError(
            "profile",
            name,
            "positions that increase",
            f"Point {backward[0] + 2} does not lie behind the one before it.",
        )
    return _uniform(x, heights)


def _parse(text: str, name: str) -> tuple[list[tuple[float, float]], tuple[str, str]]:
    units = ("", "")
    rows: list[tuple[float, float]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        content = line.strip()
        if not content:
            continue
        fields = _fields(content.lstrip("#"))
        if content.startswith("#") or (not rows and not _is_number(fields[0])):
            found = re.findall(r"[\[(]\s*([^\])]+?)\s*[\])]", content)
            if len(found) >= 2:
                units = (found[0], found[1])
            continue
        if len(fields) != 2:
            raise InputError(
                "profile",
                name,
                "two columns, position and height",
                f"Line {number} has {len(fields)}: {content[:60]!r}.",
            )
        if not all(_is_number(field) or not field for field in fields):
            raise InputError("profile", name, "numbers", f"Line {number} reads {content[:60]!r}.")
        rows.append(tuple(float(field) if field else math.nan for field in fields))  # type: ignore[arg-type]
    return rows, units


def _fields(line: str) -> list[str]:
    if ";" in line:
        return [part.strip().replace(",", ".") for part in line.split(";")]
    separator = next((mark for mark in (",", "\t") if mark in line), None)
    return [part.strip() for part in line.split(separator)] or [""]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _scale(unit: str, field: str, name: str) -> float:
    if not unit:
        raise InputError(
            field,
            "",
            "a length unit such as 'um'",
            f"Give it, or write it in the header of {name}: x [mm], height [um].",
        )
    return parse_quantity(f"1 {unit.replace('µ', 'u').replace('μ', 'u')}", "m", field=field)


def _uniform(x: FloatArray, heights: FloatArray) -> tuple[FloatArray, FloatArray, tuple[str, ...]]:
    steps = np.diff(x)
    mean = (x[-1] - x[0]) / (len(x) - 1)
    spread = float(np.max(np.abs(steps / mean - 1.0)))
    even = x[0] + mean * np.arange(len(x))
    if spread <= UNIFORM_SPACING:
        return even, heights, ()
    if spread > 9.0:
        raise InputError(
            "profile",
            f"largest step {steps.max():.3g} m",
            f"steps of at most 10 times their mean ({mean:.3g} m)",
            "Points are missing.",
        )
    return (
        even,
        np.interp(even, x, heights),
        (f"resampled: steps differed from their mean by up to {100 * spread:.0f} %",),
    )


def detrended(heights: FloatArray, order: int = 1) -> FloatArray:
    """Heights less their least-squares polynomial (1: tilt, 2: tilt and curvature)."""
    place = np.linspace(-1.0, 1.0, len(heights))
    return np.asarray(heights - np.polynomial.Polynomial.fit(place, heights, order)(place))


def gaussian_mean_line(heights: FloatArray, spacing: float, cutoff: float, *, periodic: bool = False) -> FloatArray:
    """Mean line of the Gaussian profile filter: wavelengths above the cut-off pass, half the amplitude at it.

    Weights exp(-pi (x/(a lambda_c))^2)/(a lambda_c), a = sqrt(ln 2/pi) (ISO 16610-21). At the ends of a profile that is
    not periodic the weights are scaled to their sum inside it.

    Parameters
    ----------
    heights : ndarray, shape (n,)
    spacing, cutoff : float
        [m].
    periodic : bool
    """
    n = len(heights)
    if periodic:
        k = scipy.fft.rfftfreq(n, spacing)
        return np.asarray(
            scipy.fft.irfft(scipy.fft.rfft(heights) * np.exp(-math.pi * (GAUSSIAN_CONSTANT * cutoff * k) ** 2), n)
        )
    reach = min(n - 1, math.ceil(1.2 * cutoff / spacing))
    place = spacing * np.arange(-reach, reach + 1)
    weight = np.exp(-math.pi * (place / (GAUSSIAN_CONSTANT * cutoff)) ** 2)
    size = scipy.fft.next_fast_len(n + 2 * reach)
    spectrum = scipy.fft.rfft(weight, size)

    def smoothed(values: FloatArray) -> FloatArray:
        return np.asarray(scipy.fft.irfft(scipy.fft.rfft(values, size) * spectrum, size)[reach : reach + n])

    return smoothed(heights) / smoothed(np.ones(n))


def joined_ends(heights: FloatArray, overlap: int) -> FloatArray:
    """A periodic profile, shorter by `overlap` samples: the end runs over into the beginning.

    The weights cos and sin keep the RMS of uncorrelated heights.
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
    spacing: float | None = None,
    detrend_order: int = 1,
    periodic: bool = True,
    peklenik_number: float = 1.0,
    source: str = "measured",
    notes: tuple[str, ...] = (),
) -> RoughProfile:
    """Level, filter and resample a measured profile.

    What lies below the short cut-off is taken out of the profile, and its RMS is kept as ``rms_below_cutoff``: it
    belongs to the boundary film (`ehl.surface.roughness.boundary_film`).

    Parameters
    ----------
    x, heights : ndarray, shape (n,)
        Uniform positions and heights [m].
    cutoff_long : float or None
        lambda_c: longer waves are form and waviness and are taken out [m]; None keeps them.
    cutoff_short : float
        lambda_s: shorter waves are taken out and counted [m].
    spacing : float, optional
        Of the result [m]; a fifth of the short cut-off when not given, never finer than measured.
    detrend_order : int
        Order of the polynomial taken out first.
    periodic : bool
        Whether to join the ends over a tenth of the length, for a surface that passes many times.
    peklenik_number, source, notes
        Carried along.

    Raises
    ------
    InputError
        A cut-off is out of range for the length and the spacing of the profile.
    """
    step, length = float(x[1] - x[0]), float(x[-1] - x[0])
    if not 2.0 * step <= cutoff_short <= length / 8.0:
        raise InputError("cutoff_short", cutoff_short, f"{2 * step:.3g} to {length / 8:.3g} m for this profile")
    if cutoff_long is not None and not 2.0 * cutoff_short <= cutoff_long <= length:
        raise InputError("cutoff_long", cutoff_long, f"{2 * cutoff_short:.3g} to {length:.3g} m for this profile")
    if spacing is not None and not 0.0 < spacing <= cutoff_short / 2.2:
        raise InputError("spacing", spacing, f"> 0 and at most {cutoff_short / 2.2:.3g} m")
    level = detrended(heights, detrend_order)
    done = [*notes, f"detrended (order {detrend_order})"]
    kept = gaussian_mean_line(level, step, cutoff_short)
    below = float(np.std(level - kept))
    done.append(f"Gaussian filter, short cut-off {cutoff_short:.3g} m")
    if cutoff_long is not None:
        kept = kept - gaussian_mean_line(kept, step, cutoff_long)
        done.append(f"Gaussian filter, long cut-off {cutoff_long:.3g} m")
    target = max(step, cutoff_short / 5.0) if spacing is None else spacing
    profile = RoughProfile.of(
        kept,
        step,
        cutoff=cutoff_short,
        periodic=False,
        rms_below_cutoff=below,
        peklenik_number=peklenik_number,
        source=source,
        notes=tuple(done),
    )
    if abs(target / step - 1.0) > 1e-6:
        profile = profile.resampled(target)
    if not periodic:
        return profile
    overlap = len(profile.heights) // 10
    return RoughProfile.of(
        joined_ends(np.asarray(profile.heights), overlap),
        profile.spacing,
        cutoff=cutoff_short,
        rms_below_cutoff=below,
        peklenik_number=peklenik_number,
        source=source,
        notes=(*profile.notes, "ends joined over a tenth of the length"),
    )


def profile_points(
    path: str | Path, *, unit_x: str = "", unit_height: str = ""
) -> tuple[FloatArray, FloatArray, tuple[str, ...]]:
    """Positions and heights of a text or profilometer file [m], by its file name."""
    if Path(path).suffix.lower() in (".csv", ".txt", ".dat", ".tsv", ".prn"):
        return read_profile(path, unit_x=unit_x, unit_height=unit_height)
    return read_topography(path)


def load_profile(
    path: str | Path,
    *,
    cutoff_long: float | None,
    cutoff_short: float,
    unit_x: str = "",
    unit_height: str = "",
    spacing: float | None = None,
    periodic: bool = True,
    peklenik_number: float = 1.0,
) -> RoughProfile:
    """A measured profile from a file, prepared; text columns, or a profilometer format by its file name.

    Files ending in csv, txt, dat, tsv or prn are read as text (`read_profile`), others by SurfaceTopography
    (`read_topography`). See `prepared_profile` for the cut-offs.
    """
    x, heights, notes = profile_points(path, unit_x=unit_x, unit_height=unit_height)
    return prepared_profile(
        x,
        heights,
        cutoff_long=cutoff_long,
        cutoff_short=cutoff_short,
        spacing=spacing,
        periodic=periodic,
        peklenik_number=peklenik_number,
        source=f"measured: {Path(path).name}",
        notes=notes,
    )


def read_topography(path: str | Path) -> tuple[FloatArray, FloatArray, tuple[str, ...]]:
    """Positions and heights of a profilometer file, through the optional package SurfaceTopography.

    Of a map the middle line along x is taken.

    Raises
    ------
    InputError
        The package is not installed, the file cannot be read by it, has no physical unit or has missing points.
    """
    try:
        import SurfaceTopography
    except ImportError:
        raise InputError(
            "profile",
            str(path),
            "a text file with two columns, unless SurfaceTopography is installed",
            'Install it with: pip install "mixed-ehl[roughness]".',
        ) from None
    read_bytes(path, "profile", "an existing file")  # readers of other packages would wait for a pipe
    try:
        topography: Any = SurfaceTopography.read_topography(str(path))
    except Exception as error:  # its readers raise errors of many kinds
        raise InputError(
            "profile",
            str(path),
            "a format SurfaceTopography reads",
            f"None of its readers took the file ({type(error).__name__}).",
        ) from None
    if topography.unit is None:
        raise InputError("profile", str(path), "a file that carries its length unit")
    scale = _scale(str(topography.unit), "unit", str(path))
    notes: tuple[str, ...] = ()
    if topography.dim == 1:
        x, heights = (_plain(values) for values in topography.positions_and_heights())
    else:
        grid = _plain(topography.heights())
        heights = grid[:, grid.shape[1] // 2]
        x = np.arange(len(heights)) * (topography.physical_sizes[0] / len(heights))
        notes = ("middle line of a map",)
    if not np.all(np.isfinite(heights)):
        raise InputError(
            "profile", str(path), "a profile without missing points", "Fill them in the instrument's software."
        )
    if len(heights) < MIN_POINTS:
        raise InputError("profile", str(path), f"at least {MIN_POINTS} points", f"The file has {len(heights)}.")
    x, heights, resampled = _uniform(scale * x, scale * heights)
    return x, heights, (*notes, *resampled)


def _plain(values: Any) -> FloatArray:
    """An array with nan where the instrument saw nothing."""
    return np.asarray(np.ma.filled(np.ma.asarray(values, dtype=float), math.nan))
