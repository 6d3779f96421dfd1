"""Laws of the oil against printed coefficients: a wrong exponent or constant is far outside."""

import math

import numpy as np
import pytest

from ehl.common.units import KELVIN
from ehl.fluid.density import density_at, dowson_higginson_1966
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.fluid.oil_laws import GoldAlpha, TabulatedAlpha
from ehl.fluid.viscosity import GOLD_COEFFICIENTS, gold_2001, walther_1931, walther_slope
from ehl.line_contact import LineContact
from ehl.material import Material, effective_modulus


@pytest.mark.parametrize(
    ("base", "at_1_cst", "at_100_cst"),
    [
        # 1e9 alpha = s nu^t, nu in cSt (Gold et al. 2001): s and s 100^t
        ("mineral", 9.904, 18.784975),
        ("pao", 7.382, 13.651301),
        ("polyglycol", 5.489, 10.876602),
        ("ester", 6.605, 12.355856),
    ],
)
def test_gold_at_two_viscosities(base: str, at_1_cst: float, at_100_cst: float) -> None:
    assert gold_2001(1e-6, base) * 1e9 == pytest.approx(at_1_cst, rel=1e-12)
    assert gold_2001(1e-4, base) * 1e9 == pytest.approx(at_100_cst, rel=1e-6)
    assert gold_2001(3e-5, base) * 1e9 == pytest.approx(at_1_cst * 30 ** GOLD_COEFFICIENTS[base][1], rel=1e-12)


def test_gold_through_a_measured_point_keeps_the_exponent_of_its_base() -> None:
    """alpha falls as nu^0.1485 from the measured point of a polyglycol."""
    law = GoldAlpha(law="gold", base="polyglycol", anchor_temperature=40.0 + KELVIN, anchor_value=15e-9)
    oil = Oil.load("fva3").model_copy(update={"pressure_viscosity": law})
    assert oil.alpha(40.0 + KELVIN) == pytest.approx(15e-9, rel=1e-12)
    ratio = oil.viscosity_kinematic(373.15) / oil.viscosity_kinematic(313.15)
    assert oil.alpha(373.15) == pytest.approx(15e-9 * ratio**0.1485, rel=1e-12)
    free = oil.model_copy(update={"pressure_viscosity": GoldAlpha(law="gold", base="pao")})
    nu = oil.viscosity_kinematic(333.15) * 1e6
    assert free.alpha(333.15) == pytest.approx(7.382e-9 * nu**0.1335, rel=1e-12)


def test_walther_between_its_points_by_hand() -> None:
    """An oil of 100 and 11.1 cSt at 40 and 100 degC, at 70 degC on the line of log log (nu + 0.7) over log T."""
    n = (math.log10(math.log10(100.7)) - math.log10(math.log10(11.8))) / (math.log10(373.15) - math.log10(313.15))
    m = math.log10(math.log10(100.7)) + n * math.log10(313.15)
    nu = 10 ** (10 ** (m - n * math.log10(343.15))) - 0.7
    assert walther_1931(343.15, 1e-4, 11.1e-6) == pytest.approx(nu * 1e-6, rel=1e-12)
    assert 25.0 < nu < 32.0
    step = 1e-3
    low, high = (math.log(walther_1931(343.15 + s, 1e-4, 11.1e-6)) for s in (-step, step))
    assert walther_slope(343.15, 1e-4, 11.1e-6) == pytest.approx((low - high) / (2 * step), rel=1e-7)


def test_laws_of_viscosity_and_density_by_hand() -> None:
    """eta = eta0 exp((ln eta0 + 9.67)((1 + p/1.96e8)^z - 1)), z = alpha 1.96e8/(ln eta0 + 9.67); Barus and density."""
    roelands, barus = (Lubricant(0.02, 18e-9, viscosity_law=law) for law in ("roelands", "barus"))
    assert float(barus.viscosity(np.array([0.1e9]))[0]) == pytest.approx(0.02 * math.exp(1.8), rel=1e-12)
    # 870 kg/m3 at 15 degC falls by 0.0675 % a kelvin: 820.0 at 100 degC; 1 + 0.6/2.7 times as dense under 1 GPa
    assert density_at(373.15, 870.0, -6.75e-4) == pytest.approx(870.0 * (1.0 - 0.057375), rel=1e-12)
    np.testing.assert_allclose(dowson_higginson_1966(np.array([0.0, 1e9, 2e9])), [1.0, 1 + 0.6 / 2.7, 1 + 1.2 / 4.4])
    level = math.log(0.02) + 9.67
    z = 18e-9 * 1.96e8 / level
    for pressure in (0.2e9, 1e9, 2e9):
        expected = 0.02 * math.exp(level * ((1.0 + pressure / 1.96e8) ** z - 1.0))
        assert float(roelands.viscosity(np.array([pressure]))[0]) == pytest.approx(expected, rel=1e-12)


