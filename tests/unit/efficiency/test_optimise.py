"""Search for a better ease-off: front, kill and resume, bounds, figures without data, files, command."""

import json
import math
import shutil
import tomllib
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from pages import read_page
from refusals import refused

import efficiency
from efficiency.machine_settings.design_file import targets_text
from efficiency.machine_settings.inputs import SettingsInput, load_targets
from efficiency.mesh import Mesh
from efficiency.optimisation import check, report
from efficiency.optimisation import optimise as search
from efficiency.optimisation.check import Correction
from efficiency.optimisation.evaluation import Evaluation, EvaluationTask, evaluate, evaluate_all, settings_of
from efficiency.optimisation.optimise import load_start, make_problem, optimise
from efficiency.optimisation.problem import SearchProblem, as_made, box_states, checked_limits, start_value, with_values
from efficiency.optimisation.result import Candidate, Optimisation, non_dominated, spread_out
from efficiency.optimisation.surrogate import Processes, first_points, weights_of
from efficiency.pair import GearPair
from ehl.common.data import data_names, data_path
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.journal import Journal
from ehl.common.runner import WorkersCrashed, cluster
from ehl.common.validation import validate

PAIR = "fh_spiral_bevel_12x37"
BOUNDS = {"lengthwise_crowning": "30:90 um", "profile_crowning": (8e-6, 24e-6)}
LIMITS = {"pressure_hertz_max": "1.9 GPa", "edge_load_share": "start"}
PROBLEM: dict[str, Any] = {"objectives": ["power_loss", "pressure_hertz_max"], "limits": LIMITS}
PROBLEM |= {"misalignment": {}, "friction": "constant:0.05"}
RUN = PROBLEM | {"evaluations": 7, "jobs": 1, "batch": 2, "check": 1}
SMALL = (4, 9)
START = load_targets(PAIR)
SIX = dict.fromkeys(("crowning_toe", "crowning_heel", "relief_root", "relief_tip", "twist"), "2 um")


def problem_of(start: SettingsInput = START, **change: Any) -> SearchProblem:
    """The problem of a search, with other arguments."""
    rest = {"duty": None, "tolerance": None, "over": "mean", "flanks": "drive", "oil": None}
    return make_problem(start, **(PROBLEM | {"variables": BOUNDS} | rest | change))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("optimise")


@pytest.fixture(scope="module", autouse=True)
def small_meshes() -> Any:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(search, "SEARCH_GRID", SMALL)
        patch.setattr(search, "_FIRST", 2)
        for module in (check, report):
            patch.setattr(module, "CHECK_GRID", (6, 11))
        yield


@pytest.fixture(scope="module")
def found(folder: Path) -> Optimisation:
    return optimise(PAIR, BOUNDS, store=folder / "points.jsonl", **RUN)


def values(result: Optimisation) -> list[str]:
    return [repr((e.key, e.variables, e.figures, e.reason)) for e in result.evaluations]


def test_the_gain_is_split_by_kind_of_variable() -> None:
    names = dict.fromkeys(("lengthwise_crowning", "profile_crowning", "bias")) | {"tip_relief": "10:50 um"}
    problem = problem_of(variables=names)
    first = problem.start_values
    last = first | {"lengthwise_crowning": 60e-6, "bias": 0.2, "tip_relief": 30e-6}

    def point(values: dict[str, float], reason: str = "") -> Evaluation:
        gains = {"lengthwise_crowning": 1.0, "bias": 2.0, "tip_relief": 4.0}
        loss = 100.0 - sum(gain for name, gain in gains.items() if values[name] != first[name])
        return Evaluation(repr(values), values, {"power_loss": loss}, reason)

    task = EvaluationTask(problem, {}, problem.states, SMALL, bodies="", accepted="converged")
    best = Candidate("best", point(last), point(last), point(first), {})
    split = check.gain_split(task, best, lambda tasks: [point(task.values) for task in tasks])
    assert split == pytest.approx({"crowning": 0.01, "bias and twist": 0.02, "edge relief": 0.04})
    failed = check.gain_split(task, best, lambda tasks: [point(task.values, "x") for task in tasks])
    assert math.isnan(failed["bias and twist"])


