"""
A rough contact and its uncertainty
===================================

Friction of ground flanks: asperity load share, numerical error, and the uncertainty from oil and surfaces.
"""

import ehl

contact = ehl.Contact(
    oil="75w90", temperature="90 degC", pressure_hertz="1.1 GPa", radius_equivalent="18 mm",
    speed_entrainment="2 m/s", slide_to_roll=0.4, finish="ground",
)  # fmt: skip
result = contact.solve()
result.show()
axes = result.plot()
answer = 1e9 * result.film.film_central
print(f"smooth film {answer:.0f} nm; asperities carry {100 * result.asperity_load_share:.0f} % of the load")
