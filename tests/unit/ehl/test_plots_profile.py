"""The figure of a rough profile shows the profile's own numbers."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ehl.surface.roughness import RoughProfile, generate_profile
from ehl.view.rough_plots import plot_profile


@pytest.mark.parametrize("skewness", [0.0, -1.0])
def test_panels_hold_the_profile(skewness):
    profile = generate_profile(0.4e-6, 20e-6, 4e-3, 2e-6, 3, skewness=skewness, kurtosis=3.0 + 2.0 * skewness**2)
    figure = plot_profile(profile, "flank")
    line, density, correlation, spectrum = figure.axes
    assert_allclose(line.lines[0].get_ydata(), 1e6 * profile.heights)
    assert line.get_title() == "flank"
    assert "Rq 0.4 um" in density.get_title()
    assert correlation.lines[0].get_ydata()[0] == pytest.approx(1.0)
    assert spectrum.lines[1].get_xdata()[0] == pytest.approx(1e6 * profile.cutoff)
    # Parseval: the power of all waves is the variance
    assert np.sum(spectrum.lines[0].get_ydata()) == pytest.approx(0.16, rel=1e-3)


def test_flat_profile_has_a_figure():
    flat = RoughProfile.of(np.zeros(64), 1e-6, cutoff=4e-6)
    assert "Rq 0 um" in plot_profile(flat).axes[1].get_title()
