"""Wheels that carry compiled kernels, for one Python on Linux and processors of level x86-64-v3.

    HATCH_BUILD_HOOK_ENABLE_CUSTOM=true python -m build --wheel

Without the variable the wheel is pure, one for all machines. The kernels fit numba and llvmlite of the build alone;
where they do not fit they are compiled as from the pure wheel.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class CarriedKernels(BuildHookInterface):  # type: ignore[type-arg]
    """Compiles the kernels beside the sources and puts them into the wheel."""

    def dependencies(self) -> list[str]:
        """To compile is to solve contacts."""
        return list(self.metadata.core.dependencies)

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """As of hatchling."""
        if version == "editable":
            return
        if not sys.platform.startswith("linux") or os.uname().machine != "x86_64":
            raise RuntimeError("carried kernels are made under Linux on x86_64")
        self._temporary = tempfile.TemporaryDirectory()
        kernels = Path(self._temporary.name) / "kernels"
        surrounding = {
            name: value for name, value in os.environ.items() if not name.startswith(("NUMBA_", "MIXED_EHL"))
        }
        surrounding |= {
            "NUMBA_CPU_NAME": "x86-64-v3",
            "NUMBA_CPU_FEATURES": "+avx2",
        }  # the name says the other features
        # pip reaches the dependencies of the build through PYTHONPATH
        paths = os.pathsep.join(filter(None, (self.root, os.environ.get("PYTHONPATH"))))
        surrounding |= {"PYTHONPATH": paths, "NUMBA_CACHE_DIR": f"{self._temporary.name}/compiled"}
        compiling = "import sys; from ehl.warmup import write_kernels; write_kernels(sys.argv[1])"
        subprocess.run([sys.executable, "-P", "-c", compiling, str(kernels)], env=surrounding, check=True)
        build_data["pure_python"] = False
        # the code meets the C library through numba alone: what numba runs on, it runs on
        python = f"cp{sys.version_info.major}{sys.version_info.minor}"
        build_data["tag"] = f"{python}-{python}-manylinux_2_27_x86_64"
        build_data["force_include"][str(kernels)] = "ehl/_carried"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """As of hatchling."""
        if version != "editable":
            self._temporary.cleanup()
