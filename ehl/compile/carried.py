"""Precompiled kernels of a wheel, loaded instead of compiled where they fit.

A wheel may hold kernels for one version of Python, numba and llvmlite, compiled for the processor that built it or for
all of level x86-64-v3 (`hatch_build.py`). Kernels that are damaged, made from other sources or versions, or for a
processor with features that this one lacks are ignored and compiled locally.
"""

import hashlib
import json
import os
import pickle
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import llvmlite.binding as llvm
import numba
from numba import config

from ehl.common.files import write_file

FOLDER = Path(__file__).resolve().parents[1] / "_carried"
INDEX = "kernels.json"
SWITCH = "MIXED_EHL_KERNELS"  # "native": compile for the local processor
LEVEL = "x86-64-v3"
# CPU name and features for the compiler; an empty list means the features of this machine
TARGET = (LEVEL, "+avx2")
# features of the level, as LLVM names them
FEATURES = (
    *("avx", "avx2", "bmi", "bmi2", "cx16", "f16c", "fma", "fxsr", "lzcnt", "mmx", "movbe", "popcnt", "sahf"),
    *("sse", "sse2", "sse3", "sse4.1", "sse4.2", "ssse3", "xsave"),
)

# versions of numba whose private interfaces `ehl.compile.internals` was tested with
TESTED = ((0, 61), (0, 69))


def tested_version() -> bool:
    """Whether the version of numba is one of `TESTED`."""
    found = tuple(int(part) if part.isdigit() else 0 for part in numba.__version__.split(".")[:2])
    return TESTED[0] <= found < TESTED[1]


def surrounding() -> dict[str, str]:
    """Versions and platform that compiled kernels require, in addition to their sources and the processor."""
    return {
        "python": f"{sys.implementation.cache_tag}{getattr(sys, 'abiflags', '')}",
        "numba": numba.__version__,
        "llvmlite": llvmlite.__version__,
        "platform": llvm.get_process_triple(),
    }


def why_not() -> str | None:
    """Reason why precompiled kernels are not used, or None."""
    if os.environ.get(SWITCH) == "native":
        return f"{SWITCH}=native selects compilation for the local processor"
    if config.CPU_NAME is not None or config.CPU_FEATURES is not None:
        return "NUMBA_CPU_NAME or NUMBA_CPU_FEATURES selects the target processor"
    if not tested_version():
        return f"numba {numba.__version__} is compiled by its public interfaces, as it was not tested"
    if not FOLDER.is_dir():
        return "this installation has no precompiled kernels"
    made_for, here = _index().get("surrounding"), surrounding()
    if not isinstance(made_for, dict):
        return "the index of the precompiled kernels cannot be read"
    if made_for != here:
        others = ", ".join(f"{what} {made_for.get(what)}" for what in here if made_for.get(what) != here[what])
        return f"the precompiled kernels are for {others}"
    has, needed = llvm.get_host_cpu_features(), _index().get("features")
    if not isinstance(needed, list):
        return "the index of the precompiled kernels cannot be read"
    missing = [str(feature) for feature in needed if not has.get(feature, False)]
    return f"the precompiled kernels need a processor with {', '.join(missing)}" if missing else None


def _index() -> dict[str, Any]:
    try:
        index = json.loads((FOLDER / INDEX).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return index if isinstance(index, dict) else {}


@cache
def _entries(folder: Path) -> Any:
    """Index entries of a folder if its kernels fit this process; read once in a process."""
    return _index().get("kernels") if why_not() is None else None


def _content(name: str, sources: str) -> bytes | None:
    try:
        entry = _entries(FOLDER)[name]
        content = (FOLDER / entry["file"]).read_bytes()
        whole = entry["sources"] == sources and entry["sha256"] == hashlib.sha256(content).hexdigest()
    except (OSError, LookupError, TypeError):  # no such kernel, or a damaged index
        return None
    return content if whole else None


def carries(name: str, sources: str) -> bool:
    """Whether a fitting precompiled kernel of these sources exists."""
    return _content(name, sources) is not None


def carried_kernel(name: str, sources: str, arguments: tuple[Any, ...]) -> Any:
    """Compile result of a kernel in the form of numba's disk cache, or None.

    name: module and function.
    sources: hash of the sources that the kernel is made from.
    arguments: numba types of the arguments.
    """
    content = _content(name, sources)
    if content is None:
        return None
    # the pickled code comes with the package and is trusted like it
    return next((made for taken, made in pickle.loads(content) if taken == arguments), None)


def write_carried(kernels: Iterable[tuple[str, str, Any]], folder: Path) -> int:
    """Write the kernels that this process compiled, for its processor or for `TARGET`.

    kernels: module and function, hash of the sources, and the kernel.
    folder: is created; must not exist.
    Returns: number of kernels written.
    """
    from numba.core.serialize import dumps

    chosen = config.CPU_NAME, config.CPU_FEATURES
    if chosen not in (TARGET, (None, None)):
        raise RuntimeError(f"NUMBA_CPU_NAME, NUMBA_CPU_FEATURES have to be unset or {TARGET}")
    host = sorted(name for name, has in llvm.get_host_cpu_features().items() if has)
    folder.mkdir(parents=True)
    entries: dict[str, dict[str, str]] = {}
    for name, sources, kernel in kernels:
        content = dumps(kernel.saved())
        entries[name] = {"file": f"{name}.bin", "sources": sources, "sha256": hashlib.sha256(content).hexdigest()}
        write_file(folder / f"{name}.bin", content)
    index = {"surrounding": surrounding(), "features": FEATURES if chosen == TARGET else host, "kernels": entries}
    write_file(folder / INDEX, json.dumps(index, indent=1, sort_keys=True) + "\n")
    return len(entries)
