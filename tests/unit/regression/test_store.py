"""The result file: whole rows survive whatever happens to the process, and foreign files are refused."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from ehl.common.errors import InputError
from regression.data.row_format import NUMBER_UNITS
from regression.data.store import STORE_SCHEMA, ResultStore, merge, read_file, read_run, rows_of_other_files

META: dict[str, str | int] = {
    "plan": "{}",
    "plan_name": "test",
    "plan_hash": "a" * 64,
    "solver_version": "test 1",
    "oil": "fva3",
    "oil_hash": "b" * 64,
    "bodies_hash": "c" * 64,
    "count": 10,
}


def row(number: int, **changes: Any) -> dict[str, Any]:
    values = {
        "key": f"{number:064x}",
        "origin": "sobol",
        "status": "converged",
        "reason": "",
        "skipped": "time",
        "pressure_hertz": 1e9 + number,
        "friction_coefficient": 0.01 * number,
    }
    return {**values, **changes}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    target = tmp_path / "shard-0001-of-0001.h5"
    with ResultStore(target, META) as store:
        store.append([row(1), row(2)])
        store.append([row(3, status="failed", reason="diverged", friction_coefficient=float("nan"))])
    return target


def test_rows_come_back_as_they_were_written(path: Path) -> None:
    meta, frame = read_file(path)
    assert meta["plan_name"] == "test"
    assert meta["schema"] == STORE_SCHEMA
    assert frame["key"].tolist() == [row(n)["key"] for n in (1, 2, 3)]
    assert frame["pressure_hertz"].tolist() == [1e9 + 1, 1e9 + 2, 1e9 + 3]
    assert frame["status"].tolist() == ["converged", "converged", "failed"]
    assert frame["reason"].tolist() == ["", "", "diverged"]
    assert np.isnan(frame["friction_coefficient"][2])
    # not given at all
    assert np.isnan(frame["film_central"]).all()


def test_every_column_states_its_unit(path: Path) -> None:
    with h5py.File(path) as file:
        assert file["pressure_hertz"].attrs["unit"] == "Pa"
        assert file["friction_coefficient"].attrs["unit"] == "1"
        assert all("unit" in file[name].attrs for name in file)


def test_reopening_goes_on_behind_the_last_row(path: Path) -> None:
    with ResultStore(path, META) as store:
        assert store.truncated == 0
        assert set(store.rows()) == {row(n)["key"] for n in (1, 2, 3)}
        store.append([row(4)])
        store.append([])
    assert len(read_file(path)[1]) == 4


def _tear(path: Path, *, values: int, keys: int) -> None:
    """What a process leaves that dies in the middle of writing: longer columns, blank or missing keys."""
    with h5py.File(path, "r+", libver=("earliest", "v110")) as file:
        for name in list(file)[: len(file) // 2]:
            if name not in ("key", "plan"):
                file[name].resize((3 + values,))
        file["key"].resize((3 + keys,))


@pytest.mark.parametrize(("values", "keys"), [(4, 0), (4, 2), (0, 2)])
def test_incomplete_rows_are_ignored_and_cut(path: Path, values: int, keys: int) -> None:
    _tear(path, values=values, keys=keys)
    assert len(read_file(path)[1]) == 3
    with ResultStore(path, META) as store:
        assert store.truncated == max(values, keys)
        store.append([row(9)])
    frame = read_file(path)[1]
    assert frame["key"].tolist() == [row(n)["key"] for n in (1, 2, 3, 9)]
    assert frame["pressure_hertz"].iloc[-1] == 1e9 + 9


def test_newer_schema_is_refused_in_clear_words(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        file.attrs["schema"] = STORE_SCHEMA + 1
        file.attrs["writer"] = "mixed-ehl 9.9"
    for use in (lambda: read_file(path), lambda: ResultStore(path, META)):
        with pytest.raises(InputError, match=r"newer version mixed-ehl 9\.9; update"):
            use()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("plan_hash", "another plan"),
        ("solver_version", "another version of the solver"),
        ("oil_hash", "an oil card with other properties"),
        ("bodies_hash", "materials with other properties"),
    ],
)
def test_results_of_another_run_are_not_mixed_in(path: Path, name: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        ResultStore(path, META | {name: "other"})
    other = path.with_name("shard-0002-of-0002.h5")
    ResultStore(other, META | {name: "other"}).close()
    with pytest.raises(InputError, match=words):
        read_run(path.parent)


def test_other_and_corrupt_files(path: Path) -> None:
    path.write_text("no HDF5")
    for use in (lambda: read_file(path), lambda: ResultStore(path, META)):
        with pytest.raises(InputError, match="corrupt or no result file"):
            use()
    assert [file.name for file in path.parent.iterdir()] == [path.name]
    with h5py.File(path, "w") as file:
        file["x"] = 1
    with pytest.raises(InputError, match="no schema number"):
        read_file(path)
    with h5py.File(path, "w") as file:
        file.attrs["schema"] = STORE_SCHEMA
    for use in (lambda: read_file(path), lambda: ResultStore(path, META)):
        with pytest.raises(InputError, match="Columns key, pressure_hertz"):
            use()


def test_second_writer_is_refused(path: Path) -> None:
    holder = (
        "import sys, h5py\n"
        f"with h5py.File({str(path)!r}, 'r+', libver=('earliest', 'v110')):\n"
        "    print('open', flush=True)\n"
        "    sys.stdin.read()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", holder], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdin is not None
        assert process.stdout.readline() == "open\n"
        with pytest.raises(InputError, match="Is the same shard running"):
            ResultStore(path, META)
        # how far it is can be read all the same
        assert len(read_file(path, locking=False)[1]) == 3
        process.stdin.close()
        assert process.wait() == 0


def test_merge_sorts_and_removes_doubles(path: Path, tmp_path: Path) -> None:
    with ResultStore(path.with_name("shard-0002-of-0002.h5"), META) as store:
        store.append([row(0), row(2)])
    target = tmp_path / "merged" / "all.h5"
    with pytest.raises(InputError, match="folder that exists"):
        merge(path.parent, target)
    target.parent.mkdir()
    assert merge(path.parent, target) == 4
    assert read_file(target)[1]["key"].tolist() == [row(n)["key"] for n in (0, 1, 2, 3)]
    with pytest.raises(InputError, match="does not exist yet"):
        merge(path.parent, target)


def test_runs_that_are_not_there(tmp_path: Path) -> None:
    for run in (tmp_path, tmp_path / "none"):
        with pytest.raises(InputError, match="Run `mixed-ehl sweep"):
            read_run(run)


NUMBERS = {name: float(i) for i, name in enumerate(NUMBER_UNITS)}
MANY = [{**row(n), **{name: value + 1000.0 * n for name, value in NUMBERS.items()}} for n in range(400)]
WRITTEN = {r["key"]: r for r in MANY}


@pytest.fixture(scope="module")
def content(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A file of many rows with a number in every column."""
    path = tmp_path_factory.mktemp("many") / "many.h5"
    with ResultStore(path, META) as store:
        for start in range(0, len(MANY), 40):
            store.append(MANY[start : start + 40])
    return path.read_bytes()


