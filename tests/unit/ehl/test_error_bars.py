"""Error bars as hard as values: every factor and every term of a stated error against numbers worked out by hand."""

import math
from dataclasses import make_dataclass, replace
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
from ehl.rough import TransientResult, averaging, dry_limit, mixed, solve_transient
from ehl.rough._kernels.march import COLUMNS, FILM_MEAN, MU_FLUID, SHARE
from ehl.rough.accuracy import RunPlan
from ehl.rough.averaging import Window, batch_means, film_jumped, interval_of_means
from ehl.rough.mixed import film_stress_ratio, roughness_effect
from ehl.rough.multilevel import MeshLevels
from ehl.rough.solve import _status
from ehl.smooth import hot_film, refine, thermal
from ehl.smooth.continuation import PathReport
from ehl.smooth.newton import Numbers
from ehl.smooth.refine import extrapolate
from ehl.smooth.solver import solve_steady

PLAN = RunPlan(0.01, 0.02, 12.0, 96.0, 2.9, 1.5, boundary_study=False)


@pytest.mark.parametrize(("hot", "error"), [(False, 0.0038095238 + 0.0015), (True, 0.8 * 0.0133333333 + 0.01)])
def test_error_of_three_grids_by_hand(hot: bool, error: float) -> None:
    """Value 1.01 - 0.05/3, before it 1.06 - 0.24/3; 2/7 of their distance, 3 % of the last change, 5e-7."""
    levels = [np.array([1.30]), np.array([1.06]), np.array([1.01])]
    found = extrapolate(levels, 49, hot=hot)
    assert found.values[0] == pytest.approx(0.99333333333, rel=1e-10)
    assert found.errors[0] == pytest.approx(error + 4.9667e-7, rel=1e-8)
    assert found.relative()[0] == pytest.approx((error + 4.9667e-7) / 0.9933333333, rel=1e-7)
    assert extrapolate([np.array([9.0]), *levels], 49, hot=hot).errors == found.errors  # of the last three grids


@pytest.mark.parametrize(("coarsest", "share"), [(13, 0.1), (41, 0.03 * 1.2**6), (97, 0.002), (193, 0.002)])
def test_share_of_the_last_change_falls_with_the_mesh(coarsest: int, share: float) -> None:
    """Exact second order: only the last change is left, 0.03 of it on 49 nodes and as h^6 from 0.002 to 0.1."""
    found = extrapolate([np.array([1e-3 * 4.0**-k]) for k in range(3)], coarsest)
    assert abs(found.values[0]) < 1e-18
    assert found.errors[0] == pytest.approx(share * 1e-3 * (0.25 - 0.0625), rel=1e-12)


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
    line, oil = plain.problem.line, plain.problem.lubricant
    found = estimate_thermal_effect(line, oil, (STEEL, STEEL), film_central=plain.film_central)
    assert not found.matters
    assert found.friction_change > 0.001
    assert found.film_change > 1e-4
    assert left_out.friction_error == pytest.approx(plain.friction_error + found.friction_change, rel=1e-9)
    assert left_out.film_error == pytest.approx(plain.film_error + found.film_change, rel=1e-9)
    assert left_out.mesh_error == plain.mesh_error == plain.friction_error


def rolled(friction: np.ndarray, steps: int = 5, block: float = 4.0) -> Window:
    """A window of blocks of 4 b, with this history of fluid friction and nothing on asperities."""
    units = SimpleNamespace(steps_per_half_width=steps, film=1e-6)
    model = SimpleNamespace(fluid=SimpleNamespace(sliding=1.0), contact=SimpleNamespace(friction=0.1))
    run: Any = SimpleNamespace(problem=SimpleNamespace(units=units, model=model))
    records = np.zeros((friction.size, COLUMNS))
    records[:, MU_FLUID] = friction
    parts = np.split(records, np.arange(block * steps, friction.size, block * steps).astype(int))
    return Window(run, 2.0, recorded=parts, numbers=[*range(len(parts))], rolled=friction.size / steps)


def window(friction: np.ndarray, steps: int = 5) -> Window:
    return rolled(friction, steps, block=1e3)


