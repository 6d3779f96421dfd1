"""Laws of viscosity under pressure and their four coefficients against figures worked out from published constants."""

import math
from dataclasses import replace

import numpy as np
import pytest
from refusals import refuses
from scipy.integrate import quad

from ehl.common.data import data_names
from ehl.common.units import KELVIN
from ehl.contact import Contact
from ehl.fluid import oil_alpha
from ehl.fluid.density import Murnaghan, Tait
from ehl.fluid.free_volume import Doolittle, ImprovedYasutomi, McEwenPaluch, OriginalYasutomi
from ehl.fluid.oil import Oil
from ehl.fluid.oil_laws import GoldAlpha
from ehl.fluid.pressure_viscosity import DEFINITIONS, AlphaDefinition, alpha_of
from ehl.fluid.viscosity import AbsoluteLaw, BarusLaw, ModulusLaw, PressureLaw, RelativeLaw, RoelandsLaw

# Bair's 80W-90 gear oil and Shell T9 (improved form), 5P4E (original form), squalane (Doolittle with Tait)
GEAR_OIL = ImprovedYasutomi(
    viscosity_glass=1e12, Tg0=201.45, A1=210.6, A2=0.455e-9, b1=7.606e-9, b2=-0.4193, C1=16.372, C2=29.99
)
T9 = ImprovedYasutomi(
    viscosity_glass=1e12, Tg0=189.95, A1=188.95, A2=0.719e-9, b1=8.20e-9, b2=-0.538, C1=16.09, C2=17.38
)
POLYPHENYL_ETHER = OriginalYasutomi(
    viscosity_glass=1e12, Tg0=244.95, A1=134.2, A2=1.929e-9, B1=4.815, B2=0.160e-9, C1=16.01, C2=20.69
)
SQUALANE = Doolittle(
    viscosity_reference=15.6e-3, temperature_reference=313.15, B=4.710, R0=0.6568, epsilon=-9.599e-4,
    volume_expansion=8.36e-4, state=Tait(K00=8.658e9, betaK=6.33e-3, K0_rate=11.74),
)  # fmt: skip
HYBRID = McEwenPaluch(K=6e-5, B=900.0, C=95.0, a0=20e-9, a0_fall=5e-3, q=3.0, CF=6.0, pinf=2.5e9, pinf_rise=8e6)
ABSOLUTE: dict[str, AbsoluteLaw] = {
    "80W-90": GEAR_OIL, "T9": T9, "5P4E": POLYPHENYL_ETHER, "squalane": SQUALANE, "hybrid": HYBRID,
}  # fmt: skip


def arana(a1: float, a2: float, b1: float, b2: float, celsius: float) -> ModulusLaw:
    """Constants of Arana, Larranaga & Ulacia 2019, there with T in K."""
    return ModulusLaw((a1 + KELVIN * a2, a2, b1 + KELVIN * b2, b2), celsius + KELVIN)


PAO100, M100 = (-5.73e7, 3.90e5, -39.5e-3, 23.54e-5), (-2.28e7, 2.26e5, -68.2e-3, 27.68e-5)


