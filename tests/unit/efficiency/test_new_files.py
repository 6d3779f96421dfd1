"""`mixed-ehl new` and `efficiency.new_file`: what they write works as it is."""

import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from refusals import refuses

import efficiency
import ehl
import regression
from efficiency.axle.axle_input import AxleInput, load_axle
from efficiency.conditions.duty import read_duty
from efficiency.machine_settings.inputs import load_targets
from ehl.common.validation import validate

# what the shipped file of a kind gives where it is read
READERS: dict[str, tuple[Callable[[Path], Any], Any]] = {
    "oil": (lambda path: ehl.Oil.load(str(path)).viscosity_kinematic_40, 220e-6),
    "contact": (lambda path: ehl.Contact.from_file(path).contact.pressure_hertz, 1.2e9),
    "plan": (lambda path: regression.Plan.from_file(path).sampling.size, 256),
    "design": (lambda path: efficiency.load(path).name, "my_design"),
    "targets": (lambda path: load_targets(path).blank.teeth_gear, 42),
    "axle": (lambda path: load_axle(path).name, "my_axle"),
    "duty": (lambda path: sum(row.hours for row in read_duty(path)), 1000.0),
}


@pytest.mark.parametrize("kind", READERS)
def test_files_are_read(mixed_ehl: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    monkeypatch.chdir(tmp_path)
    assert mixed_ehl("new", kind).code == 0
    [file] = tmp_path.iterdir()
    read, expected = READERS[kind]
    assert read(file) == (expected if isinstance(expected, str) else pytest.approx(expected))
    text = file.read_text(encoding="utf-8")
    assert mixed_ehl("new", kind).code == 2
    assert file.read_text(encoding="utf-8") == text
    assert mixed_ehl("new", kind, "--force").code == 0


def test_oil_by_two_viscosities_is_the_generic_oil(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(efficiency.new_file("oil", "mine", base="pao", nu40="97.5 cSt", nu100="13.3 cSt"), encoding="utf-8")
    mine, generic = ehl.Oil.load(str(path)), ehl.Oil.generic("pao", nu_40="97.5 cSt", nu_100="13.3 cSt")
    assert mine.viscosity_dynamic(363.15) == generic.viscosity_dynamic(363.15)
    assert mine.alpha(363.15) == generic.alpha(363.15)


def test_axle_has_the_offset_of_its_pair() -> None:
    for pair, offset in (
        ("fm_hypoid_13x42_relieved", 15e-3),
        ("fm_spiral_bevel_14x39_relieved", 0.0),
        ("eaxle_helical_23x75", -60e-3),  # cylindrical: the place of the shipped axle with such a pair
    ):
        content = tomllib.loads(efficiency.new_file("axle", "mine", pair=pair))
        height = validate(AxleInput, content).pinion_shaft.height
        assert height == pytest.approx(-offset)
    with refuses("design"):
        efficiency.new_file("axle", "mine", pair="no_pair")
    for pair, like in (("eaxle_helical_23x75", "truck_hypoid"), ("fm_hypoid_13x42_relieved", "eaxle_helical")):
        with refuses("like"):
            efficiency.new_file("axle", "mine", pair=pair, like=like)


@pytest.mark.parametrize(
    "answers",
    [
        {"offset": "0 mm", "teeth_pinion": 14, "teeth_gear": 39},
        {"process": "face_hobbing", "teeth_pinion": 11, "teeth_gear": 37, "offset": "25 mm", "spiral_angle": "27 deg"},
        {"process": "two_part_face_hobbing"},
        {"offset": "-12 mm", "spiral_angle": "40 deg"},
    ],
)
def test_blank_of_targets_can_be_made(tmp_path: Path, answers: dict[str, str]) -> None:
    path = tmp_path / "targets.toml"
    path.write_text(efficiency.new_file("targets", **answers), encoding="utf-8")
    blank = load_targets(path).blank
    assert blank.teeth_gear == int(answers.get("teeth_gear", 42))
    assert efficiency.blank(blank).gear.teeth == blank.teeth_gear
    assert (blank.blade_groups is not None) == ("process" in answers)
    assert blank.hypoid_offset == pytest.approx(float(answers.get("offset", "15 mm").split()[0]) / 1e3)


def test_contact_and_plan_with_a_measured_finish(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(ehl.Finish.load("ground").to_toml().replace('"0.4 um"', '"0.3 um"'), encoding="utf-8")
    both = tomllib.loads(efficiency.new_file("contact", finish="mine.toml", roughness="0.2 um"))["surface"]
    assert (both["finish"], both["roughness_rms_1"]) == ("mine.toml", "0.2 um")
    assert tomllib.loads(efficiency.new_file("plan", finish="mine.toml"))["surface"]["finish"] == "mine.toml"
    with refuses("file"):
        efficiency.new_file("plan", finish="nothing.toml")


@pytest.mark.parametrize("like", ehl.shipped("designs"))
def test_every_shipped_design_is_a_pattern(like: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(efficiency.new_file("design", "mine", like=like, torque="20 N m", oil="fva3"), encoding="utf-8")
    mine, shipped = efficiency.load(file), efficiency.load(like)
    assert mine.design.operation == shipped.design.operation.model_copy(update={"torque": 20.0, "oil": "fva3"})
    assert (mine.design.pinion, mine.design.gear) == (shipped.design.pinion, shipped.design.gear)


@pytest.mark.parametrize("name", ['a"b', "back\\slash", "1e5", "line"])
def test_names_cannot_break_the_file(name: str) -> None:
    assert tomllib.loads(efficiency.new_file("plan", name))["name"] == name
    with refuses("name"):
        efficiency.new_file("plan", name + "\n")


def test_terminal_asks_question_by_question(mixed_ehl: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    answers = iter(["pao", "", "97.5 cSt", "13.3 cSt", ""])
    monkeypatch.setattr("typer.prompt", lambda text, default, show_default: next(answers) or default)
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True, raising=False)
    assert mixed_ehl("new", "oil").code == 0
    assert list(answers) == []
    assert ehl.Oil.load(str(tmp_path / "my_oil.toml")).viscosity_kinematic_100 == pytest.approx(13.3e-6)


@pytest.mark.parametrize(("words", "full"), [("gear fzg_c4", "fzg_c40"), ("oil 75", "75w90"), ("sweep run de", "demo")])
def test_shell_completes_names(mixed_ehl: Any, monkeypatch: pytest.MonkeyPatch, words: str, full: str) -> None:
    monkeypatch.setenv("_MIXED_EHL_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", f"mixed-ehl {words}")
    monkeypatch.setenv("COMP_CWORD", str(len(words.split())))
    assert full in mixed_ehl().out.split()
