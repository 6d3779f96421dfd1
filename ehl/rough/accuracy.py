"""Mesh, start-up and averaging window of a transient run for a required accuracy."""

import math
from dataclasses import dataclass, replace

from ehl.common.errors import ConvergenceError, InputError
from ehl.inputs import TOLERANCE, Accuracy
from ehl.line_contact import LineContact
from ehl.rough.scaling import EXCHANGE_WINDOW, Settings, solved_length
from ehl.rough.surfaces import RoughSurfaces

BATCH = 2.0  # travel of the smallest batch of the mean [b]
FRONT_STARTUP = 2.9  # until the roughness has filled the contact [b]
DRAINED_STARTUP = 8.0  # additional travel until the macroscopic pressure has settled [b]
SETTLING = 1.5  # after the change to the fine mesh: mu starts up to 40 % high and settles within about 1 b [b]
THERMAL_CAP = 8.0  # longest travel for heating of the slower surface [b]
NODES_MIN, NODES_MAX = 64, 16384
# by level: largest number of nodes of an accurate mesh, and of a mesh that just resolves fine roughness
BUDGET: dict[str, tuple[int, int]] = {
    "fast": (2048, 8192), "standard": (4096, NODES_MAX), "reference": (8192, NODES_MAX)
}  # fmt: skip
MIN_PER_LENGTH = 3.0  # smallest number of nodes per correlation length that resolves the roughness
SPARE = 2.0  # mesh over the minimum number of nodes where an accurate mesh exceeds the first limit
MIN_MESH_LENGTH = 3.7  # inlet and outlet of the thinnest film [b]
PER_WAVELENGTH = 2.2  # nodes per shortest wavelength; the coarse mesh of twice the spacing must resolve it as well
LONG_WAVES = 3.0  # smallest number of correlation lengths in a batch of the mean
LONG_WINDOWS = 8.0  # largest factor of the window for roughness longer than the contact
# fine roughness has many waves in the contact, so that shorter runs give the same mean: smallest correlation length
# with the full window [b], and the smallest share of the window
FINE_LENGTH, MIN_SHARE = 0.1, 1.0 / 3.0
BLOCK = 4.0  # travel between two evaluations of the interval [b]
# tuned on rough contacts solved with both tolerances: changes mu by 1e-4 or less and saves 10 to 35 % of the work
LOOSE_STEP_TOLERANCE = 1e-3

# tuned with validation/work_precision.py: node distance over the width of the inlet sweep (`inlet_sweep`). The smooth
# film is too thin by half the square of this ratio (0.45 to 0.6 over M 13 to 290, L 3 to 9)
PER_SWEEP: dict[str, float] = {"fast": 0.35, "standard": 0.2, "reference": 0.1}
# tuned: of the coarsest of several meshes; with 1.4 the film of a contact at 2.5 GPa collapsed, and mu was wrong
PER_SWEEP_COARSEST = 0.8
NEAR_BOUNDARY, FINER_THERE = 0.15, 1.5  # film ratio below which the mesh is finer still, and the factor
# tuned with validation/work_precision.py: in thin films the edges of the contact spots determine the mesh, for any
# correlation length. "standard" has 64 lambda^-0.8 nodes per b, at most 340; error 1.5 % of mu, second order
SPOT_NODES, SPOT_POWER, SPOT_NODES_MAX = 64.0, 0.8, 340.0
SPOT_RATIO = 0.4  # film ratio below which there are contact spots
PER_SPOT: dict[str, float] = {"fast": 0.4, "standard": 1.0, "reference": 2.0}
SWEEP_FILM_MIN = 0.1  # over the composite Rq: asperities separate the surfaces at thinner films


@dataclass(frozen=True)
class RunPlan:
    """Mesh, windows and work limits of one run."""

    spacing: float  # node distance of the fine mesh [b]; the coarse mesh has twice that
    tolerance: float  # required half width of the 90 % interval of mu, over mu
    # averaging window [b]
    window_min: float
    window_max: float
    startup: float  # travel of the coarse run before the fine run starts [b]
    settling: float  # travel of both before the window [b]
    boundary_study: bool  # whether mu at twice and half the boundary film is computed
    nodes_max: int = NODES_MAX  # largest number of nodes of an accurate mesh
    coarsest: float = math.inf  # largest spacing that resolves the roughness [b]; infinity when smooth
    batch: float = BATCH  # travel of the smallest batch of the mean [b]
    nodes_fine_max: int = NODES_MAX  # largest number of nodes for fine roughness
    exchange_window: float = EXCHANGE_WINDOW  # travel per update of the macroscopic pressure [b]
    # travel over which the mean heat of the coarse run warms the surfaces without a solution of the film [b]
    preheating: float = 0.0
    window_fine: float = BATCH  # shortest averaging window on all meshes but the coarsest [b]
    budget: float = math.inf  # work of the whole contact, in node-iterations (`ehl.rough.averaging.Window.work`)
    inlet: float = math.inf  # width of the inlet sweep, which every mesh must resolve [b]
    bound: float = math.inf  # work above which the reduced plan is used (`reduced_plan`)
    give_up: float = math.inf  # work above which another model gives the result instead
    block: float = BLOCK  # travel between two evaluations of the interval [b]
    step_tolerance: float = Settings.tolerance  # of mass and gap in one step, over the film unit
    reduced: bool = False  # whether start-up, blocks and steps are reduced because of the cost


