"""Film thickness, film ratio, flash temperature and rolling traction at each contact point.

With solved contacts the values are those of the solution, otherwise those of published formulas.

Bulk temperature of the teeth as a function of the loss, by ISO/TR 15144-1 (after Oster 1982).

The friction of the estimate is that of the normal forces alone on the coarse grid, with the form of a fitted formula.
The loss at the resulting temperature deviates by less than the scatter of the estimate (this work: 30 % of the rise).
"""

import math
from collections.abc import Generator
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from efficiency.loss.kinematics import LoadedPoints, Operation
from ehl.common.arrays import FloatArray
from ehl.common.validation import InputModel
from ehl.fluid.viscosity import TEMPERATURE_RANGE
from ehl.line_contact import blok_1937
from ehl.material import Material
from ehl.state import ContactState
from ehl.uncertainty.spread import Spread
from regression.friction.conditions import Conditions, inlet_heating
from regression.friction.models import FrictionEstimate

Lubrication = Literal["dip", "spray", "submerged"]
# X_S of the report
LUBRICATION_FACTORS: dict[str, float] = {"dip": 1.0, "spray": 1.2, "submerged": 0.2}
# scatter of the estimate, standard deviation of the rise, and that of the oil at the teeth [K] (this work)
SCATTER, OIL = 0.30, 2.0
_CLOSE, _ROUNDS = 0.01, 40  # last step [K]; the error is smaller, as its slope is known within a few per cent
_SLOPE, _STEEPEST = -0.25, 0.5  # change of the rise by the loss over that of the rise: first estimate, upper limit


class CoolingInput(InputModel):
    """Table [cooling]: lubrication of the teeth."""

    lubrication: Lubrication = "dip"  # factor 1, 1.2 and 0.2 on the rise of the bulk temperature


def iso_15144_bulk_rise(power_loss: float, centre_distance: float, face_width: float, factor: float = 1.0) -> float:
    """Rise of the bulk temperature of both members above the oil [K].

    ``7400 (P mu_m H_v/(a b))^0.72 X_S/(1.2 X_Ca)``, ISO/TR 15144-1:2014, formula (84), from a public transcription.
    P mu_m H_v is the loss in kW, a and b are in mm. The factor X_Ca of tip relief (1 to about 1.5) is taken as 1.

    power_loss: sliding loss [W].
    centre_distance, face_width: [m]; for a bevel or hypoid pair the sum of the mean pitch radii and the smaller face
        width (this work).
    factor: X_S [-].
    """
    density = 1e-3 * max(power_loss, 0.0) / (1e6 * centre_distance * face_width)
    return float(7400.0 * density**0.72 * factor / 1.2)


def warmed(operation: Operation, rise: float) -> Operation:
    """The operation with teeth and contact inlets warmer than the oil by `rise` [K]."""
    bulk = min(operation.temperature + rise, TEMPERATURE_RANGE[1])
    return replace(operation, temperature_bulk_pinion=bulk, temperature_bulk_gear=bulk, temperature_inlet=bulk)


def at_hottest(operation: Operation) -> bool:
    """Whether `warming` ended at the highest temperature of the oil laws, so that the rise of the loss is larger."""
    return operation.temperature_bulk_pinion is not None and max(operation.bulk) > TEMPERATURE_RANGE[1] - _CLOSE


def bulk_spread(rise: float) -> Spread:
    """Spread of a bulk temperature that was estimated as `rise` above the oil [K]."""
    return Spread(
        float(np.hypot(SCATTER * rise, OIL)), "absolute", f"{SCATTER:.0%} of the rise, oil {OIL:g} K (estimated)"
    )


def warming(operation: Operation, size: tuple[float, float], factor: float) -> Generator[Operation, float, Operation]:
    """The operation with the bulk temperature of its own loss: a generator of operations that receives their loss [W].

    Secant method on the difference of the rise by the loss and the rise. The slope is limited, so that the steps do not
    pass the lowest rise if the loss increases with the temperature.
    """
    rise, most, slope = 0.0, TEMPERATURE_RANGE[1] - operation.temperature, _SLOPE
    before: tuple[float, float] | None = None
    for _ in range(_ROUNDS):
        found = min(iso_15144_bulk_rise((yield warmed(operation, rise)), *size, factor), most)
        if not np.isfinite(found):
            return operation
        if before is not None and rise != before[0]:
            slope = min((found - before[1]) / (rise - before[0]), _STEEPEST)
        before = rise, found
        step = (found - rise) / (1.0 - slope)
        rise = min(max(rise + step, 0.0), most)
        if abs(step) < _CLOSE:
            break
    return warmed(operation, rise)


# sharpness of the transition between both regimes of rolling traction
BLEND = 10.0


