"""Stability campaign of the gear geometry: random sensible blanks, each taken from the blank to the unloaded contact.

    python benchmarks/gear_stress.py --count 1000
    python benchmarks/gear_stress.py --count 1000 --until blank
    python benchmarks/gear_stress.py --report
    python benchmarks/gear_stress.py --cutters 500

Stages: blank (ISO 23509), gear (its settings, Formate or generated), pinion (the flank conjugate to the gear's
less a crowning), contact (ease-off, path, transmission error of the drive side). Rows are appended to a CSV as they
come; the same command again goes on where it stopped. Outcomes: "answered"; "refused" with a reason of `REASONS`;
"wrong" (any other exception, a reason not listed, a number not finite or out of all proportion): must not occur.

Cutters: random cut flanks whose blade reaches 0.2 to 8 dedendums below the root. The surface that cuts is the same,
hence the flank: every point has to lie where it lies with the plain blade, before the edge of regression, to 1 nm.
"""

from __future__ import annotations

import csv
import math
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from common import command_line
from gear_stress_cases import blank_content, deeper, formate, random_cut, row

from efficiency.blanks.inputs import PairBlankInput
from efficiency.blanks.pair import pair_blank
from efficiency.blanks.pair_blank import PairBlank
from efficiency.contact.conjugate import EaseOffTarget, conjugate_flank
from efficiency.contact.mesh_surface import mesh_surface
from efficiency.contact.transmission import transmission
from efficiency.machine_settings.gear import cut_gear, pair_dimensions
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.validation import validate

OUT = Path("benchmarks/out/gear_stress.csv")
# share of the gear's pitch above which a transmission error cannot come from the crowning laid on
TRANSMISSION_LIMIT = 0.02
STAGES = ("blank", "gear", "pinion", "contact")
# stage and field or reason of the error -> what it means
REASONS = {
    "blank:hypoid_offset": "no touching pitch cones: the offset is too large for the teeth and the cutter",
    "blank:cutter_radius": "the cutter is too small: a spiral angle on the faces would exceed 75 deg",
    "blank:pressure_angle.drive": "the limit pressure angle leaves no blade angle on the drive side",
    "blank:pressure_angle.coast": "the limit pressure angle leaves no blade angle on the coast side",
    "blank:shaft_angle": "needle, crown gear or internal gear",
    "blank:face_width_gear": "the face reaches an apex",
    "blank:depth": "teeth or slots without width",
    "blank:taper": "no tooth depth at an end of the face, or a root cone across its axis",
    "gear:undercut": "the generated gear flank is undercut at its mean point",
    "gear:flank": "the gear flank does not pass through its mean point",
    "gear:gear_settings": "no point radii and blade angles give the slot of the gear",
    "gear:cutter_radius": "the lead angle of the face-hobbing head would exceed 90 deg",
    "pinion:undercut": "the generated gear flank is undercut halfway up its addendum",
    "pinion:no_mesh": "points of the gear flank never touch a conjugate pinion",
    "contact:undercut": "a member is undercut over a third of the mating flank, or at its mean point",
    "contact:flank": "the conjugate pinion flank does not pass through its mean point",
    "contact:no_mesh": "the blank of the pinion hardly reaches the gear flank",
    "contact:no_contact": "the blanks share no part of the flank",
    "contact:map": "the fields of the mesh are not smooth enough to be mapped",
    "contact:transmission": "the transmission error is out of proportion with the ease-off",
}
NUMBERS = (
    "module_normal", "pitch_angle_pinion", "pitch_angle_gear", "spiral_pinion", "spiral_gear", "offset_angle",
    "profile_shift", "contact_ratio_profile", "contact_ratio_total", "transmission_error", "edge_contact",
    "undercut_share",
)  # fmt: skip


class Refused(Exception):
    """A stage said no."""

    def __init__(self, stage: str, reason: str, detail: str) -> None:
        self.stage, self.reason, self.detail = stage, f"{stage}:{reason}", detail
        super().__init__(detail)


def finite(value: object) -> Iterator[bool]:
    """Whether the numbers of a result are finite."""
    if is_dataclass(value):
        for field in fields(value):
            yield from finite(getattr(value, field.name))
    elif isinstance(value, (tuple, list)):
        for item in value:
            yield from finite(item)
    elif isinstance(value, float):
        yield math.isfinite(value)