def test_front_is_within_the_limits_and_nothing_beats_it(found: Optimisation) -> None:
    assert len(found.evaluations) == 7
    assert found.start.variables == {"lengthwise_crowning": 40e-6, "profile_crowning": 12e-6}
    assert found.allowed["pressure_hertz_max"] == 1.9e9
    assert found.allowed["edge_load_share"] == max(found.start.figures["edge_load_share"], 1e-3)
    names = found.problem.objectives
    figures = np.array([[e.figures[n] for n in names] for e in found.evaluations if e.feasible(found.allowed)])
    front = np.array([[e.figures[n] for n in names] for e in found.front])
    assert 0 < len(front) <= len(figures)
    for point in front:
        assert not (np.all(figures <= point, axis=1) & np.any(figures < point, axis=1)).any()
    assert list(front[:, 0]) == sorted(front[:, 0])


def test_a_point_is_what_its_parts_give(found: Optimisation) -> None:
    point = found.evaluations[1]
    inputs = with_values(START, point.variables, "drive")
    assert inputs.targets.drive.crowning_toe == inputs.targets.drive.crowning_heel
    assert inputs.targets.coast == START.targets.coast
    one, other = (efficiency.settings(each, transmission=False).design for each in (START, inputs))
    pair = GearPair(one).sharing_bodies(other)
    result = pair.at("constant:0.05", grid=SMALL, many=True, oil="75w90", driver="pinion")
    assert point.figures["power_loss"] == pytest.approx(result.power_loss, rel=1e-12)
    assert point.figures["pressure_hertz_max"] == pytest.approx(result.pressure_hertz_max, rel=1e-12)


def test_a_killed_search_ends_with_the_same_front(found: Optimisation, folder: Path, tmp_path: Path) -> None:
    lines = [line for line in (folder / "points.jsonl").read_text("utf-8").splitlines(keepends=True) if line.strip()]
    cut = tmp_path / "points.jsonl"
    # header, start, three points, start and best checked, a point, it checked, two more, another checked
    assert len(lines) == 12
    cut.write_text("".join(lines[:4]) + lines[4][:50] + "\n" + "".join(lines[6:]), encoding="utf-8")
    again = optimise(PAIR, BOUNDS, store=cut, **RUN)
    # of the seven evaluations a point was lost; the checks are no evaluations
    assert again.reused == again.to_dict()["reused"] == 6
    assert values(again) == values(found)
    assert [c.exact.figures for c in again.candidates] == [c.exact.figures for c in found.candidates]
    # another problem takes nothing from it
    other = problem_of(friction="constant:0.06")
    key = EvaluationTask(other, found.evaluations[1].variables, other.states, SMALL).key
    assert key not in {json.loads(x)["key"] for x in lines[1:]}


@pytest.mark.parametrize(("what", "shipped"), [("friction", "formulas/75w90.json"), ("oil", "oils/75w90.toml")])
def test_points_are_known_by_formula_and_oil(found: Optimisation, tmp_path: Path, what: str, shipped: str) -> None:
    def key(name: str) -> str:
        return EvaluationTask(replace(found.problem, **{what: name}), {}, ({},), SMALL).key

    content, own = data_path(*shipped.split("/")).read_bytes(), tmp_path / Path(shipped).name
    own.write_bytes(content)
    assert key(str(own)) == key("75w90") != key("fva3")
    own.write_bytes(content + b"\n")
    assert key(str(own)) != key("75w90")
    if what == "friction":
        assert key("strict:75w90") != key("75w90")


