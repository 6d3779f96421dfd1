r"""
Equations of the efficiency of a pair
=====================================

Power loss and efficiency from the loaded contact points (Kolivand, Li & Kahraman 2010), next to the program's result.
"""

import matplotlib.pyplot as plt
import numpy as np

import efficiency

mesh = efficiency.load("fm_spiral_bevel_14x39_relieved").mesh(side="drive")
result = mesh.load("300 N m").efficiency(speed="1500 rpm")
points = result.points

# %%
# **Local conditions.** Every loaded point of every position has a normal force F, a Hertz pressure, the entrainment
# :math:`u_r` and the sliding speed :math:`|v_s|`, the length of the sliding vector in the tangent plane.
force, sliding = points.force, points.speed_sliding
print(f"{force.size} points, {sliding.min():.2f} to {sliding.max():.2f} m/s of sliding")

# %%
# **Friction power** of a position q: :math:`P(q)=\sum_i\mu_iF_i|v_{s,i}|`.
loss = np.bincount(points.position, result.friction.mu * force * sliding, minlength=result.solution.positions)

# %%
# **Efficiency** with the mean over the mesh cycle: :math:`\eta=1-\bar P/(T_1\omega_1)`.
answer = 100.0 * (1.0 - loss.mean() / (result.conditions.torque * result.conditions.speed))
print(f"{answer:.4f} % here, {100.0 * result.efficiency:.4f} % by the program")

# %%
# **Mean friction** weighted with the sliding power: :math:`\bar\mu=\sum\mu F|v_s|/\sum F|v_s|`.
mean = np.sum(result.friction.mu * force * sliding) / np.sum(force * sliding)
print(f"mean mu {mean:.4f}; {result.friction_coefficient_mean:.4f} by the program")
figure, axes = plt.subplots()
axes.plot(np.degrees(result.cycle.pinion_angle), loss, "o-")
axes.set(xlabel="pinion angle [deg]", ylabel="friction power [W]", ylim=(0.0, None))
