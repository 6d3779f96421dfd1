"""Reader of measured profiles and maps: text files and the formats of instruments.

This module reads text with one column of heights and a stated spacing, positions and heights, points x, y, z on a grid,
or a matrix whose size is in the header, and simple formats of maps (.sdf, .gsf). All other files are read by the
optional package SurfaceTopography.
"""

from __future__ import annotations

import contextlib
import io
import math
import re
import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from ehl.common.arrays import FloatArray
from ehl.common.dialect import NumericBlock, numeric_block
from ehl.common.errors import InputError
from ehl.common.files import read_bytes, read_text
from ehl.common.progress import counted
from ehl.common.units import parse_quantity, spellings

MIN_POINTS = 64
UNIFORM_SPACING = 1e-3  # relative deviation of the steps above which a profile is resampled
# of roughness measurements (own choice); a length outside usually has a wrong unit [m]
LENGTH_RANGE = (0.999e-4, 0.1)
MAX_MISSING, LONGEST_GAP = 0.2, 0.02  # largest interpolated shares of the points of a line: all gaps, one gap
# spikes (own choice): deviation from the median of five points, in robust standard deviations of these deviations and
# of the heights; largest share of spikes
SPIKE_DEVIATION, SPIKE_HEIGHT, MAX_SPIKES = 10.0, 1.0, 0.02
ROBUST = 1.4826  # standard deviation of a normal distribution over its median absolute deviation

_HINT = (
    "State it in the header of the file, such as x [mm], height [um], or as unit_x and unit_height (--unit-x, "
    "--unit-height; in a contact file profile_unit_x, profile_unit_height)."
)
_EXTRA = 'Formats of instruments are read by SurfaceTopography: pip install "mixed-ehl[roughness]".'
_SPACING = (
    r"spacing|step|increment|interval|resolution|pitch|pixel[ _]?size|calibration|\bdx\b|delta ?x|abstand|schrittweite"
)
_WIDTH, _HEIGHT = r"\bwidth\b|\bbreite\b", r"\bheight\b|\bhöhe\b"
_SIZE = re.compile(r"[-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?")
_VALUE_UNIT = re.compile(r"(?:values?|height|z|werte?|höhen?)[ _-]*(?:units?|einheit(?:en)?)\W+([^\s,;\])\"]+)", re.I)
_ANY_UNIT = re.compile(r"\b(?:units?|einheit(?:en)?)\b\W+(?:der werte\W+)?([^\s,;\])\"]+)", re.I)
_POSITION = re.compile(r"x\b|lateral|position|pos\b|distance|length|weg|abstand", re.I)
_ALTITUDE = re.compile(r"z\b|height|profile?\b|raw|h(ö|oe)he|amplitude|primary|total|p\b|r\b", re.I)
_PLACEHOLDERS = (999.0, 9999.0, 99999.0, 32767.0, 32768.0)  # sizes of numbers that stand for a missing height
MIN_FILLED = 0.5  # share of the points of a grid that are given at least


class _OtherFormat(InputError):
    """A text without a table for this module; SurfaceTopography may read it."""


