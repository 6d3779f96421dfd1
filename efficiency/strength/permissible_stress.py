"""Permissible stresses: ISO 10300 factors of case-hardened steel; yield and shakedown of a line contact.

Factors after ISO 10300-2 and -3 (2023), formula numbers and values from public sources: the public repository
github.com/afuentesaz/AGMAStandards (ISO10300Calc). Its self test against ISO/TR 10300-30:2024, samples 1 to 3, provides
the values of the tests. The standard itself was not available: this is not a certified calculation.

Hertz pressure of a half-plane with a normal load and sliding friction mu. With the yield stress Y in tension and
k = Y/sqrt(3) in shear (von Mises):

    first yield, mu = 0:   p = 1.79 Y = 3.1 k, at 0.70 b; maximum shear stress 0.30 p at 0.79 b
    shakedown:             p = k/max |tau_zx/p|;  4 k at mu = 0, k/mu where the surface governs

Residual stresses of a rolling line contact cannot balance tau_zx. Where it exceeds k, cyclic plasticity occurs
(Johnson, Contact Mechanics; Johnson & Jefferis 1963, both from memory). The stresses are McEwen's.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from ehl.common.arrays import FloatArray

STRESS_CORRECTION = 2.0
"""Y_ST: root stress of the test gears over their nominal one."""
ROOT_ROUGHNESS = 16e-6
"""Default Rz of the root fillets [m] (ISO/TR 10300-30, sample 1)."""
RZ_OF_RQ = 6.0 * math.sqrt(2.0 / math.pi)
"""Rz over Rq: Rz = 6 Ra, and Ra of Gaussian heights."""
# slip layer of case-hardened steel [mm]
_SLIP_LAYER = 0.0030
# range of endurance with variable constants of the lubricant film [MPa]
_LOW, _HIGH = 850.0, 1200.0


def _within(endurance: float) -> float:
    return min(max(endurance / 1e6, _LOW), _HIGH)


def lubricant_factor(endurance: float, viscosity_40: float) -> float:
    """Z_L (54): contact endurance [Pa], kinematic viscosity at 40 degC [m2/s]."""
    low = 0.08 * (_within(endurance) - _LOW) / 350.0 + 0.83
    return low + 4.0 * (1.0 - low) / (1.2 + 134.0 / (1e6 * viscosity_40)) ** 2


def speed_factor(endurance: float, speed: float) -> float:
    """Z_v (56): contact endurance [Pa], pitch line speed of the gear at the mean point [m/s]."""
    low = 0.08 * (_within(endurance) - _LOW) / 350.0 + 0.85
    return low + 2.0 * (1.0 - low) / math.sqrt(0.8 + 32.0 / speed)


def roughness_factor(endurance: float, mean_rz: float, radius: float) -> float:
    """Z_R (59): contact endurance [Pa], mean Rz of both flanks [m], radius of relative curvature [m].

    Surfaces smoother than the test gears have the value 1 (ours), because the formula has no upper limit and would give
    1.3 for superfinished flanks.
    """
    relative = float(1e6 * mean_rz * (10.0 / (1e3 * radius)) ** (1.0 / 3.0))
    if relative <= 3.0:
        return 1.0
    return float((3.0 / relative) ** (0.12 + (1000.0 - _within(endurance)) / 5000.0))


def hypoid_factor(
    spiral_pinion: float, spiral_gear: float, generated_pressure_angle: float, effective_pressure_angle: float
) -> float:
    """Z_Hyp (12) to (19): sliding along the contact line over the sum of velocities across it; 1 without offset.

    Mean spiral angles, generated and effective pressure angle of the flank [rad]. The formula is for shaft angles at
    which the inclination of the contact line is that on the virtual gears; its range is 0.6 to 1.
    """
    cos_1, cos_2 = math.cos(spiral_pinion), math.cos(spiral_gear)
    lean = math.atan(math.tan(0.5 * (spiral_pinion + spiral_gear)) * math.sin(effective_pressure_angle))
    # velocities over that of the pinion at the mean point
    along = abs(cos_1 * (math.tan(spiral_pinion) - math.tan(spiral_gear))) * math.cos(abs(lean))
    profile = abs(2.0 * cos_1 * math.sin(generated_pressure_angle))
    lengthwise = abs(math.sin(spiral_pinion) + math.sin(spiral_gear) * cos_1 / cos_2)
    across = math.hypot(profile, lengthwise) * math.sin(math.atan2(profile, lengthwise) + abs(lean))
    return min(max(1.0 - 0.3 * (along / across - 0.15), 0.6), 1.0)


def surface_factor(root_rz: float) -> float:
    """Y_R,relT (40) of the root fillets, Rz [m] from 1 to 40 um."""
    return 1.674 - 0.529 * float((min(max(1e6 * root_rz, 1.0), 40.0) + 1.0) ** 0.1)


def notch_factor(notch: float) -> float:
    """Y_delta,relT (43) of the notch parameter: root thickness over twice the fillet radius [-]."""
    gradient = 0.2 * (1.0 + 2.0 * notch)
    return (1.0 + math.sqrt(_SLIP_LAYER * gradient)) / (1.0 + math.sqrt(_SLIP_LAYER * 1.2))


def size_factor(module: float) -> float:
    """Y_X (209) of the mean normal module [m]."""
    return min(max(1.05 - 10.0 * module, 0.80), 1.0)


YIELD_RATIO = 1.79
"""Hertz pressure at first yield of a line contact over the yield stress, Poisson's ratio 0.3."""
HARDNESS_RATIO = 3.0
"""Hardness over yield stress (Tabor)."""
_FRICTIONS = np.linspace(0.0, 0.5, 26)


