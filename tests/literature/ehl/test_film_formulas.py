"""Film formulas against the reference solutions: a blunder in a coefficient or group would be far outside."""

import json
import math

import numpy as np
import pytest

from ehl.common.data import data_path
from ehl.line_contact import moes_1992
from regression.friction.published import pan_hamrock_1989_minimum

CASES = json.loads(data_path("reference", "ehl_smooth_cases.json").read_text(encoding="utf-8"))["cases"]
COMPRESSIBLE = [case for case in CASES if case["inputs"]["density"] == "dowson-higginson"]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_moes_within_its_own_spread(case: dict) -> None:
    """Moes is an incompressible formula for h where dp/dx = 0, so it is compared with flow/(rho0 u_r): within 7 %."""
    groups = case["groups"]
    film = case["outputs"]["q_over_ur"]["value"] / case["inputs"]["R"] / math.sqrt(2.0 * groups["U"])
    assert moes_1992(groups["M"], groups["L"]) == pytest.approx(film, rel=0.07)


@pytest.mark.parametrize("case", COMPRESSIBLE, ids=lambda case: case["name"])
def test_minimum_film(case: dict) -> None:
    """Pan & Hamrock within 12 %: the spread of this fit over M 1.7 to 744."""
    groups, minimum = case["groups"], case["outputs"]["h_min"]["value"] / case["inputs"]["R"]
    assert pan_hamrock_1989_minimum(groups["U"], groups["W"], groups["G"]) == pytest.approx(minimum, rel=0.12)


def test_coefficient_and_exponents_as_printed() -> None:
    """h_min/R = 1.714 U^0.694 W^-0.128 G^0.568 (Pan & Hamrock 1989)."""
    found = [pan_hamrock_1989_minimum(*(2.0 if k == place else 1.0 for k in range(3))) for place in (0, 1, 2, 3)]
    assert found == pytest.approx(1.714 * 2.0 ** np.array([0.694, -0.128, 0.568, 0.0]), rel=1e-14)


def test_moes_reduces_to_its_asymptotes() -> None:
    # rigid isoviscous (Martin: h0 w'/(eta0 u_r R) = 4.9, so H = 2.45/M; Moes rounds the blend to 3/M) and no kink
    assert moes_1992(1e-3, 0.0) == pytest.approx(3.0 / 1e-3, rel=1e-3)
    assert moes_1992(1e5, 0.0) == pytest.approx(2.621 * 1e5**-0.2, rel=1e-3)
    assert moes_1992(1e8, 1e3) == pytest.approx(1.311 * 1e8**-0.125 * 1e3**0.75, rel=1e-2)
