"""Friction moments of rolling bearings: the SKF model, and the Palmgren form of ISO/TR 14179-2.

The equations are in millimetres, rpm, mm^2/s and N mm, as printed; arguments and results are in SI units. Equations of
the SKF model: SKF catalogue Rolling bearings, chapter Friction (2013), pages 100 to 111, in part read at yumpu.com;
constants: two independent public transcriptions of its tables 2 and 4, which agree, and two of its diagram of the drag
loss factor, which differ by less than 25 %.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import model_validator
from scipy.optimize import brentq

from efficiency.cutting.blank import Length
from efficiency.design.shaft_input import Place
from ehl.common.data import data_rows
from ehl.common.errors import InputError, check_choice
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel, Name

_MU_BOUNDARY, _MU_STANDSTILL = 0.12, 0.15
_MOST = 700.0  # exponents beyond it are zero in double precision


@cache
def skf_series() -> dict[str, dict[str, tuple[float, ...]]]:
    """R1, R2, S1, S2 of the SKF model by type and series, from `data/skf_bearings.csv`."""
    found: dict[str, dict[str, tuple[float, ...]]] = {}
    for row in data_rows("skf_bearings.csv"):
        constants = tuple(float(row[name]) for name in ("R1", "R2", "S1", "S2"))
        found.setdefault(row["type"], {})[row["series"]] = constants
    return found


@cache
def bearing_types() -> dict[str, dict[str, float]]:
    """Constants of both methods by type, from `data/bearing_types.csv`."""
    rows = data_rows("bearing_types.csv")
    return {row.pop("type"): {name: float(text) for name, text in row.items()} for row in rows}


@cache
def skf_drag() -> dict[str, list[float]]:
    """Oil level H/d_m, and drag loss factor V_M of roller and ball bearings, from `data/skf_drag.csv`."""
    rows = data_rows("skf_drag.csv")
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


class BearingInput(InputModel):
    """A rolling bearing of the axle."""

    name: Name  # name of the bearing
    type: Literal["tapered_roller", "cylindrical_roller", "deep_groove_ball"]
    series: str  # of the SKF constants: 302, 322B...; "other" of a tapered roller bearing without a row of its own
    # where its load acts on the shaft (of a tapered roller bearing the pressure centre): from the crossing point of the
    # axes along the axis, positive towards the teeth; of a cylindrical pair from the middle of the face [m]
    position: Place
    # axial forces of the shaft that it carries: those away from that point along positive positions, against them, both
    thrust: Literal["outwards", "inwards", "both", "none"] = "none"
    # [m]
    bore: Length
    outside_diameter: Length
    width: Length
    axial_factor: Annotated[float, ValueRange("", ge=0.0, le=5.0)] = 0.0  # Y of a tapered roller bearing [-]
    static_load_rating: Annotated[float, ValueRange("N", ge=0.0, le=1e8)] = 0.0  # C0 of a ball bearing [N]
    # of the oil over the lowest point of its outer raceway, where a channel feeds it; by the level of the sump where
    # not given [m]
    oil_depth: Annotated[float, ValueRange("m", ge=0.0, le=3.0)] | None = None
    # of the counterface of its own contact seals [m], with their constants (K_S1, beta, K_S2) of the SKF model
    seal_diameter: Length | None = None
    seal_constants: tuple[float, float, float] = (0.0, 0.0, 0.0)
    # factors of the Palmgren form in place of those of the type [-]
    f0: Annotated[float, ValueRange("", gt=0.0, le=50.0)] | None = None
    f1: Annotated[float, ValueRange("", gt=0.0, le=0.1)] | None = None

    @property
    def of_type(self) -> dict[str, float]:
        """Constants of its type."""
        return bearing_types()[self.type]

    @property
    def mean_diameter(self) -> float:
        """(d + D)/2 [m]."""
        return 0.5 * (self.bore + self.outside_diameter)

    @model_validator(mode="after")
    def _complete(self) -> Self:
        check_choice("series", self.series, skf_series()[self.type])
        if self.bore >= self.outside_diameter:
            raise InputError("bore", f"{1e3 * self.bore:.6g} mm", "below the outside diameter")
        if self.type == "tapered_roller":
            if self.axial_factor == 0.0:
                raise InputError("axial_factor", None, "the factor Y of a tapered roller bearing, such as 1.7")
            if self.thrust not in ("outwards", "inwards"):
                raise InputError("thrust", self.thrust, "outwards or inwards for a tapered roller bearing")
        if self.type == "cylindrical_roller" and self.thrust != "none":
            raise InputError("thrust", self.thrust, "none for a cylindrical roller bearing")
        if self.type == "deep_groove_ball" and self.thrust != "none" and self.static_load_rating == 0.0:
            raise InputError("static_load_rating", None, "C0 of a ball bearing with axial load, such as '30 kN'")
        return self


@dataclass(frozen=True)
class BearingState:
    """Load and oil of a bearing."""

    radial: float  # [N]
    axial: float  # [N]
    speed: float  # [rad/s]
    viscosity: float  # kinematic [m^2/s]
    oil_depth: float = 0.0  # of the oil over the lowest point of the outer raceway [m]
    synthetic: bool = False  # base oil of the sliding contacts of ball bearings


Moments = dict[str, float]
"""Parts of a frictional moment by their names [N m]."""


def skf_moment(bearing: BearingInput, at: BearingState) -> Moments:
    """Rolling, sliding, seal and drag moment of the SKF model [N m].

    ``M = phi_ish phi_rs G_rr (nu n)^0.6 + G_sl mu_sl + M_seal + M_drag``; range: n >= 0, loads above the minimum load
    of the bearing, constant speed, shaft horizontal, large oil reservoir. Oil so thick that starvation and shear
    heating would reduce the rolling moment is replaced by the viscosity of the maximum moment (this work), with a note.
    """
    n, nu, dm = _rpm(at.speed), 1e6 * at.viscosity, 1e3 * bearing.mean_diameter
    rolling, sliding = skf_load_variables(bearing, at.radial, at.axial)
    thick = min(nu, 1e6 * rolling_range(bearing, at))
    shear, starvation = _thick_oil(bearing, at)
    film = bearing.of_type["mu_synthetic" if at.synthetic else "mu_mineral"]
    boundary = math.exp(-min(2.6e-8 * (n * nu) ** 1.4 * dm, _MOST))
    mu = boundary * (_MU_BOUNDARY if n > 0.0 else _MU_STANDSTILL) + (1.0 - boundary) * film
    return {
        "rolling": 1e-3 * math.exp(-starvation * thick) / (1.0 + shear * thick**0.64) * rolling * (thick * n) ** 0.6,
        "sliding": 1e-3 * sliding * mu,
        "seal": skf_seal_moment(bearing),
        "drag": skf_drag_moment(bearing, at),
    }


def skf_load_variables(bearing: BearingInput, radial: float, axial: float) -> tuple[float, float]:
    """G_rr and G_sl of the SKF model in its units, from radial and axial load [N]."""
    r1, r2, s1, s2 = skf_series()[bearing.type][bearing.series]
    dm = 1e3 * bearing.mean_diameter
    if bearing.type == "tapered_roller":
        thrust = bearing.axial_factor * axial
        return r1 * dm**2.38 * (radial + r2 * thrust) ** 0.31, s1 * dm**0.82 * (radial + s2 * thrust)
    if bearing.type == "cylindrical_roller":
        return r1 * dm**2.41 * radial**0.31, s1 * dm**0.9 * axial + s2 * dm * radial
    if axial == 0.0:
        return r1 * dm**1.96 * radial**0.54, s1 * dm**-0.26 * radial ** (5.0 / 3.0)
    sine = math.sin(math.radians(24.6 * (axial / bearing.static_load_rating) ** 0.24))
    return (
        r1 * dm**1.96 * (radial + r2 / sine * axial) ** 0.54,
        s1 * dm**-0.145 * (radial**5 + s2 * dm**1.5 / sine * axial**4) ** (1.0 / 3.0),
    )


def skf_seal_moment(bearing: BearingInput) -> float:
    """Moment of the bearing's own contact seals [N m]: ``K_S1 d_s^beta + K_S2``; 0 of an open bearing."""
    if bearing.seal_diameter is None:
        return 0.0
    k1, beta, k2 = bearing.seal_constants
    return float(1e-3 * (k1 * (1e3 * bearing.seal_diameter) ** beta + k2))


