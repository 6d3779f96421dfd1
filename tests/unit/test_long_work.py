"""Progress of long computations on a terminal and in a log, and what a stopped command states."""

import io
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from ehl.common import console
from ehl.common.console import FIRST_DISPLAY, LINE_EVERY, ProgressDisplay, working
from ehl.common.progress import Progress, duration, progress_to, report_progress


@dataclass
class Clock:
    now: float = 100.0

    def __call__(self) -> float:
        return self.now


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_the_first_line_comes_within_five_seconds_and_further_ones_twice_a_minute() -> None:
    stream, clock = io.StringIO(), Clock()
    display = ProgressDisplay("comparison", stream, clock)
    lines = []
    for second in range(70):
        clock.now = 100.0 + second
        display.refresh()
        lines.append(stream.getvalue().count("\n"))
    first = lines.index(1)
    assert first == FIRST_DISPLAY <= 5.0
    assert lines.index(2) == first + LINE_EVERY


def test_the_remaining_time_is_that_of_the_current_step() -> None:
    clock = Clock()
    display = ProgressDisplay("comparison", io.StringIO(), clock)
    clock.now += 40.0
    # a stated time is shown at once and counts down
    for later, state, text in (
        (0.0, (0, 80), "0 of 80, 40 s elapsed"),
        (0.0, (0, 80, 44.0), "0 of 80, 40 s elapsed, about 44 s left"),
        (10.0, None, "0 of 80, 50 s elapsed, about 34 s left"),
        (0.0, (20, 80), "20 of 80, 50 s elapsed, about 30 s left"),
        (0.0, (80, 80), "80 of 80, 50 s elapsed"),
    ):
        clock.now += later
        if state:
            display.update(Progress("contacts", *state))
        assert display.text() == f"comparison, contacts {text}"


def test_a_terminal_has_one_line_that_is_removed_in_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    stream, clock = Terminal(), Clock()
    display = ProgressDisplay("fit", stream, clock)
    display.clear()
    assert stream.getvalue() == ""
    clock.now += 3.0
    display.update(Progress("rounds", 2, 8))
    display.refresh()
    display.clear()
    assert "fit, rounds 2 of 8, 3 s elapsed" in stream.getvalue()
    assert stream.getvalue().endswith("\x1b[2K")


def test_reports_reach_the_enclosing_block_alone() -> None:
    seen: list[Progress] = []
    report_progress("contacts", 1, 2)
    with progress_to(seen.append):
        report_progress("contacts", 1, 2)
        with progress_to(None):
            report_progress("contacts", 2, 2, 0.5)
    report_progress("contacts", 2, 2)
    assert seen == [Progress("contacts", 1, 2), Progress("contacts", 2, 2, 0.5)]
    with working("work") as display:
        report_progress("contacts", 3, 4)
        assert display.state == Progress("contacts", 3, 4)


def test_durations() -> None:
    assert [duration(t) for t in (0.4, 59.0, 61.0, 7325.0)] == ["0 s", "59 s", "1 min 1 s", "2 h 2 min"]


def test_ctrl_c_says_what_is_kept_and_how_to_go_on(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped, working("fit", "rows are kept, the same command resumes"):
        raise KeyboardInterrupt
    assert stopped.value.code == console.STOPPED == 130
    assert "rows are kept, the same command resumes" in capsys.readouterr().err


def test_stopped_commands(mixed_ehl: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def stop(*arguments: Any, **options: Any) -> None:
        raise KeyboardInterrupt

    for name in ("regression.fit", "regression.sweep", "efficiency.optimise"):
        monkeypatch.setattr(name, stop)
    assert mixed_ehl("fit", "gear_fva3", "-o", tmp_path / "f.json").code == 130
    swept = mixed_ehl("sweep", "demo", "-o", tmp_path / "run")
    assert (swept.code, str(tmp_path / "run") in swept.err) == (130, True)
    for fresh in ((), ("--fresh",)):  # which would delete what is kept
        searched = mixed_ehl("optimise", "fh_hypoid_9x34", "-o", tmp_path / "search", *fresh)
        assert (searched.code, "without --fresh" in searched.err) == (130, bool(fresh))


STARTED = """
import sys

module, sys.argv[1:] = sys.argv[1], ["oil"]

class Interrupted:
    def find_spec(self, name, *rest):
        if name == module:
            raise KeyboardInterrupt

sys.meta_path.insert(0, Interrupted())
from efficiency.cli import main
main()
"""


@pytest.mark.parametrize("module", ["typer", "ehl.fluid.oil"])
def test_ctrl_c_while_modules_are_loaded_is_no_traceback(module: str) -> None:
    """Before the command line is read, and within a command that shows no progress."""
    run = subprocess.run([sys.executable, "-c", STARTED, module], capture_output=True, text=True)
    assert (run.returncode, run.stdout, run.stderr) == (130, "", "mixed-ehl: stopped\n")
