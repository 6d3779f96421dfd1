"""Results on disk: one HDF5 file per shard, one writer per file, columns that grow, the key written last.

A row counts only when its key is on disk, and the key column is extended after everything else was flushed. A process
that is killed loses at most the rows since the last flush; incomplete rows are cut off at the next opening. Each row
carries the checksum of its content: a row that was overwritten, or lost with the end of a file, is computed again.
"""

from __future__ import annotations

import math
import os
import re
import shutil
import tempfile
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import h5py
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ehl.common.errors import InputError
from ehl.common.file_kinds import told_kind
from regression import __version__
from regression.data.row_format import KEY_WIDTH, NUMBER_UNITS, ROW, TEXT_WIDTHS, Rows, checksums, pack

STORE_SCHEMA = 2
CaseStatus = tuple[str, str, int]  # status, reason, settings tried
_STATUS = ("key", "status", "reason", "attempts")
# the oldest format of the superblock has no "opened for writing" mark, which a killed writer would leave behind
LIBVER = ("earliest", "v110")
# rows of a block: what one corrupt block of the disk can cost
_CHUNK = 64
# rows whose checksums are taken together, so that a million of them pass through little memory
_BLOCK = 16_384
# bytes of columns in memory at once
_MEMORY = 128e6
# how often a file that another process writes is copied anew where the copy cannot be read, and the pause between [s]
_COPIES, _PAUSE = 8, 0.25
MAX_ROWS = 2_000_000  # of one file; a plan has half as many cases at most, each with one retry
_COLUMNS = (*NUMBER_UNITS, *TEXT_WIDTHS, "check")
_TABLE = ("key", *TEXT_WIDTHS, *NUMBER_UNITS)
ROW_CHECKED = {**{name: ROW[name] for name in ROW.names or ()}, "check": np.dtype("<u4")}
# largest growth of the file by a block of rows: its content, and a node of the index of every column
_BLOCK_BYTES = 2 * _CHUNK * ROW.itemsize + 4096 * (len(_COLUMNS) + 1)

# what all files of one run share
_SHARED = ("plan_name", "plan_hash", "solver_version", "oil", "oil_hash", "bodies_hash", "count")
# what must be unchanged when a run is resumed
_SAME = {
    "plan_hash": "another plan",
    "solver_version": "another version of the solver",
    "oil_hash": "an oil card with other properties",
    "bodies_hash": "materials with other properties",
}


