"""A user's script sees the type of every public name: none is `Any`."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import pytest
from mypy import api

PACKAGES = ("ehl", "regression", "efficiency")
ROOT = Path(__file__).resolve().parents[2]


def test_no_public_name_is_any(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    names = [f"{package}.{name}" for package in PACKAGES for name in import_module(package).__all__]
    script = tmp_path / "script.py"
    lines = [f"import {package}" for package in PACKAGES] + [f"reveal_type({name})" for name in names]
    script.write_text("\n".join(lines) + "\n", encoding="utf-8")
    # options and cache of the repository's own check: what it has analysed is not analysed again
    found, errors, code = api.run(["--strict", "--config-file", "pyproject.toml", str(script)])
    revealed = re.findall(r'Revealed type is "(.*)"', found)
    assert len(revealed) == len(names), found + errors
    assert code == 0, found
    assert [name for name, kind in zip(names, revealed, strict=True) if kind == "Any"] == []
