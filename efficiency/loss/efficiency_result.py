"""Result of the efficiency of a pair: figures, error estimates, ranges, and arrays."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Literal, Protocol

from efficiency.loss.kinematics import Driver, LoadedPoints, Operation
from efficiency.loss.lubrication import LocalLubrication
from efficiency.ltca.load_distribution import LoadDistribution
from ehl.common.arrays import FloatArray, finite_or_none
from ehl.common.data import reason_text
from ehl.common.errors import InputError
from ehl.common.notes import Note, NoteKind, group_notes
from ehl.common.pages import Reportable
from ehl.common.threads import one_thread
from ehl.fluid.oil import Oil
from ehl.uncertainty.result import InputUncertainty, score_of
from ehl.uncertainty.spread import UncertaintyInput
from regression.friction.models import FrictionEstimate, FrictionModel

if TYPE_CHECKING:
    import pandas

    from efficiency.ltca.shaft_forces import MeshForces
    from efficiency.strength.result import Strength

LoadBalance = Literal["frictional", "frictionless"]
"""Forces in the torque balance: normal and friction forces, or only normal forces."""
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


class ResultSource(Protocol):
    """The loaded mesh of a result, which computes further results at the same operating point."""

    @property
    def design(self) -> Any:
        """The design of the pair, including misalignments."""

    @property
    def has_strength(self) -> bool:
        """Whether the strength of the teeth can be rated."""

    def forces(self, result: EfficiencyResult) -> MeshForces:
        """Mesh stiffness and shaft forces over the mesh cycle."""

    def strength_of(self, result: EfficiencyResult) -> Strength:
        """Strength of the teeth."""


@dataclass(frozen=True)
class OperatingConditions:
    """Operating conditions of a result; SI units."""

    torque: float  # at the pinion shaft [N m]
    speed: float  # of the pinion shaft [rad/s]
    temperature: float  # of the oil [K]
    oil: str  # name of the oil card
    driver: Driver
    load_balance: LoadBalance  # forces in the torque balance: normal and friction forces, or only normal forces
    temperature_inlet: float  # of the oil at the inlet of the contacts [K]
    temperature_bulk_pinion: float  # of the teeth [K]
    temperature_bulk_gear: float
    roughness_rms_pinion: float  # Rq of the flanks [m]
    roughness_rms_gear: float
    correlation_length: float  # of the flanks across the contact line, median of the points [m]
    peklenik_number: float  # the same [-]


@dataclass(frozen=True)
class EfficiencyErrors:
    """Contributions to the numerical error of the efficiency [-]."""

    positions: float  # twice the change if the positions are halved
    points: float  # twice the change if the points per contact line are halved
    contacts: float  # error from the mean friction of solved contacts; 0 for a formula
    balance: float  # of the approximate balance of normal and friction forces (`friction_equilibrium.balance_error`)


@dataclass(frozen=True)
class EdgeContact:
    """Contact at the tip, toe and heel edges."""

    pressure: float  # maximum elastic pressure at an edge [Pa]
    pressure_lower: float  # with twice the edge radius
    pressure_upper: float  # with half the edge radius
    load_share: float  # of the torque where the contact reaches an edge [-]
    loss_share: float  # of the loss there [-]


@dataclass(frozen=True)
class MeshCycle:
    """Values over the mesh cycle; the transmission error is an angle of the gear [rad]."""

    transmission_error_loaded: float  # peak-to-peak
    transmission_error_unloaded: float
    pinion_angle: FloatArray = field(repr=False)  # of each mesh position [rad]
    power_loss: FloatArray = field(repr=False)  # at each position [W]
    power_loss_rolling: FloatArray = field(repr=False)
    transmission_error: FloatArray = field(repr=False)  # loaded, at each position

    @property
    def pitch(self) -> float:
        """Pinion pitch from the equally spaced positions [rad]."""
        return float(self.pinion_angle[1] - self.pinion_angle[0]) * self.pinion_angle.size


@dataclass(frozen=True)
class FrictionRange:
    """Local conditions at the loaded points, and where they lie outside the stated range of the friction model."""

    ranges: dict[str, tuple[float, float]] = field(repr=False)  # least and largest of each variable of the formula
    flags: dict[str, int] = field(repr=False)  # number of points by the flag of the friction model
    flag_shares: dict[str, float] = field(repr=False)  # their share of the loss [-]
    # share of the sliding power at points whose pressure, entrainment speed, slide-to-roll ratio and film ratio lie
    # within those of the measured gears (`measured_states`) [-]
    measured_share: float


@dataclass(frozen=True)
class SolutionSize:
    """Size and residuals of the numerical solution."""

    positions: int
    points_per_line: int
    points_loaded: int
    contacts: int  # number of solved contacts including failed ones; 0 for a formula
    contacts_failed: dict[str, int]  # number of failed contacts by reason
    torque_residual: float  # largest relative residuals of the load distribution [-]
    compatibility_residual: float


@dataclass(frozen=True)
class ResultCase:
    """Friction model, operation, oil card and mesh of a result, from which further results are computed."""

    model: FrictionModel
    operation: Operation
    card: Oil
    mesh: ResultSource | None = None


@dataclass(frozen=True, repr=False)
class EfficiencyResult(Reportable):
    """Efficiency of one pair at one operating point; SI units.

    Parameters
    ----------
    design, side, friction_model : str
        Design, flank pair and friction model.
    conditions : OperatingConditions
        Torque, speed, temperatures, oil, roughness.
    efficiency : float
        power_output/power_input, with sliding friction only [-].
    efficiency_with_rolling : float
        Efficiency including the rolling loss [-].
    efficiency_error : float
        Estimated numerical error: sum of `errors` [-].
    errors : EfficiencyErrors
        Contributions to `efficiency_error`.
    power_loss : float
        Loss by sliding friction, mean over the mesh cycle [W].
    power_loss_rolling : float
        Loss by pressure-driven flow in the contacts, mean over the cycle [W]; not in `power_loss` and `efficiency`.
    power_input, power_output : float
        Power of the driving and of the driven member, which differ by `power_loss` [W].
    friction_coefficient_mean : float
        Mean weighted with the sliding power density: ``power_loss/sum(F |v_s|)`` [-]; nan without sliding.
    pressure_hertz_max : float
        Maximum Hertz pressure of the flanks in the cycle [Pa].
    edges : EdgeContact
        Contact at the tooth edges.
    cycle : MeshCycle
        Loss and transmission error over the mesh cycle.
    outside_range_share : float
        Share of the sliding power at points outside the stated range of the friction model [-].
    friction_range : FrictionRange
        Local conditions relative to the range of the friction model.
    solution : SolutionSize
        Size and residuals of the numerical solution.
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
    load : LoadDistribution
        Load distribution; this field and the following ones are not in `to_dict`.
    points : LoadedPoints
        Loaded points of the cycle.
    friction : FrictionEstimate
        Friction at these points.
    lubrication : LocalLubrication
        Films and temperatures at these points.
    case : ResultCase
        Friction model, operation, oil card and mesh of the result.
    own_inputs : InputUncertainty, optional
        Input uncertainty that replaces the default one; see `with_inputs`.

    Examples
    --------
    >>> import efficiency
    >>> mesh = efficiency.load("fm_spiral_bevel_14x39").mesh(positions=4, points_per_line=9)
    >>> result = mesh.load("300 N m").efficiency("constant:0.05", speed="1500 rpm")
    >>> f"{100.0 * result.efficiency:.1f} %, {result.conditions.torque:g} N m"
    '99.0 %, 300 N m'
    """

    presenter = "efficiency.output.gear_report:gear"

    design: str
    side: str
    friction_model: str
    conditions: OperatingConditions
    efficiency: float
    efficiency_with_rolling: float
    efficiency_error: float
    errors: EfficiencyErrors
    power_loss: float
    power_loss_rolling: float
    power_input: float
    power_output: float
    friction_coefficient_mean: float
    pressure_hertz_max: float
    edges: EdgeContact
    cycle: MeshCycle
    outside_range_share: float
    friction_range: FrictionRange
    solution: SolutionSize
    status: Literal["converged", "failed"]
    reason: Reason
    deflection: dict[str, float]
    skipped: tuple[str, ...]
    notes: tuple[str, ...]
    seconds: float
    load: LoadDistribution = field(repr=False, compare=False)
    points: LoadedPoints = field(repr=False, compare=False)
    friction: FrictionEstimate = field(repr=False, compare=False)
    lubrication: LocalLubrication = field(repr=False, compare=False)
    case: ResultCase = field(repr=False, compare=False)
    own_inputs: InputUncertainty | None = field(default=None, repr=False, compare=False)

    @cached_property
    def inputs(self) -> InputUncertainty:
        """Contribution of each uncertain input to the interval, computed on first access; see also `uncertainty`."""
        if not math.isfinite(self.efficiency):
            return InputUncertainty.of("efficiency", math.nan, (), lambda ln: math.nan)
        return self.own_inputs or self.uncertainty()

    @property
    def efficiency_lower(self) -> float:
        """Lower end of the interval of `inputs` from uncertain inputs, without the numerical error [-]."""
        return self.inputs.low

    @property
    def efficiency_upper(self) -> float:
        """Upper end of the same interval [-]."""
        return self.inputs.high

    @property
    def loss_interval(self) -> tuple[float, float]:
        """Interval of sliding and rolling loss together [W], both independent, at the level of `inputs`."""
        from efficiency.loss.power_loss import loss_of
        from efficiency.loss.uncertainty import ROLLING

        at, factor, ends = self.conditions, math.exp(score_of(self.inputs.level) * ROLLING), []
        for side, end, rolling in ((-1.0, self.efficiency_upper, 1.0 / factor), (1.0, self.efficiency_lower, factor)):
            sliding = loss_of(end, at.torque, at.speed, at.driver)
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

        Raises
        ------
        InputError
            The level is not between 0 and 1.
        """
        from efficiency.loss.uncertainty import efficiency_uncertainty

        return efficiency_uncertainty(self, spreads, level, solved=solved)

    def with_inputs(self, inputs: InputUncertainty) -> EfficiencyResult:
        """The result with another input uncertainty from `uncertainty`."""
        return replace(self, own_inputs=inputs)

    @property
    def has_strength(self) -> bool:
        """Whether the strength of the teeth can be rated; this requires a bevel pair and its mesh."""
        return self.case.mesh is not None and self.case.mesh.has_strength

    @cached_property
    def strength(self) -> Strength:
        """Pressure, root stress, safety factors, scuffing and micropitting with grades; computed on first access."""
        if self.case.mesh is None:
            raise InputError("strength", "a result without its mesh", "a result of `LoadedMesh.efficiency`")
        return self.case.mesh.strength_of(self)

    @cached_property
    def forces(self) -> MeshForces | None:
        """Mesh stiffness and forces on both shafts over the mesh cycle, with friction; None without a result.

        See `LoadedMesh.forces`; computed on first access.
        """
        return None if self.case.mesh is None or self.reason else self.case.mesh.forces(self)

    def references(self) -> set[str]:
        """Gear model, laws of the oil, friction model; strength if it was computed."""
        kind, at = "bevel" if self.has_strength else "cylindrical", self.conditions
        found = {"gear", f"gear:{kind}", "film formula", *self.case.card.lubricant(at.temperature).references()}
        found |= self.case.model.references()
        if max(at.temperature_bulk_pinion, at.temperature_bulk_gear) > at.temperature:
            found.add("bulk temperature")
        return found | ({"strength"} if "strength" in vars(self) else set())

    def value(self, name: str) -> Any:
        """Value by its name in tables, also from the records: ``torque``, ``edge_load_share``."""
        return attrgetter(_PATHS.get(name, name))(self)

    def scalars(self, *, interval: bool = False) -> dict[str, Any]:
        """Scalar values by their names in tables, SI units; `interval`: with the interval from uncertain inputs."""
        kept = (str, bool, int, float)
        found = {name: value for name in _PATHS if isinstance(value := self.value(name), kept)}
        return found | (self._interval() if interval else {})

    def to_dict(self, *, strength: bool = False) -> dict[str, Any]:
        """Content without the point arrays, for JSON, with the records as objects; not-a-number becomes None.

        Parameters
        ----------
        strength : bool
            Include the strength of the teeth.
        """
        plain = {f.name: getattr(self, f.name) for f in fields(self) if f.compare}
        if self.reason:
            plain["notes"] = [reason_text(self.reason), *self.notes]
        graded = {"strength": self.strength.to_dict()} if strength else {}
        graded |= {} if self.forces is None else {"forces": self.forces.to_dict()}
        return {**finite_or_none(plain | self._interval()), "uncertainty": self.inputs.to_dict(), **graded}

    def to_frame(self) -> pandas.DataFrame:
        """One row: the scalar values by name, SI units."""
        import pandas

        return pandas.DataFrame([self.scalars(interval=True) | {"notes": "; ".join(self.notes)}])

    def __repr__(self) -> str:
        at = self.conditions
        values = (
            f"{self.design}, {self.side}, {at.torque:.6g} N m, {at.speed:.6g} rad/s, "
            f"{at.temperature:.6g} K, {at.oil}, {self.friction_model}"
        )
        if self.status == "failed":
            return f"EfficiencyResult({values}: failed, {self.reason})"
        interval = ""
        if math.isfinite(self.efficiency_lower) and self.efficiency_lower < self.efficiency_upper:
            interval = f" ({self.efficiency_lower:.5f} to {self.efficiency_upper:.5f})"
        return f"EfficiencyResult({values}: efficiency {self.efficiency:.6f}{interval}, loss {self.power_loss:.5g} W)"

    def _interval(self) -> dict[str, float]:
        return {"efficiency_lower": self.efficiency_lower, "efficiency_upper": self.efficiency_upper}