def test_long_window_of_a_coarse_mesh_is_corrected_by_a_short_one_of_a_fine_mesh() -> None:
    """400 b on the coarse mesh, 16 b on one that gives 0.0005 + 1.02 times as much, the mean over all of it 0.05."""
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
    assert levels.stated() == pytest.approx((0.05, 1.645 * 0.01), rel=1e-9)
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
        (0.01, -1e-3 * ODD, 0.0),
        (0.01, 0.0 * ODD, 0.0),  # a constant difference, or mean
        (0.0, 0.01 * ODD, 0.0),
    ],
)
def test_interval_holds_the_covariance_of_both_parts(wave: float, change: np.ndarray, correlation: float) -> None:
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
    coarse, change = 0.05 + 0.01 * ODD, 0.001 + 0.008 * PAIRS
    levels = levels_of(coarse, coarse + change, blocks=(20, 20))
    # both means are of one travel and move together: batches of the extrapolated series hold their covariance
    width = interval_of_means(np.tile(coarse + change + change / 3.0, 20))
    assert levels.interval() == pytest.approx((0.051 + 0.001 / 3.0, width), rel=1e-9)
    short = MeshLevels([window(np.repeat(0.05 + 0.004 * ODD[:2], 5)), window(np.full(10, 0.051))], PLAN)
    assert short.interval()[1] == pytest.approx(1.645 * 0.004 / 3.0, rel=1e-9)
    assert short.windows[0].interval() == pytest.approx((0.05, 1.645 * 0.004), rel=1e-9)


# the last two shares are extrapolated beyond their range
@pytest.mark.parametrize(
    ("share", "blocks", "wave"),
    [(0.8, 3, 0.0), (0.2, 12, 0.0), (0.2, 3, 0.002), (0.2, 3, 0.2), (1.2, 3, 0.002), (-0.1, 3, 0.002)],
)
def test_interval_narrow_by_chance_is_widened_by_the_expected_one(share: float, blocks: int, wave: float) -> None:
    """0.15 sqrt(0.16) of mu, half of it over four times the travel, none where all or nothing touches."""
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
    found.run.problem.units.film = unit  # type: ignore[misc]
    for block, part in zip(found.recorded, np.split(films, len(found.recorded)), strict=True):
        block[:, FILM_MEAN], block[:, SHARE] = part / unit, 1e6 * part
    return found


@pytest.mark.parametrize(("wave", "rise"), [(0.0, 6e-9), (20e-9, 6e-9), (20e-9, -6e-9)])
def test_error_of_the_film_holds_mesh_and_time(wave: float, rise: float) -> None:
    """A third of the difference of both meshes and the half width of the longest window, in quadrature."""
    coarse = 300e-9 + np.tile(np.repeat(wave * ODD, 5), 5)
    levels = MeshLevels([filmed(coarse, 1e-6), filmed(coarse[:40] + rise, 2e-6)], PLAN)
    mean = 300e-9 + 4.0 / 3.0 * rise
    assert levels.film() == (pytest.approx(mean), pytest.approx(abs(rise) / 3.0, abs=1e-18))
    time = batch_means(coarse, 10)[1]
    assert levels.film_error() == pytest.approx(math.hypot(rise / 3.0, time) / mean, rel=1e-9)
    assert levels.share() == pytest.approx(1e6 * mean)
    short = MeshLevels([filmed(coarse[:20], 1e-6), filmed(coarse[:20], 1e-6)], PLAN)  # one draw
    assert short.film_error() == pytest.approx(1.645 * wave / 300e-9, rel=1e-9, abs=1e-15)


def test_parts_of_the_error_of_a_rough_contact_add_in_quadrature() -> None:
    for order in ((3.0, 4.0, 12.0, 84.0), (84.0, 12.0, 4.0, 3.0)):
        names = ("mesh_error", "statistical_error", "subgrid_error", "exchange_error")
        run: Any = SimpleNamespace(**dict(zip(names, order, strict=True)))
        assert TransientResult.friction_error.__get__(run) == pytest.approx(85.0, rel=1e-12)


