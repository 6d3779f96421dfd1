"""Stated errors, outcomes and cost of the shipped rough contacts: the tables of docs/validation_mixed.md.

    python -m validation mixed_data

`*_noise` holds every point with eight roughness profiles, so that stated errors can be compared with differences.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from common import OUT, command_line, write_rows

import regression

OILS = ("75w90", "80w90", "fva3", "eaxle", "pao220", "pg_0_1")
DATASETS = {part: [f"gear_{oil}{part}" for oil in OILS] for part in ("", "_mesh", "_film", "_noise", "_paths")}
POINT = [
    "pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll", "temperature_oil", "roughness_rms_1",
]  # fmt: skip


def outcomes(name: str, frame: pd.DataFrame) -> dict[str, object]:
    """Number by status, quantiles of the stated error [-] and of the processor time [s]."""
    row: dict[str, object] = {"data": name, "contacts": len(frame)}
    row |= {status: int((frame["status"] == status).sum()) for status in ("converged", "unsettled", "failed")}
    error = frame["friction_error"].dropna()
    row |= {f"error {level}": float(error.quantile(level)) for level in (0.5, 0.9)}
    return row | {f"seconds {level}": float(frame["seconds_cpu"].quantile(level)) for level in (0.5, 0.95, 1.0)}


def pairs(frame: pd.DataFrame) -> pd.DataFrame:
    """Difference of ln(mu) of two profiles of a point, both stated errors together, and the film ratio."""
    found = frame.dropna(subset=["friction_coefficient"]).groupby(POINT)
    two = [rows.iloc[i : i + 2] for _, rows in found for i in range(0, len(rows) - 1, 2)]
    return pd.DataFrame(
        {
            "difference": [abs(np.log(rows["friction_coefficient"]).diff().iloc[1]) for rows in two],
            "stated": [np.hypot(*rows["friction_error"]) for rows in two],
            "film_ratio": [rows["film_ratio"].iloc[0] for rows in two],
        }
    )


def main(argv: Sequence[str] | None = None) -> None:
    """Print both tables, the first of all oils together and also as CSV."""
    command_line(__doc__).parse_args(argv)
    frames = {
        f"gear{part}": pd.concat([regression.load_dataset(n).frame for n in names]) for part, names in DATASETS.items()
    }
    rows = [outcomes(name, frame) for name, frame in frames.items()]
    write_rows(OUT / "mixed_data.csv", rows)
    print(pd.DataFrame(rows).to_string(index=False, float_format="%.3g"))
    noise = {oil: pairs(frame) for oil, frame in frames["gear_noise"].groupby("oil")}
    whole = pd.concat(noise.values())
    for name, table in (noise | {"film ratio below 0.3": whole[whole["film_ratio"] < 0.3], "all": whole}).items():
        inside = float((table["difference"] <= table["stated"]).mean())
        print(f"{name}: {len(table)} pairs, {inside:.0%} inside; quantiles 0.5 and 0.9:")
        print(table[["difference", "stated"]].quantile([0.5, 0.9]).to_string(float_format="%.3g"))


if __name__ == "__main__":
    main()
