"""Limits of a cut flank: root fillet, root line, and undercut.

Below the profile the edge radius of the blade cuts the fillet; the root line is the limit to the tip plane. A generated
flank is undercut if it has an edge of regression before the end of the blade profile. The fillet then intersects the
flank above that edge, and the flank ends at this intersection.

Points along the blade (`columns`): at a station u of the face the edge length s is prescribed; cutter angle and cradle
roll follow from the station and the equation of meshing. In contrast to the search at a given height, this remains
regular at the edge of regression (undercut).
"""

from dataclasses import dataclass, replace

import numpy as np

from efficiency.cutting import newton
from efficiency.cutting.flank import CutFlank
from ehl.common.arrays import BoolArray, FloatArray
from ehl.common.errors import ConvergenceError

# every n-th row is followed step by step
_STRIDE = 4


@dataclass(frozen=True)
class EdgeColumns:
    """Points of m edge lengths at k stations."""

    parameters: FloatArray  # cutting parameters s, th, phi
    # points in the work frame [m] and unit normals out of the tooth
    position: FloatArray
    normal: FloatArray
    height: FloatArray  # height above the pitch cone [m]
    # rate of the equation of meshing along the motion of the contact point for which it is at rest in the work [m];
    # zero on the edge of regression, with opposite signs on the flank and behind the edge
    regression: FloatArray
    found: BoolArray  # whether the edge reaches the station


