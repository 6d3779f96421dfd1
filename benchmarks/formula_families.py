"""Error of each family of friction formulas against the number of contacts it was fitted to.

    python benchmarks/formula_families.py RUN --sizes 64 128 256 512 1024 --out benchmarks/out

RUN is the result file or folder of a sweep. Its rows come sorted by key, a hash, so that the first n are a random
sample of the plan; they are fitted and the last `--check` are predicted, which no fit has seen. Prints a table of all
and of the bands of the film ratio, writes formula_families_<plan>.csv and .png. Beside the errors stands what the
solver states for the same contacts (median of the 90 % bound), below which no formula can be judged.
"""

from __future__ import annotations

import argparse
import itertools
import time
from pathlib import Path
from typing import Any

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from ehl.errors import ConvergenceError, InputError
from regression.coefficients import fit_coefficients
from regression.dataset import columns, load_dataset
from regression.families import FAMILIES
from regression.fit import usable_rows

matplotlib.use("Agg")

BANDS = (0.0, 0.5, 1.0, 2.0, np.inf)


def score(family: str, fitted: pd.DataFrame, check: pd.DataFrame) -> list[dict[str, Any]]:
    """Rows of the table: all cases, then each band of the film ratio."""
    boundary = float(fitted["boundary_friction"].iloc[0])
    begin = time.process_time()
    coefficients = fit_coefficients(FAMILIES[family], fitted, boundary)
    seconds = time.process_time() - begin
    log_mu = FAMILIES[family].log_mu(columns(check), coefficients.values, boundary)
    error = np.abs(np.exp(log_mu) / check["friction_coefficient"].to_numpy() - 1.0)
    ratio, stated = check["film_ratio"].to_numpy(), check["friction_error"].to_numpy()
    rows = []
    for low, high in ((0.0, np.inf), *itertools.pairwise(BANDS)):
        inside = (ratio >= low) & ((ratio < high) | (high == np.inf))
        if inside.any():
            rows.append(
                {
                    "family": family,
                    "n": len(fitted),
                    "lambda_from": low,
                    "lambda_to": high,
                    "checked": int(inside.sum()),
                    "mape": error[inside].mean(),
                    "p95": np.quantile(error[inside], 0.95),
                    "worst": error[inside].max(),
                    "stated": np.nanmedian(stated[inside]),
                    "seconds": seconds,
                }
            )
    return rows


def main() -> None:
    """Run the comparison."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path)
    parser.add_argument("--sizes", type=int, nargs="+", default=[64, 128, 256, 512, 1024])
    parser.add_argument("--check", type=int, default=256)
    parser.add_argument("--families", nargs="+", default=list(FAMILIES), choices=list(FAMILIES))
    parser.add_argument("--out", type=Path, default=Path("benchmarks/out"))
    options = parser.parse_args()
    dataset = load_dataset(options.run)
    frame, _ = usable_rows(dataset, corners=False)
    check = frame.iloc[-options.check :].reset_index(drop=True)
    rest = frame.iloc[: -options.check]
    name = f"formula_families_{dataset.plan_name}"
    rows = []
    for family in options.families:
        for size in sorted({min(size, len(rest)) for size in options.sizes}):
            try:
                rows += score(family, rest.iloc[:size].reset_index(drop=True), check)
            except (InputError, ConvergenceError) as error:
                print(f"{family}, n = {size}: {error}")
    table = pd.DataFrame(rows)
    print(table.to_string(index=False, float_format=lambda x: f"{x:.4g}"))
    options.out.mkdir(parents=True, exist_ok=True)
    table.to_csv(options.out / f"{name}.csv", index=False)

    figure, axes = plt.subplots(figsize=(6.0, 4.4), layout="constrained")
    for family, part in table[table["lambda_to"].eq(np.inf) & table["lambda_from"].eq(0.0)].groupby("family"):
        (line,) = axes.loglog(part["n"], 100.0 * part["mape"], "o-", label=f"{family}: mean")
        axes.loglog(part["n"], 100.0 * part["p95"], "s--", color=line.get_color(), label=f"{family}: 95 %")
    axes.set(xlabel="contacts fitted to", ylabel="relative error on new contacts [%]")
    axes.set_yticks([1, 2, 5, 10, 20, 50, 100], ["1", "2", "5", "10", "20", "50", "100"], minor=False)
    axes.minorticks_off()
    figure.legend(loc="outside upper center", ncols=3, fontsize="small")
    figure.savefig(options.out / f"{name}.png", dpi=130)


if __name__ == "__main__":
    main()
