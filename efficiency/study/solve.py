"""Computing a study: geometry once per misalignment, load once per torque as well, all else on top of that.

designs x (aligned + misalignments)  ->  geometry  ->  torques  ->  load  ->  speeds x temperatures x roughnesses

Each of these tasks is written down when it ends; a study that was killed goes on where it was.
"""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from itertools import groupby, product
from operator import itemgetter
from pathlib import Path
from typing import Any

from efficiency.contact.gear_flanks import Side
from efficiency.design.design import Design, load_design
from efficiency.gear_mesh import Bodies, elastic_bodies, gear_mesh
from efficiency.loss.efficiency import mesh_efficiency
from efficiency.loss.ehl_friction import EhlFriction
from efficiency.loss.kinematics import Operation
from efficiency.ltca.mesh_grids import LoadedGrids, MeshGrids, load_grids
from efficiency.run import POINTS_PER_LINE, POSITIONS, resolve_friction
from efficiency.study.levels import MISALIGNED, Levels
from efficiency.study.points import Study, StudyPoint, with_result
from ehl import __version__
from ehl.fluid.oil import Oil
from ehl.io.errors import ConvergenceError, InputError
from ehl.io.numbers import finite_or_none
from regression.formula import Formula
from regression.friction.models import FrictionModel

State = tuple[float, float, float, float]
"""Torque, speed, temperature, roughness."""


@dataclass(frozen=True)
class StudyTask:
    """States of one design under one misalignment.

    Attributes
    ----------
    design : Design
        Misalignment included.
    blank : StudyPoint
        Names the design and what was added to its misalignment.
    side : str
    oil : str
    friction : FrictionModel
    states : tuple
        Torque, speed, temperature, roughness of each point.
    grid : (int, int)
        Positions and points per line.
    """

    design: Design
    blank: StudyPoint
    side: Side
    oil: str
    friction: FrictionModel
    states: tuple[State, ...]
    grid: tuple[int, int]

    @property
    def key(self) -> str:
        """Hash of all that the result depends on, the version of the program included."""
        model: object = self.friction
        if isinstance(model, Formula):
            model = model.formula.model_dump_json()
        design = self.design.model_dump_json()
        content = (__version__, design, self.side, self.oil, model, self.states, self.grid, asdict(self.blank))
        return hashlib.sha256(repr(content).encode()).hexdigest()


def run_study(
    designs: Sequence[Design | str],
    friction: FrictionModel | str | None = None,
    levels: Levels | None = None,
    *,
    side: Side = "drive",
    oil: str | None = None,
    positions: int = POSITIONS,
    points_per_line: int = POINTS_PER_LINE,
    jobs: int = 1,
    store: Path | None = None,
    report: Callable[[int, int], None] | None = None,
) -> Study:
    """Efficiency of designs over torque, speed, temperature, roughness and misalignment.

    Parameters
    ----------
    designs : sequence of Design or str
        Pairs to compare; the first gives the reference operating point and the default levels.
    friction : FrictionModel or str, optional
        Friction model or its name; by default the formula shipped for the oil.
    levels : Levels, optional
        Values of the parameters.
    side : {"drive", "coast"}
        Flanks that carry the load.
    oil : str, optional
        Oil card in place of the first design's; it is the same for all designs.
    positions, points_per_line : int
        Resolution of each point.
    jobs : int
        Worker processes. Models that solve contacts have their own: they are asked one after the other.
    store : Path, optional
        File of the finished tasks, read and continued.
    report : callable, optional
        Called with the number of points done and of all points.

    Raises
    ------
    InputError
        No design, two of one name, or a value that a single computation refuses. A point that cannot be computed is a
        recorded status.
    """
    clock = time.perf_counter()
    pairs = [design if isinstance(design, Design) else load_design(design) for design in designs]
    names = [pair.name for pair in pairs]
    if not pairs or len(set(names)) < len(names):
        raise InputError("designs", names, "at least one design, each once")
    card = oil or pairs[0].operation.oil
    Oil.load(card)
    chosen = Levels.around(pairs[0]) if levels is None else levels
    reference = chosen.reference(pairs[0])
    model = resolve_friction(friction if friction is not None else default_friction(card), pairs[0])
    costly = isinstance(model, EhlFriction)
    tasks: list[StudyTask] = []
    for pair in pairs:
        own = resolve_friction(friction, pair) if isinstance(friction, str) else model
        tasks += _tasks(pair, own, chosen, reference, side, card, (positions, points_per_line), costly)
    known = _read(store) if store is not None else {}
    waiting = [task for task in tasks if task.key not in known]
    total = sum(len(task.states) for task in tasks)
    done = sum(len(task.states) for task in tasks if task.key in known)
    reused = done
    for key, found in _solve_all(waiting, 1 if costly else jobs):
        known[key] = found
        if store is not None:
            _append(store, key, found)
        done += len(found[0])
        if report is not None:
            report(done, total)
    notes: Counter[str] = Counter()
    points: list[StudyPoint] = []
    for task in tasks:
        part, remarks = known[task.key]
        points += part
        notes.update(remarks)
    seconds = time.perf_counter() - clock
    return Study(
        tuple(names), side, card, model.name, chosen, reference, tuple(points), dict(notes), jobs, reused, seconds
    )


def default_friction(oil: str) -> str:
    """The formula shipped for an oil, else a published one that knows pressure, speeds, viscosity and roughness."""
    from regression.formula import shipped_formulas

    shipped = shipped_formulas(oil)
    return shipped[0] if shipped else "xu_kahraman_2007"


