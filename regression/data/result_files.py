"""Result files: journals of a run, and the HDF5 file of `merge`.

A sweep appends to one journal per shard (`ehl.common.journal`); `merge` writes one HDF5 file. Both give the same rows:
those with a correct checksum, one per case, preferably one with a result.

Row of a result file: columns with units, and the checksum that detects corrupt rows.
"""

import math
import os
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ehl.common.errors import InputError
from ehl.common.files import write_file
from ehl.common.journal import header_of, read_rows
from ehl.common.quantities import si_units
from ehl.common.validation import kind_sentence
from regression import __version__
from regression.friction.conditions import LUBRICANT_UNITS, STATE_UNITS

OUTPUT_UNITS = si_units(
    (
        *("friction_coefficient", "friction_fluid", "friction_asperity", "film_central", "film_min"),
        *("pressure_max", "film_ratio", "asperity_load_share", "roughness_load_share", "rolling_traction"),
        *("temperature_film_max", "temperature_flash", "film_error", "friction_error", "mesh_error"),
        *("statistical_error", "friction_boundary_half", "friction_boundary_double", "iterations", "boundary_film"),
        *("travel", "nodes", "steps"),
    )
)
# of the rough surfaces; a formula may use the correlation length
SURFACE_UNITS = si_units(("boundary_friction", "correlation_length", "peklenik_number", "seed"))
# times differ between runs and are not part of the data
TIMING_UNITS = si_units(("seconds", "seconds_cpu"))
NUMBER_UNITS: dict[str, str] = {
    # the order of the columns is part of the file format
    **{name: unit for name, unit in STATE_UNITS.items() if name not in SURFACE_UNITS},
    # alpha_film follows from the oil card and is not stored
    **{name: unit for name, unit in LUBRICANT_UNITS.items() if name != "pressure_viscosity_film"},
    **SURFACE_UNITS,
    **OUTPUT_UNITS,
    "attempts": "",
    **TIMING_UNITS,
}
TEXT_WIDTHS: dict[str, int] = {"origin": 8, "oil": 48, "status": 12, "reason": 64, "setting": 64, "skipped": 256}
KEY_WIDTH = 64

ROW = np.dtype(
    [
        *((name, "<f8") for name in NUMBER_UNITS),
        *((name, f"S{width}") for name, width in TEXT_WIDTHS.items()),
        ("key", f"S{KEY_WIDTH}"),
    ]
)
Rows = NDArray[np.void]


def pack(rows: Sequence[Mapping[str, Any]]) -> Rows:
    """Rows as a structured array; missing numbers are nan, missing texts are empty."""
    packed = np.zeros(len(rows), ROW)
    for name in NUMBER_UNITS:
        packed[name] = [float(row.get(name, np.nan)) for row in rows]
    for name, width in TEXT_WIDTHS.items():
        packed[name] = [str(row.get(name, "")).encode("ascii", "replace")[:width] for row in rows]
    packed["key"] = [row["key"].encode() for row in rows]
    return packed


def checksums(packed: Rows) -> NDArray[np.uint32]:
    """CRC-32 of every row's bytes, key included."""
    content, size = memoryview(packed.tobytes()), packed.dtype.itemsize
    return np.array([zlib.crc32(content[i : i + size]) for i in range(0, len(content), size)], dtype=np.uint32)


SCHEMA = 2  # of the HDF5 file
JOURNAL = ".jsonl"
CaseStatus = tuple[str, str, int]  # status, reason, settings tried
LIBVER = ("earliest", "v110")
MAX_ROWS = 2_000_000  # of one file; twice the largest number of cases of a plan
_BLOCK = 16_384  # rows read or checked together
_COLUMNS = (*NUMBER_UNITS, *TEXT_WIDTHS, "check")
_TABLE = ("key", *TEXT_WIDTHS, *NUMBER_UNITS)
# common attributes of all files of one run
_SHARED = ("plan_name", "plan_hash", "solver_version", "oil", "oil_hash", "bodies_hash", "count")
# attributes that must be equal for a run to be resumed
SAME_RUN = {
    "plan_hash": "another plan",
    "solver_version": "another version of the solver or another formula (--with)",
    "oil_hash": "an oil card with other properties",
    "bodies_hash": "materials with other properties",
}


def _difference(found: Mapping[str, Any], run: Mapping[str, Any]) -> str:
    """What differs between the attributes of two files of results; empty for files of one run."""
    return next((what for name, what in SAME_RUN.items() if found.get(name) != run.get(name)), "")


def run_files(run: Path) -> list[Path]:
    """The result files of a run: the file itself, or all in the folder.

    Raises `InputError`: there are none.
    """
    hint = "Run `mixed-ehl sweep PLAN.toml -o RUN` first."
    if os.path.isfile(run):
        if run.suffix not in (JOURNAL, ".h5") and not h5py.is_hdf5(run):
            kind = kind_sentence(run.read_text(encoding="utf-8", errors="replace"))
            raise InputError("run", str(run), "a folder or file of results", f"{kind} {hint}".strip())
        return [run]
    found = sorted([*run.glob(f"*{JOURNAL}"), *run.glob("*.h5")]) if os.path.isdir(run) else []
    # without journals that have just been created, and links to files that are gone
    files = [path for path in found if os.path.exists(path) and path.stat().st_size > 0]
    if not files:
        raise InputError("run", str(run), "a folder or file of results", hint)
    return files