@pytest.mark.parametrize(
    ("law", "slope", "secant", "star", "film", "logs"),
    [
        (arana(*PAO100, 40.0), 15.4, 14.0, 14.3, 14.6, (5.09, 8.68, 11.3)),
        (arana(*PAO100, 100.0), 11.3, 10.2, 10.2, 10.5, (3.72, 6.30, 8.21)),
        (arana(*M100, 100.0), 16.3, 14.6, 15.1, 15.4, (5.29, 8.93, 11.6)),
        (Oil.load("fva3").at(40.0 + KELVIN).pressure_law, 22.4, 20.8, 21.6, 21.8, (7.80, 13.8, 18.6)),
        (Oil.load("fva3").at(100.0 + KELVIN).pressure_law, 16.0, 14.4, 14.8, 15.1, (5.23, 8.86, 11.5)),
        (RelativeLaw(GEAR_OIL, 40.0 + KELVIN), 25.5, 20.7, 22.7, 23.2, (7.60, 14.5, 22.1)),
        (RelativeLaw(GEAR_OIL, 100.0 + KELVIN), 17.9, 14.1, 15.1, 15.6, (5.06, 9.12, 13.2)),
        (RelativeLaw(T9, 100.0 + KELVIN), 15.1, 13.0, 13.4, 13.7, (4.91, 9.63, 14.9)),
        (RelativeLaw(SQUALANE, 40.0 + KELVIN), 22.0, 16.0, 17.8, 18.6, (5.5, 9.6, 13.6)),
    ],
)
def test_four_coefficients_of_published_laws(
    law: PressureLaw, slope: float, secant: float, star: float, film: float, logs: tuple[float, ...]
) -> None:
    found = [1e9 * alpha_of(law, definition) for definition in DEFINITIONS]
    np.testing.assert_allclose(found, [slope, secant, star, film], rtol=0.01)
    np.testing.assert_allclose(law.log_ratio(np.array([0.4e9, 0.8e9, 1.2e9])), logs, rtol=0.01)


def test_viscosity_of_published_oils_at_ambient_pressure() -> None:
    ambient = [(GEAR_OIL, 40, 0.124), (GEAR_OIL, 100, 0.0115), (T9, 40, 7.9e-3), (T9, 100, 2.0e-3)]
    for law, celsius, viscosity in [*ambient, (POLYPHENYL_ETHER, 40, 0.52), (SQUALANE, 40, 15.6e-3)]:
        found = np.exp(law.log_viscosity(np.zeros(1), np.full(1, celsius + KELVIN)))
        np.testing.assert_allclose(found, viscosity, rtol=0.01)


def test_coefficients_are_their_integrals() -> None:
    """Of Roelands; all four of Barus are alpha."""
    for alpha in (5e-9, 50e-9):
        found = [alpha_of(BarusLaw(alpha, 353.15, 0.03), definition) for definition in DEFINITIONS]
        np.testing.assert_allclose(found, alpha, rtol=1e-12)
    law = RoelandsLaw(0.0106, 12e-9, 373.15, 0.03)

    def fluidity(pressure: float) -> float:
        return math.exp(-float(law.log_ratio(np.array(pressure))))

    star = 1.0 / (1e9 * quad(lambda p: fluidity(1e9 * p), 0.0, 20.0, limit=500, epsabs=1e-12)[0])
    assert alpha_of(law, "star") == pytest.approx(star, rel=1e-3, abs=0.0)  # beyond 3 GPa along the tangent
    end = 3.0 / alpha_of(law, "star")
    film = -math.expm1(-3.0) / quad(fluidity, 0.0, end, epsrel=1e-12)[0]
    assert alpha_of(law, "film") == pytest.approx(film, rel=1e-10, abs=0.0)


BASE = {"pressure_hertz": 1e9, "radius_equivalent": 0.01, "speed_entrainment": 5.0}
GOLD = {"law": "gold", "base": "pao", "anchor_temperature": 373.15, "anchor_value": 9.68e-9}
TABLE = {"law": "table", "temperature": (313.15, 353.15, 373.15), "value": (21e-9, 17e-9, 16e-9)}


def card(definition: AlphaDefinition, alpha: dict[str, object], law: str = "roelands") -> Oil:
    figures = {"viscosity_kinematic_40": 97.5e-6, "viscosity_kinematic_100": 13.26e-6, "density_15": 848.0}
    laws = {"viscosity": {"law": law}, "pressure_viscosity": alpha | {"alpha_definition": definition}}
    words = {"name": "trial", "source": "", "certainty": "mixed", "limiting_shear_coefficient": 0.05}
    return Oil.model_validate(figures | laws | words)


