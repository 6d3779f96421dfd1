"""Transient mixed EHL of a line contact of two moving rough surfaces.

Reynolds equation with mass-conserving cavitation (JFO), elastic deflection, asperity contact, side flow through the
valleys of the roughness, and heat are solved at every time step. Friction is a time mean with its errors.
"""

from ehl.rough.solve import solve_transient
from ehl.rough.surfaces import RoughSurfaces
from ehl.rough.transient_result import Fallbacks, Profiles, Snapshot, TransientResult

__all__ = ["Fallbacks", "Profiles", "RoughSurfaces", "Snapshot", "TransientResult", "solve_transient"]
