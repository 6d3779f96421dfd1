"""Friction formulas against solved contacts along gear meshes, as error of the loss and of the efficiency.

    python validation/formula_gears.py 75w90 fva3
    python validation/formula_gears.py --formula my.json --paths my_run

The contacts of gear_75w90_paths and gear_fva3_paths (`validation/gear_path_plan.py`) lie equally spaced in the work of
friction: the mean of mu over those of an operating point is that of its loss. Each contact is the mean over its
roughness profiles; what these leave to chance stands beside the errors. Prints a line per gear, operating point and
formula and writes out/formula_gears.csv.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from common import OUT, command_line, write_rows

import regression
from regression.data.dataset import columns, load_dataset
from regression.fitting.noise import expected_rows
from regression.fitting.rows import checkable_rows
from regression.formula import Formula

KINDS = ("short", "")
FILE = "gear_paths.csv"
# what a row of the table is found again by
SAME = ("pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll")


def mesh_contacts(paths: str) -> pd.DataFrame:
    """Contacts of a dataset of paths, means over profiles, with pair, operating point and loss for mu = 1 of each."""
    means = expected_rows(checkable_rows(load_dataset(paths).frame))
    table = pd.read_csv(Path("data/plans") / FILE)
    keys = np.column_stack([means[name] for name in SAME]) / (1e9, 1e-3, 1.0, 1.0)
    known = table.iloc[:, : len(SAME)].to_numpy()
    nearest = np.abs(keys[:, None, :] / known[None] - 1.0).max(axis=2)
    row = nearest.argmin(axis=1)
    if nearest.min(axis=1).max() > 1e-5:
        raise SystemExit(f"contacts of {paths} that are not in {FILE}")
    return means.assign(**{name: table[f"# {name}"].to_numpy()[row] for name in ("design", "state", "loss")})


def fitted(name: str) -> Formula:
    """A shipped formula or that of a file."""
    model = regression.friction_model(name)
    if not isinstance(model, regression.Formula):
        raise SystemExit(f"{name} is no fitted formula")
    return model


def errors(paths: str, formulas: Sequence[str]) -> list[dict[str, object]]:
    """A row for each pair, operating point and formula."""
    contacts = mesh_contacts(paths)
    rows: list[dict[str, object]] = []
    for formula in formulas:
        value = fitted(formula).evaluate(columns(contacts))
        told = contacts.assign(told=value.mu, inside=fitted(formula).extrapolation(columns(contacts)) == 0)
        told["covered"] = (value.lower <= told["friction_coefficient"]) & (told["friction_coefficient"] <= value.upper)
        for (design, state), mesh in told.groupby(["design", "state"], sort=False):
            solved, share = mesh["friction_coefficient"].mean(), mesh["loss"].iloc[0]
            chance = np.sqrt(np.sum(mesh["noise_variance"] * mesh["friction_coefficient"] ** 2)) / len(mesh) / solved
            error = mesh["told"].mean() / solved - 1.0
            rows.append(
                {
                    "formula": formula,
                    "design": design,
                    "state": state,
                    "contacts": len(mesh),
                    "film_ratio": float(mesh["film_ratio"].median()),
                    "loss": solved * share,
                    "error": 100.0 * error,
                    "chance": 100.0 * chance,
                    "points": -solved * share * error,
                    "covered": float(mesh["covered"].mean()),
                }
            )
    return rows


def main(argv: Sequence[str] | None = None) -> None:
    """Print and write."""
    parser = command_line(__doc__)
    parser.add_argument("oils", nargs="*", metavar="OIL")
    parser.add_argument("--formula", action="append", default=[], help="A formula in place of the shipped ones.")
    parser.add_argument("--paths", help="Dataset of contacts along meshes for --formula.")
    given = parser.parse_args(argv)
    if bool(given.formula) != bool(given.paths):
        parser.error("--formula and --paths belong together")
    rows = errors(given.paths, given.formula) if given.formula else []
    for oil in given.oils if given.formula else given.oils or ("75w90", "fva3"):
        rows += errors(f"gear_{oil}_paths", [oil if not kind else f"{oil}_{kind}" for kind in KINDS])
    table = pd.DataFrame(rows)
    print(
        "loss and its error in %, efficiency in points, chance: of the solved contacts' profiles, one deviation, in %"
    )
    print(table.to_string(index=False, float_format=lambda number: f"{number:.3g}"))
    worst = table.assign(error=table["error"].abs(), points=table["points"].abs())
    print(
        worst.groupby("formula", sort=False)[["error", "points"]]
        .agg(["mean", "max"])
        .to_string(float_format="{:.3f}".format)
    )
    write_rows(OUT / "formula_gears.csv", rows)


if __name__ == "__main__":
    main()
