"""Machine settings from targets: blank, gear settings, conjugate start, fit, design file."""

import tomllib
from functools import lru_cache
from pathlib import Path
from time import perf_counter

import numpy as np

from efficiency.blanks.inputs import PairBlankInput
from efficiency.blanks.pair import pair_blank
from efficiency.blanks.pair_blank import PairBlank
from efficiency.contact.contact_search import Transmission
from efficiency.contact.flank_pair import flank_pair
from efficiency.contact.gear_flanks import Side
from efficiency.cutting.cutter import FLANK_SIDES, FlankSide
from efficiency.cutting.flank import CutFlank
from efficiency.cutting.process import MODIFIED, MOTIONS, PLAIN, PROCESSES
from efficiency.design.design import Design
from efficiency.machine_settings import conjugate, settings_result
from efficiency.machine_settings.design_file import (
    FittedFlanks,
    PinionFlanks,
    design_text,
    ease_off_table,
    header,
    written_flank,
)
from efficiency.machine_settings.fit import PARAMETERS, FitResult, FittedFlank, FreeSettings, fit, measure
from efficiency.machine_settings.gear import GearCut, PairDimensions, cut_gear, pair_dimensions
from efficiency.machine_settings.inputs import Cutting, FlankTarget, MemberTargets, SettingsInput, Targets, load_targets
from efficiency.machine_settings.settings_result import RESIDUAL_LIMIT, FlankFit, SettingsResult
from ehl.common.errors import ConvergenceError
from ehl.common.threads import one_thread
from ehl.common.validation import validate

_DRIVE: dict[FlankSide, Side] = {"concave": "drive", "convex": "coast"}
_AMPLITUDE_TOLERANCE = 0.01
_LOOSER = 0.2
_ROOT_WEIGHT = 0.03
# coefficients of the map of the mesh, sufficient for the transmission error to 0.03 arcsec
_SHAPE = (12, 10)
# largest residual for which the transmission error is computed, and its largest plausible value
_MESHES, _MESHES_ANGLE = 2.0 * RESIDUAL_LIMIT, 0.01
_WAYS_OUT = 'remedies: one setting per flank, less ease-off, or cutting.pinion = "conjugate"'


@one_thread
def machine_settings(inputs: SettingsInput | Path | str, transmission: bool = True) -> SettingsResult:
    """Complete design of a pair from its blank and targets.

    Parameters
    ----------
    inputs : SettingsInput, Path or str
        Targets: the object, a file, or the name of shipped targets.
    transmission : bool
        Whether the unloaded transmission error is computed if it is not a target.

    Returns
    -------
    SettingsResult
        Machine settings of both members, residuals of the targets, and the design file.

    Raises
    ------
    InputError
        The blank or the cutter is invalid.
    ConvergenceError
        The gear or the conjugate pinion does not exist over the working depth.

    Examples
    --------
    >>> import efficiency
    >>> efficiency.settings("fh_spiral_bevel_12x37", transmission=False).status
    'converged'
    """
    began = perf_counter()
    if isinstance(inputs, Path | str):
        inputs = load_targets(inputs)
    pair, gear, grid, starts = _start(inputs.blank, inputs.cutting)
    scale = dict.fromkeys(FLANK_SIDES, 1.0)
    for _ in range(5):
        if inputs.cutting.pinion == "conjugate":
            fits, fitted = [], {side: _uncut(pair, starts[side]) for side in FLANK_SIDES}
        else:
            fits = _fit(inputs, scale)
            fitted = {flank.flank.side: flank for result in fits for flank in result.flanks}
            for side, flank in fitted.items():
                if (found := flank.found.mean()) < 0.5:
                    detail = f"the {side} pinion flank exists at {found:.0%} of its points only"
                    raise ConvergenceError("undercut", detail)
        text, design = _design(inputs, pair, gear, fitted, scale)
        amplitudes = {side: inputs.targets.of(side).transmission_error for side in FLANK_SIDES}
        mesh = {
            side: unloaded_mesh(design, _DRIVE[side], fitted[side]) if transmission or amplitudes[side] else None
            for side in FLANK_SIDES
        }
        off = {
            side: float(want / have.peak_to_peak)
            for side, want in amplitudes.items()
            if want and (have := mesh[side]) is not None
        }
        if all(abs(ratio - 1.0) < _AMPLITUDE_TOLERANCE for ratio in off.values()):
            break
        scale = {side: scale[side] * off.get(side, 1.0) for side in FLANK_SIDES}

    reports = {side: FlankFit(side, grid, fitted[side], mesh[side]) for side in FLANK_SIDES}
    findings = settings_result.tip_findings(design.flanks(), pair.blank.module_normal)
    findings += settings_result.undercut_findings(tuple(reports.values()), grid.lowest)
    warnings = (*(text for _, text in findings), *_warnings(pair.blank, reports, transmission))
    if inputs.cutting.pinion == "conjugate":
        warnings = ("pinion: flanks defined as conjugate plus ease-off, without machine settings", *warnings)
    flaws = {flaw for flaw, _ in findings}
    short = any(report.fitted.rms > RESIDUAL_LIMIT for report in reports.values())
    status = next((flaw for flaw in ("pointed", "undercut") if flaw in flaws), "residual" if short else "converged")
    return SettingsResult(
        design=design,
        text=text,
        concave=reports["concave"],
        convex=reports["convex"],
        iterations=sum(result.iterations for result in fits),
        seconds=perf_counter() - began,
        status=status,
        warnings=warnings,
    )


