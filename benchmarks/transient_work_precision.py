"""Error of the mean friction against CPU time for the transient solver, from full film to boundary.

Every case rolls the same roughness over the same window on each mesh, so that the difference to the finest one is the
error of mesh and time step, without statistics.  Writes a table (CSV) and a plot; prints the table and the slope of
the cost over the number of nodes.

    python benchmarks/transient_work_precision.py --out results --meshes 128 256 512 --reference 1024
"""

from __future__ import annotations

import argparse
import csv
import math
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from ehl.contact import LineContact
from ehl.lubricant import Lubricant
from ehl.material import load_material
from ehl.roughness import generate_profile
from ehl.transient import RoughSurfaces
from ehl.transient._kernels.march import ITERATIONS, MU_FLUID, SHARE, STAGE
from ehl.transient._kernels.newton import LAGGED
from ehl.transient.accuracy import FRONT_STARTUP
from ehl.transient.run import Run
from ehl.transient.scaling import Settings, build_problem

# entrainment speed [m/s], Rq of each surface [m], correlation length [m], boundary film [m]
CASES = {
    "full film": (20.0, 0.1e-6, 30e-6, 20e-9),
    "thin film": (5.0, 0.2e-6, 30e-6, 20e-9),
    "mixed 1": (1.5, 0.2e-6, 30e-6, 20e-9),
    "mixed 2": (0.5, 0.3e-6, 30e-6, 20e-9),
    "near boundary": (0.1, 0.4e-6, 30e-6, 30e-9),
}


def build(speed: float, rms: float, lc: float, film: float, nodes: int, peklenik: float) -> tuple[Run, float]:
    """A run of the case and its film ratio."""
    contact = LineContact.from_pressure(
        radius_equivalent=0.015,
        effective_modulus=228e9,
        pressure_hertz=1e9,
        speed_entrainment=speed,
        slide_to_roll=0.5,
    )
    oil = Lubricant(0.015, 15e-9, rheology="eyring", eyring_stress=5e6)
    period = 32.0 * contact.half_width
    surfaces = RoughSurfaces(*(generate_profile(rms, lc, period, lc / 12.0, seed) for seed in (1, 2)))
    steel = load_material("steel")
    problem = build_problem(contact, oil, surfaces, (steel, steel), Settings(nodes, film, 0.1, peklenik, False, 8e9))
    return Run(problem), problem.film_estimate / surfaces.rms


def measure(run: Run, window: float) -> tuple[float, float, float, int, float]:
    """mu, CPU seconds, iterations per step, lagged steps and CPU microseconds per iteration and node."""
    per_width = run.problem.units.steps_per_half_width
    begin = time.process_time()
    first = run.advance(round(FRONT_STARTUP * per_width))[0]
    records = run.advance(round(window * per_width))[0]
    seconds = time.process_time() - begin
    steps = np.concatenate([first, records])
    mu = float((records[:, MU_FLUID] + 0.1 * records[:, SHARE]).mean())
    work = steps[:, ITERATIONS].sum() * run.problem.x.size
    lagged = int(np.count_nonzero(steps[:, STAGE] >= LAGGED))
    return mu, seconds, float(steps[:, ITERATIONS].mean()), lagged, 1e6 * seconds / work


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("benchmark_results"))
    parser.add_argument("--meshes", type=int, nargs="+", default=[128, 256, 512])
    parser.add_argument("--reference", type=int, default=1024)
    parser.add_argument("--window", type=float, default=8.0, help="travel averaged over [half-widths]")
    parser.add_argument("--peklenik", type=float, default=math.inf)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    rows: list[dict[str, object]] = []
    figure, axes = plt.subplots(figsize=(6.0, 4.2), layout="constrained")
    for name, case in CASES.items():
        measure(build(*case, 64, options.peklenik)[0], 0.1)  # compiled before anything is timed
        found = []
        for nodes in (*options.meshes, options.reference):
            run, ratio = build(*case, nodes, options.peklenik)
            mu, seconds, iterations, lagged, unit = measure(run, options.window)
            found.append((run.problem.x.size, mu, seconds))
            rows.append(
                {
                    "case": name,
                    "film_ratio": round(ratio, 4),
                    "nodes": run.problem.x.size,
                    "friction_coefficient": f"{mu:.6f}",
                    "cpu_seconds": f"{seconds:.3f}",
                    "iterations_per_step": f"{iterations:.2f}",
                    "lagged_steps": lagged,
                    "cpu_us_per_iteration_and_node": f"{unit:.4f}",
                }
            )
        exact = found[-1][1]
        errors = [abs(mu / exact - 1.0) for _, mu, _ in found[:-1]]
        for row, error in zip(rows[-len(found) :], [*errors, 0.0], strict=True):
            row["error"] = f"{error:.2e}"
            print("  ".join(f"{value!s:>13}" for value in row.values()), flush=True)
        axes.loglog([s for _, _, s in found[:-1]], errors, "o-", label=f"{name} ($\\lambda$ = {ratio:.2g})")
    nodes_all = np.log([float(str(r["nodes"])) for r in rows])
    unit_all = np.log([float(str(r["cpu_us_per_iteration_and_node"])) for r in rows])
    print(f"cost per iteration ~ nodes^{1.0 + float(np.polyfit(nodes_all, unit_all, 1)[0]):.2f}")
    with (options.out / "transient_work_precision.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    axes.set_xlabel("CPU time [s]")
    axes.set_ylabel(f"error of $\\mu$ against {options.reference} nodes")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()
    figure.savefig(options.out / "transient_work_precision.png", dpi=150)


if __name__ == "__main__":
    main()
