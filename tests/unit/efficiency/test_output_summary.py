"""Setting sheets: what is written is read back, and a sheet becomes a design."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from efficiency.cutting.summary import parse_summary, read_summary
from efficiency.design.design import bevel_names, load_design
from efficiency.output.machine_summary import design_from_sheet, sheet_text
from ehl.common.errors import InputError

PAIR = "fm_spiral_bevel_14x39"
Cli = Callable[..., Any]


@pytest.mark.parametrize("units", ["metric", "inch"])
@pytest.mark.parametrize("name", bevel_names())
def test_sheet_of_every_shipped_design_is_read_back(name: str, units: Any, tmp_path: Path) -> None:
    design = load_design(name)
    sheet = tmp_path / "sheet.csv"
    sheet.write_text(sheet_text(design, units), encoding="utf-8")
    assert read_summary(sheet).unread == ()
    text, notes = design_from_sheet(sheet, name)
    assert notes == []
    path = tmp_path / "again.toml"
    path.write_text(text, encoding="utf-8")
    again = load_design(path)
    for member in ("pinion", "gear"):
        first, second = (pd.json_normalize(getattr(d, member).model_dump()) for d in (design, again))
        # angles pass through degrees with twelve digits
        pd.testing.assert_frame_equal(first, second, check_dtype=False, rtol=2e-11, atol=1e-15)
    assert again.operation == design.operation
    assert again.assembly == design.assembly


def test_import_on_the_command_line(mixed_ehl: Cli, tmp_path: Path) -> None:
    assert mixed_ehl("export", PAIR, "-o", tmp_path, "--what", "summary", "--units", "inch").code == 0
    sheet, output = tmp_path / "setting_sheet.csv", tmp_path / "again.toml"
    assert mixed_ehl("import", sheet, "-o", output, "--like", PAIR).code == 0
    assert load_design(output).gear.blank.teeth == 39
    assert mixed_ehl("import", sheet, "-o", tmp_path / "tables.toml").code == 0
    assert "operation" not in tomllib.loads((tmp_path / "tables.toml").read_text(encoding="utf-8"))


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