@lru_cache(maxsize=4)
def _start(
    blank_input: PairBlankInput, cutting: Cutting
) -> tuple[PairDimensions, GearCut, conjugate.FitGrid, dict[FlankSide, conjugate.ConjugateFlankStart]]:
    """Data that do not depend on the ease-off: blanks, cut gear, conjugate pinion."""
    pair = pair_dimensions(pair_blank(blank_input.model_copy(update={"gear_cutting": cutting.gear})))
    gear = cut_gear(pair, cutting.gear_eccentricity)
    grid = conjugate.grid_on_gear(pair, gear)
    return pair, gear, grid, {side: conjugate.conjugate_start(pair, gear, side, grid) for side in FLANK_SIDES}


def _fit(inputs: SettingsInput, scale: dict[FlankSide, float]) -> list[FitResult]:
    together = [FLANK_SIDES] if free_settings(inputs).common else [(side,) for side in FLANK_SIDES]
    return [
        _fit_flanks(
            inputs.model_copy(update={"targets": Targets(root_weight=inputs.targets.root_weight), **_NO_LOAD}),
            tuple((side, inputs.targets.of(side), scale[side]) for side in sides),
        )
        for sides in together
    ]


# inputs without effect on the fit of flanks
_NO_LOAD: dict[str, object] = {"name": "", "source": "", "pinion": MemberTargets(), "gear": MemberTargets()}


@lru_cache(maxsize=8)
def _fit_flanks(inputs: SettingsInput, wanted: tuple[tuple[FlankSide, FlankTarget, float], ...]) -> FitResult:
    """Settings of flanks with common settings; `wanted`: flank, its target, and the factor on its ease-off."""
    pair, gear, grid, starts = _start(inputs.blank, inputs.cutting)
    free = free_settings(inputs)
    # one setting without blade phase has one rotation of the work: the backlash follows from the point radii
    thinning = conjugate.backlash_angle(pair) if free.common and not pair.process.blade_phase else 0.0

    def attempt(weight: float, settings: FreeSettings) -> FitResult:
        flanks = [
            conjugate.target_flank(
                pair, starts[side], scale * conjugate.target_relief(target, grid.x, grid.y), weight, thinning
            )
            for side, target, scale in wanted
        ]
        if inputs.cutting.machine == "cradle":
            return conjugate.fit_on_cradle(pair, flanks, gear.screw, settings, inputs.cutting.tilt_limit)
        return fit(flanks, settings.common, settings.own)

    # if the plain settings are insufficient: more motions, then a larger root error
    weight = root_weight(inputs, pair)
    ways = [(weight, free), (weight, with_motions(free))]
    if weight > 0.0 and inputs.targets.root_weight is None:
        ways.append((_LOOSER * weight, with_motions(free)))
    best: FitResult | None = None
    for way in ways:
        result = attempt(*way)
        best = result if best is None or result.rms < best.rms else best
        if best.rms < RESIDUAL_LIMIT:
            break
    assert best is not None
    return best


