"""Friction in full film over pressure, speed, slip and temperature, of two states of the program.

``python benchmarks/before_after.py curves before.csv`` computes with the program that is on the path (run it with
PYTHONPATH at another checkout for another state); ``python benchmarks/before_after.py figure before.csv figure.png``
draws it beside the program of today, with the interval (5 to 95 %) of what is known of the oil under pressure.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from common import command_line
from matplotlib.figure import Figure

import ehl
from ehl.solve import solve_contact

KELVIN = 273.15
OILS = ("75w90", "fva3")
BASE = {"pressure": 1.0, "speed": 5.0, "slip": 0.2, "temperature": 90.0}  # GPa, m/s, -, degC; R 15 mm
SWEEPS: dict[str, tuple[str, tuple[float, ...]]] = {
    "pressure": ("Hertz pressure [GPa]", (0.4, 0.6, 0.8, 1.0, 1.3, 1.6, 2.0)),
    "speed": ("entrainment speed [m/s]", (0.5, 1.0, 2.0, 5.0, 10.0, 20.0)),
    "slip": ("slide-to-roll ratio", (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)),
    "temperature": ("oil temperature [degC]", (40.0, 60.0, 80.0, 100.0, 120.0, 140.0)),
}
NINETY = 1.645  # standard deviations of a 90 % interval


def states() -> Iterator[tuple[str, str, float, ehl.Contact]]:
    """Oil, what varies, its value, the contact."""
    for oil in OILS:
        for name, (_, values) in SWEEPS.items():
            for value in values:
                at = {**BASE, name: value}
                contact = ehl.Contact(
                    oil=oil, temperature=at["temperature"] + KELVIN, pressure_hertz=1e9 * at["pressure"],
                    radius_equivalent=15e-3, speed_entrainment=at["speed"], slide_to_roll=at["slip"],
                )  # fmt: skip
                yield oil, name, value, contact


def friction(contact: ehl.Contact, deviation: float = 0.0) -> float:
    """mu, with the rise of ln(eta) under pressure shifted by so many standard deviations of the card."""
    if deviation == 0.0:
        return contact.solve().friction_coefficient
    p = contact.problem()
    oil = contact.lubricant
    card = ehl.Oil.load(oil.oil).varied(pressure_viscosity=deviation)  # type: ignore[union-attr]
    lubricant = card.at(oil.temperature_oil)
    return solve_contact(p.line, lubricant, p.surface, p.model, p.bodies, p.temperature_bulk).friction_coefficient


def curves(path: Path, deviations: Sequence[float] = (0.0,)) -> None:
    """One row a contact: oil, what varies, value, mu of each deviation."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["oil", "over", "value", *("mu" if d == 0.0 else f"mu_{d:+g}" for d in deviations)])
        for oil, name, value, contact in states():
            writer.writerow([oil, name, value, *(f"{friction(contact, d):.5f}" for d in deviations)])


def read(path: Path) -> dict[tuple[str, str], Any]:
    """Value and mu columns of each oil and sweep."""
    with path.open(newline="") as file:
        rows = list(csv.reader(file))[1:]
    keys = dict.fromkeys((row[0], row[1]) for row in rows)
    return {key: np.array([[float(v) for v in row[2:]] for row in rows if (row[0], row[1]) == key]) for key in keys}


def draw(before: Path, after: Path, path: Path) -> None:
    """Two rows of oils, four columns of what varies."""
    old, new = read(before), read(after)
    figure = Figure(figsize=(12.5, 5.6), layout="constrained")
    for row, oil in zip(figure.subplots(2, 4, sharey="row"), OILS, strict=True):
        for axes, (name, (label, _)) in zip(row, SWEEPS.items(), strict=True):
            was, now = old[oil, name], new[oil, name]
            axes.plot(was[:, 0], was[:, 1], "--", color="0.4", label="before")
            axes.fill_between(now[:, 0], now[:, 2], now[:, 3], color="C0", alpha=0.3, lw=0, label="5 to 95 %")
            axes.plot(now[:, 0], now[:, 1], "-o", ms=3, color="C0", label="after")
            axes.set_xlabel(label)
            if name in ("speed", "slip"):
                axes.set_xscale("log")
            axes.grid(alpha=0.3)
        row[0].set_ylim(bottom=0.0)
        row[0].set_ylabel(f"{oil}\nfriction coefficient")
    row[0].legend(fontsize=8)
    figure.savefig(path, dpi=130)


def main(argv: Sequence[str] | None = None) -> None:
    """See the head of the file."""
    parser = command_line(__doc__)
    parser.add_argument("what", choices=("curves", "figure"))
    parser.add_argument("before", type=Path)
    parser.add_argument("figure", type=Path, nargs="?", default=Path("docs/figures/before_after.png"))
    options = parser.parse_args(argv)
    if options.what == "curves":
        curves(options.before)
    else:
        after = options.figure.with_name("friction_after.csv")
        curves(after, (0.0, -NINETY, NINETY))
        draw(options.before, after, options.figure)


if __name__ == "__main__":
    main()
