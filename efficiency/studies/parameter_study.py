"""Parameter study: efficiency over torque, speed, temperature, roughness, offset and misalignment.

designs x (aligned + misalignments)  ->  geometry  ->  torques  ->  load  ->  speeds x temperatures x roughnesses

The grid of `efficiency.conditions.grid` is divided into tasks. Each finished task is stored, so that an interrupted
study resumes.
"""

from __future__ import annotations

import hashlib
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from functools import lru_cache
from itertools import groupby, product
from math import radians
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from efficiency.conditions.conditions import (
    Friction,
    Values,
    axis_values,
    check_size,
    checked,
    level_quantity,
    resolve_friction,
)
from efficiency.conditions.grid import PointsResult
from efficiency.contact.gear_flanks import Side
from efficiency.design.design import MISALIGNMENTS, Design
from efficiency.loss.efficiency_result import EfficiencyResult, LoadBalance
from efficiency.loss.ehl_friction import EhlFriction
from efficiency.mesh import POINTS_PER_LINE, POSITIONS
from efficiency.pair import GearPair
from ehl import __version__
from ehl.common.arrays import finite_or_none
from ehl.common.errors import InputError
from ehl.common.journal import Journal
from ehl.common.progress import ProgressCallback, progress_to, report_progress
from ehl.common.runner import checked_jobs, run_tasks
from ehl.common.threads import one_thread
from ehl.fluid.oil import Oil
from regression.formula import Formula
from regression.friction.models import FrictionModel

if TYPE_CHECKING:
    import pandas

OPERATING = ("torque", "speed", "temperature", "roughness_rms_each")

# fractions of the torque and speed of the design; K; m; this work, after the operating ranges of automotive axles
_TORQUES, _SPEEDS = (0.1, 0.3, 0.6, 1.0), (0.1, 0.25, 0.5)
_TEMPERATURES = (313.15, 333.15, 353.15, 363.15)
_ROUGHNESSES = (1e-7, 2e-7, 4e-7, 8e-7)
_SHIFTS = (-1e-4, -5e-5, 5e-5, 1e-4)
_ARCMIN = radians(1.0 / 60.0)
_TURNS = (-4.0 * _ARCMIN, -2.0 * _ARCMIN, 2.0 * _ARCMIN, 4.0 * _ARCMIN)
DESIGNS = ("fh_hypoid_9x34_relieved", "fh_hypoid_9x34_offset_10_relieved")


@dataclass(frozen=True)
class Levels:
    """Values of each parameter in SI units; all combinations of the first four, one misalignment at a time."""

    # pinion torque [N m] and speed [rad/s], oil temperature [K], Rq of both flanks, each [m]
    torque: tuple[float, ...]
    speed: tuple[float, ...]
    temperature: tuple[float, ...]
    roughness_rms_each: tuple[float, ...]
    # misalignments added to those of the design [m], [rad]; zero is always computed
    E: tuple[float, ...] = _SHIFTS
    P: tuple[float, ...] = _SHIFTS
    G: tuple[float, ...] = _SHIFTS
    shaft_angle_error: tuple[float, ...] = _TURNS

    def __post_init__(self) -> None:
        check_size({name: getattr(self, name) for name in OPERATING})

    @classmethod
    def around(cls, design: Design, **given: tuple[float, ...]) -> Levels:
        """Default levels around the operating point of a design; `given` replaces some of them."""
        point = design.operation
        default = cls(
            torque=tuple(share * point.torque for share in _TORQUES),
            speed=tuple(share * point.speed for share in _SPEEDS),
            temperature=_TEMPERATURES,
            roughness_rms_each=_ROUGHNESSES,
        )
        ordered = {name: tuple(sorted(set(values))) for name, values in given.items()}
        return replace(default, **ordered)

    def reference(self, design: Design) -> dict[str, float]:
        """The level of each operating parameter nearest to that of the design."""
        own = design.operation
        values = {"torque": own.torque, "speed": own.speed, "temperature": own.temperature}
        values["roughness_rms_each"] = design.pinion.roughness_rms
        return {name: min(getattr(self, name), key=lambda level: abs(level - value)) for name, value in values.items()}

    def shifts(self) -> list[dict[str, Any]]:
        """Single misalignments without zero."""
        return [{name: value} for name in MISALIGNMENTS for value in getattr(self, name) if value != 0.0]

    def to_dict(self) -> dict[str, list[float]]:
        """Levels for JSON."""
        return {f.name: list(getattr(self, f.name)) for f in fields(self)}


