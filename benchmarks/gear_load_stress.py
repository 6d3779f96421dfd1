"""Stability campaign of the loaded contact: random designs, torques, misalignments and grids.

    python benchmarks/gear_load_stress.py --count 500
    python benchmarks/gear_load_stress.py --count 500 --relief --output benchmarks/out/gear_load_stress_relief.csv
    python benchmarks/gear_load_stress.py --report
    python benchmarks/gear_load_stress.py --table TABLE.md

Designs come from random sensible blanks (`gear_stress_cases`), their gear cut with settings, their pinion conjugate to
it less an ease-off; blanks that no design comes from are drawn again. Torques are 0.1 to 10 times the nominal one
(tangential force over face width and normal module of 100 N/mm2), misalignments E, P and G up to 0.5 mm, at most an
eighth of the normal module, grids 5 to 200 points a line at 4 to 8 positions, drive and coast side. `--relief`: tip,
toe and heel of both members have relief of any form, 0.2 to 20 thousandths of a module deep, or none.

"answered": load found at all positions, both residuals below 1e-10, all numbers finite, no force negative. "refused"
with a reason of `REASONS`. "wrong" (anything else): must not occur. The same command again goes on where it stopped.
"""

from __future__ import annotations

import csv
import warnings
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from common import command_line
from gear_stress_cases import blank_content, formate

from efficiency.contact.tooth_grid import tooth_shapes
from efficiency.design.design import Design
from efficiency.design.relief_input import MemberReliefInput
from efficiency.ltca.limits import edge_load, hardness
from efficiency.ltca.mesh_grids import load_grids
from efficiency.machine_settings.inputs import SettingsInput
from efficiency.machine_settings.solve import machine_settings
from efficiency.pair import Mesh
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.validation import validate

OUT = Path("benchmarks/out/gear_load_stress.csv")
RESIDUAL = 1e-10
NOMINAL = 100e6
REASONS = {
    "undercut": "a flank does not exist at its mean point, or too much of the mating flank is missing",
    "flank": "a flank does not pass through its mean point",
    "no_mesh": "the blank of the misaligned pinion hardly reaches the gear flank",
    "no_contact": "no tooth pair can touch at some pinion angle",
    "map": "the fields of the mesh are not smooth enough to be mapped",
    "transmission": "the unloaded transmission error is out of proportion with the ease-off",
    "crossing": "the flanks of a tooth cross",
    "flanks_cross": "a tooth is pointed below its tip, or a slot closes above its root",
    "newton_limit": "Newton's method on the local compliance did not converge",
    "active_set_limit": "neither active set came to an end",
}
COLUMNS = (
    "seed", "index", "process", "gear", "offset_mm", "ratio", "module_mm", "torque_factor", "torque", "E_mm", "P_mm",
    "G_mm", "relief", "side", "positions", "points", "outcome", "reason", "torque_residual", "residual", "iterations",
    "exchanges", "fallbacks", "pressure_GPa", "pressure_edge_GPa", "edge_share", "above_hardness", "seconds", "detail",
)  # fmt: skip


def random_design(seed: int, index: int) -> tuple[Design | None, dict[str, Any]]:
    """Design of a random blank, or None where no design comes from it; what is varied."""
    content = blank_content(seed, index)
    gear = "formate" if formate(content, index) else "generated"
    about = {
        "process": content["process"],
        "gear": gear,
        "offset_mm": round(1e3 * content["hypoid_offset"], 3),
        "ratio": round(content["teeth_gear"] / content["teeth_pinion"], 4),
    }
    try:
        return design_of(content, gear), about
    except (InputError, ConvergenceError):
        return None, about


def design_of(content: dict[str, Any], gear: str) -> Design:
    """The gear of a blank by settings, the pinion conjugate to it less an ease-off."""
    size = content["outer_pitch_diameter_gear"] / 0.17
    target = {"crowning_toe": 40e-6 * size, "crowning_heel": 40e-6 * size}
    target |= {"relief_root": 12e-6 * size, "relief_tip": 12e-6 * size}
    inputs = validate(
        SettingsInput,
        {
            "name": content["name"],
            "blank": content,
            "cutting": {"gear": gear, "pinion": "conjugate"},
            "targets": {"drive": target, "coast": target},
            "operation": {"torque": 200.0, "speed": 150.0, "temperature": 363.15, "oil": "75w90"},
        },
    )
    design = machine_settings(inputs, transmission=False).design
    # teeth that run to a point before their tip are no design
    tooth_shapes(design.flanks())
    return design


