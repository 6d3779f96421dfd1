"""The rough contact: results, seeds, shortcuts; mesh, window, interval and work of a run."""

import math
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from contacts import line_contact
from refusals import fails
from samples import contact_case

from ehl.common.errors import ConvergenceError
from ehl.common.validation import validate
from ehl.contact import Contact
from ehl.fluid.lubricant import Lubricant
from ehl.inputs import SurfaceInput
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.rough import RoughSurfaces, accuracy, solve_transient
from ehl.rough._kernels.march import FILM_MIN
from ehl.rough.accuracy import BATCH, WORK, RunPlan, make_run_plan, mesh_levels, with_overrides
from ehl.rough.multilevel import MeshLevels, affordable, least_levels, least_work, start_up
from ehl.rough.run import TransientRun
from ehl.rough.scaling import Settings, build_problem
from ehl.surface.roughness import RoughProfile, generate_profile

LENGTH = 4.0  # of the mesh [b]


def plan_of(line: LineContact, profile: RoughProfile, accuracy: str = "fast"):  # type: ignore[no-untyped-def]
    surfaces = RoughSurfaces(profile)
    return make_run_plan(accuracy, line, surfaces, 1e-6, drained=True, thermal=False)  # type: ignore[arg-type]


def test_mesh_carries_the_short_cutoff_of_a_measured_profile() -> None:
    x = np.arange(4000) * 1e-6
    profile = RoughProfile.of(1e-7 * np.sin(x / 2e-5), 1e-6, cutoff=2.5e-6)
    line = line_contact()
    plan = plan_of(line, profile)
    assert 2.0 * plan.spacing * line.half_width <= profile.cutoff
    assert plan.coarsest == pytest.approx(2.5e-6 / 2.2 / line.half_width)
    # the window follows roughness longer than the contact
    short = plan_of(line, generate_profile(1e-7, 0.2 * line.half_width, 1e-2, 1e-6, 1))
    waves = generate_profile(1e-7, 4.0 * line.half_width, 1e-2, 1e-5, 1)
    long = plan_of(line, waves)
    assert (short.batch, long.batch) == pytest.approx((BATCH, 3.0 * waves.correlation_length / line.half_width))
    assert long.window_max / short.window_max == pytest.approx(long.batch / short.batch)


@pytest.mark.parametrize(("accuracy", "nodes"), [("fast", 2048), ("standard", 4096), ("reference", 8192)])
def test_budget_of_nodes(accuracy: str, nodes: int) -> None:
    line = line_contact()
    finer, fine = (generate_profile(1e-7, k * LENGTH * line.half_width / nodes, 1e-3, 1e-7, 1) for k in (2.0, 4.0))
    plan = with_overrides(plan_of(line, fine, accuracy), None, 20.0, LENGTH)
    assert LENGTH / plan.spacing == pytest.approx(nodes)
    with fails("mesh_budget"):
        with_overrides(plan_of(line, finer, accuracy), None, None, LENGTH)


def test_a_finer_mesh_takes_over_travel_and_film_and_has_no_holes_in_the_macroscopic_averages() -> None:
    line = line_contact(pressure_hertz=1.7e8, radius_equivalent=0.0015)
    rough = RoughSurfaces(generate_profile(6e-7, 5e-6, 3e-4, 2.5e-7, 1))
    oil = Lubricant(0.003, 15e-9)
    steel = Material.load("steel")
    for nodes in (97, 98):  # ends of both meshes apart
        settings = Settings(nodes, 20e-9, 0.1, 1.0, False, 8e9)
        coarse = TransientRun(build_problem(line, oil, rough, (steel, steel), settings))
        coarse.advance(8)
        finer = replace(settings, nodes=2 * nodes, start_travel=coarse.travel)
        fine = TransientRun(build_problem(line, oil, rough, (steel, steel), finer))
        fine.start_from(coarse)
        assert fine.travel == pytest.approx(coarse.travel, abs=fine.problem.model.surfaces.spacing)
        films = [run.state.film.mean() * run.problem.units.film for run in (coarse, fine)]
        assert films[1] == pytest.approx(films[0], rel=0.01)
        model = fine.problem.model
        exchanging = slice(model.side_flow.first, model.contact.outlet)
        assert np.all(fine.macroscopic.typical[exchanging] > 0.0)
        assert np.all(fine.macroscopic.conductance[exchanging] > 0.0)


