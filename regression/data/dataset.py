"""Datasets: results of one or more runs in one table, sorted by case key, with derived variables.

Shipped datasets are selected by name; their plans are in the same folder.
"""

import hashlib
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ehl.common.data import counted_reasons, data_names, named_file
from ehl.common.errors import InputError
from ehl.common.files import replacing
from ehl.common.pages import TableResult, Tabular
from ehl.common.progress import counted, duration
from ehl.common.quantities import quantity
from ehl.common.sections import Head, Medium, Section
from ehl.common.table import Column, Table
from ehl.common.table_reader import harmless
from ehl.fluid.oil import Oil
from ehl.fluid.pressure_viscosity import alpha_film
from ehl.fluid.viscosity import RoelandsLaw
from regression.data import result_files
from regression.friction.conditions import DERIVED_UNITS, UNITS, Array, derive
from regression.friction.oil_cards import hashes_of_cards

FOLDER = "datasets"
SUFFIX = ".h5"
_ROWS = 16_384
Source = str | os.PathLike[str]


@dataclass(frozen=True)
class Dataset(TableResult, Tabular):
    """All cases of one or more runs, from `load_dataset`.

    Parameters
    ----------
    frame : DataFrame
        One row per case, sorted by key, in SI units with the names of docs/nomenclature.md.
    plan_name, plan_hash, solver_version, oil, oil_hash : str
        Origin; `oil` is empty for a lubricant given by numbers and for several oils (see the column of that name).
    planned : int
        Cases of the whole plan.
    card_hashes : dict
        Hash of the card of each oil; None if a card has changed and the hashes cannot be assigned.

    Examples
    --------
    >>> from regression import load_dataset
    >>> dataset = load_dataset("gear_fva3")
    >>> dataset.oils
    ('fva3',)
    >>> dataset.to_frame(units=True)[["pressure_hertz [Pa]", "friction_coefficient"]].shape == (len(dataset), 2)
    True
    """

    frame: pd.DataFrame
    plan_name: str
    plan_hash: str
    solver_version: str
    oil: str
    oil_hash: str
    planned: int
    card_hashes: dict[str, str | None]

    @property
    def units(self) -> dict[str, str]:
        """SI unit of every numeric column."""
        return {**UNITS, **result_files.NUMBER_UNITS}

    @property
    def oils(self) -> tuple[str, ...]:
        """Names of the oil cards in the data."""
        return tuple(sorted(name for name in self.frame["oil"].unique() if name))

    @property
    def converged(self) -> pd.DataFrame:
        """The rows with a result, including unsettled ones."""
        return self.frame[self.frame["status"] != "failed"].reset_index(drop=True)

    @property
    def data_hash(self) -> str:
        """Hash of keys, status and all numbers except wall times, equal for equal data."""
        digest = hashlib.sha256()
        for name in ("key", "origin", "status", "reason"):
            digest.update("\n".join(self.frame[name]).encode())
        for name in result_files.NUMBER_UNITS:
            if name not in result_files.TIMING_UNITS:
                values = np.ascontiguousarray(self.frame[name].to_numpy(dtype="<f8"))
                # one bit pattern for all nan
                digest.update(np.where(np.isnan(values), np.nan, values).astype("<f8").tobytes())
        return digest.hexdigest()

    def __len__(self) -> int:
        return len(self.frame)

    def to_frame(self, *, units: bool = False) -> pd.DataFrame:
        """The cases as a table, one row per case, sorted by key.

        Parameters
        ----------
        units : bool
            Name the columns with their SI units, as ``pressure_hertz [Pa]``.
        """
        if not units:
            return self.frame.copy()
        return self.frame.rename(columns={name: f"{name} [{unit}]" for name, unit in self.units.items() if unit})

    def save(self, path: str | Path) -> None:
        """Write the cases as CSV with the units in the second line; `InputError` if that is not possible."""
        frame, units = self.frame.copy(), [self.units.get(str(name), "") or "1" for name in self.frame]
        for name in frame.select_dtypes(exclude=["number", "bool"]):
            frame[name] = frame[name].map(harmless)
        frame.columns = pd.MultiIndex.from_arrays([frame.columns, units])
        with replacing(Path(path), "target") as draft:
            frame.to_csv(draft, index=False, float_format="%.17g", lineterminator="\n", encoding="utf-8")

    def to_dict(self) -> dict[str, Any]:
        """Origin and number of the cases, and the range of the main quantities, for JSON in SI units."""
        counts = self.frame["status"].value_counts()
        return {
            "plan": self.plan_name,
            "solver": self.solver_version,
            "oils": list(self.oils),
            "planned": self.planned,
            "cases": len(self.frame),
            **{status: int(counts.get(status, 0)) for status in ("converged", "unsettled", "failed")},
            "ranges": {name: (float(self.frame[name].min()), float(self.frame[name].max())) for name in _SUMMARY},
        }

    def __repr__(self) -> str:
        c = self.to_dict()
        low, high = c["ranges"]["friction_coefficient"]
        return (
            f"Dataset {self.plan_name!r}: {counted(c['cases'], 'case')} ({c['converged']} converged, "
            f"{c['unsettled']} unsettled, {c['failed']} failed), "
            f"{', '.join(self.oils) or 'lubricant by numbers'}, {self.solver_version}; "
            f"friction_coefficient {low:.4f} to {high:.4f}"
        )

    def table(self) -> Table:
        """Minimum, median and maximum of the main quantities."""
        rows = self.converged[list(_SUMMARY)].agg(["min", "median", "max"])
        names = ("minimum", "median", "maximum")
        cells = [(name, *row) for name, row in zip(names, rows.itertuples(index=False), strict=True)]
        return Table(("", *_SUMMARY), cells, title=repr(self), vertical=True)


