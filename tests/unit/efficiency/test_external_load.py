"""Load distributions in and out as CSV: round trip, other ways to give the same, files that cannot be used."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from refusals import refuses
from samples import AXLE_OIL as OIL
from samples import OPERATION, tiny_load, tiny_mesh

from efficiency.loss.efficiency import LoadedGrids, mesh_efficiency
from efficiency.ltca.external_load import read_load, write_load
from efficiency.mesh import Mesh
from ehl.common.errors import InputError
from regression.friction.models import ConstantFriction


@pytest.fixture(scope="module")
def geared() -> Mesh:
    return tiny_mesh()


@pytest.fixture(scope="module")
def loaded(geared: Mesh) -> LoadedGrids:
    return tiny_load(300.0)


@pytest.fixture(scope="module")
def lines(loaded: LoadedGrids, tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    path = tmp_path_factory.mktemp("load") / "load.csv"
    write_load(loaded.fine, loaded.thermal, path)
    return path.read_text(encoding="utf-8").splitlines()


def read(lines: list[str], folder: Path, geared: Mesh, torque: float | None = None) -> LoadedGrids:
    path = folder / "load.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return read_load(path, geared.flanks, geared.grids.teeth, torque)


def columns(lines: list[str]) -> dict[str, list[str]]:
    names = [name.split(" [")[0] for name in lines[1].split(",")]
    return dict(zip(names, map(list, zip(*(line.split(",") for line in lines[2:]), strict=True)), strict=True))


def test_round_trip(lines: list[str], loaded: LoadedGrids, geared: Mesh, tmp_path: Path) -> None:
    foreign = read(lines, tmp_path, geared)
    assert foreign.fine.torque_residual < 1e-12
    for p, q in zip(loaded.fine.positions, foreign.fine.positions, strict=True):
        assert q.share.keys() == {pair for pair, share in p.share.items() if share > 0.0}
        assert q.force.sum() == pytest.approx(p.force.sum(), rel=1e-13)
    result = mesh_efficiency(foreign, ConstantFriction(0.05), OIL, OPERATION)
    assert result.status == "converged"
    assert result.to_dict()["cycle"]["transmission_error_loaded"] is None


@pytest.mark.parametrize("spreadsheet", [False, True])
def test_a_saved_load_gives_the_loss_of_the_run(spreadsheet: bool, geared: Mesh, tmp_path: Path) -> None:
    """Friction in the torque balance, warm teeth and contact at edges; also as a German spreadsheet saves the file."""
    loaded, path = geared.load(300.0), tmp_path / "load.csv"
    runs: list[tuple[str, Literal["estimate", "oil"]]] = [("constant:0.1", "oil"), ("constant:0.1", "estimate")]
    for model, bulk in (*runs, ("xu_kahraman_2007", "estimate")):
        own = loaded.efficiency(model, bulk=bulk)
        loaded.write_load(path, own)
        if spreadsheet:
            text = path.read_text(encoding="utf-8").replace(",", ";").replace(".", ",")
            head, friction, *rest = text.replace("constant:0,1;", "constant:0.1,").splitlines()
            path.write_bytes("\r\n".join([f"{head};;;;", friction, *rest]).encode("utf-16"))
        again = geared.load_from(path).efficiency(model, bulk=bulk)
        assert again.conditions.load_balance == "frictional"
        warm, own_warm = (each.conditions.temperature_bulk_pinion for each in (again, own))
        assert warm == pytest.approx(own_warm, abs=1e-6)
        assert again.power_loss == pytest.approx(own.power_loss, rel=1e-9)
        assert again.pressure_hertz_max == pytest.approx(own.pressure_hertz_max, rel=1e-9)


def test_other_units_and_load_per_length(lines: list[str], loaded: LoadedGrids, geared: Mesh, tmp_path: Path) -> None:
    old = columns(lines)
    new: dict[str, list[Any]] = {
        "pinion_angle [deg]": [math.degrees(float(angle)) for angle in old["pinion_angle"]],
        "grid": old["grid"],
        "face_gear [um]": [1e3 * float(x) for x in old["face_gear"]],
        "height_gear [mm]": old["height_gear"],
        "load_per_length [N/mm]": [float(f) / float(s) for f, s in zip(old["force"], old["length"], strict=True)],
        "length [mm]": old["length"],
    }
    rows = [",".join(map(str, row)) for row in zip(*new.values(), strict=True)]
    foreign = read(["# torque = 0.3 kN m", ",".join(new), *rows], tmp_path, geared)
    for p, q in zip(loaded.fine.positions, foreign.fine.positions, strict=True):
        assert q.force.sum() == pytest.approx(p.force.sum(), rel=1e-9)
        # the tooth pair follows from the place
        assert q.share.keys() == {pair for pair, share in p.share.items() if share > 0.0}


def test_points_in_space_without_lengths(lines: list[str], loaded: LoadedGrids, geared: Mesh, tmp_path: Path) -> None:
    """Points of contact lines in the mesh frame, at the place of their own moment of contact."""
    names = ["pinion_angle [rad]", "x [m]", "y [m]", "z [m]", "force [N]"]
    rows = []
    for p in loaded.fine.positions:
        for k in np.flatnonzero(p.force > 0.0):
            rows.append([repr(float(v)) for v in (p.position.pinion_angle, *p.position.position[k], p.force[k])])
    foreign = read(["# torque = 300 N m", ",".join(names), *map(",".join, rows)], tmp_path, geared)
    own, again = (mesh_efficiency(mesh, ConstantFriction(0.05), OIL, OPERATION) for mesh in (loaded, foreign))
    assert again.efficiency == pytest.approx(own.efficiency, rel=1e-9)
    # lengths come from the spacing of the points: pressures agree but for the ends of the loaded parts
    one, two = (np.median([p.pressure_hertz.max() for p in mesh.fine.positions]) for mesh in (loaded, foreign))
    assert two == pytest.approx(one, rel=0.1)


def change(number: int, name: str, value: str) -> Callable[[list[str]], list[str]]:
    """A file with one other entry in the row of that line of the file."""

    def changed(lines: list[str]) -> list[str]:
        index = [entry.split(" [")[0] for entry in lines[1].split(",")].index(name)
        row = lines[number - 1].split(",")
        row[index] = value
        return [*lines[: number - 1], ",".join(row), *lines[number:]]

    return changed


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (change(5, "face_gear", "27.4"), "load.csv, row 5.*27.4 mm from the toe"),
        (change(7, "height_gear", "-3"), "load.csv, row 7.*root of the gear"),
        (change(4, "force", "nan"), "load.csv, row 4, force"),
        (change(6, "force", "-1"), "load.csv, row 6, force"),
        (lambda lines: ["# torque = 0 N m", *lines[1:]], "torque.*above 0 N m"),
        (lambda lines: ["# torque = 300", *lines[1:]], "line 1: torque.*unit"),
        (lambda lines: ["# torque = 400 N m", *lines[1:]], "about the pinion axis.*stated 400 N m"),
        (lambda lines: lines[1:], "torque is missing"),
        (lambda lines: lines[:2], "load.csv"),
        (lambda lines: [lines[0], lines[1].replace("face_gear [mm]", "face_gear"), *lines[2:]], "face_gear.*unit"),
        (lambda lines: [lines[0], lines[1].replace("[N]", "[kg]"), *lines[2:]], "force.*kg"),
        (lambda lines: [lines[0], lines[1].replace("force", "strength"), *lines[2:]], "strength"),
        (lambda lines: [lines[0], lines[1].replace("pair []", "x [mm]"), lines[2] + ",1", *lines[3:]], "row 3"),
        (lambda lines: [*lines[:2], *lines[-3:]], "grid 0"),
        # the first position is missing
        (lambda lines: [line for line in lines if line.split(",")[0] != lines[2].split(",")[0]], "pinion_angle"),
    ],
)
def test_bad_files_are_refused_by_row(
    lines: list[str], geared: Mesh, tmp_path: Path, damage: Callable[[list[str]], list[str]], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        read(damage(lines), tmp_path, geared)


def test_another_torque_and_a_missing_file_are_refused(lines: list[str], geared: Mesh, tmp_path: Path) -> None:
    with refuses("torque"):
        read(lines, tmp_path, geared, 250.0)
    with refuses("load_from"):
        read_load(tmp_path / "absent.csv", geared.flanks, geared.grids.teeth)
