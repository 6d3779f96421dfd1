"""The adaptive sweep: what it adds lowers the error where it counts, failures are kept, a killed run ends the same."""

from __future__ import annotations

import json
import math
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ehl.contact import Contact
from ehl.io.errors import ConvergenceError, InputError
from ehl.io.validation import validate
from regression.data.dataset import load_dataset, run_status
from regression.plan.plan import Plan
from regression.sweeping.adaptive import BATCH_FILE, SurrogateScore, adaptive_sweep
from regression.sweeping.evaluators import Outputs
from regression.sweeping.recorder import Progress
from regression.sweeping.surrogate import choose_batch, fit_surrogate


def plan(*, size: int = 32, **adaptive: Any) -> Plan:
    content = {
        "name": "adaptive",
        "sampling": {"size": size, "seed": 2},
        "variables": {
            "pressure_hertz": {"low": "0.4 GPa", "high": "2 GPa"},
            "radius_equivalent": "10 mm",
            "speed_entrainment": {"low": 1.0, "high": 10.0, "scale": "log"},
            "slide_to_roll": {"low": 0.02, "high": 1.0, "scale": "log"},
            "temperature_oil": "80 degC",
            "roughness_rms": "0.4 um",
        },
        "lubricant": {"oil": "fva3"},
        "adaptive": {"batch": 12, "budget": 56, **adaptive},
    }
    return validate(Plan, content)


def bumpy(case: Contact) -> Outputs:
    """A friction surface with a bump at high sliding that a few points do not show."""
    p, sr = (case.contact.pressure_hertz or 0.0) / 1e9, math.log(case.contact.slide_to_roll)
    bump = math.exp(-((p - 1.6) ** 2) / 0.05 - (sr + 0.3) ** 2 / 0.1)
    return {"friction_coefficient": 0.02 * (1.0 + 0.2 * p + bump), "friction_error": 1e-3}


def failing(case: Contact) -> Outputs:
    if (case.contact.pressure_hertz or 0.0) > 1.5e9:
        raise ConvergenceError("diverged")
    return bumpy(case)


def test_batches_go_where_the_weight_is_and_the_error_falls(tmp_path: Path) -> None:
    scores: list[SurrogateScore] = []
    report = adaptive_sweep(plan(gain=0.01), tmp_path, evaluate=bumpy, notify=scores.append)
    assert (report.batches, report.ended) == (2, "budget")
    assert tuple(scores) == report.scores
    assert [score.cases for score in scores] == [32, 44, 56]
    assert scores[-1].weighted < scores[0].weighted
    frame = load_dataset(tmp_path).frame
    added = frame["origin"] == "adaptive"
    assert added.sum() == 24
    # p_h times sliding speed, to which the loss is proportional
    power = frame["pressure_hertz"] * frame["slide_to_roll_total"] * frame["speed_entrainment"]
    assert power[added].median() > 3.0 * power[~added].median()
    # they lie in the box, no two at one place
    assert frame["pressure_hertz"].between(0.4e9, 2e9).all()
    assert len(np.unique(frame["slide_to_roll"].round(6))) == 56
    status = run_status(tmp_path)
    assert (status.planned, status.finished, status.adaptive) == (32, 32, 24)
    again = adaptive_sweep(plan(gain=0.01), tmp_path, evaluate=bumpy)
    assert again.scores == report.scores
    assert sum(sweep.converged for sweep in again.sweeps) == 0


def test_without_weight_the_points_spread(tmp_path: Path) -> None:
    adaptive_sweep(plan(weight="uniform", budget=44), tmp_path, evaluate=bumpy)
    frame = load_dataset(tmp_path).frame
    added = frame[frame["origin"] == "adaptive"]
    # low and high sliding alike
    assert 0.1 < (added["slide_to_roll"] < 0.15).mean() < 0.9


def test_a_killed_run_ends_as_if_it_had_not_been(tmp_path: Path) -> None:
    whole = adaptive_sweep(plan(), tmp_path / "whole", evaluate=bumpy)

    calls = Counter[str]()

    def stop(progress: Progress) -> None:
        calls["cases"] += 1
        if calls["cases"] == 33 + 13 + 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        adaptive_sweep(plan(), tmp_path / "killed", evaluate=bumpy, progress=stop)
    assert len(load_dataset(tmp_path / "killed").frame) == 32 + 12 + 4
    resumed = adaptive_sweep(plan(), tmp_path / "killed", evaluate=bumpy)
    assert resumed.scores == whole.scores
    assert load_dataset(tmp_path / "killed").data_hash == load_dataset(tmp_path / "whole").data_hash
    assert (tmp_path / "killed" / BATCH_FILE).read_text() == (tmp_path / "whole" / BATCH_FILE).read_text()


