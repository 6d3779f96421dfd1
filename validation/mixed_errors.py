"""Error studies of the deterministic solver: meshes, reported errors, statistical intervals, cost."""

from __future__ import annotations

import csv
import math
import time
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

import numpy as np
from mixed_scenes import (
    Scene,
    eyring_oil,
    family,
    friction,
    gaussian_pair,
    lagged_share,
    line,
    print_table,
    speed_of_film_ratio,
    startup_of,
    write_csv,
)
from scipy.stats import qmc

from ehl.rough import RoughSurfaces, solve_transient
from ehl.rough._kernels.march import ITERATIONS, MACRO_LOAD, SHARE
from ehl.rough.accuracy import make_run_plan
from ehl.rough.averaging import Window
from ehl.rough.batch_means import batch_means
from ehl.rough.run import TransientRun
from ehl.surface.roughness import generate_profile

BATCH = 2.0  # [b]


def batch_series(window: Window) -> np.ndarray:
    """mu of batches of 2 b."""
    values = friction(window.records)
    size = round(BATCH * window.run.problem.units.steps_per_half_width)
    count = values.size // size
    return values[: count * size].reshape(count, size).mean(axis=1)


def sample_scenes(count: int, seed: int) -> Iterator[tuple[dict[str, float], Scene, float]]:
    """Rough isothermal scenes: values, scene, and nodes per b of the fine mesh by the rule of accuracy "fast"."""
    # lambda, p_h, slip, correlation length [b], eta0, alpha, h_boundary; logarithmic
    low = np.array([0.05, 0.5e9, 0.05, 0.1, 0.005, 10e-9, 10e-9])
    high = np.array([4.0, 2.0e9, 1.5, 0.4, 0.1, 22e-9, 60e-9])
    rms = 0.4e-6
    shares = qmc.Sobol(low.size + 1, rng=seed).random_base2(math.ceil(math.log2(count)))[:count]
    for index, share in enumerate(shares):
        values = low * (high / low) ** share[:-1]
        ratio, p_h, slip, correlation, viscosity, alpha, boundary = (float(v) for v in values)
        gamma = (math.inf, 3.0, 1.0)[int(3.0 * share[-1])]
        oil = eyring_oil(viscosity, alpha)
        speed = speed_of_film_ratio(ratio, rms, oil, slide_to_roll=slip, pressure=p_h)
        contact = line(speed, slip, p_h)
        scene = Scene(contact, oil, gaussian_pair(contact, rms, correlation, index), boundary, gamma)
        drained = math.isfinite(gamma)
        film = contact.film_moes(oil)
        fine = 1.0 / make_run_plan("fast", contact, scene.surfaces, film, drained=drained, thermal=False).spacing
        row = {
            "case": index,
            "film_ratio": ratio,
            "pressure_hertz": p_h,
            "speed": speed,
            "slip": slip,
            "correlation": correlation,
            "viscosity": viscosity,
            "alpha": alpha,
            "boundary_film": boundary,
            "gamma": gamma,
        }
        yield row, scene, fine


def reported_errors(out: Path, count: int, seed: int, seconds: float, window: float = 12.0) -> None:
    """mu on meshes N/2, N and 4 N of random scenes, batch by batch; appended row by row."""
    path = out / f"mixed_reported_errors_{seed}.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    begin = time.perf_counter()
    with path.open("w", newline="") as file:
        writer: csv.DictWriter[str] | None = None
        for row, scene, mesh in sample_scenes(count, seed):
            if time.perf_counter() - begin > seconds:
                break
            begun = time.process_time()
            coarse, fine, finest = family(scene, (0.5 * mesh, mesh, 4.0 * mesh), startup_of(scene), window)
            extra: dict[str, float | str] = {"mesh": mesh}
            for name, member in (("coarse", coarse), ("fine", fine), ("finest", finest)):
                extra[f"mu_{name}"] = float(friction(member.records).mean())
                extra[f"share_{name}"] = float(member.records[:, SHARE].mean())
                extra[f"lagged_{name}"] = lagged_share(member.records)
                extra[f"batches_{name}"] = " ".join(f"{v:.8g}" for v in batch_series(member))
            extra["statistical"] = fine.interval()[1]
            extra["cpu"] = time.process_time() - begun
            if writer is None:
                writer = csv.DictWriter(file, [*row, *extra])
                writer.writeheader()
            writer.writerow(row | extra)
            file.flush()
    summarise_reported(path)


