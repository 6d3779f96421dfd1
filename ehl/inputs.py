"""Inputs of a contact: the tables of its file with units and ranges, and the form for the solvers."""

import math
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from ehl.common.errors import InputError
from ehl.common.units import ValueRange, parse_quantity, value_range
from ehl.common.validation import InputModel, in_any_case
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.viscosity import Temperature
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.surface import finish as finishes

Radius = Annotated[float, ValueRange("m", ge=1e-4, le=10.0)]
Modulus = Annotated[float, ValueRange("Pa", ge=1e9, le=2e12)]
Pressure = Annotated[float, ValueRange("Pa", ge=5e7, le=8e9)]
LoadPerLength = Annotated[float, ValueRange("N/m", ge=1.0, le=1e9)]
Speed = Annotated[
    float,
    ValueRange("m/s", ge=1e-4, le=200.0, hint="Define x in the direction of entrainment, and adapt the sign of SR."),
]
SlideToRoll = Annotated[float, ValueRange("", ge=-200.0, le=200.0)]
SlidingSpeed = Annotated[float, ValueRange("m/s", ge=-200.0, le=200.0)]
Rms = Annotated[float, ValueRange("m", ge=0.0, le=2e-5)]
Length = Annotated[float, ValueRange("m", ge=1e-6, le=1e-2)]
PeklenikNumber = Annotated[
    float, ValueRange("", ge=1.0 / 3.0, le=1e6, hint="1 is isotropic, 3 to 9 ground across; above 1e5 sealed.")
]

_SPEEDS = "speed_entrainment is (u1 + u2)/2, slide_to_roll is (u1 - u2)/speed_entrainment."
_PRESSURE = "pressure_hertz is the maximum, 4/pi of the mean pressure (point contact: 3/2)."
_LOAD = "load_per_length is the load over the length of the contact line."
_OF_DISCS = {
    **dict.fromkeys(("radius", "r"), "1/radius_equivalent = 1/R1 + 1/R2."),
    **dict.fromkeys(("speed", "u", "v", "speed_rolling", "speed_sliding", "sliding_speed"), _SPEEDS),
    **dict.fromkeys(("pressure_mean", "pressure"), _PRESSURE),
    **dict.fromkeys(("load", "force", "normal_force", "width", "length", "face_width"), _LOAD),
}
_OF_SOLIDS = {"e": "Young's modulus is youngs_modulus.", "nu": "Poisson's ratio is poisson_ratio."}
RA = "Rq is about 1.25 Ra (Gaussian heights)."


class ContactInput(InputModel):
    """Geometry, load and motion. Load: exactly one of `pressure_hertz` and `load_per_length`."""

    instead = _OF_DISCS

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
            allowed = "exactly one of pressure_hertz and load_per_length"
            raise InputError("pressure_hertz", self.pressure_hertz and "together with load_per_length", allowed)
        return self


class SolidInput(InputModel):
    """One body: a shipped material, optionally with other properties."""

    instead = _OF_SOLIDS

    material: Annotated[str, in_any_case("materials")] = "steel"
    youngs_modulus: Modulus | None = None
    poisson_ratio: Annotated[float, ValueRange("", gt=-1.0, lt=0.5)] | None = None
    thermal_conductivity: Annotated[float, ValueRange("W/(m*K)", gt=0.0, le=2000.0)] | None = None
    heat_capacity: Annotated[float, ValueRange("J/(kg*K)", gt=0.0, le=10000.0)] | None = None
    density: Annotated[float, ValueRange("kg/m^3", gt=0.0, le=30000.0)] | None = None
    hardness: Annotated[float, ValueRange("Pa", gt=0.0, le=1e11)] | None = None
    temperature_bulk: Temperature | None = None

    @model_validator(mode="after")
    def _known(self) -> Self:
        Material.load(self.material)
        return self

    def body(self) -> Material:
        """The material with the properties given here."""
        names = type(self).model_fields.keys() & Material.model_fields.keys()
        changes = {name: value for name in names if (value := getattr(self, name)) is not None}
        return Material.load(self.material).model_copy(update=changes)


