"""
Constant friction against a formula
===================================

How far a constant of 0.05 (Coleman) is from the default friction model of the oil, over the load.
"""

import matplotlib.pyplot as plt

import efficiency

mesh = efficiency.load("fm_spiral_bevel_14x39_relieved").mesh(side="drive")
torques = (50.0, 150.0, 300.0)
figure, axes = plt.subplots()
for model in (None, "constant:0.05", "xu_kahraman_2007"):
    losses = [mesh.load(torque).efficiency(model, speed="1500 rpm").power_loss for torque in torques]
    axes.plot(torques, losses, "o-", label=model or "default of the oil")
    if model is None:
        default = losses
axes.set(xlabel="pinion torque [N m]", ylabel="friction power [W]")
axes.legend()
constant = mesh.load(300.0).efficiency("constant:0.05", speed="1500 rpm").power_loss
answer = constant / default[-1]
print(f"a constant of 0.05 gives {answer:.2f} times the loss at 300 N m")