@pytest.mark.parametrize(("ratio", "nodes"), [(0.3, 168), (0.15, 292), (0.05, 340)])
def test_spots_of_thin_films_set_the_mesh_however_long_the_waves(ratio: float, nodes: float) -> None:
    """Nodes per b that kept mu within 1.5 % of 600 per b for correlation lengths of 0.2 and 0.4 b."""
    line = line_contact(pressure_hertz=1.5e9)
    wave = generate_profile(0.4e-6, 0.4 * line.half_width, 32.0 * line.half_width, 0.02 * line.half_width, 1)

    def spacing(level: Any, ratio: float = ratio) -> float:
        return make_run_plan(level, line, RoughSurfaces(wave), ratio * wave.rms, drained=False, thermal=False).spacing

    assert 1.0 / spacing("standard") == pytest.approx(nodes, rel=0.01)
    assert spacing("standard") == pytest.approx(2.0 * spacing("reference"))
    assert spacing("fast") <= 2.5 * spacing("standard") * (1.0 + 1e-12)
    assert spacing("standard", 0.5) > spacing("standard")


def test_meshes_halve_down_to_the_coarsest_that_shows_the_roughness() -> None:
    """Four from 0.01 to 0.08 b where 0.05 b is fine enough twice over; fewer nodes or a fixed window end it earlier."""
    plan = RunPlan(0.01, 0.02, 12.0, 96.0, 2.9, 1.5, boundary_study=False, coarsest=0.05)
    assert (mesh_levels(plan, 4000), mesh_levels(plan, 300)) == (4, 3)
    for change in ({"coarsest": 0.01}, {"window_max": 12.0}, {"inlet": 0.04}):
        assert mesh_levels(replace(plan, **change), 4000) == 2


def test_film_at_high_pressure_does_not_collapse_on_a_coarse_mesh() -> None:
    """At 2.5 GPa, 0.54 m/s and lambda 0.9 a mesh of 1.4 inlet sweeps gave mu 0.07, which finer ones kept for long."""
    contact = Contact(
        oil="75w90", temperature=360.376, pressure_hertz=2.469e9, radius_equivalent=15.73e-3, speed_entrainment=0.538,
        slide_to_roll=0.2039, speed_sliding_lengthwise=0.471, roughness_rms_1=45.06e-9, roughness_rms_2=45.06e-9,
        correlation_length=38.2e-6, accuracy="fast", seed=1091, eyring_stress="5 MPa",
    )  # fmt: skip
    result = contact.solve()
    assert result.asperity_load_share < 0.05
    assert 0.01 < result.friction_coefficient < 0.03


@pytest.fixture
def found(monkeypatch: pytest.MonkeyPatch) -> list[MeshLevels]:
    found: list[MeshLevels] = []
    rolled = MeshLevels.roll

    def roll(self: MeshLevels) -> None:
        rolled(self)
        found.append(self)

    monkeypatch.setattr(MeshLevels, "roll", roll)
    return found


def bounded(**change: object) -> Contact:
    """Start-up and window take some 4e6 node-iterations at "fast", of fine roughness in a thin film."""
    values = {
        "oil": "75w90", "temperature": 363.15, "pressure_hertz": 1.2e9, "radius_equivalent": 20e-3,
        "speed_entrainment": 1.0, "slide_to_roll": 0.3, "roughness_rms": 0.3e-6, "correlation_length": 20e-6,
        "accuracy": "fast",
    }  # fmt: skip
    return Contact(**(values | change))


def test_a_contact_beyond_its_bound_is_shortened(monkeypatch: pytest.MonkeyPatch, found: list[MeshLevels]) -> None:
    monkeypatch.setitem(WORK, "fast", 1e6)
    monkeypatch.setattr(accuracy, "BOUND", 1e6)
    longer = bounded().solve()
    monkeypatch.setattr(accuracy, "BOUND", 1.0)
    shorter = bounded().solve()
    assert [levels.plan.reduced for levels in found] == [False, True]
    assert any("work limited" in note for note in shorter.notes)
    assert not any("work limited" in note for note in longer.notes)
    assert found[1].windows[0].rolled < 0.5 * found[0].windows[0].rolled
    assert found[1].work < 0.75 * found[0].work
    assert shorter.statistical_error * shorter.friction_coefficient >= found[1].drift() > 0.0
    errors = [each.friction_error * each.friction_coefficient for each in (shorter, longer)]
    assert abs(shorter.friction_coefficient - longer.friction_coefficient) <= math.hypot(*errors)


