"""The command line as a user types it: results, exit codes, sentences instead of tracebacks; progress of long work."""

import io
import json
import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest
import typer

import efficiency.cli
import ehl
from ehl.common import console
from ehl.common.console import ADVANCED, FIRST_DISPLAY, LINE_EVERY, ProgressDisplay, working
from ehl.common.data import reason_text
from ehl.common.progress import Progress, duration, progress_to, report_progress

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "docs" / "examples"
PAIR = "fm_spiral_bevel_14x39"


# parser, a pair and a formula by their public functions, and the figures of a pair: what they need not import
UNUSED = {
    "import efficiency.cli": ("numpy", "pandas", "matplotlib", "pint", "h5py", "joblib"),
    "import efficiency, ehl; from regression.formula import friction_model; friction_model('xu_kahraman_2007'); "
    f"ehl.Oil.load(efficiency.load('{PAIR}').design.operation.oil); import efficiency.pair": (
        *("pandas", "pint", "scipy.optimize", "scipy.interpolate"),
    ),
    f"sys.argv = ['mixed-ehl', 'gear', '{PAIR}', '--json']\nfrom efficiency.cli import main\n"
    "try: main()\nexcept SystemExit as end: assert not end.code": ("matplotlib",),
}


@pytest.mark.parametrize("code", UNUSED)
def test_no_call_waits_for_libraries_that_it_does_not_need(code: str) -> None:
    code = f"import sys; {code}\nprint([m for m in {UNUSED[code]} if m in sys.modules], file=sys.stderr)"
    run = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True)
    assert run.stderr.splitlines()[-1] == "[]"


@pytest.mark.parametrize("example", sorted(path.name for path in EXAMPLES.glob("contact*.toml")))
def test_solve_prints_one_json_object(mixed_ehl: Any, example: str) -> None:
    outcome = mixed_ehl("solve", EXAMPLES / example, "--json")
    assert outcome.code == 0
    result = json.loads(outcome.out)
    assert result["status"] == "converged"
    assert result["friction_coefficient"] == pytest.approx(result["friction_fluid"] + result["friction_asperity"])
    assert 0.0 < result["film_min"] < result["film_central"]
    assert {"pressure_max", "film_ratio", "asperity_load_share", "film_error", "friction_error"} <= result.keys()
    if example == "contact_rough.toml":
        for name in ("friction_asperity", "asperity_load_share", "film_ratio", "mesh_error", "statistical_error"):
            assert result[name] > 0.0
        assert result["friction_error"] >= math.hypot(result["mesh_error"], result["statistical_error"])
        assert result["statistical_error"] <= 0.035
        assert result["asperity_load_share"] < result["roughness_load_share"]
        # a thicker boundary film touches sooner
        bounds = (result["friction_boundary_half"], result["friction_boundary_double"])
        assert bounds[0] < result["friction_coefficient"] < bounds[1]


@pytest.mark.parametrize(("status", "code"), [("unsettled", 0), ("failed", 1)])
def test_a_wide_interval_is_an_answer(mixed_ehl: Any, monkeypatch: pytest.MonkeyPatch, status: str, code: int) -> None:
    contact = ehl.Contact.from_file(EXAMPLES / "contact.toml")
    result = replace(contact.solve(), status=status, reason="statistical_interval", friction_error=0.25)
    monkeypatch.setattr(ehl.Contact, "solve", lambda self: result)
    outcome = mixed_ehl("solve", EXAMPLES / "contact.toml")
    assert outcome.code == code
    assert reason_text("statistical_interval") in outcome.err


def test_gear_and_its_map(mixed_ehl: Any) -> None:
    one = json.loads(mixed_ehl("gear", PAIR, "--torque", "200 N m", "--json").out)
    assert one["conditions"]["torque"] == pytest.approx(200.0)
    assert 0.98 < one["efficiency"] < 1.0
    grid = json.loads(mixed_ehl("map", PAIR, "--torque", "100, 200 N m", "--json").out)
    assert [point["torque"] for point in grid["points"]] == [100.0, 200.0]
    # the load of the map starts from its neighbour: the same within the stated errors of both
    again = grid["points"][1]
    stated = one["errors"]["balance"] + again["efficiency_error_balance"]
    assert stated < 1e-5
    assert again["efficiency"] == pytest.approx(one["efficiency"], abs=stated)


def test_compare_prints_a_row_per_model(mixed_ehl: Any) -> None:
    models = ("--friction", "constant:0.05", "--friction", "constant:0.1")
    outcome = mixed_ehl("compare", PAIR, *models, "--load-balance", "frictionless", "--json")
    rows = {row["name"]: row for row in json.loads(outcome.out)["rows"]}
    assert rows["constant:0.1"]["power_loss"] == pytest.approx(2.0 * rows["constant:0.05"]["power_loss"], rel=1e-9)
    assert any(name.startswith("Coleman-type") for name in rows)


