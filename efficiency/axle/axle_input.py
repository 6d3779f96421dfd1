"""Axle file: a pair, the bearings and seals of both shafts, oil sump, housing, methods."""

import math
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import model_validator

from efficiency.axle.bearings import BearingInput
from efficiency.conditions.duty import SIGNED
from efficiency.cutting.blank import Length
from efficiency.design.shaft_input import Place
from ehl.common.arrays import FloatArray
from ehl.common.data import named_file
from ehl.common.errors import InputError
from ehl.common.units import KELVIN, ValueRange
from ehl.common.validation import InputModel, Name, read_toml, validate
from ehl.fluid.viscosity import Temperature

Coefficient = Annotated[float, ValueRange("W/(m^2*K)", gt=0.0, le=1e5)]


class SealInput(InputModel):
    """A radial shaft seal; diameter of the shaft [m]."""

    diameter: Length


class ShaftInput(InputModel):
    """One of the two shafts."""

    height: Place = 0.0  # of its axis above that of the gear [m]
    # axial, of its two bearings against each other, without load [N]
    preload: Annotated[float, ValueRange("N", ge=0.0, le=1e7)] = 0.0
    bearings: tuple[BearingInput, ...]  # two at least, at different positions
    seals: tuple[SealInput, ...] = ()

    @model_validator(mode="after")
    def _held(self) -> Self:
        if len({bearing.position for bearing in self.bearings}) < 2:
            raise InputError("bearings", len(self.bearings), "at least two bearings at different positions")
        thrusts = sorted(bearing.thrust for bearing in self.bearings if bearing.thrust != "none")
        if thrusts not in (["both"], ["inwards", "outwards"]):
            allowed = "one bearing with thrust = 'both', or one 'inwards' and one 'outwards'"
            raise InputError("bearings.thrust", ", ".join(thrusts) or None, allowed)
        if self.preload and thrusts == ["both"]:
            raise InputError("preload", f"{self.preload:g} N", "0 N if one bearing carries both directions")
        return self

    def loads(self, wrench: FloatArray) -> list[tuple[float, float]]:
        """Radial and axial load of each bearing [N] under a force and moment (6,) at the origin of the axis.

        Radial: statics of the shaft; with more than two bearings that of a rigid shaft on equal springs (this work).
        Axial: ``F_out - F_in = K``; neither below the force that the radial load of a tapered roller bearing needs,
        ``0.5 Fr/Y`` (SKF catalogue), nor below the preload of equal springs, ``F_0 +- K/2``.
        """
        statics = np.linalg.pinv(np.array([[1.0, bearing.position] for bearing in self.bearings]).T)
        radial = np.hypot(*(statics @ -np.array([[wrench[0], wrench[4]], [wrench[1], -wrench[3]]]).T).T)
        pushed = float(wrench[2])
        induced = {
            b.thrust: 0.5 * float(r) / (b.axial_factor or math.inf) for b, r in zip(self.bearings, radial, strict=True)
        }
        inwards = max(
            induced.get("inwards", 0.0), induced.get("outwards", 0.0) - pushed, self.preload - 0.5 * pushed, -pushed
        )
        axial = {"both": abs(pushed), "inwards": inwards, "outwards": inwards + pushed, "none": 0.0}
        return [(float(r), axial[b.thrust]) for b, r in zip(self.bearings, radial, strict=True)]


class SumpInput(InputModel):
    """Oil sump."""

    oil_level: Place  # height of the oil at rest above the axis of the gear, negative below it [m]
    volume: Annotated[float, ValueRange("m^3", gt=0.0, le=1.0)]  # of the oil [m^3]


class HousingInput(InputModel):
    """Heat that leaves the oil through the housing and a cooler."""

    area: Annotated[float, ValueRange("m^2", gt=0.0, le=100.0)]  # outer surface [m^2]
    # coefficient to the air, and from the oil to the housing; the latter 200 W/(m^2 K) after ISO/TR 14179-2
    heat_transfer: Coefficient
    oil_heat_transfer: Coefficient = 200.0
    air_temperature: Temperature = 20.0 + KELVIN  # [K]
    # heat to the coolant over its temperature difference to the oil [W/K]
    cooler_conductance: Annotated[float, ValueRange("W/K", ge=0.0, le=1e6)] = 0.0
    coolant_temperature: Temperature = 60.0 + KELVIN  # [K]

    def removed(self, temperature: float) -> tuple[float, float, float]:
        """Heat through housing and cooler [W], and temperature of the housing [K], at an oil temperature [K]."""
        inside, outside = self.oil_heat_transfer, self.heat_transfer
        flux = (temperature - self.air_temperature) * inside * outside / (inside + outside)
        cooler = self.cooler_conductance * (temperature - self.coolant_temperature)
        return flux * self.area, cooler, temperature - flux / inside


class MethodsInput(InputModel):
    """Method of each loss."""

    bearings: Literal["skf", "iso_14179_2"] = "skf"
    seals: Literal["iso_14179_2", "linke"] = "linke"
    churning: Literal["changenet_velex", "iso_14179_2"] = "changenet_velex"


class OperationInput(InputModel):
    """Default operating point; values that are not given are those of the pair."""

    torque: Annotated[float, SIGNED["torque"]] | None = None  # of the pinion, negative on the coast flanks [N m]
    speed: Annotated[float, SIGNED["speed"]] | None = None  # of the pinion, negative in reverse [rad/s]
    temperature: Temperature | None = None  # of the oil [K]


class AxleInput(InputModel):
    """Content of an axle file."""

    # name and source of the values
    name: Name
    source: str = ""
    pair: str  # design of the gear pair: name of a shipped one, or path from the folder of the axle file
    pinion_shaft: ShaftInput
    gear_shaft: ShaftInput
    sump: SumpInput
    housing: HousingInput
    methods: MethodsInput = MethodsInput()
    operation: OperationInput = OperationInput()


def load_axle(name: str | Path) -> AxleInput:
    """Read and check an axle file, or a shipped axle by its name; the path of the design is relative to its folder."""
    path = named_file("axle", "axles", name)
    content = read_toml(path, "axle")
    given = path.parent / str(content.get("pair", ""))
    if given.is_file():
        content["pair"] = str(given)
    return validate(AxleInput, content, path.name)
