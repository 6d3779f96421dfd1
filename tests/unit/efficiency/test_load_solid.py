"""Solid teeth: polynomials, the ring of cells, the body of a member; finite elements of the tooth root."""

from functools import cache

import numpy as np
import pytest
from refusals import fails, refuses
from samples import STEEL, tiny_mesh

from efficiency.contact.gear_flanks import Member
from efficiency.contact.tooth_grid import ToothGrid, tooth_grid
from efficiency.design.design import BACKUP_RATIO, BodyInput, Design, load_design
from efficiency.ltca.ritz_solid import Orders, ritz_solid, tooth_cell
from efficiency.ltca.solid_tooth import ToothBody, ring_response, solid_tooth
from efficiency.strength.hexahedra import CORNERS_AND_EDGES, Factors, element_stiffness
from efficiency.strength.root_mesh import Counts, _with_arc, root_mesh
from efficiency.strength.root_stress import RootTooth, _unit_forces, root_tooth
from ehl.common.arrays import BoolArray, FloatArray, IntArray
from ehl.common.validation import validate

RIM = 8e-3
LOW = Orders(tooth=(3, 4, 6), body=(3, 3, 5))
MODULI = dict.fromkeys(("foot", "slot", "tooth"), STEEL.youngs_modulus)


@pytest.fixture(scope="module")
def grid(design: Design) -> ToothGrid:
    return tooth_grid(design.flanks(), "gear", 15, 7)


def test_cell_follows_the_flanks(grid: ToothGrid) -> None:
    """Stations and levels of the grid, between the nodes of the blocks: 14 um near the fillets, at the toe."""
    cell = tooth_cell(grid, RIM)
    face = np.broadcast_to(grid.u - grid.u[0, 0], grid.height.shape)[5:, 1:-1].ravel()
    over = (grid.height - grid.blank.root(grid.u[0]))[5:, 1:-1].ravel()
    b, c = cell.on_flank(face, over)
    for side, azimuth in ((0.0, grid.lower), (1.0, grid.upper)):
        points, _ = cell.tooth.place(np.full_like(b, side), b, c)
        expected = grid.point(azimuth, grid.u, grid.height)[5:, 1:-1].reshape(-1, 3)
        np.testing.assert_allclose(points, expected, atol=2e-5)


def test_ring_is_the_assembly_of_its_cells(grid: ToothGrid) -> None:
    """Three cells closed by a turn of three pitches, assembled and solved as one system."""
    solid = ritz_solid(tooth_cell(grid, RIM), MODULI, STEEL.poisson_ratio, frozenset({"base"}), LOW)
    pitch, cells = grid.pitch, 3
    count, rng = solid.count, np.random.default_rng(3)
    reading = rng.standard_normal((6, 3, count))
    reading[..., np.concatenate([solid.left, solid.right])] = 0.0
    reading = reading.reshape(6, -1)
    loading = reading[:2]
    response = ring_response(solid, pitch, cells, reading, 2)

    kept = np.setdiff1d(np.arange(count), solid.right)
    place = {int(number): k for k, number in enumerate(kept)}
    c, s = np.cos(pitch), np.sin(pitch)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    total = np.zeros((cells * 3 * kept.size,) * 2)
    expands = []
    for cell in range(cells):
        expand = np.zeros((3, count, cells, 3, kept.size))
        for i in range(3):
            expand[i, kept, cell, i, np.arange(kept.size)] = 1.0
            for j in range(3):
                to = [place[int(number)] for number in solid.left]
                expand[i, solid.right, (cell + 1) % cells, j, to] = turn[i, j]
        expands.append(expand.reshape(3 * count, -1))
        total += expands[-1].T @ solid.stiffness @ expands[-1]
    moved = np.linalg.solve(total, expands[0].T @ loading.T)
    scale = np.abs(response.own).max()
    np.testing.assert_allclose(response.own, reading @ expands[0] @ moved, atol=1e-8 * scale)
    np.testing.assert_allclose(response.ahead[0], reading @ expands[1] @ moved, atol=1e-8 * scale)
    np.testing.assert_allclose(response.ahead[1], reading @ expands[2] @ moved, atol=1e-8 * scale)


def mean_compliance(grid: ToothGrid, rim: float = RIM, **given: object) -> float:
    tooth = solid_tooth(grid, "convex", ToothBody(STEEL, rim, **given), LOW)  # type: ignore[arg-type]
    face, share = (x.ravel() for x in np.meshgrid(np.linspace(0.1, 0.9, 5) * 25.4e-3, np.linspace(0.2, 0.95, 4)))
    return float(tooth.influences([(face, share * tooth.whole_depth(face), np.zeros(face.size, np.int64))])[0].mean())


