"""Sources of the kernels, the folder of their compiled code, and a line on the terminal when they are compiled.

The cache of numba checks only the file of a function. A kernel contains the functions it calls, so its code is stored
under the hash of all its sources. Contents are compared, because copies and clocks change the times of files.
"""

import hashlib
import inspect
import multiprocessing
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from numba import config

from ehl.common.private_files import user_folder

_EHL = Path(__file__).resolve().parents[1]
OURS = {_EHL}
_SHARED = (
    *(_EHL / "compile" / name for name in ("compiler.py", "internals.py", "_kernels.py")),
    *(_EHL / "fluid" / name for name in ("_kernels.py", "lookup.py", "rheology.py")),
    _EHL / "heat" / "_kernels.py",
)
# kinds of kernels: for rough contacts, and for all contacts; processor time on a slow core
ROUGH, SMOOTH = "rough", "smooth"
_TAKES = {SMOOTH: "smooth contacts, 5 to 10 s", ROUGH: "rough contacts, half a minute"}
_PLACES = {"ehl.rough": ROUGH}

compiled: list[tuple[str, str]] = []  # kind and name of the kernels compiled by this process
_nested = False


def source_hash(folder: Path) -> bytes:
    """Hash of all sources of the kernels of a folder.

    folder: of the kernels; dense matrices, laws of the fluid, heat and the compiler settings are included.
    Raises `OSError`: a source cannot be read.
    """
    own = folder.glob("*.py") if folder.name == "_kernels" else folder.glob("_kernels.py")
    digest = hashlib.sha256()
    for source in sorted({*own, *_SHARED}):
        digest.update(source.name.encode() + b"\n" + hashlib.sha256(source.read_bytes()).digest())
    return digest.digest()


hash_of_folder = cache(source_hash)


def kernel_folder() -> Path:
    """Folder from which compiled kernels are loaded and in which they are kept.

    NUMBA_CACHE_DIR if it belongs to this user alone, otherwise that of `user_folder`.

    Raises `OSError` if there is none.
    """
    return user_folder("kernels", Path(config.CACHE_DIR) if config.CACHE_DIR else None, _report_refused)


@cache
def _report_refused(reason: str) -> None:
    if multiprocessing.parent_process() is None:  # reported once, not by every worker
        print(f"mixed-ehl: NUMBA_CACHE_DIR is not used: {reason}", file=sys.stderr, flush=True)


def stamped(function: Callable[..., Any]) -> tuple[str, str]:
    """Module and name of a kernel, and the hash of its sources; an empty hash for unreadable sources."""
    try:
        stamp = hash_of_folder(Path(inspect.getfile(function)).resolve().parent).hex()
    except OSError:  # in an archive
        stamp = ""
    return f"{function.__module__}.{function.__qualname__}", stamp


def kind_of(function: Callable[..., Any]) -> str:
    """Kind of contacts that a kernel is for."""
    return next((kind for place, kind in _PLACES.items() if function.__module__.startswith(place)), SMOOTH)


@contextmanager
def announced(function: Callable[..., Any]) -> Iterator[None]:
    """Report the start of compilation on standard error, once for each kind of kernels, and record its end."""
    global _nested
    if _nested:
        yield
        return
    kind = kind_of(function)
    if kind not in {done for done, _ in compiled}:
        print(f"mixed-ehl: compiling for {_TAKES[kind]}, once on this machine", file=sys.stderr, flush=True)
    _nested = True
    try:
        yield
    finally:
        _nested = False
        compiled.append((kind, f"{function.__module__}.{function.__name__}"))
