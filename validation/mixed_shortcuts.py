"""What the shortcuts of the rough solver cost in accuracy: coarser answers beyond the mesh budget, dry contact.

    python validation/mixed_shortcuts.py {budget,ways,dry} --out FOLDER

"budget": contacts that the nodes of accuracy "fast" resolve, solved again with so few that they cannot.
"ways": the short ways and the preheated surfaces of fine roughness against the long ways, on the same mesh.
"dry": contacts whose film is negligible, with the switch to dry contact and without.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pandas as pd
from common import OUT, command_line
from mixed_scenes import eyring_oil, gaussian_pair, line, speed_of_film_ratio

from ehl.common.validation import validate
from ehl.contact import Contact
from ehl.result import ContactResult
from ehl.rough import solve_transient
from ehl.rough.accuracy import BUDGET

RMS = 0.4e-6
# film ratio, p_h [GPa], SR, gamma, correlation length [b]
RESOLVED = (
    (2.0, 1.0, 0.5, 1.0, 0.04), (0.7, 1.0, 0.5, 1.0, 0.04), (0.2, 1.0, 0.5, 1.0, 0.04), (0.05, 1.0, 0.5, 1.0, 0.04),
    (0.7, 1.0, 0.5, math.inf, 0.04), (0.2, 1.0, 0.5, math.inf, 0.04), (0.7, 2.0, 0.1, 1.0, 0.04),
    (0.7, 0.5, 0.5, 3.0, 0.04), (1.5, 1.0, 0.5, 1.0, 0.02), (0.5, 1.0, 0.5, 1.0, 0.02), (0.3, 1.5, 0.3, 3.0, 0.06),
    (1.2, 0.7, 1.0, 1.0, 0.03), (3.0, 1.0, 0.5, 1.0, 0.04),
)  # fmt: skip
# film ratio, p_h [GPa], SR, gamma, correlation length [b], heat
FINE = (
    (2.0, 1.0, 0.5, 1.0, 0.02, False), (0.7, 1.0, 0.5, 1.0, 0.02, False), (0.3, 1.0, 0.5, math.inf, 0.02, False),
    (0.7, 1.0, 0.5, 3.0, 0.02, True), (1.2, 1.5, 1.5, math.inf, 0.02, True), (0.5, 1.0, 1.5, 1.0, 0.02, True),
    (1.0, 0.7, 1.9, 1.0, 0.02, True), (0.2, 1.0, 0.3, 1.0, 0.02, True), (1.0, 1.0, -1.2, 1.0, 0.01, True),
)  # fmt: skip
# film ratio, h_boundary [nm], p_h [GPa], SR, gamma, correlation length [b]
NIL = (
    (0.003, 30, 1.0, 0.5, 1.0, 0.1), (0.001, 30, 1.0, 0.5, 1.0, 0.1), (0.005, 30, 1.0, 0.5, 1.0, 0.1),
    (0.003, 30, 1.0, 0.5, 3.0, 0.1), (0.001, 30, 1.0, 0.5, math.inf, 0.1), (0.001, 30, 2.0, 0.5, 1.0, 0.1),
    (0.001, 10, 1.0, 0.5, 1.0, 0.1), (0.01, 90, 1.0, 0.5, 1.0, 0.1), (0.003, 30, 1.0, 1.5, 1.0, 0.3),
    (0.002, 30, 0.5, 0.1, 9.0, 0.1),
)  # fmt: skip


def scene(ratio: float, gpa: float, slip: float, gamma: float, length: float, seed: int, **more: Any) -> Contact:
    """A contact of the test line by its film ratio; the correlation length in half-widths."""
    speed = speed_of_film_ratio(ratio, RMS, eyring_oil(), pressure=gpa * 1e9)
    contact = line(speed, slip, gpa * 1e9)
    surface = {"roughness_rms_1": RMS / math.sqrt(2.0), "roughness_rms_2": RMS / math.sqrt(2.0), "seed": seed}
    surface |= {"correlation_length": length * contact.half_width, "peklenik_number": min(gamma, 1e6)}
    boundary, shortcuts = more.get("boundary", 20e-9), more.get("shortcuts", "auto")
    return validate(
        Contact,
        {
            "contact": {
                "effective_modulus": contact.effective_modulus, "radius_equivalent": contact.radius_equivalent,
                "pressure_hertz": gpa * 1e9, "speed_entrainment": speed, "slide_to_roll": slip,
            },
            "lubricant": {
                "viscosity_inlet": 0.015, "pressure_viscosity": 15e-9, "eyring_stress": 5e6,
                "temperature_oil": 373.15, "temperature_viscosity": 0.04,
            },
            "surface": surface | {"boundary_film": boundary},
            "model": {
                "accuracy": "fast", "thermal": "off", "shortcuts": shortcuts,
            },
        },
    )  # fmt: skip


def solved(case: Contact, nodes: int | None = None) -> tuple[ContactResult, float]:
    """The result with another budget of nodes, and its processor time."""
    clock = time.process_time()
    with mock.patch.dict(BUDGET, {"fast": (nodes, nodes) if nodes else BUDGET["fast"]}):
        result = case.solve()
    return result, time.process_time() - clock


def written(path: Path, columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Print the rows and write them."""
    table = pd.DataFrame(rows, columns=columns)
    print(table.to_string(index=False, float_format="%.4g"), flush=True)
    path.parent.mkdir(parents=True, exist_ok=True)
    table.to_csv(path, index=False)


