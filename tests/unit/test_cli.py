"""The command line as a user types it: results, exit codes, and sentences instead of tracebacks."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import typer

import efficiency.cli
import ehl
from ehl.common.console import ADVANCED
from ehl.common.data import reason_text

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "docs" / "examples"
PAIR = "fm_spiral_bevel_14x39"
PAPER = ("--load-balance", "frictionless")


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
    outcome = mixed_ehl("compare", PAIR, "--friction", "constant:0.05", "--friction", "constant:0.1", *PAPER, "--json")
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


def test_at_most_ten_options_come_before_the_advanced_ones() -> None:
    for name, command in commands():
        options = [part for part in command.params if part.param_type_name == "option" and part.name != "help"]
        assert len([part for part in options if part.rich_help_panel != ADVANCED]) <= 10, name


def test_every_command_is_in_a_panel_of_the_work() -> None:
    group: Any = typer.main.get_command(efficiency.cli.app)
    panels = [group.commands[name].rich_help_panel for name in group.list_commands(None)]
    last = ["Gear design", "Gear efficiency", "Axle", "Program"]
    assert list(dict.fromkeys(panels)) == ["Input files", "Contact", "Friction formula", *last]
