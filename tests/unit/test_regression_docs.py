"""The page docs/friction_formula.md: its plan and its commands work as printed."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from regression.families import FAMILIES

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "friction_formula.md").read_text(encoding="utf-8")


def block(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", PAGE, flags=re.DOTALL)
    assert found is not None
    return found.group(1)


def test_plan_and_commands_of_the_page(
    mixed_ehl: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("plan.toml").write_text(block("toml"))
    commands = [shlex.split(line)[1:] for line in block("sh").splitlines()]
    assert [command[0] for command in commands] == ["sweep", "sweep", "sweep", "fit", "mu"]
    # 96 cases of the solver would take too long here; the arguments are those of the page
    commands[0] += ["--with", "arana_2019", "--jobs", "1"]
    outcomes = [mixed_ehl(*command) for command in commands]
    assert [outcome.code for outcome in outcomes] == [0] * 5
    assert "96 of 96 cases" in outcomes[1].out
    assert outcomes[4].out.startswith("mu = 0.0")


def test_every_family_is_described() -> None:
    for name in FAMILIES:
        assert f"| `{name}` |" in PAGE
