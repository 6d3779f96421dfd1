"""Contacts along the meshes of the shipped gear pairs, as the table of a plan: what a fitted formula is checked with.

    python validation/gear_path_plan.py data/plans/gear_paths.csv

Each pair runs at the operating points of `STATES`: half of them slow with hot oil, half from 1500 to 20 000 rpm. The
points of a mesh are taken in the order of the path, equally spaced in the work friction takes there: the table weighs
like the loss does. Behind the columns of the plan stand pair, operating point and the loss in percent of the input if
mu were 1. Points outside the ranges of the plan `gear` are left out and counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from common import command_line

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


def write_table(file: Path, table: pd.DataFrame) -> None:
    """Points as the table of a plan."""
    scale = {"pressure_hertz": 1e-9, "radius_equivalent": 1e3, "roughness_rms": 1e6, "correlation_length": 1e6}
    written = pd.DataFrame({head: table[name] * scale.get(name, 1.0) for name, head in COLUMNS.items()})
    written[COLUMNS["temperature_oil"]] -= KELVIN
    for note in ("design", "state", "loss"):
        written[f"# {note}"] = table[note]
    written.to_csv(file, index=False, float_format="%.6g")


def main(argv: Sequence[str] | None = None) -> None:
    parser = command_line(__doc__)
    parser.add_argument("file", type=Path)
    file = parser.parse_args(argv).file
    table = pd.concat([path_points(name) for name in SHIPPED], ignore_index=True)
    print(table.groupby("design")[["outside"]].max())
    write_table(file, table)
    print(f"{len(table)} contacts")


if __name__ == "__main__":
    main()
