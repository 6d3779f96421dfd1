"""Rough contacts of the tests (`tests/twins/rough_scenes.py`) and tables for the scripts on the rough solver."""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from twins.rough_scenes import Scene, eyring_oil, gaussian_pair, line, speed_of_film_ratio

__all__ = ["Scene", "eyring_oil", "gaussian_pair", "line", "print_table", "speed_of_film_ratio", "write_csv"]


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Plain text to the terminal."""
    body = [[_text(v) for v in row] for row in rows]
    widths = [max([len(c), *(len(r[i]) for r in body)]) for i, c in enumerate(columns)]
    print(f"\n{title}")
    for row in [list(columns), *body]:
        print("  ".join(v.rjust(w) for v, w in zip(row, widths, strict=True)), flush=True)


def write_csv(path: Path, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """The same rows at full precision."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(rows)


def _text(value: object) -> str:
    if isinstance(value, (float, np.floating)):
        return f"{value:.4g}"
    return str(value)
