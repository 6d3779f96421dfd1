"""Strength of the teeth: grades of contact pressure, root bending stress, safety factors, scuffing, micropitting.

Takes the load of `efficiency.ltca` and arrays of local conditions; does not depend on friction models.
"""
