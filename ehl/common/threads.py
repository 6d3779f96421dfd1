"""One thread for the linear algebra of every public computation.

The matrices are small, so that threads of the BLAS would wait for each other, up to seconds on a busy machine. Parallel
work uses processes.
"""

import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

# read by a BLAS or OpenMP that is loaded during a computation
_VARIABLES = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "BLIS_NUM_THREADS")
# packages with libraries that use threads
_LIBRARIES = ("numpy", "scipy.linalg", "sklearn.utils._openmp_helpers")


class _Limit:
    """The limit of this process, set by the first computation that begins and removed by the last one that ends."""

    def __init__(self) -> None:
        self._lock, self._running = threading.RLock(), 0
        self._known: tuple[bool, ...] = ()
        self._libraries: Any = None
        self._set: Any = None
        self._variables: dict[str, str | None] = {}

    def begin(self) -> None:
        """Count the beginning of a computation."""
        with self._lock:
            self._running += 1
            if self._running == 1:
                self._variables = {name: os.environ.get(name) for name in _VARIABLES}
                os.environ.update(dict.fromkeys(_VARIABLES, "1"))
                self._set = self._loaded().limit(limits=1)

    def end(self) -> None:
        """Count the end of a computation."""
        with self._lock:
            self._running -= 1
            if self._running:
                return
            for name, value in self._variables.items():
                if value is None:
                    del os.environ[name]
                else:
                    os.environ[name] = value
            before = self._libraries
            self._set.restore_original_limits()
            if self._loaded() is not before:
                # a library that was loaded meanwhile gets its default number of threads
                usual = max((part.num_threads for part in before.lib_controllers), default=1)
                known = {part.filepath for part in before.lib_controllers}
                for part in self._libraries.lib_controllers:
                    if part.filepath not in known:
                        part.set_num_threads(usual)

    def _loaded(self) -> Any:
        """The loaded libraries; the list is renewed after the import of a package with a library."""
        known = tuple(name in sys.modules for name in _LIBRARIES)
        if known != self._known:
            from threadpoolctl import ThreadpoolController

            self._libraries, self._known = ThreadpoolController(), known
        return self._libraries


_limit = _Limit()


@contextmanager
def single_thread() -> Iterator[None]:
    """A block in which the linear algebra of this process has one thread; blocks may be nested."""
    _limit.begin()
    try:
        yield
    finally:
        _limit.end()


def one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """Decorator that runs a function with `single_thread`."""
    return single_thread()(function)


@cache
def keep_one_thread() -> None:
    """One thread for all computations of this process, for workers."""
    _limit.begin()