@dataclass(frozen=True, eq=False)
class MeasuredHeights:
    """Measured heights of a profile or map on equidistant positions.

    name: name of the file.
    heights (lines, n): heights along x [m]; nan for missing points.
    spacing, spacing_lines: distance of the points of a line, and of the lines [m]; the latter is nan for a profile.
    unit: unit of the heights in the file.
    notes: processing steps.
    missing, spikes: number of points interpolated by `cleaned`.
    """

    name: str
    heights: FloatArray
    spacing: float
    spacing_lines: float = math.nan
    unit: str = "m"
    notes: tuple[str, ...] = ()
    missing: int = 0
    spikes: int = 0

    def __post_init__(self) -> None:
        count = self.heights.shape[1]
        if count < MIN_POINTS:
            raise InputError("profile", self.name, f"at least {MIN_POINTS} points", f"The file has {count}.")
        length = self.spacing * count
        if not LENGTH_RANGE[0] <= length <= LENGTH_RANGE[1]:
            hint = "Check the unit of the positions."
            raise InputError("profile", f"{self.name}, {length:.3g} m long", "a length of 0.1 mm to 100 mm", hint)

    @property
    def is_map(self) -> bool:
        """Whether there is more than one line."""
        return len(self.heights) > 1

    @property
    def x(self) -> FloatArray:
        """Positions along a line, shape (n,) [m]."""
        return np.asarray(self.spacing * np.arange(self.heights.shape[1]), dtype=np.float64)

    def cleaned(self) -> MeasuredHeights:
        """Heights with interpolated gaps and spikes, and their numbers.

        A spike deviates from the median of the five points about it by more than ten robust standard deviations of such
        deviations, and by more than the robust standard deviation of the heights.

        Raises `InputError`: more than 20 % of a profile are missing, 2 % in one gap, or more than 2 % are spikes. Such
            lines of a map are excluded instead.
        """
        kept, missing, spikes, refused = [], 0, 0, ""
        for line in self.heights:
            gap = ~np.isfinite(line)
            run = _longest_run(gap)
            if gap.mean() > MAX_MISSING or run > max(3.0, LONGEST_GAP * len(line)):
                refused = f"{gap.sum()} of {len(line)} points are missing, {run} of them in a row"
                continue
            whole = _filled(line, gap)
            spike = _spikes(whole)
            if spike.mean() > MAX_SPIKES:
                refused = f"{spike.sum()} of {len(line)} points are spikes"
                continue
            kept.append(_filled(whole, spike))
            missing, spikes = missing + int(gap.sum()), spikes + int(spike.sum())
        if len(kept) < max(1, len(self.heights) / 2):
            allowed = "at most 20 % missing points, 2 % of them in a row, and 2 % spikes"
            raise InputError("profile", self.name, allowed, f"{refused}.")
        out = len(self.heights) - len(kept)
        steps = (
            (missing, f"{counted(missing, 'missing point')} interpolated"),
            (spikes, f"{counted(spikes, 'spike')} interpolated"),
            (out, f"{out} of {len(self.heights)} lines excluded because of too many gaps or spikes"),
        )
        notes = (*self.notes, *(text for count, text in steps if count))
        return replace(self, heights=np.array(kept), notes=notes, missing=missing, spikes=spikes)


def _longest_run(marked: NDArray[np.bool_]) -> int:
    ends = np.flatnonzero(np.diff(np.concatenate([[0], marked.astype(np.int8), [0]])))
    return int(np.max(ends[1::2] - ends[::2], initial=0))


def _filled(line: FloatArray, gap: NDArray[np.bool_]) -> FloatArray:
    place = np.arange(len(line))
    return np.where(gap, np.interp(place, place[~gap], line[~gap]), line).astype(np.float64)


def _spikes(line: FloatArray) -> NDArray[np.bool_]:
    place = np.linspace(-1.0, 1.0, len(line))
    level = line - np.polynomial.Polynomial.fit(place, line, 2)(place)
    off = np.abs(line - scipy.ndimage.median_filter(line, 5, mode="nearest"))
    height = ROBUST * np.median(np.abs(level - np.median(level)))
    return np.asarray(off > max(SPIKE_DEVIATION * ROBUST * float(np.median(off)), SPIKE_HEIGHT * float(height)))


def read_heights(path: str | Path, *, unit_x: str = "", unit_height: str = "") -> MeasuredHeights:
    """Heights of a profile or map from a text or instrument file.

    path: file of the measurement.
    unit_x, unit_height: units such as "mm" and "um" of a text file; they take precedence over its header.
    Raises `InputError`: the file is missing or cannot be read, has no unit, fewer than 64 points or an implausible
        length, or its positions do not increase.
    """
    content = read_bytes(path, "profile", "an existing file")
    try:
        found = simple_map(str(path), content)
    except InputError as error:
        return read_topography(path, unit_height, error)
    if found is not None:
        heights, step, between, unit = found
        return MeasuredHeights(str(path), heights, step, between if len(heights) > 1 else math.nan, unit)
    try:
        text = read_text(path, "profile", "a file of text with two columns")
    except InputError as error:
        return read_topography(path, unit_height, error)
    text = re.sub(r"\bno data\b", "nan", text, flags=re.IGNORECASE)
    try:
        block = numeric_block(text)
        if len(block.rows) < 4:
            hint = "The file has no lines of numbers."
            raise _OtherFormat("profile", str(path), "a table of positions and heights", hint)
        return _Text(str(path), text, block, unit_x, unit_height).heights()
    except _OtherFormat as error:
        return read_topography(path, unit_height, error)


