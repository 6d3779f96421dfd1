"""Cutter head, cradle machine and the flank they cut: equation of meshing, fillet, root line, undercut.

Machine settings by their trade names: radial setting, cradle angle, tilt, swivel, blank offset, sliding base, machine
root angle, machine centre to back, roll ratio, modified roll, helical motion. What depends on the process is one object
each: `PROCESSES` (face milling, face hobbing) and `GENERATIONS` (generated, Formate). Imports no other folder of the
package.
"""
