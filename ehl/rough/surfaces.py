"""The two rough surfaces of a run, sampled for its mesh."""

import math
from dataclasses import dataclass

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.surface.roughness import RoughProfile


@dataclass(frozen=True)
class RoughSurfaces:
    """Both surfaces; None is a smooth surface."""

    # heights of surface 1 (speed u1) and 2 (u2)
    profile_1: RoughProfile | None = None
    profile_2: RoughProfile | None = None

    def __post_init__(self) -> None:
        for name, profile in (("profile_1", self.profile_1), ("profile_2", self.profile_2)):
            if profile is not None and not bool(np.all(np.isfinite(profile.heights))):
                raise InputError(name, "heights", "finite numbers only [m]", "Repair the gaps of the profile first.")

    @property
    def profiles(self) -> tuple[RoughProfile, ...]:
        """The rough surfaces."""
        return tuple(p for p in (self.profile_1, self.profile_2) if p is not None and p.rms > 0.0)

    @property
    def rms(self) -> float:
        """Composite Rq [m]."""
        return math.sqrt(sum(p.rms**2 for p in self.profiles))

    @property
    def height(self) -> float:
        """Highest peak over deepest valley, both surfaces composed like their Rq [m]."""
        return math.sqrt(sum(float(np.ptp(p.heights)) ** 2 for p in self.profiles))

    @property
    def correlation_length(self) -> float:
        """lc of both surfaces [m] for the drainage (from the mean of Rq^2/lc^2); inf when smooth."""
        curvature = sum((p.rms / p.correlation_length) ** 2 for p in self.profiles)
        return self.rms / math.sqrt(curvature) if curvature > 0.0 else math.inf

    @property
    def shortest_correlation_length(self) -> float:
        """The smaller lc of both surfaces [m]; inf when smooth."""
        return min((p.correlation_length for p in self.profiles), default=math.inf)

    @property
    def shortest_wavelength(self) -> float:
        """Smallest cut-off of the profiles [m]; inf when smooth."""
        return min((p.cutoff for p in self.profiles), default=math.inf)


def sample_ring(profile: RoughProfile | None, spacing: float) -> FloatArray:
    """Heights at the spacing [m] closest to the given one that divides the period (Fourier resampling).

    Raises `InputError`: the spacing has fewer than two samples per shortest wavelength.
    """
    if profile is None or profile.rms == 0.0:
        return np.zeros(0)
    if spacing > profile.cutoff / 2.0:
        allowed = f"at most {profile.cutoff / 2.0:.3g} m for wavelengths down to {profile.cutoff:.3g} m"
        hint = "Use more nodes, or a longer cut-off with the removed part included in the boundary film."
        raise InputError("nodes", f"sample distance {spacing:.3g} m", allowed, hint)
    count = round(profile.length / spacing)
    spectrum = np.fft.rfft(profile.heights)
    kept = np.zeros(count // 2 + 1, dtype=complex)
    shared = min(spectrum.size, kept.size)
    kept[:shared] = spectrum[:shared]
    return np.asarray(np.fft.irfft(kept, count) * (count / profile.heights.size))
