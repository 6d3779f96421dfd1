"""Compiled kernels and kept results: under the contents of their sources, and only from folders of the user."""

import hashlib
import json
import os
import pickle
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numba
import numpy as np
import pytest
from numba import config, njit
from numba.core.caching import UserProvidedCacheLocator
from refusals import refuses

from ehl.common import private_files
from ehl.common.private_files import kept, private_folder, user_folder
from ehl.compile import sources as kernel_sources
from ehl.compile.compiler import INTERNAL_KERNEL, KERNEL, kernel, missing_on_disk
from ehl.compile.internals import KernelCache
from ehl.compile.sources import _SHARED, kernel_folder, source_hash
from ehl.rough._kernels import quasi_separable
from ehl.smooth import _kernels as smooth_kernels
from ehl.smooth._kernels import newton
from ehl.warmup import warm_up

ANSWER = """
import numpy as np
from ehl.rough._kernels.quasi_separable import exponential_product
x, out = np.linspace(-2.0, 1.0, 41), np.zeros(41)
exponential_product(np.cos(x), np.linspace(0.1, 1.0, 20), np.linspace(0.3, 0.99, 20), out)
print(out.tobytes().hex())
"""


@njit(**INTERNAL_KERNEL)
def inner(x):
    return 0.1 * x if x < 3.0 else 0.2 * x


@kernel(cache=False, **KERNEL)
def outer(x):
    total = 0.0
    for k in range(9):
        total += inner(x + k)
    return total


def test_what_a_kernel_calls_is_private_to_it() -> None:
    assert outer(0.5) == pytest.approx(sum(0.1 * x if x < 3.0 else 0.2 * x for x in 0.5 + np.arange(9.0)), rel=1e-15)
    (result,) = outer.overloads.values()
    # no copy of another function that a process could have loaded before
    shared = [f.name for f in result.library.get_defined_functions() if f.linkage.name.startswith("linkonce")]
    assert shared == []
    (called,) = inner.overloads.values()
    assert called.library.get_pointer_to_function(called.fndesc.llvm_func_name) == 0


def test_the_stamp_of_a_kernel_follows_the_contents_of_all_its_sources(tmp_path: Path) -> None:
    def stamp(**contents: str) -> bytes:
        for name, text in contents.items():
            (folder / f"{name}.py").write_text(text)
        return source_hash(folder)

    (folder := tmp_path / "_kernels").mkdir()
    before = stamp(one="a = 1\n", two="b = 2\n")
    os.utime(folder / "two.py", (50.0, 50.0))
    assert stamp() == before != stamp(two="b = 3\n")
    assert stamp(one="b = 2\n", two="a = 1\n") != before  # files that trade their contents are other sources


def test_kernels_on_disk_carry_the_stamp_and_another_one_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    warm_up("smooth")
    stored = newton._cache.disk
    assert stored._impl.locator.get_source_stamp() == source_hash(Path(str(smooth_kernels.__file__)).parent)
    assert not missing_on_disk(newton)
    monkeypatch.setattr(stored._cache_file, "_source_stamp", b"of other sources")
    assert missing_on_disk(newton)
    # where nothing is compiled, or kept, nothing is missing
    assert not missing_on_disk(lambda: None)


OF_USERS = pytest.mark.skipif(not hasattr(os, "getuid"), reason="under Windows each user's folders are private")


