"""What the efficiency of a pair gave: figures, error estimates, ranges, and the arrays behind them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from efficiency.loss.kinematics import Driver, LoadedPoints
from efficiency.loss.lubrication import LocalLubrication
from efficiency.ltca.load_distribution import LoadDistribution
from regression.friction.models import FrictionEstimate

FloatArray = NDArray[np.float64]

Reason = Literal[
    "",
    "load_newton_limit",
    "load_active_set_limit",
    "pressure_above_hardness",
    "friction_not_converged",
    "friction_undefined",
]
_ARRAYS_KEPT_OUT = ("load", "points", "friction", "lubrication")


@dataclass(frozen=True)
class EfficiencyResult:
    """Efficiency of one pair at one operating point; SI units.

    Attributes
    ----------
    design, side, friction_model, oil : str
        What was computed.
    friction_in_equilibrium : bool
        Whether the friction forces take part in carrying the torque.
    driver : {"pinion", "gear"}
        Member the power comes from.
    torque_pinion, speed_pinion, temperature_oil : float
        At the pinion shaft [N m], [rad/s], [K].
    temperature_inlet : float
        Of the oil as it enters the contacts [K].
    temperature_bulk_1, temperature_bulk_2 : float
        Of pinion and gear teeth [K].
    roughness_rms_1, roughness_rms_2 : float
        Rq of pinion and gear flanks [m].
    correlation_length, peklenik_number : float
        Of the roughness of either flank [m], [-].
    efficiency : float
        power_output/power_input, friction of sliding alone [-].
    efficiency_with_rolling : float
        With the rolling loss in it too [-].
    efficiency_lower, efficiency_upper : float
        With the friction model's own interval at every point at once; nan where it states none. Of solved contacts
        with the error of their mean friction.
    efficiency_error : float
        Estimate of the discretisation error of the efficiency: sum of the next two.
    efficiency_error_positions, efficiency_error_points : float
        Twice the change when the positions, and when the points per contact line, are halved [-].
    power_loss : float
        Sliding friction, mean over the mesh cycle [W].
    power_loss_rolling : float
        Pressure-driven flow in the contacts, mean over the mesh cycle [W]; not in `power_loss` and `efficiency`.
    power_input, power_output : float
        Of the driving and from the driven member, apart by `power_loss`; torque times speed at the pinion [W].
    friction_coefficient_mean : float
        Weighted with the sliding power density: power_loss/sum(F |v_s|) [-]; nan without sliding.
    pressure_max : float
        Greatest Hertz pressure of the flanks in the cycle [Pa].
    pressure_edge, pressure_edge_lower, pressure_edge_upper : float
        Greatest elastic pressure at a tip, toe or heel edge, and that of edges with twice and half its radius [Pa].
    edge_load_share, edge_loss_share : float
        Share of the torque and of the loss where the contact reaches an edge [-].
    transmission_error_loaded, transmission_error_unloaded : float
        Peak to peak over the cycle [rad of the gear].
    ranges : dict
        Least and greatest value over the loaded points of each local variable of the friction formula.
    outside_range_share : float
        Share of the sliding power at points outside the friction model's stated range [-].
    flags, flag_shares : dict
        Number of loaded points by the friction model's flag, and their share of the loss [-].
    contacts : int
        Contacts solved for the friction, failed ones among them; 0 where a formula gave it.
    contacts_failed : dict
        How many of them failed, by reason.
    torque_residual, compatibility_residual : float
        Worst relative residuals of the load distribution [-].
    positions, points_per_line, points_loaded : int
        Size of the computation.
    status, reason : str
        ``converged`` or ``failed``, and why.
    skipped : tuple of str
        What the model leaves out.
    notes : tuple of str
        Limits of the model this case touches, and where.
    seconds : float
        Wall time of loss and friction; geometry and load are shared between results.
    pinion_angle, power_loss_positions, power_loss_rolling_positions, transmission_error_positions : arrays
        Over the mesh cycle [rad], [W], [W], [rad].
    load, points, friction, lubrication
        Load distribution, loaded points, friction, film and temperatures at them, for plots; not in `to_dict`.
    """

    design: str
    side: str
    friction_model: str
    friction_in_equilibrium: bool
    driver: Driver
    oil: str
    torque_pinion: float
    speed_pinion: float
    temperature_oil: float
    temperature_inlet: float
    temperature_bulk_1: float
    temperature_bulk_2: float
    roughness_rms_1: float
    roughness_rms_2: float
    correlation_length: float
    peklenik_number: float
    efficiency: float
    efficiency_lower: float
    efficiency_upper: float
    efficiency_with_rolling: float
    efficiency_error: float
    efficiency_error_positions: float
    efficiency_error_points: float
    power_loss: float
    power_loss_rolling: float
    power_input: float
    power_output: float
    friction_coefficient_mean: float
    pressure_max: float
    pressure_edge: float
    pressure_edge_lower: float
    pressure_edge_upper: float
    edge_load_share: float
    edge_loss_share: float
    transmission_error_loaded: float
    transmission_error_unloaded: float
    ranges: dict[str, tuple[float, float]]
    outside_range_share: float
    flags: dict[str, int]
    flag_shares: dict[str, float]
    contacts: int
    contacts_failed: dict[str, int]
    torque_residual: float
    compatibility_residual: float
    positions: int
    points_per_line: int
    points_loaded: int
    status: Literal["converged", "failed"]
    reason: Reason
    skipped: tuple[str, ...]
    notes: tuple[str, ...]
    seconds: float
    pinion_angle: FloatArray = field(repr=False)
    power_loss_positions: FloatArray = field(repr=False)
    power_loss_rolling_positions: FloatArray = field(repr=False)
    transmission_error_positions: FloatArray = field(repr=False)
    load: LoadDistribution = field(repr=False, compare=False)
    points: LoadedPoints = field(repr=False, compare=False)
    friction: FrictionEstimate = field(repr=False, compare=False)
    lubrication: LocalLubrication = field(repr=False, compare=False)

    def to_dict(self) -> dict[str, Any]:
        """Everything but the point arrays, for JSON; not-a-number and infinity become None."""
        names = [name for name in self.__dataclass_fields__ if name not in _ARRAYS_KEPT_OUT]
        return {name: _plain(getattr(self, name)) for name in names}


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return [_plain(float(v)) for v in value]
    if isinstance(value, dict):
        return {key: _plain(v) for key, v in value.items()}
    if isinstance(value, tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
