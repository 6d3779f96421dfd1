"""Film formulas against the reference solutions: a blunder in a coefficient or group would be far outside."""

import json
import math
from collections.abc import Callable

import numpy as np
import pytest

from ehl.common.data import data_path
from ehl.line_contact import moes_1992
from regression.friction.published import pan_hamrock_1989_minimum

CASES = json.loads(data_path("reference", "ehl_smooth_cases.json").read_text(encoding="utf-8"))["cases"]
COMPRESSIBLE = [case for case in CASES if case["inputs"]["density"] == "dowson-higginson"]


def dowson_higginson_1968(speed: float, load: float, material: float) -> float:
    """Minimum film h_min/R = 2.65 U^0.70 G^0.54 W^-0.13 (Dowson & Higginson; exponents of 1968)."""
    return 2.65 * speed**0.70 * material**0.54 * load**-0.13


def pan_hamrock_1989_central(speed: float, load: float, material: float) -> float:
    """Central film h_c/R = 2.922 U^0.692 G^0.470 W^-0.166 (Pan & Hamrock 1989, J. Tribol. 111; unverified)."""
    return 2.922 * speed**0.692 * material**0.470 * load**-0.166


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_moes_within_its_own_spread(case: dict) -> None:
    """Moes is an incompressible formula for h where dp/dx = 0, so it is compared with flow/(rho0 u_r): within 7 %."""
    groups = case["groups"]
    film = case["outputs"]["q_over_ur"]["value"] / case["inputs"]["R"] / math.sqrt(2.0 * groups["U"])
    assert moes_1992(groups["M"], groups["L"]) == pytest.approx(film, rel=0.07)


@pytest.mark.parametrize("case", COMPRESSIBLE, ids=lambda case: case["name"])
def test_minimum_and_central_films(case: dict) -> None:
    """Dowson & Higginson within 12 %, Pan & Hamrock within 12 %: the spread of these fits over M 1.7 to 744."""
    groups, outputs, radius = case["groups"], case["outputs"], case["inputs"]["R"]
    numbers = (groups["U"], groups["W"], groups["G"])
    minimum, central = outputs["h_min"]["value"] / radius, outputs["h_central"]["value"] / radius
    assert dowson_higginson_1968(*numbers) == pytest.approx(minimum, rel=0.12)
    assert pan_hamrock_1989_minimum(*numbers) == pytest.approx(minimum, rel=0.12)
    assert pan_hamrock_1989_central(*numbers) == pytest.approx(central, rel=0.12)


def test_moes_reduces_to_its_asymptotes() -> None:
    # rigid isoviscous (Martin: h0 w'/(eta0 u_r R) = 4.9, so H = 2.45/M; Moes rounds the blend to 3/M) and no kink
    assert moes_1992(1e-3, 0.0) == pytest.approx(3.0 / 1e-3, rel=1e-3)
    assert moes_1992(1e5, 0.0) == pytest.approx(2.621 * 1e5**-0.2, rel=1e-3)
    assert moes_1992(1e8, 1e3) == pytest.approx(1.311 * 1e8**-0.125 * 1e3**0.75, rel=1e-2)


def test_moes_takes_arrays() -> None:
    load, lubricant = (grid.ravel() for grid in np.meshgrid(np.geomspace(1e-6, 1e6, 13), np.geomspace(0.1, 100.0, 7)))
    one_by_one = [moes_1992(m, lu) for m, lu in zip(load.tolist(), lubricant.tolist(), strict=True)]
    np.testing.assert_allclose(moes_1992(load, lubricant), one_by_one, rtol=1e-13)


@pytest.mark.parametrize(
    ("formula", "coefficient", "exponents"),
    [
        (dowson_higginson_1968, 2.65, (0.70, -0.13, 0.54)),
        (pan_hamrock_1989_minimum, 1.714, (0.694, -0.128, 0.568)),
        (pan_hamrock_1989_central, 2.922, (0.692, -0.166, 0.470)),
    ],
)
def test_coefficient_and_exponents_as_printed(
    formula: Callable[[float, float, float], float], coefficient: float, exponents: tuple[float, float, float]
) -> None:
    """Groups of 1 leave the coefficient; doubling U, W or G multiplies the film by 2 to its exponent."""
    assert formula(1.0, 1.0, 1.0) == coefficient
    for place, exponent in enumerate(exponents):
        groups = [1.0, 1.0, 1.0]
        groups[place] = 2.0
        assert formula(*groups) == pytest.approx(coefficient * 2.0**exponent, rel=1e-14)
