"""Error of each family of friction formulas against the number of contacts it was fitted to.

    python benchmarks/formula_families.py --oil fva3 --accuracy fast --sizes 32 64 128 256 --out benchmarks/out

Fits to the first n points of one Sobol sequence over the plan `gear_range`, then checks on points of another sequence
the fit never saw. Prints a table, writes formula_families_<oil>_<roughness>.csv and .png. Resumes like any sweep.
"""

from __future__ import annotations

import argparse
import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Any

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from ehl._data import data_path
from ehl.errors import ConvergenceError, InputError
from ehl.validation import validate
from regression.dataset import Dataset, columns, load_dataset
from regression.families import FAMILIES
from regression.fit import fit_formula
from regression.plan import Plan
from regression.sweep import available_jobs, sweep

matplotlib.use("Agg")


def plan_of(oil: str, roughness: str, accuracy: str, size: int, seed: int) -> Plan:
    """The plan `gear_range` with another oil, model, size and seed."""
    content: dict[str, Any] = tomllib.loads(data_path("plans", "gear_range.toml").read_text(encoding="utf-8"))
    content["sampling"] = {"size": size, "seed": seed}
    content["lubricant"] = {"oil": oil}
    content["model"] = {"accuracy": accuracy, "roughness": roughness}
    return validate(Plan, content)


def computed(plan: Plan, run: Path, jobs: int) -> Dataset:
    """The results of a plan, from disk as far as they are there."""
    report = sweep(plan, run, jobs=jobs)
    print(f"{run}: {report.converged} computed, {report.failed} failed, {report.reasons}", flush=True)
    return load_dataset(run)


def first_points(dataset: Dataset, plan: Plan, size: int) -> Dataset:
    """The rows of the first `size` points of the plan."""
    order = {round(case.contact.pressure_hertz, 3): i for i, (_, case) in enumerate(plan.cases())}
    index = dataset.frame["pressure_hertz"].round(3).map(order)
    rest = (getattr(dataset, field.name) for field in fields(dataset)[1:])
    return Dataset(dataset.frame[index < size].reset_index(drop=True), *rest)


def score(dataset: Dataset, check: Dataset, family: str, size: int) -> dict[str, Any]:
    """One row of the table."""
    formula = fit_formula(dataset, family)
    frame = check.converged
    mu = frame["friction_coefficient"].to_numpy()
    value = formula.evaluate(columns(frame))
    error = np.abs(value.mu / mu - 1.0)
    inside = ~value.outside
    covered = (mu >= value.lower) & (mu <= value.upper)
    return {
        "family": family,
        "n": size,
        "held_out_r2_log": formula.validation.r2_log,
        "held_out_mape": formula.validation.mape,
        "held_out_p95": formula.validation.p95,
        "held_out_worst": formula.validation.largest,
        "new_mape": error.mean(),
        "new_p95": np.quantile(error, 0.95),
        "new_worst": error.max(),
        "coverage": covered[inside].mean(),
        "inside": inside.mean(),
    }


def main() -> None:
    """Run the comparison."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--oil", default="fva3")
    parser.add_argument("--roughness", default="load_sharing")
    parser.add_argument("--accuracy", default="fast")
    parser.add_argument("--sizes", type=int, nargs="+", default=[32, 64, 128, 256], help="powers of two")
    parser.add_argument("--check", type=int, default=256)
    parser.add_argument("--jobs", type=int, default=available_jobs())
    parser.add_argument("--out", type=Path, default=Path("benchmarks/out"))
    options = parser.parse_args()
    name = f"formula_families_{options.oil}_{options.roughness}"
    runs = options.out / f"{name}_runs"
    model = (options.oil, options.roughness, options.accuracy)

    plan = plan_of(*model, max(options.sizes), 1)
    dataset = computed(plan, runs / "fit", options.jobs)
    check = computed(plan_of(*model, options.check, 22), runs / "check", options.jobs)
    rows = []
    for family in FAMILIES:
        for size in sorted(options.sizes):
            try:
                rows.append(score(first_points(dataset, plan, size), check, family, size))
            except (InputError, ConvergenceError) as error:
                print(f"{family}, n = {size}: {error}")
    table = pd.DataFrame(rows)
    print(table.to_string(index=False, float_format=lambda x: f"{x:.4g}"))
    table.to_csv(options.out / f"{name}.csv", index=False)

    figure, axes = plt.subplots(figsize=(6.0, 4.4), layout="constrained")
    for family, part in table.groupby("family"):
        (line,) = axes.loglog(part["n"], 100.0 * part["new_mape"], "o-", label=f"{family}: mean")
        axes.loglog(part["n"], 100.0 * part["new_p95"], "s--", color=line.get_color(), label=f"{family}: 95 %")
    axes.set(xlabel="contacts fitted to", ylabel="relative error on new contacts [%]")
    axes.set_xticks(sorted(options.sizes), [str(size) for size in sorted(options.sizes)], minor=False)
    axes.set_yticks([1, 2, 5, 10, 20, 50, 100], ["1", "2", "5", "10", "20", "50", "100"], minor=False)
    axes.minorticks_off()
    figure.legend(loc="outside upper center", ncols=3, fontsize="small")
    figure.savefig(options.out / f"{name}.png", dpi=130)


if __name__ == "__main__":
    main()
