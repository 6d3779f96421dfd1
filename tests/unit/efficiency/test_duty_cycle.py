"""Energies of a duty cycle, and efficiency over any axes: each geometry and each load once."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from samples import AXLE_OIL as OIL
from samples import BEVEL as DESIGN
from samples import tiny_load, tiny_mesh

from efficiency.contact.gear_flanks import Side
from efficiency.loss import parameter_map as module
from efficiency.loss.duty import DutyRow
from efficiency.loss.duty_cycle import duty_cycle
from efficiency.loss.efficiency import LoadedGrids, MeshGrids, mesh_efficiency
from efficiency.loss.kinematics import Operation
from efficiency.loss.parameter_map import parameter_map
from efficiency.run import Conditions, run_gear, run_parameter_map
from ehl.io.errors import ConvergenceError, InputError
from regression.formula import friction_model

MODEL = friction_model("xu_kahraman_2007")
ROUGH = (0.4e-6, 0.4e-6)


def run(row: DutyRow) -> Operation:
    return Operation(abs(row.speed), row.temperature_oil, *ROUGH, driver=row.driver)


def mesh(side: Side = "drive") -> MeshGrids:
    return tiny_mesh(side).mesh


def load(side: Side, torque: float) -> LoadedGrids:
    return tiny_load(torque, side)


def test_energies_add_up() -> None:
    rows = [DutyRow(200.0, 125.0, 363.15, 2.0), DutyRow(-80.0, 200.0, 353.15, 0.5), DutyRow(200.0, 60.0, 343.15, 1.0)]
    asked: list[tuple[str, float]] = []

    def counted(side: Side, torque: float) -> LoadedGrids:
        asked.append((side, torque))
        return load(side, torque)

    cycle = duty_cycle(rows, counted, MODEL, OIL, run)
    assert asked == [("drive", 200.0), ("coast", 80.0)]
    first, coast, _ = cycle.rows
    single = mesh_efficiency(load("drive", 200.0), MODEL, OIL, Operation(125.0, 363.15, *ROUGH))
    assert first.efficiency == single.efficiency
    assert first.energy_input == pytest.approx(200.0 * 125.0 * 7200.0, rel=1e-12)
    # on the coast side the gear drives, and what the pinion takes off is the output
    assert (coast.side, coast.driver) == ("coast", "gear")
    assert coast.energy_output == pytest.approx(80.0 * 200.0 * 1800.0, rel=1e-12)
    for row in cycle.rows:
        assert row.energy_input == pytest.approx(row.energy_output + row.energy_loss, rel=1e-14)
        assert row.efficiency == pytest.approx(row.energy_output / row.energy_input, rel=1e-12)
    assert cycle.efficiency == pytest.approx(1.0 - cycle.total("energy_loss") / cycle.total("energy_input"), rel=1e-14)
    content = cycle.to_dict()
    assert json.loads(json.dumps(content)) == content
    assert content["total"]["hours"] == 3.5


def test_a_failed_row_is_no_number() -> None:
    broken = replace(
        MODEL, formula=replace(MODEL.formula, local=lambda c, base: np.full(c["film_formula"].shape, np.nan))
    )
    cycle = duty_cycle([DutyRow(200.0, 125.0, 363.15, 2.0)], load, broken, OIL, run)
    assert (cycle.status, cycle.reason) == ("failed", "1 of 1 rows friction_undefined")
    assert cycle.to_dict()["total"]["efficiency"] is None


def operation(place: Mapping[str, Any]) -> Operation:
    rough = place.get("roughness_rms", 0.4e-6)
    return Operation(place.get("speed", 125.0), place.get("temperature_oil", 363.15), rough, rough)


def test_axes_in_any_order_and_each_load_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[Any] = []
    loads: list[float] = []

    def make_mesh(place: Mapping[str, Any]) -> MeshGrids:
        made.append(dict(place))
        if place["E"] > 0.0:
            raise ConvergenceError("no_contact")
        return mesh()

    def counted(given: MeshGrids, torque: float) -> LoadedGrids:
        loads.append(torque)
        return load("drive", torque)

    monkeypatch.setattr(module, "load_grids", counted)
    axes = {
        "temperature_oil": [333.15, 363.15],
        "E": [0.0, 1e-3],
        "torque": [100.0, 200.0],
        "roughness_rms": [2e-7, 4e-7],
    }
    done: list[tuple[int, int]] = []
    found = parameter_map(
        make_mesh, MODEL, OIL, axes, operation, lambda place: place["torque"], lambda *step: done.append(step)
    )
    assert found.shape == (2, 2, 2, 2)
    assert made == [{"E": 0.0}, {"E": 1e-3}]
    assert loads == [100.0, 200.0]
    assert done[-1] == (16, 16)
    values = found.values()
    expected = mesh_efficiency(load("drive", 200.0), MODEL, OIL, Operation(125.0, 363.15, 4e-7, 4e-7)).efficiency
    assert values[1, 0, 1, 1] == expected
    # a geometry that does not mesh is a reason at its points
    assert np.isnan(values[:, 1]).all()
    assert np.isfinite(values[:, 0]).all()
    assert found.reason == "8 of 16 points no_contact"
    assert json.dumps(found.to_dict())


def test_map_of_a_design_is_the_single_run() -> None:
    grid = {"positions": 4, "points_per_line": 9}
    found = run_parameter_map(DESIGN, MODEL, {"P": [5e-5], "speed": [60.0, 125.0]}, Conditions(torque=150.0), **grid)
    single = run_gear(DESIGN.with_misalignment(P=5e-5), MODEL, Conditions(torque=150.0, speed=125.0), **grid)
    assert found.values()[0, 1] == single.efficiency
    assert found.axes == {"P": (5e-5,), "speed": (60.0, 125.0)}


@pytest.mark.parametrize(
    ("axes", "words"),
    [
        ({"offset": [1.0]}, "one of design, E"),
        ({"torque": []}, "at least one value"),
        ({"torque": [-1.0]}, "above 0"),
        ({"roughness_rms": [1e-3]}, "roughness_rms"),
        ({"roughness_rms": [1e-7], "roughness_rms_gear": [1e-7]}, "either roughness_rms"),
    ],
)
def test_bad_axes(axes: dict[str, list[float]], words: str) -> None:
    with pytest.raises(InputError, match=words):
        run_parameter_map(DESIGN, MODEL, axes)