# work of a contact that is not smooth, in node-iterations of some 100 ns: a contact that needs more ends with the
# interval reached
WORK: dict[str, float] = {"fast": 1e7, "standard": 4e7, "reference": 1e9}
BOUND = 2.5  # multiple of the budget above which the plan is reduced (`reduced_plan`)
LEVELS_MAX = 4  # meshes of one contact
FINE_WINDOW = 8.0  # shortest window of the finer meshes, which supply differences only [b]

# nodes per correlation length above and below a film ratio of 0.3, nodes per b when smooth, windows [b]
LEVELS: dict[str, tuple[float, float, float, float, float]] = {
    "fast": (6.0, 10.0, 64.0, 12.0, 96.0),
    "standard": (12.0, 20.0, 128.0, 12.0, 384.0),
    "reference": (24.0, 40.0, 256.0, 24.0, 768.0),
}


def level_of(accuracy: Accuracy | float) -> str:
    """Name of the level for an accuracy.

    Raises `InputError`: neither a level nor a tolerance from 0.0001 to 0.5.
    """
    if isinstance(accuracy, str):
        if accuracy not in LEVELS:
            raise InputError("accuracy", accuracy, "fast, standard, reference or a relative tolerance on mu")
        return accuracy
    if not 1e-4 <= accuracy <= 0.5:
        raise InputError("accuracy", accuracy, "0.0001 to 0.5 as a relative tolerance on mu")
    return "fast" if accuracy >= 0.04 else "standard" if accuracy >= 0.012 else "reference"


def make_run_plan(
    accuracy: Accuracy | float,
    contact: LineContact,
    surfaces: RoughSurfaces,
    film: float,
    *,
    drained: bool,
    thermal: bool,
    fine: bool = False,
) -> RunPlan:
    """Plan of a run; ``accuracy`` is a level or the relative tolerance on mu.

    The mesh resolves the correlation length, the smooth contact, its inlet and the contact spots of thin films. It is
    finer at film ratios below 0.3 and again near the boundary regime (docs/performance.md). ``fine`` permits the larger
    number of nodes with shorter start-up and window.
    """
    level = level_of(accuracy)
    tolerance = TOLERANCE[level] if isinstance(accuracy, str) else float(accuracy)
    high, low, smooth, window_min, window_max = LEVELS[level]
    inlet = inlet_sweep(contact, max(film, SWEEP_FILM_MIN * surfaces.rms))
    sweep = PER_SWEEP[level] * inlet
    spacing, coarsest, batch = min(2.0 / smooth, sweep), math.inf, BATCH
    if surfaces.profiles:
        ratio = film / surfaces.rms
        per_length = high if ratio > 0.3 else low if ratio > NEAR_BOUNDARY else FINER_THERE * low
        lc = surfaces.shortest_correlation_length / contact.half_width
        coarsest = min(lc / MIN_PER_LENGTH, surfaces.shortest_wavelength / (PER_WAVELENGTH * contact.half_width))
        spacing = min(spacing, lc / per_length, coarsest)
        if ratio < SPOT_RATIO:
            spacing = min(spacing, 1.0 / (PER_SPOT[level] * min(SPOT_NODES / ratio**SPOT_POWER, SPOT_NODES_MAX)))
        # a batch must contain several correlation lengths of roughness that is longer than the contact
        longer = min(max(LONG_WAVES * surfaces.correlation_length / (BATCH * contact.half_width), 1.0), LONG_WINDOWS)
        batch, window_min, window_max = BATCH * longer, window_min * longer, window_max * longer
    else:
        spacing = min(1.0 / smooth, 0.5 * sweep)
        longer, window_min, window_max = 1.0, 2.0 * BATCH, 2.0 * BATCH
    startup = FRONT_STARTUP + (DRAINED_STARTUP if drained else 0.0)
    settling = SETTLING
    if thermal:
        slower = min(abs(contact.speed_1), abs(contact.speed_2)) / contact.speed_entrainment
        settling += min(2.5 / max(slower, 1e-3), THERMAL_CAP)
    study = level != "fast"
    accurate, most = BUDGET[level]
    most = most if fine else accurate
    plan = RunPlan(
        spacing,
        tolerance,
        window_min,
        window_max,
        startup,
        settling,
        study,
        accurate,
        coarsest,
        batch,
        nodes_fine_max=most,
        window_fine=min(FINE_WINDOW * longer, window_min),
        budget=WORK[level],
        inlet=inlet,
        bound=BOUND * WORK[level],
    )
    return _shortened(plan, surfaces.correlation_length / contact.half_width) if fine else plan


