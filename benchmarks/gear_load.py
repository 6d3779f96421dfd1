"""Cost and error of the gear stage: positions, points per line and polynomial orders of the teeth.

``python benchmarks/gear_load.py [FOLDER]`` prints a table and writes gear_load.csv and gear_load.png. The truth is the
finest computation of the table; the orders are varied on the default grid.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from common import OUT, command_line, write_rows
from matplotlib.figure import Figure

from efficiency.contact.gear_flanks import MEMBERS
from efficiency.design.design import load_design
from efficiency.loss.efficiency import MeshGrids, load_grids, mesh_efficiency
from efficiency.loss.kinematics import Operation
from efficiency.ltca.ritz_solid import ORDERS
from efficiency.ltca.solid_tooth import solid_tooth_of
from efficiency.pair import Mesh
from ehl.fluid.oil import Oil
from regression.formula import friction_model

DESIGN = "fm_spiral_bevel_14x39"
GRIDS = ((4, 9), (8, 9), (8, 15), (12, 15), (12, 31), (24, 31), (24, 61), (48, 61), (48, 121))
FACTORS = (0.5, 0.7, 1.0, 1.3, 1.6)
TORQUES = (30.0, 300.0)


@dataclass(frozen=True)
class Row:
    """One computation."""

    positions: int
    points_per_line: int
    order_height: int
    order_length: int
    torque: float
    seconds: float
    efficiency: float
    efficiency_error: float
    pressure_max: float


def measure(mesh: MeshGrids, grid: tuple[int, int], orders: tuple[int, int], geometry_seconds: float) -> list[Row]:
    """Efficiency with a published friction formula at both torques."""
    design = load_design(DESIGN)
    model, oil = friction_model("xu_kahraman_2007"), Oil.load("75w90")
    operation = Operation(design.operation.speed, design.operation.temperature, 0.4e-6, 0.4e-6)
    rows = []
    for torque in TORQUES:
        clock = time.perf_counter()
        result = mesh_efficiency(load_grids(mesh, torque), model, oil, operation)
        seconds = geometry_seconds + time.perf_counter() - clock
        rows.append(
            Row(*grid, *orders, torque, seconds, result.efficiency, result.efficiency_error, result.pressure_max)
        )
    return rows


def with_orders(mesh: MeshGrids, factor: float) -> MeshGrids:
    """The same mesh with other polynomial orders of the teeth."""
    flanks, bodies = load_design(DESIGN).flanks(), load_design(DESIGN).tooth_bodies()
    pinion, gear = (
        solid_tooth_of(flanks, body, member, "drive", ORDERS.scaled(factor))
        for member, body in zip(MEMBERS, bodies, strict=True)
    )
    return replace(mesh, teeth=replace(mesh.teeth, pinion=pinion, gear=gear))


def main(argv: Sequence[str] | None = None) -> None:
    """Run all computations."""
    parser = command_line(__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=OUT)
    folder = parser.parse_args(argv).folder
    folder.mkdir(parents=True, exist_ok=True)
    design = load_design(DESIGN)
    rows: list[Row] = []
    for grid in GRIDS:
        clock = time.perf_counter()
        mesh = Mesh.of(design, "drive", *grid).grids
        rows += measure(mesh, grid, ORDERS.tooth[1:], time.perf_counter() - clock)
    default = Mesh.of(design, "drive", 24, 31).grids
    teeth = [
        row
        for factor in FACTORS
        for row in measure(with_orders(default, factor), (24, 31), ORDERS.scaled(factor).tooth[1:], 0.0)
    ]

    def truth(group: list[Row], torque: float) -> float:
        return [row.efficiency for row in group if row.torque == torque][-1]

    print(
        "positions points orders torque  seconds  loss[%]  true error  stated error  p_max[GPa]   (errors of the loss)"
    )
    for group in (rows, teeth):
        for row in group:
            loss = 1.0 - row.efficiency
            error = (row.efficiency - truth(group, row.torque)) / loss
            print(
                f"{row.positions:6d} {row.points_per_line:8d}   {row.order_height:2d}x{row.order_length:2d} "
                f"{row.torque:6.0f} {row.seconds:8.2f} {100 * loss:8.4f} {error:11.1e} "
                f"{row.efficiency_error / loss:12.1e} {row.pressure_max / 1e9:11.3f}"
            )
    write_rows(folder / "gear_load.csv", rows + teeth)

    figure = Figure(figsize=(7.0, 4.2), layout="constrained")
    axes = figure.add_subplot()
    for torque, color in zip(TORQUES, ("#1f5a99", "#c8651b"), strict=True):
        part = [row for row in rows if row.torque == torque][:-1]
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
