"""Transmission error from noisy flank grids: error, stated interval and its coverage.

    python -m validation measured_flanks [DESIGN ...] [--draws 100] [--noise 1] [--deviation 1] [--flanks both]
        [--alone] [--seed 1] [--csv FILE]

Each draw gives the drive flanks a true deviation (angles, crowning, twist and a wave over the face, ``--deviation``
times the sizes below; 0: none), reads 9 x 15 points of them with noise [um, 1 sigma] and compares the transmission
error of the smoothed flanks with that of the true ones. ``--flanks gear``: that of the pinion is known.
``--alone``: without the nominal settings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from common import command_line, write_rows
from numpy.typing import NDArray

from efficiency.contact.flank_pair import flank_pair
from efficiency.contact.grid_flank import PointGrid
from efficiency.contact.measured_flank import MeasuredFlank, measured_flank
from efficiency.cutting.flank import Flank
from efficiency.design.design import load_design
from efficiency.output.files import inspection_grid
from ehl.common.quantities import to_display

FloatArray = NDArray[np.float64]
DESIGNS = ("fm_spiral_bevel_14x39", "fm_hypoid_13x42", "fh_hypoid_9x34_offset_10")
# 1 sigma [um] of the terms x, y, x^2, x y, y^2 and of a wave, one and a half over the face
SIZES = np.array([8.0, 6.0, 3.0, 3.0, 1.5, 0.3])


@dataclass(frozen=True)
class Row:
    """One draw; transmission errors peak to peak in arc seconds."""

    design: str
    draw: int
    truth: float
    found: float
    low: float
    high: float


def points(flank: Flank, shape: tuple[int, int], sizes: FloatArray, noise: FloatArray) -> PointGrid:
    """Points of a flank with a deviation and noise, both along the normal [um]."""
    grid = inspection_grid(flank, *shape, 0.04)
    x, y = 2.0 * grid.u / flank.blank.face_width, np.linspace(-1.0, 1.0, shape[0])[:, None] + 0.0 * grid.u
    shapes = np.stack([x, y, x * x, x * y, y * y, np.sin(1.5 * np.pi * (x + 0.3 * y))])
    moved = grid.position + 1e-6 * (np.tensordot(sizes, shapes, axes=1) + noise) * grid.normal
    row, column = np.meshgrid(np.arange(1, shape[0] + 1), np.arange(1, shape[1] + 1), indexing="ij")
    return PointGrid("points", row.ravel(), column.ravel(), moved.reshape(3, -1), None, "", "")


def measure(
    name: str, draws: int, noise: float, deviation: float, members: str, alone: bool, rng: np.random.Generator
) -> list[Row]:
    """Draws of one design."""
    design = load_design(name)
    flanks = design.flanks()
    pinion, gear = flanks.mating("drive")
    rows = []
    for draw in range(draws):
        seen, true = {}, {}
        for member, flank in (("pinion", pinion), ("gear", gear)):
            if members not in ("both", member):
                continue
            sizes = deviation * SIZES * rng.standard_normal(SIZES.size)

            def smooth(grid: PointGrid, error: float, nominal: Flank | None, flank: Flank = flank) -> MeasuredFlank:
                return measured_flank(grid, flank.side, flank.blank, error, nominal)

            scatter = noise * rng.standard_normal((9, 15))
            seen[member] = smooth(points(flank, (9, 15), sizes, scatter), noise * 1e-6, None if alone else flank)
            if deviation > 0.0:
                true[member] = smooth(points(flank, (11, 19), sizes, np.zeros((11, 19))), 1e-8, flank)
        results = []
        for both in (true, seen):
            pair = replace(
                flanks,
                pinion={**flanks.pinion, pinion.side: both.get("pinion", pinion)},
                gear={**flanks.gear, gear.side: both.get("gear", gear)},
            )
            results.append(flank_pair(pair, "drive").transmission)
        truth, found = results
        assert found.interval is not None
        values = (truth.peak_to_peak, found.peak_to_peak, *found.interval)
        rows.append(Row(name, draw, *(float(to_display("transmission_error", x)) for x in values)))
    return rows


def main(argv: Sequence[str] | None = None) -> None:
    """Run and print."""
    parser = command_line(__doc__)
    parser.add_argument("designs", nargs="*", default=DESIGNS)
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--noise", type=float, default=1.0)
    parser.add_argument("--deviation", type=float, default=1.0)
    parser.add_argument("--flanks", choices=("both", "gear", "pinion"), default="both")
    parser.add_argument("--alone", action="store_true")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--csv", type=Path)
    arguments = parser.parse_args(argv)
    rng, rows = np.random.default_rng(arguments.seed), []
    for name in arguments.designs:
        own = measure(
            name, arguments.draws, arguments.noise, arguments.deviation, arguments.flanks, arguments.alone, rng
        )
        error = np.array([row.found - row.truth for row in own])
        inside = sum(row.low <= row.truth <= row.high for row in own)
        width = np.mean([row.high - row.low for row in own])
        print(
            f"{name:28s} mean error {error.mean():+.2f}, standard deviation {error.std():.2f}, largest "
            f"{np.abs(error).max():.2f} arcsec; interval {width:.2f} wide holds the truth in {inside} of {len(own)}",
            flush=True,
        )
        rows += own
    if arguments.csv is not None:
        write_rows(arguments.csv, rows)


if __name__ == "__main__":
    main()
