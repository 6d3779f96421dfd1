"""Transient mixed EHL of two moving rough surfaces.

Transient Reynolds equation with Couette flow along characteristics, implicit Poiseuille flow, and mass-conserving
cavitation (JFO in the complementary form of Elrod and Adams: p >= 0, filling <= 1, one of them an equality).

1. Start-up on the coarse mesh; finer meshes start from its state and move over the same roughness.
2. The run ends when the interval of mu is within the tolerance, or at the budget of work.
3. The mesh error follows from the two finest meshes.
4. If asperities carry load, mu is computed with the boundary film doubled and halved as well.
"""

import math
import time
from dataclasses import replace

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.elastic_shear import rubbing_friction
from ehl.fluid.lubricant import Lubricant
from ehl.heat.conduction import peclet_number
from ehl.inputs import Accuracy
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.rough._kernels.march import (
    FILM_MEAN,
    FILM_MIN,
    FLASH_MAX,
    ITERATIONS,
    MACRO_LOAD,
    PRESSURE_MAX,
    SHARE,
    STAGE,
    TEMPERATURE_MAX,
)
from ehl.rough._kernels.newton import UNCONVERGED
from ehl.rough.accuracy import SETTLING, RunPlan, make_run_plan, mesh_length, mesh_levels, with_overrides
from ehl.rough.averaging import Window, film_jumped, net_exchange, realisation_error
from ehl.rough.multilevel import ERROR_ALLOWED, MeshLevels, affordable, start_up
from ehl.rough.run import TransientRun
from ehl.rough.scaling import EXCHANGE_WINDOW, RunProblem, Settings, build_problem, density_ratio
from ehl.rough.surfaces import RoughSurfaces
from ehl.rough.transient_result import Fallbacks, Profiles, Snapshot, TransientResult
from ehl.surface.roughness import EP_FILM

# shares of unconverged steps above which a result is unsettled, and above which it has failed
UNCONVERGED_ALLOWED, UNCONVERGED_FAILED = 0.01, 0.03
LAGGED_ALLOWED = 0.02
MACRO_LOAD_ALLOWED = 1.1  # largest integral of the macroscopic pressure over the load
# relative change of mu per net exchange of the side flow over the throughput, from runs with longer and shorter
# averages of its conductances
EXCHANGE_EFFECT = 0.15
SHARE_OF_STUDY = 0.01  # smallest asperity load share with a variation of the boundary film
STUDY_BLOCKS = 4  # blocks of that variation, the first for settling
PECLET_WARNING = 2.0
REPEATED = 2.0  # bounds of the work of a window, beyond which diverged blocks are not repeated