def skf_drag_moment(bearing: BearingInput, at: BearingState) -> float:
    """Moment of drag losses in an oil bath [N m]; range: nu <= 500 mm^2/s, 250 mm^2/s above half the bearing.

    For thicker oil the viscosity is that at the end of the range (this work), with a note: the equation grows with
    nu^1.4.
    """
    d, D, dm = 1e3 * bearing.bore, 1e3 * bearing.outside_diameter, 1e3 * bearing.mean_diameter
    n, depth = _rpm(at.speed), min(1e3 * at.oil_depth, 1.2 * dm)
    nu = 1e6 * min(at.viscosity, drag_range(bearing, at.oil_depth))
    if depth <= 0.0 or n == 0.0:
        return 0.0
    k_z, k_l, slim = bearing.of_type["K_Z"], bearing.of_type["K_L"], (D + d) / (D - d)
    wetted = 2.0 * math.acos(max(1.0 - depth / (0.6 * dm), -1.0))
    surface = 0.36 * dm**2 * (wetted - math.sin(wetted)) * 0.05 * k_z * slim
    factor = math.sin(0.5 * wetted) if wetted <= math.pi else 1.0
    viscous = 1.093e-7 * n**2 * dm**3 * (n * dm**2 * factor / nu) ** -1.379 * surface
    kind = "ball" if bearing.type == "deep_groove_ball" else "roller"
    drag = float(np.interp(depth / dm, skf_drag()["level"], skf_drag()[kind]))
    if kind == "roller":
        length = 5.0 * k_l * 1e3 * bearing.width / dm
        shape = 2.789e-10 * length**3 - 2.786e-4 * length**2 + 0.0195 * length + 0.6439
        volume = 4.0 * drag * k_l * shape
        return float(1e-3 * (volume * k_z * slim * 1e-9 * bearing.width * dm**4 * n**2 + viscous))
    volume = 0.4 * drag
    return float(1e-3 * (volume * k_z * slim * 1e-12 * dm**5 * n**2 + viscous))


