"""Parameter study: points against single computations, resuming, failures by name, files, command."""

import json
import math
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from pages import read_page

import efficiency
from efficiency.design.design import Design, load_design
from efficiency.mesh import Mesh
from efficiency.pair import GearPair
from efficiency.studies.parameter_study import Levels, Study, run_study
from efficiency.studies.report import section_table, study_figures, study_tables
from ehl.common.errors import ConvergenceError, InputError

MODEL = "xu_kahraman_2007"
GRID = {"grid": (4, 7)}
DESIGNS = [load_design(name) for name in ("fh_hypoid_9x34", "fh_hypoid_9x34_offset_10")]
LEVELS = Levels((100.0, 250.0), (100.0, 400.0), (333.15, 363.15), (2e-7, 4e-7), (5e-5,), (), (), ())


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("study") / "points.jsonl"


@pytest.fixture(scope="module")
def study(store: Path) -> Study:
    return run_study(DESIGNS, MODEL, LEVELS, store=store, **GRID)


def test_default_levels_go_round_the_design() -> None:
    levels = Levels.around(DESIGNS[0], speed=(3.0, 1.0, 2.0))
    assert levels.speed == (1.0, 2.0, 3.0)
    own = DESIGNS[0].pinion.roughness_rms
    nearest = min(levels.roughness_rms_each, key=lambda level: abs(math.log(level / own)))
    expected = {"torque": DESIGNS[0].operation.torque, "speed": 3.0, "temperature": 363.15}
    assert levels.reference(DESIGNS[0]) == expected | {"roughness_rms_each": nearest}
    with pytest.raises(InputError, match="torque"):
        replace(levels, torque=())


def test_points_are_those_of_single_computations(study: Study) -> None:
    assert len(study.points) == 2 * (2**4 + 1)
    assert study.status == "converged"
    moved = DESIGNS[1].with_misalignment(E=5e-5)
    one, other = (DESIGNS[0], 0.0, 100.0, 333.15, 2e-7), (moved, 5e-5, 250.0, 363.15, 4e-7)
    for design, shift, torque, temperature, rough in (one, other):
        loaded = Mesh.of(design, "drive", *GRID["grid"], keep=True).load(torque)
        at = {"speed": 400.0, "temperature": temperature, "roughness_rms_each": rough}
        alone = loaded.efficiency(MODEL, many=True, oil="75w90", **at)
        given = {"design": design.name, "E": shift, "torque": torque, "shaft_angle_error": 0.0} | at
        found = [p for p in study.points if all(getattr(p, name) == value for name, value in given.items())]
        assert len(found) == 1
        for name in ("efficiency", "power_loss", "pressure_hertz_max", "friction_coefficient_mean", "efficiency_error"):
            assert getattr(found[0], name) == pytest.approx(getattr(alone, name), rel=1e-10)
        ratio, weight = alone.lubrication.film_ratio, alone.points.force * alone.points.speed_sliding
        assert found[0].film_ratio == pytest.approx(np.average(ratio, weights=weight), rel=1e-12)


def test_film_ratio_of_smooth_flanks_is_infinite() -> None:
    smooth = replace(LEVELS, torque=(250.0,), speed=(400.0,), temperature=(363.15,), roughness_rms_each=(0.0,), E=())
    found = run_study(DESIGNS[:1], MODEL, smooth, jobs=1, **GRID)
    assert [point.film_ratio for point in found.points] == [math.inf]
    assert found.to_dict()["points"][0]["film_ratio"] is None


def test_sections_hold_all_else_at_the_reference(study: Study) -> None:
    assert study.reference == {"torque": 250.0, "speed": 400.0, "temperature": 363.15, "roughness_rms_each": 4e-7}
    for name, expected in (("speed", [100.0, 400.0]), ("E", [0.0, 5e-5])):
        points = study.section("fh_hypoid_9x34", name)
        assert [getattr(point, name) for point in points] == expected
        for other in ("torque", "speed", "temperature", "roughness_rms_each", "E", "shaft_angle_error"):
            if other != name:
                assert {getattr(point, other) for point in points} == {study.reference.get(other, 0.0)}
    low, high = study.influence("fh_hypoid_9x34", "speed")
    assert (low, high) == tuple(sorted(p.efficiency for p in study.section("fh_hypoid_9x34", "speed")))
    assert study.varied == ["torque", "speed", "temperature", "roughness_rms_each", "E"]