def at_length(flank: CutFlank, u: FloatArray, x: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Cutting parameters at stations u for the edge lengths ``x[0]``, from starting values nearby (3, k)."""
    blank = flank.blank
    sine, cosine = np.sin(blank.pitch_angle), np.cos(blank.pitch_angle)
    s = x[:1]

    def linearised(y: FloatArray) -> tuple[FloatArray, FloatArray]:
        state, slope = flank.linearise(np.concatenate([s, y]))
        radius = np.hypot(state[0], state[1])
        along = (state[0] / radius)[:, None] * slope[:, 0] + (state[1] / radius)[:, None] * slope[:, 1]
        value = blank.coordinates(radius, state[2])[0] - u
        rows = np.stack([along * sine + slope[:, 2] * cosine, slope[:, 6]], axis=1)
        return np.array([value, state[6]]), rows[:, :, 1:]

    solved, found = newton.iterate(linearised, x[1:], np.array([0.1, 0.1]), np.full(2, 1e-11))
    return np.concatenate([s, solved]), found


def columns(flank: CutFlank, u: FloatArray, lengths: FloatArray, start: FloatArray) -> EdgeColumns:
    """Follow the edge through prescribed lengths at all stations together.

    flank: flank, or fillet (with the edge radius of its blade).
    u (k,): stations: distance from the mean point along the pitch cone [m].
    lengths (m, k): edge lengths in the order of the steps [m], the first near `start`.
    start (3, k): cutting parameters of the starting points.
    """
    count = lengths.shape[0]
    marks = np.unique(np.linspace(0, count - 1, -(-count // _STRIDE) + 1).round().astype(np.int64))
    x, alive = np.array(start), np.ones(u.size, dtype=bool)
    marked: list[FloatArray] = []
    reached: list[BoolArray] = []
    for s in lengths[marks]:
        ahead = np.zeros_like(x)
        if len(marked) > 1:
            # linear extrapolation from the last two rows
            run = marked[-1][0] - marked[-2][0]
            ahead = (marked[-1] - marked[-2]) * np.where(run != 0.0, (s - x[0]) / np.where(run != 0.0, run, 1.0), 0.0)
        moved, found = at_length(flank, u, np.stack([s, x[1] + ahead[1], x[2] + ahead[2]]))
        alive = alive & found
        x = np.where(alive, moved, x)
        marked.append(x)
        reached.append(alive)
    # the intermediate rows start from linear interpolation, all at once
    place = np.arange(count)
    after = np.searchsorted(marks, place)
    before = np.maximum(after - 1, 0)
    share = ((place - marks[before]) / np.maximum(marks[after] - marks[before], 1))[:, None, None]
    path = np.stack(marked)
    between = path[before] + share * (path[after] - path[before])
    between[:, 0] = lengths
    solved, found = at_length(flank, np.tile(u, count), np.moveaxis(between, 1, 0).reshape(3, -1))
    exists = found.reshape(lengths.shape) & np.stack(reached)[after]
    parameters = np.where(exists[:, None], np.moveaxis(solved.reshape(3, *lengths.shape), 0, 1), between)
    flat = np.moveaxis(parameters, 1, 0).reshape(3, -1)
    points = flank.points(flat)
    _, height = flank.blank.place(points.position)
    shape = lengths.shape
    # a surface that is not an envelope has no edge of regression
    rate = flank.regression(flat).reshape(shape) if flank.machine.generation.rolls else np.ones(shape)
    position, normal = (np.moveaxis(x.reshape(3, *shape), 0, 1) for x in (points.position, points.normal))
    return EdgeColumns(parameters, position, normal, height.reshape(shape), rate, exists)


# smallest edge radius of a real blade: a sharp corner is given this radius, so that it cuts a fillet
SHARP = 1e-5
_ROWS = 24


@dataclass(frozen=True)
class FlankLimits:
    """Limits of a flank at stations along its face."""

    u: FloatArray  # stations: distance from the mean point along the pitch cone, from toe to heel [m]
    tip: FloatArray  # height of the face cone of the blank above the pitch cone [m]
    # height of the start of the flank: end of the blade profile, or intersection of fillet and undercut flank [m]
    start: FloatArray
    # height of the cut root at the tip plane of the blade [m]; nan where the cutter does not reach it
    root: FloatArray
    blank_root: FloatArray  # height of the root cone of the blank [m]
    undercut: BoolArray  # whether the edge of regression lies above the end of the profile
    regression: FloatArray  # height of the edge of regression [m]; nan without one
    fillet: EdgeColumns  # points of the fillet, from the profile to the root line

    @property
    def root_error(self) -> FloatArray:
        """Height of the cut root above the root cone of the blank, negative if it is cut too deep [m]."""
        return self.root - self.blank_root


def fillet(flank: CutFlank) -> CutFlank:
    """The root fillet as a flank cut by the edge radius; its s ranges from `Blade.tip` to `profile_start`."""
    radius = float(np.real(flank.blade.edge_radius)) or SHARP
    return replace(flank, blade=replace(flank.blade, edge_radius=radius, part="fillet"))


def flank_limits(flank: CutFlank, stations: int = 15) -> FlankLimits:
    """Fillet, root line and undercut of a flank.

    flank: the flank.
    stations: number of stations along the face.
    """
    blank, root_cut = flank.blank, fillet(flank)
    u = np.linspace(-0.5, 0.5, stations) * blank.face_width
    middle, found = flank.solve(u, blank.height(u, np.full(stations, 0.6)))
    if not found.all():
        raise ConvergenceError("undercut", f"the {flank.side} flank does not exist at the middle of its depth")
    s_start = root_cut.blade.profile_start
    top = middle.parameters[0]
    down = np.linspace(0.0, 1.0, _ROWS)[:, None]
    profile = columns(flank, u, top + down * (s_start - top), middle.parameters)
    # more points near the profile, where the fillet is steep
    arc = s_start + down**2 * (root_cut.blade.tip - s_start) + 0.0 * u
    curve = columns(root_cut, u, arc, profile.parameters[-1])

    sign = np.sign(profile.regression[0])
    behind = (profile.regression * sign < 0.0) & profile.found
    undercut = behind.any(axis=0)
    start, edge = profile.height[-1].copy(), np.full(stations, np.nan)
    if undercut.any():
        limit = _edge_of_regression(flank, u, profile, behind, undercut)
        edge[undercut], start[undercut] = limit.height[-1], _crossing(root_cut, u[undercut], limit, curve, undercut)
    reached = profile.found[-1] & curve.found[-1]
    start[~profile.found[-1] & ~undercut] = np.nan
    return FlankLimits(
        u=u,
        tip=blank.tip(u),
        start=start,
        root=np.where(reached, curve.height[-1], np.nan),
        blank_root=blank.root(u),
        undercut=undercut,
        regression=edge,
        fillet=curve,
    )


def _edge_of_regression(
    flank: CutFlank, u: FloatArray, profile: EdgeColumns, behind: BoolArray, undercut: BoolArray
) -> EdgeColumns:
    """The undercut stations from mid-depth to the edge of regression, computed by the Illinois method."""
    own = np.flatnonzero(undercut)
    last = np.argmax(behind[:, own], axis=0)
    front, back = profile.parameters[last - 1, :, own].T, profile.parameters[last, :, own].T
    ahead, beyond = profile.regression[last - 1, own], profile.regression[last, own]
    kept = np.zeros(own.size)
    for _ in range(10):
        x, _ = at_length(flank, u[own], front + ahead / (ahead - beyond) * (back - front))
        rate = flank.regression(x)
        nearer = rate * ahead > 0.0
        # Illinois method: the value of an end retained twice is halved
        beyond = np.where(nearer, beyond * np.where(kept > 0.0, 0.5, 1.0), rate)
        ahead = np.where(nearer, rate, ahead * np.where(kept < 0.0, 0.5, 1.0))
        front, back = np.where(nearer, x, front), np.where(nearer, back, x)
        kept = np.where(nearer, 1.0, -1.0)
    middle = profile.parameters[0, :, own].T
    share = 1.0 - np.linspace(1.0, 0.0, 2 * _ROWS)[:, None] ** 2
    return columns(flank, u[own], middle[0] + share * (front[0] - middle[0]), middle)


def _crossing(
    root_cut: CutFlank, u: FloatArray, limit: EdgeColumns, curve: EdgeColumns, undercut: BoolArray
) -> FloatArray:
    """Heights of the intersection of fillet and undercut flank; those of the edge of regression without one."""
    edge, begin = limit.height[-1], curve.parameters[0][:, undercut]
    # the fillet from the profile to the height of the edge of regression
    sunk = np.argmax(curve.height[:, undercut] < edge, axis=0)
    end = np.take_along_axis(curve.parameters[:, 0, undercut], sunk[None], axis=0)[0]
    steps = np.linspace(0.0, 1.0, 2 * _ROWS)[:, None]
    fine = columns(root_cut, u, begin[0] + steps * (end - begin[0]), begin)
    heights = np.array(edge)
    for k in range(u.size):
        x, y = limit.position[:, 0, k], limit.position[:, 1, k]
        into = -np.sign(limit.normal[0, 1, k] * x[0] - limit.normal[0, 0, k] * y[0])
        # angles about the axis into the tooth, at equal heights
        flank = into * np.angle((x + 1j * y) / (x[0] + 1j * y[0]))
        below = into * np.angle((fine.position[:, 0, k] + 1j * fine.position[:, 1, k]) / (x[0] + 1j * y[0]))
        height = fine.height[:, k]
        gap = below - np.interp(height, limit.height[::-1, k], flank[::-1])
        cuts = np.flatnonzero((gap > 0.0) & (height > edge[k]))
        if cuts.size and cuts[0] > 0:
            share = gap[cuts[0]] / (gap[cuts[0]] - gap[cuts[0] - 1])
            heights[k] = height[cuts[0]] + share * (height[cuts[0] - 1] - height[cuts[0]])
    return heights
