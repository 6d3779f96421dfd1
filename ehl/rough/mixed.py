"""Mixed lubrication by the transient solver: its surfaces, unresolved roughness, and estimates of its effect.

Running-in as wear of the peaks of both profiles to a given Rq (`worn`).

Roughness finer than the mesh: long waves remain a profile, shorter waves are replaced by a subgrid film.

Waves shorter than a cut-off are removed from the profiles; their RMS is sigma_sub. Solids are in contact where the
gap of the filtered surfaces is c sigma_sub above the boundary film. This is the mean gap of the fine roughness under
load. In dry contact it decreases with the logarithm of the pressure over the stiffness E* times the RMS slope (form of
Persson 2007, Phys. Rev. Lett. 99, 125502, unverified; both constants are fitted to runs that resolve the roughness).
c = 0 (no contact of the fine part) and 2 c + 0.5 (at most 2.5, its peaks) bound friction, and their difference is the
error: see docs/roughness.md.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError, InputError
from ehl.fluid.lubricant import Lubricant
from ehl.heat.traction import ThermalTraction
from ehl.inputs import ContactProblem, ModelInput, SurfaceInput
from ehl.line_contact import LineContact
from ehl.rough import RoughSurfaces, TransientResult, solve_transient
from ehl.rough.accuracy import BUDGET, NODES_MIN, level_of, mesh_length, min_nodes
from ehl.rough.multilevel import ERROR_ALLOWED
from ehl.surface.measured_surface import detrended, gaussian_mean_line, load_profile, profile_points
from ehl.surface.roughness import CUTOFF_PER_CORRELATION_LENGTH, RoughProfile, SelfAffine, generate_profile

STYLUS_CUTOFF = 2.5e-6  # shortest wavelength in Rq [m]
CUTOFF_NODES = 8.0  # nodes per shortest remaining wavelength
BUDGET_SHARE = 0.6  # share of the nodes of the accuracy; the bounds of the subgrid film dominate the error
# tuned on runs that resolve the roughness (validation/mixed_shortcuts.py): mean gap/sigma_sub = 0.4 ln(0.5 E* slope/p)
GAP_LOG, GAP_PRESSURE = 0.4, 0.5
MIN_GAP, MAX_GAP = 0.1, 2.5


@dataclass(frozen=True)
class SplitSurfaces:
    """Both surfaces without their fine part, and the properties of that part."""

    surfaces: RoughSurfaces  # the waves longer than the cut-off
    cutoff: float  # [m]
    rms: float  # composite Rq of the unfiltered surfaces [m]
    rms_below: float  # composite RMS below the cut-off, sigma_sub [m]
    slope: float  # composite RMS slope of that part [-]

    def gap(self, contact: LineContact) -> float:
        """Mean gap of the fine part under the Hertz pressure, over sigma_sub [-]."""
        stiffness = 0.5 * contact.effective_modulus * self.slope
        if stiffness <= 0.0:
            return MIN_GAP
        gap = GAP_LOG * math.log(GAP_PRESSURE * stiffness / contact.pressure_hertz)
        return min(max(gap, MIN_GAP), MAX_GAP)

    def subgrid_films(self, contact: LineContact, base: float) -> tuple[float, float, float]:
        """Boundary film plus subgrid film [m]: without the fine part, expected value, and upper bound."""
        gap = self.gap(contact)
        return base, base + gap * self.rms_below, base + min(2.0 * gap + 0.5, MAX_GAP) * self.rms_below


def split_surfaces(surface: SurfaceInput, half_width: float, length: float, cutoff: float) -> SplitSurfaces:
    """Split the roughness of a contact at a wavelength.

    surface: generated or measured roughness.
    half_width, length, cutoff: Hertz half-width, length of generated profiles, and cut-off [m].
    """
    kept: list[RoughProfile | None] = []
    whole = below = slope = 0.0
    for number, (rms, path) in enumerate(surface.each, start=1):
        if path is not None:
            profile, fine_rms, fine_slope = _split_measured(path, surface, cutoff)
        elif rms > 0.0:
            profile, fine_rms, fine_slope = _split_generated(
                surface.rms_in_contact(rms), surface, 2 * surface.seed + number, length, cutoff
            )
        else:
            kept.append(None)
            continue
        kept.append(profile)
        coarse = profile.rms if profile is not None else 0.0
        whole += coarse**2 + fine_rms**2
        below += fine_rms**2
        slope += fine_slope**2
    return SplitSurfaces(RoughSurfaces(*kept), cutoff, math.sqrt(whole), math.sqrt(below), math.sqrt(slope))


def _split_generated(
    rms: float, surface: SurfaceInput, seed: int, length: float, cutoff: float
) -> tuple[RoughProfile | None, float, float]:
    """Long waves of a generated profile, and RMS and slope of the fine part from its spectrum."""
    lc = surface.correlation_length
    left_out = share_left_out(surface, cutoff)
    slope = math.sqrt(2.0) * rms / lc
    if surface.hurst is not None:
        slope = rms * SelfAffine(lc, surface.hurst).slope(STYLUS_CUTOFF, cutoff)
    if cutoff > length / 4.0:
        return None, rms, slope
    profile = generate_profile(
        rms * math.sqrt(1.0 - left_out),
        lc,
        length,
        cutoff / 4.0,
        seed,
        cutoff=cutoff,
        hurst=surface.hurst,
    )
    return profile, rms * math.sqrt(left_out), slope


def share_left_out(surface: SurfaceInput, cutoff: float) -> float:
    """Share of the variance of a generated surface in waves shorter than the cut-off [m].

    The whole spectrum exp(-(k lc)^2/4) is included; for a self-affine surface waves down to 2.5 um (ISO 3274).
    """
    if surface.hurst is None:
        return math.erfc(math.pi * surface.correlation_length / cutoff)
    spectrum = SelfAffine(surface.correlation_length, surface.hurst)
    unseen = spectrum.share_below(STYLUS_CUTOFF)
    return max(spectrum.share_below(cutoff) - unseen, 0.0) / (1.0 - unseen)


def _split_measured(path: str, surface: SurfaceInput, cutoff: float) -> tuple[RoughProfile | None, float, float]:
    found, heights, _ = profile_points(path, unit_x=surface.profile_unit_x, unit_height=surface.profile_unit_height)
    spacing = found.spacing
    level = detrended(heights, surface.detrend)
    in_band = gaussian_mean_line(level, spacing, surface.cutoff_short)
    try:
        profile = load_profile(path, cutoff_short=cutoff, **surface.profile_reading)
    except InputError:
        # the cut-off exceeds the range of the file: all its roughness is fine structure
        if surface.cutoff_long is not None:
            in_band = in_band - gaussian_mean_line(in_band, spacing, surface.cutoff_long)
        return None, float(np.std(in_band)), float(np.std(np.diff(in_band))) / spacing
    fine = in_band - gaussian_mean_line(level, spacing, cutoff)
    return profile, float(np.std(fine)), float(np.std(np.diff(fine))) / spacing


def worn(profile: RoughProfile, rms: float) -> RoughProfile:
    """The profile with its peaks worn to plateaus at one height; the valleys remain.

    Heights become min(z, c), with the level c that gives the required Rq: the truncated heights of plateau surfaces
    (King, Watson & Stout 1978, unverified). From Rq 0.5 to 0.3 um Gaussian heights get a skewness of -1.6; a hardened
    disc that ran in by that much had -1.38 (Morales-Espejel & Brizmer 2011). Roughness of the plateaus is neglected.

    profile: heights before running-in [m].
    rms: Rq after running-in [m]; the profile is unchanged if its Rq is not larger.
    Returns: profile with a note on the removed height.
    """
    if rms >= profile.rms:
        return profile
    from scipy.optimize import brentq

    low, high = float(profile.heights.min()), float(profile.heights.max())
    level = float(brentq(lambda c: float(np.std(np.minimum(profile.heights, c))) - rms, low, high, xtol=1e-15))
    heights = np.minimum(profile.heights, level)
    depths = [f"{1e9 * depth:.0f} nm" for depth in (high - level, float(np.mean(profile.heights - heights)))]
    note = f"running-in: peaks worn by up to {depths[0]}, {depths[1]} in the mean"
    found = RoughProfile.of(heights, profile.spacing, cutoff=profile.cutoff)
    return replace(found, source=profile.source, notes=(note,))


# tuned with validation/mixed_shortcuts.py: shortest wave of a self-affine profile over lc; shorter ones change mu by
# -4 to +5 % (H 0.85, film ratio 0.7, gamma 1 and 5)
SELF_AFFINE_CUTOFF = 0.4
PROFILE_LENGTH = 32.0  # of a generated profile [b]
MIN_CORRELATION_LENGTHS = 60  # smallest length of a generated profile in correlation lengths
# tuned with tests/verification/ehl/test_continuous_friction.py (the next three): relative change of mu by roughness at
# a film ratio of 2.8, and its decrease with the film ratio (5 % at 3.4 with the lateral mode)
ROUGHNESS_EFFECT, ROUGHNESS_RATIO, ROUGHNESS_POWER = 0.065, 2.8, 1.8
# tuned: at shear stresses far below tau0 films are viscous, and pressure ripples increase mu as exp(alpha p): by 3 to
# 20 % instead of 2.4 % at tau0, in seven cases down to 0.02 tau0. The inverse of the stress is an upper bound
MIN_STRESS_RATIO = 0.02
# tuned: factor on Rq; at a film ratio of 3.9 ridges and waves change mu by 1.9 %, random profiles by 1.7 %
REGULAR_WAVES = 1.15
GAUSSIAN_HEIGHT = 6.0  # highest peak over deepest valley of a Gaussian profile of some sixty correlation lengths [Rq]
ROLLING_EFFECT = 0.0075  # change of ln(viscosity) in the inlet that changes the film by 0.5 %
CONVECTED = 0.005  # share of the heat of the shear
# tuned with validation/mixed_shortcuts.py: largest change of mu by roughness without asperity contact
MAX_EFFECT_WITHOUT_CONTACT = 0.15
SHEAR_STRENGTH = 1e9  # about the shear modulus of a glassy oil: a larger stress is an error of the shear law [Pa]
# tuned with the same script: error of mu by a subgrid film over its change with twice the cut-off; 0.05 to 2.4 in
# fully resolved contacts
OVER_CHANGE = 2.5


def _viscous(stress_ratio: float) -> float:
    """Factor on the effect of roughness at stresses far below tau0, without shear thinning [-]."""
    return 1.0 / min(stress_ratio + MIN_STRESS_RATIO, 1.0)


def roughness_effect(film_ratio: float, stress_ratio: float = math.inf) -> float:
    """Estimated relative change of mu by roughness for thick films (own work) [-].

    film_ratio: of the film with thermal effects.
    stress_ratio: mean shear stress of the smooth film over that of shear thinning (`film_stress_ratio`).
    """
    return float(ROUGHNESS_EFFECT * (ROUGHNESS_RATIO / film_ratio) ** ROUGHNESS_POWER * _viscous(stress_ratio))


def roughness_matters(film_ratio: float, model: ModelInput, stress_ratio: float = math.inf) -> bool:
    """Whether the estimated effect of roughness on mu exceeds half the required tolerance."""
    return model.shortcuts == "off" or roughness_effect(film_ratio, stress_ratio) > 0.5 * model.tolerance


def film_stress_ratio(friction: float, contact: LineContact, lubricant: Lubricant) -> float:
    """Mean shear stress of a smooth film over the stress of shear thinning or the limiting stress [-].

    The lower of both stresses at the mean Hertz pressure is used (tau0 of Eyring's or the stress of Carreau's law).
    Infinite without sliding, since there is no friction.
    """
    if friction == 0.0:
        return math.inf
    pressure = np.array([0.25 * math.pi * contact.pressure_hertz])
    law = lubricant.shear_law
    limit = float(law.limiting_stress(pressure)[0])
    stress = limit if law.rheology == "newtonian" else min(limit, float(law.scale(pressure)[0]))
    return abs(friction) * float(pressure[0]) / stress


def film_heat_of(
    heat: ThermalTraction | None, contact: LineContact, lubricant: Lubricant
) -> tuple[FloatArray, ...] | None:
    """Heat in the smooth film along x [m]: of the pressure-driven flow and convected [W/m2], and kept there [-].

    The heat convected to a place is the excess of the heat that reaches the walls over the heat of the shear, and
    `ThermalTraction.lag_heat`. Elsewhere a share of the heat of the shear reaches the walls: it is kept. None if all is
    negligible: the heat of the flow changes ln(viscosity) at x < 0 by less than `ROLLING_EFFECT` (the film grows with
    the inlet viscosity to the power of about 2/3), and convection moves less than the share `CONVECTED` of the heat.
    """
    if heat is None:
        return None
    slope = lubricant.dlog_viscosity_dtemperature(np.zeros(1), np.array([lubricant.temperature]))
    rise = np.max(heat.temperature_rise_rolling[heat.x < 0.0], initial=0.0)
    freed = contact.speed_sliding * heat.shear_stress
    moved, whole = (np.trapezoid(row, heat.x) for row in (np.abs(heat.shear_heat - freed), freed))
    if not (abs(float(slope[0])) * rise > ROLLING_EFFECT or moved > CONVECTED * whole):
        return None
    into = heat.shear_heat - heat.lag_heat
    kept = np.divide(into, freed, out=np.ones(freed.size), where=(freed > into) & (freed != 0.0))
    return heat.x, heat.rolling_heat, heat.lag_heat + np.maximum(into - freed, 0.0), kept


def rough_surfaces(surface: SurfaceInput, contact: LineContact) -> RoughSurfaces:
    """Both profiles of a contact: measured if a file is given, else generated; optionally run in.

    A generated profile depends on seed, Rq, correlation length and contact width but not on the mesh.
    """
    half_width = contact.half_width
    profiles: list[RoughProfile | None] = []
    for number, (rms, path) in enumerate(surface.each, start=1):
        if path is not None:
            profiles.append(load_profile(path, cutoff_short=surface.cutoff_short, **surface.profile_reading))
        elif rms > 0.0:
            lc = surface.correlation_length
            # the spectrum of a Gaussian autocorrelation is negligible below its cut-off: the profile has the whole Rq
            left_out = 0.0 if surface.hurst is None else share_left_out(surface, _cutoff(surface))
            profiles.append(
                generate_profile(
                    rms * math.sqrt(1.0 - left_out),
                    lc,
                    _profile_length(surface, half_width),
                    lc / 20.0,
                    2 * surface.seed + number,
                    skewness=surface.skewness,
                    kurtosis=surface.kurtosis,
                    cutoff=_cutoff(surface),
                    hurst=surface.hurst,
                )
            )
        else:
            profiles.append(None)
    if surface.running_in != "none":
        profiles = [None if profile is None else worn(profile, surface.running_in) for profile in profiles]
    return RoughSurfaces(*profiles)


def _cutoff(surface: SurfaceInput) -> float:
    """Shortest wavelength of a generated profile [m]."""
    per_length = CUTOFF_PER_CORRELATION_LENGTH if surface.hurst is None else SELF_AFFINE_CUTOFF
    return per_length * surface.correlation_length


@dataclass(frozen=True)
class SmoothFriction:
    """Properties of the smooth contact for the estimates of the effect of roughness."""

    film: float = 0.0  # film at x = 0 with thermal effects [m]; 0 if unknown
    stress_ratio: float = math.inf  # `film_stress_ratio` [-]


def profile_notes(surface: SurfaceInput) -> tuple[str, ...]:
    """Notes on the processing of measured profiles: gaps, spikes, the line of a map."""
    units = {"unit_x": surface.profile_unit_x, "unit_height": surface.profile_unit_height}
    paths = dict.fromkeys(path for _, path in surface.each if path is not None)
    return tuple(f"{Path(path).name}: {note}" for path in paths for note in profile_points(path, **units)[2])


def roughness_heights(surface: SurfaceInput, contact: LineContact) -> tuple[float, float]:
    """Composite Rq [m], and the larger of it and the Rq of Gaussian surfaces of the same peak-to-valley height."""
    if not surface.measured:
        return surface.roughness_rms, surface.roughness_rms
    surfaces = rough_surfaces(surface, contact)
    return surfaces.rms, max(REGULAR_WAVES * surfaces.rms, surfaces.height / GAUSSIAN_HEIGHT)


def solve_mixed(
    problem: ContactProblem,
    smooth: SmoothFriction,
    *,
    thermal: bool,
    film_heat: tuple[FloatArray, ...] | None = None,
    window: float | None = None,
) -> TransientResult:
    """Run the transient solver for one contact.

    smooth: film and stress of the smooth contact.
    thermal: whether thermal effects are included.
    film_heat: heat in the smooth film along x (`film_heat_of`).
    window: averaging window [b]; default: until the interval of mu is reached.
    Returns: result of the solver. Roughness finer than the accurate mesh is first replaced by a subgrid film, which
    increases the boundary film by the height of the fine part. Its uncertainty is `subgrid_error`;
    `friction_boundary_half` and `friction_boundary_double` are mu without the subgrid film and with it at its peaks.
    If this and the mesh error exceed `ERROR_ALLOWED` tolerances, a mesh that resolves the roughness is used. The status
    is "unsettled" with the reason "mesh_budget" if nodes and work of the accuracy do not suffice for one.
    """
    contact, lubricant, surface, model = problem.line, problem.lubricant, problem.surface, problem.model
    accuracy = model.friction_tolerance or model.accuracy
    common: dict[str, Any] = {
        "accuracy": accuracy,
        "boundary_friction": surface.boundary_friction,
        "peklenik_number": math.inf if surface.peklenik_number > 1e5 else surface.peklenik_number,
        "thermal": thermal,
        "hardness": problem.hardness,
        "materials": problem.bodies,
        "temperature_bulk": problem.temperature_bulk,
        "film_heat": film_heat,
        "travel": window,
    }
    accurate, most = BUDGET[level_of(accuracy)]
    finest = _cutoff(surface) / CUTOFF_PER_CORRELATION_LENGTH  # lc of a Gaussian autocorrelation of that cut-off
    needed = min_nodes(finest / contact.half_width) if surface.roughness_rms > 0.0 else 0.0
    resolved = {"boundary_film": surface.film_of_contact, **common}
    try:
        if needed > accurate:
            raise ConvergenceError("mesh_budget", "roughness too fine")
        surfaces = rough_surfaces(surface, contact)
        run = solve_transient(contact, lubricant, surfaces, **resolved)
        if run.reason in ("lagged_steps", "unconverged_steps") and window is None and 2 * run.nodes <= most:
            run = _on_finer_mesh(run, contact, lubricant, surfaces, resolved)
        return _with_profile_notes(run, surfaces)
    except ConvergenceError as error:
        if error.reason != "mesh_budget":
            raise
    coarse = _with_subgrid_film(problem, smooth, common)
    if surface.running_in != "none":
        note = "running-in changes only Rq, not the shape of the peaks: the roughness is finer than the mesh"
        coarse = replace(coarse, notes=(*coarse.notes, note))
    if coarse.status == "converged" and coarse.friction_error <= ERROR_ALLOWED * model.tolerance:
        return coarse
    if needed <= most:
        try:
            surfaces = rough_surfaces(surface, contact)
            fine = solve_transient(contact, lubricant, surfaces, fine_roughness=True, bounded=True, **resolved)
            return _with_profile_notes(fine, surfaces)
        except ConvergenceError as error:
            if error.reason not in ("mesh_budget", "work_limit"):
                raise
    return coarse if coarse.status == "failed" else replace(coarse, status="unsettled", reason="mesh_budget")


def _on_finer_mesh(
    run: TransientResult, contact: LineContact, lubricant: Lubricant, surfaces: RoughSurfaces, common: dict[str, Any]
) -> TransientResult:
    """The result on twice the nodes, with smaller steps, if it converges."""
    try:
        finer = solve_transient(contact, lubricant, surfaces, nodes=2 * run.nodes, **common)
    except ConvergenceError:
        return run
    note = "mesh and time step halved, as steps did not converge"
    return replace(finer, notes=(*finer.notes, note)) if finer.status == "converged" else run


def _with_profile_notes(result: TransientResult, surfaces: RoughSurfaces) -> TransientResult:
    """The result with the notes of the profiles on running-in."""
    found = dict.fromkeys(note for profile in surfaces.profiles for note in profile.notes)
    return replace(result, notes=(*result.notes, *found))


def _with_subgrid_film(problem: ContactProblem, smooth: SmoothFriction, common: dict[str, Any]) -> TransientResult:
    """Result with the waves that a coarse mesh resolves, and a subgrid film for shorter ones.

    The error is the larger of two: from mu without the subgrid film and at its peaks, and from mu with twice the
    cut-off.
    """
    contact, lubricant, surface = problem.line, problem.lubricant, problem.surface
    length = mesh_length(contact, contact.film_moes(lubricant))
    nodes = max(round(BUDGET_SHARE * BUDGET[level_of(common["accuracy"])][0]), NODES_MIN)

    def solved(nodes: int, bounds: bool) -> tuple[TransientResult, SplitSurfaces, tuple[float, float, float]]:
        cutoff = CUTOFF_NODES * length / nodes * contact.half_width
        split = split_surfaces(surface, contact.half_width, _profile_length(surface, contact.half_width), cutoff)
        films = split.subgrid_films(contact, surface.film_of_contact)
        run = solve_transient(
            contact,
            lubricant,
            split.surfaces,
            boundary_film=films[1],
            boundary_range=(films[0], films[2]) if bounds else None,
            boundary_study=bounds,
            nodes=nodes,
            fine_roughness=True,
            **common,
        )
        return run, split, films

    run, split, (low, expected, high) = solved(nodes, bounds=True)
    if run.status == "failed":
        return run
    strongest = 2.0 * SHEAR_STRENGTH * contact.half_width / contact.load_per_length
    error = _subgrid_error(run, smooth, split.rms_below, strongest)
    coarser = solved(max(nodes // 2, NODES_MIN), bounds=False)[0]
    if coarser.status != "failed" and run.friction_coefficient != 0.0:
        change = abs(min(coarser.friction_coefficient, strongest) / run.friction_coefficient - 1.0)
        error = max(error, OVER_CHANGE * change)
    note = (
        f"the mesh does not resolve roughness below {split.cutoff * 1e6:.3g} um (RMS {split.rms_below * 1e6:.3g} of "
        f"{split.rms * 1e6:.3g} um); it is replaced by a subgrid film of {expected * 1e9:.3g} nm, and the error of mu "
        f"follows from its bounds of {low * 1e9:.3g} and {high * 1e9:.3g} nm or from twice the cut-off"
    )
    return replace(run, subgrid_error=error, notes=(*run.notes, note))


def _subgrid_error(run: TransientResult, smooth: SmoothFriction, rms_below: float, strongest: float) -> float:
    """Largest deviation of mu within the bounds of the subgrid film, over mu.

    The effect of the fine roughness on thick films is a lower bound, for films without asperity contact. ``strongest``
    limits mu, which has no bound for an oil without limiting shear stress.
    """
    mu = run.friction_coefficient
    if mu == 0.0:
        return 0.0
    found = (min(bound, strongest) for bound in (run.friction_boundary_half, run.friction_boundary_double))
    bounds = max(abs(bound - mu) for bound in found) / mu
    ripple = MAX_EFFECT_WITHOUT_CONTACT
    if smooth.film > 0.0:
        left_out = roughness_effect(smooth.film / rms_below) if rms_below > 0.0 else 0.0
        ripple = min(left_out, MAX_EFFECT_WITHOUT_CONTACT)
    return max(bounds, ripple * _viscous(smooth.stress_ratio))


def _profile_length(surface: SurfaceInput, half_width: float) -> float:
    """Period of a generated profile [m]."""
    return max(PROFILE_LENGTH * half_width, MIN_CORRELATION_LENGTHS * surface.correlation_length)
