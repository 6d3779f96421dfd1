"""
Efficiency of a gear pair
=========================

A shipped pair with a shipped formula, and the uncertainty of the result.
"""

import efficiency

pair = efficiency.load("fm_spiral_bevel_14x39_relieved")
result = pair.mesh(side="drive").load("300 N m").efficiency("75w90", speed="1500 rpm")
answer = 100 * result.efficiency
print(f"efficiency {answer:.3f} %, numerical error {100 * result.efficiency_error:.1g} %")
axes = result.inputs.plot()
