"""Error bars as hard as values: every factor and every term of a stated error against numbers worked out by hand."""

import math
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from refusals import fails
from samples import CONTACT, STEEL
from samples import contact_case as case
from twins.rough_scenes import eyring_oil, gaussian_pair, line

from ehl.fluid.lubricant import Lubricant
from ehl.heat.estimate import estimate_thermal_effect
from ehl.inputs import ContactProblem, ModelInput, SurfaceInput
from ehl.line_contact import LineContact
from ehl.result import ContactResult
from ehl.rough import RoughSurfaces, TransientResult, dry_limit, mixed, solve_transient
from ehl.rough._kernels.march import COLUMNS, FILM_MEAN, MU_FLUID, SHARE
from ehl.rough.accuracy import RunPlan
from ehl.rough.averaging import (
    Window,
    batch_means,
    film_jumped,
    interval_of_means,
    neighbour_correlation,
    net_exchange,
    realisation_error,
    richardson,
)
from ehl.rough.mixed import film_stress_ratio, roughness_effect
from ehl.rough.multilevel import MeshLevels
from ehl.rough.solve import _status
from ehl.smooth import hot_film, refine, thermal
from ehl.smooth.continuation import PathReport
from ehl.smooth.newton import Numbers
from ehl.smooth.refine import extrapolate
from ehl.smooth.solver import solve_steady
from ehl.validity import _limits_of_heat, friction_above_limit_temperature

# --- smooth contact: nested grids

PLAN = RunPlan(0.01, 0.02, 12.0, 96.0, 2.9, 1.5, boundary_study=False)


@pytest.mark.parametrize(("hot", "error"), [(False, 0.0038095238 + 0.0015), (True, 0.8 * 0.0133333333 + 0.01)])
def test_error_of_three_grids_by_hand(hot: bool, error: float) -> None:
    """Value 1.01 - 0.05/3, before it 1.06 - 0.24/3; 2/7 of their distance, 3 % of the last change, 5e-7.

    With heat 0.8 and a fifth.
    """
    levels = [np.array([1.30]), np.array([1.06]), np.array([1.01])]
    found = extrapolate(levels, 49, hot=hot)
    assert found.values[0] == pytest.approx(0.99333333333, rel=1e-10)
    assert found.errors[0] == pytest.approx(error + 4.9667e-7, rel=1e-8)
    assert found.relative()[0] == pytest.approx((error + 4.9667e-7) / 0.9933333333, rel=1e-7)
    assert extrapolate([np.array([9.0]), *levels], 49, hot=hot).errors == found.errors  # of the last three grids


@pytest.mark.parametrize(
    ("coarsest", "share"), [(13, 0.1), (41, 0.03 * 1.2**6), (97, 0.03 / 64.0), (193, 0.002), (385, 0.002)]
)
def test_share_of_the_last_change_falls_with_the_mesh(coarsest: int, share: float) -> None:
    """Exact second order: only the last change is left, 0.03 of it on 49 nodes and as h^6 from 0.002 to 0.1."""
    levels = [np.array([1e-3 * 4.0**-k]) for k in range(3)]
    found = extrapolate(levels, coarsest)
    assert abs(found.values[0]) < 1e-18
    assert found.errors[0] == pytest.approx(max(share, 0.002) * 1e-3 * (0.25 - 0.0625), rel=1e-12)


def test_error_of_third_order_is_twice_the_true_one() -> None:
    """Errors e, e/8, e/64 leave -e/48 in the extrapolation; 2/7 of its change of 7 e/48 is 2 e/48."""
    e = 0.48
    levels = [np.array([1.0 + e * 8.0**-k]) for k in range(3)]
    found = extrapolate(levels, 193)
    assert found.values[0] == pytest.approx(1.0 - e / 48.0, rel=1e-14)
    guards = 0.002 * e * (1 / 8 - 1 / 64) + 5e-7 * found.values[0]
    assert found.errors[0] - guards == pytest.approx(2.0 * e / 48.0, rel=1e-10)


def test_error_of_a_rounded_spike_is_larger_than_that_of_a_square_root(monkeypatch: pytest.MonkeyPatch) -> None:
    """Outputs wrong by the root of the rounding change by 0.73 of their error with three times the rounding."""

    def level(gamma: float) -> Any:
        scaled = SimpleNamespace(gamma=gamma, rounded=lambda factor: level(0.04 * factor))
        return SimpleNamespace(scaled=scaled, gamma=gamma, grid=0, unknowns=0, iterations=3)

    monkeypatch.setattr(refine, "solve_level", lambda grid, contact, guess, **rest: contact)
    monkeypatch.setattr(refine, "numbers_of", lambda at, shear: Numbers(*(1.0 + np.arange(7) * at.gamma**0.5)))
    report: Any = PathReport()
    found = refine.rounding_errors(level(0.0).scaled, level(0.04), None, report)  # type: ignore[arg-type]
    np.testing.assert_allclose(found, 2.0 * (math.sqrt(3.0) - 1.0) * 0.2 * np.arange(7), rtol=1e-9)
    assert report.iterations == 3


