"""Every fenced block of README and site runs as it is printed, or stands here with the reason why not.

The commands of a page run in order in a folder of their own, and so do its Python blocks; what takes minutes or needs
files of the reader is only parsed (`ONLY_READ`), a few blocks have tests of their own (`RUN_BY`). Links lead to files
that exist; what the pages on theory and robustness name as their code and their tests exists.

Numbers of README, landing page and tutorials, and of the pictures of both, are those of the program. The outputs below
the cells of the tutorials are made when the pages are built.
"""

import inspect
import json
import re
import shlex
import shutil
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import click
import pytest
import typer
from pages import read_page
from PIL import Image

import efficiency
import ehl
import regression
from efficiency.cli import app
from efficiency.design.design import Design
from efficiency.loss.ehl_friction import EhlFriction
from efficiency.machine_settings.inputs import load_targets
from efficiency.machine_settings.settings_result import RESIDUAL_LIMIT
from efficiency.optimisation.problem import BOX
from ehl.common.validation import validate
from regression.calibration.calibrate import setup_of
from regression.data.dataset import load_dataset
from regression.plan.plan import Plan
from regression.sweeping.slurm import DEFAULT_JOBS, DEFAULT_TIME

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md")]
PAGES += sorted(path for folder in (DOCS, DOCS / "tutorials") for path in folder.glob("*.md"))
COMMAND: Any = typer.main.get_command(app)


@dataclass(frozen=True)
class Block:
    """A fenced block: page, language, text."""

    page: str
    language: str
    text: str

    def __str__(self) -> str:
        return f"{self.page} {self.language} {self.text.strip().partition(chr(10))[0][:50]}"


def fenced() -> Iterator[Block]:
    for path in PAGES:
        for match in re.finditer(r"^( *)```([^\n`]*)\n(.*?)^ *```", path.read_text(encoding="utf-8"), re.S | re.M):
            if not match[2].startswith("{"):  # lists of pages
                yield Block(path.relative_to(ROOT).as_posix(), match[2], match[3])


BLOCKS = list(fenced())

# blocks that a test of another module runs, by page and language or first line: its name
RUN_BY = {
    ("docs/sweep.md", "from dask_jobqueue import SLURMCluster"): "test_the_cluster_of_the_page_on_sweeps_computes",
    ("docs/formula_code.md", "c"): "test_example_of_the_page",
}

# why lines of `sh` blocks are not run here, and how they begin
ONLY_READ = {
    "the gate runs it": ("python -m pip install", "python -m sphinx", "ruff ", "mypy", "pytest"),
    "hours": ("python validation",),
    "test_examples runs the examples": ("jupytext",),
    "test_example_of_the_page compiles and runs it": ("cc -O3", "./main"),
    "writes into the start file of the shell": ("mixed-ehl --install-completion",),
    "the browser test and test_wheel run it": ("mixed-ehl app", "mixed-ehl demo"),
    "minutes; a tutorial or test_study runs less": (
        *("mixed-ehl optimise fm_", "mixed-ehl optimise my_targets.toml", "mixed-ehl study"),
        "mixed-ehl compare fm_spiral_bevel_14x39_relieved --friction formula.json",
    ),
    "RUN, PATHS, NOISE: folders of the reader": ("mixed-ehl fit RUN", "mixed-ehl mu formula.json --hull RUN"),
    "a tutorial runs it": (
        "mixed-ehl calibrate synthetic_traction.csv --setup calibration.toml -o",
        "mixed-ehl calibrate docs/examples/synthetic_traction.csv",
        "mixed-ehl gear fm_spiral_bevel_14x39 --report",
        "mixed-ehl gear fm_spiral_bevel_14x39_relieved --friction formula.json --report",
    ),
    "test_cli solves one": ("mixed-ehl solve docs/examples/contact_rough.toml",),
    "test_page_of_a_point_and_of_a_map": ('mixed-ehl map fm_spiral_bevel_14x39 --torque "50',),
    "test_example_commands_run runs it": (
        *("mixed-ehl geometry fm_spiral_bevel_14x39", "mixed-ehl export fm_spiral_bevel_14x39 -o files"),
        'mixed-ehl misalignment fm_spiral_bevel_14x39 --E "-0.1, 0, 0.1 mm"',
    ),
}

