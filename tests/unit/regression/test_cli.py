"""The commands `sweep`, `fit` and `mu`, from plan to friction value, and bad input."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from refusals import refused
from small_plans import GEAR_VARIABLES, point_options

from regression.data.dataset import load_dataset

PLAN = 'name = "cli"\n[sampling]\nsize = 32\n' + GEAR_VARIABLES
Call = Callable[..., Any]


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    path = tmp_path / "plan.toml"
    path.write_text(PLAN)
    return path


@pytest.mark.usefixtures("little_training")
def test_plan_to_friction_value(mixed_ehl: Call, plan: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run, formula = tmp_path / "run", tmp_path / "formula.json"
    for number in (1, 2):
        shard = ("--shard", f"{number}/2", "--with", "xu_kahraman_2007", "--jobs", "1")
        assert "16 converged, 0 failed" in mixed_ehl("sweep", plan, "-o", run, *shard).out
    # the option first, and everything on disk already
    again = mixed_ehl("sweep", "-o", run, plan, "--shard", "1/2", "--with", "xu_kahraman_2007", "--jobs", "1")
    assert "16 found on disk, 0 converged" in again.out
    status = json.loads(mixed_ehl("sweep", "status", run, "--json").out)
    assert (status["planned"], status["finished"], status["complete"]) == (32, 32, True)
    assert len(status["shards"]) == 2
    for name in ("all.h5", "all.csv"):
        assert mixed_ehl("sweep", "merge", run, "-o", tmp_path / name).code == 0
    assert len((tmp_path / "all.csv").read_text().splitlines()) == 34
    assert load_dataset(tmp_path / "all.h5").data_hash == load_dataset(run).data_hash

    monkeypatch.setenv("COLUMNS", "80")
    fitted = mixed_ehl("fit", run, "-o", formula, "--plot", tmp_path / "parity.png")
    assert fitted.code == 0
    assert "…" not in fitted.out  # in 80 columns with nothing cut off
    assert (tmp_path / "parity.png").read_bytes().startswith(b"\x89PNG")

    value = json.loads(mixed_ehl("mu", formula, *point_options(), "--json").out)
    direct = json.loads(mixed_ehl("mu", "xu_kahraman_2007", *point_options(), "--oil", "fva3", "--json").out)
    assert value["friction_coefficient"] == pytest.approx(direct["friction_coefficient"], rel=1e-9)
    assert (value["flag"], value["oil"]) == ("ok", "fva3")
    assert value["friction_lower"] <= value["friction_coefficient"] <= value["friction_upper"]
    assert direct["friction_lower"] is None


def test_a_formula_without_a_value_gives_none_and_exit_code_1(mixed_ehl: Call) -> None:
    options = point_options(pressure="50 MPa", radius="1 mm", speed="200 m/s", temperature="0 degC")
    as_json = mixed_ehl("mu", "benedict_kelley_1961", *options, "--oil", "fva3", "--json")
    assert as_json.code == 1
    content = json.loads(as_json.out)
    assert content["flag"] == "undefined"
    assert content["friction_coefficient"] is content["friction_lower"] is content["friction_upper"] is None
    assert mixed_ehl("mu", "benedict_kelley_1961", *options, "--oil", "fva3").code == 1
    # outside of its range: a value with a note
    for pressure, noted in (("1 GPa", False), ("3 GPa", True)):
        found = mixed_ehl("mu", "xu_kahraman_2007", *point_options(pressure=pressure), "--oil", "fva3")
        assert (found.code, found.err != "") == (0, noted)
    along = point_options(lengthwise="1 m/s", oil="fva3")
    assert mixed_ehl("mu", "constant:0.05", *along).out.split()[2] == "0.0500"


def test_other_refusals(mixed_ehl: Call, plan: Path, tmp_path: Path) -> None:
    """What no option of test_mistakes is about: what is missing, and a plan in place of a folder."""
    run, formula = tmp_path / "run", tmp_path / "f.json"
    (tmp_path / "empty.toml").write_text("")
    for arguments, field in (
        (("mu", "xu_kahraman_2007", *point_options()), "--oil"),
        (("sweep", plan), "-o RUN"),
        (("sweep", plan, "-o", run, "--set", "variables.speed_entrainment.high=0.5"), "speed_entrainment.high"),
        (("sweep", tmp_path / "empty.toml", "-o", run), "empty.toml"),
        (("sweep", plan, "-o", plan), "plan.toml"),
        # no option has this value
        (("sweep", plan, "--estimate", "--set", "lubricant.oil=true"), "lubricant.oil"),
        (("export", "gear", "-o", tmp_path / "f.c"), "--oil-arguments"),
        (("sweep", "status", run), "run"),
        (("fit", run, "-o", formula), "run"),
        (("fit", run, "-o", formula, "--family", "xu", "--nested"), "--nested"),
    ):
        refused(mixed_ehl(*arguments), field)


def test_cases_that_fail_are_said_in_the_exit_code(mixed_ehl: Call, plan: Path, tmp_path: Path) -> None:
    # an unloaded, fast contact is outside the range of Benedict & Kelley
    plan.write_text(PLAN.replace('low = "0.4 GPa"', 'low = "50 MPa"').replace('high = "15 m/s"', 'high = "150 m/s"'))
    command = ("sweep", plan, "-o", tmp_path / "run", "--with", "benedict_kelley_1961", "--jobs", "1")
    # a resumed run reports the same failures on disk, whichever process computed them
    swept, resumed = mixed_ehl(*command), mixed_ehl(*command)
    assert swept.code == resumed.code == 1
    assert resumed.err.splitlines()[-1] == swept.err.splitlines()[-1]
    assert mixed_ehl("sweep", "status", tmp_path / "run", "--failed").code == 0
    content = json.loads(mixed_ehl("sweep", "status", tmp_path / "run", "--json").out)
    failed = content["failed"]
    assert len(failed) == sum(content["shards"][0]["failed"].values()) > 0
    assert {case["reason"] for case in failed} == {"undefined"}
    assert set(failed[0]["conditions"]) >= {"pressure_hertz", "slide_to_roll", "temperature_oil"}


def test_changes_on_the_command_line_are_part_of_the_plan(mixed_ehl: Call, plan: Path, tmp_path: Path) -> None:
    estimate = mixed_ehl("sweep", plan, "--estimate", "--jobs", "2", "--set", "sampling.size=64")
    assert "64 cases" in estimate.out
    assert "1 case " in mixed_ehl("sweep", plan, "--estimate", "--set", "sampling.size=1").out
    run = ("-o", tmp_path / "run", "--with", "arana_2019", "--jobs", "1", "--set", "lubricant.oil=75w90")
    assert mixed_ehl("sweep", plan, *run).code == 0
    # without the change the folder holds another run
    assert mixed_ehl("sweep", plan, *run[:-2]).code == 2
