"""Compiled kernels of the transient solver, one module per physical step.

Scaled variables throughout: x in Hertz half-widths b, pressure in p_h, film in the film unit of the run
(`ehl.rough.scaling`); time in steps of dx/u_r.
"""

from __future__ import annotations

from pathlib import Path

from ehl.io.kernel_cache import FLUID_LAWS, drop_outdated_cache

drop_outdated_cache(Path(__file__).parent, *FLUID_LAWS)
