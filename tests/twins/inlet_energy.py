"""Pressure gradient of a hot inlet with the energy equation across the film, by finite differences.

Generalised Reynolds equation (Dowson 1962) without convection: the stress is tau_m + y dp/dx, each layer has its own
temperature, and dp/dx and tau_m give the flow u_r (h - h*) and the sliding speed. Nothing is linearised, and the heat
is that of the whole stress. Sliding is along or across the flow.
"""

import math
from collections.abc import Callable

import numpy as np
from scipy.linalg import solve_banded

LAYERS = 61


def gradient(
    viscosity: Callable[[np.ndarray], np.ndarray],  # over temperature, at the pressure of the place
    eyring: float,  # infinite for a Newtonian film
    film: float,
    flow: float,  # u_r (h - h*)
    sliding: float,
    across: bool,  # sliding at right angles to the flow
    conductivity: float,
    wall: float,  # temperature of both surfaces
) -> float:
    """dp/dx at one place of the inlet."""
    y = np.linspace(-0.5, 0.5, LAYERS) * film
    weights = np.full(LAYERS, y[1] - y[0])
    weights[[0, -1]] *= 0.5
    curve = np.diag(np.full(LAYERS, 2.0)) - np.diag(np.ones(LAYERS - 1), 1) - np.diag(np.ones(LAYERS - 1), -1)
    curve *= conductivity / (y[1] - y[0]) ** 2
    curve[[0, -1]] = 0.0
    curve[0, 0] = curve[-1, -1] = 1.0
    temperature = np.full(LAYERS, wall)
    eta = float(viscosity(np.array([wall]))[0])
    unit = np.array([12.0 * eta * flow / film**3, max(eta * sliding / film, 1e-6)])
    found = np.ones(2)

    def rates(found: np.ndarray, fluidity: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rates along the flow and the sliding, and the heat."""
        slope, middle = found * unit
        along, other = (y * slope, np.full(LAYERS, middle)) if across else (middle + y * slope, np.zeros(LAYERS))
        stress = np.hypot(along, other)
        thinning = np.sinh(stress / eyring) / np.maximum(stress / eyring, 1e-12) if math.isfinite(eyring) else 1.0
        rate = fluidity * thinning
        return rate * along, rate * (other if across else along), rate * stress**2

    def excess(found: np.ndarray, fluidity: np.ndarray) -> np.ndarray:
        along, sheared, _ = rates(found, fluidity)
        speed = weights @ sheared / max(sliding, 1e-9) - 1.0 if sliding > 0.0 else found[1]
        return np.array([weights @ (y * along) / flow - 1.0, speed])

    for _ in range(200):
        fluidity = 1.0 / viscosity(temperature)
        for _ in range(4):
            here, step = excess(found, fluidity), 1e-6 * np.eye(2)
            slopes = np.array([excess(found + row, fluidity) - here for row in step]).T / 1e-6
            found = found - np.linalg.solve(slopes, here)
        heat = rates(found, fluidity)[2]
        heat[[0, -1]] = wall
        change = np.linalg.solve(curve, heat) - temperature
        temperature = temperature + 0.7 * change
        if np.abs(change).max() < 1e-7:
            return float(found[0] * unit[0])
    raise AssertionError("no balance of the layers")


def flow_rises(
    x: np.ndarray, film: np.ndarray, heat: np.ndarray, rolling: float, capacity: float, conductivity: float,
    wall: np.ndarray | None = None,
) -> np.ndarray:  # fmt: skip
    """Rise above the walls by heat with convection: its mean, and with the weight 12 (y/h)^2.

    rho c u dT/dx = k d2T/dy2 + 12 (q/h) (y/h)^2 for the heat of the pressure-driven flow, with the parabolic velocity
    of the flow and no reversed flow. With a temperature of the walls: even heat q/h and even velocity.
    """
    y = np.linspace(-0.5, 0.5, LAYERS)
    even, wall = wall is not None, np.zeros(x.size) if wall is None else wall
    weights = np.full(LAYERS, y[1] - y[0])
    weights[[0, -1]] *= 0.5
    rise, found = np.zeros(LAYERS), np.zeros((x.size, 2))
    for i in range(1, x.size):
        back = 1.5 * (1.0 - film[-1] / film[i]) * (1.0 - 4.0 * y**2)
        speed = np.full(LAYERS, rolling * film[-1] / film[i]) if even else np.maximum(rolling * (1.0 - back), 0.0)
        carried, through = capacity * speed / (x[i] - x[i - 1]), conductivity / (film[i] * (y[1] - y[0])) ** 2
        band = np.zeros((3, LAYERS))
        right = carried * (rise + wall[i - 1] - wall[i]) + heat[i] / film[i] * (1.0 if even else 12.0 * y**2)
        band[0, 2:], band[1], band[2, :-2] = -through, carried + 2.0 * through, -through
        band[1, [0, -1]], right[[0, -1]] = through, 0.0  # of the size of the others, or rows are exchanged
        rise = solve_banded((1, 1), band, right)
        found[i] = weights @ rise, 12.0 * weights @ (y**2 * rise)
    return found
