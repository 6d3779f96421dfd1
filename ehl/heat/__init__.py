"""Heat in the steady smooth line contact: surfaces, film, and what they do to friction."""

from ehl.heat.conduction import jaeger_matrix, material_point_matrix, peclet_number, surface_matrix
from ehl.heat.estimate import THERMAL_THRESHOLD, ThermalEstimate, estimate_thermal_effect
from ehl.heat.film import (
    CarriedShearHeat,
    CouetteFilm,
    InletFactor,
    carried_shear_heat,
    couette_film,
    flux_to_surface_1,
    inlet_thermal_factors,
    murch_wilson_1975,
    thermal_loading,
    wilson_gupta_1992,
    zhu_cheng_1984,
)
from ehl.heat.traction import FilmProfile, Matrices, ThermalTraction, surface_matrices, thermal_traction

__all__ = [
    "THERMAL_THRESHOLD",
    "CarriedShearHeat",
    "CouetteFilm",
    "FilmProfile",
    "InletFactor",
    "Matrices",
    "ThermalEstimate",
    "ThermalTraction",
    "carried_shear_heat",
    "couette_film",
    "estimate_thermal_effect",
    "flux_to_surface_1",
    "inlet_thermal_factors",
    "jaeger_matrix",
    "material_point_matrix",
    "murch_wilson_1975",
    "peclet_number",
    "surface_matrices",
    "surface_matrix",
    "thermal_loading",
    "thermal_traction",
    "wilson_gupta_1992",
    "zhu_cheng_1984",
]
