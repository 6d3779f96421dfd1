"""Unloaded tooth contact analysis (TCA): surface of roll angle, ease-off, transmission error, contact pattern.

Input: flanks and an assembly; independent of design files. Imports `blanks` and `cutting`.
"""
