"""Machine settings from a blank, a cutter and targets of the bearing contact; the result is a design file.

Imports `design` and the folders below it.
"""
