"""The pages docs/friction_formula.md and docs/sweep.md: their plans and their commands work as printed."""

import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "friction_formula.md").read_text(encoding="utf-8")


def block(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", PAGE, flags=re.DOTALL)
    assert found is not None
    return found.group(1)


@pytest.mark.usefixtures("commands_alone")
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


SWEEP_PAGE = (Path(__file__).resolve().parents[3] / "docs" / "sweep.md").read_text(encoding="utf-8")


def test_plan_and_commands_of_the_page_on_sweeps(
    mixed_ehl: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (plan,) = re.findall(r"```toml\n(.*?)```", SWEEP_PAGE, flags=re.DOTALL)
    Path("plan.toml").write_text(plan)
    found = re.search(r"```sh\n(.*?)```", SWEEP_PAGE, flags=re.DOTALL)
    assert found is not None
    commands = [shlex.split(line)[1:] for line in found.group(1).splitlines()]
    commands[1] += ["--with", "xu_kahraman_2007", "--jobs", "1"]
    outcomes = [mixed_ehl(*command) for command in commands]
    assert [outcome.code for outcome in outcomes] == [0] * 4
    # two oils, two levels, 48 points and the corners inside
    finished = re.search(r"(\d+) of (\d+) cases", outcomes[2].out)
    assert finished is not None
    assert 4 * 48 < int(finished[1]) == int(finished[2]) <= 4 * (48 + 8)
