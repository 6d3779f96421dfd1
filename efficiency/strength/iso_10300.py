"""Factors of permissible stresses after ISO 10300-2 and -3 (2023), for case-hardened steel; from public sources.

Formula numbers and values as read in the public repository github.com/afuentesaz/AGMAStandards (ISO10300Calc, commit
35a7d1e0), whose self test against ISO/TR 10300-30:2024, sample 1, gives the figures of our tests. The standard itself
was not seen: not a certified calculation.
"""

from __future__ import annotations

import math

STRESS_CORRECTION = 2.0
"""Y_ST: root stress of the test gears over their nominal one."""
ROOT_ROUGHNESS = 16e-6
"""Rz of the root fillets where nothing is known of them [m] (ISO/TR 10300-30, sample 1)."""
RZ_OF_RQ = 6.0 * math.sqrt(2.0 / math.pi)
"""Rz over Rq: Rz = 6 Ra, and Ra of Gaussian heights."""
# slip layer of case-hardened steel [mm]
_SLIP_LAYER = 0.0030
# endurance between which the constants of the lubricant film change [MPa]
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

    Smoother than the test gears counts as 1 (ours): the formula has no upper end, superfinished flanks would get 1.3.
    """
    relative = float(1e6 * mean_rz * (10.0 / (1e3 * radius)) ** (1.0 / 3.0))
    if relative <= 3.0:
        return 1.0
    return float((3.0 / relative) ** (0.12 + (1000.0 - _within(endurance)) / 5000.0))


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