@dataclass(frozen=True)
class StudyPoint:
    """One design, misalignment and operating point; SI units, names as in `EfficiencyResult`.

    efficiency to outside_range_share: nan for a failed point.
    """

    design: str
    hypoid_offset: float  # [m]
    # misalignments added to the design's [m], [rad]
    E: float = 0.0
    P: float = 0.0
    G: float = 0.0
    shaft_angle_error: float = 0.0
    # pinion torque [N m] and speed [rad/s], oil temperature [K], Rq of each flank [m]
    torque: float = 0.0
    speed: float = 0.0
    temperature: float = 0.0
    roughness_rms_each: float = 0.0
    efficiency: float = math.nan
    efficiency_lower: float = math.nan
    efficiency_upper: float = math.nan
    efficiency_error: float = math.nan
    efficiency_with_rolling: float = math.nan
    power_loss: float = math.nan
    power_loss_rolling: float = math.nan
    power_input: float = math.nan
    friction_coefficient_mean: float = math.nan
    film_ratio: float = math.nan  # mean, weighted with the sliding power [-]
    pressure_hertz_max: float = math.nan
    temperature_flash: float = math.nan  # maximum surface temperature of the cycle [K]
    transmission_error_loaded: float = math.nan
    transmission_error_unloaded: float = math.nan
    outside_range_share: float = math.nan
    status: str = "failed"
    reason: str = ""
    seconds: float = 0.0
    # most severe grade, safety factors, integral temperature and specific film, if requested
    strength: dict[str, Any] = field(default_factory=dict)
    # half width of the interval of the efficiency from each single cause of uncertainty, the largest first [-]
    causes: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()  # notes on the computation of this point

    @property
    def label(self) -> str:
        """Design and state as text, as the name of a failed point."""
        levels = [level_quantity(name).text(getattr(self, name)) for name in OPERATING]
        shifts = [name for name in MISALIGNMENTS if getattr(self, name) != 0.0]
        levels += [f"{name} {level_quantity(name).text(getattr(self, name))}" for name in shifts]
        return f"{self.design}, {', '.join(levels)}"

    def scalars(self) -> dict[str, Any]:
        """The scalar values by name."""
        apart = ("strength", "causes", "notes")
        return {name: getattr(self, name) for name in self.__dataclass_fields__ if name not in apart} | self.strength

    @property
    def aligned(self) -> bool:
        """Whether no misalignment is added."""
        return not any(getattr(self, name) for name in MISALIGNMENTS)


def with_result(point: StudyPoint, result: EfficiencyResult) -> StudyPoint:
    """A point with the values of its result."""
    found = result.scalars(interval=True) | {"notes": result.notes}
    wanted = {f.name for f in fields(StudyPoint)} - {"design", *OPERATING}
    known = {name: value for name, value in found.items() if name in wanted}
    weight = result.points.force * result.points.speed_sliding
    ratio = result.lubrication.film_ratio  # infinite for smooth flanks
    at = (weight > 0.0) & ~np.isnan(ratio)
    mean = float(np.average(ratio[at], weights=weight[at])) if at.any() else math.nan
    values = vars(point) | known
    flash = float(np.nanmax(result.lubrication.temperature_flash)) if result.points.force.size else math.nan
    return StudyPoint(**values | {"film_ratio": mean, "temperature_flash": flash, "causes": result.inputs.groups})


