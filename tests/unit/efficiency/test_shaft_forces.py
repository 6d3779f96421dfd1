"""Forces on both shafts and mesh stiffness over the mesh cycle."""

import json
import math
import pickle
from typing import Any

import numpy as np
import pytest

import efficiency
from efficiency.output.tables import position_table

pytestmark = pytest.mark.fast


def loaded(name: str, side: Any = "drive", torque: float | None = None, **state: str) -> efficiency.LoadedMesh:
    return efficiency.load(name).mesh(side, positions=4, points_per_line=9, **state).load(torque)


MOVED = {"E": "0.1 mm", "P": "-0.1 mm", "shaft_angle_error": "2 arcmin"}


@pytest.mark.parametrize(
    ("name", "side", "driver", "state"),
    [("fh_hypoid_9x34", "coast", "gear", {}), ("fm_hypoid_13x42", "drive", "pinion", MOVED)],
)
def test_forces_balance_torque_and_power(name: str, side: str, driver: str, state: dict[str, str]) -> None:
    mesh = loaded(name, side, **state)
    result = mesh.efficiency("constant:0.05", driver=driver)
    forces = result.forces
    np.testing.assert_allclose(forces.pinion.torque, mesh.torque, rtol=1e-12)
    share = forces.gear.torque.mean() * mesh.mesh.bevel.ratio / mesh.torque
    assert (share if driver == "pinion" else 1.0 / share) == pytest.approx(result.efficiency, rel=1e-9)
    shafts = forces.pinion, forces.gear
    np.testing.assert_allclose(*(s.axial**2 + s.radial**2 + s.tangential**2 for s in shafts), rtol=2e-12)
    for shaft in shafts:
        # one radius for all positions
        np.testing.assert_allclose(shaft.tangential * shaft.radius, shaft.torque, rtol=0.1)


@pytest.mark.parametrize(("name", "side"), [("fm_spiral_bevel_14x39", "drive"), ("fh_spiral_bevel_12x37", "coast")])
def test_forces_are_those_of_statics_at_the_mean_point(name: str, side: str) -> None:
    """Axial and radial force of a spiral bevel pair by the closed form of textbooks, without friction."""
    mesh = loaded(name, side)
    pitch, forces = mesh.mesh.pitch, mesh.forces()
    normal, spiral = pitch.pressure_angle, pitch.spiral_angle[0]
    way = 1.0 if side == "drive" else -1.0
    ahead = math.tan(normal) / math.cos(spiral), way * math.tan(abs(spiral))
    # the mean point of the force is above the pitch cone of the pinion and out of the plane of the axes, which turns
    # radial and tangential force of the pinion
    for shaft, angle, radius, sign, near in (
        (forces.pinion, pitch.pitch_angle[0], pitch.radius[0], 1.0, 0.05),
        (forces.gear, pitch.pitch_angle[1], pitch.radius[1], -1.0, 0.03),
    ):
        tangential = shaft.torque.mean() / radius
        axial = tangential * (ahead[0] * math.sin(angle) + sign * ahead[1] * math.cos(angle))
        radial = tangential * (ahead[0] * math.cos(angle) - sign * ahead[1] * math.sin(angle))
        assert shaft.axial.mean() == pytest.approx(axial, abs=near * tangential)
        if sign < 0.0:
            assert shaft.radial.mean() == pytest.approx(radial, abs=near * tangential)


def test_parallel_axes() -> None:
    """A helical pair has equal and opposite axial forces, T tan(beta)/r of the pitch circle at constant torque."""
    forces = efficiency.load("eaxle_helical_23x75").mesh().load().forces()
    np.testing.assert_allclose(forces.pinion.axial, -forces.gear.axial, rtol=1e-12)
    assert np.ptp(forces.pinion.axial) < 1e-9 * abs(forces.pinion.axial[0])


def test_forces_are_in_json_and_tables_of_a_result() -> None:
    mesh = loaded("fm_spiral_bevel_14x39")
    result = pickle.loads(pickle.dumps(mesh.efficiency("constant:0.05", load_balance="frictionless")))
    content = json.loads(json.dumps(result.to_dict(), allow_nan=False))["forces"]
    [first, *_] = position_table(result).records()
    assert first["force_axial_pinion"] == content["pinion"]["axial"][0]
    failed = mesh.mesh.load("5000 N m").efficiency("constant:0.05")
    assert failed.forces is None
    assert "forces" not in failed.to_dict()