@pytest.fixture
def places(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[Path]:
    """The three folders that compiled kernels may be in, none made yet: given, of the user, temporary."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "given"))
    names = ("given", "cache/mixed-ehl/kernels", f"mixed-ehl-kernels-{os.getuid()}")
    return [tmp_path / name for name in names]


def plant(folder: Path, how: str) -> None:
    """Put something in the place of a private folder; "private" makes the folder itself."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    if how == "file":
        folder.write_text("")
        return
    made = folder.with_name(f"behind_{folder.name}") if how == "link" else folder
    made.mkdir(mode=0o700)
    if how == "link":
        folder.symlink_to(made)
    elif how == "open to others":
        folder.chmod(0o770)
    elif how == "below one of all":
        folder.parent.chmod(0o777)
    elif how == "of another":
        if os.getuid() != 0:
            pytest.skip("only the administrator can give a folder away")
        os.chown(folder, 12345, -1)


@OF_USERS
@pytest.mark.parametrize("how", ["open to others", "link", "of another", "file"])
def test_kernels_are_in_the_first_folder_that_belongs_to_the_user_alone(places, capfd, how):
    kernel_sources._report_refused.cache_clear()
    for folder in places:
        assert kernel_folder() == folder
        assert folder.stat().st_mode & 0o777 == 0o700
        assert Path(str(KernelCache(newton.py_func).cache_path)).parent == folder
        shutil.rmtree(folder)
        plant(folder, how)
        with pytest.raises((PermissionError, FileExistsError)):
            private_folder(folder)
    with pytest.raises((PermissionError, FileExistsError)):
        kernel_folder()
    assert KernelCache(newton.py_func).cache_path is None  # each process compiles its own
    assert capfd.readouterr().err.count("NUMBA_CACHE_DIR is not used") == 1


@dataclass
class Attack:
    """Runs a command of another where it is loaded."""

    made: Path

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return os.mkdir, (str(self.made),)


@OF_USERS
@pytest.mark.parametrize("how", ["private", "of another", "below one of all"])
def test_nothing_is_loaded_from_a_folder_of_others(tmp_path: Path, how: str) -> None:
    planted, ran = tmp_path / "between" / "planted", tmp_path / "ran"
    plant(planted, how)
    function = quasi_separable.exponential_product.py_func
    index = Path(KernelCache(function).disk._cache_file._index_path)
    # as the program lays it out, and as numba does
    for name in (index.parent.name, UserProvidedCacheLocator.get_suitable_cache_subpath(quasi_separable.__file__)):
        (planted / name).mkdir(mode=0o700)
        content = pickle.dumps(numba.__version__) + pickle.dumps(Attack(ran))
        (planted / name / index.name).write_bytes(content)
    surrounding = os.environ | {"NUMBA_CACHE_DIR": str(planted)}
    run = subprocess.run([sys.executable, "-c", ANSWER], env=surrounding, capture_output=True, text=True)
    trusted = how == "private"  # what is planted there does run
    assert ran.exists() == trusted
    assert ("NUMBA_CACHE_DIR is not used" in run.stderr) != trusted
    assert (run.returncode == 0 and run.stdout != "") != trusted


def test_warmup(mixed_ehl: Callable[..., Any]) -> None:
    warm_up("smooth")
    again = warm_up("smooth")
    assert (again.kinds, again.compiled, again.seconds_cpu) == (("smooth",), {"smooth": 0}, {"smooth": 0})
    assert json.loads(mixed_ehl("warmup", "smooth", "--json").out)["compiled"] == {"smooth": 0}
    assert [mixed_ehl("warmup", kind).code for kind in ("smooth", "wet")] == [0, 2]
    with refuses("kind"):
        warm_up("all")


def test_a_loaded_kernel_gives_the_bits_of_a_compiled_one(tmp_path: Path) -> None:
    """What is compiled is announced once; an untested version compiles by the public interface of numba."""
    before = "import sys, numba\nnumba.__version__ = sys.argv[1]\n"
    after = "from ehl.compile import carried, compiler\nprint(carried.why_not(), len(compiler.compiled_kernels()))"
    runs = [
        subprocess.run(
            [sys.executable, "-c", before + ANSWER.replace("print(", "print(*out) #") + after, version],
            env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}, capture_output=True, text=True, check=True,
        )
        for version in (numba.__version__, numba.__version__, "99.0", "99.0")
    ]  # fmt: skip
    answers, ways = zip(*(run.stdout.splitlines() for run in runs), strict=True)
    assert answers[0] == answers[1]
    assert [len(run.stderr.splitlines()) for run in runs[:2]] == [1, 0]
    assert "99.0" not in ways[0]
    assert [way.split()[1] for way in ways[2:]] == ["99.0", "99.0"]
    assert [way.split()[-1] for way in ways[2:]] == ["1", "0"]  # then it is on disk
    assert [run.stderr.count("numba 99.0") for run in runs[2:]] == [1, 0]
    tested, first, again = (np.array(answer.split(), float) for answer in answers[1:])
    np.testing.assert_allclose([first, again], [tested, tested], rtol=1e-12, atol=1e-14)


@pytest.mark.fast
@pytest.mark.parametrize("name", ["rough/_kernels", "smooth", "heat", "fluid", "compile"])
def test_hash_of_kernels_has_every_kernel_they_call(name: str) -> None:
    """A kernel holds the code of those it calls: a change of any of them must not leave the stored one in use."""
    root = Path(str(smooth_kernels.__file__)).parents[1]
    own = set((root / name).glob("*.py" if name.endswith("_kernels") else "_kernels.py"))
    imported = re.compile(r"^from ehl\.([\w.]*_kernels[\w.]*) import", re.M)
    for source in own:
        for module in imported.findall(source.read_text(encoding="utf-8")):
            called = root / (module.replace(".", "/") + ".py")
            assert called in own | set(_SHARED), f"{source.name} calls {module}"


@pytest.fixture
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setenv("MIXED_EHL_CACHE", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path / "cache" / "mixed-ehl" / "results"


def counted() -> Callable[[], dict[str, Any]]:
    calls = count(1)
    return lambda: {"values": np.linspace(0.0, 1.0, 5) / 3.0, "call": next(calls)}


def test_a_result_is_computed_once(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make = counted()
    first, second = kept("results", "a", make), kept("results", "a", make)
    assert first["call"] == second["call"] == 1
    assert first["values"].tobytes() == second["values"].tobytes()
    assert folder.stat().st_mode & 0o777 == 0o700 or os.name == "nt"
    assert [file.name for file in folder.iterdir()] == ["a"]
    # turned off, and without a place
    monkeypatch.setenv("MIXED_EHL_CACHE", "off")
    assert kept("results", "a", make)["call"] == 2
    monkeypatch.delenv("MIXED_EHL_CACHE")
    monkeypatch.setattr(private_files, "user_folder", Mock(side_effect=PermissionError))
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
    make = counted()
    kept("results", "a", make)
    entry = folder / "a"
    entry.write_bytes(damage(entry.read_bytes()))
    assert [kept("results", "a", make)["call"] for _ in range(2)] == [2, 2]


@OF_USERS
def test_nothing_of_others_is_loaded(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make, ran = counted(), tmp_path / "ran"
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
    true, other = os.fstat, os.getuid() + 1
    monkeypatch.setattr(private_files.os, "fstat", lambda n: os.stat_result([*true(n)[:4], other, *true(n)[5:]]))
    assert kept("results", "c", make)["call"] == 4
    assert not ran.exists()


def test_the_least_recently_used_entries_go(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(private_files, "ENTRIES", 3)
    for place, key in enumerate("abc"):
        kept("results", key, counted())
        os.utime(folder / key, (place, place))
    kept("results", "a", counted())
    kept("results", "d", counted())
    assert {file.name for file in folder.iterdir()} == {"a", "c", "d"}
