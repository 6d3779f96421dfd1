"""How kernels are compiled: a function that Python calls becomes one closed piece of machine code.

By itself the compiler makes machine code of every function, optimises each once more within all that call it, and
leaves open which of several copies a call meets: the caller's, or one that was loaded before. Here what only kernels
call goes unoptimised into its callers, is optimised there once, and stays private to them. So a process that compiles,
one that loads, and one that did other work before run the same instructions, and compiling takes a third less.

A function that Python and kernels call is two: one that Python calls, compiled when it does, and a twin for kernels.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from typing import Any

from numba import types
from numba.core import config
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.registry import CPUDispatcher

from ehl.compile.cache import KernelCache, announced

LONG_WRAPPER = 100  # blocks of code


class KernelLibrary(JITCodeLibrary):
    """Code of a function that Python calls: what it calls is private to it."""

    def __init__(self, codegen: Any, name: str) -> None:
        super().__init__(codegen, name)
        self._own: set[str] = set()  # names of the function and its wrappers

    def add_ir_module(self, ir_module: Any) -> None:
        """As of numba."""
        for function in ir_module.functions:
            if not function.is_declaration:
                self._own.add(function.name)
                if len(function.blocks) > LONG_WRAPPER and function.name.startswith("_ZN7cpython"):
                    # it takes some hundred arrays out of Python once a call: to polish it takes longer than to run it
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
        """No machine code, no place for the environment of the function."""


class InternalLibrary(JITCodeLibrary):
    """Code of a function that only kernels call: it waits, unoptimised, to be put into those."""

    @property
    def codegen(self) -> Any:
        """What the compiler tells of a finished function."""
        return _NoEnvironment

    def get_pointer_to_function(self, name: str) -> int:
        """None: nobody calls it by itself."""
        self._ensure_finalized()
        return 0

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


class Options(Flags):
    """Options of a function as a key, which the compiler compares a hundred thousand times for a rough contact.

    By itself it asks each option for its value, or its default, in every comparison: a tenth of all compiling.
    """

    __slots__ = ()

    def __eq__(self, other: object) -> Any:
        return self._values == other._values if isinstance(other, Options) else super().__eq__(other)

    def __hash__(self) -> int:
        return _HASH


_HASH = hash(Flags())  # that of the names of all options, whatever their values


class KernelCompiler(Compiler):
    """Compiles functions that Python calls."""

    library: type[JITCodeLibrary] = KernelLibrary

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.state.flags = Options(self.state.flags)

    def compile_extra(self, func: Any) -> Any:
        """As of numba."""
        self.state.library = self.library(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        collecting = gc.isenabled()
        gc.disable()  # a compiler's many objects live to its end: looking for garbage among them takes an eighth more
        try:
            with announced(func):
                return super().compile_extra(func)
        finally:
            if collecting:
                gc.enable()


class InternalCompiler(KernelCompiler):
    """Compiles functions that only kernels call."""

    library = InternalLibrary


# options of a kernel that Python calls
KERNEL: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True}
# and of one that only kernels call; a call from Python would crash. Without the wrappers for Python it compiles faster,
# and so it does without counting references: kernels keep no array
INTERNAL_KERNEL: dict[str, Any] = {
    "error_model": "numpy",
    "pipeline_class": InternalCompiler,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "_nrt": False,
}


class Kernel(CPUDispatcher):
    """A function that Python calls, with its twin for kernels."""

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
        """What a kernel meets that calls this one."""
        return types.Dispatcher(self._twin)

    def enable_caching(self) -> None:
        """Load what is carried or on disk, keep what is compiled."""
        self._cache = KernelCache(self.py_func)


def kernel(*, cache: bool = True, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function that Python calls.

    Parameters
    ----------
    cache : bool
        Whether its code is kept.
    **options
        `KERNEL` and more, as of ``numba.njit``.
    """

    def of(function: Callable[..., Any]) -> Any:
        if config.DISABLE_JIT:
            return function
        made = Kernel(function, targetoptions={"nopython": True, "boundscheck": None, **options})
        if cache:
            made.enable_caching()
        return made

    return of
