"""Deflections: shafts and bearings under the mesh force, and a table over the torque of both flanks."""

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from refusals import fails, refuses
from scipy.optimize import minimize

from efficiency.contact.assembly import Assembly, RigidMove, displaced_axes
from efficiency.design.design import Design, load_design
from efficiency.design.shaft_input import MISALIGNMENTS, Deflection, MemberStiffnessInput, Misalignment, StiffnessInput
from efficiency.ltca import shaft_deflection
from efficiency.ltca.mesh_grids import MeshGrids
from efficiency.ltca.shaft_deflection import shaft_compliance
from efficiency.mesh import LoadedMesh
from efficiency.pair import GearPair
from ehl.common.data import data_path
from ehl.common.errors import InputError
from ehl.common.validation import validate

PAIR = "fm_hypoid_13x42_relieved"
BEARINGS = [{"position": 0.15, "radial": 4e8, "axial": 2e8}, {"position": 0.23, "radial": 3e8}]
OF_GEAR = [{"position": -0.08, "radial": 5e8}, {"position": 0.08, "radial": 5e8, "axial": 3e8}]
SHAFTS: dict[str, Any] = {
    "pinion": {"reference_point": 0.11, "shaft_diameter": 0.06, "bearings": BEARINGS},
    "gear": {"reference_point": 0.03, "shaft_diameter": 0.08, "bearings": OF_GEAR},
}


def on(given: dict[str, Any]) -> Design:
    start = load_design(PAIR)
    stiffness = validate(StiffnessInput, given, "assembly.stiffness")
    return start.model_copy(update={"assembly": start.assembly.model_copy(update={"stiffness": stiffness})})


def loaded(design: Design) -> LoadedMesh:
    return GearPair(design).mesh(positions=4, points_per_line=9).load(200.0)


def test_overhung_shaft_by_hand() -> None:
    """Statics of the bearings, integral of M^2/EI and of the shear force; moment by Castigliano."""
    a, span, near, far, d, e, nu = 0.04, 0.08, 4e8, 3e8, 0.06, 2.1e11, 0.3
    bending = e * math.pi * d**4 / 64.0
    shear = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu) * e / 2.6 * math.pi * d**2 / 4.0
    found = shaft_compliance(0.11, [(0.15, near, 2e8), (0.23, far, 0.0)], d, 0.0, e, nu)
    by_force = a**2 * (span + a) / (3.0 * bending) + (a + a**2 / span) / shear
    by_force += ((span + a) / span) ** 2 / near + (a / span) ** 2 / far
    by_moment = (a + span / 3.0) / bending + 1.0 / (span * shear) + (1.0 / near + 1.0 / far) / span**2
    axial = 1.0 / 2e8 + a / (e * math.pi * d**2 / 4.0)
    assert np.diag(found)[[0, 1, 2, 4]] == pytest.approx([by_force, by_force, axial, by_moment], rel=1e-9)
    # a force at the overhung end along x lifts it there: the slope falls towards the bearings
    assert found[0, 4] < 0.0 < found[1, 3]
    assert np.linalg.eigvalsh(found / np.sqrt(np.outer(np.diag(found), np.diag(found)))).min() > 0.0


def test_axes_by_the_common_normal() -> None:
    """Feet of the common normal from a search along both lines."""
    placed = Assembly(13, 42, 1.4, 0.03, E=1e-4, P=-2e-4, G=1e-4, shaft_angle_error=1e-3)
    rng = np.random.default_rng(3)
    moves = [RigidMove(*(rng.normal(size=3) * scale for scale in (0.1, 1e-3, 5e-3))) for _ in range(2)]
    found = displaced_axes(placed, *moves)
    origins = placed.pinion_origin[:, 0], np.array([0.0, 0.0, placed.G])
    axes = placed.pinion_axis[:, 0], np.array([0.0, 0.0, 1.0])
    lines = [(move.moved(at), move.turned(way)) for move, at, way in zip(moves, origins, axes, strict=True)]

    def apart(way: np.ndarray) -> float:
        return float(np.sum((lines[0][0] - way[0] * lines[0][1] - lines[1][0] + way[1] * lines[1][1]) ** 2)) * 1e6

    best = minimize(apart, [0.0, 0.0], method="BFGS", options={"gtol": 1e-12})
    assert placed.offset + found.E == pytest.approx(math.sqrt(best.fun * 1e-6), abs=1e-9)
    assert pytest.approx(tuple(best.x), abs=1e-7) == (found.P, found.G)
    angle = math.acos(lines[0][1] @ lines[1][1])
    assert placed.shaft_angle + found.shaft_angle_error == pytest.approx(angle, abs=1e-12)


