"""Stated errors, outcomes and cost of the shipped rough contacts: the tables of docs/validation_mixed.md.

    python -m validation mixed_data

`*_noise` holds every point with eight roughness profiles, so that stated errors can be compared with deviations.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from common import OUT, command_line, write_rows

import regression

OILS = ("75w90", "80w90", "fva3", "eaxle", "pao220", "pg_0_1")
PARTS = ("", "_mesh", "_film", "_fast", "_rapid", "_pairs", "_hot", "_uncertain", "_noise", "_hot_noise", "_paths")
DATASETS = {part: [f"gear_{oil}{part}" for oil in OILS] for part in PARTS}
POINT = [
    "pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll", "temperature_oil", "roughness_rms_1",
]  # fmt: skip
SHARES = (0.0, 0.001, 0.1, 0.3, 0.6, 0.9, 0.96, 1.0)  # classes of the asperity load share


def outcomes(name: str, frame: pd.DataFrame) -> dict[str, object]:
    """Number by status, quantiles of the stated error [-] and of the processor time [s]."""
    row: dict[str, object] = {"data": name, "contacts": len(frame)}
    row |= {status: int((frame["status"] == status).sum()) for status in ("converged", "unsettled", "failed")}
    error = frame["friction_error"].dropna()
    row |= {f"error {level}": float(error.quantile(level)) for level in (0.5, 0.9)}
    return row | {f"seconds {level}": float(frame["seconds_cpu"].quantile(level)) for level in (0.5, 0.95, 1.0)}


def deviations(frame: pd.DataFrame) -> pd.DataFrame:
    """Deviation of ln(mu) of each rough contact from the mean of the other profiles of its point, and stated errors.

    It is divided by the root of 1 + 1/n for the error of that mean of n profiles. `numerical`: of time mean and mesh.
    """
    rough = frame[frame["friction_coefficient"].notna() & (frame["statistical_error"] > 0.0)]
    friction = np.log(rough["friction_coefficient"]).groupby([rough[name] for name in POINT])
    count = friction.transform("count")
    deviation = (np.log(rough["friction_coefficient"]) - friction.transform("mean")).abs()
    numerical = np.hypot(rough["statistical_error"], rough["mesh_error"])
    table = rough[["oil", "film_ratio", "asperity_load_share", "friction_error"]]
    return table.assign(deviation=deviation * np.sqrt(count / (count - 1)), numerical=numerical)[count > 1]


def main(argv: Sequence[str] | None = None) -> None:
    """Print both tables, the first of all oils together and also as CSV."""
    command_line(__doc__).parse_args(argv)
    frames = {
        f"gear{part}": pd.concat([regression.load_dataset(n).frame for n in names]) for part, names in DATASETS.items()
    }
    rows = [outcomes(name, frame) for name, frame in frames.items()]
    write_rows(OUT / "mixed_data.csv", rows)
    print(pd.DataFrame(rows).to_string(index=False, float_format="%.3g"))
    found = deviations(pd.concat([frames["gear_noise"], frames["gear_hot_noise"]]))
    shares = pd.cut(found["asperity_load_share"], SHARES, include_lowest=True)
    for by in (found["oil"], shares, pd.Series("all", found.index)):
        for name, table in found.groupby(by, observed=True):
            inside = [f"{(table['deviation'] <= table[error]).mean():.0%}" for error in ("numerical", "friction_error")]
            print(f"{name}: {len(table)} contacts, inside numerical and stated error {inside}; quantiles 0.5 and 0.9:")
            quantiles = table[["deviation", "numerical", "friction_error"]].quantile([0.5, 0.9])
            print(quantiles.to_string(float_format="%.3g"))


if __name__ == "__main__":
    main()
