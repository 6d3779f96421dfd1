"""Time against error of every way to the friction of a contact: short form, networks, process, solver.

    python -m validation friction_work --out docs/figures

On the points of the shipped data that were never fitted; the truth is the mean over the eight roughness profiles of a
point. The Gaussian process corrects the short form, from the contacts and the inputs of the networks; its length scales
are fitted to a part of the contacts. A contact of the solver (accuracy "fast", one profile) is compared with the
other profiles.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from common import OUT, command_line, write_rows
from numpy.typing import NDArray
from shipped_formulas import DATA, FITTED, OILS
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

import regression
from regression.data.dataset import columns, load_dataset
from regression.fitting.rows import checkable_rows, computed_friction, expected_rows
from regression.friction.conditions import GROUPS
from regression.friction.network import INPUTS

matplotlib.use("Agg")

Values = NDArray[np.float64]
FIRST, MOST = 1000, 14_000  # contacts for the length scales of the process and for itself, whose matrix is dense
REPEATS = 5


def rows_of(oil: str, kind: str) -> pd.DataFrame:
    """Contacts of a shipped dataset."""
    return checkable_rows(load_dataset(DATA / "datasets" / f"gear_{oil}{kind}.h5").frame)


def inputs(frame: pd.DataFrame) -> Values:
    """Logarithms of the inputs of the networks."""
    table = columns(frame)
    found = (GROUPS[name](table) if name in GROUPS else table[name] for name in INPUTS[:-2])
    return np.column_stack([np.log(np.abs(values)) for values in found])


def by_oil(frames: dict[str, pd.DataFrame], suffix: str) -> tuple[Values, float]:
    """mu of all points by the formula of each oil, and the processor time of a point [s]."""
    mu, spent, count = [], 0.0, 0
    for oil, frame in frames.items():
        formula = regression.Formula.load(oil + suffix)
        table = {name: np.tile(values, REPEATS) for name, values in columns(frame).items()}
        formula.coefficient(table)
        begin = time.process_time()
        found = formula.coefficient(table)
        spent, count = spent + time.process_time() - begin, count + found.size
        mu.append(found[: len(frame)])
    return np.concatenate(mu), spent / count


def process(frames: dict[str, pd.DataFrame], short: Values) -> tuple[Values, float]:
    """mu by a Gaussian process that corrects the short form, and the processor time of a point [s]."""
    fitted = {oil: pd.concat([rows_of(oil, kind) for kind in FITTED], ignore_index=True) for oil in OILS}
    x = np.vstack([inputs(frame) for frame in fitted.values()])
    y = np.log(np.concatenate([computed_friction(f) for f in fitted.values()]) / by_oil(fitted, "_short")[0])
    middle, spread = x.mean(axis=0), x.std(axis=0)
    varies = spread > 1e-6
    x = ((x - middle) / np.where(varies, spread, 1.0))[:, varies]
    drawn = np.random.default_rng(1).permutation(len(y))
    some, most = drawn[:FIRST], drawn[:MOST]
    kernel = ConstantKernel(0.1) * Matern(np.full(x.shape[1], 3.0), (0.1, 1e3), nu=2.5) + WhiteKernel(0.01)
    noise = np.concatenate([(f["friction_error"].to_numpy() / 1.645) ** 2 for f in fitted.values()])
    scales = GaussianProcessRegressor(kernel, alpha=noise[some]).fit(x[some], y[some]).kernel_
    model = GaussianProcessRegressor(scales, alpha=noise[most], optimizer=None).fit(x[most], y[most])
    at = ((np.vstack([inputs(f) for f in frames.values()]) - middle) / np.where(varies, spread, 1.0))[:, varies]
    begin = time.process_time()
    found = model.predict(at)
    return short * np.exp(found), (time.process_time() - begin) / len(at)


def single(frames: dict[str, pd.DataFrame]) -> tuple[Values, float]:
    """Errors of contacts of the solver against the other profiles of the point, and the time of a contact [s]."""
    errors, seconds = [], []
    for frame in frames.values():
        means = expected_rows(frame).set_index("key")["friction_coefficient"]
        one = frame[frame["key"].isin(means.index)]
        mean, count = means[one["key"]].to_numpy(), 8
        mu = one["friction_coefficient"].to_numpy()
        errors.append(np.abs(mu / ((count * mean - mu) / (count - 1)) - 1.0))
        seconds.append(one["seconds_cpu"].to_numpy())
    return np.concatenate(errors), float(np.concatenate(seconds).mean())


def main(argv: Sequence[str] | None = None) -> None:
    """Print, write and draw mean and median error over time."""
    parser = command_line(__doc__)
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args(argv)
    profiles = {oil: rows_of(oil, "_noise") for oil in OILS}
    frames = {oil: expected_rows(frame) for oil, frame in profiles.items()}
    truth = np.concatenate([computed_friction(frame) for frame in frames.values()])
    short, seconds = by_oil(frames, "_short")
    network, spent = by_oil(frames, "")
    found = {"short form": (short, seconds), "networks": (network, spent), "Gaussian process": process(frames, short)}
    rows = [
        {"model": name, "seconds": at, "mean": float(np.mean(e)), "median": float(np.median(e))}
        for name, (e, at) in [
            *((name, (np.abs(mu / truth - 1.0), at)) for name, (mu, at) in found.items()),
            ("solver, one profile", single(profiles)),
        ]
    ]
    print(pd.DataFrame(rows).to_string(index=False, float_format="%.3g"))
    write_rows(OUT / "friction_work.csv", rows)
    figure, axes = plt.subplots(figsize=(6.4, 3.8), layout="constrained")
    for name, marker in (("mean", "o"), ("median", "s")):
        axes.loglog([row["seconds"] for row in rows], [100.0 * row[name] for row in rows], marker, label=name)
    for row in rows:
        axes.annotate(row["model"], (row["seconds"], 100.0 * row["mean"]), (6, 6), textcoords="offset points")
    axes.set_xlabel("processor time of a point [s]")
    axes.set_ylabel("error of $\\mu$ [%]")
    axes.set(xlim=(1e-7, 1e3), ylim=(0.5, 20.0))
    axes.set_yticks([1.0, 2.0, 5.0, 10.0, 20.0], ["1", "2", "5", "10", "20"])
    axes.legend()
    options.out.mkdir(parents=True, exist_ok=True)
    figure.savefig(options.out / "friction_work.png", dpi=150)


if __name__ == "__main__":
    main()