class _Text:
    """A table of numbers with its header."""

    def __init__(self, name: str, text: str, block: NumericBlock, unit_x: str, unit_height: str) -> None:
        self.name, self.block = name, block
        self.header = "\n".join(block.header)
        self.given = unit_x, unit_height
        self._require_one_table(text)

    def _require_one_table(self, text: str) -> None:
        """Reject numbers after the block, or rows of another width in it, which follow a line that is not numeric."""
        dialect, block = self.block.dialect, self.block
        widths = [len(row) for row in block.rows]
        width = max(set(widths), key=widths.count)
        lines = text.splitlines()
        for number, row in zip(block.numbers, block.rows, strict=True):
            if len(row) > width:
                hint = f"Line {number} has {len(row)} cells: {lines[number - 1][:60]!r}."
                raise _OtherFormat("profile", self.name, "rows of one width", hint)
            row += [""] * (width - len(row))
        behind = (dialect.cells(line) for line in lines[block.last :])
        if any(len(cells) == width and cells[0] and dialect.is_numeric(cells[0]) for cells in behind):
            hint = f"Line {block.last + 1} reads {lines[block.last][:60]!r}."
            raise _OtherFormat("profile", self.name, "numbers", hint)

    def _refused(self, allowed: str, hint: str) -> InputError:
        return InputError("profile", self.name, allowed, hint)

    def heights(self) -> MeasuredHeights:
        """The table as positions and heights, by the number of its columns."""
        rows = zip(self.block.rows, self.block.numbers, strict=True)
        data = np.array([[self._value(cell, number) for cell in row] for row, number in rows])
        width = data.shape[1]
        if width == 1:
            return self._column(_without_placeholders(data[:, 0]))
        if width >= 8 and not re.search(r"[\[(]", self.header.splitlines()[-1] if self.header else ""):
            return self._matrix(_without_placeholders(data))
        if width == 3 and (grid := _grid(_without_placeholders(data[:, 2]), *data[:, :2].T)) is not None:
            values, dx, dy = grid
            unit_x, unit = self._units(3, 0, 2)
            scale = self._scale(unit_x, "unit_x")
            values = values * self._scale(unit, "unit_height")
            return MeasuredHeights(self.name, values, dx * scale, dy * scale, unit)
        x, z = self._named_columns(width)
        return self._trace(data[:, x], _without_placeholders(data[:, z]), x, *self._units(width, x, z))

    def _value(self, cell: str, number: int) -> float:
        try:
            return float(self.block.dialect.number(cell) or 0.0) if cell else math.nan
        except InputError as error:
            raise self._refused(error.allowed, f"Line {number}: {cell!r}: {error.hint}") from None

    def _named_columns(self, width: int) -> tuple[int, int]:
        """Columns of position and height, by the nearest line of heads; of two columns without heads in this order."""
        for line in reversed(self.block.header):
            heads = self._heads(line, width)
            x = next((k for k, head in enumerate(heads) if _POSITION.match(head)), None)
            z = next((k for k, head in enumerate(heads) if _ALTITUDE.match(head)), None)
            if x is not None and z is not None:
                return x, z
        if width == 2:
            return 0, 1
        hint = f"The table that begins in line {self.block.first} has {width} columns."
        raise _OtherFormat("profile", self.name, "two columns, position and height, or columns named x and z", hint)

    def _heads(self, line: str, width: int) -> list[str]:
        line = line.lstrip("#% ")
        heads = self.block.dialect.cells(line)
        if len(heads) != width:
            heads = next((cut for cut in (re.split(r"\s{2,}|\t|[,;]", line), line.split()) if len(cut) == width), [])
        return [head.strip() for head in heads]

    def _units(self, count: int, x: int, z: int) -> tuple[str, str]:
        """Units of the columns x and z: as given, of their heads, or as stated for all; empty where there is none."""
        found = [""] * count
        for line in reversed(self.block.header):
            brackets = re.findall(r"[\[(]\s*([^\])]+?)\s*[\])]", line)
            units = brackets if len(brackets) == count else [_unit_of(head) for head in self._heads(line, count)]
            if any(units):
                found = units
                break
        stated = self._stated_unit()
        return self.given[0] or found[x] or stated, self.given[1] or found[z] or stated

    def _lengths(self, words: str) -> list[float]:
        """Lengths that the header states in lines with one of some words, such as ``Width: 240 um`` [m]."""
        found = []
        for line in self.block.header:
            match = re.search(words, line, re.I)
            number = _SIZE.search(line, match.end()) if match else None
            if match is None or number is None:
                continue
            between = re.findall(r"[\[(]([^\])]+)", line[match.end() : number.start()])
            after = re.split(r"[\s,;\"]+", line[number.end() :].lstrip(' \t,;"'))
            unit = (between or after)[0].strip()
            unit = _unit_of(unit) or self.given[0]
            if unit:
                found.append(float(number[0].replace(",", ".")) * self._scale(unit, "unit_x"))
        return found

    def _scale(self, unit: str, field: str) -> float:
        if not unit:
            raise _OtherFormat(field, None, "a length unit such as 'um'", _HINT)
        known = _unit_of(unit)
        return parse_quantity(f"1 {known or unit}", "m", field=field)

    def _trace(
        self, positions: FloatArray, heights: FloatArray, column: int, unit_x: str, unit_height: str
    ) -> MeasuredHeights:
        scale = self._scale(unit_x, "unit_x")
        x, z = positions * scale, heights * self._scale(unit_height, "unit_height")
        if not np.isfinite(x).all():
            raise self._refused("a position for each height", f"{(~np.isfinite(x)).sum()} positions are missing.")
        if x[0] > x[-1]:
            x, z = x[::-1], z[::-1]
        printed = [row[column].strip('"').lower() for row in self.block.rows]
        decimals = max(len(re.split("[.,]", cell)[-1]) if re.search("[.,]", cell) else 0 for cell in printed)
        rounding = 0.0 if any("e" in cell for cell in printed) else scale * 10.0**-decimals
        even = x[0] + (x[-1] - x[0]) * np.arange(len(x)) / (len(x) - 1)
        if len(x) >= MIN_POINTS and x[-1] > x[0] and np.max(np.abs(x - even)) < 1.01 * rounding:
            return even_trace(self.name, even, z, unit_height)  # uneven only as printed, with too few decimals
        backward = np.flatnonzero(np.diff(x) <= 0.0)
        if len(x) >= MIN_POINTS and len(backward):
            line = self.block.numbers[backward[0] + 1]
            hint = f"The position of point {backward[0] + 2} (line {line}) is not larger than the previous one."
            raise self._refused("increasing positions", hint)
        return even_trace(self.name, x, z, unit_height)

    def _column(self, values: FloatArray) -> MeasuredHeights:
        spacing = self._lengths(_SPACING)
        if not spacing:
            allowed = "positions and heights, or a spacing in the header such as 'spacing: 0.5 um'"
            raise _OtherFormat("profile", self.name, allowed, "The file has one column.")
        unit = self.given[1] or self._stated_unit()
        return MeasuredHeights(self.name, values[None, :] * self._scale(unit, "unit_height"), spacing[0], unit=unit)

    def _stated_unit(self) -> str:
        """Unit of the heights that the header states; empty if there is none."""
        stated = [found[1] for pattern in (_VALUE_UNIT, _ANY_UNIT) if (found := pattern.search(self.header))]
        heads = [_unit_of(line) for line in reversed(self.block.header) if _ALTITUDE.match(line)]
        return next(filter(_unit_of, (*stated, *heads)), "")

    def _matrix(self, data: FloatArray) -> MeasuredHeights:
        rows, columns = data.shape
        sizes = [self._lengths(words) for words in (_WIDTH, _HEIGHT)]
        steps = self._lengths(_SPACING)
        if all(sizes):
            steps = [sizes[0][0] / columns, sizes[1][0] / rows]
        unit = self.given[1] or self._stated_unit()
        if not steps or not unit:
            hint = (
                f"The table that begins in line {self.block.first} has {columns} columns. The header of a map "
                "states its size or spacing, and its unit: '# Width: 240 um', '# Height: 240 um', '# Value units: m'."
            )
            raise _OtherFormat("profile", self.name, "two columns, position and height, or a map", hint)
        return MeasuredHeights(self.name, data * self._scale(unit, "unit_height"), steps[0], steps[-1], unit)


