"""Rough profiles with given statistics.

Monotone maps from Gaussian heights to heights with a given skewness and kurtosis (Johnson's system).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError


@dataclass(frozen=True)
class Translation:
    """Increasing map from z of N(0, 1) to a height of mean 0 and variance 1.

    Johnson, N. L. (1949), Biometrika 36, 149-176: unbounded family ``sinh((z - a)/b)``, bounded family
    ``1/(1 + exp(-(z - a)/b))``.

    family: {"unbounded", "bounded"}
    a, b: location and scale in the family; b > 0.
    mean, std, sign: standardisation, and -1 for a mirrored curve.
    """

    family: str
    a: float
    b: float
    mean: float
    std: float
    sign: float

    def __call__(self, z: FloatArray) -> FloatArray:
        raw = _shape(self.family, self.a, self.b, self.sign * z)
        return np.asarray(self.sign * (raw - self.mean) / self.std)


def _shape(family: str, a: float, b: float, z: FloatArray) -> FloatArray:
    t = (z - a) / b
    # clipped so that both families are finite at the lognormal line between them
    if family == "unbounded":
        return np.asarray(np.sinh(np.clip(t, -300.0, 300.0)))
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(t, -300.0, 300.0))))


NEARLY_GAUSSIAN = 0.07  # skewness below which the fit starts at the limit of a small one
# trapezoidal rule on the normal density: spectrally accurate, nodes to 9 sigma
_NODES = np.linspace(-9.0, 9.0, 721)
_WEIGHTS = np.exp(-0.5 * _NODES**2)
_WEIGHTS /= _WEIGHTS.sum()


def _moments(family: str, a: float, b: float) -> tuple[float, float, float, float]:
    y = _shape(family, a, b, _NODES)
    mean = float(_WEIGHTS @ y)
    centred = y - mean
    std = math.sqrt(float(_WEIGHTS @ centred**2))
    unit = centred / std
    return mean, std, float(_WEIGHTS @ unit**3), float(_WEIGHTS @ unit**4)


def lognormal_kurtosis(skewness: float) -> float:
    """Kurtosis of the lognormal distribution of that skewness, the border of Johnson's two families [-]."""
    half = scipy.optimize.brentq(lambda w: (w + 2.0) * math.sqrt(w - 1.0) - abs(skewness), 1.0, 1.0 + skewness**2)
    return float(half**4 + 2.0 * half**3 + 3.0 * half**2 - 3.0)


@lru_cache(maxsize=64)
def translation(skewness: float, kurtosis: float) -> Callable[[FloatArray], FloatArray]:
    """The Johnson curve with these moments.

    Raises `InputError`: kurtosis <= skewness^2 + 1 (impossible), kurtosis above 60, or no curve was found (close to
        that limit or to the lognormal line).
    """
    if not kurtosis > skewness**2 + 1.0:
        raise InputError(
            "kurtosis", kurtosis, f"> skewness^2 + 1 = {skewness**2 + 1.0:g}", "No distribution has such moments."
        )
    if not kurtosis <= 60.0:
        raise InputError("kurtosis", kurtosis, "at most 60")
    sign = -1.0 if skewness < 0.0 else 1.0
    border = lognormal_kurtosis(skewness)
    family = "unbounded" if kurtosis > border else "bounded"

    def residual(q: FloatArray) -> FloatArray:
        _, _, third, fourth = _moments(family, float(q[0]), math.exp(float(q[1])))
        # kurtosis above its bound on a logarithmic scale, which resolves the region near the bound
        return np.array([third - sign * skewness, math.log((fourth - third**2 - 1.0) / (kurtosis - skewness**2 - 1.0))])

    starts = [(0.0, 0.3), (-1.0, 0.3), (1.0, 0.3), (2.0, 0.0), (-2.0, 0.7), (4.0, 1.0), (0.5, -0.5), (6.0, 0.5)]
    low, high = [-60.0, -3.0], [60.0, 4.0]
    size = abs(skewness)
    if family == "bounded" and 1e-4 < size < NEARLY_GAUSSIAN:  # location and scale grow as 1/skewness
        starts, low, high = [(3.23 / size, -math.log(0.5 * size))], [0.0, 0.0], [1e5, 12.0]
    for start in starts:
        fit = scipy.optimize.least_squares(residual, start, bounds=(low, high), xtol=1e-14, ftol=1e-14)
        if np.max(np.abs(fit.fun)) < 1e-7:
            a, b = float(fit.x[0]), math.exp(float(fit.x[1]))
            mean, std, _, _ = _moments(family, a, b)
            return Translation(family, a, b, mean, std, sign)
    allowed = f"moments of a Johnson curve; none was found near the lognormal kurtosis {border:.3g} of this skewness"
    raise InputError("skewness, kurtosis", (skewness, kurtosis), allowed, "Change the kurtosis by 1 %.")


