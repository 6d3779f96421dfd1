"""Efficiency over conditions: grids, loss maps, duty cycles, parameter studies."""
