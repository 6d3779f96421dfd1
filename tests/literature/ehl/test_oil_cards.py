"""Cards of oils against the constants and figures of their sources, computed here from the printed numbers."""

import math
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from refusals import refused, refuses

from ehl.common.data import data_names, data_path
from ehl.common.errors import InputError
from ehl.common.units import KELVIN
from ehl.common.validation import validate
from ehl.fluid.oil import Oil
from ehl.fluid.oil_family import OIL_FAMILIES, astm_d2270, both_viscosities, generic_card, generic_name


def rows(name: str) -> dict[str, dict[str, Any]]:
    """A table of data/reference by card."""
    return pd.read_csv(data_path("reference", name), comment="#").set_index("card").to_dict("index")


FVA, ARANA = rows("oils_fva400.csv"), rows("oils_arana.csv")
# usable laws down to 20 degC only: a1 + a2 T is not positive at -40 degC, which cards must be
SHIPPED = [card for card in FVA if card in data_names("oils")]
PLACEHOLDER_DENSITY = ("hc_additive", "hc_pma", "hc_pma_additive", "pao_ester_additive_pma")


def rise(card: str, pressure: float, celsius: float) -> float:
    """ln(eta/eta0) of a card at a pressure [Pa]."""
    return float(Oil.load(card).at(celsius + KELVIN).log_viscosity_ratio(np.array(pressure)))


def rise_fva(row: dict[str, Any], bar: float, celsius: float) -> float:
    """As the FVA 400 constants are printed: p in bar, T in degC."""
    return bar / (row["a1_bar"] + row["a2_bar_K"] * celsius + (row["b1"] + row["b2_K"] * celsius) * bar)


@pytest.mark.parametrize("card", SHIPPED)
def test_fva_400_oils_have_the_viscosity_of_their_source_over_pressure_and_temperature(card: str) -> None:
    """eta = nu rho exp(L), nu = A exp(B/(T + 95)) through nu40 and nu100."""
    row, oil = FVA[card], Oil.load(card)
    exponent = math.log(row["nu40_cst"] / row["nu100_cst"]) / (1.0 / 135.0 - 1.0 / 195.0)
    for celsius in (20.0, 40.0, 80.0, 100.0, 120.0):
        nu = row["nu40_cst"] * math.exp(exponent * (1.0 / (celsius + 95.0) - 1.0 / 135.0))
        density = 1e3 * (row["rho15_g_ml"] + row["d_g_ml_K"] * (celsius - 15.0))
        if card in PLACEHOLDER_DENSITY:  # of the source, stated on the card
            density = float(oil.density(celsius + KELVIN))
        ambient = math.log(1e-6 * nu * density)
        for gigapascal in (0.0, 0.2, 0.5, 0.8, 1.2):
            kelvin, wanted = celsius + KELVIN, rise_fva(row, 1e4 * gigapascal, celsius)
            found = float(oil.at(kelvin).log_viscosity(np.array(gigapascal * 1e9), np.array(kelvin)))
            assert found == pytest.approx(ambient + wanted, abs=0.006)
            assert rise(card, gigapascal * 1e9, celsius) == pytest.approx(wanted, rel=1e-6)
    assert oil.density(15.0 + KELVIN) == pytest.approx(1e3 * row["rho15_g_ml"], rel=1e-4) or card in PLACEHOLDER_DENSITY
    # slopes and secants of the table; its last printed digit is 0.1 1/GPa
    for celsius in (40, 100):
        slope = 1e9 * oil.at(celsius + KELVIN).pressure_viscosity
        assert slope == pytest.approx(row[f"slope_{celsius}"], abs=0.051)
        assert rise(card, 0.2e9, celsius) / 0.2 == pytest.approx(row[f"secant_{celsius}"], abs=0.051)
    assert rise(card, 0.8e9, 100.0) == pytest.approx(row["log_ratio_08_100"], abs=0.051)


@pytest.mark.parametrize("card", ARANA)
def test_oils_of_arana_have_the_pressure_law_and_the_viscosities_of_the_paper(card: str) -> None:
    row, oil = ARANA[card], Oil.load(card)
    for celsius in (40.0, 70.0, 100.0):
        kelvin = celsius + KELVIN
        low, stiffening = row["a1_Pa"] + row["a2_Pa_K"] * kelvin, row["b1"] + row["b2_K"] * kelvin
        for pressure in (0.2e9, 0.8e9, 1.2e9):
            assert rise(card, pressure, celsius) == pytest.approx(pressure / (low + stiffening * pressure), rel=1e-5)
    for celsius in (40, 100):
        kelvin = celsius + KELVIN
        # printed in whole 1/GPa
        assert 1e9 * oil.at(kelvin).pressure_viscosity == pytest.approx(row[f"slope_{celsius}"], abs=0.5)
        nu = 1e6 * oil.viscosity_dynamic(kelvin) / oil.density(kelvin)
        assert nu == pytest.approx(row[f"nu{celsius}_cst"], rel=1e-4)


