"""Loaded tooth contact of real pairs: balance, optimality, limits, convergence, an independent solver, edges."""

import math
from dataclasses import replace

import numpy as np
import pytest

from efficiency.contact.contact_lines import MeshPosition, mesh_cycle
from efficiency.contact.mesh_surface import EDGES
from efficiency.design.design import load_design
from efficiency.ltca.limits import edge_load, limit_notes
from efficiency.ltca.load_distribution import (
    ElasticPosition,
    LoadDistribution,
    distribute_load,
    elastic_cycle,
    loads_of_forces,
    weber_local,
)
from efficiency.ltca.mesh_grids import load_grids
from efficiency.mesh import Mesh

DESIGN = load_design("fm_spiral_bevel_14x39")


@pytest.fixture(scope="module")
def geared() -> Mesh:
    return Mesh.of(DESIGN, "drive", 8, 15, keep=True)


@pytest.fixture(scope="module")
def load(geared: Mesh) -> LoadDistribution:
    return load_grids(geared.grids, 300.0).fine


@pytest.fixture(scope="module")
def crowded(geared: Mesh) -> ElasticPosition:
    return max(geared.grids.elastic_fine, key=lambda p: np.unique(p.position.pair).size)


@pytest.mark.parametrize("torque", [0.1, 3.0, 300.0, 3000.0])
def test_balance_and_optimality(geared: Mesh, torque: float) -> None:
    """Sum of loads and all conditions of contact to 1e-10, written out anew."""
    mesh = load_grids(geared.grids, torque)
    for p, elastic in zip(mesh.fine.positions, mesh.mesh.elastic_fine, strict=True):
        at, loaded = p.position, p.force > 0.0
        assert p.force @ at.lever_pinion == pytest.approx(torque, rel=1e-10)
        assert p.force @ at.lever_gear == pytest.approx(torque * 39 / 14, rel=1e-8)
        assert np.all(p.force >= 0.0)
        local = np.zeros(p.force.size)
        local[loaded] = elastic.approach(np.where(loaded, p.force, 1.0))[0][loaded]
        separation = elastic.bending @ p.force + local + at.gap - at.lever_pinion * p.approach
        scale = p.approach * at.lever_pinion.max()
        assert np.abs(separation[loaded]).max() < 1e-10 * scale
        assert separation.min() > -1e-10 * scale


def test_stiffness_is_the_derivative_of_the_torque(crowded: ElasticPosition, geared: Mesh) -> None:
    step = 1e-4
    low, middle, high = (
        distribute_load([crowded], geared.grids.teeth, 300.0 * (1.0 + k * step)).positions[0] for k in (-1, 0, 1)
    )
    slope = 600.0 * step / (high.approach - low.approach)
    assert middle.equilibrium.stiffness == pytest.approx(slope, rel=1e-3)


def straight_line(crowded: ElasticPosition, points: int = 9) -> ElasticPosition:
    """One straight line of even radius and no gap, on teeth that do not bend."""
    at = crowded.position
    k = int(np.argmin(np.abs(at.height_gear - 0.5 * at.height_gear.max())))
    one = {
        name: np.repeat(getattr(at, name)[k : k + 1], points, axis=0)
        for name in MeshPosition.__dataclass_fields__
        if isinstance(getattr(at, name), np.ndarray)
    }
    one |= {"length": np.full(points, 2e-3), "gap": np.zeros(points)}
    position = replace(at, edge=None, **one)
    law, zero = crowded.approach, np.zeros(points)
    depths = tuple(np.repeat(depth[k : k + 1], points) for depth in law.depths)
    edge = {"free_edge": zero, "edge_distance": zero + np.inf, "rounding": zero + 1.0}
    law = replace(law, length=position.length, radius_equivalent=position.radius_equivalent, depths=depths, **edge)
    return ElasticPosition(position, np.zeros((points, points)), law)


def test_hertz_limit_is_exact(crowded: ElasticPosition, geared: Mesh) -> None:
    """A single straight line of rigid teeth: even load, Hertz pressure and width, Weber's approach."""
    line, torque = straight_line(crowded), 100.0
    at, modulus = line.position, line.approach.effective_modulus
    load = distribute_load([line], geared.grids.teeth, torque).positions[0]
    even = torque / float(at.lever_pinion[0]) / (at.length.sum())
    np.testing.assert_allclose(load.load_per_length, even, rtol=1e-12)
    radius = float(at.radius_equivalent[0])
    half_width = math.sqrt(8.0 * even * radius / (math.pi * modulus))
    np.testing.assert_allclose(load.half_width, half_width, rtol=1e-12)
    np.testing.assert_allclose(load.pressure_hertz, 2.0 * even / (math.pi * half_width), rtol=1e-12)
    np.testing.assert_array_equal(load.pressure_max, load.pressure_hertz)
    approach = sum(
        float(weber_local(even, half_width, depth[0], material.youngs_modulus, material.poisson_ratio))
        for depth, material in zip(line.approach.depths, line.approach.materials, strict=True)
    )
    assert load.approach * at.lever_pinion[0] == pytest.approx(approach, rel=1e-11)


