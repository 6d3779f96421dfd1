"""Rough surfaces: generated and measured height profiles."""
