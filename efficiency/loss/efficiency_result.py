"""What the efficiency of a pair gave: figures, error estimates, ranges, and the arrays behind them."""

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
from ehl.common.threads import one_thread
from ehl.fluid.oil import Oil
from ehl.uncertainty.result import InputUncertainty
from regression.friction.models import FrictionEstimate, FrictionModel

if TYPE_CHECKING:
    import pandas

    from efficiency.strength.result import Strength
    from ehl.uncertainty.spread import UncertaintyInput


LoadBalance = Literal["frictional", "frictionless"]
Bulk = Literal["estimate", "oil"]
"""What carries the pinion torque: normal and friction forces together, or the normal forces alone."""
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
    """The loaded mesh a result comes from, which answers further questions about the same operating point."""

    @property
    def design(self) -> Any:
        """The design of the pair, misalignments included."""

    @property
    def has_strength(self) -> bool:
        """Whether the strength of the teeth can be rated."""

    def solve(
        self, model: FrictionModel, operation: Operation, oil: Oil, load_balance: LoadBalance | None = None
    ) -> EfficiencyResult:
        """The same at another operation or with another friction model."""

    def strength_of(self, result: EfficiencyResult) -> Strength:
        """Strength of the teeth."""


@dataclass(frozen=True, repr=False)
class EfficiencyResult(Reportable):
    """Efficiency of one pair at one operating point; SI units.

    Parameters
    ----------
    design, side, friction_model : str
        What was computed.
    load_balance : {"frictional", "frictionless"}
        What carries the pinion torque: normal and friction forces together, or the normal forces alone.
    driver : {"pinion", "gear"}
        Member the power comes from.
    oil : str
        Name of the oil card.
    torque, speed, temperature : float
        At the pinion shaft [N m], [rad/s], [K].
    temperature_inlet : float
        Of the oil as it enters the contacts [K].
    temperature_bulk_1, temperature_bulk_2 : float
        Of pinion and gear teeth [K].
    roughness_rms_1, roughness_rms_2 : float
        Rq of pinion and gear flanks [m].
    correlation_length, peklenik_number : float
        Of the roughness across the contact line [m], [-]; the median of the points.
    efficiency : float
        power_output/power_input, friction of sliding alone [-].
    efficiency_with_rolling : float
        With the rolling loss in it too [-].
    efficiency_error : float
        Estimate of the error of the solution: sum of the next four.
    efficiency_error_positions, efficiency_error_points : float
        Twice the change when the positions, and when the points per contact line, are halved [-].
    efficiency_error_contacts : float
        By the error of the mean friction of solved contacts; 0 where a formula gave it [-].
    efficiency_error_balance : float
        Of the shortcut to the forces that carry the torque together with friction
        (`efficiency.loss.friction_equilibrium.balance_error`) [-].
    power_loss : float
        Sliding friction, mean over the mesh cycle [W].
    power_loss_rolling : float
        Pressure-driven flow in the contacts, mean over the mesh cycle [W]; not in `power_loss` and `efficiency`.
    power_input, power_output : float
        Of the driving and from the driven member, apart by `power_loss`; torque times speed at the pinion [W].
    friction_coefficient_mean : float
        Weighted with the sliding power density: ``power_loss/sum(F |v_s|)`` [-]; nan without sliding.
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
    deflection : dict
        Misalignment E, P, G [m], shaft_angle_error [rad] that the load adds by shafts, bearings and housing, where
        the design states their stiffness; `rounds` of the solution and the last `change` [m]. Else empty.
    skipped : tuple of str
        What the model leaves out.
    notes : tuple of str
        Limits of the model this case touches, and where.
    seconds : float
        Wall time of loss and friction; geometry and load are shared between results.
    pinion_angle, power_loss_positions, power_loss_rolling_positions, transmission_error_positions : arrays
        Over the mesh cycle [rad], [W], [W], [rad].
    load : LoadDistribution
        For plots, as the next three; not in `to_dict`.
    points : LoadedPoints
        Loaded points of the cycle.
    friction : FrictionEstimate
        At these points.
    lubrication : LocalLubrication
        Film and temperatures at them.
    model : FrictionModel
        The result was computed with, as the next two; not in `to_dict`.
    operation : Operation
        Operating point.
    card : Oil
        Oil card.
    source : ResultSource, optional
        The loaded mesh it comes from; not in `to_dict`.
    asked : InputUncertainty, optional
        In place of the interval by the formula and the usual spreads; see `with_inputs`.

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
        """What each uncertain input makes of the interval, computed when asked for; see also `uncertainty`."""
        if not math.isfinite(self.efficiency):
            return InputUncertainty.of("efficiency", math.nan, (), lambda ln: math.nan)
        return self.asked or self.uncertainty()

    @property
    def efficiency_lower(self) -> float:
        """Lower end of the 90 % interval by uncertain inputs [-]; the error of the solution is not in it."""
        return self.inputs.low

    @property
    def efficiency_upper(self) -> float:
        """Upper end of the same interval [-]."""
        return self.inputs.high

    @one_thread
    def uncertainty(
        self, spreads: UncertaintyInput | None = None, level: float = 0.90, *, solved: bool = False
    ) -> InputUncertainty:
        """Interval of the efficiency by what is not known of the inputs, with other spreads or another level.

        Parameters
        ----------
        spreads : UncertaintyInput, optional
            In place of those of the design file, the oil card and the defaults.
        level : float
            Share of cases the interval is to hold [-].
        solved : bool
            Where contacts were solved for the friction: solve some anew at both ends of every input (minutes), in
            place of asking a formula of the oil.

        Returns
        -------
        InputUncertainty

        Raises
        ------
        InputError
            The level is no share between 0 and 1.
        """
        from efficiency.loss.uncertainty import efficiency_uncertainty

        at = self.points, self.friction, self.card, self.operation
        return efficiency_uncertainty(self.model, *at, self.power_loss, self.torque, spreads, level, solved=solved)

    def with_inputs(self, inputs: InputUncertainty) -> EfficiencyResult:
        """The same with another input uncertainty, as of `uncertainty`."""
        return replace(self, asked=inputs)

    @property
    def has_strength(self) -> bool:
        """Whether the strength of the teeth can be rated: of bevel pairs, with their mesh."""
        return self.source is not None and self.source.has_strength

    @cached_property
    def strength(self) -> Strength:
        """Grades of pressure, root stress, safety factors, scuffing and micropitting; computed when asked for."""
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
        """The single values by their names, SI units, without the interval by uncertain inputs (the cells of a map)."""
        kept = (str, bool, int, float)
        return {name: value for name in self._names() if isinstance(value := getattr(self, name), kept)}

    def to_dict(self, *, strength: bool = False) -> dict[str, Any]:
        """Everything but the point arrays, for JSON; not-a-number and infinity become None.

        Parameters
        ----------
        strength : bool
            With the strength of the teeth.
        """
        plain = {name: _plain(getattr(self, name)) for name in self._names()}
        interval = {name: _plain(value) for name, value in self._interval().items()}
        graded = {"strength": self.strength.to_dict()} if strength else {}
        return plain | interval | {"uncertainty": self.inputs.to_dict()} | graded

    def to_frame(self) -> pandas.DataFrame:
        """One row: the single values by their names, SI units."""
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
    # before the limits that its sentence names too
    NoteKind("edges carry", "warning"),
    NoteKind("not converged:", "fault"),
    NoteKind("no answer:", "fault"),
    NoteKind("above shakedown", "fault"),
    NoteKind("the teeth would yield", "fault"),
    NoteKind("the two flanks do not match", "fault"),
    NoteKind("has no value at", "fault"),
    NoteKind("no state of uniform motion", "fault"),
    NoteKind("contacts not solved", "warning"),
    NoteKind("was fitted to", "warning"),
    NoteKind("has other figures now", "warning"),
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
    NoteKind("shafts and bearings give way", "for information"),
)
"""Kinds of notes on a pair; others count as warnings."""


def pair_notes(said: Iterable[tuple[str, str]]) -> list[Note]:
    """Notes on a pair, each with its case, one for each kind and the gravest first."""
    return group_notes(said, GEAR_NOTES)
