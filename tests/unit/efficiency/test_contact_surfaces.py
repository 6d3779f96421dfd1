"""Flanks without settings: conjugate with an ease-off, grids of points, tables of ease-off; patches and curves."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from refusals import fails
from scipy.interpolate import Akima1DInterpolator, CubicSpline

from efficiency.contact.chebyshev import Patch, PointFit, akima_curve, cubic_spline
from efficiency.contact.conjugate import EaseOffTarget, EaseOffTerm, conjugate_flank, read_ease_off_map
from efficiency.contact.contact_lines import mesh_cycle
from efficiency.contact.contact_search import transmission
from efficiency.contact.grid_flank import grid_flank, read_point_grid
from efficiency.contact.mesh_surface import MeshSurface, mesh_surface
from efficiency.cutting.machine import turn
from efficiency.design.design import Design, load_design
from efficiency.mesh import Mesh
from efficiency.output.files import inspection_grid, write_inspection_grid
from ehl.common.data import data_path
from ehl.common.errors import InputError

ARCSEC = np.pi / (180.0 * 3600.0)
BEVEL, HYPOID = "fm_spiral_bevel_14x39", "fh_hypoid_9x34"
PAIRS: tuple[tuple[str, Any], ...] = tuple((name, side) for name in (BEVEL, HYPOID) for side in ("drive", "coast"))


def conjugate_pair(name: str, side: Any, target: EaseOffTarget) -> MeshSurface:
    design = load_design(name)
    pinion, gear = design.flanks().mating(side)
    flank = conjugate_flank(gear, pinion.blank, design.placement(), target)
    return mesh_surface(gear, flank, design.placement())


def inside(surface: MeshSurface, count: int = 300) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(5)
    u = random.uniform(-0.5, 0.5, count) * surface.gear.blank.face_width
    v = random.uniform(0.0, 1.0, count)
    some = surface.margin(u, v) > 0.0
    return u[some], v[some]


@pytest.mark.parametrize(("name", "side"), PAIRS)
def test_conjugate_flank_has_no_ease_off_and_no_transmission_error(name: str, side: Any) -> None:
    """The hypoid's conjugate pinion is undercut at its root."""
    surface = conjugate_pair(name, side, EaseOffTarget())
    u, v = inside(surface)
    assert np.abs(surface.patch(u, v, ("ease_off",))).max() < 1e-13
    assert transmission(surface).peak_to_peak / ARCSEC < 1e-4
    assert max(position.gap.max() for position in mesh_cycle(surface, positions=4, points_per_line=9)) < 1e-12
    assert (surface.undercut is not None) == (name == HYPOID)
    if surface.undercut is not None:
        assert 0.0 < surface.undercut.share < 0.02
        assert surface.undercut.fraction[0] > 0.9


@pytest.mark.parametrize(("name", "side"), PAIRS[1:3])
def test_ease_off_asked_for_is_the_ease_off_measured(name: str, side: Any) -> None:
    terms = [EaseOffTerm(length_power=n, depth_power=m, relief=z) for n, m, z in ((3, 0, 4e-6), (1, 2, -3e-6))]
    shape = {"lengthwise_crowning": 40e-6, "profile_crowning": 12e-6, "bias": 0.3, "twist": 6e-6}
    target = EaseOffTarget(**shape, contact_face=0.1, contact_depth=-0.05, terms=tuple(terms))
    surface = conjugate_pair(name, side, target)
    u, v = inside(surface)
    blank, pinion = surface.gear.blank, surface.pinion.blank
    low, high = -pinion.mean_addendum, blank.mean_addendum
    length, depth = 2.0 * u / blank.face_width, (surface.height(u, v) - 0.5 * (low + high)) / (0.5 * (high - low))
    rest = surface.patch(u, v, ("ease_off",))[0] - target(length, depth)
    # one rotation of the pinion is free
    lever = surface.patch(u, v, ("lever",))[0]
    rest -= lever * (lever @ rest) / (lever @ lever)
    assert np.abs(rest).max() < 1e-9