def solve_transient(
    contact: LineContact,
    lubricant: Lubricant,
    surfaces: RoughSurfaces | None = None,
    *,
    accuracy: Accuracy | float = "standard",
    boundary_film: float | None = None,
    boundary_friction: float = 0.10,
    peklenik_number: float = 1.0,
    thermal: bool = False,
    hardness: float = 8e9,
    materials: tuple[Material, Material] | None = None,
    temperature_bulk: tuple[float, float] | None = None,
    film_heat: tuple[FloatArray, ...] | None = None,
    nodes: int | None = None,
    travel: float | None = None,
    boundary_study: bool | None = None,
    boundary_range: tuple[float, float] | None = None,
    fine_roughness: bool = False,
    bounded: bool = False,
) -> TransientResult:
    """Time-averaged friction of a lubricated line contact, from a transient solution with moving rough surfaces.

    contact: geometry, load and motion; either surface may be faster, stationary or in reversed motion.
    lubricant: laws at the inlet temperature.
    surfaces: both profiles; default: smooth.
    accuracy: level, or relative tolerance on mu.
    boundary_film: h_boundary [m], 1 nm to 20 um; default: that of extreme-pressure additives.
    boundary_friction: mu_b of the asperity pressure [-]; less at slips where it sticks (`rubbing_friction`).
    peklenik_number: gamma of the side flow, at least 1/3; infinity: no side flow (sealed valleys).
    thermal: thermal effects in film and surfaces.
    hardness: largest total pressure [Pa].
    materials: thermal properties of both bodies; default: steel.
    temperature_bulk: bulk temperatures of both bodies [K]; default: that of the oil.
    film_heat: heat in the smooth film (`ehl.rough.mixed.film_heat_of`), for `thermal`. That of the pressure-driven flow
        arises where the gap is many times the roughness, and convection matters in thick films: both hardly depend on
        the rough film.
    nodes: fixed number of nodes.
    travel: fixed window [b].
    boundary_study: True: compute mu at half and twice the boundary film even with accuracy "fast"; False: never.
    boundary_range: boundary films instead of half and twice the film, for any asperity load share [m].
    fine_roughness: more nodes, shorter start-up and window, for correlation lengths much shorter than the contact.
    bounded: whether the solution ends with an error if the shortest run exceeds the work of the accuracy.
    Raises `InputError`: a value is out of range, or the given nodes do not resolve the profiles; `ConvergenceError`
    "mesh_budget": the nodes, or the work if `bounded`, of this accuracy do not suffice for the roughness.
    """
    begin = time.perf_counter()
    rough = surfaces if surfaces is not None else RoughSurfaces()
    film = EP_FILM if boundary_film is None else boundary_film
    _check(contact, film, boundary_friction, peklenik_number, hardness)
    bodies = materials if materials is not None else (Material.load("steel"), Material.load("steel"))
    estimate = contact.film_moes(lubricant)
    drained = math.isfinite(peklenik_number) and bool(rough.profiles)
    length = mesh_length(contact, estimate)
    plan = make_run_plan(accuracy, contact, rough, estimate, drained=drained, thermal=thermal, fine=fine_roughness)
    plan = with_overrides(plan, nodes, travel, length)
    if bounded:
        plan = replace(plan, give_up=plan.bound)
    if boundary_study is not None:
        plan = replace(plan, boundary_study=boundary_study)
    sliding_friction = rubbing_friction(contact, boundary_friction)
    settings = Settings(
        round(length / plan.spacing),
        film,
        sliding_friction,
        peklenik_number,
        thermal,
        hardness,
        temperature_bulk=temperature_bulk,
        film_heat=film_heat,
        exchange_window=plan.exchange_window,
    )
    count = mesh_levels(plan, settings.nodes)
    meshes = [max(32, settings.nodes // 2**k) for k in range(count - 1, -1, -1)]

    def problem(nodes: int, travel: float = 0.0, film: float = film) -> RunProblem:
        chosen = replace(settings, nodes=nodes, start_travel=travel, boundary_film=film)
        return build_problem(contact, lubricant, rough, bodies, chosen)

    def coarsest(plan: RunPlan) -> RunProblem:
        nonlocal settings
        settings = replace(settings, tolerance=plan.step_tolerance)
        return problem(meshes[0])

    # a window that is given is rolled whatever it takes
    bound = REPEATED * plan.bound if plan.window_max > plan.window_min else math.inf
    coarse = Window(TransientRun(coarsest(plan)), plan.batch, bound)
    plan, flux, warming = start_up(coarse, plan, count, rough.correlation_length / contact.half_width, coarsest)
    settling = plan.settling if flux is None else SETTLING
    study = 0.0
    if boundary_range is not None or plan.boundary_study:
        study = 2.0 * coarse.rate * min(STUDY_BLOCKS * plan.block, plan.window_max)
    if plan.window_max > plan.window_min:
        count = affordable(plan, coarse, count, study)
    begun = coarse.branch()
    while True:
        levels = MeshLevels([coarse], plan, study)
        for n in meshes[1:count]:
            before = levels.fine.run
            finer = Window(TransientRun(problem(n, before.travel)), plan.batch, bound)
            finer.run.start_from(before)
            if flux is not None:
                x, x_finer = coarse.run.problem.x, finer.run.problem.x
                finer.run.preheat(warming, np.array([np.interp(x_finer, x, row) for row in flux]))
            levels.windows.append(finer)
            for each in levels.windows:
                each.start(settling)
        settled = coarse.run.branch(coarse.run.problem)
        levels.roll()
        if count == len(meshes) or not levels.finer_needed():
            break
        # the finer mesh excluded by the budget is needed: repeat with it
        count += 1
        coarse = begun.branch()

    factors = (math.nan, math.nan)
    share = levels.mean(SHARE)
    if boundary_range is not None or (plan.boundary_study and share > SHARE_OF_STUDY):
        films = boundary_range or (0.5 * film, 2.0 * film)
        thinner, thicker = (_friction_factor(settled, problem(meshes[0], film=f), coarse) for f in films)
        factors = (thinner, thicker)
    return _result(contact, lubricant, rough, bodies, levels, len(meshes), estimate, factors, begin)


def _friction_factor(begun: TransientRun, problem: RunProblem, reference: Window) -> float:
    """Ratio of mu with another boundary film to that of the reference, over its blocks without the first (settling)."""
    varied = Window(begun.branch(problem))
    steps = [len(block) for block in reference.recorded[:STUDY_BLOCKS]]
    known = reference.friction()[: sum(steps)]
    varied.roll(sum(steps) / varied.run.problem.units.steps_per_half_width)
    first = steps[0] if len(steps) > 1 else 0
    mu = float(known[first:].mean())
    return float(varied.friction()[first:].mean()) / mu if mu != 0.0 else 1.0


def _check(contact: LineContact, film: float, friction: float, peklenik: float, hardness: float) -> None:
    if not contact.speed_entrainment > 0.0:
        raise InputError("speed_entrainment", contact.speed_entrainment, "> 0 m/s", "Swap surfaces 1 and 2.")
    if not 1e-9 <= film <= 20e-6:
        raise InputError("boundary_film", film, "1 nm to 20 um")
    if not 0.0 <= friction <= 1.0:
        raise InputError("boundary_friction", friction, "0 to 1")
    if not peklenik >= 1.0 / 3.0 - 1e-12:
        raise InputError("peklenik_number", peklenik, ">= 1/3", "The side-flow model is not validated below it.")
    if not hardness > contact.pressure_hertz:
        raise InputError("hardness", hardness, f"> {contact.pressure_hertz:.3g} Pa, the Hertz pressure")


def _notes(
    contact: LineContact, materials: tuple[Material, Material], problem: RunProblem, plan: RunPlan
) -> tuple[str, ...]:
    notes = []
    if problem.settings.nodes == plan.nodes_max:
        notes.append("the mesh has the maximum number of nodes of this accuracy")
    if plan.reduced:
        notes.append(
            "work limited: shorter start-up and averaging window, larger step tolerance; the error includes the drift"
        )
    elif plan.exchange_window < EXCHANGE_WINDOW:
        warm = ", surfaces preheated by the mean heat flux" if plan.preheating else ""
        notes.append(f"fine roughness: shorter start-up and averaging window{warm}")
    if problem.settings.boundary_film < 10e-9 and problem.model.surfaces.profile_1.size:
        notes.append("boundary film below 10 nm: the mesh may not resolve it")
    if problem.settings.thermal:
        for speed, material in zip((contact.speed_1, contact.speed_2), materials, strict=True):
            peclet = peclet_number(speed, contact.half_width, material)
            if peclet < PECLET_WARNING:
                notes.append(f"Peclet number {peclet:.2g} of a surface: flash temperature overestimated by 8 % or more")
    return tuple(notes)


def _status(levels: MeshLevels) -> tuple[str, str]:
    mean, half_width = levels.interval()
    fine, plan = levels.fine, levels.plan
    stages = fine.everything[:, STAGE]
    if not math.isfinite(mean):
        return "failed", "not_finite"
    if film_jumped(fine.column(FILM_MEAN), fine.column(FILM_MEAN), fine.roughness):
        return "failed", "film_jump"
    if np.mean(stages == UNCONVERGED) > UNCONVERGED_FAILED:
        return "failed", "unconverged_steps"
    for window in levels.windows if not levels.even else [fine]:
        stages = window.records[:, STAGE]
        if np.mean(stages == UNCONVERGED) > UNCONVERGED_ALLOWED or np.mean(stages == UNCONVERGED - 1) > LAGGED_ALLOWED:
            return "unsettled", "lagged_steps"
    if fine.records[:, MACRO_LOAD].mean() > MACRO_LOAD_ALLOWED:
        return "unsettled", "macroscopic_pressure"
    allowed = ERROR_ALLOWED * plan.tolerance
    if exchange_error(levels, net_exchange(levels.longest)) > allowed:
        return "unsettled", "net_exchange"
    if not half_width <= allowed * abs(mean):  # also without an interval
        return "unsettled", "statistical_interval"
    return "converged", ""


def exchange_error(levels: MeshLevels, exchanged: float) -> float:
    """Relative error of mu by a net exchange, for the load share of the film."""
    return EXCHANGE_EFFECT * exchanged * (1.0 - min(max(levels.share(), 0.0), 1.0))


def _result(
    contact: LineContact,
    lubricant: Lubricant,
    surfaces: RoughSurfaces,
    materials: tuple[Material, Material],
    levels: MeshLevels,
    wanted: int,
    estimate: float,
    factors: tuple[float, float],
    begin: float,
) -> TransientResult:
    fine, longest = levels.fine, levels.longest
    run, problem = fine.run, fine.run.problem
    units, model = problem.units, problem.model
    everything = fine.everything
    mu, half_width = levels.stated()
    scale = abs(mu) if mu != 0.0 else math.inf
    status, reason = _status(levels)
    hot = problem.settings.thermal
    inlet = lubricant.temperature
    profiles = fine.profiles
    x = problem.x * units.half_width
    exchanged = net_exchange(longest)
    stages = np.bincount(everything[:, STAGE].astype(int), minlength=UNCONVERGED + 1)
    share = min(max(levels.share(), 0.0), 1.0)
    rubbing = float(model.contact.friction * share)
    notes = _notes(contact, materials, problem, levels.plan)
    if len(levels.windows) < wanted:
        coarse = 2 ** (wanted - len(levels.windows))
        notes = (*notes, f"mesh {coarse} times as coarse as the accuracy requires, to limit the work")
    # corrected by the mean difference of the finer meshes
    history = longest.friction()
    history = history + (mu - float(history.mean()))
    steps_per_half_width = longest.run.problem.units.steps_per_half_width
    return TransientResult(
        status=status,
        reason=reason,
        notes=notes,
        friction_coefficient=mu,
        friction_fluid=mu - rubbing,
        friction_asperity=rubbing,
        asperity_load_share=share,
        roughness_load_share=1.0 - levels.mean(MACRO_LOAD) if model.side_flow.on else math.nan,
        film_mean=levels.film()[0],
        film_min=max(levels.mean(FILM_MIN, film=True), problem.settings.boundary_film),
        pressure_max=levels.mean(PRESSURE_MAX) * units.pressure,
        film_ratio=estimate / surfaces.rms if surfaces.rms > 0.0 else math.inf,
        temperature_film_max=levels.mean(TEMPERATURE_MAX) if hot else inlet,
        temperature_flash=inlet + levels.mean(FLASH_MAX) if hot else inlet,
        statistical_error=half_width / scale,
        realisation_error=realisation_error(longest, surfaces, contact, half_width / scale),
        mesh_error=levels.mesh_error() / scale,
        film_error=levels.film_error(),
        exchange_error=exchange_error(levels, exchanged) if model.side_flow.on else 0.0,
        friction_boundary_half=mu * factors[0],
        friction_boundary_double=mu * factors[1],
        boundary_film=problem.settings.boundary_film,
        net_exchange=exchanged,
        fallbacks=Fallbacks(*(int(n) for n in stages)),
        iterations_per_step=float(everything[:, ITERATIONS].mean()),
        nodes=problem.x.size,
        steps=len(everything),
        repeats=sum(window.repeats for window in levels.windows),
        travel=len(history) / steps_per_half_width,
        seconds=time.perf_counter() - begin,
        history_travel=np.asarray((np.arange(len(history)) + 1.0) / steps_per_half_width, dtype=float),
        history_friction=history,
        profiles=Profiles(
            x=x,
            pressure_fluid=profiles[0] * units.pressure,
            pressure_asperity=profiles[1] * units.pressure,
            pressure_macroscopic=profiles[2] * units.pressure,
            film=profiles[3] * units.film,
            temperature_film=profiles[4],
            temperature_surface=inlet + profiles[5],
        ),
        snapshot=snapshot(run),
        run=run,
    )


def snapshot(run: TransientRun) -> Snapshot:
    """The last step of a run, SI."""
    state, units, fluid = run.state, run.problem.units, run.problem.model.fluid
    pressure = state.fluid_pressure
    gap = np.maximum(state.film, run.problem.model.contact.boundary)
    return Snapshot(
        x=run.problem.x * units.half_width,
        pressure_fluid=pressure * units.pressure,
        pressure_asperity=state.contact_pressure * units.pressure,
        film=gap * units.film,
        filling=np.minimum(state.mass / (density_ratio(pressure, fluid) * gap), 1.0),
        temperature_film=state.temperature.copy(),
    )
