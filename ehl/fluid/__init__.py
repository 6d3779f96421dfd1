"""Lubricants: viscosity, density and shear laws, oil cards, film formulas, load sharing."""

from __future__ import annotations
