"""Elastic and thermal properties of the solids, and the effective modulus of a pair."""

from __future__ import annotations

from typing import Annotated

from ehl.common.units import ValueRange
from ehl.common.validation import InputModel, load_shipped


class Material(InputModel):
    """Elastic and thermal properties of one body; each value is an SI number or a string with its unit.

    Parameters
    ----------
    youngs_modulus : float or str
        Young's modulus E [Pa].
    poisson_ratio : float
        Poisson's ratio nu [-].
    thermal_conductivity : float or str
        Thermal conductivity [W/(m K)].
    heat_capacity : float or str
        Specific heat capacity [J/(kg K)].
    density : float or str
        Density [kg/m3].
    hardness : float or str
        Maximum total pressure in contact [Pa].
    contact_endurance, bending_endurance : float or str, optional
        Endurance limits of gears: contact stress sigma_Hlim and nominal root stress sigma_Flim [Pa].
    name, source : str
        Name of the material, and source of the values.
    """

    name: str = "custom"
    source: str = ""
    youngs_modulus: Annotated[float, ValueRange("Pa", ge=1e6, le=2e12)]
    poisson_ratio: Annotated[float, ValueRange("", gt=-1.0, lt=0.5)]
    thermal_conductivity: Annotated[float, ValueRange("W/(m*K)", gt=0.0, le=2000.0)] = 30.0
    heat_capacity: Annotated[float, ValueRange("J/(kg*K)", gt=0.0, le=10000.0)] = 465.0
    density: Annotated[float, ValueRange("kg/m^3", gt=0.0, le=30000.0)] = 7830.0
    hardness: Annotated[float, ValueRange("Pa", gt=0.0, le=1e11)] = 8e9
    contact_endurance: Annotated[float, ValueRange("Pa", gt=0.0, le=1e11)] | None = None
    bending_endurance: Annotated[float, ValueRange("Pa", gt=0.0, le=1e11)] | None = None

    @classmethod
    def load(cls, name: str) -> Material:
        """A shipped material, one of `ehl.shipped("materials")`.

        Raises
        ------
        InputError
            There is no such material; the message lists the available ones.

        Examples
        --------
        >>> import ehl
        >>> ehl.Material.load("steel").poisson_ratio
        0.3
        """
        return load_shipped(cls, "materials", name, "material")

    @property
    def thermal_effusivity(self) -> float:
        """sqrt(k rho c) [J/(m2 K s^1/2)], which determines the flash temperature."""
        return float((self.thermal_conductivity * self.density * self.heat_capacity) ** 0.5)

    @property
    def thermal_diffusivity(self) -> float:
        """k/(rho c) [m2/s]."""
        return self.thermal_conductivity / (self.density * self.heat_capacity)


def effective_modulus(body_1: Material, body_2: Material) -> float:
    """Effective modulus E' [Pa] with 2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.

    Some authors omit the factor 2 and obtain half of this value.
    """
    compliance = sum((1.0 - m.poisson_ratio**2) / m.youngs_modulus for m in (body_1, body_2))
    return 2.0 / compliance
