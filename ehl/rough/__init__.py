"""Transient rough mixed EHL of a line contact: two moving surfaces, film, contact, drainage and heat."""

from __future__ import annotations

from ehl.rough.result import Fallbacks, Profiles, Snapshot, TransientResult
from ehl.rough.solve import solve_transient
from ehl.rough.surfaces import RoughSurfaces

__all__ = ["Fallbacks", "Profiles", "RoughSurfaces", "Snapshot", "TransientResult", "solve_transient"]
