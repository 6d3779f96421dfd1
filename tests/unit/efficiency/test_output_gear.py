"""What a gear run leaves behind: fields over the flank, figures, page, workbook, CSV, each against the result."""

import csv
import json
import re
from collections.abc import Callable
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from openpyxl import load_workbook
from pages import read_page

from efficiency.conditions.grid import Grid
from efficiency.design.design import Design, load_design
from efficiency.geometry.pair_geometry import geometry_notes
from efficiency.loss.compare import Comparison, compare_models
from efficiency.loss.efficiency import mesh_efficiency
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.loss.kinematics import Operation
from efficiency.ltca.mesh_grids import load_grids
from efficiency.mesh import Mesh
from efficiency.output.comparison_report import (
    axis_limit,
    plot_comparison,
    plot_friction_along_mesh,
    plot_loss_along_mesh,
    plot_loss_by_region,
    plot_run_time,
)
from efficiency.output.flank_map import FlankMap
from efficiency.output.gear_report import load_figures, loss_figures, mesh_figures
from efficiency.output.map_report import nearest_point
from efficiency.output.plots_load import contour_figure, map_figures
from efficiency.output.tables import (
    comparison_table,
    comparison_tables,
    efficiency_grids,
    efficiency_table,
    map_tables,
    position_table,
    range_table,
    result_tables,
)
from ehl.common.errors import InputError
from ehl.common.figures import figure_of
from ehl.fluid.oil import Oil
from regression.formula import friction_model

OIL = Oil.load("75w90")
TORQUES, SPEEDS, TEMPERATURES = (60.0, 150.0, 300.0), (60.0, 120.0, 240.0), (333.15, 363.15)
Meshed = tuple[Design, Any]


def operation(speed: float = 125.0, temperature: float = 363.15) -> Operation:
    return Operation(speed, temperature, 0.4e-6, 0.3e-6)


@pytest.fixture(scope="module")
def geared() -> Meshed:
    design = load_design("fm_spiral_bevel_14x39")
    return design, Mesh.of(design, "drive", 6, 9, keep=True)


@pytest.fixture(scope="module")
def result(geared: Meshed) -> EfficiencyResult:
    loaded = geared[1].load(300.0)
    found = mesh_efficiency(loaded.grids, friction_model("xu_kahraman_2007"), OIL, operation())
    return replace(found, case=replace(found.case, mesh=loaded))


@pytest.fixture(scope="module")
def flank(geared: Meshed, result: EfficiencyResult) -> FlankMap:
    return FlankMap.of(geared[0].flanks(), result)


@pytest.fixture(scope="module")
def grid(geared: Meshed) -> Grid:
    model = friction_model("xu_kahraman_2007")
    rough = {"roughness_rms_pinion": 0.4e-6, "roughness_rms_gear": 0.3e-6}
    return geared[1].map(model, TORQUES, SPEEDS, TEMPERATURES, **rough)


@pytest.fixture(scope="module")
def comparison(geared: Meshed) -> Comparison:
    models = [friction_model("constant:0.05"), friction_model("xu_kahraman_2007")]
    return compare_models(load_grids(geared[1].grids, 300.0), models, OIL, operation(), geared[1].pitch)


def require_units(figure: Figure) -> None:
    """Every axis names its quantity and unit; so do colour bars."""
    labels = 0
    for axes in figure.axes:
        if not axes.axison:
            continue
        shared = bool(axes.get_shared_y_axes().get_siblings(axes)[1:]) or bool(axes.get_ylabel())
        assert shared
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            if label:
                labels += 1
                assert re.search(r"\[[^\]]+\]", label), label
    assert labels >= 2


