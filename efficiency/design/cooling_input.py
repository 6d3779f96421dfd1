"""What the heat balance of the teeth takes: how well each member is cooled."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import model_validator

from ehl.io.errors import InputError
from ehl.io.units import ValueRange
from ehl.io.validation import InputModel


class MemberCooling(InputModel):
    """Cooling of one member: its thermal resistance to the oil, or heat transfer coefficient and wetted area."""

    thermal_resistance: Annotated[float, ValueRange("K/W", gt=0.0, le=1e3)] | None = None
    heat_transfer_coefficient: Annotated[float, ValueRange("W/(m^2*K)", gt=0.0, le=1e6)] | None = None
    cooled_area: Annotated[float, ValueRange("m^2", gt=0.0, le=100.0)] | None = None

    @model_validator(mode="after")
    def _one_description(self) -> Self:
        if self.thermal_resistance is not None:
            for name in ("heat_transfer_coefficient", "cooled_area"):
                if getattr(self, name) is not None:
                    allowed = "either thermal_resistance or heat_transfer_coefficient and cooled_area"
                    raise InputError(name, getattr(self, name), allowed)
        return self


class CoolingInput(InputModel):
    """Table [cooling]: heat from the teeth to the oil.

    `oil_inlet`: the oil enters the contacts at the mean bulk temperature of both members ("bulk") or as it is ("oil").
    """

    pinion: MemberCooling = MemberCooling()
    gear: MemberCooling = MemberCooling()
    oil_inlet: Literal["bulk", "oil"] = "bulk"