def test_roelands_falls_with_temperature_as_a_power_of_t_minus_138() -> None:
    """ln eta + 9.67 goes as (T - 138 K)^-S0 at every pressure; S0 by the slope at ambient pressure."""
    oil = Lubricant(0.02, 18e-9, viscosity_law="roelands", temperature=353.15, temperature_viscosity=0.03)
    s0 = 0.03 * (353.15 - 138.0) / (math.log(0.02) + 9.67)
    for pressure in (0.0, 0.5e9):
        cold = float(oil.log_viscosity(np.array([pressure]), np.array([353.15]))[0]) + 9.67
        hot = float(oil.log_viscosity(np.array([pressure]), np.array([403.15]))[0]) + 9.67
        assert hot / cold == pytest.approx((215.15 / 265.15) ** s0, rel=1e-9)


def test_groups_of_the_line_contact_by_hand() -> None:
    """U = eta0 u_r/(E'R), W = w'/(E'R), G = alpha_film E'; M = W (2 U)^-1/2, L = G (2 U)^1/4.

    alpha_film is alpha for the Barus law.
    """
    contact = LineContact(0.02, 200e9, 4e5, 5.0, 0.6, 4.0)
    oil = Lubricant(0.02, 18e-9, viscosity_law="barus")
    assert contact.dowson_groups(oil) == pytest.approx((2.5e-11, 1e-4, 3600.0), rel=1e-12)
    assert contact.moes_groups(oil) == pytest.approx((1e-4 / math.sqrt(5e-11), 3600.0 * (5e-11) ** 0.25), rel=1e-12)
    assert contact.half_width == pytest.approx(math.sqrt(8.0 * 4e5 * 0.02 / (math.pi * 200e9)), rel=1e-12)
    # 3 m/s along x and 4 m/s along y
    assert contact.speed_sliding == pytest.approx(5.0, rel=1e-12)
    assert contact.slide_to_roll_total == pytest.approx(1.0, rel=1e-12)
    assert contact.sliding_cosine == pytest.approx(0.6, rel=1e-12)
    assert (contact.speed_1, contact.speed_2) == pytest.approx((6.5, 3.5), rel=1e-12)
    load = math.pi / 2 * contact.half_width * contact.pressure_hertz
    assert contact.load_per_length == pytest.approx(load, rel=1e-12)
    given = LineContact.from_pressure(
        radius_equivalent=0.02, effective_modulus=200e9, pressure_hertz=1e9, speed_entrainment=5.0, slide_to_roll=-0.4
    )
    assert given.pressure_hertz == pytest.approx(1e9, rel=1e-12)
    assert given.speed_1 - given.speed_2 == pytest.approx(-2.0)
    steel = Material.load("steel")
    assert effective_modulus(steel, steel) == pytest.approx(206e9 / (1 - 0.09), rel=1e-12)
    rolling = LineContact(0.02, 200e9, 4e5, 5.0)
    assert (rolling.speed_sliding, rolling.sliding_cosine) == (0.0, 1.0)


def test_tabulated_pressure_viscosity_is_linear_in_its_logarithm() -> None:
    """Between the points, and beyond them with the slope of the ends."""
    law = TabulatedAlpha(law="table", temperature=(300.0, 320.0, 360.0), value=(20e-9, 16e-9, 10e-9))
    oil = Oil.load("fva3").model_copy(update={"pressure_viscosity": law})
    assert oil.alpha(310.0) == pytest.approx(math.sqrt(20e-9 * 16e-9), rel=1e-12)
    assert oil.alpha(330.0) == pytest.approx(16e-9 * (10 / 16) ** 0.25, rel=1e-12)
    assert oil.alpha(290.0) == pytest.approx(20e-9 * (20 / 16) ** 0.5, rel=1e-12)
    assert oil.alpha(380.0) == pytest.approx(10e-9 * (10 / 16) ** 0.5, rel=1e-12)
    one = TabulatedAlpha(law="table", temperature=(313.15,), value=(17e-9,))
    assert oil.model_copy(update={"pressure_viscosity": one}).alpha(400.0) == 17e-9


def test_eyring_stress_of_mineral_oil_meets_the_published_one_of_fva3_below_contact_pressure() -> None:
    """k T/V, 8.1, 8.8, 9.4, 10.5 MPa at 15, 40, 60, 100 degC without pressure: ours passes it from 0.3 to 0.8 GPa."""
    card = Oil.load("fva3")
    for temperature, stress in ((288.15, 8.1e6), (313.15, 8.8e6), (333.15, 9.4e6), (373.15, 10.5e6)):
        law = card.at(temperature).eyring_stress
        assert law(0.3e9) < stress < law(0.8e9)


def test_limiting_stress_of_the_base_oil_serves_where_the_card_has_none() -> None:
    """tau_L = 0.048 p of polyalphaolefins, 0.065 p of mineral oils; a coefficient of the card goes before it."""
    card = Oil.load("pao100")
    assert card.limiting_stress == (0.0, 0.048)
    limit = card.at(353.15).shear_law.limiting_stress(np.array([0.0, 1e9]))
    assert limit == pytest.approx([0.0, 48e6], rel=1e-12)
    assert Oil.load("fva3").limiting_stress == (0.0, 0.065)
    assert Oil.load("t9").limiting_stress == (0.0, 0.083)