def test_reported_errors_are_those_of_the_grids(monkeypatch: pytest.MonkeyPatch) -> None:
    """The result hands on the relative errors of film, smallest film, friction and pressure, each with its own."""

    def known(levels: list[np.ndarray], coarsest: int, *, hot: bool) -> refine.GridLimit:
        assert not hot
        found = extrapolate(levels, coarsest)
        return replace(found, errors=1e-5 * np.arange(1.0, 1.0 + found.values.size) * np.abs(found.values))

    monkeypatch.setattr("ehl.smooth.refine.extrapolate", known)
    result = solve_steady(LineContact.from_pressure(effective_modulus=226e9, **CONTACT), Lubricant(0.02, 18e-9))
    names = ("film_central", "film_min", "friction", "pressure_max")
    assert [getattr(result, f"{name}_error") for name in names] == pytest.approx([1e-5, 2e-5, 3e-5, 4e-5], rel=1e-9)


# --- smooth contact: heat


# the second is not settled after all rounds, but acceptable
@pytest.mark.parametrize(("change", "unsettled"), [(1e-4, False), (0.04, True)])
def test_error_of_a_hot_film_has_three_terms(monkeypatch: pytest.MonkeyPatch, change: float, unsettled: bool) -> None:
    """The grids of film and heat together, further rounds, and extrapolated temperatures."""
    solved = thermal._solved

    def balanced(hot: Any, *arguments: Any) -> Any:
        film = solved(hot, *arguments)
        hot.change, hot.extrapolated = (change, 0.5 * change), 3e-4
        return film

    monkeypatch.setattr(thermal, "_solved", balanced)
    line = LineContact.from_pressure(effective_modulus=226e9, **CONTACT)
    result = thermal.solve_smooth(line, Lubricant(0.02, 18e-9), (STEEL, STEEL), accuracy="fast")
    assert result.status == "converged"
    assert result.rounds_left == unsettled
    film = result.film
    assert result.friction_error == pytest.approx(film.friction_error + change + 3e-4, rel=1e-12)
    assert result.film_error == pytest.approx(film.film_error + 0.5 * change + 3e-4, rel=1e-12)


def test_change_of_a_round_is_relative_to_the_newer_film() -> None:
    before, after = Numbers(1.0, 0.9, 0.05, *[0.0] * 4), Numbers(1.25, 0.75, 0.04, *[0.0] * 4)
    assert hot_film._changes(before, after) == pytest.approx((0.25, 0.2))
    assert hot_film._changes(after, before) == pytest.approx((0.2, 0.25))


def test_heat_left_out_adds_its_estimate_to_both_errors() -> None:
    slow = {**CONTACT, "speed_entrainment": 0.3, "slide_to_roll": 0.02, "pressure_hertz": 6e8}
    plain = case(contact=slow, model={"thermal": "off"}).solve()
    left_out = case(contact=slow, model={"thermal": "auto"}).solve()
    given = case(contact=slow)
    found = estimate_thermal_effect(
        given.line_contact(), given.lubricant.lubricant(), (STEEL, STEEL), film_central=plain.film_central
    )
    assert not found.matters
    assert found.friction_change > 0.001
    assert found.film_change > 1e-4
    assert left_out.friction_error == pytest.approx(plain.friction_error + found.friction_change, rel=1e-9)
    assert left_out.film_error == pytest.approx(plain.film_error + found.film_change, rel=1e-9)
    assert left_out.mesh_error == plain.mesh_error == plain.friction_error


# --- rough contact: interval of a mean


SQUARE = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0])


@pytest.mark.parametrize(
    ("series", "steps", "student", "error"),
    [
        # ten means of +-1: no positive correlation, r = 0.1 for its bias, inflation 1.2222, freedom 10/1.2222 - 1
        (np.repeat(np.tile([1.0, -1.0], 5), 2), 4, 1.887387, math.sqrt(10.0 / 9.0 * 1.2222222 / 10.0)),
        # seven products of 0.25, four of them positive, over eight squares: r = 1/8, with its bias 0.125 + 1.375/8 =
        # 0.296875, inflation 1.844444, freedom 8/1.844444 - 1 = 3.337349
        (SQUARE, 1, 2.259480, math.sqrt(2.0 / 7.0 * 1.844444444 / 8.0)),
        # no correlation is trusted above its bound: inflation 9, two degrees of freedom
        (np.arange(6.0), 1, 2.919986, math.sqrt(3.5 * 9.0 / 6.0)),
    ],
)
def test_interval_of_a_mean_by_hand(series: np.ndarray, steps: int, student: float, error: float) -> None:
    """Student's t (95 %) times the standard error by half batches, inflated by (1 + r)/(1 - r) of their neighbours."""
    assert batch_means(series + 3.0, steps) == pytest.approx((3.0 + series.mean(), student * error), rel=1e-6)
    assert neighbour_correlation(SQUARE) == pytest.approx(0.125)
    assert neighbour_correlation(np.ones(8)) == 0.0


def test_interval_merges_twenty_parts_with_a_correlation_above_a_fifth() -> None:
    """Runs of two or three equal parts: r = 0.28; of 21 parts the first is left out, 19 are too few to be merged."""
    parts = 1e-3 * np.repeat([1.0, -1.0] * 4, [3, 3, 2, 3, 3, 2, 3, 2])
    assert neighbour_correlation(parts) == pytest.approx(0.284, abs=1e-3)
    merged = parts[1:].reshape(10, 2).mean(axis=1)
    assert interval_of_means(parts) == pytest.approx(interval_of_means(merged), rel=1e-12)
    assert interval_of_means(parts[1:]) == pytest.approx(interval_of_means(merged), rel=1e-12)
    assert interval_of_means(parts[2:]) != pytest.approx(
        interval_of_means(parts[3:].reshape(9, 2).mean(axis=1)), rel=1e-3
    )


