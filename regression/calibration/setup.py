"""Setup of a calibration (TOML): oil, fitted parameters, specimens, solids, noise, conditions of all rows.

Parameters of a calibration: meaning, bounds, and the oil card with new values.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Literal, NamedTuple, Self

from pydantic import BeforeValidator, Field, model_validator

from ehl import inputs
from ehl.common.errors import InputError, check_choice
from ehl.common.units import KELVIN, ValueRange
from ehl.common.validation import InputModel, in_any_case
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.fluid.oil_laws import GoldAlpha, ModulusAlpha, TabulatedAlpha
from ehl.fluid.rheology import RisingStress, stress_at
from ehl.fluid.viscosity import ModulusViscosity, Temperature
from ehl.inputs import ModelInput, SolidInput, SurfaceInput

GOLD_ANCHOR = 100.0 + KELVIN  # anchor temperature of a formula without measured value [K]
# default of the pressures between which a stress increases: those of the published 75W-90 law [Pa]
RISE_BETWEEN = (0.5e9, 3.5e9)
START_PRESSURE = 1e9  # pressure at which a stress law gives the start value of a constant stress [Pa]


class Bounds(NamedTuple):
    """Bounds of a parameter, which is positive and fitted in its logarithm, SI."""

    low: float
    high: float


PARAMETERS = {
    "eyring_stress": Bounds(2e5, 1e8),  # the same at all pressures
    "stress_low": Bounds(1e5, 1e8),  # lower level of the rising Eyring stress
    "stress_slope": Bounds(1e-3, 0.3),  # of the rising Eyring stress with pressure
    "limiting_shear_coefficient": Bounds(5e-3, 0.3),
    "pressure_viscosity": Bounds(3e-9, 4.5e-8),
    "boundary_film": Bounds(5e-9, 1e-7),
    "boundary_friction": Bounds(0.01, 0.5),
}
RISING = ("stress_low", "stress_slope")
SURFACE = ("boundary_friction", "boundary_film")  # the parameters that are no properties of the oil


def start_values(card: Oil, temperature: float, *, rising: bool) -> dict[str, float]:
    """Values of the oil parameters of a card at a temperature [K] for the selected stress law."""
    lubricant = card.at(temperature)
    values = {
        "limiting_shear_coefficient": lubricant.limiting_shear_coefficient,
        "pressure_viscosity": lubricant.pressure_viscosity,
    }
    if rising:
        law = _rising(card)
        return values | {"stress_low": law.stress_low, "stress_slope": law.stress_slope}
    return values | {"eyring_stress": float(stress_at(lubricant.eyring_stress, START_PRESSURE))}


def _rising(card: Oil) -> RisingStress:
    if card.eyring_stress_pressure is not None:
        return card.eyring_stress_pressure
    start, end = RISE_BETWEEN
    return RisingStress(stress_low=card.eyring_stress or 5e6, stress_slope=0.02, pressure_start=start, pressure_end=end)


def card_with(card: Oil, values: Mapping[str, float], temperature: float) -> Oil:
    """The card with the given parameter values; `pressure_viscosity` is that at `temperature` [K].

    alpha is scaled by one factor at all temperatures; for laws with constants ln(eta/eta0) is scaled.
    """
    changes: dict[str, object] = {}
    for name in ("eyring_stress", "limiting_shear_coefficient"):
        if name in values:
            changes[name] = values[name]
    if "limiting_shear_coefficient" in values and card.limiting_stress[0] > 0.0:
        changes["limiting_shear_ambient"] = card.limiting_stress[0]  # otherwise lost for that of the base oil
    if "stress_low" in values:
        law = _rising(card)
        changes["eyring_stress_pressure"] = law.model_copy(update={name: values[name] for name in RISING})
    if "pressure_viscosity" in values:
        changes |= _scaled_alpha(card, values["pressure_viscosity"] / float(card.alpha(temperature)), temperature)
    return card.model_copy(update=changes)


def _scaled_alpha(card: Oil, factor: float, temperature: float) -> dict[str, object]:
    """The slope at p = 0 times a factor at every temperature; laws with constants are scaled as a whole."""
    law = card.pressure_viscosity
    if factor == 1.0:
        return {}
    if isinstance(law, TabulatedAlpha):
        slopes = tuple(factor * float(card.alpha(at)) for at in law.temperature)
        return {"pressure_viscosity": law.model_copy(update={"value": slopes, **_as_slope(law)})}
    if isinstance(law, GoldAlpha):
        at = law.anchor_temperature if law.anchor_value is not None and law.anchor_temperature else GOLD_ANCHOR
        anchor = {"anchor_temperature": at, "anchor_value": factor * float(card.alpha(at))}
        return {"pressure_viscosity": law.model_copy(update={**anchor, **_as_slope(law)})}
    if isinstance(card.viscosity, ModulusViscosity) and law.anchor_value is None:
        constants = {name: getattr(card.viscosity, name) / factor for name in ("a1", "a2", "b1", "b2")}
        return {"viscosity": card.viscosity.model_copy(update=constants)}
    anchor = {"anchor_temperature": temperature, "anchor_value": factor * float(card.alpha(temperature))}
    return {"pressure_viscosity": ModulusAlpha(law="constants", alpha_definition="slope", **anchor)}


def _as_slope(law: TabulatedAlpha | GoldAlpha) -> dict[str, object]:
    """Definition "slope" if the card has a definition; the default is the slope."""
    return {} if law.alpha_definition is None else {"alpha_definition": "slope"}


def lubricant_of(card: Oil, temperature: float, *, rising: bool) -> Lubricant:
    """The lubricant of a card at a temperature [K]; `rising`: with an Eyring stress that increases with pressure."""
    lubricant = card.at(temperature)
    return replace(lubricant, eyring_stress=_rising(card)) if rising else lubricant


class ConditionsInput(InputModel):
    """Conditions of all rows of the table."""

    instead = inputs.ContactInput.instead

    pressure_hertz: inputs.Pressure | None = None
    load: Annotated[float, ValueRange("N", gt=0.0, le=1e7)] | None = None
    load_per_length: inputs.LoadPerLength | None = None
    radius_equivalent: inputs.Radius | None = None
    speed_entrainment: inputs.Speed | None = None
    slide_to_roll: inputs.SlideToRoll | None = None
    temperature_oil: Temperature | None = None
    roughness_rms: inputs.Rms | None = None


class SpecimensInput(InputModel):
    """Shape of the contact; a point contact is replaced by a line contact, as the solver is for line contacts.

    The line contact has the same maximum (Hertz) pressure or the same mean pressure (`match`).
    """

    geometry: Literal["line", "point"]
    match: Literal["hertz_pressure", "mean_pressure"] = "hertz_pressure"
    radius_transverse: inputs.Radius | None = None
    length: Annotated[float, ValueRange("m", ge=1e-5, le=1.0)] | None = None
    coating: Annotated[str, Field(max_length=200)] = ""

    @model_validator(mode="after")
    def _of_the_geometry(self) -> Self:
        if self.geometry == "line":
            if self.match != "hertz_pressure":
                raise InputError("match", self.match, "match only with geometry = 'point'")
            if self.radius_transverse is not None:
                raise InputError("radius_transverse", self.radius_transverse, "a radius only with geometry = 'point'")
        elif self.length is not None:
            raise InputError("length", self.length, "a length only with geometry = 'line'")
        return self


class NoiseInput(InputModel):
    """Standard deviation of measured mu: sqrt(absolute^2 + (relative mu)^2); estimated if not given."""

    absolute: Annotated[float, ValueRange("", ge=0.0, le=1.0)] | None = None
    relative: Annotated[float, ValueRange("", ge=0.0, le=1.0)] | None = None
    estimate: Literal["absolute", "relative"] = "absolute"

    @model_validator(mode="after")
    def _stated_or_estimated(self) -> Self:
        if self.stated and "estimate" in self.model_fields_set:
            raise InputError("estimate", self.estimate, "either the noise, or estimate for the form of estimated noise")
        if self.stated and not (self.absolute or 0.0) + (self.relative or 0.0) > 0.0:
            raise InputError("absolute", self.absolute, "above 0", "Remove both to estimate the noise.")
        return self

    @property
    def stated(self) -> bool:
        """Whether the noise is given."""
        return self.absolute is not None or self.relative is not None


class CalibrationSetup(InputModel):
    """Known inputs of a measurement and fitted parameters: the content of the setup file."""

    oil: Annotated[str, in_any_case("oils")]
    parameters: Annotated[tuple[str, ...], BeforeValidator(lambda value: (value,) if isinstance(value, str) else value)]
    eyring_stress_law: Literal["constant", "pressure"] | None = None
    conditions: ConditionsInput = ConditionsInput()
    specimens: SpecimensInput
    noise: NoiseInput = NoiseInput()
    solid_1: SolidInput = SolidInput()
    solid_2: SolidInput = SolidInput()
    surface: SurfaceInput = SurfaceInput()
    model: ModelInput = ModelInput(accuracy="fast")

    @model_validator(mode="after")
    def _whole(self) -> Self:
        Oil.load(self.oil)
        self._check_parameters()
        if self.eyring_stress_law == "constant" and set(RISING) & set(self.parameters):
            raise InputError("eyring_stress_law", "constant", "pressure, with stress_low or stress_slope fitted")
        if self.eyring_stress_law == "pressure" and "eyring_stress" in self.parameters:
            raise InputError("eyring_stress_law", "pressure", "constant, with eyring_stress fitted")
        for name in ("roughness_rms_1", "roughness_rms_2", "profile_1", "profile_2"):
            if name in self.surface.model_fields_set:
                hint = "Both surfaces share it equally."
                raise InputError(f"surface.{name}", "given", "roughness_rms in the table or in [conditions]", hint)
        for name, solid in (("solid_1", self.solid_1), ("solid_2", self.solid_2)):
            if solid.temperature_bulk is not None:
                hint = "The bodies have the oil temperature of each row."
                raise InputError(f"{name}.temperature_bulk", solid.temperature_bulk, "no bulk temperature", hint)
        return self

    def _check_parameters(self) -> None:
        names = self.parameters
        if not names:
            raise InputError("parameters", "none", "at least one of " + ", ".join(PARAMETERS))
        for name in names:
            check_choice("parameters", name, PARAMETERS)
            if names.count(name) > 1:
                raise InputError("parameters", name, "each parameter once")
            if name in RISING and "eyring_stress" in names:
                hint = "tau0 is either constant, or increases with pressure (stress_low, stress_slope)."
                raise InputError("parameters", f"eyring_stress, {name}", "one law of the Eyring stress", hint)

    @property
    def roughness_rms(self) -> float:
        """Composite Rq of rows that state none: of a finish, or 0 [m]."""
        surface = self.surface
        return math.hypot(surface.roughness_rms_1, surface.roughness_rms_2) if surface.finish is not None else 0.0

    @property
    def rising(self) -> bool:
        """Whether the Eyring stress increases with pressure."""
        return self.eyring_stress_law == "pressure" or bool(set(RISING) & set(self.parameters))
