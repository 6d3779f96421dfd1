"""Parts of the transient engine against each other: elastic kernels, step tolerance, shear laws, ends of the mesh.

    python validation/mixed_engine.py STUDY --out validation/out

Variants take turns over the same travel of the same surfaces, so that ratios of time are of one run. Each study prints
its table and writes CSV; one core, two to five minutes.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from unittest import mock

import numpy as np
from common import OUT, command_line
from mixed_scenes import (
    RADIUS,
    STEEL,
    Scene,
    eyring_oil,
    friction,
    gaussian_pair,
    line,
    print_table,
    speed_of_film_ratio,
    startup_of,
    write_csv,
)
from scipy.optimize import brentq

from ehl.fluid.density import Tait, TaitCompression
from ehl.fluid.free_volume import Doolittle, McEwenPaluch
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.fluid.rheology import RisingStress
from ehl.fluid.yasutomi import ImprovedYasutomi, OriginalYasutomi
from ehl.rough._kernels.march import FILM_MEAN, ITERATIONS, STAGE
from ehl.rough._kernels.newton import PLAIN
from ehl.rough.run import TransientRun
from ehl.rough.scaling import build_problem, solved_length

RMS = 0.4e-6
WINDOW = 4.0
TURNS = 8
# of the study of the ends: composite roughness [m] and film ratios on the test line, and film ratios of a rougher one
ROUGHNESSES = (0.2e-6, 0.4e-6, 0.6e-6, 0.8e-6)
ENDED_RATIOS, SOFT_RATIOS = (0.03, 0.1, 0.3, 1.0, 3.0), (0.1, 0.3, 1.0)


def changed(scene: Scene, mesh: float, **settings: object) -> TransientRun:
    """A run with other settings."""
    usual = scene.run(mesh).problem.settings
    return TransientRun(
        build_problem(
            scene.contact, scene.lubricant, scene.surfaces, (STEEL, STEEL), replace(usual, **settings)  # type: ignore[arg-type]
        )
    )  # fmt: skip


def in_turns(runs: Mapping[str, TransientRun], startup: float) -> dict[str, tuple[float, float, float, float]]:
    """mu, mean film [m], iterations and us per step of runs that roll the same way in turns."""
    records: dict[str, list[np.ndarray]] = {name: [] for name in runs}
    times: dict[str, list[float]] = {name: [] for name in runs}
    for run in runs.values():
        run.advance(round(startup * run.problem.units.steps_per_half_width))
    for _ in range(TURNS):
        for name, run in runs.items():
            steps = round(WINDOW / TURNS * run.problem.units.steps_per_half_width)
            begun = time.process_time()
            records[name].append(run.advance(steps)[0])
            times[name].append((time.process_time() - begun) / steps)
    found = {}
    for name, run in runs.items():
        every = np.concatenate(records[name])
        film = float(every[:, FILM_MEAN].mean()) * run.problem.units.film
        found[name] = float(friction(every).mean()), film, float(every[:, ITERATIONS].mean()), np.median(times[name])
    return found


def tolerance(out: Path) -> None:
    """The step tolerance on coarse and very fine meshes."""
    oil = eyring_oil()
    columns = ("lambda", "nodes per b", "tolerance", "mu", "film [nm]", "iterations", "us per step")
    rows = []
    for ratio in (4.0, 1.5, 0.3):
        contact = line(speed_of_film_ratio(ratio, RMS, oil))
        scene = Scene(contact, oil, gaussian_pair(contact, RMS, 0.15))
        for mesh in (64.0, 128.0, 300.0, 600.0):
            runs = {f"{value:g}": changed(scene, mesh, tolerance=value) for value in (1e-4, 2e-5, 2e-6)}
            for name, (mu, film, iterations, seconds) in in_turns(runs, 3.4).items():
                rows.append((ratio, mesh, name, mu, 1e9 * film, iterations, 1e6 * seconds))
    print_table("step tolerance", columns, rows)
    write_csv(out / "mixed_tolerance.csv", columns, rows)


def laws(out: Path) -> None:
    """What the shear laws cost, and what they make of one rough contact; the coefficients are round numbers."""
    plain = eyring_oil()
    carreau = {"rheology": "carreau", "carreau_stress": 5e6, "carreau_exponent": 0.5}
    smooth = {"limiting_shear": "smooth", "limiting_shear_coefficient": 0.06, "limiting_shear_ambient": 2e6}
    oils = {
        "eyring": plain,
        "newtonian": replace(plain, rheology="newtonian"),
        "eyring, tau0(p)": replace(
            plain,
            eyring_stress=RisingStress(stress_low=5e6, stress_slope=0.035, pressure_start=0.5e9, pressure_end=3.5e9),
        ),
        "carreau": replace(plain, **carreau),  # type: ignore[arg-type]
        "eyring, smooth limit": replace(plain, **smooth),  # type: ignore[arg-type]
        "carreau, smooth limit": replace(plain, **carreau, **smooth),  # type: ignore[arg-type]
    }
    columns = ("lambda", "heat", "law", "mu", "film [nm]", "iterations", "time over eyring")
    rows = []
    for ratio in (1.5, 0.3):
        contact = line(speed_of_film_ratio(ratio, RMS, plain))
        scene = Scene(contact, plain, gaussian_pair(contact, RMS, 0.15))
        for thermal in (False, True):
            runs = {name: scene.with_(lubricant=oil, thermal=thermal).run(100.0) for name, oil in oils.items()}
            found = in_turns(runs, 5.0)
            for name, (mu, film, iterations, seconds) in found.items():
                rows.append((ratio, thermal, name, mu, 1e9 * film, iterations, seconds / found["eyring"][3]))
    print_table("shear laws", columns, rows)
    write_csv(out / "mixed_laws.csv", columns, rows)


def by_law(law: str, **changes: object) -> Lubricant:
    """An Eyring oil of 90 degC with its viscosity by a law; constants of published oils."""
    absolute: dict[str, object] = {
        "yasutomi_improved": ImprovedYasutomi(
            viscosity_glass=1e12, Tg0=201.45, A1=210.6, A2=0.455e-9, b1=7.606e-9, b2=-0.4193, C1=16.372, C2=29.99
        ),
        "yasutomi_original": OriginalYasutomi(
            viscosity_glass=1e12, Tg0=244.95, A1=134.2, A2=1.929e-9, B1=4.815, B2=0.160e-9, C1=16.01, C2=20.69
        ),
        "doolittle": Doolittle(
            viscosity_reference=15.6e-3,
            temperature_reference=313.15,
            B=4.710,
            R0=0.6568,
            epsilon=-9.599e-4,
            volume_expansion=8.36e-4,
            state=Tait(K00=8.658e9, betaK=6.33e-3, K0_rate=11.74),
        ),
        "mcewen_paluch": McEwenPaluch(
            K=6e-5, B=900.0, C=95.0, a0=20e-9, a0_fall=5e-3, q=3.0, CF=6.0, pinf=2.5e9, pinf_rise=8e6
        ),
    }
    if law == "modulus":
        return replace(Oil.load("fva3").at(363.15), rheology="eyring", **changes)  # type: ignore[arg-type]
    plain = eyring_oil(0.02, temperature=363.15, temperature_viscosity=0.035)
    if law in absolute:
        density = {"compression": TaitCompression(1e9, 11.0)}
        return replace(plain, viscosity_law=law, absolute_law=absolute[law], **density, **changes)  # type: ignore[arg-type]
    return replace(plain, viscosity_law=law, **changes)  # type: ignore[arg-type]


VISCOSITY_LAWS = ("barus", "modulus", "yasutomi_improved", "yasutomi_original", "doolittle", "mcewen_paluch")


def as_stiff(oil: Lubricant, pressure: float) -> Lubricant:
    """The Roelands oil with the same viscosity at ambient pressure and at `pressure` [Pa]."""
    plain = replace(oil, viscosity_law="roelands", absolute_law=None, modulus_constants=())
    wanted = float(oil.log_viscosity_ratio(pressure))
    alpha = brentq(
        lambda a: float(replace(plain, pressure_viscosity=a).log_viscosity_ratio(pressure)) - wanted, 1e-9, 1e-7
    )
    return replace(plain, pressure_viscosity=alpha)


def viscosity(out: Path) -> None:
    """What the viscosity laws cost: a step and an iteration against an equally stiff Roelands oil, in turns."""
    columns = ("lambda", "gamma", "heat", "law", "mu", "mu roelands", "iterations a step", "of roelands",
               "step / roelands", "iteration / roelands")  # fmt: skip
    rows = []
    for ratio, gamma, heat in ((1.0, math.inf, False), (0.3, 1.0, False), (1.0, math.inf, True), (0.3, 1.0, True)):
        for law in VISCOSITY_LAWS:
            oil = by_law(law)
            runs = {}
            for name, own in (("roelands", as_stiff(oil, 0.25e9 * math.pi)), (law, oil)):
                contact = line(speed_of_film_ratio(ratio, RMS, own))
                runs[name] = Scene(contact, own, gaussian_pair(contact, RMS, 0.15), 30e-9, gamma, heat).run(80.0)
            found = in_turns(runs, 2.9)
            (mu_0, _, count, seconds), (mu, _, iterations, own_seconds) = found["roelands"], found[law]
            step = own_seconds / seconds
            each = step * count / iterations
            rows.append((ratio, gamma, "on" if heat else "off", law, mu, mu_0, iterations, count, step, each))
    print_table("viscosity laws", columns, rows)
    write_csv(out / "mixed_viscosity_laws.csv", columns, rows)


@dataclass(frozen=True)
class Ended:
    """One run whose mesh ends where asperities no longer touch, or where that of a smooth contact does."""

    mu: float
    film: float
    edge_pressure: float  # largest mean pressure of the last three nodes, over p_h
    reach: float  # of the asperity contact behind the middle [b]
    fallbacks: float
    microseconds: float


def ended(scene: Scene, mesh: float, window: float, short: bool) -> Ended:
    """A run on the mesh as it is, or on the ``short`` one of the smooth contact."""
    smooth = mock.patch("ehl.rough.scaling.rough_length", lambda contact, film, rms: solved_length(contact, film))
    with smooth if short else nullcontext():
        run = scene.run(mesh)
    run.advance(round((startup_of(scene) + 0.5) * mesh))
    begun = time.process_time()
    records, profiles = run.advance(round(window * mesh))
    spent = time.process_time() - begun
    touching = run.problem.x[profiles[1] > 0.0]
    return Ended(
        mu=float(friction(records).mean()),
        film=float(records[:, FILM_MEAN].mean()) * run.problem.units.film,
        edge_pressure=float((profiles[0] + profiles[1])[-3:].max()),
        reach=float(touching[-1]) if touching.size else 0.0,
        fallbacks=float(np.mean(records[:, STAGE] > PLAIN)),
        microseconds=1e6 * spent / len(records),
    )


def ends(out: Path) -> None:
    """The mesh as far as asperities touch, against one that ends where that of the smooth contact does."""
    oil = eyring_oil()
    scenes: list[tuple[str, float, Scene]] = []
    lines = [(0.005, 0.5e9, 0.5e-6, ratio) for ratio in SOFT_RATIOS]
    lines += [(RADIUS, p_h, rms, ratio) for p_h in (1e9, 2e9) for rms in ROUGHNESSES for ratio in ENDED_RATIOS]
    for radius, p_h, rms, ratio in lines:
        contact = line(speed_of_film_ratio(ratio, rms, oil, pressure=p_h, radius=radius), 0.5, p_h, radius)
        surfaces = gaussian_pair(contact, rms, 0.1)
        name = f"R {radius * 1e3:g} mm, {p_h / 1e9:g} GPa, Rq {rms * 1e6:g} um"
        scenes += [(name, ratio, Scene(contact, oil, surfaces, 30e-9, gamma)) for gamma in (1.0, math.inf)]
    columns = ("scene", "lambda", "gamma", "mu", "change of mu %", "of film %", "reach b", "end p/p_h, short",
               "end p/p_h", "fallbacks, short", "fallbacks", "time / short")  # fmt: skip
    rows = []
    for name, ratio, scene in scenes:
        window = 12.0 if scene.contact.radius_equivalent == RADIUS else 48.0
        short, full = (ended(scene, 80.0, window, cut) for cut in (True, False))
        changes = 100 * (full.mu / short.mu - 1.0), 100 * (full.film / short.film - 1.0)
        row = name, ratio, scene.peklenik_number, full.mu, *changes, full.reach, short.edge_pressure
        rows.append((*row, full.edge_pressure, short.fallbacks, full.fallbacks, full.microseconds / short.microseconds))
    print_table("where the mesh ends", columns, rows)
    write_csv(out / "mixed_ends.csv", columns, rows)
    numbers = np.array([row[4:] for row in rows[2 * len(SOFT_RATIOS) :]])
    print(f"test line, {len(numbers)} scenes: largest change of mu {np.abs(numbers[:, 0]).max():.2g} %,")
    print(f"fallback steps {numbers[:, 5].sum():.3g} -> {numbers[:, 6].sum():.3g} (sums of shares),")
    print(f"time of a step {np.median(numbers[:, 7]):.3g} of the short one in the median")


STUDIES = {"tolerance": tolerance, "laws": laws, "viscosity": viscosity, "ends": ends}


def main(argv: Sequence[str] | None = None) -> None:
    """Run one study."""
    parser = command_line(__doc__)
    parser.add_argument("study", choices=STUDIES)
    parser.add_argument("--out", type=Path, default=OUT)
    given = parser.parse_args(argv)
    STUDIES[given.study](given.out)


if __name__ == "__main__":
    main()