def test_interval_needs_five_batches_and_widens_with_its_confidence() -> None:
    assert math.isnan(batch_means(np.arange(8.0), 2)[1])
    assert [math.isfinite(interval_of_means(np.arange(float(count)))) for count in (2, 3)] == [False, True]
    assert math.isfinite(batch_means(np.arange(10.0), 2)[1])
    series = np.tile([1.0, -1.0], 5)
    # t(97.5 %) over t(95 %) at 7.1818 degrees of freedom: 2.352/1.888
    ratio = batch_means(series, 2, 0.95)[1] / batch_means(series, 2)[1]
    assert ratio == pytest.approx(2.352 / 1.888, rel=2e-3)


@pytest.mark.parametrize(
    ("coarse", "fine", "value", "error"),
    [
        (0.0516, 0.0504, 0.05, 0.0004),  # 0.05 + 0.0004 (h/dx)^2: exact, and the fine mean is off by the error
        (0.0484, 0.0496, 0.05, 0.0004),
        (0.8, 1.0, 1.0 + 0.1 / 3.0, 0.4 / 3.0),  # of a third of 0.2 a half is corrected; the third is error, and twice
        (1.2, 1.0, 1.0 - 0.1 / 3.0, 0.4 / 3.0),  # what is left
        (-0.8, -1.0, -1.0 - 0.1 / 3.0, 0.4 / 3.0),
    ],
)
def test_extrapolation_of_two_meshes_corrects_by_no_more_than_a_third_of_ten_per_cent(
    coarse: float, fine: float, value: float, error: float
) -> None:
    assert richardson(coarse, fine) == pytest.approx((value, error), rel=1e-9)


def window(friction: np.ndarray, steps_per_half_width: int = 5, batch: float = 2.0) -> Window:
    """A window with this history of fluid friction and nothing on asperities."""
    units = SimpleNamespace(steps_per_half_width=steps_per_half_width, film=1e-6)
    model = SimpleNamespace(fluid=SimpleNamespace(sliding=1.0), contact=SimpleNamespace(friction=0.1))
    run: Any = SimpleNamespace(problem=SimpleNamespace(units=units, model=model))
    records = np.zeros((friction.size, COLUMNS))
    records[:, MU_FLUID] = friction
    found = Window(run, batch)
    found.recorded.append(records)
    found.numbers.append(0)
    found.rolled = friction.size / steps_per_half_width
    return found


def test_window_of_too_few_batches_counts_as_one_draw() -> None:
    """1.645 standard deviations, those of the history: +-0.01 about 0.05."""
    short = window(np.tile([0.04, 0.06], 10))
    assert short.interval() == pytest.approx((0.05, 1.645 * 0.01), rel=1e-12)
    long = window(np.tile([0.04, 0.06], 100))
    assert long.interval()[1] == pytest.approx(batch_means(long.friction(), 10)[1], rel=1e-12)


def test_window_counts_asperity_friction() -> None:
    fine = window(np.tile([0.04, 0.06], 50))
    fine.recorded[0][:, SHARE] = 0.2
    assert fine.friction().mean() == pytest.approx(0.05 + 0.1 * 0.2)
    fine.run.problem.model.fluid.sliding = 0.0  # type: ignore[misc]
    np.testing.assert_array_equal(fine.friction(), np.zeros(100))


def rolled(friction: np.ndarray, steps_per_half_width: int = 5) -> Window:
    """A window of blocks of 4 b."""
    whole = window(friction, steps_per_half_width)
    parts = np.split(whole.recorded[0], range(4 * steps_per_half_width, friction.size, 4 * steps_per_half_width))
    whole.recorded[:], whole.numbers[:] = parts, range(len(parts))
    return whole


def test_long_window_of_a_coarse_mesh_is_corrected_by_a_short_one_of_a_fine_mesh() -> None:
    """400 b on the coarse mesh, 16 b on one that gives 0.0005 + 1.02 times as much, the mean over all of it 0.05.

    A third of the difference is added once more, as the error of the fine mesh.
    """
    rng = np.random.default_rng(5)
    coarse = np.repeat(0.05 + 0.01 * rng.standard_normal(400), 5)
    coarse += 0.05 - coarse.mean()
    fine = 0.0005 + 1.02 * np.repeat(coarse[:80], 2)
    levels = MeshLevels([rolled(coarse), rolled(fine, 10)], PLAN)
    mean, half_width = levels.interval()
    difference = 0.0005 + 0.02 * coarse[:80].mean()
    assert mean == pytest.approx(0.05 + 4.0 / 3.0 * difference, rel=1e-9)
    assert levels.mesh_error() == pytest.approx(difference / 3.0, rel=1e-6)
    assert abs(mean - (0.05 + 4.0 / 3.0 * 0.0015)) < half_width
    alone = MeshLevels([rolled(coarse[:80]), rolled(fine, 10)], PLAN)
    assert alone.friction() == pytest.approx(fine.mean() + difference / 3.0, rel=1e-9)
    assert half_width < 0.4 * alone.interval()[1]


def test_two_meshes_with_little_common_travel_have_one_draw_as_stated_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """One common block of 4 b with two parts, too few for an interval; mu varies by 0.01 over the longest window."""
    wave = np.tile([0.04, 0.06], 200)
    levels = MeshLevels([rolled(wave), rolled(np.repeat(wave[:20], 2), 10)], replace(PLAN, batch=4.0))
    assert not levels.interval()[1] < math.inf
    flat = np.zeros(0)
    levels.fine.run.problem.model.surfaces = SimpleNamespace(profile_1=flat, profile_2=flat)  # type: ignore[assignment]
    monkeypatch.setattr("ehl.rough.solve.net_exchange", lambda _: 0.0)
    mean, half_width = levels.stated()
    assert mean == pytest.approx(0.05, rel=1e-9)
    assert half_width == pytest.approx(1.645 * 0.01, rel=1e-9)
    assert _status(levels) == ("unsettled", "statistical_interval")