def test_terms_of_the_ease_off() -> None:
    length, depth = np.array([-1.0, 0.0, 1.0, 1.0]), np.array([0.0, 1.0, 0.0, 1.0])
    np.testing.assert_allclose(EaseOffTarget(lengthwise_crowning=1e-3)(length, depth), [1e-3, 0.0, 1e-3, 1e-3])
    np.testing.assert_allclose(EaseOffTarget(profile_crowning=1e-3)(length, depth), [0.0, 1e-3, 0.0, 1e-3])
    np.testing.assert_allclose(EaseOffTarget(twist=1e-3)(length, depth), [0.0, 0.0, 0.0, 1e-3])
    # the crest of the crowning at the tip lies half a face width nearer the heel
    assert EaseOffTarget(lengthwise_crowning=1e-3, bias=1.0)(np.array([1.0]), np.array([1.0]))[0] == 0.0
    assert EaseOffTarget(lengthwise_crowning=1e-3, contact_face=0.5)(np.array([0.5]), np.array([0.7]))[0] == 0.0
    term = EaseOffTerm(length_power=2, depth_power=1, relief=1e-3)
    np.testing.assert_allclose(EaseOffTarget(terms=(term,))(length, depth), [0.0, 0.0, 0.0, 1e-3])


def test_normal_of_the_conjugate_flank_with_ease_off() -> None:
    """Square to differences of the flank; unit length, out of the tooth."""
    design = load_design(HYPOID)
    pinion, gear = design.flanks().mating("coast")
    target = EaseOffTarget(lengthwise_crowning=60e-6, profile_crowning=20e-6, twist=15e-6)
    flank = conjugate_flank(gear, pinion.blank, design.placement(), target)
    u = np.array([-0.2, 0.0, 0.3]) * pinion.blank.face_width
    h, step = np.array([1e-3, 0.0, 2e-3]), 1e-6
    points, found = flank.solve(u, h)
    assert found.all()
    for du, dh in ((step, 0.0), (0.0, step)):
        ahead, behind = (flank.solve(u + k * du, h + k * dh)[0].position for k in (1.0, -1.0))
        along = (ahead - behind) / np.linalg.norm(ahead - behind, axis=0)
        assert np.abs((along * points.normal).sum(axis=0)).max() < 1e-9
    np.testing.assert_allclose(np.linalg.norm(points.normal, axis=0), 1.0, rtol=1e-13)
    cut, _ = pinion.solve(u, h)
    there = turn(cut.normal, points.azimuth - cut.azimuth)
    assert ((there * points.normal).sum(axis=0) > 0.999).all()


def grid_file(folder: Path, design: Design) -> Path:
    path = folder / "gear.csv"
    write_inspection_grid(path, design, "gear", "convex", inspection_grid(design.gear.flank("convex"), 9, 13, 0.04))
    return path


@pytest.mark.parametrize("name", [BEVEL, HYPOID])
def test_grid_of_a_cut_flank_gives_the_flank_back(tmp_path: Path, name: str) -> None:
    design = load_design(name)
    cut = design.gear.flank("convex")
    path = grid_file(tmp_path, design)
    flank = grid_flank(read_point_grid(path), "convex", cut.blank)
    assert flank.error < 1e-8
    u, v = (g.ravel() for g in np.meshgrid(np.linspace(-0.45, 0.45, 7) * cut.blank.face_width, [0.06, 0.5, 0.95]))
    exact, found = cut.solve(u, cut.blank.height(u, v))
    fitted, there = flank.solve(u, cut.blank.height(u, v))
    assert found.all()
    assert there.all()
    off = ((fitted.position - exact.position) * exact.normal).sum(axis=0)
    assert np.abs(off).max() < max(flank.error, 2e-12)
    assert np.linalg.norm(fitted.normal - exact.normal, axis=0).max() < 1e-6
    # a file of points alone, without head and normals
    lines = path.read_text(encoding="utf-8").splitlines()
    kept = [lines[0]] + [",".join(line.split(",")[:5]) for line in lines[2:]]
    path.write_text("\n".join(kept), encoding="utf-8")
    assert grid_flank(read_point_grid(path), "convex", cut.blank).error < 1e-7


