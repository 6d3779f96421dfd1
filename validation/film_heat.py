"""Film temperature of the solver against the energy equation across the film, at given pressure, film and surfaces.

    python -m validation film_heat              # some states
    python -m validation film_heat --sample 64  # states spread over temperature, pressure, speed and slip

The solver takes the viscosity at the effective temperature of a film of exponential viscosity (docs/heat.md) and
convects the heat of the shear in the first mode of conduction across the film. Here
rho c u(z) dT/dx = k d2T/dz2 + tau dv/dz is marched along x by finite differences, with one shear stress across the film
and the viscosity of each layer. The same equation without convection and, for the latter, the viscosity at mid-film of
a parabola, which many programs use, are compared as well. The rise by the heat of the pressure-driven flow is that of
the solver.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from common import OUT, command_line, write_rows
from scipy.linalg import solve_banded
from scipy.optimize import brentq
from scipy.stats import qmc

import ehl
from ehl.heat.estimate import convection_error

LAYERS, TURNS, FINER = 31, 20, 3
# oil, temperature, pressure, radius, entrainment [m/s], slide-to-roll ratio
CASES = (
    ("75w90", "90 degC", "0.6 GPa", "20 mm", 20.0, 0.3),
    ("75w90", "60 degC", "0.8 GPa", "20 mm", 15.0, 0.3),
    ("eaxle", "60 degC", "0.6 GPa", "15 mm", 30.0, 0.2),
    ("fva3", "60 degC", "1 GPa", "15 mm", 10.0, 0.5),
    ("pao220", "70 degC", "0.5 GPa", "10 mm", 12.0, 0.1),
    ("75w90", "40 degC", "0.4 GPa", "15 mm", 10.0, 0.2),
    ("75w90", "90 degC", "1.2 GPa", "15 mm", 5.0, 0.3),
    ("fva3", "90 degC", "1.5 GPa", "15 mm", 3.0, 0.4),
    ("minr", "80 degC", "1 GPa", "9 mm", 1.0, 0.4),
    ("minr", "64 degC", "0.42 GPa", "15 mm", 12.7, 0.1),
    ("fva3", "83 degC", "0.65 GPa", "15 mm", 45.0, 0.07),
    ("75w90", "40 degC", "0.6 GPa", "15 mm", 30.0, 0.5),
    ("eaxle", "40 degC", "0.8 GPa", "15 mm", 60.0, 1.0),
    ("75w90", "20 degC", "0.6 GPa", "15 mm", 40.0, 1.0),
)


@dataclass(frozen=True)
class Film:
    """A film at given pressure and surface temperature; arrays over x, SI."""

    x: np.ndarray
    pressure: np.ndarray
    film: np.ndarray
    walls: np.ndarray
    raised: np.ndarray  # rise by the heat of the pressure-driven flow
    stress: np.ndarray  # of the solver
    oil: Any
    sliding: float
    rolling: float

    def law(self, i: int) -> tuple[float, float, float]:
        """Eyring stress, limiting stress and conductivity at a node."""
        p, unlimited = np.array([self.pressure[i]]), replace(self.oil.shear_law, limit_slope=math.inf)
        two = (math.exp(float(unlimited.log_stress(np.array([rate]), p)[0][0])) for rate in (60.0, 61.0))
        eyring = -float(np.subtract(*two))
        limit = self.oil.limiting_shear_ambient + self.oil.limiting_shear_coefficient * p[0]
        return eyring, float(limit), float(self.oil.film_conductivity(p[0], self.oil.thermal_conductivity))

    def viscosity(self, i: int, temperature: np.ndarray) -> np.ndarray:
        """eta at a node and some temperatures, to which the rise by the pressure-driven flow is added."""
        return np.exp(self.oil.log_viscosity(np.full(temperature.size, self.pressure[i]), temperature + self.raised[i]))

    def at_mid_film(self) -> np.ndarray:
        """Shear stress with local conduction and the viscosity at mid-film of the parabola."""
        tau = np.zeros(self.x.size)
        for i in np.flatnonzero(self.pressure > 0.0):
            eyring, limit, k = self.law(i)

            def found(stress: float, i: int = i, eyring: float = eyring, limit: float = limit, k: float = k) -> float:
                rise = stress * self.sliding * self.film[i] / (8.0 * k)
                eta = float(self.viscosity(i, np.array([self.walls[i] + rise]))[0])
                return min(eyring * math.asinh(eta * self.sliding / self.film[i] / eyring), limit) - stress

            tau[i] = brentq(found, 0.0, 1.01 * limit + 1e3)
        return tau

    def across(self, convection: bool) -> np.ndarray:
        """Shear stress with the energy equation across the film, with or without convection."""
        z = np.linspace(0.0, 1.0, LAYERS)
        weights = np.full(LAYERS, z[1])
        weights[[0, -1]] *= 0.5
        along = self.rolling + self.sliding * (z - 0.5)
        temperature, tau = np.full(LAYERS, self.walls[0]), np.zeros(self.x.size)
        for i in range(1, self.x.size):
            if self.pressure[i] <= 0.0:
                temperature[:] = self.walls[i]
                continue
            eyring, limit, k = self.law(i)
            density = self.oil.density * float(self.oil.density_ratio(self.pressure[i : i + 1])[0])
            carried = convection * density * self.oil.heat_capacity * along / (self.x[i] - self.x[i - 1])
            through = k / (self.film[i] * z[1]) ** 2
            now = temperature.copy()
            for _ in range(TURNS):
                fluidity = weights / self.viscosity(i, now)
                tau[i] = min(eyring * math.asinh(self.sliding / (fluidity.sum() * self.film[i] * eyring)), limit)
                heat = tau[i] * self.sliding / self.film[i] * fluidity / weights / fluidity.sum()
                band, right = np.zeros((3, LAYERS)), carried * temperature + heat
                band[0, 2:], band[1], band[2, :-2] = -through, carried + 2.0 * through, -through
                band[1, [0, -1]], right[[0, -1]] = through, through * self.walls[i]
                now = 0.5 * (now + solve_banded((1, 1), band, right))
            temperature = now
        return tau


def film_of(result: Any) -> Film:
    """The film of a smooth result on a finer mesh."""
    heat, line = result.heat, result.problem.line
    coarse = np.arange(heat.x.size)
    x = np.interp(np.linspace(0.0, coarse[-1], FINER * coarse.size), coarse, heat.x)
    x = x[x > -4.0 * line.half_width]
    walls = 0.5 * (heat.temperature_flash_1 + heat.temperature_flash_2)
    pressure, height = (np.interp(heat.x, result.film.x, of) for of in (result.film.pressure, result.film.film))
    oil = result.problem.lubricant
    raised = heat.rolling_heat * height / (20.0 * oil.film_conductivity(pressure, oil.thermal_conductivity))
    rows = (np.interp(x, heat.x, of) for of in (pressure, height, walls, raised, heat.shear_stress))
    return Film(x, *rows, oil, line.speed_sliding, line.speed_entrainment)


def sampled(count: int) -> list[tuple[str, str, str, str, float, float]]:
    """Contacts like `CASES` of six oils, 20 to 110 degC, 0.3 to 1.6 GPa, 3 to 50 m/s, slide-to-roll ratio to 1.5."""
    oils = ("75w90", "eaxle", "fva3", "pao220", "minr", "pg_0_1")
    unit = qmc.Sobol(5, rng=11).random(count)
    return [
        (
            oils[i % 6],
            f"{20.0 + 90.0 * a} degC",
            f"{0.3 * (1.6 / 0.3) ** b} GPa",
            "15 mm",
            3.0 * (50 / 3) ** c,
            0.03 * 50**d,
        )
        for i, (a, b, c, d, _) in enumerate(unit.tolist())
    ]


def main(argv: Sequence[str] | None = None) -> None:
    """Print and write the differences of friction in per cent."""
    parser = command_line(__doc__)
    parser.add_argument("--sample", type=int, default=0)
    options, rows = parser.parse_args(argv), []
    for oil, temperature, pressure, radius, speed, slip in sampled(options.sample) if options.sample else CASES:
        result = ehl.Contact(
            oil=oil, temperature=temperature, pressure_hertz=pressure, radius_equivalent=radius,
            speed_entrainment=speed, slide_to_roll=slip,
        ).solve()  # fmt: skip
        film = film_of(result)
        line, reduction = result.problem.line, result.film.film_central / result.isothermal.film_central
        convection = convection_error(line, result.problem.lubricant, result.film.film_central, reduction)
        mid, solver, local, whole = (
            float(np.trapezoid(tau, film.x))
            for tau in (film.at_mid_film(), film.stress, film.across(False), film.across(True))
        )
        row = {
            "oil": oil, "temperature": temperature, "pressure": pressure, "speed": speed, "slide_to_roll": slip,
            "mu": round(result.friction_coefficient, 5), "Peclet number": round(convection.peclet_film, 3),
            "reduction of the film": round(reduction, 3), "error allowed [%]": 100.0 * convection.friction_change,
            "solver over across [%]": 100.0 * (solver / whole - 1.0),
            "without convection [%]": 100.0 * (local / whole - 1.0),
            "mid-film over across without convection [%]": 100.0 * (mid / local - 1.0),
        }  # fmt: skip
        print("  ".join(f"{v:.2f}" if isinstance(v, float) and name != "mu" else str(v) for name, v in row.items()))
        rows.append(row)
    write_rows(OUT / "film_heat.csv", rows)


if __name__ == "__main__":
    main()