def summarise_reported(path: Path) -> None:
    """Coverage and sharpness of candidate estimates of the mesh error."""
    with path.open() as file:
        rows = list(csv.DictReader(file))
    candidates: dict[str, list[float]] = {}
    for row in rows:
        coarse, fine, finest = (float(row[f"mu_{k}"]) for k in ("coarse", "fine", "finest"))
        true = abs(fine - finest)
        a, b = (np.array([float(v) for v in row[f"batches_{k}"].split()]) for k in ("coarse", "fine"))
        common = min(a.size, b.size)
        difference = b[:common] - a[:common]
        spread = float(np.std(difference, ddof=1)) / math.sqrt(difference.size)
        d = abs(fine - coarse)
        for name, estimate in (
            ("d/2", d / 2),
            ("d", d),
            ("hypot(d/2, 2 s)", math.hypot(d / 2, 2 * spread)),
            ("hypot(d, 2 s)", math.hypot(d, 2 * spread)),
            ("hypot(d, 3 s), as reported", math.hypot(d, 3 * spread)),
        ):
            candidates.setdefault(name, []).append(estimate / max(true, 1e-12))
    table = []
    for name, ratios in candidates.items():
        r = np.array(ratios)
        table.append((name, len(r), float(np.mean(r >= 1.0)), float(np.median(r)), float(np.quantile(r, 0.05))))
    print_table("reported over true mesh error", ("estimate", "cases", "inside", "median ratio", "5 % quantile"), table)


INTERVAL_CONDITIONS = {
    "lambda 1.5, sealed": (1.5, math.inf, 0.5),
    "lambda 0.5, gamma 1": (0.5, 1.0, 0.5),
    "lambda 0.2, sealed": (0.2, math.inf, 0.5),
    "lambda 0.2, SR 0.1": (0.2, math.inf, 0.1),
}


def statistical_intervals(out: Path, seeds: int, window: float, only: int | None = None) -> None:
    """mu step by step over seeds at four conditions on one mesh, and the coverage of the 90 % interval."""
    oil, rms, mesh = eyring_oil(), 0.4e-6, 40.0
    for number, (name, (ratio, gamma, slip)) in enumerate(INTERVAL_CONDITIONS.items()):
        if only is not None and number != only:
            continue
        contact = line(speed_of_film_ratio(ratio, rms, oil, slide_to_roll=slip), slip)
        collected = []
        for seed in range(seeds):
            scene = Scene(contact, oil, gaussian_pair(contact, rms, 0.15, 100 + seed, 64.0), 30e-9, gamma)
            (member,) = family(scene, (mesh,), startup_of(scene), window)
            collected.append(friction(member.records))
        shortest = min(s.size for s in collected)
        series = np.array([s[:shortest] for s in collected])
        np.savez_compressed(out / f"mixed_intervals_{number}.npz", name=name, mesh=mesh, series=series)
    summarise_intervals(out)


def summarise_intervals(out: Path) -> None:
    """Coverage of the interval of `ehl.rough.batch_means` against the mean over all seeds."""
    rows = []
    inside_all: list[bool] = []
    for path in sorted(out.glob("mixed_intervals_?.npz")):
        data = np.load(path)
        series, mesh, name = data["series"], float(data["mesh"]), str(data["name"])
        truth = float(series.mean())
        for travel in (12.0, 24.0, 48.0):
            steps = round(travel * mesh)
            if steps > series.shape[1] + mesh:
                continue
            part = series[:, :steps]
            found = [batch_means(s, round(BATCH * mesh)) for s in part]
            inside = [abs(m - truth) <= w for m, w in found]
            inside_all += inside
            half = np.array([w for _, w in found])
            std = float(part.mean(axis=1).std(ddof=1))
            rows.append(
                (name, travel, truth, std / truth, float(np.median(half)) / truth, float(np.mean(inside)), len(inside))
            )
        stopped = [abs(m - truth) <= w for m, w in stopped_runs(series, mesh)]
        rows.append((name, math.nan, truth, math.nan, math.nan, float(np.mean(stopped)), len(stopped)))
    columns = ("condition", "window b", "mu", "std of means", "median half width", "coverage", "intervals")
    print_table("nominal 90 % interval of mu; without a window: runs that stop by it", columns, rows)
    print(f"all together: {np.mean(inside_all):.3f} of {len(inside_all)}")
    write_csv(out / "mixed_intervals.csv", columns, rows)