def read_meta(run: Path) -> dict[str, Any]:
    """Attributes of a run from its first file; `InputError` as in `read_file`."""
    path = run_files(run)[0]
    if path.suffix == JOURNAL:
        return header_of(path)
    with _corruption_reported(path), h5py.File(path, "r", locking=False) as file:
        return _attributes(file, path)


def read_file(path: Path) -> tuple[dict[str, Any], Rows]:
    """Attributes of the run in a result file, and its valid rows, the last one of each case.

    A journal that is being written by another process gives its complete rows.

    Raises `InputError`: the file is corrupt or no result file, or has a newer schema.
    """
    if path.suffix != JOURNAL:
        return _read_hdf5(path)
    header, rows = header_of(path), read_rows(path)
    blocks = []
    while block := list(islice(rows, _BLOCK)):
        blocks.append(pack(block))
    packed = np.concatenate([np.zeros(0, ROW), *blocks])
    _, last = np.unique(packed["key"][::-1], return_index=True)
    return header, packed[np.sort(packed.size - 1 - last)]


def read_run(run: Path) -> tuple[dict[str, Any], Rows]:
    """Common attributes of the files of a run, and all their rows, one per case.

    Rows of journals are sorted by key; those of one HDF5 file have the order of the file.

    Raises `InputError`: there are no results, or the files belong to different runs.
    """
    files = files_of_one_run(run)
    (first, (meta, rows)), *others = files.items()
    if others or first.suffix == JOURNAL:
        rows = one_row_per_case([found for _, found in files.values()])
    return {name: meta.get(name) for name in ("schema", "writer", "plan", *_SHARED)}, rows


def files_of_one_run(run: Path) -> dict[Path, tuple[dict[str, Any], Rows]]:
    """Attributes and rows of every file of a run; `InputError` as in `read_run`."""
    (first, *others) = files = {path: read_file(path) for path in run_files(run)}
    for path in others:
        if what := _difference(files[path][0], files[first][0]):
            hint = f"One of them contains results of {what}; use one folder per run."
            raise InputError("run", str(run), f"files of one run ({first.name}, {path.name})", hint)
    return files


def one_row_per_case(parts: Sequence[Rows]) -> Rows:
    """Rows of several files sorted by key; for each key the first one with a result, else the first one."""
    rows = np.concatenate(parts)
    order = np.lexsort((rows["status"] == b"failed", rows["key"]))
    fresh = np.ones(order.size, dtype=bool)
    fresh[1:] = rows["key"][order[1:]] != rows["key"][order[:-1]]
    return np.asarray(rows[order[fresh]])


def table_of(rows: Rows, names: Sequence[str] = _TABLE) -> pd.DataFrame:
    """Rows as a table."""
    table: dict[str, Any] = {name: rows[name] if name in NUMBER_UNITS else _texts(rows[name]) for name in names}
    # separate columns, as one block would need the memory of all numbers again
    return pd.DataFrame({name: np.ascontiguousarray(column) for name, column in table.items()}, copy=False)


