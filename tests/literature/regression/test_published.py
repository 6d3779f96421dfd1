"""Published friction formulas against printed values and against their equations in the authors' units."""

import math

import numpy as np
import pytest

from regression.friction import published as p

# one contact in SI, and the same in the units of the authors
LOAD, ETA, NU, SLIDING, SUM, R, RA, PRESSURE = 400e3, 0.02, 25e-6, 3.0, 20.0, 0.012, 0.4e-6, 1.2e9


@pytest.mark.parametrize(
    ("gpa", "ratio", "speed", "cp", "radius", "rough", "printed"),
    [(1.5, 0.3, 5.0, 10.0, 0.010, 0.2, 0.018651), (1.0, 0.1, 10.0, 10.0, 0.020, 0.2, 0.006709)],
)
def test_xu_2007_check_values(
    gpa: float, ratio: float, speed: float, cp: float, radius: float, rough: float, printed: float
) -> None:
    # given to six decimals
    mu = p.xu_kahraman_2007(gpa * 1e9, ratio, speed, cp * 1e-3, radius, rough * 1e-6)
    assert float(mu) == pytest.approx(printed, abs=0.5e-6)


def test_xu_2007_known_defect_growth_with_roughness() -> None:
    # the reference notes a growth of about 8 times from 0.1 to 1.5 um
    low, high = p.xu_kahraman_2007(1e9, 0.3, 5.0, 0.01, 0.01, np.array([0.1e-6, 1.5e-6]))
    assert high / low == pytest.approx(8.0, rel=0.05)


def test_benedict_kelley_constant_is_the_imperial_one_and_its_roughness_factor() -> None:
    # 3.17e8 with lb/in, cP and in/s (unverified) gives the 29660 of the metric form, printed to four digits
    pound_per_inch, inch = 175.126835, 0.0254
    metric = 3.17e8 * 1e3 / pound_per_inch * inch**3
    assert metric == pytest.approx(29660.0, rel=1e-3)
    mu = p.benedict_kelley_1961(LOAD, ETA, SLIDING, SUM)
    assert float(mu) == pytest.approx(0.0127 * math.log10(29660.0 * 400.0 / (20.0 * 3.0 * 400.0)), rel=1e-12)
    rough = p.benedict_kelley_1961(LOAD, ETA, SLIDING, SUM, 25 * 2.54e-8)
    assert float(rough / mu) == pytest.approx(2.0, rel=1e-12)


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (p.schlenk_1994(LOAD, ETA, SUM, R, RA), 0.048 * (400 / (20 * 12)) ** 0.2 * 20**-0.05 * 0.4**0.25),
        (p.iso_tr_14179_1(NU, 5e6, 10.0), 25**-0.223 * 5**-0.40 / (3.239 * 10**0.70)),
        (
            p.iso_tr_14179_2(LOAD, ETA, SUM, R, RA, 0.06),
            0.045 * (400 / (20 * 12)) ** 0.2 * 20**-0.05 * 3.8 * (0.4 / 60) ** 0.25,
        ),
        (p.misharin_1958(NU, SLIDING, SUM), 0.325 * (3 * 20 * 25) ** -0.25),
        (
            p.drozdov_gavrikov_1967(PRESSURE, NU, SLIDING, SUM),
            1 / (0.8 * 5 * 3 + 20 * (0.47 - 0.13e-4 * 1.2e9 / 98066.5 - 0.4e-3 * 25) + 13.4),
        ),
        (
            p.odonoghue_cameron_1966(NU, SLIDING, 0.5 * SUM, R, RA),
            0.6
            * ((0.4 / 0.0254 + 22) / 35)
            / (25**0.125 * (3 / 0.0254) ** (1 / 3) * (10 / 0.0254) ** (1 / 6) * (12 / 25.4) ** 0.5),
        ),
        (
            p.arana_2019_fluid(0.9e9, 50.0, 16e-9, SLIDING, 0.4e-6, 0.047),
            2 * 0.047 / (16 * 0.9) * math.asinh(50 * 16e-9 * 3 / (2 * 0.047 * 0.4e-6)),
        ),
    ],
    ids=["schlenk", "iso1", "iso2", "misharin", "drozdov", "odonoghue", "arana"],
)
def test_equation_in_the_authors_units(value: np.ndarray, expected: float) -> None:
    assert float(value) == pytest.approx(expected, rel=1e-9)


def test_values_at_the_ends_of_misharin_of_lubricant_factors_and_of_shares() -> None:
    assert float(p.misharin_1958(1e-6, 1e-3, 1.0)) == 0.08
    assert float(p.misharin_1958(1e-3, 30.0, 60.0)) == 0.02
    bases = ("mineral", "pao", "ester", "polyglycol")
    assert [float(p.lubricant_factor_niemann(base, 6.0)) for base in bases] == [1.0, 0.8, 0.8, 0.75]
    np.testing.assert_allclose(p.share_arana_2019([0.0, 1.0, 4.0]), [1.0, 0.1572992, 0.0], atol=2e-8)
    np.testing.assert_allclose(p.share_doleschel_2002([0.0, 1.0, 2.0, 5.0]), [1.0, 0.25, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(p.share_matsumoto_2014([0.1, 1.0, 10.0, 100.0, 1e4]), [0, 0, 0.5, 1, 1], atol=1e-15)


def test_masjedi_khonsari_share_by_hand() -> None:
    # logarithms by hand, base 10: U 1e-11, W 1e-4, G 4000, s 3e-5, V 0.035
    lg = math.log10
    roughness = 6.015 * lg(3e-5) + 1.168 * lg(0.035)
    inside = 10.0 ** (lg(4470.0) + roughness - 0.485 * 4.0 + 3.741 * 11.0 - 2.898 * lg(4000.0))
    per_cent = 0.005 * 10.0 ** (0.408 * 4.0 + 0.088 * 11.0 + 0.103 * lg(4000.0)) * math.log(1.0 + inside)
    share = p.share_masjedi_khonsari_2012(1e-11, 1e-4, 4000.0, 3e-5, 0.035)
    assert 5.0 < per_cent < 95.0
    assert float(share) == pytest.approx(0.01 * per_cent, rel=1e-9)
    # smoother is less, and what is no share is no number
    assert float(p.share_masjedi_khonsari_2012(1e-11, 1e-4, 4000.0, 3e-6, 0.035)) < 1e-3
    assert math.isnan(float(p.share_masjedi_khonsari_2012(1e-14, 1e-4, 4000.0, 3e-5, 0.035)))
