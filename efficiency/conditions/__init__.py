"""Efficiency over conditions: grids, duty cycles and maps."""