def test_a_light_load_on_a_thick_film_does_not_fly_apart() -> None:
    """The macroscopic pressure carried 1.3 of the load, and films grew to metres; smooth flanks have 5.6 um."""
    light = Contact(
        oil="75w90", temperature=298.15, pressure_hertz=0.2e9, radius_equivalent=80e-3, speed_entrainment=20.0,
        slide_to_roll=0.01, roughness_rms=1.2e-6, correlation_length=120e-6, peklenik_number=0.35, accuracy="fast",
        seed=167,
    )  # fmt: skip
    result = light.solve()
    run = result.transient
    assert run.fallbacks.lagged + run.fallbacks.unconverged == 0
    assert run.film_mean == pytest.approx(5.6e-6, rel=0.25)
    assert run.friction_coefficient < 2.5e-4
    assert run.friction_error < 0.3


def test_a_valley_wider_than_the_contact_is_no_film_that_jumped() -> None:
    """Correlation length 1.5 b, 37 nm of film on 0.76 um of roughness: a film of 1.06 um where a valley passes."""
    wide = Contact(
        oil="75w90", temperature=399.338, pressure_hertz=0.374883e9, radius_equivalent=6.476e-3,
        speed_entrainment=0.311645, slide_to_roll=0.572586, speed_sliding_lengthwise=0.0653, roughness_rms=0.765453e-6,
        correlation_length=61.8e-6, peklenik_number=0.77, accuracy="fast",
    )  # fmt: skip
    result = wide.solve()
    assert result.status != "failed"
    assert 0.9 < result.friction_coefficient / wide.surface.boundary_friction < 1.0


def test_smallest_film_is_no_thinner_than_the_boundary_film(monkeypatch: pytest.MonkeyPatch) -> None:
    """A long mean and corrections of shorter windows may add up to less."""
    mean = MeshLevels.mean

    def low(self: MeshLevels, column: int, *, film: bool = False) -> float:
        return 0.5 * mean(self, column, film=film) if column == FILM_MIN else mean(self, column, film=film)

    monkeypatch.setattr(MeshLevels, "mean", low)
    run = bounded(roughness_rms=0.6e-6, correlation_length=100e-6).solve().transient
    assert run.film_min == run.boundary_film


# one block of 4 b, 12 to 96 b on the coarsest mesh and 8 b on finer ones; start-up of 2.9 b and 1.5 b on each mesh
PLAN = RunPlan(0.01, 0.05, 12.0, 96.0, 2.9, 1.5, boundary_study=False, block=4.0, window_fine=8.0, budget=1e4)


@pytest.mark.parametrize(
    ("inlet", "levels", "least", "work"),
    [
        (math.inf, 4, 2, 5.5 + 3.4 * 5.5),
        (0.1, 4, 3, 7.0 + 3.4 * 7.0 + 3.4**2 * 5.5),  # 0.35 of the inlet is finer than four spacings, not than two
        (0.08 / 0.7, 4, 2, 24.2),
        (0.01, 3, 3, 94.38),
    ],
)
def test_smallest_number_of_meshes_and_their_work(inlet: float, levels: int, least: int, work: float) -> None:
    plan = replace(PLAN, inlet=inlet)
    assert least_levels(plan, levels) == least
    assert least_work(plan, 10.0, 2.0, levels) == pytest.approx(20.0 + 10.0 * work)


@pytest.mark.parametrize(
    ("budget", "count"), [(5745.5, 4), (5745.4, 3), (886.2, 3), (886.0, 2), (0.0, 2), (math.inf, 4)]
)
def test_number_of_meshes_within_a_budget(budget: float, count: int) -> None:
    """150 of work and, for four, 165 + 425 + 1271.6 + 3733.88; for three 150 + 374 + 1098.2, within two budgets."""
    coarsest: Any = SimpleNamespace(work=100.0, rate=10.0)
    assert affordable(replace(PLAN, budget=budget), coarsest, 4, 50.0) == count


