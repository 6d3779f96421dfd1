"""Random plausible blanks of bevel and hypoid pairs.

Ratios 1 to 6, offsets 0 to half the mean radius of the gear, gear spiral angles 0 to 50 deg, normal modules 1 to 15 mm,
shaft angles 60 to 120 deg. "Sensible" ties together what belongs together: the gear is no crown gear (its pitch angle
up to 85 deg), the pinion's spiral angle is at most 55 deg, the face 0.15 to 0.3 of the outer cone distance and at most
10 modules wide, the cutter radius 0.7 to 1.2 mean cone distances and above that of parallel slots, the lead angle of a
face-hobbing head below 25 deg. Where the blank warns of undercut the designer's remedy is taken: another addendum
factor, then larger pressure angles; what stays undercut is drawn again.
"""

import json
import math
import sys
import warnings
from collections import Counter
from dataclasses import asdict, replace
from math import asin, atan2, ceil, cos, radians, sin
from typing import Any

import numpy as np

from efficiency.blanks.inputs import PairBlankInput
from efficiency.blanks.pair import pair_blank
from efficiency.blanks.pair_blank import PairBlank
from efficiency.contact.conjugate import EaseOffTarget, conjugate_flank
from efficiency.contact.contact_search import transmission
from efficiency.contact.mesh_surface import mesh_surface
from efficiency.cutting.cutter import FLANK_SIDES
from efficiency.cutting.flank import CutFlank
from efficiency.design.design import bevel_names, load_design
from efficiency.machine_settings.gear import cut_gear, pair_dimensions
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.validation import validate

HEADS = (3, 5, 7, 11, 13, 17)
# share of the gear's pitch above which a transmission error cannot come from the crowning laid on
TRANSMISSION_LIMIT = 0.02
# stage and field or reason of the error
REASONS = {
    *("blank:hypoid_offset", "blank:cutter_radius", "blank:shaft_angle", "blank:face_width_gear", "blank:depth"),
    *("blank:taper", "blank:pressure_angle.drive", "blank:pressure_angle.coast"),
    *(f"gear:{reason}" for reason in ("undercut", "flank", "gear_settings", "cutter_radius")),
    *("pinion:undercut", "pinion:no_mesh"),
    *(f"contact:{reason}" for reason in ("undercut", "flank", "no_mesh", "no_contact", "map", "transmission")),
}


def blank_content(seed: int, index: int) -> dict[str, Any]:
    """Content of one random blank file (SI numbers), the same for the same seed and index."""
    rng = np.random.default_rng([seed, index])
    while True:
        content = _draw(rng)
        if content is not None:
            content = _without_undercut({"name": f"random_{seed}_{index}", **content})
        if content is not None:
            return content


def _without_undercut(content: dict[str, Any]) -> dict[str, Any] | None:
    """The blank after the designer's remedy, or None where there is none."""
    for more in (0.0, 2.0, 4.0, 6.0):
        angles = {side: angle + radians(more) for side, angle in content["pressure_angle"].items()}
        trial = {**content, "pressure_angle": angles}
        for _ in range(3):
            try:
                pair = pair_blank(PairBlankInput.model_validate(trial))
            except InputError:
                return trial
            if not any(point.undercut for point in pair.undercut):
                return trial
            least = max(point.limit for point in pair.undercut if point.member == "pinion")
            most = min(point.limit for point in pair.undercut if point.member == "gear")
            depth = 2.0 * pair.addendum_factor
            factor = 0.5 - max(min(pair.profile_shift, most - 0.02), least + 0.02) / depth
            if not 0.06 <= factor <= 0.5:
                break
            trial = {**trial, "depth": {"data_type": "II", "gear_addendum_factor": factor}}
    return None


