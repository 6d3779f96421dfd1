"""Kernels of the transient solver against plain NumPy twins."""

import math
from dataclasses import replace

import numpy as np
import pytest
from contacts import line_contact

from ehl.common.data import data_names
from ehl.compile._kernels import log as log_of_one
from ehl.fluid._kernels import inlet_laws
from ehl.fluid.density import TaitCompression
from ehl.fluid.free_volume import McEwenPaluch
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.rough._kernels.fluid import fluidity_rows, temperature_place
from ehl.rough._kernels.quasi_separable import MODES, factor_and_solve
from ehl.rough._kernels.records import Fluid, FluidityRows
from ehl.rough._kernels.vectors import exp, log
from ehl.rough.exponential_sums import fit_log_kernel, fit_root_kernel, kernel_constant, log_coefficients, log_kernel
from ehl.rough.scaling import Units, scaled_fluid

MODULUS = (3.4e7, 5.0e5, 3.4e-2, 3.0e-5)


def distances(n: int) -> np.ndarray:
    return np.abs(np.subtract.outer(np.arange(n), np.arange(n)))


def test_log_coefficients_are_the_integral_of_the_logarithm() -> None:
    # cell around 0: 1 + ln 2; cell around 1 by exact integration of -ln s over [0.5, 1.5]
    exact = -(1.5 * math.log(1.5) - 1.5 - 0.5 * math.log(0.5) + 0.5)
    np.testing.assert_allclose(log_coefficients(3)[:2], [1.0 + math.log(2.0), exact], rtol=1e-14)


@pytest.mark.parametrize("modes", [MODES, 10])
@pytest.mark.parametrize("n", [64, 512, 4096, 32768])
def test_fitted_log_kernel_states_its_error(n: int, modes: int) -> None:
    table, fit = log_kernel(n, modes), fit_log_kernel(n, modes)
    kernel = log_coefficients(n) + kernel_constant(n)
    for found in (table, fit):
        deviation = np.abs(found.evaluate(np.arange(n, dtype=float)) - kernel)
        assert deviation.max() == pytest.approx(found.error)
        # the kernel spans ln n
        assert found.error < (0.12 if modes == MODES else 3e-4 if n > 512 else 1.2e-5) * math.log(n)
    assert deviation[0] < 1e-12
    # the optimum is flat: where the fit stops depends on the machine, so that the table may be a little better or worse
    assert table.error < 1.01 * fit.error
    assert log_kernel(n, modes) is table
    assert log_kernel(128, 7).weights.size == 7  # not of the table


