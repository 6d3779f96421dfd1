"""Machine settings from targets for 100 varied blanks: residual, iterations, time.

    python validation/settings_fit.py [--cases 100] [--first 0] [--seed 1] [--way NAME]
        [--sized] [--csv settings_fit.csv]

Each case is a random pair (ratio, teeth, size, offset, spiral angle, cutter, wanted ease-off, way of cutting) whose
blank `pair_blank` accepts. Printed: every case; share of pairs with both residuals below 3 um rms by way of cutting.
With --sized: share of a torque on edges in the worst state of the box before `sized_for_load` and after it (drive,
coast), at 150 kPa d_e2^3 of the gear on both sides (the 14x39 at 300 N m), and centre of the load in half face widths.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees, radians
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from common import command_line, write_rows

from efficiency.blanks.pair import pair_blank
from efficiency.ltca.limits import EDGE_LIMIT
from efficiency.machine_settings.inputs import SettingsInput
from efficiency.machine_settings.solve import machine_settings
from efficiency.optimisation.load_sizing import sized_for_load
from ehl.common.errors import InputError, MixedEhlError
from ehl.common.validation import validate

WAYS = {
    "face_hobbed both flanks": ("face_hobbing", "formate", "both_flanks", "uniform", 30),
    "face_hobbed each flank": ("face_hobbing", "formate", "each_flank", "uniform", 15),
    "face_hobbed generated gear": ("face_hobbing", "generated", "both_flanks", "uniform", 10),
    "two-part head": ("two_part_face_hobbing", "generated", "both_flanks", "uniform", 0),  # by --way alone
    "face_milled formate": ("face_milling", "formate", "each_flank", "tilted_root", 25),
    "face_milled generated gear": ("face_milling", "generated", "each_flank", "standard", 20),
}
CROWNING = ((20e-6, 6e-6), (40e-6, 12e-6), (80e-6, 20e-6))


@dataclass(frozen=True)
class Row:
    """One case; lengths in mm, angles in degrees, residuals in um."""

    case: int
    way: str
    teeth_pinion: int
    teeth_gear: int
    outer_diameter: float
    offset: float
    spiral: float
    cutter_radius: float
    blade_groups: int
    crowning: float
    rms_drive: float
    rms_coast: float
    largest: float
    undercut: int
    root_error: float
    iterations: int
    seconds: float
    reason: str


def pair(way: str, rng: np.random.Generator) -> dict[str, Any]:
    """A random targets file, SI."""
    process, gear, pinion, taper, _ = WAYS[way]
    teeth = int(rng.integers(8, 17))
    mate = round(teeth * rng.uniform(1.8, 5.0))
    while np.gcd(teeth, mate) > 1:
        mate += 1
    diameter = rng.uniform(0.09, 0.30)
    offset = float(rng.choice([0.0, rng.uniform(0.02, 0.34)])) * 0.5 * diameter
    spiral = radians(rng.uniform(20.0, 38.0))
    blank: dict[str, Any] = {
        "name": "case",
        "method": 0 if offset == 0.0 else 2 if "hobbing" in process else 1,
        "process": process,
        "teeth_pinion": teeth,
        "teeth_gear": mate,
        "hand_pinion": str(rng.choice(["left", "right"])),
        "hypoid_offset": offset,
        "outer_pitch_diameter_gear": diameter,
        "face_width_gear": rng.uniform(0.12, 0.165) * diameter,
        "taper": {"type": taper},
        "backlash": {"type": "outer_transverse", "value": 1e-3 * diameter},
    }
    if blank["method"] == 1:
        blank["mean_spiral_angle_pinion"] = spiral + 1.3 * offset / (0.5 * diameter)
    else:
        blank["mean_spiral_angle_gear"] = spiral
    # cutter radius from a little below the mean cone distance times the sine of the spiral angle to well above
    blank["cutter_radius"] = diameter * rng.uniform(0.36, 0.62)
    if "hobbing" in process:
        blank["blade_groups"] = int(rng.choice([11, 13, 17]))
        blank["cutter_radius"] = diameter * rng.uniform(0.38, 0.55)
    ends, edges = CROWNING[rng.integers(len(CROWNING))]
    ends, edges = ends * diameter / 0.17, edges * diameter / 0.17
    target = {"crowning_toe": ends, "crowning_heel": ends, "relief_root": edges, "relief_tip": edges}
    return {
        "name": "case",
        "blank": blank,
        "cutting": {"gear": gear, "pinion": pinion},
        "targets": {"drive": target, "coast": target},
        "operation": {"torque": 200.0, "speed": 300.0, "temperature": 363.0, "oil": "75w90"},
    }


def solve(case: int, way: str, inputs: SettingsInput) -> Row:
    """Settings of one pair."""
    blank, began = inputs.blank, process_time()
    common = (
        case,
        way,
        blank.teeth_pinion,
        blank.teeth_gear,
        1e3 * (blank.outer_pitch_diameter_gear or 0.0),
        1e3 * blank.hypoid_offset,
        degrees(blank.mean_spiral_angle_gear or blank.mean_spiral_angle_pinion or 0.0),
        1e3 * blank.cutter_radius,
        blank.blade_groups or 0,
        1e6 * inputs.targets.drive.crowning_toe,
    )
    try:
        result = machine_settings(inputs, transmission=False)
    except MixedEhlError as error:
        nan = float("nan")
        return Row(*common, nan, nan, nan, 0, nan, 0, process_time() - began, str(error))
    drive, coast = (flank.fitted for flank in result.flanks)
    roots = np.concatenate([drive.root_error, coast.root_error, [0.0]])
    return Row(
        *common,
        1e6 * drive.rms,
        1e6 * coast.rms,
        1e6 * max(drive.largest, coast.largest),
        sum(len(flank.undercut) for flank in result.flanks),
        1e3 * float(np.abs(roots).max()),
        result.iterations,
        process_time() - began,
        "",
    )


def size(case: int, way: str, inputs: SettingsInput) -> bool:
    """Sizing of one pair for its torque; whether it succeeds."""
    blank, began = inputs.blank, process_time()
    torque = 150e3 * (blank.outer_pitch_diameter_gear or 0.0) ** 3 * blank.teeth_pinion / blank.teeth_gear
    try:
        sizing = sized_for_load(inputs, torque)
        shares = sizing.shares
        worst = ", ".join(f"{100.0 * load.worst:.2f}" for load in sizing.sides.values())
        centres = ", ".join(f"{100.0 * load.centre:+.0f}" for load in sizing.sides.values())
        found = f"{100.0 * shares[0]:6.2f} -> {worst} % of {torque:5.0f} N m, centre {centres} %, {len(shares)} steps"
    except MixedEhlError as error:
        shares, found = (), str(error)[:90]
    seconds = process_time() - began
    print(f"{case:4d} {way:28s} {blank.teeth_pinion:2d}x{blank.teeth_gear:<2d} {found} {seconds:5.1f} s", flush=True)
    return len(shares) > 0


def main(argv: Sequence[str] | None = None) -> None:
    """Run the cases and print the table."""
    parser = command_line(__doc__)
    parser.add_argument("--cases", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="number of the first case that is sized")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--way", choices=list(WAYS))
    parser.add_argument("--sized", action="store_true")
    parser.add_argument("--csv", type=Path, default=None)
    arguments = parser.parse_args(argv)
    rng = np.random.default_rng(arguments.seed)
    names, shares = list(WAYS), np.array([way[-1] for way in WAYS.values()], dtype=float)
    rows: list[Row] = []
    refused, count, sized = 0, 0, []
    while max(len(rows), count) < arguments.cases:
        way = arguments.way or str(rng.choice(names, p=shares / shares.sum()))
        try:
            inputs = validate(SettingsInput, pair(way, rng))
            pair_blank(inputs.blank)
        except InputError:
            refused += 1
            continue
        if arguments.sized:
            if count >= arguments.first:
                sized.append(size(count, way, inputs))
            count += 1
            continue
        rows.append(solve(len(rows), way, inputs))
        row = rows[-1]
        print(
            f"{row.case:4d} {row.way:28s} {row.teeth_pinion:2d}x{row.teeth_gear:<2d} d{row.outer_diameter:5.0f} "
            f"a{row.offset:5.1f} b{row.spiral:5.1f} rc{row.cutter_radius:6.1f} c{row.crowning:5.0f}: "
            f"{row.rms_drive:6.2f} {row.rms_coast:6.2f} max {row.largest:6.1f} uc {row.undercut:3d} "
            f"root {row.root_error:5.2f} it {row.iterations:3d} {row.seconds:5.2f} s {row.reason[:90]}",
            flush=True,
        )
    print(f"\n{refused} random blanks refused by their geometry\n")
    if sized:
        print(f"{sum(sized)} of {len(sized)} pairs sized, edges below {100.0 * EDGE_LIMIT:g} % of the torque")
    for way in [*names, None]:
        chosen = [row for row in rows if way in (None, row.way)]
        if not chosen:
            continue
        good = [row for row in chosen if max(row.rms_drive, row.rms_coast) < 3.0]
        median = np.nanmedian([max(row.rms_drive, row.rms_coast) for row in chosen])
        seconds = [row.seconds for row in chosen]
        print(
            f"{way or 'all':28s} {len(good)}/{len(chosen)} below 3 um rms, median {median:.2f} um, "
            f"time median {np.median(seconds):.2f} s, longest {max(seconds):.2f} s"
        )
    if arguments.csv is not None:
        write_rows(arguments.csv, rows)


if __name__ == "__main__":
    main()