# parts of a block of 4 b, half a batch each: two patterns without correlation, and their sum
ODD, PAIRS = np.array([1.0, -1.0, 1.0, -1.0]), np.array([1.0, 1.0, -1.0, -1.0])


def levels_of(*parts: np.ndarray, blocks: tuple[int, ...]) -> MeshLevels:
    """Meshes with these means in the four parts of each of so many blocks."""
    return MeshLevels([rolled(np.tile(np.repeat(p, 5), n)) for p, n in zip(parts, blocks, strict=True)], PLAN)


@pytest.mark.parametrize(
    ("wave", "change", "correlation"),
    [
        (0.01, 1e-3 * ODD, 1.0),
        (0.01, 1e-3 * (ODD + PAIRS), math.sqrt(0.5)),
        (0.01, 1e-3 * PAIRS, 0.0),
        (0.01, -1e-3 * ODD, 0.0),
        (0.01, 0.0 * ODD, 0.0),  # a constant difference, or mean
        (0.0, 0.01 * ODD, 0.0),
    ],
)
def test_interval_holds_the_covariance_of_mean_and_difference(
    wave: float, change: np.ndarray, correlation: float
) -> None:
    """Of the same travel, 4 blocks of the 20 of the coarse mesh: 2 r w0 w1 sqrt(4/20); a negative one counts for 0."""
    coarse = 0.05 + wave * ODD
    levels = levels_of(coarse, coarse + 0.001 + change, blocks=(20, 4))
    mean, half_width = levels.interval()
    assert mean == pytest.approx(0.05 + 0.004 / 3.0)
    first = batch_means(np.tile(np.repeat(coarse, 5), 20), 10)[1]
    second = 4.0 / 3.0 * interval_of_means(np.tile(0.001 + change, 4))
    assert levels.half_widths() == pytest.approx([first, second], rel=1e-9, abs=1e-15)
    both = 2.0 * correlation * first * second * math.sqrt(0.2)
    assert half_width == pytest.approx(math.sqrt(first**2 + second**2 + both), rel=1e-9)


def test_interval_of_meshes_that_rolled_as_far_holds_that_of_the_extrapolation() -> None:
    """Of the fine mean and of a third of the difference; of less than three parts the difference is one draw."""
    coarse = 0.05 + 0.01 * ODD
    change = 0.001 + 0.008 * PAIRS
    levels = levels_of(coarse, coarse + change, blocks=(20, 20))
    # both means are of one travel and move together: batches of the extrapolated series hold their covariance
    width = interval_of_means(np.tile(coarse + change + change / 3.0, 20))
    assert levels.interval() == pytest.approx((0.051 + 0.001 / 3.0, width), rel=1e-9)
    short = MeshLevels([window(np.repeat(0.05 + 0.004 * ODD[:2], 5)), window(np.full(10, 0.051))], PLAN)
    assert short.interval()[1] == pytest.approx(1.645 * 0.004 / 3.0, rel=1e-9)


# the last two shares are extrapolated beyond their range
@pytest.mark.parametrize(
    ("share", "blocks", "wave"),
    [(0.2, 3, 0.0), (0.8, 3, 0.0), (0.2, 12, 0.0), (0.2, 3, 0.002), (0.2, 3, 0.2)]
    + [(share, 3, 0.002) for share in (0.0, 1.0, 1.2, -0.1)],
)
def test_interval_narrow_by_chance_is_widened_by_the_expected_one(share: float, blocks: int, wave: float) -> None:
    """0.15 sqrt(0.16) of mu, half of it over four times the travel, none where all or nothing touches.

    Mean of both squares, the expected one with six batches; not below the found one, nor above the tolerance.
    """
    strict = levels_of(0.05 + wave * ODD, 0.05 + wave * ODD, blocks=(blocks, blocks))
    levels, batches = replace(strict, plan=replace(PLAN, tolerance=0.05)), 2.0 * blocks
    expected = (0.06 if blocks == 3 else 0.03) if 0.0 < share < 1.0 else 0.0
    for block in (block for each in levels.windows for block in each.recorded):
        block[:, SHARE] = share
    mean, found = levels.interval()
    assert mean == pytest.approx(0.05 + 0.1 * share)
    both = (batches * found**2 + 6.0 * (expected * mean) ** 2) / (batches + 6.0)
    assert levels.stated() == (mean, pytest.approx(max(found, math.sqrt(both)), rel=1e-9, abs=1e-15))
    assert strict.stated()[1] == pytest.approx(max(found, min(math.sqrt(both), 0.02 * mean)), rel=1e-9, abs=1e-15)
    assert (levels.stated()[1] > found) is (share in (0.2, 0.8) and wave < 0.1)


