"""Compilation of kernels before they are needed, for the command `mixed-ehl warmup` and for worker processes."""

import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numba
import numpy as np

from ehl.common.errors import InputError
from ehl.common.pages import TableResult
from ehl.common.table import Column, Table
from ehl.compile.carried import write_carried
from ehl.compile.compiler import compiled_kernels, internals, missing_on_disk
from ehl.compile.sources import ROUGH, SMOOTH, stamped
from ehl.contact import Contact

# a thermal contact whose solution uses the kernels of its kind; at this slip the film is strained elastically as well
_CONTACT: dict[str, Any] = {
    "oil": "75w90",
    "temperature": "60 degC",
    "pressure_hertz": "1.2 GPa",
    "radius_equivalent": "5 mm",
    "speed_entrainment": "5 m/s",
    "slide_to_roll": 0.005,
    "thermal": "on",
    "accuracy": "fast",
}
_ROUGH: dict[str, Any] = {"roughness_rms": "0.4 um", "correlation_length": "100 um", "friction_tolerance": 0.3}
KINDS = {SMOOTH: (SMOOTH,), ROUGH: (SMOOTH, ROUGH), "gear": (SMOOTH, ROUGH)}
_WORDS = {SMOOTH: "smooth contacts", ROUGH: "rough contacts"}


@dataclass(frozen=True)
class Warmup(TableResult):
    """Result of a compilation."""

    kinds: tuple[str, ...]  # kinds of contacts whose kernels are ready: smooth, rough
    compiled: dict[str, int]  # kernels compiled by this call, by kind; the others were on disk
    seconds_cpu: dict[str, float]  # processor time of compiling and one solution, by kind [s]
    seconds: float  # wall time of the call, its solutions included [s]

    def table(self) -> Table:
        """One row per kind of contact."""
        rows = [(_WORDS[kind], self.compiled[kind], self.seconds_cpu[kind]) for kind in self.kinds]
        count = sum(self.compiled.values())
        note = f"{count} kernels compiled" if count else "nothing to compile: all kernels were on disk"
        columns = ("kernels of", "compiled", Column("seconds_cpu", label="CPU time"))
        return Table(columns, rows, title=f"ready in {self.seconds:.1f} s", notes=(note,))

    def to_dict(self) -> dict[str, Any]:
        """Content for JSON."""
        return {**vars(self), "kinds": list(self.kinds)}


def warm_up(kind: str = "gear") -> Warmup:
    """Compile the kernels that are not on disk, by solving a small contact of each kind.

    Parameters
    ----------
    kind : str
        ``smooth``, ``rough`` (includes smooth), or ``gear`` (both).

    Returns
    -------
    Warmup

    Raises
    ------
    InputError
        An unknown kind.

    Examples
    --------
    >>> import efficiency
    >>> efficiency.warmup("smooth").kinds
    ('smooth',)
    """
    if kind not in KINDS:
        raise InputError("kind", kind, " or ".join(KINDS))
    clock, kinds, found, spent = time.perf_counter(), KINDS[kind], len(compiled_kernels()), dict[str, float]()
    for part in kinds:
        processor = time.thread_time()
        result = Contact(**_CONTACT, **(_ROUGH if part == ROUGH else {})).solve()
        if result.transient is not None:  # the kernel of preheating is used for fine roughness only
            run = result.transient.run
            run.preheat(0.0, np.zeros((2, run.problem.x.size)))
        spent[part] = time.thread_time() - processor
    new = [kind for kind, _ in compiled_kernels()[found:]]
    return Warmup(
        kinds,
        {part: new.count(part) for part in kinds},
        {part: spent[part] if part in new else 0.0 for part in kinds},
        time.perf_counter() - clock,
    )


def prepare_workers(*, rough: bool) -> None:
    """Compile the kernels of worker processes once; `rough`: including those of transient rough contacts."""
    from ehl.rough._kernels.march import march
    from ehl.smooth._kernels import newton

    if missing_on_disk(newton) or (rough and missing_on_disk(march)):
        warm_up(ROUGH if rough else SMOOTH)


def write_kernels(folder: str | Path) -> int:
    """Compile all kernels and write them to a new folder for a wheel; returns their number."""
    if internals is None:
        raise RuntimeError(f"numba {numba.__version__} was not tested: its kernels cannot be carried")
    warm_up("gear")
    modules = [module for name, module in sys.modules.items() if name.startswith("ehl.")]
    found = {
        id(value): value for module in modules for value in vars(module).values() if isinstance(value, internals.Kernel)
    }
    used = [kernel for kernel in found.values() if kernel.overloads]
    return write_carried([(*stamped(kernel.py_func), kernel) for kernel in used], Path(folder))