def true_rows(path: Path) -> int:
    """Number of rows in a file, every one of which is what was written."""
    records = read_file(path)[1].to_dict("records")
    assert all(record == {**record, **WRITTEN[record["key"]]} for record in records)
    return len(records)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 0.999])
def test_whole_rows_of_a_file_cut_short_are_saved(path: Path, content: bytes, share: float) -> None:
    path.write_bytes(content[: int(share * len(content))])
    for read in (lambda: read_file(path), lambda: read_run(path.parent)):
        with pytest.raises(InputError, match=r"shard-0001-of-0001\.h5.*corrupt.*sweep again") as caught:
            read()
        assert "running" not in str(caught.value)
    with ResultStore(path, META) as store:
        assert store.recovered == len(store.rows())
        store.append([r for key, r in WRITTEN.items() if key not in store.rows()])
    # the rows of all blocks before the cut
    assert store.recovered >= 64 * int((share - 0.25) * len(MANY) / 64)
    assert (share >= 0.5) == (store.recovered > 0)
    assert path.with_name(path.name + ".corrupt").stat().st_size == int(share * len(content))
    assert true_rows(path) == len(MANY)


def _outcome(use: Callable[[], int]) -> int | str:
    try:
        return use()
    except InputError as error:
        return str(error)


@pytest.mark.parametrize("offset", range(500, 240_000, 17_001))
def test_a_file_overwritten_anywhere_never_gives_a_wrong_number(path: Path, content: bytes, offset: int) -> None:
    noise = np.random.default_rng(offset).integers(0, 256, 3000, dtype=np.uint8).tobytes()
    path.write_bytes(content[:offset] + noise + content[offset + len(noise) :])
    assert len(content) > 240_000

    def resume() -> int:
        with ResultStore(path, META) as store:
            known = store.rows()
            store.append([r for key, r in WRITTEN.items() if key not in known])
        return true_rows(path)

    for outcome in (_outcome(lambda: true_rows(path)), _outcome(resume)):
        assert isinstance(outcome, int) or (path.name in outcome and "corrupt" in outcome)
    # past the head of the file something says what it is, and it can be gone on with
    assert outcome == len(MANY) or offset < 40_000


def test_rows_that_lost_their_checksum_do_not_count(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        file["friction_coefficient"][1] = 0.7
    assert read_file(path)[1]["key"].tolist() == [row(n)["key"] for n in (1, 3)]
    with ResultStore(path, META) as store:
        assert (store.corrupt, store.truncated, store.recovered) == (1, 0, None)
        assert row(2)["key"] not in store.rows()
        store.append([row(2)])
    assert len(read_file(path)[1]) == 3


def test_of_two_shards_the_one_with_a_result_counts(path: Path) -> None:
    with ResultStore(path.with_name("shard-0002-of-0002.h5"), META) as store:
        store.append([row(3, friction_coefficient=0.03), row(2, status="failed", reason="time_cap")])
    frame = read_run(path.parent)[1]
    assert frame["status"].tolist() == ["converged"] * 3
    assert frame["friction_coefficient"].tolist() == [0.01, 0.02, 0.03]
    others = rows_of_other_files(path)
    assert {key: entry[0] for key, entry in others.items()} == {row(2)["key"]: "failed", row(3)["key"]: "converged"}