def test_body_and_how_it_is_held(grid: ToothGrid) -> None:
    base = mean_compliance(grid)
    rigid = mean_compliance(grid, youngs_modulus=1e15)
    assert rigid < 0.9 * base
    # 0.03 % of the tooth's own deflection is left at 1e15 Pa, and a tenth of that at 1e16 Pa
    assert mean_compliance(grid, youngs_modulus=1e16) == pytest.approx(rigid, rel=5e-4)
    assert mean_compliance(grid, 0.5 * RIM) < base < mean_compliance(grid, 2.0 * RIM)
    held_twice = mean_compliance(grid, held=frozenset({"base", "heel"}))
    # held at the heel alone the whole rim turns
    assert held_twice < base < mean_compliance(grid, held=frozenset({"heel"}))


def test_member_that_nothing_holds_is_refused(grid: ToothGrid) -> None:
    with fails("tooth_not_held"):
        solid_tooth(grid, "convex", ToothBody(STEEL, RIM, frozenset()), LOW)


def test_default_rim_and_its_limit(design: Design) -> None:
    blank = design.gear.blank
    assert BodyInput().thickness(blank) == pytest.approx(BACKUP_RATIO * (blank.mean_addendum + blank.mean_dedendum))
    slender = load_design("fh_hypoid_9x34").pinion.blank
    assert BodyInput().thickness(slender) < BACKUP_RATIO * (slender.mean_addendum + slender.mean_dedendum)
    given = {"rim_thickness": "12 mm", "held": ["base", "heel"]}
    content = design.model_dump(exclude_none=True)
    content["pinion"]["body"] = given
    body = validate(Design, content).pinion.body
    assert (body.rim_thickness, body.held) == (pytest.approx(0.012), ("base", "heel"))
    given["rim_thickness"] = "60 mm"
    with refuses("pinion.body.rim_thickness"):
        validate(Design, content)


E = 2.1e11


@cache
def tooth_of(member: Member) -> RootTooth:
    mesh = tiny_mesh()
    return root_tooth(mesh.bevel.flanks(), member, getattr(mesh.grids.teeth, member), mesh.pitch.module_normal)


def box(counts: tuple[int, int, int], size: tuple[float, float, float]) -> tuple[FloatArray, IntArray]:
    lattice = np.indices([2 * n + 1 for n in counts])
    used = (lattice % 2).sum(axis=0) <= 1
    number = np.full(used.shape, -1)
    number[used] = np.arange(used.sum())
    nodes = (lattice[:, used].T / (2.0 * np.array(counts))) * size
    first = 2 * np.indices(counts).reshape(3, -1).T
    i, j, k = np.moveaxis(first[:, None] + CORNERS_AND_EDGES + 1, 2, 0)
    return nodes, number[i, j, k]


def solved(nodes: FloatArray, elements: IntArray, held: BoolArray, kept: BoolArray, force: FloatArray) -> FloatArray:
    """Displacement (n, 3) of a body that does not contract across; the kept nodes are solved last."""
    stiffness = element_stiffness(nodes[elements], np.full(len(elements), E), 0.0)
    factors = Factors(elements, stiffness, nodes[elements].mean(axis=1) / 1e-3, kept, held)
    reduced = factors.condensed_load(force.reshape(-1, 1).copy())
    border = (3 * factors.border[:, None] + np.arange(3)).ravel()
    reduced[border] = np.linalg.solve(factors.stiffness, reduced[border])
    reduced[np.repeat(held, 3)] = 0.0
    return factors.displacement(reduced, np.ones(len(nodes), bool)).reshape(-1, 3)


def test_patch_of_distorted_elements_strains_evenly() -> None:
    """A linear displacement is an exact solution: no forces inside, whatever the shape of the elements."""
    nodes, elements = box((2, 2, 3), (1.0, 1.0, 1.0))
    inside = np.all((nodes > 0.0) & (nodes < 1.0), axis=1)
    corner = np.zeros(len(nodes), bool)
    corner[np.unique(elements[:, np.abs(CORNERS_AND_EDGES).sum(axis=1) == 3])] = True
    nodes[inside & corner] += np.random.default_rng(3).uniform(-0.08, 0.08, (int((inside & corner).sum()), 3))
    # middles of edges stay in the middle
    for place in np.flatnonzero(np.abs(CORNERS_AND_EDGES).sum(axis=1) == 2):
        middle = CORNERS_AND_EDGES[place]
        ways = [middle + step * (middle == 0) for step in (-1, 1)]
        ends = [np.flatnonzero((way == CORNERS_AND_EDGES).all(axis=1))[0] for way in ways]
        nodes[elements[:, place]] = 0.5 * nodes[elements[:, ends]].sum(axis=1)
    stiffness = element_stiffness(nodes[elements], np.full(len(elements), E), 0.3)
    gradient = np.array([[1.0, 0.3, -0.2], [0.5, -0.4, 0.1], [0.2, 0.6, 0.7]])
    moved = nodes @ gradient.T
    force = np.zeros((len(nodes), 3))
    np.add.at(force, elements, np.einsum("eij,ej->ei", stiffness, moved[elements].reshape(-1, 60)).reshape(-1, 20, 3))
    assert np.abs(force[inside]).max() < 1e-12 * np.abs(force).max()


