"""Geometry of a pair as tables, figures, page and files: what they say agrees with the design and with each other."""

import csv
import json
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from pages import read_page

from efficiency.design.design import Design, load_design
from efficiency.geometry import pair_geometry as geometry_module
from efficiency.geometry.pair_geometry import PairGeometry, pair_geometry
from efficiency.output.files import inspection_grid, write_inspection_grid
from efficiency.output.geometry_report import graded_notes, side_figures
from efficiency.output.machine_summary import summary_rows, write_summary
from ehl.common.errors import ConvergenceError
from ehl.common.figures import figure_of

EXAMPLE = Path(__file__).resolve().parents[3] / "docs" / "examples" / "gear_geometry.sh"
PAIR = "fm_spiral_bevel_14x39"
Cli = Callable[..., Any]


@pytest.fixture(scope="module")
def geometry(design: Design) -> PairGeometry:
    return pair_geometry(design)


def test_geometry_of_both_sides(geometry: PairGeometry) -> None:
    assert geometry.status == "converged"
    assert set(geometry.sides) == {"drive", "coast"}
    for side in geometry.sides.values():
        low, high = side.ease_off
        assert 0.0 <= low < 1e-8
        assert high > 1e-5
        # the more pairs share the mesh, the longer each lasts: lines in mesh over the cycle add up to the same ratio
        lines = np.mean([np.unique(position.pair).size for position in side.cycle])
        assert side.contact_ratio == pytest.approx(lines, abs=0.06)
        assert 1.0 < side.path_ratio < side.contact_ratio
    assert json.dumps(geometry.to_dict(), allow_nan=False)


def test_flank_angles_agree_with_the_blank(geometry: PairGeometry) -> None:
    for flank in geometry.flanks.values():
        assert np.degrees(flank.spiral_angle) == pytest.approx(35.0, abs=0.5)
        assert np.degrees(flank.pressure_angle) == pytest.approx(20.0, abs=0.2)
    # the gear is cut to its root cone
    for name in ("gear_concave", "gear_convex"):
        root = geometry.flanks[name].root_error
        assert max(abs(value) for value in root) < 5e-5
        assert geometry.flanks[name].undercut == 0.0


def test_a_side_that_fails_is_told(design: Design, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(design: Design, side: str, marking: float) -> None:
        raise ConvergenceError("undercut", f"{side} flank ends")

    monkeypatch.setattr(geometry_module, "side_geometry", fail)
    found = pair_geometry(design, ("coast",))
    assert found.status == "failed"
    assert [(note.grade, note.where) for note in graded_notes(found) if note.where] == [("fault", "coast")]


def test_figures_of_an_undercut_hypoid_pair() -> None:
    found = pair_geometry(load_design("fh_hypoid_9x34"), ("drive",))
    assert any("undercut" in note.text for note in graded_notes(found))
    for picture in side_figures(found.sides["drive"]):
        assert figure_of(picture.draw()).axes


@pytest.mark.parametrize(("units", "factor"), [("metric", 1e3), ("inch", 1.0 / 0.0254)])
def test_summary_holds_the_numbers_of_the_design(design: Design, tmp_path: Path, units: Any, factor: float) -> None:
    path = tmp_path / "summary.csv"
    write_summary(path, design, units)
    lines = path.read_text(encoding="utf-8").splitlines()
    table = {(row["section"], row["name"]): row for row in csv.DictReader(lines[1:])}
    radial, cradle = (float(table["machine", name]["pinion_convex"]) for name in ("radial_setting", "cradle_angle"))
    machine = design.pinion.convex.machine
    expected = machine.radial_setting * factor, np.degrees(machine.cradle_angle)
    assert (radial, cradle) == pytest.approx(expected, rel=1e-15)
    assert table["cutter", "point_radius"]["unit"] == ("mm" if units == "metric" else "in")
    assert table["blank", "hand"]["pinion_concave"] == "left"


def test_blank_dimensions_of_the_summary(design: Design) -> None:
    """ISO 23509 F.2 as printed in the source of the design: outer diameters, crowns along the axis."""
    rows = {row.name: row.values for row in summary_rows(design) if row.section == "blank"}
    assert rows["outer_diameter"][0] == pytest.approx(63.5, abs=0.01)
    assert rows["outer_diameter"][2] == pytest.approx(176.893, abs=0.01)
    # the face cone through the crown meets the axis in its apex
    for k in (0, 2):
        apex, crown, diameter, angle = (
            float(rows[name][k] or 0.0)
            for name in ("face_apex_beyond_crossing", "crossing_to_crown", "outer_tip_diameter", "face_angle")
        )
        assert (apex + crown) * np.tan(np.radians(angle)) == pytest.approx(0.5 * diameter, rel=1e-9)


def test_grid_file_starts_at_root_and_heel(design: Design, tmp_path: Path) -> None:
    """That its points are on the flank is in `test_contact_surfaces`."""
    flank, path = design.pinion.flank("concave"), tmp_path / "pinion.csv"
    grid = inspection_grid(flank, 5, 9)
    assert 0.0 < flank.lowest_fraction() == grid.lowest < 0.1
    write_inspection_grid(path, design, "pinion", "concave", grid)
    table = pd.read_csv(path, comment="#")
    u, h = flank.blank.coordinates(np.hypot(table["x"], table["y"]) * 1e-3, table["z"] * 1e-3)
    assert np.corrcoef(table["row"], np.real(h))[0, 1] > 0.8
    assert np.corrcoef(table["column"], np.real(u))[0, 1] < -0.99


def commands() -> list[str]:
    return [line for line in EXAMPLE.read_text(encoding="utf-8").splitlines() if line.startswith("mixed-ehl")]


def test_example_commands_run(mixed_ehl: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for line in commands():
        outcome = mixed_ehl(*shlex.split(line)[1:])
        assert outcome.code == 0, outcome.err
    page = read_page(tmp_path / "geometry.html")
    # figures of the side, and the axial section
    assert page.source.count("<svg") == len(list((tmp_path / "geometry").glob("*.png"))) == 10
    assert "nan" not in page.text
    written = {path.name for path in (tmp_path / "files").iterdir()}
    assert {"pinion.stl", "pinion_tooth_space.stl", "pinion_concave.csv", "machine_summary.csv"} <= written
    tour = (EXAMPLE.parents[1] / "tour.md").read_text(encoding="utf-8")
    assert all(line in tour for line in commands())


def test_geometry_on_the_command_line(mixed_ehl: Cli) -> None:
    outcome = mixed_ehl("geometry", PAIR, "--json", "--side", "coast", "--marking", "8 um")
    result = json.loads(outcome.out)
    assert (result["marking"], list(result["sides"])) == (pytest.approx(8e-6), ["coast"])
