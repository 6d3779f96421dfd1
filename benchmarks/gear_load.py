"""Cost and error of the gear stage: positions, points per line and polynomials of the tooth plates.

``python benchmarks/gear_load.py [FOLDER]`` prints a table and writes gear_load.csv and gear_load.png. The truth is the
finest computation of the table; the polynomials of the plates are varied on the default grid.
"""

from __future__ import annotations

import csv
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path

from matplotlib.figure import Figure

from efficiency.design import load_design
from efficiency.gear_mesh import gear_mesh
from efficiency.load.compliance import Tooth
from efficiency.loss.efficiency import Mesh, load_mesh, mesh_efficiency
from efficiency.loss.kinematics import Operation
from ehl.oil import Oil
from regression.friction_models import friction_model

DESIGN = "fm_spiral_bevel_14x39"
GRIDS = ((4, 9), (8, 9), (8, 15), (12, 15), (12, 31), (24, 31), (24, 61), (48, 61), (48, 121))
TERMS = ((4, 8), (6, 14), (8, 20), (12, 28), (16, 36))
TORQUES = (30.0, 300.0)


@dataclass(frozen=True)
class Row:
    """One computation."""

    positions: int
    points_per_line: int
    terms_height: int
    terms_length: int
    torque_pinion: float
    seconds: float
    efficiency: float
    efficiency_error: float
    pressure_max: float


def measure(mesh: Mesh, grid: tuple[int, int], terms: tuple[int, int], geometry_seconds: float) -> list[Row]:
    """Efficiency with a published friction formula at both torques."""
    design = load_design(DESIGN)
    model, oil = friction_model("xu_kahraman_2007"), Oil.load("75w90")
    operation = Operation(design.operation.speed, design.operation.temperature_oil, 0.4e-6, 0.4e-6)
    rows = []
    for torque in TORQUES:
        clock = time.perf_counter()
        result = mesh_efficiency(load_mesh(mesh, torque), model, oil, operation)
        seconds = geometry_seconds + time.perf_counter() - clock
        rows.append(
            Row(*grid, *terms, torque, seconds, result.efficiency, result.efficiency_error, result.pressure_max)
        )
    return rows


def with_terms(mesh: Mesh, terms: tuple[int, int]) -> Mesh:
    """The same mesh with other polynomials in the plates of the teeth."""

    def tooth(old: Tooth) -> Tooth:
        return replace(old, plate=replace(old.plate, terms_height=terms[0], terms_length=terms[1]))

    teeth = mesh.teeth
    return replace(mesh, teeth=replace(teeth, pinion=tooth(teeth.pinion), gear=tooth(teeth.gear)))


def main() -> None:
    """Run all computations."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path()
    folder.mkdir(parents=True, exist_ok=True)
    design = load_design(DESIGN)
    rows: list[Row] = []
    for grid in GRIDS:
        clock = time.perf_counter()
        mesh = gear_mesh(design, "drive", *grid).mesh
        rows += measure(mesh, grid, (8, 20), time.perf_counter() - clock)
    default = gear_mesh(design, "drive", 24, 31).mesh
    plates = [row for terms in TERMS for row in measure(with_terms(default, terms), (24, 31), terms, 0.0)]

    def truth(group: list[Row], torque: float) -> float:
        return [row.efficiency for row in group if row.torque_pinion == torque][-1]

    print(
        "positions points  terms torque  seconds  loss[%]  true error  stated error  p_max[GPa]   (errors of the loss)"
    )
    for group in (rows, plates):
        for row in group:
            loss = 1.0 - row.efficiency
            error = (row.efficiency - truth(group, row.torque_pinion)) / loss
            print(
                f"{row.positions:6d} {row.points_per_line:8d}   {row.terms_height:2d}x{row.terms_length:2d} "
                f"{row.torque_pinion:6.0f} {row.seconds:8.2f} {100 * loss:8.4f} {error:11.1e} "
                f"{row.efficiency_error / loss:12.1e} {row.pressure_max / 1e9:11.3f}"
            )
    with (folder / "gear_load.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(Row.__dataclass_fields__)
        writer.writerows([getattr(row, name) for name in Row.__dataclass_fields__] for row in rows + plates)

    figure = Figure(figsize=(7.0, 4.2), layout="constrained")
    axes = figure.add_subplot()
    for torque, color in zip(TORQUES, ("#1f5a99", "#c8651b"), strict=True):
        part = [row for row in rows if row.torque_pinion == torque][:-1]
        seconds = [row.seconds for row in part]
        true = [abs(row.efficiency - truth(rows, torque)) / (1.0 - row.efficiency) for row in part]
        stated = [row.efficiency_error / (1.0 - row.efficiency) for row in part]
        axes.loglog(seconds, true, "o", color=color, label=f"true, {torque:g} N m")
        axes.loglog(seconds, stated, "_", ms=12, color=color, label=f"stated, {torque:g} N m")
    axes.set(xlabel="seconds (geometry, load, loss; one core)", ylabel="error of the loss [-]")
    axes.legend(frameon=False)
    figure.savefig(folder / "gear_load.png", dpi=150)


if __name__ == "__main__":
    main()
