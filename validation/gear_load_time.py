"""CPU seconds of the gear side over mesh positions and over map points: docs/figures/gear_load_time.png."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from common import command_line, write_rows
from matplotlib.figure import Figure

import efficiency

DESIGNS = ("fm_spiral_bevel_14x39", "fh_hypoid_9x34")
FRICTION = "xu_kahraman_2007"
POSITIONS, POINTS = (12, 24, 48, 96), (20, 80, 200, 400)


def seconds(task: Callable[[], Any], repeats: int = 5) -> float:
    """Median CPU seconds of a task."""
    found = []
    for _ in range(repeats):
        started = time.process_time()
        task()
        found.append(time.process_time() - started)
    return float(np.median(found))


def rows_of(name: str) -> list[dict[str, Any]]:
    """Whole pair over mesh positions, and maps over their points with the geometry known."""
    pair, share = efficiency.load(name), np.linspace(0.1, 1.5, 20)
    mesh = pair.mesh()
    mesh.load()

    def whole(positions: int) -> Any:
        return efficiency.load(name).mesh(positions=positions).load().efficiency(FRICTION)

    def grid(points: int) -> Any:
        torques = (200.0 * share[: points // 20]).tolist()
        return mesh.over(FRICTION, torque=torques, speed=(150.0 * share).tolist())

    parts = (("mesh positions", POSITIONS, whole), ("map points", POINTS, grid))
    return [
        {"design": name, "over": over, "size": size, "seconds": seconds(lambda: task(size))}  # noqa: B023
        for over, sizes, task in parts
        for size in sizes
    ]


def main(argv: Sequence[str] | None = None) -> None:
    """Measure and draw."""
    parser = command_line(__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs/figures"))
    folder = parser.parse_args(argv).out
    rows = [row for name in DESIGNS for row in rows_of(name)]
    write_rows(folder / "gear_load_time.csv", rows)
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    for axes, over in zip(figure.subplots(1, 2), ("mesh positions", "map points"), strict=True):
        for name in DESIGNS:
            own = [row for row in rows if row["design"] == name and row["over"] == over]
            axes.loglog([row["size"] for row in own], [row["seconds"] for row in own], "o-", label=name)
        axes.set(xlabel=over, ylabel="CPU seconds")
        axes.legend(frameon=False, fontsize=8)
    figure.savefig(folder / "gear_load_time.png", dpi=130)


if __name__ == "__main__":
    main()
