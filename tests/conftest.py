import atexit
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

# bodies, roots and meshes of designs are computed once for all processes of a session
if "PYTEST_XDIST_WORKER" not in os.environ:
    os.environ["MIXED_EHL_CACHE"] = tempfile.mkdtemp(prefix="mixed-ehl-tests-")
    atexit.register(shutil.rmtree, os.environ["MIXED_EHL_CACHE"], ignore_errors=True)

# threads of the BLAS wait for each other and for other workers; processes of tests inherit this
for _library in ("OPENBLAS", "MKL", "OMP", "BLIS"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

# the same draws on every machine, however loaded
settings.register_profile("gate", deadline=None, derandomize=True)
settings.load_profile("gate")

# files of the marker `fast`, by folder: cheap tests of every package, some 70 s of processor time with warm kernels
FAST = {
    "unit/ehl": ("units table inputs lubricant finish"),
    "unit/regression": ("plan friction_models code_record noise table_files calibration_inputs"),
    "unit/efficiency": (
        "blank cutting_design cutting_kinematics contact_sample load_equilibrium output_solid "
        "grid strength loss lubrication"
    ),
    "unit": ("import_direction"),
    "golden": ("golden"),
}

# files that reach with those of `fast` every line and branch of input, units, formula files and journal
PARTS = {
    "unit/ehl": "measured_surface",
    "unit/regression": "store formula interface datasets",
    "unit": "mistakes",
}

# files of the longest tests, which come first: none is left to one process when the others have ended
LONGEST = (
    "verification/test_wheel verification/regression/test_real_slurm unit/test_examples unit/test_pages "
    "unit/test_public_docs verification/regression/test_slurm unit/efficiency/test_app unit/regression/test_cli"
)

_approx = pytest.approx


def approx(expected: Any, rel: float | None = None, abs: float | None = None, nan_ok: bool = False) -> Any:
    """`pytest.approx` without its hidden absolute tolerance.

    Of 1e-12, that would accept any compliance [m/N], and pressure-viscosity coefficients to three digits at best.
    """
    if abs is None:
        rel, abs = 1e-6 if rel is None else rel, 0.0
    return _approx(expected, rel=rel, abs=abs, nan_ok=nan_ok)


pytest.approx = approx


@pytest.fixture(scope="session", autouse=True)
def _svg() -> Iterator[Any]:
    """All pairs keep their bodies; figures of pages are not drawn: its value draws them."""
    from efficiency.pair import GearPair
    from ehl.common import pages

    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(GearPair.__init__.__kwdefaults__, "keep", True)
        drawn = pages.picture_svg
        patch.setattr(pages, "picture_svg", lambda picture: "<svg></svg>")
        yield drawn


@pytest.fixture
def svg_figures(monkeypatch: pytest.MonkeyPatch, _svg: Any) -> None:
    """Figures of pages are drawn and written as SVG: one test of each layout of page needs it."""
    monkeypatch.setattr("ehl.common.pages.picture_svg", _svg)


@pytest.fixture(autouse=True)
def _close_figures() -> Iterator[None]:
    """Close the figures that a test drew: `plot()` of a result opens one."""
    yield
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is not None:
        pyplot.close("all")


@pytest.fixture(scope="session")
def design() -> Any:
    """The shipped spiral bevel pair."""
    from efficiency.design.design import load_design

    return load_design("fm_spiral_bevel_14x39")


@pytest.fixture
def little_training(monkeypatch: pytest.MonkeyPatch) -> None:
    """Networks of a few steps, where what follows from the fit is in question: `test_fit_checks` trains them whole."""
    monkeypatch.setattr("regression.fitting.coefficients._STEPS", (5, 5))


@pytest.fixture
def coarse_roots(monkeypatch: pytest.MonkeyPatch) -> None:
    """Roots of few elements, kept apart from those of other tests: `test_load_solid` is about their number."""
    from efficiency.strength import root_stress

    monkeypatch.setenv("MIXED_EHL_CACHE", os.path.join(os.environ["MIXED_EHL_CACHE"], "coarse"))
    monkeypatch.setattr(root_stress, "Counts", partial(root_stress.Counts, 3, 4, 1, 1, 1, 6))


@pytest.fixture
def commands_alone(monkeypatch: pytest.MonkeyPatch, little_training: None, coarse_roots: None) -> None:
    """Coarse meshes and roots, networks hardly trained: each has its own tests."""
    from efficiency.pair import GearPair

    mesh = GearPair.mesh

    def coarse(self: Any, side: Any = "drive", positions: int = 8, points_per_line: int = 15, **moved: Any) -> Any:
        return mesh(self, side, positions, points_per_line, **moved)

    monkeypatch.setattr(GearPair, "mesh", coarse)


@pytest.fixture
def small_search(monkeypatch: pytest.MonkeyPatch, coarse_roots: None) -> None:
    """A search for a better ease-off and its check on one small mesh: `test_optimise` is about the search."""
    for name in ("optimise.SEARCH_GRID", "check.CHECK_GRID", "report.CHECK_GRID"):
        monkeypatch.setattr(f"efficiency.optimisation.{name}", (6, 11))
    monkeypatch.setattr("efficiency.optimisation.optimise._FIRST", 1)


@dataclass(frozen=True)
class Outcome:
    """What one call of the command line gave."""

    code: int
    out: str
    err: str


@cache
def _commands() -> Any:
    """The parsers of all commands, built once: that takes longer than most of the commands tested."""
    from typer.main import get_command

    from efficiency.cli import app

    return get_command(app)


@pytest.fixture
def mixed_ehl(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Outcome]:
    """Call the command line in this process: ``mixed_ehl("solve", "case.toml", "--json")``."""
    from efficiency.cli import main

    monkeypatch.setattr("efficiency.cli.app", _commands())

    def call(*arguments: object) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["mixed-ehl", *map(str, arguments)])
        capsys.readouterr()
        code = 0
        try:
            main()
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else int(end.code is not None)
        captured = capsys.readouterr()
        if code == 70 and (log := re.search(r"Details: (\S+\.log)", captured.err)):
            raise AssertionError(Path(log[1]).read_text(encoding="utf-8"))  # no command may need its last resort
        return Outcome(code, captured.out, captured.err)

    return call


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--regenerate-golden", action="store_true", help="update tests/golden/*.json; review the diff")


_TESTS = Path(__file__).parent
_FIRST = [_TESTS / f"{name}.py" for name in LONGEST.split()]
_FAST, _PARTS = (
    {_TESTS / folder / f"test_{name}.py" for folder, names in table.items() for name in names.split()}
    for table in (FAST, PARTS)
)


def pytest_sessionfinish() -> None:
    """Write the coverage of a worker, which is killed where it takes ten seconds to end."""
    coverage = sys.modules.get("coverage")
    if coverage is not None and (measured := coverage.Coverage.current()) is not None:
        measured.save()


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """With ``-m fast`` or ``-m "fast or parts"`` no other file is imported."""
    wanted = {"fast": _FAST, "fast or parts": _FAST | _PARTS}.get(config.option.markexpr)
    return True if wanted is not None and collection_path.suffix == ".py" and collection_path not in wanted else None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the files in `LONGEST` first, and mark the tests of those in `FAST` and `PARTS`."""
    items.sort(key=lambda item: _FIRST.index(item.path) if item.path in _FIRST else len(_FIRST))
    for item in items:
        if item.path in _FAST:
            item.add_marker(pytest.mark.fast)
        if item.path in _PARTS:
            item.add_marker(pytest.mark.parts)
