"""Formula of an oil that is in no shipped data: error over the number of its contacts that were solved.

    python -m validation own_oil pao_ester minr --sizes 32 64

The plan is that of `mixed-ehl new plan`; 64 other points with four roughness profiles each are the truth (solved once,
in validation/out/own_oil; the same command resumes). Without contacts the shipped formula `gear` stands.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from common import OUT, command_line, write_rows

import regression
from regression.data.dataset import columns, load_dataset
from regression.fitting.rows import checkable_rows, computed_friction, expected_rows

TRUTH = ["sampling.size=64", "sampling.realisations=4", "sampling.seed=4711"]


def solved(folder: Path, oil: str, name: str, changes: Sequence[str], jobs: int | None) -> Path:
    """File of the results of the plan of an oil with some changes."""
    plan, target = folder / f"{oil}.toml", folder / f"{oil}_{name}.h5"
    if target.exists():
        return target
    folder.mkdir(parents=True, exist_ok=True)
    if not plan.exists():
        program = Path(sys.executable).with_name("mixed-ehl")
        subprocess.run([program, "new", "plan", "--oil", oil, "--output", plan], check=True)
    run = regression.sweep(regression.Plan.from_file(plan, list(changes)), folder / f"{oil}_{name}", jobs=jobs)
    run.merge(target, complete=True)
    return target


def main(argv: Sequence[str] | None = None) -> None:
    """Print and write mean, 95 % and bias of the error, and the share inside the stated interval."""
    parser = command_line(__doc__)
    parser.add_argument("oils", nargs="*", default=["pao_ester", "minr"])
    parser.add_argument("--sizes", type=int, nargs="+", default=[64])
    parser.add_argument("--jobs", type=int)
    options = parser.parse_args(argv)
    rows, folder = [], OUT / "own_oil"
    for oil in options.oils:
        frame = load_dataset(solved(folder, oil, "truth", TRUTH, options.jobs)).frame
        frame = expected_rows(checkable_rows(frame))
        truth = computed_friction(frame)
        formulas = {0: regression.Formula.load("gear")}
        for size in options.sizes:
            data = solved(folder, oil, str(size), [f"sampling.size={size}"], options.jobs)
            formulas[size] = regression.fit(str(data), jobs=options.jobs)
        for size, formula in formulas.items():
            found = formula.evaluate(columns(frame))
            error = found.mu / truth - 1.0
            row = {
                "oil": oil, "contacts": size, "mean": np.abs(error).mean(), "p95": np.quantile(np.abs(error), 0.95),
                "bias": error.mean(), "covered": np.mean((found.lower <= truth) & (truth <= found.upper)),
                "held out": formula.validation.mape if size else np.nan,
            }  # fmt: skip
            print("  ".join(f"{v:.3f}" if isinstance(v, float) else str(v) for v in row.values()), flush=True)
            rows.append(row)
    write_rows(OUT / "own_oil.csv", rows)


if __name__ == "__main__":
    main()
