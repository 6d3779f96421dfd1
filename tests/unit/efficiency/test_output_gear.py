"""What a gear run and the geometry of a pair leave behind: fields, figures, pages, workbooks, CSV, files."""

import csv
import json
import re
import shlex
from copy import copy
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from pages import read_page
from samples import BEVEL, tiny_mesh

from efficiency.conditions.grid import Grid
from efficiency.design.design import Design, load_design
from efficiency.geometry import pair_geometry as geometry_module
from efficiency.geometry.pair_geometry import PairGeometry, pair_geometry
from efficiency.loss.compare import Comparison
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.output import comparison_report as report
from efficiency.output.files import inspection_grid, write_inspection_grid
from efficiency.output.flank_map import FlankMap
from efficiency.output.gear_report import load_figures, loss_figures, mesh_figures, nearest_point
from efficiency.output.geometry_report import graded_notes, side_figures
from efficiency.output.machine_summary import summary_rows, write_summary
from efficiency.output.plots_load import map_figures
from efficiency.output.tables import carrying_points, efficiency_grids, efficiency_table
from ehl.common.errors import ConvergenceError
from ehl.common.figures import figure_of
from regression.formula import friction_model

TORQUES, SPEEDS, TEMPERATURES = (60.0, 150.0, 300.0), (60.0, 120.0, 240.0), (333.15, 363.15)
MODEL = friction_model("xu_kahraman_2007")
ROUGH = {"roughness_rms_pinion": 0.4e-6, "roughness_rms_gear": 0.3e-6}


@pytest.fixture(scope="module")
def result() -> EfficiencyResult:
    return tiny_mesh().load(300.0).efficiency(MODEL, load_balance="frictionless", **ROUGH)


def test_largest_film_ratio_is_that_of_points_that_carry_load(result: EfficiencyResult) -> None:
    """A point with a vanishing force, as at the end of a line, does not change it."""
    force = np.append(np.full(999, 1.0), [1e-9, 1e-12])
    assert list(carrying_points(force)) == [True] * 999 + [False] * 2
    at = carrying_points(result.points.force)
    assert result.points.force[at].sum() >= 0.999 * result.points.force.sum()
    shown = dict(zip(efficiency_table(result).names, efficiency_table(result).rows[0], strict=True))
    assert shown["film_ratio_max"] == result.lubrication.film_ratio[at].max() <= result.lubrication.film_ratio.max()


def test_results_are_equal_to_themselves_alone(result: EfficiencyResult, grid: Grid, comparison: Comparison) -> None:
    """Their arrays have no single truth value; the same for all results."""
    for found in (result, result.inputs, result.friction, grid, comparison):
        assert found in (found,)
        assert found != copy(found)
        assert len({found, copy(found)}) == 2


@pytest.fixture(scope="module")
def flank(result: EfficiencyResult) -> FlankMap:
    return FlankMap.of(BEVEL.flanks(), result)


@pytest.fixture(scope="module")
def grid() -> Grid:
    return tiny_mesh().map(MODEL, TORQUES, SPEEDS, TEMPERATURES, **ROUGH)


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    return tiny_mesh().load(300.0).compare([friction_model("constant:0.05"), MODEL])


def require_units(figure: Figure) -> None:
    """Every axis that has a name has a unit; so do colour bars."""
    shown = [axes for axes in figure.axes if axes.axison]
    labels = [label for axes in shown for label in (axes.get_xlabel(), axes.get_ylabel()) if label]
    assert len(labels) >= 2
    assert [label for label in labels if not re.search(r"\[[^\]]+\]", label)] == []


def test_loss_density_integrates_to_the_loss(flank: FlankMap, result: EfficiencyResult) -> None:
    lost = 0.0
    power = result.friction.mu * result.points.force * result.points.speed_sliding
    for value, k, i in zip(power, result.points.position, result.points.index, strict=True):
        edge = result.load.positions[k].position.edge
        if edge is None or not edge.touching[i]:
            lost += value / result.solution.positions
    assert np.nansum(flank.loss_density * flank.area) == pytest.approx(lost, rel=1e-12)
    assert 0.5 * result.power_loss < lost <= result.power_loss * (1.0 + 1e-12)


