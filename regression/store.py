"""Results on disk: one HDF5 file per shard, one writer per file, columns that grow, the key written last.

A row counts only when its key is on disk, and the key column is extended after everything else was flushed. A process
that dies loses at most the rows since the last flush; whatever it tore is cut off at the next opening.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import h5py
import numpy as np
import pandas as pd

from ehl.errors import InputError
from regression import __version__
from regression.conditions import LUBRICANT_UNITS, STATE_UNITS

STORE_SCHEMA = 1
# the oldest format of the superblock has no "opened for writing" mark, which a killed writer would leave behind
_LIBVER = ("earliest", "v110")
_CHUNK = 256

OUTPUT_UNITS: dict[str, str] = {
    "friction_coefficient": "",
    "friction_fluid": "",
    "friction_asperity": "",
    "film_central": "m",
    "film_min": "m",
    "pressure_max": "Pa",
    "film_ratio": "",
    "asperity_load_share": "",
    "roughness_load_share": "",
    "rolling_traction": "",
    "temperature_film_max": "K",
    "temperature_flash": "K",
    "film_error": "",
    "friction_error": "",
    "mesh_error": "",
    "statistical_error": "",
    "friction_boundary_half": "",
    "friction_boundary_double": "",
    "iterations": "",
}
# wall time is provenance: it differs from run to run and is no part of the data
TIMING_UNITS: dict[str, str] = {"seconds": "s"}
NUMBER_UNITS: dict[str, str] = {
    **STATE_UNITS,
    **LUBRICANT_UNITS,
    "boundary_friction": "",
    **OUTPUT_UNITS,
    **TIMING_UNITS,
}
TEXT_WIDTHS: dict[str, int] = {"origin": 8, "status": 12, "reason": 64, "skipped": 256}
KEY_WIDTH = 64

# what all files of one run share
_SHARED = ("plan", "plan_name", "plan_hash", "solver_version", "oil", "oil_hash", "bodies_hash", "count")
# what must not have changed when a run goes on
_SAME = {
    "plan_hash": "another plan",
    "solver_version": "another version of the solver",
    "oil_hash": "an oil card with other figures",
    "bodies_hash": "materials with other figures",
}


class ResultStore:
    """One result file, open for writing.

    Parameters
    ----------
    path : Path
        The file; made if there is none.
    meta : mapping
        What the run is, by the names of `regression.sweep.run_meta`; an existing file must be of the same run.

    Raises
    ------
    InputError
        The file belongs to another run, has a newer schema, is damaged, or another process writes to it.
    """

    def __init__(self, path: Path, meta: Mapping[str, str | int]) -> None:
        self.path = path
        if not path.exists():
            _create(path, meta)
        with _undamaged(path):
            self._file = _open(path, "r+")
            try:
                _check_schema(self._file, path)
                for name, what in _SAME.items():
                    if _attribute(self._file, name) != meta[name]:
                        hint = f"It holds results of {what}; give another output folder."
                        raise InputError("run", str(path), "a folder of this plan's own results", hint)
                self.torn = self._cut_torn_rows()
            except BaseException:
                self._file.close()
                raise

    def _cut_torn_rows(self) -> int:
        """Cut every column back to the rows whose key is on disk; returns how many rows were cut."""
        columns = [self._file[name] for name in (*NUMBER_UNITS, *TEXT_WIDTHS)]
        keys = self._file["key"]
        whole = min(len(keys), *(len(column) for column in columns))
        # a key of zeros was allocated and never written
        stored = keys[:whole]
        blank = np.flatnonzero(stored == b"")
        whole = int(blank[0]) if blank.size else whole
        longest = max(len(keys), *(len(column) for column in columns))
        if longest > whole:
            for column in (keys, *columns):
                column.resize((whole,))
            self._file.flush()
        return longest - whole

    def keys(self, *, converged_only: bool = False) -> set[str]:
        """Keys of the cases on disk: all of them, or those that converged."""
        with _undamaged(self.path):
            keys, status = self._file["key"][:], self._file["status"][:]
            return {k.decode() for k, s in zip(keys, status, strict=True) if s == b"converged" or not converged_only}

    def append(self, rows: Sequence[Mapping[str, Any]]) -> None:
        """Write rows and put them on disk; the keys go last.

        Raises
        ------
        InputError
            The disk is full or gone; what was on it before stays valid.
        """
        if not rows:
            return
        try:
            self._write(rows)
        except OSError as error:
            hint = f"{error}. Make room and give the same command again."
            raise InputError("run", str(self.path), "a disk that can be written", hint) from None

    def _write(self, rows: Sequence[Mapping[str, Any]]) -> None:
        start, stop = len(self._file["key"]), len(self._file["key"]) + len(rows)
        for name in NUMBER_UNITS:
            column = self._file[name]
            column.resize((stop,))
            column[start:] = [float(row.get(name, np.nan)) for row in rows]
        for name, width in TEXT_WIDTHS.items():
            column = self._file[name]
            column.resize((stop,))
            column[start:] = [str(row[name]).encode("ascii", "replace")[:width] for row in rows]
        self._to_disk()
        keys = self._file["key"]
        keys.resize((stop,))
        keys[start:] = [row["key"].encode() for row in rows]
        self._to_disk()

    def _to_disk(self) -> None:
        self._file.flush()
        # past the system's cache too, so that the order of data and keys holds if the power fails
        os.fsync(self._file.id.get_vfd_handle())

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _create(path: Path, meta: Mapping[str, str | int]) -> None:
    """Make an empty result file; it appears under its name only when it is whole."""
    draft = path.with_name(f"{path.name}.{os.getpid()}.new")
    try:
        with h5py.File(draft, "w", libver=_LIBVER) as file:
            file.attrs["schema"] = STORE_SCHEMA
            file.attrs["writer"] = f"mixed-ehl {__version__}"
            for name, value in meta.items():
                file.attrs[name] = value
            for name, unit in NUMBER_UNITS.items():
                column = file.create_dataset(name, (0,), "f8", maxshape=(None,), chunks=(_CHUNK,), fillvalue=np.nan)
                column.attrs["unit"] = unit or "1"
            for name, width in (*TEXT_WIDTHS.items(), ("key", KEY_WIDTH)):
                column = file.create_dataset(name, (0,), f"S{width}", maxshape=(None,), chunks=(_CHUNK,))
                column.attrs["unit"] = "text"
        draft.replace(path)
    except OSError as error:
        raise InputError("run", str(path), "a folder that can be written", f"{error}.") from None


def _open(path: Path, mode: str, locking: bool = True) -> h5py.File:
    try:
        # some network file systems cannot lock; there one writer per file is the user's care
        return h5py.File(path, mode, libver=_LIBVER, locking="best-effort" if locking else False)
    except OSError as error:
        # HDF5 speaks of blocks too: only these words mean a lock
        if isinstance(error, BlockingIOError) or "unable to lock file" in str(error):
            hint = "Is the same shard running?"
            raise InputError("run", str(path), "a file no other process writes to", hint) from None
        raise _damaged(path, error) from None


def _damaged(path: Path, error: Exception) -> InputError:
    hint = f"It is damaged or no result file ({error}); move it away and sweep again to compute its cases."
    return InputError("run", str(path), "a readable result file", hint)


@contextmanager
def _undamaged(path: Path) -> Iterator[None]:
    """Whatever reading a damaged file raises in the block becomes one sentence that names the file."""
    try:
        yield
    except InputError:
        raise
    except (OSError, RuntimeError, KeyError, TypeError, ValueError) as error:
        raise _damaged(path, error) from None


def _attribute(file: h5py.File, name: str) -> Any:
    value = file.attrs.get(name)
    return int(value) if isinstance(value, np.integer) else value


def _check_schema(file: h5py.File, path: Path) -> None:
    schema = _attribute(file, "schema")
    if not isinstance(schema, int):
        raise InputError("run", str(path), "a result file of `mixed-ehl sweep`", "It holds no schema number.")
    if schema > STORE_SCHEMA:
        raise InputError(
            f"{path.name}.schema",
            schema,
            f"at most {STORE_SCHEMA}",
            f"It was written by the newer version {_attribute(file, 'writer')}; update mixed-ehl to read it.",
        )
    lacking = [name for name in ("key", *NUMBER_UNITS, *TEXT_WIDTHS) if name not in file]
    if lacking:
        hint = f"It lacks {', '.join(lacking[:5])}: damaged, or of an unfinished version. Move it away and sweep again."
        raise InputError("run", str(path), "a result file with all columns", hint)


def read_file(path: Path, *, locking: bool = True) -> tuple[dict[str, Any], pd.DataFrame]:
    """Attributes and whole rows of one result file.

    Raises
    ------
    InputError
        The file is being written, damaged, foreign, or has a newer schema.
    """
    with _undamaged(path), _open(path, "r", locking) as file:
        _check_schema(file, path)
        whole = min(len(file[name]) for name in ("key", *NUMBER_UNITS, *TEXT_WIDTHS))
        table: dict[str, Any] = {"key": [key.decode() for key in file["key"][:whole]]}
        table |= {name: [text.decode() for text in file[name][:whole]] for name in TEXT_WIDTHS}
        table |= {name: file[name][:whole] for name in NUMBER_UNITS}
        meta = {name: _attribute(file, name) for name in file.attrs}
    frame = pd.DataFrame(table)
    # a failed case that was tried again stands there twice; the last counts
    frame = frame[frame["key"] != ""].drop_duplicates("key", keep="last")
    return meta, frame.reset_index(drop=True)


def run_files(run: Path) -> list[Path]:
    """The result files of a run: the file itself, or all in the folder.

    Raises
    ------
    InputError
        There are none.
    """
    if run.is_file():
        return [run]
    files = sorted(run.glob("*.h5")) if run.is_dir() else []
    if not files:
        hint = "Run `mixed-ehl sweep PLAN.toml -o RUN` first."
        raise InputError("run", str(run), "a folder or file of results", hint)
    return files


def read_run(run: Path, *, locking: bool = True) -> tuple[dict[str, Any], pd.DataFrame]:
    """What all files of a run share, and all their rows, one per key, sorted by key.

    Raises
    ------
    InputError
        There are no results, or the files belong to different runs.
    """
    parts = [(path, *read_file(path, locking=locking)) for path in run_files(run)]
    first_path, first, _ = parts[0]
    for path, meta, _ in parts[1:]:
        for name, what in _SAME.items():
            if meta.get(name) != first.get(name):
                hint = f"One of them holds results of {what}; keep one run per folder."
                raise InputError("run", str(run), f"files of one run ({first_path.name}, {path.name})", hint)
    frame = pd.concat([part[2] for part in parts], ignore_index=True)
    frame = frame.drop_duplicates("key").sort_values("key", ignore_index=True)
    return {name: first.get(name) for name in ("schema", "writer", *_SHARED)}, frame


def merge(run: Path, target: Path) -> int:
    """Write all rows of a run into one file, sorted by key; returns how many.

    Raises
    ------
    InputError
        As `read_run`; or the target exists already.
    """
    if target.exists():
        raise InputError("target", str(target), "a file that does not exist yet")
    if not target.parent.is_dir():
        raise InputError("target", str(target), "a file in a folder that exists")
    meta, frame = read_run(run)
    shared = {name: meta[name] for name in _SHARED}
    draft = target.with_name(target.name + ".merging")
    draft.unlink(missing_ok=True)
    with ResultStore(draft, shared) as store:
        store.append([{str(name): value for name, value in row.items()} for row in frame.to_dict("records")])
    draft.replace(target)
    return len(frame)