# exp(-(k lc)^2/4), the spectrum of the ACF exp(-(x/lc)^2), is 5 % of its peak at k = 3.5/lc
CUTOFF_PER_CORRELATION_LENGTH = 2.0 * math.pi / 3.5
GAUSSIAN_WITHIN = 2e-3  # skewness and kurtosis - 3 up to which heights are left Gaussian
EP_FILM = 30e-9  # film of the additives of gear oils (data/additives/EP.toml) [m]


@dataclass(frozen=True, eq=False)
class RoughProfile:
    """Heights of one period of a surface along x with mean zero, and their statistics.

    heights (n,): heights above the mean line [m]; read-only.
    spacing: distance between samples [m]; the last sample is followed by the first.
    rms: Rq [m].
    skewness, kurtosis: third and fourth standardised moments [-]; 0 and 3 for a Gaussian.
    correlation_length: lag at which the autocorrelation first falls to 1/e [m], lc of the ACF exp(-(x/lc)^2); nan for a
        flat profile.
    cutoff: shortest wavelength [m].
    source: "generated" or "measured".
    notes: changes by running-in.
    """

    heights: FloatArray
    spacing: float
    rms: float
    skewness: float
    kurtosis: float
    correlation_length: float
    cutoff: float
    source: str = "measured"
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, heights: FloatArray, spacing: float, *, cutoff: float) -> RoughProfile:
        """Profile from measured heights, whose mean is subtracted."""
        z = np.asarray(heights, dtype=float) - np.mean(heights)
        z.setflags(write=False)
        rms, skewness, kurtosis = moments(z)
        lc = measured_correlation_length(z, spacing)
        return cls(z, float(spacing), rms, skewness, kurtosis, lc, float(cutoff))

    @property
    def length(self) -> float:
        """Length of the period [m]."""
        return self.spacing * len(self.heights)

    @property
    def x(self) -> FloatArray:
        """Positions of the samples [m]."""
        return np.asarray(self.spacing * np.arange(len(self.heights)), dtype=float)


def moments(heights: FloatArray) -> tuple[float, float, float]:
    """Rq [m], skewness [-] and kurtosis [-] of heights with mean zero; (0, 0, 3) for a flat profile."""
    rms = float(np.sqrt(np.mean(heights**2)))
    if rms == 0.0:
        return 0.0, 0.0, 3.0
    unit = heights / rms
    return rms, float(np.mean(unit**3)), float(np.mean(unit**4))