def test_sliding_is_the_rate_of_the_blank_coordinates(flank: FlankMap, result: EfficiencyResult) -> None:
    blank, step = flank.flanks.blank("gear"), 1e-7
    parts = [load.position for load in result.load.positions]
    places = np.concatenate([p.position for p in parts])
    vectors = [p.sliding_along[:, None] * p.along + p.sliding_across[:, None] * p.across for p in parts]
    ends = [places + sign * step * np.concatenate(vectors) for sign in (-1.0, 1.0)]
    (u0, h0), (u1, h1) = (blank.coordinates(np.hypot(e[:, 0], e[:, 1]), e[:, 2]) for e in ends)
    at = np.concatenate(flank.lines)
    speed = result.conditions.speed / (2.0 * step)
    for found, moved in zip(flank.sliding, (u1 - u0, h1 - h0), strict=True):
        np.testing.assert_allclose(found.ravel(), moved[at] * speed, rtol=1e-5, atol=1e-6)


def test_every_axis_has_its_unit(flank: FlankMap, result: EfficiencyResult, grid: Grid, comparison: Comparison) -> None:
    for picture in chain(load_figures(flank), loss_figures(flank), mesh_figures(result), map_figures(grid)):
        require_units(figure_of(picture.draw()))
    for figure in (report.plot_friction_along_mesh(comparison), report.plot_loss_along_mesh(comparison)):
        require_units(figure_of(figure))
    assert report.plot_run_time(comparison).get_xlabel().endswith("[s]")
    shown = report.plot_loss_by_region(comparison).axes[0].images[0].get_array()
    np.testing.assert_allclose(np.asarray(shown).sum(), 100.0)


def test_another_oil_and_what_lies_outside_the_range_are_said() -> None:
    grid = tiny_mesh().map(
        friction_model("75w90"), [300.0], [0.5, 20000.0 * np.pi / 30.0], [363.15], **ROUGH, oil="fva3"
    )
    shares = [point.outside_range_share for point in grid.results]
    assert shares[0] > shares[1]
    [table] = efficiency_grids(grid)
    assert f"at most {100.0 * shares[0]:.1f} %" in table.notes[0]
    assert [column.label for column in table.columns[1:]] == ["4.775 rpm", "20000 rpm"]
    assert sum("was fitted to 75w90, not to fva3" in note for note in grid.results[0].notes) == 1


def test_workbook_and_csv_hold_the_result(result: EfficiencyResult, tmp_path: Path) -> None:
    result.write(xlsx=tmp_path / "r.xlsx", csv=tmp_path / "csv")
    single = pd.read_excel(tmp_path / "r.xlsx", "result", header=None, index_col=0)
    assert [*single.loc["efficiency"]] == [pytest.approx(100.0 * result.efficiency, rel=1e-14), "%"]
    points, positions = (pd.read_excel(tmp_path / "r.xlsx", name) for name in ("points", "positions"))
    assert {"pressure_hertz [GPa]", "temperature_bulk_1 [degC]", "film_central [nm]"} < set(points)
    np.testing.assert_allclose(points["friction_coefficient"], result.friction.mu, rtol=1e-14)
    assert points["power_loss [W]"].sum() / result.solution.positions == pytest.approx(result.power_loss, rel=1e-12)
    np.testing.assert_allclose(positions["power_loss [W]"], result.cycle.power_loss, rtol=1e-14)
    np.testing.assert_allclose(positions.filter(like="share of pair").sum(axis=1), 1.0)
    table = pd.read_csv(tmp_path / "csv" / "points.csv")
    assert [name.split(" [")[0] for name in table] == [name.split(" [")[0] for name in points]
    assert {"pressure_hertz [Pa]", "temperature_bulk_1 [K]", "film_central [m]"} < set(table)
    np.testing.assert_allclose(table["force [N]"], result.points.force, rtol=1e-14)
    for of_points in (table, points):  # numbered as in the notes, without a unit
        assert list(of_points["mesh position"]) == list(result.points.position + 1)


