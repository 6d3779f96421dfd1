"""Lubricants: viscosity, density and shear laws, oil cards and film formulas."""