def test_bending_of_a_bar() -> None:
    """Held at one end, sheared at the other: deflection of Timoshenko's beam, and the numbering does not matter."""
    length, height = 10e-3, 1e-3
    nodes, elements = box((10, 2, 2), (length, height, height))
    held, end = nodes[:, 0] == 0.0, np.isclose(nodes[:, 0], length)
    force = np.zeros((len(nodes), 3))
    force[end, 1] = 10.0 / end.sum()
    inertia, area = height**4 / 12.0, height**2
    expected = 10.0 * length**3 / (3.0 * E * inertia) + 1.2 * 10.0 * length / (0.5 * E * area)
    one = solved(nodes, elements, held, end, force)
    assert one[end, 1].mean() == pytest.approx(expected, rel=5e-3)
    middle = np.isclose(nodes[:, 0], 0.5 * length)
    np.testing.assert_allclose(solved(nodes, elements, held, middle, force), one, rtol=1e-6, atol=1e-13)


@pytest.mark.parametrize("member", ["pinion", "gear"])
def test_unit_loads_keep_force_and_moment(member: Member) -> None:
    """Consistent forces of each place of load: one newton, less what the flank is curved; shares keep the place."""
    mesh = tiny_mesh()
    solid = getattr(mesh.grids.teeth, member)
    rim, module = solid.body.rim_thickness, mesh.pitch.module_normal
    found = root_mesh(mesh.bevel.flanks(), member, solid.grid, rim, module, Counts())
    forces = _unit_forces(found, int(solid.side)).reshape(len(found.nodes), 3, -1)
    size = np.linalg.norm(forces.sum(axis=0), axis=0)
    np.testing.assert_allclose(size, 1.0, atol=0.02)
    tooth = tooth_of(member)
    face, height = 0.4 * tooth.width, np.interp(0.4, np.linspace(0.0, 1.0, 13), tooth.levels[3])
    share = tooth.shares(np.array([face]), np.array([height]))[0]
    assert share.sum() == pytest.approx(1.0)
    levels = tooth.levels.ravel()
    places = np.tile(np.linspace(0.0, tooth.width, tooth.levels.shape[1]), tooth.levels.shape[0])
    assert share @ places == pytest.approx(face)
    assert share @ levels == pytest.approx(height)


def test_stress_converges_with_the_elements() -> None:
    """Fewer elements in each direction, by a third: less than 2 % of the stress under a load high on the tooth."""
    mesh = tiny_mesh()
    given = mesh.bevel.flanks(), "pinion", mesh.grids.teeth.pinion, mesh.pitch.module_normal
    face = np.linspace(0.35, 0.65, 7)
    stresses = []
    for tooth in (tooth_of("pinion"), root_tooth(*given, Counts(3, 4, 2, 2, 2, 8))):
        height = np.interp(face, np.linspace(0.0, 1.0, tooth.levels.shape[1]), 0.8 * tooth.levels[-1])
        load = tooth.shares(face * tooth.width, height).sum(axis=0) * 1e3
        one, two, shear = np.moveaxis(tooth.loaded[0] @ load, 2, 0)
        stresses.append(float((0.5 * (one + two) + np.hypot(0.5 * (one - two), shear)).max()))
    assert stresses[0] == pytest.approx(stresses[1], rel=0.02)


def test_arc_that_does_not_fit_is_refused() -> None:
    y = np.linspace(2.25, 0.2, 12)
    flank = np.stack([0.35 + (2.25 - y) * np.tan(np.radians(20.0)), y], axis=-1)
    arc = _with_arc(flank, 0.0, 0.3)
    assert arc[-1, 1] == pytest.approx(0.0)
    assert np.all(np.diff(arc[:, 1]) < 0.0)
    with fails("no_fillet"):
        _with_arc(flank, 0.0, 8.0)
    with fails("no_fillet"):
        _with_arc(np.array([[0.5, 2.0], [0.6, 1.0]]), -50.0, 0.2)