# main quantities of a dataset
_SUMMARY = (
    *("pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll_total"),
    *("temperature_oil", "roughness_rms", "film_ratio", "friction_coefficient"),
)


def load_dataset(*runs: Source | Dataset) -> Dataset:
    """Read the results of one or more runs.

    Parameters
    ----------
    *runs : str, path, Run or Dataset
        Folders or files of results, or names of shipped datasets (`ehl.shipped`). Duplicate cases count once.

    Returns
    -------
    Dataset

    Raises
    ------
    InputError
        There are no results, they cannot be read, they are of different solver versions, or the properties of one oil
        differ between them.

    Examples
    --------
    >>> from regression import load_dataset
    >>> both = load_dataset("gear_75w90", "gear_fva3")
    >>> both.oils
    ('75w90', 'fva3')
    """
    if not runs:
        raise InputError("run", None, "at least one folder or file of results, or a shipped dataset")
    return _joined([run if isinstance(run, Dataset) else _read(results_path(run)) for run in runs])


def results_path(run: Source) -> Path:
    """Folder or file of the results of a run, or the file of the shipped dataset of that name.

    Raises `InputError`: neither exists; the message lists the available names.
    """
    path = Path(run)
    if os.path.exists(path):
        return path
    if str(run) in (names := data_names(FOLDER, SUFFIX)):
        return named_file("run", FOLDER, str(run), SUFFIX)
    allowed = " or ".join(filter(None, ("a folder or file of results", ", ".join(names))))
    raise InputError("run", str(run), allowed, "Run `mixed-ehl sweep PLAN.toml -o RUN` first.")


def _read(run: Path) -> Dataset:
    meta, rows = result_files.read_run(run)
    if not len(rows):
        raise InputError("run", str(run), "a run with at least one finished case", "Run the sweep first.")
    frame = result_files.table_of(rows)
    # in blocks of rows, as the law of an oil needs the memory of hundreds of numbers per row
    film = [_film_coefficient(frame[start : start + _ROWS]) for start in range(0, len(frame), _ROWS)]
    frame = frame.assign(pressure_viscosity_film=np.concatenate(film))
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


def _film_coefficient(frame: pd.DataFrame) -> Array:
    """alpha_film of every row [1/Pa], which is not stored: from alpha and the law of the card.

    Rows without an available card use the Roelands law through eta0 and alpha, or the Barus law if it gives the stored
    viscosity at the mean pressure.
    """
    alpha = frame["pressure_viscosity"].to_numpy(dtype=float)
    viscosity = frame["viscosity_inlet"].to_numpy(dtype=float)
    temperature = frame["temperature_oil"].to_numpy(dtype=float)
    rise = np.log(frame["viscosity_mean_pressure"].to_numpy(dtype=float) / viscosity)
    barus = np.abs(rise - alpha * 0.25 * np.pi * frame["pressure_hertz"].to_numpy(dtype=float)) < 1e-6 * np.abs(rise)
    roelands = alpha_film(RoelandsLaw(viscosity, alpha, temperature, 0.0))  # type: ignore[arg-type]
    film: Array = np.where(barus, alpha, roelands)
    for name in frame["oil"].unique():
        try:
            card = Oil.load(name) if name else None
        except InputError:
            card = None
        if card is not None:
            rows = (frame["oil"] == name).to_numpy()
            lubricant = card.at(temperature[rows])
            film[rows] = alpha[rows] * lubricant.pressure_viscosity_film / lubricant.pressure_viscosity
    return film


def _joined(datasets: Sequence[Dataset]) -> Dataset:
    if len(datasets) == 1:
        return datasets[0]
    versions = sorted({dataset.solver_version for dataset in datasets})
    if len(versions) > 1:
        raise InputError("run", ", ".join(versions), "runs of one solver version", "Repeat the older sweep.")
    cards: dict[str, str | None] = {}
    for dataset in datasets:
        for oil, card in dataset.card_hashes.items():
            if cards.setdefault(oil, card) != card:
                raise InputError("oil", oil, "one card of this oil in all runs", "Repeat the sweeps with one card.")
    frame = pd.concat([dataset.frame for dataset in datasets], ignore_index=True)
    frame = frame.drop_duplicates("key").sort_values("key", ignore_index=True)
    hashes = "\n".join(sorted(dataset.plan_hash for dataset in datasets))
    named = {dataset.oil for dataset in datasets}
    return Dataset(
        frame,
        " + ".join(dict.fromkeys(dataset.plan_name for dataset in datasets)),
        hashlib.sha256(hashes.encode()).hexdigest(),
        versions[0],
        named.pop() if len(named) == 1 else "",
        "\n".join(dict.fromkeys(dataset.oil_hash for dataset in datasets)),
        sum(dataset.planned for dataset in datasets),
        cards,
    )


