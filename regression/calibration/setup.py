"""Setup of a calibration (TOML): oil, fitted parameters, specimens, solids, noise, conditions of all rows."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from ehl import inputs
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel, in_any_case, read_toml, validate
from ehl.fluid.oil import Oil
from ehl.fluid.viscosity import Temperature
from ehl.inputs import ModelInput, SolidInput, SurfaceInput
from regression.calibration.parameters import RISING, check_parameters


class ConditionsInput(InputModel):
    """Conditions of all rows of the table."""

    pressure_hertz: inputs.Pressure | None = None
    load: Annotated[float, ValueRange("N", gt=0.0, le=1e7)] | None = None
    load_per_length: inputs.LoadPerLength | None = None
    radius_equivalent: inputs.Radius | None = None
    speed_entrainment: inputs.Speed | None = None
    slide_to_roll: inputs.SlideToRoll | None = None
    temperature_oil: Temperature | None = None
    roughness_rms: inputs.Rms | None = None

    def given(self) -> dict[str, float]:
        """The given conditions in SI units."""
        return {name: value for name, value in self.model_dump().items() if value is not None}


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


def _names(value: Any) -> Any:
    return (value,) if isinstance(value, str) else value


class CalibrationModel(ModelInput):
    """Model of the contacts; rough contacts are solved, whatever `roughness` says."""

    roughness: Literal["solved", "load_sharing"] = "solved"


class CalibrationSetup(InputModel):
    """Known inputs of a measurement and fitted parameters: the content of the setup file."""

    oil: Annotated[str, in_any_case("oils")]
    parameters: Annotated[tuple[str, ...], BeforeValidator(_names)]
    eyring_stress_law: Literal["constant", "pressure"] | None = None
    conditions: ConditionsInput = ConditionsInput()
    specimens: SpecimensInput
    noise: NoiseInput = NoiseInput()
    solid_1: SolidInput = SolidInput()
    solid_2: SolidInput = SolidInput()
    surface: SurfaceInput = SurfaceInput()
    model: CalibrationModel = CalibrationModel(accuracy="fast")

    @model_validator(mode="after")
    def _whole(self) -> Self:
        Oil.load(self.oil)
        check_parameters(self.parameters)
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

    @property
    def roughness_rms(self) -> float:
        """Composite Rq of rows that state none: of a finish, or 0 [m]."""
        surface = self.surface
        return math.hypot(surface.roughness_rms_1, surface.roughness_rms_2) if surface.finish is not None else 0.0

    @property
    def rising(self) -> bool:
        """Whether the Eyring stress increases with pressure."""
        return self.eyring_stress_law == "pressure" or bool(set(RISING) & set(self.parameters))


def load_setup(path: Path, changes: dict[str, Any]) -> CalibrationSetup:
    """Read a setup file."""
    return validate(CalibrationSetup, read_toml(path, "setup") | changes, path.name)
