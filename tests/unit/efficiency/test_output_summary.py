"""Setting sheets: what is written is read back, and a sheet becomes a design."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import BaseModel

from efficiency.contact.grid_flank import grid_flank, read_point_grid
from efficiency.cutting.summary import parse_summary, read_summary
from efficiency.design.design import bevel_names, load_design
from efficiency.output.files import export_grids
from efficiency.output.machine_summary import design_from_sheet, sheet_text, write_sheet
from ehl.common.errors import InputError

PAIR = "fm_spiral_bevel_14x39"
Cli = Callable[..., Any]


def numbers(model: BaseModel, path: str = "") -> Iterator[tuple[str, object]]:
    for name in type(model).model_fields:
        value = getattr(model, name)
        if isinstance(value, BaseModel):
            yield from numbers(value, f"{path}.{name}")
        else:
            yield f"{path}.{name}", value


@pytest.mark.parametrize("units", ["metric", "inch"])
@pytest.mark.parametrize("name", bevel_names())
def test_sheet_of_every_shipped_design_is_read_back(name: str, units: Any, tmp_path: Path) -> None:
    design = load_design(name)
    sheet = tmp_path / "sheet.csv"
    write_sheet(sheet, design, units)
    assert read_summary(sheet).unread == ()
    text, notes = design_from_sheet(sheet, name)
    assert notes == []
    path = tmp_path / "again.toml"
    path.write_text(text, encoding="utf-8")
    again = load_design(path)
    for member in ("pinion", "gear"):
        first, second = (dict(numbers(getattr(d, member))) for d in (design, again))
        assert first.keys() == second.keys()
        for key, value in first.items():
            # angles pass through degrees with twelve digits
            assert second[key] == (pytest.approx(value, rel=2e-11, abs=1e-15) if isinstance(value, float) else value), (
                key
            )
    assert again.operation == design.operation
    assert again.assembly == design.assembly


def test_sheet_in_inch() -> None:
    text = sheet_text(load_design(PAIR), "inch")
    assert "units,                             inch" in text
    # the face width of 25.4 mm
    assert "face width,                        1\n" in text


def test_import_on_the_command_line(mixed_ehl: Cli, tmp_path: Path) -> None:
    assert mixed_ehl("export", PAIR, "-o", tmp_path, "--what", "summary", "--units", "inch").code == 0
    sheet, output = tmp_path / "setting_sheet.csv", tmp_path / "again.toml"
    outcome = mixed_ehl("import", sheet, "-o", output, "--like", PAIR)
    assert outcome.code == 0
    assert "can be computed" in outcome.out
    assert mixed_ehl("geometry", output, "--side", "drive").code == 0
    alone = mixed_ehl("import", sheet, "-o", tmp_path / "tables.toml")
    assert alone.code == 0
    assert "operation are missing" in alone.out


def test_a_sheet_as_papers_print_it(mixed_ehl: Cli, tmp_path: Path) -> None:
    """Zeros of a Formate gear, labels with units, decimal commas, cp1252; the hands are those of the other design."""
    base, sheet, output = load_design("fm_hypoid_13x42"), tmp_path / "sheet.csv", tmp_path / "again.toml"
    text = sheet_text(base, "metric")
    lines = ["Setting sheet, 20 \u00b0C"]
    for line in text.splitlines():
        label, _, value = (part.strip() for part in line.partition(","))
        if label == "cradle angle":
            value = str(abs(float(value)))
        label = {"radial setting": "Radial distance [mm]", "cradle angle": "Cradle angle (\u00b0)"}.get(label, label)
        if label != "hand":
            lines.append(f"{label};{value.replace('.', ',')};;" if label != "name" else line)
    for after in [k for k, line in enumerate(lines) if line.startswith("process;formate")][::-1]:
        lines[after + 1 : after + 1] = ["ratio of roll;0", "helical motion (mm/rad);0", "modified roll 2c;0"]
    sheet.write_bytes("\r\n".join(lines).encode("cp1252"))
    outcome = mixed_ehl("import", sheet, "-o", output, "--like", "fm_hypoid_13x42")
    assert outcome.code == 0, outcome.err
    assert "roll_ratio" in outcome.out
    again = load_design(output)
    for member in ("pinion", "gear"):
        for flank in ("concave", "convex"):
            first, second = (getattr(getattr(d, member), flank).machine for d in (base, again))
            assert second.radial_setting == pytest.approx(first.radial_setting, rel=1e-9)
            assert second.cradle_angle == pytest.approx(first.cradle_angle, rel=1e-9)
    sheet.write_text("\n".join(line.replace("ratio of roll;0", "ratio of roll;3") for line in lines), encoding="utf-8")
    assert mixed_ehl("import", sheet, "-o", output, "--like", "fm_hypoid_13x42").code == 2


def test_all_lines_that_cannot_be_used_are_reported_together() -> None:
    with pytest.raises(InputError) as caught:
        parse_summary("member, gear\nteeth, 41.5\nradial [deg], 90\nhand, middle")
    assert [problem.field for problem in caught.value.problems] == ["line 2 (teeth)", "line 3", "line 4 (hand)"]


def test_lines_not_known_are_told(mixed_ehl: Cli, tmp_path: Path) -> None:
    sheet = tmp_path / "sheet.txt"
    sheet.write_text(sheet_text(load_design(PAIR)) + "grinding wheel, 3\n", encoding="utf-8")
    outcome = mixed_ehl("import", sheet, "-o", tmp_path / "again.toml", "--like", PAIR)
    assert outcome.code == 0
    assert "not read: grinding wheel, 3" in outcome.out


def test_grid_file_is_read_back_as_a_flank(tmp_path: Path) -> None:
    design = load_design(PAIR)
    export_grids(design, "gear", tmp_path, 9, 15)
    exact = design.gear.flank("convex")
    flank = grid_flank(read_point_grid(tmp_path / "gear_convex.csv"), "convex", exact.blank, "right")

    u, h = np.linspace(-0.011, 0.011, 7), np.linspace(-0.003, 0.001, 7)
    one, other = exact.solve(u, h)[0], flank.solve(u, h)[0]
    assert np.abs(one.position - other.position).max() < 1e-8
    assert np.abs(one.normal - other.normal).max() < 1e-5