@pytest.mark.parametrize(
    ("card", "secant_80"), [("minr", 16.7), ("estr", 11.4), ("p150", 11.8), ("pagd", 10.5), ("paor", 12.8)]
)
def test_gear_oils_whose_alpha_is_golds_have_it_as_secant(card: str, secant_80: float) -> None:
    """Their published alpha at 80 degC is Gold's formula to the printed digits, which gives secants at 0.2 GPa."""
    oil = Oil.load(card)
    scale, exponent = {
        "mineral": (9.904, 0.139), "pao": (7.382, 0.1335), "polyglycol": (5.489, 0.1485), "ester": (6.605, 0.136),
    }[oil.base]  # fmt: skip
    assert scale * (1e6 * oil.viscosity_kinematic(353.15)) ** exponent == pytest.approx(secant_80, abs=0.051)
    assert rise(card, 0.2e9, 80.0) / 0.2 == pytest.approx(secant_80, rel=1e-3)


@pytest.mark.parametrize("card", data_names("oils"))
def test_viscosity_of_a_card_rises_with_pressure_and_agrees_with_both_given_ones(card: str) -> None:
    oil = Oil.load(card)
    for celsius, nu in ((40.0, oil.viscosity_kinematic_40), (100.0, oil.viscosity_kinematic_100)):
        kelvin = celsius + KELVIN
        assert oil.viscosity_dynamic(kelvin) / oil.density(kelvin) == pytest.approx(nu, rel=2e-3)
    pressure = np.linspace(0.0, 2e9, 81)
    assert oil.at(KELVIN - 40.0).pressure_viscosity > 0.0
    for kelvin in np.linspace(*oil.temperature_valid, 8):
        values = oil.at(float(kelvin)).log_viscosity_ratio(pressure)
        assert np.all(np.diff(values) > 0.0)


@pytest.mark.parametrize("base", OIL_FAMILIES)
def test_the_generic_oil_has_the_oils_of_its_family_inside_the_stated_spread(base: str) -> None:
    """Root mean square over 40 to 120 degC and 0.2 to 1.2 GPa, n/(n - 1); every oil within 2.5 deviations.

    The shape is the mean of the constants of the FVA 400 oils, each set times its secant at 0.2 GPa and 80 degC.
    """
    family = OIL_FAMILIES[base]
    found, sets = [], []
    for card in family.oils:
        row = FVA[card]
        constants = np.array([1e5 * row["a1_bar"], 1e5 * row["a2_bar_K"], row["b1"], row["b2_K"]])
        sets.append(constants * rise_fva(row, 2000.0, 80.0) / 0.2)
        oil = Oil.load(f"{base} {row['nu40_cst']}/{row['nu100_cst']}")
        assert oil.uncertainty.pressure_viscosity == family.spread
        for celsius in (40.0, 80.0, 120.0):
            law = oil.at(celsius + KELVIN)
            for bar in (2000.0, 4000.0, 8000.0, 12000.0):
                found.append(rise_fva(row, bar, celsius) / float(law.log_viscosity_ratio(np.array(bar * 1e5))) - 1.0)
    np.testing.assert_allclose(family.shape, np.mean(sets, axis=0), rtol=1e-3)
    deviation = math.sqrt(np.mean(np.square(found)) * len(family.oils) / (len(family.oils) - 1))
    assert 0.7 * family.spread < deviation < 1.03 * family.spread
    assert max(map(abs, found)) < 2.5 * family.spread


# FVA 400 oils without a usable law above 0.2 GPa
SECANT_ONLY = {"pao": ("pao_ester_pma",), "ester": ("pti", "dia_ke")}


@pytest.mark.parametrize("base", OIL_FAMILIES)
def test_the_level_of_a_family_is_the_fit_of_the_secants_of_its_oils(base: str) -> None:
    """ln alpha over ln nu by least squares, 30 to 120 degC in steps of 10 K."""
    family, log_nu, log_secant = OIL_FAMILIES[base], [], []
    for row in (FVA[card] for card in (*family.oils, *SECANT_ONLY.get(base, ()))):
        exponent = math.log(row["nu40_cst"] / row["nu100_cst"]) / (1.0 / 135.0 - 1.0 / 195.0)
        for celsius in range(30, 121, 10):
            log_nu.append(math.log(row["nu40_cst"]) + exponent * (1.0 / (celsius + 95.0) - 1.0 / 135.0))
            log_secant.append(math.log(rise_fva(row, 2000.0, celsius) / 0.2))
    exponent, log_scale = np.polyfit(log_nu, log_secant, 1)
    assert family.secant == pytest.approx((math.exp(log_scale), exponent), rel=5e-3)


