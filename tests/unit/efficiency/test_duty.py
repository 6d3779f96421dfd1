"""`mixed-ehl plan`: designs and a duty cycle become the plan of a sweep."""

import json
import math
from functools import cache, partialmethod
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refuses

from efficiency.conditions.duty import DutyRow, read_duty
from efficiency.design.design import load_design
from efficiency.loss.efficiency import mesh_efficiency
from efficiency.loss.kinematics import Operation
from efficiency.pair import GearPair
from ehl.common.errors import InputError
from ehl.fluid.oil import Oil
from regression.formula import friction_model
from regression.plan.plan import Plan

DESIGN = "fm_spiral_bevel_14x39"
DUTY = """torque [N m],speed [rpm],temperature [degC],hours [h],# gear
300,1200,90,100,third
-80,2000,80,20,coast
0,500,40,5,idle
"""


@cache
def pair() -> GearPair:
    return GearPair(DESIGN)


@pytest.fixture
def duty(tmp_path: Path) -> Path:
    path = tmp_path / "duty.csv"
    path.write_text(DUTY)
    return path


def test_duty_cycles_are_read(duty: Path) -> None:
    rows = read_duty(duty)
    assert [(row.side, row.driver, row.hours) for row in rows] == [("drive", "pinion", 100.0), ("coast", "gear", 20.0)]
    assert (rows[0].speed, rows[0].temperature) == pytest.approx((40.0 * np.pi, 363.15))


def test_a_recording_of_a_vehicle(mixed_ehl: Any, tmp_path: Path) -> None:
    path = tmp_path / "cycle.csv"
    lines = ["Logger V3;2026-01-01", "Zeit [s];Geschwindigkeit [km/h];Radmoment [Nm];Gang"]
    lines += ["0,0;36,0;1.114,3;3", "1,0;72;-557,1;3", "3,0;Bad;200;3", "4,0;36,0;0;3"]
    path.write_bytes("\r\n".join(lines).encode("cp1252"))
    rows = read_duty(path, tyre_radius="0.32 m", ratio=39.0 / 14.0, temperature="80 C")
    assert [row.torque for row in rows] == pytest.approx([400.0, -200.0], rel=1e-3)
    assert [row.speed for row in rows] == pytest.approx([10.0 / 0.32 * 39 / 14, 20.0 / 0.32 * 39 / 14])
    assert [row.hours * 3600.0 for row in rows] == pytest.approx([1.0, 3.0])
    assert rows[0].temperature == pytest.approx(353.15)
    for name, value in (("ratio", math.nan), ("tyre_radius", "0 m"), ("temperature", "1e300 degC")):
        with refuses(name):  # also where the file does not need it
            read_duty(path, **{"tyre_radius": "0.32 m", "ratio": 2.0, "temperature": "80 C"} | {name: value})
    with refuses("tyre_radius"):
        read_duty(path, ratio=2.0, temperature=353.0)
    outcome = mixed_ehl("duty", DESIGN, path, "--tyre-radius", "0.32 m", "--json")
    assert outcome.code == 0, outcome.err
    assert json.loads(outcome.out)["total"]["hours"] == pytest.approx(4.0 / 3600.0)
    path.write_text("time [s],speed [km/h],torque [Nm],temperature [C]\n1,36,100,80\n1,36,100,80\n")
    with refuses("cycle.csv, column time"):
        read_duty(path, tyre_radius=0.3, ratio=2.0)


def test_reverse_is_a_negative_speed() -> None:
    """Driven backwards the coast flanks carry the torque and the power still comes from the pinion."""
    assert (DutyRow(-80.0, -100.0, 363.15, 1.0).side, DutyRow(-80.0, -100.0, 363.15, 1.0).driver) == ("coast", "pinion")
    assert (DutyRow(80.0, -100.0, 363.15, 1.0).side, DutyRow(80.0, -100.0, 363.15, 1.0).driver) == ("drive", "gear")


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("torque [N m]", "torque", "row 2, torque"),
        (",hours [h]", ",# hours", "column hours"),
        ("1200", "-120000", "row 2, speed"),
        ("100,third", "-1,third", "row 2, hours"),
        (DUTY[DUTY.index("300") :], "0,500,40,5,idle\n", "1 rows"),
    ],
)
def test_bad_duties(duty: Path, old: str, new: str, word: str) -> None:
    duty.write_text(DUTY.replace(old, new))
    with pytest.raises(InputError, match=word):
        read_duty(duty)


def test_weights_are_the_work_lost() -> None:
    """With a constant mu, mu times the weights is the energy the efficiency of the same mesh loses."""
    design = load_design(DESIGN)
    row = DutyRow(300.0, 125.0, 363.15, 2.0)
    (part,) = pair().duty_points([row], grid=(4, 9))
    operation = Operation(row.speed, row.temperature, design.pinion.roughness_rms, design.gear.roughness_rms)
    loaded = pair().mesh("drive", 4, 9).load(300.0).grids
    result = mesh_efficiency(loaded, friction_model("constant:0.05"), Oil.load("75w90"), operation)
    assert 0.05 * part.weight.sum() == pytest.approx(2.0 * result.power_loss, rel=1e-12)


def test_a_duty_becomes_a_plan(mixed_ehl: Any, duty: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(GearPair, "duty_points", partialmethod(GearPair.duty_points, grid=(4, 9)))
    target = tmp_path / "seen.toml"
    assert mixed_ehl("plan", DESIGN, "--duty", duty, "-o", target, "--size", "48", "--oil", "fva3").code == 0
    plan = Plan.from_file(target)
    assert plan.oil == "fva3"
    pressure, temperature = (plan.variables.axes[name].values for name in ("pressure_hertz", "temperature_oil"))
    assert 0.1e9 < pressure[0] < 1e9 < pressure[1] < 2.5e9
    assert temperature[0] < 353.15 < 363.15 < temperature[1]
    assert mixed_ehl("sweep", target, "--estimate").code == 0


@pytest.mark.parametrize(("head", "units", "hours"), [("hours", "", 5.0), ("hours", "N m,rpm,degC,s\n", 5.0 / 3600.0)])
def test_a_column_named_after_its_unit(tmp_path: Path, head: str, units: str, hours: float) -> None:
    path = tmp_path / "duty.csv"
    first = "torque,speed,temperature" if units else "torque [N m],speed [rpm],temperature [degC]"
    path.write_text(f"{first},{head}\n{units}100,1500,80,5\n", encoding="utf-8")
    assert [row.hours for row in read_duty(path)] == pytest.approx([hours])
