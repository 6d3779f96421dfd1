"""Figure of a rough profile as it is used: heights, height distribution, autocorrelation, spectrum."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ehl.surface.roughness import RoughProfile, autocorrelation
from ehl.view.plots import BLUE, GREY, ORANGE

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_profile(profile: RoughProfile, title: str = "") -> Figure:
    """Four panels of one profile, with the Gaussian of the same Rq and correlation length in grey.

    Parameters
    ----------
    profile : RoughProfile
    title : str
        The profile's source when empty.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 5.6), layout="constrained")
    axes = figure.subplot_mosaic([["line"] * 3, ["density", "correlation", "spectrum"]], height_ratios=(2, 3))
    line, panels = axes["line"], [axes[name] for name in ("density", "correlation", "spectrum")]
    heights, scale = np.asarray(profile.heights) * 1e6, 1e6
    line.plot(profile.x * 1e3, heights, color=BLUE, lw=0.7)
    line.set(xlabel="x [mm]", ylabel="height [um]", xlim=(0.0, profile.length * 1e3))
    line.set_title(title or profile.source or "profile", fontsize=9)

    rq = max(profile.rms * scale, 1e-9)
    panels[0].hist(heights, bins=60, density=True, color=BLUE, alpha=0.5)
    z = np.linspace(-4.0 * rq, 4.0 * rq, 161)
    panels[0].plot(z, np.exp(-0.5 * (z / rq) ** 2) / (rq * math.sqrt(2.0 * math.pi)), color=GREY)
    panels[0].set(xlabel="height [um]", ylabel="density [1/um]")
    moments = f"skewness {profile.skewness:.2f}, kurtosis {profile.kurtosis:.2f}"
    panels[0].set_title(f"Rq {profile.rms * scale:.3g} um, {moments}", fontsize=8)

    lc = profile.correlation_length
    reach = 4.0 * lc if math.isfinite(lc) else 0.1 * profile.length
    acf = autocorrelation(np.asarray(profile.heights), periodic=profile.periodic)
    lag = profile.spacing * np.arange(len(acf))
    near = lag <= reach
    panels[1].plot(lag[near] * 1e6, acf[near], color=BLUE)
    if math.isfinite(lc):
        panels[1].plot(lag[near] * 1e6, np.exp(-((lag[near] / lc) ** 2)), color=GREY)
    panels[1].axhline(0.0, color=GREY, lw=0.5)
    panels[1].set(xlabel="lag [um]", ylabel="autocorrelation [-]")
    panels[1].set_title(f"correlation length {lc * 1e6:.3g} um", fontsize=8)

    power = np.abs(np.fft.rfft(heights)[1:]) ** 2 / len(heights) ** 2 * 2.0
    wavelength = profile.length / np.arange(1, len(power) + 1) * 1e6
    shown = power > 1e-12 * max(float(power.max(initial=0.0)), 1e-300)
    panels[2].loglog(wavelength[shown], power[shown], color=BLUE, lw=0.7)
    panels[2].axvline(profile.cutoff * 1e6, color=ORANGE, ls="--", lw=1.0)
    panels[2].set(xlabel="wavelength [um]", ylabel="power [um^2]")
    panels[2].set_title(f"cut-off {profile.cutoff * 1e6:.3g} um", fontsize=8)
    return figure