def budget(out: Path, seeds: int) -> None:
    """Coarser answers against the resolved one."""
    rows: list[list[Any]] = []
    for ratio, gpa, slip, gamma, length in RESOLVED:
        for seed in range(1, seeds + 1):
            case = scene(ratio, gpa, slip, gamma, length, seed)
            full, cost = solved(case)
            for share in (0.9, 0.4):
                coarse, cheap = solved(case, round(share * 3.0 * 3.7 / length))
                mu = coarse.friction_coefficient
                true = abs(full.friction_coefficient / mu - 1.0)
                rows.append(
                    [ratio, gpa, slip, gamma, length, seed, share, full.friction_coefficient, mu,
                     coarse.friction_boundary_half, coarse.friction_boundary_double, true, coarse.friction_error,
                     full.friction_error, true <= coarse.friction_error + full.friction_error, coarse.status,
                     cost, cheap]
                )  # fmt: skip
    columns = ("lambda", "p_h", "SR", "gamma", "lc/b", "seed", "budget", "mu", "mu coarse", "low", "high", "true",
               "reported", "own", "inside", "status", "s", "s coarse")  # fmt: skip
    written(out / "mixed_budget.csv", columns, rows)
    inside = np.array([row[14] for row in rows], dtype=bool)
    ratios = np.array([row[12] / row[11] for row in rows], dtype=float)
    wrong = np.array([row[11] for row in rows], dtype=float)
    print(f"inside {inside.mean():.0%} of {len(rows)}; reported over true, median {np.median(ratios):.2g}")
    print(f"true error median {np.median(wrong):.2g}, largest {wrong.max():.2g}")


def ways(out: Path, seeds: int) -> None:
    """Short ways and preheated surfaces against long ways."""
    rows: list[list[Any]] = []
    for ratio, gpa, slip, gamma, length, thermal in FINE:
        contact = line(speed_of_film_ratio(ratio, RMS, eyring_oil(), pressure=gpa * 1e9), slip, gpa * 1e9)
        for seed in range(1, seeds + 1):
            rough = gaussian_pair(contact, RMS, length, seed)
            mus, errors, costs = [], [], []
            for fine, travel in ((True, None), (False, 24.0)):
                clock = time.process_time()
                run = solve_transient(
                    contact, eyring_oil(), rough, accuracy="fast", peklenik_number=gamma,
                    thermal=thermal, travel=travel, fine_roughness=fine, nodes=round(6.0 * 3.7 / length),
                )  # fmt: skip
                mus.append(run.friction_coefficient)
                errors.append(run.statistical_error)
                costs.append(time.process_time() - clock)
            true = mus[0] / mus[1] - 1.0
            rows.append([ratio, gpa, slip, gamma, length, thermal, seed, *mus, true, *errors, *costs])
    columns = ("lambda", "p_h", "SR", "gamma", "lc/b", "thermal", "seed", "mu short", "mu long", "difference",
               "interval short", "interval long", "s short", "s long")  # fmt: skip
    written(out / "mixed_ways.csv", columns, rows)
    inside = np.array([abs(row[9]) <= math.hypot(row[10], row[11]) for row in rows])
    print(f"inside both intervals: {inside.mean():.0%} of {len(rows)}")


def dry(out: Path, seeds: int) -> None:
    """The switch to dry contact against the run without it."""
    rows: list[list[Any]] = []
    for ratio, film, gpa, slip, gamma, length in NIL:
        for seed in range(1, seeds + 1):
            results = []
            for shortcuts in ("auto", "off"):
                case = scene(ratio, gpa, slip, gamma, length, seed, boundary=film * 1e-9, shortcuts=shortcuts)
                results.append(solved(case))
            (quick, cheap), (full, cost) = results
            true = abs(full.friction_coefficient / quick.friction_coefficient - 1.0)
            rows.append(
                [ratio, film, gpa, slip, gamma, length, seed, quick.dry is not None, full.friction_coefficient,
                 full.asperity_load_share, true, quick.friction_error, full.friction_error,
                 quick.film_central * 1e9, full.film_central * 1e9, quick.pressure_max / 1e9, full.pressure_max / 1e9,
                 cheap, cost]
            )  # fmt: skip
    columns = ("lambda", "h_b", "p_h", "SR", "gamma", "lc/b", "seed", "dry", "mu", "share", "true", "reported", "own",
               "h dry", "h", "p dry", "p", "s dry", "s")  # fmt: skip
    written(out / "mixed_dry.csv", columns, rows)


def main(argv: Sequence[str] | None = None) -> None:
    """Run from the command line."""
    parser = command_line(__doc__)
    parser.add_argument("study", choices=("budget", "ways", "dry"))
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args(argv)
    {"budget": budget, "ways": ways, "dry": dry}[options.study](options.out, options.seeds)


if __name__ == "__main__":
    main()
