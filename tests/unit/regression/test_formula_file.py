"""Formula files: earlier schema, checksum, refusals on the command line with the remedy."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ehl.common.data import data_path
from ehl.common.errors import InputError
from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.friction.conditions import conditions_of
from regression.friction.formula import FORMULA_SCHEMA, load_formula
from regression.friction.gaussian_process import GpResidual

SHIPPED = data_path("formulas", "fva3_load_share.json")
Call = Callable[..., Any]
POINT = (
    *("--pressure", "1 GPa", "--radius", "12 mm", "--speed", "5 m/s", "--slide-to-roll", "0.3"),
    *("--temperature", "80 degC", "--roughness", "0.4 um"),
)


def schema_1() -> dict[str, Any]:
    """The shipped formula as schema 1 wrote it."""
    content = json.loads(load_formula(SHIPPED).to_json())
    new = (
        "oils",
        "checksum",
        "residual",
        "film_residual",
        "cloud",
        "paths",
        "nested",
        "noise",
        "boundary_friction_range",
    )
    old = {name: value for name, value in content.items() if name not in new}
    return old | {"schema": 1, "oil": content["oils"][0]}


def test_schema_1_is_read_and_says_the_same(tmp_path: Path) -> None:
    path = tmp_path / "old.json"
    path.write_text(json.dumps(schema_1()))
    old, new = load_formula(path), load_formula(SHIPPED)
    assert old.schema_version == FORMULA_SCHEMA
    assert old.oil == new.oil
    assert (old.cloud, old.residual, old.noise, old.paths) == (None, None, None, None)
    conditions = conditions_of(ContactState.of(pressure_hertz=1e9, radius_equivalent=0.01, effective_modulus=226e9,
        speed_entrainment=5.0, slide_to_roll=0.3, roughness_rms_1=3e-7), Oil.load("fva3"))  # fmt: skip
    assert old.evaluate(conditions).mu == new.evaluate(conditions).mu
    old.save(path)
    assert json.loads(path.read_text())["schema"] == FORMULA_SCHEMA
    assert load_formula(path) == old


def test_schema_1_of_a_lubricant_by_numbers_has_no_oil(tmp_path: Path) -> None:
    path = tmp_path / "old.json"
    path.write_text(json.dumps(schema_1() | {"oil": {"name": None, "card_hash": None}}))
    assert load_formula(path).oils == ()


def test_schema_2_with_a_process_is_read_and_says_the_same(tmp_path: Path) -> None:
    """It stored the points of its one process before they were divided by the length scales, and no second process."""
    new = load_formula(SHIPPED).model_copy(
        update={
            "residual": GpResidual(
                variables=("pressure_hertz", "speed_entrainment"), mean=(20.7, 1.6), scale=(0.5, 0.8), low=(-2.0, -2.0),
                high=(2.0, 2.0), length_scales=(2.5, 0.5), variance=0.02, noise=1e-4,
                points=((0.0, 0.5), (0.25, -1.5)), weights=(3.0, -2.0), alpha=(1e-4,),
            )
        }
    )  # fmt: skip
    content = new.model_dump(mode="json", by_alias=True)
    del content["film_residual"]
    content["schema"] = 2
    content["residual"]["points"] = [[0.0, 0.25], [0.625, -0.75]]
    content["checksum"] = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
    path = tmp_path / "old.json"
    path.write_text(json.dumps(content))
    assert load_formula(path).model_dump() == new.model_dump()
    del content["residual"]["length_scales"]
    path.write_text(json.dumps(content))
    with pytest.raises(InputError, match="length_scales"):
        load_formula(path)


def test_rows_of_numbers_stand_on_one_line(tmp_path: Path) -> None:
    text = load_formula(SHIPPED).to_json()
    low, high = load_formula(SHIPPED).ranges["pressure_hertz"]
    assert f'"pressure_hertz": [{low!r}, {high!r}]' in text


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("coefficients", "stress"), 0.9),
        (("boundary_friction",), 0.12),
        (("interval", "largest"), 0.01),
        (("ranges", "pressure_hertz"), [1e8, 4e9]),
    ],
)
def test_an_edited_number_is_refused_with_the_remedy(
    tmp_path: Path, mixed_ehl: Call, place: tuple[str, ...], value: object
) -> None:
    content = json.loads(load_formula(SHIPPED).to_json())
    target = content
    for name in place[:-1]:
        target = target[name]
    target[place[-1]] = value
    path = tmp_path / "edited.json"
    path.write_text(json.dumps(content))
    with pytest.raises(InputError, match=r"edited by hand or damaged.*fit it again"):
        load_formula(path)
    refused = mixed_ehl("mu", path, *POINT)
    assert refused.code == 2
    assert "edited by hand" in refused.err


def test_order_and_layout_are_no_edit(tmp_path: Path) -> None:
    content = json.loads(load_formula(SHIPPED).to_json())
    path = tmp_path / "again.json"
    path.write_text(json.dumps(dict(reversed(content.items())), indent=7))
    assert load_formula(path) == load_formula(SHIPPED)


def test_command_line_refuses_newer_and_damaged_files(tmp_path: Path, mixed_ehl: Call) -> None:
    text = load_formula(SHIPPED).to_json()
    newer = json.dumps(json.loads(text) | {"schema": FORMULA_SCHEMA + 1})
    for content, words in ((newer, "update mixed-ehl"), (text[: len(text) // 2], "mixed-ehl fit RUN"), ("", "read")):
        path = tmp_path / "formula.json"
        path.write_text(content)
        refused = mixed_ehl("mu", path, *POINT)
        assert refused.code == 2
        assert words in refused.err
        assert "Traceback" not in refused.err
