"""Misalignment study: contact of a pair over E, P, G and shaft angle, without load and at a torque (V-H check).

The flank points are solved once; every state of misalignment takes them over and computes its ease-off, contact path,
transmission error and pattern again. At a torque every state has its load distribution as well, on the same elastic
bodies.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import product
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from efficiency.contact.flank_grid import FlankGrid
from efficiency.contact.flank_pair import MARKING, FlankPair, flank_pair
from efficiency.contact.gear_flanks import Side
from efficiency.contact.relief import FlankDeviation, flank_tolerances
from efficiency.design.design import MISALIGNMENTS, Design
from ehl.common.arrays import finite_or_none
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.pages import Reportable, StatusOfReason
from ehl.common.progress import ProgressCallback, progress_to, report_progress

if TYPE_CHECKING:
    import pandas

    from efficiency.loss.efficiency_result import EfficiencyResult

# columns of a state under load
LOADED = (
    *("transmission_error_loaded", "pressure_hertz_max", "edge_load_share", "load_centre_u"),
    *("power_loss", "efficiency"),
)
QUANTILES = (0.05, 0.5, 0.95)
DEVIATIONS = tuple(FlankDeviation.model_fields)
"""Names of the deviations of the flanks."""
# names of the columns of files and JSON, where they differ from those of `MisalignmentPoint`
_COLUMNS = {"error_maximum_u": "crest_u", "error_maximum_depth": "crest_depth", "undercut": "absent"}


@dataclass(frozen=True)
class MisalignmentPoint:
    """Contact in one state of misalignment; quantities under load are nan without a torque."""

    # misalignments [m], shaft_angle_error [rad]
    E: float
    P: float
    G: float
    shaft_angle_error: float
    peak_to_peak: float = np.nan  # of the transmission error of the mesh [rad]
    harmonic_1: float = np.nan  # its amplitude at the mesh frequency [rad]
    # where the transmission error is highest, on the gear: from the mean point to the heel [m], share of the depth
    error_maximum_u: float = np.nan
    error_maximum_depth: float = np.nan
    # marked share of the mating flank; its extent as a share of face width and depth of the gear
    pattern_area: float = np.nan
    pattern_length: float = np.nan
    pattern_width: float = np.nan
    # its centre, as for the maximum
    pattern_u: float = np.nan
    pattern_depth: float = np.nan
    undercut: float = 0.0  # share of the mating flank that is undercut
    edges: str = ""  # edges in contact without load, separated by commas
    pattern_edges: str = ""  # edges that the pattern reaches
    transmission_error_loaded: float = np.nan  # peak to peak at the torque [rad]
    pressure_hertz_max: float = np.nan  # maximum Hertz pressure of the flanks [Pa]
    edge_load_share: float = np.nan  # share of the torque where the contact reaches an edge
    # where the force acts in the mean, along the gear face from its middle to the heel [m]
    load_centre_u: float = np.nan
    # of the mesh [W], [-]
    power_loss: float = np.nan
    efficiency: float = np.nan
    # ``edge contact``: computed, an edge carries somewhere in the mesh
    status: Literal["converged", "edge contact", "failed"] = "failed"
    reason: str = ""  # of a failure
    deviation: FlankDeviation = field(default_factory=FlankDeviation)  # of the flanks from their design

    def to_dict(self, loaded: bool = False) -> dict[str, float | str]:
        """Values by their column names in files, including those under load."""
        names = [f.name for f in fields(self) if f.name != "deviation" and (loaded or f.name not in LOADED)]
        own = self.deviation.model_dump() if self.deviation else {}
        return {_COLUMNS.get(name, name): getattr(self, name) for name in names} | own


@dataclass(frozen=True)
class MisalignmentStudy:
    """Contact over a grid of misalignments."""

    # name of the design and of the flank pair
    design: str
    side: Side
    marking: float  # thickness of the marking compound [m]
    # values of each misalignment; the points are all their combinations, shaft_angle_error running fastest.
    # With `samples`: the standard deviation of each
    E: tuple[float, ...]
    P: tuple[float, ...]
    G: tuple[float, ...]
    shaft_angle_error: tuple[float, ...]
    points: tuple[MisalignmentPoint, ...]  # results
    seconds: float  # wall time
    torque: float | None = None  # of the pinion [N m]; none without load
    samples: int | None = None  # number of random states instead of the combinations
    accuracy_grade: int | None = None  # of the flanks of random states
    tolerances: FlankDeviation = field(default_factory=FlankDeviation)  # standard deviations of the flanks

    @property
    def status(self) -> Literal["converged", "failed"]:
        """``failed`` if no state could be computed."""
        return "failed" if all(point.status == "failed" for point in self.points) else "converged"

    @property
    def varied(self) -> list[str]:
        """Misalignments with more than one value, or with a standard deviation."""
        values = {name: getattr(self, name) for name in MISALIGNMENTS}
        return [name for name, given in values.items() if len(given) > 1 or (self.samples and any(given))]

    def distribution(self) -> dict[str, tuple[float, ...]]:
        """Mean, standard deviation, and 5, 50 and 95 % quantile of each result over the states that were computed."""
        names = ["peak_to_peak", *(LOADED if self.torque is not None else ())]
        found = {name: np.array([getattr(p, name) for p in self.points if p.status != "failed"]) for name in names}
        return {
            name: (float(v.mean()), float(v.std(ddof=1)), *(float(q) for q in np.quantile(v, QUANTILES)))
            for name, v in found.items()
            if v.size > 1
        }

    def to_dict(self) -> dict[str, object]:
        """Plain numbers and strings for JSON; None where a value could not be computed."""
        loaded = self.torque is not None
        names = ("design", "side", "marking", *(["torque"] if loaded else []), *MISALIGNMENTS)
        names += ("points", "seconds", "status")
        content = {name: getattr(self, name) for name in names}
        if self.samples:
            content |= {"samples": self.samples, "distribution": self.distribution()}
            content |= {"accuracy_grade": self.accuracy_grade, "tolerances": self.tolerances.model_dump()}
        return dict(finite_or_none(content | {"points": [p.to_dict(loaded) for p in self.points]}))


@dataclass(frozen=True, repr=False)
class MisalignmentGrid(StatusOfReason, Reportable):
    """Contact of a pair over misalignments: from `GearPair.misalignment`."""

    presenter = "efficiency.output.misalignment_report:misalignment"

    pair: Design  # design of the pair
    studies: tuple[MisalignmentStudy, ...]  # one for each side

    @property
    def reason(self) -> str:
        """Number of failed states."""
        points = [point for study in self.studies for point in study.points]
        failed = sum(point.status == "failed" for point in points)
        return f"{failed} of {len(points)} states" if failed else ""

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {"studies": [study.to_dict() for study in self.studies]}

    def to_frame(self) -> pandas.DataFrame:
        """One row per state, SI units."""
        import pandas

        rows = (
            [p.to_dict(study.torque is not None) | {"side": study.side} for p in study.points] for study in self.studies
        )
        return pandas.concat(map(pandas.DataFrame, rows), ignore_index=True)

    def __repr__(self) -> str:
        states = ", ".join(f"{study.side} {len(study.points)} states" for study in self.studies)
        return f"MisalignmentGrid({self.studies[0].design}: {states}, {self.status})"


def misalignment_study(
    design: Design,
    *,
    E: Sequence[float] = (0.0,),
    P: Sequence[float] = (0.0,),
    G: Sequence[float] = (0.0,),
    shaft_angle_error: Sequence[float] = (0.0,),
    side: Side = "drive",
    marking: float = MARKING,
    progress: ProgressCallback | None = None,
    torque: float | None = None,
    load: Callable[[Design], EfficiencyResult] | None = None,
    samples: int | None = None,
    accuracy_grade: int | None = None,
) -> MisalignmentStudy:
    """Contact at all combinations of misalignments, or at random ones, added to those of the design.

    E, P, G, shaft_angle_error: values of each misalignment [m], shaft_angle_error [rad].
    side: which flanks are in contact.
    marking: thickness of the marking compound [m].
    progress: called with a `Progress` after each point.
    torque: pinion torque [N m]; None without load.
    load: loaded contact of the design in a state.
    samples: number of states with independent normal misalignments whose standard deviations are the values.
    accuracy_grade: of the flanks, whose deviations are random as well (`flank_tolerances`).
    Returns: a point that cannot be computed is a status with its reason, not an error.
    Raises `InputError`: a value out of the range of the design file, or no value for a misalignment.
    """
    clock = time.perf_counter()
    axes = zip(MISALIGNMENTS, (E, P, G, shaft_angle_error), strict=True)
    values = {name: tuple(float(x) for x in given) for name, given in axes}
    for name, given in values.items():
        if not given:
            raise InputError(name, "no value", "at least one value")
        if samples is not None and (len(given) > 1 or given[0] < 0.0):
            raise InputError(name, given, "one standard deviation of at least 0, as the states are random samples")
    start = design.assembly.misalignment
    points: list[MisalignmentPoint] = []
    grid: FlankGrid | None = None
    own, tolerances = design.assembly.flank_deviation, FlankDeviation()
    if samples is None:
        states = list(product(values["E"], values["P"], values["G"], values["shaft_angle_error"]))
        made = [own] * len(states)
    else:
        from scipy.special import ndtri
        from scipy.stats import qmc

        if accuracy_grade is not None:
            blanks = design.pinion.blank, design.gear.blank
            spiral = design.flanks().mating(side)[1].mean_angles()[0]
            module = 2.0 * blanks[1].mean_cone_distance * math.sin(blanks[1].pitch_angle) * math.cos(spiral)
            tolerances = flank_tolerances(accuracy_grade, module / blanks[1].teeth, *blanks)
        spread = [*(values[name][0] for name in MISALIGNMENTS), *tolerances.model_dump().values()]
        spread = spread[: None if tolerances else len(MISALIGNMENTS)]
        # the same normal numbers every time, from a scrambled Sobol sequence, whose means converge faster
        whole = qmc.Sobol(len(spread), seed=20260101).random_base2(max(samples - 1, 1).bit_length())
        rows = (ndtri(whole[:samples]) * np.array(spread)).tolist()
        states = [(e, p, g, angle) for e, p, g, angle, *_ in rows]
        made = [_deviated(own, row[len(MISALIGNMENTS) :]) for row in rows]
    for number, (state, deviation) in enumerate(zip(states, made, strict=True)):
        placed = {n: getattr(start, n) + x for n, x in zip(MISALIGNMENTS, state, strict=True)}
        moved = design.with_misalignment(**placed).with_deviation(deviation)
        try:
            pair = flank_pair(moved.flanks(), side, grid=grid)
        except ConvergenceError as error:
            points.append(MisalignmentPoint(*state, reason=str(error), deviation=deviation))
        else:
            grid = pair.surface.grid
            point = replace(_point(pair, state, marking), deviation=deviation)
            if load is not None:
                point = _loaded(point, load, moved, 0.5 * design.gear.blank.face_width)
            points.append(point)
        with progress_to(progress):
            report_progress("states", number + 1, len(states))
    return MisalignmentStudy(
        design.name,
        side,
        marking,
        **values,
        points=tuple(points),
        seconds=time.perf_counter() - clock,
        torque=torque,
        samples=samples,
        accuracy_grade=accuracy_grade,
        tolerances=tolerances,
    )


def _deviated(own: FlankDeviation, more: Sequence[float]) -> FlankDeviation:
    """A deviation with that of a random state added, within its range."""
    added = dict(zip(DEVIATIONS, more, strict=False))
    limit = 5e-4
    values = {name: min(max(x + added.get(name, 0.0), -limit), limit) for name, x in own.model_dump().items()}
    return FlankDeviation(**values)


def _point(pair: FlankPair, state: tuple[float, float, float, float], marking: float) -> MisalignmentPoint:
    mesh, pattern, surface = pair.transmission, pair.pattern(marking), pair.surface
    return MisalignmentPoint(
        *state,
        peak_to_peak=mesh.peak_to_peak,
        harmonic_1=float(mesh.harmonics[0]),
        error_maximum_u=surface.error_maximum[0],
        error_maximum_depth=surface.error_maximum[1],
        pattern_area=pattern.area_share,
        pattern_length=pattern.length,
        pattern_width=pattern.width,
        pattern_u=pattern.centre[0],
        pattern_depth=pattern.centre[1],
        undercut=surface.undercut.share if surface.undercut is not None else 0.0,
        edges=", ".join(mesh.edges),
        pattern_edges=", ".join(pattern.edges),
        status="edge contact" if mesh.edges else "converged",
    )


def _loaded(
    point: MisalignmentPoint, load: Callable[[Design], EfficiencyResult], moved: Design, half_face: float
) -> MisalignmentPoint:
    """The state with what its load adds."""
    try:
        result = load(moved)
    except ConvergenceError as error:
        return replace(point, status="failed", reason=f"at the torque: {error}")
    positions = result.load.positions
    force = np.concatenate([part.force for part in positions])
    face = np.concatenate([part.position.face_gear for part in positions])
    centre = float(np.sum(force * face) / np.sum(force)) if force.any() else np.nan
    return replace(
        point,
        **{name: result.value(name) for name in LOADED if name != "load_centre_u"},
        load_centre_u=centre - half_face,
        reason=result.reason,
        status="failed" if result.status == "failed" else point.status,
    )
