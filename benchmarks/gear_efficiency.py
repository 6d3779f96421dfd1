"""Run time of the efficiency of a pair, and friction formulas against solving every contact.

``python benchmarks/gear_efficiency.py [FOLDER] [--part interface times growth map models contacts]
[--design NAME ...]``

``interface``: CPU seconds of the questions of the public interface: first answer from the design file, new torque, new
speed, 20 x 20 map. ``times``: CPU seconds of each stage from the design file on. ``growth``: seconds over mesh
positions and over map points. ``map``: 20 x 20 torques and speeds, with the memory it takes. ``models``: efficiency
with the shipped formulas of the oil (or those given with ``--formula``), with smooth and load-sharing contacts,
against the deterministic rough solver, at the operating point of each design and at a third of its speed and 110
degC. ``contacts``: wall time of ``ehl`` and ``ehl:smooth`` on `--jobs` cores, with `--contacts` contacts or as many as
the program takes; run it on an idle machine. CSV files and figures go to FOLDER.
"""

from __future__ import annotations

import csv
import resource
import time
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from common import command_line
from matplotlib.figure import Figure

from efficiency.design.design import Design, load_design
from efficiency.loss.efficiency import load_grids, mesh_efficiency
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.ehl_friction import EhlFriction
from efficiency.loss.kinematics import Operation
from efficiency.loss.regions import friction_along_mesh
from efficiency.pair import GearPair, Mesh, resolve_friction
from ehl.fluid.oil import Oil
from regression.formula import shipped_formulas
from regression.friction.conditions import conditions_of

DESIGNS = ("fm_spiral_bevel_14x39", "fh_hypoid_9x34")
POSITIONS = (12, 24, 48, 96)
REFERENCE = "ehl"
SOLVED = ("ehl:smooth", "ehl:load_sharing", REFERENCE)


@dataclass(frozen=True)
class Stage:
    """CPU seconds of one stage."""

    design: str
    stage: str
    seconds: float


@dataclass(frozen=True)
class Growth:
    """CPU seconds over the size of a computation."""

    over: str
    size: int
    seconds: float


@dataclass(frozen=True)
class Model:
    """Efficiency with one friction model; the difference is in points (1 = 1 % of the input power)."""

    design: str
    rpm: float
    degC: float
    film_ratio: float  # mean over the sliding power, by formula
    friction: str
    efficiency: float
    efficiency_lower: float
    efficiency_upper: float
    difference: float
    mean_mu: float
    outside_range_share: float
    contacts: int
    failed: int
    status: str
    seconds: float  # CPU


@dataclass(frozen=True)
class Contacts:
    """Run time of solved contacts."""

    design: str
    friction: str
    contacts: int
    failed: int
    jobs: int
    wall_seconds: float
    efficiency: float
    efficiency_lower: float
    efficiency_upper: float


def efficiency_map(mesh: Any, model: Any, oil: Oil, torques: Any, at: Any, speeds: Any, temperatures: Any) -> list[Any]:
    """Efficiency at every combination; the load once per torque."""
    from efficiency.loss.efficiency import mesh_efficiency

    loads = [load_grids(mesh, torque) for torque in torques]
    return [mesh_efficiency(load, model, oil, at(s, t)) for load in loads for s in speeds for t in temperatures]


def cpu(work: Callable[[], Any]) -> tuple[Any, float]:
    """What some work gives, and its CPU seconds in this process."""
    clock = time.process_time()
    result = work()
    return result, time.process_time() - clock


def at(design: Design) -> Operation:
    """Operating point of a design file."""
    return design.running(design.operation.speed, design.operation.temperature)


def times(design: Design, formula: str) -> list[Stage]:
    """Stages of one operating point, and the same again with the geometry known."""
    model, oil, torque = resolve_friction(formula, design), Oil.load(design.operation.oil), design.operation.torque
    geared, geometry = cpu(lambda: Mesh.of(design))
    loaded, first = cpu(lambda: load_grids(geared.grids, torque))
    _, friction = cpu(lambda: mesh_efficiency(loaded, model, oil, at(design)))
    other, again = cpu(lambda: load_grids(geared.grids, 0.8 * torque))
    _, loss = cpu(lambda: mesh_efficiency(other, model, oil, at(design)))
    rows = {"geometry": geometry, "compliance and load": first, "friction and loss": friction}
    rows |= {"one more point, geometry known": again + loss}
    return [Stage(design.name, stage, seconds) for stage, seconds in rows.items()]


def growth(design: Design, formula: str) -> list[Growth]:
    """Seconds over mesh positions (load and loss, geometry known) and over map points (load known)."""
    model, oil, torque = resolve_friction(formula, design), Oil.load(design.operation.oil), design.operation.torque
    rows = []
    for positions in POSITIONS:
        mesh = Mesh.of(design, "drive", positions).grids
        load_grids(mesh, 0.9 * torque)
        _, seconds = cpu(lambda mesh=mesh: mesh_efficiency(load_grids(mesh, torque), model, oil, at(design)))
        rows.append(Growth("positions", positions, seconds))
    mesh = Mesh.of(design).grids
    for count in (4, 16, 64):
        speeds = list(np.linspace(50.0, 500.0, count))

        def run(speeds: Sequence[float] = speeds) -> Any:
            return efficiency_map(mesh, model, oil, [torque], lambda s, t: design.running(s, t), speeds, [363.15])

        rows.append(Growth("map points of one torque", count, cpu(run)[1]))
    return rows