def test_of_three_meshes_the_finest_difference_is_extrapolated() -> None:
    coarse, middle, fine = 0.05 + 0.01 * ODD, 0.052 + 0.01 * ODD + 0.001 * PAIRS, 0.0526 + 0.012 * ODD
    levels = levels_of(coarse, middle, fine, blocks=(20, 8, 4))
    assert levels.friction() == pytest.approx(0.05 + 0.002 + 4.0 / 3.0 * 0.0006, rel=1e-9)
    assert levels.mesh_error() == pytest.approx(0.0002, rel=1e-6)
    widths = [interval_of_means(np.tile(middle - coarse, 8)), interval_of_means(np.tile(fine - middle, 4))]
    assert levels.half_widths()[1:] == pytest.approx([widths[0], 4.0 / 3.0 * widths[1]], rel=1e-9)
    even = levels_of(coarse, middle, fine, blocks=(8, 8, 8))
    assert even.interval()[1] == pytest.approx(interval_of_means(np.tile(fine + (fine - middle) / 3.0, 8)), rel=1e-9)
    films = MeshLevels([filmed(np.full(40, height), 1e-6) for height in (300e-9, 310e-9, 313e-9)], PLAN)
    assert films.film() == pytest.approx((314e-9, 1e-9), rel=1e-9)


def test_errors_follow_windows_that_are_extended() -> None:
    coarse, fine = 0.05 + 0.01 * ODD, 0.052 + 0.01 * ODD + 0.001 * PAIRS
    levels, longer = (levels_of(coarse, fine, blocks=blocks) for blocks in ((20, 4), (40, 5)))
    levels.interval()
    for each, more in zip(levels.windows, longer.windows, strict=True):
        each.recorded[:], each.numbers[:], each.steps = more.recorded, more.numbers, 1
    assert levels.interval() == longer.interval()


def filmed(films: np.ndarray, unit: float) -> Window:
    """A window with these films [m], in units of its own."""
    found = rolled(np.full(films.size, 0.05))
    units: Any = found.run.problem.units
    units.film = unit
    for block, part in zip(found.recorded, np.split(films, len(found.recorded)), strict=True):
        block[:, FILM_MEAN] = part / unit
        block[:, SHARE] = 1e6 * part
    return found


@pytest.mark.parametrize(("wave", "rise"), [(0.0, 6e-9), (20e-9, 0.0), (20e-9, 6e-9), (20e-9, -6e-9)])
def test_error_of_the_film_holds_mesh_and_time(wave: float, rise: float) -> None:
    """A third of the difference of both meshes and the half width of the longest window, in quadrature.

    The asperity load share is extrapolated alike.
    """
    coarse = 300e-9 + np.tile(np.repeat(wave * ODD, 5), 5)
    levels = MeshLevels([filmed(coarse, 1e-6), filmed(coarse[:40] + rise, 2e-6)], PLAN)
    mean = 300e-9 + 4.0 / 3.0 * rise
    assert levels.film() == (pytest.approx(mean), pytest.approx(abs(rise) / 3.0, abs=1e-18))
    time = batch_means(coarse, 10)[1]
    assert levels.film_error() == pytest.approx(math.hypot(rise / 3.0, time) / mean, rel=1e-9)
    assert (time > 1e-9) is (wave > 0.0)
    assert levels.share() == pytest.approx(1e6 * mean)
    short = MeshLevels([filmed(coarse[:20], 1e-6), filmed(coarse[:20], 1e-6)], PLAN)  # one draw
    assert short.film_error() == pytest.approx(1.645 * wave / 300e-9, rel=1e-9, abs=1e-15)


def test_parts_of_the_error_of_a_rough_contact_add_in_quadrature() -> None:
    for order in ((3.0, 4.0, 12.0, 84.0), (84.0, 12.0, 4.0, 3.0)):
        names = ("mesh_error", "statistical_error", "subgrid_error", "exchange_error")
        run: Any = SimpleNamespace(**dict(zip(names, order, strict=True)))
        assert TransientResult.friction_error.__get__(run) == pytest.approx(85.0, rel=1e-12)


@pytest.mark.parametrize(
    ("exchanged", "error", "reason"), [(0.4, 0.06, ""), (1.3, 0.195, ""), (1.4, 0.21, "net_exchange")]
)
def test_net_exchange_of_the_side_flow_is_an_error_of_friction(
    monkeypatch: pytest.MonkeyPatch, exchanged: float, error: float, reason: str
) -> None:
    """0.15 of mu for all of the throughput; of more than four tolerances of 5 % the result is unsettled."""
    monkeypatch.setattr("ehl.rough.solve.net_exchange", lambda window: exchanged)
    monkeypatch.setattr(MeshLevels, "stated", lambda levels: (levels.friction(), 0.03 * levels.friction()))
    contact = line(2.0)
    surfaces = gaussian_pair(contact, 0.1e-6, 0.2)
    settings: Any = {"nodes": 100, "travel": 12.0, "accuracy": "fast"}
    run = solve_transient(contact, eyring_oil(), surfaces, **settings)
    error *= 1.0 - run.asperity_load_share  # nothing touches at this film ratio, or hardly
    assert run.exchange_error == pytest.approx(error, rel=1e-12)
    assert run.statistical_error == pytest.approx(0.03, rel=1e-12)
    assert run.friction_error == pytest.approx(math.hypot(run.mesh_error, run.statistical_error, error), rel=1e-12)
    assert (run.status, run.reason) == (("unsettled" if reason else "converged"), reason)
    sealed = solve_transient(contact, eyring_oil(), surfaces, **settings, peklenik_number=math.inf)
    assert sealed.exchange_error == 0.0


