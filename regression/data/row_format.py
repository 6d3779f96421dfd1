"""Row of a result file: columns with units, and the checksum that detects corrupt rows."""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ehl.common.quantities import si_units
from regression.friction.conditions import LUBRICANT_UNITS, STATE_UNITS

OUTPUT_UNITS = si_units(
    (
        "friction_coefficient",
        "friction_fluid",
        "friction_asperity",
        "film_central",
        "film_min",
        "pressure_max",
        "film_ratio",
        "asperity_load_share",
        "roughness_load_share",
        "rolling_traction",
        "temperature_film_max",
        "temperature_flash",
        "film_error",
        "friction_error",
        "mesh_error",
        "statistical_error",
        "friction_boundary_half",
        "friction_boundary_double",
        "iterations",
        "boundary_film",
        "travel",
        "nodes",
        "steps",
    )
)
# of the rough surfaces; a formula may use the correlation length
SURFACE_UNITS = si_units(("boundary_friction", "correlation_length", "peklenik_number", "seed"))
# times differ between runs and are not part of the data
TIMING_UNITS = si_units(("seconds", "seconds_cpu"))
NUMBER_UNITS: dict[str, str] = {
    # the order of the columns is part of the file format
    **{name: unit for name, unit in STATE_UNITS.items() if name not in SURFACE_UNITS},
    # alpha_film follows from the oil card and is not stored
    **{name: unit for name, unit in LUBRICANT_UNITS.items() if name != "pressure_viscosity_film"},
    **SURFACE_UNITS,
    **OUTPUT_UNITS,
    "attempts": "",
    **TIMING_UNITS,
}
TEXT_WIDTHS: dict[str, int] = {"origin": 8, "oil": 48, "status": 12, "reason": 64, "setting": 64, "skipped": 256}
KEY_WIDTH = 64

ROW = np.dtype(
    [
        *((name, "<f8") for name in NUMBER_UNITS),
        *((name, f"S{width}") for name, width in TEXT_WIDTHS.items()),
        ("key", f"S{KEY_WIDTH}"),
    ]
)
Rows = NDArray[np.void]


def pack(rows: Sequence[Mapping[str, Any]]) -> Rows:
    """Rows as a structured array; missing numbers are nan, missing texts are empty."""
    packed = np.zeros(len(rows), ROW)
    for name in NUMBER_UNITS:
        packed[name] = [float(row.get(name, np.nan)) for row in rows]
    for name, width in TEXT_WIDTHS.items():
        packed[name] = [str(row.get(name, "")).encode("ascii", "replace")[:width] for row in rows]
    packed["key"] = [row["key"].encode() for row in rows]
    return packed


def checksums(packed: Rows) -> NDArray[np.uint32]:
    """CRC-32 of every row's bytes, key included."""
    content, size = memoryview(packed.tobytes()), packed.dtype.itemsize
    return np.array([zlib.crc32(content[i : i + size]) for i in range(0, len(content), size)], dtype=np.uint32)
