"""Table and figure of a stress campaign, and what its two passes together say of the whole sample."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from scipy.stats import beta
from stress import LEFT
from stress_cases import MODULUS

MEASURES = (
    "case_seconds", "memory_mb", "nodes", "steps", "iterations_per_step", "steps_relaxed", "steps_continued",
    "steps_slow", "steps_lagged", "steps_unconverged", "net_exchange", "mesh_error", "statistical_error",
    "friction_error",
)  # fmt: skip
COLORS = {
    "converged": "tab:green", "with fallback": "tab:olive", "unsettled": "tab:orange", "refused": "tab:red",
    "wrong": "black",
}  # fmt: skip
SOLVED = ("converged", "with fallback")
NOT_DRAWN = "left, not drawn"


def report(folder: Path, kind: str) -> None:
    """Print and write table and figure of all files of this range."""
    first = _read(sorted(folder.glob(f"stress_{kind}_seed*.csv")))
    second = _read(sorted(folder.glob(f"again_{kind}_seed*.csv")))
    if second.empty:
        text, data = table(first), first
    else:
        left = first[first.reason.isin(LEFT)]
        known = first[~first.reason.isin(LEFT)]
        parts = ("both passes", combined(known, len(left), second), "\nfirst pass, without those it left", table(known))
        text = "\n".join((*parts, "\nsecond pass", table(second)))
        rest = left[~left["index"].isin(second["index"])].assign(outcome=NOT_DRAWN)
        data = pd.concat([rest, known, second], ignore_index=True)
    print(text)
    (folder / f"stress_{kind}.txt").write_text(text + "\n", encoding="utf-8")
    plot(data, folder / f"stress_{kind}.png")


def _read(files: list[Path]) -> pd.DataFrame:
    if not files:
        return pd.DataFrame()
    data = pd.concat([pd.read_csv(file) for file in files], ignore_index=True)
    data["reason"] = data["reason"].fillna("")
    return data


def combined(known: pd.DataFrame, left: int, second: pd.DataFrame) -> str:
    """Outcomes of the whole sample: those known, and of those left the shares the second pass found.

    The range behind a share is the 90 % interval of Clopper and Pearson of what the second pass drew.
    """
    total = len(known) + left
    lines = [f"{total} contacts, {left} left by the first pass, {len(second)} of them solved in the second"]

    def line(name: str, among_known: int, among_second: int) -> str:
        low, high = proportion(among_second, len(second))
        share, low, high = ((among_known + left * p) / total for p in (among_second / len(second), low, high))
        return f"{share:7.1%} ({low:.1%} to {high:.1%})  {name}: {among_known} + {among_second} of {len(second)}"

    lines.append(line("converged, with fallback or not", *(int(d.outcome.isin(SOLVED).sum()) for d in (known, second))))
    for outcome in COLORS:
        lines.append(line(outcome, *(int((d.outcome == outcome).sum()) for d in (known, second))))
    for outcome in ("unsettled", "refused"):
        reasons = [Counter(d[d.outcome == outcome].reason) for d in (known, second)]
        for name in sorted(set().union(*reasons), key=lambda name: -sum(r[name] for r in reasons)):
            lines.append("     " + line(f"{outcome}, {name}", *(r[name] for r in reasons)))
    return "\n".join(lines)


def proportion(count: int, total: int, level: float = 0.90) -> tuple[float, float]:
    """Interval of Clopper and Pearson of a share."""
    tail = 0.5 * (1.0 - level)
    low = beta.ppf(tail, count, total - count + 1) if count else 0.0
    high = beta.ppf(1.0 - tail, count + 1, total - count) if count < total else 1.0
    return float(low), float(high)


def table(data: pd.DataFrame) -> str:
    """Counts by outcome and reason, and what a case cost."""
    total = len(data)
    lines = [f"{total} contacts"]
    for outcome in COLORS:
        part = data[data.outcome == outcome]
        lines.append(f"{len(part):6d} {len(part) / total:7.1%}  {outcome}")
        lines += [f"       {n:6d}  {name}" for name, n in Counter(part.reason).most_common() if name]
    interval = ((data.outcome == "unsettled") & (data.reason == "statistical_interval")).mean()
    lines.append(
        f"converged {data.outcome.isin(SOLVED).mean():.1%}; {interval:.1%} more solved with an interval of mu beyond "
        "the tolerance"
    )
    rough = data[data.steps.notna()] if "steps" in data else data
    for name in MEASURES:
        values = rough[name].dropna()
        if len(values):
            low, high = np.quantile(values, [0.5, 0.95])
            lines.append(f"{name:>20s}: median {low:9.3g}, 95 % {high:9.3g}, max {values.max():9.3g}")
    return "\n".join(lines)


def plot(data: pd.DataFrame, path: Path) -> None:
    """Where the outcomes lie."""
    half_width = 4.0 * data.radius_equivalent * data.pressure_hertz / MODULUS
    planes = (
        ("pressure_hertz", data.pressure_hertz, "viscosity_inlet x speed_entrainment [N/m]",
         data.viscosity_inlet * data.speed_entrainment),
        ("half_width / correlation_length", half_width / data.correlation_length, "film_ratio", data.film_ratio),
        ("slide_to_roll", data.slide_to_roll, "pressure_viscosity x pressure_hertz",
         data.pressure_viscosity * data.pressure_hertz),
    )  # fmt: skip
    figure, axes = plt.subplots(1, 3, figsize=(15, 4.5), layout="constrained")
    for axis, (name_x, x, name_y, y) in zip(axes, planes, strict=True):
        for outcome, color in ({NOT_DRAWN: "lightgray"} | COLORS).items():
            mask = (data.outcome == outcome) & np.isfinite(y)
            if outcome == NOT_DRAWN and not mask.any():
                continue
            axis.plot(x[mask], y[mask], ".", color=color, ms=4, label=f"{outcome} ({(data.outcome == outcome).sum()})")
        axis.set(xlabel=name_x, ylabel=name_y, yscale="log", xscale="linear" if "slide" in name_x else "log")
    axes[0].legend(fontsize=8)
    figure.savefig(path, dpi=130)
    plt.close(figure)