def test_slope_of_the_side_flow_by_hand() -> None:
    """Sums 0, 1, 4, 4, 4 of four batches: slope 1.1 by least squares, mean 1. With three batches their mean."""
    found = window(np.zeros(10))
    found.run.problem.model.contact = SimpleNamespace(middle_first=1, middle_last=3)
    found.run.state = SimpleNamespace(mass=np.array([9.0, 0.5, 0.5, 9.0]))  # type: ignore[assignment]
    found.exchanges.append(np.outer([1.0, 3.0, 0.0, 0.0], [0.1, 0.4, -0.3]))
    assert net_exchange(found) == pytest.approx(1.1, rel=1e-12)
    del found.exchanges[:]
    found.exchanges += [np.array([[each, -3.0 * each]]) for each in (3.0, 0.0, 0.0)]
    assert net_exchange(found) == pytest.approx(4.0)


def test_bounded_run_is_one_draw_of_stretches_as_long_as_a_block() -> None:
    """The front (2.9 b, 5 steps each) does not count, then means .04, .06, .05, .05 and the window .05.

    Student's t of the 90 % interval at four degrees of freedom: 2.13185.
    """
    coarse = rolled(np.full(10, 0.05))
    start = np.zeros((15 + 3 + 40, COLUMNS))  # three steps are less than a stretch
    start[:18, MU_FLUID] = 9.0
    start[18:, MU_FLUID] = np.repeat([0.04, 0.06, 0.05, 0.05], 10)
    coarse.started.append(start)
    levels = MeshLevels([coarse, rolled(np.full(20, 0.051), 10)], replace(PLAN, reduced=True, block=2.0))
    assert levels.drift() == pytest.approx(2.13185 * math.sqrt(2e-4 / 4.0), rel=1e-5)
    assert levels.interval() == pytest.approx((0.051 + 0.001 / 3.0, levels.drift()), rel=1e-9)
    assert replace(levels, plan=PLAN).drift() == 0.0


def test_meshes_without_a_block_in_common_are_a_failure_with_its_reason() -> None:
    """The first block of one mesh went astray as often as it was rolled anew, and what both rolled ended apart."""
    coarse, fine = rolled(np.full(40, 0.04)), rolled(np.full(80, 0.05), 10)
    coarse.numbers[:], fine.numbers[:] = [0, 1], [2, 3]
    levels = MeshLevels([coarse, fine], PLAN)
    for figure in (levels.friction, levels.mesh_error, levels.interval):
        with fails("film_jump"):
            figure()


def test_two_meshes_are_compared_in_the_same_pieces() -> None:
    """2.6 b on one mesh and 2.4 b on the other, by the steps that divide a block, are the same travel."""
    coarse, fine = window(np.full(13, 0.049), 5), window(np.linspace(0.04, 0.06, 24), 10)
    levels = MeshLevels([coarse, fine], PLAN)
    assert coarse.pieces([0], 0.5 * PLAN.batch) != fine.pieces([0], 0.5 * PLAN.batch)
    assert levels.differences(1).mean() == pytest.approx(0.001, rel=1e-9)
    mean, half_width = levels.interval()
    assert mean == pytest.approx(0.05 + 0.001 / 3.0)
    assert half_width > 0.0


def test_interval_of_a_corrected_mean_covers_as_it_says() -> None:
    """The fine mesh gives 0.99 times the coarse one in the mean, the extrapolation 1 - 4/3 x 0.01 times."""
    rng = np.random.default_rng(6)
    inside = 0
    for _ in range(200):
        coarse = 0.05 + 0.005 * np.repeat(rng.standard_normal(96), 5)
        fine = 0.99 * coarse[:80] + 0.001 * np.repeat(rng.standard_normal(16), 5)
        mean, half_width = MeshLevels([rolled(coarse), rolled(fine)], PLAN).interval()
        inside += abs(mean - 0.05 * (1.0 - 0.04 / 3.0)) < half_width
    assert 0.83 < inside / 200 < 0.97


def test_other_stretches_of_the_surfaces_widen_the_interval() -> None:
    """Surface 1 brings 10 b of 40 b travel, surface 2 all it can: growth 0.8 x 4 + 0.2 x 1 = 3.4."""
    line = LineContact(0.01, 226e9, 1e5, 2.0, 0.0)
    b = line.half_width

    def profile(rms: float, length: float, correlation_length: float = 0.0) -> Any:
        return SimpleNamespace(rms=rms, length=length * b, correlation_length=correlation_length * b)

    surfaces: Any = SimpleNamespace(
        profile_1=profile(2.0, 10.0), profile_2=profile(1.0, 1000.0), rms=math.sqrt(5.0), heights=None
    )
    rolled = window(np.zeros(200))
    assert realisation_error(rolled, surfaces, line, 0.01) == pytest.approx(0.01 * math.sqrt(3.4), rel=1e-12)
    assert realisation_error(rolled, RoughSurfaces(), line, 0.01) == 0.0
    # both ends of the window show more of a long surface than its travel: growth 40/45, which does not narrow
    long: Any = SimpleNamespace(profile_1=profile(1.0, 1000.0, 5.0), profile_2=None, rms=1.0)
    assert realisation_error(rolled, long, line, 0.01) == 0.01
    # a surface that stands still shows one correlation length, here 5 b of 40 b
    standing: Any = SimpleNamespace(profile_1=None, profile_2=profile(1.0, 1000.0, 5.0), rms=1.0)
    sliding = LineContact(0.01, 226e9, 1e5, 2.0, 2.0)
    assert sliding.speed_2 == 0.0
    assert realisation_error(rolled, standing, sliding, 0.01) == pytest.approx(0.01 * math.sqrt(8.0), rel=1e-12)


