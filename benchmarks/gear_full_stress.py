"""Stability campaign of the whole gear side: relief, soft shafts, friction in the balance, either member driving.

    python benchmarks/gear_full_stress.py --count 500
    python benchmarks/gear_full_stress.py --report

Random designs, torques, misalignments and reliefs as in `gear_load_stress`; every second design stands on soft shafts
(bearings, or a full 6 x 6 matrix per member; 0.01 to 0.5 % of a module under the nominal force), friction is constant,
a published formula or one of the shipped ones, speeds and oil temperatures are random, and each load runs with the
pinion and with the gear driving. Grids: 4 positions, 7 to 17 points a line.

Checked of every answer, "wrong" otherwise: numbers finite, no force negative, residuals below 1e-10; torque of force
vectors about both axes and loss point by point: input = output + loss to 1e-10 at each position, shaft torque to 1e-10;
efficiency between 0 and 1; the deflection returns itself under the load it ends with; the status agrees with pressure
and hardness. Every twentieth design is built again as its mirror image: same efficiency, pressure and deflection. Every
25th is solved on twice the positions and points: the change is put over the stated error.
"""

from __future__ import annotations

import csv
import math
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from common import command_line
from gear_load_stress import NOMINAL, REASONS, RESIDUAL, design_of, lines_of, module_normal, random_design, with_relief
from gear_stress_cases import blank_content, formate

from efficiency.contact.displaced_axes import DisplacedAxes
from efficiency.design.design import Design
from efficiency.design.stiffness_input import StiffnessInput
from efficiency.ltca.limits import hardness
from efficiency.ltca.shaft_deflection import axes_under_load
from efficiency.pair import LoadedMesh, Mesh
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.validation import validate

OUT = Path("benchmarks/out/gear_full_stress.csv")
MIRROR, REFINED = 20, 25
FRICTIONS = ("constant", "xu_kahraman_2007", "75w90", "75w90_short")
REFUSED = REASONS | {
    "deflection_limit": "shafts too soft: E, P, G do not settle",
    "assembly.stiffness": "shafts so soft that the axes leave the range of misalignments",
    "self_locking": "friction takes the whole torque",
    "pressure_above_hardness": "flank pressure above the hardness",
}
COLUMNS = (
    "seed", "index", "process", "gear", "offset_mm", "ratio", "module_mm", "torque_factor", "torque", "E_mm", "P_mm",
    "G_mm", "relief", "shafts", "side", "positions", "points", "friction", "speed", "temperature", "outcome", "reason",
    "residual", "energy", "deflection_um", "deflection_rounds", "deflection_residual_um", "pressure_GPa", "edge_share",
    "efficiency_pinion", "efficiency_gear", "error", "mirror", "refined", "seconds", "detail",
)  # fmt: skip


class Wrong(Exception):
    """An answer that breaks an invariant."""


def require(holds: bool | np.bool_, what: str) -> None:
    """Raise what is wrong."""
    if not holds:
        raise Wrong(what)


def soft_shafts(design: Design, rng: np.random.Generator) -> tuple[dict[str, Any], str]:
    """Table [assembly.stiffness] of random shafts; empty for every second design."""
    kind = str(rng.choice(["", "", "bearings", "matrix"]))
    if not kind:
        return {}, ""
    module = module_normal(design)
    force = NOMINAL * design.gear.blank.face_width * module
    tables: dict[str, Any] = {}
    for member in ("pinion", "gear"):
        blank = getattr(design, member).blank
        cone = blank.mean_cone_distance
        at, rate = cone * float(np.cos(blank.pitch_angle)), force / (module * 10.0 ** rng.uniform(-4.0, -2.3))
        if kind == "matrix":
            size = np.sqrt(rate) * np.array([1.0, 1.0, 1.0, cone, cone, cone])
            skew = rng.uniform(-1.0, 1.0, (6, 6))
            body = np.eye(6) + 0.15 * (skew + skew.T) / 2.0
            tables[member] = {"reference_point": at, "matrix": (body * np.outer(size, size)).tolist()}
        else:
            span = cone * rng.uniform(0.3, 1.0)
            first = at + (1.0 if rng.integers(2) else -0.4) * span
            tables[member] = {
                "reference_point": at,
                "shaft_diameter": float(0.8 * cone * np.sin(blank.pitch_angle) * rng.uniform(0.7, 1.3)),
                "bearings": [
                    {"position": float(first), "radial": rate, "axial": 0.5 * rate},
                    {"position": float(first + span), "radial": rate * rng.uniform(0.5, 2.0)},
                ],
            }
    if rng.uniform() < 0.3:
        del tables[str(rng.choice(["pinion", "gear"]))]
    return tables, kind + " " + " ".join(tables)


