"""Lubricants: viscosity, density and shear laws, oil cards and film formulas."""

from __future__ import annotations
