"""Random smooth contacts with heat: time against error at each accuracy.

    python -m benchmarks smooth_heat --count 32

Contacts of the plan of a shipped oil with the roughness left out. The truth is "reference"; errors are those of mu and
of the larger one of both films. CPU times of one core, beside the isothermal contact.

    python -m benchmarks smooth_heat --count 32 --before CHECKOUT

The same contacts by the program of another checkout and this one, in turn, twice each in processes of their own: the
ratio of the sums of the shorter times, and what mu and films move by.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from common import OUT, command_line

from ehl import Contact, ContactResult
from regression.plan.plan import Plan

VALUES = ("friction_coefficient", "film_central", "film_min")


def contacts(oil: str, count: int, accuracy: str, thermal: str) -> list[Contact]:
    """The first contacts of a plan of the gear range without roughness."""
    plan = Plan.from_dict(
        {
            "name": "smooth",
            "sampling": {"size": 1024, "seed": 1, "corners": False},
            "variables": {
                "pressure_hertz": {"low": "0.2 GPa", "high": "2.5 GPa"},
                "radius_equivalent": {"low": "5 mm", "high": "80 mm", "scale": "log"},
                "speed_entrainment": {"low": "0.1 m/s", "high": "20 m/s", "scale": "log"},
                "slide_to_roll": {"low": 0.01, "high": 1.5, "scale": "log"},
                "lengthwise_to_roll": {"low": 0.0, "high": 2.0},
                "temperature_oil": {"low": "25 degC", "high": "130 degC"},
                "roughness_rms": "0 um",
            },
            "constraints": {
                "load_per_length": {"high": "3000 N/mm"},
                "speed_sliding": {"high": "20 m/s"},
                "temperature_flash": {"high": "450 degC"},
            },
            "lubricant": {"oil": oil},
            "model": {"roughness": "deterministic", "accuracy": accuracy, "thermal": thermal},
        }
    )
    return [plan.case_at(number) for number in range(count)]


def solved(cases: Sequence[Contact]) -> tuple[list[ContactResult], np.ndarray]:
    """Results and CPU seconds of each."""
    cases[0].solve()  # compiled and imported
    results, seconds = [], []
    for case in cases:
        started = time.process_time()
        results.append(case.solve())
        seconds.append(time.process_time() - started)
    return results, np.array(seconds)


def study(oil: str, count: int) -> pd.DataFrame:
    """One row for each accuracy."""
    truth, _ = solved(contacts(oil, count, "reference", "on"))
    exact = np.array([[getattr(result, name) for name in VALUES] for result in truth])
    rows = []
    for accuracy in ("fast", "standard"):
        _, cold = solved(contacts(oil, count, accuracy, "off"))
        results, hot = solved(contacts(oil, count, accuracy, "on"))
        change = np.abs(np.array([[getattr(result, name) for name in VALUES] for result in results]) / exact - 1.0)
        errors = np.column_stack([change[:, 0], change[:, 1:].max(axis=1)])
        stated = np.array([[r.friction_error, r.film_error] for r in results])
        rough = np.array([[r.friction_error, r.film_error] for r in truth])
        rows.append(
            {"oil": oil, "accuracy": accuracy, "contacts": count}
            | {"isothermal [ms]": 1e3 * np.median(cold), "with heat [ms]": 1e3 * np.median(hot)}
            | {"longest [ms]": 1e3 * hot.max(), "converged": np.mean([r.status == "converged" for r in results])}
            | {f"{name} error {q}": f(errors[:, k]) for k, name in enumerate(("mu", "film")) for q, f in PARTS.items()}
            | {f"{name} inside": np.mean(errors <= stated + rough, axis=0)[k] for k, name in enumerate(("mu", "film"))}
        )
    return pd.DataFrame(rows)


def by_contact(count: int) -> pd.DataFrame:
    """Time, values and stated error of every contact."""
    rows = []
    for oil in OILS:
        for accuracy in ("fast", "standard"):
            results, seconds = solved(contacts(oil, count, accuracy, "on"))
            for result, spent in zip(results, seconds, strict=True):
                values = {name: getattr(result, name) for name in (*VALUES, "friction_error", "film_error")}
                rows.append({"oil": oil, "accuracy": accuracy, "ms": 1e3 * spent} | values)
    return pd.DataFrame(rows)


def compare(before: Path, count: int) -> pd.DataFrame:
    """Two programs in turn, twice each."""
    tables: dict[Path, list[pd.DataFrame]] = {before: [], Path(__file__).parents[1]: []}
    for _ in range(2):
        for checkout, found in tables.items():
            with tempfile.TemporaryDirectory() as folder:
                out = Path(folder) / "contacts.csv"
                command = [sys.executable, __file__, "--count", str(count), "--contacts", str(out)]
                subprocess.run(command, env=os.environ | {"PYTHONPATH": str(checkout)}, check=True)
                found.append(pd.read_csv(out))
    then, now = (first.assign(ms=np.minimum(first["ms"], second["ms"])) for first, second in tables.values())
    moved = pd.DataFrame({name: (now[name] / then[name] - 1.0).abs() for name in VALUES})
    data = now[["oil", "accuracy"]].assign(
        then=then["ms"], now=now["ms"], mu=moved.iloc[:, 0], films=moved.iloc[:, 1:].max(axis=1)
    )
    data["mu/stated"] = data["mu"] / now["friction_error"]
    rows = []
    for (oil, accuracy), part in data.groupby(["oil", "accuracy"], sort=False):
        rows.append(
            {"oil": oil, "accuracy": accuracy, "then, median [ms]": part["then"].median()}
            | {"now, median [ms]": part["now"].median(), "sum, now over then": part["now"].sum() / part["then"].sum()}
            | {f"{name} moved, {q}": f(part[name]) for name in ("mu", "films") for q, f in PARTS.items()}
            | {"mu moved over stated, largest": part["mu/stated"].max()}
        )
    return pd.DataFrame(rows)


OILS = ("75w90", "fva3")
PARTS = {"median": np.median, "largest": np.max}


def main(argv: Sequence[str] | None = None) -> None:
    """Run from the command line."""
    parser = command_line(__doc__)
    parser.add_argument("--count", type=int, default=32)
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--before", type=Path, help="checkout of another program")
    parser.add_argument("--contacts", type=Path, help="only times and values of each contact, to this file")
    options = parser.parse_args(argv)
    if options.contacts:
        by_contact(options.count).to_csv(options.contacts, index=False)
        return
    if options.before:
        data, name = compare(options.before.resolve(), options.count), "smooth_heat_before.csv"
    else:
        data, name = pd.concat([study(oil, options.count) for oil in OILS]), "smooth_heat.csv"
    options.out.mkdir(parents=True, exist_ok=True)
    data.to_csv(options.out / name, index=False)
    print(data.T.to_string())


if __name__ == "__main__":
    main()
