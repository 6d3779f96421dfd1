"""Flanks of a two-part head by a second algorithm: no normals, no equation of meshing.

The edge of a blade moves with the head, the cradle and the work; the swept points fill space except where the
determinant of the map from (length along the edge, head angle, roll) to space vanishes: the envelope. Numbers are read
from a design file; nothing of the product is called.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
STEP = 1e-30


def rotated(axis: int, angle: Any, point: Array) -> Array:
    """Points (3, n) rotated about a coordinate axis."""
    a, b = (axis + 1) % 3, (axis + 2) % 3
    out = [point[0], point[1], point[2]]
    out[a] = np.cos(angle) * point[a] - np.sin(angle) * point[b]
    out[b] = np.sin(angle) * point[a] + np.cos(angle) * point[b]
    return np.array([component + 0.0 * out[a] for component in out])


class HeadFlank:
    """One flank of one member from the tables of a design file in SI units."""

    def __init__(self, flank: Mapping[str, Any], blank: Mapping[str, Any], side: str) -> None:
        self.m, self.c, self.b = flank["machine"], flank["cutter"], blank
        self.hand = 1.0 if blank["hand"] == "right" else -1.0
        self.out = 1.0 if side == "concave" else -1.0
        self.start = self._facing()

    def cone(self, u: Array, h: Array) -> Array:
        """Radius and height along the axis of points at (u, h) of the pitch cone."""
        d, along = self.b["pitch_angle"], self.b["mean_cone_distance"] + u
        apex = self.b["pitch_apex_beyond_crossing"]
        return np.array([along * np.sin(d) + h * np.cos(d), along * np.cos(d) - h * np.sin(d) - apex])

    def _facing(self) -> float:
        """Head angle at which a blade points to the mean point of the blank above the work axis."""
        m = self.m
        (radius, z), g = self.cone(np.zeros(1), np.zeros(1))[:, 0], m["machine_root_angle"]
        z += m["machine_centre_to_back"]
        point = np.array([np.sin(g) * radius + np.cos(g) * z, -m["blank_offset"], np.sin(g) * z - np.cos(g) * radius])
        point[2] += m["sliding_base"]
        point[:2] -= m["radial_setting"] * np.array([np.cos(m["cradle_angle"]), np.sin(m["cradle_angle"])])
        seen = rotated(1, -m["tilt"], rotated(2, -m["swivel"], point[:, None]))
        return float(np.arctan2(seen[1, 0], seen[0, 0]))

    def swept(self, x: Array) -> Array:
        """Points (3, n) in the work frame: x is length along the edge from its reference point, head angle, roll."""
        t, head, roll = x
        m, c = self.m, self.c
        angle, bend = c["blade_angle"], c["blade_curvature"]
        if bend:
            xi = (np.cos(angle) - np.cos(angle + bend * t)) / bend
            eta = (np.sin(angle + bend * t) - np.sin(angle)) / bend
        else:
            xi, eta = t * np.sin(angle), t * np.cos(angle)
        moved = self.out * c["eccentricity"]
        plane = self.hand * c["blade_offset_angle"]
        away = c["radius_offset"] + moved + self.out * xi
        edge = np.array([c["cutter_radius"] + away * np.cos(plane), away * np.sin(plane), -c["reference_height"] - eta])
        back = self.start + plane + self.hand * c["eccentricity_angle"]
        point = rotated(2, head, edge) - moved * np.array([[np.cos(back)], [np.sin(back)], [0.0]])
        point = rotated(2, m["swivel"], rotated(1, m["tilt"], point))
        q = m["cradle_angle"]
        point = point + m["radial_setting"] * np.array([[np.cos(q)], [np.sin(q)], [0.0]])
        point = rotated(2, roll, point)
        shifts = [m["sliding_base"]] + [m.get(f"helical_motion_{k}", 0.0) for k in (1, 2, 3)]
        base = shifts[0] + roll * (shifts[1] + roll * (shifts[2] / 2.0 + roll * shifts[3] / 6.0))
        x_m, y_m, z_m = point[0], point[1] + m["blank_offset"], point[2] - base
        g = m["machine_root_angle"]
        work = np.array(
            [np.sin(g) * x_m - np.cos(g) * z_m, y_m, np.cos(g) * x_m + np.sin(g) * z_m - m["machine_centre_to_back"]]
        )
        turned = roll - m.get("modified_roll_2c", 0.0) / 2.0 * roll**2 - m.get("modified_roll_6d", 0.0) / 6.0 * roll**3
        indexed = c["blade_groups"] / self.b["teeth"] * (head - self.start - self.hand * c["blade_phase"])
        return rotated(2, indexed - m["roll_ratio"] * turned, work)

    def _equations(self, x: Array, target: Array) -> Array:
        point = self.swept(x)
        columns = [np.imag(self.swept(x + 1j * STEP * np.eye(3)[k][:, None])) / STEP for k in range(3)]
        size = self.b["mean_cone_distance"]
        volume = np.einsum("in,in->n", columns[0], np.cross(columns[1], columns[2], axis=0)) / size**2
        return np.array([np.hypot(point[0], point[1]) - target[0], point[2] - target[1], volume]) / size

    def azimuth(self, target: Array, start: Array | None = None) -> tuple[Array, Array]:
        """Azimuth of the flank at (radius, z), (2, n), and its parameters (3, n)."""
        x = np.array([[0.0], [self.start], [0.0]]) + np.zeros((3, target.shape[1])) if start is None else start.copy()
        steps = np.array([1e-6, 1e-5, 1e-5])
        for _ in range(40):
            value = self._equations(x, target)
            slope = [
                (self._equations(x + shift, target) - self._equations(x - shift, target)) / (2.0 * step)
                for step, shift in zip(steps, np.diag(steps)[:, :, None], strict=True)
            ]
            change = np.linalg.solve(np.stack(slope, axis=-1).transpose(1, 0, 2), value.T[..., None])[..., 0].T
            limit = np.minimum(1.0, np.array([[5e-3], [0.1], [0.1]]) / np.abs(change).clip(1e-300)).min(axis=0)
            x = x - limit * change
            if np.abs(change).max() < 1e-13:
                break
        point = self.swept(x)
        return np.arctan2(point[1], point[0]), x