@dataclass
class Rolled:
    rate: float  # work per b
    rolled: float = 0.0
    work: float = 0.0
    blocks: list[float] = field(default_factory=list)

    def block(self, travel: float) -> None:
        self.blocks.append(travel)
        self.rolled += travel
        self.work += self.rate * travel


class Counted(MeshLevels):
    """mu 0.05 with variances that fall with the travel: of the coarsest mesh and of each difference."""

    spreads: tuple[float, ...] = (0.0, 0.0)
    change = 0.0

    def half_widths(self) -> list[float]:
        return [math.sqrt(s / w.rolled) if w.rolled else 0.0 for s, w in zip(self.spreads, self.windows, strict=True)]

    def interval(self) -> tuple[float, float]:
        return 0.05, math.hypot(*self.half_widths())

    def friction(self) -> float:
        return 0.05

    def differences(self, level: int) -> Any:
        assert level == len(self.windows) - 1
        return np.array([self.change])


def counted(plan: RunPlan, spreads: tuple[float, ...], rolled: tuple[float, ...] = (0.0, 0.0), **more: Any) -> Counted:
    windows: Any = [Rolled(10.0 * 4.0**k, travel, 10.0 * 4.0**k * travel) for k, travel in enumerate(rolled)]
    found = Counted(windows, plan, **more)
    found.spreads = spreads
    return found


# the interval is 5 % of 0.05 where the sum of spread over travel is 6.25e-6
@pytest.mark.parametrize(
    ("spreads", "change", "travels"),
    [
        ((7.4e-5, 0.0), {}, (12.0, 8.0)),
        ((7.6e-5, 0.0), {}, (16.0, 8.0)),
        ((7.4e-5, 5.1e-5), {}, (32.0, 16.0)),  # the largest gain per work: of six blocks four on the coarse mesh first
        ((9e-4, 0.0), {}, (96.0, 8.0)),  # full
        ((2e-4, 0.0), {"budget": 640.0}, (32.0, 8.0)),  # the budget ends it
        ((2e-4, 0.0), {"budget": 640.0, "reserved": 41.0}, (24.0, 8.0)),
        ((8e-4, 0.0), {"budget": 600.0}, (52.0, 8.0)),  # within two budgets the interval is 8 %
        ((2e-1, 0.0), {"budget": 1000.0}, (40.0, 8.0)),  # unlikely to settle: three quarters of it
        ((2e-1, 0.0), {"budget": 270.0}, (12.0, 4.0)),  # the shortest window of a finer mesh is one block
        ((2e-2, 0.0), {"budget": 1000.0}, (200.0, 8.0)),  # within eight budgets the interval is 20 %
        ((2e-2, 0.0), {"budget": 1e9, "reserved": 4e8 - 1e3}, (96.0, 8.0)),  # no more than 4e8 for that
        ((2e-2, 0.0), {"window_max": 12.0, "window_min": 10.0}, (12.0, 8.0)),
        ((2e-2, 0.0), {"window_max": 10.0, "window_min": 10.0, "budget": 0.0}, (10.0, 10.0)),
    ],
)
def test_travel_of_each_mesh(spreads: tuple[float, ...], change: dict[str, float], travels: tuple[float, ...]) -> None:
    reserved = change.pop("reserved", 0.0)
    levels = counted(replace(PLAN, **change), spreads, reserved=reserved)  # type: ignore[arg-type]
    levels.roll()
    assert tuple(window.rolled for window in levels.windows) == travels
    if levels.plan.window_max == levels.plan.window_min:
        assert [window.blocks for window in levels.windows] == [[4.0, 4.0, 2.0]] * 2  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("change", "budget", "needed"),
    [(0.006, 442.0, True), (-0.006, 442.0, True), (0.0049, 442.0, False), (0.006, 440.0, False)],
)
def test_a_finer_mesh_where_two_differ(change: float, budget: float, needed: bool) -> None:
    """120 + 320 of work so far, 3.4 x 40 x (1.5 + 8) = 1292 for another mesh, twice the budget at most: 881."""
    levels = counted(replace(PLAN, budget=2.0 * budget), (0.0, 0.0), (12.0, 8.0))
    levels.change = change
    levels.windows[0].work, levels.windows[1].work = 120.0, 352.0  # type: ignore[misc]
    assert levels.finer_needed() is needed


