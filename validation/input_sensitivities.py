"""What boundary film, lay, temperature and steel of the bodies do to friction: inputs a friction formula does not hold.

Contacts spread over what gears see are solved with each input lowered and raised by what the 90 % interval of its
default spread spans, with the same roughness, so that the difference is the input's alone. The slopes of ln mu, for the
boundary film also those of the logit of the asperity load share, are averaged over ln lambda and written to
`data/sensitivities.csv`, which the input uncertainty of formulas reads.

    python validation/input_sensitivities.py --contacts 24 --rows rows.csv
    python validation/input_sensitivities.py --rows rows.csv --table     # the table of rows that were computed
"""

from __future__ import annotations

import csv
import math
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from common import command_line
from scipy.stats import qmc

import ehl
from ehl.common.data import data_path
from ehl.fluid.oil import Oil
from ehl.uncertainty.spread import FILM_RATIOS, FILM_TO_SHARE
from regression.friction.conditions import conditions_of, contact_points

# lower and upper ends of what gear meshes see; lambda takes the speed with it
RANGES = {
    "pressure_hertz": (0.5e9, 1.6e9),
    "radius_equivalent": (6e-3, 30e-3),
    "slide_to_roll": (0.05, 0.6),
    "along": (0.05, 1.0),
    "temperature_oil": (313.15, 393.15),
    "roughness_rms": (0.2e-6, 1.2e-6),
    "correlation_length": (10e-6, 40e-6),
    "peklenik_number": (1.2, 5.0),
    "film_ratio": (0.06, 5.0),
}
SPEEDS, SKEWNESS = (0.3, 30.0), -0.8
FILM_FACTORS, LAYS, WARMER, CONDUCTIVITIES = (1.0 / 3.0, 2.0), (0.5, 2.0), 16.0, (2.0 / 3.0, 1.5)
STEEL = ehl.Material.load("steel").thermal_conductivity
# of the mean over ln lambda
WIDTH = 0.5
# ends of what a contact file may say
FILMS = (5e-9, 300e-9)
COLUMNS = ("film_ratio", "input", "step_below", "step_above", "below", "above", "friction_coefficient", "status")
LEAST_SHARE = 1e-3  # of the load on asperities, below which the mesh does not resolve its change


def states(count: int, oil: str) -> list[dict[str, float]]:
    """Contacts by a Latin hypercube, ln-uniform."""
    shares = qmc.LatinHypercube(len(RANGES), rng=7).random(count)
    found = []
    for row in shares:
        values = {
            name: math.exp(math.log(low) + share * math.log(high / low))
            for share, (name, (low, high)) in zip(row, RANGES.items(), strict=True)
        }
        along, target = values.pop("along"), values.pop("film_ratio")
        speed = 3.0
        for _ in range(6):
            at = conditions_of(contact_points(**values, speed_entrainment=speed), Oil.load(oil))
            speed = float(np.clip(speed * (target / float(at["film_ratio_formula"])) ** 1.5, *SPEEDS))
        found.append(values | {"speed_entrainment": speed, "speed_sliding_lengthwise": along * speed})
    return found


def row_of(base: ehl.ContactResult, ends: Sequence[ehl.ContactResult], quantity: str) -> list[object]:
    """Changes of ln mu, or of the logit of the asperity load share, at the lower and upper end of an input."""

    def level(result: ehl.ContactResult) -> float:
        if quantity == "friction":
            return math.log(result.friction_coefficient)
        return math.log(result.asperity_load_share / (1.0 - result.asperity_load_share))

    changes = [level(end) - level(base) for end in ends]
    return [*changes, base.friction_coefficient, "/".join(end.status for end in ends)]


