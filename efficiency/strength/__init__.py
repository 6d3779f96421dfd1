"""Strength of the teeth: grades of contact pressure, root bending stress, safety factors, scuffing, micropitting.

Based on the load of `efficiency.ltca` and arrays of local conditions, independent of friction models.
"""