# what makes a command short enough for a test
SHORTER = {
    "mixed-ehl sweep plan.toml -o run": ["--with", "arana_2019", "--jobs", "1"],
    "mixed-ehl sweep plan.toml --output run --shard": ["--with", "arana_2019"],
    "mixed-ehl sweep my_plan.toml --output": ["--with", "arana_2019"],
    "mixed-ehl optimise my_pair.toml": ["--evaluations", "5"],
    "mixed-ehl sweep data/plans/demo.toml": ["--with", "xu_kahraman_2007", "--jobs", "1"],
    "mixed-ehl fit run -o formula.json --report fit.html": ["--family", "power_law"],
    "mixed-ehl misalignment fh_hypoid_9x34_relieved --samples": ["--samples", "2", "--friction", "constant:0.05"],
}


# options of files that a command writes
WRITTEN = r" (?:-o|--output|--report|--model|--csv|--xlsx|--plot) ([\w./-]+)"


def not_run(command: str) -> str:
    """Why a command is only read; empty if it runs."""
    return next((reason for reason, starts in ONLY_READ.items() if command.startswith(starts)), "")


def run_by(block: Block) -> str:
    """Test of another module that runs a block; empty if there is none."""
    first = block.text.strip().partition("\n")[0]
    return RUN_BY.get((block.page, block.language)) or RUN_BY.get((block.page, first), "")


def commands(block: Block) -> list[str]:
    """Commands of a `sh` block, without remarks."""
    lines = [part.strip() for line in block.text.splitlines() for part in line.split("&&")]
    return [line.partition("  #")[0].rstrip() for line in lines if line]


OURS = [block for block in BLOCKS if not run_by(block)]
SHELL = {
    page: [line for block in OURS if (block.page, block.language) == (page, "sh") for line in commands(block)]
    for page in sorted({block.page for block in OURS if block.language == "sh"})
}
RUNNING = {page: lines for page, lines in SHELL.items() if not all(map(not_run, lines))}
PYTHON = {
    page: [block.text for block in OURS if (block.page, block.language) == (page, "python")]
    for page in sorted({block.page for block in OURS if block.language == "python"})
}
FRAGMENTS = [block for block in OURS if block.language == "toml"]


def defined_in(*folders: str) -> set[str]:
    """Names of the functions and classes of some folders."""
    return {
        name
        for folder in folders
        for module in (ROOT / folder).rglob("*.py")
        for name in re.findall(r"^ *(?:def|class) (\w+)", module.read_text(encoding="utf-8"), re.M)
    }


CODE, TESTS = defined_in("ehl", "regression", "efficiency"), defined_in("tests")


def test_every_block_runs_or_has_its_reason() -> None:
    assert set(RUN_BY.values()) <= TESTS
    firsts = {(block.page, block.text.strip().partition("\n")[0]) for block in BLOCKS}
    assert set(RUN_BY) <= {(block.page, block.language) for block in BLOCKS} | firsts
    lines = [line for block in BLOCKS if block.language == "sh" for line in commands(block)]
    starts = [start for group in ONLY_READ.values() for start in group]
    assert [start for start in starts if not any(line.startswith(start) for line in lines)] == []
    ours = [line for own in SHELL.values() for line in own]
    assert [line for line in ours if not (line.startswith("mixed-ehl ") or not_run(line))] == []


