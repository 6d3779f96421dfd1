"""Friction models: names, flags, and what must hold for each of them."""

import numpy as np
import pytest
from contacts import gear_state as state
from hypothesis import given, settings
from hypothesis import strategies as st

from ehl.common.errors import InputError
from ehl.fluid.oil import Oil
from regression.formula import friction_model
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
