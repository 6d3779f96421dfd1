"""Append-only journal of finished rows on disk, from which the same command resumes a run.

Each line is one JSON object. The first line is the header: schema, writer, and identification of the run. Every line
begins with the CRC-32 of its other bytes. Corrupt and incomplete lines are ignored and their rows are computed again.
The later of two rows with one key is valid. Only one process writes a file, protected by an advisory lock, or by a
second file if the file system has no locks. Other processes may read it at the same time.

Sync policy of the program: a row is permanent when `Journal.append` returns, since every append ends with `fsync`.
Output files are written by `ehl.common.files.write_file` to a temporary file, synced, and renamed.
"""

import contextlib
import json
import os
import re
import stat
import tempfile
import threading
import time
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO, Self

from ehl.common.errors import InputError
from ehl.common.files import make_folder
from ehl.common.version import __version__

SCHEMA = 1
BEAT, STALE = 2.0, 60.0  # touch interval of a writer without locks, age of a killed writer [s]
_LINE = re.compile(rb'\{"check":"([0-9a-f]{8})",(.+\})\n')


class Journal:
    """A journal that is open for writing.

    path: the file; created with its folder if it does not exist. None keeps the rows in memory only.
    run: identification of the run, JSON values; stored in the header.
    same: names in `run` that must agree with an existing file, each with words for the difference.
    field: name of the file in errors.
    keep: selects the part of each row that is kept in memory; by default the whole row.
    rows: key to the kept part of its last row.
    on_disk, reused: keys found when the file was opened, and those of them that were tasks of `run_tasks`.
    truncated: 1 if an incomplete line of a killed writer was removed.
    corrupt: number of lines that do not match their checksum.
    Raises `InputError`: the file is of another run, is not a journal, has a newer schema, or another process writes it.
    """

    def __init__(
        self,
        path: Path | None,
        run: Mapping[str, Any] | None = None,
        same: Mapping[str, str] | None = None,
        field: str = "run",
        keep: Callable[[dict[str, Any]], Any] = lambda row: row,
    ) -> None:
        self.field, self._keep = field, keep
        self.rows: dict[str, Any] = {}
        self.reused: set[str] = set()
        self.truncated = self.corrupt = 0
        self._file: BinaryIO | None = None
        self._holder: _Holder | None = None
        if path is not None:
            self._open(path, run or {}, same or {})
        self.on_disk = frozenset(self.rows)

    def _open(self, path: Path, run: Mapping[str, Any], same: Mapping[str, str]) -> None:
        self.path = path
        header = _line({"schema": SCHEMA, "writer": f"mixed-ehl {__version__}", **run})
        make_folder(path.parent, self.field)
        try:
            self._file = open(path, "a+b", buffering=0)  # noqa: SIM115 (closed by `close`)
            _require_file(os.fstat(self._file.fileno()))
        except OSError as error:
            self.close()
            raise InputError(self.field, str(path), "a file that can be read and written", f"{error}.") from None
        try:
            self._lock(self._file)
            self._read(self._file, header, run, same)
        except BaseException:
            self.close()
            raise

    def _lock(self, file: BinaryIO) -> None:
        try:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            hint = "Is the same command running? Wait for its end, or choose another output."
            raise InputError(self.field, str(self.path), "a file no other process writes to", hint) from None
        except (ImportError, OSError):  # a file system without locks
            self._holder = _Holder(self.path.with_name(f"{self.path.name}.writer"), self.field)

    def _read(self, opened: BinaryIO, header: bytes, run: Mapping[str, Any], same: Mapping[str, str]) -> None:
        """Read the rows on disk and remove an incomplete last line of a killed writer."""
        size = os.fstat(opened.fileno()).st_size
        opened.seek(0)
        if size < len(header) and header.startswith(opened.read(size)):  # new, or killed within the first line
            os.ftruncate(opened.fileno(), 0)
            self._write(opened, header)
            return
        found = header_of(self.path, self.field)
        for name, what in same.items():
            if found.get(name) != run.get(name):
                hint = f"It contains results of {what}; choose another output folder."
                raise InputError(self.field, str(self.path), "a folder with results of this run", hint)
        with open(self.path, "rb") as file:
            end = len(file.readline())
            for line in file:
                if not line.endswith(b"\n"):
                    break
                end += len(line)
                row = _content(line)
                if row is None or "key" not in row:
                    self.corrupt += 1
                else:
                    self.rows[row["key"]] = self._keep(row)
        if end < size:
            self.truncated = 1
            os.ftruncate(opened.fileno(), end)

    def append(self, rows: Iterable[Mapping[str, Any]]) -> None:
        """Write rows and sync them to disk.

        Raises `InputError`: the disk is full or not available; earlier rows remain valid.
        """
        lines = [_line(row) for row in rows]
        if lines and self._file is not None:
            self._write(self._file, b"".join(lines))
        for line in lines:
            row = _content(line) or {}
            self.rows[row["key"]] = self._keep(row)

    def _write(self, file: BinaryIO, content: bytes) -> None:
        size = os.fstat(file.fileno()).st_size
        try:
            left = memoryview(content)
            while left:
                left = left[file.write(left) :]
            os.fsync(file.fileno())
        except OSError as error:
            with contextlib.suppress(OSError):
                os.ftruncate(file.fileno(), size)
            hint = f"{error}. Free some space and repeat the command."
            raise InputError(self.field, str(self.path), "a disk that can be written", hint) from None

    def close(self) -> None:
        """Close the file and release its lock."""
        if self._file is not None:
            self._file.close()
        if self._holder is not None:
            self._holder.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.close()


