"""What is timed: contacts, formulas, gear pairs and commands, by the public interface."""

from __future__ import annotations

import math
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import Any

import numpy as np

import efficiency
import ehl
import regression

DESIGN, HYPOID = "fm_spiral_bevel_14x39", "fh_hypoid_9x34"
STATES = tuple(product(("0.6 GPa", "1.5 GPa"), ("1 m/s", "10 m/s"), (0.05, 0.5)))
POINTS = 2000


@dataclass(frozen=True)
class Timed:
    """One benchmark.

    Parameters
    ----------
    about : str
        What a run computes and what its error is.
    setup : callable
        Prepares and returns the task that is timed.
    error : callable
        Relative error of the result of the task.
    """

    about: str
    setup: Callable[[], Callable[[], Any]]
    error: Callable[[Any], float]


def contacts(accuracy: str, **more: Any) -> list[ehl.Contact]:
    """Contacts of the gear range with the oil 75W90 at 80 degC."""
    return [
        ehl.Contact(
            oil="75w90", temperature="80 degC", pressure_hertz=pressure, radius_equivalent="15 mm",
            speed_entrainment=speed, slide_to_roll=slip, accuracy=accuracy, **more,
        )
        for pressure, speed, slip in STATES
    ]  # fmt: skip


def friction(results: Sequence[ehl.ContactResult]) -> np.ndarray:
    """Friction coefficients."""
    return np.array([result.friction_coefficient for result in results])


def smooth(thermal: str) -> Timed:
    """Eight smooth contacts against the accuracy "reference"."""

    def error(results: Sequence[ehl.ContactResult]) -> float:
        truth = friction([contact.solve() for contact in contacts("reference", thermal=thermal)])
        return float(np.max(np.abs(friction(results) / truth - 1.0)))

    return Timed(
        f'eight smooth contacts, "standard", heat {thermal}; largest error of mu against "reference"',
        lambda: lambda: [contact.solve() for contact in contacts("standard", thermal=thermal)],
        error,
    )


def rough() -> list[ehl.ContactResult]:
    """Two rough contacts of the gear range."""
    return [contact.solve() for contact in contacts("fast", roughness_rms="0.4 um")[2:6:3]]


def points_of(name: str) -> Callable[[], Any]:
    """Friction with its interval at many points."""
    model, slip = regression.friction_model(name), np.linspace(0.02, 0.8, POINTS)

    def task() -> Any:
        return model.mu(
            pressure_hertz="1 GPa", radius_equivalent="15 mm", speed_entrainment="5 m/s", slide_to_roll=slip,
            temperature="90 degC", roughness_rms="0.4 um",
        )  # fmt: skip

    return task


def half_interval(found: Any) -> float:
    """Half the stated interval over mu, median."""
    return float(np.median(0.5 * (found.upper - found.lower) / found.mu))


@cache
def load_error(name: str) -> float:
    """Change of the efficiency loss from the default mesh to twice the positions and points."""
    losses = [
        1.0 - efficiency.load(name).mesh(**counts).load().efficiency("constant:0.05").efficiency
        for counts in ({}, {"positions": 48, "points_per_line": 61})
    ]
    return abs(losses[0] / losses[1] - 1.0)


def new_torque() -> Callable[[], Any]:
    """Load and loss at a torque that was not solved before, geometry known."""
    mesh, torques = efficiency.load(DESIGN).mesh(), iter(np.linspace(150.0, 250.0, 50).tolist())
    mesh.load("100 N m")
    return lambda: mesh.load(next(torques)).efficiency("75w90")


def many_points() -> Callable[[], Any]:
    """A map of 20 x 20 torques and speeds, geometry included."""
    share = np.linspace(0.1, 1.5, 20)
    return lambda: efficiency.load(DESIGN).over(
        "75w90", torque=(200.0 * share).tolist(), speed=(150.0 * share).tolist()
    )


def published_sweep() -> Callable[[], Any]:
    """The cases of a plan by a published formula: what a sweep costs next to its cases."""

    def task() -> Any:
        with tempfile.TemporaryDirectory() as folder:
            return regression.sweep("demo", folder, formula="xu_kahraman_2007", jobs=1).status()

    return task


def command(*arguments: str) -> Callable[[], Callable[[], float]]:
    """CPU seconds of a process of its own; they are the error, as the clock of this process does not see them."""

    def task() -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    return lambda: task


