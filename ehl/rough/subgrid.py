"""Roughness finer than the mesh: long waves remain a profile, shorter waves are replaced by a subgrid film.

Waves shorter than a cut-off are removed from the profiles; their RMS is sigma_sub. Solids count as touching where the
gap of the filtered surfaces is c sigma_sub above the boundary film. This is the mean gap of the fine roughness under
load. In dry contact it decreases with the logarithm of the pressure over the stiffness E* times the RMS slope (form of
Persson 2007, Phys. Rev. Lett. 99, 125502, from memory; both constants are fitted to runs that resolve the roughness).
c = 0 (no contact of the fine part) and 2 c + 0.5 (at most 2.5, its peaks) bound friction, and their difference is the
error: see docs/roughness.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ehl.common.errors import InputError
from ehl.inputs import SurfaceInput
from ehl.line_contact import LineContact
from ehl.rough import RoughSurfaces
from ehl.surface.measured_profile import detrended, gaussian_mean_line, load_profile, profile_points
from ehl.surface.roughness import RoughProfile, SelfAffine, generate_profile

STYLUS_CUTOFF = 2.5e-6  # shortest wavelength in Rq [m]
CUTOFF_NODES = 8.0  # nodes per shortest remaining wavelength
BUDGET_SHARE = 0.6  # share of the nodes of the accuracy; the bounds of the subgrid film dominate the error
# tuned on runs that resolve the roughness (validation/mixed_shortcuts.py): mean gap/sigma_sub = 0.4 ln(0.5 E* slope/p)
GAP_LOG, GAP_PRESSURE = 0.4, 0.5
MIN_GAP, MAX_GAP = 0.1, 2.5


@dataclass(frozen=True)
class SplitSurfaces:
    """Both surfaces without their fine part, and the properties of that part."""

    surfaces: RoughSurfaces  # the waves longer than the cut-off
    cutoff: float  # [m]
    rms: float  # composite Rq of the unfiltered surfaces [m]
    rms_below: float  # composite RMS below the cut-off, sigma_sub [m]
    slope: float  # composite RMS slope of that part [-]

    def gap(self, contact: LineContact) -> float:
        """Mean gap of the fine part under the Hertz pressure, over sigma_sub [-]."""
        stiffness = 0.5 * contact.effective_modulus * self.slope
        if stiffness <= 0.0:
            return MIN_GAP
        gap = GAP_LOG * math.log(GAP_PRESSURE * stiffness / contact.pressure_hertz)
        return min(max(gap, MIN_GAP), MAX_GAP)

    def subgrid_films(self, contact: LineContact, base: float) -> tuple[float, float, float]:
        """Boundary film plus subgrid film [m]: without the fine part, expected value, and upper bound."""
        gap = self.gap(contact)
        return base, base + gap * self.rms_below, base + min(2.0 * gap + 0.5, MAX_GAP) * self.rms_below


def split_surfaces(surface: SurfaceInput, half_width: float, length: float, cutoff: float) -> SplitSurfaces:
    """Split the roughness of a contact at a wavelength.

    surface: generated or measured roughness.
    half_width, length, cutoff: Hertz half-width, length of generated profiles, and cut-off [m].
    """
    kept: list[RoughProfile | None] = []
    whole = below = slope = 0.0
    for number, (rms, path) in enumerate(
        ((surface.roughness_rms_1, surface.profile_1), (surface.roughness_rms_2, surface.profile_2)), start=1
    ):
        if path is not None:
            profile, fine_rms, fine_slope = _split_measured(path, surface, cutoff)
        elif rms > 0.0:
            profile, fine_rms, fine_slope = _split_generated(rms, surface, 2 * surface.seed + number, length, cutoff)
        else:
            kept.append(None)
            continue
        kept.append(profile)
        coarse = profile.rms if profile is not None else 0.0
        whole += coarse**2 + fine_rms**2
        below += fine_rms**2
        slope += fine_slope**2
    return SplitSurfaces(RoughSurfaces(*kept), cutoff, math.sqrt(whole), math.sqrt(below), math.sqrt(slope))


def _split_generated(
    rms: float, surface: SurfaceInput, seed: int, length: float, cutoff: float
) -> tuple[RoughProfile | None, float, float]:
    """Long waves of a generated profile, and RMS and slope of the fine part from its spectrum."""
    lc = surface.correlation_length
    left_out = share_left_out(surface, cutoff)
    slope = math.sqrt(2.0) * rms / lc
    if surface.hurst is not None:
        slope = rms * SelfAffine(lc, surface.hurst).slope(STYLUS_CUTOFF, cutoff)
    if cutoff > length / 4.0:
        return None, rms, slope
    profile = generate_profile(
        rms * math.sqrt(1.0 - left_out),
        lc,
        length,
        cutoff / 4.0,
        seed,
        cutoff=cutoff,
        hurst=surface.hurst,
        peklenik_number=surface.peklenik_number,
    )
    return profile, rms * math.sqrt(left_out), slope


def share_left_out(surface: SurfaceInput, cutoff: float) -> float:
    """Share of the variance of a generated surface in waves shorter than the cut-off [m].

    The whole spectrum exp(-(k lc)^2/4) is included; for a self-affine surface waves down to 2.5 um (ISO 3274).
    """
    if surface.hurst is None:
        return math.erfc(math.pi * surface.correlation_length / cutoff)
    spectrum = SelfAffine(surface.correlation_length, surface.hurst)
    unseen = spectrum.share_below(STYLUS_CUTOFF)
    return max(spectrum.share_below(cutoff) - unseen, 0.0) / (1.0 - unseen)


def _split_measured(path: str, surface: SurfaceInput, cutoff: float) -> tuple[RoughProfile | None, float, float]:
    x, heights, _ = profile_points(path, unit_x=surface.profile_unit_x, unit_height=surface.profile_unit_height)
    spacing = float(x[1] - x[0])
    level = detrended(heights, surface.detrend)
    in_band = gaussian_mean_line(level, spacing, surface.cutoff_short)
    try:
        profile = load_profile(path, cutoff_short=cutoff, **surface.profile_reading)
    except InputError:
        # the cut-off exceeds the range of the file: all its roughness is fine structure
        if surface.cutoff_long is not None:
            in_band = in_band - gaussian_mean_line(in_band, spacing, surface.cutoff_long)
        return None, float(np.std(in_band)), float(np.std(np.diff(in_band))) / spacing
    fine = in_band - gaussian_mean_line(level, spacing, cutoff)
    return profile, float(np.std(fine)), float(np.std(np.diff(fine))) / spacing
