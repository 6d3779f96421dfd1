"""Datasets by name: those that come with the program, beside the plan each was computed from."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ehl._data import data_names, named_file
from ehl.errors import InputError
from regression.dataset import Dataset, load_dataset

if TYPE_CHECKING:
    from regression.plan import Plan

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
    path = Path(run)
    if path.exists():
        return load_dataset(path)
    if str(run) in dataset_names():
        return load_dataset(named_file("run", FOLDER, run, SUFFIX))
    allowed = " or ".join(("a folder or file of results", *([", ".join(dataset_names())] if dataset_names() else [])))
    raise InputError("run", str(run), allowed, "Run `mixed-ehl sweep PLAN.toml -o RUN` first.")


def dataset_plan(name: str) -> Plan:
    """The plan a shipped dataset was computed from: the file of its name beside it.

    Raises
    ------
    InputError
        There is no such plan.
    """
    from regression.plan import load_plan

    return load_plan(named_file("plan", FOLDER, name))