def whole_map(design: Design, formula: str, points: int = 20) -> tuple[float, float]:
    """CPU seconds of a map of torques and speeds from the design on, and the most memory in use [MB]."""
    model, oil = resolve_friction(formula, design), Oil.load(design.operation.oil)
    torques = list(np.linspace(0.1, 1.5, points) * design.operation.torque)
    speeds = list(np.linspace(0.1, 1.5, points) * design.operation.speed)

    def run() -> Any:
        mesh = Mesh.of(design).grids
        return efficiency_map(mesh, model, oil, torques, lambda s, t: design.running(s, t), speeds, [363.15])

    _, seconds = cpu(run)
    return seconds, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def interface(design: Design, formula: str, repeats: int = 3) -> list[Stage]:
    """Questions a notebook asks one after the other, each the least of some repetitions; the map on a new mesh."""
    torque, speed = design.operation.torque, design.operation.speed
    runs = []
    for k in range(repeats):
        loaded, first = cpu(lambda: GearPair(load_design(design.name)).mesh().load())
        _, answer = cpu(partial(loaded.efficiency, formula))
        other, load = cpu(partial(loaded.mesh.load, (0.8 + 0.01 * k) * torque))
        _, of_load = cpu(partial(other.efficiency, formula))
        _, of_speed = cpu(partial(loaded.efficiency, formula, speed=0.7 * speed))
        runs.append([first + answer, load + of_load, of_speed])
    mesh, share = GearPair(design).mesh(), np.linspace(0.1, 1.5, 20)
    _, of_map = cpu(lambda: mesh.over(formula, torque=list(share * torque), speed=list(share * speed)))
    names = ("design file to efficiency", "new torque", "new speed", "map of 20 x 20 points")
    seconds = (*np.min(runs, axis=0).tolist(), of_map)
    return [Stage(design.name, name, value) for name, value in zip(names, seconds, strict=True)]


def operations(design: Design) -> tuple[Operation, ...]:
    """The design's own operating point, and a slow hot one whose films are thin."""
    own = at(design)
    return own, replace(own, speed=own.speed / 3.0, temperature=383.15)


def models(
    design: Design, formulas: Sequence[str], solved: Sequence[str], contacts: int | None
) -> tuple[list[Model], list[list[EfficiencyResult]]]:
    """Efficiency with each friction model at each operating point, solved contacts on one core; and the results."""
    oil = Oil.load(design.operation.oil)
    loaded = load_grids(Mesh.of(design).grids, design.operation.torque)
    rows, results = [], []
    for operation in operations(design):
        found = []
        for name in (*solved, *formulas):
            model = resolve_friction(name, design)
            if isinstance(model, EhlFriction):
                model = replace(_solving(model, contacts), jobs=1)
            found.append(cpu(partial(mesh_efficiency, loaded, model, oil, operation)))
        reference = next((r for r, _ in found if r.friction_model == REFERENCE), found[0][0])
        results.append([result for result, _ in found])
        for result, seconds in found:
            points = result.points
            film = conditions_of(points.state, oil)["film_ratio_formula"]
            rows.append(
                Model(
                    design.name,
                    result.speed * 30.0 / np.pi,
                    result.temperature - 273.15,
                    float(np.average(film, weights=points.force * points.speed_sliding)),
                    result.friction_model,
                    result.efficiency,
                    result.efficiency_lower,
                    result.efficiency_upper,
                    100.0 * (result.efficiency - reference.efficiency),
                    result.friction_coefficient_mean,
                    result.outside_range_share,
                    result.contacts,
                    sum(result.contacts_failed.values()),
                    result.status,
                    seconds,
                )
            )
    return rows, results


def _solving(model: EhlFriction, contacts: int | None) -> EhlFriction:
    """The model with so many contacts, or as the program has it."""
    return model if contacts is None else replace(model, points=contacts, tolerance=0.0)


def contacts_of(design: Design, names: Sequence[str], contacts: int | None, jobs: int) -> list[Contacts]:
    """Wall time of solved contacts, worker processes and their start included."""
    oil = Oil.load(design.operation.oil)
    loaded = load_grids(Mesh.of(design).grids, design.operation.torque)
    rows = []
    for name in names:
        model = resolve_friction(name, design)
        if not isinstance(model, EhlFriction):
            continue
        clock = time.perf_counter()
        result = mesh_efficiency(loaded, replace(_solving(model, contacts), jobs=jobs), oil, at(design))
        seconds = time.perf_counter() - clock
        failed = sum(result.contacts_failed.values())
        interval = result.efficiency, result.efficiency_lower, result.efficiency_upper
        rows.append(Contacts(design.name, name, result.contacts, failed, jobs, seconds, *interval))
    return rows