def with_relief(design: Design, rng: np.random.Generator) -> tuple[Design, str]:
    """The design with random relief, and the relief in short: amounts in um."""
    module, update, short = module_normal(design), {}, []
    for member in ("pinion", "gear"):
        blank = getattr(design, member).blank
        half = 0.5 * blank.face_width
        taper = np.tan(blank.addendum_angle) + np.tan(blank.dedendum_angle)
        depth = blank.mean_addendum + blank.mean_dedendum - half * abs(taper)
        tables = {}
        for edge, most in (("tip", 0.9 * depth), ("toe", 0.45 * blank.face_width), ("heel", 0.45 * blank.face_width)):
            if rng.uniform() < 0.75:
                amount = 2e-4 * module * 100.0 ** rng.uniform()
                form = str(rng.choice(["linear", "parabolic", "circular"]))
                length = max(most * rng.uniform(0.05, 1.0), 1.1 * amount)
                tables[edge] = {"amount": float(amount), "length": float(length), "form": form}
                short.append(f"{member} {edge} {form} {amount * 1e6:.3g}")
        relief = MemberReliefInput.model_validate(tables)
        relief.check(blank.blank())
        update[member] = getattr(design, member).model_copy(update={"edge_relief": relief})
    return design.model_copy(update=update), "; ".join(short)


def module_normal(design: Design) -> float:
    """Mean normal module [m], about: with the spiral angle of 35 deg."""
    gear = design.gear.blank
    return 2.0 * gear.mean_cone_distance * float(np.sin(gear.pitch_angle)) / gear.teeth * 0.82


def run_case(design: Design, rng: np.random.Generator) -> dict[str, Any]:
    """One design under one torque."""
    module = module_normal(design)
    pinion = design.pinion.blank
    radius = pinion.mean_cone_distance * float(np.sin(pinion.pitch_angle))
    nominal = NOMINAL * design.gear.blank.face_width * module * radius
    factor = float(10.0 ** rng.uniform(-1.0, 1.0))
    most = min(0.5e-3, 0.125 * module)
    moved = dict(zip("EPG", rng.uniform(-most, most, 3).tolist(), strict=True))
    points, positions = round(5.0 * 40.0 ** rng.uniform()), int(rng.choice([4, 6, 8]))
    side: Any = "drive" if rng.integers(2) else "coast"
    row: dict[str, Any] = {
        "module_mm": round(1e3 * module, 3),
        "torque_factor": round(factor, 4),
        "torque": nominal * factor,
        "side": side,
        "positions": positions,
        "points": points,
        **{f"{name}_mm": round(1e3 * value, 4) for name, value in moved.items()},
    }
    start = process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            mesh = Mesh.of(design.with_misalignment(**moved), side, positions, points).grids
            loaded = load_grids(mesh, nominal * factor)
        row |= verdict(loaded)
    except ConvergenceError as error:
        row |= refused(error.reason, str(error))
    except InputError as error:
        row |= refused(error.field, str(error))
    except Exception as error:
        row |= {"outcome": "wrong", "reason": type(error).__name__, "detail": str(error)}
    return {**row, "seconds": round(process_time() - start, 3)}


def refused(reason: str, detail: str) -> dict[str, Any]:
    """Row of a case without an answer."""
    return {"outcome": "refused" if reason in REASONS else "wrong", "reason": reason, "detail": detail}


def verdict(loaded: Any) -> dict[str, Any]:
    """Outcome and figures of a loaded mesh."""
    load, teeth = loaded.fine, loaded.mesh.teeth
    edges = edge_load(load, teeth)
    row = {
        "torque_residual": load.torque_residual,
        "residual": load.compatibility_residual,
        "iterations": max(p.equilibrium.iterations for p in load.positions),
        "exchanges": max(p.equilibrium.exchanges for p in load.positions),
        "fallbacks": sum(p.equilibrium.fallbacks for p in load.positions),
        "pressure_GPa": load.pressure_max / 1e9,
        "pressure_edge_GPa": edges.pressure / 1e9,
        "edge_share": edges.share,
        "above_hardness": int(load.pressure_max > hardness(teeth)),
    }
    for part in (loaded.fine, loaded.coarse):
        if part.status == "failed":
            return row | refused(part.reason, "")
        arrays = [getattr(p, name) for p in part.positions for name in ("force", "pressure_max", "half_width")]
        finite = all(np.isfinite(array).all() for array in [*arrays, part.transmission_error, part.stiffness_tangent])
        if not finite or any((p.force < 0.0).any() for p in part.positions):
            return row | {"outcome": "wrong", "reason": "a number not finite or a negative force"}
        if max(part.torque_residual, part.compatibility_residual) > RESIDUAL:
            return row | {"outcome": "wrong", "reason": "residual above 1e-10"}
    return row | {"outcome": "answered", "reason": ""}