def _draw(rng: np.random.Generator) -> dict[str, Any] | None:
    ratio = rng.uniform(1.0, 6.0)
    fewest = max(8, ceil(24 / ratio))
    z_1 = int(rng.integers(fewest, fewest + 12))
    z_2 = max(z_1, round(z_1 * ratio))
    sigma = radians(rng.uniform(60.0, 120.0))
    bevel = atan2(sin(sigma), z_1 / z_2 + cos(sigma))
    if bevel > radians(85.0):
        return None
    method = int(rng.integers(0, 4))
    offset_share = 0.0 if method == 0 else rng.uniform(0.0, 0.5)
    # offset angle in the pitch plane, about: 2a = dm2 sin(zeta)(1 + cos d2/(u cos d1))
    reach = 1.0 + cos(bevel) * z_1 / z_2 / max(cos(sigma - bevel), 0.2)
    turn = asin(min(1.0, offset_share / reach))
    spiral = radians(rng.uniform(0.0, 50.0))
    if spiral + turn > radians(55.0):
        return None
    module = float(np.exp(rng.uniform(np.log(1e-3), np.log(15e-3))))
    mean_diameter = module * z_2 / cos(spiral)
    cone = 0.5 * mean_diameter / sin(bevel)
    share = rng.uniform(0.15, 0.30)
    outer = cone / (1.0 - 0.5 * share)
    face = min(share * outer, 10.0 * module / cos(spiral) * outer / cone)
    hobbed = bool(rng.integers(0, 2))
    radius = max(rng.uniform(0.7, 1.2) * cone, 1.1 * cone * sin(spiral))
    groups = None
    if hobbed:
        fitting = [z for z in HEADS if 0.5 * z * module < radius * sin(radians(25.0))]
        groups = int(rng.choice(fitting)) if fitting else 1
    angle = radians(rng.uniform(16.0, 25.0))
    member, value = ("pinion", spiral + turn) if method == 1 else ("gear", spiral)
    return {
        "method": method, "process": "face_hobbing" if hobbed else "face_milling", "teeth_pinion": z_1,
        "teeth_gear": z_2, "hand_pinion": "left" if rng.integers(0, 2) else "right", "shaft_angle": sigma,
        "hypoid_offset": offset_share * 0.5 * mean_diameter,
        "outer_pitch_diameter_gear": mean_diameter + face * sin(bevel), "face_width_gear": face,
        f"mean_spiral_angle_{member}": value, "cutter_radius": radius, "blade_groups": groups,
        "pressure_angle": {"drive": angle, "coast": angle},
        "backlash": {"type": "mean_normal", "value": 0.03 * module},
    }  # fmt: skip


def deeper(flank: CutFlank, depth: float) -> CutFlank:
    """The same cutting surface on a blade that reaches further below the root [m]: the flank it cuts is the same."""
    blade, machine = flank.blade, flank.machine
    centre = machine.cutter_centre + depth * machine.cutter_axes[:, 2]
    machine = replace(
        machine,
        radial_setting=float(np.hypot(centre[0], centre[1])),
        cradle_angle=float(np.arctan2(centre[1], centre[0])),
        sliding_base=machine.sliding_base - float(centre[2]),
    )
    raised = {
        name: replace(part, height=part.height + depth)
        for name in ("toprem", "flankrem", "protuberance")
        if (part := getattr(blade, name)) is not None
    }
    if blade.groups or blade.curvature:
        blade = replace(blade, reference_height=blade.reference_height + depth, **raised)
    else:
        radius = blade.point_radius - blade.sign * depth * np.tan(blade.blade_angle)
        blade = replace(blade, point_radius=float(radius), **raised)
    return replace(flank, blade=blade, machine=machine)


def random_cut(seed: int, index: int) -> tuple[CutFlank, float]:
    """A random cut flank, and by how much its blade is to reach deeper [m].

    Every second one is a gear from a random blank, generated or Formate; the others are flanks of shipped designs with
    random changes of blade and machine. The depth is 0.2 to 8 mean dedendums.
    """
    rng = np.random.default_rng([seed, index, 7])
    side = FLANK_SIDES[int(rng.integers(0, 2))]
    if index % 2:
        content = blank_content(seed, index)
        pair = pair_blank(PairBlankInput.model_validate(content))
        way = "formate" if formate(content, int(rng.integers(0, 2))) else "generated"
        flank = cut_gear(pair_dimensions(replace(pair, gear_cutting=way))).flank(side)
    else:
        design = load_design(str(rng.choice(bevel_names())))
        shipped = design.flank("pinion" if rng.uniform() < 0.7 else "gear", side)
        assert isinstance(shipped, CutFlank)
        flank = shipped
    blade = replace(flank.blade, blade_angle=flank.blade.blade_angle + radians(rng.uniform(-3.0, 3.0)))
    machine = replace(
        flank.machine,
        tilt=flank.machine.tilt + radians(rng.uniform(-3.0, 3.0)),
        radial_setting=flank.machine.radial_setting * rng.uniform(0.98, 1.02),
        roll_ratio=flank.machine.roll_ratio * rng.uniform(0.99, 1.01),
    )
    return replace(flank, blade=blade, machine=machine), float(rng.uniform(0.2, 8.0) * flank.blank.mean_dedendum)


