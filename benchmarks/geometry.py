"""Cost and error of the unloaded contact: time against the grid of the map, flank points, misalignment studies.

``python benchmarks/geometry.py [FOLDER]`` prints two tables and writes geometry.csv and geometry.png. The error is that
of the transmission error and of the contact path against direct tangency of both flanks in space, over 0.7 pitches to
both sides of the highest point. Times are CPU seconds of one core after a first run.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from common import OUT, command_line, write_rows
from matplotlib.figure import Figure

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from direct_tangency import check_path

from efficiency.contact.contact_lines import mesh_cycle
from efficiency.contact.flank_grid import SHAPE
from efficiency.contact.flank_pair import flank_pair
from efficiency.contact.gear_flanks import Side
from efficiency.contact.mesh_surface import mesh_surface
from efficiency.contact.transmission import contact_path
from efficiency.design.design import Design, load_design
from efficiency.geometry.misalignment import misalignment_study
from ehl.common.data import data_names

SHAPES = ((6, 5), (9, 7), (13, 10), SHAPE, (24, 18))
SIDES: tuple[Side, ...] = ("drive", "coast")
ARCSEC = np.pi / (180.0 * 3600.0)


@dataclass(frozen=True)
class Row:
    """One design, side and grid."""

    design: str
    side: str
    coefficients: str
    seconds_map: float
    seconds_contact: float
    seconds_pattern: float
    error_estimate_nm: float
    error_arcsec: float
    error_path_um: float
    undercut_percent: float


def seconds(work: Callable[[], object], repeats: int = 2) -> float:
    """Least CPU time of some runs."""
    times = []
    for _ in range(repeats):
        clock = time.process_time()
        work()
        times.append(time.process_time() - clock)
    return min(times)


def measure(design: Design, side: Side, shape: tuple[int, int]) -> Row:
    """Time and error of one map."""
    pinion, gear = design.flanks().mating(side)
    assembly = design.placement()
    surface = mesh_surface(gear, pinion, assembly, shape=shape)
    path = contact_path(surface, surface.error_maximum_roll + np.linspace(-0.7, 0.7, 7) * surface.pitch)
    check = check_path(surface, path)
    pair = flank_pair(design.flanks(), side, shape)
    return Row(
        design.name,
        side,
        f"{shape[0]} x {shape[1]}",
        seconds(lambda: mesh_surface(gear, pinion, assembly, shape=shape)),
        seconds(lambda: flank_pair(design.flanks(), side, shape)),
        seconds(pair.pattern),
        surface.interpolation_error * 1e9,
        check.transmission_error / ARCSEC,
        check.distance * 1e6,
        100.0 * surface.undercut.share if surface.undercut is not None else 0.0,
    )


def flank_points(design: Design) -> float:
    """Seconds for both flanks of both members at 31 x 15 points."""
    flanks = [design.flank(member, side) for member in ("pinion", "gear") for side in ("concave", "convex")]

    def work() -> None:
        for flank in flanks:
            u, v = (g.ravel() for g in np.meshgrid(np.linspace(-0.5, 0.5, 31), np.linspace(0.15, 1.0, 15)))
            u = u * flank.blank.face_width
            flank.solve(u, flank.blank.height(u, v))

    return seconds(work)


def main(argv: Sequence[str] | None = None) -> None:
    """Run everything."""
    parser = command_line(__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=OUT)
    folder = parser.parse_args(argv).folder
    folder.mkdir(parents=True, exist_ok=True)
    designs = [load_design(name) for name in data_names("designs")]
    flank_pair(designs[0].flanks())

    rows = []
    print("map [s], whole unloaded analysis [s], pattern [s], estimated and true error")
    for design, side, shape in product(designs, SIDES, SHAPES):
        row = measure(design, side, shape)
        rows.append(row)
        print(
            f"{row.design:28} {row.side:5} {row.coefficients:8} {row.seconds_map:7.3f} {row.seconds_contact:7.3f} "
            f"{row.seconds_pattern:7.3f}   {row.error_estimate_nm:9.2e} nm {row.error_arcsec:9.2e} arcsec "
            f"{row.error_path_um:9.2e} um   undercut {row.undercut_percent:.2f} %",
            flush=True,
        )

    print("\nflanks of both members at 31 x 15 points [s]; unloaded analysis with 24 x 31 contact lines [s]; study [s]")
    steps = np.linspace(-1e-4, 1e-4, 10)
    for design in designs:
        lines = seconds(lambda chosen=design: mesh_cycle(flank_pair(chosen.flanks()).surface, 24, 31))
        study = seconds(lambda chosen=design: misalignment_study(chosen, E=steps, P=steps), 1)
        print(f"{design.name:28} {flank_points(design):7.3f} {lines:7.3f}   100 points {study:6.2f}", flush=True)

    write_rows(folder / "geometry.csv", rows)
    figure = Figure(figsize=(7.0, 4.5), layout="constrained")
    axes = figure.add_subplot()
    for design in designs:
        for side, marker in zip(SIDES, ("o-", "s--"), strict=True):
            own = [row for row in rows if row.design == design.name and row.side == side]
            times, errors = [row.seconds_contact for row in own], [row.error_arcsec for row in own]
            axes.loglog(times, errors, marker, label=f"{design.name}, {side}")
    axes.axhline(0.1, color="0.5", lw=0.8)
    axes.set(xlabel="unloaded analysis [s]", ylabel="error of the transmission error [arcsec]")
    axes.legend(fontsize=7)
    figure.savefig(folder / "geometry.png", dpi=150)


if __name__ == "__main__":
    main()