class ResultStore:
    """One result file, open for writing.

    Parameters
    ----------
    path : Path
        The file; created where it does not exist.
    meta : mapping
        What the run is, by the names of `regression.sweeping.sweep.run_meta`; an existing file must be of the same run.

    Attributes
    ----------
    truncated : int
        Incomplete rows of an interrupted process that were cut off.
    corrupt : int
        Rows whose content no longer matches their checksum; they do not count.
    recovered : int or None
        Rows recovered from a file that was truncated or corrupt, which is kept with the suffix ``.corrupt``; None where
        the file was sound.

    Raises
    ------
    InputError
        The file belongs to another run, has a newer schema, is corrupt beyond use, or another process writes to it.
    """

    def __init__(self, path: Path, meta: Mapping[str, str | int]) -> None:
        self.path = path
        self.recovered: int | None = None
        if not os.path.exists(path):
            _create(path, meta)
        try:
            self._open_checked(meta)
        except _CorruptFile:
            self.recovered = _recover_rows(path, meta)
            self._open_checked(meta)

    def _open_checked(self, meta: Mapping[str, str | int]) -> None:
        self._file = _open(self.path, "r+")
        try:
            with _corruption_reported(self.path):
                _check_schema(self._file, self.path)
                _check_same(self._file, self.path, meta)
                self.truncated = self._cut_incomplete_rows()
                valid, self.corrupt = _valid_rows(self._file)
                self._rows = {name: self._file[name][: valid.size][valid] for name in _STATUS}
                self._columns = {name: self._file[name].id for name in ("key", *_COLUMNS)}
        except BaseException:
            self._file.close()
            raise

    def _cut_incomplete_rows(self) -> int:
        """Cut every column back to the rows whose key is on disk; returns how many rows were cut."""
        columns = [self._file[name] for name in _COLUMNS]
        keys = self._file["key"]
        complete = min(len(keys), *(len(column) for column in columns))
        # a key of zeros was allocated and never written
        written = np.flatnonzero(keys[:complete] != b"")
        complete = int(written[-1]) + 1 if written.size else 0
        longest = max(len(keys), *(len(column) for column in columns))
        if longest > complete:
            for column in (keys, *columns):
                column.resize((complete,))
            self._file.flush()
        return longest - complete

    def rows(self) -> dict[str, CaseStatus]:
        """Status, reason and attempts of every case that was on disk when the file was opened, by key."""
        keys, status, reasons = ([text.decode() for text in self._rows[name]] for name in ("key", "status", "reason"))
        return _case_status(keys, status, reasons, self._rows["attempts"])

    def append(self, rows: Sequence[Mapping[str, Any]]) -> None:
        """Write rows and put them on disk; the keys go last.

        Raises
        ------
        InputError
            The disk is full or gone; what was on it before stays valid.
        """
        if not rows:
            return
        self.append_packed(pack(rows))

    def append_packed(self, packed: Rows) -> None:
        """As `append`, of rows as `regression.data.row_format.pack` makes them."""
        try:
            self._write(packed)
        except (OSError, RuntimeError) as error:
            hint = f"{error}. Free some space and repeat the command."
            raise InputError("run", str(self.path), "a disk that can be written", hint) from None

    def _write(self, packed: Rows) -> None:
        blocks = len(packed) // _CHUNK + 2
        self._reserve_space(blocks * _BLOCK_BYTES)
        for name in (*NUMBER_UNITS, *TEXT_WIDTHS):
            self._extend(name, packed[name])
        self._extend("check", checksums(packed))
        self._to_disk()
        # flushing released the space that was not needed
        self._reserve_space(blocks * (_CHUNK * KEY_WIDTH + 4096))
        self._extend("key", packed["key"])
        self._to_disk()

    def _reserve_space(self, size: int) -> None:
        """Reserve bytes behind the end of the file: HDF5 crashes the process when the disk is full."""
        _reserve(self._file.id.get_vfd_handle(), self._file.id.get_filesize(), size)

    def _extend(self, name: str, values: np.ndarray[Any, Any]) -> None:
        """Put values behind the last of a column; h5py's own indexing takes ten times as long."""
        column = self._columns[name]
        start = column.shape[0]
        column.set_extent((start + values.size,))
        space = column.get_space()
        space.select_hyperslab((start,), values.shape)
        column.write(h5py.h5s.create_simple(values.shape), space, np.ascontiguousarray(values))

    def _to_disk(self) -> None:
        self._file.flush()
        # past the system's cache too, so that the order of data and keys holds if the power fails
        os.fsync(self._file.id.get_vfd_handle())

    def close(self) -> None:
        """Close the file; an error of a full disk here has been reported before."""
        try:
            self._file.close()
            # opened anew, HDF5 cuts off the space that was reserved and not needed
            h5py.File(self.path, "r+", libver=LIBVER).close()
        except (OSError, RuntimeError) as error:
            hint = f"{error}. Free some space and repeat the command."
            raise InputError("run", str(self.path), "a disk that can be written", hint) from None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self.close()
        except InputError:
            if value is None:
                raise


def _reserve(descriptor: int, start: int, size: int) -> None:
    """Reserve bytes of a file on the disk, where the system can."""
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(descriptor, start, size)


def _create(path: Path, meta: Mapping[str, str | int]) -> None:
    """Make an empty result file; it appears under its name only when it is complete."""
    draft = path.with_name(f"{path.name}.{os.getpid()}.new")
    try:
        with draft.open("wb") as file:
            _reserve(file.fileno(), 0, 2 * _BLOCK_BYTES + len(str(meta["plan"])))
        with h5py.File(draft, "w", libver=LIBVER) as file:
            file.attrs["schema"] = STORE_SCHEMA
            file.attrs["writer"] = f"mixed-ehl {__version__}"
            for name in _SHARED:
                file.attrs[name] = meta[name]
            # a dataset: the plan of a long table is too much for an attribute
            file["plan"] = str(meta["plan"])
            file["plan"].attrs["unit"] = "JSON"
            for name, unit in NUMBER_UNITS.items():
                column = file.create_dataset(name, (0,), "f8", maxshape=(None,), chunks=(_CHUNK,), fillvalue=np.nan)
                column.attrs["unit"] = unit or "1"
            for name, width in (*TEXT_WIDTHS.items(), ("key", KEY_WIDTH)):
                column = file.create_dataset(name, (0,), f"S{width}", maxshape=(None,), chunks=(_CHUNK,))
                column.attrs["unit"] = "text"
            column = file.create_dataset("check", (0,), "u4", maxshape=(None,), chunks=(_CHUNK,))
            column.attrs["unit"] = "CRC-32 of the row"
        draft.replace(path)
    except (OSError, RuntimeError) as error:
        draft.unlink(missing_ok=True)
        raise InputError("run", str(path), "a folder that can be written", f"{error}.") from None


