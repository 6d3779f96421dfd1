"""Blanks of a pair (ISO 23509): pitch cones, tooth proportions, face width, undercut check, virtual gears.

Imports `cutting`.
"""