def stopped_runs(series: np.ndarray, mesh: float) -> Iterator[tuple[float, float]]:
    """mu and interval of runs that look every 4 b from 12 to 24 b and stop inside one of four tolerances."""
    looks = [[batch_means(s[: round(t * mesh)], round(BATCH * mesh)) for t in (12, 16, 20, 24)] for s in series]
    last = np.array([found[-1] for found in looks])
    for tolerance in np.quantile(last[:, 1] / last[:, 0], (0.15, 0.3, 0.6, 0.85)):
        for found in looks:
            yield next(((m, w) for m, w in found if w <= tolerance * m), found[-1])


def mesh_table(out: Path, window: float) -> None:
    """mu and both shares on N, 2 N, 4 N for four lays and three boundary films at one speed."""
    oil, rms = eyring_oil(), 0.4e-6
    contact = line(speed_of_film_ratio(0.3, rms, oil))
    surfaces = gaussian_pair(contact, rms, 0.1)
    columns = ("gamma", "h_boundary nm", "nodes per b", "mu", "asperity share", "roughness share", "change of mu %")
    rows = []
    for gamma in (math.inf, 3.0, 1.0, 1.0 / 3.0):
        for boundary in (10e-9, 30e-9, 60e-9):
            scene = Scene(contact, oil, surfaces, boundary, gamma)
            meshes = (100.0, 200.0, 400.0)
            windows = family(scene, meshes, startup_of(scene), window)
            last = float(friction(windows[-1].records).mean())
            for mesh, member in zip(meshes, windows, strict=True):
                mean = member.records.mean(axis=0)
                mu = float(friction(member.records).mean())
                rough = 1.0 - float(mean[MACRO_LOAD]) if math.isfinite(gamma) else math.nan
                rows.append((gamma, boundary * 1e9, mesh, mu, float(mean[SHARE]), rough, 100 * (mu / last - 1.0)))
            print_table("", columns, rows[-3:])
            write_csv(out / "mixed_mesh.csv", columns, rows)
    print_table("mesh convergence at lambda 0.3", columns, rows)


def mesh_targets(out: Path, window: float) -> None:
    """Sealed isothermal mu of the meshes of each accuracy against 4 times finer, from lambda 3 to the boundary."""
    oil, rms, correlation = eyring_oil(), 0.4e-6, 0.1
    columns = ("lambda", "nodes per b", "mu", "share", "mu 4 N", "error %", "paired noise %", "lagged", "lagged 4 N")
    rows = []
    for ratio in (3.0, 1.5, 0.8, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02):
        contact = line(speed_of_film_ratio(ratio, rms, oil))
        scene = Scene(contact, oil, gaussian_pair(contact, rms, correlation))
        film = contact.film_moes(oil)
        mesh = 1.0 / make_run_plan("standard", contact, scene.surfaces, film, drained=False, thermal=False).spacing
        standard, finest = family(scene, (mesh, 4.0 * mesh), startup_of(scene), window)
        a, b = batch_series(standard), batch_series(finest)
        k = min(a.size, b.size)
        mu, best = float(friction(standard.records).mean()), float(friction(finest.records).mean())
        noise = float(np.std(a[:k] - b[:k], ddof=1)) / math.sqrt(k) / best
        share = float(standard.records[:, SHARE].mean())
        rows.append(
            (
                ratio,
                mesh,
                mu,
                share,
                best,
                100 * (mu / best - 1.0),
                100 * noise,
                lagged_share(standard.records),
                lagged_share(finest.records),
            )
        )
        print_table("", columns, rows[-1:])
        write_csv(out / "mixed_targets.csv", columns, rows)
    print_table(f"mesh of accuracy standard against 4 times finer, window {window} b", columns, rows)


