"""Every fenced block of README and site runs as it is printed, or stands here with the reason why not.

Tutorials, the README and some pages have tests of their own (`RUN_BY`). The commands of the other pages run in order in
a folder of their own, the Python and TOML blocks one by one. What takes minutes or needs files of the reader is only
read (`ONLY_READ`): commands, options and shipped names exist, which holds for every command in the text too.
"""

from __future__ import annotations

import ast
import pkgutil
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
import matplotlib.pyplot as plt
import pytest
import typer

import ehl
import regression
from efficiency.cli import app
from efficiency.design.design import Design
from efficiency.machine_settings.inputs import load_targets
from ehl.common.data import shipped
from ehl.common.validation import validate
from regression.calibration.setup import load_setup
from regression.friction.published_registry import PUBLISHED

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

SWEEPS = "test_plan_and_commands_of_the_page_on_sweeps"
# blocks that a test of another module runs, by page and language or first line: its name
RUN_BY = {
    ("README.md", "python"): "test_five_lines_of_the_readme",
    ("docs/index.md", "python"): "test_five_lines_of_the_landing_page",
    ("docs/tour.md", "python"): "test_the_three_stories_in_one_notebook",
    ("docs/friction_formula.md", "sh"): "test_plan_and_commands_of_the_page",
    ("docs/friction_formula.md", "toml"): "test_plan_and_commands_of_the_page",
    ("docs/sweep.md", "toml"): SWEEPS,
    (
        "docs/sweep.md",
        "mixed-ehl sweep gear_default --estimate --jobs 2",
    ): "test_plan_and_commands_of_the_page_on_sweeps",
    ("docs/sweep.md", "from dask_jobqueue import SLURMCluster"): "test_the_cluster_of_the_page_on_sweeps_computes",
    ("docs/formula_code.md", "c"): "test_example_of_the_page",
} | {
    (f"docs/tutorials/{page}.md", "sh"): "test_tutorial_runs_as_it_is_printed"
    for page in ("oil", "gear", "calibrate", "cluster", "better")
}

# lines of `sh` blocks that are not run here, by how they begin, and why
ONLY_READ = {
    "python -m pip install": "the gate installs",
    "python -m sphinx": "the gate builds the site",
    "ruff ": "the gate runs it",
    "mypy": "the gate runs it",
    "pytest": "the tests themselves",
    "jupytext": "converts examples, which test_examples runs",
    "cc -O2": "test_example_of_the_page compiles and runs it",
    "./main": "test_example_of_the_page compiles and runs it",
    "mixed-ehl --install-completion": "writes into the start file of the shell",
    "mixed-ehl app": "the browser test serves it",
    "mixed-ehl demo": "test_wheel runs it",
    "mixed-ehl optimise": "minutes; the tutorial runs a search with fewer points",
    "mixed-ehl study": "minutes; test_study runs smaller ones",
    "mixed-ehl fit RUN": "RUN, PATHS, NOISE: folders of hundreds of contacts of the reader",
    "mixed-ehl mu formula.json --hull RUN": "RUN, as above",
    "mixed-ehl calibrate boundary_film_conditions.csv": "rough contacts, minutes",
    "mixed-ehl calibrate made.csv": "rough contacts, minutes",
    "mixed-ehl calibrate synthetic_traction.csv": "the tutorial runs it",
    "mixed-ehl calibrate docs/examples/synthetic_traction.csv": "the tutorial runs it",
    "mixed-ehl compare fm_spiral_bevel_14x39 --friction formula.json": "solves every contact point, a minute",
    "mixed-ehl solve docs/examples/contact_rough.toml": "animates half a minute; test_solve_rough solves the contact",
    "mixed-ehl gear fm_spiral_bevel_14x39 --friction 75w90 --report": "the tutorial writes the page",
    "mixed-ehl gear fm_spiral_bevel_14x39 --friction formula.json --report": "as above",
    'mixed-ehl map fm_spiral_bevel_14x39 --friction 75w90 --torque "50': "test_page_of_a_point_and_of_a_map",
    "mixed-ehl geometry fm_spiral_bevel_14x39": "test_example_commands_run runs it",
    "mixed-ehl export fm_spiral_bevel_14x39 -o files": "test_example_commands_run runs it",
    'mixed-ehl misalignment fm_spiral_bevel_14x39 --E "-0.1, 0, 0.1 mm"': "test_example_commands_run runs it",
}

# what makes a command short enough for a test
SHORTER = {
    "mixed-ehl sweep data/plans/demo.toml": ["--with", "xu_kahraman_2007", "--jobs", "1"],
    "mixed-ehl fit run -o formula.json --report fit.html": ["--family", "power_law"],
}