def palmgren_moment(bearing: BearingInput, at: BearingState) -> Moments:
    """Moment with and without load of the Palmgren form of ISO/TR 14179-2 [N m].

    ``M_0 = 1e-7 f_0 (nu n)^(2/3) d_m^3``, below nu n = 2000: ``160e-7 f_0 d_m^3``; ``M_1 = f_1 P_1 d_m``, P_1 the
    larger one of Fr and 2 Y Fa (tapered roller) or 3.3 Fa - 0.1 Fr (deep groove ball). Range: moderate speed and load.
    """
    f0, f1 = bearing.f0 or bearing.of_type["f0"], bearing.f1 or bearing.of_type["f1"]
    dm, product = 1e3 * bearing.mean_diameter, 1e6 * at.viscosity * _rpm(at.speed)
    speed = (1e-7 * product ** (2.0 / 3.0) if product >= 2000.0 else 160e-7) * f0 * dm**3
    thrust = {"tapered_roller": 2.0 * bearing.axial_factor * at.axial, "cylindrical_roller": 0.0}
    load = max(at.radial, thrust.get(bearing.type, 3.3 * at.axial - 0.1 * at.radial))
    return {"no load": 1e-3 * speed, "load": 1e-3 * f1 * load * dm}


BEARING_METHODS: dict[str, Callable[[BearingInput, BearingState], Moments]] = {
    "skf": skf_moment,
    "iso_14179_2": palmgren_moment,
}


def drag_range(bearing: BearingInput, oil_depth: float) -> float:
    """Largest viscosity of the SKF drag equation [m^2/s]."""
    return 500e-6 if oil_depth <= 0.5 * bearing.outside_diameter else 250e-6


def rolling_range(bearing: BearingInput, at: BearingState) -> float:
    """Viscosity at which the SKF rolling moment is largest [m^2/s]; infinite where it grows at the oil's own."""
    shear, starvation = _thick_oil(bearing, at)

    def growth(nu: float) -> float:
        return float(0.6 - starvation * nu - 0.64 * shear * nu**0.64 / (1.0 + shear * nu**0.64))

    nu = 1e6 * at.viscosity
    return math.inf if growth(nu) >= 0.0 else 1e-6 * float(brentq(growth, 0.0, nu))


def _thick_oil(bearing: BearingInput, at: BearingState) -> tuple[float, float]:
    """1/phi_ish - 1 over nu^0.64 and -ln phi_rs over nu, nu in mm^2/s.

    The latter is 0 in an oil bath above the lowest rolling elements, 0.1 d_m.
    """
    d, D, dm = 1e3 * bearing.bore, 1e3 * bearing.outside_diameter, 1e3 * bearing.mean_diameter
    n, starved = _rpm(at.speed), 3e-8 if 1e3 * at.oil_depth < 0.1 * dm else 0.0
    return 1.84e-9 * (n * dm) ** 1.28, starved * n * (d + D) * math.sqrt(bearing.of_type["K_Z"] / (2.0 * (D - d)))


def bearing_limits(method: str, bearing: BearingInput, at: BearingState) -> list[str]:
    """Notes on bearings outside the range of their method."""
    speed, most = _rpm(at.speed), 1e-3 * bearing.of_type["speed_factor"] / bearing.mean_diameter
    fast = f"bearing {bearing.name}: {speed:.4g} rpm, above the usual limiting speed (about {most:.0f} rpm)"
    notes = [f"{fast}: its loss is extrapolated"] if speed > most else []
    if method != "skf":
        return notes
    ends = {"rolling moment": rolling_range(bearing, at)}
    if at.oil_depth > 0.0:
        ends["drag"] = drag_range(bearing, at.oil_depth)
    seen = f"of bearing {bearing.name}: {1e6 * at.viscosity:.4g} cSt, limited to"
    thick = (name for name, end in ends.items() if at.viscosity > end)
    return notes + [f"{name} {seen} {1e6 * ends[name]:.3g} cSt, the end of the range" for name in thick]


def _rpm(speed: float) -> float:
    return abs(speed) * 30.0 / math.pi