def kurtosis_of(skewness: float) -> float:
    """Default kurtosis [-]: that of truncated heights, below that of the lognormal distribution."""
    return 3.0 + 1.5 * skewness**2


EACH_RMS = ("roughness_rms_1", "roughness_rms_2")
PRINTED = {
    "rsm": ValueRange("m", ge=5e-6, le=5e-3),
    "rdq": ValueRange("", ge=1e-4, le=0.5),
    "sal": ValueRange("m", ge=1e-6, le=1e-3),
}

LEAST_WORN = 0.3  # least Rq over that before running-in: with less hardly a valley is left (this work)
WORN_RMS = ValueRange("m", ge=1e-8, le=2e-5, hint="Rq of each surface after running-in, or none.")


class SurfaceInput(InputModel):
    """Roughness of both surfaces and the boundary friction of their asperities.

    Rq is given for each surface (`roughness_rms_1`, `roughness_rms_2`), or as the composite Rq of two equal surfaces
    (`roughness_rms`). The profilometer parameters `rsm`, `rdq` and `sal` may replace the correlation length.
    """

    instead = dict.fromkeys(
        ("ra", "rq", "roughness_ra", "roughness"), "Give Rq as roughness_rms_1 and roughness_rms_2. " + RA
    )

    roughness_rms_1: Rms = 0.0
    roughness_rms_2: Rms = 0.0
    profile_1: str | None = None
    profile_2: str | None = None
    profile_unit_x: str = ""
    profile_unit_height: str = ""
    detrend: Annotated[int, Field(ge=1, le=8)] = 2
    cutoff_short: Length = 2.5e-6
    cutoff_long: Annotated[float, ValueRange("m", ge=1e-5, le=0.1)] | None = 8e-4
    finish: Annotated[str | None, in_any_case("finishes")] = None
    finish_state: finishes.State = "run_in"
    additive: Annotated[str, in_any_case("additives")] = finishes.DEFAULT_ADDITIVE
    spectrum: Literal["gaussian", "self_affine"] = "gaussian"
    hurst_exponent: Annotated[float, ValueRange("", ge=0.1, le=0.95)] = 0.85
    correlation_length: Length = finishes.SHORTEST_LENGTH
    skewness: Annotated[float, ValueRange("", ge=-3.0, le=3.0)] = 0.0
    kurtosis: Annotated[float, ValueRange("", ge=1.5, le=20.0)] = 3.0
    lay_angle: Annotated[float, ValueRange("rad", ge=-1.571, le=1.571)] = 0.0
    peklenik_number: PeklenikNumber = 1.0
    # the range includes half and twice the film of every additive, for the study of its effect
    boundary_film: Annotated[float, ValueRange("m", ge=1e-9, le=1e-6)] | None = None
    boundary_friction: Annotated[float, ValueRange("", ge=0.0, le=1.0)] = 0.10
    # Rq of each rough surface after its peaks have worn
    running_in: Literal["none"] | float = "none"
    seed: Annotated[int, Field(ge=0)] = 1

    @model_validator(mode="before")
    @classmethod
    def _of_other_forms(cls, values: Any) -> Any:
        """Fields from the composite Rq, the profilometer parameters and a text for Rq after running-in."""
        if not isinstance(values, dict):
            return values
        found = dict(values)
        if found.get("roughness_rms") is not None:
            if any(found.get(name) is not None for name in EACH_RMS):
                allowed = "either the composite roughness_rms, or roughness_rms_1 and roughness_rms_2 of the surfaces"
                raise InputError("roughness_rms", values["roughness_rms"], allowed)
            each = value_range(Rms).check(found.pop("roughness_rms"), "roughness_rms") / 2.0**0.5
            found |= dict.fromkeys(EACH_RMS, each)
        printed = {name: PRINTED[name].check(found[name], name) for name in PRINTED if found.get(name) is not None}
        if printed:
            if (given := found.get("correlation_length")) is not None:
                raise InputError("correlation_length", given, "either correlation_length, or rsm, rdq and sal")
            rough = [parse_quantity(found.get(name) or 0.0, "m", field=name) for name in EACH_RMS]
            rough = [rms for rms in rough if rms > 0.0]
            if "rdq" in printed and not rough:
                raise InputError("rdq", values["rdq"], "rdq together with Rq of the surfaces")
            rms = math.sqrt(sum(value**2 for value in rough) / max(len(rough), 1))
            found = {name: value for name, value in found.items() if name not in PRINTED}
            found["correlation_length"] = finishes.printed_correlation_length(rms, **printed)
        if "running_in" in found:
            worn = found["running_in"]
            none = worn is None or (isinstance(worn, str) and worn.strip().lower() == "none")
            found["running_in"] = "none" if none else WORN_RMS.check(worn, "running_in")
        return found

    @model_validator(mode="after")
    def _one_description(self) -> Self:
        for rms, path in (("roughness_rms_1", self.profile_1), ("roughness_rms_2", self.profile_2)):
            if path is not None and getattr(self, rms) > 0.0:
                raise InputError(
                    rms, f"{1e6 * getattr(self, rms):g} um", "either a measured profile or its Rq, not both"
                )
        if self.running_in != "none" and self.finish is not None and self.finish_state == "run_in":
            raise InputError("finish_state", self.finish_state, "new, together with running_in: wear begins there")
        return self

    @model_validator(mode="after")
    def _fill(self) -> Self:
        # defaults are not marked as given, so that the correlation length follows a changed Rq
        for name, value in self._defaults().items():
            if name not in self.model_fields_set:
                self.__dict__[name] = value
        rough = max(self.roughness_rms_1, self.roughness_rms_2)
        if self.running_in != "none" and self.running_in < LEAST_WORN * rough:
            allowed = f"at least {LEAST_WORN * rough * 1e6:.3g} um, {100 * LEAST_WORN:.0f} % of Rq before running-in"
            raise InputError("running_in", f"{self.running_in * 1e6:.3g} um", allowed)
        return self

    def _defaults(self) -> dict[str, Any]:
        """Default values from finish, additive and Rq."""
        values: dict[str, Any] = {"boundary_friction": finishes.Additive.load(self.additive).boundary_friction.value}
        if self.finish is None:
            length = finishes.default_correlation_length(self.roughness_rms_1, self.roughness_rms_2)
            return values | {"correlation_length": float(length), "kurtosis": kurtosis_of(self.skewness)}
        finish = finishes.Finish.load(self.finish, self.finish_state)
        for rms, path in (("roughness_rms_1", self.profile_1), ("roughness_rms_2", self.profile_2)):
            if rms not in self.model_fields_set and path is None:
                self.__dict__[rms] = values[rms] = finish.roughness_rms.value
        skewness = self.skewness if "skewness" in self.model_fields_set else finish.skewness.value
        each = [rms for rms in (self.roughness_rms_1, self.roughness_rms_2) if rms > 0.0]
        own = finish.length_at(math.hypot(*each) / math.sqrt(len(each) or 1.0))
        length, gamma = finishes.lay_seen(float(own), finish.lay_ratio.value, self.lay_angle)
        return values | {
            "correlation_length": float(length),
            "skewness": skewness,
            "kurtosis": kurtosis_of(skewness),
            "peklenik_number": max(float(gamma), 1.0 / 3.0),
        }

    @property
    def hurst(self) -> float | None:
        """Hurst exponent of generated profiles; None for the Gaussian autocorrelation."""
        return self.hurst_exponent if self.spectrum == "self_affine" else None

    @property
    def film_of_contact(self) -> float:
        """h_boundary: the given boundary film, or that of the additive [m]."""
        return self.boundary_film or finishes.Additive.load(self.additive).boundary_film.value

    @property
    def profile_reading(self) -> dict[str, Any]:
        """Options of `ehl.surface.measured_surface.load_profile` for measured profiles."""
        return {
            "unit_x": self.profile_unit_x,
            "unit_height": self.profile_unit_height,
            "detrend": self.detrend,
            "cutoff_long": self.cutoff_long,
        }

    @property
    def each(self) -> tuple[tuple[float, str | None], tuple[float, str | None]]:
        """Rq before running-in [m] and measured profile of both surfaces."""
        return (self.roughness_rms_1, self.profile_1), (self.roughness_rms_2, self.profile_2)

    @property
    def measured(self) -> bool:
        """Whether a measured profile is given."""
        return self.profile_1 is not None or self.profile_2 is not None

    def rms_in_contact(self, rms: float) -> float:
        """Rq of a surface in the contact [m], from its Rq before running-in."""
        return rms if self.running_in == "none" else min(rms, self.running_in)

    @property
    def roughness_rms(self) -> float:
        """Composite Rq of the generated surfaces in the contact [m], without measured profiles."""
        return math.hypot(*map(self.rms_in_contact, (self.roughness_rms_1, self.roughness_rms_2)))


