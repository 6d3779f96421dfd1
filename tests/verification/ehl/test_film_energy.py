"""Pressure gradient of a hot inlet against the energy equation across the film."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from contacts import hot_oil, line_contact
from scipy.integrate import quad
from scipy.linalg import solve_banded

from ehl.fluid._kernels import log_mobility
from ehl.fluid.lubricant import FilmConductivity, Lubricant
from ehl.heat import _kernels
from ehl.heat._kernels import Film, flow_heat
from ehl.heat.traction import RISE, FilmTemperature, film_temperature, flow_shares

RADIUS, GAP, ROLLING = 15e-3, 1.2e-6, 5.0
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
    """dp/dx at one place of the inlet by the energy equation across the film, by finite differences.

    Generalised Reynolds equation (Dowson 1962) without convection: the stress is tau_m + y dp/dx, each layer has its
    own temperature, and dp/dx and tau_m give the flow u_r (h - h*) and the sliding speed. Nothing is linearised, and
    the heat is that of the whole stress. Sliding is along or across the flow.
    """
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


def test_shares_of_the_mobilities_against_quadrature() -> None:
    """Profile of an exponential viscosity: S = a tanh a, 1/eta falls as 1/cosh(2 a y/h)^2."""
    for a in (0.05, 0.5, 1.5, 5.0, 50.0):
        heat, shear = a * math.tanh(a), math.tanh(a) / a
        along, across = flow_shares(np.array([0.04]), np.array([heat / 0.04]), np.zeros(1))[:, 0]
        weighted = quad(lambda y, a=a: 24.0 * y**2 / math.cosh(2.0 * a * y) ** 2, 0.0, 0.5)[0]
        assert across == pytest.approx(weighted / shear, rel=1e-3)
        assert along == pytest.approx(1.5 / heat * (1.0 - 2.0 * a / math.sinh(2.0 * a)), rel=1e-3)
        if a == 0.05:  # a flow across the sliding sees 2/5 of the rise at mid-film, the shear 2/3
            share = (math.log(math.sinh(2.0 * a) / (2.0 * a)) + math.log(across)) / heat
            assert share == pytest.approx(0.4, abs=2e-3)
    cold = flow_shares(np.array([0.04, -0.04]), np.array([0.0, 10.0]), np.zeros(2))
    np.testing.assert_allclose(cold, 1.0)


def test_heat_of_the_pressure_driven_flow_is_a_quartic() -> None:
    """Heat as y^2: mean rise 4/5, with the weight of the flow 4/7 of that at mid-film, q h/(16 k)."""
    rise = lambda y: 1.0 - y**4  # noqa: E731
    mean = quad(rise, 0.0, 1.0)[0]
    flow = quad(lambda y: 3.0 * y**2 * rise(y), 0.0, 1.0)[0]
    assert (mean, flow) == pytest.approx((4.0 / 5.0, 4.0 / 7.0))
    decay, middle = 0.04, 0.003  # q h/(8 k) is twice the rise at mid-film
    shares = flow_shares(np.array([decay]), np.zeros(1), np.array([2.0 * middle]))
    np.testing.assert_allclose(np.log(shares), -decay * (mean - flow) * middle, rtol=1e-4)


def balanced(sliding: float, across: bool, eyring: float) -> tuple[FilmTemperature, np.ndarray, Lubricant]:
    """Film temperatures of an inlet between cold surfaces, with the pressure gradient in balance with its heat."""
    oil = hot_oil(
        viscosity_inlet=0.05, viscosity_law="barus", rheology="newtonian" if math.isinf(eyring) else "eyring",
        eyring_stress=min(eyring, 1e9), film_conductivity=FilmConductivity(c1=0.0, c2=0.0),
    )  # fmt: skip
    x = np.linspace(-1.5e-3, -0.1e-3, 1401)
    film = GAP + x**2 / (2.0 * RADIUS)
    cold = np.cumsum(12.0 * oil.viscosity_inlet * ROLLING * (film - GAP) / film**3) * (x[1] - x[0])
    pressure = -np.log1p(-np.minimum(oil.pressure_viscosity * cold, 0.93)) / oil.pressure_viscosity
    at = np.searchsorted(pressure, [0.03e9, 0.09e9, 0.15e9])
    pressure, film = pressure[at], film[at]
    along, cross = (0.0, sliding) if across else (sliding, 0.0)
    speeds = {"speed_entrainment": ROLLING, "slide_to_roll": along / ROLLING, "speed_sliding_lengthwise": cross}
    line = line_contact(**speeds, radius_equivalent=RADIUS)
    none, k = np.zeros((at.size, at.size)), np.full(at.size, oil.thermal_conductivity)
    slope, flow = np.zeros(at.size), ROLLING * (film - GAP)
    shear = oil.shear_law.numbers(1.0, 1.0, 1.0)
    for _ in range(40):
        bulk, heat = (oil.temperature,) * 2, flow * slope
        found = film_temperature(pressure, film, k, line, oil, bulk, (none, none), rolling_heat=heat)
        mobility = np.zeros(at.size)
        first, second = np.exp(found.log_flow_shares)
        cosine = line.sliding_cosine**2 if sliding > 0.0 else 1.0
        weights = cosine * first, cosine * (first - second) + (1.0 - cosine) * second
        for i in range(at.size):
            log_eta = float(oil.log_viscosity(pressure[i : i + 1], found.temperature[i : i + 1])[0])
            for direction, weight in zip((1.0, 0.0), weights, strict=True):
                one = log_mobility(log_eta, max(line.speed_sliding, 1e-9), film[i], pressure[i], direction, shear)[0]
                mobility[i] += weight[i] * math.exp(one)
        slope = 12.0 * flow / (film**3 * mobility)
    return found, slope, oil


@pytest.mark.parametrize(
    ("sliding", "across", "eyring", "tolerance"),
    [
        (0.0, False, math.inf, 0.01), (5.0, False, math.inf, 0.01), (10.0, False, math.inf, 0.01),
        (5.0, False, 8e6, 0.01), (10.0, True, math.inf, 0.02), (10.0, True, 8e6, 0.02),
    ],
)  # fmt: skip
def test_pressure_gradient_of_a_hot_inlet(sliding: float, across: bool, eyring: float, tolerance: float) -> None:
    """Mobilities between 0.97 and 0.75 of those at the film temperature."""
    found, slope, oil = balanced(sliding, across, eyring)
    assert found.converged
    for i, (p, h) in enumerate(zip(found.pressure, found.film, strict=True)):
        twin = gradient(
            lambda t, p=p: np.exp(oil.log_viscosity(np.full(t.size, p), t)), eyring, h, ROLLING * (h - GAP), sliding,
            across, oil.thermal_conductivity, oil.temperature,
        )  # fmt: skip
        assert slope[i] == pytest.approx(twin, rel=tolerance)


@pytest.mark.parametrize(("gap", "rolling"), [(1e-6, 8.0), (2e-6, 12.0)])
def test_heat_of_the_flow_with_convection(gap: float, rolling: float) -> None:
    """Inlet of a Hertz contact up to the reduced pressure 0.93; thermal loading 0.35 and 1.4."""
    half, radius, alpha, k, capacity = 0.15e-3, 20e-3, 18e-9, 0.14, 1.8e6
    x = np.linspace(-2e-3, -half, 2001)
    away = -x / half
    root = np.sqrt(np.maximum(away**2 - 1.0, 0.0))
    film = gap + half**2 / (2.0 * radius) * (away * root - np.log(away + root))
    reduced = np.cumsum((film - gap) / film**3)
    pressure = -np.log1p(-0.93 * reduced / reduced[-1]) / alpha
    heat = rolling * (film - gap) * np.gradient(pressure, x)
    mean, flow = flow_rises(x, film, heat, rolling, capacity, k).T
    length = capacity * rolling * gap * film / (12.0 * k)
    mine = flow_heat(x, pressure, film, np.ones(x.size), length, rolling) * film / k
    inside = (pressure > 0.01e9) & (pressure < 0.1e9)
    np.testing.assert_allclose(mine[inside] / 20.0, mean[inside], rtol=0.04)
    np.testing.assert_allclose(mine[inside] / 28.0, flow[inside], rtol=0.1)


@pytest.mark.parametrize(("length", "tolerance"), [(0.3, 0.003), (3.0, 0.015)])
def test_convected_heat_of_the_shear(length: float, tolerance: float) -> None:
    """Even heat in a Hertz contact and its inlet, walls that get warmer; ``length`` C h/(12 k) in half-widths."""
    half, k, capacity = 0.2e-3, 0.27, 1.8e6
    x = np.linspace(-3.0, 1.0, 3001) * half
    film = 1e-6 * (1.0 + np.maximum(-x / half - 1.0, 0.0) ** 1.5)
    heat = 5e7 * np.exp(-4.0 * np.maximum(-x / half - 1.0, 0.0)) * (1.2 + np.sin(3.0 * x / half))
    wall = 8.0 / (1.0 + np.exp(-4.0 * x / half))
    rolling = length * 12.0 * k * half / (capacity * film[-1] ** 2)
    mean = flow_rises(x, film, heat, rolling, capacity, k, wall)[:, 0]
    coarse = np.concatenate([np.linspace(0, 1500, 41), np.linspace(1500, 3000, 61)[1:]]).astype(int)
    nodes, found = np.zeros((_kernels.ROWS, coarse.size)), np.empty(coarse.size)
    flow = capacity * rolling * film[-1]
    lengths = flow * film[coarse] / (12.0 * k)
    _kernels.fill_convection(nodes, x[coarse], lengths, wall[coarse], flow)
    model = Film(nodes, 1.0, hot_oil().shear_law.numbers(1.0, 1.0, 1.0), 0.0, math.inf, RISE)
    _kernels.conducted(model, heat[coarse], found)
    inside = x[coarse] > -half
    rise, local = (q * film[coarse] / (12.0 * k) for q in (found, heat[coarse]))
    np.testing.assert_allclose(rise[inside], mean[coarse][inside], rtol=0.0, atol=tolerance * local.max())
    assert np.abs(local - mean[coarse])[inside].max() > 20.0 * tolerance * local.max()
