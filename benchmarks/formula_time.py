"""Time of the formulas with Gaussian processes in gears, and what its shortcuts leave, against their plain sums.

    python benchmarks/formula_time.py --oil 75w90 --map 6

At full and 0.4 of the torque of five pairs, at 1500 rpm with oil of 90 degC and at 300 rpm and 120 degC: CPU seconds of
friction with its interval at all points of one state by the form, by compiled sums and by the plain ones, and of the
efficiency by the form and the processes; the largest difference of mu, and the error of the efficiency by rounds that
the form makes in place of the processes, stated and against all rounds with them. Then of a map. A line per state;
writes out/formula_time.csv.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pandas as pd
from common import OUT, command_line, write_rows

import efficiency
from efficiency.loss import friction_equilibrium
from regression.formula import Formula
from regression.friction.conditions import conditions_of
from regression.friction.gaussian_process import GpResidual, Sums, matern

PAIRS = (
    "fm_spiral_bevel_14x39",
    "fh_spiral_bevel_12x37",
    "fm_hypoid_13x42",
    "fh_hypoid_9x34",
    "fh_hypoid_9x34_offset_10",
)
STATES = (("1500 rpm", "90 degC"), ("300 rpm", "120 degC"))


def least(work: Callable[[], Any], times: int = 3) -> tuple[Any, float]:
    """What some work gives, and the least of its CPU milliseconds."""
    found = []
    for _ in range(times):
        clock = time.process_time()
        result = work()
        found.append(1e3 * (time.process_time() - clock))
    return result, min(found)


def plain(process: GpResidual) -> Sums:
    """Sums of a process by distances and exponentials of the libraries, all pairs at once."""
    points, weights = np.array(process.points), np.array(process.weights)

    def sums(scaled: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        covariance = matern(np.column_stack(scaled), points, process.variance)
        spread = covariance[:, : len(process.alpha)] @ process.root
        return covariance @ weights, np.sum(spread**2, axis=1)

    return sums


def row_of(loaded: Any, oil: str, point: dict[str, Any]) -> dict[str, Any]:
    """Times and differences of one state."""
    form, model = Formula.load(oil), Formula.load(f"{oil}_gp")
    loaded.efficiency(model, **point)  # what is made once
    by_form, form_ms = least(lambda: loaded.efficiency(form, **point))
    found, process_ms = least(lambda: loaded.efficiency(model, **point))
    settled = friction_equilibrium.form_of
    friction_equilibrium.form_of = lambda model: model
    whole = loaded.efficiency(model, **point)
    friction_equilibrium.form_of = settled
    state, card = found.points.state, found.card
    _, form_points = least(lambda: form.evaluate(state, card))
    fast, fast_points = least(lambda: model.evaluate(state, card))
    sums = tuple(plain(process) for process in model.formula.processes)
    table, ramp = model.formula.with_minimum_sliding(conditions_of(state, card))
    slow, slow_points = least(lambda: model.formula.friction(table, model.formula.boundary_friction, sums))
    return {
        "points": state.size,
        "points_form_ms": form_points,
        "points_processes_ms": fast_points,
        "points_plain_ms": slow_points,
        "mu_difference": float(np.nanmax(np.abs(fast.mu / (slow[0] * ramp) - 1.0))),
        "efficiency_form_ms": form_ms,
        "efficiency_processes_ms": process_ms,
        "efficiency": found.efficiency,
        "processes_less_form": found.efficiency - by_form.efficiency,
        "rounds_stated": found.efficiency_error_balance,
        "rounds_error": abs(found.efficiency - whole.efficiency),
        "whole_stated": whole.efficiency_error_balance,
    }


def main(argv: Sequence[str] | None = None) -> None:
    """Print and write."""
    parser = command_line(__doc__)
    parser.add_argument("--oil", action="append", default=[], help="Oil of shipped formulas; repeat for several.")
    parser.add_argument("--map", type=int, default=6, help="Torques and speeds of the map, each; 0 for none.")
    given = parser.parse_args(argv)
    oils, rows = given.oil or ["75w90", "fva3"], []
    for name in PAIRS:
        pair = efficiency.load(name)
        mesh, torque = pair.mesh("drive"), pair.design.operation.torque
        for share in (1.0, 0.4):
            loaded = mesh.load(share * torque)
            for oil in oils:
                for speed, temperature in STATES:
                    point = {"oil": oil, "speed": speed, "temperature": temperature}
                    rows.append({"design": name, "torque": share, **point, **row_of(loaded, oil, point)})
    table = pd.DataFrame(rows)
    print(table.to_string(index=False, float_format="{:.3g}".format))
    numbers = table.select_dtypes("number").drop(columns=["torque", "efficiency"])
    print(numbers.agg(["mean", "median", "max"]).T.to_string(float_format="{:.3g}".format))
    if given.map:
        pair = efficiency.load(PAIRS[0])
        mesh, torque = pair.mesh("drive"), pair.design.operation.torque
        axes = {
            "torque": list(np.linspace(0.2, 1.0, given.map) * torque),
            "speed": [f"{rpm:.0f} rpm" for rpm in np.geomspace(300.0, 4000.0, given.map)],
        }
        for model in (oils[0], f"{oils[0]}_gp"):
            _, spent = least(lambda model=model: mesh.over(model, **axes), 2)  # type: ignore[misc]
            print(f"map of {given.map} x {given.map} of {PAIRS[0]} by {model}: {1e-3 * spent:.2f} s")
    write_rows(OUT / "formula_time.csv", rows)


if __name__ == "__main__":
    main()
