"""A small wave through the contact in pure rolling: the engine, the linear theory of the same equations, and the curve.

The linear theory shares nothing with the engine but the laws of the oil: smooth film of `ehl.smooth`, dense exactly
integrated kernel, one complex system per wavelength instead of time steps.
"""

import math
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.linalg import toeplitz
from twins.rough_scenes import Scene, eyring_oil, line

from ehl.fluid.lubricant import Lubricant
from ehl.line_contact import LineContact
from ehl.rough import RoughSurfaces
from ehl.rough.accuracy import inlet_sweep
from ehl.rough.dry import DeflectionOperator
from ehl.smooth.solver import SteadyResult, solve_steady
from ehl.surface.roughness import RoughProfile

VISCOSITY, ALPHA = 0.04, 18e-9
FARTHEST = 12.0  # reach of the linear mesh ahead of the contact [b]


def oil_of() -> Lubricant:
    """Newtonian oil of both studies."""
    return eyring_oil(VISCOSITY, ALPHA, rheology="newtonian")


def curve(g: float) -> float:
    """Ad/Ai of Venner, Couhier, Lubrecht & Greenwood (1997); ``g`` = (wavelength/b) M^0.75/L^0.5."""
    return 1.0 / (1.0 + 0.125 * g + 0.04 * g * g)


def wavy(contact: LineContact, wavelength: float, amplitude: float) -> RoughSurfaces:
    """One surface with a cosine of the wavelength [b] and amplitude [m]."""
    length = wavelength * contact.half_width
    points = 64
    heights = amplitude * np.cos(2.0 * np.pi * np.arange(4 * points) / points)
    profile = RoughProfile.of(heights, length / points, cutoff=length)
    return RoughSurfaces(profile, None)


def mesh_of(contact: LineContact, oil: Lubricant, wavelength: float) -> float:
    """Nodes per b that resolve the wave and the inlet of the smooth film."""
    return max(60.0, 30.0 / wavelength, 5.0 / inlet_sweep(contact, contact.film_moes(oil)))


def attenuation(contact: LineContact, oil: Lubricant, wavelength: float, nodes_per_b: float) -> tuple[float, float]:
    """Amplitude of the film over that of the rigid wave, in the middle of the contact, and the formula's g."""
    film = contact.film_moes(oil)
    amplitude = 0.05 * film
    scene = Scene(contact, oil, wavy(contact, wavelength, amplitude), 1e-9)
    run = scene.run(nodes_per_b)
    per_b = run.problem.units.steps_per_half_width
    run.advance(round(max(4.0, 2.0 + 2.0 * wavelength) * per_b))
    middle = int(np.argmin(np.abs(run.problem.x)))
    steps = round(2.0 * wavelength * per_b)
    history = np.zeros(steps)
    for k in range(steps):
        run.advance(1)
        history[k] = run.state.film[middle]
    phase = 2.0 * np.pi * np.arange(steps) / (wavelength * per_b)
    # least squares: the steps need not divide the wave, and the mean film is 20 times the wave
    basis = np.column_stack([np.ones(steps), np.cos(phase), np.sin(phase)])
    _, cosine, sine = np.linalg.lstsq(basis, history)[0]
    deformed = math.hypot(cosine, sine) * run.problem.units.film
    load, material = contact.moes_groups(oil)
    return deformed / amplitude, wavelength * load**0.75 / math.sqrt(material)