def case(seed: int = 1, rms: float = 0.085e-6, slide_to_roll: float = 0.05, **model: Any) -> Contact:
    """A thick film over slight roughness; film ratio 6.2 by default."""
    contact = {"radius_equivalent": 0.01, "pressure_hertz": 0.8e9, "speed_entrainment": 3.0}
    return contact_case(
        contact=contact | {"slide_to_roll": slide_to_roll},
        lubricant={"viscosity_inlet": 0.04, "pressure_viscosity": 16e-9},
        surface={"roughness_rms_1": rms, "correlation_length": 60e-6, "seed": seed},
        model={"accuracy": "fast", "thermal": "off"} | model,
    )


def test_roughness_left_out_of_a_thick_film_changes_no_more_than_said() -> None:
    change, unsure, skipped = [], [], case().solve()
    assert skipped.film_ratio == pytest.approx(6.2, rel=0.02)
    assert skipped.transient is None
    assert any("roughness and time: estimated change" in text for text in skipped.skipped)
    for seed in (1, 2, 3):
        full = case(seed, shortcuts="off").solve()
        assert full.transient is not None
        change.append(full.friction_coefficient / skipped.friction_coefficient - 1.0)
        unsure.append(full.friction_error)
        assert abs(change[-1]) < skipped.friction_error + full.friction_error
    assert len(set(change)) == 3  # the seed makes the surface
    assert abs(np.mean(change)) < skipped.friction_error + np.mean(unsure) / math.sqrt(3.0)
    # the estimate is no blank cheque either
    assert skipped.friction_error < 0.02


def test_roughness_left_out_of_a_viscous_film_counts_for_more() -> None:
    viscous = {"slide_to_roll": 1e-3, "friction_tolerance": 0.5}
    skipped = case(**viscous).solve()
    assert skipped.transient is None
    eyring = case(friction_tolerance=0.5).solve()
    assert skipped.friction_error > 3.0 * eyring.friction_error
    changes = []
    for seed in (1, 2):
        full = case(seed, **viscous, shortcuts="off").solve()
        changes.append(full.friction_coefficient / skipped.friction_coefficient - 1.0)
        assert abs(changes[-1]) < skipped.friction_error + full.friction_error
    # the statement holds without the error of the run; with other films it would not
    assert eyring.friction_error < np.mean(changes) < skipped.friction_error
    assert case(slide_to_roll=1e-3).solve().transient is not None
    assert case(slide_to_roll=0.0).solve().transient is None


@pytest.mark.parametrize("kind", ["waves", "scratch"])
def test_measured_roughness_left_out_changes_no_more_than_said(kind: str, tmp_path: Path) -> None:
    x = np.arange(0.0, 1.2e-3, 1e-6)
    heights = np.sin(2.0 * np.pi * x / 60e-6) if kind == "waves" else -4.2 * np.exp(-(((x - 0.6e-3) / 10e-6) ** 2))
    path = tmp_path / "profile.csv"
    rows = "\n".join(f"{a:.9g},{b:.9g}" for a, b in zip(x * 1e6, heights * 0.12, strict=True))
    path.write_text("x [um], height [um]\n" + rows + "\n", encoding="utf-8")
    surface = {"profile_1": str(path), "cutoff_short": "4 um", "cutoff_long": None}
    measured = case().model_copy(update={"surface": validate(SurfaceInput, surface)})
    skipped = measured.solve()
    full = measured.model_copy(update={"model": measured.model.model_copy(update={"shortcuts": "off"})}).solve()
    assert skipped.transient is None
    assert full.transient is not None
    assert skipped.film_ratio == pytest.approx(full.film_ratio, rel=1e-6)
    assert kind == "scratch" or skipped.film_ratio == pytest.approx(6.2, rel=0.03)  # of the same Rq
    change = abs(full.friction_coefficient / skipped.friction_coefficient - 1.0)
    assert change < skipped.friction_error + full.friction_error
    assert skipped.friction_error < 0.025


