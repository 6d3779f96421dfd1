"""Geometry and unloaded contact of a design: both sides of a pair, and what misalignments change."""
