"""Kernels that a wheel carries: taken where all fits, else compiled; a carried one gives the bits of its target."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import pytest
from numba import float64, types

from ehl.compile import carried as carried_kernels
from ehl.compile.carried import FEATURES, INDEX, TARGET, carried_kernel, carries, surrounding, why_not, write_carried
from ehl.compile.compiler import missing_on_disk
from ehl.compile.sources import stamped
from ehl.rough._kernels.quasi_separable import exponential_product

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux") or not all(llvm.get_host_cpu_features().get(f, False) for f in FEATURES),
    reason="kernels are carried for Linux on x86-64-v3",
)

ANSWER = """
import sys
from pathlib import Path
import numpy as np
from ehl.compile import carried as carried_kernels
from ehl.compile import sources as kernel_sources
from ehl.rough._kernels.quasi_separable import exponential_product as kernel
if sys.argv[1] == "use":
    carried_kernels.FOLDER = Path(sys.argv[2])
x, out = np.linspace(-2.0, 1.0, 41), np.zeros(41)
kernel(np.cos(x), np.linspace(0.1, 1.0, 24), np.linspace(0.3, 0.99, 24), out)
if sys.argv[1] == "write":
    carried_kernels.write_carried([(*kernel_sources.stamped(kernel.py_func), kernel)], Path(sys.argv[2]))
print(out.tobytes().hex(), len(kernel_sources.compiled))
"""
ROW = types.Array(float64, 1, "C")
NAME, SOURCES = stamped(exponential_product.py_func)


def answer(how: str, folder: Path, **surrounding: str) -> subprocess.CompletedProcess[str]:
    kept = folder.with_name(folder.name + "_cache")
    shutil.rmtree(kept, ignore_errors=True)
    clean = {name: value for name, value in os.environ.items() if not name.startswith(("NUMBA_CPU", "MIXED_EHL"))}
    command, clean = [sys.executable, "-c", ANSWER, how, str(folder)], clean | {"NUMBA_CACHE_DIR": str(kept)}
    return subprocess.run(command, env=clean | surrounding, capture_output=True, text=True, check=True)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """Folder of one kernel compiled for the target, and the answer of the process that did."""
    folder = tmp_path_factory.mktemp("kernels") / "carried"
    made = answer("write", folder, NUMBA_CPU_NAME=TARGET[0], NUMBA_CPU_FEATURES=TARGET[1])
    return folder, made.stdout.split()[0]


@pytest.fixture
def folder(written: tuple[Path, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    copy = Path(shutil.copytree(written[0], tmp_path / "carried"))
    for name in ("CPU_NAME", "CPU_FEATURES"):
        monkeypatch.setattr(carried_kernels.config, name, None)
    monkeypatch.delenv("MIXED_EHL_KERNELS", raising=False)
    monkeypatch.setattr(carried_kernels, "FOLDER", copy)
    carried_kernels._entries.cache_clear()
    yield copy
    carried_kernels._entries.cache_clear()


def change(folder: Path, **entries: Any) -> None:
    index = json.loads((folder / INDEX).read_text())
    (folder / INDEX).write_text(json.dumps(index | entries))


def test_a_carried_kernel_gives_the_bits_of_its_target_and_nothing_is_compiled(written: tuple[Path, str]) -> None:
    folder, bits = written
    taken = answer("use", folder)
    assert taken.stdout.split() == [bits, "0"]
    assert taken.stderr == ""
    assert not list(folder.with_name("carried_cache").rglob("*.nbc"))


def test_what_is_carried_counts_before_what_is_on_disk(folder: Path) -> None:
    assert why_not() is None
    assert carries(NAME, SOURCES)
    assert not missing_on_disk(exponential_product)
    library, *_ = carried_kernel(NAME, SOURCES, (ROW, ROW, ROW, ROW))
    assert library[1] == "object"
    assert carried_kernel(NAME, SOURCES, (ROW, ROW, ROW)) is None
    assert not carries(NAME + "s", SOURCES)
    assert not carries(NAME, SOURCES[::-1])


def one_bit_flipped(content: bytes) -> bytes:
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]


@pytest.mark.parametrize(
    ("name", "damaged"),
    [
        (f"{NAME}.bin", one_bit_flipped),
        (f"{NAME}.bin", None),
        (INDEX, None),
        (INDEX, lambda content: b"{\xff"),
        (INDEX, lambda content: b"[]"),
        (INDEX, lambda content: json.dumps(json.loads(content) | {"kernels": {NAME: [1]}}).encode()),
        (INDEX, lambda content: content.replace(f"{NAME}.bin".encode(), b"../elsewhere")),
    ],
)
def test_what_is_damaged_does_not_count(folder: Path, name: str, damaged: Callable[[bytes], bytes] | None) -> None:
    content = (folder / name).read_bytes()
    (folder / name).unlink()
    if damaged is not None:
        (folder / name).write_bytes(damaged(content))
    assert not carries(NAME, SOURCES)
    assert carried_kernel(NAME, SOURCES, (ROW, ROW, ROW, ROW)) is None


@pytest.mark.parametrize("what", ["python", "numba", "llvmlite", "platform"])
def test_kernels_for_another_surrounding_do_not_count(folder: Path, what: str) -> None:
    change(folder, surrounding=surrounding() | {what: "of old"})
    assert why_not() == f"the precompiled kernels are for {what} of old"
    assert not carries(NAME, SOURCES)


def test_who_names_a_processor_or_has_an_older_one_compiles(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused() -> str:
        carried_kernels._entries.cache_clear()
        assert not carries(NAME, SOURCES)
        return str(why_not())

    with monkeypatch.context() as patch:
        patch.setenv("MIXED_EHL_KERNELS", "native")
        assert "MIXED_EHL_KERNELS" in refused()
    for name in ("CPU_NAME", "CPU_FEATURES"):
        with monkeypatch.context() as patch:
            patch.setattr(carried_kernels.config, name, "generic")
            assert "NUMBA_CPU_NAME" in refused()
    has = llvm.get_host_cpu_features()
    monkeypatch.setattr(carried_kernels.llvm, "get_host_cpu_features", lambda: dict(has, fma=False))
    assert "fma" in refused()
    change(folder, features=None)
    assert "index" in refused()


def test_features_of_written_kernels(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def needed(place: Path) -> set[str]:
        return set(json.loads((place / INDEX).read_text())["features"])

    assert needed(folder) == set(FEATURES)
    write_carried([], tmp_path / "new")
    assert needed(tmp_path / "new") == {name for name, has in llvm.get_host_cpu_features().items() if has}
    monkeypatch.setattr(carried_kernels.config, "CPU_NAME", "generic")
    with pytest.raises(RuntimeError):
        write_carried([], tmp_path / "other")