def formate(content: dict[str, Any], index: int) -> bool:
    """Whether the gear is cut without generating motion: every second one from ratio 2.5 on, as in practice."""
    return index % 2 == 0 and bool(content["teeth_gear"] >= 2.5 * content["teeth_pinion"])


class Refused(Exception):
    """A stage failed: stage, reason and message."""


def run_stage(stage: str, function: Any, *arguments: Any) -> Any:
    """One stage; errors meant for a user become `Refused`."""
    try:
        return function(*arguments)
    except (InputError, ConvergenceError) as error:
        reason = error.field if isinstance(error, InputError) else error.reason
        raise Refused(f"{stage}:{reason}", str(error)) from None


def check_contact(pair: PairBlank, gear_cutting: str) -> None:
    """Gear flank, conjugate pinion flank and unloaded contact of the drive side."""
    geometry = run_stage("gear", pair_dimensions, replace(pair, gear_cutting=gear_cutting))
    gear = run_stage("gear", cut_gear, geometry).flank("convex")
    size = pair.module_normal / 4e-3
    relief = EaseOffTarget(lengthwise_crowning=40e-6 * size, profile_crowning=12e-6 * size)
    pinion = run_stage("pinion", conjugate_flank, gear, geometry.pinion, geometry.assembly, relief)
    surface = run_stage("contact", mesh_surface, gear, pinion, geometry.assembly)
    error = run_stage("contact", transmission, surface).peak_to_peak
    if not error <= TRANSMISSION_LIMIT * 2.0 * math.pi / pair.gear.teeth:
        raise ArithmeticError(f"transmission error {math.degrees(error):.3g} deg, undercut {surface.undercut}")


def run_case(seed: int, index: int, until: str) -> dict[str, str]:
    """Outcome of one random blank, until "blank" or "contact"; never raises."""
    content = blank_content(seed, index)
    gear = "formate" if formate(content, index) else "generated"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            pair = run_stage("blank", pair_blank, validate(PairBlankInput, content))
            json.dumps(asdict(pair), allow_nan=False, default=str)  # all numbers are finite
            if until != "blank":
                check_contact(pair, gear)
    except Refused as refusal:
        reason, detail = refusal.args
        return {"outcome": "refused" if reason in REASONS else "wrong", "reason": reason, "detail": detail}
    except Exception as error:
        return {"outcome": "wrong", "reason": type(error).__name__, "detail": str(error)}
    return {"outcome": "answered"}


def run_cutter(seed: int, index: int) -> str:
    """Outcome of one random cutter reaching too deep: "answered", "refused" (by both blades) or what is wrong."""
    try:
        flank, depth = random_cut(seed, index)
    except (InputError, ConvergenceError):
        return "refused"
    blank = flank.blank
    u, v = (grid.ravel() for grid in np.meshgrid(np.linspace(-0.5, 0.5, 7), np.linspace(0.0, 1.0, 6)))
    u = u * blank.face_width
    h = blank.height(u, v)
    found = []
    for blade in (flank, deeper(flank, depth)):
        try:
            found.append(blade.solve(u, h))
        except ConvergenceError as error:
            found.append(error)
    failed = [isinstance(each, ConvergenceError) for each in found]
    if any(failed):
        return "refused" if all(failed) else f"wrong: {found}"
    (points, exists), (others, also) = found
    flank_part = exists & (flank.regression(points.parameters) > 0.0) if flank.machine.generation.rolls else exists
    lost = int((flank_part & ~also).sum())
    off = np.linalg.norm(points.position - others.position, axis=0)[flank_part & also].max(initial=0.0)
    right = flank_part.any() and not lost and off < 1e-9
    return "answered" if right else f"wrong: {flank_part.sum()} points, {lost} lost, {off * 1e9:.3g} nm off"


def main() -> None:
    """Count the outcomes of random pairs until the unloaded contact: ``python tests/twins/random_blanks.py 100``."""
    outcomes: Counter[str] = Counter()
    for index in range(int(sys.argv[1]) if len(sys.argv) > 1 else 100):
        case = run_case(1, index, "contact")
        outcomes[f"{case['outcome']} {case.get('reason', '')}"] += 1
    for outcome, count in outcomes.most_common():
        print(f"{count:5d}  {outcome}")


if __name__ == "__main__":
    main()
