"""Numbers of README, landing page and tutorials, and of the pictures of both, are those of the program.

The outputs below the cells of the tutorials are made when the pages are built; `test_pages` runs their commands.
"""

import inspect
import json
import re
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from PIL import Image

import efficiency
import regression
from efficiency.loss.ehl_friction import EhlFriction
from efficiency.machine_settings.settings_result import RESIDUAL_LIMIT
from efficiency.optimisation.problem import BOX
from regression.data.dataset import dataset_names, load_dataset
from regression.plan.plan import Plan
from regression.sweeping.slurm import DEFAULT_JOBS, DEFAULT_TIME

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", ROOT / "docs" / "index.md", *sorted((ROOT / "docs" / "tutorials").glob("*.md"))]
PROSE = {
    path.stem + "-" * (path.name == "index.md" and path.parent.name == "docs"): re.sub(
        r"^```.*?^```|\]\(\S*\)", "]", path.read_text(encoding="utf-8"), flags=re.S | re.M
    )
    for path in PAGES
}
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
WORDS = {"half": 0.5, "two": 2, "three": 3, "four": 4, "five": 5, "six": 6, "seven": 7, "eight": 8, "nine": 9}
NUMBER = re.compile(rf"\d+(?:\.\d+)*|\b(?:{'|'.join(WORDS)})\b", re.I)


def oils() -> list[regression.Formula]:
    """Formulas of the oils that have a short one as well."""
    folder = ROOT / "data" / "formulas"
    return [regression.Formula.load(path.stem.removesuffix("_short")) for path in folder.glob("*_short.json")]


def solved() -> list[float]:
    """Oils, contacts of their formulas, contacts of the data that are not fitted, oils of `gear`."""
    (fitted,) = {formula.data.count for formula in (*oils(), regression.Formula.load("gear"))}
    kept = [name for name in dataset_names() if name.endswith(("_paths", "_noise"))]
    others = sum(len(load_dataset(name).frame) for name in kept)
    return [len(oils()), fitted, others, len(regression.Formula.load("gear").oils)]


def level() -> list[float]:
    """Of the interval of a formula, and of an efficiency [%]."""
    (found,) = {formula.interval.level for formula in oils()}
    assert inspect.signature(efficiency.EfficiencyResult.uncertainty).parameters["level"].default == found
    return [100.0 * found]


# page (by its stem, "" for any page) and phrase: values of its numbers
PHRASES: dict[tuple[str, str], Callable[[], list[float]]] = {
    ("", r"\d+ % interval"): level,
    ("", r"Python 3\.\d+"): lambda: [float(PROJECT["requires-python"].removeprefix(">="))],
    ("", r"\d+ contacts, (?:formulas fitted|fits formulas)"): lambda: [Plan.from_file("demo").count],
    ("README", r"(?s)formulas of \w+ oils.*?fitted to all \w+"): solved,
    ("better", r"±[\d.]+ mm"): lambda: [1e3 * next(iter({*BOX.values()}))],
    ("cluster", r"of a task \(default \d+\)"): lambda: [DEFAULT_JOBS],
    ("cluster", r"\(default \d+ hours\)"): lambda: [float(DEFAULT_TIME.partition(":")[0])],
    ("gear", r"above \d µm the exit code is 1"): lambda: [1e6 * RESIDUAL_LIMIT, 1.0],
    ("oil", r"networks of \w+\s\w+"): lambda: [float(len(regression.Formula.load("gear").oils))],
}


@pytest.mark.parametrize(("page", "phrase"), PHRASES)
def test_numbers_of_a_page_are_those_of_the_program(page: str, phrase: str) -> None:
    found = [text for stem, prose in PROSE.items() if page in ("", stem) for text in re.findall(phrase, prose)]
    assert found
    for text in found:
        shown = [WORDS.get(number.lower()) or float(number) for number in NUMBER.findall(text)]
        assert shown == pytest.approx(PHRASES[page, phrase]()), text


def test_numbers_of_the_pictures_are_those_of_the_program() -> None:
    """Closed forms and formulas to the printed digits, solved contacts within the stated error of fewer contacts."""
    shown = {}
    for name in ("report_gear", "comparison"):
        with Image.open(ROOT / "docs" / "figures" / f"{name}.png") as image:
            shown[name] = json.loads(image.text["Description"])
    gear, rows = shown.values()
    fitted = {name for name in rows if "fitted" in name or ", mu " in name}
    pair, torque = efficiency.load("fm_spiral_bevel_14x39_relieved"), 200.0
    models = [name for name in rows if name != "ehl" and "-type" not in name and name not in fitted]
    compared = pair.compare(models, torque=torque)
    today = {row.name: row.efficiency for row in compared.rows}
    assert rows.keys() == {*today, *fitted, "ehl"} - {name for name in today if name not in rows}
    for name in rows.keys() & today.keys():
        assert rows[name] == pytest.approx(today[name], abs=5e-6), name
    result = compared.results[0]
    assert gear.pop("efficiency") == pytest.approx(result.efficiency, abs=5e-5)
    for name, value in gear.items():
        assert value == pytest.approx(getattr(result, name), rel=2e-3), name
    solved = pair.mesh().load(torque).efficiency(EhlFriction("ehl", points=16, jobs=1))
    for name in ("ehl", *(name for name in fitted if "fitted" in name)):
        assert abs(rows[name] - solved.efficiency) < solved.efficiency_error