def mirrored_shafts(tables: dict[str, Any]) -> dict[str, Any]:
    """In the mirror image y turns round, and the rotations about x and z."""
    turn = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    image = {}
    for member, given in tables.items():
        image[member] = dict(given)
        if "matrix" in given:
            image[member]["matrix"] = (np.array(given["matrix"]) * np.outer(turn, turn)).tolist()
    return image


def on_shafts(design: Design, tables: dict[str, Any]) -> Design:
    """The design with [assembly.stiffness]."""
    if not tables:
        return design
    stiffness = validate(StiffnessInput, tables, "assembly.stiffness")
    return design.model_copy(update={"assembly": design.assembly.model_copy(update={"stiffness": stiffness})})


def force_vectors(loaded: LoadedMesh, result: Any) -> Iterator[tuple[float, float, float]]:
    """Torques about both axes and loss over the pinion speed at each position, from vectors point by point.

    Velocities are omega x r of both members; friction on each acts against its sliding over the other.
    """
    axes, blanks = loaded.grids.mesh.axes, loaded.mesh.design
    assert axes is not None
    teeth = blanks.pinion.blank.teeth / blanks.gear.blank.teeth
    spin = 1.0 if result.driver == "pinion" else -1.0
    every = [np.zeros(p.force.size) for p in result.load.positions]
    for k, i, mu in zip(result.load.loaded_position, result.load.loaded_index, result.friction.mu, strict=True):
        every[k][i] = mu
    for load, mu in zip(result.load.positions, every, strict=True):
        p = load.position
        arms = [p.position - axis.origin for axis in axes]
        turns = [np.cross(axis.direction, arm) for axis, arm in zip(axes, arms, strict=True)]
        ahead = [np.sign(np.mean(np.sum(turn * p.normal, axis=1))) for turn in turns]
        slip = spin * (turns[0] - ahead[0] * ahead[1] * teeth * turns[1])
        slip -= np.sum(slip * p.normal, axis=1)[:, None] * p.normal
        size = np.linalg.norm(slip, axis=1)[:, None]
        on_gear = load.force[:, None] * (p.normal * ahead[0] + mu[:, None] * slip / np.where(size > 0.0, size, 1.0))
        about = [float(np.sum(np.cross(arm, on_gear) @ axis.direction)) for axis, arm in zip(axes, arms, strict=True)]
        yield abs(about[0]), abs(about[1]) * teeth, float(np.sum(mu * load.force * size[:, 0]))


def check_energy(loaded: LoadedMesh, result: Any) -> float:
    """Greatest error of shaft torque and energy, over the pinion torque."""
    worst = 0.0
    for k, (pinion, gear, loss) in enumerate(force_vectors(loaded, result)):
        ends = (pinion, gear) if result.driver == "pinion" else (gear, pinion)
        stated = result.power_loss_positions[k] / result.speed
        worst = max(worst, abs(pinion - loaded.torque), abs(ends[0] - ends[1] - loss), abs(loss - stated))
    power = result.power_input - result.power_output - result.power_loss
    return float(max(worst, abs(power) / result.speed) / loaded.torque)


def check_load(loaded: LoadedMesh) -> dict[str, Any]:
    """Load distribution and deflection."""
    row: dict[str, Any] = {}
    for part in (loaded.grids.fine, loaded.grids.coarse):
        if part.status == "failed":
            raise ConvergenceError(part.reason, "load")
        arrays = [getattr(p, name) for p in part.positions for name in ("force", "pressure_max", "half_width")]
        require(all(np.isfinite(array).all() for array in [*arrays, part.transmission_error]), "load not finite")
        require(all((p.force >= 0.0).all() for p in part.positions), "a negative force")
        row["residual"] = max(part.torque_residual, part.compatibility_residual, row.get("residual", 0.0))
    require(row["residual"] < RESIDUAL, "residual above 1e-10")
    design, moved = loaded.mesh.design, loaded.grids.mesh.deflection
    stiffness = design.assembly.stiffness
    require((moved is not None) == stiffness.given, "deflection missing, or without shafts")
    if moved is not None:
        placed, start = design.placement(), design.assembly.misalignment
        # the frame turns with the axes: it settles at the forces of the result
        again = DisplacedAxes(placed.E, placed.P, placed.G, placed.shaft_angle_error, np.eye(3), np.zeros(3))
        for _ in range(5):
            again = axes_under_load(placed, stiffness.compliances(), loaded.grids.coarse, again)
        found = {"E": design.mirror * again.E, "P": again.P, "G": again.G, "shaft_angle_error": again.shaft_angle_error}
        off = [abs(found[name] - getattr(start, name) - getattr(moved, name)) for name in found]
        row |= {
            "deflection_um": 1e6 * max(abs(moved.E), abs(moved.P), abs(moved.G)),
            "deflection_rounds": moved.rounds,
            "deflection_residual_um": 1e6 * max(off[:3]),
        }
        # the tolerances of the rounds, and a tenth of them for the frame of the last round, which lags by one
        require(max(off[:3]) < 1.1e-7 and off[3] < 1.1e-6, "the deflection does not return itself")
    return row


