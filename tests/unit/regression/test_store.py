"""Result files: whole rows survive whatever happens to the process, and foreign files are refused."""

import errno
import io
import os
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import Mock

import h5py
import numpy as np
import pytest
from refusals import refuses

from ehl.common.data import data_path
from ehl.common.errors import InputError
from ehl.common.journal import SCHEMA as JOURNAL_SCHEMA
from ehl.common.journal import Journal, header_of, read_rows
from regression.data import result_files
from regression.data.dataset import run_status
from regression.data.result_files import SAME_RUN, SCHEMA, case_status, merge, read_file, read_run, table_of

META: dict[str, str | int] = {"plan": "{}", "plan_name": "test", "plan_hash": "a" * 64, "solver_version": "test 1"}
META |= {"oil": "fva3", "oil_hash": "b" * 64, "bodies_hash": "c" * 64, "count": 10}


def journal(path: Path, **changes: Any) -> Journal:
    return Journal(path, META | changes, SAME_RUN, keep=case_status)


def row(number: int, **changes: Any) -> dict[str, Any]:
    values = {"key": f"{number:064x}", "origin": "sobol", "status": "converged", "reason": "", "skipped": "time"}
    return {**values, "pressure_hertz": 1e9 + number, "friction_coefficient": 0.01 * number, **changes}


def keys(path: Path) -> list[str]:
    return table_of(read_file(path)[1])["key"].tolist()


@pytest.fixture
def path(tmp_path: Path) -> Path:
    target = tmp_path / "shard-0001-of-0001.jsonl"
    with journal(target) as rows:
        rows.append([row(1), row(2)])
        rows.append([row(3, status="failed", reason="diverged", friction_coefficient=float("nan"))])
    return target


@pytest.fixture
def merged(path: Path, tmp_path: Path) -> Path:
    merge(path, tmp_path / "merged.h5")
    return tmp_path / "merged.h5"


def test_rows_come_back_as_they_were_written(path: Path, merged: Path) -> None:
    for file, schema in ((path, JOURNAL_SCHEMA), (merged, SCHEMA)):
        meta, rows = read_file(file)
        frame = table_of(rows)
        assert {name: meta[name] for name in META} == META
        assert meta["schema"] == schema
        columns = [frame[name].tolist() for name in ("key", "pressure_hertz", "status", "reason")]
        rows = [row(1), row(2), row(3, status="failed", reason="diverged")]
        assert columns == [[r[name] for r in rows] for name in ("key", "pressure_hertz", "status", "reason")]
        assert np.isnan([frame["friction_coefficient"][2], *frame["film_central"]]).all()
    with h5py.File(merged) as file:
        assert all("unit" in file[name].attrs for name in file)
        assert [file[name].attrs["unit"] for name in ("pressure_hertz", "friction_coefficient")] == ["Pa", "1"]
    with journal(path) as again:  # goes on behind the last row
        assert (again.truncated, again.corrupt, len(again.rows)) == (0, 0, 3)
        again.append([row(4)])
        again.append([])
    assert len(keys(path)) == 4


def test_without_a_file_rows_stay_in_memory() -> None:
    with Journal(None, keep=case_status) as rows:
        rows.append([row(1), row(3, status="failed", reason="diverged")])
        rows.append([])
    assert [entry[0] for entry in rows.rows.values()] == ["converged", "failed"]
    assert rows.on_disk == frozenset()


@pytest.mark.parametrize("size", [0, 1, 30])
def test_a_journal_killed_within_its_header_begins_again(path: Path, size: int) -> None:
    os.truncate(path, size)
    with journal(path) as rows:
        assert rows.rows == {}
        rows.append([row(1)])
    assert keys(path) == [row(1)["key"]]


def test_newer_schemas_are_refused(path: Path, merged: Path, tmp_path: Path) -> None:
    with h5py.File(merged, "r+") as file:
        file.attrs["schema"] = SCHEMA + 1
        file.attrs["writer"] = "mixed-ehl 9.9"
    newer = tmp_path / "newer.jsonl"
    journal(newer, schema=JOURNAL_SCHEMA + 1, writer="mixed-ehl 9.9").close()
    for use in (lambda: read_file(merged), lambda: read_file(newer), lambda: journal(newer)):
        with pytest.raises(InputError) as caught:
            use()
        assert caught.value.field.endswith(".schema")


