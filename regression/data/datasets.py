"""Datasets by name: those that come with the program, beside the plan each was computed from."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import pandas as pd

from ehl.io.data import data_names, named_file
from ehl.io.errors import InputError
from regression.data.dataset import Dataset, load_dataset
from regression.data.store import LIBVER, merge

if TYPE_CHECKING:
    from regression.plan.plan import Plan

FOLDER = "datasets"
SUFFIX = ".h5"


def dataset_names() -> tuple[str, ...]:
    """Names of the datasets that come with the program."""
    return data_names(FOLDER, SUFFIX)


def named_dataset(run: str | Path) -> Dataset:
    """A run's results, or the shipped dataset of that name.

    Parameters
    ----------
    run : str or Path
        Folder or file of results, or one of `dataset_names`.

    Raises
    ------
    InputError
        Neither exists (the message lists the names there are), or the results cannot be read.
    """
    return load_dataset(results_path(run))


def results_path(run: str | Path) -> Path:
    """Folder or file of a run's results, or the file of the shipped dataset of that name; errors as `named_dataset`."""
    path = Path(run)
    if path.exists():
        return path
    if str(run) in dataset_names():
        return named_file("run", FOLDER, run, SUFFIX)
    allowed = " or ".join(("a folder or file of results", *([", ".join(dataset_names())] if dataset_names() else [])))
    raise InputError("run", str(run), allowed, "Run `mixed-ehl sweep PLAN.toml -o RUN` first.")


def joined(datasets: Sequence[Dataset]) -> Dataset:
    """The cases of several runs as one dataset; a case that several have counts once.

    Raises
    ------
    InputError
        The runs are of different solver versions, or of different figures under one oil's name.
    """
    if len(datasets) == 1:
        return datasets[0]
    versions = sorted({dataset.solver_version for dataset in datasets})
    if len(versions) > 1:
        raise InputError("run", ", ".join(versions), "runs of one solver version", "Sweep the older plan again.")
    cards: dict[str, str | None] = {}
    for dataset in datasets:
        own = dataset.card_hashes or dict.fromkeys(dataset.oils, dataset.oil_hash or None)
        for oil, card in own.items():
            if cards.setdefault(oil, card) != card:
                raise InputError("oil", oil, "one card of this oil in all runs", "Sweep with one set of figures.")
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


def dataset_plan(name: str) -> Plan:
    """The plan a shipped dataset was computed from: the file of its name beside it.

    Raises
    ------
    InputError
        There is no such plan.
    """
    from regression.plan.plan import load_plan

    return load_plan(named_file("plan", FOLDER, name))


def merge_compressed(run: Path, target: Path) -> int:
    """Write all rows of a run into one compressed file, as datasets are shipped; returns how many.

    The file is read like any other result file, and can be swept into as well.

    Raises
    ------
    InputError
        As `regression.data.store.merge`.
    """
    plain = target.with_name(target.name + ".plain")
    plain.unlink(missing_ok=True)
    if target.exists():
        raise InputError("target", str(target), "a file that does not exist yet")
    try:
        count = merge(run, plain)
        with h5py.File(plain, "r", libver=LIBVER) as source, h5py.File(target, "w", libver=LIBVER) as packed:
            packed.attrs.update(source.attrs)
            for name, column in source.items():
                small = column.shape == ()
                how = {} if small else {"compression": "gzip", "compression_opts": 9, "shuffle": True}
                size = {} if small else {"chunks": (max(min(len(column), 1024), 1),), "maxshape": (None,)}
                packed.create_dataset(name, data=column[()], dtype=column.dtype, **how, **size)
                packed[name].attrs.update(column.attrs)
    except OSError as error:
        raise InputError("target", str(target), "a file that can be written", f"{error}.") from None
    finally:
        plain.unlink(missing_ok=True)
    return count
