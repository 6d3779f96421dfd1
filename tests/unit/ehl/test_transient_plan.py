"""Mesh, window and interval of a transient run: what is planned, and what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest
from contacts import line_contact
from refusals import fails

from ehl.contact import Contact
from ehl.fluid.lubricant import Lubricant
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.rough import RoughSurfaces, accuracy
from ehl.rough._kernels.march import FILM_MIN
from ehl.rough.accuracy import BATCH, WORK, RunPlan, make_run_plan, mesh_levels, with_overrides
from ehl.rough.multilevel import MeshLevels
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
    plan = plan_of(line_contact(), profile)
    companion = 2.0 * plan.spacing * line_contact().half_width
    assert companion <= profile.cutoff
    assert plan.coarsest == pytest.approx(2.5e-6 / 2.2 / line_contact().half_width)


@pytest.mark.parametrize(("accuracy", "nodes"), [("fast", 2048), ("standard", 4096), ("reference", 8192)])
def test_budget_of_nodes(accuracy: str, nodes: int) -> None:
    line = line_contact()
    fine = generate_profile(1e-7, LENGTH * line.half_width / nodes * 4.0, 1e-3, 1e-7, 1)
    plan = with_overrides(plan_of(line, fine, accuracy), None, 20.0, LENGTH)
    assert LENGTH / plan.spacing == pytest.approx(nodes)
    finer = generate_profile(1e-7, LENGTH * line.half_width / nodes * 2.0, 1e-3, 1e-7, 1)
    with fails("mesh_budget"):
        with_overrides(plan_of(line, finer, accuracy), None, None, LENGTH)


def test_window_follows_roughness_longer_than_the_contact() -> None:
    line = line_contact()
    short = plan_of(line, generate_profile(1e-7, 0.2 * line.half_width, 1e-2, 1e-6, 1))
    waves = generate_profile(1e-7, 4.0 * line.half_width, 1e-2, 1e-5, 1)
    long = plan_of(line, waves)
    assert short.batch == BATCH
    assert long.batch == pytest.approx(3.0 * waves.correlation_length / line.half_width)
    assert long.window_max / short.window_max == pytest.approx(long.batch / short.batch)


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
    plans = {
        level: make_run_plan(level, line, RoughSurfaces(wave), ratio * wave.rms, drained=False, thermal=False)
        for level in ("fast", "standard", "reference")
    }
    assert 1.0 / plans["standard"].spacing == pytest.approx(nodes, rel=0.01)
    assert plans["standard"].spacing == pytest.approx(2.0 * plans["reference"].spacing)
    assert plans["fast"].spacing <= 2.5 * plans["standard"].spacing * (1.0 + 1e-12)
    thick = make_run_plan("standard", line, RoughSurfaces(wave), 0.5 * wave.rms, drained=False, thermal=False)
    assert thick.spacing > plans["standard"].spacing


# --- meshes and budget


def test_meshes_halve_down_to_the_coarsest_that_shows_the_roughness() -> None:
    """Four from 0.01 to 0.08 b where 0.05 b is fine enough twice over; fewer nodes or a fixed window end it earlier."""
    plan = RunPlan(0.01, 0.02, 12.0, 96.0, 2.9, 1.5, boundary_study=False, coarsest=0.05)
    assert mesh_levels(plan, 4000) == 4
    assert mesh_levels(replace(plan, coarsest=0.01), 4000) == 2
    assert mesh_levels(plan, 300) == 3
    assert mesh_levels(replace(plan, window_max=12.0), 4000) == 2
    assert mesh_levels(replace(plan, inlet=0.04), 4000) == 2


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
    """The meshes of each contact that is rolled."""
    found: list[MeshLevels] = []
    rolled = MeshLevels.roll

    def roll(self: MeshLevels) -> None:
        rolled(self)
        found.append(self)

    monkeypatch.setattr(MeshLevels, "roll", roll)
    return found


# --- bound of the work


def bounded(**change: object) -> Contact:
    """Start-up and window take some 4e6 node-iterations at "fast", of fine roughness in a thin film."""
    values = {
        "oil": "75w90", "temperature": 363.15, "pressure_hertz": 1.2e9, "radius_equivalent": 20e-3,
        "speed_entrainment": 1.0, "slide_to_roll": 0.3, "roughness_rms": 0.3e-6, "correlation_length": 20e-6,
        "accuracy": "fast",
    }  # fmt: skip
    return Contact(**(values | change))


def test_a_contact_beyond_its_bound_is_shortened_and_its_interval_holds_the_longer_run(
    monkeypatch: pytest.MonkeyPatch, found: list[MeshLevels]
) -> None:
    """Half of the travel, less work, and both means inside both errors."""
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
    assert math.isfinite(shorter.friction_error)
    assert shorter.statistical_error * shorter.friction_coefficient >= found[1].drift() > 0.0
    apart = abs(shorter.friction_coefficient - longer.friction_coefficient)
    assert apart <= math.hypot(
        shorter.friction_error * shorter.friction_coefficient, longer.friction_error * longer.friction_coefficient
    )


def test_the_dearest_contacts_of_the_gear_range_stay_near_their_bound(found: list[MeshLevels]) -> None:
    """Thin films at high load, whose inlet needs 1385 nodes: 5e7 node-iterations for what it takes.

    That gives mu 0.0312, with an error of 5 %.
    """
    dear = Contact(
        oil="75w90", temperature=399.607, pressure_hertz=1.19501e9, radius_equivalent=26.942e-3,
        speed_entrainment=0.118761, slide_to_roll=0.13462, speed_sliding_lengthwise=0.209,
        roughness_rms_1=91.25e-9, roughness_rms_2=91.25e-9, correlation_length=22.7e-6, peklenik_number=5.236,
        accuracy="fast",
    )  # fmt: skip
    result = dear.solve()
    assert result.status != "failed"
    assert found[-1].plan.reduced
    assert found[-1].work < WORK["fast"] * accuracy.BOUND
    assert abs(result.friction_coefficient - 0.0312) <= result.friction_error * result.friction_coefficient
    assert result.friction_error < 0.4


# --- light loads on thick films, and on valleys wider than the contact


def test_a_light_load_on_a_thick_film_does_not_fly_apart() -> None:
    """The macroscopic pressure carried 1.3 of the load, and films grew to metres; a tenth of the Rq gives 4.7 um."""
    light = Contact(
        oil="75w90", temperature=298.15, pressure_hertz=0.2e9, radius_equivalent=80e-3, speed_entrainment=20.0,
        slide_to_roll=0.01, roughness_rms=1.2e-6, correlation_length=120e-6, peklenik_number=0.35, accuracy="fast",
        seed=167,
    )  # fmt: skip
    result = light.solve()
    run = result.transient
    assert run is not None
    assert run.fallbacks.lagged + run.fallbacks.unconverged == 0
    assert run.film_mean == pytest.approx(4.7e-6, rel=0.25)
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
    assert run is not None
    assert run.film_min == run.boundary_film