def test_what_the_search_tells_wrong_is_corrected_near_checked_points(found: Optimisation) -> None:
    first, second = found.evaluations[1:3]
    allowed = {"pressure_hertz_max": 1.2e9, "edge_load_share": 1e-3}
    limited = {"pressure_hertz_max": 1.3e9, "edge_load_share": 1e-3}
    clean = Correction(found.problem, allowed)
    assert clean(first) is first

    def exact(point: Evaluation, ratio: float) -> Evaluation:
        pressure, edges = (point.figures[name] for name in limited)
        figures = {"pressure_hertz_max": ratio * pressure * 1.3 / 1.2, "edge_load_share": 2.0 * edges}
        return replace(point, figures=figures)

    for ratio, expected in ((1.04, 1.04), (1.5, 1.1), (0.5, 0.9), (np.nan, 1.0)):
        corrected = clean.updated(first, exact(first, ratio), limited)
        # by one point everywhere the same
        for point in (first, second):
            pressure = expected * point.figures["pressure_hertz_max"]
            assert corrected(point).figures == pytest.approx(point.figures | {"pressure_hertz_max": pressure})
    both = clean.updated(first, exact(first, 1.04), limited).updated(second, exact(second, 1.0), limited)
    places = found.problem.places_of([first.variables, second.variables])
    middle = replace(first, variables=found.problem.values_at(places.mean(axis=0)))
    points = first, middle, second
    ratios = [both(p).figures["pressure_hertz_max"] / p.figures["pressure_hertz_max"] for p in points]
    assert ratios == pytest.approx([1.04, math.sqrt(1.04), 1.0], rel=1e-6)
    # limits are reduced by the errors once these are known
    assert clean.limits["pressure_hertz_max"] < both.limits["pressure_hertz_max"] < allowed["pressure_hertz_max"]
    failed = replace(first, figures={}, reason="no_contact: for the test")
    assert both(failed) is failed


