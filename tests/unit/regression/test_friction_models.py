"""Friction models: names, flags, what must hold for each of them; local conditions worked out by hand."""

import math
from typing import Any

import numpy as np
import pytest
from contacts import gear_state
from contacts import gear_state as state
from hypothesis import given, settings
from hypothesis import strategies as st
from refusals import refuses
from samples import AXLE_OIL

from ehl.common.errors import InputError
from ehl.fluid.oil import Oil
from ehl.line_contact import LineContact, moes_1992
from regression.formula import friction_model
from regression.friction.conditions import conditions_of, contact_points
from regression.friction.models import FrictionFlag, FrictionModel
from regression.friction.published_registry import PUBLISHED, SLIDING_FLOOR

OIL = Oil.load("fva3")


@pytest.mark.parametrize("name", [*sorted(PUBLISHED), "coleman"])
def test_published_are_plausible_and_keep_the_shape(name: str) -> None:
    model = friction_model(name)
    assert isinstance(model, FrictionModel)
    estimate = model.mu(state(speed_entrainment=np.array([[2.0, 5.0, 9.0]])), oil=OIL)
    assert estimate.mu.shape == (1, 3)
    assert ((estimate.mu > 0.005) & (estimate.mu < 0.15)).all()
    assert np.isnan(estimate.lower).all() or name == "coleman"
    # pitch point, unloaded end of a line, smooth flanks, both bodies rough: a number, or a flag where unloaded
    rough = 3e-7 * np.array([1.0, 1.0, 0.0, 1.0])
    slides, pressures = np.array([0.0, 0.3, 0.3, -0.3]), 1e9 * np.array([1.0, 0.0, 1.0, 1.0])
    points = state(slide_to_roll=slides, pressure_hertz=pressures, roughness_rms_1=rough, roughness_rms_2=rough)
    estimate = model.mu(points, oil=OIL)
    defined = estimate.flag != FrictionFlag.UNDEFINED
    assert defined[[0, 2, 3]].all()
    assert np.isfinite(estimate.mu[defined]).all()
    assert (estimate.mu[defined] >= 0.0).all()


@settings(max_examples=25, deadline=None)
@given(ratio=st.floats(0.01, 1.5), along=st.floats(0.0, 5.0), name=st.sampled_from(sorted(PUBLISHED)))
def test_friction_does_not_depend_on_the_sign_of_sliding(ratio: float, along: float, name: str) -> None:
    both = state(slide_to_roll=np.array([ratio, -ratio]), speed_sliding_lengthwise=np.array([along, -along]))
    mu = friction_model(name).mu(both, oil=OIL).mu
    assert mu[0] == mu[1]


def test_flags_of_range_and_of_undefined_values() -> None:
    xu = friction_model("xu_kahraman_2007").mu(state(pressure_hertz=np.array([1e9, 0.1e9])), oil=OIL)
    assert xu.flag.tolist() == [FrictionFlag.OK, FrictionFlag.OUTSIDE_RANGE]
    # a nearly unloaded point at speed: the logarithm turns negative
    unloaded = state(pressure_hertz=np.array([1e9, 1e6]), speed_entrainment=15.0)
    kelley = friction_model("benedict_kelley_1961").mu(unloaded, oil=OIL)
    assert kelley.flag.tolist() == [FrictionFlag.OK, FrictionFlag.UNDEFINED]
    assert np.isnan([kelley.mu[1], kelley.lower[1], kelley.upper[1]]).all()
    # formulas that diverge are held at the least sliding
    least = friction_model("benedict_kelley_1961").mu(
        state(slide_to_roll=np.array([0.0, SLIDING_FLOOR / 5.0])), oil=OIL
    )
    assert least.mu[0] == least.mu[1]
    assert least.flag[0] == FrictionFlag.OUTSIDE_RANGE


def test_base_oil_enters_the_lubricant_factor() -> None:
    mineral = friction_model("schlenk_1994").mu(state(), oil=OIL)
    pao = friction_model("schlenk_1994").mu(state(), oil="pao100")
    viscosity = OIL.at(363.15).viscosity_inlet / Oil.load("pao100").at(363.15).viscosity_inlet
    assert float(pao.mu / mineral.mu) == pytest.approx(0.8 * viscosity**0.05, rel=1e-12)


@pytest.mark.parametrize("name", ["constant", "constant:x", "constant:-0.1", "constant:nan", "xu_2007", "nothing.json"])
def test_bad_names_are_refused(name: str) -> None:
    with pytest.raises(InputError) as caught:
        friction_model(name)
    assert caught.value.value == name


def test_conditions_of_two_points_by_hand() -> None:
    """1 GPa and 12 mm at 4 m/s; sliding 1.2 m/s across and 0.5 m/s along the line, the second point smooth."""
    given = {"slide_to_roll": -0.3, "speed_sliding_lengthwise": 0.5, "effective_modulus": 228e9}
    rough = {"roughness_rms_1": [0.3e-6, 0.0], "roughness_rms_2": [0.4e-6, 0.0]}
    kept = {"pressure_hertz": 1e9, "speed_entrainment": 4.0, "temperature_oil": [353.15, 373.15]}
    found = conditions_of(gear_state(**kept, **given, **rough), AXLE_OIL)
    half_width = 4.0 * 0.012 * 1e9 / 228e9
    load = 0.5 * math.pi * half_width * 1e9
    by_hand = {"half_width": half_width, "load_per_length": load, "speed_sum": 8.0, "speed_sliding": 1.3}
    for name, value in (by_hand | {"slide_to_roll_total": 1.3 / 4.0, "roughness_rms": [0.5e-6, 0.0]}).items():
        np.testing.assert_allclose(found[name], value, rtol=1e-12)
    for k, temperature in enumerate((353.15, 373.15)):
        oil = AXLE_OIL.at(temperature)
        line = LineContact(0.012, 228e9, load, 4.0)
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
