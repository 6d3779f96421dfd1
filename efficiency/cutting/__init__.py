"""Cutter head, cradle machine and the generated flank: equation of meshing, fillet, root line, undercut.

Machine settings by their trade names: radial setting, cradle angle, tilt, swivel, blank offset, sliding base, machine
root angle, machine centre to back, roll ratio, modified roll, helical motion. Process-dependent properties are objects
in `PROCESSES` (face milling, face hobbing with one-part and two-part heads) and `GENERATIONS` (generated, Formate).
Imports no other folder of the package.
"""
