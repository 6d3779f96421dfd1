"""Measured flank: what the machine was set to cut, plus a smooth deviation with a known uncertainty.

An inspection machine gives points with noise. Their deviation from the nominal flank, along its normal, is a smooth
field over face and depth (`smooth_field`): thickness, pressure and spiral angle are free, crownings and twist have a
common size, what is beyond changes over some length; the points decide. What scatters about that is the measurement,
at least the stated uncertainty. The mean of the field is the flank, its covariance the uncertainty of the flank, and
of the transmission error that follows from it. Without a nominal flank the deviation is that from a polynomial
through the points, free to fourth order, and the uncertainty larger.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from efficiency.contact.chebyshev import Patch
from efficiency.contact.conjugate import regular_points
from efficiency.contact.grid_flank import Hand, PointGrid, SmoothFlank, normal_sense, placed_points
from efficiency.contact.measured_deviation import SmoothField, smooth_field
from efficiency.cutting.blank import Blank
from efficiency.cutting.cutter import FlankSide
from efficiency.cutting.flank import Flank, FlankPoints
from ehl.common.errors import ConvergenceError, InputError

FloatArray = NDArray[np.float64]

# coefficients of the azimuth over face and depth, and how far beyond the blank it is laid
_SHAPE = (20, 14)
_BEYOND = 0.06
# over an undercut root: how far above the lowest point it begins, the first that will do, fractions of the depth
_RAISED = (0.0, 0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.2)
# order of the free part of the deviation with and without a nominal flank
_ORDER, _ORDER_ALONE = 1, 4
# no cut and ground flank lies farther from its nominal one [m]
_FARTHEST = 0.5e-3
# points that scatter more than this times the stated uncertainty are worth a word
_SCATTER = 1.3


@dataclass(frozen=True)
class MeasuredFlank(SmoothFlank):
    """Nominal flank plus the smooth part of measured deviations; see `measured_flank`.

    Attributes
    ----------
    place : (2, n) array
        Measured points: u over half the face width, depth fraction from -1 to 1.
    deviation : (n,) array
        Measured minus nominal along the normal, positive outwards, without its mean [m].
    offset : float
        That mean as an angle about the axis: thickness, or the turn of the grid [rad].
    stated, scatter : float
        Measurement uncertainty as given, and scatter of the points about the flank, both 1 sigma [m].
    field : SmoothField
        The deviation over face and depth.
    """

    place: FloatArray
    deviation: FloatArray
    offset: float
    stated: float
    scatter: float
    field: SmoothField

    def covariance(self, u: FloatArray, h: FloatArray) -> FloatArray:
        """Covariance of the flank along its normal at blank coordinates [m^2], (n, n)."""
        return self.field.covariance(_place(self.blank, u, h)) * 1e-12

    def smooth_deviation(self, u: FloatArray, h: FloatArray) -> FloatArray:
        """Deviation from nominal without noise and without its mean [m], (n,)."""
        return self.field.mean(_place(self.blank, u, h)) * 1e-6

    @property
    def note(self) -> str:
        """What a designer has to know of the measurement."""
        text = f"standard uncertainty of one point {self.stated * 1e6:.2g} um"
        if self.scatter > _SCATTER * self.stated:
            text += f", but the points scatter by {self.scatter * 1e6:.2g} um about a smooth flank: that is used"
        return text


def measured_flank(
    grid: PointGrid, side: FlankSide, blank: Blank, hand: Hand, uncertainty: float, nominal: Flank | None = None
) -> MeasuredFlank:
    """Smooth flank behind measured points.

    Parameters
    ----------
    grid : PointGrid
        Points; normals are not used, as they are not measured.
    side : str
        Flank they belong to.
    blank : Blank
        Of the member.
    hand : str
        Of the member.
    uncertainty : float
        Standard uncertainty of one point along the normal [m].
    nominal : Flank, optional
        What should have been cut.

    Raises
    ------
    InputError
        The points are not those of this flank and blank.
    ConvergenceError
        The nominal flank does not exist where its blank does.
    """
    u, v, h, azimuth = placed_points(grid, side, blank)
    sense = normal_sense(side, hand)
    half = (0.5 + _BEYOND) * blank.face_width
    ranges = (-half, half), (-_BEYOND, 1.0 + _BEYOND)
    measured = (float(u.min()), float(u.max())), (float(v.min()), float(v.max()))
    if nominal is None:
        base = Patch.fit_points(*measured, (3, 3), u, v, {"azimuth": azimuth})
        flank = SmoothFlank(side, blank, sense, base, "", 0.0)
        at, here = flank.points(np.stack([u, h, np.zeros_like(u)])), np.ones(u.size, dtype=bool)
        (reference,) = base(u, v, ("azimuth",))
        nodes = Patch.nodes(*ranges, _SHAPE)
        points = flank.points(np.stack([nodes[0], blank.height(*nodes), np.zeros_like(nodes[0])]))
    else:
        at, here = nominal.solve(u, h)
        reference = np.arctan2(at.position[1], at.position[0])
        nodes_u, nodes_v, points, regular = regular_points(nominal, *ranges, _SHAPE)
        for raised in _RAISED:
            if regular.all():
                break
            # next to a limit of undercut the azimuth is no polynomial: no farther down than the points, or a bit less
            # where the limit rises beyond them at toe and heel: one node missing would leave a corner to chance
            ranges = ranges[0], (measured[1][0] + raised, 1.0 + _BEYOND)
            nodes_u, nodes_v, points, regular = regular_points(nominal, *ranges, _SHAPE)
        if not regular.all():
            raise ConvergenceError("undercut", f"the nominal {side} flank does not exist where the points are")
        nodes = nodes_u, nodes_v
    if here.sum() < 0.8 * here.size:
        raise ConvergenceError("undercut", f"the nominal {side} flank does not exist at a fifth of the measured points")
    u, h, turn = u[here], h[here], np.angle(np.exp(1j * (azimuth - reference)))[here]
    levers = _lever(at)[here]
    offset = float(np.angle(np.mean(np.exp(1j * turn))))
    deviation = np.angle(np.exp(1j * (turn - offset))) * levers
    worst = int(np.argmax(np.abs(deviation)))
    if abs(deviation[worst]) > _FARTHEST:
        raise InputError(
            f"{grid.path}, row {grid.row[here][worst]}, column {grid.column[here][worst]}",
            f"{deviation[worst] * 1e3:.4g} mm from the nominal flank",
            f"within {_FARTHEST * 1e3:g} mm of it",
            "Check that the points are those of this member and flank, and their units.",
        )
    place = _place(blank, u, h)
    field = smooth_field(place, deviation * 1e6, uncertainty * 1e6, _ORDER if nominal is not None else _ORDER_ALONE)

    node_height = blank.height(*nodes)
    smooth = field.mean(_place(blank, nodes[0], node_height)) * 1e-6
    around = np.arctan2(points.position[1], points.position[0])
    middle = around[int(np.argmin(np.sum(_place(blank, nodes[0], node_height) ** 2, axis=0)))]
    total = middle + np.angle(np.exp(1j * (around - middle))) + offset + smooth / _lever(points)
    patch = Patch.fit(*ranges, _SHAPE, {"azimuth": total})
    apart = patch(u, v[here], ("azimuth",))[0] - reference[here] - offset - field.mean(place) * 1e-6 / levers
    missed = max(float(np.abs(np.angle(np.exp(1j * apart)) * levers).max()), patch.tail["azimuth"] * abs(levers).max())
    spread = np.sqrt(np.maximum(np.diag(field.covariance(place)), 0.0)).max() * 1e-6
    return MeasuredFlank(
        side,
        blank,
        sense,
        patch,
        f"the points of {grid.path}",
        2.0 * float(spread) + missed,
        place=place,
        deviation=deviation,
        offset=offset,
        stated=uncertainty,
        scatter=field.noise * 1e-6,
        field=field,
    )


def _place(blank: Blank, u: FloatArray, h: FloatArray) -> FloatArray:
    """Face and depth from -1 to 1, (2, n)."""
    root = blank.root(u)
    return np.stack([2.0 * u / blank.face_width, 2.0 * (h - root) / (blank.tip(u) - root) - 1.0])


def _lever(points: FlankPoints) -> FloatArray:
    """Way along the outward normal for a turn about the axis [m/rad], (n,)."""
    (x, y, _), (nx, ny, _) = points.position, points.normal
    return np.asarray(x * ny - y * nx)
