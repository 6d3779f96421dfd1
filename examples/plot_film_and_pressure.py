"""
Film and pressure in one contact
================================

The classic picture: a flat film with a constriction at the outlet, a Hertzian pressure with its spike.
"""

import ehl

contact = ehl.Contact(
    oil="fva3", temperature="80 degC", pressure_hertz="0.8 GPa", radius_equivalent="15 mm",
    speed_entrainment="3 m/s", slide_to_roll=0.1,
)  # fmt: skip
result = contact.solve()
axes = result.plot()
answer = 1e9 * result.film_min
print(f"smallest film {answer:.0f} nm, numerical error {100 * result.film_error:.2g} %")
