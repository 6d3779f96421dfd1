"""Smooth, steady line contact: tracked exit, graded mesh, full Newton, values with a grid error."""

from __future__ import annotations

from ehl.steady.result import SteadyResult
from ehl.steady.solver import REASONS, solve_steady

__all__ = ["REASONS", "SteadyResult", "solve_steady"]