def warm_up(design: Design, names: Sequence[str], jobs: int) -> None:
    """Compiled code in the cache of the machine."""
    contacts_of(design, names, 24, jobs)


def plot_models(results: Sequence[Sequence[EfficiencyResult]], path: Path) -> None:
    """Friction along the mesh cycle by each model, a row per operating point."""
    figure = Figure(figsize=(8.0, 3.0 * len(results)), layout="constrained")
    for axes, found in zip(np.atleast_1d(figure.subplots(len(results), 1)), results, strict=True):
        for result in found:
            line = {"linewidth": 2.5, "color": "black"} if result.friction_model == REFERENCE else {"linewidth": 1.2}
            angle = np.degrees(result.pinion_angle)
            axes.plot(angle, friction_along_mesh(result), label=result.friction_model, **line)
        rpm, temperature = result.speed * 30.0 / np.pi, result.temperature - 273.15
        axes.set_title(f"{result.design}, {rpm:.0f} rpm, {temperature:.0f} °C", fontsize=10)
        axes.set(xlabel="pinion angle [°]", ylabel="mean friction coefficient")
        axes.set_ylim(bottom=0.0)
        axes.legend(frameon=False, fontsize=7, ncol=3)
    figure.savefig(path, dpi=150)


def write(folder: Path, name: str, rows: Sequence[Any]) -> None:
    """Rows of one kind as CSV and on the screen."""
    header = [field.name for field in fields(rows[0])]
    with (folder / f"gear_efficiency_{name}.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(astuple(row) for row in rows)
    print("\n" + "  ".join(header))
    for row in rows:
        print("  ".join(f"{value:.5g}" if isinstance(value, float) else str(value) for value in astuple(row)))


def plot_growth(rows: Sequence[Growth], path: Path) -> None:
    """Seconds over size, with the straight line through the origin."""
    figure = Figure(figsize=(7.0, 3.4), layout="constrained")
    kinds = dict.fromkeys(row.over for row in rows)
    for axes, kind in zip(figure.subplots(1, len(kinds)), kinds, strict=True):
        part = [row for row in rows if row.over == kind]
        size = np.array([row.size for row in part])
        seconds = np.array([row.seconds for row in part])
        axes.loglog(size, seconds, "o-", color="#1f5a99")
        axes.loglog(size, seconds[-1] * size / size[-1], "--", color="#8a8f98", label="linear")
        axes.set(xlabel=kind, ylabel="CPU seconds")
        axes.legend(frameon=False)
    figure.savefig(path, dpi=150)


def main(argv: Sequence[str] | None = None) -> None:
    """Run the parts asked for."""
    parser = command_line(__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=Path())
    parser.add_argument("--part", nargs="+", default=["interface", "times", "growth", "map", "models"])
    parser.add_argument("--design", nargs="+", default=list(DESIGNS))
    parser.add_argument("--formula", nargs="+", help="formula files or names; default: those shipped for the oil")
    parser.add_argument("--solved", nargs="*", default=list(SOLVED), help="solved contacts to compare with")
    parser.add_argument("--contacts", type=int, help="contacts solved of a mesh; default: as the program")
    parser.add_argument("--jobs", type=int, default=2, help="worker processes of the part contacts")
    given = parser.parse_args(argv)
    given.folder.mkdir(parents=True, exist_ok=True)
    designs, reading = cpu(lambda: [load_design(name) for name in given.design])
    formulas = [given.formula or list(shipped_formulas(design.operation.oil)) for design in designs]
    # the first run of all pays for compiled code and caches
    times(designs[0], formulas[0][0])
    if "interface" in given.part:
        rows = [row for design, names in zip(designs, formulas, strict=True) for row in interface(design, names[0])]
        write(given.folder, "interface", rows)
    if "times" in given.part:
        stages = [row for design, names in zip(designs, formulas, strict=True) for row in times(design, names[0])]
        write(given.folder, "times", [Stage("all", "reading the designs", reading), *stages])
    if "growth" in given.part:
        rows = growth(designs[0], formulas[0][0])
        write(given.folder, "growth", rows)
        plot_growth(rows, given.folder / "gear_efficiency_growth.png")
    if "map" in given.part:
        seconds, memory = whole_map(designs[0], formulas[0][0])
        print(f"\nmap of 20 x 20 points: {seconds:.1f} s CPU, {memory:.0f} MB in the whole run")
    if "models" in given.part:
        rows = []
        for design, names in zip(designs, formulas, strict=True):
            more, results = models(design, names, given.solved, given.contacts)
            rows += more
            plot_models(results, given.folder / f"gear_efficiency_{design.name}.png")
        write(given.folder, "models", rows)
    if "contacts" in given.part:
        names = [name for name in ("ehl:smooth", REFERENCE) if name in given.solved]
        warm_up(designs[0], names, given.jobs)
        write(
            given.folder,
            "contacts",
            [row for d in designs for row in contacts_of(d, names, given.contacts, given.jobs)],
        )


if __name__ == "__main__":
    main()
