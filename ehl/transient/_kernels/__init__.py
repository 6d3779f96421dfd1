"""Compiled kernels of the transient solver, one module per physical step.

Scaled variables throughout: x in Hertz half-widths b, pressure in p_h, film in the film unit of the run
(`ehl.transient.scaling`); time in steps of dx/u_r.
"""

from __future__ import annotations

import contextlib
from pathlib import Path


def drop_outdated_cache(folder: Path) -> int:
    """Remove compiled kernels older than any source of the folder; returns how many.

    The compiler's cache looks at the file of a function only. A kernel keeps what it calls inlined, so after an edit
    of one module the others would go on with its old code.
    """
    newest = max(source.stat().st_mtime for source in folder.glob("*.py"))
    dropped = 0
    for index in (folder / "__pycache__").glob("*.nbi"):
        with contextlib.suppress(OSError):  # another process was faster, or the installation is read-only
            if index.stat().st_mtime < newest:
                index.unlink()
                dropped += 1
    return dropped


drop_outdated_cache(Path(__file__).parent)