@pytest.mark.parametrize(("exchanged", "reason"), [(1.3, ""), (1.4, "net_exchange")])
def test_net_exchange_is_an_error_of_friction(monkeypatch: pytest.MonkeyPatch, exchanged: float, reason: str) -> None:
    """0.15 of mu for all of the throughput; of more than four tolerances of 5 % the result is unsettled."""
    monkeypatch.setattr("ehl.rough.solve.net_exchange", lambda window: exchanged)
    monkeypatch.setattr(MeshLevels, "stated", lambda levels: (levels.friction(), 0.03 * levels.friction()))
    contact = line(2.0)
    surfaces = gaussian_pair(contact, 0.1e-6, 0.2)
    settings: Any = {"nodes": 100, "travel": 12.0, "accuracy": "fast"}
    run = solve_transient(contact, eyring_oil(), surfaces, **settings)
    error = 0.15 * exchanged * (1.0 - run.asperity_load_share)  # nothing touches at this film ratio, or hardly
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
    assert averaging.net_exchange(found) == pytest.approx(1.1, rel=1e-12)
    found.exchanges[:] = [np.array([[each, -3.0 * each]]) for each in (3.0, 0.0, 0.0)]
    assert averaging.net_exchange(found) == pytest.approx(4.0)


def test_bounded_run_is_one_draw_of_stretches_as_long_as_a_block() -> None:
    """The front (2.9 b, 5 steps each) does not count, then means .04, .06, .05, .05 and the window .05."""
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
    """The first block of one mesh fails at every restart, and the ends of both meshes differ."""
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
    rolling, sliding = (LineContact(0.01, 226e9, 1e5, 2.0, slip) for slip in (0.0, 2.0))
    b = rolling.half_width

    def profile(rms: float, length: float, correlation_length: float = 0.0) -> Any:
        return SimpleNamespace(rms=rms, length=length * b, correlation_length=correlation_length * b)

    def error(one: Any, two: Any, line: LineContact, rms: float = 1.0) -> float:
        surfaces: Any = SimpleNamespace(profile_1=one, profile_2=two, rms=rms, heights=None)
        return averaging.realisation_error(window(np.zeros(200)), surfaces, line, 0.01)

    both = error(profile(2.0, 10.0), profile(1.0, 1000.0), rolling, math.sqrt(5.0))
    assert both == pytest.approx(0.01 * math.sqrt(3.4), rel=1e-12)
    assert error(None, None, rolling, 0.0) == 0.0
    # both ends of the window show more of a long surface than its travel: growth 40/45, which does not narrow
    assert error(profile(1.0, 1000.0, 5.0), None, rolling) == 0.01
    # surface 2 stands still and shows one correlation length, here 5 b of 40 b
    assert error(None, profile(1.0, 1000.0, 5.0), sliding) == pytest.approx(0.01 * math.sqrt(8.0), rel=1e-12)


@pytest.mark.parametrize(
    ("last", "roughness", "astray"),
    [(4.9, 0.0, False), (5.1, 0.0, True), (math.nan, 0.0, True), (9.9, 2.0, False), (10.1, 2.0, True)],
)
def test_a_step_of_five_times_the_median_film_went_astray(last: float, roughness: float, astray: bool) -> None:
    """Or of the composite Rq, where that is more; where nearly all steps did, the films are far too thick."""
    films = np.array([*np.ones(8), last])
    assert film_jumped(films, films, roughness) is astray
    assert film_jumped(1e9 * films, 1e9 * films, roughness)


