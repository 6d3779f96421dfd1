from __future__ import annotations

import re
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

# the same draws on every machine, however loaded
settings.register_profile("gate", deadline=None, derandomize=True)
settings.load_profile("gate")

_approx = pytest.approx


def approx(expected: Any, rel: float | None = None, abs: float | None = None, nan_ok: bool = False) -> Any:
    """`pytest.approx` without its hidden absolute tolerance.

    Of 1e-12, that would accept any compliance [m/N], and pressure-viscosity coefficients to three digits at best.
    """
    if abs is None:
        rel, abs = 1e-6 if rel is None else rel, 0.0
    return _approx(expected, rel=rel, abs=abs, nan_ok=nan_ok)


pytest.approx = approx


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
        if code == 70 and (log := re.search(r" is in (\S+\.log)", captured.err)):
            raise AssertionError(Path(log[1]).read_text(encoding="utf-8"))  # no command may need its last resort
        return Outcome(code, captured.out, captured.err)

    return call


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--regenerate-golden", action="store_true", help="write tests/golden/*.json anew; review the diff")