def _texts(column: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Decoded texts of a column."""
    known: dict[bytes, str] = {}
    found = [known.get(text) or known.setdefault(text, text.decode("ascii", "replace")) for text in column]
    return np.array(found, dtype=object)


def case_status(row: Mapping[str, Any]) -> CaseStatus:
    """Status, reason and attempts of a row of a journal."""
    return str(row.get("status", "")), str(row.get("reason", "")), int(row.get("attempts", 1))


def cases_of_other_files(path: Path, run: Mapping[str, Any]) -> dict[str, CaseStatus]:
    """Status, reason and attempts of the cases in the other files of the folder of a run, by key.

    A file that cannot be read is ignored, so that its cases are computed again.

    Raises `InputError`: a file contains results of another run than that with the attributes `run`.
    """
    parts = []
    for other in sorted([*path.parent.glob(f"*{JOURNAL}"), *path.parent.glob("*.h5")]):
        if other != path:
            try:
                meta, rows = read_file(other)
            except InputError:
                continue
            if what := _difference(meta, run):
                hint = f"It contains results of {what}; choose another output folder."
                raise InputError("run", str(other), "a folder with results of this run", hint)
            parts.append(rows)
    rows = one_row_per_case(parts) if parts else np.zeros(0, ROW)
    keys, status, reasons = (_texts(rows[name]) for name in ("key", "status", "reason"))
    attempts = np.nan_to_num(rows["attempts"], nan=1.0).astype(int)
    return dict(zip(keys, zip(status, reasons, attempts.tolist(), strict=True), strict=True))


def merge(run: Path, target: Path, *, compress: bool = False) -> int:
    """Write all rows of a run into one HDF5 file; returns their number.

    Raises `InputError`: as in `read_run`, or the target exists or cannot be written.
    """
    if os.path.exists(target):
        raise InputError("target", str(target), "a file that does not exist yet")
    meta, rows = read_run(run)
    write_hdf5(target, meta, rows, compress=compress)
    return len(rows)


def write_hdf5(target: Path, meta: Mapping[str, Any], rows: Rows, *, compress: bool = False) -> None:
    """Write rows into a new HDF5 file, via memory, as the HDF5 library crashes on a full disk."""
    how = {"compression": "gzip", "compression_opts": 9, "shuffle": True} if compress and len(rows) else {}
    chunks = (min(len(rows), 1024),) if how else None
    with h5py.File(target.name, "w", libver=LIBVER, driver="core", backing_store=False) as file:
        file.attrs["schema"] = SCHEMA
        file.attrs["writer"] = f"mixed-ehl {__version__}"
        for name in _SHARED:
            file.attrs[name] = meta[name]
        # a dataset, as the plan of a long table is too large for an attribute
        file["plan"] = str(meta["plan"])
        file["plan"].attrs["unit"] = "JSON"
        units = NUMBER_UNITS | dict.fromkeys((*TEXT_WIDTHS, "key"), "text")
        for name, unit in units.items():
            column = file.create_dataset(name, data=rows[name], chunks=chunks, **how)
            column.attrs["unit"] = unit or "1"
        column = file.create_dataset("check", data=checksums(rows), chunks=chunks, **how)
        column.attrs["unit"] = "CRC-32 of the row"
        file.flush()
        content = file.id.get_file_image()
    write_file(target, content, "target")


def _read_hdf5(path: Path) -> tuple[dict[str, Any], Rows]:
    with _corruption_reported(path), h5py.File(path, "r", locking=False) as file:
        meta = _attributes(file, path)
        size = _declared_rows(file, path)
        rows = np.zeros(size, ROW)
        for name in ROW.names or ():
            rows[name] = file[name][:size]
        stated = file["check"][:size]
        valid = rows["key"] != b""
        for start in range(0, size, _BLOCK):
            block = slice(start, start + _BLOCK)
            valid[block] &= checksums(rows[block]) == stated[block]
        return meta, np.asarray(rows[valid])


@contextmanager
def _corruption_reported(path: Path) -> Iterator[None]:
    """Convert any error of reading a corrupt file into an `InputError` with the name of the file."""
    try:
        yield
    except InputError:
        raise
    except PermissionError as error:
        raise InputError("run", str(path), "a file that can be read", f"{error}.") from None
    except Exception as error:  # h5py raises errors of many kinds
        hint = f"It is corrupt or no result file ({error}); remove it and repeat the merge or sweep."
        raise InputError("run", str(path), "a readable result file", hint) from None


def _attribute(file: h5py.File, name: str) -> Any:
    value = file.attrs.get(name)
    return int(value) if isinstance(value, np.integer) else value


def _attributes(file: h5py.File, path: Path) -> dict[str, Any]:
    """Attributes of the run in a file with all columns of this schema; a corrupt text may not be printable."""
    schema = _attribute(file, "schema")
    if not isinstance(schema, int):
        raise InputError("run", str(path), "a result file of `mixed-ehl sweep merge`", "It has no schema number.")
    if schema > SCHEMA:
        hint = f"It was written by the newer version {_attribute(file, 'writer')}; update mixed-ehl to read it."
        raise InputError(f"{path.name}.schema", schema, f"at most {SCHEMA}", hint)
    missing = [name for name in ("key", *_COLUMNS) if name not in file]
    if schema < SCHEMA or missing:
        columns = f"Columns {', '.join(missing[:5])} are missing: " if missing else ""
        hint = f"{columns}it is corrupt, or of an older version. Remove it and repeat the merge or sweep."
        raise InputError("run", str(path), f"a result file of schema {SCHEMA} with all columns", hint)
    meta = {name: _attribute(file, name) for name in ("schema", "writer", *_SHARED)}
    for name, value in meta.items():
        if name in ("schema", "count"):
            sound = isinstance(value, int) and 0 < value <= MAX_ROWS
        else:
            sound = isinstance(value, str) and value.isprintable()
        if not sound:
            raise ValueError(f"its attribute {name} is {value!r}")
    plan = file["plan"].asstr()[()]
    if not isinstance(plan, str):
        raise TypeError("its plan is no text")
    return meta | {"plan": plan}


def _declared_rows(file: h5py.File, path: Path) -> int:
    """Number of rows of the columns, checked before memory is allocated."""
    sizes = [file[name].shape for name in ("key", *_COLUMNS)]
    largest = max(math.prod(size) for size in sizes)
    if largest > MAX_ROWS:
        raise InputError("run", str(path), f"a result file of at most {MAX_ROWS} rows", f"It has {largest}.")
    if max(file[name].dtype.itemsize for name in ("key", *_COLUMNS)) > max(KEY_WIDTH, *TEXT_WIDTHS.values()):
        raise TypeError("its columns are of another type")
    return int(min(size[0] if len(size) == 1 else 0 for size in sizes))
