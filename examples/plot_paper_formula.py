r"""
Equations of a friction formula
===============================

The form of Xu and Kahraman (2007), fitted to shipped results by plain least squares, next to the shipped model.
"""

import matplotlib.pyplot as plt
import numpy as np

import regression

data = regression.load_dataset("gear_75w90").converged
data = data[(data["film_ratio"] > 0.5) & (data["slide_to_roll"].abs() > 0.05)]
mu = data["friction_coefficient"].to_numpy()
pressure, slip = data["pressure_hertz"].to_numpy() / 1e9, np.abs(data["slide_to_roll"].to_numpy())
speed, radius = data["speed_entrainment"].to_numpy(), data["radius_equivalent"].to_numpy()
viscosity, roughness = 1e3 * data["viscosity_inlet"].to_numpy(), 1e6 * data["roughness_rms"].to_numpy()

# %%
# **Form**, with the pressure in GPa, the viscosity in mPa s, the entrainment in m/s, R in m and Rq in um:
#
# .. math:: \mu=e^{f}p_h^{b_2}|SR|^{b_3}u_r^{b_6}\eta_0^{b_7}R^{b_8},\qquad
#    f=b_1+b_4|SR|p_h\log_{10}\eta_0+b_5e^{-|SR|p_h\log_{10}\eta_0}+b_9e^{R_q}
#
# Its logarithm is linear in the nine coefficients.
group = slip * pressure * np.log10(viscosity)
terms = [
    np.ones(len(mu)), np.log(pressure), np.log(slip), group, np.exp(-group),
    np.log(speed), np.log(viscosity), np.log(radius), np.exp(roughness),
]  # fmt: skip
matrix = np.column_stack(terms)

# %%
# **Least squares**: minimise :math:`\sum_i(\ln\mu_i-\sum_jb_jf_{ij})^2`.
coefficients, *_ = np.linalg.lstsq(matrix, np.log(mu), rcond=None)
fitted = np.exp(matrix @ coefficients)
answer = float(np.mean(np.abs(fitted / mu - 1.0)))
print(f"{len(mu)} contacts with film ratios above 0.5 and slip above 0.05: mean error {100 * answer:.0f} %")

# %%
# **The shipped model** multiplies a physical form, asperities and film, by factors of small networks. Its error on
# contacts that were never fitted, at all film ratios:
formula = regression.Formula.load("75w90")
print(f"{100 * formula.unseen.mape:.1f} %")
figure, axes = plt.subplots()
axes.loglog(mu, fitted, ".", ms=3)
axes.plot([0.005, 0.1], [0.005, 0.1], color="0.5", lw=0.8)
axes.set(xlabel="solved mu", ylabel="mu of nine coefficients")