def run_stage(stage: str, function: Any, *arguments: Any) -> Any:
    """One stage; errors meant for a user become `Refused`."""
    try:
        return function(*arguments)
    except InputError as error:
        raise Refused(stage, error.field, str(error)) from None
    except ConvergenceError as error:
        raise Refused(stage, error.reason, str(error)) from None


def blank_numbers(pair: PairBlank) -> dict[str, float]:
    """What the table keeps of a blank: mm, deg."""
    return {
        "module_normal": pair.module_normal * 1e3,
        "pitch_angle_pinion": math.degrees(pair.pinion.pitch_angle),
        "pitch_angle_gear": math.degrees(pair.gear.pitch_angle),
        "spiral_pinion": math.degrees(pair.pinion.mean_spiral_angle),
        "spiral_gear": math.degrees(pair.gear.mean_spiral_angle),
        "offset_angle": math.degrees(pair.offset_angle),
        "profile_shift": pair.profile_shift,
        "contact_ratio_profile": pair.virtual_drive.contact_ratio_profile,
        "contact_ratio_total": pair.virtual_drive.contact_ratio_total,
    }


def contact_numbers(pair: PairBlank, generated: bool, until: str) -> dict[str, float]:
    """Gear flank, conjugate pinion flank and unloaded contact of the drive side."""
    geometry = run_stage("gear", pair_dimensions, pair, generated)
    gear = run_stage("gear", cut_gear, geometry).flank("convex")
    if until == "gear":
        return {}
    size = pair.module_normal / 4e-3
    relief = EaseOffTarget(lengthwise_crowning=40e-6 * size, profile_crowning=12e-6 * size)
    pinion = run_stage("pinion", conjugate_flank, gear, geometry.pinion, geometry.assembly, relief)
    if until == "pinion":
        return {}
    surface = run_stage("contact", mesh_surface, gear, pinion, geometry.assembly)
    contact = run_stage("contact", transmission, surface)
    gone = surface.undercut
    if contact.peak_to_peak > TRANSMISSION_LIMIT * 2.0 * math.pi / pair.gear.teeth:
        raise ArithmeticError(f"transmission error {math.degrees(contact.peak_to_peak):.3g} deg, undercut {gone}")
    return {
        "transmission_error": math.degrees(contact.peak_to_peak) * 3600.0,
        "edge_contact": float(bool(contact.edges)),
        "undercut_share": 0.0 if gone is None else float(gone.share),
    }


def run_case(seed: int, index: int, until: str) -> dict[str, Any]:
    """One case: its row of the table; never raises."""
    content = blank_content(seed, index)
    gear = "formate" if formate(content, index) else "generated"
    result: dict[str, Any] = {"seed": seed, "index": index, "gear": gear, **row(content)}
    start = perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            pair = run_stage("blank", pair_blank, validate(PairBlankInput, content))
            if not all(finite(pair)):
                raise ArithmeticError("a number of the blank is not finite")
            result |= {"warnings": " ".join(sorted({warning.kind for warning in pair.warnings})), **blank_numbers(pair)}
            if until != "blank":
                numbers = contact_numbers(pair, result["gear"] == "generated", until)
                if not all(map(math.isfinite, numbers.values())):
                    raise ArithmeticError(f"not finite: {numbers}")
                result |= numbers
        result |= {"outcome": "answered", "stage": until}
    except Refused as refusal:
        outcome = "refused" if refusal.reason in REASONS else "wrong"
        result |= {"outcome": outcome, "stage": refusal.stage, "reason": refusal.reason, "detail": refusal.detail}
    except Exception as error:
        result |= {"outcome": "wrong", "stage": "", "reason": type(error).__name__, "detail": str(error)}
    return {**result, "seconds": round(perf_counter() - start, 4)}


