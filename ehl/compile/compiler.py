"""Compilation of kernels and their cache on disk: each function called from Python is one closed piece of machine code.

By default numba generates machine code for every function and optimises it again within each caller. Which of several
copies a call uses (that of the caller, or one loaded before) is undefined. Here functions called only by kernels are
inserted into their callers without optimisation, optimised there once, and private to them. All processes then run the
same instructions, whether they compiled or loaded them, and compilation takes a third less time.

A function called both from Python and by kernels is compiled twice: for Python on its first call, and for kernels.

The cache of numba checks only the file of a function. A kernel contains the functions it calls, so its cache entry has
the hash of all sources of its code. Contents are compared, because copies and clocks change the times of files.
"""

from __future__ import annotations

import gc
import hashlib
import inspect
import multiprocessing
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

from numba import types
from numba.core import config
from numba.core.caching import CompileResultCacheImpl, FunctionCache, NullCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult, Flags
from numba.core.registry import CPUDispatcher

from ehl.common.private_files import private_folder, user_folder
from ehl.compile.carried import carried_kernel, carries

_EHL = Path(__file__).resolve().parents[1]
_OURS = {_EHL}
_SHARED = (
    *(_EHL / "compile" / name for name in ("compiler.py", "_kernels.py")),
    *(_EHL / "fluid" / name for name in ("_kernels.py", "lookup.py", "rheology.py")),
)
# kinds of kernels: for rough contacts, and for all contacts; processor time on a slow core
ROUGH, SMOOTH = "rough", "smooth"
_TAKES = {SMOOTH: "smooth contacts, 5 to 10 s", ROUGH: "rough contacts, half a minute"}
_PLACES = {"ehl.rough": ROUGH}

compiled: list[tuple[str, str, float]] = []  # kind, name and processor time [s] of the kernels compiled by this process
_nested = False


def source_hash(folder: Path) -> bytes:
    """Hash of all sources of the kernels of a folder.

    folder: of the kernels; dense matrices, laws of the fluid and the compiler settings are included.
    Raises `OSError`: a source cannot be read.
    """
    own = folder.glob("*.py") if folder.name == "_kernels" else folder.glob("_kernels.py")
    digest = hashlib.sha256()
    for source in sorted({*own, *_SHARED}):
        digest.update(source.name.encode() + b"\n" + hashlib.sha256(source.read_bytes()).digest())
    return digest.digest()


_hash_of_folder = cache(source_hash)


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


class _ContentLocator:
    """A private folder for the kernels of one folder, under the hash of their sources."""

    def __init__(self, folder: Path, line: int, stamp: bytes) -> None:
        self._folder = folder
        self._line = line
        self._stamp = stamp

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> _ContentLocator | None:
        """See the locators of numba; None for code of other packages, and without a folder."""
        folder = Path(py_file).resolve().parent
        if not _OURS & set(folder.parents):
            return None
        try:
            stamp = _hash_of_folder(folder)
            place = private_folder(kernel_folder() / stamp.hex()[:16])
        except OSError:  # sources in an archive, or no place
            return None
        return cls(place, py_func.__code__.co_firstlineno, stamp)

    def ensure_cache_path(self) -> None:
        """Make the folder."""
        private_folder(self._folder)

    def get_cache_path(self) -> str:
        """The folder."""
        return str(self._folder)

    def get_source_stamp(self) -> bytes:
        """Hash of the sources."""
        return self._stamp

    def get_disambiguator(self) -> str:
        """The line of the function."""
        return str(self._line)


class _Results(CompileResultCacheImpl):
    _locator_classes = (_ContentLocator,)


class _OnDisk(FunctionCache):
    _impl_class = _Results


