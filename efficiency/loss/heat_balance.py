"""Bulk temperature of the teeth: friction heat into each member against its cooling by the oil, an option.

loss  ->  heat into each member (Blok's division)  ->  T = T_oil + R Q  ->  film and friction there  ->  loss

Steady state; all friction heat leaves through the members to the oil, nothing through shafts or housing. The pressure-
driven flow heats the oil, not the teeth.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from efficiency.cutting.blank import Blank
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.kinematics import Operation
from efficiency.loss.lubrication import heat_share
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.pages import TableResult
from ehl.common.quantities import quantity
from ehl.common.table import Table
from ehl.common.units import KELVIN, ValueRange
from ehl.common.validation import InputModel
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.viscosity import TEMPERATURE_RANGE
from ehl.material import Material

if TYPE_CHECKING:
    pass

FloatArray = NDArray[np.float64]
Solve = Callable[[Operation], EfficiencyResult]

TOLERANCE = 0.01  # [K]
LIMIT = 40
WETTED_SHARE = 0.5


class MemberCooling(InputModel):
    """Cooling of one member: its thermal resistance, or heat transfer coefficient and wetted area.

    Attributes
    ----------
    thermal_resistance : float, optional
        From the teeth to the oil [K/W].
    heat_transfer_coefficient : float, optional
        In its place, with the area [W/(m2 K)]; by default that of flanks wetted once per turn.
    cooled_area : float, optional
        Wetted area [m2]; by default both flanks of all teeth.
    """

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

    Attributes
    ----------
    pinion, gear : MemberCooling
        Of each member.
    oil_inlet : {"bulk", "oil"}
        Temperature of the oil at the inlet of the contacts: the mean bulk temperature of both members, or its own.
    """

    pinion: MemberCooling = MemberCooling()
    gear: MemberCooling = MemberCooling()
    oil_inlet: Literal["bulk", "oil"] = "bulk"

    @property
    def stated(self) -> bool:
        """Whether anything of it is given: resistance, coefficient, area or inlet."""
        return self.model_dump() != CoolingInput().model_dump()


@dataclass(frozen=True, repr=False)
class HeatBalance(TableResult):
    """Bulk temperatures at which the friction heat and the cooling of both members agree.

    Attributes
    ----------
    result : EfficiencyResult
        At these temperatures.
    thermal_resistance : tuple of float
        Of pinion and gear to the oil [K/W].
    heat : tuple of float
        Into pinion and gear [W]; their sum is the power loss.
    rounds : int
        Solutions of the mesh.
    residual : float
        Largest difference between the temperatures used and those the heat would give [K].
    """

    result: EfficiencyResult
    thermal_resistance: tuple[float, float]
    heat: tuple[float, float]
    rounds: int
    residual: float

    def to_dict(self) -> dict[str, Any]:
        """Resistances, heat and convergence, for JSON."""
        return {name: getattr(self, name) for name in ("thermal_resistance", "heat", "rounds", "residual")}

    def __repr__(self) -> str:
        pinion, gear = self.result.temperature_bulk_1, self.result.temperature_bulk_2
        return f"HeatBalance(bulk {pinion:.5g} K and {gear:.5g} K, heat {self.heat[0]:.4g} W and {self.heat[1]:.4g} W)"

    def table(self) -> Table:
        """Bulk temperature, heat and thermal resistance of both members."""
        result = self.result
        inlet = quantity("temperature_inlet").text(result.temperature_inlet)
        return Table.from_columns(
            {
                "member": ("pinion", "gear"),
                "temperature_bulk": (result.temperature_bulk_1, result.temperature_bulk_2),
                "heat": self.heat,
                "thermal_resistance": self.thermal_resistance,
            },
            title="Heat balance: bulk temperatures at which friction heat and cooling of the teeth agree.",
            notes=(f"oil enters the contacts at {inlet}; {self.rounds} rounds, {self.residual:.1g} K left",),
            name="heat balance",
            vertical=True,
        )


def wetted_heat_transfer(lubricant: Lubricant, speed: float) -> float:
    """Heat transfer coefficient of teeth that oil wets once per turn [W/(m2 K)]; a default, ours.

    Fresh oil of unlimited depth takes up ``2 sqrt(k rho c/(pi t))`` per kelvin on average over the time t of a turn;
    half of it is used (films are thin, and not all of the flank is wetted). For an FZG type C pair at 1450 rpm it is
    within 10 % of what the bulk temperature formula of ISO/TR 15144 (from memory) implies, 1240 W/(m2 K).

    Parameters
    ----------
    lubricant : Lubricant
        Oil at its temperature.
    speed : float
        Of the member [rad/s].
    """
    effusivity = math.sqrt(lubricant.thermal_conductivity * lubricant.density * lubricant.heat_capacity)
    return WETTED_SHARE * 2.0 * effusivity * math.sqrt(speed / 2.0) / math.pi