def spots(out: Path, window: float) -> None:
    """Meshes of thin films on line B (1.5 GPa, SR 0.15), sealed: error of mu against 600 nodes per b, and CPU time.

    The time is that of accuracy "standard" with its companion, with the floor of nodes for contact spots and without.
    """
    oil, rms, p_h, slip = eyring_oil(), 0.4e-6, 1.5e9, 0.15
    meshes = (100.0, 150.0, 200.0, 600.0)
    columns = ("lambda", "lc b", "seed", *(f"error at {m:g} %" for m in meshes[:-1]), "noise at 100 %", "mu",
               "nodes per b", "s", "s without floor")  # fmt: skip
    rows = []
    for ratio in (0.38, 0.3, 0.2, 0.15, 0.1, 0.06):
        contact = line(speed_of_film_ratio(ratio, rms, oil, pressure=p_h), slip, p_h)
        film = contact.film_moes(oil)
        for correlation in (0.2, 0.4):
            for seed in (1, 2):
                scene = Scene(contact, oil, gaussian_pair(contact, rms, correlation, seed))
                *coarse, finest = family(scene, meshes, startup_of(scene), window)
                mu = float(friction(finest.records).mean())
                errors = [100 * (float(friction(w.records).mean()) / mu - 1.0) for w in coarse]
                a, b = batch_series(coarse[0]), batch_series(finest)
                k = min(a.size, b.size)
                noise = 100 * float(np.std(a[:k] - b[:k], ddof=1)) / math.sqrt(k) / mu
                mesh = (
                    1.0 / make_run_plan("standard", contact, scene.surfaces, film, drained=False, thermal=False).spacing
                )
                seconds = standard_time(scene)
                with mock.patch("ehl.rough.accuracy.SPOT_RATIO", 0.0):
                    before = standard_time(scene)
                rows.append((ratio, correlation, seed, *errors, noise, mu, mesh, seconds, before))
        print_table("", columns, rows[-4:])
        write_csv(out / "mixed_spots.csv", columns, rows)
    print_table(f"meshes of thin films, window {window} b", columns, rows)


def standard_time(scene: Scene) -> float:
    """Processor time of accuracy "standard", window 4 b, without the study of the boundary film [s]."""
    begun = time.process_time()
    solve_transient(
        scene.contact, scene.lubricant, scene.surfaces, accuracy="standard", boundary_film=scene.boundary_film,
        peklenik_number=scene.peklenik_number, travel=4.0, boundary_study=False,
    )  # fmt: skip
    return time.process_time() - begun


# film ratio, SR, gamma, period and window [b]
STRETCHES = (
    (0.5, 0.5, math.inf, 32.0, 16.0), (0.5, 0.5, math.inf, 8.0, 32.0), (0.5, 0.5, 1.0, 8.0, 32.0),
    (0.2, 0.5, math.inf, 8.0, 32.0), (0.5, 0.05, math.inf, 8.0, 32.0), (0.5, 1.9, math.inf, 16.0, 32.0),
    (0.5, -2.0, math.inf, 32.0, 16.0), (0.2, -2.0, math.inf, 32.0, 16.0),
)  # fmt: skip


def stretches(out: Path, seeds: int) -> None:
    """mu over other stretches of the same surfaces: spread over seeds, and what two error bars cover of it."""
    oil, rms = eyring_oil(), 0.4e-6
    columns = ("lambda", "SR", "gamma", "period b", "window b", "1.645 std %", "interval %", "covers %",
               "realisation error %", "covers % ", "net exchange", "chance")  # fmt: skip
    rows = []
    for ratio, slip, gamma, period, window in STRETCHES:
        contact = line(speed_of_film_ratio(ratio, rms, oil, slide_to_roll=slip), slip)
        b = contact.half_width
        results = []
        for seed in range(seeds):
            each = (
                generate_profile(rms / math.sqrt(2.0), 0.15 * b, period * b, 0.0075 * b, 2 * seed + i) for i in (1, 2)
            )
            results.append(
                solve_transient(
                    contact,
                    oil,
                    RoughSurfaces(*each),
                    accuracy="fast",
                    nodes=150,
                    boundary_film=30e-9,
                    peklenik_number=gamma,
                    travel=window,
                )
            )
        friction_ = np.array([r.friction_coefficient for r in results])
        away = np.abs(friction_ / friction_.mean() - 1.0)
        spread = 164.5 * float(np.std(friction_, ddof=1) / friction_.mean())
        row: list[float] = [ratio, slip, gamma, period, window, spread]
        for bars in ([r.statistical_error for r in results], [r.realisation_error for r in results]):
            row += [100 * float(np.median(bars)), 100 * float(np.mean(away <= np.array(bars)))]
        row += [float(np.median([getattr(r, k) for r in results])) for k in ("net_exchange", "net_exchange_threshold")]
        rows.append(row)
        write_csv(out / "mixed_stretches.csv", columns, rows)
    print_table(f"other stretches of the same surfaces, {seeds} seeds", columns, rows)


