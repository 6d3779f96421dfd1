"""README and tour: what they print for a notebook runs, and what they link to exists."""

import re
import tomllib
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pytest

import regression

README = Path(__file__).resolve().parents[2] / "README.md"
TOUR = README.parent / "docs" / "tour.md"
FIRST, *STORIES = [
    block for page in (README, TOUR) for block in re.findall(r"```python\n(.*?)```", page.read_text("utf-8"), re.S)
]


@pytest.mark.usefixtures("commands_alone")
def test_the_three_stories_in_one_notebook(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    # values of a formula in place of 48 contacts, which `test_wheel` solves
    monkeypatch.setattr(regression, "sweep", partial(regression.sweep, formula="xu_kahraman_2007"))
    notebook: dict[str, Any] = {}
    assert [story.split()[1] for story in STORIES] == ["ehl", "regression", "efficiency"]
    for story in STORIES:
        exec(compile(story, "tour.md", "exec"), notebook)
    plt.close("all")
    assert notebook["path"].to_frame()["film_ratio"].is_monotonic_increasing
    assert 0.0 < notebook["result"].efficiency < 1.0
    assert notebook["result"].friction_model == notebook["formula"].name
    written = {path.name for path in tmp_path.iterdir()}
    assert {"contact.html", "run", "formula.json", "mu.c"} <= written


def test_the_landing_page_has_lines_of_the_readme() -> None:
    landing = (TOUR.parent / "index.md").read_text("utf-8")
    [block] = re.findall(r"```python\n(.*?)```", landing, re.S)
    ours, theirs = ([line.partition("  #")[0] for line in text.splitlines()] for text in (FIRST, block))
    assert set(theirs) <= set(ours)


def test_five_lines_of_the_readme(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    notebook: dict[str, Any] = {}
    exec(compile(FIRST, "README.md", "exec"), notebook)
    assert 0.98 < notebook["result"].efficiency < 1.0
    assert (tmp_path / "gear.html").exists()


def test_citation_and_licence_are_those_of_the_package() -> None:
    root = README.parent
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = (root / "CITATION.cff").read_text(encoding="utf-8").splitlines()
    assert f"version: {project['version']}" in citation
    assert f"license: {project['license']}" in citation
    [licence] = project["license-files"]
    assert (root / licence).read_text(encoding="utf-8").startswith("BSD 3-Clause License")