@dataclass(frozen=True, repr=False)
class Study(PointsResult):
    """Efficiencies of several designs over the parameters."""

    presenter = "efficiency.studies.report:study"
    file_name = "study"

    designs: tuple[str, ...]  # in the given order
    side: str
    oil: str
    friction_model: str
    levels: Levels
    reference: dict[str, float]  # operating point common to all sections
    points: tuple[StudyPoint, ...]
    # worker processes; points read from an earlier run
    jobs: int
    reused: int
    seconds: float  # wall time [s]

    @property
    def failed(self) -> tuple[StudyPoint, ...]:
        """Points that failed."""
        return tuple(point for point in self.points if point.status == "failed")

    def to_frame(self) -> pandas.DataFrame:
        """One row per point, SI units."""
        import pandas

        return pandas.DataFrame([point.scalars() for point in self.points])

    def __repr__(self) -> str:
        return f"Study({', '.join(self.designs)}, {self.friction_model}: {len(self.points)} points, {self.status})"

    def section(self, design: str, name: str, **fixed: float) -> list[StudyPoint]:
        """Points of a design along one parameter, sorted; the others as fixed, otherwise at the reference."""
        state = self.reference | fixed
        held = {key: value for key, value in state.items() if key != name}
        shifts = {key: fixed.get(key, 0.0) for key in MISALIGNMENTS if key != name}
        chosen = [
            point
            for point in self.points
            if point.design == design and all(getattr(point, key) == value for key, value in (held | shifts).items())
            if name in MISALIGNMENTS or getattr(point, name) in getattr(self.levels, name)
        ]
        return sorted(chosen, key=lambda point: float(getattr(point, name)))

    def reference_point(self, design: str) -> StudyPoint:
        """The point of a design at the reference."""
        torque = self.reference["torque"]
        return next(point for point in self.section(design, "torque") if point.torque == torque and point.aligned)

    def influence(self, design: str, name: str) -> tuple[float, float]:
        """Minimum and maximum efficiency over one parameter, the others at the reference; nan if all failed."""
        values = [point.efficiency for point in self.section(design, name)]
        known = [value for value in values if math.isfinite(value)]
        return (min(known), max(known)) if known else (math.nan, math.nan)

    @property
    def varied(self) -> list[str]:
        """Parameters with more than one value."""
        return [name for name in OPERATING if len(getattr(self.levels, name)) > 1] + [
            name for name in MISALIGNMENTS if any(value != 0.0 for value in getattr(self.levels, name))
        ]

    def to_dict(self) -> dict[str, Any]:
        """Content for JSON; not-a-number becomes None."""
        names = ("side", "oil", "friction_model", "reference", "status", "reason", "notes", "jobs", "seconds")
        head = {name: getattr(self, name) for name in names}
        rows = finite_or_none([point.scalars() for point in self.points])
        reference = finite_or_none([self.reference_point(design) for design in self.designs])
        head = {"designs": list(self.designs)} | head | {"levels": self.levels.to_dict(), "points": rows}
        return head | {"reference_points": reference}


@dataclass(frozen=True)
class StudyTask:
    """States of one design with one misalignment."""

    design: Design  # design with its misalignment
    blank: StudyPoint  # point with the names of the design and the added misalignment
    side: Side
    oil: str
    friction: FrictionModel
    states: tuple[tuple[float, ...], ...]  # torque, speed, temperature, roughness of each point
    grid: tuple[int, int]  # positions and points per line
    load_balance: LoadBalance  # forces in the torque balance
    strength: bool  # whether the strength is computed

    @property
    def key(self) -> str:
        """Hash of all inputs of the result, including the version of the program."""
        model: object = self.friction
        if isinstance(model, Formula):
            model = model.model_dump_json()
        design = self.design.model_dump_json()
        run = (self.states, self.grid, self.load_balance, self.strength)
        content = (__version__, design, self.side, self.oil, model, *run, asdict(self.blank))
        return hashlib.sha256(repr(content).encode()).hexdigest()


