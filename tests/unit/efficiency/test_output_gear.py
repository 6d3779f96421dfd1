"""What a gear run leaves behind: fields over the flank, figures, page, workbook, CSV, each against the result."""

import csv
import json
import re
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from pages import read_page

from efficiency.conditions.grid import Grid
from efficiency.design.design import Design, load_design
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
from efficiency.output.gear_report import load_figures, loss_figures, mesh_figures, nearest_point
from efficiency.output.plots_load import map_figures
from efficiency.output.tables import comparison_tables, efficiency_grids, map_tables, result_tables
from ehl.common.figures import figure_of
from ehl.fluid.oil import Oil
from regression.formula import friction_model

OIL = Oil.load("75w90")
TORQUES, SPEEDS, TEMPERATURES = (60.0, 150.0, 300.0), (60.0, 120.0, 240.0), (333.15, 363.15)
MODEL, OPERATION = friction_model("xu_kahraman_2007"), Operation(125.0, 363.15, 0.4e-6, 0.3e-6)
ROUGH = {"roughness_rms_pinion": 0.4e-6, "roughness_rms_gear": 0.3e-6}
Meshed = tuple[Design, Any]


@pytest.fixture(scope="module")
def geared() -> Meshed:
    design = load_design("fm_spiral_bevel_14x39")
    return design, Mesh.of(design, "drive", 6, 9, keep=True)


@pytest.fixture(scope="module")
def result(geared: Meshed) -> EfficiencyResult:
    loaded = geared[1].load(300.0)
    found = mesh_efficiency(loaded.grids, MODEL, OIL, OPERATION)
    return replace(found, case=replace(found.case, mesh=loaded))


@pytest.fixture(scope="module")
def flank(geared: Meshed, result: EfficiencyResult) -> FlankMap:
    return FlankMap.of(geared[0].flanks(), result)


@pytest.fixture(scope="module")
def grid(geared: Meshed) -> Grid:
    return geared[1].map(MODEL, TORQUES, SPEEDS, TEMPERATURES, **ROUGH)


@pytest.fixture(scope="module")
def comparison(geared: Meshed) -> Comparison:
    models = [friction_model("constant:0.05"), MODEL]
    return compare_models(load_grids(geared[1].grids, 300.0), models, OIL, OPERATION, geared[1].pitch)


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
    for figure in (plot_friction_along_mesh(comparison), plot_loss_along_mesh(comparison)):
        require_units(figure)
    assert plot_run_time(comparison).axes[0].get_xlabel().endswith("[s]")
    shown = plot_loss_by_region(comparison).axes[0].images[0].get_array()
    np.testing.assert_allclose(np.asarray(shown).sum(), 100.0)


def test_another_oil_and_what_lies_outside_the_range_are_said(geared: Meshed) -> None:
    grid = geared[1].map(friction_model("75w90"), [300.0], [0.5, 125.0], [363.15], **ROUGH, oil="fva3")
    shares = [point.outside_range_share for point in grid.results]
    assert shares[0] > shares[1]
    [table] = efficiency_grids(grid)
    assert f"at most {100.0 * shares[0]:.1f} %" in table.notes[0]
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


@pytest.mark.usefixtures("svg_figures")
def test_page_of_a_point_and_of_a_map(grid: Grid, tmp_path: Path) -> None:
    grid.write(report=tmp_path / "map.html", xlsx=tmp_path / "map.xlsx")
    page = read_page(tmp_path / "map.html")
    assert page.source.count("<svg") > 20
    chosen = nearest_point(grid)
    assert (chosen.conditions.torque, chosen.conditions.speed, chosen.conditions.temperature) == (300.0, 120.0, 363.15)
    # the result with its interval and the error of the solution in the first section
    value, low, high, error = (
        100.0 * getattr(chosen, f"efficiency{end}") for end in ("", "_lower", "_upper", "_error")
    )
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
    axes = plot_comparison(replace(comparison, rows=(*comparison.rows, wild)))
    # an arrow at the end of the axis of the others
    assert sum(line.get_marker() == ">" for line in axes.lines) == 1
    assert axis_limit(np.array([1.0, 1.2, np.nan, 150.0])) == 1.2
    assert axis_limit(np.array([np.nan])) == 1.0


def test_comparison_as_page_and_tables(comparison: Comparison, tmp_path: Path) -> None:
    comparison.write(plot=tmp_path / "c.svg", report=tmp_path / "c.html", xlsx=tmp_path / "c.xlsx")
    assert all(row.label in read_page(tmp_path / "c.html").text for row in comparison.rows)
    sheets = pd.read_excel(tmp_path / "c.xlsx", sheet_name=None)
    np.testing.assert_allclose(sheets["models"]["efficiency [%]"], [100.0 * row.efficiency for row in comparison.rows])
    regions = sheets["share of loss by region"].set_index(sheets["share of loss by region"].columns[0])
    np.testing.assert_allclose(regions.sum(axis=1), 100.0, rtol=1e-12)


def test_tables_have_units_in_their_heads(result: EfficiencyResult, grid: Grid, comparison: Comparison) -> None:
    plain = re.compile(r"(angle|_gear|_pinion|_oil|_hertz|_loss|_max|force|length|speed|torque|radius|film_central)$")
    for table in chain(result_tables(result), map_tables(grid), comparison_tables(comparison)):
        assert table.rows
        head = next(csv.reader(table.csv().splitlines()))
        assert [name for name in head if plain.search(name)] == []


def test_rating_sheet_of_a_design(mixed_ehl: Any, tmp_path: Path) -> None:
    outcome = mixed_ehl("gear", "fh_hypoid_9x34", "--rating", "--torque", "200 N m", "--json")
    rated = json.loads(outcome.out)
    assert rated["inputs"]["torque"] == 200.0
    assert min(rated[side]["safety_root"][member] for side in ("drive", "coast") for member in (0, 1)) > 1.0
    load = ("--load-from", "load.csv", "--uncertainty")
    for arguments in (("--rating", "--side", "coast"), ("--rating", "--E", "0.1 mm"), ("--spectrum", "duty.csv"), load):
        assert mixed_ehl("gear", "fh_hypoid_9x34", *arguments).code == 2
