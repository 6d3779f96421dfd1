"""Reader of measured profiles and maps: text files and the formats of instruments.

This module reads text with one column of heights and a stated spacing, positions and heights, points x, y, z on a grid,
or a matrix whose size is in the header. All other files are read by the optional package SurfaceTopography.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from ehl.common.dialect import NumericBlock, numeric_block
from ehl.common.errors import InputError
from ehl.common.files import read_bytes, read_text
from ehl.common.units import parse_quantity, spellings

FloatArray = NDArray[np.float64]

MIN_POINTS = 64
UNIFORM_SPACING = 1e-3  # relative deviation of the steps above which a profile is resampled
# of roughness measurements (own choice); a length outside usually has a wrong unit [m]
LENGTH_RANGE = (0.999e-4, 0.1)
MAX_MISSING, LONGEST_GAP = 0.2, 0.02  # largest interpolated shares of the points of a line: all gaps, one gap
# spikes (own choice): deviation from the median of five points, in robust standard deviations of these deviations and
# of the heights; largest share of spikes
SPIKE_DEVIATION, SPIKE_HEIGHT, MAX_SPIKES = 10.0, 1.0, 0.02
ROBUST = 1.4826  # standard deviation of a normal distribution over its median absolute deviation

_HINT = "Set profile_unit_x and profile_unit_height, or add the units to the header of the file: x [mm], height [um]."
_EXTRA = 'Formats of instruments are read by SurfaceTopography: pip install "mixed-ehl[roughness]".'
_SIZE = r"[^\d\n]{0,20}?([-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?)\s*([^\d\s,;]+)"
_SPACING = re.compile(rf"(?:spacing|step|increment|interval|resolution|pitch|\bdx\b|delta ?x){_SIZE}", re.I)
_WIDTH, _HEIGHT = (re.compile(rf"\b{word}\b{_SIZE}", re.I) for word in ("width", "height"))
_VALUE_UNIT = re.compile(r"(?:value|height|z)[ _-]*units?\W+([^\s,;\])]+)", re.I)
_ANY_UNIT = re.compile(r"\bunits?\W+([^\s,;\])]+)", re.I)
_POSITION = re.compile(r"x\b|lateral|position|pos\b|distance|length|weg|abstand", re.I)
_ALTITUDE = re.compile(r"z\b|height|profile?\b|raw|h(ö|oe)he|amplitude", re.I)


class _OtherFormat(InputError):
    """A text without a table for this module; SurfaceTopography may read it."""


@dataclass(frozen=True, eq=False)
class MeasuredHeights:
    """Measured heights of a profile or map on equidistant positions.

    Parameters
    ----------
    name : str
        Name of the file.
    heights : ndarray, shape (lines, n)
        Heights along x [m]; nan for missing points.
    spacing, spacing_lines : float
        Distance of the points of a line, and of the lines [m]; the latter is nan for a profile.
    unit : str
        Unit of the heights in the file.
    notes : tuple of str
        Processing steps.
    missing, spikes : int
        Number of points interpolated by `cleaned`.
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

        Raises
        ------
        InputError
            More than 20 % of a profile are missing, 2 % in one gap, or more than 2 % are spikes. Such lines of a map
            are excluded instead.
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
        notes = list(self.notes)
        if missing:
            notes.append(f"{missing} missing points interpolated")
        if spikes:
            notes.append(f"{spikes} spikes interpolated")
        out = len(self.heights) - len(kept)
        if out:
            notes.append(f"{out} of {len(self.heights)} lines excluded because of too many gaps or spikes")
        return replace(self, heights=np.array(kept), notes=tuple(notes), missing=missing, spikes=spikes)


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

    Parameters
    ----------
    path : str or Path
        File of the measurement.
    unit_x, unit_height : str
        Units such as "mm" and "um" of a text file; they take precedence over its header.

    Raises
    ------
    InputError
        The file is missing or cannot be read, has no unit, fewer than 64 points or an implausible length, or its
        positions do not increase.
    """
    try:
        text = read_text(path, "profile", "a file of text with two columns", any_encoding=True)
    except InputError as error:
        return read_topography(path, unit_height, error)
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
                raise self._refused("rows of one width", hint)
            row += [""] * (width - len(row))
        behind = (dialect.cells(line) for line in lines[block.last :])
        if any(len(cells) == width and cells[0] and dialect.is_numeric(cells[0]) for cells in behind):
            raise self._refused("numbers", f"Line {block.last + 1} is {lines[block.last][:60]!r}.")

    def _refused(self, allowed: str, hint: str) -> InputError:
        return InputError("profile", self.name, allowed, hint)

    def heights(self) -> MeasuredHeights:
        """The table as positions and heights, by the number of its columns."""
        rows = zip(self.block.rows, self.block.numbers, strict=True)
        data = np.array([[self._value(cell, number) for cell in row] for row, number in rows])
        if data.shape[1] == 1:
            return self._column(data[:, 0])
        if data.shape[1] == 2:
            return self._trace(data[:, 0], data[:, 1], *self._units(2))
        if data.shape[1] >= 8 and not re.search(r"[\[(]", self.header.splitlines()[-1] if self.header else ""):
            return self._matrix(data)
        if data.shape[1] == 3 and (grid := _grid(data)) is not None:
            x, z = self._units(2) if len(self._found(3)) != 3 else (self._found(3)[0], self._found(3)[2])
            x, z = self.given[0] or x, self.given[1] or z
            values, dx, dy = grid
            scale = self._scale(x, "unit_x")
            return MeasuredHeights(self.name, values * self._scale(z, "unit_height"), dx * scale, dy * scale, z)
        columns, heads = self._named_columns(data.shape[1])
        found = self._found(data.shape[1]) or [_unit_of(head) for head in heads]
        x, z = (found[k] for k in columns)
        return self._trace(data[:, columns[0]], data[:, columns[1]], self.given[0] or x, self.given[1] or z)

    def _value(self, cell: str, number: int) -> float:
        try:
            return float(self.block.dialect.number(cell) or 0.0) if cell else math.nan
        except InputError as error:
            raise self._refused(error.allowed, f"Line {number}: {cell!r}: {error.hint}") from None

    def _named_columns(self, width: int) -> tuple[list[int], list[str]]:
        """Columns of position and height of a wider table, and all heads, from the line closest to the numbers."""
        for line in reversed(self.block.header):
            heads = self._heads(line, width)
            x = next((k for k, head in enumerate(heads) if _POSITION.match(head)), None)
            z = next((k for k, head in enumerate(heads) if _ALTITUDE.match(head)), None)
            if x is not None and z is not None:
                return [x, z], heads
        hint = f"The table that begins in line {self.block.first} has {width} columns."
        raise _OtherFormat("profile", self.name, "two columns, position and height, or columns named x and z", hint)

    def _heads(self, line: str, width: int) -> list[str]:
        line = line.lstrip("#% ")
        heads = self.block.dialect.cells(line)
        if len(heads) != width:
            heads = next((cut for cut in (re.split(r"\s{2,}|\t|[,;]", line), line.split()) if len(cut) == width), [])
        return [head.strip() for head in heads]

    def _units(self, count: int) -> tuple[str, str]:
        found = self._found(count)
        x, z = (found[0], found[-1]) if found else ("", "")
        stated = _VALUE_UNIT.search(self.header) or _ANY_UNIT.search(self.header)
        default = stated[1] if stated else ""
        return self.given[0] or x or default, self.given[1] or z or default

    def _found(self, count: int) -> list[str]:
        """Units of all columns from the header line with units that is closest to the numbers."""
        for line in reversed(self.block.header):
            brackets = re.findall(r"[\[(]\s*([^\])]+?)\s*[\])]", line)
            if len(brackets) == count:
                return brackets
            units = [_unit_of(head) for head in self._heads(line, count)]
            if units and all(units):
                return units
        return []

    def _scale(self, unit: str, field: str) -> float:
        if not unit:
            raise _OtherFormat(field, "", "a length unit such as 'um'", _HINT)
        known = _unit_of(unit)
        return parse_quantity(f"1 {known or unit}", "m", field=field)

    def _trace(self, positions: FloatArray, heights: FloatArray, unit_x: str, unit_height: str) -> MeasuredHeights:
        x = positions * self._scale(unit_x, "unit_x")
        z = heights * self._scale(unit_height, "unit_height")
        if not np.isfinite(x).all():
            raise self._refused("a position for each height", f"{(~np.isfinite(x)).sum()} positions are missing.")
        if x[0] > x[-1]:
            x, z = x[::-1], z[::-1]
        backward = np.flatnonzero(np.diff(x) <= 0.0)
        if len(x) >= MIN_POINTS and len(backward):
            line = self.block.numbers[backward[0] + 1]
            hint = f"The position of point {backward[0] + 2} (line {line}) is not larger than the previous one."
            raise self._refused("increasing positions", hint)
        return even_trace(self.name, x, z, unit_height)

    def _column(self, values: FloatArray) -> MeasuredHeights:
        spacing = _SPACING.search(self.header)
        if spacing is None:
            allowed = "positions and heights, or a spacing in the header such as 'spacing: 0.5 um'"
            raise _OtherFormat("profile", self.name, allowed, "The file has one column.")
        step = float(spacing[1].replace(",", ".")) * self._scale(spacing[2], "unit_x")
        unit = self._units(1)[1]
        return MeasuredHeights(self.name, values[None, :] * self._scale(unit, "unit_height"), step, unit=unit)

    def _matrix(self, data: FloatArray) -> MeasuredHeights:
        sizes = [found for found in (_WIDTH.search(self.header), _HEIGHT.search(self.header)) if found]
        stated = _VALUE_UNIT.search(self.header)
        if len(sizes) < 2 or not (stated or self.given[1]):
            hint = (
                f"The table that begins in line {self.block.first} has {data.shape[1]} columns. The header of a map "
                "must contain its size and unit: '# Width: 240 um', '# Height: 240 um', '# Value units: m'."
            )
            raise _OtherFormat("profile", self.name, "two columns, position and height, or a map", hint)
        width, height = (float(size[1].replace(",", ".")) * self._scale(size[2], "unit_x") for size in sizes)
        unit = self.given[1] or (stated[1] if stated else "")
        rows, columns = data.shape
        return MeasuredHeights(self.name, data * self._scale(unit, "unit_height"), width / columns, height / rows, unit)


def _unit_of(text: str) -> str:
    """Length unit at the end of a head such as ``Lateral um``, ``x/mm``, ``z_um``, ``Raw Micrometer``; "" if none."""
    known = spellings("m")
    word = re.split(r"[\s/_:\[(]+", text.strip(" ])"))[-1].replace("\u00b5", "u").replace("\u03bc", "u")
    return next((name for name in (word, word.lower()) if name in known), "")


def _grid(data: FloatArray) -> tuple[FloatArray, float, float] | None:
    """Points x, y, z as lines along x, and both spacings; None if they are not on a grid."""
    x, y = np.unique(data[:, 0]), np.unique(data[:, 1])
    if len(x) * len(y) != len(data) or min(len(x), len(y)) < 2:
        return None
    heights = np.full((len(y), len(x)), math.nan)
    heights[np.searchsorted(y, data[:, 1]), np.searchsorted(x, data[:, 0])] = data[:, 2]
    return heights, float(x[-1] - x[0]) / (len(x) - 1), float(y[-1] - y[0]) / (len(y) - 1)


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

    Parameters
    ----------
    path : str or Path
        File of the measurement.
    unit : str
        Unit of lengths and heights, for a file that does not state one.
    own : InputError, optional
        Error of the text reader, raised if the package cannot read the file either.
    """
    name = str(path)
    read_bytes(path, "profile", "an existing file")  # other readers would block on a named pipe
    try:
        import SurfaceTopography
    except ImportError:
        allowed = "a text file with positions and heights, or an instrument file with SurfaceTopography installed"
        problem = own or InputError("profile", name, allowed)
        raise _with_hint(problem, _EXTRA) from None
    try:
        topography: Any = SurfaceTopography.read_topography(name)
        lengths, heights = _extent(topography)
    except Exception as error:  # its readers raise errors of many kinds
        hint = f"SurfaceTopography cannot read the file ({type(error).__name__})."
        problem = own or InputError("profile", name, "a format of SurfaceTopography")
        raise _with_hint(problem, hint) from None
    stated = unit or topography.unit
    if not stated or topography.physical_sizes is None:
        raise own or InputError("profile", name, "a file with its size and length unit", _HINT)
    scale = parse_quantity(f"1 {_unit_of(str(stated)) or stated}", "m", field="unit")
    note = "read by SurfaceTopography"
    if topography.dim == 1:
        found = even_trace(name, scale * lengths, scale * heights, str(stated))
        return replace(found, notes=(note, *found.notes))
    step, between = scale * lengths / np.array(heights.shape)
    return MeasuredHeights(name, scale * heights.T, float(step), float(between), str(stated), (note,))


def _with_hint(problem: InputError, hint: str) -> InputError:
    return InputError(problem.field, problem.value, problem.allowed, f"{problem.hint} {hint}".strip())


def _extent(topography: Any) -> tuple[FloatArray, FloatArray]:
    """Positions and heights of a profile, or both sizes and the heights of a map."""
    if topography.dim == 1:
        x, heights = topography.positions_and_heights()
        return _plain(x), _plain(heights)
    return np.array(topography.physical_sizes, dtype=float), _plain(topography.heights())


def _plain(values: Any) -> FloatArray:
    """Array with nan for missing points."""
    return np.asarray(np.ma.filled(np.ma.asarray(values, dtype=float), math.nan))
