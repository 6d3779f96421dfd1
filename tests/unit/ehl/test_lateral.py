"""Lateral elasticity and side flow of rough contacts: kernel, wave number, mean total pressure, outflow of spots."""

import math

import numpy as np
import pytest
from scipy.integrate import dblquad, quad
from scipy.special import k0
from twins.exact_elasticity import elastic_error
from twins.rough_scenes import Scene, eyring_oil, gaussian_pair, line

from ehl.compile.compiler import FAST_KERNEL, kernel
from ehl.rough._kernels.quasi_separable import MODES, exponential_product
from ehl.rough._kernels.side_flow import (
    OUTFLOW_MAX,
    OUTFLOW_PRESSURE,
    deflect_mean,
    isotropic_outflow,
    update_mean_total,
)
from ehl.rough.exponential_sums import bessel_kernel, quad_bessel
from ehl.rough.run import TransientRun
from ehl.rough.scaling import ELASTIC_MODES, MARKS_ALONG, flattening_wave_number

RMS = 0.4e-6
WAVE_NUMBERS = (0.003, 0.02, 0.1, 0.3, 1.0)  # per node


@kernel(cache=False, **FAST_KERNEL)  # it compiles kernels of other files in
def update(macro, work, model):  # type: ignore[no-untyped-def]
    update_mean_total(macro, work, model)


@kernel(cache=False, **FAST_KERNEL)
def outflow(state, macro, work, model):  # type: ignore[no-untyped-def]
    isotropic_outflow(state, macro, work, model)


def scene_of(gamma: float, correlation: float = 0.2) -> Scene:
    contact = line(1.0)
    return Scene(contact, eyring_oil(), gaussian_pair(contact, RMS, correlation), 30e-9, gamma)


def run_of(gamma: float, nodes_per_half_width: float = 40.0) -> TransientRun:
    return scene_of(gamma).run(nodes_per_half_width)


# --- kernel


def integrated(k: float, distance: float) -> float:
    """Integral of K0 over a cell by quadrature, in two parts where the logarithm is inside."""
    if distance == 0.0:
        return 2.0 * float(quad(lambda s: k0(k * s), 0.0, 0.5, epsrel=1e-11)[0])
    return float(quad(lambda s: k0(k * s), distance - 0.5, distance + 0.5, epsabs=0.0, epsrel=1e-11)[0])


@pytest.mark.parametrize("k", WAVE_NUMBERS)
def test_bessel_kernel_is_the_integral_of_k0_within_its_stated_error(k: float) -> None:
    """The long sum is as good as the ten modes of the logarithm, the short one serves the Newton matrix."""
    distance = np.unique(np.round(np.geomspace(1.0, 11.0 / k + 2.0, 40)))
    exact = np.array([integrated(k, d) for d in distance])
    np.testing.assert_allclose([quad_bessel(k, d) for d in distance], exact, rtol=1e-6, atol=1e-8)
    own = integrated(k, 0.0)
    assert quad_bessel(k, 0.0) == pytest.approx(own, rel=1e-10)
    bounds = (2e-4, 0.1 if k < 0.01 else 0.02)
    for found, modes, bound in zip(bessel_kernel(k, ELASTIC_MODES, MODES), (ELASTIC_MODES, MODES), bounds, strict=True):
        assert found.weights.size == found.ratios.size == modes
        assert found.evaluate(np.zeros(1))[0] == pytest.approx(own, rel=1e-12)
        deviation = np.abs(found.evaluate(distance) - exact).max()
        assert deviation <= found.error * 1.05
        assert found.error < bound  # K0 of the next node is 5.2 to 0.4
        assert np.all((found.ratios >= 0.0) & (found.ratios < 1.0))
        assert np.all(found.weights[:-1] >= 0.0)


