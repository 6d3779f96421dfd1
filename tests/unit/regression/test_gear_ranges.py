"""Ranges from what gears see: weighted quantiles, and the plan written over them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contacts import gear_state
from refusals import refuses

from ehl.common.errors import InputError
from ehl.fluid.oil import Oil
from regression.plan.operating_range import WeightedPoints, operating_range, weighted_quantile
from regression.plan.plan import Plan

OIL = Oil.load("fva3")


def points(count: int = 400, **changes: Any) -> WeightedPoints:
    random = np.random.default_rng(3)
    values = {
        "pressure_hertz": random.uniform(0.5e9, 1.5e9, count),
        "radius_equivalent": 0.01 * 3.0 ** random.random(count),
        "speed_entrainment": 2.0 * 4.0 ** random.random(count),
        "slide_to_roll": random.uniform(-0.6, 0.6, count),
        "speed_sliding_lengthwise": random.uniform(-2.0, 2.0, count),
    }
    state = gear_state(**values | {"roughness_rms_2": 0.4e-6} | changes)
    return WeightedPoints(state, np.ones(state.size), OIL)


def test_weighted_quantiles() -> None:
    values = np.array([3.0, 1.0, 2.0, 10.0])
    # equal weights: the quantiles of Hazen
    levels = np.linspace(0.05, 0.95, 7)
    expected = np.quantile(values, levels, method="hazen")
    np.testing.assert_allclose(weighted_quantile(values, np.ones(4), levels), expected, rtol=1e-14)
    # a weight of two is the point twice, in the middle of which the level is the same
    repeated = np.repeat(np.random.default_rng(1).random(50), 4)
    single = weighted_quantile(repeated[::4], np.full(50, 4.0), levels)
    np.testing.assert_allclose(single, np.quantile(repeated[::4], levels, method="hazen"), rtol=1e-14)
    # points without weight do not count, whatever they are
    assert weighted_quantile([1.0, 5.0, 99.0], [1.0, 1.0, 0.0], 1.0) == 5.0
    for bad in (([], []), ([1.0], [0.0]), ([1.0, 2.0], [1.0, -1.0]), ([1.0], [np.nan]), ([1.0], [1.0, 2.0])):
        with refuses("weights"):
            weighted_quantile(*bad, 0.5)


def test_ranges_hold_the_share_of_the_weight_asked_for() -> None:
    part = points()
    weighted = WeightedPoints(part.state, part.state.pressure_hertz * part.state.speed_sliding, OIL)
    ranges = operating_range([weighted], 0.9)
    for name, values in (
        ("pressure_hertz", part.state.pressure_hertz),
        ("speed_entrainment", part.state.speed_entrainment),
        ("slide_to_roll", np.abs(part.state.slide_to_roll)),
    ):
        inside = (values >= ranges[name].low) & (values <= ranges[name].high)
        assert weighted.weight[inside].sum() / weighted.weight.sum() == pytest.approx(0.9, abs=0.01)
        assert ranges[name].minimum == values.min()
        assert ranges[name].maximum == values.max() == ranges.to_frame().loc[name, "maximum"]
    # sliding weighs: what slides more is seen more
    assert ranges["slide_to_roll"].median > operating_range([part], 0.9)["slide_to_roll"].median
    assert {"lengthwise_to_roll", "temperature_oil", "roughness_rms", "film_ratio"} <= set(ranges.variables)


def test_the_plan_holds_the_ranges_and_is_one(tmp_path: Path) -> None:
    texture = {"correlation_length": 45e-6}
    hot = points(temperature_oil=393.15, **texture)
    ranges = operating_range([points(**texture), hot], 0.95)
    text = ranges.plan_text("seen", ("fva3", "75w90"), size=40, description='what "gears" see')
    (tmp_path / "seen.toml").write_text(text)
    plan = Plan.from_file(tmp_path / "seen.toml")
    assert ranges.plan("seen", ["fva3", "75w90"], size=40).plan_hash == plan.plan_hash
    assert plan.description == 'what "gears" see'
    assert plan.count == 80
    assert plan.oils == ("fva3", "75w90")
    for name, axis in plan.variables.axes.items():
        if axis.sampled:
            (low, high), seen = axis.values, ranges[name]
            assert low <= seen.low < seen.high <= high
            # a tenth more at each end, and the rounding
            scale = np.log if axis.scale == "log" else np.asarray
            assert low == 0.0 or np.ptp(scale([low, high])) == pytest.approx(
                1.2 * np.ptp(scale([seen.low, seen.high])), rel=0.05
            )
    # one roughness, one value
    assert plan.variables.axes["roughness_rms"].values == pytest.approx((0.5e-6,), rel=0.01)
    assert plan.variables.axes["correlation_length"].values == pytest.approx((45e-6,), rel=0.01)
    window = plan.constraints.film_ratio
    assert window.low < ranges["film_ratio"].low < ranges["film_ratio"].high < window.high


def test_spur_gears_have_no_lengthwise_sliding_and_a_pitch_point(tmp_path: Path) -> None:
    spur = points(speed_sliding_lengthwise=0.0, slide_to_roll=np.linspace(-1e-5, 0.4, 400))
    text = operating_range([spur], 1.0).plan_text("spur", ("fva3",), size=32)
    assert "lengthwise_to_roll = 0.0" in text
    (tmp_path / "spur.toml").write_text(text)
    low, _ = Plan.from_file(tmp_path / "spur.toml").variables.axes["slide_to_roll"].values
    assert 1e-4 < low <= 1e-3


def test_refusals() -> None:
    with pytest.raises(InputError):
        operating_range([])
    with refuses("coverage"):
        operating_range([points()], 0.2)