def check_result(loaded: LoadedMesh, result: Any) -> dict[str, Any]:
    """Status, numbers and energy of an answer; refusals that hold are raised as such."""
    limit = hardness(loaded.grids.mesh.teeth)
    if result.status != "converged":
        above = result.reason == "pressure_above_hardness"
        require(math.isnan(result.efficiency), "failed with an efficiency")
        require(not above or result.pressure_max > limit, "refused below the hardness")
        raise ConvergenceError(result.reason, "result")
    require(result.pressure_max <= limit, "answered above the hardness")
    optional = {"transmission_error_unloaded"}
    broken = [
        name
        for name, value in result.scalars().items()
        if isinstance(value, float) and not math.isfinite(value) and name not in optional
    ]
    require(not broken, "not finite: " + " ".join(broken))
    require(0.0 < result.efficiency_with_rolling < result.efficiency < 1.0, "efficiency not between 0 and 1")
    require(0.0 <= result.edge_load_share <= 1.0, "share of the edges")
    energy = check_energy(loaded, result)
    require(energy < 1e-10, f"energy off by {energy:.2g}")
    return {"energy": energy, "pressure_GPa": result.pressure_max / 1e9, "edge_share": result.edge_load_share}


def run_case(seed: int, index: int, design: Design) -> dict[str, Any]:
    """One design under one torque, both members driving."""
    rng, more = (np.random.default_rng([seed, index, k]) for k in (1, 3))
    module, pinion = module_normal(design), design.pinion.blank
    radius = pinion.mean_cone_distance * float(np.sin(pinion.pitch_angle))
    factor = float(10.0 ** rng.uniform(-1.0, 1.0))
    torque = NOMINAL * design.gear.blank.face_width * module * radius * factor
    most = min(0.5e-3, 0.125 * module)
    placed = dict(zip("EPG", rng.uniform(-most, most, 3).tolist(), strict=True))
    tables, shafts = soft_shafts(design, more)
    friction = str(more.choice(FRICTIONS))
    if friction == "constant":
        friction = f"constant:{more.uniform(0.02, 0.12):.3f}"
    speed, temperature = 0.5 * 60.0 ** more.uniform() / radius, 273.15 + more.uniform(30.0, 120.0)
    side: Any = "drive" if more.integers(2) else "coast"
    positions, points = 4, int(more.integers(7, 18))
    row: dict[str, Any] = {
        "module_mm": round(1e3 * module, 3), "torque_factor": round(factor, 4), "torque": torque, "side": side,
        "positions": positions, "points": points, "shafts": shafts, "friction": friction, "speed": round(speed, 3),
        "temperature": round(temperature, 2), **{f"{name}_mm": round(1e3 * value, 4) for name, value in placed.items()},
    }  # fmt: skip

    def solved(of: Design, on: dict[str, Any], counts: tuple[int, int]) -> tuple[LoadedMesh, dict[str, Any]]:
        loaded = Mesh.of(on_shafts(of.with_misalignment(**placed), on), side, *counts).load(torque)
        check = check_load(loaded)
        return loaded, check | {
            driver: loaded.efficiency(friction, speed=speed, temperature=temperature, driver=driver)
            for driver in ("pinion", "gear")
        }

    start = process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            loaded, found = solved(design, tables, (positions, points))
            results = {driver: found.pop(driver) for driver in ("pinion", "gear")}
            row |= found
            for driver, result in results.items():
                checked = check_result(loaded, result)
                row |= checked | {"energy": max(checked["energy"], row.get("energy", 0.0))}
                row[f"efficiency_{driver}"] = result.efficiency
            one = results["pinion"]
            row["error"] = one.efficiency_error
            if index % MIRROR == 0:
                image, _ = other_hand(seed, index)
                _, other = solved(image, mirrored_shafts(tables), (positions, points))
                two = other["pinion"]
                row["mirror"] = max(
                    abs((1.0 - two.efficiency) / (1.0 - one.efficiency) - 1.0),
                    abs(two.pressure_max / one.pressure_max - 1.0),
                    abs(other.get("deflection_um", 0.0) - row.get("deflection_um", 0.0)),
                )
                require(row["mirror"] < 1e-4, "the mirror image differs")
            if index % REFINED == 0:
                _, finer = solved(design, tables, (2 * positions, 2 * points))
                change = abs(finer["pinion"].efficiency - one.efficiency)
                row["refined"] = change / (one.efficiency_error + finer["pinion"].efficiency_error)
        row |= {"outcome": "answered", "reason": ""}
    except ConvergenceError as error:
        row |= refused(error.reason, str(error))
    except InputError as error:
        row |= refused(error.field, str(error))
    except Wrong as error:
        row |= {"outcome": "wrong", "reason": "invariant", "detail": str(error)}
    except Exception as error:
        row |= {"outcome": "wrong", "reason": type(error).__name__, "detail": str(error)}
    return {**row, "seconds": round(process_time() - start, 3)}


