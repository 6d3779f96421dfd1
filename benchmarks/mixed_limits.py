"""Limits the deterministic solver must reproduce: smooth, dry, drained, heat."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from mixed_scenes import (
    BOUNDARY_FRICTION,
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

from ehl.fluid.conductivity import FilmConductivity
from ehl.line_contact import LineContact
from ehl.rough import solve_transient
from ehl.rough._kernels.march import MACRO_LOAD, SHARE
from ehl.rough._kernels.motion import move_surfaces
from ehl.rough._kernels.records import TRAVEL
from ehl.rough.averaging import Window, net_exchange
from ehl.rough.dry import solve_dry
from ehl.rough.run import Run
from ehl.smooth import solve_steady
from ehl.smooth.thermal import solve_smooth

CONSTANT = FilmConductivity(0.0, 0.0)  # the film conductivity of the prototype the runs are compared with


def smooth_limit(out: Path) -> None:
    """Transient runs of smooth surfaces against the steady solvers, without and with heat."""
    rows = []
    oil = eyring_oil()
    for speed, slip, p_h in (
        (5.0, 0.5, 1e9),
        (1.0, 0.1, 1e9),
        (15.0, 1.0, 1e9),
        (5.0, 0.5, 0.5e9),
        (5.0, 0.3, 2e9),
        (0.3, 0.05, 0.7e9),
    ):
        contact = line(speed, slip, p_h)
        steady = solve_steady(contact, oil, accuracy="reference")
        moving = solve_transient(contact, oil, nodes=940)
        middle = np.abs(steady.x) < 0.8 * contact.half_width
        film = np.trapezoid(steady.film[middle], steady.x[middle]) / np.ptp(steady.x[middle])
        rows.append(
            (
                "isothermal",
                speed,
                slip,
                p_h / 1e9,
                moving.friction_coefficient,
                100 * (moving.friction_coefficient / steady.friction_fluid - 1.0),
                100 * (moving.film_mean / film - 1.0),
                math.nan,
            )
        )
    for speed, slip, p_h in ((5.0, 0.3, 1e9), (5.0, 1.0, 1e9), (15.0, 0.3, 1e9), (5.0, 0.3, 2e9), (15.0, 1.0, 2e9)):
        contact = line(speed, slip, p_h)
        oil = replace(oil, film_conductivity=CONSTANT)
        hot = solve_smooth(
            contact,
            oil,
            (STEEL, STEEL),
            thermal="on",
            accuracy="standard",
        )
        moving = solve_transient(contact, oil, nodes=500, thermal=True)
        rows.append(
            (
                "thermal",
                speed,
                slip,
                p_h / 1e9,
                moving.friction_coefficient,
                100 * (moving.friction_coefficient / hot.friction_fluid - 1.0),
                math.nan,
                moving.temperature_film_max - hot.temperature_film_max,
            )
        )
    columns = ("heat", "u_r", "SR", "p_h GPa", "mu transient", "mu error %", "film error %", "film temperature error K")
    print_table("smooth limit: transient against steady", columns, rows)
    write_csv(out / "mixed_smooth.csv", columns, rows)


def dry_error(run: Run, contact: LineContact) -> tuple[float, float, float]:
    """L1 difference of the pressures, contact lengths of run and of `ehl.rough.dry` over b, at the run's geometry."""
    problem = run.problem
    units, surfaces = problem.units, problem.model.surfaces
    gap = np.zeros(problem.x.size)
    move_surfaces(gap, run.state.scalars[TRAVEL], surfaces)
    x = problem.x * units.half_width
    total = (run.state.fluid_pressure + run.state.contact_pressure) * units.pressure
    dry = solve_dry(contact, x, -(gap - surfaces.parabola) * units.film, hardness=8e9)
    length = np.count_nonzero(run.state.contact_pressure > 0.0) * units.spacing
    difference = float(np.abs(dry.pressure - total).sum() / total.sum())
    return difference, length / contact.half_width, dry.contact_length / contact.half_width


def dry_limit(out: Path) -> None:
    """Nearly no lubricant: pressures of the moving contact against the dry contact of the same geometry."""
    rows = []
    oil = eyring_oil(1e-6, 1e-11)
    for rms, correlation, gamma in ((0.2e-6, 0.1, math.inf), (0.4e-6, 0.1, math.inf), (0.8e-6, 0.2, math.inf),
                                    (0.4e-6, 0.1, 1.0), (0.2e-6, 0.2, 3.0)):  # fmt: skip
        contact = line(0.02)
        scene = Scene(contact, oil, gaussian_pair(contact, rms, correlation), 20e-9, gamma)
        run = scene.run(100.0)
        records, _ = run.advance(round(startup_of(scene) * 100))
        difference, touching, dry_touching = dry_error(run, contact)
        mu = float(friction(records[-1:])[0])
        rows.append(
            (rms * 1e6, correlation, gamma, float(records[-1, SHARE]), mu, 100 * difference, touching, dry_touching)
        )
    columns = ("Rq um", "lc b", "gamma", "asperity share", "mu", "pressure difference %", "contact b", "contact b, dry")
    print_table("dry limit", columns, rows)
    write_csv(out / "mixed_dry.csv", columns, rows)