@pytest.mark.usefixtures("svg_figures")
def test_page_of_a_point_and_of_a_map(grid: Grid, tmp_path: Path) -> None:
    grid.write(report=tmp_path / "map.html", xlsx=tmp_path / "map.xlsx")
    page = read_page(tmp_path / "map.html")
    assert page.source.count("<svg") > 20
    chosen = nearest_point(grid)
    assert (chosen.conditions.torque, chosen.conditions.speed, chosen.conditions.temperature) == (300.0, 120.0, 363.15)
    # the result with its interval and the error of the solution in the first section
    ends = ("", "_lower", "_upper", "_error")
    value, low, high, error = (100.0 * getattr(chosen, f"efficiency{end}") for end in ends)
    for text in (f"{value:.2f} %", f"{low:.1f} to {high:.1f} %", f"± {error:.1g} %"):
        assert text in page.sections[0]
    assert all(f"{100.0 * point.efficiency:.3f}" in page.text for point in grid.results)
    losses = pd.read_excel(tmp_path / "map.xlsx", "map")["power_loss [W]"]
    np.testing.assert_allclose(losses, grid.values("power_loss").ravel(), rtol=1e-14)
    cells = pd.read_excel(tmp_path / "map.xlsx", "efficiency at 90 degC", index_col=0)
    np.testing.assert_allclose(cells, 100.0 * grid.values()[:, :, 1], rtol=1e-14)


def test_a_wild_interval_does_not_ruin_the_chart(comparison: Comparison) -> None:
    first = comparison.rows[0]
    wild = replace(first, name="wild", efficiency=0.98, efficiency_lower=-0.49, efficiency_upper=0.985)
    axes = report.plot_comparison(replace(comparison, rows=(*comparison.rows, wild)))
    # an arrow at the end of the axis of the others
    assert sum(line.get_marker() == ">" for line in axes.lines) == 1
    assert report.axis_limit(np.array([1.0, 1.2, np.nan, 150.0])) == 1.2
    assert report.axis_limit(np.array([np.nan])) == 1.0


def test_comparison_as_page_and_tables(comparison: Comparison, tmp_path: Path) -> None:
    comparison.write(plot=tmp_path / "c.svg", report=tmp_path / "c.html", xlsx=tmp_path / "c.xlsx")
    assert all(row.label in read_page(tmp_path / "c.html").text for row in comparison.rows)
    sheets = pd.read_excel(tmp_path / "c.xlsx", sheet_name=None)
    np.testing.assert_allclose(sheets["models"]["efficiency [%]"], [100.0 * row.efficiency for row in comparison.rows])
    regions = sheets["share of loss by region"].set_index(sheets["share of loss by region"].columns[0])
    np.testing.assert_allclose(regions.sum(axis=1), 100.0, rtol=1e-12)


def test_rating_sheet_of_a_design(mixed_ehl: Any, tmp_path: Path) -> None:
    outcome = mixed_ehl("gear", "fh_hypoid_9x34", "--rating", "--torque", "200 N m", "--json")
    rated = json.loads(outcome.out)
    assert rated["inputs"]["torque"] == 200.0
    assert min(rated[side]["safety_root"][member] for side in ("drive", "coast") for member in (0, 1)) > 1.0


EXAMPLE = Path(__file__).resolve().parents[3] / "docs" / "examples" / "gear_geometry.sh"


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


def test_example_commands_run(mixed_ehl: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_geometry_on_the_command_line(mixed_ehl: Any) -> None:
    outcome = mixed_ehl("geometry", BEVEL.name, "--json", "--side", "coast", "--marking", "8 um")
    result = json.loads(outcome.out)
    assert (result["marking"], list(result["sides"])) == (pytest.approx(8e-6), ["coast"])