def thermal_resistance(
    blank: Blank, cooling: MemberCooling, lubricant: Lubricant, speed: float, spiral_angle: float
) -> float:
    """Thermal resistance of the teeth of a member to the oil [K/W]; what is not given is the default (ours).

    Parameters
    ----------
    blank : Blank
        Of the member.
    cooling : MemberCooling
        What is given.
    lubricant : Lubricant
        Oil at its temperature.
    speed : float
        Of the member [rad/s].
    spiral_angle : float
        Mean spiral angle [rad].
    """
    height = blank.mean_addendum + blank.mean_dedendum
    area = cooling.cooled_area or 2.0 * blank.teeth * blank.face_width / math.cos(spiral_angle) * height
    transfer = cooling.heat_transfer_coefficient or wetted_heat_transfer(lubricant, speed)
    return cooling.thermal_resistance or 1.0 / (transfer * area)


def heat_into_members(result: EfficiencyResult, bodies: tuple[Material, Material]) -> tuple[float, float]:
    """Friction heat into pinion and gear, mean over the mesh cycle [W]."""
    points = result.points
    power = result.friction.mu * points.force * points.speed_sliding / result.positions
    share = heat_share(points.state, bodies)
    return float(np.sum(share * power)), float(np.sum((1.0 - share) * power))


def balance_heat(
    solve: Solve,
    operation: Operation,
    resistance: tuple[float, float],
    bodies: tuple[Material, Material],
    *,
    warm_inlet: bool = True,
) -> HeatBalance:
    """Find the bulk temperatures of both members.

    Parameters
    ----------
    solve : callable
        Efficiency at an operation.
    operation : Operation
        Speed, oil temperature, roughness; its bulk and inlet temperatures are replaced.
    resistance : tuple of float
        Thermal resistance of pinion and gear to the oil [K/W].
    bodies : tuple of Material
        Pinion and gear.
    warm_inlet : bool
        The oil enters the contacts at the mean of both bulk temperatures, not at its own.

    Raises
    ------
    ConvergenceError
        ``bulk_too_hot`` above the temperatures of oils, ``heat_rounds`` where the temperatures do not settle.
    """
    oil = operation.temperature
    most = TEMPERATURE_RANGE[1] - oil
    rise = np.zeros(2)
    slope = np.zeros((2, 2))  # of the rise that the heat gives by the rise it is computed at
    before: tuple[FloatArray, FloatArray] | None = None
    for rounds in range(1, LIMIT + 1):
        bulk = oil + rise
        result = solve(
            replace(
                operation,
                temperature_bulk_pinion=float(bulk[0]),
                temperature_bulk_gear=float(bulk[1]),
                temperature_inlet=float(bulk.mean()) if warm_inlet else oil,
            )
        )
        heat = heat_into_members(result, bodies)
        wrong = np.array(resistance) * np.array(heat) - rise
        if result.status == "failed":
            return HeatBalance(result, resistance, heat, rounds, float(np.abs(wrong).max()))
        if np.abs(wrong).max() < TOLERANCE:
            return HeatBalance(result, resistance, heat, rounds, float(np.abs(wrong).max()))
        if np.any((rise >= most) & (wrong > 0.0)):
            pinion, gear = (f"{oil + more - KELVIN:.0f} degC" for more in rise)
            detail = f"bulk {pinion} (pinion) and {gear} (gear) and rising: less load or more cooling"
            raise ConvergenceError("bulk_too_hot", detail)
        if before is not None:
            # Broyden's update of the slope, as Newton's method is not worth two more solutions a round
            step, change = rise - before[0], (wrong + rise) - (before[1] + before[0])
            slope += np.outer(change - slope @ step, step) / float(step @ step)
        before = rise.copy(), wrong
        step = np.linalg.solve(np.eye(2) - slope, wrong)
        if step @ wrong <= 0.0:
            # more heat than the cooling can follow: that balance would not be stable, so follow the heat
            step = wrong
        # a slope near 1 would throw the next step far off
        largest = 2.0 * float(np.abs(wrong).max())
        rise = np.clip(rise + np.clip(step, -largest, largest), 0.0, most)
    raise ConvergenceError("heat_rounds", f"bulk temperatures off by {np.abs(wrong).max():.2g} K after {LIMIT} rounds")
