"""Local conditions of a contact point, worked out by hand from its state and its oil."""

import math
from typing import Any

import numpy as np
import pytest
from refusals import refuses

from ehl.fluid.oil import Oil
from ehl.line_contact import LineContact, moes_1992
from ehl.state import ContactState
from regression.friction.conditions import conditions_of, contact_points

OIL = Oil.load("75w90")


def test_conditions_of_two_points_by_hand() -> None:
    """1 GPa and 12 mm at 4 m/s; sliding 1.2 m/s across and 0.5 m/s along the line, the second point smooth."""
    state = ContactState.of(
        pressure_hertz=[1e9, 1e9],
        radius_equivalent=0.012,
        effective_modulus=228e9,
        speed_entrainment=4.0,
        slide_to_roll=-0.3,
        speed_sliding_lengthwise=0.5,
        temperature_oil=[353.15, 373.15],
        roughness_rms_1=[0.3e-6, 0.0],
        roughness_rms_2=[0.4e-6, 0.0],
    )
    found = conditions_of(state, OIL)
    half_width = 4.0 * 0.012 * 1e9 / 228e9
    np.testing.assert_allclose(found["half_width"], half_width, rtol=1e-12)
    np.testing.assert_allclose(found["load_per_length"], 0.5 * math.pi * half_width * 1e9, rtol=1e-12)
    np.testing.assert_allclose(found["speed_sum"], 8.0, rtol=1e-12)
    np.testing.assert_allclose(found["speed_sliding"], 1.3, rtol=1e-12)
    np.testing.assert_allclose(found["slide_to_roll_total"], 1.3 / 4.0, rtol=1e-12)
    np.testing.assert_allclose(found["roughness_rms"], [0.5e-6, 0.0], rtol=1e-12)
    for k, temperature in enumerate((353.15, 373.15)):
        oil = OIL.at(temperature)
        line = LineContact(0.012, 228e9, 0.5 * math.pi * half_width * 1e9, 4.0)
        speed, _, _ = line.dowson_groups(oil)
        incompressible = moes_1992(*line.moes_groups(oil)) * 0.012 * math.sqrt(2.0 * speed)
        # Dowson & Higginson at 1 GPa
        film = incompressible / (1.0 + 0.6 / 2.7)
        assert found["film_formula"][k] == pytest.approx(film, rel=1e-9)
        assert found["viscosity_inlet"][k] == pytest.approx(oil.viscosity_inlet, rel=1e-12)
        assert found["viscosity_kinematic"][k] == pytest.approx(oil.viscosity_inlet / oil.density, rel=1e-12)
        mean = float(oil.viscosity(np.array([0.25e9 * math.pi]))[0])
        assert found["viscosity_mean_pressure"][k] == pytest.approx(mean, rel=1e-9)
    assert found["film_ratio_formula"][0] == pytest.approx(found["film_formula"][0] / 0.5e-6, rel=1e-12)
    assert found["film_ratio_formula"][1] == math.inf


def test_contradicting_points_are_refused() -> None:
    """Ratios above 2 are bodies that move in opposite directions."""
    point = {"pressure_hertz": 1e9, "radius_equivalent": 0.012, "speed_entrainment": 4.0, "temperature_oil": 353.15}
    assert contact_points(**point, slide_to_roll=2.0).slide_to_roll == 2.0
    changes: list[tuple[dict[str, Any], str]] = [
        ({"temperature": 353.15}, "temperature"),
        ({"speed_entrainment": []}, "speed_entrainment"),
        ({"speed_entrainment": [1.0, 2.0], "slide_to_roll": [0.1, 0.2, 0.3]}, "speed_entrainment, slide_to_roll"),
        *(({"slide_to_roll": ratio}, "slide_to_roll") for ratio in (2.1, -3.0, [0.1, 2.5])),
    ]
    for change, field in changes:
        with refuses(field):
            contact_points(**point | {"slide_to_roll": 0.2} | change)