# names in tables that differ from those of the fields
_TABLE_NAMES = {
    **{("errors", name): f"efficiency_error_{name}" for name in ("positions", "points", "contacts", "balance")},
    **{("edges", f"pressure{end}"): f"pressure_edge{end}" for end in ("", "_lower", "_upper")},
    **{("edges", f"{what}_share"): f"edge_{what}_share" for what in ("load", "loss")},
}
_RECORDS = {
    "conditions": OperatingConditions,
    "errors": EfficiencyErrors,
    "edges": EdgeContact,
    "cycle": MeshCycle,
    "friction_range": FrictionRange,
    "solution": SolutionSize,
}
# attribute of each value by its name in tables; the arrays of a record are without repr
_PATHS = {
    _TABLE_NAMES.get((f.name, part), part or f.name): f"{f.name}.{part}".rstrip(".")
    for f in fields(EfficiencyResult)
    for part in ([p.name for p in fields(_RECORDS[f.name]) if p.repr] if f.name in _RECORDS else [""])
}

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
    NoteKind("outside the data of", "warning"),
    NoteKind("above first yield", "warning"),
    NoteKind("above the contact endurance", "warning"),
    NoteKind("pitting safety", "warning", low=True),
    NoteKind("is undercut", "warning"),
    NoteKind("the mating tip would reach it", "warning"),
    NoteKind("withdraw the cutter", "warning"),
    NoteKind("of the whole depth above the root cone", "for information"),
    NoteKind("the contact pattern runs into", "warning"),
    NoteKind("unloaded contact runs over an edge", "warning"),
    NoteKind("unverified: compare it with the source", "warning"),
    # with the lay of ground flanks the loss of the 14x39 is a third smaller
    NoteKind("the Peklenik number has no effect", "warning"),
    NoteKind("mesh loss only", "for information"),
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
