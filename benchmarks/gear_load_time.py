"""Time of the loaded contact with the geometry known: growth with the mesh positions and with the torques of a map.

``python benchmarks/gear_load_time.py [FOLDER]`` prints a table and writes gear_load_time.csv and gear_load_time.png.
CPU seconds of one core: compliance of both grids (once per mesh), and load on both grids (once per torque), the median
of five.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from time import process_time

import numpy as np
from matplotlib.figure import Figure

from efficiency.design import load_design
from efficiency.gear_mesh import gear_mesh
from efficiency.load.loaded_mesh import load_mesh

DESIGNS = ("fm_spiral_bevel_14x39", "fh_hypoid_9x34")
POSITIONS = (6, 12, 24, 48, 96)


def measure(name: str, positions: int) -> dict[str, float | str | int]:
    """One mesh at its nominal torque."""
    design = load_design(name)
    clock = process_time()
    mesh = gear_mesh(design, "drive", positions).mesh
    geometry = process_time() - clock
    clock = process_time()
    points = sum(p.position.pair.size for p in (*mesh.elastic_fine, *mesh.elastic_coarse))
    compliance = process_time() - clock
    load_mesh(mesh, design.operation.torque)
    seconds = []
    for _ in range(5):
        clock = process_time()
        load_mesh(mesh, design.operation.torque)
        seconds.append(process_time() - clock)
    return {
        "design": name,
        "positions": positions,
        "points": points,
        "geometry": geometry,
        "compliance": compliance,
        "load": float(np.median(seconds)),
    }


def main() -> None:
    """Run all computations."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path()
    folder.mkdir(parents=True, exist_ok=True)
    rows = [measure(name, positions) for name in DESIGNS for positions in POSITIONS]
    for row in rows:
        print(
            f"{row['design']:24s} {row['positions']:4d} positions {row['points']:6d} points  geometry and teeth "
            f"{row['geometry']:.3f} s  compliance {row['compliance']:.3f} s  load {row['load']:.4f} s"
        )
    with (folder / "gear_load_time.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    figure = Figure(figsize=(6.0, 4.0), layout="constrained")
    axes = figure.add_subplot()
    for name, colour in zip(DESIGNS, ("#1f5a99", "#c8651b"), strict=True):
        part = [row for row in rows if row["design"] == name]
        count = [float(row["positions"]) for row in part]
        axes.loglog(count, [float(row["load"]) for row in part], "o-", color=colour, label=f"load, {name}")
        axes.loglog(count, [float(row["compliance"]) for row in part], "s--", color=colour, label="its compliance")
    axes.loglog(POSITIONS, 0.004 * np.array(POSITIONS), ":", color="grey", label="linear")
    axes.set(xlabel="mesh positions [-]", ylabel="CPU seconds, one core")
    axes.legend(frameon=False, fontsize=8)
    figure.savefig(folder / "gear_load_time.png", dpi=150)


if __name__ == "__main__":
    main()
