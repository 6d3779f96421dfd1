"""Compilation of kernels: by `ehl.compile.internals` for the versions of numba that it was tested with.

Any other version compiles each function in the ordinary way, by public interfaces. This takes three times as long,
wheels carry no kernels, and results agree to rounding only, also those of two processes.
"""

import multiprocessing
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from types import ModuleType
from typing import Any

import numba
from numba import config, njit

from ehl.common.private_files import private_folder
from ehl.compile.carried import tested_version
from ehl.compile.sources import compiled, kernel_folder, kind_of, stamped

internals: ModuleType | None = None
if tested_version():
    with suppress(ImportError, AttributeError):
        from ehl.compile import internals

# options of a kernel called from Python
KERNEL: dict[str, Any] = {"error_model": "numpy"}
# options of a kernel called only by kernels; a call from Python would crash. Without wrappers for Python and without
# reference counting it compiles faster; kernels keep no array
INTERNAL_KERNEL: dict[str, Any] = {"error_model": "numpy"}

# the same with the order of sums and products left to the compiler
FAST_MATH = {"reassoc", "contract", "arcp", "nsz"}
FAST_KERNEL = KERNEL | {"fastmath": FAST_MATH}
FAST_INTERNAL_KERNEL = INTERNAL_KERNEL | {"fastmath": FAST_MATH}
if internals is not None:
    _SHORT = {"no_cfunc_wrapper": True, "_nrt": False}
    KERNEL["no_cfunc_wrapper"] = True
    FAST_KERNEL |= _SHORT
    for options in (INTERNAL_KERNEL, FAST_INTERNAL_KERNEL):
        options |= _SHORT | {"pipeline_class": internals.InternalCompiler, "no_cpython_wrapper": True}


def missing_on_disk(kernel: Any) -> bool:
    """Whether a kernel has a folder on disk but no code of the present sources."""
    cache = getattr(kernel, "_cache", None)
    return internals is not None and isinstance(cache, internals.KernelCache) and cache.holds_nothing()


_by_numba: list[tuple[Any, int]] = []  # ordinarily compiled kernels, and how often each was compiled so far


def _ordinary(function: Callable[..., Any], cached: bool, options: dict[str, Any]) -> Any:
    """Kernel by the public interface of numba, its code in a folder under the hash of its sources."""
    place, new, before = None, False, config.CACHE_DIR
    if cached:
        with suppress(OSError):  # no place: each process compiles
            place = private_folder(kernel_folder() / f"numba-{stamped(function)[1][:16]}")
            new = not any(place.iterdir())
    try:
        config.CACHE_DIR = str(place or before)
        made = njit(**options, cache=place is not None)(function)
    finally:
        config.CACHE_DIR = before
    if place is not None and not str(made.stats.cache_path).startswith(str(place)):  # it would load old code
        made = njit(**options)(function)
    if new:
        _report_ordinary()
    _by_numba.append((made, 0))
    return made


@cache
def _report_ordinary() -> None:
    if multiprocessing.parent_process() is None:
        text = f"numba {numba.__version__} was not tested: kernels are compiled in a few minutes, once on this machine"
        print(f"mixed-ehl: {text}", file=sys.stderr, flush=True)


def compiled_kernels() -> list[tuple[str, str]]:
    """Kind and name of the kernels compiled by this process so far."""
    for i, (made, known) in enumerate(_by_numba):
        count, function = sum(made.stats.cache_misses.values()), made.py_func
        compiled.extend([(kind_of(function), f"{function.__module__}.{function.__name__}")] * (count - known))
        _by_numba[i] = made, count
    return compiled


def kernel(*, cache: bool = True, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function called from Python.

    cache: whether its code is stored.
    **options: as of `KERNEL` and ``numba.njit``.
    """

    def of(function: Callable[..., Any]) -> Any:
        if config.DISABLE_JIT:
            return function
        if internals is None:
            return _ordinary(function, cache, options)
        made = internals.Kernel(function, targetoptions={"nopython": True, "boundscheck": None, **options})
        if cache:
            made.enable_caching()
        return made

    return of
