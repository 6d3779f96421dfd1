"""Random smooth contacts of the gear range: how many converge, how, at what cost.

    python validation/smooth_campaign.py --count 512 --accuracy standard --out validation/out

Prints a table, writes smooth_campaign_<rheology>_<accuracy>.csv and .png. Warm runs start from the result of a
neighbouring contact (3 % in pressure, 2 % in radius, 1 % in speed, 10 % in slip), as along a gear mesh. Times are CPU
times of the process (one thread).
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from common import OUT, command_line
from smooth_sample import contact_of, gear_range, neighbour

from ehl.smooth.solver import solve_steady

matplotlib.use("Agg")

INPUTS = ("pressure_hertz", "radius_equivalent", "speed_entrainment", "viscosity_inlet", "pressure_viscosity",
          "eyring_stress", "slide_to_roll")  # fmt: skip


def campaign(count: int, seed: int, rheology: str, accuracy: str) -> pd.DataFrame:
    """One row per contact."""
    rows = []
    solve_steady(*contact_of(next(iter(gear_range(1, 0))), rheology), accuracy=accuracy)  # compile
    for values in gear_range(count, seed):
        contact, lubricant = contact_of(values, rheology)
        started = time.process_time()
        result = solve_steady(contact, lubricant, accuracy=accuracy)
        cold = time.process_time() - started
        before = solve_steady(*contact_of(neighbour(values, -1.0), rheology), accuracy=accuracy)
        started = time.process_time()
        warm = solve_steady(contact, lubricant, accuracy=accuracy, start=before)
        load, material = contact.moes_groups(lubricant)
        rows.append(
            dict(zip(INPUTS, values, strict=True))
            | {
                "moes_load": load,
                "moes_material": material,
                "status": result.status,
                "reason": result.reason,
                "fallbacks": " ".join(result.fallbacks),
                "film_central": result.film_central,
                "film_min": result.film_min,
                "friction_fluid": result.friction_fluid,
                "pressure_max": result.pressure_max,
                "film_central_error": result.film_central_error,
                "film_min_error": result.film_min_error,
                "friction_error": result.friction_error,
                "mass_residual": result.mass_residual,
                "nodes": result.nodes,
                "iterations": result.iterations,
                "seconds_cold": cold,
                "warm_status": warm.status,
                "warm_fallbacks": " ".join(warm.fallbacks),
                "warm_iterations": warm.iterations,
                "seconds_warm": time.process_time() - started,
            }
        )
    return pd.DataFrame(rows)


def table(data: pd.DataFrame) -> str:
    """What the campaign shows, in lines."""
    total = len(data)
    lines = [f"contacts {total}, converged {np.mean(data.status == 'converged'):.2%}"]
    outcomes = Counter(zip(data.status, data.reason, data.fallbacks, strict=True))
    lines += [f"  {n:5d}  {' '.join(filter(None, key))}" for key, n in outcomes.most_common()]
    warm = Counter(zip(data.warm_status, data.warm_fallbacks, strict=True))
    lines += ["warm:"] + [f"  {n:5d}  {' '.join(filter(None, key))}" for key, n in warm.most_common()]
    good = data[data.status == "converged"]
    for name, scale, unit in (
        ("seconds_cold", 1e3, "ms"), ("seconds_warm", 1e3, "ms"), ("iterations", 1, ""), ("warm_iterations", 1, ""),
        ("nodes", 1, ""), ("film_central_error", 100, "%"), ("film_min_error", 100, "%"),
        ("friction_error", 100, "%"), ("mass_residual", 1, ""),
    ):  # fmt: skip
        low, high = np.quantile(good[name], [0.5, 0.95])
        most = good[name].max()
        lines.append(
            f"{name:>20s}: median {scale * low:9.3g}, 95 % {scale * high:9.3g}, max {scale * most:9.3g} {unit}"
        )
    return "\n".join(lines)


def plot(data: pd.DataFrame, path: Path) -> None:
    """Where in the Moes plane, and how long."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    kinds = {
        "converged": (data.status == "converged") & (data.fallbacks == ""),
        "converged with a fallback": (data.status == "converged") & (data.fallbacks != ""),
        "failed": data.status == "failed",
    }
    for (label, mask), colour in zip(kinds.items(), ("tab:green", "tab:orange", "tab:red"), strict=True):
        left.loglog(data.moes_load[mask], data.moes_material[mask], ".", color=colour, label=f"{label} ({mask.sum()})")
    left.set(xlabel="M", ylabel="L", title="random contacts of the gear range")
    left.legend(fontsize=8)
    for name in ("seconds_cold", "seconds_warm"):
        right.plot(np.sort(data[name]) * 1e3, np.linspace(0.0, 1.0, len(data)), label=name.removeprefix("seconds_"))
    right.set(xscale="log", xlabel="CPU time of one solution [ms]", ylabel="share of contacts", title="one core")
    right.legend()
    figure.savefig(path, dpi=130)
    plt.close(figure)


def main(argv: Sequence[str] | None = None) -> None:
    """Run the campaign from the command line."""
    parser = command_line(__doc__)
    parser.add_argument("--count", type=int, default=512)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rheology", choices=("eyring", "newtonian"), default="eyring")
    parser.add_argument("--accuracy", choices=("fast", "standard", "reference"), default="standard")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args(argv)
    data = campaign(options.count, options.seed, options.rheology, options.accuracy)
    print(table(data))
    options.out.mkdir(parents=True, exist_ok=True)
    name = options.out / f"smooth_campaign_{options.rheology}_{options.accuracy}"
    data.to_csv(name.with_suffix(".csv"), index=False)
    plot(data, name.with_suffix(".png"))


if __name__ == "__main__":
    main()
