"""
A Stribeck curve
================

Friction and film over speed of one contact, from mixed to full film.
"""

import matplotlib.pyplot as plt

import ehl

contact = ehl.Contact(
    oil="75w90", temperature="90 degC", pressure_hertz="1.2 GPa", radius_equivalent="15 mm",
    speed_entrainment="5 m/s", slide_to_roll=0.2, roughness_rms="0.4 um", finish="ground", accuracy="fast",
)  # fmt: skip
speeds = (0.3, 0.6, 1.2, 2.5, 5.0, 10.0, 20.0)
table = ehl.solve_path([contact.replace(speed_entrainment=speed) for speed in speeds]).to_frame()

figure, axes = plt.subplots()
axes.semilogx(table["film_ratio"], table["friction_coefficient"], "o-", label="mu")
axes.semilogx(table["film_ratio"], table["friction_asperity"], "s--", label="of asperities")
axes.set(xlabel="film ratio", ylabel="friction coefficient")
axes.legend()
answer = table["friction_coefficient"].iloc[0] / table["friction_coefficient"].iloc[-1]
print(f"mu falls by a factor of {answer:.2f} from 0.3 to 20 m/s")
