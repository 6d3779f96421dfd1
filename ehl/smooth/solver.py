"""Solver of the smooth, steady, isothermal line contact.

First integral of the Reynolds equation: Poiseuille flow (rho h^3/12 eta) S dp/dx equals Couette flow u_r (rho h - Q).
The exit condition at the onset of cavitation is that of Swift and Stieber (Swift-Stieber), p = dp/dx = 0.

1. A coarse solution follows from a neighbouring contact or by continuation from an easy contact.
2. A mesh is graded for its features.
3. Solutions on three nested grids give Richardson values with errors.
"""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Literal

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.threads import single_thread
from ehl.fluid.lubricant import Lubricant
from ehl.inputs import Accuracy
from ehl.line_contact import LineContact
from ehl.smooth.continuation import HARD_NODES, PATH_NODES, PathReport, cold_path, from_neighbour, refined
from ehl.smooth.newton import FilmShear, Level, NewtonFailure, Numbers, friction_inlet, numbers_of
from ehl.smooth.refine import COARSEST, GridLimit, nested, rounding_errors, settled
from ehl.smooth.scaling import ScaledContact, scaled_contact

REASONS = (
    "no_entrainment",
    "path_stalled",
    "path_limit",
    "start_infeasible",
    "singular_matrix",
    "damping_exhausted",
    "iteration_limit",
    "negative_pressure",
    "gap_closes_at_exit",
)
ROUNDED = "spike_rounded"
FALLBACKS = ("neighbour_too_far", ROUNDED, "coarse_grid_dropped", "tolerance_not_met")


@dataclass(frozen=True)
class SteadyResult:
    """Smooth, steady line contact; SI units.

    ``film_central``, ``film_min``, ``pressure_max`` and ``friction_fluid`` are extrapolated over three grids; the
    ``*_error`` are estimates of their relative grid error. The profiles are those of the finest grid.
    """

    status: Literal["converged", "failed"]
    reason: str  # "" or the reason of the failure, one of `REASONS`
    # profiles on the graded mesh [m, Pa, m, Pa]; x = 0 is the centre of the undeformed parabola
    x: FloatArray
    pressure: FloatArray
    film: FloatArray
    shear_stress: FloatArray
    # h at x = 0 and the smallest h [m]
    film_central: float
    film_min: float
    pressure_max: float  # [Pa]
    # integral of the film shear in the direction of sliding over w', from x_inlet to x_exit [-]; never negative
    friction_fluid: float
    # integral of (h/2) dp/dx over w' from x_inlet to x_exit [-]; converges like 1/|x_inlet|
    rolling_traction: float
    flow: float  # mass flow over (rho0 u_r) = rho/rho0 h at dp/dx = 0 [m]
    film_central_error: float
    film_min_error: float
    pressure_max_error: float
    friction_error: float
    iterations: int
    nodes: int
    # largest imbalance of the flow over the flow, and of the load over the load
    mass_residual: float
    load_residual: float
    # start of the integrals of friction and rolling traction [m]; upstream of the mesh, which begins at x[0], the inlet
    # is a fully flooded open parabola with pressure, load and shear in closed form
    x_inlet: float
    x_exit: float  # position of vanishing pressure and pressure gradient [m]
    fallbacks: tuple[str, ...] = ()  # deviations from the standard solution path
    skipped: tuple[str, ...] = ()  # neglected effects with reasons
    coarse: Level | None = field(default=None, repr=False, compare=False)

    @property
    def film_error(self) -> float:
        """Relative error estimate of the films, the larger of both."""
        return max(self.film_central_error, self.film_min_error)


def solve_steady(
    contact: LineContact, lubricant: Lubricant, *, accuracy: Accuracy = "standard", start: SteadyResult | None = None
) -> SteadyResult:
    """Solve the smooth, steady, isothermal line contact.

    Reynolds d/dx(rho h^3/(12 eta) S dp/dx) = u_r d(rho h)/dx with p = dp/dx = 0 at the exit, elastic film and load.

    contact, lubricant: SI records.
    accuracy: films and friction to about 1 %, 0.5 %, 0.05 % (the measured errors are far smaller).
    start: result of a neighbouring contact.
    Returns: result; with status "failed" and a reason of `REASONS` if there is no solution.
    Raises `InputError`: unknown accuracy.
    """
    if accuracy not in COARSEST:
        raise InputError("accuracy", accuracy, ", ".join(COARSEST))
    report = PathReport()
    if contact.speed_entrainment == 0.0:
        return _failed("no_entrainment", report, [])
    scaled = scaled_contact(contact, lubricant)
    shear = film_shear(contact, lubricant)
    fallbacks: list[str] = []
    reason = ""
    for attempt in _attempts(scaled, start):
        if attempt.fallback:
            fallbacks.append(attempt.fallback)
        try:
            with undisturbed():
                near = settled(attempt.run(report), report)
                levels, limit = nested(near, shear, accuracy, report, fallbacks)
                limit = replace(limit, errors=limit.errors + rounding_errors(scaled, near, shear, report))
        except NewtonFailure as failure:
            reason = failure.reason
        else:
            return steady_result(contact, shear, levels, limit, near, report, fallbacks)
    return _failed(reason, report, fallbacks)


