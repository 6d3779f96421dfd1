"""
An oil under pressure
=====================

How much thicker does the oil get in the contact, and how well is that known?
"""

import ehl

oil = ehl.Oil.generic("pao", nu_40="97.5 cSt", nu_100="13.3 cSt")
state = oil.at(363.15)
print(f"eta0 {1e3 * state.viscosity_inlet:.2f} mPa s, alpha {1e9 * state.alpha:.2f} 1/GPa at 90 degC")
print(f"ln(eta/eta0) uncertain by {100 * oil.uncertainty.pressure_viscosity:.0f} %")

axes = oil.plot(temperatures="40, 90, 120 degC")
answer = 1e9 * state.alpha