class KernelCache(NullCache):
    """Code of one kernel from the installation or from disk; without a writable folder each process compiles."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        self.disk = NullCache()
        with suppress(RuntimeError):  # no place
            self.disk = _OnDisk(function)

    @property
    def cache_path(self) -> str | None:
        """Folder of the kernels compiled on this machine."""
        return self.disk.cache_path

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """See numba."""
        found = self._carried(sig, target_context)
        return self.disk.load_overload(sig, target_context) if found is None else found

    def save_overload(self, sig: Any, data: Any) -> None:
        """See numba."""
        self.disk.save_overload(sig, data)

    def saved(self, sig: Any, target_context: Any) -> Any:
        """Stored code of one signature."""
        disk: Any = self.disk
        return disk._cache_file.load(disk._index_key(sig, target_context.codegen()))

    def flush(self) -> None:
        """Delete the kernels compiled on this machine."""
        self.disk.flush()

    def _carried(self, sig: Any, target_context: Any) -> Any:
        made = carried_kernel(*stamped(self._function), tuple(sig))
        if made is None:
            return None
        target_context.refresh()
        return CompileResult._rebuild(target_context, *made)

    def holds_nothing(self) -> bool:
        """Whether a folder exists on disk, and neither it nor the installation has code of the present sources."""
        with suppress(AttributeError, OSError):  # without a folder nothing can be stored
            return not (carries(*stamped(self._function)) or self.disk._cache_file._load_index())
        return False


def stamped(function: Callable[..., Any]) -> tuple[str, str]:
    """Module and name of a kernel, and the hash of its sources; an empty hash for unreadable sources."""
    try:
        stamp = _hash_of_folder(Path(inspect.getfile(function)).resolve().parent).hex()
    except OSError:  # in an archive
        stamp = ""
    return f"{function.__module__}.{function.__qualname__}", stamp


@contextmanager
def announced(function: Callable[..., Any]) -> Iterator[None]:
    """Report the start of compilation on standard error, once for each kind of kernels, and record its time."""
    global _nested
    if _nested:
        yield
        return
    kind = next((kind for place, kind in _PLACES.items() if function.__module__.startswith(place)), SMOOTH)
    if kind not in {done for done, _, _ in compiled}:
        print(f"mixed-ehl: compiling for {_TAKES[kind]}, once on this machine", file=sys.stderr, flush=True)
    clock = time.thread_time()
    _nested = True
    try:
        yield
    finally:
        _nested = False
        compiled.append((kind, f"{function.__module__}.{function.__name__}", time.thread_time() - clock))


def missing_on_disk(kernel: Any) -> bool:
    """Whether a kernel has a folder on disk but no code of the present sources."""
    cache = getattr(kernel, "_cache", None)
    return isinstance(cache, KernelCache) and cache.holds_nothing()


LONG_WRAPPER = 100  # blocks of code


class KernelLibrary(JITCodeLibrary):
    """Code of a function called from Python; the functions that it calls are private to it."""

    def __init__(self, codegen: Any, name: str) -> None:
        super().__init__(codegen, name)
        self._own: set[str] = set()  # names of the function and its wrappers

    def add_ir_module(self, ir_module: Any) -> None:
        """See numba."""
        for function in ir_module.functions:
            if not function.is_declaration:
                self._own.add(function.name)
                if len(function.blocks) > LONG_WRAPPER and function.name.startswith("_ZN7cpython"):
                    # it unpacks some hundred arrays once per call; optimising it would take longer than running it
                    function.attributes.add("optnone")
                    function.attributes.add("noinline")
        super().add_ir_module(ir_module)

    def _optimize_final_module(self) -> None:
        for function in self._final_module.functions:
            if not function.is_declaration and function.name not in self._own:
                function.linkage = "internal"
        super()._optimize_final_module()


class _NoEnvironment:
    @staticmethod
    def set_env(name: str, env: Any) -> None:
        """Without machine code there is no environment of the function."""


class InternalLibrary(JITCodeLibrary):
    """Code of a function called only by kernels: inserted into them without optimisation."""

    @property
    def codegen(self) -> Any:
        """Output of the compiler for a finished function."""
        return _NoEnvironment

    def get_pointer_to_function(self, name: str) -> int:
        """Zero: the function is not called on its own."""
        self._ensure_finalized()
        return 0

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


class Options(Flags):
    """Options of a function as a key, which numba compares a hundred thousand times for a rough contact.

    The default comparison evaluates each option, which takes a tenth of the compilation time.
    """

    __slots__ = ()

    def __eq__(self, other: object) -> Any:
        return self._values == other._values if isinstance(other, Options) else super().__eq__(other)

    def __hash__(self) -> int:
        return _HASH


_HASH = hash(Flags())  # of the names of all options, independent of their values


class KernelCompiler(Compiler):
    """Compiler of functions called from Python."""

    library: type[JITCodeLibrary] = KernelLibrary

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.state.flags = Options(self.state.flags)

    def compile_extra(self, func: Any) -> Any:
        """See numba."""
        self.state.library = self.library(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        collecting = gc.isenabled()
        gc.disable()  # the objects of the compiler live until its end: collection would add an eighth to its time
        try:
            with announced(func):
                return super().compile_extra(func)
        finally:
            if collecting:
                gc.enable()


class InternalCompiler(KernelCompiler):
    """Compiler of functions called only by kernels."""

    library = InternalLibrary


# options of a kernel called from Python
KERNEL: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True}
# options of a kernel called only by kernels; a call from Python would crash. Without wrappers for Python and without
# reference counting it compiles faster; kernels keep no array
INTERNAL_KERNEL: dict[str, Any] = {
    "error_model": "numpy",
    "pipeline_class": InternalCompiler,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "_nrt": False,
}


# the same with the order of sums and products left to the compiler
FAST_MATH = {"reassoc", "contract", "arcp", "nsz"}
FAST_KERNEL = KERNEL | {"fastmath": FAST_MATH, "_nrt": False}
FAST_INTERNAL_KERNEL = INTERNAL_KERNEL | {"fastmath": FAST_MATH}


class Kernel(CPUDispatcher):
    """A function called from Python, with a second version for kernels."""

    def __init__(
        self,
        py_func: Callable[..., Any],
        locals: dict[str, Any] | None = None,
        targetoptions: dict[str, Any] | None = None,
        pipeline_class: type[Compiler] = KernelCompiler,
    ) -> None:
        locals = locals or {}  # older compilers refuse None
        super().__init__(py_func, locals, targetoptions, pipeline_class)
        within = dict(self.targetoptions, no_cpython_wrapper=True)
        self._twin = CPUDispatcher(py_func, locals, within, InternalCompiler)

    @property
    def _numba_type_(self) -> Any:
        """Type of this kernel for a kernel that calls it."""
        return types.Dispatcher(self._twin)

    def enable_caching(self) -> None:
        """Load code from the installation or from disk; store new code."""
        self._cache = KernelCache(self.py_func)

    def saved(self) -> list[tuple[Any, Any]]:
        """Stored code of this function, by signature."""
        return [(taken, self._cache.saved(taken, self.targetctx)) for taken in self.overloads]


def kernel(*, cache: bool = True, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function called from Python.

    cache: whether its code is stored.
    **options: as of `KERNEL` and ``numba.njit``.
    """

    def of(function: Callable[..., Any]) -> Any:
        if config.DISABLE_JIT:
            return function
        made = Kernel(function, targetoptions={"nopython": True, "boundscheck": None, **options})
        if cache:
            made.enable_caching()
        return made

    return of
