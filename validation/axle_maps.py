"""Torque loss of a shipped heavy truck axle against two measured axles of its ratio: figure and table for docs/axle.md.

Nothing is fitted: the axle file has the ratio, the ring gear and the oil volume of a measured axle, and usual bearings.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from common import OUT, command_line, write_rows
from matplotlib.figure import Figure

import efficiency

REFERENCE = Path(__file__).resolve().parents[1] / "data" / "reference" / "axle_maps.csv"
TEMPERATURES = {"vecto_tractor": 70.0, "ro440": 80.0, "ro440_loaded": 80.0}  # [degC], the first assumed


@dataclass(frozen=True)
class Compared:
    """Torque loss at the pinion at one point [N m]."""

    axle: str
    speed_rpm: float
    torque: float
    measured: float
    computed: float
    lower: float
    upper: float


def compared() -> list[Compared]:
    """Measured and computed torque loss at all points."""
    lines = [line for line in REFERENCE.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    axle, rows = efficiency.Axle("heavy_truck_hypoid"), []
    for row in csv.DictReader(lines):
        speed, torque = float(row["speed_rpm"]), float(row["torque_Nm"])
        point = axle.at(torque, f"{speed} rpm", f"{TEMPERATURES[row['axle']]} degC").points[0]
        losses = point.loss_total, point.loss_total_lower, point.loss_total_upper
        rows.append(
            Compared(row["axle"], speed, torque, float(row["torque_loss_Nm"]), *(p / point.speed for p in losses))
        )
    return rows


def statistics(rows: list[Compared]) -> list[dict[str, object]]:
    """Mean and scatter of ln(computed/measured), share inside the interval, and exponents over torque and speed."""
    found = []
    for name in dict.fromkeys(row.axle for row in rows):
        for kind, some in (
            ("without torque", [r for r in rows if r.axle == name and r.torque == 0.0]),
            ("under torque", [r for r in rows if r.axle == name and r.torque > 0.0]),
        ):
            if not some:
                continue
            ratio = np.log([r.computed / r.measured for r in some])
            inside = np.mean([r.lower <= r.measured <= r.upper for r in some])
            x = np.column_stack([np.ones(len(some)), np.log([r.speed_rpm for r in some])])
            if len({r.torque for r in some}) > 1:
                x = np.column_stack([x, np.log([r.torque for r in some])])
            slopes = [
                np.linalg.lstsq(x, np.log([getattr(r, k) for r in some]), rcond=None)[0]
                for k in ("measured", "computed")
            ]
            found.append(
                {
                    "axle": name,
                    "points": f"{kind}, {len(some)}",
                    "bias_%": round(100.0 * float(np.expm1(ratio.mean())), 1),
                    "sd_%": round(100.0 * float(ratio.std()), 1),
                    "inside_%": round(100.0 * float(inside)),
                    "speed_exponents": ", ".join(f"{s[1]:.2f}" for s in slopes),
                    "torque_exponents": ", ".join(f"{s[2]:.2f}" for s in slopes) if x.shape[1] > 2 else "",
                }
            )
    return found


def draw(rows: list[Compared], path: Path) -> None:
    """Torque loss over the speed at some torques, and over the torque at some speeds."""
    figure = Figure(figsize=(10.5, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    for colour, (name, marker) in enumerate((("vecto_tractor", "o"), ("ro440", "s"))):
        some = [row for row in rows if row.axle == name and row.torque == 0.0]
        speed = [row.speed_rpm for row in some]
        left.plot(speed, [r.measured for r in some], marker, color=f"C{colour}", label=f"{name}, measured")
        left.plot(
            speed, [r.computed for r in some], "-", color=f"C{colour}", label=f"computed, {TEMPERATURES[name]:.0f} °C"
        )
        left.fill_between(speed, [r.lower for r in some], [r.upper for r in some], color=f"C{colour}", alpha=0.15, lw=0)
    left.set(
        title="without torque", xlabel="pinion speed [rpm]", ylabel="torque loss at the pinion [N m]", ylim=(0.0, None)
    )
    for colour, speed in enumerate((143.0, 855.0, 1853.0)):
        some = [row for row in rows if row.axle == "vecto_tractor" and row.speed_rpm == speed]
        torque = [row.torque for row in some]
        right.plot(torque, [r.measured for r in some], "o", color=f"C{colour}", label=f"{speed:.0f} rpm, measured")
        right.plot(torque, [r.computed for r in some], "-", color=f"C{colour}", label=f"{speed:.0f} rpm, computed")
        right.fill_between(
            torque, [r.lower for r in some], [r.upper for r in some], color=f"C{colour}", alpha=0.12, lw=0
        )
    right.set(title="vecto_tractor", xlabel="pinion torque [N m]", ylabel="torque loss [N m]", ylim=(0.0, None))
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8, loc="upper left")
    figure.savefig(path, dpi=130)


def main(argv: Sequence[str] | None = None) -> None:
    """Draw the figure, write all points, print the table."""
    parser = command_line(__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs/figures"), help="folder of the figure")
    out = parser.parse_args(argv).out
    rows = compared()
    write_rows(OUT / "axle_maps.csv", rows)
    draw(rows, out / "axle_maps.png")
    for line in statistics(rows):
        print(" | ".join(str(value) for value in line.values()))


if __name__ == "__main__":
    main()
