"""Formula files: checksum, refusals on the command line with the remedy."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from refusals import refuses

from ehl.common.data import data_path
from regression.formula import Formula

SHIPPED = data_path("formulas", "fva3_short.json")
Call = Callable[..., Any]
POINT = (
    *("--pressure", "1 GPa", "--radius", "12 mm", "--speed", "5 m/s", "--slide-to-roll", "0.3"),
    *("--temperature", "80 degC", "--roughness-rms", "0.4 um"),
)


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
    with refuses("edited.json.checksum"):
        Formula.load(path)
    assert mixed_ehl("mu", path, *POINT).code == 2


def test_order_and_layout_are_no_edit(tmp_path: Path) -> None:
    content = json.loads(Formula.load(SHIPPED).to_json())
    path = tmp_path / "again.json"
    path.write_text(json.dumps(dict(reversed(content.items())), indent=7))
    assert Formula.load(path).to_dict() == Formula.load(SHIPPED).to_dict()


def test_command_line_refuses_damaged_files(tmp_path: Path, mixed_ehl: Call) -> None:
    text, path = Formula.load(SHIPPED).to_json(), tmp_path / "formula.json"
    for content in (text[: len(text) // 2], ""):
        path.write_text(content)
        assert mixed_ehl("mu", path, *POINT).code == 2
