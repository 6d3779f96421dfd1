"""
Misalignment and efficiency
===========================

Contact pressure and efficiency of a pair whose pinion is shifted along its axis.
"""

import matplotlib.pyplot as plt

import efficiency

pair = efficiency.load("fm_spiral_bevel_14x39_relieved")
shifts = (-0.1, 0.0, 0.1)
results = [pair.mesh(P=f"{shift} mm").load("300 N m").efficiency(speed="1500 rpm") for shift in shifts]
figure, (left, right) = plt.subplots(1, 2, layout="constrained")
left.plot(shifts, [1e-9 * result.pressure_hertz_max for result in results], "o-")
left.set(xlabel="pinion shift P [mm]", ylabel="greatest pressure [GPa]")
right.plot(shifts, [100.0 * result.efficiency for result in results], "o-")
right.set(xlabel="pinion shift P [mm]", ylabel="efficiency [%]")
answer = 100.0 * results[0].efficiency
print(f"efficiency at P = {shifts[0]} mm: {answer:.3f} %")