C_POINTS, C_ROUNDS = 1000, 200
_LOOP = """
int main(int count, char **arguments) {
  static f_point at[%(points)d];
  static f_result results[%(points)d];
  for (int i = 0; i < %(points)d; i++)
    at[i] = (f_point){0.5e9 + 1e6 * i, 0.015, 2.26e11, 5.0, 0.02 + 8e-4 * i, 0.1, 363.15, 1.6e-5, 5.0, 4e-7};
  for (int k = 0; k < %(rounds)d; k++)
    if (count == 1) f_points(%(points)d, at, results);
    else for (int i = 0; i < %(points)d; i++) results[i] = f(%(arguments)s);
  return results[%(points)d - 1].upper > 0.0 && arguments ? 0 : 1;
}
"""


def exported(*single: str) -> Callable[[], Callable[[], float]]:
    """Least microseconds of processor time of the exported C at one point, in blocks or by a `single` call each."""

    def setup() -> Callable[[], float]:
        folder = tempfile.TemporaryDirectory()
        source, times = f"{folder.name}/f.c", [math.inf]
        arguments = ", ".join(f"at[i].{name}" for name in regression.Formula.load("75w90").export(source))
        with open(source, "a", encoding="utf-8") as file:
            file.write(_LOOP % {"points": C_POINTS, "rounds": C_ROUNDS, "arguments": arguments})
        subprocess.run(["cc", "-O3", "-fno-math-errno", "-o", f"{folder.name}/f", source, "-lm"], check=True)

        def task() -> float:
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
            subprocess.run([f"{folder.name}/f", *single], check=True)
            times.append(1e6 * (resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before) / C_POINTS / C_ROUNDS)
            return min(times)

        return task

    return setup


TIMED = {
    "smooth_contact": smooth("off"),
    "smooth_heat": smooth("on"),
    "rough_contact": Timed(
        'two rough contacts, "fast"; largest stated error of mu',
        lambda: rough,
        lambda results: max(result.friction_error for result in results),
    ),
    "formula": Timed(
        f"formula 75w90 at {POINTS} points; half the stated interval over mu", lambda: points_of("75w90"), half_interval
    ),
    "formula_c": Timed(
        "formula 75w90 as C (flags of its head), function of many points; microseconds a point in place of the error",
        exported(),
        float,
    ),
    "formula_c_single": Timed(
        "the same with a call for each point; microseconds a point in place of the error", exported("single"), float
    ),
    "gear_pair": Timed(
        "hypoid pair from the design file to the efficiency; change of the loss on twice the mesh",
        lambda: lambda: efficiency.load(HYPOID).mesh().load().efficiency("75w90"),
        lambda result: load_error(HYPOID),
    ),
    "gear_torque": Timed(
        "load and loss at one more torque, geometry known; stated error of the loss",
        new_torque,
        lambda result: result.efficiency_error / (1.0 - result.efficiency),
    ),
    "gear_map": Timed(
        "map of 20 x 20 torques and speeds from the design file on; change of the loss on twice the mesh",
        many_points,
        lambda result: load_error(DESIGN),
    ),
    "axle_map": Timed(
        "`mixed-ehl axle NAME --json`, map of 20 x 20, in a process of its own; its CPU seconds in place of the error",
        command(
            *("-c", "from efficiency.cli import main; main()", "axle", "truck_hypoid", "--json"),
            *("--torque", "20:400:20 N m", "--speed", "200:4000:20 rpm", "--temperature", "80 degC"),
        ),
        float,
    ),
    "axle_point": Timed(
        "`mixed-ehl axle NAME --json`, one point, in a process of its own; its CPU seconds in place of the error",
        command(
            *("-c", "from efficiency.cli import main; main()", "axle", "truck_hypoid", "--json"),
            *("--torque", "250 N m", "--speed", "1500 rpm", "--temperature", "80 degC"),
        ),
        float,
    ),
    "machine_settings": Timed(
        "machine settings of a hypoid pair from targets; none",
        lambda: lambda: efficiency.settings("fh_hypoid_9x34_offset_10"),
        lambda result: math.nan,
    ),
    "sweep": Timed(
        "the plan demo by a published formula, as what a sweep costs next to its cases; none",
        published_sweep,
        lambda result: math.nan,
    ),
    "start": Timed(
        "import of the packages in a process of its own; its CPU seconds in place of the error",
        command("-c", "import efficiency, regression, ehl; efficiency.load; ehl.Contact; regression.fit"),
        float,
    ),
    "gear_command": Timed(
        "`mixed-ehl gear NAME --json` in a process of its own; its CPU seconds in place of the error",
        command(
            "-c", "from efficiency.cli import main; main()", "gear", DESIGN, "--friction", "constant:0.05", "--json"
        ),
        float,
    ),
}