def lines_of(path: Path) -> list[dict[str, str]]:
    """Rows of the table there are."""
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def summary(path: Path) -> list[tuple[str, str]]:
    """Lines of the report."""
    lines = lines_of(path)
    designs = [line for line in lines if line["outcome"] != "no design"]
    out = [("designs", str(len(designs))), ("blanks without a design", str(len(lines) - len(designs)))]
    for outcome, count in Counter(line["outcome"] for line in designs).most_common():
        out.append((outcome, f"{count} ({count / len(designs):.1%})"))
    for reason, count in Counter(line["reason"] for line in designs if line["reason"]).most_common():
        out.append((f"reason {reason}", f"{count}, {REASONS.get(reason, 'not listed')}"))
    good = [line for line in designs if line["outcome"] == "answered"]
    for name, text in (
        ("residual", "worst residual of compatibility"),
        ("torque_residual", "worst residual of the torque"),
        ("iterations", "most Newton steps"),
        ("fallbacks", "most uses of the slow active set"),
        ("seconds", "most CPU seconds, geometry included"),
    ):
        out.append((text, f"{max(float(line[name]) for line in good):.3g}"))
    seconds = np.median([float(line["seconds"]) for line in good])
    out.append(("median CPU seconds, geometry included", f"{seconds:.3g}"))
    for name, low, high in (
        ("torque_factor", 0.1, 1.0),
        ("torque_factor", 1.0, 10.0),
        ("points", 5, 30),
        ("points", 31, 200),
    ):
        part = [line for line in designs if low <= float(line[name]) <= high]
        share = np.mean([line["outcome"] == "answered" for line in part])
        out.append((f"answered with {name} {low:g} to {high:g}", f"{share:.1%} of {len(part)}"))
    above = sum(line["above_hardness"] == "1" for line in good)
    out.append(("answered, flank pressure above the hardness (told in the result)", str(above)))
    edge = np.median([float(line["edge_share"]) for line in good])
    out.append(("median share of the torque at edges", f"{edge:.1%}"))
    return out


def main(argv: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = command_line(__doc__)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=6)
    parser.add_argument("--output", type=Path, default=OUT)
    parser.add_argument("--relief", action="store_true", help="random relief on tip, toe and heel")
    parser.add_argument("--report", action="store_true")
    parser.add_argument("--table", type=Path)
    arguments = parser.parse_args(argv)
    if not arguments.report and arguments.table is None:
        arguments.output.parent.mkdir(parents=True, exist_ok=True)
        known = lines_of(arguments.output)
        have = sum(line["outcome"] != "no design" for line in known)
        index = 1 + max((int(line["index"]) for line in known), default=-1)
        with arguments.output.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, COLUMNS, restval="")
            if not known:
                writer.writeheader()
            while have < arguments.count:
                design, about = random_design(arguments.seed, index)
                row = {"seed": arguments.seed, "index": index, **about, "outcome": "no design"}
                if design is not None and arguments.relief:
                    design, relief = with_relief(design, np.random.default_rng([arguments.seed, index, 2]))
                    row["relief"] = relief
                if design is not None:
                    row |= run_case(design, np.random.default_rng([arguments.seed, index, 1]))
                    have += 1
                writer.writerow(row)
                file.flush()
                index += 1
    table = summary(arguments.output)
    width = max(len(name) for name, _ in table)
    print("\n".join(f"{name:{width}s}  {value}" for name, value in table))
    if arguments.table is not None:
        rows = "\n".join(f"| {name} | {value} |" for name, value in table)
        arguments.table.write_text(f"| loaded contact, random designs | |\n|---|---|\n{rows}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