def files_of(page: str, mixed_ehl: Any) -> None:
    """What the commands of a page find in their folder."""
    if page in ("docs/friction_formula.md", "docs/sweep.md"):
        Path("plan.toml").write_text(next(b.text for b in FRAGMENTS if b.page == page), encoding="utf-8")
    elif page in ("docs/calibration.md", "docs/tutorials/calibrate.md"):
        for path in (DOCS / "examples").iterdir():
            shutil.copy(path, path.name)
    elif page == "docs/formula_code.md":
        regression.Formula.load("fva3").save("formula.json")
    elif page == "docs/machine_settings.md":
        assert mixed_ehl("export", "fm_spiral_bevel_14x39", "-o", ".", "--what", "grid").code == 0
    elif page == "docs/gear_output.md":
        table = "torque [N m],speed [rpm],torque_loss [N m]\n"
        for torque in (-2000.0, 2000.0):
            table += "".join(f"{torque},{speed},{0.5 + 1e-4 * speed}\n" for speed in (0.0, 5000.0))
        Path("bearings.csv").write_text(table)
    elif page == "docs/oils.md":
        text = (DOCS / "examples" / "contact.toml").read_text(encoding="utf-8")
        Path("contact.toml").write_text(text.replace('"fva3"', '"my_oil.toml"'), encoding="utf-8")
    elif page == "docs/tour.md":
        for name in ("docs", "data"):
            Path(name).symlink_to(ROOT / name)


