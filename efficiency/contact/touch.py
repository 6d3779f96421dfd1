"""Rotation of the gear that brings it to a point of the real pinion: both flanks placed in space, nothing expanded.

A point of the real pinion flank, carried by the pinion to its angle, lies at some radius and height of the gear; there
the gear flank has a known azimuth. The difference is the rotation at which the gear flank meets that point. Unloaded,
the gear turns as far as the foremost point lets it: the largest such rotation over the flanks. Inside the flanks that
is tangency with a common normal, on their rim the contact of an edge with the mating flank.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.blanks.cones import Blank
from efficiency.contact.mesh_surface import PINION, MeshSurface
from efficiency.cutting.newton import Array

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Touch:
    """Points of the pinion brought to the gear.

    Attributes
    ----------
    slope : (2, n) array
        Derivatives along u and v of the rotation the gear is short of the constant ratio [rad/m, rad].
    limits : (k, n) array
        Distance inside each of `EDGES` [m], each member in its own coordinates; the last one only where the pinion is
        undercut.
    limit_slopes : (k, 2, n) array
        Their derivatives.
    gear_u, gear_v : (n,) arrays
        Where the point touches the gear.
    gear_rotation : (n,) array
        Rotation f2 of the gear at which it touches, from -pi to pi [rad]; real.
    """

    slope: Array
    limits: Array
    limit_slopes: Array
    gear_u: Array
    gear_v: Array
    gear_rotation: FloatArray


def _axial(point: Array, slopes: tuple[Array, Array]) -> tuple[Array, list[Array]]:
    """Radius of points, and the slopes of radius, azimuth and height."""
    radius = np.sqrt(point[0] ** 2 + point[1] ** 2)
    rates = []
    for slope in slopes:
        around = (point[0] * slope[1] - point[1] * slope[0]) / radius**2
        rates.append(np.stack([(point[0] * slope[0] + point[1] * slope[1]) / radius, around, slope[2]]))
    return radius, rates


def _limits(blank: Blank, u: Array, h: Array, rates: list[Array]) -> tuple[list[Array], list[Array]]:
    """Distances inside toe, heel, tip and root of a blank and their slopes; `rates` of radius, azimuth and height."""
    half = 0.5 * blank.face_width
    tip, root = (float(cone(np.ones(1))[0] - cone(np.zeros(1))[0]) for cone in (blank.tip, blank.root))
    tip_zero, root_zero = (float(cone(np.zeros(1))[0]) for cone in (blank.tip, blank.root))
    values = [u + half, half - u, tip_zero + tip * u - h, h - root_zero - root * u]
    c, s = np.cos(blank.pitch_angle), np.sin(blank.pitch_angle)
    along = np.stack([rate[0] * s + rate[2] * c for rate in rates])
    over = np.stack([rate[0] * c - rate[2] * s for rate in rates])
    return values, [along, -along, tip * along - over, over - root * along]


def touch(surface: MeshSurface, angle: FloatArray, u: Array, v: Array) -> Touch:
    """Bring pinion points to the gear.

    Parameters
    ----------
    surface : MeshSurface
        Map of the mesh.
    angle : (n,) array
        Pinion angles from the design point in driving direction [rad].
    u, v : (n,) arrays
        Points of the map whose real pinion points are meant; real or complex.
    """
    assembly, gear, pinion = surface.assembly, surface.gear.blank, surface.pinion.blank
    at, at_u, at_v = surface.patch.slopes(u, v, PINION)
    turned = np.pi + surface.direction * angle + surface.roll_zero
    cosine, sine = np.cos(turned), np.sin(turned)

    def place(vector: Array) -> Array:
        around = np.stack([cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1], vector[2]])
        return np.asarray(assembly.pinion_frame @ around)

    point = place(at) + assembly.pinion_origin - np.array([[0.0], [0.0], [assembly.G]])
    radius, rates = _axial(point, (place(at_u), place(at_v)))
    gear_u, gear_h = gear.coordinates(radius, point[2])
    on_gear, gear_slopes = _limits(gear, gear_u, gear_h, rates)
    depth, depth_rate = on_gear[2] + on_gear[3], gear_slopes[2] + gear_slopes[3]
    gear_v = on_gear[3] / depth
    v_rate = (gear_slopes[3] - gear_v * depth_rate) / depth
    azimuth, by_u, by_v = surface.patch.slopes(gear_u, gear_v, ("azimuth",))
    ahead = [rate[1] for rate in rates] - by_u * gear_slopes[0] - by_v * v_rate

    radius_1, rates_1 = _axial(at, (at_u, at_v))
    pinion_u, pinion_h = pinion.coordinates(radius_1, at[2])
    on_pinion, pinion_slopes = _limits(pinion, pinion_u, pinion_h, rates_1)
    limits, slopes = [*on_gear, *on_pinion], [*gear_slopes, *pinion_slopes]
    if "regular" in surface.patch.names:
        regular, regular_u, regular_v = surface.patch.slopes(u, v, ("regular",))
        scale = surface.undercut_scale
        limits.append(scale * regular[0])
        slopes.append(scale * np.concatenate([regular_u, regular_v]))
    here = np.arctan2(np.real(point[1]), np.real(point[0])) - surface.gear_azimuth
    return Touch(
        slope=-surface.forward * np.stack(ahead),
        limits=np.stack(limits),
        limit_slopes=np.stack(slopes),
        gear_u=gear_u,
        gear_v=gear_v,
        gear_rotation=np.angle(np.exp(1j * (here - np.real(azimuth[0])))),
    )
