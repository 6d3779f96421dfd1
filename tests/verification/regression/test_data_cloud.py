"""The extrapolation guard against plain geometry, linear programs and held-out points."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from ehl.common.errors import InputError
from ehl.common.validation import validate
from regression.friction.data_cloud import STEP, CloudDistance, DataCloud, covering_points, data_cloud, in_convex_hull

NAMES = ("pressure_hertz", "radius_equivalent", "speed_entrainment")


def cases(count: int, seed: int) -> dict[str, np.ndarray]:
    """A box in logarithms whose corner of high p and R is cut off, as a load limit does."""
    random = np.random.default_rng(seed)
    u = random.uniform(-1.0, 1.0, (4 * count, 3))
    u = u[u[:, 0] + u[:, 1] < 0.8][:count]
    return dict(zip(NAMES, (np.array([1e9, 0.02, 5.0]) * np.exp(u)).T, strict=True))


TABLE = cases(1000, 1)


def cloud(count: int = 64) -> DataCloud:
    return data_cloud(TABLE, NAMES, count)


def at(*u: float) -> dict[str, np.ndarray]:
    return dict(zip(NAMES, (np.array([1e9, 0.02, 5.0]) * np.exp(u))[:, None], strict=True))


def test_fitted_cases_are_inside_new_ones_nearly_all_and_the_cut_corner_is_outside() -> None:
    fitted = cloud()
    assert (fitted.extrapolation(TABLE) == CloudDistance.INSIDE).all()
    assert fitted.distance(fitted.whitened(TABLE)).max() <= 1.0 + 1e-9
    new = fitted.extrapolation(cases(2000, 2))
    assert np.mean(new != CloudDistance.INSIDE) < 0.03
    assert not (new == CloudDistance.FAR).any()
    corner = at(0.95, 0.95, 0.0)
    for name in NAMES:
        assert TABLE[name].min() < corner[name][0] < TABLE[name].max()
    assert fitted.extrapolation(corner)[0] > CloudDistance.INSIDE
    assert fitted.extrapolation(at(0.3, 0.3, 0.0))[0] == CloudDistance.INSIDE
    nothing, infinite = ({**at(0.0, 0.0, 0.0), "speed_entrainment": np.array([x])} for x in (0.0, np.inf))
    for point in (at(3.0, 3.0, 0.0), nothing, infinite):
        assert fitted.extrapolation(point)[0] == CloudDistance.FAR


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3).filter(lambda u: max(map(abs, u)) > 0.1))
def test_every_way_out_leads_from_inside_to_far(direction: list[float]) -> None:
    unit = np.array(direction) / max(map(abs, direction))
    # a variable alone is the matter of the ranges of a formula
    unit[np.argsort(np.abs(unit))[1]] = np.copysign(1.0, unit[np.argsort(np.abs(unit))[1]])
    levels = [int(cloud().extrapolation(at(*(unit * f)))[0]) for f in (0.0, 1.2, 1.6, 4.0)]
    assert levels[0] == CloudDistance.INSIDE
    assert levels[1] >= CloudDistance.NEAR
    assert levels == sorted(levels)
    assert levels[-1] == CloudDistance.FAR


def test_limits_are_those_of_sums_and_differences_with_the_slack() -> None:
    fitted = cloud()
    random = np.random.default_rng(8)
    logs = np.log([1e9, 0.02, 5.0]) + random.uniform(-1.3, 1.3, (500, 3))
    u, cases_u = (
        (values - np.array(fitted.mean)) / np.array(fitted.scale)
        for values in (logs, np.log(np.column_stack([TABLE[name] for name in fitted.variables])))
    )
    margin = np.full(500, np.inf)
    for i, k in ((0, 1), (0, 2), (1, 2)):
        for sign in (1.0, -1.0):
            inside, given = cases_u[:, i] + sign * cases_u[:, k], u[:, i] + sign * u[:, k]
            slack = 0.03 * np.ptp(inside)
            margin = np.minimum(margin, np.minimum(given - inside.min() + slack, inside.max() + slack - given))
    np.testing.assert_allclose(fitted.pair_margin(logs), margin, atol=1.1e-3)


def test_coordinates_are_white_and_distance_is_to_the_nearest_point_over_the_covering_radius() -> None:
    fitted = cloud()
    few = cloud(20)
    new = cases(100, 5)
    apart = few.whitened(new)[:, None] - STEP * np.array(few.points)
    nearest = np.linalg.norm(apart, axis=2).min(axis=1)
    np.testing.assert_allclose(few.distance(few.whitened(new)), nearest / few.radius, rtol=1e-9)
    assert few.radius > 1.5 * fitted.radius
    # the rounding of stored coordinates is a margin
    assert few.distance(few.whitened(TABLE)).max() * few.radius == pytest.approx(few.radius - 1e-3 * 3**0.5, abs=6e-4)
    z = fitted.whitened(TABLE)
    np.testing.assert_allclose(np.cov(z, rowvar=False), np.eye(3), atol=5e-3)
    np.testing.assert_allclose(z.mean(axis=0), 0.0, atol=5e-3)
    logs = np.log(np.column_stack([TABLE[name] for name in fitted.variables]))
    assert fitted.mean == tuple(np.round(logs.mean(axis=0), 3))
    assert fitted.scale == tuple(np.round(logs.std(axis=0), 4))
    shaped = {name: values[:6].reshape(2, 3) for name, values in TABLE.items()}
    assert fitted.extrapolation(shaped).shape == (2, 3)


def test_covering_points_cover() -> None:
    z = np.random.default_rng(3).standard_normal((500, 3))
    chosen, radius = covering_points(z, 50)
    distance = np.linalg.norm(z[:, None] - z[chosen][None], axis=2).min(axis=1)
    assert np.unique(chosen).size == 50
    assert chosen[0] == np.argmin(np.linalg.norm(z, axis=1))
    assert distance.max() == pytest.approx(radius, rel=1e-12)
    # Gonzalez: at most twice the best radius, and the chosen lie at least the radius apart
    apart = np.linalg.norm(z[chosen][:, None] - z[chosen][None], axis=2)[~np.eye(50, dtype=bool)]
    assert apart.min() >= radius
    # where every point is chosen the neighbours give the scale
    z = z[:20] + 3.0
    chosen, radius = covering_points(z, 50)
    apart = np.sort(np.linalg.norm(z[:, None] - z[None], axis=2), axis=1)
    assert (chosen.size, radius) == (20, pytest.approx(np.quantile(apart[:, 1], 0.99), rel=1e-12))


def test_what_follows_from_the_others_is_left_out() -> None:
    # one oil: its viscosity is a function of the temperature
    temperature = np.random.default_rng(4).uniform(300.0, 400.0, 1000)
    table = {**TABLE, "temperature_oil": temperature, "viscosity_inlet": np.exp(800.0 / (temperature - 170.0))}
    for names in (("temperature_oil", "viscosity_inlet", *NAMES), (*NAMES, "temperature_oil", "viscosity_inlet")):
        found = data_cloud(table, names)
        assert found.variables == tuple(name for name in names if name != "viscosity_inlet")
    assert data_cloud(TABLE, NAMES[:1]) is None
    # a parabola through three cases is no evidence
    assert data_cloud({name: values[:3] for name, values in TABLE.items()}, NAMES[:2]) is not None
    assert data_cloud({**TABLE, "radius_equivalent": np.full(1000, 0.02)}, NAMES[1:]) is None


def test_convex_hull_by_linear_programs_is_that_of_delaunay() -> None:
    random = np.random.default_rng(6)
    points, queries = random.standard_normal((60, 3)), 1.5 * random.standard_normal((80, 3))
    expected = Delaunay(points).find_simplex(queries) >= 0
    assert 0.2 < expected.mean() < 0.8
    np.testing.assert_array_equal(in_convex_hull(queries, points), expected)
    # a mean of cases is always inside, in units far from 1 too
    assert in_convex_hull(points[:7].mean(axis=0) * 1e9, points * 1e9).all()


def test_file_round_trip_and_damage() -> None:
    fitted = cloud()
    content = json.loads(fitted.model_dump_json())
    again = validate(DataCloud, content)
    np.testing.assert_array_equal(again.extrapolation(cases(200, 7)), fitted.extrapolation(cases(200, 7)))
    for change, words in (
        ({"variables": ["pressure", *NAMES[1:]]}, "pressure_hertz"),
        ({"points": [[0, 1]]}, "rows of 3 numbers"),
        ({"points": []}, "at least one point"),
        ({"limits": [[0, 3, 0, 0, 0, 0]]}, "indices from 0 to 2"),
        ({"limits": [[-1, 1, 0, 0, 0, 0]]}, "indices from 0 to 2"),
        ({"mean": [0.0]}, "means and scales"),
        ({"radius": 0.0}, "radius"),
    ):
        with pytest.raises(InputError, match=words):
            validate(DataCloud, content | change)
