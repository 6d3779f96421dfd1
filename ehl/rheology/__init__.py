"""Shear laws of the lubricant: one description for the traction and for the pressure flow of both solvers."""

from __future__ import annotations

from ehl.rheology.laws import Limit, Rheology, RisingStress, ShearLaw

__all__ = ["Limit", "Rheology", "RisingStress", "ShearLaw"]