@pytest.mark.usefixtures("commands_alone", "small_search")
@pytest.mark.parametrize("page", RUNNING)
def test_commands_of_a_page_run(page: str, mixed_ehl: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They end well and write the files that they name."""
    monkeypatch.chdir(tmp_path)
    files_of(page, mixed_ehl)
    ours = [line for line in RUNNING[page] if not not_run(line)]
    for line in ours:
        more = next((words for start, words in SHORTER.items() if line.startswith(start)), [])
        outcome = mixed_ehl(*shlex.split(line)[1:], *more)
        assert outcome.code == 0, (line, outcome.err)
        assert outcome.out + outcome.err, line
    named = [name for line in ours if "--slurm" not in line for name in re.findall(WRITTEN, line)]
    assert [name for name in named if not Path(name).exists()] == []
    for path in tmp_path.glob("*.html"):
        read_page(path)


@pytest.mark.usefixtures("commands_alone")
@pytest.mark.parametrize("page", PYTHON)
def test_python_of_a_page_runs(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One block after the other, as in a notebook."""
    monkeypatch.chdir(tmp_path)
    if page in ("docs/sweep.md", "docs/tour.md"):  # values of a published formula in place of contacts
        instead = partial(regression.sweep, formula="xu_kahraman_2007")
        monkeypatch.setattr(regression, "sweep", instead)
        monkeypatch.setattr("regression.sweeping.run.sweep", instead)
    notebook: dict[str, Any] = {}
    for text in PYTHON[page]:
        fewer = text.replace('["lubricant.oil=fva3"]', '["lubricant.oil=fva3", "sampling.size=64"]')
        exec(compile(fewer, page, "exec"), notebook)
        assert all(Path(name).exists() for name in re.findall(r'\.(?:report|save|export)\("([^"]+)"', text))
    if isinstance(notebook.get("result"), efficiency.EfficiencyResult):
        assert 0.9 < notebook["result"].efficiency < 1.0


def merged(content: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """Tables with entries put in; a flank of another kind takes the place of cutter and machine."""
    if "ease_off" in changes:
        content = {key: value for key, value in content.items() if key not in ("cutter", "machine")}
    tables = {key: merged(content.get(key, {}), value) for key, value in changes.items() if isinstance(value, dict)}
    return content | changes | tables


@pytest.mark.parametrize("block", FRAGMENTS, ids=str)
def test_tables_of_pages_are_read(block, mixed_ehl, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    content = tomllib.loads(block.text)
    if block.page == "docs/calibration.md":
        Path("setup.toml").write_text(block.text, encoding="utf-8")
        assert setup_of("setup.toml").parameters == tuple(content["parameters"])
    elif block.page in ("docs/friction_formula.md", "docs/sweep.md"):
        assert regression.Plan.from_dict(content).count > 0
    elif block.page == "docs/roughness.md":
        given = tomllib.loads((DOCS / "examples" / "contact_rough.toml").read_text(encoding="utf-8"))
        assert ehl.Contact(**given | content).surface.finish == "ground"
    elif block.page == "docs/oils.md":
        given = tomllib.loads((DOCS / "examples" / "contact.toml").read_text(encoding="utf-8"))
        lubricant = content.get("lubricant", {"temperature_oil": "80 degC"} | content)
        assert ehl.Contact(**given | {"lubricant": lubricant}).to_dict()["lubricant"]
    elif block.page == "docs/machine_settings.md":
        Path("targets.toml").write_text(block.text, encoding="utf-8")
        assert load_targets("targets.toml").targets.drive.crowning_toe == pytest.approx(4e-5)
    else:
        assert mixed_ehl("export", "fm_spiral_bevel_14x39", "-o", ".", "--what", "grid").code == 0
        given = tomllib.loads((ROOT / "data" / "designs" / "fm_spiral_bevel_14x39.toml").read_text(encoding="utf-8"))
        design = validate(Design, merged(given, content))
        for member in ("pinion", "gear"):
            for side in ("concave", "convex"):
                assert design.flank(member, side) is not None


@pytest.mark.parametrize(
    "line", [line for own in SHELL.values() for line in own if line.startswith("mixed-ehl ") and not_run(line)]
)
def test_command_of_a_page_is_parsed(line: str) -> None:
    """All that the command line checks before it computes, of what is not run here."""
    words = shlex.split(line.partition("|")[0])[1:]
    command, parents = COMMAND, click.Context(COMMAND, info_name="mixed-ehl")
    while hasattr(command, "list_commands") and words and not words[0].startswith("-"):
        name = words[0] if words[0] in command.list_commands(parents) or command.name != "sweep" else "run"
        command, words = command.get_command(parents, name), words[1:] if name == words[0] else words
    if not any(word == "--help" or word.endswith("completion") for word in words):
        assert not command.make_context(command.name, words, parent=parents).args


def test_links_and_pictures_of_the_pages_exist() -> None:
    # made by the build of the site
    built = ("gallery/", "../gallery/", "nomenclature.md", "../nomenclature.md", "units.md", "references.md")
    for path in PAGES:
        links = re.findall(r"\]\(([^)#\s]+)", path.read_text(encoding="utf-8"))
        missing = [link for link in links if "://" not in link and not (path.parent / link).exists()]
        assert [link for link in missing if not link.startswith(built)] == [], path


def test_functions_and_tests_named_on_the_pages_exist() -> None:
    theory = (DOCS / "theory.md").read_text(encoding="utf-8").splitlines()
    for proof in (line for line in theory if line.startswith("→ ")):
        functions, tests = (set(re.findall(r"`(\w+)`", part)) for part in proof.split(";"))
        assert functions
        assert functions <= CODE
        assert tests
        assert tests <= TESTS
    faults = set(re.findall(r"`(test_\w+)`", (DOCS / "robustness.md").read_text(encoding="utf-8")))
    assert len(faults) > 30
    assert faults <= TESTS | {path.stem for path in (ROOT / "tests").rglob("test_*.py")}


PROSE = {
    path.stem + "-" * (path.name == "index.md" and path.parent.name == "docs"): re.sub(
        r"^```.*?^```|\]\(\S*\)", "]", path.read_text(encoding="utf-8"), flags=re.S | re.M
    )
    for path in (ROOT / "README.md", DOCS / "index.md", *sorted((DOCS / "tutorials").glob("*.md")))
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
    kept = [name for name in ehl.shipped("datasets") if name.endswith(("_paths", "_noise"))]
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
