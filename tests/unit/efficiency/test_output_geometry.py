"""Geometry of a pair as tables, figures, page and files: what they say agrees with the design and with each other."""

import csv
import json
import re
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
from efficiency.output.files import FORMAT, inspection_grid, write_inspection_grid
from efficiency.output.geometry_report import contact_table, graded_notes, side_figures
from efficiency.output.machine_summary import summary_rows, write_summary
from efficiency.output.plots_geometry import blank_figure
from ehl.common.errors import ConvergenceError
from ehl.common.figures import figure_of

EXAMPLE = Path(__file__).resolve().parents[3] / "docs" / "examples" / "gear_geometry.sh"
TOUR = EXAMPLE.parents[1] / "tour.md"
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
        # close to a parabola: amplitudes of its orders fall with their square
        harmonics = side.pair.transmission.harmonics
        assert harmonics[0] / harmonics[1] == pytest.approx(4.0, rel=0.02)
    assert len(json.dumps(geometry.to_dict(), allow_nan=False)) > 1000


def test_flank_angles_agree_with_the_blank(geometry: PairGeometry) -> None:
    for flank in geometry.flanks.values():
        assert np.degrees(flank.spiral_angle) == pytest.approx(35.0, abs=0.5)
        assert np.degrees(flank.pressure_angle) == pytest.approx(20.0, abs=0.2)
    assert geometry.flanks["pinion_concave"].lowest > 0.0
    # the pinion settings of this pair define the flanks only, with a note of each; the gear is cut to its root cone
    assert all(any(f"pinion {side} flank" in note for note in geometry.notes) for side in ("concave", "convex"))
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
    (told,) = [note for note in graded_notes(found) if note.where]
    assert (told.grade, told.where) == ("fault", "coast")


def test_every_axis_has_a_name_and_a_unit(geometry: PairGeometry, design: Design) -> None:
    figures = [figure_of(shown.draw()) for side in geometry.sides.values() for shown in side_figures(side)]
    for figure in [*figures, blank_figure(design)]:
        for axes in (axes for axes in figure.axes if axes.axison):
            labels = {axes.get_xlabel(), axes.get_ylabel()} - ({""} if axes.get_label() == "<colorbar>" else set())
            assert labels
            assert all(re.search(r"\[[^\]]+\]", label) for label in labels), labels


def test_figures_of_an_undercut_hypoid_pair() -> None:
    found = pair_geometry(load_design("fh_hypoid_9x34"), ("drive",))
    assert any("undercut" in note.text for note in graded_notes(found))
    pictures = {picture.name: picture for picture in side_figures(found.sides["drive"])}
    for name in ("teeth_in_mesh", "ease_off_pinion", "contact_pattern_gear"):
        assert sum(axes.axison for axes in figure_of(pictures[f"drive_{name}"].draw()).axes) >= 2


def test_contact_table_has_a_column_for_each_side(geometry: PairGeometry) -> None:
    table = contact_table(geometry)
    for side, row in zip(geometry.sides.values(), table.records(), strict=True):
        assert row["peak_to_peak"] == side.pair.transmission.peak_to_peak


@pytest.mark.parametrize(("units", "factor"), [("metric", 1e3), ("inch", 1.0 / 0.0254)])
def test_summary_holds_the_numbers_of_the_design(design: Design, tmp_path: Path, units: Any, factor: float) -> None:
    path = tmp_path / "summary.csv"
    write_summary(path, design, units)
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[0] == f"# mixed-ehl machine summary v1; design={PAIR}; units={units}"
    table = {(row["section"], row["name"]): row for row in csv.DictReader(lines[1:])}
    machine = design.pinion.convex.machine
    radial = table["machine", "radial_setting"]
    assert float(radial["pinion_convex"]) == pytest.approx(machine.radial_setting * factor, rel=1e-15)
    assert float(table["machine", "cradle_angle"]["gear_concave"]) == pytest.approx(
        np.degrees(design.gear.concave.machine.cradle_angle), rel=1e-15
    )
    assert table["cutter", "point_radius"]["unit"] == ("mm" if units == "metric" else "in")
    assert table["blank", "hand"]["pinion_concave"] == "left"
    assert int(table["blank", "teeth"]["gear_convex"]) == 39


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
    assert design.gear.flank("concave").lowest_fraction() == 0.0
    write_inspection_grid(path, design, "pinion", "concave", grid)
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[0] == f"# {FORMAT}; member=pinion; flank=concave; units=mm"
    table = pd.read_csv(path, comment="#")
    assert [*table] == ["row", "column", "x", "y", "z", "nx", "ny", "nz"]
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
    assert page.source.count("<svg") == 10
    assert "nan" not in page.text
    names = {path.stem for path in (tmp_path / "geometry").glob("*.png")}
    assert {"blank_section", "coast_ease_off_gear", "coast_contact_pattern_pinion", "coast_teeth_in_mesh"} <= names
    assert len(names) == 10
    assert {path.name for path in (tmp_path / "files").iterdir()} >= {
        "pinion.stl", "pinion_tooth_space.stl", "pinion_concave.csv", "pinion_convex.csv", "machine_summary.csv",
    }  # fmt: skip


def test_the_tour_shows_the_example_commands() -> None:
    page = TOUR.read_text(encoding="utf-8")
    for line in commands():
        assert line in page


def test_geometry_on_the_command_line(mixed_ehl: Cli) -> None:
    outcome = mixed_ehl("geometry", PAIR, "--json", "--side", "coast", "--marking", "8 um")
    assert outcome.code == 0
    result = json.loads(outcome.out)
    assert result["marking"] == pytest.approx(8e-6)
    assert list(result["sides"]) == ["coast"]
    assert result["sides"]["coast"]["pattern"]["area_share"] > 0.1
