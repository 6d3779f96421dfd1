"""Smooth, steady line contact: tracked exit, graded mesh, full Newton, values with a grid error."""

from __future__ import annotations

from ehl.smooth.result import SteadyResult
from ehl.smooth.solver import FALLBACKS, REASONS, solve_steady

__all__ = ["FALLBACKS", "REASONS", "SteadyResult", "solve_steady"]