def test_a_contact_of_far_too_much_work_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shown with a limit below the work of an ordinary contact."""
    monkeypatch.setattr("ehl.rough.averaging.LIMIT", 1e-4)
    result = case(rms=0.3e-6).solve()
    assert (result.status, result.reason) == ("failed", "work_limit")


@pytest.mark.parametrize("finer", ["converged", "unsettled", "ConvergenceError"])
def test_steps_that_do_not_converge_are_repeated_on_a_finer_mesh(finer: str, monkeypatch: pytest.MonkeyPatch) -> None:
    solved: list[int] = []

    def solve(*arguments: Any, nodes: int | None = None, **settings: Any) -> Any:
        found = solve_transient(*arguments, nodes=nodes, **settings)
        solved.append(found.nodes)
        if nodes is None:
            return replace(found, status="unsettled", reason="lagged_steps")
        assert nodes == 2 * solved[0]
        if finer == "ConvergenceError":
            raise ConvergenceError("mesh_budget", "")
        return replace(found, status=finer)

    monkeypatch.setattr("ehl.rough.mixed.solve_transient", solve)
    result = case(rms=0.4e-6).solve()
    assert len(solved) == 2
    assert 1.8 * solved[0] < solved[1] < 2.2 * solved[0]
    assert result.status == ("converged" if finer == "converged" else "unsettled")
    assert any("time step halved" in note for note in result.notes) == (finer == "converged")


class Started:
    """The coarsest mesh of a start-up, of five steps per half-width and 10 of work per b."""

    def __init__(self, thermal: bool) -> None:
        settings, units = SimpleNamespace(thermal=thermal), SimpleNamespace(steps_per_half_width=5)
        self.run, self.problem = self, SimpleNamespace(settings=settings, units=units)
        self.batch, self.steps, self.work, self.pieces, self.warmed = 2.0, 0, 0.0, list[float](), list[Any]()

    def start(self, travel: float) -> None:
        self.pieces.append(travel)
        self.steps += round(5 * travel)
        self.work += 10.0 * travel
        self.travel = self.steps / 5

    def branch(self, problem: RunPlan) -> "Started":
        assert problem.reduced
        return self

    def mean_flux(self, travel: float) -> Any:
        self.warmed.append(("flux", travel))
        return np.array([1.0 * len(self.warmed)])

    def preheat(self, travel: float, flux: Any) -> None:
        assert flux[0] == len(self.warmed)
        self.warmed.append(("heat", travel))


@pytest.mark.parametrize(
    ("change", "thermal", "pieces", "warming"),
    [
        ({"window_max": 12.0, "give_up": 1e9}, True, [10.0], 0.0),
        ({"give_up": 343.0}, False, [0.4, 2.8, 2.8, 2.8, 1.2], 0.0),
        ({"give_up": 341.0}, False, [0.4], None),  # 4 + 96 to go, and 242 of two meshes
        ({"settling": 4.5}, True, [2.8, 2.8, 2.8, 2.8, 1.8], 13.0),  # 3 b more until the bodies are warm
        ({"settling": 4.5, "preheating": 3.0}, True, [2.8, 2.8, 2.8, 1.6], 3.0),
        ({"bound": 341.0}, False, [2.8, 0.2], 0.0),  # 28 + 72 + 242 of two meshes is above: the start-up becomes 3 b
        ({"bound": 341.0, "reduced": True}, False, [2.8, 2.8, 2.8, 1.6], 0.0),
    ],
)
def test_start_up(monkeypatch, change, thermal, pieces, warming):
    def shortened(plan: RunPlan, length: float) -> RunPlan:
        assert length == 0.07
        return replace(plan, startup=3.0, batch=1.0, reduced=True)

    monkeypatch.setattr("ehl.rough.multilevel.reduced_plan", shortened)
    window, given = Started(thermal), replace(PLAN, startup=10.0, **change)
    with fails("mesh_budget") if warming is None else nullcontext():
        plan, flux, travel = start_up(window, given, 4, 0.07, lambda plan: plan)
        assert (travel, flux is None) == (pytest.approx(warming), warming == 0.0)
        assert (plan.reduced, plan.batch) == (given.reduced or given.bound < 342.0, window.batch)
        rounds = [("flux", 0.5), ("heat", 3.0)] * 2 if given.preheating else []
        assert window.warmed == [*rounds, ("flux", 0.5)] * (warming > 0.0)
    assert window.pieces == pytest.approx(pieces)