def _tasks(
    design: Design,
    friction: FrictionModel,
    levels: Levels,
    reference: dict[str, float],
    side: Side,
    oil: str,
    grid: tuple[int, int],
    costly: bool,
) -> Iterator[StudyTask]:
    """States of the aligned design, a task for each torque, and each misalignment at the reference.

    Costly states make a task each.
    """
    every = tuple(product(levels.torque, levels.speed, levels.temperature_oil, levels.roughness_rms))
    middle = (reference["torque"], reference["speed"], reference["temperature_oil"], reference["roughness_rms"])
    start = design.assembly.misalignment
    for shift in ({}, *levels.shifts()):
        moved = {name: getattr(start, name) + shift.get(name, 0.0) for name in MISALIGNED}
        blank = StudyPoint(
            design=design.name,
            hypoid_offset=design.assembly.hypoid_offset,
            E=shift.get("E", 0.0),
            P=shift.get("P", 0.0),
            G=shift.get("G", 0.0),
            alpha=shift.get("alpha", 0.0),
            torque=0.0,
            speed=0.0,
            temperature_oil=0.0,
            roughness_rms=0.0,
        )
        task = StudyTask(design.with_misalignment(**moved), blank, side, oil, friction, (), grid)
        states = (middle,) if shift else every
        for _, part in groupby(states, key=None if costly else itemgetter(0)):
            yield replace(task, states=tuple(part))


Found = tuple[list[StudyPoint], dict[str, int]]


def _solve_all(tasks: Sequence[StudyTask], jobs: int) -> Iterator[tuple[str, Found]]:
    """Key and result of each task, as they end; long ones first."""
    ordered = sorted(tasks, key=lambda task: -len(task.states))
    if jobs == 1 or len(ordered) < 2:
        yield from map(_solve, ordered)
        return
    from joblib import Parallel, delayed, parallel_config

    with parallel_config(backend="loky", inner_max_num_threads=1):
        yield from Parallel(n_jobs=jobs, return_as="generator_unordered")(delayed(_solve)(task) for task in ordered)


def _solve(task: StudyTask) -> tuple[str, Found]:
    """All points of a task; what cannot be computed is a failed point with its reason."""
    from threadpoolctl import threadpool_limits

    points: list[StudyPoint] = []
    notes: Counter[str] = Counter()
    card = Oil.load(task.oil)
    with threadpool_limits(1):
        for torque, speed, temperature, roughness in task.states:
            clock = time.perf_counter()
            point = replace(
                task.blank, torque=torque, speed=speed, temperature_oil=temperature, roughness_rms=roughness
            )
            try:
                loaded = _loaded(task.design, task.side, torque, task.grid)
                operation = Operation.of_design(task.design, speed, temperature, task.design.operation.driver)
                operation = replace(operation, roughness_rms_pinion=roughness, roughness_rms_gear=roughness)
                result = mesh_efficiency(loaded, task.friction, card, operation)
            except ConvergenceError as error:
                points.append(replace(point, reason=error.reason))
                notes[f"{error.reason}: {error.detail}"] += 1
                continue
            points.append(replace(with_result(point, result), seconds=time.perf_counter() - clock))
            notes.update(result.notes)
    return task.key, (points, dict(notes))


@lru_cache(maxsize=4)
def _bodies(aligned: str, side: Side) -> Bodies:
    return elastic_bodies(Design.model_validate_json(aligned), side)


@lru_cache(maxsize=2)
def _mesh(design: str, side: Side, grid: tuple[int, int]) -> MeshGrids:
    pair = Design.model_validate_json(design)
    return gear_mesh(pair, side, *grid, _bodies(pair.with_misalignment().model_dump_json(), side)).mesh


@lru_cache(maxsize=2)
def _loaded_mesh(design: str, side: Side, torque: float, grid: tuple[int, int]) -> LoadedGrids:
    return load_grids(_mesh(design, side, grid), torque)


def _loaded(design: Design, side: Side, torque: float, grid: tuple[int, int]) -> LoadedGrids:
    return _loaded_mesh(design.model_dump_json(), side, torque, grid)


def _append(store: Path, key: str, found: Found) -> None:
    """Write a finished task as one line."""
    points = finite_or_none(found[0])
    line = json.dumps({"key": key, "points": points, "notes": found[1]}, allow_nan=False)
    try:
        store.parent.mkdir(parents=True, exist_ok=True)
        with store.open("a", encoding="utf-8") as file:
            # a line that was cut off when an earlier run was killed must not swallow this one
            file.write(f"\n{line}\n" if file.tell() else f"{line}\n")
    except OSError as error:
        raise InputError("--output", str(store.parent), "a folder that can be written", f"{error}.") from None


def _read(store: Path) -> dict[str, Found]:
    """Finished tasks of an earlier run; a line that was cut off when it was killed counts as not computed."""
    found: dict[str, Found] = {}
    if not store.is_file():
        return found
    for line in store.read_text(encoding="utf-8").splitlines():
        try:
            row = json.loads(line)
            points = [StudyPoint(**_numbers(point)) for point in row["points"]]
            found[row["key"]] = points, row["notes"]
        except (ValueError, KeyError, TypeError):
            continue
    return found


def _numbers(row: dict[str, Any]) -> dict[str, Any]:
    return {name: math.nan if value is None else value for name, value in row.items()}