@pytest.mark.parametrize(
    ("last", "roughness", "astray"),
    [(4.9, 0.0, False), (5.1, 0.0, True), (math.nan, 0.0, True), (9.9, 2.0, False), (10.1, 2.0, True)],
)
def test_a_step_of_five_times_the_median_film_went_astray(last: float, roughness: float, astray: bool) -> None:
    """Or of the composite Rq, where that is more; where nearly all steps did, the films are far too thick."""
    films = np.array([*np.ones(8), last])
    assert film_jumped(films, films, roughness) is astray
    assert film_jumped(1e9 * films, 1e9 * films, roughness)


# --- rough contact: what is left out


def test_roughness_left_out_of_a_thick_film_is_added_to_the_error() -> None:
    """0.065 (2.8/lambda)^1.8, divided by the stress ratio + 0.02 where the film is far below tau0."""
    assert roughness_effect(2.8) == pytest.approx(0.065, rel=1e-12)
    assert roughness_effect(5.6) == pytest.approx(0.065 / 3.4822022531845, rel=1e-9)
    assert roughness_effect(2.8, 0.08) == pytest.approx(0.65, rel=1e-12)
    assert roughness_effect(2.8, 0.0) == pytest.approx(3.25, rel=1e-12)
    smooth = case(model={"thermal": "off"}).solve()
    rough = case(surface={"roughness_rms_1": smooth.film_central / 9.0}, model={"thermal": "off"})
    result = rough.solve()
    assert result.transient is None
    ratio = film_stress_ratio(smooth.friction_fluid, rough.line_contact(), rough.lubricant.lubricant())
    expected = smooth.friction_error + roughness_effect(9.0, ratio)
    assert film_stress_ratio(0.0, rough.line_contact(), rough.lubricant.lubricant()) == math.inf
    # mu times a mean pressure of 0.785 GPa over 5 MPa, or over the limit of the stress where that is all there is
    newtonian = Lubricant(0.02, 18e-9, limiting_shear_coefficient=0.08)
    eyring = replace(newtonian, rheology="eyring", eyring_stress=5e6)
    assert film_stress_ratio(0.05, rough.line_contact(), eyring) == pytest.approx(0.05 * 50.0 * math.pi, rel=1e-9)
    assert film_stress_ratio(0.02, rough.line_contact(), newtonian) == pytest.approx(0.25)
    assert film_stress_ratio(0.02, rough.line_contact(), Lubricant(0.02, 18e-9)) == 0.0
    assert roughness_effect(math.inf, 0.0) == 0.0
    assert result.friction_error == pytest.approx(expected, rel=1e-9)


@dataclass(frozen=True)
class Run:
    """What the subgrid film needs of a run."""

    friction_coefficient: float
    friction_boundary_half: float = math.nan
    friction_boundary_double: float = math.nan
    status: str = "converged"
    notes: tuple[str, ...] = ()
    subgrid_error: float = 0.0


@pytest.mark.parametrize(
    ("bounds", "coarser", "error"),
    [
        ((0.049, 0.080), 0.0505, 0.6),  # the film at its peaks
        ((0.020, 0.051), 0.0505, 0.6),  # without the film
        ((0.049, 0.051), 0.0600, 0.5),  # twice the cut-off: 2.5 x 20 %
        ((0.049, 0.051), 0.0400, 0.5),
        ((0.049, 9.999), 0.0505, 7.0),  # no bound above a shear stress of 1 GPa: mu 0.4
        ((0.050, 0.050), 0.0500, 0.07),  # where nothing touches: roughness of a film of that thickness
    ],
)
def test_error_of_a_subgrid_film_is_its_largest_part(
    monkeypatch: pytest.MonkeyPatch, bounds: tuple[float, float], coarser: float, error: float
) -> None:
    """mu 0.05; half width 0.2 mm, load 1 MN/m, so that 1 GPa over the width is 0.4 of the load."""
    seen: list[tuple[int, float]] = []

    def solve(contact: Any, lubricant: Any, surfaces: Any, *, nodes: int, boundary_study: bool, **rest: Any) -> Run:
        seen.append((nodes, rest["boundary_film"]))
        assert (rest["boundary_range"] is None) is (not boundary_study)
        return Run(0.05, *bounds) if boundary_study else Run(coarser)

    monkeypatch.setattr(mixed, "solve_transient", solve)
    monkeypatch.setattr(mixed, "roughness_effect", lambda ratio: 0.07)
    known = {"effective_modulus": 226e9, "pressure_hertz": 1e9, "radius_equivalent": 0.01}
    contact: Any = SimpleNamespace(half_width=0.2e-3, load_per_length=1e6, film_moes=lambda oil: 1e-7, **known)
    surface = SurfaceInput(roughness_rms_1=0.4e-6, roughness_rms_2=0.4e-6, correlation_length=4e-6)
    problem = ContactProblem(contact, Lubricant(0.02, 18e-9), surface, ModelInput(), (STEEL, STEEL), (353.15, 353.15))
    found = mixed._with_subgrid_film(problem, mixed.SmoothFriction(1e-6), {"accuracy": "fast"})
    assert found.subgrid_error == pytest.approx(error, rel=1e-9)
    (nodes, film), (half, thicker) = seen
    assert half == nodes // 2
    assert thicker > film > surface.film_of_contact


