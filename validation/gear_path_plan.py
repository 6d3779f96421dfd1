"""Contacts along the meshes of gear pairs, as tables of plans.

    python validation/gear_path_plan.py data/plans/gear_paths.csv         # five pairs: what formulas are checked with
    python validation/gear_path_plan.py data/plans --random 900 --seed 1  # `gear_pairs`: what they are fitted to

Each pair runs at the operating points of `STATES`: half of them slow with hot oil, half from 1500 to 20 000 rpm. The
points of a mesh are taken in the order of the path, equally spaced in the work friction takes there: the table weighs
like the loss does. Behind the columns of the plan stand pair, operating point and the loss in percent of the input if
mu were 1. Points outside the ranges of the plan `gear` are left out and counted.

With `--random` contacts are added to the table of each oil, from the meshes of `RANDOM_PAIRS`, drawn in proportion to
the work of friction, with size, speed, temperature and finish of their own. The shipped tables hold 900 draws from
0.1 m/s (seed 70 000), 900 from 3 m/s (80 000) and 500 of large gears (90 000, `--slowest 20 --size 2 5`), without those
outside the range of `gear`.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from common import command_line
from shipped_formulas import OILS

import efficiency
from efficiency.conditions.duty import DutyRow
from ehl.common.units import KELVIN
from regression.plan.plan import Plan

SHIPPED = (
    "fm_spiral_bevel_14x39",
    "fm_hypoid_13x42",
    "fh_hypoid_9x34",
    "fh_hypoid_9x34_offset_10",
    "fh_spiral_bevel_12x37",
)
# torque over that of the design, speed of the pinion [rpm], oil temperature [degC]
STATES = (
    (1.0, 100.0, 120.0),
    (0.5, 100.0, 120.0),
    (1.0, 400.0, 120.0),
    (0.5, 400.0, 120.0),
    (1.0, 1500.0, 90.0),
    (0.5, 6000.0, 90.0),
    (0.25, 16_000.0, 90.0),
    (0.25, 20_000.0, 90.0),
)
POINTS = 5  # of each mesh at each operating point
# none of `other_pairs`, which checks the formulas
RANDOM_PAIRS = (*(f"{name}_relieved" for name in SHIPPED), "fzg_c14", "fzg_h501", "fzg_h951")
PARTS = (0.1, 0.2, 0.35, 0.6, 1.0, 1.4)  # of the torque of the design
COLUMNS = {
    "pressure_hertz": "pressure_hertz [GPa]",
    "radius_equivalent": "radius_equivalent [mm]",
    "speed_entrainment": "speed_entrainment [m/s]",
    "slide_to_roll": "slide_to_roll",
    "lengthwise_to_roll": "lengthwise_to_roll",
    "temperature_oil": "temperature_oil [degC]",
    "roughness_rms": "roughness_rms [um]",
    "correlation_length": "correlation_length [um]",
    "peklenik_number": "peklenik_number",
}


def path_points(name: str, states: Sequence[tuple[float, float, float]] = STATES) -> pd.DataFrame:
    """Points of one pair, SI units; `outside` is the share of the work outside the ranges of the plan `gear`."""
    pair = efficiency.load(name)
    design = pair.design
    duty = [DutyRow(part * design.operation.torque, rpm * np.pi / 30.0, oil + KELVIN, 1.0) for part, rpm, oil in states]
    ranges = Plan.from_file("gear").axes
    tables = []
    for points, row in zip(pair.duty_points(duty), duty, strict=True):
        state = points.state
        table = pd.DataFrame({name: np.asarray(getattr(state, name)) for name in COLUMNS if hasattr(state, name)})
        table["lengthwise_to_roll"] = np.abs(state.speed_sliding_lengthwise) / state.speed_entrainment
        inside = np.ones(len(table), dtype=bool)
        for name in ("pressure_hertz", "radius_equivalent", "speed_entrainment"):
            inside &= table[name].between(*ranges[name].values).to_numpy()
        inside &= table["lengthwise_to_roll"].to_numpy() <= ranges["lengthwise_to_roll"].values[-1]
        inside &= table["slide_to_roll"].abs().between(1e-3, ranges["slide_to_roll"].values[-1]).to_numpy()
        work = np.cumsum(points.weight * inside)
        chosen = np.searchsorted(work, work[-1] * (np.arange(POINTS) + 0.5) / POINTS)
        outside = 1.0 - work[-1] / points.weight.sum()
        labels = {
            "design": design.name,
            "state": f"{row.torque:.4g} N*m {row.speed * 30.0 / np.pi:.4g} rpm {row.temperature - KELVIN:.3g} degC",
            # power lost in percent of the input for mu = 1, all along the mesh
            "loss": 100.0 * points.weight.sum() / (row.hours * row.torque * row.speed),
            "outside": outside,
        }
        tables.append(table.iloc[np.unique(chosen)].assign(**labels))
    return pd.concat(tables, ignore_index=True)


def random_points(
    meshes: Sequence[tuple[np.ndarray, np.ndarray]], count: int, slowest: float, size: Sequence[float], seed: int
) -> pd.DataFrame:
    """Contacts drawn from meshes, SI units.

    slowest: least entrainment speed [m/s].
    size: range of the factor of the radius.
    meshes: weights of the points and their pressure, radius, sliding across and along over entrainment, and Peklenik
        number, shape (5, points).
    """
    random, ranges = np.random.default_rng(seed), Plan.from_file("gear").axes
    rows = []
    for mesh in random.integers(len(meshes), size=count):
        weight, values = meshes[mesh]
        rows.append(values[:, random.choice(weight.size, p=weight / weight.sum())])
    names = ("pressure_hertz", "radius_equivalent", "slide_to_roll", "lengthwise_to_roll", "peklenik_number")
    table = pd.DataFrame(rows, columns=names)

    def drawn(low: float, high: float) -> np.ndarray:
        return np.exp(random.uniform(np.log(low), np.log(high), count))

    table["radius_equivalent"] *= drawn(*size)
    table["peklenik_number"] *= drawn(0.6, 1.6)
    table["speed_entrainment"] = drawn(slowest, 62.0)
    table["temperature_oil"] = random.uniform(35.0, 150.0, count) + KELVIN
    table["roughness_rms"] = drawn(0.15, 2.0) * 1e-6
    table["correlation_length"] = table["roughness_rms"] * drawn(15.0, 150.0)
    table["slide_to_roll"] = table["slide_to_roll"].abs()
    inside = np.logical_and.reduce([table[name].between(*ranges[name].values) for name in table])
    return table[inside]


def meshes_of(name: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """Meshes of one pair at all torques, as `random_points` takes them."""
    pair = efficiency.load(name)
    at = pair.design.operation
    duty = [DutyRow(part * at.torque, at.speed, at.temperature, 1.0) for part in PARTS]
    found = []
    for points in pair.duty_points(duty):
        state = points.state
        lengthwise = np.abs(state.speed_sliding_lengthwise) / state.speed_entrainment
        values = (state.pressure_hertz, state.radius_equivalent, state.slide_to_roll, lengthwise, state.peklenik_number)
        found.append(
            (np.ravel(points.weight), np.array([np.broadcast_to(v, points.weight.shape).ravel() for v in values]))
        )
    return found


def write_table(file: Path, table: pd.DataFrame, *, add: bool = False) -> None:
    """Points as the table of a plan, or added to one."""
    scale = {"pressure_hertz": 1e-9, "radius_equivalent": 1e3, "roughness_rms": 1e6, "correlation_length": 1e6}
    written = pd.DataFrame({head: table[name] * scale.get(name, 1.0) for name, head in COLUMNS.items()})
    written[COLUMNS["temperature_oil"]] -= KELVIN
    for note in ("design", "state", "loss"):
        if note in table:
            written[f"# {note}"] = table[note]
    written.to_csv(file, mode="a" if add else "w", header=not add, index=False, float_format="%.6g")


def main(argv: Sequence[str] | None = None) -> None:
    parser = command_line(__doc__)
    parser.add_argument("file", type=Path, help="table, or its folder with --random")
    parser.add_argument("--random", type=int, help="contacts drawn for each oil")
    parser.add_argument("--slowest", type=float, default=0.1, help="least entrainment speed of those [m/s]")
    parser.add_argument("--size", type=float, nargs=2, default=(0.7, 3.0), help="range of their size over the design's")
    parser.add_argument("--seed", type=int, default=1)
    selected = parser.parse_args(argv)
    file = selected.file
    if selected.random:
        meshes = [mesh for name in RANDOM_PAIRS for mesh in meshes_of(name)]
        for number, oil in enumerate(OILS):
            table = random_points(meshes, selected.random, selected.slowest, selected.size, selected.seed + number)
            path = file / f"gear_pairs_{oil}.csv"
            write_table(path, table, add=path.exists())
            print(f"{oil}: {len(table)} contacts")
        return
    table = pd.concat([path_points(name) for name in SHIPPED], ignore_index=True)
    print(table.groupby("design")[["outside"]].max())
    write_table(file, table)
    print(f"{len(table)} contacts")


if __name__ == "__main__":
    main()
