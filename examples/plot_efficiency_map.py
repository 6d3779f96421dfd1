"""
Efficiency over torque and speed
================================

Geometry is computed once; every point of the map uses it.
"""

import efficiency

mesh = efficiency.load("fm_spiral_bevel_14x39_relieved").mesh(side="drive")
grid = mesh.over("75w90", torque="100, 200, 300 N m", speed=["500 rpm", "1500 rpm"])
table = grid.to_frame()
axes = grid.plot()
answer = 100 * table["efficiency"].max()
print(f"best point {answer:.3f} %")