def test_axes_that_stay() -> None:
    placed = Assembly(13, 42, 1.4, -0.03, E=1e-4, P=-2e-4, G=1e-4, shaft_angle_error=1e-3)
    rest = RigidMove(np.zeros(3), np.zeros(3), np.zeros(3))
    found = displaced_axes(placed, rest, rest)
    # a right-hand pinion has its offset along -y, and the normal turns with the axes, not with the offset
    assert (found.E, found.P, found.G, found.shaft_angle_error) == pytest.approx((1e-4, -2e-4, 1e-4, 1e-3), abs=1e-15)
    np.testing.assert_allclose(found.frame, np.eye(3), atol=1e-15)


def rounds_of(monkeypatch: pytest.MonkeyPatch, answer: Any) -> tuple[float, float, int]:
    """E, shaft angle and rounds of the equilibrium where a load answers to E and 0.1 m shaft angle with others."""
    placed = Assembly(13, 42, 1.4, 0.03)

    def moved(placed: Any, compliances: Any, load: Any, now: Any) -> Any:
        E, turned = answer(np.array([now.E, 0.1 * now.shaft_angle_error]))
        return replace(now, E=float(E), shaft_angle_error=10.0 * float(turned))

    mesh = MeshGrids("stub", "drive", (), (), None, 9)  # type: ignore[arg-type]
    monkeypatch.setattr(shaft_deflection, "axes_under_load", moved)
    monkeypatch.setattr(shaft_deflection, "load_grids", lambda *_: SimpleNamespace(coarse=SimpleNamespace(reason="")))
    found = shaft_deflection.solve_deflection(placed, (None, None), 1.0, (lambda _: mesh,)).deflection
    return found.E, found.shaft_angle_error, found.rounds


def test_rounds_with_secants_settle_where_plain_rounds_grow(monkeypatch: pytest.MonkeyPatch) -> None:
    """A load that answers to a displacement with 1.5 times as much, the other way: solved, by the solution at hand."""
    matrix, start = np.array([[-1.5, 0.2], [0.1, 0.4]]), np.array([1e-4, 3e-5])
    E, shaft_angle_error, rounds = rounds_of(monkeypatch, lambda x: start + matrix @ x)
    expected = np.linalg.solve(np.eye(2) - matrix, start)
    assert pytest.approx([expected[0], 10.0 * expected[1]], abs=1e-9) == [E, shaft_angle_error]
    assert rounds <= 5
    # shafts without an equilibrium
    with fails("deflection_limit"):
        rounds_of(monkeypatch, lambda x: np.array([-1e-4 if x[0] > 0.0 else 1e-4, 0.0]))


def test_same_as_stated_by_hand() -> None:
    """The misalignment that comes out, put in by hand, gives the same contact; rounds end at the tolerance."""
    soft = loaded(on(SHAFTS))
    moved = soft.grids.mesh.deflection
    assert 0.0 <= moved.change < 1e-7
    by_hand = load_design(PAIR).with_misalignment(**{name: getattr(moved, name) for name in MISALIGNMENTS})
    result, same = (each.efficiency("constant:0.05") for each in (soft, loaded(by_hand)))
    assert result.efficiency == pytest.approx(same.efficiency, abs=1e-9)
    assert result.pressure_hertz_max == pytest.approx(same.pressure_hertz_max, rel=1e-5)
    assert result.deflection["E"] == moved.E


def test_matrix_of_the_shaft_is_the_shaft() -> None:
    """Inverse of the compliance as a matrix, with the digits that a listing has."""
    pinion = validate(MemberStiffnessInput, SHAFTS["pinion"])
    matrix = np.linalg.inv(pinion.compliance().matrix)
    listed = [[float(f"{x:.8g}") for x in row] for row in matrix]
    same = validate(MemberStiffnessInput, {"reference_point": 0.11, "matrix": listed})
    np.testing.assert_allclose(same.compliance().matrix, pinion.compliance().matrix, rtol=1e-5, atol=1e-18)


GOOD = 1e8 * np.eye(6)