def _unit_of(text: str) -> str:
    """Length unit at the end of a head such as ``Lateral um``, ``x/mm``, ``z_um``, ``Raw Micrometer``; "" if none."""
    known = spellings("m")
    word = re.split(r"[\s/_:\[(]+", text.strip(" ])"))[-1].replace("\u00b5", "u").replace("\u03bc", "u")
    return next((name for name in (word, word.lower()) if name in known), "")


def _without_placeholders(values: FloatArray) -> FloatArray:
    """Heights with nan instead of a number such as -9999, where it is far beyond all others."""
    size = np.abs(values)
    for number in _PLACEHOLDERS:
        meant = size == number
        if meant.any() and not meant.all() and number > 10.0 * np.nanmax(size[~meant]):
            return np.where(meant, math.nan, values)
    return values


def _grid(heights: FloatArray, x: FloatArray, y: FloatArray) -> tuple[FloatArray, float, float] | None:
    """Points as lines along x, and both spacings; None where they are not on a grid."""
    columns, lines = np.unique(x), np.unique(y)
    size = len(columns) * len(lines)
    if min(len(columns), len(lines)) < 2 or not MIN_FILLED * size <= len(heights) <= size:
        return None
    found = np.full((len(lines), len(columns)), math.nan)
    found[np.searchsorted(lines, y), np.searchsorted(columns, x)] = heights
    return found, float(np.ptp(columns)) / (len(columns) - 1), float(np.ptp(lines)) / (len(lines) - 1)