@one_thread
def run_study(
    designs: Sequence[GearPair | Design | str | Path] = DESIGNS,
    friction: Friction | None = None,
    levels: Levels | None = None,
    *,
    side: Side = "drive",
    oil: str | None = None,
    grid: tuple[int, int] = (POSITIONS, POINTS_PER_LINE),
    jobs: int | None = None,
    store: Path | None = None,
    progress: ProgressCallback | None = None,
    load_balance: LoadBalance = "frictional",
    strength: bool = False,
    **values: Values,
) -> Study:
    """Efficiency of designs over torque, speed, temperature, roughness and misalignment.

    Parameters
    ----------
    designs : sequence of Design or str
        Pairs to compare; the first one defines the reference operating point and the default levels.
    friction : FrictionModel or str, optional
        Friction model or its name; default: the formula shipped for the oil.
    levels : Levels, optional
        Values of all parameters; default: values around the operating point of the first design.
    side : {"drive", "coast"}
        Loaded flanks.
    oil : str, optional
        Oil card instead of that of the first design; all designs use the same card.
    grid : (int, int), optional
        Mesh positions and points per contact line.
    jobs : int, optional
        Worker processes; default: all available cores. For models with solved contacts the points are computed one
        after the other, because these models start their own processes.
    store : Path, optional
        File of the finished tasks; an existing file is read and continued.
    progress : callable, optional
        Called with a `Progress` after each task.
    load_balance : {"frictional", "frictionless"}
        Forces in the torque balance: normal and friction forces, or only the normal forces.
    strength : bool
        Add the strength at each point: most severe grade, safety factors, integral temperature, specific film.
    **values : sequence
        Levels of `torque`, `speed`, `temperature`, `roughness_rms_each`, `E`, `P`, `G`, `shaft_angle_error` instead of
        the default levels, as in `GearPair.over`.

    Returns
    -------
    Study
        One row for each combination, and the influence of each parameter.

    Raises
    ------
    InputError
        No design, two designs of the same name, or an invalid value. A point that cannot be computed does not raise an
        error; its status is recorded.

    Examples
    --------
    >>> import efficiency
    >>> one = {"speed": ["1500 rpm"], "temperature": ["90 degC"], "roughness_rms_each": ["0.4 um"]}
    >>> aligned = {"E": [0.0], "P": [0.0], "G": [0.0], "shaft_angle_error": [0.0]}
    >>> study = efficiency.study(["fm_spiral_bevel_14x39"], "constant:0.05", torque="200, 300 N m", **one, **aligned)
    >>> len(study.to_frame())
    2
    """
    clock = time.perf_counter()
    jobs, side, load_balance = checked_jobs(jobs), checked("side", side), checked("load_balance", load_balance)
    pairs = [(design if isinstance(design, GearPair) else GearPair(design)).design for design in designs]
    names = [pair.name for pair in pairs]
    if not pairs or len(set(names)) < len(names):
        raise InputError("designs", names, "at least one design, each once")
    card = oil or pairs[0].operation.oil
    Oil.load(card)
    given = {name: tuple(axis_values(name, value)) for name, value in values.items()}
    chosen = Levels.around(pairs[0], **given) if levels is None else levels
    reference = chosen.reference(pairs[0])
    model = resolve_friction(friction, pairs[0], card)
    costly = isinstance(model, EhlFriction)
    tasks: list[StudyTask] = []
    for pair in pairs:
        own = resolve_friction(friction, pair) if isinstance(friction, str) else model
        aligned = StudyPoint(pair.name, pair.assembly.hypoid_offset)
        task = StudyTask(pair, aligned, side, card, own, (), grid, load_balance, strength)
        tasks += _tasks(task, chosen, reference, costly)
    total, done = sum(len(task.states) for task in tasks), 0
    ordered = sorted(tasks, key=lambda task: -len(task.states))
    known: dict[str, list[StudyPoint]] = {}
    with Journal(store, field="store") as journal:
        rows = run_tasks(ordered, _solve, jobs=1 if costly else jobs, journal=journal)
        for task, row in zip(ordered, rows, strict=True):
            known[task.key] = [StudyPoint(**point | {"notes": tuple(point["notes"])}) for point in row["points"]]
            done += len(task.states)
            with progress_to(progress):
                report_progress("points", done, total)
    reused = sum(len(known[key]) for key in journal.reused)
    points = [point for task in tasks for point in known[task.key]]
    seconds = time.perf_counter() - clock
    about = tuple(names), side, card, model.name, chosen, reference
    return Study(*about, tuple(points), jobs, reused, seconds)


def _tasks(task: StudyTask, levels: Levels, reference: dict[str, float], costly: bool) -> Iterator[StudyTask]:
    """Tasks of the aligned design, one for each torque, and of each misalignment at the reference.

    Expensive states have one task each.
    """
    every = tuple(product(*(getattr(levels, name) for name in OPERATING)))
    middle = tuple(reference[name] for name in OPERATING)
    start = task.design.assembly.misalignment
    for shift in ({}, *levels.shifts()):
        moved = {name: getattr(start, name) + shift.get(name, 0.0) for name in MISALIGNMENTS}
        placed = replace(task, design=task.design.with_misalignment(**moved), blank=replace(task.blank, **shift))
        for _, part in groupby((middle,) if shift else every, key=None if costly else itemgetter(0)):
            yield replace(placed, states=tuple(part))


def _solve(task: StudyTask) -> dict[str, list[dict[str, Any]]]:
    """All points of a task; a point that cannot be computed is a failed point with its reason."""
    points: list[StudyPoint] = []
    pair = _pair(task.design.with_misalignment().model_dump_json())
    fixed: dict[str, Any] = {"side": task.side, "oil": task.oil, "driver": task.design.operation.driver}
    fixed |= {"load_balance": task.load_balance} | task.design.assembly.misalignment.model_dump()

    clock = time.perf_counter()
    states: list[dict[str, Any]] = [dict(zip(OPERATING, state, strict=True)) for state in task.states]
    solved = pair._evaluator(task.friction, task.grid, fixed, strength=task.strength)[0].points(states)
    seconds = (time.perf_counter() - clock) / len(states)
    for condition, found in zip(states, solved, strict=True):
        point = replace(task.blank, **condition)
        if found.result is None:
            points.append(replace(point, reason=found.reason, notes=found.notes))
        else:
            point = with_result(replace(point, strength=found.requested), found.result)
            points.append(replace(point, seconds=seconds))
    return {"points": [asdict(point) for point in points]}


@lru_cache(maxsize=4)
def _pair(aligned: str) -> GearPair:
    return GearPair(Design.model_validate_json(aligned))