def boundary_limit(out: Path) -> None:
    """Asperity share and mu as eta0 u_r -> 0 at fixed roughness, for three lays."""
    oil, rms = eyring_oil(), 0.4e-6
    rows = []
    for gamma in (math.inf, 3.0, 1.0):
        for ratio in (0.1, 0.03, 0.01, 0.003, 0.001, 0.0003):
            contact = line(speed_of_film_ratio(ratio, rms, oil))
            scene = Scene(contact, oil, gaussian_pair(contact, rms, 0.1), 30e-9, gamma)
            run = scene.run(100.0)
            run.advance(round(startup_of(scene) * 100))
            records, _ = run.advance(400)
            rows.append((gamma, ratio, float(records[:, SHARE].mean()), float(friction(records).mean())))
    columns = ("gamma", "lambda", "asperity share", "mu")
    print_table(f"boundary limit, mu_b = {BOUNDARY_FRICTION}, h_boundary 30 nm", columns, rows)
    write_csv(out / "mixed_boundary_limit.csv", columns, rows)


def macroscopic_start(out: Path, windows: int = 10) -> None:
    """A drained run whose macroscopic pressure starts at three shares of Hertz's: windows of 8 b after 11 b."""
    oil, rms, mesh = eyring_oil(), 0.4e-6, 100.0
    contact = line(speed_of_film_ratio(0.25, rms, oil))
    scene = Scene(contact, oil, gaussian_pair(contact, rms, 0.1), 30e-9, 1.0)
    columns = ("start over Hertz", "window", "mu", "asperity share", "roughness share", "net exchange")
    rows = []
    for share in (0.2, 0.5, 0.9):
        run = scene.run(mesh)
        inner = slice(2, run.problem.model.contact.outlet)  # the ends are given
        run.macroscopic.pressure[inner] = share * run.state.fluid_pressure[inner]
        rolled = [Window(run)]
        rolled[0].start(startup_of(scene))
        for number in range(windows):
            rolled.append(Window(run))
            rolled[-1].roll(8.0)
            rows.append((share, f"{number + 1}", *averages(rolled[-1])))
        for count in (2, windows):  # all of a run as longer windows
            for first in range(1, windows + 1, count):
                longer = Window(run)
                for part in rolled[first : first + count]:
                    longer.recorded += part.recorded
                    longer.exchanges += part.exchanges
                    longer.sums += part.sums
                rows.append((share, f"{first} to {first + count - 1}", *averages(longer)))
    print_table("start of the macroscopic pressure, gamma 1, lambda 0.25", columns, rows)
    write_csv(out / "mixed_start.csv", columns, rows)


def averages(window: Window) -> tuple[float, float, float, float]:
    """mu, both shares and the net exchange over the throughput of a window."""
    records = window.records
    shares = float(records[:, SHARE].mean()), 1.0 - float(records[:, MACRO_LOAD].mean())
    return float(friction(records).mean()), *shares, net_exchange(window)[0]


def slip_curves(out: Path) -> None:
    """mu over slip with and without heat at the conditions of the prototype's table (smooth), and one rough set."""
    slips = (0.01, 0.03, 0.1, 0.3, 0.6, 1.0, 1.5)
    rows = []
    curves = {}
    for alpha, p_h, speed in (
        (9.68e-9, 1e9, 5.0),
        (9.68e-9, 2e9, 15.0),
        (15e-9, 1e9, 5.0),
        (15e-9, 1e9, 15.0),
        (15e-9, 2e9, 5.0),
        (15e-9, 2e9, 15.0),
    ):
        oil = replace(eyring_oil(0.0106, alpha), film_conductivity=CONSTANT)
        cold, hot = [], []
        for slip in slips:
            contact = line(speed, slip, p_h)
            a = solve_transient(contact, oil, nodes=256)
            b = solve_transient(contact, oil, nodes=256, thermal=True)
            cold.append(a.friction_coefficient)
            hot.append(b.friction_coefficient)
            film, flash = b.temperature_film_max - 373.15, b.temperature_flash - 373.15
            rows.append(
                ("smooth", alpha * 1e9, p_h / 1e9, speed, slip, cold[-1], hot[-1], cold[-1] / hot[-1], film, flash)
            )
        curves[f"smooth, α {alpha * 1e9:.3g}/GPa, {p_h / 1e9:.0f} GPa, {speed:.0f} m/s"] = (cold, hot)
    oil, rms = eyring_oil(0.0106), 0.4e-6
    cold, hot = [], []
    for slip in slips:
        contact = line(5.0, slip)
        pair = gaussian_pair(contact, rms, 0.15)
        values = []
        for thermal in (False, True):
            scene = Scene(contact, oil, pair, 20e-9, 1.0, thermal)
            run = scene.run(80.0)
            run.advance(round((startup_of(scene) + 6.0) * 80))
            values.append(float(friction(run.advance(12 * 80)[0]).mean()))
        cold.append(values[0])
        hot.append(values[1])
        rows.append(("rough", 15.0, 1.0, 5.0, slip, *values, values[0] / values[1], math.nan, math.nan))
    curves[f"rough, λ {scene.film_ratio:.2g}, α 15/GPa, 1 GPa, 5 m/s"] = (cold, hot)
    columns = (
        "surface",
        "alpha 1/GPa",
        "p_h GPa",
        "u_r",
        "SR",
        "mu isothermal",
        "mu thermal",
        "ratio",
        "film K",
        "flash K",
    )
    print_table("friction over slip", columns, rows)
    write_csv(out / "mixed_slip.csv", columns, rows)
    figure, axes = plt.subplots(figsize=(7, 4.4))
    for (name, (a, b)), colour in zip(curves.items(), plt.colormaps["tab10"].colors, strict=False):
        axes.semilogx(slips, a, "--", color=colour, lw=1)
        axes.semilogx(slips, b, "o-", color=colour, ms=3, label=name)
    axes.set(xlabel="slide-to-roll ratio", ylabel="friction coefficient", title="dashed isothermal, solid with heat")
    axes.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(out / "mixed_slip.png", dpi=130)