@pytest.mark.parametrize("waves", [0.3, 1.0, 3.0])
def test_cosine_pressure_deflects_by_the_symbol_of_the_mode(waves: float) -> None:
    """V = 4 p/(E' sqrt(k_x^2 + k_e^2)) in the middle of the mesh, SI; k_x in k_e."""
    scene = scene_of(1.0, 0.1)
    run = scene.run(200.0)
    units, elastic = run.problem.units, run.problem.model.elastic
    wave_number = flattening_wave_number(scene.surfaces.correlation_length, 1.0)
    x = run.problem.x
    pressure = np.cos(waves * wave_number * units.half_width * x)
    response = np.zeros(x.size)
    exponential_product(pressure, elastic.weights, elastic.ratios, response)
    middle = np.abs(x) < 0.5
    exact = 4.0 * units.pressure / (228e9 * wave_number * math.hypot(waves, 1.0)) * pressure
    np.testing.assert_allclose(response[middle] * units.film, exact[middle], atol=0.01 * exact.max())


@pytest.mark.parametrize("gamma", [0.5, 1.0, 2.0, 6.0, 20.0])
def test_wave_number_of_the_flattening_pressure_is_that_of_the_spectrum(gamma: float) -> None:
    """<k_y^2 k^2>/<k^2> by two-dimensional integrals of exp(-(k_x^2 + gamma^2 k_y^2) lc^2/4), lc = 1.

    Less for marks along the motion, by a factor after two-dimensional solutions.
    """

    def moment(power: int) -> float:
        def weighted(v: float, u: float) -> float:
            y = v / gamma
            return float(y**power * (u * u + y * y) * math.exp(-0.25 * (u * u + v * v)))

        return float(dblquad(weighted, 0.0, 16.0, 0.0, 16.0, epsrel=1e-9)[0])

    exact = math.sqrt(moment(2) / moment(0)) * min(gamma, 1.0) ** MARKS_ALONG
    assert flattening_wave_number(20e-6, gamma) == pytest.approx(exact / 20e-6, rel=1e-7)


# --- mean total pressure


def test_a_pressure_that_is_its_own_mean_deflects_by_the_line_kernel() -> None:
    """V = K_log Q + K_e (q - Q): with q = Q the exact logarithm is left, with Q = 0 the lateral mode alone."""
    run = run_of(1.0)
    pressure = np.sqrt(np.maximum(1.0 - run.problem.x**2, 0.0)) * (1.0 + 0.2 * np.cos(9.0 * run.problem.x))
    run.state.fluid_pressure[:], run.state.contact_pressure[:] = pressure, 0.0
    run.macroscopic.total[:] = pressure
    deflect_mean(run.macroscopic, run._work, run.problem.model)
    assert elastic_error(run) < 0.01
    run.macroscopic.total[:] = 0.0
    deflect_mean(run.macroscopic, run._work, run.problem.model)
    assert np.all(run.macroscopic.deflection == 0.0)


def dense(elastic: object, n: int) -> np.ndarray:
    """A sum of exponentials as a matrix."""
    distance = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    powers = elastic.ratios[:, None, None] ** distance  # type: ignore[attr-defined]
    return np.asarray(np.einsum("m,mij->ij", elastic.weights, powers))  # type: ignore[attr-defined]


@pytest.mark.parametrize(("gamma", "softness"), [(1.0, 0.03), (1.0, 0.3), (6.0, 0.1)])
def test_mean_total_pressure_reaches_the_time_mean_at_constant_load(gamma: float, softness: float) -> None:
    """A film that answers linearly, (D + K_e) q = g - (K_log - K_e) Q - h0 with sum q = W, and has one fixed point.

    D is `softness` times the diagonal of the kernel, not what the solver assumes, and grows threefold along x. Q starts
    with more than the load. Plain averages, Q += gain (q - Q), diverge at gamma 1: long waves of Q move q by more than
    themselves.
    """
    run = scene_of(gamma, 0.05).run(60.0)
    macro, model, x = run.macroscopic, run.problem.model, run.problem.x
    inside = np.abs(x) < 1.0
    wanted = np.where(inside, np.sqrt(np.maximum(1.0 - x * x, 0.0)) * (1.0 + 0.3 * np.cos(7.0 * x)) + 0.05, 0.0)
    wanted *= model.contact.load / wanted.sum()
    lateral, long = dense(model.elastic, x.size), dense(model.elastic_mean, x.size)
    film = softness * lateral[0, 0] * np.diag(2.0 + x)
    soft = (film + lateral)[np.ix_(inside, inside)]
    shape = ((film + long) @ wanted)[inside]
    system = np.block([[soft, np.ones((len(soft), 1))], [np.ones((1, len(soft))), np.zeros((1, 1))]])

    def answer() -> np.ndarray:
        right = np.append(shape - ((long - lateral) @ macro.total)[inside], model.contact.load)
        found = np.zeros(x.size)
        found[inside] = np.linalg.solve(system, right)[:-1]
        return found

    macro.total[:] *= 1.05  # more than the load
    distance = []
    for _ in range(100):
        mean = answer()
        distance.append(np.abs(mean - macro.total).max())
        macro.sum_total[:] = 7.0 * mean
        macro.counts[0] = 7
        update(macro, run._work, model)
        assert np.all(macro.sum_total == 0.0)
        assert tuple(macro.counts) == (0, len(distance))
    assert distance[0] > 0.05
    assert distance[40] < 1e-4 * distance[0]
    assert np.abs(macro.total - wanted).max() < 1e-5
    assert macro.total.sum() == pytest.approx(model.contact.load, rel=1e-6)
    np.testing.assert_allclose(macro.deflection, (long - lateral) @ macro.total, rtol=1e-8, atol=1e-9)


