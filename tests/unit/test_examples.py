"""The gallery of examples runs, with the number each one ends with; tutorials run as they are printed."""

import re
import runpy
import shlex
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pytest
from pages import read_page

ROOT = Path(__file__).resolve().parents[2]
ANSWERS = {
    "plot_axle": 1226.23,
    "plot_blank": 39 / 14,
    "plot_constant_friction": 1.33156,
    "plot_contact_pattern": 12.2771,
    "plot_efficiency_map": 99.2343,
    "plot_film_and_pressure": 302.987,
    "plot_formula": 0.0457828,
    "plot_gear_efficiency": 99.2343,
    "plot_misalignment": 99.2819,
    "plot_oil_under_pressure": 11.2358,
    "plot_paper_contact": 0.0410145,
    "plot_paper_formula": 0.378765,
    "plot_paper_pair": 99.3403,
    "plot_rough_contact": 180.925,
    "plot_stribeck_curve": 1.84344,
}


def test_every_example_has_a_number() -> None:
    assert {path.stem for path in (ROOT / "examples").glob("*.py")} == set(ANSWERS)


@pytest.mark.parametrize("name", ANSWERS)
def test_example_gives_its_number(name: str) -> None:
    outcome = runpy.run_path(str(ROOT / "examples" / f"{name}.py"))
    plt.close("all")
    assert outcome["answer"] == pytest.approx(ANSWERS[name], rel=2e-3)


def commands(page: str) -> list[list[str]]:
    """Commands of the ``sh`` blocks of a page, without the name of the program."""
    text = (ROOT / "docs" / "tutorials" / f"{page}.md").read_text(encoding="utf-8")
    lines = [line for block in re.findall(r"```sh\n(.*?)```", text, re.S) for line in block.splitlines()]
    found = [shlex.split(line) for line in lines]
    assert all(words[0] == "mixed-ehl" for words in found)
    return [words[1:] for words in found]


WRITTEN = {
    "oil": {"my_oil.toml", "my_contact.toml", "my_plan.toml", "run", "formula.json", "fit.html", "friction.c"},
    "gear": {"my_pair.toml", "my_design.toml", "my_design_targets.toml", "geometry.html", "gear.html", "map"},
    "calibrate": {"card.toml", "curves.png", "calibration.html", "calibration.toml", "synthetic_traction.csv"},
    "cluster": {"plan.toml", "run", "cases.h5", "formula.json"},
    "better": {"my_pair.toml", "better"},
    "axle": {"my_axle.toml", "point.html", "duty.csv", "duty.html", "axle.vtlm"},
}


@pytest.mark.usefixtures("commands_alone", "small_search")
@pytest.mark.parametrize("page", WRITTEN)
def test_tutorial_runs_as_it_is_printed(
    mixed_ehl: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, page: str
) -> None:
    monkeypatch.chdir(tmp_path)
    if page == "calibrate":
        for name in ("calibration.toml", "synthetic_traction.csv"):
            shutil.copy(ROOT / "docs" / "examples" / name, tmp_path)
    told = commands(page)
    assert len(told) >= 2
    if page == "better":  # fewer points
        told[1][told[1].index("--evaluations") + 1] = "5"
    for words in told:
        if words[0] == "sweep" and "--jobs" in words:  # `test_wheel` solves the contacts of a sweep
            words += ["--with", "arana_2019"]
        outcome = mixed_ehl(*words)
        assert outcome.code == 0, (words, outcome.err)
        assert outcome.out
    assert {path.name for path in tmp_path.iterdir()} == WRITTEN[page]
    for path in tmp_path.glob("*.html"):
        read_page(path)
