"""Errors of the deterministic rough solver: reported and statistical errors, meshes, cost, Stribeck curves.

    python validation/mixed_validation.py STUDY --out validation/out

Every study prints its tables and writes CSV and, where it has one, a PNG; each runs alone on one core.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib
from common import OUT, command_line

matplotlib.use("Agg")

import mixed_errors
import mixed_stribeck


def main(argv: Sequence[str] | None = None) -> None:
    """Run one study."""
    parser = command_line(__doc__)
    studies = ("reported", "intervals", "stretches", "mesh", "targets", "spots", "cost", "stribeck")
    parser.add_argument("study", choices=studies)
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--count", type=int, default=100, help="cases or seeds")
    parser.add_argument("--seed", type=int, default=21)
    parser.add_argument("--seconds", type=float, default=1800.0, help="time after which no further case is started")
    parser.add_argument("--window", type=float, default=12.0, help="travel averaged [b]")
    parser.add_argument("--only", type=int, help="number of the one condition of the intervals to run")
    given = parser.parse_args(argv)
    given.out.mkdir(parents=True, exist_ok=True)
    if given.study == "reported":
        mixed_errors.reported_errors(given.out, given.count, given.seed, given.seconds, given.window)
    elif given.study == "intervals":
        mixed_errors.statistical_intervals(given.out, given.count, given.window, given.only)
    elif given.study == "stretches":
        mixed_errors.stretches(given.out, given.count)
    elif given.study == "spots":
        mixed_errors.spots(given.out, given.window)
    elif given.study == "mesh":
        mixed_errors.mesh_table(given.out, given.window)
    elif given.study == "targets":
        mixed_errors.mesh_targets(given.out, given.window)
    elif given.study == "stribeck":
        mixed_stribeck.stribeck(given.out, given.window)
    elif given.study == "cost":
        mixed_errors.cost(given.out)


if __name__ == "__main__":
    main()