@pytest.mark.parametrize("name", ["plan_hash", "solver_version", "oil_hash", "bodies_hash"])
def test_results_of_another_run_are_not_mixed_in(path: Path, name: str) -> None:
    with refuses("run"):
        journal(path, **{name: "other"})
    journal(path.with_name("shard-0002-of-0002.jsonl"), **{name: "other"}).close()
    for read in (read_run, run_status):
        with refuses("run"):
            read(path.parent)


def test_other_and_corrupt_files(path: Path, merged: Path) -> None:
    for content in (b"no journal", b"no journal\n", b'{"schema":1}\n', b"\x00" * 400):
        path.write_bytes(content)
        for use in (read_file, journal):
            with refuses("run"):
                use(path)
        assert path.read_bytes() == content
    merged.write_text("no HDF5")
    with refuses("run"):
        read_file(merged)
    for attributes in ({}, {"schema": SCHEMA}):
        with h5py.File(merged, "w") as file:
            file.attrs.update(attributes)
        with refuses("run"):
            read_file(merged)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no FIFOs here")
@pytest.mark.parametrize("kind", ["folder", "pipe", "device"])
def test_folders_pipes_and_devices_are_no_journals(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "shard.jsonl"
    {"folder": os.mkdir, "pipe": os.mkfifo, "device": partial(os.symlink, "/dev/full")}[kind](path)
    for use in (journal, header_of, lambda path: list(read_rows(path)), read_file):
        with refuses("run"):
            use(path)


def test_second_writer_is_refused(path: Path) -> None:
    holder = "import sys\nfrom pathlib import Path\nfrom ehl.common.journal import Journal\n"
    holder += f"with Journal(Path({str(path)!r})):\n    print('open', flush=True)\n    sys.stdin.read()\n"
    command, pipes = [sys.executable, "-c", holder], {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen(command, text=True, **pipes) as process:
        assert process.stdout.readline() == "open\n"
        with refuses("run"):
            journal(path)
        # its rows can be read all the same
        assert len(keys(path)) == 3
        process.stdin.close()
        assert process.wait() == 0
    journal(path).close()


@pytest.fixture
def naps(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """A file system without locks, and a clock that notes what waits for it."""
    found: list[float] = []
    monkeypatch.setattr("fcntl.flock", Mock(side_effect=OSError(errno.ENOLCK, "no locks available")))
    monkeypatch.setattr("ehl.common.journal.BEAT", 0.02)
    monkeypatch.setattr("ehl.common.journal.time", SimpleNamespace(sleep=found.append))
    return found


def test_second_writer_is_refused_without_locks(path: Path, naps: list[float]) -> None:
    """A file next to the journal shows its writer, and is touched as long as this writes."""
    shown = path.with_name(f"{path.name}.writer")
    before = os.umask(0)
    with journal(path):
        os.umask(before)
        assert shown.stat().st_mode & 0o777 == 0o644
        assert naps == []
        os.utime(shown, (0.0, 0.0))
        waiting = time.monotonic() + 20.0
        while shown.stat().st_mtime == 0.0 and time.monotonic() < waiting:
            time.sleep(0.01)
        assert shown.stat().st_mtime > 0.0
        with refuses("run"):
            journal(path)
        assert naps == [0.02, 0.02]
    assert not shown.exists()


@pytest.mark.parametrize(("age", "killed"), [(0.0, False), (30.0, False), (90.0, True)])
def test_a_writer_without_locks_ends_after_a_minute(path: Path, naps: list[float], age: float, killed: bool) -> None:
    shown = path.with_name(f"{path.name}.writer")
    shown.touch()
    touched = shown.stat().st_mtime - age
    os.utime(shown, (touched, touched))
    if killed:
        with journal(path) as rows:
            rows.append([row(7)])
    else:
        with refuses("run"):
            journal(path)
    assert shown.exists() is not killed


@pytest.mark.parametrize("kind", ["dangling", "folder", "refused"])
def test_a_sign_of_a_writer_that_cannot_be_made_is_refused(path, naps, kind, monkeypatch):
    shown = path.with_name(f"{path.name}.writer")
    if kind == "refused":
        opened, none = os.open, path.parent / "none" / "x"
        monkeypatch.setattr(os, "open", lambda name, *how: opened(none if name == shown else name, *how))
    else:
        shown.mkdir() if kind == "folder" else shown.symlink_to("nowhere")
        os.utime(shown, (0.0, 0.0), follow_symlinks=False)
    with journal(path) if kind == "dangling" else refuses("run"):
        journal(path) if kind != "dangling" else None
    assert os.path.lexists(shown) is (kind == "folder")


class FullDisk(io.FileIO):
    room = 100

    def write(self, content: Any) -> int:
        if not self.room:
            raise OSError(errno.ENOSPC, "No space left on device")
        written = super().write(bytes(content)[: min(self.room, 7)])
        self.room -= written
        return written


def test_rows_are_on_disk_whole_or_not_at_all(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    synced: list[int] = []
    monkeypatch.setattr(os, "fsync", synced.append)
    whole = path.read_bytes()
    with journal(path) as rows:
        rows._file.close()
        rows._file = file = FullDisk(path, "ab")
        with refuses("run"):
            rows.append([row(8)])
        assert path.read_bytes() == whole
        assert synced == []
        assert row(8)["key"] not in rows.rows
        file.room = 10_000
        rows.append([row(9)])
        assert synced == [file.fileno()]
    assert keys(path)[-1] == row(9)["key"]


def test_merge_sorts_and_removes_doubles(path: Path, tmp_path: Path) -> None:
    with journal(path.with_name("shard-0002-of-0002.jsonl")) as rows:
        rows.append([row(0), row(2)])
    target = tmp_path / "merged" / "all.h5"
    assert merge(path.parent, target) == 4
    assert keys(target) == [row(n)["key"] for n in (0, 1, 2, 3)]
    with refuses("target"):
        merge(path.parent, target)
    small = target.with_name("small.h5")
    merge(path.parent, small, compress=True)
    assert read_file(small)[1].tobytes() == read_file(target)[1].tobytes()


def test_runs_that_are_not_there(tmp_path: Path) -> None:
    (gone := tmp_path / "gone").mkdir()
    (gone / "shard.jsonl").symlink_to("nowhere")
    for run in (tmp_path, tmp_path / "none", gone):
        with refuses("run"):
            read_run(run)


@pytest.mark.parametrize(
    ("text", "command"),
    [('{"schema": 1}', "mu"), ("torque,speed\n1,2\n", "duty"), ("<p>report</p>", "report"), ("a = 1", "sweep"),
     (data_path("oils", "fva3.toml").read_text(encoding="utf-8"), "oil")],
)  # fmt: skip
def test_a_file_of_another_kind_is_named(text: str, command: str, tmp_path: Path) -> None:
    path = tmp_path / "given.txt"
    path.write_text(text, encoding="utf-8")
    with refuses("run") as caught:
        read_run(path)
    assert command in caught.value.hint


NUMBERS = {name: float(i) for i, name in enumerate(result_files.NUMBER_UNITS)}
MANY = [{**row(n), **{name: value + 1000.0 * n for name, value in NUMBERS.items()}} for n in range(400)]
WRITTEN = {r["key"]: r for r in MANY}


@pytest.fixture(scope="module")
def content(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """A journal and a merged file of many rows with a number in every column."""
    path = tmp_path_factory.mktemp("many") / "many.jsonl"
    with journal(path) as rows:
        for start in range(0, len(MANY), 40):
            rows.append(MANY[start : start + 40])
    merge(path, path.with_suffix(".h5"))
    return {suffix: path.with_suffix(suffix).read_bytes() for suffix in (".jsonl", ".h5")}


def true_rows(path: Path) -> int:
    """Number of rows in a file, every one of which is what was written."""
    records = table_of(read_file(path)[1]).to_dict("records")
    assert all(record == {**record, **WRITTEN[record["key"]]} for record in records)
    return len(records)


def resumed(path: Path) -> int:
    """Rows of a journal after a run that computes what is missing."""
    with journal(path) as rows:
        rows.append([r for key, r in WRITTEN.items() if key not in rows.rows])
    return true_rows(path)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.999])
def test_whole_rows_of_a_journal_cut_short_are_kept(path: Path, content: dict[str, bytes], share: float) -> None:
    for file in (path, merged := path.with_suffix(".h5")):
        whole = content[file.suffix]
        file.write_bytes(whole[: int(share * len(whole))])
    assert true_rows(path) == pytest.approx(share * len(MANY), abs=2.0)
    with journal(path) as rows:
        assert (rows.truncated, rows.corrupt) == (1, 0)  # the row that a process left which died while writing
    assert resumed(path) == len(MANY)
    with refuses("run"):
        read_file(merged)


def _outcome(use: Callable[[], int]) -> int | str:
    try:
        return use()
    except InputError as error:
        return str(error.value)


@pytest.mark.parametrize("share", np.linspace(0.0001, 0.98, 6))
@pytest.mark.parametrize("length", [1, 3000])
def test_a_file_overwritten_anywhere_never_gives_a_wrong_number(tmp_path, content, share, length):
    noise = np.random.default_rng(int(1e6 * share)).integers(0, 256, length, dtype=np.uint8).tobytes()
    for suffix, whole in content.items():
        path, offset = tmp_path / f"damaged{suffix}", int(share * len(whole))
        path.write_bytes(whole[:offset] + noise + whole[offset + length :])
        assert len(whole) > 200_000
        assert _outcome(lambda path=path: true_rows(path)) in (str(path), *range(len(MANY) + 1))  # type: ignore[misc]
    # behind its header a journal can always be resumed
    path, header = tmp_path / "damaged.jsonl", content[".jsonl"].index(b"\n") + 1
    behind = int(share * len(content[".jsonl"])) >= header
    assert _outcome(lambda: resumed(path)) == (len(MANY) if behind else str(path))


def test_every_flipped_bit_of_a_row_is_detected(path: Path) -> None:
    whole = bytearray(path.read_bytes())
    begin = whole.index(b"\n") + 1
    for bit in range(8 * begin, 8 * whole.index(b"\n", begin), 7):
        whole[bit // 8] ^= 1 << bit % 8
        path.write_bytes(whole)
        whole[bit // 8] ^= 1 << bit % 8
        assert keys(path) == [row(n)["key"] for n in (2, 3)]


def test_rows_that_do_not_match_their_checksum_do_not_count(path: Path, merged: Path) -> None:
    with h5py.File(merged, "r+") as file:
        file["friction_coefficient"][1] = 0.7
    assert keys(merged) == [row(n)["key"] for n in (1, 3)]
    path.write_bytes(path.read_bytes().replace(b'"friction_coefficient":0.02', b'"friction_coefficient":0.72'))
    assert keys(path) == [row(n)["key"] for n in (1, 3)]
    with journal(path) as rows:
        assert (rows.corrupt, rows.truncated) == (1, 0)
        assert row(2)["key"] not in rows.rows
        rows.append([row(2)])
    assert len(keys(path)) == 3


def test_of_two_shards_the_one_with_a_result_counts(path: Path) -> None:
    with journal(path.with_name("shard-0002-of-0002.jsonl")) as rows:
        rows.append([row(3, friction_coefficient=0.03), row(2, status="failed", reason="time_cap")])
    frame = table_of(read_run(path.parent)[1])
    assert frame[["status", "friction_coefficient"]].to_numpy().tolist() == [
        ["converged", mu] for mu in (0.01, 0.02, 0.03)
    ]
    run = header_of(path)
    others = result_files.cases_of_other_files(path, run)
    assert {key: entry[0] for key, entry in others.items()} == {row(2)["key"]: "failed", row(3)["key"]: "converged"}
    with refuses("run") as caught:  # results of another solver, before any case is computed
        result_files.cases_of_other_files(path, run | {"solver_version": "xu_kahraman_2007"})
    assert str(caught.value.value).endswith("shard-0002-of-0002.jsonl")