# Arana et al. (2019), and the middle of their mineral oil and PAO where they have no figure
RATIOS = {"mineral": 0.047, "hydrocracked": 0.041, "pao": 0.035, "ester": 0.041, "polyglycol": 0.044}


def eyring_stress_arana_2019(row: dict[str, Any], ratio: float, pascal: float, celsius: float) -> float:
    """2 Lambda/alpha, alpha = d ln(eta)/dp = A/(A + B p)^2 of the modulus law with the printed constants."""
    low, stiffening = row["a1_bar"] + row["a2_bar_K"] * celsius, row["b1"] + row["b2_K"] * celsius
    bar = pascal / 1e5
    return 2.0 * ratio * 1e5 * (low + stiffening * bar) ** 2 / low


@pytest.mark.parametrize("base", OIL_FAMILIES)
def test_the_eyring_stress_of_a_base_oil_is_that_of_its_fva_400_oils(base: str) -> None:
    """Geometric mean over the oils that have a card; the linear law within 10 % of it in the mean, 20 % anywhere."""
    family, missed = OIL_FAMILIES[base], []
    rows_of_base = [FVA[card] for card in OIL_FAMILIES[base].oils if card in SHIPPED]
    assert family.ratio == RATIOS[base]
    for celsius in (40.0, 60.0, 80.0, 100.0, 120.0):
        law = family.eyring_stress(celsius + KELVIN)
        for pascal in (0.0, 0.3e9, 0.6e9, 0.9e9, 1.2e9):
            found = [eyring_stress_arana_2019(row, family.ratio, pascal, celsius) for row in rows_of_base]
            missed.append(math.log(law(pascal) / float(np.exp(np.mean(np.log(found))))))
    assert np.sqrt(np.mean(np.square(missed))) < 0.10
    assert np.max(np.abs(missed)) < 0.25
    assert abs(np.mean(missed)) < 0.02


# thrust ball bearings of FEUP, saturated (data/reference/measured/ranges.toml, ball_bearing_traction)
@pytest.mark.parametrize("card", ["minr", "paor", "estr", "pagd", "p150"])
def test_no_limit_lies_below_measured_mean_traction(card: str) -> None:
    with data_path("reference/measured", "ranges.toml").open("rb") as file:
        measured = tomllib.load(file)["ball_bearing_traction"]
    ambient, slope = Oil.load(card).limiting_stress
    assert slope + ambient / 1e9 > measured[card]
    low, high = OIL_FAMILIES[Oil.load(card).base].limit_range
    assert low <= slope <= high


def test_generic_oil_by_hand() -> None:
    """PAO, 97.5 and 13.26 cSt: Walther gives 22.346 cSt at 80 degC, the secant is 7.09 nu^0.144."""
    oil = Oil.generic("pao", nu_40="97.5 cSt", nu_100=13.26e-6)
    nu_80 = 1e6 * oil.viscosity_kinematic(353.15)
    secant = float(oil.at(353.15).log_viscosity_ratio(np.array(0.2e9))) / 0.2
    assert nu_80 == pytest.approx(22.346, rel=1e-3)
    assert secant == pytest.approx(7.09 * nu_80**0.144, rel=1e-4)
    for celsius in (20.0, 40.0, 70.0, 100.0, 130.0, 150.0):
        kelvin = celsius + KELVIN
        walther = oil.viscosity_kinematic(kelvin) * oil.density(kelvin)
        assert oil.viscosity_dynamic(kelvin) == pytest.approx(walther, rel=0.02)
        assert celsius not in (40.0, 100.0) or oil.viscosity_dynamic(kelvin) == pytest.approx(walther, rel=1e-9)