@pytest.mark.parametrize("definition", DEFINITIONS)
@pytest.mark.parametrize(("alpha", "law"), [(GOLD, "roelands"), (TABLE, "roelands"), (GOLD, "barus")])
def test_cards_hold_their_stated_coefficient(definition: AlphaDefinition, alpha: dict[str, object], law: str) -> None:
    oil = card(definition, alpha, law)
    temperature = np.linspace(-40.0, 200.0, 41) + KELVIN
    lubricant = oil.at(temperature)
    found = alpha_of(lubricant.pressure_law, definition)
    np.testing.assert_allclose(found, oil_alpha.stated(oil, temperature), rtol=1e-10)
    film = alpha_of(lubricant.pressure_law, "film")
    np.testing.assert_allclose(lubricant.pressure_viscosity_film, film, rtol=1e-9)
    if law == "roelands":
        assert max(fit(oil).error for fit in (oil_alpha._slope_over_stated, oil_alpha._film_over_slope)) < 1e-9


@pytest.mark.parametrize("name", data_names("oils"))
def test_film_coefficient_of_every_card_is_that_of_its_law(name: str) -> None:
    oil = Oil.load(name)
    coldest = -25.0 if name == "5p4e" else -40.0  # below -28 degC 5P4E is a glass
    lubricant = oil.at(np.linspace(coldest, 200.0, 41) + KELVIN)
    film = alpha_of(lubricant.pressure_law, "film")
    # laws that are steep in the cold are met less well there
    np.testing.assert_allclose(lubricant.pressure_viscosity_film, film, rtol=1e-6)
    valid = oil.at(np.linspace(*oil.temperature_valid, 21))
    np.testing.assert_allclose(valid.pressure_viscosity_film, alpha_of(valid.pressure_law, "film"), rtol=1e-7)
    # for another law by dataclasses.replace it is computed again
    thick = replace(oil.at(353.15), pressure_rise_factor=1.2)
    assert thick.pressure_viscosity_film == pytest.approx(alpha_of(thick.pressure_law, "film"), rel=1e-12, abs=0.0)
    assert thick.pressure_viscosity_film > 1.1 * oil.at(353.15).pressure_viscosity_film


def test_an_anchored_law_by_constants_has_its_anchor() -> None:
    """FVA 400 "HC + PMA1" through a secant of 9.68 1/GPa at 100 degC: all constants over 0.9404."""
    law = {"law": "modulus", "K": 6.4e-5, "B": 1073.0, "C": 110.0}
    law |= {"a1": 4.115e7, "a2": 4.797e5, "b1": 0.0361, "b2": 0.4055e-4}
    alpha = {"law": "constants", "anchor_temperature": 373.15, "anchor_value": 9.68e-9}
    figures = card("slope", GOLD).model_dump() | {"viscosity": law}
    figures["pressure_viscosity"] = alpha | {"alpha_definition": "secant_200"}
    oil = Oil.model_validate({key: value for key, value in figures.items() if value is not None})
    assert alpha_of(oil.at(373.15).pressure_law, "secant_200") == pytest.approx(9.68e-9, rel=1e-12, abs=0.0)
    assert oil.at(313.15).modulus_constants[0] == pytest.approx(4.115e7 / 0.94042, rel=1e-4)


def test_cards_without_the_meaning_of_their_coefficient_say_so() -> None:
    silent = card("slope", GOLD).model_copy(update={"pressure_viscosity": GoldAlpha.model_validate(GOLD)})
    assert "alpha_definition" in silent.remarks()[0]
    assert silent.at(373.15).pressure_viscosity == pytest.approx(9.68e-9, rel=1e-12, abs=0.0)
    assert card("secant_200", GOLD).remarks() == ()
    contact = Contact(**BASE, viscosity_inlet=0.02, pressure_viscosity=18e-9)
    assert "alpha_definition" in contact.lubricant.remarks()[0]
    stated = contact.replace(alpha_definition="slope")
    assert not any("alpha_definition" in remark for remark in stated.lubricant.remarks())