def changed(i: int, j: int, value: float) -> list[list[float]]:
    matrix = GOOD.copy()
    matrix[i, j] = value
    return matrix.tolist()  # type: ignore[no-any-return]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"matrix": changed(2, 2, -1.0)}, "row 3"),
        ({"matrix": changed(0, 1, 1e7)}, "row 1, column 2"),
        ({"matrix": (GOOD + 2e8 * (np.eye(6, k=1) + np.eye(6, k=-1))).tolist()}, "smallest eigenvalue -"),
        ({"matrix": changed(0, 0, math.nan)}, "matrix"),
        ({"matrix": GOOD[:, :5].tolist()}, "matrix"),
        ({}, "either a matrix or bearings"),
        ({"bearings": SHAFTS["pinion"]["bearings"][:1], "shaft_diameter": 0.05}, "two bearings"),
        ({"bearings": SHAFTS["pinion"]["bearings"]}, "shaft_diameter"),
        (SHAFTS["pinion"] | {"shaft_bore": 0.07}, "shaft_bore"),
        ({"bearings": [{"position": z, "radial": 1e8} for z in (0.1, 0.2)], "shaft_diameter": 0.05}, "axial"),
    ],
)
def test_bad_input(given: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        validate(MemberStiffnessInput, {"reference_point": 0.1} | given)


def test_shafts_of_rubber_are_refused() -> None:
    with refuses("assembly.stiffness"):
        loaded(on({"pinion": {"reference_point": 0.1, "matrix": (1e5 * np.eye(6)).tolist()}}))


TABLED = "fm_spiral_bevel_14x39_relieved"
TABLE = """torque [N m];E [um];P [um];G [um];alpha [arcmin]
-300;10;-20;5;0
300;-40;30;20;1
0;-4;2;0;0
600;-70;50;30;2
"""


def made(folder: Path, text: str) -> Design:
    (folder / "deflections.csv").write_text(text, encoding="utf-8")
    content = data_path("designs", f"{TABLED}.toml").read_text(encoding="utf-8")
    path = folder / "own.toml"
    path.write_text(content + '\n[assembly.deflection]\ntable = "deflections.csv"\n', encoding="utf-8")
    return load_design(path)


def test_rows_are_interpolated_for_both_flanks(tmp_path: Path) -> None:
    design = made(tmp_path, TABLE)
    for torque, side, expected in (
        (450.0, "drive", (-55e-6, 40e-6, 25e-6, math.radians(1.5 / 60.0))),
        (150.0, "coast", (3e-6, -9e-6, 2.5e-6, 0.0)),
        (0.0, "drive", (-4e-6, 2e-6, 0.0, 0.0)),
    ):
        moved = design.under_torque(torque, side).assembly.misalignment
        assert [getattr(moved, name) for name in MISALIGNMENTS] == pytest.approx(expected, abs=1e-12)
    with refuses("assembly.deflection.table"):
        design.under_torque(400.0, "coast")
    without_zero = made(tmp_path, "torque [N m],E [um]\n300,30\n")
    assert pytest.approx(10e-6) == without_zero.under_torque(100.0).assembly.misalignment.E
    # displacements stated at one torque
    given = {"misalignment": Misalignment(P=1e-5), "deflection": Deflection(E=1e-4, torque=300.0)}
    one = design.model_copy(update={"assembly": design.assembly.model_copy(update=given)})
    moved = one.under_torque(150.0).assembly.misalignment
    assert pytest.approx((0.5e-4, 1e-5)) == (moved.E, moved.P)
    with pytest.raises(ValidationError, match="the pinion torque of these displacements"):
        Deflection(E=1e-4)


def test_tables_that_cannot_be_used_are_refused(tmp_path: Path) -> None:
    head = "torque [N m],E [um]\n"
    for text in ("torque [N m]\n300\n", f"{head}300,3000\n", f"{head}300,30\n300,20\n", "torque,E\n300,30\n"):
        with pytest.raises(InputError):
            made(tmp_path, text)
    # nor a table next to values at one torque
    with pytest.raises(InputError):
        validate(Deflection, {"table": [[300.0, 1e-5, 0.0, 0.0, 0.0]], "E": "10 um", "torque": "300 N m"})


def test_efficiency_with_a_table_is_that_of_the_misaligned_pair(tmp_path: Path) -> None:
    design = made(tmp_path, TABLE)
    assert validate(Design, design.model_dump()) == design
    moved = load_design(TABLED).with_misalignment(E=-40e-6, P=30e-6, G=20e-6, shaft_angle_error=math.radians(1 / 60))
    found, expected = (GearPair(pair).at("constant:0.05", grid=(4, 9), torque=300.0) for pair in (design, moved))
    assert found.efficiency == pytest.approx(expected.efficiency, rel=1e-9)
    assert found.pressure_hertz_max == pytest.approx(expected.pressure_hertz_max, rel=1e-9)
