from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from refusals import refuses

from ehl.fluid.load_sharing import LOAD_SHARES, load_sharing


@pytest.mark.parametrize("model", LOAD_SHARES)
@given(film_ratio=st.floats(0.0, 20.0), step=st.floats(1e-3, 5.0))
def test_share_falls_from_one_to_nothing(model: str, film_ratio: float, step: float) -> None:
    share = LOAD_SHARES[model]
    assert share(0.0) == 1.0
    assert 0.0 <= share(film_ratio + step) <= share(film_ratio) <= 1.0
    assert share(50.0) == 0.0


@pytest.mark.parametrize("model", LOAD_SHARES)
def test_limits_of_friction(model: str) -> None:
    dry = load_sharing(0.0, 0.02, 0.1, model)
    assert (dry.friction_fluid, dry.friction_asperity, dry.asperity_load_share) == (0.0, 0.1, 1.0)
    smooth = load_sharing(math.inf, 0.02, 0.1, model)
    assert (smooth.friction_fluid, smooth.friction_asperity, smooth.asperity_load_share) == (0.02, 0.0, 0.0)


def test_arana_share_at_unit_film_ratio() -> None:
    assert LOAD_SHARES["arana_2019"](1.0) == pytest.approx(1.0 - 0.8427007929, abs=1e-9)


@pytest.mark.parametrize(("film_ratio", "share"), [(0.0, 1.0), (0.5, 0.5625), (1.0, 0.25), (1.6, 0.04), (2.0, 0.0)])
def test_doleschel_share_by_hand(film_ratio: float, share: float) -> None:
    """(1 - lambda/2)^2 up to 2."""
    assert LOAD_SHARES["doleschel_2002"](film_ratio) == pytest.approx(share, rel=1e-12)


def test_unknown_model() -> None:
    with refuses("model.load_sharing"):
        load_sharing(1.0, 0.02, 0.1, "guess")


@pytest.mark.parametrize("model", LOAD_SHARES)
def test_scale_is_a_factor_on_the_film_ratio(model: str) -> None:
    scaled, moved = load_sharing(0.5, 0.02, 0.1, model, 1.6), load_sharing(0.8, 0.02, 0.1, model)
    assert scaled.asperity_load_share == pytest.approx(moved.asperity_load_share, rel=1e-12)
    assert scaled.asperity_load_share < load_sharing(0.5, 0.02, 0.1, model).asperity_load_share