def autocorrelation(heights: FloatArray, *, periodic: bool = True) -> FloatArray:
    """Autocorrelation at lags 0, 1, 2... samples, 1 at lag 0; unbiased for a non-periodic profile."""
    n = len(heights)
    size = n if periodic else scipy.fft.next_fast_len(2 * n)
    power = np.abs(scipy.fft.rfft(heights, size)) ** 2
    raw = scipy.fft.irfft(power, size)[: n // 2 + 1]
    if not periodic:
        raw = raw * (n / (n - np.arange(len(raw))))
    return np.asarray(raw / raw[0]) if raw[0] > 0.0 else np.ones_like(raw)


def measured_correlation_length(heights: FloatArray, spacing: float, *, periodic: bool = True) -> float:
    """Lag at which the autocorrelation first falls to 1/e [m]; nan if it does not."""
    acf = autocorrelation(heights, periodic=periodic)
    below = np.flatnonzero(acf < math.exp(-1.0))
    if not len(below):
        return math.nan
    i = int(below[0])
    # a Gaussian ACF is linear in sqrt(-ln ACF); after a zero crossing the ACF itself is interpolated
    if acf[i] > 0.0:
        before, after = math.sqrt(max(-math.log(min(acf[i - 1], 1.0)), 0.0)), math.sqrt(-math.log(acf[i]))
        fraction = (1.0 - before) / (after - before)
    else:
        fraction = (acf[i - 1] - math.exp(-1.0)) / (acf[i - 1] - acf[i])
    return spacing * (i - 1 + float(fraction))


def generate_profile(
    rms: float,
    correlation_length: float,
    length: float,
    spacing: float,
    seed: int,
    *,
    skewness: float = 0.0,
    kurtosis: float = 3.0,
    cutoff: float | None = None,
    hurst: float | None = None,
) -> RoughProfile:
    """Periodic, band-limited random profile with the autocorrelation exp(-(x/lc)^2), or a self-affine one.

    The spectrum depends on seed, length, correlation length, Hurst exponent and cut-off only: another spacing samples
    the same profile at other points. Non-Gaussian heights are a monotone Johnson translation of the Gaussian profile,
    which adds harmonics above the cut-off and slightly shortens the correlation length.

    rms: Rq of the whole period [m]; 0 gives a flat profile.
    correlation_length: lc of the autocorrelation [m].
    length: period [m]; at least 4 lc.
    spacing: approximate sample distance [m]; the closest one that divides the period is used.
    seed: seed of the random numbers, non-negative.
    skewness, kurtosis: moments of the height distribution [-]; those of one profile scatter about them.
    cutoff: shortest wavelength [m]; default: 2 pi lc/3.5.
    hurst: Hurst exponent H of a self-affine profile, 0 < H < 1, with a spectrum that is flat below the roll-off and
        decreases as k^-(1 + 2 H) above it (`SelfAffine`); default: the Gaussian autocorrelation.
    Returns profile with its statistics.
    Raises `InputError`: a value is out of range, the spacing does not resolve the cut-off, or no distribution has such
        moments.
    """
    _require("rms", rms, rms >= 0.0, ">= 0 m")
    _require("correlation_length", correlation_length, correlation_length > 0.0, "> 0 m")
    least = 4.0 * correlation_length
    _require("length", length, length >= least, f">= 4 correlation lengths ({least:g} m)")
    _require("seed", seed, isinstance(seed, (int, np.integer)) and seed >= 0, "an integer >= 0")
    shortest = CUTOFF_PER_CORRELATION_LENGTH * correlation_length if cutoff is None else float(cutoff)
    allowed = f"> 0 and at most a quarter of the length ({length / 4:g} m)"
    _require("cutoff", shortest, 0.0 < shortest <= length / 4.0, allowed)
    _require("spacing", spacing, spacing > 0.0, "> 0 m")
    if spacing > shortest / 2.2:
        allowed = f"at most {shortest / 2.2:.4g} m for a profile with wavelengths down to {shortest:.4g} m"
        hint = "Use a finer mesh, or a longer cut-off with the removed part included in the boundary film."
        raise InputError("spacing", spacing, allowed, hint)
    count = max(1, round(length / spacing))
    modes = _modes(seed, correlation_length, length, shortest, hurst)
    # statistics, mean and scale are those of one fine sampling, so that they do not depend on the spacing
    fine, heights = _synthesis(modes, 16 * len(modes)), _synthesis(modes, count)
    if abs(skewness) > GAUSSIAN_WITHIN or abs(kurtosis - 3.0) > GAUSSIAN_WITHIN:
        curve = translation(skewness, kurtosis)
        fine, heights = curve(fine), curve(heights)
        heights = (heights - np.mean(fine)) / np.std(fine)
        fine = (fine - np.mean(fine)) / np.std(fine)
    heights = rms * heights
    heights.setflags(write=False)
    _, measured_skewness, measured_kurtosis = moments(fine)
    return RoughProfile(
        heights,
        length / count,
        float(rms),
        measured_skewness,
        measured_kurtosis,
        measured_correlation_length(fine, length / len(fine)),
        shortest,
        source="generated",
    )


def _modes(seed: int, lc: float, length: float, shortest: float, hurst: float | None = None) -> NDArray[np.complex128]:
    """Complex amplitudes of the wave numbers 1..n over the period, scaled to unit variance."""
    count = int(length / shortest * (1.0 + 1e-12))
    k = 2.0 * math.pi / length * np.arange(1.0, count + 1.0)
    # one row of random numbers per mode: the long waves do not depend on the cut-off
    draw = np.random.default_rng(seed).standard_normal((count, 2))
    density = np.exp(-((k * lc) ** 2) / 4.0) if hurst is None else SelfAffine(lc, hurst).density(k)
    amplitude = (draw[:, 0] + 1j * draw[:, 1]) * np.sqrt(density)
    return np.asarray(amplitude / math.sqrt(2.0 * float(np.sum(np.abs(amplitude) ** 2))))


@dataclass(frozen=True)
class SelfAffine:
    """Spectrum of a self-affine profile: S(k) ~ (1 + (k/k_r)^2)^-(1/2 + H).

    Flat for waves longer than the roll-off 2 pi/k_r, a power law for shorter ones. The autocorrelation is the Matern
    function 2^(1-H)/Gamma(H) (k_r x)^H K_H(k_r x), which is exp(-k_r x) for H = 1/2.

    correlation_length: lag at which the autocorrelation of all waves is 1/e [m].
    hurst: H, 0 < H < 1.
    """

    correlation_length: float
    hurst: float

    def __post_init__(self) -> None:
        _require("correlation_length", self.correlation_length, self.correlation_length > 0.0, "> 0 m")
        _require("hurst_exponent", self.hurst, 0.0 < self.hurst < 1.0, "> 0 and < 1")

    @property
    def roll_off(self) -> float:
        """Wavelength 2 pi/k_r [m]."""
        return 2.0 * math.pi * self.correlation_length / _lag_of_1_over_e(self.hurst)

    def density(self, wave_number: FloatArray) -> FloatArray:
        """S over S(0) [-] at wave numbers [1/m]."""
        ratio = np.asarray(wave_number) * self.roll_off / (2.0 * math.pi)
        return np.asarray((1.0 + ratio**2) ** -(0.5 + self.hurst))

    def share_below(self, wavelength: float) -> float:
        """Share of the variance in waves shorter than this [-]."""
        return float(scipy.special.betainc(self.hurst, 0.5, 1.0 / (1.0 + (self.roll_off / wavelength) ** 2)))

    def slope(self, shortest: float, longest: float = math.inf) -> float:
        """RMS slope of the waves between two wavelengths [m] over the Rq of all waves [1/m]."""
        first, last = self.roll_off / longest, self.roll_off / min(shortest, longest)
        u = np.linspace(math.sqrt(first), math.sqrt(last), 2001) ** 2  # dense at the long waves
        density = (1.0 + u**2) ** -(0.5 + self.hurst)
        whole = 0.5 * float(scipy.special.beta(0.5, self.hurst))
        return 2.0 * math.pi / self.roll_off * math.sqrt(float(np.trapezoid(u**2 * density, u)) / whole)


@lru_cache(maxsize=64)
def _lag_of_1_over_e(hurst: float) -> float:
    """k_r x at which the Matern autocorrelation is 1/e."""

    def excess(x: float) -> float:
        bessel = scipy.special.kv(hurst, x)
        return float(2.0 ** (1.0 - hurst) / scipy.special.gamma(hurst) * x**hurst * bessel) - math.exp(-1.0)

    return float(scipy.optimize.brentq(excess, 1e-8, 20.0, xtol=1e-14))


def _synthesis(modes: NDArray[np.complex128], count: int) -> FloatArray:
    spectrum = np.zeros(count // 2 + 1, dtype=complex)
    spectrum[1 : len(modes) + 1] = modes
    return np.asarray(scipy.fft.irfft(spectrum, count) * count)


def _require(field: str, value: object, holds: bool, allowed: str) -> None:
    if not holds:
        raise InputError(field, value, allowed)
