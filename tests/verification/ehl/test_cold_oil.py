"""Cold start: smooth contacts of oils from -40 degC on, whose films heat makes a hundred times thinner."""

from itertools import product

import numpy as np
import pytest
from samples import CONTACT

from ehl.contact import Contact
from ehl.fluid.oil import Oil
from ehl.result import ContactResult

OILS = ("75w90", "80w90", "fva3", "squalane", "pao_ester")


def solve(oil: str, temperature: float, pressure: str, speed: str) -> ContactResult:
    contact = CONTACT | {"pressure_hertz": pressure, "speed_entrainment": speed}
    return Contact(oil=oil, temperature=f"{temperature} degC", accuracy="fast", **contact).solve()


@pytest.mark.parametrize("temperature", [-40, -20])
def test_cold_contacts_have_an_answer(temperature: float) -> None:
    for oil, pressure, speed in product(OILS, ("0.5 GPa", "1.2 GPa"), ("0.5 m/s", "5 m/s")):
        result = solve(oil, temperature, pressure, speed)
        assert result.status != "failed", (oil, pressure, speed, result.reason)
        assert 0.01 < result.friction_coefficient < 0.08
        assert result.film_central < 60e-6


def test_the_reference_temperature_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Viscosities from other temperatures on are those of the same oil: the same film and friction."""
    found = {}
    for warmer in ((60.0,), (90.0,)):
        monkeypatch.setattr("ehl.smooth.thermal.WARMER", warmer)
        found[warmer] = solve("80w90", -40, "1.2 GPa", "0.5 m/s")
    one, other = found.values()
    assert one.heat is not None
    assert one.film_central == pytest.approx(other.film_central, rel=one.film_error + other.film_error)
    allowed = one.friction_error + other.friction_error
    assert one.friction_coefficient == pytest.approx(other.friction_coefficient, rel=allowed)


@pytest.mark.parametrize("name", ["75w90", "80w90", "squalane", "5p4e"])
def test_an_oil_referred_to_another_temperature_is_the_same_oil(name: str) -> None:
    cold = Oil.load(name).at(273.15)
    warm = cold.referred_to(330.0)
    pressure, temperature = np.linspace(0.0, 1.5e9, 7)[:, None], np.linspace(260.0, 420.0, 7)[None, :]
    expected = cold.log_viscosity(pressure, temperature)
    np.testing.assert_allclose(warm.log_viscosity(pressure, temperature), expected, atol=1e-11)
    at_330 = np.exp(cold.log_viscosity(pressure, np.array([330.0]))[:, 0])
    np.testing.assert_allclose(warm.viscosity(pressure[:, 0]), at_330)
