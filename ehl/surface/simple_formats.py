"""Readers of the simple formats of maps: text after ISO 25178-71 (.sdf), and Gwyddion Simple Field (.gsf)."""

from __future__ import annotations

import math
import re

import numpy as np
from numpy.typing import NDArray

from ehl.common.errors import InputError
from ehl.common.units import parse_quantity

FloatArray = NDArray[np.float64]
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