MAX_PRESSURE_OVER_MODULUS = 1.0 / 16.0  # half-width a quarter of the radius
MAX_SLIDING = 200.0  # [m/s]

Thermal = Literal["off", "auto", "on"]
Accuracy = Literal["fast", "standard", "reference"]
TOLERANCE: dict[str, float] = {"fast": 0.05, "standard": 0.02, "reference": 0.01}  # relative, of mu


class ModelInput(InputModel):
    """Models and accuracy."""

    thermal: Thermal = "auto"
    accuracy: Accuracy = "standard"
    friction_tolerance: Annotated[float, ValueRange("", ge=1e-4, le=0.5)] | None = None
    shortcuts: Literal["auto", "off"] = "auto"

    @property
    def tolerance(self) -> float:
        """Required relative accuracy of mu [-]."""
        return self.friction_tolerance or TOLERANCE[self.accuracy]


_OF_LINE = (
    *("pressure_hertz", "load_per_length", "radius_equivalent", "effective_modulus", "speed_entrainment"),
    *("slide_to_roll", "speed_sliding_lengthwise"),
)


@dataclass(frozen=True)
class ContactProblem:
    """One contact in the form of the solvers, in SI units.

    line: geometry, load and motion.
    lubricant: the oil at its inlet temperature.
    surface: roughness and boundary friction.
    model: physics and accuracy.
    bodies: both bodies.
    temperature_bulk: their bulk temperatures [K].
    """

    line: LineContact
    lubricant: Lubricant
    surface: SurfaceInput
    model: ModelInput
    bodies: tuple[Material, Material]
    temperature_bulk: tuple[float, float]

    @property
    def rough(self) -> bool:
        """Whether either surface is rough."""
        return self.surface.roughness_rms > 0.0 or self.surface.measured

    @property
    def hardness(self) -> float:
        """Hardness of the softer body [Pa]."""
        return min(body.hardness for body in self.bodies)

    def to_dict(self) -> dict[str, float]:
        """Operating point in SI units with the names of docs/nomenclature.md."""
        return {
            **{name: getattr(self.line, name) for name in _OF_LINE},
            "temperature_oil": self.lubricant.temperature,
            "temperature_bulk_1": self.temperature_bulk[0],
            "temperature_bulk_2": self.temperature_bulk[1],
            "viscosity_inlet": self.lubricant.viscosity_inlet,
            "pressure_viscosity": self.lubricant.alpha,
            "roughness_rms_1": self.surface.roughness_rms_1,
            "roughness_rms_2": self.surface.roughness_rms_2,
        }
