"""Error of friction and film against CPU time: the rough engine, the smooth solver, the operators.

    python validation/work_precision.py --out results [--parts engine smooth operators]

Twenty cases from full film to boundary. Each rolls the same roughness over the same window at every setting, so that
the difference to a finer mesh is the error of mesh and time step, without statistics. CPU time of one thread, without
compilation, per half-width of travel. Writes one CSV per part and work_precision.png.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from common import OUT, command_line
from mixed_scenes import Scene, eyring_oil, gaussian_pair, line, speed_of_film_ratio
from scipy.linalg import toeplitz
from smooth_accuracy import single_grids

from ehl.rough import solve_transient
from ehl.rough._kernels.march import FILM_MEAN
from ehl.rough._kernels.quasi_separable import exponential_product
from ehl.rough.accuracy import FRONT_STARTUP, SETTLING
from ehl.rough.averaging import Window
from ehl.rough.dry import DeflectionOperator, uniform_grid
from ehl.rough.exponential_sums import fit_log_kernel, range_of
from ehl.rough.run import TransientRun
from ehl.rough.scaling import ELASTIC_MODES
from ehl.smooth.refine import extrapolate
from ehl.smooth.solver import solve_steady

matplotlib.use("Agg")

RATIOS = (4.0, 2.5, 1.5, 1.0, 0.7, 0.5, 0.3, 0.15, 0.06, 0.02)
# Hertz pressure [Pa], slide-to-roll ratio, correlation length [b]
LINES = {"A": (1.0e9, 0.5, 0.1), "B": (1.5e9, 0.15, 0.2)}
RMS = 0.4e-6
SETTINGS = ("fast", "standard", "reference")
FIXED = (32, 64, 128)  # nodes per b
FINEST, FINEST_THIN = 600, 1000  # nodes per b of the run errors refer to; the latter below a film ratio of 0.4
SHARP = 2e-6  # tolerance of its steps, film units
STARTUP = FRONT_STARTUP + SETTLING


def scenes() -> dict[str, tuple[float, Scene]]:
    """Film ratio and scene of every case."""
    oil, found = eyring_oil(), {}
    for name, (pressure, slip, correlation) in LINES.items():
        for ratio in RATIOS:
            contact = line(speed_of_film_ratio(ratio, RMS, oil, pressure=pressure), slip, pressure)
            found[f"{name} {ratio:g}"] = (ratio, Scene(contact, oil, gaussian_pair(contact, RMS, correlation)))
    return found


def march(scene: Scene, per_width: float, window: float) -> tuple[Window, float]:
    """One run from rest on one mesh, and its CPU seconds."""
    run = Window(scene.run(per_width))
    begin = time.process_time()
    run.start(STARTUP)
    run.roll(window)
    return run, time.process_time() - begin


def take_over(scene: Scene, per_width: float, window: float) -> tuple[Window, float]:
    """A run that starts from the state of a coarse one, as the engine does, and its CPU seconds.

    Its steps are solved ten times as sharply: on so fine a mesh the usual tolerance of a step adds up, to 3 % of a
    thick film and 0.5 % of mu at 600 nodes per b.
    """
    begin = time.process_time()
    coarse = Window(scene.run(FIXED[1]))
    coarse.start(FRONT_STARTUP)
    problem = scene.run(per_width, start_travel=coarse.run.travel).problem
    sharp = problem.model.contact._replace(tolerance=SHARP)
    run = Window(TransientRun(replace(problem, model=problem.model._replace(contact=sharp))))
    run.run.start_from(coarse.run)
    run.start(SETTLING)
    run.roll(window)
    return run, time.process_time() - begin


def averages(run: Window) -> tuple[float, float]:
    """mu and mean film [m] of a window."""
    return float(run.friction().mean()), float(run.records[:, FILM_MEAN].mean()) * run.run.problem.units.film


def engine(cases: dict[str, tuple[float, Scene]], window: float) -> pd.DataFrame:
    """Settings and fixed meshes on every case."""
    rows = []
    travel = STARTUP + window
    march(next(iter(cases.values()))[1], 16, 0.1)  # compiled before anything is timed
    for name, (ratio, scene) in cases.items():
        finest, spent = take_over(scene, FINEST if ratio > 0.4 else FINEST_THIN, window)
        mu, film = averages(finest)
        base = {"case": name, "film_ratio": ratio}
        rows.append(
            base | {"setting": "finest", "nodes": finest.run.problem.x.size, "mu": mu, "film": film, "seconds": spent}
        )
        for per_width in FIXED:
            run, seconds = march(scene, per_width, window)
            found = averages(run)
            row = base | {"setting": f"{per_width} per b", "nodes": run.run.problem.x.size, "seconds": seconds}
            rows.append(row | _errors(found, (mu, film), seconds, travel))
        for setting in SETTINGS:
            begin = time.process_time()
            result = solve_transient(
                scene.contact,
                scene.lubricant,
                scene.surfaces,
                accuracy=setting,
                boundary_film=scene.boundary_film,
                peklenik_number=scene.peklenik_number,
                travel=window,
                boundary_study=False,
            )
            seconds = time.process_time() - begin
            found = (result.friction_coefficient, result.film_mean)
            row = base | {"setting": setting, "nodes": result.nodes, "seconds": seconds}
            row |= {"mesh_error": result.mesh_error}
            row |= {"lagged": result.fallbacks.lagged, "unconverged": result.fallbacks.unconverged}
            rows.append(row | _errors(found, (mu, film), seconds, travel))
        print(f"  {name}", flush=True)
    return pd.DataFrame(rows)


def _errors(found: tuple[float, float], exact: tuple[float, float], seconds: float, travel: float) -> dict[str, float]:
    return {
        "mu": found[0],
        "film": found[1],
        "mu_error": abs(found[0] / exact[0] - 1.0),
        "film_error": abs(found[1] / exact[1] - 1.0),
        "seconds_per_width": seconds / travel,
    }


def smooth(cases: dict[str, tuple[float, Scene]]) -> pd.DataFrame:
    """The steady solver on the smooth contacts of the same cases, against extrapolated finer grids."""
    rows = []
    some = next(iter(cases.values()))[1]
    solve_steady(some.contact, some.lubricant)
    for name, (ratio, scene) in cases.items():
        nodes = solve_steady(scene.contact, scene.lubricant, accuracy="standard").nodes
        counts = tuple((nodes - 1) * k + 1 for k in (1, 2, 4))
        levels = [v for v, _ in single_grids(scene.contact, scene.lubricant, counts)]
        film, _, mu = extrapolate(levels, counts[0]).values
        for setting in SETTINGS:
            begin = time.process_time()
            result = solve_steady(scene.contact, scene.lubricant, accuracy=setting)
            seconds = time.process_time() - begin
            row = {"case": name, "film_ratio": ratio, "setting": setting, "nodes": result.nodes, "seconds": seconds}
            rows.append(row | _errors((result.friction_fluid, result.film_central), (mu, film), seconds, np.nan))
    return pd.DataFrame(rows)


def operators() -> pd.DataFrame:
    """Time and deviation of the elastic operators on a Hertz pressure with Gaussian ripple of 20 %."""
    rows = []
    contact = line(1.0)
    for n in (256, 512, 1024, 2048):
        x = uniform_grid(contact, n)
        dx = float(x[1] - x[0])
        hertz = np.sqrt(np.maximum(1.0 - (x / contact.half_width) ** 2, 0.0))
        q = hertz * (1.0 + 0.2 * np.random.default_rng(1).standard_normal(n))
        fft = DeflectionOperator(n, dx, contact.effective_modulus)
        matrix = toeplitz(fft.coefficients)
        sum_ = fit_log_kernel(range_of(n), ELASTIC_MODES)
        out = np.zeros(n)
        exponential_product(q, sum_.weights, sum_.ratios, out)
        scale = 4.0 * dx * contact.pressure_hertz / (np.pi * contact.effective_modulus)
        dense = matrix @ (q * contact.pressure_hertz)
        exact = dense / scale
        row = {
            "nodes": n,
            "soe_us": _microseconds(lambda: exponential_product(q, sum_.weights, sum_.ratios, out)),  # noqa: B023
            "fft_us": _microseconds(lambda: fft(q)),  # noqa: B023
            "dense_us": _microseconds(lambda: matrix @ q),  # noqa: B023
            # a rigid shift does not count; over the elastic scale b^2/R of the contact
            "soe_deviation_nm": 0.5e9 * float(np.ptp(out - exact)) * scale,
            "fft_deviation_nm": 1e9 * float(np.abs(fft(q * contact.pressure_hertz) - dense).max()),
            "deflection_nm": 1e9 * float(np.ptp(dense)),
        }
        rows.append(row)
    return pd.DataFrame(rows)


def _microseconds(call: Callable[[], object], repeats: int = 9) -> float:
    """Median over turns of the CPU time of one call [us]."""
    turns = []
    for _ in range(repeats):
        begin = time.process_time()
        for _ in range(50):
            call()
        turns.append((time.process_time() - begin) / 50 * 1e6)
    return float(np.median(turns))


def plot(folder: Path) -> None:
    """Everything that was computed, in one log-log figure."""
    figure, axes = plt.subplots(figsize=(6.0, 5.4), layout="constrained")
    path = folder / "engine.csv"
    if path.exists():
        data = pd.read_csv(path)
        data = data[data.setting != "finest"]
        for style, names in (("o-", SETTINGS), ("s--", tuple(f"{n} per b" for n in FIXED))):
            for low, high, colour in ((0.4, 9.0, "C0"), (0.1, 0.4, "C1"), (0.0, 0.1, "C3")):
                part = data[(data.film_ratio > low) & (data.film_ratio <= high) & data.setting.isin(names)]
                middle = part.groupby("setting", sort=False)[["seconds_per_width", "mu_error"]].median()
                what = "fast / standard / reference" if style == "o-" else "one mesh, 32 / 64 / 128 per b"
                label = f"{what}, λ {low:g} to {high:g}" if high < 9.0 else f"{what}, λ > {low:g}"
                axes.loglog(middle.seconds_per_width, middle.mu_error, style, color=colour, label=label)
                axes.loglog(part.seconds_per_width, part.mu_error, style[0], color=colour, ms=2.5, alpha=0.4)
        axes.set(title="rough contact: 20 cases (small) and medians")
    axes.set(xlabel="processor time per half-width of travel [s]", ylabel="relative error of μ [-]")
    axes.grid(True, which="both", alpha=0.25)
    if axes.get_lines():
        axes.legend(fontsize=7, ncol=2, loc="upper center", bbox_to_anchor=(0.5, -0.13))
    figure.savefig(folder / "work_precision.png", dpi=140)
    plt.close(figure)


def summary(data: pd.DataFrame) -> str:
    """Medians and largest errors by setting and lubrication regime."""
    regime = pd.cut(data.film_ratio, [0.0, 0.1, 0.4, 9.0], labels=["boundary", "mixed", "film"])
    group = data.groupby([regime, "setting"], sort=False, observed=True)
    table = group.agg(
        cases=("mu_error", "size"),
        mu_median=("mu_error", "median"),
        mu_max=("mu_error", "max"),
        film_median=("film_error", "median"),
        film_max=("film_error", "max"),
        seconds=("seconds", "median"),
    )
    return str(table.to_string(float_format=lambda v: f"{v:.2e}"))


def main(argv: Sequence[str] | None = None) -> None:
    """Run the parts from the command line."""
    parser = command_line(__doc__)
    parts = ["operators", "smooth", "engine"]
    parser.add_argument("--parts", nargs="+", choices=parts, default=parts)
    parser.add_argument("--window", type=float, default=4.0, help="travel averaged over [b]")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args(argv)
    folder: Path = options.out
    folder.mkdir(parents=True, exist_ok=True)
    cases = scenes()
    for part in options.parts:
        data = {
            "operators": operators,
            "smooth": lambda: smooth(cases),
            "engine": lambda: engine(cases, options.window),
        }[part]()
        data.to_csv(folder / f"{part}.csv", index=False)
        if part in ("smooth", "engine"):
            print(summary(data[data.setting != "finest"]), flush=True)
        else:
            print(data.to_string(index=False, float_format=lambda v: f"{v:.4g}"), flush=True)
    plot(folder)


if __name__ == "__main__":
    main()
