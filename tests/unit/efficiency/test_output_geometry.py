"""Geometry of a pair as tables, figures, page and files: what they say agrees with the design and with each other."""

import csv
import json
import re
import shlex
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pages import read_page

from efficiency.design.design import Design, load_design
from efficiency.geometry import pair_geometry as geometry_module
from efficiency.geometry.pair_geometry import PairGeometry, pair_geometry
from efficiency.output.files import FORMAT, inspection_grid, write_inspection_grid
from efficiency.output.geometry_report import contact_table, graded_notes, misalignment_text, side_figures
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
    notes = geometry.notes
    assert any("pinion concave flank ends" in note for note in notes)
    # the pinion settings of this pair define the flanks only; the gear is cut to its root cone
    assert any("pinion convex flank: the blade tips" in note for note in notes)
    for name in ("gear_concave", "gear_convex"):
        root = geometry.flanks[name].root_error
        assert root is not None
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
    assert told.text.endswith("coast flank ends")


def drawn(figure: Figure) -> Iterator[Axes]:
    figure.canvas.draw()
    yield from (axes for axes in figure.axes if axes.axison)


def test_every_axis_has_a_name_and_a_unit(geometry: PairGeometry, design: Design) -> None:
    figures = [figure_of(shown.draw()) for side in geometry.sides.values() for shown in side_figures(side)]
    for figure in [*figures, blank_figure(design)]:
        for axes in drawn(figure):
            labels = [axes.get_xlabel(), axes.get_ylabel()]
            if axes.get_label() == "<colorbar>":
                labels = [label for label in labels if label]
                assert labels
            for label in labels:
                assert re.search(r"\[[^\]]+\]", label), label


def test_figures_of_an_undercut_hypoid_pair() -> None:
    found = pair_geometry(load_design("fh_hypoid_9x34"), ("drive",))
    assert any("undercut" in note.text for note in graded_notes(found))
    pictures = {picture.name: picture for picture in side_figures(found.sides["drive"])}
    for name in ("teeth_in_mesh", "ease_off_pinion", "contact_pattern_gear"):
        assert len(list(drawn(figure_of(pictures[f"drive_{name}"].draw())))) >= 2


def test_contact_table_has_a_column_for_each_side(geometry: PairGeometry) -> None:
    table = contact_table(geometry)
    for side, row in zip(geometry.sides.values(), table.records(), strict=True):
        assert row["peak_to_peak"] == side.pair.transmission.peak_to_peak
    assert "arcsec" in table.html()


def test_misalignment_in_words(design: Design) -> None:
    assert misalignment_text(design) == "aligned"
    moved = design.with_misalignment(E=1e-4, shaft_angle_error=np.radians(0.05))
    assert misalignment_text(moved) == "misaligned: E +0.1 mm, shaft_angle_error +0.05 deg"


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
    assert table["machine", "radial_setting"]["unit"] == ("mm" if units == "metric" else "in")
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


def test_grid_file_is_the_flank(design: Design, tmp_path: Path) -> None:
    flank = design.gear.flank("convex")
    grid = inspection_grid(flank, 5, 9, margin=0.08)
    path = tmp_path / "gear_convex.csv"
    write_inspection_grid(path, design, "gear", "convex", grid)
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[0] == f"# {FORMAT}; member=gear; flank=convex; units=mm"
    assert lines[2] == "row,column,x,y,z,nx,ny,nz"
    table = np.loadtxt(lines[3:], delimiter=",")
    assert table.shape == (45, 8)
    u, h = flank.blank.coordinates(np.hypot(table[:, 2], table[:, 3]) * 1e-3, table[:, 4] * 1e-3)
    on_flank, _ = flank.solve(np.real(u), np.real(h))
    np.testing.assert_allclose(table[:, 2:5].T * 1e-3, on_flank.position, atol=2e-12)
    np.testing.assert_allclose(table[:, 5:].T, on_flank.normal, atol=1e-9)
    rows, columns = table[:, 0].reshape(5, 9), table[:, 1].reshape(5, 9)
    assert (np.diff(rows, axis=0) == 1.0).all()
    assert (np.diff(columns, axis=1) == 1.0).all()
    # row 1 at the root, column 1 at the heel
    assert (np.diff(np.real(h).reshape(5, 9), axis=0) > 0.0).all()
    assert (np.diff(np.real(u).reshape(5, 9), axis=1) < 0.0).all()


def test_normals_of_the_grid_point_out_of_the_tooth(design: Design) -> None:
    """Both flanks of a gear slot face each other."""
    concave, convex = (inspection_grid(design.gear.flank(side), 3, 3) for side in ("concave", "convex"))
    across = convex.position[:, 1, 1] - concave.position[:, 1, 1]
    assert across @ concave.normal[:, 1, 1] > 0.0
    assert across @ convex.normal[:, 1, 1] < 0.0


def test_grid_starts_where_the_flank_does(design: Design) -> None:
    flank = design.pinion.flank("concave")
    lowest = flank.lowest_fraction()
    grid = inspection_grid(flank, 7, 11)
    assert 0.0 < lowest == grid.lowest < 0.1
    assert np.isfinite(grid.position).all()
    assert design.gear.flank("concave").lowest_fraction() == 0.0


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
    for words in ("machine root angle", "Ease-off", "mixed-ehl", "1. Drive side"):
        assert words in page.text
    assert "arcsec transmission error without load, drive" in page.sections[0]
    assert "the mating tip would reach it" in page.sections[0]
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
    table = mixed_ehl("geometry", PAIR, "--side", "drive", "--units", "inch")
    for words in ("machine root angle", "transmission error", "contact ratio", "[deg]", "4.50702"):
        assert words in table.out