def even_trace(name: str, x: FloatArray, heights: FloatArray, unit: str = "m") -> MeasuredHeights:
    """Profile on equidistant positions; `InputError` if a step exceeds 10 times the mean."""
    if len(x) < MIN_POINTS:
        raise InputError("profile", name, f"at least {MIN_POINTS} points", f"The file has {len(x)}.")
    steps, mean = np.diff(x), (x[-1] - x[0]) / (len(x) - 1)
    spread = float(np.max(np.abs(steps / mean - 1.0)))
    if spread <= UNIFORM_SPACING:
        return MeasuredHeights(name, heights[None, :], float(mean), unit=unit)
    if spread > 9.0:
        allowed = f"steps of at most 10 times their mean ({mean:.3g} m)"
        raise InputError("profile", f"{name}, largest step {steps.max():.3g} m", allowed, "Points are missing.")
    even = x[0] + mean * np.arange(len(x))
    note = f"resampled: steps differed from their mean by up to {100 * spread:.0f} %"
    return MeasuredHeights(name, np.interp(even, x, heights)[None, :], float(mean), unit=unit, notes=(note,))


def read_topography(path: str | Path, unit: str = "", own: InputError | None = None) -> MeasuredHeights:
    """Heights of an instrument file, read by the optional package SurfaceTopography.

    path: file of the measurement.
    unit: unit of lengths and heights, for a file that does not state one.
    own: error of the text reader, raised if the package cannot read the file either.
    """
    name = str(path)
    read_bytes(path, "profile", "an existing file")  # other readers would block on a named pipe
    try:
        with warnings.catch_warnings(action="ignore", category=ImportWarning):  # it warns without the optional mpi4py
            import SurfaceTopography
    except ImportError:
        allowed = "a text file with positions and heights, or an instrument file with SurfaceTopography installed"
        problem = own or InputError("profile", name, allowed)
        raise _with_hint(problem, _EXTRA) from None
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            topography: Any = SurfaceTopography.read_topography(name)
        profile = topography.dim == 1
        extent = topography.positions_and_heights() if profile else (topography.physical_sizes, topography.heights())
        lengths, heights = map(_plain, extent)  # positions, or both sizes of a map
    except Exception as error:  # its readers raise errors of many kinds
        hint = f"SurfaceTopography cannot read the file ({type(error).__name__})."
        problem = own or InputError("profile", name, "a format of SurfaceTopography")
        raise _with_hint(problem, hint) from None
    stated = unit or topography.unit
    if not stated or topography.physical_sizes is None:
        raise own or InputError("profile", name, "a file with its size and length unit", _HINT)
    scale = parse_quantity(f"1 {_unit_of(str(stated)) or stated}", "m", field="unit")
    note = "read by SurfaceTopography"
    if profile:
        found = even_trace(name, scale * lengths, scale * heights, str(stated))
        return replace(found, notes=(note, *found.notes))
    step, between = scale * lengths / np.array(heights.shape)
    return MeasuredHeights(name, scale * heights.T, float(step), float(between), str(stated), (note,))


