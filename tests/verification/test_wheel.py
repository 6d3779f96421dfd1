"""A user without the checkout: build the wheel, install it in a fresh environment, run the main job elsewhere."""

import json
import os
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def build(folder: Path, **surrounding: str) -> Path:
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation", "-w", str(folder), str(ROOT)],
        env={name: value for name, value in os.environ.items() if name != "MIXED_EHL_KERNELS"} | surrounding,
        check=True,
        capture_output=True,
    )
    (built,) = folder.glob("mixed_ehl-*.whl")
    return built


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build(tmp_path_factory.mktemp("wheel"), MIXED_EHL_KERNELS="none")


def test_wheel_carries_the_data_and_nothing_foreign(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    for folder in (ROOT / "data").iterdir():
        for file in (found for found in folder.rglob("*") if found.is_file()):
            assert f"ehl/_data/{file.relative_to(ROOT / 'data').as_posix()}" in names
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"ehl", "regression", "efficiency"}
    # one wheel for all: kernels are compiled where they run, nothing in it depends on Python or machine
    assert wheel.name.endswith("-py3-none-any.whl")
    assert not [name for name in names if name.endswith((".so", ".pyd", ".dylib", ".nbi", ".nbc", ".pyc", ".bin"))]


@pytest.mark.wheel
@pytest.mark.skipif(sysconfig.get_platform() != "linux-x86_64", reason="looks for the name of its wheel")
def test_demo_runs_from_an_installed_wheel_and_compiles_nothing(tmp_path: Path) -> None:
    """What the wheel compiles while it is built, the demo does not. `.ci/versions` tries the wheel without kernels."""
    wheel = build(tmp_path / "wheel")
    python_tag = f"cp{sys.version_info.major}{sys.version_info.minor}"
    assert wheel.name.endswith(f"-{python_tag}-{python_tag}-linux_x86_64.whl")
    assert "ehl/_carried/ehl.rough._kernels.march.march.bin" in zipfile.ZipFile(wheel).namelist()
    environment = tmp_path / "environment"
    venv.create(environment, with_pip=True)
    python = environment / "bin" / "python"
    subprocess.run(
        [python, "-m", "pip", "install", "-q", "--no-deps", "--no-index", str(wheel)], check=True, capture_output=True
    )
    # the dependencies come from the environment of this test; a path line does not follow the .pth files there,
    # so the editable installation stays invisible
    (site,) = environment.glob("lib/python*/site-packages")
    (site / "dependencies.pth").write_text(sysconfig.get_paths()["purelib"] + "\n")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    clean = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "COV_", "MIXED_EHL"))}
    run = subprocess.run(
        [environment / "bin" / "mixed-ehl", "demo", "--output", "out", "--jobs", "1"],
        cwd=elsewhere,
        env={**clean, "NUMBA_CACHE_DIR": str(tmp_path / "numba")},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert "compiling" not in run.stderr
    assert not list((tmp_path / "numba").rglob("*.nbc"))
    report = (elsewhere / "out" / "report.html").read_text(encoding="utf-8")
    summary = json.loads((elsewhere / "out" / "demo.json").read_text(encoding="utf-8"))
    assert 0.95 < summary["gear"]["efficiency"] < 1.0
    assert "<svg" in report
    where = subprocess.run(
        [python, "-c", "import ehl; print(ehl.__file__)"], cwd=elsewhere, env=clean, capture_output=True, text=True
    )
    assert str(environment) in where.stdout