class _BeingWritten(InputError):
    """Another process has the file open for writing."""


class _CorruptFile(InputError):
    """A file that is truncated or corrupt: part of its rows may be recovered."""


def _open(path: Path, mode: str, locking: bool = True) -> h5py.File:
    try:
        # some network file systems cannot lock; there the user must keep to one writer per file
        return h5py.File(path, mode, libver=LIBVER, locking="best-effort" if locking else False)
    except OSError as error:
        # HDF5 mentions blocks too: only these words mean a lock
        if isinstance(error, BlockingIOError) or "unable to lock file" in str(error):
            hint = "Is the same shard running?"
            raise _BeingWritten("run", str(path), "a file no other process writes to", hint) from None
        raise _corrupt_file(path, error) from None


def _corrupt_file(path: Path, error: Exception) -> InputError:
    if isinstance(error, PermissionError):
        return InputError("run", str(path), "a file that can be read and written", f"{error}.")
    hint = f"It is corrupt or no result file ({error}); move it away and sweep again to compute its cases."
    return _CorruptFile("run", str(path), "a readable result file", hint)


@contextmanager
def _corruption_reported(path: Path) -> Iterator[None]:
    """Turn any error of reading a corrupt file in the block into one sentence that names the file."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:  # h5py lets errors of every kind through
        raise _corrupt_file(path, error) from None


def _valid_rows(file: h5py.File) -> tuple[NDArray[np.bool_], int]:
    """Which rows match their checksum, and how many others there are."""
    size = _declared_rows(file, Path(file.filename))
    valid, corrupt = np.zeros(size, dtype=bool), 0
    for start in range(0, size, _BLOCK):
        block = slice(start, min(start + _BLOCK, size))
        packed = np.zeros(block.stop - start, ROW)
        for name in ROW.names or ():
            packed[name] = file[name][block]
        keyed = packed["key"] != b""
        valid[block] = keyed & (checksums(packed) == file["check"][block])
        corrupt += int(np.count_nonzero(keyed & ~valid[block]))
    return valid, corrupt


def _recover_rows(path: Path, meta: Mapping[str, str | int]) -> int:
    """Copy the valid rows of a truncated or corrupt file into a new one; returns how many.

    The corrupt file is kept with the suffix ``.corrupt``.

    Raises
    ------
    InputError
        It is not a result file, belongs to another run, or nothing in it can be read.
    """
    copy = path.with_name(f"{path.name}.{os.getpid()}.new")
    try:
        shutil.copyfile(path, copy)
        _restore_length(copy)
        with _corruption_reported(path), _open(copy, "r", locking=False) as file:
            _check_schema(file, path)
            _check_same(file, path, meta)
            packed = _readable_rows(file)
    except OSError as error:
        raise InputError("run", str(path), "a folder that can be written", f"{error}.") from None
    finally:
        copy.unlink(missing_ok=True)
    path.replace(path.with_name(path.name + ".corrupt"))
    _create(path, meta)
    with ResultStore(path, meta) as store:
        store.append_packed(packed)
    return len(packed)


def _restore_length(path: Path) -> None:
    """Extend a truncated file to its length by zeros: HDF5 opens no file shorter than it was closed with."""
    try:
        h5py.File(path, "r", locking=False).close()
    except OSError as error:
        stored = re.search(r"stored_eof = (\d+)", str(error))
        if stored is not None and "truncated" in str(error):
            os.truncate(path, int(stored[1]))


def _readable_rows(file: h5py.File) -> Rows:
    """The rows that can be read from a corrupt file, block by block, and match their checksum."""
    lengths = []
    for name in ("key", *_COLUMNS):
        try:
            lengths.append(min(len(file[name]), MAX_ROWS))
        except Exception:
            return np.zeros(0, ROW)
    size = min(lengths)
    packed, stated = np.zeros(size, ROW), np.zeros(size, np.uint32)
    for start in range(0, size, _CHUNK):
        block = slice(start, min(start + _CHUNK, size))
        try:
            for name in ROW.names or ():
                packed[name][block] = file[name][block]
            stated[block] = file["check"][block]
        except Exception:
            # these rows keep a blank key
            packed["key"][block] = b""
    valid = (packed["key"] != b"") & (checksums(packed) == stated)
    return np.asarray(packed[valid])


def _attribute(file: h5py.File, name: str) -> Any:
    value = file.attrs.get(name)
    return int(value) if isinstance(value, np.integer) else value


def _attributes(file: h5py.File, path: Path) -> dict[str, Any]:
    """What the file says of its run; a text with a flipped bit may hold signs that no terminal takes."""
    meta = {name: _attribute(file, name) for name in ("schema", "writer", *_SHARED)}
    for name, value in meta.items():
        if name in ("schema", "count"):
            sound = isinstance(value, int) and 0 < value <= MAX_ROWS
        else:
            sound = isinstance(value, str) and value.isprintable()
        if not sound:
            raise _corrupt_file(path, ValueError(f"its attribute {name} is {value!r}"))
    return meta


def _declared_rows(file: h5py.File, path: Path) -> int:
    """Rows every column has; a file that declares more than there may be is refused before memory is taken."""
    sizes = [file[name].shape for name in ("key", *_COLUMNS)]
    largest = max(math.prod(size) for size in sizes)
    if largest > MAX_ROWS:
        raise InputError("run", str(path), f"a result file of at most {MAX_ROWS} rows", f"It declares {largest}.")
    if max(file[name].dtype.itemsize for name in ("key", *_COLUMNS)) > ROW.itemsize:
        raise TypeError("its columns are of another type")
    return int(min(size[0] if len(size) == 1 else 0 for size in sizes))


def _check_same(file: h5py.File, path: Path, meta: Mapping[str, str | int]) -> None:
    for name, what in _SAME.items():
        if _attribute(file, name) != meta[name]:
            hint = f"It holds results of {what}; give another output folder."
            raise InputError("run", str(path), "a folder of this plan's own results", hint)


def _check_schema(file: h5py.File, path: Path) -> None:
    schema = _attribute(file, "schema")
    if not isinstance(schema, int):
        raise InputError("run", str(path), "a result file of `mixed-ehl sweep`", "It has no schema number.")
    if schema > STORE_SCHEMA:
        raise InputError(
            f"{path.name}.schema",
            schema,
            f"at most {STORE_SCHEMA}",
            f"It was written by the newer version {_attribute(file, 'writer')}; update mixed-ehl to read it.",
        )
    missing = [name for name in ("key", *_COLUMNS) if name not in file]
    if schema < STORE_SCHEMA or missing:
        columns = f"Columns {', '.join(missing[:5])} are missing: " if missing else ""
        hint = f"{columns}it is corrupt, or of an older version. Move it away and sweep again."
        raise InputError("run", str(path), f"a result file of schema {STORE_SCHEMA} with all columns", hint)


@dataclass
class _Part:
    """A result file and which of its rows count: those that match their checksum, the last one of each case.

    Attributes
    ----------
    path, source : Path
        The file, and what is read: a copy of it where another process writes it.
    meta : dict
        Attributes, and the plan.
    rows, keys, failed : array
        Numbers of the rows, their keys, and whether they are without an answer.
    """

    path: Path
    source: Path
    meta: dict[str, Any]
    rows: NDArray[np.int64]
    keys: NDArray[np.bytes_]
    failed: NDArray[np.bool_]


def _part(path: Path, copies: Path, *, locking: bool) -> _Part:
    """The rows of a file, also of one that is being written.

    Raises
    ------
    InputError
        The file is corrupt or no result file, or has a newer schema.
    """
    source, file = _opened(path, copies, locking=locking)
    with file, _corruption_reported(path):
        meta = _attributes(file, path)
        plan = file["plan"].asstr()[()]
        if not isinstance(plan, str):
            raise TypeError("its plan is no text")
        meta["plan"] = plan
        valid, _ = _valid_rows(file)
        rows = np.flatnonzero(valid)
        keys = file["key"][: valid.size][rows]
        # a failed case that was computed again has two rows; the last counts
        _, last = np.unique(keys[::-1], return_index=True)
        kept = np.sort(rows.size - 1 - last)
        failed = file["status"][: valid.size][rows[kept]] == b"failed"
        return _Part(path, source, meta, rows[kept], keys[kept], failed)


def _opened(path: Path, copies: Path, *, locking: bool) -> tuple[Path, h5py.File]:
    """A file of the right schema, open for reading, and where it lies: in the folder of copies if it is being written.

    A copy does not change between two readings, and its rows have checksums; where a block was on its way to the disk
    it is made anew.
    """
    try:
        # without lock it is not in the way of a sweep that starts
        file = _open(path, "r")
        if not locking:
            file.close()
            file = _open(path, "r", locking=False)
        return path, _of_schema(file, path)
    except _BeingWritten:
        pass
    copy = copies / f"{len(list(copies.iterdir()))}-{path.name}"
    for left in reversed(range(_COPIES)):
        shutil.copyfile(path, copy)
        try:
            file = _of_schema(_open(copy, "r", locking=False), path)
            with _corruption_reported(path):
                _valid_rows(file)
            return copy, file
        except InputError:
            if not left:
                raise
            time.sleep(_PAUSE)
    raise AssertionError


def _of_schema(file: h5py.File, path: Path) -> h5py.File:
    try:
        with _corruption_reported(path):
            _check_schema(file, path)
    except BaseException:
        file.close()
        raise
    return file


def _columns(
    parts: Sequence[_Part], order: NDArray[np.int64], names: Sequence[str], copies: Path
) -> Iterator[tuple[str, NDArray[Any]]]:
    """Columns of the rows of several files in some order; not many are in memory at once, nor files open."""
    total = sum(part.rows.size for part in parts)
    left = list(names)
    while left:
        group, size = [left.pop(0)], 0
        while left and (size := size + total * ROW_CHECKED[left[0]].itemsize) < _MEMORY:
            group.append(left.pop(0))
        found = {name: np.empty(total, ROW_CHECKED[name]) for name in group}
        start = 0
        for part in parts:
            end, last = start + part.rows.size, part.rows[-1] + 1 if part.rows.size else 0
            # a sweep may have begun to write it since
            part.source, file = _opened(part.source, copies, locking=True)
            with file, _corruption_reported(part.path):
                for name in group:
                    found[name][start:end] = file[name][:last][part.rows]
            start = end
        for name in group:
            yield name, found.pop(name)[order]


def _table(
    parts: Sequence[_Part], order: NDArray[np.int64], copies: Path, names: Sequence[str] = _TABLE
) -> pd.DataFrame:
    columns = _columns(parts, order, names, copies)
    table: dict[str, Any] = {name: values if name in NUMBER_UNITS else _texts(values) for name, values in columns}
    # not gathered into one block: that would take the memory of all numbers once more
    return pd.DataFrame(table, copy=False)


def _texts(column: NDArray[np.bytes_]) -> list[str]:
    """Texts, each different one decoded once."""
    known: dict[bytes, str] = {}
    return [known.get(text) or known.setdefault(text, text.decode("ascii", "replace")) for text in column]


def read_file(
    path: Path, *, locking: bool = True, names: Sequence[str] = _TABLE
) -> tuple[dict[str, Any], pd.DataFrame]:
    """Attributes and valid rows of one result file; rows that do not match their checksum are omitted.

    Of a file that another process writes these are the rows that are whole. `names` are the columns read.

    Raises
    ------
    InputError
        The file is corrupt or no result file, or has a newer schema.
    """
    with _copies() as copies:
        part = _part(path, copies, locking=locking)
        return part.meta, _table([part], np.arange(part.rows.size), copies, names)


@contextmanager
def _copies() -> Iterator[Path]:
    """A folder for copies of files that are being written."""
    with tempfile.TemporaryDirectory(prefix="mixed-ehl-") as folder:
        yield Path(folder)


def run_files(run: Path) -> list[Path]:
    """The result files of a run: the file itself, or all in the folder.

    Raises
    ------
    InputError
        There are none.
    """
    hint = "Run `mixed-ehl sweep PLAN.toml -o RUN` first."
    if os.path.isfile(run):
        if run.suffix != ".h5" and not h5py.is_hdf5(run):
            kind = told_kind(run.read_text(encoding="utf-8", errors="replace"))
            raise InputError("run", str(run), "a folder or file of results", f"{kind} {hint}".strip())
        return [run]
    files = sorted(run.glob("*.h5")) if os.path.isdir(run) else []
    if not files:
        raise InputError("run", str(run), "a folder or file of results", hint)
    return files


def _parts_of(
    run: Path, copies: Path, *, locking: bool = True
) -> tuple[dict[str, Any], list[_Part], NDArray[np.int64]]:
    """What all files of a run share, the files, and the order of their rows: one per case, sorted by key.

    Where several have a case one with a result counts, of these the first.
    """
    parts = [_part(path, copies, locking=locking) for path in run_files(run)]
    first = parts[0]
    for part in parts[1:]:
        for name, what in _SAME.items():
            if part.meta.get(name) != first.meta.get(name):
                hint = f"One of them holds results of {what}; keep one run per folder."
                raise InputError("run", str(run), f"files of one run ({first.path.name}, {part.path.name})", hint)
    keys = np.concatenate([part.keys for part in parts])
    order = np.lexsort((np.concatenate([part.failed for part in parts]), keys))
    fresh = np.ones(order.size, dtype=bool)
    fresh[1:] = keys[order[1:]] != keys[order[:-1]]
    meta = {name: first.meta.get(name) for name in ("schema", "writer", "plan", *_SHARED)}
    return meta, parts, order[fresh]


def read_run(run: Path, *, locking: bool = True) -> tuple[dict[str, Any], pd.DataFrame]:
    """What all files of a run share, and all their rows, one per key, sorted by key.

    A run that is being computed gives the rows that are whole.

    Raises
    ------
    InputError
        There are no results, or the files belong to different runs.
    """
    with _copies() as copies:
        meta, parts, order = _parts_of(run, copies, locking=locking)
        return meta, _table(parts, order, copies)


def one_row_per_case(frames: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """The rows of several files sorted by key; where two have a case, one with a result counts."""
    frame = pd.concat(frames, ignore_index=True)
    frame = frame.assign(failed=frame["status"] == "failed").sort_values(
        ["key", "failed"], kind="stable", ignore_index=True
    )
    return frame.drop_duplicates("key", ignore_index=True).drop(columns="failed")


def merge(run: Path, target: Path) -> int:
    """Write all rows of a run into one file, sorted by key, some columns at a time; returns how many.

    Raises
    ------
    InputError
        As `read_run`; or the target exists already.
    """
    if os.path.exists(target):
        raise InputError("target", str(target), "a file that does not exist yet")
    if not os.path.isdir(target.parent):
        raise InputError("target", str(target), "a file in a folder that exists")
    draft = target.with_name(target.name + ".merging")
    draft.unlink(missing_ok=True)
    with _copies() as copies:
        meta, parts, order = _parts_of(run, copies)
        _create(draft, {name: meta[name] for name in ("plan", *_SHARED)})
        try:
            with draft.open("rb+") as file:
                _reserve(file.fileno(), 0, (order.size // _CHUNK + 2) * _BLOCK_BYTES)
            with _open(draft, "r+") as whole:
                for name, column in _columns(parts, order, (*_COLUMNS, "key"), copies):
                    whole[name].resize((order.size,))
                    whole[name][...] = column
        except (OSError, RuntimeError) as error:
            draft.unlink(missing_ok=True)
            hint = f"{error}. Free some space and repeat the command."
            raise InputError("target", str(target), "a disk that can be written", hint) from None
    draft.replace(target)
    return int(order.size)


def rows_of_other_files(path: Path) -> dict[str, CaseStatus]:
    """Status, reason and attempts of the cases in the other files of a run's folder, by key.

    A file that cannot be read (it is being written, or corrupt) is ignored: its cases are computed again.
    """
    frames = []
    for other in sorted(path.parent.glob("*.h5")):
        if other != path:
            with suppress(InputError):
                frames.append(read_file(other, locking=False, names=_STATUS)[1])
    if not frames:
        return {}
    rows = one_row_per_case(frames)
    return _case_status(rows["key"], rows["status"], rows["reason"], rows["attempts"].to_numpy())


def _case_status(
    keys: Iterable[str], status: Iterable[str], reasons: Iterable[str], attempts: Any
) -> dict[str, CaseStatus]:
    rows = zip(keys, status, reasons, np.nan_to_num(attempts, nan=1.0), strict=True)
    return {key: (word, reason, int(count)) for key, word, reason, count in rows}