@pytest.mark.parametrize(("option", "value"), [("--friction", "guess_1999"), ("--oil", "olive"), ("--speed", "0 rpm")])
def test_refused_before_meshing(mixed_ehl: Any, monkeypatch: pytest.MonkeyPatch, option: str, value: str) -> None:
    monkeypatch.delattr("efficiency.GearPair.mesh")
    for command in ("gear", "compare"):
        assert mixed_ehl(command, PAIR, option, value).code == 2


def test_errors_name_options_that_were_typed_only(mixed_ehl: Any, tmp_path: Path) -> None:
    """What stands in a file keeps its name there."""
    design = tmp_path / "design.toml"
    text = (ROOT / "data" / "designs" / f"{PAIR}.toml").read_text(encoding="utf-8")
    design.write_text(text.replace('oil = "75w90"', 'oil = "olive"'), encoding="utf-8")
    assert "operation.oil = 'olive'" in mixed_ehl("gear", design, "--friction", "constant:0.05").err


def test_doctor_finds_nothing_wrong(mixed_ehl: Any) -> None:
    outcome = mixed_ehl("doctor")
    assert outcome.code == 0, outcome.out


def commands() -> list[tuple[str, Any]]:
    """All commands with their names; those of `new` are made from templates."""
    found = []

    def walk(command: Any, name: str) -> None:
        for part in getattr(command, "commands", {}):
            walk(command.commands[part], f"{name} {part}".strip())
        if not hasattr(command, "commands"):
            found.append((name, command))

    walk(typer.main.get_command(efficiency.cli.app), "")
    return found


def test_panels_of_options_and_commands() -> None:
    """At most ten options come before the advanced ones; every command is in a panel of the work."""
    for name, command in commands():
        options = [part for part in command.params if part.param_type_name == "option" and part.name != "help"]
        assert len([part for part in options if part.rich_help_panel != ADVANCED]) <= 10, name
    group: Any = typer.main.get_command(efficiency.cli.app)
    panels = [group.commands[name].rich_help_panel for name in group.list_commands(None)]
    last = ["Gear design", "Gear efficiency", "Axle", "Program"]
    assert list(dict.fromkeys(panels)) == ["Input files", "Contact", "Friction formula", *last]


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_the_first_line_comes_within_five_seconds_and_further_ones_twice_a_minute() -> None:
    stream, clock = io.StringIO(), Mock(return_value=100.0)
    display = ProgressDisplay("comparison", stream, clock)
    lines = []
    for second in range(70):
        clock.return_value = 100.0 + second
        display.refresh()
        lines.append(stream.getvalue().count("\n"))
    first = lines.index(1)
    assert first == FIRST_DISPLAY <= 5.0
    assert lines.index(2) == first + LINE_EVERY


def test_the_remaining_time_is_that_of_the_current_step() -> None:
    clock = Mock(return_value=100.0)
    display = ProgressDisplay("comparison", io.StringIO(), clock)
    clock.return_value += 40.0
    # a stated time is shown at once and counts down
    for later, state, text in (
        (0.0, (0, 80), "0 of 80, 40 s elapsed"),
        (0.0, (0, 80, 44.0), "0 of 80, 40 s elapsed, about 44 s left"),
        (10.0, None, "0 of 80, 50 s elapsed, about 34 s left"),
        (0.0, (20, 80), "20 of 80, 50 s elapsed, about 30 s left"),
        (0.0, (80, 80), "80 of 80, 50 s elapsed"),
    ):
        clock.return_value += later
        if state:
            display.update(Progress("contacts", *state))
        assert display.text() == f"comparison, contacts {text}"
    # results of an earlier run took no time
    for later, done, text in ((0.0, 39, ""), (0.01, 40, ""), (9.99, 50, ", about 30 s left")):
        clock.return_value += later
        display.update(Progress("points", done, 80))
        assert display.text().partition(" elapsed")[2] == text


def test_a_terminal_has_one_line_that_is_removed_in_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    stream, clock = Terminal(), Mock(return_value=100.0)
    display = ProgressDisplay("fit", stream, clock)
    display.clear()
    assert stream.getvalue() == ""
    clock.return_value += 3.0
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
    assert [duration(t) for t in (0.4, 59.0, 61.0, 7325.0)] == ["0 s", "59 s", "1 min 1 s", "2 h 2 min"]


@pytest.mark.parametrize("done", [0, 1])
def test_ctrl_c_says_what_is_kept_and_how_to_go_on(capsys: pytest.CaptureFixture[str], done: int) -> None:
    def work() -> None:
        report_progress("rows", done, 2)
        raise KeyboardInterrupt

    with pytest.raises(SystemExit) as stopped, working("fit", "rows are kept, the same command resumes"):
        work()
    assert stopped.value.code == console.STOPPED == 130
    error = capsys.readouterr().err
    assert "rows are kept, the same command resumes" in error
    assert ("before the first new result" in error) == (done == 0)


def test_stopped_commands(mixed_ehl: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in ("regression.fit", "regression.sweep", "efficiency.optimise"):
        monkeypatch.setattr(name, Mock(side_effect=KeyboardInterrupt))
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
