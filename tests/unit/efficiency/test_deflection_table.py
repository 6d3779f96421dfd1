"""Deflections as a table over the torque of both flanks."""

from math import radians
from pathlib import Path

import pytest

import efficiency
from efficiency.design.design import Design, load_design
from efficiency.design.shaft_input import MISALIGNMENTS, Deflection
from ehl.common.data import data_path
from ehl.common.errors import InputError
from ehl.common.validation import validate

NAME = "fm_spiral_bevel_14x39_relieved"
TABLE = """torque [N m];E [um];P [um];G [um];alpha [arcmin]
-300;10;-20;5;0
300;-40;30;20;1
0;-4;2;0;0
600;-70;50;30;2
"""


def made(folder: Path, text: str, torque: str = "300 N m") -> Design:
    """A shipped design with a table next to its file."""
    (folder / "deflections.csv").write_text(text, encoding="utf-8")
    content = data_path("designs", f"{NAME}.toml").read_text(encoding="utf-8")
    path = folder / "own.toml"
    path.write_text(content + '\n[assembly.deflection]\ntable = "deflections.csv"\n', encoding="utf-8")
    return load_design(path)


@pytest.mark.fast
def test_rows_are_interpolated_for_both_flanks(tmp_path: Path) -> None:
    design = made(tmp_path, TABLE)
    for torque, side, expected in (
        (450.0, "drive", (-55e-6, 40e-6, 25e-6, radians(1.5 / 60.0))),
        (150.0, "coast", (3e-6, -9e-6, 2.5e-6, 0.0)),
        (0.0, "drive", (-4e-6, 2e-6, 0.0, 0.0)),
    ):
        moved = design.under_torque(torque, side).assembly.misalignment
        assert [getattr(moved, name) for name in MISALIGNMENTS] == pytest.approx(expected, abs=1e-12)
    with pytest.raises(InputError) as refused:
        design.under_torque(400.0, "coast")
    assert refused.value.field == "assembly.deflection.table"
    without_zero = made(tmp_path, "torque [N m],E [um]\n300,30\n")
    assert pytest.approx(10e-6) == without_zero.under_torque(100.0).assembly.misalignment.E


@pytest.mark.fast
@pytest.mark.parametrize(
    "text",
    [
        "torque [N m]\n300\n",
        "torque [N m],E [um]\n300,3000\n",
        "torque [N m],E [um]\n300,30\n300,20\n",
        "torque,E\n300,30\n",
        "E [um]\n30\n",
    ],
)
def test_tables_that_cannot_be_used_are_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError):
        made(tmp_path, text)


@pytest.mark.fast
def test_a_table_excludes_values_at_one_torque() -> None:
    with pytest.raises(InputError):
        validate(Deflection, {"table": [[300.0, 1e-5, 0.0, 0.0, 0.0]], "E": "10 um", "torque": "300 N m"})


def test_efficiency_with_a_table_is_that_of_the_misaligned_pair(tmp_path: Path) -> None:
    design = made(tmp_path, TABLE)
    assert validate(Design, design.model_dump()) == design
    moved = load_design(NAME).with_misalignment(E=-40e-6, P=30e-6, G=20e-6, shaft_angle_error=radians(1.0 / 60.0))
    found, expected = (
        efficiency.GearPair(pair).at("constant:0.05", grid=(4, 9), torque=300.0) for pair in (design, moved)
    )
    assert found.efficiency == pytest.approx(expected.efficiency, rel=1e-9)
    assert found.pressure_hertz_max == pytest.approx(expected.pressure_hertz_max, rel=1e-9)