@pytest.mark.parametrize("definition", DEFINITIONS)
def test_lubricants_given_by_numbers_hold_their_stated_coefficient(definition: AlphaDefinition) -> None:
    stated = {"pressure_viscosity": 15e-9, "alpha_definition": definition, "temperature": 373.15}
    glass = {"law": "yasutomi_improved", "Tg0": "-71.70 degC", "A1": 210.6, "A2": "0.455 1/GPa"}
    glass |= {"b1": "7.606 1/GPa", "b2": -0.4193, "C1": 16.372, "C2": 29.99}
    for lubricant in (
        Contact(**BASE, **stated, viscosity_inlet=0.02).lubricant.lubricant(),
        Contact(**BASE, **stated, viscosity_inlet=0.02, viscosity_law="barus").lubricant.lubricant(),
        Contact(**BASE, **stated, viscosity=glass).lubricant.lubricant(),
    ):
        assert alpha_of(lubricant.pressure_law, definition) == pytest.approx(15e-9, rel=1e-10, abs=0.0)
        law = lubricant.pressure_law
        assert lubricant.pressure_viscosity == pytest.approx(alpha_of(law, "slope"), rel=1e-10, abs=0.0)
    own = Contact(**BASE, viscosity=glass, temperature=373.15).lubricant.lubricant()
    assert own.viscosity_inlet == pytest.approx(0.01154, rel=1e-3)
    assert alpha_of(own.pressure_law, "secant_200") == pytest.approx(14.14e-9, rel=1e-3, abs=0.0)


@pytest.mark.parametrize("name", ABSOLUTE)
def test_derivatives_of_laws_by_constants(name: str) -> None:
    law = ABSOLUTE[name]
    pressure, temperature = np.meshgrid(np.linspace(1e6, 4e9, 61), np.linspace(253.15, 453.15, 31))
    step = 1e3
    slope = (law.log_viscosity(pressure + step, temperature) - law.log_viscosity(pressure - step, temperature)) / 2e3
    np.testing.assert_allclose(law.by_pressure(pressure, temperature), slope, rtol=1e-5, atol=1e-14)
    warm, cold = (law.log_viscosity(pressure, temperature + s) for s in (0.01, -0.01))
    # the place of the largest viscosity of the original form moves with temperature: 2e-13/Pa times some MPa/K
    near = 3e-6 if name == "5P4E" else 1e-7
    np.testing.assert_allclose(law.by_temperature(pressure, temperature), (warm - cold) / 0.02, rtol=1e-5, atol=near)
    assert np.all(law.by_pressure(pressure, temperature) >= 0.0)


def test_modulus_law_with_a_pole_goes_on_along_its_tangent() -> None:
    """b1 + b2 T < 0 above 98 degC (PAO/E + PIB of FVA 400): the pole at 120 degC is at 9.7 GPa."""
    law = ModulusLaw((2.704e7, 8.399e5, 57.94e-3, -5.921e-4), 393.15, (1000.0, 95.0))
    low, stiffening = 2.704e7 + 120.0 * 8.399e5, 57.94e-3 - 120.0 * 5.921e-4
    last = -0.9 * low / stiffening
    pressure = np.array([0.8 * last, 1.5 * last, 3.0 * last])
    wanted = [pressure[0] / (low + stiffening * pressure[0])]
    wanted += [last / (0.1 * low) + (p - last) / (0.01 * low) for p in pressure[1:]]
    np.testing.assert_allclose(law.log_ratio(pressure), wanted, rtol=1e-12)
    assert np.all(np.diff(law.log_ratio(np.linspace(0.0, 2.0 * last, 200))) > 0.0)
    warm, cold = (law.log_ratio(pressure, np.full(3, 393.15 + s)) for s in (0.01, -0.01))
    found = law.by_temperature(pressure, np.full(3, 393.15))
    np.testing.assert_allclose(found, (warm - cold) / 0.02, rtol=1e-6)


def test_original_yasutomi_form_never_thins_under_pressure() -> None:
    """F = 1 - 4.815 ln(1 + 0.16 p) turns negative near 1.4 GPa; the viscosity stays at its largest."""
    pressure = np.linspace(0.0, 5e9, 400)
    for celsius in (20.0, 40.0, 100.0, 140.0):
        value = POLYPHENYL_ETHER.log_viscosity(pressure, np.full(400, celsius + KELVIN))
        assert np.all(np.diff(value) >= -1e-12)
        free = 1.0 - 4.815 * np.log1p(0.16e-9 * pressure)
        distance = (celsius + 28.2 - 134.2 * np.log1p(1.929e-9 * pressure)) * free
        plain = math.log(1e12) - math.log(10.0) * 16.01 * distance / (20.69 + distance)
        rising = (np.minimum.accumulate(distance) == distance) & (distance > -0.5 * 20.69)
        assert rising.sum() > 20
        np.testing.assert_allclose(value[rising], plain[rising], rtol=1e-9)