def rows(count: int, path: Path, oil: str) -> None:
    """Solve the contacts; each is written down when it is done."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for number, state in enumerate(states(count, oil)):
            clock = time.perf_counter()
            each = state["roughness_rms"] / math.sqrt(2.0)
            rough = {"roughness_rms_1": each, "roughness_rms_2": each}
            given = {name: value for name, value in state.items() if name != "roughness_rms"}
            contact = ehl.Contact(oil=oil, **given, **rough, skewness=SKEWNESS, seed=number + 1, accuracy="fast")
            base = contact.solve()
            if base.status == "failed":
                continue
            film, bulk = contact.surface.film_of_contact, state["temperature_oil"]
            films = [float(np.clip(film * f, *FILMS)) for f in FILM_FACTORS]
            steps: dict[str, tuple[list[float], list[dict[str, object]]]] = {
                "boundary_film": ([math.log(f / film) for f in films], [{"boundary_film": f} for f in films]),
                "peklenik_number": (
                    [math.log(factor) for factor in LAYS],
                    [{"peklenik_number": factor * state["peklenik_number"]} for factor in LAYS],
                ),
                "temperature_bulk": (
                    [-WARMER, WARMER],
                    [{f"temperature_bulk_{body}": bulk + by for body in "12"} for by in (-WARMER, WARMER)],
                ),
                "conductivity_solid": (
                    [math.log(factor) for factor in CONDUCTIVITIES],
                    [
                        {f"solid_{body}": {"thermal_conductivity": factor * STEEL} for body in "12"}
                        for factor in CONDUCTIVITIES
                    ],
                ),
            }
            for name, (spans, changes) in steps.items():
                ends = [contact.replace(**change).solve() for change in changes]
                writer.writerow([base.film_ratio, name, *spans, *row_of(base, ends, "friction")])
                shares = [base.asperity_load_share, *(end.asperity_load_share for end in ends)]
                if name == "boundary_film" and all(LEAST_SHARE < share < 1.0 - LEAST_SHARE for share in shares):
                    writer.writerow([base.film_ratio, FILM_TO_SHARE, *spans, *row_of(base, ends, "share")])
            file.flush()
            print(
                f"{number} lambda {base.film_ratio:.3f} mu {base.friction_coefficient:.4f}, "
                f"{time.perf_counter() - clock:.0f} s"
            )


def table(path: Path, target: Path) -> None:
    """Mean slopes near each film ratio, and how far single contacts are from them."""
    with path.open() as file:
        found = [row for row in csv.DictReader(file) if "failed" not in row["status"]]
    with target.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["input", "film_ratio", "slope_below", "slope_above", "scatter"])
        for name in (FILM_TO_SHARE, "boundary_film", "peklenik_number", "temperature_bulk", "conductivity_solid"):
            # a film that is at its limit already does not move
            mine = [
                row for row in found if row["input"] == name and float(row["step_below"]) * float(row["step_above"])
            ]
            ratio = np.log([float(row["film_ratio"]) for row in mine])
            slopes = np.array([[float(row[s]) / float(row[f"step_{s}"]) for s in ("below", "above")] for row in mine])
            for node in FILM_RATIOS:
                weight = np.exp(-0.5 * ((ratio - math.log(node)) / WIDTH) ** 2)
                weight /= weight.sum()
                mean = weight @ slopes
                scatter = math.sqrt(float(weight @ np.mean((slopes - mean) ** 2, axis=1)))
                writer.writerow([name, node, *(f"{value:.4g}" for value in (*mean, scatter))])
    print(target.read_text())


def main(argv: Sequence[str] | None = None) -> None:
    """Rows, and the table made of them."""
    parser = command_line(__doc__)
    parser.add_argument("--contacts", type=int, default=24)
    parser.add_argument("--oil", default="75w90")
    parser.add_argument("--rows", type=Path, default=Path("sensitivity_rows.csv"))
    parser.add_argument("--table", action="store_true", help="only make the table")
    options = parser.parse_args(argv)
    if not options.table:
        rows(options.contacts, options.rows, options.oil)
    table(options.rows, data_path("sensitivities.csv"))


if __name__ == "__main__":
    main()
