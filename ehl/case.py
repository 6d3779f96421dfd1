"""The input file of one contact (`mixed-ehl solve CASE.toml`): tables, units and allowed ranges."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from ehl.contact import LineContact
from ehl.fluid.lubricant_inputs import DirectLubricant as DirectLubricant
from ehl.fluid.lubricant_inputs import LubricantInput
from ehl.fluid.lubricant_inputs import OilLubricant as OilLubricant
from ehl.fluid.lubricant_inputs import PressureViscosity as PressureViscosity
from ehl.fluid.lubricant_inputs import Stress as Stress
from ehl.fluid.lubricant_inputs import Viscosity as Viscosity
from ehl.fluid.oil import Temperature
from ehl.io.errors import InputError
from ehl.io.units import Quantity
from ehl.io.validation import InputModel, read_toml, validate
from ehl.material import Material, effective_modulus, load_material

Radius = Annotated[float, Quantity("m", ge=1e-4, le=10.0)]
Modulus = Annotated[float, Quantity("Pa", ge=1e9, le=2e12)]
Pressure = Annotated[float, Quantity("Pa", ge=5e7, le=8e9)]
LoadPerLength = Annotated[float, Quantity("N/m", ge=1.0, le=1e9)]
Speed = Annotated[
    float,
    Quantity("m/s", ge=1e-4, le=200.0, hint="Point x the way the lubricant is drawn in, and give SR its sign."),
]
SlideToRoll = Annotated[float, Quantity("", ge=-200.0, le=200.0)]
SlidingSpeed = Annotated[float, Quantity("m/s", ge=-200.0, le=200.0)]
Rms = Annotated[float, Quantity("m", ge=0.0, le=2e-5)]
Length = Annotated[float, Quantity("m", ge=1e-6, le=1e-2)]
PeklenikNumber = Annotated[
    float, Quantity("", ge=1.0 / 3.0, le=1e6, hint="1 is isotropic, 3 to 9 ground across; above 1e5 sealed.")
]


class ContactInput(InputModel):
    """Geometry, load and motion. Load: exactly one of `pressure_hertz` and `load_per_length`."""

    radius_equivalent: Radius
    effective_modulus: Modulus | None = None
    pressure_hertz: Pressure | None = None
    load_per_length: LoadPerLength | None = None
    speed_entrainment: Speed
    slide_to_roll: SlideToRoll = 0.0
    speed_sliding_lengthwise: SlidingSpeed = 0.0

    @model_validator(mode="after")
    def _one_load(self) -> Self:
        if (self.pressure_hertz is None) == (self.load_per_length is None):
            both = "neither" if self.pressure_hertz is None else "both"
            raise InputError("pressure_hertz", both, "exactly one of pressure_hertz and load_per_length")
        return self


class SolidInput(InputModel):
    """One body: a shipped material, or one with some figures of its own."""

    material: str = "steel"
    youngs_modulus: Modulus | None = None
    poisson_ratio: Annotated[float, Quantity("", gt=-1.0, lt=0.5)] | None = None
    E: Modulus | None = None
    nu: Annotated[float, Quantity("", gt=-1.0, lt=0.5)] | None = None
    thermal_conductivity: Annotated[float, Quantity("W/(m*K)", gt=0.0, le=2000.0)] | None = None
    heat_capacity: Annotated[float, Quantity("J/(kg*K)", gt=0.0, le=10000.0)] | None = None
    density: Annotated[float, Quantity("kg/m^3", gt=0.0, le=30000.0)] | None = None
    hardness: Annotated[float, Quantity("Pa", gt=0.0, le=1e11)] | None = None
    temperature_bulk: Temperature | None = None

    @model_validator(mode="after")
    def _known(self) -> Self:
        load_material(self.material)
        for short, long in (("E", "youngs_modulus"), ("nu", "poisson_ratio")):
            if getattr(self, short) is not None and getattr(self, long) is not None:
                raise InputError(short, getattr(self, short), f"only one of {short} and {long}")
        return self

    def body(self) -> Material:
        """The material with the figures given here in place of the shipped ones."""
        given = {
            "youngs_modulus": self.youngs_modulus if self.E is None else self.E,
            "poisson_ratio": self.poisson_ratio if self.nu is None else self.nu,
            "thermal_conductivity": self.thermal_conductivity,
            "heat_capacity": self.heat_capacity,
            "density": self.density,
            "hardness": self.hardness,
        }
        changes = {key: value for key, value in given.items() if value is not None}
        return load_material(self.material).model_copy(update=changes)


class SurfaceInput(InputModel):
    """Roughness of both surfaces and the boundary friction of their asperities."""

    roughness_rms_1: Rms = 0.0
    roughness_rms_2: Rms = 0.0
    profile_1: str | None = None
    profile_2: str | None = None
    cutoff_short: Length = 2.5e-6
    cutoff_long: Annotated[float, Quantity("m", ge=1e-5, le=0.1)] | None = 8e-4
    correlation_length: Length = 30e-6
    skewness: Annotated[float, Quantity("", ge=-3.0, le=3.0)] = 0.0
    kurtosis: Annotated[float, Quantity("", ge=1.5, le=20.0)] = 3.0
    peklenik_number: PeklenikNumber = 1.0
    boundary_film: Annotated[float, Quantity("m", ge=5e-9, le=1e-7)] | None = None
    boundary_friction: Annotated[float, Quantity("", ge=0.0, le=1.0)] = 0.10
    seed: Annotated[int, Field(ge=0)] = 1

    @model_validator(mode="after")
    def _one_description(self) -> Self:
        for rms, path in (("roughness_rms_1", self.profile_1), ("roughness_rms_2", self.profile_2)):
            if path is not None and getattr(self, rms) > 0.0:
                raise InputError(rms, getattr(self, rms), "either a measured profile or its Rq, not both")
        return self

    @property
    def measured(self) -> bool:
        """Whether a measured profile is given."""
        return self.profile_1 is not None or self.profile_2 is not None

    @property
    def roughness_rms(self) -> float:
        """Composite Rq of the generated surfaces [m]; measured profiles carry their own."""
        return math.hypot(self.roughness_rms_1, self.roughness_rms_2)


MOST_PRESSURE_OVER_MODULUS = 1.0 / 16.0  # half-width a quarter of the radius
MOST_SLIDING = 200.0  # [m/s]

Thermal = Literal["off", "auto", "on"]
Accuracy = Literal["fast", "standard", "reference"]
Elasticity = Literal["soe", "fft"]


class ModelInput(InputModel):
    """Which physics, and how accurately."""

    thermal: Thermal = "auto"
    accuracy: Accuracy = "standard"
    roughness: Literal["load_sharing", "deterministic"] = "deterministic"
    elasticity: Elasticity = "soe"
    friction_tolerance: Annotated[float, Quantity("", ge=1e-4, le=0.5)] | None = None
    shortcuts: Literal["auto", "off"] = "auto"
    load_sharing: Literal["arana_2019", "doleschel_2002"] = "arana_2019"
    load_sharing_scale: Annotated[float, Quantity("", ge=0.05, le=20.0)] = 1.0

    @model_serializer(mode="wrap")
    def _without_unit_scale(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        # the key of a case is the hash of its text: cases of the published law keep theirs
        content: dict[str, Any] = handler(self)
        if self.load_sharing_scale == 1.0:
            content.pop("load_sharing_scale", None)
        return content


class Case(InputModel):
    """One contact: the content of the file `mixed-ehl solve` reads."""

    contact: ContactInput
    lubricant: LubricantInput
    solid_1: SolidInput = SolidInput()
    solid_2: SolidInput = SolidInput()
    surface: SurfaceInput = SurfaceInput()
    model: ModelInput = ModelInput()

    @model_validator(mode="after")
    def _one_modulus(self) -> Self:
        elastic = {"E", "nu", "youngs_modulus", "poisson_ratio", "material"}
        given = (self.solid_1.model_fields_set | self.solid_2.model_fields_set) & elastic
        if self.contact.effective_modulus is not None and given:
            raise InputError(
                "contact.effective_modulus",
                self.contact.effective_modulus,
                "either effective_modulus or the elastic figures of [solid_1] and [solid_2]",
            )
        return self

    @model_validator(mode="after")
    def _within_the_theory(self) -> Self:
        contact = self.line_contact()
        if contact.pressure_hertz > MOST_PRESSURE_OVER_MODULUS * contact.effective_modulus:
            raise InputError(
                "contact.pressure_hertz",
                f"{contact.pressure_hertz:.4g} Pa",
                f"at most {MOST_PRESSURE_OVER_MODULUS * contact.effective_modulus:.4g} Pa for this effective modulus",
                "The contact would be wider than a quarter of its radius, and bodies are half-spaces here.",
            )
        if contact.speed_sliding > MOST_SLIDING:
            raise InputError(
                "contact.slide_to_roll",
                self.contact.slide_to_roll,
                f"a sliding speed of at most {MOST_SLIDING:g} m/s",
                f"It is {contact.speed_sliding:.4g} m/s.",
            )
        return self

    @model_validator(mode="after")
    def _what_each_model_takes(self) -> Self:
        deterministic = self.model.roughness == "deterministic"
        if self.surface.measured and not deterministic:
            raise InputError(
                "surface.profile_1" if self.surface.profile_1 else "surface.profile_2",
                self.surface.profile_1 or self.surface.profile_2,
                "a measured profile only with model.roughness = 'deterministic'",
                "Load sharing knows Rq alone.",
            )
        return self

    @property
    def modulus(self) -> float:
        """Effective modulus E' [Pa], as given or from the two bodies."""
        given = self.contact.effective_modulus
        return effective_modulus(self.solid_1.body(), self.solid_2.body()) if given is None else given

    def line_contact(self) -> LineContact:
        """The contact the solvers take."""
        c = self.contact
        motion = {
            "speed_entrainment": c.speed_entrainment,
            "slide_to_roll": c.slide_to_roll,
            "speed_sliding_lengthwise": c.speed_sliding_lengthwise,
        }
        if c.pressure_hertz is not None:
            return LineContact.from_pressure(
                radius_equivalent=c.radius_equivalent,
                effective_modulus=self.modulus,
                pressure_hertz=c.pressure_hertz,
                **motion,
            )
        assert c.load_per_length is not None
        return LineContact(c.radius_equivalent, self.modulus, c.load_per_length, **motion)

    def without_effect(self) -> tuple[str, ...]:
        """Inputs the chosen models do not use, in words."""
        idle: list[tuple[str, str]] = []
        given, oil = self.surface.model_fields_set, self.lubricant
        idle += [(f"lubricant.{name}", why) for name, why in oil.idle_keys()]
        incompressible = isinstance(oil, DirectLubricant) and oil.density_law == "incompressible"
        if incompressible and "density_coefficients" in oil.model_fields_set:
            idle.append(("lubricant.density_coefficients", "density_law is incompressible"))
        if self.model.thermal == "off":
            for name, solid in (("solid_1", self.solid_1), ("solid_2", self.solid_2)):
                if solid.temperature_bulk is not None:
                    idle.append((f"{name}.temperature_bulk", "thermal is off"))
        if self.model.elasticity == "fft" and self.model.roughness == "load_sharing":
            idle.append(("model.elasticity", "load sharing has no transient"))
        if self.model.roughness == "deterministic":
            law = {"load_sharing", "load_sharing_scale"} & self.model.model_fields_set
            idle += [(f"model.{name}", "the roughness is deterministic") for name in sorted(law)]
        if self.model.roughness == "load_sharing" and self.surface.roughness_rms > 0.0:
            shape = ("correlation_length", "skewness", "kurtosis", "peklenik_number", "boundary_film", "seed")
            idle += [(f"surface.{name}", "load sharing knows Rq alone") for name in shape if name in given]
        return tuple(f"{name} has no effect: {why}" for name, why in idle)

    def bulk_temperatures(self) -> tuple[float, float]:
        """Bulk temperatures of both bodies [K]; the oil's where none is given."""
        oil = self.lubricant.temperature_oil
        return (self.solid_1.temperature_bulk or oil, self.solid_2.temperature_bulk or oil)


def load_case(path: str | Path) -> Case:
    """Read and check the input file of one contact.

    Raises
    ------
    InputError
        Naming field, value and allowed range.
    """
    return validate(Case, read_toml(path))