def not_run(command: str) -> str:
    """Why a command is only read; empty if it runs."""
    return next((reason for start, reason in ONLY_READ.items() if command.startswith(start)), "")


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
PYTHON = [block for block in OURS if block.language == "python"]
FRAGMENTS = [block for block in OURS if block.language == "toml"]


def test_every_block_runs_or_has_its_reason() -> None:
    tests = {
        node.name
        for module in (ROOT / "tests").rglob("test_*.py")
        for node in ast.walk(ast.parse(module.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef)
    }
    assert len(BLOCKS) > 60
    assert {block.language for block in OURS} == {"sh", "python", "toml", "text"}
    assert set(RUN_BY.values()) <= tests
    # nothing is excused that is not there
    firsts = {(block.page, block.text.strip().partition("\n")[0]) for block in BLOCKS}
    assert set(RUN_BY) <= {(block.page, block.language) for block in BLOCKS} | firsts
    lines = [line for block in BLOCKS if block.language == "sh" for line in commands(block)]
    assert [start for start in ONLY_READ if not any(line.startswith(start) for line in lines)] == []
    named = {word for reason in ONLY_READ.values() for word in re.findall(r"test_\w+", reason)}
    assert named <= tests | {path.stem for path in (ROOT / "tests").rglob("test_*.py")}
    # what runs is ours; what is not ours has its reason
    assert [
        line for lines in SHELL.values() for line in lines if not (line.startswith("mixed-ehl ") or not_run(line))
    ] == []
    for block in BLOCKS:
        if block.language == "text":
            assert "mixed-ehl " not in block.text.replace("# mixed-ehl flank grid", ""), block
            assert "import " not in block.text, block


def files_of(page: str, mixed_ehl: Callable[..., Any]) -> None:
    """What the commands of a page find in their folder."""
    if page == "docs/calibration.md":
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


@pytest.mark.parametrize("page", RUNNING)
def test_commands_of_a_page_run(
    page: str, mixed_ehl: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    files_of(page, mixed_ehl)
    for line in RUNNING[page]:
        if not not_run(line):
            more = next((words for start, words in SHORTER.items() if line.startswith(start)), [])
            outcome = mixed_ehl(*shlex.split(line)[1:], *more)
            assert outcome.code == 0, (line, outcome.err)
            assert outcome.out + outcome.err, line
    plt.close("all")


@pytest.mark.parametrize("block", PYTHON, ids=str)
def test_python_of_a_page_runs(block: Block, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = block.text
    if block.page == "docs/sweep.md":  # 64 values of a published formula in place of 2048 contacts
        text = text.replace('["lubricant.oil=fva3"]', '["lubricant.oil=fva3", "sampling.size=64"]')
        assert text != block.text
        instead = partial(regression.sweep, formula="xu_kahraman_2007")
        monkeypatch.setattr(regression, "sweep", instead)
        monkeypatch.setattr("regression.sweeping.run.sweep", instead)
    exec(compile(text, block.page, "exec"), {})
    plt.close("all")


def merged(content: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """Tables with entries put in; a flank of another kind takes the place of cutter and machine."""
    if "ease_off" in changes:
        content = {key: value for key, value in content.items() if key not in ("cutter", "machine")}
    tables = {key: merged(content.get(key, {}), value) for key, value in changes.items() if isinstance(value, dict)}
    return content | changes | tables


@pytest.mark.parametrize("block", FRAGMENTS, ids=str)
def test_tables_of_a_page_are_read(
    block: Block, mixed_ehl: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    content = tomllib.loads(block.text)
    if block.page == "docs/calibration.md":
        Path("setup.toml").write_text(block.text, encoding="utf-8")
        assert load_setup(Path("setup.toml"), {}).parameters == tuple(content["parameters"])
    elif block.page == "docs/roughness.md":
        given = tomllib.loads((DOCS / "examples" / "contact_rough.toml").read_text(encoding="utf-8"))
        assert ehl.Contact.from_dict(given | content).surface.finish == "ground"
    elif block.page == "docs/oils.md":
        given = tomllib.loads((DOCS / "examples" / "contact.toml").read_text(encoding="utf-8"))
        lubricant = content.get("lubricant", {"temperature_oil": "80 degC"} | content)
        assert ehl.Contact.from_dict(given | {"lubricant": lubricant}).to_dict()["lubricant"]
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


def spans() -> Iterator[tuple[str, str]]:
    """(page, command) of every command in the text and in the blocks."""
    for path in PAGES:
        text = path.read_text(encoding="utf-8")
        for found in re.findall(r"(?<!`)`(mixed-ehl [^`]+)`(?!`)", text):
            yield path.relative_to(ROOT).as_posix(), " ".join(found.split())
    for block in BLOCKS:
        if block.language == "sh":
            for line in commands(block):
                if line.startswith("mixed-ehl "):
                    yield block.page, line


SOURCES = [f"/{path.relative_to(ROOT).as_posix()}" for path in ROOT.rglob("*.py")]
SPANS = sorted(set(spans()))
NAMED = {
    name for kind in ("designs", "oils", "formulas", "blanks", "plans", "targets", "datasets") for name in shipped(kind)
} | set(PUBLISHED)


@pytest.mark.parametrize(("page", "line"), SPANS, ids=lambda value: value.replace("/", "-")[:60])
def test_command_in_the_text_exists(page: str, line: str) -> None:
    """Command, options and shipped names; in blocks all the command line would check before it computes."""
    words = [word for word in shlex.split(line.replace("\\|", "|"))[1:] if word not in ("...", "[--json]")]
    words = words[: words.index("|")] if "|" in words else words
    command = COMMAND
    parents = click.Context(COMMAND, info_name="mixed-ehl")
    while words and hasattr(command, "list_commands") and not words[0].startswith("-"):
        if words[0].isupper():  # COMMAND: any
            return
        name = words[0] if words[0] in command.list_commands(parents) or command.name != "sweep" else "run"
        found = command.get_command(parents, name)
        assert found is not None, f"{page}: no command {name}"
        command, words = found, words[1:] if name == words[0] else words
    options = {option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)}
    options |= {"--help", "--install-completion", "--show-completion"}
    assert [word for word in words if re.match(r"--?[a-zA-Z]", word) and word not in options] == []
    names = [word for word in words if re.fullmatch(r"(fm|fh|iso23509|gear)_\w+|(fva3|75w90)\w*", word)]
    assert set(names) <= NAMED, set(names) - NAMED
    if not all(word == "--help" or word.endswith("completion") for word in words) and (
        any(line in lines for lines in SHELL.values())
    ):
        inner = command.make_context(command.name, words, parent=parents)
        assert not inner.args


def every_command() -> Iterator[Any]:
    stack = [COMMAND]
    while stack:
        command = stack.pop()
        if hasattr(command, "list_commands"):
            context = click.Context(command)
            stack += [command.get_command(context, name) for name in command.list_commands(context)]
        yield command


def test_help_is_whole_sentences_and_nothing_of_it_is_taken_for_markup() -> None:
    for command in every_command():
        texts = {parameter.name: getattr(parameter, "help", None) for parameter in command.params} | {"": command.help}
        for name, text in texts.items():
            assert text, (command.name, name)
            assert text.rstrip().endswith((".", ")")), (command.name, name, text)
            assert "[" not in text, (command.name, name, text)


def test_options_in_the_text_exist() -> None:
    known = {"--help", "--version", "--install-completion", "--show-completion", "--nthreads"}
    known |= {"--part", "--rheology"}  # of benchmarks
    for command in every_command():
        known |= {option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)}
    for path in PAGES:
        found = set(re.findall(r"`(--[a-z][a-z-]*)", path.read_text(encoding="utf-8")))
        assert found <= known, (path.name, found - known)


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix().replace("/", "-"))
def test_links_and_pictures_of_a_page_exist(path: Path) -> None:
    links = re.findall(r"\]\(([^)#\s]+)", path.read_text(encoding="utf-8"))
    missing = [link for link in links if "://" not in link and not (path.parent / link).exists()]
    assert [link for link in missing if not link.startswith(("gallery/", "../gallery/"))] == []


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix().replace("/", "-"))
def test_modules_and_names_of_a_page_exist(path: Path) -> None:
    """Files of Python, folders and dotted names between backticks; an old one sends the reader nowhere."""
    text = path.read_text(encoding="utf-8")
    missing = [
        name for name in re.findall(r"`([\w/]+\.py)\b", text) if not any(f.endswith(f"/{name}") for f in SOURCES)
    ]
    missing += [
        name
        for name in re.findall(r"`((?:ehl|regression|efficiency|data)/[\w/]*)`", text)
        if not (ROOT / name).exists()
    ]
    for name in re.findall(r"`((?:ehl|regression|efficiency)(?:\.\w+)+)", text):
        try:
            pkgutil.resolve_name(name)
        except (ImportError, AttributeError):
            missing.append(name)
    assert missing == []
