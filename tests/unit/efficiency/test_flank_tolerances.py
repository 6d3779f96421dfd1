"""Flank tolerances of a grade: a tolerance of ISO 1328-1:2013 is two standard deviations."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from efficiency.contact.relief import FlankDeviation, flank_tolerances
from efficiency.design.design import load_design


@pytest.mark.parametrize("grade", [5, 6])
def test_two_standard_deviations_are_the_tolerance(grade: int) -> None:
    """Slope: range of the deviation; form: its band about the mean line. Root of the sum of squares of both members."""
    design, module = load_design("fh_hypoid_9x34"), 4.0
    blanks = design.pinion.blank, design.gear.blank
    # ISO 1328-1:2013, um, of module, reference diameter and face width in mm
    laws: dict[str, Callable[[float, float], float]] = {
        "profile_slope": lambda d, b: 0.4 * module + 0.001 * d + 4.0,
        "profile_crowning": lambda d, b: 0.55 * module + 5.0,
        "lengthwise_slope": lambda d, b: 0.05 * math.sqrt(d) + 0.35 * math.sqrt(b) + 4.0,
        "lengthwise_crowning": lambda d, b: 0.07 * math.sqrt(d) + 0.45 * math.sqrt(b) + 4.0,
    }
    laws["twist"] = laws["lengthwise_crowning"]
    sizes = [(2e3 * x.mean_cone_distance * math.sin(x.pitch_angle), 1e3 * x.face_width) for x in blanks]
    sigma = flank_tolerances(grade, 1e-3 * module, *blanks).model_dump()
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, 21) * blanks[1].face_width, np.linspace(0.0, 1.0, 21))
    plane = np.stack([np.ones(u.size), u.ravel() / blanks[1].face_width, v.ravel()], axis=1)
    for name, law in laws.items():
        depth = FlankDeviation(**{name: 2.0 * sigma[name]}).depth(blanks[1], u, v).ravel()
        mean = 0.0 if name.endswith("slope") else plane @ np.linalg.lstsq(plane, depth, rcond=None)[0]
        allowed = math.sqrt(2.0) ** (grade - 5) * math.hypot(*(law(*size) for size in sizes))
        assert 1e6 * np.ptp(depth - mean) == pytest.approx(allowed, rel=1e-9)
