"""
A blank from main dimensions
============================

Pitch lines and tips of both members in the plane of their axes, after ISO 23509.
"""

import matplotlib.pyplot as plt
import numpy as np

import efficiency

blank = efficiency.blank("iso23509_f2")
figure, axes = plt.subplots(layout="constrained")
for member, name in ((blank.pinion, "pinion"), (blank.gear, "gear")):
    distance = 1e3 * np.array([member.inner_cone_distance, member.outer_cone_distance])
    pitch = distance * np.cos(member.pitch_angle), distance * np.sin(member.pitch_angle)
    crown = [1e3 * member.crossing_to_front_crown, 1e3 * member.crossing_to_crown]
    tip = crown, [500 * member.inner_tip_diameter, 500 * member.outer_tip_diameter]
    order = slice(None, None, 1 if name == "pinion" else -1)  # the axes are at right angles
    [line] = axes.plot(*pitch[order], label=f"{name}, pitch line")
    axes.plot(*tip[order], "--", color=line.get_color(), label=f"{name}, tip")
axes.set(xlabel="along the pinion axis [mm]", ylabel="along the gear axis [mm]", aspect="equal")
axes.legend()
answer = blank.ratio
print(f"ratio {answer:.4f}, normal module {1e3 * blank.module_normal:.3f} mm")
