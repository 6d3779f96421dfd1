"""Blank of a member: cones, face, tooth height (ISO 23509)."""
