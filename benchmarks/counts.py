"""Ten counts of work that any machine repeats: iterations, steps and calls of fixed tasks, against their baseline.

``python benchmarks/counts.py`` prints the table and ends with 1 if a count lies outside its tolerance;
``--write`` makes the counts of this run the baseline, counts.json. Seconds on a shared machine scatter by tens of per
cent; these do not scatter at all. A count far below its baseline fails too and requires a new baseline. Calls are those
of the program's own Python functions, compiled kernels and libraries left out.
"""

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
from scipy.stats import qmc

import efficiency
import ehl
import regression
from efficiency.design.design import load_design
from efficiency.ltca.mesh_grids import load_grids
from efficiency.machine_settings import solve
from efficiency.machine_settings.solve import machine_settings
from efficiency.mesh import Mesh
from ehl.fluid.lubricant import Lubricant
from ehl.line_contact import LineContact
from ehl.rough import RoughSurfaces, solve_transient
from ehl.smooth.solver import solve_steady
from ehl.surface.roughness import generate_profile
from regression.data.dataset import load_dataset
from regression.fitting.coefficients import fit_coefficients
from regression.fitting.rows import usable_rows
from regression.formula import friction_model
from regression.friction.families import FAMILIES

BASELINE = Path(__file__).with_name("counts.json")
TOLERANCE = 0.1  # of the baseline: other versions of the libraries may take another iteration here and there
OWN = tuple(str(Path(package.__file__).parent) for package in (ehl, regression, efficiency))
DESIGN = "fm_spiral_bevel_14x39"
SMOOTH = 4


@dataclass(frozen=True)
class Count:
    """One count and its baseline."""

    name: str
    value: int
    baseline: int | None

    @property
    def within(self) -> bool:
        """Whether it lies within the tolerance of the baseline."""
        return self.baseline is not None and abs(self.value - self.baseline) <= TOLERANCE * self.baseline


def calls(task: Callable[[], Any]) -> int:
    """Calls of the program's own functions in a task; comprehensions left out, newer Pythons inline them."""
    number = 0

    def count(frame: FrameType, event: str, argument: object) -> None:
        nonlocal number
        code = frame.f_code
        number += event == "call" and code.co_filename.startswith(OWN) and not code.co_name.startswith("<")

    task()  # caches are filled, modules imported
    sys.setprofile(count)
    try:
        task()
    finally:
        sys.setprofile(None)
    return number


def smooth_contacts() -> list[tuple[LineContact, Lubricant]]:
    """Contacts of the gear range: p_h [Pa], R [m], u_r [m/s], eta0 [Pa s], alpha [1/Pa], tau0 [Pa], slide-to-roll."""
    low = np.array([0.3e9, 0.005, 0.2, 0.003, 10e-9, 3e6, 0.01])
    high = np.array([2.5e9, 0.08, 20.0, 0.15, 25e-9, 10e6, 1.5])
    found = []
    for share in qmc.Sobol(low.size, rng=3).random(SMOOTH):
        values = low * (high / low) ** share
        values[4] = low[4] + (high - low)[4] * share[4]
        p_h, radius, speed, viscosity, alpha, stress, slip = (float(value) for value in values)
        line = LineContact.from_pressure(
            radius_equivalent=radius,
            effective_modulus=2.264e11,
            pressure_hertz=p_h,
            speed_entrainment=speed,
            slide_to_roll=slip,
        )
        found.append((line, Lubricant(viscosity, alpha, "roelands", rheology="eyring", eyring_stress=stress)))
    return found


def rough() -> tuple[int, int, float]:
    """Nodes, steps and Newton iterations a step of a small rough contact."""
    line = LineContact.from_pressure(
        radius_equivalent=15e-3,
        effective_modulus=2.264e11,
        pressure_hertz=1e9,
        speed_entrainment=5.0,
        slide_to_roll=0.2,
    )
    oil = Lubricant(0.015, 15e-9, rheology="eyring", eyring_stress=5e6)
    profile = generate_profile(3e-7, 2e-5, 16.0 * line.half_width, 2e-6, 1)
    run = solve_transient(
        line, oil, RoughSurfaces(profile), nodes=160, travel=2.0, accuracy="reference", boundary_study=False
    )
    return run.nodes, run.steps, run.iterations_per_step


def measure() -> dict[str, int]:
    """All counts, by their name."""
    smooth = [solve_steady(*contact) for contact in smooth_contacts()]
    nodes, steps, iterations = rough()
    mesh = Mesh.of(load_design(DESIGN), "drive", 4, 9)
    loads = [load_grids(mesh.grids, torque).fine for torque in (30.0, 200.0, 600.0)]
    balances = [position.equilibrium for load in loads for position in load.positions]
    loaded = mesh.load("200 N m")
    frame, _ = usable_rows(load_dataset("gear_fva3"), corners=False)
    formula = friction_model("fva3")
    return {
        f"Newton iterations of {SMOOTH} smooth contacts": sum(result.iterations for result in smooth),
        f"nodes of {SMOOTH} smooth contacts": sum(result.nodes for result in smooth),
        "time steps of a rough contact": steps,
        "steps times nodes of a rough contact": steps * nodes,
        "Newton iterations of a rough contact": round(steps * iterations),
        "calls of the unloaded contact of a pair": calls(lambda: Mesh.of(load_design(DESIGN), "drive", 4, 9).grids),
        "Newton iterations of three loaded meshes": sum(balance.iterations for balance in balances),
        "calls of an efficiency by formula": calls(lambda: loaded.efficiency(formula, speed="1500 rpm")),
        "calls of machine settings": calls(_settings_anew),
        "calls of a formula's fit": calls(lambda: fit_coefficients(FAMILIES["short"], frame, 0.11)),
    }


def _settings_anew() -> object:
    solve._start.cache_clear()
    solve._fit_flanks.cache_clear()
    return machine_settings("fh_hypoid_9x34_offset_10", transmission=False)


def compared() -> list[Count]:
    """All counts beside their baseline."""
    baseline = json.loads(BASELINE.read_text(encoding="utf-8")) if BASELINE.exists() else {}
    return [Count(name, value, baseline.get(name)) for name, value in measure().items()]


def main() -> int:
    """Count, compare and print; ``--write`` makes these counts the baseline."""
    counts = compared()
    if "--write" in sys.argv:
        numbers = {count.name: count.value for count in counts}
        BASELINE.write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")
    for count in counts:
        print(f"{count.name:45} {count.value:9} baseline {count.baseline} {'' if count.within else 'OUTSIDE'}")
    return int(not all(count.within for count in counts))


if __name__ == "__main__":
    sys.exit(main())
