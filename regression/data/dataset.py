"""The dataset of a run: one table, sorted by case key, with the derived variables, and what it came from."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from ehl.io.errors import InputError
from regression.data.row_format import NUMBER_UNITS, TIMING_UNITS
from regression.data.store import one_row_per_case, read_file, read_run, run_files
from regression.friction.conditions import DERIVED_UNITS, UNITS, Array, derive
from regression.friction.oil_cards import hashes_of_cards


@dataclass(frozen=True)
class Dataset:
    """All cases of a run.

    Parameters
    ----------
    frame : DataFrame
        One row per case, sorted by key; columns by the names of docs/nomenclature.md, SI.
    plan_name, plan_hash, solver_version, oil, oil_hash : str
        Where it comes from; `oil` is empty for a lubricant given by numbers, and for several oils, which stand in the
        column of that name.
    planned : int
        Cases of the whole plan.
    card_hashes : dict
        Oil to the hash of its card; None where one of several cards has changed since and they cannot be told apart.
    """

    frame: pd.DataFrame
    plan_name: str
    plan_hash: str
    solver_version: str
    oil: str
    oil_hash: str
    planned: int
    card_hashes: dict[str, str | None] = field(default_factory=dict)

    @property
    def units(self) -> dict[str, str]:
        """SI unit of every number column."""
        return {**UNITS, **NUMBER_UNITS}

    @property
    def oils(self) -> tuple[str, ...]:
        """Names of the oil cards in the data."""
        return tuple(sorted(name for name in self.frame["oil"].unique() if name))

    @property
    def converged(self) -> pd.DataFrame:
        """The rows with a result (those called unsettled have a wide interval, but they have one)."""
        return self.frame[self.frame["status"] != "failed"].reset_index(drop=True)

    @property
    def data_hash(self) -> str:
        """Hash of keys, status and all numbers but the wall times: equal for equal data, whoever computed them."""
        digest = hashlib.sha256()
        for name in ("key", "origin", "status", "reason"):
            digest.update("\n".join(self.frame[name]).encode())
        for name in NUMBER_UNITS:
            if name not in TIMING_UNITS:
                values = np.ascontiguousarray(self.frame[name].to_numpy(dtype="<f8"))
                # every not-a-number counts as the same
                digest.update(np.where(np.isnan(values), np.nan, values).astype("<f8").tobytes())
        return digest.hexdigest()


def load_dataset(run: Path) -> Dataset:
    """Read all result files of a run.

    Raises
    ------
    InputError
        There are no results, they belong to different runs, or a file cannot be read.
    """
    meta, frame = read_run(run)
    if frame.empty:
        raise InputError("run", str(run), "a run with at least one finished case", "Sweep first.")
    derived = derive({name: frame[name].to_numpy() for name in frame if name in UNITS})
    frame = frame.assign(**{name: derived[name] for name in DERIVED_UNITS})
    oils = tuple(name for name in str(meta["oil"]).split(", ") if name)
    return Dataset(
        frame,
        str(meta["plan_name"]),
        str(meta["plan_hash"]),
        str(meta["solver_version"]),
        oils[0] if len(oils) == 1 else "",
        str(meta["oil_hash"]),
        int(meta["count"]),
        hashes_of_cards(oils, str(meta["oil_hash"])),
    )


def columns(frame: pd.DataFrame) -> dict[str, Array]:
    """The variables of a dataset as the table a formula takes."""
    return {name: frame[name].to_numpy(dtype=float) for name in UNITS}


@dataclass(frozen=True)
class ShardStatus:
    """What one result file holds."""

    path: Path
    finished: int
    converged: int
    unsettled: int
    failed: dict[str, int]
    seconds: float


@dataclass(frozen=True)
class FailedCase:
    """A case without a result: its key, the reason, how many settings were tried, and where it lies."""

    key: str
    reason: str
    attempts: int
    seconds: float
    conditions: dict[str, float]


@dataclass(frozen=True)
class RunStatus:
    """How far a run is.

    Parameters
    ----------
    plan_name : str
        Name of the plan.
    planned, finished : int
        Cases of the plan, and distinct ones of them on disk.
    adaptive : int
        Cases on disk that an adaptive sweep added.
    failed : tuple of FailedCase
        Cases without a result, by reason.
    shards : tuple of ShardStatus
        One per file.
    longest : float
        Processor time of the longest case [s].
    """

    plan_name: str
    planned: int
    finished: int
    adaptive: int
    failed: tuple[FailedCase, ...]
    shards: tuple[ShardStatus, ...]
    longest: float = 0.0

    @property
    def complete(self) -> bool:
        """Whether every case of the plan is on disk."""
        return self.finished >= self.planned


def run_status(run: Path) -> RunStatus:
    """How far a run is; also while it is being computed.

    Raises
    ------
    InputError
        There are no results, or a file cannot be read.
    """
    shards, frames = [], []
    plan_name, planned = "", 0
    for path in run_files(run):
        # without lock, so that a running sweep is neither disturbed nor in the way
        meta, frame = read_file(path, locking=False)
        failed = frame[frame["status"] == "failed"]
        unsettled = int((frame["status"] == "unsettled").sum())
        converged = len(frame) - len(failed) - unsettled
        reasons = {str(reason): int(count) for reason, count in failed["reason"].value_counts().items()}
        seconds = float(frame["seconds_cpu"].sum())
        shards.append(ShardStatus(path, len(frame), converged, unsettled, reasons, seconds))
        frames.append(frame)
        plan_name, planned = str(meta["plan_name"]), int(meta["count"])
    every = one_row_per_case(frames)
    adaptive = int((every["origin"] == "adaptive").sum())
    lost = tuple(_failed_cases(every[every["status"] == "failed"]))
    longest = float(every["seconds_cpu"].max()) if len(every) else 0.0
    return RunStatus(plan_name, planned, len(every) - adaptive, adaptive, lost, tuple(shards), longest)


_WHERE = ("pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll", "temperature_oil")


def _failed_cases(frame: pd.DataFrame) -> Iterator[FailedCase]:
    for record in frame.sort_values(["reason", "key"]).to_dict("records"):
        where = {name: float(record[name]) for name in _WHERE}
        rough = float(np.hypot(record["roughness_rms_1"], record["roughness_rms_2"]))
        yield FailedCase(
            str(record["key"]),
            str(record["reason"]),
            int(record["attempts"]),
            float(record["seconds"]),
            {**where, "roughness_rms": rough},
        )


def export_table(dataset: Dataset, target: Path) -> None:
    """Write the dataset as CSV; the second line holds the units.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    units = [dataset.units.get(str(name), "") or "1" for name in dataset.frame]
    try:
        with target.open("w", encoding="utf-8", newline="") as file:
            file.write(",".join(map(str, dataset.frame.columns)) + "\n" + ",".join(units) + "\n")
            dataset.frame.to_csv(file, index=False, header=False, float_format="%.17g", lineterminator="\n")
    except OSError as error:
        raise InputError("target", str(target), "a writable path", f"{error.strerror}.") from None