def coarse_film(contact: LineContact, lubricant: Lubricant, report: PathReport) -> tuple[Level, str] | None:
    """The isothermal film on a coarse grid and the fallback it took; None if there is no solution."""
    for attempt in _attempts(scaled_contact(contact, lubricant), None):
        with suppress(NewtonFailure), undisturbed():
            return settled(attempt.run(report), report), attempt.fallback
    return None


@contextmanager
def undisturbed() -> Iterator[None]:
    """Run in one thread, which is fastest for small matrices, and ignore overflow in rejected trial steps."""
    with single_thread(), np.errstate(all="ignore"):
        yield


@dataclass(frozen=True)
class _Attempt:
    """One way to a coarse solution, and its name as a fallback (empty for the standard way)."""

    fallback: str
    run: Callable[[PathReport], Level]


def _attempts(scaled: ScaledContact, start: SteadyResult | None) -> list[_Attempt]:
    """Ways to a solution in order of trial."""
    hard, blunt = refined(HARD_NODES, scaled), scaled.rounded()
    nodes = PATH_NODES if hard == HARD_NODES else hard
    attempts = [_Attempt("", partial(cold_path, scaled, n)) for n in dict.fromkeys((nodes, hard))]
    if blunt.gamma > scaled.gamma:
        attempts.append(_Attempt(ROUNDED, partial(cold_path, blunt, hard)))
    if start is None or start.coarse is None:
        return attempts
    neighbour, first = start.coarse, blunt if ROUNDED in start.fallbacks else scaled
    return [
        _Attempt(ROUNDED if first is blunt else "", partial(from_neighbour, neighbour, first)),
        _Attempt("neighbour_too_far", attempts[0].run),
        *attempts[1:],
    ]


def film_shear(contact: LineContact, lubricant: Lubricant) -> FilmShear:
    """Dimensionless shear stress of the film."""
    b, p_h = contact.half_width, contact.pressure_hertz
    rate = lubricant.viscosity_inlet * contact.speed_sliding * contact.radius_equivalent / (p_h * b**2)
    return FilmShear(lubricant.shear_law, p_h, rate)


def steady_result(
    contact: LineContact,
    shear: FilmShear,
    levels: list[Level],
    limit: GridLimit,
    near: Level,
    report: PathReport,
    fallbacks: list[str],
) -> SteadyResult:
    """Result in SI units from the levels of a contact and their grid limit."""
    values, relative = Numbers(*limit.values.tolist()), Numbers(*limit.relative().tolist())
    fine = levels[-1]
    friction, friction_error = values.friction, relative.friction
    if friction < 0.0:  # extrapolated shear of an unresolved Newtonian spike
        friction, friction_error = numbers_of(fine, shear).friction, 1.0
    b, p_h = contact.half_width, contact.pressure_hertz
    height = b * b / contact.radius_equivalent
    return SteadyResult(
        status="converged",
        reason="",
        x=b * fine.x,
        pressure=p_h * fine.unknowns.pressure,
        film=height * fine.film,
        shear_stress=p_h * shear.stress_at(fine.log_eta, fine.film, fine.unknowns.pressure),
        film_central=height * values.film_central,
        film_min=height * values.film_min,
        friction_fluid=friction,
        pressure_max=p_h * values.pressure_max,
        flow=height * values.flow,
        rolling_traction=b / contact.radius_equivalent * values.rolling,
        film_central_error=relative.film_central,
        film_min_error=relative.film_min,
        friction_error=friction_error,
        pressure_max_error=relative.pressure_max,
        iterations=report.iterations,
        nodes=fine.x.size,
        mass_residual=fine.mass_residual,
        load_residual=fine.load_residual,
        fallbacks=tuple(dict.fromkeys(fallbacks)),
        skipped=("heat: isothermal",) if fine.scaled.offset is None else (),
        x_inlet=b * friction_inlet(fine),
        x_exit=b * values.exit,
        coarse=near,
    )


def _failed(reason: str, report: PathReport, fallbacks: list[str]) -> SteadyResult:
    """Result without a solution: zeros with infinite errors."""
    empty = np.zeros(0)
    return SteadyResult(
        "failed", reason, empty, empty, empty, empty, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        math.inf, math.inf, math.inf, math.inf, report.iterations, 0, math.inf, math.inf, 0.0, 0.0,
        tuple(dict.fromkeys(fallbacks)),
    )  # fmt: skip
