"""Friction networks along the meshes of gear pairs and at states that no shipped data were chosen with.

    python -m validation other_pairs                # three oils, each contact with four roughness profiles
    python -m validation other_pairs pg_0_1 --jobs 2

The pairs are those of `PAIRS` at the operating points of `STATES`, five points of each mesh spaced equally in friction
work. The truth of a contact is the mean over its profiles. A run is resumed from its folder in validation/out.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from common import OUT, command_line, one_of, write_rows
from gear_path_plan import path_points, write_table
from shipped_formulas import OILS, within_scatter

import regression
from regression.data.dataset import columns, load_dataset
from regression.fitting.rows import checkable_rows, computed_friction, expected_rows

PAIRS = ("fm_hypoid_13x37_relieved", "tp_spiral_bevel_12x37_relieved", "eaxle_helical_23x75")
# torque over that of the design, speed of the pinion [rpm], oil temperature [degC]
STATES = (
    (0.75, 250.0, 60.0),
    (0.35, 800.0, 105.0),
    (1.0, 3000.0, 75.0),
    (0.5, 10_000.0, 80.0),
    (0.15, 14_000.0, 110.0),
)  # fmt: skip


def errors(oil: str, jobs: int | None) -> dict[str, object]:
    """Mean and 95 % quantile of the error of mu, bias, and share of the contacts inside the interval.

    `widened`: inside the interval with the scatter of the mean over the profiles.
    """
    folder = OUT / "other_pairs"
    folder.mkdir(parents=True, exist_ok=True)
    table = folder / "points.csv"
    if not table.exists():
        write_table(table, pd.concat([path_points(name, STATES) for name in PAIRS], ignore_index=True))
    changes = [f"lubricant.oil={oil}", f"table.file={table.resolve()}", "sampling.realisations=4", "sampling.seed=77"]
    run = regression.sweep(regression.Plan.from_file("gear_paths", changes), folder / oil, jobs=jobs)
    target = folder / f"{oil}.h5"
    target.unlink(missing_ok=True)
    run.merge(target, complete=True)
    frame = expected_rows(checkable_rows(load_dataset(target).frame))
    truth, found = computed_friction(frame), regression.Formula.load(oil).evaluate(columns(frame))
    error = found.mu / truth - 1.0
    return {
        "oil": oil, "contacts": len(frame), "mean": np.abs(error).mean(), "p95": np.quantile(np.abs(error), 0.95),
        "bias": error.mean(), "covered": np.mean((found.lower <= truth) & (truth <= found.upper)),
        "widened": np.mean(within_scatter(found, frame)),
    }  # fmt: skip


def main(argv: Sequence[str] | None = None) -> None:
    """Print and write the errors of each oil."""
    parser = command_line(__doc__)
    parser.add_argument("oils", nargs="*", type=one_of(OILS), default=["75w90", "fva3", "pao220"])
    parser.add_argument("--jobs", type=int)
    options = parser.parse_args(argv)
    rows = []
    for oil in options.oils:
        rows.append(errors(oil, options.jobs))
        print("  ".join(f"{v:.3f}" if isinstance(v, float) else str(v) for v in rows[-1].values()), flush=True)
    write_rows(OUT / "other_pairs.csv", rows)


if __name__ == "__main__":
    main()