def free_settings(inputs: SettingsInput) -> FreeSettings:
    """Free settings of the pinion.

    One setting for both flanks: those of the cutting process. With one setting per flank all settings are separate.
    Cutter axis, radial setting, radius and blade alone would suffice for the flank, with a root error of 1 to 3 mm.
    """
    cutting = inputs.cutting
    common: tuple[str, ...] = ()
    own: tuple[str, ...] = (*PLAIN, *MODIFIED, "blade_angle", "point_radius", "curvature", "phase")
    if cutting.pinion != "each_flank":
        process = PROCESSES[inputs.blank.process]
        common, own = process.shared_settings(cutting.machine == "free_form", cutting.radius_offsets == "free")
    free = (name for name in own if name != "curvature" or inputs.curved_blades)
    return FreeSettings(tuple(PARAMETERS[name] for name in common), tuple(PARAMETERS[name] for name in free))


def with_motions(free: FreeSettings) -> FreeSettings:
    """The settings with modified roll and helical motion, for targets that the plain settings do not reach."""
    motions = [PARAMETERS[name] for name in MOTIONS]
    if free.common:
        return FreeSettings((*free.common, *(m for m in motions if m not in free.common)), free.own)
    return FreeSettings((), (*free.own, *(m for m in motions if m not in free.own)))


def root_weight(inputs: SettingsInput, pair: PairDimensions) -> float:
    """Residual per metre of root error, smaller if both flanks share few settings."""
    if inputs.targets.root_weight is not None:
        return inputs.targets.root_weight
    return pair.process.root_weight if inputs.cutting.pinion == "both_flanks" else _ROOT_WEIGHT


def _uncut(pair: PairDimensions, start: conjugate.ConjugateFlankStart) -> FittedFlank:
    """The conjugate flank itself, evaluated for undercut only."""
    target = conjugate.target_flank(pair, start, np.zeros(start.parameters.shape[1]), 0.0)
    return measure(target, target.flank, target.phase, target.parameters)


def _design(
    inputs: SettingsInput, pair: PairDimensions, gear: GearCut, fitted: FittedFlanks, scale: dict[FlankSide, float]
) -> tuple[str, Design]:
    """Text and content of the design file."""
    cut_flanks: dict[FlankSide, CutFlank] = {side: written_flank(gear.flank(side), 0.0) for side in FLANK_SIDES}
    pinion: PinionFlanks
    if inputs.cutting.pinion == "conjugate":
        pinion = {side: ease_off_table(inputs.targets.of(side), scale[side]) for side in FLANK_SIDES}
    else:
        # blade phases of both flanks from their mean rotation; the backlash is removed from the pinion tooth
        back = {side: fitted[side].outwards * conjugate.backlash_angle(pair) for side in FLANK_SIDES}
        middle = 0.5 * sum(fitted[side].phase for side in FLANK_SIDES)
        pinion = {
            side: written_flank(fitted[side].flank, fitted[side].phase - middle - back[side]) for side in FLANK_SIDES
        }
    text = design_text(inputs, pair.blank, pinion, cut_flanks, header(inputs, fitted))
    return text, validate(Design, tomllib.loads(text))


def unloaded_mesh(design: Design, side: Side, fitted: FittedFlank) -> Transmission | None:
    """Unloaded transmission error of the mesh; None if the pair does not mesh or is far from the target."""
    if fitted.rms > _MESHES:
        return None
    try:
        mesh = flank_pair(design.flanks(), side, shape=_SHAPE).transmission
    except ConvergenceError:
        return None
    return mesh if mesh.peak_to_peak < _MESHES_ANGLE else None


def _warnings(blank: PairBlank, reports: dict[FlankSide, FlankFit], transmission: bool) -> tuple[str, ...]:
    out = []
    for side, report in reports.items():
        if report.fitted.rms > RESIDUAL_LIMIT:
            residual = f"residual {report.fitted.rms * 1e6:.2f} um rms"
            out.append(f"{side}: {residual}, above {RESIDUAL_LIMIT * 1e6:g}; {_WAYS_OUT}")
        root, clearance = float(np.abs(report.fitted.root_error).max(initial=0.0)), blank.clearance_pinion
        if root > 0.5 * clearance:
            limit = f"more than half the clearance of {clearance * 1e3:.2f} mm"
            out.append(f"{side}: root error {root * 1e3:.2f} mm, {limit}")
        if report.transmission is None:
            if transmission:
                out.append(f"{side}: no unloaded transmission error, because the flanks do not mesh over the whole map")
        elif report.transmission.edges:
            out.append(f"{side}: unloaded contact runs over an edge: {', '.join(report.transmission.edges)}")
    return tuple(out)