@pytest.mark.parametrize(
    ("state", "power"),
    [
        (Tait(K00=8.658e9, betaK=6.33e-3, K0_rate=11.74), False),
        (Murnaghan(K00=9.234e9, betaK=6.09e-3, K0_rate=10.545), True),
    ],
)
def test_equations_of_state_by_their_bulk_modulus(state: Tait | Murnaghan, power: bool) -> None:
    """K = rho dp/drho is K0 at p = 0 and grows with K0'; Murnaghan's grows linearly, Tait's as (K0 + (1 + K0') p) V."""
    at = state.at(333.15)
    pressure = np.linspace(0.0, 3e9, 31)
    bulk = at.ratio(pressure) / at.slope(pressure)
    zero = state.K00 * math.exp(-state.betaK * 333.15)
    tait = (zero + (1.0 + state.K0_rate) * pressure) / at.ratio(pressure)
    wanted = zero + state.K0_rate * pressure if power else tait
    np.testing.assert_allclose(bulk, wanted, rtol=1e-12)
    # the density by integrating its slope
    wanted_ratio = [1.0 + quad(lambda p: float(at.slope(p)), 0.0, end, epsrel=1e-12)[0] for end in pressure[1::10]]
    np.testing.assert_allclose(at.ratio(pressure[1::10]), wanted_ratio, rtol=1e-9)


def test_constants_with_which_the_viscosity_falls_or_has_a_pole_are_refused() -> None:
    """5P4E's original form is at its largest near 1.2 GPa at 100 degC; b1 below zero is a pole at a1/|b1|."""
    base = BASE | {"temperature": 373.15}
    ether = {"law": "yasutomi_original", "Tg0": "-28.2 degC", "A1": 134.2, "A2": "1.929 1/GPa"}
    ether |= {"B1": 4.815, "B2": "0.160 1/GPa", "C1": 16.01, "C2": 20.69}
    assert Contact(**base, viscosity=ether).lubricant.lubricant().viscosity_inlet == pytest.approx(0.0164, rel=1e-2)
    with refuses("viscosity.law"):
        Contact(**base, viscosity=ether, pressure_valid="2 GPa")
    pole = {"law": "modulus", "K": 6e-5, "B": 1000.0, "C": 100.0, "a1": 5e7, "a2": 0.0, "b1": -0.2, "b2": 0.0}
    with refuses("viscosity.law"):
        Contact(**base, viscosity=pole)


def test_beyond_the_measured_pressure_the_law_goes_on_and_its_tangent_bounds_it() -> None:
    """Modulus law: L = p/(A + B p), tangent A/(A + B p)^2."""
    base = BASE | {"pressure_hertz": 1.5e9, "temperature": 373.15}
    law = {"law": "modulus", "K": 6e-5, "B": 1000.0, "C": 100.0, "a1": 8e7, "a2": 0.0, "b1": 0.05, "b2": 0.0}
    oil = Contact(**base, viscosity=law, pressure_valid="0.7 GPa").lubricant.lubricant()
    at, end = (p / (8e7 + 0.05 * p) for p in (1.5e9, 0.7e9))
    tangent = end + 0.8e9 * 8e7 / (8e7 + 0.05 * 0.7e9) ** 2
    assert oil.continuation_difference(1.5e9) == pytest.approx(tangent / at - 1.0, rel=1e-9)
    assert oil.continuation_difference(0.6e9) == 0.0
    notes = Contact(**base, viscosity=law, pressure_valid="0.7 GPa", thermal="off").solve().notes
    assert any("above 0.7 GPa, the measured range of the oil" in note for note in notes)