def test_fitted_root_kernel_against_the_integral() -> None:
    fit = fit_root_kernel(4096)
    j = np.arange(4096, dtype=float)
    exact = 2.0 * (np.sqrt(j + 1.0) - np.sqrt(j))
    assert np.abs(fit.evaluate(j) / exact - 1.0).max() < 5e-3
    # the temperature under a constant flux, which is what the memory computes
    np.testing.assert_allclose(np.cumsum(fit.evaluate(j)), 2.0 * np.sqrt(j + 1.0), rtol=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_quasi_separable_solution_matches_dense(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = 50
    fit = fit_log_kernel(64, MODES)
    weights, ratios = 0.02 * fit.weights, fit.ratios
    kind = rng.integers(0, 4, n)
    kind[rng.integers(0, n)] = 4  # at the cap: no unknown
    band = np.zeros((6, n))
    band[0], band[2] = -rng.random((2, n))
    band[1], band[4] = 2.0 + rng.random(n), 1.0 + rng.random(n)
    band[3], band[5] = 0.3 * rng.standard_normal((2, n))
    band[3, 0] = band[5, -1] = 0.0
    kernel = (ratios[:, None, None] ** distances(n) * weights[:, None, None]).sum(axis=0)
    film = band[4][:, None] * kernel
    film[1:] += band[3, 1:, None] * kernel[:-1]
    film[:-1] += band[5, :-1, None] * kernel[1:]
    pressure = np.diag(band[1]) + np.diag(band[0, 1:], -1) + np.diag(band[2, :-1], 1)
    f, c = np.flatnonzero(kind & 1), np.flatnonzero(kind & 2)
    matrix = np.block(
        [[(pressure + film)[np.ix_(f, f)], film[np.ix_(f, c)]], [kernel[np.ix_(c, f)], kernel[np.ix_(c, c)]]]
    )
    rhs_f, rhs_c, unit = rng.standard_normal((3, n))
    expected = np.linalg.solve(matrix, np.column_stack([np.r_[rhs_f[f], rhs_c[c]], np.r_[unit[f], np.ones(c.size)]]))
    solution = np.zeros((4, n))
    factor_and_solve(0, n, kind, band, weights, ratios, rhs_f, rhs_c, unit, solution, np.zeros((n, 4 + 2 * MODES)))
    for column, rows in ((0, (0, 1)), (1, (2, 3))):
        got = np.r_[solution[rows[0], f], solution[rows[1], c]]
        assert np.abs(got - expected[:, column]).max() < 1e-12 * np.abs(expected[:, column]).max()


def test_elementary_functions_match_the_library() -> None:
    x = np.linspace(-690.0, 690.0, 20001)
    np.testing.assert_allclose([exp(v) for v in x[::50]], np.exp(x[::50]), rtol=1e-15)
    y = np.exp(np.linspace(-300.0, 300.0, 601))
    np.testing.assert_allclose([log(v) for v in y], np.log(y), atol=1e-15, rtol=1e-15)
    np.testing.assert_allclose([log_of_one(v) for v in y], np.log(y), atol=2e-13, rtol=1e-13)
    assert exp(-1e9) == pytest.approx(0.0, abs=1e-300)


def scaled(lubricant: Lubricant, lengthwise: float = 0.0, heated: bool = True) -> Fluid:
    contact = line_contact(slide_to_roll=0.4, speed_sliding_lengthwise=lengthwise)
    return scaled_fluid(contact, lubricant, Units(contact.half_width, 1e9, 1e-6, 2e-6, 4e-7), 20e-6, heated)


def rows_of(film: np.ndarray, pressure: np.ndarray, thermal: float) -> FluidityRows:
    n = film.size
    rows = FluidityRows.of(n)
    rows.film[:], rows.pressure[:], rows.thermal[:] = film, pressure, thermal
    return rows


BOX = Lubricant(0.02, 15e-9, temperature=363.15, temperature_viscosity=0.035)
BOXES = {
    "barus": replace(BOX, viscosity_law="barus"),
    "roelands": BOX,
    "modulus": replace(BOX, viscosity_law="modulus", modulus_constants=MODULUS, temperature_constants=(800.0, 95.0)),
} | {name: replace(Oil.load(name).at(353.15), rheology="newtonian") for name in data_names("oils")}
MCEWEN = McEwenPaluch(K=6e-5, B=900.0, C=95.0, a0=20e-9, a0_fall=5e-3, q=3.0, CF=6.0, pinf=2.5e9, pinf_rise=8e6)
BOXES["mcewen_paluch"] = replace(
    BOX, viscosity_law="mcewen_paluch", absolute_law=MCEWEN, compression=TaitCompression(1e9, 11.0)
)
# what the table is worth for laws near a pole or kink there: of ln(eta/eta0)
TABLE_ERROR = {"5p4e": 2.5e-5, "mcewen_paluch": 2.5e-6, "pg_1_1": 2.5e-6, "fva2": 8e-6}


@pytest.mark.parametrize("name", BOXES)
def test_kernels_read_every_law_to_1e_6_over_pressure_and_temperature(name: str) -> None:
    oil = BOXES[name]
    grids = np.meshgrid(np.linspace(0.0, 4.0, 173), np.linspace(263.0, 600.0, 61))
    pressure, temperature = (grid.ravel() for grid in grids)
    film = np.ones(pressure.size)

    def read(p: np.ndarray, t: np.ndarray, heated: bool) -> FluidityRows:
        fluid = scaled(oil, heated=heated)
        rows = rows_of(film, p, 0.0)
        rows.thermal[:] = [temperature_place(value, fluid.table) for value in t]
        fluidity_rows(rows, 0.01, fluid, 1.0, 1.0)
        return rows

    law = oil.pressure_law
    warm, inlet = read(pressure, temperature, True), read(pressure, temperature, False)
    wanted = law.log_ratio(1e9 * pressure, temperature)
    # thinner than e^-12 or stiffer than e^20 is no film; a modulus law has a pole where the cold oil turns solid
    inside = (np.abs(wanted) < (15.0 if oil.viscosity_law == "modulus" else 20.0)) & (
        law.log_ratio(1.05e9 * pressure, temperature) < 30.0
    )
    inside &= law.log_ratio(1.05e9 * pressure, temperature) >= wanted
    assert inside.mean() > 0.2
    used = inside & (np.abs(wanted) < 15.0) & (pressure <= 2.5) & (temperature <= 500.0)
    if name == "5p4e":  # 5P4E is a glass below, and its largest viscosity a kink
        used &= temperature > 293.0
    tolerance = TABLE_ERROR.get(name, 1e-6)
    error = np.abs(warm.exponent - wanted)
    assert error[used].max() <= tolerance
    assert error[inside & (temperature > 293.0)].max() <= max(2e-4 if name == "5p4e" else 2.5e-5, tolerance)
    at_inlet = law.log_ratio(1e9 * pressure)
    soft = at_inlet < (15.0 if name in TABLE_ERROR else 30.0)
    row_error = 1e-6 if name in TABLE_ERROR else 1e-7
    np.testing.assert_allclose(inlet.exponent[soft], at_inlet[soft], rtol=0.0, atol=row_error)
    np.testing.assert_allclose(inlet.slope[soft], 1e9 * law.by_pressure(1e9 * pressure[soft]), rtol=1e-5)
    np.testing.assert_allclose(inlet.density, oil.density_ratio(1e9 * pressure), rtol=1e-8)
    slope = (read(pressure + 1e-6, temperature, True).exponent - warm.exponent) / 1e-6
    np.testing.assert_allclose(slope[inside], warm.slope[inside], rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("name", BOXES)
def test_no_pressure_or_temperature_gives_a_number_that_is_none(name: str) -> None:
    fluid = scaled(BOXES[name])
    pressure, temperature = (
        grid.ravel() for grid in np.meshgrid([0.0, 1e-9, 1.0, 9.99, 10.0, 15.0, 1e4], [1.0, 223.0, 300.0, 1500.0, 1e6])
    )
    rows = rows_of(np.ones(pressure.size), pressure, 0.0)
    rows.thermal[:] = [temperature_place(value, fluid.table) for value in temperature]
    fluidity_rows(rows, 0.01, fluid, 1.0, 1.0)
    for values in (rows.exponent, rows.slope, rows.density, rows.f, rows.by_pressure):
        assert np.isfinite(values).all()
    assert (rows.exponent <= 80.0).all()
    assert (rows.slope >= 0.0).all()
    for p in (-5.0, -1e-3, 0.0, 10.0, 11.0, 1e4):
        value, slope, density, density_slope = inlet_laws(p, fluid.table)
        ahead = inlet_laws(p + 1e-5 * max(abs(p), 1.0), fluid.table)
        assert math.isfinite(value)
        assert slope > 0.0
        assert density_slope >= 0.0
        assert ahead[0] > value
        assert ahead[2] >= density