def test_noise_is_smoothed_and_stated(tmp_path: Path) -> None:
    design = load_design(BEVEL)
    cut = design.gear.flank("convex")
    grid = inspection_grid(cut, 9, 13, 0.04)
    noise = 1e-6 * np.random.default_rng(2).standard_normal(grid.u.shape)
    path = tmp_path / "noisy.csv"
    write_inspection_grid(path, design, "gear", "convex", replace(grid, position=grid.position + noise * grid.normal))
    flank = grid_flank(read_point_grid(path), "convex", cut.blank)
    assert 2e-6 < flank.error < 6e-6
    points, _ = flank.solve(grid.u.ravel(), grid.height.ravel())
    normal = grid.normal.reshape(3, -1)
    off = ((points.position - grid.position.reshape(3, -1)) * normal).sum(axis=0)
    # smoother than what went in
    assert np.sqrt(np.mean(off**2)) < 0.7e-6


def cells(change: Any) -> Any:
    """The text with other cells in line 20, that of row 2, column 4."""
    return lambda text: "\n".join(
        ",".join(change(line.split(","))) if number == 20 else line for number, line in enumerate(text.splitlines(), 1)
    )


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (lambda text: text.replace("units=mm", "units=furlong"), "units"),
        (lambda text: text.replace("row,column,x,y,z", "row,column,a,b,c"), "line 3"),
        (lambda text: text.replace("flank=convex", "flank=concave"), "flank"),
        (lambda text: text.replace("units=mm", "units=inch"), r"row \d+, column \d+"),
        (cells(lambda row: [*row[:5], "0.1", "0.1", "0.1"]), "row 2, column 4.*length"),
        (cells(lambda row: [*row[:5], *(str(-float(x)) for x in row[5:])]), "normal"),
        (cells(lambda row: ["1", "1", *row[2:]]), "row 1, column 1 = '2 points'"),
    ],
)
def test_bad_grid_files_are_refused_by_place(tmp_path: Path, change: Any, named: str) -> None:
    design = load_design(BEVEL)
    path = grid_file(tmp_path, design)
    path.write_text(change(path.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(InputError, match=named):
        grid_flank(read_point_grid(path), "convex", design.gear.blank)


def test_table_of_ease_off(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    x, y = random.uniform(-1.0, 1.0, (2, 60))
    path = tmp_path / "map.csv"
    rows = "\n".join(f"{a},{b},{30.0 * a * a - 4.0 * a * b + 3.0 * b**3}" for a, b in zip(x, y, strict=True))
    path.write_text("length,depth,ease_off\n" + rows, encoding="utf-8")
    given = read_ease_off_map(path)
    assert given.error < 1e-15
    assert given(np.array([0.5]), np.array([-1.0]))[0] == pytest.approx((7.5 + 2.0 - 3.0) * 1e-6, rel=1e-9)


BAD = {"0,0,nan\n": "row 2", "12,0,1\n": "row 2", "0,0,1\n": "1 points", "0,0,1\n" * 9: "spread"}
BAD = {"a,b,c\n0,0,0\n": "header"} | {f"length,depth,ease_off\n{rows}": named for rows, named in BAD.items()}


@pytest.mark.parametrize(("text", "named"), BAD.items())
def test_bad_tables_of_ease_off(tmp_path: Path, text: str, named: str) -> None:
    path = tmp_path / "map.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=named):
        read_ease_off_map(path)


def test_patch_over_a_part_of_its_rectangle() -> None:
    """A corner cut off: inside the rest the fit is as good as an interpolation, with complex derivatives as well."""

    def field(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.asarray(np.exp(0.7 * u) / (1.5 + v))

    u, v = Patch.nodes((-1.0, 1.0), (0.0, 1.0), (24, 20))
    kept = u + 2.0 * v < 1.8
    patch = PointFit((-1.0, 1.0), (0.0, 1.0), (14, 12), u[kept], v[kept])({"f": field(u, v)[kept]})
    random = np.random.default_rng(1)
    x, y = random.uniform(-1.0, 1.0, 200), random.uniform(0.0, 1.0, 200)
    some = x + 2.0 * y < 1.8
    assert np.abs(patch(x, y, ("f",))[0] - field(x, y))[some].max() < 1e-9
    value, by_u, by_v = patch.slopes(x[some] + 1e-20j, y[some], ("f",))
    np.testing.assert_allclose(np.imag(value) / 1e-20, np.real(by_u), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(np.real(by_v)[0], (-field(x, y) / (1.5 + y))[some], rtol=1e-5)
    assert patch.raised((20, 20))(x, y, ("f",)) == pytest.approx(patch(x, y, ("f",)), abs=1e-12)


@settings(max_examples=20)
@given(st.integers(0, 2), st.integers(0, 2), st.floats(-0.9, 1.9), st.floats(0.1, 0.9))
def test_patch_is_exact_for_polynomials_and_their_derivatives(du: int, dv: int, u: float, v: float) -> None:
    nodes_u, nodes_v = Patch.nodes((-1.0, 2.0), (0.0, 1.0), (6, 5))
    fields = {"f": nodes_u**3 * nodes_v**2 + nodes_v, "one": 0.0 * nodes_u + 1.0}
    patch = Patch.fit((-1.0, 2.0), (0.0, 1.0), (6, 5), fields)
    up = [u**3, 3.0 * u**2, 6.0 * u][du]
    vp = [v**2, 2.0 * v, 2.0][dv]
    extra = [v, 1.0, 0.0][dv] if du == 0 else 0.0
    value = patch(np.array([u]), np.array([v]), ("f", "one"), du=du, dv=dv)[:, 0]
    np.testing.assert_allclose(value, [up * vp + extra, float(du == 0 and dv == 0)], atol=1e-11)


def test_patch_tail_tells_resolved_from_unresolved_fields() -> None:
    u, v = Patch.nodes((0.0, 1.0), (0.0, 1.0), (10, 10))
    patch = Patch.fit((0.0, 1.0), (0.0, 1.0), (10, 10), {"smooth": np.exp(u * v), "kink": np.abs(u - 0.4) + v})
    assert patch.tail["smooth"] < 1e-7
    assert patch.tail["kink"] > 1e-3


def test_curves_are_those_of_scipy() -> None:
    rng = np.random.default_rng(1)
    x = np.cumsum(rng.uniform(0.2, 2.0, 30))
    # a flat part, a straight part and a kink among the rest
    y = np.concatenate([rng.normal(size=15), np.zeros(5), 2.0 * x[20:26] - 3.0, rng.normal(size=4)])
    at = np.append(np.linspace(x[0] - 0.5, x[-1] + 0.5, 500), x)
    np.testing.assert_allclose(akima_curve(x, y, at), Akima1DInterpolator(x, y, method="makima")(at), atol=1e-13)
    assert np.all(akima_curve(x, y, np.linspace(x[16], x[18], 9)) == 0.0)
    for n in (5, 7, 15):
        rows, near = np.stack([y[:n], y[-n:]]), np.linspace(x[0] - 0.3, x[n - 1] + 0.3, 101)
        exact = CubicSpline(x[:n], rows, axis=-1)(near)
        np.testing.assert_allclose(cubic_spline(x[:n], rows, near), exact, atol=1e-12 * n)
        np.testing.assert_allclose(cubic_spline(x[:n], rows[1], near), exact[1], atol=1e-12 * n)


def test_edges_far_longer_than_the_lines_of_contact_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A face width of micrometres gave thousands of contact points, and gigabytes of compliance."""
    monkeypatch.setattr("efficiency.cutting.blank.NARROWEST_FACE", 0.0)
    path = tmp_path / "narrow.toml"
    path.write_text(data_path("designs", f"{BEVEL}.toml").read_text().replace('"25.4 mm"', '"0.0254 mm"'))
    with fails("short_lines"):
        Mesh.of(load_design(path))
