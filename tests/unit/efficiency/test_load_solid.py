"""Parts of the solid tooth: polynomials, a cell, the ring of cells, the body of a member."""

from pathlib import Path

import numpy as np
import pytest
from refusals import fails, refuses

from efficiency.contact.tooth_grid import ToothGrid, tooth_grid
from efficiency.design.design import BACKUP_RATIO, BodyInput, Design, load_design
from efficiency.ltca.ritz_solid import Orders, RitzSolid, ritz_solid, tooth_cell
from efficiency.ltca.solid_tooth import SolidTooth, ToothBody, ring_response, solid_tooth
from ehl.material import Material

STEEL = Material.load("steel")
RIM = 8e-3
LOW = Orders(tooth=(3, 4, 6), body=(3, 3, 5))
MODULI = dict.fromkeys(("foot", "slot", "tooth"), STEEL.youngs_modulus)


@pytest.fixture(scope="module")
def grid(design: Design) -> ToothGrid:
    return tooth_grid(design.flanks(), "gear", 15, 7)


def cell_solid(grid: ToothGrid, held: frozenset[str], orders: Orders = LOW) -> RitzSolid:
    return ritz_solid(tooth_cell(grid, RIM), MODULI, STEEL.poisson_ratio, held, orders)


def test_cell_follows_the_flanks(grid: ToothGrid) -> None:
    """Stations and levels of the grid, between the nodes of the blocks: 14 um beside the fillets, at the toe."""
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
    solid, pitch, cells = cell_solid(grid, frozenset({"base"})), grid.pitch, 3
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


def influence(tooth: SolidTooth) -> np.ndarray:
    face, share = (x.ravel() for x in np.meshgrid(np.linspace(0.1, 0.9, 5) * 25.4e-3, np.linspace(0.2, 0.95, 4)))
    return tooth.influences([(face, share * tooth.whole_depth(face), np.zeros(face.size, np.int64))])[0]


def mean_compliance(grid: ToothGrid, rim: float = RIM, **given: object) -> float:
    return float(influence(solid_tooth(grid, "convex", ToothBody(STEEL, rim, **given), LOW)).mean())  # type: ignore[arg-type]


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


def test_default_rim_and_its_limit(design: Design, tmp_path: Path) -> None:
    blank = design.gear.blank
    assert BodyInput().thickness(blank) == pytest.approx(BACKUP_RATIO * (blank.mean_addendum + blank.mean_dedendum))
    slender = load_design("fh_hypoid_9x34").pinion.blank
    assert BodyInput().thickness(slender) < BACKUP_RATIO * (slender.mean_addendum + slender.mean_dedendum)
    text = Path("data/designs/fm_spiral_bevel_14x39.toml").read_text(encoding="utf-8")
    file = tmp_path / "design.toml"
    file.write_text(text + '\n[pinion.body]\nrim_thickness = "12 mm"\nheld = ["base", "heel"]\n', encoding="utf-8")
    body = load_design(file).pinion.body
    assert (body.rim_thickness, body.held) == (pytest.approx(0.012), ("base", "heel"))
    file.write_text(text + '\n[pinion.body]\nrim_thickness = "60 mm"\n', encoding="utf-8")
    with refuses("pinion.body.rim_thickness"):
        load_design(file)