def refused(reason: str, detail: str) -> dict[str, Any]:
    """Row of a case without an answer."""
    return {"outcome": "refused" if reason in REFUSED else "wrong", "reason": reason, "detail": detail}


def relieved(seed: int, index: int, design: Design) -> tuple[Design, str]:
    """With its random relief."""
    return with_relief(design, np.random.default_rng([seed, index, 2]))


def other_hand(seed: int, index: int) -> tuple[Design, str]:
    """The mirror image, built from its own blank."""
    content = blank_content(seed, index)
    hand = {"left": "right", "right": "left"}[content["hand_pinion"]]
    gear = "formate" if formate(content, index) else "generated"
    return relieved(seed, index, design_of(content | {"hand_pinion": hand}, gear))


def summary(path: Path) -> list[tuple[str, str]]:
    """Lines of the report."""
    lines = lines_of(path)
    designs = [line for line in lines if line["outcome"] != "no design"]
    good = [line for line in designs if line["outcome"] == "answered"]
    out = [("designs", str(len(designs))), ("blanks without a design", str(len(lines) - len(designs)))]
    for outcome, count in Counter(line["outcome"] for line in designs).most_common():
        out.append((outcome, f"{count} ({count / len(designs):.1%})"))
    for reason, count in Counter(line["reason"] for line in designs if line["reason"]).most_common():
        out.append((f"reason {reason}", f"{count}, {REFUSED.get(reason, 'not listed')}"))
    for name in ("bearings", "matrix"):
        out.append((f"answered on {name}", str(sum(line["shafts"].startswith(name) for line in good))))
    for name, text in (
        ("residual", "worst residual of torque and compatibility"),
        ("energy", "worst energy, input less output less loss, over the input"),
        ("deflection_um", "largest deflection, um"),
        ("deflection_residual_um", "worst deflection that does not return itself, um"),
        ("mirror", "worst difference of a mirror image"),
        ("seconds", "most CPU seconds"),
    ):
        values = [float(line[name]) for line in good if line[name]]
        out.append((text, f"{max(values, default=math.nan):.3g} of {len(values)}"))
    worse = [float(line["efficiency_gear"]) < float(line["efficiency_pinion"]) for line in good]
    out.append(("back-driving worse than driving", f"{sum(worse)} of {len(worse)}"))
    better = [
        (float(line["efficiency_gear"]) - float(line["efficiency_pinion"])) / float(line["error"])
        for line in good
        if float(line["efficiency_gear"]) >= float(line["efficiency_pinion"])
    ]
    out.append(("better by at most, over the stated error", f"{max(better, default=math.nan):.2f} of {len(better)}"))
    refined = np.array([float(line["refined"]) for line in good if line["refined"]])
    out.append(("refined within the stated errors", f"{np.count_nonzero(refined <= 1.0)} of {refined.size}"))
    if refined.size:
        out.append(("change of refinement over the stated errors, median, most",
                    f"{np.median(refined):.2f}, {refined.max():.2f}"))  # fmt: skip
    return out


def main(argv: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = command_line(__doc__)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=6)
    parser.add_argument("--output", type=Path, default=OUT)
    parser.add_argument("--report", action="store_true")
    arguments = parser.parse_args(argv)
    if not arguments.report:
        arguments.output.parent.mkdir(parents=True, exist_ok=True)
        known = lines_of(arguments.output)
        have = sum(line["outcome"] != "no design" for line in known)
        index = 1 + max((int(line["index"]) for line in known), default=-1)
        with arguments.output.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, COLUMNS, restval="")
            if not known:
                writer.writeheader()
            for k in range(index, 100 * arguments.count):
                if have >= arguments.count:
                    break
                design, about = random_design(arguments.seed, k)
                row = {"seed": arguments.seed, "index": k, **about, "outcome": "no design"}
                if design is not None:
                    design, row["relief"] = relieved(arguments.seed, k, design)
                    row |= run_case(arguments.seed, k, design)
                    have += 1
                writer.writerow(row)
                file.flush()
    table = summary(arguments.output)
    width = max(len(name) for name, _ in table)
    print("\n".join(f"{name:{width}s}  {value}" for name, value in table))


if __name__ == "__main__":
    main()
