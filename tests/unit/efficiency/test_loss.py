"""Loss, result, map and what they refuse, on a small real mesh."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from refusals import fails, refuses
from samples import AXLE_OIL as OIL
from samples import BEVEL as DESIGN
from samples import OPERATION, tiny_load, tiny_mesh

from efficiency.loss.closed_form import coleman_type
from efficiency.loss.efficiency import LoadedGrids, MeshGrids, load_grids, mesh_efficiency
from efficiency.loss.kinematics import LoadedPoints, Operation
from efficiency.loss.power_loss import efficiency_of, position_losses
from efficiency.ltca.load_distribution import distribute_load
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


@pytest.fixture(scope="module")
def mesh() -> MeshGrids:
    return tiny_mesh().grids


@pytest.fixture(scope="module")
def loaded(mesh: MeshGrids) -> LoadedGrids:
    return tiny_load()


def test_power_is_friction_force_times_sliding_speed() -> None:
    state = ContactState.of(
        pressure_hertz=[1e9, 1e9, 1e9], radius_equivalent=0.01, effective_modulus=226e9, speed_entrainment=2.0
    )
    points = LoadedPoints(
        state, np.array([100.0, 50.0, 10.0]), np.array([1.0, 2.0, 3.0]), np.array([0, 0, 2]), np.array([0, 1, 0])
    )
    np.testing.assert_allclose(position_losses(points, np.array([0.1, 0.05, 0.2]), 3), [15.0, 0.0, 6.0])
    assert efficiency_of(7.0, 10.0, 7.0) == pytest.approx(0.9)


def test_points_outside_the_range_are_told(loaded: LoadedGrids) -> None:
    result = mesh_efficiency(loaded, FromPressure(), OIL, OPERATION)
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
def test_missing_friction_is_a_failure_not_a_number(loaded: LoadedGrids, flag: FrictionFlag, reason: str) -> None:
    result = mesh_efficiency(loaded, FromPressure(worse=flag), OIL, OPERATION)
    assert (result.status, result.reason) == ("failed", reason)
    assert math.isnan(result.efficiency)
    # points without friction count with the mean friction of the others
    mu, unknown = result.friction.mu, np.isnan(result.friction.mu)
    lost = np.where(unknown, np.nanmean(mu), mu) * result.points.force * result.points.speed_sliding
    shares = result.friction_range.flag_shares
    assert shares[flag.name.lower()] == pytest.approx(lost[unknown].sum() / lost.sum())
    assert result.to_dict()["efficiency"] is None


def test_pressure_above_the_hardness_fails_and_says_where(mesh: MeshGrids) -> None:
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
    arcsec = math.degrees(near.at(grid=COARSE).cycle.transmission_error_unloaded) * 3600.0
    assert any(f"transmission error, {arcsec:.0f} arcsec peak to peak" in note for note in near.at(grid=COARSE).notes)
    with fails("transmission"):
        far.at(grid=COARSE)


def test_failed_load_is_a_failure(mesh: MeshGrids, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("efficiency.ltca.equilibrium.NEWTON_LIMIT", 1)
    result = mesh_efficiency(load_grids(mesh, 200.0), ConstantFriction(0.05), OIL, OPERATION)
    assert (result.status, result.reason) == ("failed", "load_newton_limit")
    assert math.isnan(result.efficiency)


IMPOSSIBLE: dict[str, tuple[Any, ...]] = {
    "torque": (0.0, -300.0, math.nan, math.inf, 1e300),
    "speed": (0.0, -1.0, math.nan, 5001.0),
    "temperature": (80.0, 90.0, 600.0, math.nan),
}


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in IMPOSSIBLE.items() for value in values])
def test_impossible_conditions_are_refused(mesh: MeshGrids, name: str, value: float) -> None:
    """At one point, over a grid, and of the torque where loads are distributed; ranges are those of the design file."""
    with refuses(name):
        PAIR.at(grid=COARSE, **{name: value})
    with refuses(name):
        PAIR.over(grid=COARSE, **{name: [value]})
    if name == "torque" and not 0.0 < value < math.inf:
        with refuses("torque"):
            distribute_load(mesh.elastic_fine, mesh.teeth, value)


@pytest.mark.parametrize("grid", [(5, 9), (2, 9), (4, 3), (4.5, 9)])
def test_impossible_grids_are_refused(grid: tuple[int, int]) -> None:
    with pytest.raises(InputError, match=r"positions|points_per_line"):
        PAIR.at(grid=grid)


def test_impossible_roughness_is_refused() -> None:
    # the design file allows 20 um
    assert Operation(100.0, 363.15, 2e-5, 2e-5).roughness_rms_pinion == 2e-5
    for rough, member in (((0.0, -1e-7), "gear"), ((2.1e-5,), "pinion")):
        with refuses(f"roughness_rms_{member}"):
            Operation(100.0, 363.15, *rough)


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
    map_ = PAIR.mesh("drive", *COARSE).map("xu_kahraman_2007", [300.0, 100.0], None, [333.15, 363.15])
    assert map_.shape == (2, 1, 2)
    assert map_.values()[0, 0, 1] == pytest.approx(result.efficiency, abs=2e-5)