def linear_attenuation(
    contact: LineContact, oil: Lubricant, smooth: SteadyResult, wavelength: float, nodes_per_b: float
) -> float:
    """Ad/Ai of an infinitely small wave by the linearised transient Reynolds equation (ours).

    With every change proportional to exp(i k (u t - x)), k = 2 pi/wavelength, and hats for its amplitude,

        dF/dx = u exp(-i k x) d/dx[exp(i k x) m],    m = rho h + rho' h0 p,    h = delta + K p - exp(-i k x)
        F = f0 dp/dx + f0 dp0/dx [3 h/h0 + (rho'/rho0 - eta'/eta) p],    f0 = rho0 h0^3/(12 eta),    sum p = 0

    with the smooth film of the same contact (index 0), pure rolling, Newtonian. p = 0 at the inlet and the smooth exit;
    wavelength in b.
    """
    b, u = contact.half_width, contact.speed_entrainment
    dx = b / nodes_per_b
    first, last = max(smooth.x[0], -FARTHEST * b), smooth.x_exit
    x = dx * np.arange(math.ceil(first / dx), math.floor(last / dx) + 1)
    n, middle = x.size, 0.5 * (x[1:] + x[:-1])
    pressure, film = PchipInterpolator(smooth.x, smooth.pressure), PchipInterpolator(smooth.x, smooth.film)
    p, h = np.maximum(pressure(x), 0.0), film(x)
    p_half, h_half = np.maximum(pressure(middle), 0.0), film(middle)
    rho_half = oil.density_ratio(p_half)
    fluidity = rho_half * h_half**3 / (12.0 * oil.viscosity(p_half))
    wedge = fluidity * pressure.derivative()(middle)
    by_film = 3.0 * wedge / h_half
    by_pressure = wedge * (oil.compression.slope(p_half) / rho_half - oil.pressure_law.by_pressure(p_half))

    # columns: p/p_h at the nodes, delta, and the given wave
    wave = np.exp(-2j * np.pi * x / (wavelength * b))
    pressures = np.hstack([contact.pressure_hertz * np.eye(n), np.zeros((n, 2))])
    bent = toeplitz(DeflectionOperator(n, dx, contact.effective_modulus).coefficients) * contact.pressure_hertz
    films = np.hstack([bent, np.ones((n, 1)), -wave[:, None]])
    mass = oil.density_ratio(p)[:, None] * films + (oil.compression.slope(p) * h)[:, None] * pressures
    flux = (fluidity / dx)[:, None] * np.diff(pressures, axis=0)
    flux = flux + 0.5 * by_film[:, None] * (films[1:] + films[:-1])
    flux += 0.5 * by_pressure[:, None] * (pressures[1:] + pressures[:-1])
    carried = np.conj(wave)[:, None] * mass
    slope = np.zeros_like(carried)
    slope[1] = carried[1] - carried[0]
    slope[2:] = 1.5 * carried[2:] - 2.0 * carried[1:-1] + 0.5 * carried[:-2]
    system = np.zeros((n + 1, n + 2), dtype=complex)
    system[1 : n - 1] = np.diff(flux, axis=0) / u - (wave[:, None] * slope)[1 : n - 1]
    system[0, 0] = system[n - 1, n - 1] = 1.0
    system[n, :n] = 1.0
    answer = np.append(np.linalg.solve(system[:, :-1], -system[:, -1]), 1.0)
    return float(np.interp(0.0, x, np.abs(films @ answer)))


def contact_of(load: float, material: float) -> LineContact:
    """The contact in pure rolling with Moes's groups M = W (2U)^-0.5 and L = alpha E' (2U)^0.25."""
    modulus, radius = line(1.0).effective_modulus, line(1.0).radius_equivalent
    twice_speed = (material / (ALPHA * modulus)) ** 4
    per_length = load * math.sqrt(twice_speed)  # W
    speed = 0.5 * twice_speed * modulus * radius / VISCOSITY
    return line(speed, 0.0, modulus * math.sqrt(per_length / (2.0 * math.pi)))


def main() -> None:
    """Draw docs/figures/waviness.png: engine, linear theory and curve."""
    oil = oil_of()
    figure, axes = plt.subplots(figsize=(6.5, 4.2))
    many = np.geomspace(0.1, 60, 200)
    axes.semilogx(many, [curve(g) for g in many], "k-", label="1/(1 + 0.125 g + 0.04 g²)")
    theory = [
        (g, linear_attenuation(contact, oil, smooth, wavelength, max(90.0, 30.0 / wavelength)))
        for material in (5.0, 10.0, 15.0, 20.0)
        for load in (5.0, 10.0, 30.0, 100.0)
        for contact in [contact_of(load, material)]
        for smooth in [solve_steady(contact, oil, accuracy="reference")]
        for g in (0.3, 0.7, 1.0, 1.5, 2.5, 5.0, 8.0)
        if smooth.status == "converged" and 0.2 < (wavelength := g * math.sqrt(material) / load**0.75) < 3.0
    ]
    axes.semilogx(*zip(*theory, strict=True), "k.", ms=3, alpha=0.5, label="linear theory, M 5 to 100, L 5 to 20")
    for speed, pressure in ((5.0, 0.7e9), (5.0, 1.2e9), (1.0, 1.2e9), (0.3, 1.5e9)):
        contact = line(speed, 0.0, pressure)
        load, material = contact.moes_groups(oil)
        found = [attenuation(contact, oil, w, mesh_of(contact, oil, w)) for w in (0.125, 0.25, 0.5, 1.0, 2.0)]
        label = f"solver, M {load:.0f}, L {material:.1f}"
        axes.semilogx([g for _, g in found], [value for value, _ in found], "o", label=label)
    axes.set(xlabel="g = (wavelength/b) M^0.75/L^0.5", ylabel="Ad/Ai")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(Path(__file__).parents[2] / "docs" / "figures" / "waviness.png", dpi=130)


if __name__ == "__main__":
    main()