def _shortened(plan: RunPlan, correlation_length: float) -> RunPlan:
    """Shorter windows for fine roughness; ``correlation_length`` in b."""
    share = min(max(correlation_length / FINE_LENGTH, MIN_SHARE), 1.0)
    return replace(
        plan,
        window_min=share * plan.window_min,
        window_fine=share * plan.window_fine,
        exchange_window=share * plan.exchange_window,
        settling=SETTLING,
        preheating=plan.settling - SETTLING,
    )


def reduced_plan(plan: RunPlan, correlation_length: float) -> RunPlan:
    """Reduced plan of a contact whose work would exceed its bound; ``correlation_length`` in b.

    The surfaces are preheated and the step tolerance is looser. Start-up, blocks and batches of fine roughness are
    shorter. The update interval of the macroscopic pressure is unchanged: with shorter intervals it follows single
    waves, which changed mu by 4 % in one contact.
    """
    if plan.exchange_window == EXCHANGE_WINDOW:
        plan = replace(_shortened(plan, correlation_length), exchange_window=plan.exchange_window)
    share = min(max(correlation_length / FINE_LENGTH, MIN_SHARE), 1.0)
    return replace(
        plan, block=share * plan.block, batch=share * plan.batch, step_tolerance=LOOSE_STEP_TOLERANCE, reduced=True
    )


def inlet_sweep(contact: LineContact, film: float) -> float:
    """Width of the inlet zone in which the pressure of a thin film builds up, (h R/b^2)^(2/3) [b].

    There the gap of a Hertz contact, about (b^2/R) s^(3/2) at s half-widths ahead of it, equals the film.
    """
    return float((film * contact.radius_equivalent / contact.half_width**2) ** (2.0 / 3.0))


def min_nodes(correlation_length: float) -> float:
    """Smallest number of nodes that resolves generated roughness; ``correlation_length`` in b."""
    return MIN_PER_LENGTH * MIN_MESH_LENGTH / correlation_length


def with_overrides(plan: RunPlan, nodes: int | None, travel: float | None, length: float) -> RunPlan:
    """The plan with a fixed number of nodes or a fixed window, within the largest number of nodes.

    Raises `InputError`: `nodes` or `travel` is out of range; `ConvergenceError` "mesh_budget": the largest mesh of this
    level does not resolve the roughness.
    """
    if nodes is not None:
        if not NODES_MIN <= nodes <= NODES_MAX:
            raise InputError("nodes", nodes, f"{NODES_MIN} to {NODES_MAX}")
        plan = replace(plan, spacing=length / nodes)
    if travel is not None:
        if not 1.0 <= travel <= 1e5:
            raise InputError("travel", travel, "1 to 100000 half-widths")
        plan = replace(plan, window_min=travel, window_max=travel)
    if nodes is None and length / plan.spacing > plan.nodes_max:
        needed = length / plan.coarsest
        if needed > plan.nodes_fine_max:
            raise ConvergenceError("mesh_budget", f"{math.ceil(needed)} nodes needed, {plan.nodes_fine_max} in budget")
        affordable = min(max(plan.nodes_max, SPARE * needed), plan.nodes_fine_max)
        plan = replace(plan, spacing=max(plan.spacing, length / affordable))
    return plan


def mesh_levels(plan: RunPlan, nodes: int) -> int:
    """Number of meshes; the coarsest resolves roughness and inlet. Two for a fixed window or when smooth."""
    levels = 2
    coarsest = min(2.0 * plan.coarsest, PER_SWEEP_COARSEST * plan.inlet)
    if plan.window_max > plan.window_min:
        while levels < LEVELS_MAX and plan.spacing * 2**levels <= coarsest and nodes / 2**levels >= NODES_MIN:
            levels += 1
    return levels


def mesh_length(contact: LineContact, film: float) -> float:
    """Solved length [b]."""
    inlet, outlet = solved_length(contact, film)
    return outlet - inlet