def test_loss_density_integrates_to_the_loss(flank: FlankMap, result: EfficiencyResult) -> None:
    lost = 0.0
    power = result.friction.mu * result.points.force * result.points.speed_sliding
    for value, k, i in zip(power, result.points.position, result.points.index, strict=True):
        edge = result.load.positions[k].position.edge
        if edge is None or not edge.touching[i]:
            lost += value / result.solution.positions
    assert np.nansum(flank.loss_density * flank.area) == pytest.approx(lost, rel=1e-12)
    assert 0.5 * result.power_loss < lost <= result.power_loss * (1.0 + 1e-12)


def test_sliding_in_the_projection_is_the_rate_of_the_blank_coordinates(
    flank: FlankMap, result: EfficiencyResult
) -> None:
    blank, step = flank.flanks.blank("gear"), 1e-7
    along, up = flank.sliding
    places = np.concatenate([load.position.position for load in result.load.positions])
    vectors = np.concatenate(
        [
            p.sliding_along[:, None] * p.along + p.sliding_across[:, None] * p.across
            for p in (load.position for load in result.load.positions)
        ]
    )
    ends = [places + sign * step * vectors for sign in (-1.0, 1.0)]
    (u0, h0), (u1, h1) = (blank.coordinates(np.hypot(e[:, 0], e[:, 1]), e[:, 2]) for e in ends)
    at = np.concatenate(flank.lines)
    speed = result.conditions.speed / (2.0 * step)
    np.testing.assert_allclose(along.ravel(), (u1 - u0)[at] * speed, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(up.ravel(), (h1 - h0)[at] * speed, rtol=1e-5, atol=1e-6)


def test_lines_follow_each_other_over_the_flank(flank: FlankMap) -> None:
    assert np.all(np.diff(flank.roll) > 0.0)
    u, h = flank.place("gear")
    blank = flank.flanks.blank("gear")
    assert np.all(np.abs(u) <= 0.5 * blank.face_width * (1.0 + 1e-9))
    assert np.all(h >= blank.root(u) - 1e-9)
    assert np.all(h <= blank.tip(u) + 1e-9)
    assert np.nanmax(flank.local("temperature_flash")) == np.max(flank.result.lubrication.temperature_flash)


def test_every_axis_has_its_unit(flank: FlankMap, result: EfficiencyResult, grid: Grid, comparison: Comparison) -> None:
    names = []
    for picture in chain(load_figures(flank), loss_figures(flank), mesh_figures(result), map_figures(grid)):
        require_units(figure_of(picture.draw()))
        assert picture.caption.endswith(".")
        names.append(picture.name)
    assert len(set(names)) == len(names)
    for figure in (plot_friction_along_mesh(comparison), plot_loss_along_mesh(comparison)):
        require_units(figure)
    assert plot_run_time(comparison).axes[0].get_xlabel().endswith("[s]")
    shown = plot_loss_by_region(comparison).axes[0].images[0].get_array()
    assert shown is not None
    np.testing.assert_allclose(np.asarray(shown).sum(), 100.0)


def test_contours_hold_the_map(grid: Grid) -> None:
    figure = contour_figure(grid, "power_loss")
    low, high = figure.axes[0].collections[0].get_clim()
    assert low <= grid.values("power_loss").min()
    assert high >= grid.values("power_loss").max()


def test_another_oil_and_what_lies_outside_the_range_are_said(geared: Meshed, tmp_path: Path) -> None:
    mesh, rough = geared[1], {"roughness_rms_pinion": 0.4e-6, "roughness_rms_gear": 0.3e-6, "oil": "fva3"}
    grid = mesh.map(friction_model("75w90"), [300.0], [0.5, 125.0], [363.15], strength=True, **rough)
    shares = [point.outside_range_share for point in grid.results]
    assert shares[0] > shares[1]
    [table] = efficiency_grids(grid)
    assert f"at most {100.0 * shares[0]:.1f} % of the sliding power, at 300" in table.notes[0]
    other = [note for note in grid.results[0].notes if "was fitted to 75w90, not to fva3" in note]
    assert len(other) == 1
    assert not any("was fitted to" in note for note in mesh.load(300.0).efficiency("75w90", oil="75w90").notes)
    grid.report(tmp_path / "map.html")
    page = read_page(tmp_path / "map.html")
    # both on the first screen: how much lies outside, at how many points and where most; and that the oil is another
    assert "was fitted to 75w90, not to fva3" in page.sections[0]
    assert f"{100.0 * shares[0]:.1f} % of the sliding power lies outside the range of formula 75w90" in page.sections[0]
    assert "2 of 2; worst: 300 N m, " in page.sections[0]
    assert table.notes[0] in page.text


def sheet_rows(path: Path, name: str) -> list[tuple[Any, ...]]:
    book = load_workbook(path, read_only=True)
    rows = list(book[name].iter_rows(values_only=True))
    book.close()
    return rows


def test_workbook_and_csv_hold_the_result(result: EfficiencyResult, tmp_path: Path) -> None:
    result.write(plot=tmp_path / "figures", xlsx=tmp_path / "r.xlsx", csv=tmp_path / "csv")
    single = {row[0]: row[1:] for row in sheet_rows(tmp_path / "r.xlsx", "result")}
    assert single["efficiency"] == (pytest.approx(100.0 * result.efficiency, rel=1e-14), "%")
    assert single["friction_model"] == ("xu_kahraman_2007", "")
    pressure = pytest.approx(result.friction_range.ranges["pressure_hertz"][1] / 1e9, rel=1e-14)
    assert single["pressure_hertz (maximum)"] == (pressure, "GPa")
    header, *points = sheet_rows(tmp_path / "r.xlsx", "points")
    assert len(points) == result.solution.points_loaded
    column = {name: np.array([row[k] for row in points]) for k, name in enumerate(header)}
    for name in ("pressure_hertz [GPa]", "radius_equivalent [mm]", "temperature_bulk_1 [degC]", "film_central [nm]"):
        assert name in column
    np.testing.assert_allclose(column["friction_coefficient"], result.friction.mu, rtol=1e-14)
    assert column["power_loss [W]"].sum() / result.solution.positions == pytest.approx(result.power_loss, rel=1e-12)
    position, *rows = sheet_rows(tmp_path / "r.xlsx", "positions")
    lost = [row[position.index("power_loss [W]")] for row in rows]
    np.testing.assert_allclose(lost, result.cycle.power_loss, rtol=1e-14)
    shares = [k for k, name in enumerate(position) if name.startswith("share of pair")]
    np.testing.assert_allclose([sum(row[k] for k in shares) for row in rows], 1.0)
    with (tmp_path / "csv" / "points.csv").open(encoding="utf-8", newline="") as file:
        table = list(csv.reader(file))
    assert [name.split(" [")[0] for name in table[0]] == [name.split(" [")[0] for name in header]
    assert {"pressure_hertz [Pa]", "temperature_bulk_1 [K]", "film_central [m]"} < set(table[0])
    at = table[0].index("force [N]")
    np.testing.assert_allclose([float(row[at]) for row in table[1:]], result.points.force, rtol=1e-14)
    stems = {path.stem for path in (tmp_path / "csv").iterdir()}
    assert stems > {"result", "uncertainty", "remarks", "positions", "points"}
    assert len(list((tmp_path / "figures").glob("*.png"))) == 17


@pytest.mark.usefixtures("svg_figures")
def test_page_of_a_point_and_of_a_map(geared: Meshed, grid: Grid, tmp_path: Path) -> None:
    grid.write(report=tmp_path / "map.html", xlsx=tmp_path / "map.xlsx")
    page = read_page(tmp_path / "map.html")
    text = page.text
    assert page.source.count("<svg") == 4 + 15 + 2 + 1 + 1
    # undercut and roots are no matter of the loaded flanks: the page has to say them all the same
    told = geometry_notes(geared[0], "drive")
    assert any("the blade tips leave a root up to" in note for note in told)
    roots = max(re.findall(r"a root up to ([\d.]+) mm above the root cone", " ".join(told)), key=float)
    assert f"a root up to {roots} mm above the root cone" in page.sections[0]
    chosen = nearest_point(grid)
    assert (chosen.conditions.torque, chosen.conditions.speed, chosen.conditions.temperature) == (300.0, 120.0, 363.15)
    # the answer with its interval and the error of the solution on the first screen
    low, high = 100.0 * chosen.efficiency_lower, 100.0 * chosen.efficiency_upper
    assert page.sections[0].index(f"{100.0 * chosen.efficiency:.2f} %") < page.sections[0].index("warning")
    assert f"{low:.1f} to {high:.1f} %" in page.sections[0]
    assert f"± {100.0 * chosen.efficiency_error:.1g} %" in page.sections[0]
    for text_of_point in (f"{100.0 * r.efficiency:.3f}" for r in grid.results):
        assert text_of_point in text
    assert page.sections[0].count("edges carry") == 1
    assert page.sections[-1].startswith(f"{len(page.sections) - 1}. Method")
    header, *rows = sheet_rows(tmp_path / "map.xlsx", "map")
    losses = [row[header.index("power_loss [W]")] for row in rows]
    np.testing.assert_allclose(losses, grid.values("power_loss").ravel(), rtol=1e-14)
    cells = sheet_rows(tmp_path / "map.xlsx", "efficiency at 90 degC")
    np.testing.assert_allclose([row[1:] for row in cells[1:]], 100.0 * grid.values()[:, :, 1], rtol=1e-14)


def test_a_wild_interval_does_not_ruin_the_chart(comparison: Comparison) -> None:
    first = comparison.rows[0]
    wild = replace(first, name="wild", efficiency=0.98, efficiency_lower=-0.49, efficiency_upper=0.985)
    axes = plot_comparison(replace(comparison, rows=(*comparison.rows, wild)))
    alone = plot_comparison(comparison)
    assert axes.get_xlim()[1] < 2.5 * alone.get_xlim()[1]
    # an arrow at the end of the axis of the others, with the numbers said
    (label,) = [text.get_text() for text in axes.texts if "98.00" in text.get_text()]
    assert "-49 to 98.5 %" in label
    assert sum(line.get_marker() == ">" for line in axes.lines) == 1
    assert axis_limit(np.array([1.0, 1.2, np.nan, 150.0])) == 1.2
    assert axis_limit(np.array([np.nan])) == 1.0


def test_comparison_as_page_and_tables(comparison: Comparison, tmp_path: Path) -> None:
    comparison.write(plot=tmp_path / "c.svg", report=tmp_path / "c.html", xlsx=tmp_path / "c.xlsx")
    page = read_page(tmp_path / "c.html")
    for row in comparison.rows:
        assert row.label in page.text
    # one row for a kind of note, however many models have it
    assert page.sections[0].count("edges carry") == 1
    found = [row.efficiency for row in comparison.rows if row.kind == "mesh"]
    assert f"{100.0 * min(found):.2f} to {100.0 * max(found):.2f} %" in page.sections[0]
    header, *rows = sheet_rows(tmp_path / "c.xlsx", "models")
    assert [row[header.index("efficiency [%]")] for row in rows] == pytest.approx(
        [100.0 * r.efficiency for r in comparison.rows]
    )
    header, *rows = sheet_rows(tmp_path / "c.xlsx", "friction along the mesh")
    at = header.index("constant:0.05")
    np.testing.assert_allclose([row[at] for row in rows], 0.05, rtol=1e-12)
    header, *rows = sheet_rows(tmp_path / "c.xlsx", "share of loss by region")
    np.testing.assert_allclose([sum(row[1:]) for row in rows], 100.0, rtol=1e-12)
    assert len(comparison_table(comparison).rows) == len(comparison.rows)


def test_terminal_names_models_and_notes_as_the_page_does(
    result: EfficiencyResult,
    comparison: Comparison,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # so wide that no label is broken over two lines
    monkeypatch.setenv("COLUMNS", "300")
    comparison.show()
    shown = capsys.readouterr().out
    for row in comparison.rows:
        assert row.label in shown
    assert "constant:0.05" not in shown
    assert "xu_kahraman_2007" not in shown
    # a row for a kind of note, however many models have it
    assert shown.count("edges carry") == 1
    assert re.search(rf"warning, {len(comparison.results)} of {len(comparison.results)} .*edges carry", shown)
    notes = [line.split()[0].rstrip(",") for line in shown.splitlines() if re.search(r", (\d+ of \d+|all cases)", line)]
    assert notes == sorted(notes, key=["fault", "warning", "for"].index)
    result.show()
    shown = capsys.readouterr().out
    assert "friction: Xu & Kahraman 2007" in shown
    assert shown.count("edges carry") == 1


def test_tables_for_the_page(result: EfficiencyResult) -> None:
    low, high = range_table(result).records()
    assert (low["end"], high["end"]) == ("minimum", "maximum")
    assert low["pressure_hertz"] == pytest.approx(result.friction_range.ranges["pressure_hertz"][0])
    assert high["pressure_hertz"] == pytest.approx(result.pressure_hertz_max)
    assert f"<td>{high['pressure_hertz'] / 1e9:.3f}</td>" in range_table(result).html()
    positions = position_table(result).records()
    assert [row["power_loss"] for row in positions] == list(result.cycle.power_loss)
    mean = np.average([row["friction_coefficient_mean"] for row in positions], weights=_sliding_work(result))
    assert mean == pytest.approx(result.friction_coefficient_mean, rel=1e-9)
    (row,) = efficiency_table(result).records()
    assert row["efficiency"] == result.efficiency
    assert row["temperature_flash"] == np.nanmax(result.lubrication.temperature_flash)


def _sliding_work(result: EfficiencyResult) -> Any:
    points = result.points
    return np.bincount(points.position, points.force * points.speed_sliding)


def test_grids_hold_the_efficiencies(grid: Grid) -> None:
    for number, table in enumerate(efficiency_grids(grid)):
        np.testing.assert_array_equal([row[1:] for row in table.rows], grid.values()[:, :, number])


def test_tables_have_units_in_their_heads(result: EfficiencyResult, grid: Grid, comparison: Comparison) -> None:
    plain = re.compile(r"(angle|_gear|_pinion|_oil|_hertz|_loss|_max|force|length|speed|torque|radius|film_central)$")
    for table in chain(result_tables(result), map_tables(grid), comparison_tables(comparison)):
        assert table.rows
        head = next(csv.reader(table.csv().splitlines()))
        assert [name for name in head if plain.search(name)] == []


def test_a_path_that_cannot_be_written(result: EfficiencyResult, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for kind, place in (("xlsx", tmp_path / "file" / "t.xlsx"), ("csv", tmp_path / "file")):
        with pytest.raises(InputError) as error:
            result.write(**{kind: place})
        assert error.value.field == kind


def test_a_load_from_a_file_has_no_uncertainty(mixed_ehl: Callable[..., Any]) -> None:
    outcome = mixed_ehl("gear", "fm_spiral_bevel_14x39", "--load-from", "load.csv", "--uncertainty")
    assert outcome.code == 2
    assert "--uncertainty" in outcome.err


def test_rating_sheet_of_a_design(mixed_ehl: Callable[..., Any], tmp_path: Path) -> None:
    outcome = mixed_ehl("gear", "fh_hypoid_9x34", "--rating", "--torque", "200 N m", "--json")
    rated = json.loads(outcome.out)
    assert rated["inputs"]["torque"] == 200.0
    assert min(rated[side]["safety_root"][member] for side in ("drive", "coast") for member in (0, 1)) > 1.0
    for arguments in (("--rating", "--side", "coast"), ("--rating", "--E", "0.1 mm"), ("--spectrum", "duty.csv")):
        assert mixed_ehl("gear", "fh_hypoid_9x34", *arguments).code == 2
