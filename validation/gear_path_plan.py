"""Contacts along the meshes of the shipped gear pairs, as the table of a plan: what a fitted formula is checked with.

    python validation/gear_path_plan.py data/datasets/gear_paths.csv

Each pair runs at its own torque and at half of it, at its own speed and, with oil 30 K hotter, at a third of it. The
points of a mesh are taken in the order of the path, equally spaced in the work friction takes there: the table weighs
like the loss does. Behind the columns of the plan stand pair, operating point and the loss in percent of the input if
mu were 1. Points outside the ranges of the dataset `gear_75w90` are left out and counted.
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
from regression.data.dataset import dataset_plan

SHIPPED = (
    "fm_spiral_bevel_14x39",
    "fm_hypoid_13x42",
    "fh_hypoid_9x34",
    "fh_hypoid_9x34_offset_10",
    "fh_spiral_bevel_12x37",
)
HOTTER = 30.0  # [K]
POINTS = 10  # of each mesh at each operating point
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


def path_points(name: str) -> pd.DataFrame:
    """Points of one pair, SI units; `outside` is the share of the work outside the ranges of `gear_75w90`."""
    pair = efficiency.load(name)
    design = pair.design
    torque, speed, oil = design.operation.torque, design.operation.speed, design.operation.temperature
    duty = [
        DutyRow(t, s, hot, 1.0)
        for t in (torque, 0.5 * torque)
        for s, hot in ((speed, oil), (speed / 3.0, oil + HOTTER))
    ]
    ranges = dataset_plan("gear_75w90").axes
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


def main(argv: Sequence[str] | None = None) -> None:
    parser = command_line(__doc__)
    parser.add_argument("file", type=Path)
    file = parser.parse_args(argv).file
    table = pd.concat([path_points(name) for name in SHIPPED], ignore_index=True)
    print(table.groupby("design")[["outside"]].max())
    scale = {"pressure_hertz": 1e-9, "radius_equivalent": 1e3, "roughness_rms": 1e6, "correlation_length": 1e6}
    written = pd.DataFrame({head: table[name] * scale.get(name, 1.0) for name, head in COLUMNS.items()})
    written[COLUMNS["temperature_oil"]] -= KELVIN
    for note in ("design", "state", "loss"):
        written[f"# {note}"] = table[note]
    written.to_csv(file, index=False, float_format="%.6g")
    print(f"{len(table)} contacts")


if __name__ == "__main__":
    main()
