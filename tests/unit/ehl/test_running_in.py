"""Running-in by plastic flattening."""

import math

import numpy as np
import pytest
from contacts import line_contact

import ehl
from ehl.common.errors import ConvergenceError, InputError
from ehl.rough.dry import solve_dry, uniform_grid
from ehl.rough.mixed import flattened
from ehl.surface.roughness import RoughProfile, generate_profile

LINE = line_contact(pressure_hertz=1.2e9, speed_entrainment=1.0, slide_to_roll=0.0)
B = LINE.half_width


def rough(rms: float = 0.4e-6) -> RoughProfile:
    return generate_profile(rms, 0.05 * B, 6.0 * B, 0.005 * B, 3)


def test_elastic_contact_leaves_the_profile() -> None:
    profile = rough()
    assert flattened(profile, LINE, math.inf) is profile
    hard = flattened(profile, LINE, 40e9)
    # the offset that is taken out and put back rounds, by library, in the last digit
    np.testing.assert_allclose(hard.heights, profile.heights, rtol=1e-12, atol=1e-20)


def test_peaks_are_flattened_and_a_second_passage_takes_little() -> None:
    profile, hardness = rough(), 2.5e9
    once = flattened(profile, LINE, hardness)
    taken = profile.heights - once.heights
    taken -= taken.min()
    assert taken.max() > 20e-9
    assert once.rms < profile.rms
    assert once.skewness < profile.skewness
    # only what stands out is touched
    assert profile.heights[taken > 1e-10].mean() > 0.9 * profile.rms
    assert np.median(taken) < 1e-10
    again = flattened(once, LINE, hardness)
    rest = once.heights - again.heights
    assert (rest - rest.min()).max() < 0.3 * taken.max()
    assert "flattened plastically" in once.notes[-1]


def test_flattening_is_the_yield_of_the_dry_contact() -> None:
    """A single asperity in the middle: its plastic overlap is what is taken off."""
    x = uniform_grid(LINE, 600)
    bump = 1e-6 * np.exp(-((x / (0.05 * B)) ** 2))
    found = solve_dry(LINE, x, bump - bump.mean(), hardness=3e9)
    yielded = np.max(-found.gap[found.pressure >= 3e9 * (1.0 - 1e-12)])
    spacing = float(x[1] - x[0])
    period = round(6.0 * B / spacing)
    heights = np.zeros(period)
    heights[: x.size] = bump
    # the asperity stands where a window has its middle
    shift = round(2.0 * B / spacing) - np.argmax(heights)
    profile = RoughProfile.of(np.roll(heights, shift), spacing, cutoff=8.0 * spacing)
    taken = profile.heights - flattened(profile, LINE, 3e9).heights
    assert taken.max() - taken.min() == pytest.approx(yielded, rel=0.1)


def test_a_hardness_below_the_load_is_refused() -> None:
    with pytest.raises(ConvergenceError, match="hardness"):
        flattened(rough(), LINE, 0.2e9)


def test_unknown_running_in_is_refused() -> None:
    given = {
        "oil": "75w90", "temperature": "80 degC", "pressure_hertz": "1 GPa", "radius_equivalent": "15 mm",
        "speed_entrainment": "1 m/s", "roughness_rms": "0.4 um",
    }  # fmt: skip
    with pytest.raises(InputError) as error:
        ehl.Contact(**given, running_in="wear")
    assert error.value.field == "running_in"
