"""Cutting simulation: cutter, machine, flank."""
