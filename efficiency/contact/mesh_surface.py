"""The gear flank as a map of the mesh: surface of roll angle, ease-off and where the pinion's blank ends.

All fields are smooth on the gear flank and are kept as Chebyshev patches over (u, v): u [m] along the gear's pitch cone
from the mean point towards the heel, v the fraction of its whole depth from the root.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.assembly import Assembly, dot, turn
from efficiency.contact.ease_off import conjugate_points, ease_off, pinion_phase
from efficiency.contact.patch import Patch
from efficiency.cutting.flank import Flank
from ehl.errors import ConvergenceError

FloatArray = NDArray[np.float64]

POSITION = ("x", "y", "z")
NORMAL = ("nx", "ny", "nz")
_SHAPE = (15, 12)
# how far the map goes beyond the blank along the face and over the tip (fractions of face and depth): line ends can
# then be bracketed, and unloaded contact just over an edge is still seen
_OVERHANG = (0.04, 0.06)
# where the flanks end (undercut) soon after the edge, the map goes only this far
_OVERHANG_NARROW = (0.004, 0.008, 0.008)


@dataclass(frozen=True)
class MeshSurface:
    """Fields of the mesh on the gear flank.

    Attributes
    ----------
    gear, pinion : Flank
        The two real flanks.
    assembly : Assembly
        Their position, misalignments included.
    phase : float
        Rotation of the pinion flank about its axis [rad] that makes the smallest ease-off zero.
    direction : float
        +1 or -1: sense of pinion rotation about the axis of the mesh frame when these flanks drive.
    roll_zero : float
        Pinion rotation f1 [rad] at which the design point touches; roll angles are ``direction (f1 - roll_zero)``.
    design_point : (float, float)
        (u, v) of the design point: mean cone distance, middle of the working depth.
    crest : (float, float)
        (u, v) of the smallest ease-off over lever, where the transmission error has its highest point.
    patch : Patch
        Fields ``x y z nx ny nz`` (gear frame; normal out of the gear tooth), ``roll`` (surface of roll angle in driving
        direction [rad]), ``ease_off`` [m], ``lever`` (arm about the gear axis [m]), ``turn_back`` (ease-off over lever:
        the gear rotation that closes it [rad]), ``bend`` (separation of the conjugate pair over the lever is
        ``bend (roll - angle)^2/2`` at a point fixed to the pinion [1/rad]), ``u1``, ``h1`` (blank coordinates on the
        pinion [m]).
    """

    gear: Flank
    pinion: Flank
    assembly: Assembly
    phase: float
    direction: float
    roll_zero: float
    design_point: tuple[float, float]
    crest: tuple[float, float]
    patch: Patch

    @property
    def pitch(self) -> float:
        """Angular pitch of the pinion [rad]."""
        return 2.0 * np.pi / self.assembly.teeth_pinion

    @property
    def crest_roll(self) -> float:
        """Roll angle of the crest [rad]."""
        u, v = self.crest
        return float(self.patch(np.array([u]), np.array([v]), ("roll",))[0, 0])

    @property
    def interpolation_error(self) -> float:
        """Estimated interpolation error of the ease-off [m]."""
        return self.patch.tail["ease_off"]

    def height(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Height over the gear's pitch cone [m]."""
        return self.gear.blank.height(u, v)

    def fraction(self, u: FloatArray, h: FloatArray) -> FloatArray:
        """Fraction v of the gear's whole depth at a height over its pitch cone."""
        root = self.gear.blank.root(u)
        return np.asarray((h - root) / (self.gear.blank.tip(u) - root))

    def margin(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Distance inside the nearest toe, heel, face or root cone of both members [m], negative outside."""
        u1, h1 = self.patch(u, v, ("u1", "h1"))
        limits = []
        for blank, along, height in (
            (self.gear.blank, u, self.height(u, v)),
            (self.pinion.blank, u1, h1),
        ):
            half = 0.5 * blank.face_width
            limits += [along + half, half - along, blank.tip(along) - height, height - blank.root(along)]
        return np.asarray(np.min(limits, axis=0))

    def exact_roll(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Surface of roll angle from the equation of meshing at the interpolated point and normal."""
        f2, _ = self.assembly.roll(self.patch(u, v, POSITION), self.patch(u, v, NORMAL))
        return np.asarray(self.direction * (f2 / self.assembly.ratio - self.roll_zero))


def mesh_surface(gear: Flank, pinion: Flank, assembly: Assembly, overhang_root: float = 0.06) -> MeshSurface:
    """Build the map of the mesh of two real flanks.

    Parameters
    ----------
    gear, pinion : Flank
        Mating flanks.
    assembly : Assembly
        Their position, misalignments included.
    overhang_root : float
        How far the map goes below the deepest contact with the pinion's face cone, as a fraction of the whole depth.
        A flank that ends just outside the blanks (undercut) gets a map with less overhang on all sides.

    Raises
    ------
    ConvergenceError
        A flank does not exist somewhere in the mating region (undercut), or the members do not mesh there.
    """
    try:
        return _map(gear, pinion, assembly, (*_OVERHANG, overhang_root))
    except ConvergenceError as error:
        if error.reason != "undercut":
            raise
    return _map(gear, pinion, assembly, _OVERHANG_NARROW)


def _map(gear: Flank, pinion: Flank, assembly: Assembly, overhang: tuple[float, float, float]) -> MeshSurface:
    half = 0.5 * gear.blank.face_width * (1.0 + overhang[0])
    u_range = (-half, half)
    deepest = _deepest_contact(gear, pinion, assembly, u_range)
    middle = 0.5 * (deepest + 1.0)
    v_range = (deepest - overhang[2], 1.0 + overhang[1])

    u, v = Patch.nodes(u_range, v_range, _SHAPE)
    # the design point rides along as the last point
    u, v = np.append(u, 0.0), np.append(v, middle)
    points, found = gear.solve(u, gear.blank.height(u, v))
    _require(found, "gear", gear, u, v)
    conjugate = conjugate_points(points, assembly)
    reference = conjugate_points(gear.points(points.parameters[:, -1:]), assembly)
    phase = pinion_phase(reference, pinion)
    relief, parameters, found = ease_off(conjugate, pinion, phase)
    _require(found, "pinion", pinion, u, v)

    in_mesh = assembly.gear_in_mesh(points.position, conjugate.gear_roll)
    force = -turn(points.normal, conjugate.gear_roll)
    lever_pinion, lever_gear = assembly.levers(in_mesh, force)
    lever = np.abs(lever_gear)
    direction = float(np.sign(lever_pinion[-1]))
    pinion_roll = conjugate.gear_roll / assembly.ratio

    # turn the pinion until its highest point touches: the smallest ease-off becomes zero
    tilted = Patch.fit(u_range, v_range, _SHAPE, {"turn_back": (relief / lever)[:-1]})
    crest, lowest = _crest(tilted)
    phase += direction * lowest / abs(assembly.ratio)
    relief, _, found = ease_off(conjugate, pinion, phase, parameters)
    _require(found, "pinion", pinion, u, v)

    u1, h1 = pinion.blank.coordinates(np.hypot(conjugate.position[0], conjugate.position[1]), conjugate.position[2])
    fields = dict(zip(POSITION + NORMAL, [*points.position, *points.normal], strict=True)) | {
        "roll": direction * (pinion_roll - pinion_roll[-1]),
        "ease_off": relief,
        "lever": lever,
        "turn_back": relief / lever,
        "u1": np.real(u1),
        "h1": np.real(h1),
    }
    patch = Patch.fit(u_range, v_range, _SHAPE, {name: values[:-1] for name, values in fields.items()})
    # off their line of contact the conjugate flanks part as bend (roll - angle)^2/2 at a point fixed to the pinion
    frame = line_frame(patch, u[:-1], v[:-1])
    sliding = direction * assembly.sliding(in_mesh[:, :-1])
    share = dot(sliding, turn(frame.gradient, conjugate.gear_roll[:-1]))
    patch = patch.extended({"bend": conjugate.rate[:-1] * (1.0 - share) / lever[:-1]})
    return MeshSurface(gear, pinion, assembly, phase, direction, float(pinion_roll[-1]), (0.0, middle), crest, patch)


def _crest(patch: Patch) -> tuple[tuple[float, float], float]:
    """Place and value of the smallest ease-off over lever; on the rim of the map where it falls to the outside."""
    (u0, u1), (v0, v1) = patch.u_range, patch.v_range
    u, v = (grid.ravel() for grid in np.meshgrid(np.linspace(u0, u1, 41), np.linspace(v0, v1, 31)))
    lowest = int(np.argmin(patch(u, v, ("turn_back",))[0]))
    at = np.array([u[lowest], v[lowest]])
    for _ in range(8):
        a, b = at[:1], at[1:]
        name = ("turn_back",)
        gradient = np.array([patch(a, b, name, du=1)[0, 0], patch(a, b, name, dv=1)[0, 0]])
        mixed = patch(a, b, name, du=1, dv=1)[0, 0]
        hessian = np.array([[patch(a, b, name, du=2)[0, 0], mixed], [mixed, patch(a, b, name, dv=2)[0, 0]]])
        if np.linalg.det(hessian) <= 0.0 or hessian[0, 0] <= 0.0:
            break
        at = np.clip(at - np.linalg.solve(hessian, gradient), [u0, v0], [u1, v1])
    return (float(at[0]), float(at[1])), float(patch(at[:1], at[1:], ("turn_back",))[0, 0])


@dataclass(frozen=True)
class LineFrame:
    """Tangents of the gear flank at points of contact lines, gear frame.

    Attributes
    ----------
    along : (3, n) array
        Unit tangent of the line of constant roll angle, towards the heel.
    gradient : (3, n) array
        Tangential gradient of the roll angle [rad/m]: the line runs over the gear at ``1/|gradient|`` per unit speed.
    rates_gradient, rates_along : (2, n) arrays
        Change of (u, v) per metre along the gradient and along the line.
    """

    along: FloatArray
    gradient: FloatArray
    rates_gradient: FloatArray
    rates_along: FloatArray


def line_frame(patch: Patch, u: FloatArray, v: FloatArray) -> LineFrame:
    """Directions of the contact lines through points of the gear flank."""
    ru, rv = patch(u, v, POSITION, du=1), patch(u, v, POSITION, dv=1)
    (roll_u,), (roll_v,) = patch(u, v, ("roll",), du=1), patch(u, v, ("roll",), dv=1)
    along = (ru * roll_v - rv * roll_u) * np.sign(roll_v)
    stretch = np.sqrt(dot(along, along))
    rates_along = np.stack([roll_v, -roll_u]) * np.sign(roll_v) / stretch
    e, f, g = dot(ru, ru), dot(ru, rv), dot(rv, rv)
    area = e * g - f * f
    up, vp = (g * roll_u - f * roll_v) / area, (e * roll_v - f * roll_u) / area
    gradient = ru * up + rv * vp
    size = np.sqrt(dot(gradient, gradient))
    return LineFrame(along / stretch, gradient, np.stack([up, vp]) / size, rates_along)


def _deepest_contact(gear: Flank, pinion: Flank, assembly: Assembly, u_range: tuple[float, float]) -> float:
    """Smallest fraction v of the gear's depth that the pinion's face cone reaches inside the face width."""
    columns, rows = np.linspace(*u_range, 7), np.linspace(0.0, 1.0, 9)
    u, v = (grid.ravel() for grid in np.meshgrid(columns, rows, indexing="ij"))
    points, found = gear.solve(u, gear.blank.height(u, v))
    f2, _ = assembly.roll(points.position, points.normal)
    found &= np.isfinite(f2)
    f2 = np.where(found, f2, 0.0)
    in_mesh = assembly.gear_in_mesh(points.position, f2)
    position, _ = assembly.to_pinion(in_mesh, points.normal, f2 / assembly.ratio)
    u1, h1 = pinion.blank.coordinates(np.hypot(position[0], position[1]), position[2])
    # a root that is undercut or never meshes lies below the deepest contact all the same
    room = np.where(found, pinion.blank.tip(np.real(u1)) - np.real(h1), -1.0).reshape(columns.size, rows.size)
    # room under the pinion's face cone grows with v; where it is never negative the whole depth is reached
    crossing = [float(np.interp(0.0, column, rows)) for column in room]
    deepest = min(crossing)
    if deepest > 0.9:
        raise ConvergenceError(
            "no_mesh", "the pinion blank hardly reaches the gear flank; check the blanks and the offset"
        )
    return deepest


def _require(found: NDArray[np.bool_], member: str, flank: Flank, u: FloatArray, v: FloatArray) -> None:
    if found.all():
        return
    worst = int(np.argmin(found))
    raise ConvergenceError(
        "undercut",
        f"the {flank.side} {member} flank does not exist at {np.sum(~found)} of {found.size} points, "
        f"for one at u = {u[worst] * 1e3:.3g} mm, depth fraction {v[worst]:.3g} of the gear",
    )
