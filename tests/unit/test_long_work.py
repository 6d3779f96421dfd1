"""Long work is heard of within five seconds, says how long it will take, and what is kept where it is stopped."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import regression
from ehl.common import console
from ehl.common.console import FIRST_WORD, WORD_EVERY, Pulse, progress, working
from ehl.common.progress import listening, tell

Cli = Callable[..., Any]


@dataclass
class Clock:
    now: float = 100.0

    def __call__(self) -> float:
        return self.now


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_the_first_word_comes_within_five_seconds_and_further_ones_twice_a_minute() -> None:
    stream, clock = io.StringIO(), Clock()
    pulse = Pulse("comparison", stream, clock)
    said = []
    for second in range(70):
        clock.now = 100.0 + second
        pulse.tick()
        said.append(stream.getvalue().count("\n"))
    first = said.index(1)
    assert first == FIRST_WORD <= 5.0
    assert said.index(2) == first + WORD_EVERY
    assert stream.getvalue().splitlines()[0] == "mixed-ehl: comparison, 3 s elapsed"


def test_the_remaining_time_is_that_of_the_step_at_hand() -> None:
    clock = Clock()
    pulse = Pulse("comparison", io.StringIO(), clock)
    clock.now += 40.0
    pulse.move("contacts", 0, 80)
    assert pulse.words() == "comparison, contacts 0 of 80, 40 s elapsed"
    pulse.move("contacts", 0, 80, 44.0)
    assert pulse.words() == "comparison, contacts 0 of 80, 40 s elapsed, about 44 s as estimated"
    clock.now += 10.0
    pulse.move("contacts", 20, 80)
    assert pulse.words() == "comparison, contacts 20 of 80, 50 s elapsed, about 30 s left"
    pulse.move("contacts", 80, 80)
    assert pulse.words() == "comparison, contacts 80 of 80, 50 s elapsed"


def test_a_terminal_has_one_line_that_is_empty_in_the_end() -> None:
    stream, clock = Terminal(), Clock()
    pulse = Pulse("fit", stream, clock)
    pulse.clear()
    assert stream.getvalue() == ""
    for _ in range(3):
        clock.now += 3.0
        pulse.tick()
    pulse.clear()
    assert "\n" not in stream.getvalue()
    assert "fit, 9 s elapsed" in stream.getvalue()
    assert stream.getvalue().endswith("\r\x1b[K")


def test_what_is_told_deep_inside_is_heard_and_only_there(monkeypatch: pytest.MonkeyPatch) -> None:
    heard: list[tuple[str, int, int]] = []
    tell("contacts", 1, 2)
    with listening(lambda *state: heard.append(state)):
        tell("contacts", 1, 2)
    tell("contacts", 2, 2)
    assert heard == [("contacts", 1, 2)]
    with working("work") as pulse:
        tell("contacts", 3, 4)
        assert (pulse.step, pulse.done, pulse.total) == ("contacts", 3, 4)
    with progress("points") as move:
        move(1, 5)
        move("points", 2, 5)


def test_ctrl_c_says_what_is_kept_and_how_to_go_on(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped, working("fit", "rows are kept, the same command resumes"):
        raise KeyboardInterrupt
    assert stopped.value.code == console.STOPPED == 130
    assert capsys.readouterr().err == "mixed-ehl: stopped after 0 s; rows are kept, the same command resumes\n"


def test_stopped_commands(mixed_ehl: Cli, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def stop(*arguments: Any, **options: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(regression, "fit", stop)
    fitted = mixed_ehl("fit", "gear_fva3", "-o", tmp_path / "f.json")
    assert (fitted.code, "the same command begins again" in fitted.err) == (130, True)
    monkeypatch.setattr(regression, "sweep", stop)
    swept = mixed_ehl("sweep", "demo", "-o", tmp_path / "run")
    assert swept.code == 130
    assert f"finished cases are kept in {tmp_path / 'run'}, the same command resumes" in swept.err
