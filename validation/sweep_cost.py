"""What the cost estimate of a plan is worth: its seconds against the processor time of finished runs, and a fit.

    python validation/sweep_cost.py RUN...

Each run (or shipped dataset) holds deterministic contacts of one accuracy. Prints the error of the estimate case by
case, in sum and for the order of computation, the same of a fit to these runs held out, and its coefficients; writes
sweep_cost.csv.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from common import command_line
from numpy.typing import NDArray
from scipy.stats import spearmanr

from regression.data.dataset import load_dataset
from regression.plan.cost import LEVEL, ROUGH, cost_terms

Array = NDArray[np.float64]
FOLDS = 5
NEEDED = ("half_width", "correlation_length", "film_ratio_formula", "roughness_rms", "radius_equivalent")


def main(argv: Sequence[str] | None = None) -> None:
    """Compare estimate and measurement."""
    parser = command_line(__doc__)
    parser.add_argument("runs", nargs="+")
    parser.add_argument("--accuracy", choices=sorted(LEVEL), default="fast")
    parser.add_argument("--csv", type=Path, default=Path("sweep_cost.csv"))
    options = parser.parse_args(argv)
    frames = [load_dataset(run).frame for run in options.runs]
    frame = frames[0] if len(frames) == 1 else pd.concat(frames, ignore_index=True)
    rough = frame[(frame["steps"] > 0) & (frame["attempts"] == 1)]
    table = {name: rough[name].to_numpy(dtype=float) for name in NEEDED}
    terms, seconds = cost_terms(table), rough["seconds_cpu"].to_numpy()
    constant, factor = LEVEL[options.accuracy]
    estimate = factor * np.exp(constant + terms @ np.array(ROUGH))
    print(f"{len(rough)} rough cases, {seconds.mean():.3g} s in the mean, longest {seconds.max():.3g} s")
    report("the estimate", estimate, seconds)
    design = np.column_stack([np.ones(len(rough)), terms])
    # every point is in one fold with all of its profiles
    point = (
        rough[["pressure_hertz", "speed_entrainment", "radius_equivalent"]].round(12).astype(str).agg("|".join, axis=1)
    )
    fold = pd.factorize(point)[0] % FOLDS
    held_out = np.empty(len(rough))
    for number in range(FOLDS):
        found, scale = fit(design[fold != number], seconds[fold != number])
        held_out[fold == number] = scale * np.exp(design[fold == number] @ found)
    report("a fit to these runs, each fold by the others", held_out, seconds)
    found, scale = fit(design, seconds)
    print("its constant and terms:", ", ".join(f"{value:.3f}" for value in found), f"; factor {scale:.2f}")
    pd.DataFrame(table | {"seconds": seconds, "estimate": estimate, "held out": held_out}).to_csv(
        options.csv, index=False
    )


def fit(design: Array, seconds: Array) -> tuple[Array, float]:
    """Least squares of ln(seconds), and the factor that makes the sum right."""
    found, *_ = np.linalg.lstsq(design, np.log(seconds), rcond=None)
    return found, float(seconds.sum() / np.exp(design @ found).sum())


def report(what: str, estimate: Array, seconds: Array) -> None:
    """Print how good an estimate is, case by case, in sum, and for the order of computation."""
    half, most = np.exp(np.quantile(np.abs(np.log(estimate / seconds)), [0.5, 0.9]))
    place = np.argsort(np.argsort(-estimate)) / len(seconds)
    longest = place[seconds >= np.quantile(seconds, 0.99)]
    print(f"{what}: sum over measured {estimate.sum() / seconds.sum():.2f}")
    print(f"  half of the cases within a factor {half:.2f}, 90 % within {most:.2f}")
    print(f"  rank correlation {spearmanr(estimate, seconds).statistic:.2f}")
    print(f"  nine in ten of the longest 1 %: among the first {100.0 * np.quantile(longest, 0.9):.0f} % of the order")


if __name__ == "__main__":
    main()