def run_cutter(seed: int, index: int) -> tuple[str, str]:
    """Outcome and detail of one random cutter reaching too deep: "answered", "refused" (by both blades) or "wrong"."""
    try:
        flank, depth = random_cut(seed, index)
    except (InputError, ConvergenceError) as error:
        return "refused", str(error)
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
    plain, deep = found
    if isinstance(plain, ConvergenceError) or isinstance(deep, ConvergenceError):
        both = isinstance(plain, ConvergenceError) and isinstance(deep, ConvergenceError)
        return ("refused" if both else "wrong"), f"{plain if not both else ''} {deep}"
    (points, exists), (others, also) = plain, deep
    flank_part = exists & (flank.regression(points.parameters) > 0.0) if flank.machine.generation.rolls else exists
    lost = int((flank_part & ~also).sum())
    off = np.linalg.norm(points.position - others.position, axis=0)[flank_part & also].max(initial=0.0)
    right = flank_part.any() and not lost and off < 1e-9
    return ("answered" if right else "wrong"), f"{flank_part.sum()} points, {lost} lost, {off * 1e9:.3g} nm off"


def cutters(count: int, first: int, seed: int) -> None:
    """Print the outcomes of random cutters that reach too deep."""
    outcomes: Counter[str] = Counter()
    for index in range(first, first + count):
        outcome, detail = run_cutter(seed, index)
        outcomes[outcome] += 1
        if outcome != "answered":
            print(f"{index}: {outcome}: {detail}", flush=True)
    print(", ".join(f"{outcome} {number}" for outcome, number in outcomes.most_common()))


def columns() -> list[str]:
    """Columns of the table."""
    head = ["seed", "index", "gear", *row(blank_content(0, 0))]
    return [*head, "outcome", "stage", "reason", "warnings", *NUMBERS, "seconds", "detail"]


def done(path: Path) -> set[tuple[int, int]]:
    """Cases the table holds."""
    if not path.exists():
        return set()
    with path.open(newline="", encoding="utf-8") as file:
        return {(int(line["seed"]), int(line["index"])) for line in csv.DictReader(file)}


def report(path: Path) -> None:
    """Print counts by outcome, reason and kind of pair."""
    with path.open(newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    total = len(lines)
    print(f"{total} blanks")
    for outcome, count in Counter(line["outcome"] for line in lines).most_common():
        print(f"  {outcome:10s} {count:5d}  {count / total:.1%}")
    for reason, count in Counter(line["reason"] for line in lines if line["reason"]).most_common():
        print(f"  {reason:32s} {count:5d}  {REASONS.get(reason, 'not listed')}")
    print("\nanswered of each kind")
    for name in ("method", "process", "gear"):
        kinds = sorted({line[name] for line in lines})
        parts = []
        for kind in kinds:
            outcomes = [line["outcome"] == "answered" for line in lines if line[name] == kind]
            parts.append(f"{kind}: {sum(outcomes)}/{len(outcomes)}")
        print(f"  {name:8s} " + ", ".join(parts))
    print("\nblanks with a warning of each kind")
    kinds = Counter(kind for line in lines for kind in line["warnings"].split())
    print("  " + ", ".join(f"{kind} {count}" for kind, count in kinds.most_common()))
    seconds = np.array([float(line["seconds"]) for line in lines])
    print(
        "\nseconds a case: median {:.3f}, 95 % {:.3f}, largest {:.3f}".format(
            *np.percentile(seconds, [50.0, 95.0, 100.0])
        )
    )


def main(argv: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = command_line(__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--until", choices=STAGES, default="contact")
    parser.add_argument("--output", type=Path, default=OUT)
    parser.add_argument("--report", action="store_true")
    parser.add_argument("--cutters", type=int, help="run so many random cutters that reach too deep, nothing else")
    arguments = parser.parse_args(argv)
    if arguments.cutters is not None:
        cutters(arguments.cutters, arguments.first, arguments.seed)
        return
    if not arguments.report:
        arguments.output.parent.mkdir(parents=True, exist_ok=True)
        known = done(arguments.output)
        with arguments.output.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, columns(), restval="")
            if not known:
                writer.writeheader()
            for index in range(arguments.first, arguments.first + arguments.count):
                if (arguments.seed, index) in known:
                    continue
                writer.writerow(run_case(arguments.seed, index, arguments.until))
                file.flush()
    report(arguments.output)


if __name__ == "__main__":
    main()