def test_the_rest_of_a_search_knows_the_checked_points(
    found: Optimisation, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[Correction] = []
    inner = search._search

    def searched(task: Any, points: Any, correction: Any, *rest: Any) -> Any:
        seen.append(correction)
        return inner(task, points, correction, *rest)

    monkeypatch.setattr(search, "_search", searched)
    monkeypatch.setattr(Correction, "_error", lambda *_: math.log(1.1))
    optimise(PAIR, BOUNDS, store=shutil.copy(folder / "points.jsonl", tmp_path), **RUN)
    best = found.evaluations[1]
    assert [len(correction.known) for correction in seen][:2] == [0, 2]
    for name in found.allowed:
        assert seen[1](best).figures[name] == pytest.approx(1.1 * best.figures[name])


def test_workers_give_the_same_points_and_lose_one_at_most(found: Optimisation) -> None:
    tasks = [EvaluationTask(found.problem, e.variables, found.search_states, SMALL) for e in found.evaluations[1:3]]
    bodies = settings_of(found.problem, {}).design.model_dump_json()
    tasks = [replace(task, bodies=bodies) for task in tasks]
    with cluster("local:1") as workers:
        points = evaluate_all(tasks, workers, Journal(None))
    assert [p.figures for p in points] == [p.figures for p in found.evaluations[1:3]]

    def crashes(numbered: Any, *_: Any) -> Any:
        """The first row is lost with its worker, and when it is alone again."""
        for number, task in numbered:
            if task.key == tasks[0].key:
                raise WorkersCrashed
            yield number, asdict(Evaluation(task.key, task.values, {"power_loss": 1.0}))

    first, second = evaluate_all(tasks, crashes, Journal(None))
    assert first.reason.startswith("worker_lost")
    assert second.figures == {"power_loss": 1.0}


def test_a_search_without_a_better_design_says_so(mixed_ehl, monkeypatch, tmp_path, found) -> None:
    """No row of verdicts without a checked point; better points of the search that were not checked are no failure."""
    unchecked = replace(found, candidates=())
    assert "none was checked" in unchecked.reason
    first = found.problem.objectives[0]
    worse = [e for e in found.evaluations if e.figures.get(first, 1e9) >= found.start.figures[first]]
    none = replace(unchecked, evaluations=tuple(worse))
    assert none.reason.startswith(f"none of {len(worse) - 1} ")
    assert "verdict" not in report.candidates_table(none).names
    assert report.candidates_table(found).names[-1] == "verdict"
    monkeypatch.setattr("efficiency.optimise", lambda *args, **options: none)
    outcome = mixed_ehl("optimise", PAIR, "-o", tmp_path / "none", "--json")
    assert outcome.code == 1
    assert "converged" not in outcome.err


def test_a_gain_inside_its_interval_is_called_so(found: Optimisation) -> None:
    def exact(loss: float, low: float, high: float) -> Evaluation:
        losses = {"aligned": (loss, 0.1), "interval": (low, high), "viscosity": (low, high)}
        return Evaluation("k", {}, {"power_loss": loss, "pressure_hertz_max": 1e9}, losses=losses)

    # one input moves both losses alike, but the second less
    sure = Candidate("a", found.start, exact(90.0, 81.0, 99.0), exact(100.0, 90.0, 110.0), {})
    assert sure.gain == pytest.approx(0.1)
    assert sure.gain_interval == pytest.approx((0.1, 0.1))
    vague = Candidate("a", found.start, exact(97.0, 96.0, 112.0), exact(100.0, 90.0, 110.0), {})
    assert vague.gain_interval[0] < 0.0 < vague.gain_interval[1]
    above = Candidate("a", found.start, exact(97.0, 96.0, 112.0), sure.start, {"pressure_hertz_max": 0.9e9})
    assert (sure.holds, above.holds) == (True, False)
    assert len({candidate.verdict for candidate in (sure, vague, above)}) == 3


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"variables": {"lengthwise_crowning": "90:30 um"}}, "lower bound"),
        ({"variables": {"lengthwise_crowning": "30 um"}}, "from:to"),
        ({"variables": {"lengthwise_crowning": "-5:30 um"}}, "at least 0"),
        ({"variables": {"lengthwise_crowning": None, "crowning_toe": None}}, "lengthwise_crowning, which also sets"),
        ({"variables": {"tip_relief": None}}, "edge_relief"),
        ({"variables": {"hypoid_offset": None}}, "Give hypoid_offset in the blank"),
        ({"variables": {"spiral_angle": "30:90 deg"}}, "65"),
        ({"variables": {"blank": "1:2"}}, "a group of variables"),
        ({"tolerance": {"spiral_angle": "1 deg"}}, "lengthwise_crowning"),
        ({"tolerance": {"bias": 0.0}}, "above 0"),
        ({"tolerance": {"bias": 0.1, "twist": "-2 um"}}, "extends to both sides"),
        ({"tolerance": {"profile_crowning": "2 um", "relief_tip": "2 um"}}, "also sets relief_tip"),
        ({"tolerance": dict.fromkeys(("bias", "contact_face", "contact_depth"), 0.1) | SIX}, "at most 7"),
        ({"flanks": "coast"}, "carry load"),
    ],
)
def test_what_cannot_be_used_is_told(change: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        problem_of(**change)


def test_missing_figures(monkeypatch: pytest.MonkeyPatch, found: Optimisation, mixed_ehl: Any, tmp_path: Path) -> None:
    monkeypatch.setattr(Mesh, "root_teeth", lambda self: ("no fillet, for the test",) * 2)
    call = ["optimise", PAIR, "-o", str(tmp_path), "--objective", "root_stress_gear", "--friction", "constant:0.05"]
    assert mixed_ehl(*call, "--E", "0 mm", "--P", "0 mm", "--jobs", "1").code == 2
    bare = Evaluation("k", {}, dict.fromkeys(found.problem.figures, 1.0) | {"pressure_hertz_max": math.nan})
    pair = GearPair(settings_of(found.problem, {}).design)
    with pytest.raises(InputError, match="pressure_hertz_max"):
        search._with_data(found.problem, pair, bare, default=False)
    # a point that lost its root
    problem = problem_of(limits={"root_stress_gear": "start"})
    task = EvaluationTask(problem, found.evaluations[1].variables, ({},), SMALL)
    assert evaluate(task).reason.startswith("no_data: no root_stress_gear")


def test_reasons_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(task: EvaluationTask) -> Evaluation:
        if task.values.get("lengthwise_crowning", 0.0) > 45e-6:
            return Evaluation(task.key, task.values, reason="no_contact: for the test")
        return Evaluation(task.key, task.values, dict.fromkeys(task.problem.figures, 1.0 + sum(task.values.values())))

    names = evaluate_all.__globals__
    monkeypatch.setitem(names, "evaluate", fails)
    result = optimise(PAIR, BOUNDS, **RUN | {"check": 0, "evaluations": 16})
    frame = result.to_frame()
    assert set(frame.loc[frame["status"] == "failed", "reason"]) == {"no_contact: for the test"}
    assert json.loads(json.dumps(result.to_dict(), allow_nan=False))["status"] == "failed"
    assert len(report.candidates_table(result).rows) == 1  # the start
    monkeypatch.setitem(names, "evaluate", lambda task: Evaluation(task.key, {}, reason="no_contact: nowhere"))
    with pytest.raises(ConvergenceError, match="nowhere"):
        optimise(PAIR, BOUNDS, **RUN)


def test_states_of_a_box_are_balanced() -> None:
    assert box_states({}) == ({},)
    widths = {"lengthwise_crowning": "5 um", "bias": 0.1, "contact_face": 0.05, "tip_relief": "3 um"}
    for box, errors, count in (
        ({"E": 5e-5}, {}, 3),
        ({"E": 5e-5, "P": "0.1 mm"}, {}, 5),
        ({"E": 5e-5}, {"bias": 0.1, "twist": "2 um"}, 5),
        ({"E": 5e-5, "P": 5e-5, "G": 2e-5}, widths, 9),
    ):
        aligned, *corners = box_states(box, errors)
        assert len(corners) + 1 == count
        assert not any(aligned.values())
        signs = np.sign([list(corner.values()) for corner in corners])
        assert np.all(signs.sum(axis=0) == 0)
        np.testing.assert_array_equal(signs.T @ signs, len(corners) * np.eye(signs.shape[1]))
        assert all(corner.keys() == {*box, *errors} for corner in corners)


def test_a_pair_as_made_has_the_errors_and_settings_of_its_own(found: Optimisation) -> None:
    relieved = load_targets(PAIR + "_relieved")
    state = {"E": 5e-5, "lengthwise_crowning": -1e-3, "bias": 0.2, "tip_relief": 2e-6}
    made = as_made(relieved, state, "drive")
    own = relieved.targets.drive
    assert (made.targets.drive.crowning_toe, made.targets.drive.crowning_heel) == (0.0, 0.0)
    assert made.targets.drive.bias == own.bias + 0.2
    assert made.targets.coast == relieved.targets.coast
    old, new = (x.pinion.edge_relief.tip for x in (relieved, made))
    assert new.amount == pytest.approx(old.amount + 2e-6)
    assert as_made(relieved, {"E": 5e-5}, "drive") is relieved

    errors = {"lengthwise_crowning": 10e-6}
    point = found.evaluations[1]
    task = EvaluationTask(found.problem, point.variables, ({}, errors), SMALL)
    both, alone = evaluate(task), evaluate(replace(task, states=({},)))
    moved = {**point.variables, "lengthwise_crowning": point.variables["lengthwise_crowning"] + 10e-6}
    shifted = evaluate(replace(task, values=moved, states=({},)))
    assert not both.reason
    for name, worst in (("power_loss", np.mean), ("pressure_hertz_max", np.max)):
        assert both.figures[name] == pytest.approx(worst([alone.figures[name], shifted.figures[name]]), rel=1e-9)


def test_default_bounds_hold_the_start() -> None:
    for targets in (START, load_targets(f"{PAIR}_relieved")):
        problem = problem_of(targets, variables=None)
        for variable in problem.variables:
            assert variable.low < problem.start_values[variable.name] < variable.high
    assert {v.name for v in problem.variables} >= {"tip_relief", "end_relief"}
    relieved = with_values(targets, {"tip_relief": 2e-5}, "drive")
    assert relieved.gear.edge_relief.tip.amount == 2e-5
    assert checked_limits({"edge_load_share": "2 %"}) == {"edge_load_share": 0.02}


@pytest.mark.parametrize("name", data_names("targets"))
def test_targets_are_written_as_they_are_read(name: str) -> None:
    def flat(inputs: SettingsInput) -> dict[Any, Any]:
        return dict(pd.json_normalize(inputs.model_dump()).iloc[0])

    targets = load_targets(name)
    changed = with_values(targets, {"profile_crowning": 12.3456e-6, "spiral_angle": 0.61}, "both", "another")
    text = targets_text(changed, "A comment.")
    again, wanted = flat(validate(SettingsInput, tomllib.loads(text))), flat(changed)
    assert again.keys() == wanted.keys()
    for key, value in wanted.items():
        assert again[key] == (pytest.approx(value, rel=1e-9) if isinstance(value, float) else value), key
    assert "12.3456 um" in text


@pytest.mark.parametrize("name", ["fm_hypoid_13x42", "fh_hypoid_9x34", PAIR])
def test_the_blank_follows_its_variables(name: str) -> None:
    targets = load_targets(name)
    offset = ["hypoid_offset"] if targets.blank.hypoid_offset > 0.0 else []
    problem, fixed = (problem_of(targets, variables=["blank", *more]) for more in (offset, []))
    names = [v.name for v in problem.variables]
    # the package is fixed unless its variable is named
    assert "hypoid_offset" not in [v.name for v in fixed.variables]
    assert {"spiral_angle", "cutter_radius", "pressure_angle_drive", "pressure_angle_coast"} <= set(names)
    for variable in problem.variables:
        assert variable.low < problem.start_values[variable.name] < variable.high
    assert problem.varies_blank
    assert with_values(targets, problem.start_values, "drive").blank == targets.blank
    # each of them changes only the blank and is found again
    for variable in problem.variables:
        value = variable.at(0.3)
        changed = with_values(targets, {variable.name: value}, "drive")
        assert start_value(changed, variable.name, "drive") == pytest.approx(value)
        assert changed.blank != targets.blank
        assert changed.targets == targets.targets
        others = [n for n in names if n != variable.name]
        assert [start_value(changed, n, "drive") for n in others] == [problem.start_values[n] for n in others]


def test_a_point_with_another_blank_has_bodies_of_its_own() -> None:
    variables = {"pressure_angle_drive": "18:22 deg", "lengthwise_crowning": "35:45 um"}
    problem = problem_of(variables=variables, objectives=["power_loss"], limits={})
    task = replace(search.search_task(problem, settings_of(problem, {})), grid=SMALL)
    assert not task.bodies
    values = {"pressure_angle_drive": math.radians(22.0), "lengthwise_crowning": 40e-6}
    point = evaluate(replace(task, values=values))
    pair = GearPair(efficiency.settings(with_values(problem.start, values, "drive"), transmission=False).design)
    own = pair.at("constant:0.05", grid=SMALL, many=True, oil="75w90", driver="pinion")
    assert point.figures["power_loss"] == pytest.approx(own.power_loss, rel=1e-12)


def test_front_of_known_points() -> None:
    points = np.array([[0.0, 1.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.5]])
    assert non_dominated(points).tolist() == [True, True, False, False, True]
    assert spread_out(np.array([[0.0, 1.0], [0.1, 0.9], [0.5, 0.5], [1.0, 0.0]]), 3) == [0, 3, 2]


def test_the_search_finds_the_front_of_two_variables() -> None:
    # both objectives and a limit that cuts the front; the truth by a grid of 201 x 201
    def figures(z: np.ndarray) -> np.ndarray:
        x, y = z[:, 0], z[:, 1]
        first = (x - 0.2) ** 2 + 0.5 * (y - 0.3) ** 2
        return np.stack([first, (x - 0.8) ** 2 + (y - 0.6) ** 2, np.sin(3.0 * x) + y], axis=1)

    limits, corner = np.array([np.inf, np.inf, 1.2]), np.array([0.6, 0.7])

    def volume(z: np.ndarray) -> float:
        """Area that the front dominates below the corner."""
        values = figures(z)
        kept = values[np.all(values <= limits, axis=1) & np.all(values[:, :2] < corner, axis=1), :2]
        x, y = kept[np.argsort(kept[:, 0])].T
        return float(np.diff(x, append=corner[0]) @ (corner[1] - np.minimum.accumulate(y)))

    axis = np.linspace(0.0, 1.0, 61)
    truth = volume(np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2))
    points, processes = first_points(2, 8, 1, np.array([0.5, 0.5])), Processes(2, limits, 2, 1)
    for k in range(7):
        number, scales = len(points), k % 3 == 0
        batch = processes.next_points(points, figures(points), np.zeros((0, 2)), count=3, number=number, scales=scales)
        points = np.vstack([points, batch])
    assert volume(points) > 0.95 * truth
    assert volume(first_points(2, len(points), 1, np.array([0.5, 0.5]))) < volume(points)
    assert [weights_of(3, k, 1).argmax() for k in (0, 1, 2, 5)] == [0, 1, 0, 2]