TURN_STEPS = 200
COST_MESHES = (35.0, 70.0, 140.0, 280.0, 560.0, 1120.0, 2240.0)  # nodes per b; drainage and heat on the first four


def rolling(scene: Scene, mesh: float) -> TransientRun:
    """A run past its start-up of 4 b; a fine one takes over the state of a coarser one and rolls 0.3 b more."""
    first = scene.run(min(mesh, 280.0))
    first.advance(round(4.0 * first.problem.units.steps_per_half_width))
    if mesh <= 280.0:
        return first
    run = scene.run(mesh, start_travel=first.travel)
    run.start_from(first)
    run.advance(round(0.3 * run.problem.units.steps_per_half_width))
    return run


def cost(out: Path, repeats: int = 9) -> None:
    """CPU time of a step over the number of nodes, and what drainage and heat add to it.

    Meshes and variants take turns, the variants of a mesh over the same travel; medians over the turns of times, of
    ratios within a turn, and of exponents within a turn.
    """
    oil, rms = eyring_oil(), 0.4e-6
    rows: list[tuple[float | str, ...]] = []
    exponents: list[tuple[float | str, ...]] = []
    columns = ("lambda", "variant", "nodes", "us per step", "iterations", "us per iteration", "added to sealed %")
    for ratio in (1.5, 0.3):
        contact = line(speed_of_film_ratio(ratio, rms, oil))
        base = Scene(contact, oil, gaussian_pair(contact, rms, 0.2))
        variants = {
            "sealed": base,
            "gamma 1": base.with_(peklenik_number=1.0),
            "sealed, heat": base.with_(thermal=True),
        }
        runs = {
            (mesh, name): rolling(scene, mesh)
            for mesh in COST_MESHES
            for name, scene in variants.items()
            if name == "sealed" or mesh < 300.0
        }
        used: dict[tuple[float, str], list[float]] = {key: [] for key in runs}
        iterations: dict[tuple[float, str], list[float]] = {key: [] for key in runs}
        for _ in range(repeats):
            for key, run in runs.items():
                begun = time.process_time()
                records, _ = run.advance(TURN_STEPS)
                used[key].append((time.process_time() - begun) / TURN_STEPS)
                iterations[key].append(float(records[:, ITERATIONS].mean()))
        per_iteration = {key: np.divide(used[key], iterations[key]) for key in runs}
        for key, times in used.items():
            mesh, name = key
            added = 100 * (float(np.median(np.divide(times, used[mesh, "sealed"]))) - 1.0)
            per_step, mean = 1e6 * float(np.median(times)), float(np.mean(iterations[key]))
            each = 1e6 * float(np.median(per_iteration[key]))
            rows.append((ratio, name, runs[key].problem.x.size, per_step, mean, each, added))
        for first, last in ((0, 4), (2, 6)):
            keys = [(mesh, "sealed") for mesh in COST_MESHES[first : last + 1]]
            nodes = [runs[key].problem.x.size for key in keys]
            times = np.array([per_iteration[key] for key in keys])
            slopes = np.polyfit(np.log(nodes), np.log(times), 1)[0]
            exponents.append((ratio, f"{nodes[0]} to {nodes[-1]}", np.median(slopes), slopes.min(), slopes.max()))
    print_table("cost", columns, rows)
    write_csv(out / "mixed_cost.csv", columns, rows)
    columns = ("lambda", "nodes", "exponent", "least", "most")
    print_table("exponent of the time per iteration in the number of nodes, over the turns", columns, exponents)
    write_csv(out / "mixed_cost_exponents.csv", columns, exponents)