class _Holder:
    """A file next to a journal that replaces a lock if the file system has none.

    The writer touches it every few seconds. After `STALE` seconds without a touch the writer is regarded as killed.
    Ages are differences of file system times, because the clocks of two machines may differ.

    Raises `InputError`: another process writes the journal.
    """

    def __init__(self, path: Path, field: str) -> None:
        self._path, self._end = path, threading.Event()
        for _ in range(2):
            try:
                os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o644))
                break
            except FileExistsError:
                with contextlib.suppress(OSError):
                    touched = path.lstat().st_mtime
                    time.sleep(BEAT)
                    if path.lstat().st_mtime == touched and self._age() > STALE:
                        path.unlink()
            except OSError as error:
                raise InputError(field, str(path), "a folder that can be written", f"{error}.") from None
        else:
            hint = (
                f"The file system has no locks, and {path.name} shows a writer. Is the same command running? If its "
                f"writer was killed, repeat the command after {STALE:.0f} s."
            )
            raise InputError(field, str(path), "a file no other process writes to", hint)
        self._thread = threading.Thread(target=self._beat, daemon=True)
        self._thread.start()

    def _age(self) -> float:
        with tempfile.NamedTemporaryFile(dir=self._path.parent) as now:
            return os.stat(now.name).st_mtime - self._path.lstat().st_mtime

    def _beat(self) -> None:
        while not self._end.wait(BEAT):
            with contextlib.suppress(OSError):
                os.utime(self._path)

    def release(self) -> None:
        """End holding it."""
        self._end.set()
        self._thread.join()
        self._path.unlink(missing_ok=True)


def header_of(path: Path, field: str = "run") -> dict[str, Any]:
    """Header of a journal.

    Raises `InputError`: the file is not a journal, cannot be read, or has a newer schema.
    """
    try:
        _require_file(os.stat(path))  # a pipe would be waited for
        with open(path, "rb") as file:
            header = _content(file.readline())
    except OSError as error:
        raise InputError(field, str(path), "a file that can be read", f"{error}.") from None
    if header is None or not isinstance(schema := header.get("schema"), int):
        hint = "It is corrupt or not a journal. Move it to another folder and run again to compute its rows."
        raise InputError(field, str(path), "a readable result file", hint)
    if schema > SCHEMA:
        hint = f"It was written by the newer version {header.get('writer')}; update mixed-ehl to read it."
        raise InputError(f"{path.name}.schema", schema, f"at most {SCHEMA}", hint)
    return header


def _require_file(status: os.stat_result) -> None:
    if not stat.S_ISREG(status.st_mode):
        raise OSError("It is a folder, pipe or device, not a file")


def read_rows(path: Path) -> Iterator[dict[str, Any]]:
    """Valid rows of a journal in the order of writing; also while another process writes it.

    Raises `InputError`: see `header_of`.
    """
    header_of(path)
    with open(path, "rb") as file:
        file.readline()
        for line in file:
            row = _content(line)
            if row is not None and "key" in row:
                yield row


def _line(row: Mapping[str, Any]) -> bytes:
    """A row as a line, with NumPy scalars as numbers and non-finite values as NaN and Infinity."""
    body = json.dumps(row, separators=(",", ":"), default=lambda value: value.item()).encode()[1:]
    return b'{"check":"%08x",%b\n' % (zlib.crc32(body), body)


def _content(line: bytes) -> dict[str, Any] | None:
    """Row of a line; None if the line is incomplete or does not match its checksum."""
    match = _LINE.fullmatch(line)
    if match is None or int(match[1], 16) != zlib.crc32(match[2]):
        return None
    content = json.loads(b"{" + match[2])
    return content if isinstance(content, dict) else None