def test_error_of_a_dry_contact_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    """Share off the asperities, times the film's friction where that is above mu_b; film by the spread of six moments.

    Gaps of 1 to 6 nm on a boundary film of 20 nm: mean 23.5 nm, standard deviation sqrt(3.5) nm.
    """
    gaps = iter([1e-9 * k for k in (1, 2, 3, 4, 5, 6)] * 2)

    def contact_of(line: LineContact, *rest: Any) -> Any:
        x = np.linspace(-2.0, 2.0, 41) * line.half_width
        return SimpleNamespace(status="converged", x=x, gap=np.full(41, next(gaps)), pressure_max=2e9)

    monkeypatch.setattr(dry_limit, "_dry_contact", contact_of)
    line = LineContact.from_pressure(effective_modulus=226e9, **CONTACT)
    oil = Lubricant(0.02, 10e-9)
    surface = SurfaceInput(roughness_rms_1=0.4e-6, boundary_friction=0.1, boundary_film=20e-9)
    model = ModelInput(accuracy="fast")
    for friction, factor in ((0.05, 1.0), (0.2, 2.0)):
        problem = ContactProblem(line, oil, surface, model, (STEEL, STEEL), (oil.temperature, oil.temperature))
        found = dry_limit.dry_limit(problem, 0.8e-9, friction)
        assert found.friction_error == pytest.approx(0.01 * factor, rel=1e-12)
        spread = 2.015048 * math.sqrt(3.5) / math.sqrt(6.0) / 23.5  # 90 % of Student's t with five degrees of freedom
        assert found.film_error == pytest.approx(spread + 0.8 / 23.5, rel=1e-6)
        assert found.film_mean == pytest.approx(23.5e-9, rel=1e-12)


# --- verdict


@pytest.fixture(scope="module")
def heated() -> ContactResult:
    result = case(contact={**CONTACT, "slide_to_roll": 0.8}, model={"thermal": "on", "accuracy": "fast"}).solve()
    assert result.heat is not None
    return result


def test_friction_of_films_too_hot_for_any_law_counts_as_error(heated: ContactResult) -> None:
    """A third of the shear on nodes above 1000 K: a third of the fluid friction has no law."""
    x = np.linspace(0.0, 3.0, 301)
    hot = np.where(x > 2.0, 1001.0, 900.0)
    heat: Any = SimpleNamespace(x=x, shear_stress=np.full(301, 5e7), temperature_film=hot)
    result = replace(heated, heat=heat, temperature_film_max=1001.0)
    assert friction_above_limit_temperature(result) == pytest.approx(heated.friction_fluid / 3.0, rel=0.01)
    assert friction_above_limit_temperature(replace(result, temperature_film_max=999.0)) == 0.0


def test_rough_films_too_hot_count_by_the_larger_of_two_shares(heated: ContactResult) -> None:
    """Hot spots of the last step count twice: 2 x 0.2; under the mean profile half of the pressure is hot."""

    def rough(spots: float, mean: float) -> ContactResult:
        state = SimpleNamespace(shear=np.array([spots, 1.0 - spots]), temperature=np.array([1100.0, 400.0]))
        profiles = SimpleNamespace(
            pressure_fluid=np.array([mean, 1.0 - mean]), temperature_film=np.array([1100.0, 400.0])
        )
        transient: Any = SimpleNamespace(run=SimpleNamespace(state=state), profiles=profiles)
        return replace(heated, transient=transient, temperature_film_max=1100.0, friction_fluid=0.04)

    for spots, mean, share in ((0.2, 0.1, 0.4), (0.2, 0.5, 0.5), (0.8, 0.0, 1.0)):
        assert friction_above_limit_temperature(rough(spots, mean)) == pytest.approx(share * 0.04, rel=1e-12)


@pytest.mark.parametrize(("peclet", "error"), [(0.1, 0.22), (5.0, 0.04), (0.5**0.5, 0.18), (100.0, 0.006)])
def test_rough_contacts_hold_the_error_of_conduction(
    monkeypatch: pytest.MonkeyPatch, peclet: float, error: float
) -> None:
    """Of the thermal change of ln mu, 0.05 to 0.04 without asperities, for 80 % of the friction."""
    monkeypatch.setattr("ehl.validity.peclet_number", lambda *body: peclet)
    line = LineContact.from_pressure(effective_modulus=226e9, **CONTACT)
    hot, cold = (SimpleNamespace(film_central=3e-7, friction_fluid=mu) for mu in (0.04, 0.05))
    result: Any = SimpleNamespace(
        friction_fluid=0.04, friction_coefficient=0.05, film=hot, isothermal=cold, transient=1
    )
    problem: Any = SimpleNamespace(line=line, lubricant=Lubricant(0.02, 18e-9), bodies=(STEEL, STEEL))
    assert list(_limits_of_heat(result, problem))[-1].friction == pytest.approx(0.8 * error * math.log(1.25))


@pytest.mark.parametrize(("share", "reason"), [(0.02, ""), (0.03, "too_hot")])
def test_friction_without_a_law_widens_the_error_and_unsettles_a_result(
    monkeypatch: pytest.MonkeyPatch, share: float, reason: str
) -> None:
    """Its share of mu is added whole; above half the tolerance of 5 % the result does not stand as converged."""
    plain = case(model={"thermal": "off", "accuracy": "fast"}).solve()
    monkeypatch.setattr(
        "ehl.validity.friction_above_limit_temperature", lambda result: share * result.friction_coefficient
    )
    hot = case(model={"thermal": "off", "accuracy": "fast"}).solve()
    assert hot.friction_error == pytest.approx(plain.friction_error + share, rel=1e-12)
    assert hot.reason == reason
    assert hot.status == ("unsettled" if reason else "converged")