def test_failed_cases_stay_and_turn_the_search_elsewhere(tmp_path: Path) -> None:
    report = adaptive_sweep(plan(), tmp_path, evaluate=failing, retries=0)
    frame = load_dataset(tmp_path).frame
    failed = frame["status"] == "failed"
    assert report.batches == 2
    assert len(frame) == 56
    assert set(frame[failed]["reason"]) == {"diverged"}
    assert (frame[failed]["pressure_hertz"] > 1.5e9).all()
    # the batches went on where there are results
    added = frame["origin"] == "adaptive"
    assert 0.0 < failed[added].mean() < 1.0


def test_a_region_that_fails_is_left_alone_and_one_nobody_saw_is_sought() -> None:
    random = np.random.default_rng(1)
    points, candidates = random.random((80, 2)), random.random((400, 2))
    values = np.sin(5.0 * points[:, 0]) * np.cos(3.0 * points[:, 1])
    right = points[:, 0] > 0.5
    sound = (points[~right], values[~right], np.full(np.count_nonzero(~right), 1e-3))
    far = candidates[:, 0] > 0.6

    def share(failed: np.ndarray) -> float:
        return float(far[choose_batch(fit_surrogate(*sound, failed), candidates, np.ones(400), 20)].mean())

    unseen, failing = share(np.zeros((0, 2))), share(points[right])
    # 40 % of the candidates lie there
    assert unseen > 0.6
    assert failing < 0.7 * unseen


def test_it_ends_when_two_batches_gain_too_little(tmp_path: Path) -> None:
    def linear(case: Contact) -> Outputs:
        rough = 0.3 * math.sin(1e4 * case.contact.slide_to_roll)
        return {"friction_coefficient": 0.02 * math.exp(rough), "friction_error": 0.0}

    # noise no surrogate can learn
    report = adaptive_sweep(plan(budget=200, gain=0.5), tmp_path, evaluate=linear)
    assert report.ended == "no_gain"
    assert report.batches == 2


def test_leave_one_out_residuals_and_batches_of_the_surrogate() -> None:
    random = np.random.default_rng(4)
    inputs = random.random((40, 2))
    values = np.sin(4.0 * inputs[:, 0]) + inputs[:, 1]
    surrogate = fit_surrogate(inputs, values, np.full(40, 1e-3), np.zeros((0, 2)))
    # by hand: the process without the point, at the point (trend and hyperparameters as found)
    design = np.column_stack([np.ones(40), inputs])
    rest = values - design @ np.linalg.lstsq(design, values, rcond=None)[0]
    for left in (0, 17):
        others = np.delete(np.arange(40), left)
        known = surrogate.signal * surrogate.correlation(inputs[others], inputs[others])
        known += np.diag(surrogate.noise[others])
        cross = surrogate.signal * surrogate.correlation(inputs[others], inputs[left : left + 1])[:, 0]
        assert surrogate.residual[left] == pytest.approx(
            rest[left] - cross @ np.linalg.solve(known, rest[others]), rel=1e-5
        )
    # where all is known the variance is small; far from all it is largest, and a batch does not crowd there
    candidates = np.vstack([inputs[:5], [[3.0, 3.0], [3.0, 3.01], [-2.0, 0.5]]])
    assert set(choose_batch(surrogate, candidates, np.ones(8), 2)) in ({5, 7}, {6, 7})
    with_failure = fit_surrogate(inputs, values, np.full(40, 1e-3), np.array([[3.0, 3.0]]))
    assert with_failure.success_probability(np.array([[3.0, 3.0]]))[0] < 0.3
    assert with_failure.success_probability(np.array([[-3.0, -3.0]]))[0] == pytest.approx(40 / 41, rel=1e-6)
    assert with_failure.success_probability(inputs[:1])[0] > 0.9
    assert with_failure.covariance(candidates)[5, 5] < 0.6 * surrogate.covariance(candidates)[5, 5]


def test_refusals(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"adaptive.budget.*more than the plan's 32 cases"):
        adaptive_sweep(plan(budget=32), tmp_path, evaluate=bumpy)
    with pytest.raises(InputError, match=r"sampling.size = 8.*at least 16 results"):
        adaptive_sweep(plan(size=8), tmp_path / "few", evaluate=bumpy)
    values = {"pressure_hertz": 1e9, "radius_equivalent": 0.01, "speed_entrainment": 5, "slide_to_roll": [0.1, 0.2]}
    lattice = validate(
        Plan, {"name": "x", "variables": {**values, "temperature_oil": 350}, "lubricant": {"oil": "fva3"}}
    )
    with pytest.raises(InputError, match=r"at least one range"):
        adaptive_sweep(lattice, tmp_path / "lattice", evaluate=bumpy)
    adaptive_sweep(plan(budget=33), tmp_path / "record", evaluate=bumpy)
    for text in ("{", json.dumps({"schema": 99, "plan_hash": "", "batches": []})):
        (tmp_path / "record" / BATCH_FILE).write_text(text)
        with pytest.raises(InputError, match=r"adaptive\.json.*Move it away"):
            adaptive_sweep(plan(budget=33), tmp_path / "record", evaluate=bumpy)
