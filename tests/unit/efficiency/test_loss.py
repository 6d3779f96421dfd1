"""Loss, result and what they refuse, on a small real mesh; load distributions in and out as CSV."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from refusals import fails, refuses
from samples import AXLE_OIL as OIL
from samples import BEVEL as DESIGN
from samples import OPERATION, tiny_load, tiny_mesh

from efficiency.loss.closed_form import coleman_type
from efficiency.loss.efficiency import mesh_efficiency
from efficiency.loss.kinematics import LoadedPoints
from efficiency.loss.power_loss import efficiency_of, position_losses
from efficiency.ltca.external_load import read_load, write_load
from efficiency.ltca.load_distribution import distribute_load
from efficiency.ltca.mesh_grids import LoadedGrids, load_grids
from efficiency.pair import GearPair
from ehl.common.errors import InputError
from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.friction.conditions import Conditions
from regression.friction.models import ConstantFriction, FrictionEstimate, FrictionFlag, FrictionModel

PAIR, COARSE = GearPair(DESIGN), (4, 9)


@dataclass(frozen=True)
class FromPressure(FrictionModel):
    """mu proportional to pressure, with an interval of 10 % and flags above a pressure."""

    name: str = "test"
    limit: float = 1e9
    worse: FrictionFlag = FrictionFlag.OUTSIDE_RANGE

    def evaluate(self, conditions: Conditions, oil: Oil) -> FrictionEstimate:
        mu = 0.05 * conditions["pressure_hertz"] / 1e9
        beyond = conditions["pressure_hertz"] > self.limit
        if self.worse >= FrictionFlag.NOT_CONVERGED:
            mu = np.where(beyond, np.nan, mu)
        return FrictionEstimate(mu, 0.9 * mu, 1.1 * mu, np.where(beyond, self.worse, 0).astype(np.int8))


def test_power_is_friction_force_times_sliding_speed() -> None:
    one = {"radius_equivalent": 0.01, "effective_modulus": 226e9, "speed_entrainment": 2.0}
    state, at = ContactState.of(pressure_hertz=[1e9, 1e9, 1e9], **one), (np.array([0, 0, 2]), np.array([0, 1, 0]))
    points = LoadedPoints(state, np.array([100.0, 50.0, 10.0]), np.array([1.0, 2.0, 3.0]), *at)
    np.testing.assert_allclose(position_losses(points, np.array([0.1, 0.05, 0.2]), 3), [15.0, 0.0, 6.0])
    assert efficiency_of(7.0, 10.0, 7.0) == pytest.approx(0.9)


def test_points_outside_the_range_are_told() -> None:
    result = mesh_efficiency(tiny_load(), FromPressure(), OIL, OPERATION)
    pressure = result.points.state.pressure_hertz
    power = result.points.force * result.points.speed_sliding
    assert result.outside_range_share == pytest.approx(power[pressure > 1e9].sum() / power.sum())
    assert result.friction_range.flags["outside_range"] == np.count_nonzero(pressure > 1e9) > 0
    lost = result.friction.mu * power
    assert result.friction_range.flag_shares["outside_range"] == pytest.approx(lost[pressure > 1e9].sum() / lost.sum())
    assert result.status == "converged"


@pytest.mark.parametrize(
    ("flag", "reason"),
    [(FrictionFlag.NOT_CONVERGED, "friction_not_converged"), (FrictionFlag.UNDEFINED, "friction_undefined")],
)
def test_missing_friction_is_a_failure_not_a_number(flag: FrictionFlag, reason: str) -> None:
    result = mesh_efficiency(tiny_load(), FromPressure(worse=flag), OIL, OPERATION)
    assert (result.status, result.reason) == ("failed", reason)
    assert math.isnan(result.efficiency)
    # points without friction count with the mean friction of the others
    mu, unknown = result.friction.mu, np.isnan(result.friction.mu)
    lost = np.where(unknown, np.nanmean(mu), mu) * result.points.force * result.points.speed_sliding
    shares = result.friction_range.flag_shares
    assert shares[flag.name.lower()] == pytest.approx(lost[unknown].sum() / lost.sum())
    assert result.to_dict()["efficiency"] is None


def test_pressure_above_the_hardness_fails_and_says_where() -> None:
    mesh = tiny_mesh().grids
    soft = mesh.teeth.material_gear.model_copy(update={"hardness": 1.2e9})
    weak = replace(mesh, teeth=replace(mesh.teeth, material_gear=soft))
    result = mesh_efficiency(load_grids(weak, 200.0), ConstantFriction(0.05), OIL, OPERATION)
    assert (result.status, result.reason) == ("failed", "pressure_above_hardness")
    assert np.isnan([result.efficiency, result.power_loss]).all()
    assert result.pressure_hertz_max == result.points.state.pressure_hertz.max()
    # a torque at which no point reaches it
    light = mesh_efficiency(load_grids(weak, 5.0), ConstantFriction(0.05), OIL, OPERATION)
    assert light.status == "converged"


def test_flanks_that_do_not_match_are_noted_or_refused() -> None:
    """The shipped bevel pair with the axes moved apart as if it were a hypoid pair."""
    near, far = (
        GearPair(DESIGN.model_copy(update={"assembly": DESIGN.assembly.model_copy(update={"hypoid_offset": offset})}))
        for offset in (0.003, 0.01)
    )
    result = near.at(grid=COARSE)
    arcsec = math.degrees(result.cycle.transmission_error_unloaded) * 3600.0
    assert any(f"transmission error, {arcsec:.0f} arcsec peak to peak" in note for note in result.notes)
    with fails("transmission"):
        far.at(grid=COARSE)


def test_failed_load_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("efficiency.ltca.equilibrium.NEWTON_LIMIT", 1)
    result = mesh_efficiency(load_grids(tiny_mesh().grids, 200.0), ConstantFriction(0.05), OIL, OPERATION)
    assert (result.status, result.reason) == ("failed", "load_newton_limit")
    assert math.isnan(result.efficiency)


IMPOSSIBLE: dict[str, tuple[Any, ...]] = {
    "torque": (0.0, -300.0, math.nan, math.inf, 1e300),
    "speed": (0.0, -1.0, math.nan, 5001.0),
    "temperature": (80.0, 90.0, 600.0, math.nan),
    "roughness_rms_pinion": (2.1e-5,),
    "roughness_rms_gear": (-1e-7,),
    "correlation_length": (1e-9,),
    "peklenik_number": (0.0,),
}


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in IMPOSSIBLE.items() for value in values])
def test_impossible_conditions_are_refused(name: str, value: float) -> None:
    """At one point, over a grid, and of the torque where loads are distributed; ranges are those of the design file."""
    with refuses(name):
        PAIR.at(grid=COARSE, **{name: value})
    with refuses(name):
        PAIR.over(grid=COARSE, **{name: [value]})
    if name == "torque" and not 0.0 < value < math.inf:
        with refuses("torque"):
            distribute_load(tiny_mesh().grids.elastic_fine, tiny_mesh().grids.teeth, value)


def test_roughness_of_the_design_file_is_allowed() -> None:
    assert PAIR.at("constant:0.05", grid=COARSE, roughness_rms_pinion=2e-5).conditions.roughness_rms_pinion == 2e-5


def test_run_functions_agree() -> None:
    result = PAIR.at("xu_kahraman_2007", grid=COARSE)
    assert result.conditions.torque == DESIGN.operation.torque
    comparison = PAIR.compare(("xu_kahraman_2007",), grid=COARSE)
    assert comparison.rows[0].efficiency == result.efficiency
    fitted = comparison.rows[1]
    assert fitted.name.endswith("fitted to xu_kahraman_2007")
    # the same mean mu, spread otherwise over the flank: the forces that balance it are not quite the same
    assert fitted.power_loss == pytest.approx(result.power_loss, rel=2e-3)
    plain = PAIR.compare(("xu_kahraman_2007",), grid=COARSE, load_balance="frictionless")
    assert plain.rows[1].power_loss == pytest.approx(plain.rows[0].power_loss, rel=1e-12)
    # Coleman's constant and the fitted one in both closed forms
    assert [row.kind for row in comparison.rows] == ["mesh"] * 2 + ["closed form"] * 4
    closed = next(row for row in comparison.rows if row.name == "Coleman-type (this work)")
    assert closed.efficiency == coleman_type(PAIR.mesh("drive", *COARSE).pitch, 0.05)
    for row in comparison.rows:
        assert row.power_loss == pytest.approx((1.0 - row.efficiency) * result.power_input, rel=1e-9)
    assert np.sum(comparison.rows[0].loss_regions) == pytest.approx(1.0, rel=1e-12)


@pytest.fixture(scope="module")
def lines(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    path = tmp_path_factory.mktemp("load") / "load.csv"
    write_load(tiny_load(300.0).fine, tiny_load(300.0).thermal, path)
    return path.read_text(encoding="utf-8").splitlines()


def read(lines: list[str], folder: Path, torque: float | None = None) -> LoadedGrids:
    path = folder / "load.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return read_load(path, tiny_mesh().flanks, tiny_mesh().grids.teeth, torque)


def test_round_trip(lines: list[str], tmp_path: Path) -> None:
    foreign = read(lines, tmp_path)
    assert foreign.fine.torque_residual < 1e-12
    for p, q in zip(tiny_load(300.0).fine.positions, foreign.fine.positions, strict=True):
        assert q.share.keys() == {pair for pair, share in p.share.items() if share > 0.0}
        assert q.force.sum() == pytest.approx(p.force.sum(), rel=1e-13)
    result = mesh_efficiency(foreign, ConstantFriction(0.05), OIL, OPERATION)
    assert result.status == "converged"
    assert result.to_dict()["cycle"]["transmission_error_loaded"] is None


@pytest.mark.parametrize("spreadsheet", [False, True])
def test_a_saved_load_gives_the_loss_of_the_run(spreadsheet: bool, tmp_path: Path) -> None:
    """Friction in the torque balance, warm teeth and contact at edges; also as a German spreadsheet saves the file."""
    loaded, path = tiny_mesh().load(300.0), tmp_path / "load.csv"
    runs: list[tuple[str, Literal["estimate", "oil"]]] = [("constant:0.1", "oil"), ("constant:0.1", "estimate")]
    for model, bulk in (*runs, ("xu_kahraman_2007", "estimate")):
        own = loaded.efficiency(model, bulk=bulk)
        loaded.write_load(path, own)
        if spreadsheet:
            text = path.read_text(encoding="utf-8").replace(",", ";").replace(".", ",")
            head, friction, *rest = text.replace("constant:0,1;", "constant:0.1,").splitlines()
            path.write_bytes("\r\n".join([f"{head};;;;", friction, *rest]).encode("utf-16"))
        again = tiny_mesh().load_from(path).efficiency(model, bulk=bulk)
        assert again.conditions.load_balance == "frictional"
        warm, own_warm = (each.conditions.temperature_bulk_pinion for each in (again, own))
        assert warm == pytest.approx(own_warm, abs=1e-6)
        assert again.power_loss == pytest.approx(own.power_loss, rel=1e-9)
        assert again.pressure_hertz_max == pytest.approx(own.pressure_hertz_max, rel=1e-9)
        np.testing.assert_allclose(again.forces.gear.axial, own.forces.gear.axial, rtol=1e-6)
        assert again.to_dict()["forces"]["stiffness"] == [None] * 4


def test_other_units_and_load_per_length(lines: list[str], tmp_path: Path) -> None:
    names = [name.split(" [")[0] for name in lines[1].split(",")]
    old = dict(zip(names, zip(*(line.split(",") for line in lines[2:]), strict=True), strict=True))
    new: dict[str, list[Any]] = {
        "pinion_angle [deg]": [math.degrees(float(angle)) for angle in old["pinion_angle"]],
        "grid": old["grid"],
        "face_gear [um]": [1e3 * float(x) for x in old["face_gear"]],
        "height_gear [mm]": old["height_gear"],
        "load_per_length [N/mm]": [float(f) / float(s) for f, s in zip(old["force"], old["length"], strict=True)],
        "length [mm]": old["length"],
    }
    rows = [",".join(map(str, row)) for row in zip(*new.values(), strict=True)]
    foreign = read(["# torque = 0.3 kN m", ",".join(new), *rows], tmp_path)
    for p, q in zip(tiny_load(300.0).fine.positions, foreign.fine.positions, strict=True):
        assert q.force.sum() == pytest.approx(p.force.sum(), rel=1e-9)
        # the tooth pair follows from the place
        assert q.share.keys() == {pair for pair, share in p.share.items() if share > 0.0}


def test_points_in_space_without_lengths(lines: list[str], tmp_path: Path) -> None:
    """Points of contact lines in the mesh frame, at the place of their own moment of contact."""
    names = ["pinion_angle [rad]", "x [m]", "y [m]", "z [m]", "force [N]"]
    heavy, rows = tiny_load(300.0), []
    for p in heavy.fine.positions:
        for k in np.flatnonzero(p.force > 0.0):
            rows.append([repr(float(v)) for v in (p.position.pinion_angle, *p.position.position[k], p.force[k])])
    foreign = read(["# torque = 300 N m", ",".join(names), *map(",".join, rows)], tmp_path)
    own, again = (mesh_efficiency(mesh, ConstantFriction(0.05), OIL, OPERATION) for mesh in (heavy, foreign))
    assert again.efficiency == pytest.approx(own.efficiency, rel=1e-9)
    # lengths come from the spacing of the points: pressures agree but for the ends of the heavy parts
    one, two = (np.median([p.pressure_hertz.max() for p in mesh.fine.positions]) for mesh in (heavy, foreign))
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
def test_bad_files_are_refused_by_row(lines: list[str], tmp_path: Path, damage: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read(damage(lines), tmp_path)


def test_another_torque_and_a_missing_file_are_refused(lines: list[str], tmp_path: Path) -> None:
    with refuses("torque"):
        read(lines, tmp_path, 250.0)
    with refuses("load_from"):
        read_load(tmp_path / "absent.csv", tiny_mesh().flanks, tiny_mesh().grids.teeth)
