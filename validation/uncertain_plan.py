"""Contacts at which the friction networks are uncertain, as the tables of the plan `gear_uncertain`.

    python validation/uncertain_plan.py data/plans SEED  # adds a choice to the table of each oil

Networks are trained with all fitted contacts of all oils. Of every `CANDIDATES` consecutive points of a Sobol sequence
in the ranges of a plan (`POINTS`), the one is taken at which ln mu of the networks scatters most, for each oil. The
tables hold three choices: twice 420 contacts of `gear` and `gear_mesh` (seeds 40 000 and 50 000), then those of
`POINTS` (seed 60 000). The first 420, a quarter more contacts, lowered the error of points never fitted by 9 %; twice
as many random ones by 13 %.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from common import command_line
from gear_path_plan import write_table
from shipped_formulas import DATA, FITTED, OILS

from regression.data.dataset import load_dataset
from regression.fitting import coefficients
from regression.fitting.rows import usable_rows
from regression.friction.families import family_named
from regression.plan.plan import Plan

POINTS = {"gear": 380, "gear_mesh": 160, "gear_film": 260}
CANDIDATES = 8
MEMBERS = 8


def trained() -> tuple[coefficients.FittedForm, float]:
    """Closed form of all oils with several networks, whose scatter varies less than that of three, and mu_b."""
    coefficients.MEMBERS = MEMBERS
    data = load_dataset(*(DATA / "datasets" / f"gear_{oil}{kind}.h5" for oil in OILS for kind in FITTED))
    rows = usable_rows(data, corners=False)[0]
    return coefficients.fit_form(family_named("short"), rows, network=True), float(rows["boundary_friction"].iloc[0])


def chosen(form: coefficients.FittedForm, mu_b: float, oil: str, seed: int) -> pd.DataFrame:
    """Values of the variables of the chosen points, SI units, with the scatter of ln mu."""
    found = []
    for name, count in POINTS.items():
        changes = [
            f"lubricant.oil={oil}", f"sampling.seed={seed + OILS.index(oil)}", f"sampling.size={count * CANDIDATES}",
        ]  # fmt: skip
        plan = Plan.from_file(name, changes)
        points = plan.points
        table = pd.DataFrame(plan.conditions(points.columns, points.oils)).assign(oil=oil, boundary_friction=mu_b)
        _, scatter = form.friction(table)
        best = np.asarray(scatter).reshape(count, CANDIDATES).argmax(axis=1) + CANDIDATES * np.arange(count)
        found.append(pd.DataFrame(points.columns).assign(scatter=scatter).iloc[best])
    return pd.concat(found, ignore_index=True)


def main(argv: Sequence[str] | None = None) -> None:
    parser = command_line(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("seed", type=int, help="of the first oil; each oil adds one")
    selected = parser.parse_args(argv)
    form, mu_b = trained()
    for oil in OILS:
        points = chosen(form, mu_b, oil, selected.seed)
        path = selected.folder / f"gear_uncertain_{oil}.csv"
        write_table(path, points, add=path.exists())
        print(f"{oil}: {len(points)} contacts, median scatter of ln mu {points['scatter'].median():.3f}", flush=True)


if __name__ == "__main__":
    main()
