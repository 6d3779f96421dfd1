"""Binary STL: the triangles of a solid, in mm."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from efficiency.output.solid import Solid
from ehl.io.errors import InputError

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def write_stl(path: Path, solid: Solid, title: str) -> None:
    """Write a solid as binary STL with mm for its unit.

    Parameters
    ----------
    path : Path
        File to write.
    solid : Solid
        Closed surface.
    title : str
        Goes into the header, cut at 80 bytes.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    corners = solid.points[solid.triangles] * 1e3
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    records = np.zeros(len(corners), _RECORD)
    records["normal"] = np.divide(normal, size, out=np.zeros_like(normal), where=size > 0.0)
    records["corners"] = corners
    # a header that begins with "solid" would be taken for the text format
    header = f"STL in mm: {title}".encode("ascii", "replace")[:80].ljust(80)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(header + np.uint32(len(records)).tobytes() + records.tobytes())
    except OSError as error:
        raise InputError("--stl", str(path), "a writable file", f"{error}.") from None


def read_stl(path: Path) -> np.ndarray[tuple[int, int, int], np.dtype[np.float64]]:
    """Corners of the triangles of a binary STL file, (n, 3, 3), in the unit of the file.

    Raises
    ------
    InputError
        The file is no binary STL.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError("file", str(path), "a readable STL file", f"{error}.") from None
    if len(content) < 84 or len(content) != 84 + _RECORD.itemsize * int(np.frombuffer(content[80:84], "<u4")[0]):
        raise InputError("file", str(path), "a binary STL file", "Its length does not fit its number of triangles.")
    return np.asarray(np.frombuffer(content[84:], _RECORD)["corners"], dtype=np.float64)
