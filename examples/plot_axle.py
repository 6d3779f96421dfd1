"""
Losses of a whole axle
======================

Mesh, bearings, seals and churning of a shipped axle over the speed, without torque and under load.
"""

import matplotlib.pyplot as plt

import efficiency

axle = efficiency.Axle("truck_hypoid")
losses = axle.map("0, 200 N m", "200:3000:6 rpm", "80 degC", "xu_kahraman_2007")
figure, axes = plt.subplots()
for torque in (0.0, 200.0):
    points = [point for point in losses.points if point.torque == torque]
    axes.plot([p.speed for p in points], [p.loss_total for p in points], label=f"{torque:g} N m")
axes.set(xlabel="pinion speed [rad/s]", ylabel="loss of the axle [W]")
axes.legend()
point = axle.at("200 N m", "1500 rpm", "80 degC", "xu_kahraman_2007").points[0]
answer = point.loss_total
print(f"{answer:.0f} W: mesh {point.loss_mesh:.0f} W, bearings {point.loss_bearings:.0f} W")