def test_light_load_approaches_the_unloaded_transmission_error(geared: Mesh) -> None:
    """Lag goes to zero with the load as in a point contact, (T^2/3), on lines cut down to the few tenths that touch."""
    lags = []
    for torque in (1e-3, 1e-1):
        load = load_grids(geared.grids, torque).fine
        angles = np.array([p.position.pinion_angle for p in load.positions])
        lags.append(geared.flanks.transmission.at(angles) - load.transmission_error)
    assert lags[0].min() > 0.0
    assert lags[0].max() < 0.005 * geared.flanks.transmission.peak_to_peak
    exponent = np.log(lags[1].mean() / lags[0].mean()) / math.log(100.0)
    assert exponent == pytest.approx(2.0 / 3.0, abs=0.04)


def test_default_grid_has_one_per_cent_of_the_transmission_error(geared: Mesh) -> None:
    teeth = geared.grids.teeth
    surface = geared.flanks.surface
    cycles = {points: elastic_cycle(mesh_cycle(surface, 8, points, edges=True), teeth) for points in (31, 81)}
    for torque in (30.0, 300.0):
        error = {points: distribute_load(cycle, teeth, torque).transmission_error for points, cycle in cycles.items()}
        assert np.ptp(error[31]) == pytest.approx(np.ptp(error[81]), rel=0.01)
        np.testing.assert_allclose(error[31], error[81], rtol=0.005)


def test_light_loads_get_all_points_of_their_lines(geared: Mesh) -> None:
    """At 1 N m the standard lines have hardly a point where the flanks touch; the grid follows the load."""
    light, nominal = load_grids(geared.grids, 1.0), load_grids(geared.grids, 300.0)
    assert nominal.mesh is geared.grids
    assert light.mesh is not geared.grids
    loaded = [np.count_nonzero(p.force) for p in light.fine.positions]
    before = [
        np.count_nonzero(p.force) for p in distribute_load(geared.grids.elastic_fine, geared.grids.teeth, 1.0).positions
    ]
    assert min(loaded) >= 6
    assert np.mean(loaded) > 2.5 * np.mean(before)
    # torques near each other share their lines
    assert load_grids(geared.grids, 1.05).mesh is light.mesh


def test_edges_take_over_where_the_path_ends(load: LoadDistribution, geared: Mesh) -> None:
    """A pair comes in on the tip edge of the gear and goes out on that of the pinion, before and after its path."""
    names: dict[str, list[float]] = {}
    for p in load.positions:
        at, edge = p.position, p.position.edge
        for k in np.flatnonzero(edge.touching & (p.force > 0.0)):
            angle = at.pinion_angle + at.pair[k] * geared.flanks.surface.pitch
            names.setdefault(EDGES[edge.index[k]], []).append(angle)
    assert {"gear tip", "pinion tip"} <= names.keys()
    assert max(names["gear tip"]) < min(names["pinion tip"])
    assert load.contact_ratio > 2.0


def test_edge_load_is_told_with_its_interval(load: LoadDistribution, geared: Mesh) -> None:
    teeth = geared.grids.teeth
    edges = edge_load(load, teeth)
    assert 0.02 < edges.share_extended < edges.share < 0.3
    assert edges.share == pytest.approx(sum(edges.shares.values()))
    assert load.pressure_hertz_max < edges.pressure_lower < edges.pressure < edges.pressure_upper
    (note,) = limit_notes(load, teeth, 0.0)
    assert f"edges carry {100 * edges.share:.2g} % of the torque" in note
    assert "before and after the path" in note
    # a light load in the middle of the flanks knows no edge
    centre = load_grids(geared.grids, 0.1).fine
    assert edge_load(centre, teeth).share < 0.01
    # the truth for other radii lies in the interval, though the load then shifts a little
    for factor in (0.5, 2.0):
        other = replace(
            teeth,
            edge_rounding_pinion=factor * teeth.edge_rounding_pinion,
            edge_rounding_gear=factor * teeth.edge_rounding_gear,
        )
        pressure = edge_load(distribute_load(elastic_cycle(geared.grids.fine, other), other, 300.0), other).pressure
        assert pressure == pytest.approx(edges.pressure_upper if factor < 1.0 else edges.pressure_lower, rel=0.1)


@pytest.mark.parametrize("tiny", [0.0, 5e-324, 1e-312, 1e-200])
def test_vanishing_force_on_an_edge(geared: Mesh, load: LoadDistribution, tiny: float) -> None:
    """An edge that only just touches: no division by its width, no share, no pressure."""
    for p, elastic in zip(load.positions, geared.grids.elastic_fine, strict=True):
        edge = p.position.edge
        force = np.where(edge.touching, tiny, 1.0)
        at = np.array([p.approach]), np.array([p.transmission_error])
        (changed,) = loads_of_forces([elastic.position], elastic.approach, force, *at, [p.equilibrium])
        for values in (changed.pressure_max, changed.half_width):
            assert np.isfinite(values).all()
            assert values[edge.touching].max(initial=0.0) < 1e-80 * values.max()
        edges = edge_load(replace(load, positions=(changed,)), geared.grids.teeth)
        assert edges.share_extended < 1e-100
        assert math.isfinite(edges.pressure_upper)


def test_misaligned_pair_carries() -> None:
    """All three axes off by 0.5 mm: the contact moves to the edges, the load is still found."""
    geared = Mesh.of(DESIGN.with_misalignment(E=0.5e-3, P=-0.5e-3, G=0.5e-3), "drive", 4, 11, keep=True)
    load = load_grids(geared.grids, 300.0).fine
    assert load.status == "converged"
    assert max(load.torque_residual, load.compatibility_residual) < 1e-10
    assert edge_load(load, geared.grids.teeth).share > 0.2