def test_a_killed_study_goes_on(study: Study, store: Path) -> None:
    lines = [line for line in store.read_text(encoding="utf-8").splitlines(keepends=True) if line.strip()]
    assert len(lines) == 1 + 2 * (2 + 1)
    store.write_text("".join(lines[:-1]) + lines[-1][:40], encoding="utf-8")
    cut = json.loads(lines[-1])
    again = run_study(DESIGNS, MODEL, LEVELS, store=store, **GRID)
    assert again.reused == len(study.points) - len(cut["points"])

    def numbers(one: Study) -> list[str]:
        return [repr(replace(point, seconds=0.0)) for point in one.points]

    assert numbers(again) == numbers(study)
    assert run_study(DESIGNS, MODEL, LEVELS, store=store, **GRID).reused == len(study.points)
    other = run_study(DESIGNS[:1], "constant:0.05", replace(LEVELS, E=()), store=store, **GRID)
    assert other.reused == 0


def test_files_hold_the_points(study: Study, tmp_path: Path) -> None:
    study.write(folder=tmp_path)
    assert {path.stem for path in tmp_path.glob("*.png")} == {picture.name for picture in study_figures(study)}
    table = pd.read_csv(tmp_path / "study.csv", dtype=str)
    assert {"torque [N m]", "speed [rad/s]", "temperature [K]", "roughness_rms_each [m]"} < set(table)
    assert [*map(float, table["efficiency"])] == [point.efficiency for point in study.points]
    losses = pd.read_excel(tmp_path / "study.xlsx", "study")["power_loss [W]"]
    np.testing.assert_allclose(losses, [point.power_loss for point in study.points], rtol=1e-14)
    page = read_page(tmp_path / "study.html")
    assert page.source.count("<svg") == len(list(study_figures(study)))
    for design in study.designs:
        point = study.reference_point(design)
        assert f"{100.0 * point.efficiency_lower:.2f} to {100.0 * point.efficiency_upper:.2f} %" in page.sections[0]


def test_strength_of_each_point_where_it_is_asked_for(study: Study, store: Path) -> None:
    few = Levels((100.0, 200.0), (150.0,), (353.15,), (4e-7,), (), (), (), ())
    asked = {"store": store, "strength": True, "jobs": 1, **GRID}
    run_study(DESIGNS[:1], MODEL, few, **asked)
    again = run_study(DESIGNS[:1], MODEL, few, **asked)
    assert again.reused == 2
    table = study_tables(again)[0]
    pair = GearPair(DESIGNS[0])
    for row, torque in zip(table.records(), few.torque, strict=True):
        own = pair.mesh("drive", *GRID["grid"]).load(torque)
        expected = own.efficiency(MODEL, speed=150.0, temperature=353.15, roughness_rms_each=4e-7).strength.columns()
        assert row["strength"] == expected["strength"] == "warning"
        for name in ("safety_contact", "safety_root_pinion", "safety_root_gear", "film_specific"):
            assert row[name] == pytest.approx(expected[name], rel=2e-2)  # bulk temperature from fewer points
    failed = replace(again, points=(replace(again.points[0], strength={}, status="failed"), again.points[1]))
    assert study_tables(failed)[0].records()[0]["safety_contact"] is None


def test_a_point_that_fails_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    true = Mesh.of

    def refuses(design: Design, *arguments: Any) -> Any:
        if design.assembly.misalignment.shaft_angle_error != 0.0:
            raise ConvergenceError("no_contact", "for the test")
        return true(design, *arguments)

    monkeypatch.setattr(Mesh, "of", refuses)
    levels = replace(LEVELS, torque=(250.0,), speed=(400.0,), temperature=(363.15,), E=(), shaft_angle_error=(1e-3,))
    study = run_study(DESIGNS[:1], MODEL, levels, jobs=1, **GRID)
    assert study.status == "failed"
    assert [(point.shaft_angle_error, point.reason) for point in study.failed] == [(1e-3, "no_contact")]
    assert section_table(study, "fh_hypoid_9x34", "shaft_angle_error").records()[1]["reason"] == "no_contact"
    point = json.loads(json.dumps(study.to_dict(), allow_nan=False))["points"][-1]
    assert point["efficiency"] is None


def test_the_command(mixed_ehl: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    # a coarse mesh is enough here; the arguments are those of a user
    monkeypatch.setattr(efficiency, "study", partial(run_study, **GRID))
    call = ["study", "fh_hypoid_9x34", "--friction", "constant:0.05", "--torque", "100:200:2 N m"]
    call += ["--speed", "1000 rpm", "--temperature", "80 degC", "--roughness-each", "0.4 um", "--jobs", "1"]
    call += ["--E", "0 mm", "--P", "0 mm", "--G", "0 mm", "--shaft-angle-error", "0 arcmin"]
    outcome = mixed_ehl(*call, "--json")
    assert outcome.code == 0, outcome.err
    assert [point["torque"] for point in json.loads(outcome.out)["points"]] == [100.0, 200.0]
    assert mixed_ehl(*call).code == 0
    assert (tmp_path / "mixed-ehl-study" / "over_torque.png").is_file()
    assert mixed_ehl("study", "fh_hypoid_9x34", "fh_hypoid_9x34").code == 2
