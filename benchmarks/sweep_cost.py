"""What the cost estimate of a plan is worth: its seconds against the processor time of finished runs, and a fit.

    python benchmarks/sweep_cost.py RUN...

Each run holds deterministic contacts of one accuracy. Prints the error of the estimate case by case and in sum, and the
coefficients a fit to these runs would have; writes sweep_cost.csv.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from common import command_line

from regression.data.dataset import load_dataset
from regression.plan.cost import LEVEL, ROUGH, cost_terms


def main(argv: Sequence[str] | None = None) -> None:
    """Compare estimate and measurement."""
    parser = command_line(__doc__)
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("--accuracy", choices=sorted(LEVEL), default="fast")
    parser.add_argument("--csv", type=Path, default=Path("sweep_cost.csv"))
    options = parser.parse_args(argv)
    frames = [load_dataset(run).frame for run in options.runs]
    frame = frames[0] if len(frames) == 1 else pd.concat(frames, ignore_index=True)
    rough = frame[(frame["steps"] > 0) & (frame["attempts"] == 1)]
    terms = cost_terms(
        (rough["half_width"] / rough["correlation_length"]).to_numpy(), rough["film_ratio_formula"].to_numpy()
    )
    seconds = rough["seconds_cpu"].to_numpy()
    constant, factor = LEVEL[options.accuracy]
    estimate = factor * np.exp(constant + terms @ np.array(ROUGH))
    error = np.abs(np.log(estimate / seconds))
    print(f"{len(rough)} rough cases, {seconds.mean():.3g} s in the mean, longest {seconds.max():.3g} s")
    ratio = estimate / seconds
    half, most = np.exp(np.quantile(error, [0.5, 0.9]))
    print(f"estimate over measured: sum {estimate.sum() / seconds.sum():.2f}, median case {np.median(ratio):.2f}")
    print(f"half of the cases within a factor {half:.2f}, 90 % within {most:.2f}")
    design = np.column_stack([np.ones(len(rough)), terms])
    found, *_ = np.linalg.lstsq(design, np.log(seconds), rcond=None)
    fitted = np.exp(design @ found)
    scatter = float(np.std(np.log(seconds / fitted)))
    print("constant and terms of a fit to these runs:", ", ".join(f"{value:.3f}" for value in found))
    print(f"its factor {seconds.sum() / fitted.sum():.2f}, scatter of ln(seconds) {scatter:.2f}")
    with options.csv.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["half_width_over_length", "film_ratio_formula", "seconds", "estimate"])
        width = rough["half_width"] / rough["correlation_length"]
        writer.writerows(zip(width, rough["film_ratio_formula"], seconds, estimate, strict=True))


if __name__ == "__main__":
    main()
