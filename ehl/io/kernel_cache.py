"""Compiled kernels on disk, and which of them are out of date."""

from __future__ import annotations

import contextlib
import hashlib
import os
from pathlib import Path

_FLUID = Path(__file__).resolve().parents[1] / "fluid"
FLUID_LAWS = tuple(_FLUID / name for name in ("_kernels.py", "lookup.py", "rheology.py"))


def drop_outdated_cache(folder: Path, *elsewhere: Path) -> int:
    """Remove compiled kernels older than any source of the folder, or than those elsewhere; returns how many.

    The compiler's cache looks at the file of a function only. A kernel keeps what it calls inlined, so after an edit
    of one module the others would go on with its old code.
    """
    places = [folder / "__pycache__"]
    if shared := os.environ.get("NUMBA_CACHE_DIR"):
        places.append(
            Path(shared) / f"{folder.name}_{hashlib.sha1(str(folder).encode(), usedforsecurity=False).hexdigest()}"
        )
    newest = max(source.stat().st_mtime for source in (*folder.glob("*.py"), *elsewhere))
    dropped = 0
    for index in (index for place in places for index in place.glob("*.nbi")):
        with contextlib.suppress(OSError):  # another process was faster, or the installation is read-only
            if index.stat().st_mtime < newest:
                index.unlink()
                dropped += 1
    return dropped
