"""Compiled kernels of the transient solver, one module per physical step.

Scaled variables throughout: x in Hertz half-widths b, pressure in p_h, film in the film unit of the run
(`ehl.rough.scaling`); time in steps of dx/u_r.
"""

from __future__ import annotations