def test_a_search_learns_which_variables_decide_what_can_be_made() -> None:
    rng = np.random.default_rng(3)
    points, fresh = rng.random((60, 6)), rng.random((200, 6))

    def margin(z: np.ndarray) -> np.ndarray:
        return 1.3 - z[:, 0] - z[:, 3]

    processes = Processes(6, np.array([np.inf]), 1, 1)
    assert np.all(processes.success(fresh) == 1.0)
    made = margin(points) > 0.0
    processes.fit(points[made], points[made][:, :1], points[~made], scales=True)
    found = processes.success(fresh)
    can, cannot = found[margin(fresh) > 0.3], found[margin(fresh) < -0.3]
    assert can.min() > 0.5 > cannot.max()
    assert np.median(can) > 0.95 > 0.05 > np.median(cannot)
    # feasible points near in all other variables are no evidence
    mixed = np.where(np.arange(6) % 3 == 0, 0.95, points[made])
    assert processes.success(mixed).max() < 0.2


def test_the_command(mixed_ehl: Any, found: Optimisation, folder: Path) -> None:
    # the arguments are those of a user; the points are known from the fixture
    call = ["optimise", PAIR, "-o", str(folder), "--vary", "lengthwise_crowning=30:90 um"]
    call += ["--vary", "profile_crowning=8:24 um", "--objective", "power_loss", "--objective", "pressure_hertz_max"]
    call += ["--limit", "pressure_hertz_max=1.9 GPa", "--limit", "edge_load_share", "--friction", "constant:0.05"]
    call += ["--E", "0 mm", "--P", "0 mm", "--evaluations", "7", "--batch", "2", "--check", "1", "--jobs", "1"]
    outcome = mixed_ehl(*call)
    assert outcome.code == 0, outcome.err
    best = found.best
    written = {path.name for path in folder.iterdir()}
    assert {"pareto.csv", "candidates.csv", "evaluations.csv", "optimise.xlsx", "trade.png", "problem.json"} <= written
    assert (folder / best.name / "setting_sheet.csv").is_file()
    assert f"{-100.0 * best.gain:+.1f} %" in read_page(folder / "optimise.html").sections[0]
    # a search continues from a design whose targets are in the same folder
    again = load_start(folder / f"{best.name}.toml")
    assert start_value(again, "profile_crowning", "drive") == best.point.variables["profile_crowning"]
    # the written design has the reported loss; with constant friction its gain has no interval
    reopened = efficiency.load(folder / f"{best.name}.toml").at("constant:0.05", grid=(6, 11), many=True, oil="75w90")
    assert reopened.power_loss == pytest.approx(best.exact.figures["power_loss"], rel=1e-6)
    low, high = best.gain_interval
    assert low <= 1.0 - best.exact.losses["aligned"][0] / best.start.losses["aligned"][0] <= high
    for start in ("no_such_pair", data_path("designs", f"{PAIR}.toml")):
        refused(mixed_ehl("optimise", start, "-o", folder / "refused"), "targets =")
