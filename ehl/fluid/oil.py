"""Oil cards: properties of one oil, and its `Lubricant` at a temperature."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache, lru_cache
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, ValidationInfo, field_validator, model_validator

from ehl.common.arrays import FloatArray, Values
from ehl.common.data import data_names
from ehl.common.errors import InputError, same_name
from ehl.common.pages import Reportable
from ehl.common.sections import Medium, Section
from ehl.common.units import KELVIN, ValueRange
from ehl.common.validation import InputModel, load_shipped, read_toml, validate
from ehl.fluid import oil_alpha, oil_laws, oil_sheet
from ehl.fluid.density import density_at
from ehl.fluid.lubricant import ASSUMED_CONDUCTIVITY, CONDUCTIVITY_OF_BASE, FilmConductivity, Lubricant
from ehl.fluid.oil_family import OIL_FAMILIES, SHEAR_MODULUS, check_viscosities, generic_card, generic_name
from ehl.fluid.pressure_viscosity import AlphaDefinition
from ehl.fluid.rheology import LinearStress, RisingStress
from ehl.fluid.viscosity import TEMPERATURE_RANGE, Temperature, WaltherViscosity, walther_1931, walther_slope

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pandas import DataFrame

KinematicViscosity = Annotated[float, ValueRange("m^2/s", gt=1e-7, le=1.0)]


class CalibratedValue(InputModel):
    """A parameter fitted to measured friction: SI value, standard error of its logarithm, 95 % interval."""

    value: float
    standard_error: float
    interval_low: float
    interval_high: float
    unit: str = ""


class CalibrationRecord(InputModel):
    """Calibrated parameters of a card and the data they are from (`mixed-ehl calibrate`), in SI units."""

    file: str
    file_hash: str
    date: str
    solver_version: str
    card: str
    model: str
    geometry: str
    coating: str = ""
    rows_used: int
    rows_excluded: int
    outliers: tuple[int, ...] = ()
    noise: float
    fitted: dict[str, CalibratedValue]
    undetermined: tuple[str, ...] = ()
    held: dict[str, float] = Field(default_factory=dict)
    conditions: dict[str, tuple[float, float]]
    surface: dict[str, float] = Field(default_factory=dict)

    def __hash__(self) -> int:
        """Of the data, as tables have no hash: a card is a key of caches."""
        return hash((self.file_hash, self.card, self.date))


class Oil(InputModel, Reportable):
    """An oil card (`data/oils/*.toml`), with source and certainty of each value in the file.

    Examples
    --------
    >>> oil = Oil.load("75w90")
    >>> f"{1e6 * oil.viscosity_kinematic(373.15):.1f} cSt"
    '13.3 cSt'
    """

    name: str
    description: str = ""
    source: str
    certainty: Literal["published", "mixed", "unverified"]
    viscosity_kinematic_40: KinematicViscosity
    viscosity_kinematic_100: KinematicViscosity
    base: Literal["mineral", "hydrocracked", "pao", "polyglycol", "ester"] = "mineral"
    density_15: Annotated[float, ValueRange("kg/m^3", ge=500.0, le=2000.0)]
    density_temperature: Annotated[float, ValueRange("1/K", ge=-2e-3, le=0.0)] = -6.75e-4
    viscosity: oil_laws.ViscosityInput
    pressure_viscosity: oil_laws.AlphaInput
    density_pressure: oil_laws.DensityInput | None = None
    # default: the values of the base oil (`ehl.fluid.oil_family`)
    limiting_shear_coefficient: Annotated[float, ValueRange("", gt=0.0, le=1.0)] | None = None
    limiting_shear_ambient: Annotated[float, ValueRange("Pa", ge=0.0, le=1e8)] | None = None
    eyring_stress: Annotated[float, ValueRange("Pa", ge=1e4, le=1e9)] | None = None
    shear_modulus: Annotated[float, ValueRange("Pa", ge=1e5, le=1e11)] | None = None
    eyring_stress_pressure: RisingStress | None = None
    thermal_conductivity: Annotated[float, ValueRange("W/(m*K)", gt=0.0, le=10.0)] = 0.14
    conductivity_pressure: FilmConductivity | None = None
    heat_capacity: Annotated[float, ValueRange("J/(kg*K)", gt=0.0, le=10000.0)] = 2000.0
    temperature_valid: tuple[Temperature, Temperature] = (20.0 + KELVIN, 150.0 + KELVIN)
    # failure load stage of the FZG scuffing test A/8.3/90, and permissible specific film against micropitting
    fzg_stage: Annotated[int, Field(ge=1, le=14)] | None = None
    film_permissible: Annotated[float, ValueRange("", gt=0.0, le=5.0)] | None = None
    pressure_valid: Annotated[float, ValueRange("Pa", gt=0.0, le=1e10)] | None = None
    calibration: CalibrationRecord | None = None
    # missing values follow from the law
    uncertainty: oil_laws.CardUncertainty = Field(default_factory=dict, validate_default=True)
    # factors of a `varied` card, for formulas of its oil with other inputs
    factors: oil_laws.InputFactors = oil_laws.InputFactors()

    @field_validator("uncertainty", mode="before")
    @classmethod
    def _complete_uncertainty(cls, given: Any, info: ValidationInfo) -> Any:
        """Standard deviations of the inputs, with default values for missing ones."""
        if not isinstance(given, dict):
            return given
        if not {"viscosity", "pressure_viscosity"} <= info.data.keys():  # their errors are reported
            return dict.fromkeys(oil_laws.VARIABLES, 0.0) | {"source": ""} | given
        viscosity, alpha = info.data["viscosity"], info.data["pressure_viscosity"]
        base, certainty = info.data.get("base", "mineral"), info.data.get("certainty", "mixed")
        by_gold = isinstance(alpha, oil_laws.GoldAlpha) and alpha.anchor_value is None
        return oil_laws.standard_uncertainty(viscosity, base if by_gold else None, certainty) | given

    @classmethod
    def load(cls, name: str | Oil) -> Oil:
        """A shipped oil, a generic oil, or a card of the user.

        Parameters
        ----------
        name : str or Oil
            One of `ehl.shipped("oils")` (case-insensitive); a generic oil such as ``"pao 97.5/13.3"`` (cSt at 40 and
            100 degC), ``"mineral vg 220"`` or ``"mineral vg 220 vi 95"`` (`Oil.generic`); the path of a .toml file; or
            an oil, which is returned.

        Raises
        ------
        InputError
            There is no such oil or file; the message lists the shipped ones.

        Examples
        --------
        >>> import ehl
        >>> round(ehl.Oil.load("fva3").viscosity_kinematic(313.15) * 1e6)
        97
        """
        if isinstance(name, Oil):
            return name
        if not name.endswith(".toml"):
            name = same_name(name, data_names("oils"))
        return _load_card(name, _changed(name))

    @classmethod
    def generic(
        cls,
        base: str,
        *,
        nu_40: float | str | None = None,
        nu_100: float | str | None = None,
        iso_vg: int | None = None,
        viscosity_index: float | None = None,
        density_15: float | str | None = None,
        name: str | None = None,
    ) -> Oil:
        """A generic oil from base and viscosity, with ln(eta/eta0) and uncertainty of its family.

        Parameters
        ----------
        base : {"mineral", "hydrocracked", "pao", "ester", "polyglycol"}
        nu_40, nu_100 : float or str, optional
            Kinematic viscosity at 40 and 100 degC, m2/s or with unit.
        iso_vg : int, optional
            ISO VG instead of both; nu100 then follows from the viscosity index or is typical of the family.
        viscosity_index : float, optional
            Viscosity index, with one of the three above (`ehl.fluid.oil_family.astm_d2270`).
        density_15 : float or str, optional
            Density at 15 degC, kg/m3; default: typical of the family.
        name : str, optional
            Name of the card.

        Raises
        ------
        InputError
            There is no such base or viscosity grade, or the viscosity does not decrease with temperature.

        Examples
        --------
        >>> oil = ehl.Oil.generic("pao", nu_40="97.5 cSt", nu_100="13.26 cSt")
        >>> oil == ehl.Oil.load("pao 97.5/13.26"), oil.uncertainty.pressure_viscosity
        (True, 0.14)
        """
        given = {"nu_40": nu_40, "nu_100": nu_100, "density_15": density_15, "viscosity_index": viscosity_index}
        known = validate(_GenericInput, {key: value for key, value in given.items() if value is not None})
        viscosities = known.nu_40, known.nu_100, iso_vg
        content = generic_card(base, *viscosities, known.density_15, name, known.viscosity_index)
        return validate(cls, content, content["name"])

    def __repr__(self) -> str:
        nu_40, nu_100 = 1e6 * self.viscosity_kinematic_40, 1e6 * self.viscosity_kinematic_100
        words = self.description or self.base
        return f"Oil({self.name!r}: {words}, {nu_40:.4g} and {nu_100:.4g} cSt at 40 and 100 degC)"

    __str__ = __repr__

    def density(self, temperature: Values) -> Values:
        """Density at ambient pressure [kg/m3]; `temperature` in K."""
        return density_at(temperature, self.density_15, self.density_temperature)

    def viscosity_kinematic(self, temperature: Values) -> Values:
        """Kinematic viscosity at ambient pressure [m2/s]; `temperature` in K."""
        nu = walther_1931(temperature, self.viscosity_kinematic_40, self.viscosity_kinematic_100)
        return self.factors.viscosity * nu

    def viscosity_dynamic(self, temperature: Values) -> Values:
        """Dynamic viscosity at ambient pressure [Pa s]; `temperature` in K."""
        if isinstance(self.viscosity, WaltherViscosity):
            return self.viscosity_kinematic(temperature) * self.density(temperature)
        viscosity: Values = (
            self.factors.viscosity * oil_laws.figures_by_constants(self.viscosity, temperature, 1.0)["viscosity_inlet"]
        )
        return viscosity

    def temperature_viscosity(self, temperature: Values) -> Values:
        """beta = -d ln(eta)/dT at ambient pressure [1/K]; `temperature` in K."""
        if not isinstance(self.viscosity, WaltherViscosity):
            beta: Values = oil_laws.figures_by_constants(self.viscosity, temperature, 1.0)["temperature_viscosity"]
            return beta
        # eta = nu rho
        thinning = walther_slope(temperature, self.viscosity_kinematic_40, self.viscosity_kinematic_100)
        return thinning - self.density_temperature * self.density_15 / self.density(temperature)

    def alpha(self, temperature: Values) -> Values:
        """Pressure-viscosity coefficient d ln(eta)/dp at p = 0 [1/Pa]; `temperature` in K.

        The other definitions are `ehl.fluid.pressure_viscosity.alpha_of` of the law of the lubricant.
        """
        alpha: Values = oil_alpha.slope(self, temperature)
        return alpha

    @property
    def alpha_definition(self) -> AlphaDefinition:
        """Definition of the coefficient in the card; default: slope."""
        return self.pressure_viscosity.alpha_definition or "slope"

    def remarks(self) -> tuple[str, ...]:
        """Notes on assumptions of this card."""
        law = self.pressure_viscosity
        stated = not isinstance(law, oil_laws.ModulusAlpha) and law.alpha_definition is None
        assumed = self.conductivity_pressure is None and self.base in ("ester", "polyglycol")
        return (oil_laws.NO_DEFINITION.format(where=f"the card of {self.name}"),) * stated + (
            ASSUMED_CONDUCTIVITY,
        ) * assumed

    @property
    def limiting_stress(self) -> tuple[float, float]:
        """tau_L0 [Pa] and Lambda [-] of the card or its base oil."""
        if self.limiting_shear_coefficient is not None:
            return self.limiting_shear_ambient or 0.0, self.limiting_shear_coefficient
        return self.limiting_shear_ambient or 0.0, OIL_FAMILIES[self.base].limit_slope

    def varied(self, **deviations: float) -> Oil:
        """The card with inputs shifted by multiples of the standard deviations in `uncertainty`.

        An input x becomes x exp(n s) with its relative standard deviation s. `pressure_viscosity` multiplies
        ln(eta/eta0) at all pressures and temperatures. The Eyring stress does not depend on the other inputs.

        Parameters
        ----------
        **deviations : float
            n of `pressure_viscosity`, `viscosity`, `eyring_stress`, `limiting_shear`, `thermal_conductivity`; default:
            0.

        Raises
        ------
        InputError
            There is no such input.

        Examples
        --------
        >>> oil = ehl.Oil.load("fva3")
        >>> thick = oil.varied(pressure_viscosity=+1.0)
        >>> rise = [card.at(353.15).log_viscosity_ratio(0.8e9) for card in (oil, thick)]
        >>> round(float(rise[1] / rise[0]), 3)
        1.083
        """
        for name in deviations:
            if name not in oil_laws.VARIABLES:
                raise InputError(name, deviations[name], "one of " + ", ".join(oil_laws.VARIABLES))
        factor = {name: math.exp(n * getattr(self.uncertainty, name)) for name, n in deviations.items()}
        factors = {name: getattr(self.factors, name) * value for name, value in factor.items()}
        changes: dict[str, Any] = {"factors": self.factors.model_copy(update=factors)}
        rising, scale = self.eyring_stress_pressure, factor.get("eyring_stress", 1.0)
        if rising is not None and scale != 1.0:
            changes["eyring_stress_pressure"] = rising.scaled(scale)
        return self.model_copy(update=changes)

    def at(self, temperature: float | FloatArray) -> Lubricant:
        """The lubricant at an inlet temperature.

        Eyring stress, limiting stress and shear modulus are those of the base oil if the card has none.

        Parameters
        ----------
        temperature : float or array
            Inlet temperature [K]; an array gives array fields.

        Raises
        ------
        InputError
            The temperature is outside -40 to 200 degC, or the constants of the card give no viscosity there.

        Examples
        --------
        >>> import ehl
        >>> ehl.Oil.load("fva3").at(353.15).viscosity_law
        'modulus'
        """
        low, high = TEMPERATURE_RANGE
        values = np.ravel(np.asarray(temperature, dtype=float))
        wrong = values[~((low <= values) & (values <= high))]
        if wrong.size:
            allowed, hint = f"{low:.6g} K to {high:.6g} K (-40 to 200 degC)", "Write degrees Celsius as '80 degC'."
            raise InputError("temperature_oil", f"{wrong[0]:.6g} K", allowed, hint)
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            found = self.without_film(temperature)
        inlet = np.ravel(np.asarray(found.viscosity_inlet))
        if not np.all(np.isfinite(inlet) & (inlet > 0.0)):
            impossible = float(np.broadcast_to(values, inlet.shape)[~(np.isfinite(inlet) & (inlet > 0.0))][0])
            allowed = f"a temperature with a finite viscosity by the constants of the oil {self.name}"
            raise InputError("temperature_oil", f"{impossible:.6g} K", allowed, "Correct [viscosity] of its card.")
        single = {name: value for name, value in vars(found).items() if isinstance(value, np.floating | np.ndarray)}
        numbers = {name: float(value) for name, value in single.items() if value.ndim == 0}
        numbers["extrapolated"] = max(map(self._extrapolated, {float(values.min()), float(values.max())}))
        plain = replace(found, **numbers)  # type: ignore[arg-type]
        film = oil_alpha.film(self, temperature, found.pressure_viscosity)
        return plain.with_alpha_film(float(film) if isinstance(film, np.floating) else film)

    def _extrapolated(self, temperature: float) -> float:
        """Distance of ln eta0 from its tangent over 1/T at the end of the measured temperatures [-]."""
        measured = min(max(temperature, self.temperature_valid[0]), self.temperature_valid[1])
        if measured == temperature:
            return 0.0
        end = self.without_film(measured)
        change = math.log(float(self.without_film(temperature).viscosity_inlet / end.viscosity_inlet))
        return abs(change - float(end.temperature_viscosity * measured * (measured / temperature - 1.0)))

    def lubricant(self, temperature: Any) -> Lubricant:
        """`at` without checks, for values that only support arithmetic."""
        found = self.without_film(temperature)
        return found.with_alpha_film(oil_alpha.film(self, temperature, found.pressure_viscosity))

    def without_film(self, temperature: Any) -> Lubricant:
        """`lubricant` without precomputed alpha_film."""
        law, alpha, factors = self.viscosity, self.alpha(temperature), self.factors
        limit_ambient, limit_slope = self.limiting_stress
        stress: float | LinearStress = (
            factors.eyring_stress * self.eyring_stress
            if self.eyring_stress is not None
            else OIL_FAMILIES[self.base].eyring_stress(temperature).scaled(factors.eyring_stress)
        )
        if isinstance(law, WaltherViscosity):
            figures: dict[str, Any] = {
                "viscosity_law": law.law,
                "viscosity_inlet": self.viscosity_dynamic(temperature),
                "pressure_viscosity": alpha,
                "temperature_viscosity": self.temperature_viscosity(temperature),
            }
        else:
            figures = oil_laws.figures_by_constants(law, temperature, oil_alpha.factor(self))
            figures |= {"pressure_viscosity": alpha, "viscosity_inlet": self.viscosity_dynamic(temperature)}
        return Lubricant(
            pressure_rise_factor=factors.pressure_viscosity,
            pressure_valid=self.pressure_valid or math.inf,
            rheology="eyring",
            eyring_stress=stress,
            limiting_shear_coefficient=factors.limiting_shear * limit_slope,
            limiting_shear_ambient=factors.limiting_shear * limit_ambient,
            shear_modulus=self.shear_modulus or SHEAR_MODULUS,
            temperature=temperature,
            density=self.density(temperature),
            thermal_conductivity=factors.thermal_conductivity * self.thermal_conductivity,
            heat_capacity=self.heat_capacity,
            **figures,
            film_conductivity=self.conductivity_pressure or CONDUCTIVITY_OF_BASE[self.base],
            **oil_laws.compression_of(self.density_pressure, law, temperature),
        )

    def to_dict(self, temperatures: str | Sequence[float | str] | None = None) -> dict[str, Any]:
        """The card with all properties at temperatures such as "40, 100 degC" (the default), in SI units."""
        return oil_sheet.sheet(self, oil_sheet.temperatures_of(temperatures))

    def to_frame(self, temperatures: str | Sequence[float | str] | None = None) -> DataFrame:
        """One row per temperature: viscosity, the four alphas, shear and thermal properties in SI units."""
        import pandas as pd

        return pd.DataFrame(self.to_dict(temperatures)["states"])

    def _plot(self, ax: Axes | None, **options: Any) -> Axes:
        return oil_sheet.plot_oil(self, oil_sheet.temperatures_of(options.get("temperatures")), ax)

    def sections(self, medium: Medium = "page", *args: Any, **options: Any) -> list[Section]:
        """Properties at `temperatures` (as in `to_dict`), increase of viscosity with pressure, uncertainty."""
        return oil_sheet.oil_sections(self, oil_sheet.temperatures_of(options.get("temperatures")), medium)

    def save(self, path: str | PathLike[str]) -> None:
        """Write the card as TOML in SI units; `InputError` if the path does not end in .toml."""
        oil_sheet.write_card(self, Path(path), "Oil card written by mixed-ehl")

    def _check_law(self, law: oil_laws.ViscosityByConstants) -> None:
        """Check that the law gives the kinematic viscosities of the card, where it is valid."""
        low, high = self.temperature_valid
        for celsius in (40, 100):
            name, kelvin = f"viscosity_kinematic_{celsius}", celsius + KELVIN
            with np.errstate(all="ignore"):
                eta = float(oil_laws.figures_by_constants(law, kelvin, 1.0)["viscosity_inlet"])
            stated, by_law = 1e6 * getattr(self, name), 1e6 * eta / float(self.density(kelvin))
            if low <= kelvin <= high and abs(by_law - stated) > LAW_AGREES * stated:
                allowed = f"within {100.0 * LAW_AGREES:g} % of {by_law:.4g} cSt, as the law of the card gives"
                hint = "For other viscosities write a new card: `mixed-ehl oil --base ... --nu40 ... --nu100 ... -o`."
                raise InputError(name, f"{stated:.6g} cSt", allowed, hint)

    @model_validator(mode="after")
    def _possible(self) -> Self:
        check_viscosities(self.viscosity_kinematic_40, self.viscosity_kinematic_100, "viscosity_kinematic_100")
        if not isinstance(self.viscosity, WaltherViscosity):
            oil_laws.check_rising(self.viscosity, self.temperature_valid, self.pressure_valid)
            self._check_law(self.viscosity)
        by_constants = isinstance(self.pressure_viscosity, oil_laws.ModulusAlpha)
        if by_constants == isinstance(self.viscosity, WaltherViscosity):
            allowed = "'table' or 'gold'" if by_constants else "'constants': its coefficient follows from its constants"
            allowed += f", with law = '{self.viscosity.law}'"
            raise InputError("pressure_viscosity.law", self.pressure_viscosity.law, allowed)
        return self


LAW_AGREES = 0.02  # largest relative difference of the law of a card from its kinematic viscosities (this work)


class _GenericInput(InputModel):
    """Quantities of `Oil.generic`."""

    nu_40: KinematicViscosity | None = None
    nu_100: KinematicViscosity | None = None
    density_15: Annotated[float, ValueRange("kg/m^3", ge=500.0, le=2000.0)] | None = None
    viscosity_index: Annotated[float, ValueRange("", ge=-20.0, le=400.0)] | None = None


def _changed(name: str) -> int:
    """Time stamp of a card of the user, so that a changed file is read again; 0 for shipped cards."""
    if not name.endswith(".toml"):
        return 0
    try:
        return Path(name).stat().st_mtime_ns
    except OSError:
        return 0


def lubricant_of(name: str | Oil, temperature: Any) -> Lubricant:
    """`Oil.at` of an oil; contacts in series share one card and temperature, so the last are kept."""
    if isinstance(name, Oil) or not isinstance(temperature, float):
        return Oil.load(name).at(temperature)
    return _lubricant_of(name, _changed(name), temperature)


@lru_cache(maxsize=64)
def _lubricant_of(name: str, changed: int, temperature: float) -> Lubricant:
    return Oil.load(name).at(temperature)


@cache
def _load_card(name: str, changed: int) -> Oil:
    if name.endswith(".toml") and Path(name).is_file():
        return validate(Oil, read_toml(name, "oil"), name)
    generic = generic_name(name)
    if generic is not None:
        return validate(Oil, generic_card(**generic), name)
    if name.lower().replace(":", " ").partition(" ")[0] in OIL_FAMILIES:
        allowed = "cSt at 40 and 100 degC 'pao 97.5/13.3', one of them and the index 'pao 97.5 vi 145', or 'pao vg 220'"
        raise InputError("oil", name, allowed, "Numbers have a decimal point.")
    also = "; a generic oil such as 'pao 97.5/13.3' or 'mineral vg 220'; or the path of a card ending in .toml"
    return load_shipped(Oil, "oils", name, "oil", also)