def columns(frame: pd.DataFrame) -> dict[str, Array]:
    """The variables of a dataset as the input table of a formula."""
    return {name: frame[name].to_numpy(dtype=float) for name in UNITS}


@dataclass(frozen=True)
class ShardStatus:
    """Content of one result file."""

    path: Path
    finished: int
    converged: int
    unsettled: int
    failed: dict[str, int]
    seconds: float


@dataclass(frozen=True)
class FailedCase:
    """A case without a result."""

    key: str
    reason: str
    attempts: int  # number of settings tried
    seconds: float
    conditions: dict[str, float]  # SI units


@dataclass(frozen=True)
class RunStatus(TableResult):
    """Progress of a run."""

    plan_name: str
    planned: int  # cases of the plan
    finished: int  # distinct cases on disk
    failed: tuple[FailedCase, ...]  # cases without a result, by reason
    shards: tuple[ShardStatus, ...]  # one per file
    seconds: float  # processor time of these cases [s]
    longest: float  # and of the longest one [s]

    @property
    def complete(self) -> bool:
        """Whether every case of the plan is on disk."""
        return self.finished >= self.planned

    def to_dict(self) -> dict[str, Any]:
        """Content for JSON."""
        shards = [{**asdict(shard), "path": str(shard.path)} for shard in self.shards]
        return {**asdict(self), "shards": shards, "complete": self.complete}

    def table(self) -> Table:
        """One row per result file."""
        rows = [
            (s.path.name, s.finished, s.converged, s.unsettled, counted_reasons(s.failed) or 0, s.seconds)
            for s in self.shards
        ]
        columns = ("file", "finished", "converged", "unsettled", "failed", Column("seconds_cpu", label="CPU time"))
        title = f"{self.plan_name}: {self.finished} of {counted(self.planned, 'case')}"
        note = f"CPU time of all cases {duration(self.seconds)}, of the longest {duration(self.longest)}"
        return Table(columns, rows, title=title, notes=(note,))

    def failed_table(self) -> Table:
        """One row per case without a result: reason, key, attempts, conditions, wall time."""
        shown = [Column(name, label=quantity(name).symbol, digits=3) for name in _WHERE]
        rows = [(c.reason, c.key[:12], c.attempts, *c.conditions.values(), c.seconds) for c in self.failed]
        title = counted(len(self.failed), "failed case")
        return Table(("reason", "key", "attempts", *shown, Column("seconds", label="t")), rows, title=title)

    def sections(self, medium: Medium = "page", *args: Any, **options: Any) -> list[Section]:
        """Result files and failed cases."""
        failed = [self.failed_table()] if self.failed and medium != "terminal" else []
        return [Section("", [Head(self.table().title), self.table(), *failed])]


_WHERE = (
    *("pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll", "temperature_oil"),
    "roughness_rms",
)
_OF_STATUS = (
    *("key", "status", "reason", "attempts", "seconds", "seconds_cpu", *_WHERE[:-1]),
    *("roughness_rms_1", "roughness_rms_2"),
)


def run_status(run: Path) -> RunStatus:
    """Progress of a run, which may still be in progress.

    Raises `InputError`: there are no results, a file cannot be read, or the files belong to different runs.
    """
    shards, parts = [], []
    files = result_files.files_of_one_run(run)
    for path, (_, rows) in files.items():
        frame = result_files.table_of(rows, _OF_STATUS)
        found = frame["status"].value_counts()
        converged, unsettled = (int(found.get(status, 0)) for status in ("converged", "unsettled"))
        failed = frame.loc[frame["status"] == "failed", "reason"].value_counts()
        reasons = {str(reason): int(count) for reason, count in failed.items()}
        seconds = float(frame["seconds_cpu"].sum())
        shards.append(ShardStatus(path, len(frame), converged, unsettled, reasons, seconds))
        parts.append(rows)
    every = result_files.table_of(result_files.one_row_per_case(parts), _OF_STATUS)
    every["roughness_rms"] = np.hypot(every["roughness_rms_1"], every["roughness_rms_2"])
    failures = tuple(
        FailedCase(r["key"], r["reason"], int(r["attempts"]), r["seconds"], {name: r[name] for name in _WHERE})
        for r in every[every["status"] == "failed"].sort_values(["reason", "key"]).to_dict("records")
    )
    seconds, longest = (float(times) for times in every["seconds_cpu"].agg(["sum", "max"]).fillna(0.0))
    meta = files[shards[0].path][0]
    counts = int(meta["count"]), len(every)
    return RunStatus(str(meta["plan_name"]), *counts, failures, tuple(shards), seconds, longest)