def _with_hint(problem: InputError, hint: str) -> InputError:
    return InputError(problem.field, problem.value, problem.allowed, f"{problem.hint} {hint}".strip())


def _plain(values: Any) -> FloatArray:
    """Array with nan for missing points."""
    return np.asarray(np.ma.filled(np.ma.asarray(values, dtype=float), math.nan))


# simple formats of maps: text after ISO 25178-71 (.sdf), and Gwyddion Simple Field (.gsf)
_SDF, _GSF = re.compile(rb"a(ISO|BCR)-1\.\d"), b"Gwyddion Simple Field 1."
_MOST = 100_000_000  # points of a map


def simple_map(name: str, content: bytes) -> tuple[FloatArray, float, float, str] | None:
    """Heights (lines, n) [m], spacing of points and lines [m], and unit in the file; None for another format.

    Raises `InputError`: the file has one of the formats, but is incomplete.
    """
    try:
        if _SDF.match(content.lstrip()[:8]):
            return _sdf(content.decode("latin-1"))
        if content.startswith(_GSF):
            return _gsf(content)
    except (ValueError, KeyError, IndexError) as error:
        hint = f"{type(error).__name__}: {error}."
        raise InputError("profile", name, "a complete map with its size, spacing and heights", hint) from None
    return None


def _header(text: str) -> dict[str, str]:
    pairs = (line.partition("=") for line in text.splitlines() if "=" in line)
    return {key.strip().casefold(): value.split(";")[0].strip() for key, _, value in pairs}


def _shape(lines: str, points: str) -> tuple[int, int]:
    shape = int(lines), int(points)
    if min(shape) < 1 or shape[0] * shape[1] > _MOST:
        raise ValueError(f"{shape[0]} x {shape[1]} points")
    return shape


def _sdf(text: str) -> tuple[FloatArray, float, float, str]:
    """Header, heights and trailer, each ended by an asterisk; scales in metres, BAD for a missing height."""
    head, body = re.split(r"^\s*\*\s*$", text, maxsplit=2, flags=re.MULTILINE)[:2]
    given = _header(head)
    shape = _shape(given["numprofiles"], given["numpoints"])
    values = [math.nan if word.casefold() == "bad" else float(word) for word in body.split()]
    heights = float(given["zscale"]) * np.array(values).reshape(shape)
    return heights, float(given["xscale"]), float(given["yscale"]), "m"


def _gsf(content: bytes) -> tuple[FloatArray, float, float, str]:
    """Header, one to four zero bytes up to a multiple of four, and 32-bit numbers of the lowest byte first."""
    end = content.index(b"\0")
    given = _header(content[:end].decode("utf-8"))
    lines, points = _shape(given["yres"], given["xres"])
    data = np.frombuffer(content, "<f4", lines * points, end + 4 - end % 4)
    unit = given.get("zunits", "m") or "m"
    lateral = parse_quantity(f"1 {given.get('xyunits', 'm') or 'm'}", "m", field="unit_x")
    sizes = (lateral * float(given.get(name, "1")) for name in ("xreal", "yreal"))
    dx, dy = (size / count for size, count in zip(sizes, (points, lines), strict=True))
    heights = parse_quantity(f"1 {unit}", "m", field="unit_height") * data.astype(np.float64).reshape(lines, points)
    return heights, dx, dy, unit
