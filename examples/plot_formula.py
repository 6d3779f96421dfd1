"""
What a friction formula says
============================

A shipped formula over sliding, with its interval, and its flag outside the data.
"""

import matplotlib.pyplot as plt
import numpy as np

import regression

formula = regression.Formula.load("75w90")
sliding = np.geomspace(0.01, 1.0, 30)
points = [
    formula.mu(
        pressure_hertz="1.2 GPa", radius_equivalent="15 mm", speed_entrainment="5 m/s", slide_to_roll=float(slip),
        temperature="90 degC", roughness_rms="0.4 um",
    )
    for slip in sliding
]  # fmt: skip
answer = float(points[15].mu)
print(points[15])

figure, axes = plt.subplots()
axes.semilogx(sliding, [float(point.mu) for point in points])
axes.set(xlabel="slide-to-roll ratio", ylabel="friction coefficient", title=formula.name)
