"""Losses of an axle at one or many operating points, split by source."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Literal

import numpy as np

from efficiency.conditions.duty import HOUR
from efficiency.loss.efficiency_result import pair_notes
from efficiency.vehicle.loss_map import LossMap, LossPoint, LossTable
from ehl.common.arrays import FloatArray, finite_or_none
from ehl.common.errors import InputError
from ehl.common.quantities import quantity, rounded
from ehl.common.sections import Head, Item, MainResult, Medium, Notes, Section, Text
from ehl.common.table import Column, Table
from ehl.uncertainty.result import score_of
from regression.friction.published_registry import model_label

Ends = dict[str, tuple[float, float]]
"""Ends of the 90 % interval of a loss by its source, over the loss."""
OUTSIDE = (
    "Not included: differential, half shafts, wheel hubs and their bearings, splash from gear to gear and onto "
    "bearings, oil displaced from the mesh, forces other than those of the mesh, the oil level in motion."
)
Kind = Literal["point", "map", "duty"]
SOURCES = ("mesh", "bearings", "seals", "churning", "windage")
# standard deviation of ln(loss) of the methods (this work)
SCATTER = {"skf": 0.25, "iso_14179_2": 0.35, "seals": 0.3, "churning": 0.8, "windage": 0.7}
# kinematic viscosity from which an interval begins to reach to the other method, and from which it does [m^2/s] (this
# work)
THICK_OIL = 500e-6, 5000e-6


def interval_ends(bearings: str, viscosity: float, others: Mapping[str, float]) -> Ends:
    """Ends of the 90 % interval of each loss outside the mesh, over the loss.

    No method was measured in thick oil: the interval reaches to the loss by the other method there, so that it states
    by how much published methods differ.

    bearings: method of the bearings.
    viscosity: kinematic [m^2/s].
    others: loss by the other method over the loss, by source.
    """
    scatter, found = SCATTER | {"bearings": SCATTER[bearings]}, Ends()
    share = float(np.interp(math.log(viscosity), np.log(THICK_OIL), (0.0, 1.0)))
    for name in SOURCES[1:]:
        factor, other = math.exp(score_of(0.90) * scatter[name]), others.get(name, 1.0) ** share
        found[name] = min(1.0 / factor, other), max(factor, other)
    return found


def _brief(name: str, value: float) -> str:
    """A loss or energy [SI] with its unit and two significant digits."""
    shown = quantity(name)
    return shown.text(shown.to_si(rounded(shown.to_display(value), 2)))


# short heads of a table with many points
_SHORT = {"torque": "torque", "speed": "speed", "temperature": "oil", "loss_total_lower": "lower limit"}
_SHORT |= {"loss_total_upper": "upper limit", "axle_efficiency": "efficiency"}
_SHORT |= {"outside_range_share": "outside the range"}
_SHORT |= {f"loss_{source}": source for source in SOURCES}


def _by_uncertainty(name: str, digits: int, label: str) -> Column:
    """A column; losses, and what follows from them, with few significant digits."""
    if name == "axle_efficiency":
        return Column(name, label=label, digits=digits + 1)
    if name == "outside_range_share":
        return Column(name, label=label, decimals=1)
    uncertain = name.startswith(("loss_", "energy_", "heat_", "axle_power_"))
    return Column(name, label=label, digits=digits if uncertain else 0, rounded=uncertain)


@dataclass(frozen=True)
class AxlePoint:
    """Losses at one operating point."""

    # of the pinion, signed; of oil and housing; duration in a duty cycle
    torque: float
    speed: float
    temperature: float
    temperature_housing: float
    hours: float
    # all losses, and the ends of their 90 % interval; by source in `loss_mesh`...
    loss_total: float
    loss_total_lower: float
    loss_total_upper: float
    loss_mesh: float
    loss_bearings: float
    loss_seals: float
    loss_churning: float
    loss_windage: float
    loss_mesh_lower: float
    loss_mesh_upper: float
    # the output is negative if the losses exceed the pinion power
    axle_power_input: float
    axle_power_output: float
    axle_efficiency: float
    # heat flow from the oil, and heat that warms the axle
    heat_housing: float
    heat_cooler: float
    heat_stored: float
    outside_range_share: float  # share of the sliding power outside the range of the friction model
    status: str
    reason: str


@dataclass(frozen=True)
class BearingLoss:
    """Load, moment [N m] and loss [W] of one bearing; `parts` of the moment by name."""

    shaft: str
    bearing: str
    radial_load: float
    axial_load: float
    moment: float
    loss: float
    parts: dict[str, float]


@dataclass(frozen=True, repr=False)
class AxleResult(LossTable):
    """Losses of an axle."""

    kind: Kind
    axle: str
    source: str
    design: str
    friction_model: str
    oil: str
    methods: dict[str, str]  # method of bearings, seals, churning
    points: tuple[AxlePoint, ...] = field(repr=False)  # of a map by temperature, then speed, then torque
    # of a single point; the latter by the other methods [W]
    bearings: tuple[BearingLoss, ...] = field(default=(), repr=False)
    alternatives: dict[str, float] = field(default_factory=dict, repr=False)
    case_notes: tuple[tuple[str, str], ...] = field(default=(), repr=False)  # point and note
    ends: tuple[Ends, ...] = field(default=(), repr=False)  # of the losses outside the mesh, of each point
    uses: frozenset[str] = field(default=frozenset(), repr=False)  # cited by `references`

    def values(self, name: str = "loss_total") -> FloatArray:
        """Values of one column for all points."""
        return np.array([getattr(point, name) for point in self.points])

    def energy(self, name: str = "loss_total") -> float:
        """Power of a duty cycle summed over its time [J]."""
        return math.fsum(getattr(point, name) * HOUR * point.hours for point in self.points)

    def split(self) -> dict[str, tuple[float, float, float, float]]:
        """Loss [W] or energy of a duty cycle [J] by source and in total: value, ends of the 90 % interval, share.

        The share is that of the squared width. The errors of a source are taken as the same at all points of a duty
        cycle, those of different sources as independent.
        """
        if self.kind == "map":
            raise InputError("split", "map", "a point or a duty cycle")
        weights = [HOUR * point.hours if self.kind == "duty" else 1.0 for point in self.points]

        def take(name: str, place: int | None = None) -> float:
            ends = [1.0 if place is None else each[name][place] for each in self.ends]
            losses = self.values(f"loss_{name}")
            return math.fsum(w * loss * end for w, loss, end in zip(weights, losses, ends, strict=True))

        rows = {name: (take(name), take(name, 0), take(name, 1)) for name in SOURCES[1:]}
        rows = {"mesh": (take("mesh"), take("mesh_lower"), take("mesh_upper"))} | rows
        widths = {name: (high - low) ** 2 for name, (_, low, high) in rows.items()}
        total, square = take("total"), max(math.fsum(widths.values()), 1e-300)
        found = {name: (*row, widths[name] / square) for name, row in rows.items()}
        down, up = (math.hypot(*(row[0] - row[end] for row in rows.values())) for end in (1, 2))
        return found | {"total": (total, total - down, total + up, 1.0)}

    def references(self) -> set[str]:
        """Gear model, laws of the oil, friction model, methods of bearings, seals and churning."""
        return {*self.uses, "gear", *(f"{kind}:{name}" for kind, name in self.methods.items())}

    def loss_map(self, temperature: float | None = None) -> LossMap:
        """The points of a map at one oil temperature [K], the first if not given, for `LossMap.write_model`."""
        kelvin = self.points[0].temperature if temperature is None else temperature
        points = [point for point in self.points if point.temperature == kelvin]
        if self.kind != "map" or not points:
            raise InputError("loss_map", f"{self.kind}, {kelvin:g} K", "a map and one of its temperatures")
        rows = []
        for p in points:
            total, mesh = p.loss_total / p.speed, p.loss_mesh / p.speed
            figures = (p.torque, p.speed, total, mesh, total - mesh, p.outside_range_share)
            ends = p.loss_total_lower / p.speed, p.loss_total_upper / p.speed
            rows.append(LossPoint(*figures, p.status, p.reason, *ends))
        first = (("", f"bearings and drag: axle {self.axle}, {self._methods}"), *self.case_notes)
        uses = frozenset(self.references())
        return LossMap(self.design, self.friction_model, self.oil, kelvin, tuple(rows), first, uses)

    def table(self) -> Table:
        """One row per point."""
        rows = [asdict(point) for point in self.points]
        table = Table.from_records(rows, title=self._title, name="axle", vertical=self.kind == "point")
        return table if self.kind == "duty" else table.select([name for name in table.names if name != "hours"])

    def _shown_table(self) -> Table:
        """The points with digits by their uncertainty: a single one without its losses, many without their heat."""
        table, point = self.table(), self.kind == "point"
        hidden = "loss_" if point else ("heat_", "temperature_housing", "loss_mesh_", "axle_power_")
        names = [name for name in table.names if not name.startswith(hidden)]
        names = [name for name in names if name not in ("status", "reason") or self.reason]
        table, labels = table.select(names), {} if point else _SHORT
        least = {name: self._digits_of(name) for name in names} if point else {}
        columns = [_by_uncertainty(name, least.get(name, 3), labels.get(name, "")) for name in names]
        notes = () if point else ("The files also have powers, heat flows and the temperature of the housing.",)
        return replace(table, columns=columns, notes=notes)

    def sections(self, medium: Medium = "page", *args: Any, **options: Any) -> list[Section]:
        """Loss with its interval, its split by source, bearings, notes, effects not included."""
        tables = [self.table() if medium == "files" else self._shown_table()]
        tables += [] if self.kind == "map" else [self._split_table()]
        tables += [self._bearing_table()] if self.bearings else []
        if medium == "files":
            return [Section("", [Head(self._title), *tables])]
        named = self._title.partition(": ")
        head: list[Item] = [Head(named[0], f"{named[2]}. {self.source}")]
        if self.kind != "map":
            value, low, high = (_brief(self._shown, value) for value in self.split()["total"][:3])
            label = "energy lost in the axle" if self.kind == "duty" else "total loss of the axle"
            head.append(MainResult(value, label, [(f"{low.split()[0]} to {high}", "90 % interval")]))
        notes = Notes(pair_notes(self.case_notes), len(self.points))
        method = f"Methods: {self._methods}; the intervals of these methods are estimated."
        if self.alternatives:
            others = ", ".join(f"{name} {_brief('loss_total', loss)}" for name, loss in self.alternatives.items())
            method += f" Other methods: {others}."
        return [Section("", [*head, *tables, notes, Text(method), Text(OUTSIDE)])]

    def _digits_of(self, name: str) -> int:
        """Digits of a value of a single point: two, for a power as many as the decimal place of the loss requires."""
        power, loss = (abs(getattr(self.points[0], of)) for of in (name, "loss_total"))
        if not name.startswith("axle_power_") or not power * loss > 0.0:
            return 2
        return 2 + max(0, math.floor(math.log10(power)) - math.floor(math.log10(loss)))

    @property
    def _shown(self) -> str:
        return "energy_total" if self.kind == "duty" else "loss_total"

    def _split_table(self) -> Table:
        title = "By source, with 90 % intervals and shares of the squared width of the total."
        ends = (("", self._shown.partition("_")[0]), ("_lower", "lower limit"), ("_upper", "upper limit"))
        values = [Column(self._shown + end, label=label, digits=2, rounded=True) for end, label in ends]
        rows = [(source, *row) for source, row in self.split().items()]
        return Table([Column("source"), *values, Column("share", decimals=1)], rows, title=title, name="sources")

    @property
    def _title(self) -> str:
        friction = f", friction: {model_label(self.friction_model)}" if self.friction_model else ""
        return f"Axle {self.axle}: {self.design}, {self.oil}{friction}"

    @property
    def _methods(self) -> str:
        return ", ".join(f"{name} {method}" for name, method in self.methods.items())

    def _bearing_table(self) -> Table:
        rows = []
        for row in map(asdict, self.bearings):
            parts = row.pop("parts")
            rows.append({name.replace("_", " "): value for name, value in row.items()})
            rows[-1] |= {f"moment, {name}": value for name, value in parts.items()}
        title = "Bearings: loads [N], moment and its parts [N m], loss [W]."
        table = Table.from_records(rows, title=title, name="bearings")
        columns = [
            Column(name, label=name.removeprefix("moment, "), digits=3 if "load" in name else 2, rounded=True)
            for name in table.names
        ]
        return replace(table, columns=columns)

    def to_dict(self) -> dict[str, Any]:
        """Points, split and notes in SI units, for JSON; nan becomes None."""
        names = ("kind", "axle", "design", "friction_model", "oil", "methods", "status", "reason")
        about = {name: getattr(self, name) for name in names}
        if self.kind != "map":
            parts = ("value", "lower", "upper", "share")
            about["sources"] = finite_or_none({k: dict(zip(parts, v, strict=True)) for k, v in self.split().items()})
        arrays = {"points": finite_or_none(self.points), "bearings": finite_or_none(self.bearings)}
        return {**about, "alternatives": self.alternatives, **arrays, "notes": list(self.notes), "outside": OUTSIDE}

    def __repr__(self) -> str:
        return f"AxleResult({self.axle}, {self.kind}: {len(self.points)} points, {self.status})"
