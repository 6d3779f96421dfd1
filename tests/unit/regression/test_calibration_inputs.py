"""Calibration: measured tables, setups, and exit code 2 with the field where they cannot be used."""

import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refused

from regression.calibration.calibrate import setup_of
from regression.calibration.measurement import read_measurement

SETUP = """
oil = "fva3"
parameters = ["eyring_stress", "boundary_friction"]
[conditions]
radius_equivalent = "9.525 mm"
temperature_oil = "80 degC"
roughness_rms = "80 nm"
[specimens]
geometry = "point"
"""
TABLE = """load [N],speed_entrainment [mm/s],slide_to_roll [%],friction_coefficient,curve
36,2500,5,0.030,a
36,2500,50,0.040,a
36,100,50,0.080,b
36,0,50,0.080,b
"""
GOOD = TABLE.replace("36,0,", "36,50,")
UNITS_BELOW = "load,speed_entrainment,slide_to_roll,friction_coefficient,curve\nN,mm/s,%,1,\n" + GOOD.partition("\n")[2]


def files(folder: Path, table: str = GOOD, setup: str = SETUP) -> tuple[Path, Path]:
    measured, given = folder / "measured.csv", folder / "setup.toml"
    measured.write_text(table, encoding="utf-8")
    given.write_text(setup, encoding="utf-8")
    return measured, given


def test_units_of_the_header_and_common_conditions(tmp_path: Path) -> None:
    measured, given = files(tmp_path)
    measurement = read_measurement(measured, setup_of(given).conditions.model_dump(exclude_none=True))
    assert (measurement.load, measurement.curve) == ("load", ("a", "a", "b", "b"))
    columns = {"speed_entrainment": [2.5, 2.5, 0.1, 0.05], "slide_to_roll": [0.05, 0.5, 0.5, 0.5]}
    for name, values in (columns | {"temperature_oil": 353.15, "roughness_rms": 80e-9}).items():
        np.testing.assert_allclose(measurement.columns[name], values)
    changed = tomllib.loads(SETUP) | {"surface": {"finish": "Superfinished"}}
    setup = setup_of(changed)
    assert setup.roughness_rms == pytest.approx(2.0**0.5 * setup.surface.roughness_rms_1)
    assert np.isnan(measurement.uncertainty).all()


RIG = """MTM Test Data File
Step 1 "Traction"\tstarted at 10:00
Rolling Speed (mm/s)\tTraction Coeff (-)\tLube Temp (°C)\tPot Temp (°C)\tBall Load (N)\tSRR (%)
"""


@pytest.mark.parametrize("signed", [True, False])
def test_slip_in_both_directions_is_folded_and_repeats_averaged(tmp_path: Path, signed: bool) -> None:
    measured, given = files(tmp_path, "", SETUP.replace('temperature_oil = "80 degC"\n', ""))
    rng, slips, offset = np.random.default_rng(5), (1.0, 5.0, 20.0, 50.0), 0.002
    truth = [0.05 * math.tanh(slip / 10.0) for slip in slips]
    lines = []
    for sign in (1, -1, 1):
        for slip, mu in zip(slips, truth, strict=True):
            value = (sign if signed else 1.0) * mu + (offset if signed else 0.0)
            cells = (2500.0 * (1.0 + 1e-3 * rng.standard_normal()), value, 79.9, 81.0, 36.02, sign * slip)
            lines.append("\t".join(f"{cell:.6g}" for cell in cells))
    lines.append("2500\t0.0515\t79.9\t81.0\t36.02\t100" if signed else "2500\t0.0495\t79.9\t81.0\t36.02\t100")
    measured.write_text(RIG + "\n".join(lines) + "\nAll steps completed\n", encoding="cp1252")
    found = read_measurement(measured, setup_of(given).conditions.model_dump(exclude_none=True))
    np.testing.assert_allclose(found.friction, [*truth, 0.0495], rtol=1e-4)
    np.testing.assert_allclose(found.columns["slide_to_roll"], [0.01, 0.05, 0.2, 0.5, 1.0])
    np.testing.assert_allclose(found.columns["temperature_oil"], 353.05)
    assert found.row_numbers == (4, 5, 6, 7, 16)
    assert ("+0.0020" in found.notes[0]) is signed


@pytest.mark.parametrize(
    ("table", "setup", "field"),
    [
        (TABLE, SETUP, "measured.csv, row 5, speed_entrainment"),
        (GOOD.replace("0.030", ""), SETUP, "row 2, friction_coefficient"),
        (GOOD.replace(",0.0", ",-0.0"), SETUP, "row 2, friction_coefficient"),  # friction against a positive slip
        (GOOD.replace("load [N]", "weight [N]"), SETUP, "weight"),
        (GOOD.replace("slide_to_roll", "u1"), SETUP, "slide_to_roll is (u1 - u2)"),
        (GOOD.replace("slide_to_roll", "#slip"), SETUP, "slide_to_roll is (u1 - u2)"),
        (GOOD.replace("load [N]", "#load"), SETUP, "pressure_hertz, load, load_per_length"),
        (RIG.replace("SRR (%)", "SRR") + "2500\t0.04\t80\t80\t36\t50\n", SETUP, "slide_to_roll"),
        (GOOD, SETUP.replace('temperature_oil = "80 degC"\n', ""), "column temperature_oil"),
        (GOOD, SETUP.replace('radius_equivalent = "9.525 mm"', 'load = "3 N"'), "conditions.load"),
        (GOOD, SETUP.replace('"boundary_friction"', '"tau0"'), "tau0"),
        (GOOD, SETUP.replace('"boundary_friction"', '"stress_slope"'), "stress_slope"),
        (GOOD, SETUP.replace('"boundary_friction"', '"eyring_stress"'), "once"),
        (GOOD, SETUP.replace('["eyring_stress", "boundary_friction"]', "[]"), "parameters"),
        (GOOD, SETUP.replace('"eyring_stress"', '"stress_low", "stress_slope"'), "parameters"),  # at one pressure
        (GOOD, SETUP.replace('roughness_rms = "80 nm"\n', ""), "boundary_friction"),
        (GOOD, SETUP.replace('geometry = "point"', 'geometry = "line"'), "specimens.length"),
        (GOOD, SETUP + "length = 0.01\n", "length"),
        (GOOD.replace("load [N]", "load [kN]"), SETUP, "row 2"),
        (UNITS_BELOW.replace("N,", "kN,"), SETUP, "row 3"),
        (GOOD.replace("load [N]", "load_per_length [N/m]"), SETUP, "specimens.geometry"),
        (GOOD, SETUP + "[noise]\nabsolute = 0.0\n", "noise"),
        (GOOD.replace("50,0.0", "0,0.0").replace("5,0.03", "0,0.03"), SETUP, "slide_to_roll"),
        ("\n".join(GOOD.splitlines()[:3]), SETUP, "2 rows"),
        (GOOD, SETUP + '[surface]\nroughness_rms_1 = "1 um"\n', "surface.roughness_rms_1"),
    ],
)
def test_refusals(mixed_ehl: Any, tmp_path: Path, table: str, setup: str, field: str) -> None:
    measured, given = files(tmp_path, table, setup)
    refused(mixed_ehl("calibrate", measured, "--setup", given, "--jobs", "1"), field)
