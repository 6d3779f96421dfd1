"""The stories of the README for a notebook run as they are printed."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pytest

README = Path(__file__).resolve().parents[2] / "README.md"
STORIES = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.S)


def test_the_three_stories_in_one_notebook(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    notebook: dict[str, Any] = {}
    assert [story.split()[1] for story in STORIES] == ["ehl", "regression", "efficiency"]
    for story in STORIES:
        exec(compile(story, "README.md", "exec"), notebook)
    plt.close("all")
    assert notebook["path"].to_frame()["film_ratio"].is_monotonic_increasing
    assert 0.0 < notebook["result"].efficiency < 1.0
    assert notebook["result"].friction_model == notebook["formula"].name
    written = {path.name for path in tmp_path.iterdir()}
    assert {"contact.html", "run", "formula.json", "mu.c"} <= written


def test_citation_and_licence_are_those_of_the_package() -> None:
    root = README.parent
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = (root / "CITATION.cff").read_text(encoding="utf-8").splitlines()
    assert f"version: {project['version']}" in citation
    assert f"license: {project['license']}" in citation
    [licence] = project["license-files"]
    assert (root / licence).read_text(encoding="utf-8").startswith("BSD 3-Clause License")


def test_every_file_the_readme_links_to_exists() -> None:
    links = re.findall(r"\]\(([^)#]+)", README.read_text(encoding="utf-8"))
    missing = [link for link in links if "://" not in link and not (README.parent / link).exists()]
    assert len(links) > 20
    assert missing == []