def test_roughness_left_out_of_a_thick_film_is_added_to_the_error() -> None:
    """0.065 (2.8/lambda)^1.8, divided by the stress ratio + 0.02 where the film is far below tau0."""
    assert roughness_effect(2.8) == pytest.approx(0.065, rel=1e-12)
    assert roughness_effect(5.6) == pytest.approx(0.065 / 3.4822022531845, rel=1e-9)
    assert roughness_effect(2.8, 0.08) == pytest.approx(0.65, rel=1e-12)
    assert roughness_effect(math.inf, 0.0) == 0.0
    smooth = case(model={"thermal": "off"}).solve()
    result = case(surface={"roughness_rms_1": smooth.film_central / 9.0}, model={"thermal": "off"}).solve()
    assert result.transient is None
    line, oil = smooth.problem.line, smooth.problem.lubricant
    expected = smooth.friction_error + roughness_effect(9.0, film_stress_ratio(smooth.friction_fluid, line, oil))
    assert result.friction_error == pytest.approx(expected, rel=1e-9)
    assert film_stress_ratio(0.0, line, oil) == math.inf
    # mu times a mean pressure of 0.785 GPa over 5 MPa, or over the limit of the stress where that is all there is
    newtonian = Lubricant(0.02, 18e-9, limiting_shear_coefficient=0.08)
    eyring = replace(newtonian, rheology="eyring", eyring_stress=5e6)
    assert film_stress_ratio(0.05, line, eyring) == pytest.approx(0.05 * 50.0 * math.pi, rel=1e-9)
    assert film_stress_ratio(0.02, line, newtonian) == pytest.approx(0.25)
    assert film_stress_ratio(0.02, line, Lubricant(0.02, 18e-9)) == 0.0


Run = make_dataclass(
    "Run",
    ["friction_coefficient", "friction_boundary_half", "friction_boundary_double", "status", "notes", "subgrid_error"],
)


@pytest.mark.parametrize(
    ("bounds", "coarser", "error"),
    [
        ((0.049, 0.080), 0.0505, 0.6),  # the film at its peaks
        ((0.020, 0.051), 0.0505, 0.6),  # without the film
        ((0.049, 0.051), 0.0400, 0.5),  # twice the cut-off: 2.5 x 20 %
        ((0.049, 9.999), 0.0505, 7.0),  # no bound above a shear stress of 1 GPa: mu 0.4
        ((0.050, 0.050), 0.0500, 0.07),  # where nothing touches: roughness of a film of that thickness
    ],
)
def test_error_of_a_subgrid_film_is_its_largest_part(monkeypatch, bounds, coarser, error):
    """mu 0.05; half width 0.2 mm, load 1 MN/m, so that 1 GPa over the width is 0.4 of the load."""
    seen: list[tuple[int, float]] = []

    def solve(*contact: Any, nodes: int, boundary_study: bool, **rest: Any) -> Any:
        seen.append((nodes, rest["boundary_film"]))
        assert (rest["boundary_range"] is None) is (not boundary_study)
        return Run(*((0.05, *bounds) if boundary_study else (coarser, math.nan, math.nan)), "converged", (), 0.0)

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
    """Gaps of 1 to 6 nm on a boundary film of 20 nm: mean 23.5 nm, standard deviation sqrt(3.5) nm."""
    gaps = iter([1e-9 * k for k in (1, 2, 3, 4, 5, 6)] * 2)

    def contact_of(line: LineContact, *rest: Any) -> Any:
        x = np.linspace(-2.0, 2.0, 41) * line.half_width
        return SimpleNamespace(status="converged", x=x, gap=np.full(41, next(gaps)), pressure_max=2e9)

    monkeypatch.setattr(dry_limit, "_dry_contact", contact_of)
    surface = {"roughness_rms_1": 0.4e-6, "boundary_friction": 0.1, "boundary_film": 20e-9}
    lubricant = {"viscosity_inlet": 0.02, "pressure_viscosity": 10e-9}
    problem = case(lubricant=lubricant, surface=surface, model={"accuracy": "fast"}).problem()
    for friction, factor in ((0.05, 1.0), (0.2, 2.0)):
        found = dry_limit.dry_limit(problem, 0.8e-9, friction)
        assert found.friction_error == pytest.approx(0.01 * factor, rel=1e-12)
        spread = 2.015048 * math.sqrt(3.5) / math.sqrt(6.0) / 23.5  # 90 % of Student's t with five degrees of freedom
        assert found.film_error == pytest.approx(spread + 0.8 / 23.5, rel=1e-6)
        assert found.film_mean == pytest.approx(23.5e-9, rel=1e-12)
