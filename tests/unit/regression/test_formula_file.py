"""Formula files: checksum, refusals on the command line with the remedy."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ehl.common.data import data_path
from ehl.common.errors import InputError
from regression.formula import Formula
from regression.friction.fitted import FORMULA_SCHEMA

SHIPPED = data_path("formulas", "fva3_short.json")
Call = Callable[..., Any]
POINT = (
    *("--pressure", "1 GPa", "--radius", "12 mm", "--speed", "5 m/s", "--slide-to-roll", "0.3"),
    *("--temperature", "80 degC", "--roughness-rms", "0.4 um"),
)


def test_rows_of_numbers_stand_on_one_line(tmp_path: Path) -> None:
    text = Formula.load(SHIPPED).to_json()
    low, high = Formula.load(SHIPPED).ranges["pressure_hertz"]
    assert f'"pressure_hertz": [{low!r}, {high!r}]' in text


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("coefficients", "strain"), 0.9),
        (("boundary_friction",), 0.12),
        (("interval", "largest"), 0.01),
        (("ranges", "pressure_hertz"), [1e8, 4e9]),
    ],
)
def test_an_edited_number_is_refused_with_the_remedy(
    tmp_path: Path, mixed_ehl: Call, place: tuple[str, ...], value: object
) -> None:
    content = json.loads(Formula.load(SHIPPED).to_json())
    target = content
    for name in place[:-1]:
        target = target[name]
    target[place[-1]] = value
    path = tmp_path / "edited.json"
    path.write_text(json.dumps(content))
    with pytest.raises(InputError, match="was changed"):
        Formula.load(path)
    refused = mixed_ehl("mu", path, *POINT)
    assert refused.code == 2
    assert "was changed" in refused.err


def test_order_and_layout_are_no_edit(tmp_path: Path) -> None:
    content = json.loads(Formula.load(SHIPPED).to_json())
    path = tmp_path / "again.json"
    path.write_text(json.dumps(dict(reversed(content.items())), indent=7))
    assert Formula.load(path).to_dict() == Formula.load(SHIPPED).to_dict()


def test_command_line_refuses_newer_and_damaged_files(tmp_path: Path, mixed_ehl: Call) -> None:
    text = Formula.load(SHIPPED).to_json()
    newer = json.dumps(json.loads(text) | {"schema": FORMULA_SCHEMA + 1})
    for content, words in ((newer, "update mixed-ehl"), (text[: len(text) // 2], "mixed-ehl fit RUN"), ("", "read")):
        path = tmp_path / "formula.json"
        path.write_text(content)
        refused = mixed_ehl("mu", path, *POINT)
        assert refused.code == 2
        assert words in refused.err
        assert "Traceback" not in refused.err
