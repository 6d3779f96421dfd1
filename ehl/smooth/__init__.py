"""Smooth, steady line contact: tracked exit, graded mesh, full Newton, values with a grid error."""

from __future__ import annotations

from ehl.smooth.solver import FALLBACKS, REASONS, solve_steady
from ehl.smooth.steady_result import SteadyResult

__all__ = ["FALLBACKS", "REASONS", "SteadyResult", "solve_steady"]
