"""Losses of seals and of gears in oil and air: radial shaft seals, churning, windage."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from ehl.common.units import KELVIN
from ehl.fluid.oil import Oil

GRAVITY = 9.80665  # [m/s^2]
AIR_DENSITY, AIR_VISCOSITY = 1.2, 1.5e-5  # at 20 degC [kg/m^3], [m^2/s]
# Reynolds numbers between which both regimes of Changenet and Velex are mixed
_VISCOUS, _INERTIAL = 6000.0, 9000.0
SMALL_SUMP = 1.0  # smallest V/D^3 of their measurements


@dataclass(frozen=True)
class Wheel:
    """A gear for the churning formulas; a bevel gear has its outer pitch diameter (this work)."""

    teeth: int
    radius: float  # pitch radius, of a bevel gear at the heel [m]
    radius_tip: float  # largest radius [m]
    face_width: float  # [m]
    tooth_height: float  # [m]
    pressure_angle: float  # [rad]
    helix_angle: float  # [rad]


def iso_14179_2_seal(diameter: float, speed: float, oil: Oil, temperature: float) -> float:
    """Loss of a radial shaft seal by ISO/TR 14179-2 [W]: ``7.69e-6 d^2 n``, d in mm, n in rpm.

    Read in a public program that names the report; range: one lip, no pressure, any oil and temperature.
    """
    return 7.69e-6 * (1e3 * diameter) ** 2 * abs(speed) * 30.0 / math.pi


def linke_seal(diameter: float, speed: float, oil: Oil, temperature: float) -> float:
    """Loss of a radial shaft seal after Linke [W]: ``(145 - 1.6 T + 350 lg lg(nu_40 + 0.8)) d^2 n 1e-7``.

    T in degC, nu_40 in mm^2/s, d in mm, n in rpm (Linke, Stirnradverzahnung; the three coefficients also in a public
    transcription, the power of ten unverified); range: mineral and synthetic gear oils up to about 120 degC, beyond
    which the formula falls to zero.
    """
    nu40 = 1e6 * float(oil.viscosity_kinematic(40.0 + KELVIN))
    bracket = 145.0 - 1.6 * (temperature - KELVIN) + 350.0 * math.log10(math.log10(nu40 + 0.8))
    return max(bracket, 0.0) * 1e-7 * (1e3 * diameter) ** 2 * abs(speed) * 30.0 / math.pi


SEAL_METHODS: dict[str, Callable[[float, float, Oil, float], float]] = {
    "iso_14179_2": iso_14179_2_seal,
    "linke": linke_seal,
}


def changenet_velex_torque(
    wheel: Wheel, depth: float, speed: float, viscosity: float, density: float, volume: float
) -> float:
    """Churning torque of a gear in an oil bath after Changenet and Velex (J. Mech. Des. 129, 2007) [N m].

    ``T = rho omega^2 R^3 S C/2``, S the wetted surface; with ``Re = omega R b/nu``, ``Fr = omega^2 R/g``, ``D = 2 R``:
    below Re = 6000 ``C = 1.366 (h/D)^0.45 (V/D^3)^0.1 Fr^-0.6 Re^-0.21``, above 9000 ``C = 3.644 (h/D)^0.1
    (V/D^3)^-0.35 Fr^-0.88 (b/D)^0.85``, linear between. Fitted to single spur and helical gears at low and medium
    speed; the two formulas for high speed are not in it, nor the direction of the flow from one gear onto the other.
    V/D^3 below `SMALL_SUMP` is set to it (this work): the rig had V/D^3 of 1 to 7 (box of 365 x 185 mm, gears of 96
    to 160 mm, unverified), an axle has 0.1 to 0.5, for which both formulas differ by a factor 3 to 5 at the same Re.

    wheel: the gear.
    depth: immersion depth h of the tip circle [m].
    speed: [rad/s].
    viscosity, density: kinematic [m^2/s]; [kg/m^3].
    volume: V of the oil [m^3].
    """
    omega, R, b = abs(speed), wheel.radius, wheel.face_width
    h = min(depth, 2.0 * R)
    if h <= 0.0 or omega == 0.0:
        return 0.0
    angle = math.acos(1.0 - h / R)
    flanks = 2.0 * wheel.teeth * angle * wheel.tooth_height * b
    wetted = R**2 * (2.0 * angle - math.sin(2.0 * angle)) + 2.0 * R * b * angle
    wetted += flanks / (math.pi * math.cos(wheel.pressure_angle) * math.cos(wheel.helix_angle))
    reynolds, froude, D = omega * R * b / viscosity, omega**2 * R / GRAVITY, 2.0 * R
    filling = max(volume / D**3, SMALL_SUMP)
    viscous = 1.366 * (h / D) ** 0.45 * filling**0.1 * froude**-0.6 * reynolds**-0.21
    inertial = 3.644 * (h / D) ** 0.1 * filling**-0.35 * froude**-0.88 * (b / D) ** 0.85
    share = min(max((reynolds - _VISCOUS) / (_INERTIAL - _VISCOUS), 0.0), 1.0)
    return float(0.5 * density * omega**2 * R**3 * wetted * ((1.0 - share) * viscous + share * inertial))


def iso_14179_2_torque(depth: float, face_width: float, velocity: float) -> float:
    """Hydraulic loss torque of a gear stage by ISO/TR 14179-2 after Mauz [N m].

    ``T = C_Sp C_1 exp(C_2 v/v_0)``, ``C_1 = 0.063 h/h_0 + 0.0128 (b/b_0)^3``, ``C_2 = h/(80 h_0) + 0.2``, with
    h_0 = b_0 = 10 mm and v_0 = 10 m/s; h is the sum of both immersion depths. The factor C_Sp of oil splashed onto the
    mesh is taken as 1 (this work). Neither viscosity nor diameter is in it: for mineral oils at running temperature and
    gears of the sizes that were measured. Without oil, and at rest, it is taken as zero (this work).

    depth, face_width: h, b [m].
    velocity: at the pitch circle [m/s].
    """
    if depth <= 0.0 or velocity == 0.0:
        return 0.0
    h, b = depth / 0.01, face_width / 0.01
    return (0.063 * h + 0.0128 * b**3) * math.exp((h / 80.0 + 0.2) * velocity / 10.0)


@dataclass(frozen=True)
class OilBath:
    """Oil around two gears, pinion first."""

    depths: tuple[float, float]  # immersion depths of the tip circles [m]
    speeds: tuple[float, float]  # [rad/s]
    viscosity: float  # kinematic [m^2/s]
    density: float  # [kg/m^3]
    volume: float  # [m^3]


def changenet_velex_loss(wheels: tuple[Wheel, Wheel], bath: OilBath) -> float:
    """Churning loss of each of both gears [W]."""
    fluid = bath.viscosity, bath.density, bath.volume
    each = zip(wheels, bath.depths, bath.speeds, strict=True)
    return math.fsum(abs(w) * changenet_velex_torque(wheel, h, w, *fluid) for wheel, h, w in each)


def iso_14179_2_loss(wheels: tuple[Wheel, Wheel], bath: OilBath) -> float:
    """Churning loss of the stage [W]: one torque on the gear shaft, or on the pinion shaft if the gear is not immersed.

    Applied to each gear separately, b^3 would count twice, and a small fast pinion would cause most of the loss.
    """
    dipping = 1 if bath.depths[1] > 0.0 else 0
    depth = math.fsum(min(h, 2.0 * wheel.radius_tip) for wheel, h in zip(wheels, bath.depths, strict=True))
    speed, wide = abs(bath.speeds[dipping]), min(wheel.face_width for wheel in wheels)
    return speed * iso_14179_2_torque(depth, wide, speed * wheels[dipping].radius)


def churning_limits(method: str, wheels: tuple[Wheel, Wheel], bath: OilBath) -> list[str]:
    """A note if the sump is smaller than those of the measurements."""
    filling = bath.volume / (2.0 * wheels[1].radius) ** 3
    if method != "changenet_velex" or bath.depths[1] <= 0.0 or filling >= SMALL_SUMP:
        return []
    return [f"churning: oil volume {filling:.2g} D^3 of the gear, limited to {SMALL_SUMP:g} D^3, the end of the range"]


CHURNING_METHODS: dict[str, Callable[[tuple[Wheel, Wheel], OilBath], float]] = {
    "changenet_velex": changenet_velex_loss,
    "iso_14179_2": iso_14179_2_loss,
}


def windage_torque(radius: float, speed: float) -> float:
    """Torque of a smooth disc in air, both sides (von Karman 1921; Schlichting, Boundary-layer theory) [N m].

    ``T = rho omega^2 R^5 C/2``, C is the larger of 3.87 Re^-0.5 and 0.146 Re^-0.2, ``Re = omega R^2/nu``. Teeth
    are neglected: a lower bound.
    """
    omega = abs(speed)
    if omega == 0.0:
        return 0.0
    reynolds = omega * radius**2 / AIR_VISCOSITY
    return float(0.5 * AIR_DENSITY * omega**2 * radius**5 * max(3.87 * reynolds**-0.5, 0.146 * reynolds**-0.2))
