"""Results kept on disk between processes: found again, computed again where an entry cannot be trusted."""

import hashlib
import os
import pickle
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ehl.common import private_files
from ehl.common.private_files import kept, user_folder

OF_USERS = pytest.mark.skipif(not hasattr(os, "getuid"), reason="folders of users")


@pytest.fixture
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The folder of kept results, not made yet."""
    monkeypatch.setenv("MIXED_EHL_CACHE", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path / "cache" / "mixed-ehl" / "results"


class Count:
    """Computes a result and counts how often."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self) -> dict[str, Any]:
        self.calls += 1
        return {"values": np.linspace(0.0, 1.0, 5) / 3.0, "call": self.calls}


class Attack:
    """Makes a folder where it is loaded."""

    def __init__(self, made: Path) -> None:
        self.made = made

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return os.mkdir, (str(self.made),)


def test_a_result_is_computed_once_and_always_where_it_cannot_be_kept(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make = Count()
    first, second = kept("results", "a", make), kept("results", "a", make)
    assert make.calls == 1
    assert first["values"].tobytes() == second["values"].tobytes()
    assert folder.stat().st_mode & 0o777 == 0o700 or os.name == "nt"
    assert [file.name for file in folder.iterdir()] == ["a"]
    # turned off, and without a place
    monkeypatch.setenv("MIXED_EHL_CACHE", "off")
    assert kept("results", "a", make)["call"] == 2
    monkeypatch.delenv("MIXED_EHL_CACHE")

    def nowhere(kind: str, first: Path | None) -> Path:
        raise PermissionError(kind)

    monkeypatch.setattr(private_files, "user_folder", nowhere)
    assert kept("results", "a", make)["call"] == 3


@pytest.mark.parametrize(
    "damage",
    [
        lambda content: b"",
        lambda content: content[:-1],
        lambda content: content[:40] + bytes([content[40] ^ 1]) + content[41:],
        # whole, but of a class that is no longer there
        lambda content: hashlib.sha256(b"cno_module\nno_class\n.").digest() + b"cno_module\nno_class\n.",
    ],
)
def test_a_damaged_entry_is_computed_again(folder: Path, damage: Callable[[bytes], bytes]) -> None:
    make = Count()
    kept("results", "a", make)
    entry = folder / "a"
    entry.write_bytes(damage(entry.read_bytes()))
    assert kept("results", "a", make)["call"] == 2
    assert kept("results", "a", make)["call"] == 2
    assert make.calls == 2


@OF_USERS
def test_nothing_is_loaded_that_others_could_have_written(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make, ran = Count(), tmp_path / "ran"
    content = pickle.dumps(Attack(ran))
    planted = tmp_path / "planted"
    planted.write_bytes(hashlib.sha256(content).digest() + content)
    # a link in the folder, a file without its hash
    user_folder("results")
    (folder / "a").symlink_to(planted)
    (folder / "b").write_bytes(content)
    assert kept("results", "a", make)["call"] == 1
    assert kept("results", "b", make)["call"] == 2
    # a folder that others can write to is passed over, with what is in it
    folder.chmod(0o777)
    (folder / "c").write_bytes(planted.read_bytes())
    assert kept("results", "c", make)["call"] == 3
    assert not ran.exists()
    # a file of another user
    folder.chmod(0o700)
    true = os.fstat
    monkeypatch.setattr(
        private_files.os,
        "fstat",
        lambda number: os.stat_result([*true(number)[:4], os.getuid() + 1, *true(number)[5:]]),
    )
    assert kept("results", "c", make)["call"] == 4
    assert not ran.exists()


def test_the_least_recently_used_entries_go(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(private_files, "ENTRIES", 3)
    for place, key in enumerate("abc"):
        kept("results", key, Count())
        os.utime(folder / key, (place, place))
    make = Count()
    kept("results", "a", make)
    kept("results", "d", Count())
    assert make.calls == 0
    assert {file.name for file in folder.iterdir()} == {"a", "c", "d"}
