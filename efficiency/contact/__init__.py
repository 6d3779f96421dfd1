"""Unloaded tooth contact analysis (TCA): surface of roll angle, ease-off, transmission error, contact pattern.

Takes flanks and an assembly, never a design file. Imports `blanks` and `cutting`.
"""