def yield_stress(hardness: float) -> float:
    """Yield stress in tension of a material [Pa] from its hardness (Tabor)."""
    return hardness / HARDNESS_RATIO


def yield_pressure(stress: float) -> float:
    """Hertz pressure at which a line contact first yields below its surface [Pa]; `stress` is the yield stress."""
    return YIELD_RATIO * stress


def shear_stress(across: FloatArray, depth: FloatArray, friction: float) -> FloatArray:
    """tau_zx over the Hertz pressure at points in half-widths, positive for depth (McEwen; Johnson)."""
    x, z = np.broadcast_arrays(across, depth)
    level = 1.0 - x**2 + z**2
    root = np.sqrt(level**2 + 4.0 * x**2 * z**2)
    m2, n2 = 0.5 * (root + level), 0.5 * (root - level)
    m, n = np.sqrt(m2), np.sqrt(np.maximum(n2, 0.0)) * np.sign(x)
    total = np.maximum(m2 + n2, 1e-300)
    normal = -n * (m2 - z**2) / total
    sideways = -(m * (1.0 + (z**2 + n2) / total) - 2.0 * z)
    return np.asarray(normal + friction * sideways)


@lru_cache(maxsize=1)
def _greatest_shear() -> FloatArray:
    """Maximum |tau_zx|/p for each of `_FRICTIONS`."""
    across, depth = np.linspace(-1.5, 1.5, 301)[:, None], np.linspace(1e-6, 1.5, 151)[None]
    return np.array([np.abs(shear_stress(across, depth, mu)).max() for mu in _FRICTIONS])


def shakedown_pressure(stress: float, friction: ArrayLike = 0.0) -> FloatArray:
    """Shakedown limit of a line contact: Hertz pressure above which cyclic plasticity occurs [Pa].

    `stress` is the yield stress in tension [Pa]; friction coefficients are limited to 0.5.
    """
    shear = np.interp(np.abs(np.asarray(friction, float)), _FRICTIONS, _greatest_shear())
    return np.asarray(stress / np.sqrt(3.0) / shear)
