"""Result of the efficiency of a pair: figures, error estimates, ranges, and arrays."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np

from efficiency.loss.kinematics import Driver, LoadedPoints, Operation
from efficiency.loss.lubrication import LocalLubrication
from efficiency.ltca.load_distribution import LoadDistribution
from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.notes import Note, NoteKind, group_notes
from ehl.common.pages import Reportable
from ehl.common.reasons import reason_text
from ehl.common.threads import one_thread
from ehl.fluid.oil import Oil
from ehl.uncertainty.result import InputUncertainty, score_of
from regression.friction.models import FrictionEstimate, FrictionModel

if TYPE_CHECKING:
    import pandas

    from efficiency.strength.result import Strength
    from ehl.uncertainty.spread import UncertaintyInput


LoadBalance = Literal["frictional", "frictionless"]
"""Forces in the torque balance: normal and friction forces, or normal forces alone."""
Bulk = Literal["estimate", "oil"]
Reason = Literal[
    "",
    "load_newton_limit",
    "load_active_set_limit",
    "pressure_above_hardness",
    "self_locking",
    "load_balance_limit",
    "friction_not_converged",
    "friction_undefined",
]
_ARRAYS_KEPT_OUT = ("load", "points", "friction", "lubrication", "model", "operation", "card", "source", "asked")


class ResultSource(Protocol):
    """The loaded mesh of a result, which computes further results at the same operating point."""

    @property
    def design(self) -> Any:
        """The design of the pair, including misalignments."""

    @property
    def has_strength(self) -> bool:
        """Whether the strength of the teeth can be rated."""

    def solve(
        self, model: FrictionModel, operation: Operation, oil: Oil, load_balance: LoadBalance | None = None
    ) -> EfficiencyResult:
        """Result at another operation or with another friction model."""

    def strength_of(self, result: EfficiencyResult) -> Strength:
        """Strength of the teeth."""


@dataclass(frozen=True, repr=False)
class EfficiencyResult(Reportable):
    """Efficiency of one pair at one operating point; SI units.

    Parameters
    ----------
    design, side, friction_model : str
        Design, flank pair and friction model.
    load_balance : {"frictional", "frictionless"}
        Forces in the torque balance: normal and friction forces, or normal forces alone.
    driver : {"pinion", "gear"}
        Driving member.
    oil : str
        Name of the oil card.
    torque, speed, temperature : float
        Torque [N m] and speed [rad/s] at the pinion shaft, oil temperature [K].
    temperature_inlet : float
        Temperature of the oil at the inlet of the contacts [K].
    temperature_bulk_1, temperature_bulk_2 : float
        Bulk temperature of pinion and gear teeth [K].
    roughness_rms_1, roughness_rms_2 : float
        Rq of pinion and gear flanks [m].
    correlation_length, peklenik_number : float
        Correlation length of the roughness across the contact line [m] and Peklenik number [-], median of the points.
    efficiency : float
        power_output/power_input, with sliding friction only [-].
    efficiency_with_rolling : float
        Efficiency including the rolling loss [-].
    efficiency_error : float
        Estimated numerical error: sum of the next four [-].
    efficiency_error_positions, efficiency_error_points : float
        Twice the change if the positions, or the points per contact line, are halved [-].
    efficiency_error_contacts : float
        Error from the mean friction of solved contacts; 0 for a formula [-].
    efficiency_error_balance : float
        Error of the approximate balance of normal and friction forces
        (`efficiency.loss.friction_equilibrium.balance_error`) [-].
    power_loss : float
        Loss by sliding friction, mean over the mesh cycle [W].
    power_loss_rolling : float
        Loss by pressure-driven flow in the contacts, mean over the cycle [W]; not in `power_loss` and `efficiency`.
    power_input, power_output : float
        Power of the driving and of the driven member, which differ by `power_loss` [W].
    friction_coefficient_mean : float
        Mean weighted with the sliding power density: ``power_loss/sum(F |v_s|)`` [-]; nan without sliding.
    pressure_max : float
        Maximum Hertz pressure of the flanks in the cycle [Pa].
    pressure_edge, pressure_edge_lower, pressure_edge_upper : float
        Maximum elastic pressure at a tip, toe or heel edge, and with twice and half the edge radius [Pa].
    edge_load_share, edge_loss_share : float
        Share of the torque and of the loss where the contact reaches an edge [-].
    transmission_error_loaded, transmission_error_unloaded : float
        Peak-to-peak values over the cycle, as gear angle [rad].
    ranges : dict
        Smallest and largest value over the loaded points of each local variable of the friction formula.
    outside_range_share : float
        Share of the sliding power at points outside the stated range of the friction model [-].
    flags, flag_shares : dict
        Number of loaded points by the flag of the friction model, and their share of the loss [-].
    contacts : int
        Number of solved contacts including failed ones; 0 for a formula.
    contacts_failed : dict
        Number of failed contacts by reason.
    torque_residual, compatibility_residual : float
        Largest relative residuals of the load distribution [-].
    positions, points_per_line, points_loaded : int
        Size of the computation.
    status, reason : str
        ``converged`` or ``failed``, and the reason of failure.
    deflection : dict
        Misalignment E, P, G [m] and shaft_angle_error [rad] caused by the load through shafts, bearings and housing,
        if the design states their stiffness; `rounds` of the solution and the last `change` [m]. Otherwise empty.
    skipped : tuple of str
        Effects that the model neglects.
    notes : tuple of str
        Limits of the model that this case exceeds, with their place.
    seconds : float
        Wall time of loss and friction; geometry and load are shared between results [s].
    pinion_angle, power_loss_positions, power_loss_rolling_positions, transmission_error_positions : arrays
        Values over the mesh cycle [rad], [W], [W], [rad].
    load : LoadDistribution
        Load distribution; this field and the following ones are not in `to_dict`.
    points : LoadedPoints
        Loaded points of the cycle.
    friction : FrictionEstimate
        Friction at these points.
    lubrication : LocalLubrication
        Films and temperatures at these points.
    model : FrictionModel
        Friction model.
    operation : Operation
        Operating point.
    card : Oil
        Oil card.
    source : ResultSource, optional
        Loaded mesh of the result.
    asked : InputUncertainty, optional
        Input uncertainty that replaces the default one; see `with_inputs`.

    Examples
    --------
    >>> import efficiency
    >>> mesh = efficiency.load("fm_spiral_bevel_14x39").mesh(positions=4, points_per_line=9)
    >>> result = mesh.load("300 N m").efficiency("constant:0.05", speed="1500 rpm")
    >>> f"{100.0 * result.efficiency:.1f} %"
    '99.0 %'
    """

    presenter = "efficiency.output.gear_report:gear"

    design: str
    side: str
    friction_model: str
    load_balance: LoadBalance
    driver: Driver
    oil: str
    torque: float
    speed: float
    temperature: float
    temperature_inlet: float
    temperature_bulk_1: float
    temperature_bulk_2: float
    roughness_rms_1: float
    roughness_rms_2: float
    correlation_length: float
    peklenik_number: float
    efficiency: float
    efficiency_with_rolling: float
    efficiency_error: float
    efficiency_error_positions: float
    efficiency_error_points: float
    efficiency_error_contacts: float
    efficiency_error_balance: float
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
    deflection: dict[str, float]
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
    model: FrictionModel = field(repr=False, compare=False)
    operation: Operation = field(repr=False, compare=False)
    card: Oil = field(repr=False, compare=False)
    source: ResultSource | None = field(default=None, repr=False, compare=False)
    asked: InputUncertainty | None = field(default=None, repr=False, compare=False)

    @cached_property
    def inputs(self) -> InputUncertainty:
        """Contribution of each uncertain input to the interval, computed on first access; see also `uncertainty`."""
        if not math.isfinite(self.efficiency):
            return InputUncertainty.of("efficiency", math.nan, (), lambda ln: math.nan)
        return self.asked or self.uncertainty()

    @property
    def efficiency_lower(self) -> float:
        """Lower end of the 90 % interval from uncertain inputs, without the numerical error [-]."""
        return self.inputs.low

    @property
    def efficiency_upper(self) -> float:
        """Upper end of the same interval [-]."""
        return self.inputs.high

    @property
    def loss_interval(self) -> tuple[float, float]:
        """90 % interval of sliding and rolling loss together [W], both independent."""
        from efficiency.loss.uncertainty import ROLLING

        power, factor = self.torque * self.speed, math.exp(score_of(0.90) * ROLLING)
        ends = []
        for side, end, rolling in ((-1.0, self.efficiency_upper, 1.0 / factor), (1.0, self.efficiency_lower, factor)):
            sliding = power * (1.0 - end if self.driver == "pinion" else 1.0 / end - 1.0)
            width = math.hypot(sliding - self.power_loss, (rolling - 1.0) * self.power_loss_rolling)
            ends.append(self.power_loss + self.power_loss_rolling + side * width)
        return ends[0], ends[1]

    @one_thread
    def uncertainty(
        self, spreads: UncertaintyInput | None = None, level: float = 0.90, *, solved: bool = False
    ) -> InputUncertainty:
        """Interval of the efficiency from uncertain inputs, with other spreads or another level.

        Parameters
        ----------
        spreads : UncertaintyInput, optional
            Spreads that replace those of the design file, the oil card and the defaults.
        level : float
            Probability of the interval [-].
        solved : bool
            For solved contacts: solve some of them at both ends of every input (minutes) instead of using a formula of
            the oil.

        Returns
        -------
        InputUncertainty

        Raises
        ------
        InputError
            The level is not between 0 and 1.
        """
        from efficiency.loss.uncertainty import efficiency_uncertainty

        at = self.points, self.friction, self.card, self.operation
        return efficiency_uncertainty(self.model, *at, self.power_loss, self.torque, spreads, level, solved=solved)

    def with_inputs(self, inputs: InputUncertainty) -> EfficiencyResult:
        """The result with another input uncertainty from `uncertainty`."""
        return replace(self, asked=inputs)

    @property
    def has_strength(self) -> bool:
        """Whether the strength of the teeth can be rated; this requires a bevel pair and its mesh."""
        return self.source is not None and self.source.has_strength

    @cached_property
    def strength(self) -> Strength:
        """Pressure, root stress, safety factors, scuffing and micropitting with grades; computed on first access."""
        return self._source("strength").strength_of(self)

    def references(self) -> set[str]:
        """Gear model, laws of the oil, friction model; strength where it was computed."""
        kind = "bevel" if self.has_strength else "cylindrical"
        found = {"gear", f"gear:{kind}", "film formula", *self.card.lubricant(self.temperature).references()}
        found |= self.model.references()
        if max(self.temperature_bulk_1, self.temperature_bulk_2) > self.temperature:
            found.add("bulk temperature")
        return found | ({"strength"} if "strength" in vars(self) else set())

    def scalars(self) -> dict[str, Any]:
        """Scalar values by name, SI units, without the interval from uncertain inputs (the cells of a map)."""
        kept = (str, bool, int, float)
        return {name: value for name in self._names() if isinstance(value := getattr(self, name), kept)}

    def to_dict(self, *, strength: bool = False) -> dict[str, Any]:
        """Content without the point arrays, for JSON; not-a-number and infinity become None.

        Parameters
        ----------
        strength : bool
            Include the strength of the teeth.
        """
        plain = {name: _plain(getattr(self, name)) for name in self._names()}
        if self.reason:
            plain["notes"] = [reason_text(self.reason), *self.notes]
        interval = {name: _plain(value) for name, value in self._interval().items()}
        graded = {"strength": self.strength.to_dict()} if strength else {}
        return plain | interval | {"uncertainty": self.inputs.to_dict()} | graded

    def to_frame(self) -> pandas.DataFrame:
        """One row: the scalar values by name, SI units."""
        import pandas

        return pandas.DataFrame([self.scalars() | self._interval() | {"notes": "; ".join(self.notes)}])

    def __repr__(self) -> str:
        values = (
            f"{self.design}, {self.side}, {self.torque:.6g} N m, {self.speed:.6g} rad/s, "
            f"{self.temperature:.6g} K, {self.oil}, {self.friction_model}"
        )
        if self.status == "failed":
            return f"EfficiencyResult({values}: failed, {self.reason})"
        interval = ""
        if math.isfinite(self.efficiency_lower) and self.efficiency_lower < self.efficiency_upper:
            interval = f" ({self.efficiency_lower:.5f} to {self.efficiency_upper:.5f})"
        return f"EfficiencyResult({values}: efficiency {self.efficiency:.6f}{interval}, loss {self.power_loss:.5g} W)"

    def _repr_html_(self) -> str:
        names = ("efficiency", "efficiency_lower", "efficiency_upper", "efficiency_error", "power_loss")
        more = ("friction_coefficient_mean", "pressure_max", "outside_range_share", "status", "reason")
        frame = self.to_frame()[[*names, *more]].T
        return str(frame.to_html(header=False)) + "".join(f"<p>{escape(note)}</p>" for note in self.notes)

    def _interval(self) -> dict[str, float]:
        return {"efficiency_lower": self.efficiency_lower, "efficiency_upper": self.efficiency_upper}

    def _names(self) -> list[str]:
        return [name for name in self.__dataclass_fields__ if name not in _ARRAYS_KEPT_OUT]

    def _source(self, what: str) -> ResultSource:
        if self.source is None:
            raise InputError(what, "a result without its mesh", "a result of `LoadedMesh.efficiency`")
        return self.source


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


GEAR_NOTES: tuple[NoteKind, ...] = (
    # listed before the limits that its sentence also names
    NoteKind("edges carry only", "for information"),
    NoteKind("edges carry", "warning"),
    NoteKind("not converged:", "fault"),
    NoteKind("no result:", "fault"),
    NoteKind("above shakedown", "fault"),
    NoteKind("the teeth would yield", "fault"),
    NoteKind("the two flanks do not match", "fault"),
    NoteKind("has no value at", "fault"),
    NoteKind("no state of uniform motion", "fault"),
    NoteKind("contacts not solved", "warning"),
    NoteKind("fitted to run-in surfaces", "for information"),
    NoteKind("was fitted to", "warning"),
    NoteKind("has been changed since", "warning"),
    NoteKind("of the sliding power lies outside the range", "warning"),
    NoteKind("above first yield", "warning"),
    NoteKind("above the contact endurance", "warning"),
    NoteKind("pitting safety", "warning", low=True),
    NoteKind("is undercut", "warning"),
    NoteKind("the mating tip would reach it", "warning"),
    NoteKind("withdraw the cutter", "warning"),
    NoteKind("of the whole depth above the root cone", "for information"),
    NoteKind("the contact pattern runs into", "warning"),
    NoteKind("unloaded contact runs over an edge", "warning"),
    NoteKind("from memory, to be checked in print", "warning"),
    # with the lay of ground flanks the loss of the 14x39 is a third smaller
    NoteKind("the Peklenik number has no effect", "warning"),
    NoteKind("loss of the mesh alone", "for information"),
    NoteKind("bearings and drag:", "for information"),
    NoteKind("not graded", "for information"),
    NoteKind("error of that surface", "for information"),
    NoteKind("by the uncertainty of the measured flanks", "for information"),
    NoteKind("is approximate at some pinion angles", "for information"),
    NoteKind("shafts and bearings deflect", "for information"),
)
"""Kinds of notes on a pair; others count as warnings."""


def pair_notes(said: Iterable[tuple[str, str]]) -> list[Note]:
    """Notes on a pair with their cases, one for each kind, the most severe first."""
    return group_notes(said, GEAR_NOTES)
