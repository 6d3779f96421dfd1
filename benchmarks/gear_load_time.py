"""Time of the gear side: stages from the design file on, growth with mesh positions and with map points, memory.

``python benchmarks/gear_load_time.py [FOLDER]`` prints tables and writes gear_load_time.csv and gear_load_time.png.
CPU seconds of one core (set OMP_NUM_THREADS=1). Stages: a new process each, after one that has filled the caches of
bytecode. Growth: geometry of both grids and compliance once per mesh, load once per torque, each the median of five;
maps of torques by twenty speeds with the geometry known. Memory: the most in use after all that.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from common import OUT, command_line, write_rows
from matplotlib.figure import Figure

from efficiency.design.design import load_design
from efficiency.loss.kinematics import Operation
from efficiency.ltca.load_distribution import elastic_cycle
from efficiency.ltca.mesh_grids import load_grids
from efficiency.pair import Mesh, elastic_bodies
from ehl.fluid.oil import Oil
from regression.formula import friction_model

DESIGNS = ("fm_spiral_bevel_14x39", "fh_hypoid_9x34")
COLOURS = ("#1f5a99", "#c8651b")
POSITIONS = (6, 12, 24, 48, 96)
TORQUES = (1, 2, 5, 10, 20)
SPEEDS = 20
FORMULA = "xu_kahraman_2007"

STAGES = f"""
from time import process_time
marks = [("start of Python", process_time())]
import json, sys
from efficiency.design.design import load_design
from efficiency.pair import Mesh, elastic_bodies
from efficiency.loss.efficiency import load_grids, mesh_efficiency
from efficiency.loss.kinematics import Operation
from ehl.fluid.oil import Oil
from regression.formula import friction_model
marks.append(("imports", process_time()))
design = load_design(sys.argv[1])
marks.append(("reading the design", process_time()))
bodies = elastic_bodies(design, "drive")
marks.append(("solid teeth", process_time()))
mesh = Mesh.of(design, bodies=bodies).grids
marks.append(("geometry and contact lines", process_time()))
mesh.elastic_fine, mesh.elastic_coarse
marks.append(("compliance at the points", process_time()))
loaded = load_grids(mesh, design.operation.torque)
marks.append(("load", process_time()))
operation = Operation(design.operation.speed, design.operation.temperature, 4e-7, 4e-7)
mesh_efficiency(loaded, friction_model("{FORMULA}"), Oil.load(design.operation.oil), operation)
marks.append(("friction and loss", process_time()))
print(json.dumps(marks))
"""


@dataclass(frozen=True)
class Growth:
    """CPU seconds of one kind of work over its size."""

    design: str
    work: str
    size: int
    seconds: float


def efficiency_map(mesh: Any, model: Any, oil: Oil, torques: Any, at: Any, speeds: Any, temperatures: Any) -> list[Any]:
    """Efficiency at every combination; the load once per torque."""
    from efficiency.loss.efficiency import mesh_efficiency

    loads = [load_grids(mesh, torque) for torque in torques]
    return [mesh_efficiency(load, model, oil, at(s, t)) for load in loads for s in speeds for t in temperatures]


def cpu(work: Callable[[], Any], repeats: int = 1) -> float:
    """CPU seconds of this process, median of some repeats."""
    seconds = []
    for _ in range(repeats):
        clock = process_time()
        work()
        seconds.append(process_time() - clock)
    return float(np.median(seconds))


def stages(name: str, repeats: int = 5) -> dict[str, float]:
    """CPU seconds of each stage of one operating point from its design file, each the least of some processes."""
    runs = []
    for _ in range(repeats + 1):
        run = subprocess.run([sys.executable, "-c", STAGES, name], capture_output=True, text=True, check=True)
        marks = json.loads(run.stdout)
        runs.append([marks[0][1], *(after[1] - before[1] for before, after in pairwise(marks))])
    return dict(zip((mark[0] for mark in marks), np.min(runs[1:], axis=0).tolist(), strict=True))


def over_positions(name: str) -> list[Growth]:
    """Work at the nominal torque over the number of mesh positions."""
    design = load_design(name)
    torque, bodies = design.operation.torque, elastic_bodies(design, "drive")
    rows = []
    for count in POSITIONS:
        mesh = Mesh.of(design, "drive", count, bodies=bodies).grids
        load_grids(mesh, torque)
        work: dict[str, Callable[[], Any]] = {
            "geometry": lambda count=count: Mesh.of(design, "drive", count, bodies=bodies),
            "compliance": lambda mesh=mesh: [elastic_cycle(c, mesh.teeth) for c in (mesh.fine, mesh.coarse)],
            "load": lambda mesh=mesh: load_grids(mesh, torque),
        }
        rows += [Growth(name, kind, count, cpu(run, 5)) for kind, run in work.items()]
    return rows


def over_map(name: str) -> list[Growth]:
    """A map with the geometry known over its number of points."""
    design = load_design(name)
    given = design.operation
    mesh, model, oil = Mesh.of(design).grids, friction_model(FORMULA), Oil.load(given.oil)
    load_grids(mesh, given.torque)
    speeds = list(np.linspace(0.1, 1.5, SPEEDS) * given.speed)
    rows = []

    def at(speed: float, temperature: float) -> Operation:
        return Operation(speed, temperature, 4e-7, 4e-7)

    for count in TORQUES:
        torques = list(np.linspace(1.5 / count, 1.5, count) * given.torque)

        def run(torques: list[float] = torques) -> Any:
            return efficiency_map(mesh, model, oil, torques, at, speeds, [given.temperature])

        rows.append(Growth(name, "map", count * SPEEDS, cpu(run)))
    return rows


def plot(rows: list[Growth], path: Path) -> None:
    """Seconds over positions and over map points; dotted: in proportion."""
    figure = Figure(figsize=(8.6, 4.0), layout="constrained")
    kinds = ({"geometry": "^-.", "compliance": "s--", "load": "o-"}, {"map": "o-"})
    for axes, styles, label in zip(figure.subplots(1, 2), kinds, ("mesh positions", "map points"), strict=True):
        for work, style in styles.items():
            for name, colour in zip(DESIGNS, COLOURS, strict=True):
                part = [row for row in rows if row.design == name and row.work == work]
                axes.loglog(
                    [r.size for r in part],
                    [r.seconds for r in part],
                    style,
                    color=colour,
                    label=f"{work}, {name.split('_')[-1]}",
                )
        last = max((row for row in rows if row.work in styles and row.work in ("load", "map")), key=lambda r: r.size)
        sizes = sorted({row.size for row in rows if row.work in styles})
        axes.loglog(sizes, [0.6 * last.seconds * n / last.size for n in sizes], ":", color="grey", label="linear")
        axes.set(xlabel=f"{label} [-]", ylabel="CPU seconds of one core")
        axes.set_xticks(sizes, [str(n) for n in sizes])
        axes.minorticks_off()
        axes.set_ylim(bottom=0.3 * axes.get_ylim()[0])
        axes.legend(frameon=False, fontsize=8, loc="lower right", ncols=2)
    figure.savefig(path, dpi=150)


def main(argv: Sequence[str] | None = None) -> None:
    """Run all computations."""
    parser = command_line(__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=OUT)
    folder = parser.parse_args(argv).folder
    folder.mkdir(parents=True, exist_ok=True)
    split = {name: stages(name) for name in DESIGNS}
    for stage in next(iter(split.values())):
        print(f"{stage:28s}" + "".join(f"{split[name][stage]:10.3f}" for name in DESIGNS))
    print(f"{'sum':28s}" + "".join(f"{sum(split[name].values()):10.3f}" for name in DESIGNS))
    rows = [row for name in DESIGNS for row in (*over_positions(name), *over_map(name))]
    for row in rows:
        print(f"{row.design:24s} {row.work:12s} {row.size:5d} {row.seconds:8.3f} s")
    print(f"memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0:.0f} MB")
    write_rows(folder / "gear_load_time.csv", rows)
    plot(rows, folder / "gear_load_time.png")


if __name__ == "__main__":
    main()
