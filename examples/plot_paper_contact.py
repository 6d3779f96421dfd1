r"""
Equations of one contact
========================

The friction coefficient of a smooth contact from its film and pressure, step by step, next to the result of the solver.
"""

import numpy as np
from scipy.integrate import trapezoid

import ehl

contact = ehl.Contact(
    viscosity_inlet="15 mPa s", pressure_viscosity="18 1/GPa", viscosity_law="roelands", eyring_stress="6 MPa",
    pressure_hertz="1 GPa", radius_equivalent="15 mm", speed_entrainment="5 m/s", slide_to_roll=0.2, thermal="off",
)  # fmt: skip
result = contact.solve()
x, p, h = result.film.x, result.film.pressure, result.film.film

# %%
# **Load.** The Hertz pressure :math:`p_h` of a line contact with the effective modulus E' and the radius R carries
# :math:`w'=\frac{\pi}{2}p_hb` with the half-width :math:`b=4Rp_h/E'`.
line = result.problem.line
half_width = 4.0 * line.radius_equivalent * line.pressure_hertz / line.effective_modulus
load = np.pi / 2.0 * line.pressure_hertz * half_width
print(f"load {load / 1e3:.1f} N/mm; integral of the pressure {trapezoid(p, x) / 1e3:.1f} N/mm")

# %%
# **Viscosity** after Roelands, :math:`\ln\eta=\ln\eta_0+(\ln\eta_0+9.67)\left[(1+p/p_0)^z-1\right]` with
# :math:`p_0=0.196` GPa and :math:`z=\alpha p_0/(\ln\eta_0+9.67)`.
eta0, alpha, p0 = 0.015, 18e-9, 1.962e8
height = np.log(eta0) + 9.67
viscosity = eta0 * np.exp(height * ((1.0 + p / p0) ** (alpha * p0 / height) - 1.0))

# %%
# **Shear stress** of a Ree-Eyring fluid at the sliding speed :math:`u_s=SR\,u_r`:
# :math:`\tau=\tau_0\,\mathrm{asinh}\frac{\eta u_s}{\tau_0h}`.
sliding = line.slide_to_roll * line.speed_entrainment
shear = 6e6 * np.arcsinh(viscosity * sliding / (6e6 * h))

# %%
# **Friction coefficient** :math:`\mu=\frac{1}{w'}\int\tau\,\mathrm{d}x`. The solver extrapolates over three meshes and
# adds the inlet upstream of the mesh; this sum takes the finest mesh alone.
answer = trapezoid(shear, x) / load
print(f"mu {answer:.5f} here, {result.friction_coefficient:.5f} by the solver")
figure = result.plot().figure