@dataclass(frozen=True)
class SolvedFriction(FrictionEstimate):
    """Friction of solved contacts with further results of the solution."""

    # central film thickness [m], film ratio of the smooth isothermal film [-]
    film_central: FloatArray
    film_ratio: FloatArray
    temperature_flash: FloatArray  # maximum surface temperature [K]
    rolling_traction: FloatArray  # rolling traction of each surface over the load per length [-]
    contacts: int = 0  # number of requested contacts
    failed: dict[str, int] = field(default_factory=dict)  # number of failed contacts by reason
    # relative error of the mean friction coefficient, weighted with the sliding power [-]: random errors of contacts
    # are independent; errors of the method and of failed contacts are correlated
    mean_error: float = math.nan
    method_error: float = math.nan  # its part by the method, which is common to all draws of the roughness [-]


@dataclass(frozen=True)
class LocalLubrication:
    """Lubrication at each loaded point; arrays as in `LoadedPoints`."""

    film_central: FloatArray  # central film thickness with inlet heating [m]
    film_ratio: FloatArray  # lambda: smooth isothermal film over the composite Rq [-]; infinity for smooth flanks
    temperature_flash: FloatArray  # maximum surface temperature: bulk temperature plus flash [K]
    rolling_traction: FloatArray  # traction of the pressure gradient on each surface over the load per length [-]
    # Moes film with the inlet factor of Gupta, flash temperature of Blok, rolling traction of Biboulet &
    # Houpert; or the solutions of the friction model
    source: Literal["formula", "ehl"]


def local_lubrication(
    points: LoadedPoints, friction: FrictionEstimate, table: Conditions, bodies: tuple[Material, Material]
) -> LocalLubrication:
    """Film, flash temperature and rolling traction at the loaded points.

    points: loaded points; surface 1 is the pinion.
    friction: friction at them; a `SolvedFriction` contains the results of solved contacts.
    table: conditions of the points from `regression.friction.conditions.conditions_of`.
    bodies: pinion and gear.
    """
    if isinstance(friction, SolvedFriction):
        return LocalLubrication(
            friction.film_central, friction.film_ratio, friction.temperature_flash, friction.rolling_traction, "ehl"
        )
    state = points.state
    scale = state.effective_modulus * state.radius_equivalent
    return LocalLubrication(
        film_central=np.asarray(table["film_formula"] * inlet_heating(table)),
        film_ratio=table["film_ratio_formula"],
        temperature_flash=surface_temperature(state, friction.mu, bodies),
        rolling_traction=biboulet_houpert_2010(
            2.0 * table["viscosity_inlet"] * state.speed_entrainment / scale, state.load_per_length / scale
        ),
        source="formula",
    )


def biboulet_houpert_2010(speed: FloatArray, load: FloatArray) -> FloatArray:
    """Rolling traction of each surface of a line contact over the load per length [-].

    ``T = 1.42 sqrt(U W)`` of rigid surfaces and ``T = 1.47 U^0.75`` of elastic ones; the smaller one is used, with a
    smooth transition of power 10. T is the force per length over E'R, U = 2 eta0 u_r/(E'R), W = w'/(E'R). Biboulet &
    Houpert 2010, Proc. IMechE J 224, as given by a public secondary source. Isothermal, flooded. The result is 0.82 to
    1.03 times that of the smooth solver of this program (0.1 to 1.8 GPa, 1 and 10 m/s, 75W-90 and FVA3).

    speed, load: U and W [-].
    """
    rigid, elastic = 1.42 * np.sqrt(speed * load), 1.47 * speed**0.75
    force = elastic / (1.0 + (elastic / rigid) ** BLEND) ** (1.0 / BLEND)
    return np.asarray(force / load)


def surface_temperature(
    state: ContactState, friction_coefficient: FloatArray, bodies: tuple[Material, Material]
) -> FloatArray:
    """Maximum surface temperature in the contact [K]: convected bulk temperature of both bodies plus Blok's flash.

    The share of the friction heat into body 1 is B1 sqrt(u1)/(B1 sqrt(u1) + B2 sqrt(u2)); the flash is that of
    `ehl.line_contact.blok_1937`.
    """
    speeds = (1.0 + 0.5 * state.slide_to_roll, 1.0 - 0.5 * state.slide_to_roll)
    one, two = (
        body.thermal_effusivity * np.sqrt(np.abs(speed * state.speed_entrainment))
        for body, speed in zip(bodies, speeds, strict=True)
    )
    share = one / (one + two)
    bulk = share * state.temperature_bulk_1 + (1.0 - share) * state.temperature_bulk_2
    heat = friction_coefficient * state.load_per_length * state.speed_sliding
    return np.asarray(bulk + blok_1937(heat, state.half_width, one + two))
