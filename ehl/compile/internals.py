"""Compilation of each function called from Python to one closed piece of machine code, by private interfaces of numba.

By default numba generates machine code for every function and optimises it again within each caller. Which of several
copies a call uses (that of the caller, or one loaded before) is undefined. Here functions called only by kernels are
inserted into their callers without optimisation, optimised there once, and private to them. All processes then run the
same instructions, whether they compiled or loaded them, and compilation takes a third less time.

A function called both from Python and by kernels is compiled twice: for Python on its first call, and for kernels.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from numba import types
from numba.core import caching
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult, Flags
from numba.core.registry import CPUDispatcher

from ehl.common.private_files import private_folder
from ehl.compile.carried import carried_kernel, carries
from ehl.compile.sources import OURS, announced, hash_of_folder, kernel_folder, stamped


class _ContentLocator(caching._SourceFileBackedLocatorMixin, caching._CacheLocator):
    """A private folder for the kernels of one folder, under the hash of their sources."""

    def __init__(self, py_func: Callable[..., Any], py_file: str) -> None:
        self._lineno, self._stamp = py_func.__code__.co_firstlineno, hash_of_folder(Path(py_file).resolve().parent)
        self._folder = private_folder(kernel_folder() / self._stamp.hex()[:16])

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> _ContentLocator | None:
        """See numba; None for code of other packages, for sources in an archive, and without a folder."""
        with suppress(OSError):
            if OURS & set(Path(py_file).resolve().parents):
                return cls(py_func, py_file)
        return None

    def ensure_cache_path(self) -> None:
        """Make the folder."""
        private_folder(self._folder)

    def get_cache_path(self) -> str:
        """The folder."""
        return str(self._folder)

    def get_source_stamp(self) -> bytes:
        """Hash of the sources."""
        return self._stamp


class _Results(caching.CompileResultCacheImpl):
    _locator_classes = (_ContentLocator,)


class _OnDisk(caching.FunctionCache):
    _impl_class = _Results


class KernelCache(caching.NullCache):
    """Code of one kernel from the installation or from disk; without a writable folder each process compiles."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        self.disk = caching.NullCache()
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