# --- outflow of spots


def outflow_of(curvature: float, height: float = 0.1, known: float = 1.0, exchange: float = 3.0) -> np.ndarray:
    """Factors under p = P + height - curvature (i - 60)^2, fluidity 3 and an exchange of 3 times the known factor."""
    run = run_of(1.0)
    state, macro, work = run.state, run.macroscopic, run._work
    i = np.arange(state.film.size)
    macro.pressure[:] = 0.4
    state.fluid_pressure[:] = 0.4 + np.maximum(height - curvature * (i - 60.0) ** 2, -0.2)
    state.outflow[:] = known
    work.node.f[:] = 3.0
    work.exchange[:] = exchange * known
    outflow(state, macro, work, run.problem.model)
    return state.outflow.copy()


def test_outflow_of_a_parabolic_spot_by_hand() -> None:
    """-(1/gamma^2) d/dx [f d(p - P)/dx] = 2 f curvature/gamma^2, over the exchange k f (p - P) of the mean field.

    Averaged over the correlation length, 8 nodes, a parabola stays what it is. The factor moves with the fluid by one
    node, and does not know of the factor that was there.
    """
    isotropic = run_of(1.0).problem.model.side_flow.isotropic
    curvature, i = 0.005, np.arange(58, 63)
    excess = 0.1 - curvature * (i - 60.0) ** 2
    wanted = np.clip(isotropic * 2.0 * curvature / excess, 1.0, OUTFLOW_MAX)
    assert 1.0 < wanted.min() < wanted.max() < OUTFLOW_MAX
    found = outflow_of(curvature)
    np.testing.assert_allclose(found[i + 1], wanted, rtol=1e-10)
    np.testing.assert_allclose(outflow_of(curvature, known=2.5)[i + 1], wanted, rtol=1e-10)


def test_outflow_is_never_below_that_of_the_mean_field_and_bounded() -> None:
    assert np.all(outflow_of(-1e-3, 0.1) == 1.0)  # a spot that its neighbours feed
    assert outflow_of(0.005, exchange=0.03)[61] == OUTFLOW_MAX
    assert outflow_of(10.0, 0.5)[61] == 1.0  # a spike of one node drains no more than it is wide
    assert np.all(outflow_of(1e-3, 0.9 * OUTFLOW_PRESSURE) == 1.0)


@pytest.mark.parametrize(("gamma", "nodes_per_half_width"), [(1.0, 40.0), (1.0, 80.0), (3.0, 40.0)])
def test_outflow_counts_lengths_in_the_mode_along_the_line(gamma: float, nodes_per_half_width: float) -> None:
    """1/(gamma k_e dx)^2: the same spot on half the spacing has a quarter of its curvature per node."""
    scene = scene_of(gamma)
    run = scene.run(nodes_per_half_width)
    lengths = gamma * flattening_wave_number(scene.surfaces.correlation_length, gamma) * run.problem.units.spacing
    assert run.problem.model.side_flow.isotropic == pytest.approx(lengths**-2.0, rel=1e-12)
