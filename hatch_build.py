"""Compiles the kernels into the wheel, so that the first contact of a user waits for nothing.

MIXED_EHL_KERNELS: not set: for the processor that builds, as with ``pip install .``, or none where that fails;
"portable": for Linux and all processors of level x86-64-v3, a failure is an error; "none": a wheel for all machines.

What the user's folder of kernels holds from the same sources is not compiled once more.
The kernels fit numba and llvmlite of the build alone; where they do not fit they are compiled at first use.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from packaging.requirements import Requirement

SOLVING = {"numpy", "scipy", "numba", "llvmlite", "pydantic", "threadpoolctl"}  # what a contact imports


class CarriedKernels(BuildHookInterface):  # type: ignore[type-arg]
    """Compiles the kernels beside the sources and puts them into the wheel."""

    _kept: tempfile.TemporaryDirectory[str] | None = None

    def dependencies(self) -> list[str]:
        """To compile is to solve contacts."""
        if self._chosen == "none":
            return []
        return [line for line in self.metadata.core.dependencies if Requirement(line).name in SOLVING]

    @property
    def _chosen(self) -> str:
        return os.environ.get("MIXED_EHL_KERNELS", "")

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """As of hatchling."""
        if version == "editable" or self._chosen == "none":
            return
        try:
            kernels = self._compile()
        except (OSError, subprocess.CalledProcessError) as error:
            if self._chosen == "portable":
                raise
            self.app.display_warning(f"kernels are compiled at first use, not here: {error}")
            return
        build_data["pure_python"] = False
        build_data["infer_tag"] = self._chosen != "portable"  # else of this Python and machine
        if self._chosen == "portable":
            # the code meets the C library through numba alone: what numba runs on, it runs on
            python = f"cp{sys.version_info.major}{sys.version_info.minor}"
            build_data["tag"] = f"{python}-{python}-manylinux_2_27_x86_64"
        build_data["force_include"][str(kernels)] = "ehl/_carried"

    def _compile(self) -> Path:
        self._kept = tempfile.TemporaryDirectory()
        kernels = Path(self._kept.name) / "kernels"
        surrounding = {
            name: value for name, value in os.environ.items() if not name.startswith(("NUMBA_", "MIXED_EHL"))
        }
        if self._chosen == "portable":
            if not sys.platform.startswith("linux") or os.uname().machine != "x86_64":
                raise OSError("portable kernels are made under Linux on x86_64")
            # the name says the other features
            surrounding |= {"NUMBA_CPU_NAME": "x86-64-v3", "NUMBA_CPU_FEATURES": "+avx2"}
            surrounding |= {"NUMBA_CACHE_DIR": f"{self._kept.name}/compiled"}
        # pip reaches the dependencies of the build through PYTHONPATH
        paths = os.pathsep.join(filter(None, (self.root, os.environ.get("PYTHONPATH"))))
        surrounding |= {"PYTHONPATH": paths}
        compiling = "import sys; from ehl.warmup import write_kernels; write_kernels(sys.argv[1])"
        subprocess.run([sys.executable, "-P", "-c", compiling, str(kernels)], env=surrounding, check=True)
        return kernels

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """As of hatchling."""
        if self._kept is not None:
            self._kept.cleanup()