def test_names_of_generic_oils() -> None:
    viscosities = {"viscosity_40": pytest.approx(97.5e-6), "viscosity_100": pytest.approx(13.3e-6)}
    assert generic_name("pao 97.5/13.3") == {"base": "pao"} | viscosities
    assert generic_name("Mineral ISO VG 220") == {"base": "mineral", "iso_vg": 220}
    assert generic_name("PAO 97.5cSt / 13.3 cSt") == generic_name("pao 97.5/13.3")
    assert generic_name("polyglycol vg460") == {"base": "polyglycol", "iso_vg": 460}
    assert generic_name("75w90") is generic_name("fva3") is None
    assert Oil.load("mineral vg 220").viscosity_kinematic_40 == pytest.approx(220e-6)
    by_grade, by_figures = generic_card("ester", iso_vg=100), generic_card("ester", 1e-4, 1.4e-5)
    assert by_grade["uncertainty"]["viscosity"] > by_figures["uncertainty"]["viscosity"]


# ASTM D2270: its two worked examples, printed as whole numbers, with L and H of its table
@pytest.mark.parametrize(("nu_40", "nu_100", "printed"), [(73.30, 8.86, 92), (22.83, 5.05, 156)])
def test_viscosity_index(nu_40: float, nu_100: float, printed: int) -> None:
    index = astm_d2270(1e-6 * nu_40, 1e-6 * nu_100)
    assert round(index) == printed
    for known in ((1e-6 * nu_40, None), (None, 1e-6 * nu_100)):
        assert both_viscosities(index, *known) == pytest.approx((1e-6 * nu_40, 1e-6 * nu_100), rel=1e-6)


def test_an_oil_is_given_by_its_viscosity_index(mixed_ehl: Callable[..., Any]) -> None:
    nu_100 = both_viscosities(145.0, 97.5e-6, None)[1]
    by_name, by_keyword = Oil.load("PAO 97.5 VI 145"), Oil.generic("pao", nu_40="97.5 cSt", viscosity_index=145)
    assert by_name.viscosity_kinematic_100 == by_keyword.viscosity_kinematic_100 == pytest.approx(nu_100)
    graded = Oil.load("mineral vg 220 vi 95")
    assert astm_d2270(graded.viscosity_kinematic_40, graded.viscosity_kinematic_100) == pytest.approx(95.0)
    options = ("oil", "--base", "pao", "--nu100", "13.3 cSt")
    assert mixed_ehl(*options, "--vi", "145").code == 0
    for wrong, field in (
        (("--vi", "500"), "--vi"),
        (("--nu40", "97.5"), "--nu40"),
        (("--nu40", "97.5 cSt", "--density", "850"), "--density"),
    ):
        refused(mixed_ehl(*options, *wrong), field)
    refused(reversed_order := mixed_ehl(*options, "--nu40", "9 cSt"), "--nu100")
    assert "nu_40" not in reversed_order.err


def test_viscosities_of_a_card_are_those_of_its_law(tmp_path: Path) -> None:
    card = Oil.generic("mineral", iso_vg=220)
    card.varied(viscosity=2.0).save(tmp_path / "varied.toml")
    assert Oil.load(str(tmp_path / "varied.toml")) == card.varied(viscosity=2.0)
    content = card.model_dump(exclude_none=True)
    for field in ("viscosity_kinematic_40", "viscosity_kinematic_100"):
        with refuses(field):
            validate(Oil, content | {field: 0.97 * content[field]})
    with refuses("viscosity_kinematic_40"):
        validate(Oil, content | {"density_15": 1.03 * card.density_15})
    # an error in the law is no error of the uncertainty, which follows from it
    content["pressure_viscosity"], content["uncertainty"] = {"law": "gold"}, {}
    with pytest.raises(InputError) as caught:
        validate(Oil, content)
    assert [problem.field for problem in caught.value.problems] == ["pressure_viscosity.base"]


@pytest.mark.parametrize(
    ("name", "field"),
    [
        ("olive 97/13", "base"),
        ("pao 13/97", "nu_100"),
        ("pao vg 99", "iso_vg"),
        ("pao 97", "oil"),
        ("pao 97,5/13,3", "oil"),
        ("pao 97..5/13.3", "oil"),
        ("no_such_oil", "oil"),
        # by keywords: every viscosity once
        ({}, "iso_vg"),
        ({"nu_40": "100 cSt"}, "iso_vg"),
        ({"nu_40": "100 cSt", "nu_100": "14 cSt", "iso_vg": 100}, "iso_vg"),
        ({"nu_40": "97.5 cSt", "nu_100": "13 cSt", "viscosity_index": 145}, "iso_vg"),
        ({"nu_40": 97.5, "nu_100": 13.3}, "nu_40"),
        ({"nu_40": "8 cSt", "viscosity_index": -15.0}, "viscosity_index"),
    ],
)
def test_what_is_no_oil(name: str | dict[str, Any], field: str) -> None:
    with refuses(field):
        Oil.load(name) if isinstance(name, str) else Oil.generic("pao", **name)
