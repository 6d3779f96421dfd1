"""Losses of an axle at one or many operating points, split by source."""

import math
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

import numpy as np

from efficiency.conditions.duty import HOUR
from efficiency.loss.efficiency_result import pair_notes
from efficiency.vehicle.loss_map import LossMap, LossPoint, LossTable
from ehl.common.arrays import FloatArray, finite_or_none
from ehl.common.errors import InputError
from ehl.common.quantities import quantity
from ehl.common.sections import Head, Item, MainResult, Medium, Notes, Section, Text
from ehl.common.table import Table
from regression.friction.published_registry import model_label

OUTSIDE = (
    "Outside the model: differential, half shafts, wheel hubs and their bearings, splash from gear to gear and onto "
    "bearings, squeezing of oil in the mesh, forces other than those of the mesh, the oil level in motion."
)
Kind = Literal["point", "map", "duty"]
SOURCES = ("mesh", "bearings", "seals", "churning", "windage")
# standard deviation of ln(loss) of the methods, and the factor to the ends of a 90 % interval (ours)
SCATTER = {"skf": 0.25, "iso_14179_2": 0.35, "seals": 0.3, "churning": 0.8, "windage": 0.7}
_NINETY = 1.645


def interval_factors(bearings: str) -> dict[str, float]:
    """Factors from a loss to the ends of its 90 % interval by source, of a method of bearings."""
    scatter = SCATTER | {"bearings": SCATTER[bearings]}
    return {name: math.exp(_NINETY * scatter[name]) for name in SOURCES[1:]}


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
    # the output is below zero where the losses exceed the power of the pinion
    axle_power_input: float
    axle_power_output: float
    axle_efficiency: float
    # what leaves the oil, and what warms the axle
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
    # of a single point; the latter by the methods that were not chosen [W]
    bearings: tuple[BearingLoss, ...] = field(default=(), repr=False)
    alternatives: dict[str, float] = field(default_factory=dict, repr=False)
    said: tuple[tuple[str, str], ...] = field(default=(), repr=False)  # point and note

    def values(self, name: str = "loss_total") -> FloatArray:
        """One figure of all points."""
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
        take = self.energy if self.kind == "duty" else lambda name: float(getattr(self.points[0], name))
        factors = interval_factors(self.methods["bearings"])
        rows = {name: (take(f"loss_{name}"),) * 3 for name in SOURCES}
        rows = {k: (p, p / factors.get(k, 1.0), p * factors.get(k, 1.0)) for k, (p, *_) in rows.items()}
        rows["mesh"] = take("loss_mesh"), take("loss_mesh_lower"), take("loss_mesh_upper")
        widths = {name: (high - low) ** 2 for name, (_, low, high) in rows.items()}
        total, square = take("loss_total"), max(math.fsum(widths.values()), 1e-300)
        found = {name: (*row, widths[name] / square) for name, row in rows.items()}
        down, up = (math.hypot(*(row[0] - row[end] for row in rows.values())) for end in (1, 2))
        return found | {"total": (total, total - down, total + up, 1.0)}

    def references(self) -> set[str]:
        """Gear model, published friction formula, methods of bearings, seals and churning."""
        return {"gear", f"friction:{self.friction_model}", *(f"{kind}:{name}" for kind, name in self.methods.items())}

    def loss_map(self, temperature: float | None = None) -> LossMap:
        """The points of a map at one oil temperature [K], the first if not given, for `LossMap.to_vecto`."""
        kelvin = self.points[0].temperature if temperature is None else temperature
        points = [point for point in self.points if point.temperature == kelvin]
        if self.kind != "map" or not points:
            raise InputError("loss_map", f"{self.kind}, {kelvin:g} K", "a map, and a temperature of it")
        rows = []
        for p in points:
            total, mesh = p.loss_total / p.speed, p.loss_mesh / p.speed
            figures = (p.torque, p.speed, total, mesh, total - mesh, p.outside_range_share)
            rows.append(LossPoint(*figures, p.status, p.reason))
        said = (("", f"bearings and drag: axle {self.axle}, {self._methods}"), *self.said)
        return LossMap(self.design, self.friction_model, self.oil, kelvin, tuple(rows), said)

    def table(self) -> Table:
        """One row per point."""
        rows = [asdict(point) for point in self.points]
        if self.kind != "duty":
            rows = [{name: value for name, value in row.items() if name != "hours"} for row in rows]
        return Table.from_records(rows, title=self._title, name="axle", vertical=self.kind == "point")

    def sections(self, medium: Medium = "page", *args: Any, **options: Any) -> list[Section]:
        """Loss with its interval, its split by source, bearings, notes, what is outside."""
        tables = [self.table(), *([] if self.kind == "map" else [self._split_table()])]
        tables += [self._bearing_table()] if self.bearings else []
        if medium == "files":
            return [Section("", [Head(self._title), *tables])]
        head: list[Item] = [Head(self._title, self.source)]
        if self.kind != "map":
            value, low, high = (quantity(self._shown).text(value) for value in self.split()["total"][:3])
            head.append(
                MainResult(value, f"{quantity(self._shown).label} of the axle", [(f"{low} to {high}", "90 % interval")])
            )
        said = Notes(pair_notes(self.said), len(self.points))
        method = f"Methods: {self._methods}; the intervals of these methods are ours."
        if self.alternatives:
            others = ", ".join(
                f"{name} {quantity('loss_total').text(loss)}" for name, loss in self.alternatives.items()
            )
            method += f" Other methods: {others}."
        return [Section("", [*head, *tables, said, Text(method), Text(OUTSIDE)])]

    @property
    def _shown(self) -> str:
        return "energy_total" if self.kind == "duty" else "loss_total"

    def _split_table(self) -> Table:
        names = (self._shown, f"{self._shown}_lower", f"{self._shown}_upper", "share")
        rows = [{"source": source} | dict(zip(names, row, strict=True)) for source, row in self.split().items()]
        title = "By source, with 90 % intervals and shares in the width of the total's."
        return Table.from_records(rows, title=title, name="sources")

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
            rows.append(row | {f"moment, {name}": value for name, value in parts.items()})
        return Table.from_records(rows, title="Bearings: loads [N], moments [N m], losses [W].", name="bearings")

    def to_dict(self) -> dict[str, Any]:
        """For JSON; not-a-number becomes None."""
        names = ("kind", "axle", "design", "friction_model", "oil", "methods", "status", "reason")
        about = {name: getattr(self, name) for name in names}
        if self.kind != "map":
            parts = ("value", "lower", "upper", "share")
            about["sources"] = finite_or_none({k: dict(zip(parts, v, strict=True)) for k, v in self.split().items()})
        arrays = {"points": finite_or_none(self.points), "bearings": finite_or_none(self.bearings)}
        about["interval_factors"] = interval_factors(self.methods["bearings"])
        return {**about, "alternatives": self.alternatives, **arrays, "notes": list(self.notes), "outside": OUTSIDE}

    def __repr__(self) -> str:
        return f"AxleResult({self.axle}, {self.kind}: {len(self.points)} points, {self.status})"
