"""Error of each family of friction formulas: held out by whole cells, and against the number of contacts fitted to.

    python validation/formula_families.py gear_75w90 gear_fva3
    python validation/formula_families.py RUN --sizes 64 128 256 512 1024

A RUN is a folder or file of results, or a shipped dataset. The first table is that of `mixed-ehl fit`: ten folds of
whole (p, R) cells, all cases and by bands of the film ratio (`regression.fitting.cross_validation`). With `--sizes` the
rows, which come sorted by key, a hash, and so in random order, are fitted from the first on, and the last `--check` are
predicted, which no fit has seen. Writes
formula_families_<plan>.csv, with `--sizes` also the same with _sizes.csv and
_sizes.png. Beside the errors stands what the solver states for the same contacts (median of its bound).
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from common import OUT, command_line

from ehl.common.errors import ConvergenceError, InputError
from regression.data.dataset import columns, load_dataset
from regression.fitting.coefficients import fit_coefficients
from regression.fitting.cross_validation import cross_validate
from regression.fitting.rows import usable_rows
from regression.friction.conditions import Array
from regression.friction.families import FAMILIES

matplotlib.use("Agg")

BANDS = (0.0, 0.5, 1.0, 2.0, np.inf)


def errors(family: str, fitted: int, frame: pd.DataFrame, mu: Array, seconds: float) -> list[dict[str, Any]]:
    """Rows of a table: predicted against computed friction for all cases, then each band of the film ratio."""
    computed = frame["friction_coefficient"].to_numpy()
    error = np.abs(mu / computed - 1.0)
    ratio, stated = frame["film_ratio"].to_numpy(), frame["friction_error"].to_numpy()
    rows = []
    for low, high in ((0.0, np.inf), *itertools.pairwise(BANDS)):
        inside = (ratio >= low) & ((ratio < high) | (high == np.inf))
        if inside.any():
            rows.append(
                {
                    "family": family,
                    "n": fitted,
                    "lambda_from": low,
                    "lambda_to": high,
                    "checked": int(inside.sum()),
                    "mape": error[inside].mean(),
                    "p95": np.quantile(error[inside], 0.95),
                    "worst": error[inside].max(),
                    "bias": np.mean(mu[inside] / computed[inside] - 1.0),
                    "stated": np.nanmedian(stated[inside]),
                    "seconds": seconds,
                }
            )
    return rows


def held_out(family: str, frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Errors with whole cells left out."""
    begin = time.process_time()
    mu = cross_validate(FAMILIES[family], frame).mu
    return errors(family, len(frame), frame, mu, time.process_time() - begin)


def first_rows(family: str, frame: pd.DataFrame, size: int, check: pd.DataFrame) -> list[dict[str, Any]]:
    """Errors at `check` of a fit to the first rows."""
    fitted = frame.iloc[:size].reset_index(drop=True)
    boundary = float(fitted["boundary_friction"].iloc[0])
    begin = time.process_time()
    coefficients = fit_coefficients(FAMILIES[family], fitted, boundary)
    seconds = time.process_time() - begin
    mu = np.exp(FAMILIES[family].log_mu(columns(check), coefficients.values, boundary))
    return errors(family, size, check, mu, seconds)


def tabulate(rows: list[dict[str, Any]], path: Path) -> pd.DataFrame:
    """Print a table and write it."""
    table = pd.DataFrame(rows)
    print(table.to_string(index=False, float_format=lambda x: f"{x:.4g}"), flush=True)
    table.to_csv(path, index=False)
    return table


def plot_sizes(table: pd.DataFrame, path: Path) -> None:
    """Error over the number of contacts, all film ratios together."""
    figure, axes = plt.subplots(figsize=(6.0, 4.4), layout="constrained")
    for family, part in table[table["lambda_to"].eq(np.inf) & table["lambda_from"].eq(0.0)].groupby("family"):
        (line,) = axes.loglog(part["n"], 100.0 * part["mape"], "o-", label=f"{family}: mean")
        axes.loglog(part["n"], 100.0 * part["p95"], "s--", color=line.get_color(), label=f"{family}: 95 %")
    axes.set(xlabel="contacts fitted to", ylabel="relative error on new contacts [%]")
    axes.set_yticks([1, 2, 5, 10, 20, 50, 100], ["1", "2", "5", "10", "20", "50", "100"], minor=False)
    axes.minorticks_off()
    figure.legend(loc="outside upper center", ncols=3, fontsize="small")
    figure.savefig(path, dpi=130)
    plt.close(figure)


def main(argv: Sequence[str] | None = None) -> None:
    """Run the comparison."""
    parser = command_line(__doc__)
    parser.add_argument("runs", nargs="+")
    parser.add_argument("--sizes", type=int, nargs="+", default=[])
    parser.add_argument("--check", type=int, default=256)
    parser.add_argument("--families", nargs="+", default=list(FAMILIES), choices=list(FAMILIES))
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args(argv)
    options.out.mkdir(parents=True, exist_ok=True)
    for run in options.runs:
        dataset = load_dataset(run)
        frame, excluded = usable_rows(dataset, corners=False)
        name = options.out / f"formula_families_{dataset.plan_name}"
        print(f"{run}: {len(frame)} cases; left out: {excluded}")
        tabulate([row for family in options.families for row in held_out(family, frame)], name.with_suffix(".csv"))
        check, rest = frame.iloc[-options.check :].reset_index(drop=True), frame.iloc[: -options.check]
        rows = []
        for family, size in itertools.product(options.families, sorted({min(n, len(rest)) for n in options.sizes})):
            try:
                rows += first_rows(family, rest, size, check)
            except (InputError, ConvergenceError) as error:
                print(f"{family}, n = {size}: {error}")
        if rows:
            table = tabulate(rows, name.with_name(name.name + "_sizes.csv"))
            plot_sizes(table, name.with_name(name.name + "_sizes.png"))


if __name__ == "__main__":
    main()
