"""What the strength of a loaded pair gave: grades, root stress, safety factors, scuffing and micropitting numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from efficiency.strength.root_stress import RootStress
from ehl.common.arrays import FloatArray
from ehl.common.pages import TableResult
from ehl.common.table import Table

if TYPE_CHECKING:
    import pandas

Level = Literal["note", "warning"]

_SHOWN = (
    "pressure_flank",
    "contact_endurance",
    "safety_contact",
    "root_stress_pinion",
    "root_stress_gear",
    "safety_root_pinion",
    "safety_root_gear",
    "temperature_flash",
    "temperature_integral",
    "film_specific",
)


COLUMNS = ("safety_contact", "safety_root_pinion", "safety_root_gear", "temperature_integral", "film_specific")


@dataclass(frozen=True)
class Grade:
    """One kind of limit a load goes beyond, with its worst value."""

    kind: str
    level: Level
    text: str  # what, where, and what to do about it

    def __str__(self) -> str:
        return f"{self.level.upper() if self.level == 'warning' else self.level}: {self.text}"


@dataclass(frozen=True)
class Strength(TableResult):
    """Strength of a pair at one operating point; SI units, nan where something is not known.

    Safety factors are after ISO 10300-2 and -3, from public sources, not a certified calculation. The stresses are
    those of the loaded tooth contact with the torque as given: the factors K of the standard are 1.
    """

    status: Literal["ok", "note", "warning"]  # worst level of the grades
    grades: tuple[Grade, ...]  # one for each kind of limit, the worst first
    pressure_flank: float  # greatest Hertz pressure inside the flanks, edges left out [Pa]
    contact_endurance: float  # of the weaker member [Pa]
    # pressure at first yield below the surface, and the shakedown limit, above which cyclic plasticity sets in [Pa]
    pressure_yield: float
    pressure_shakedown: float
    # greatest elastic pressure at an edge [Pa], share of the torque there [-]
    pressure_edge: float
    edge_load_share: float
    safety_contact: float  # S_H: permissible contact stress over `pressure_flank` [-]
    # greatest tensile stress of the root fillets over the mesh cycle [Pa]
    root_stress_pinion: float
    root_stress_gear: float
    # most negative stress of the fillets on the other side [Pa]
    root_compression_pinion: float
    root_compression_gear: float
    # S_F: permissible root stress over `root_stress_pinion` or `root_stress_gear` [-]
    safety_root_pinion: float
    safety_root_gear: float
    temperature_flash: float  # greatest contact temperature, bulk plus flash of Blok [K]
    temperature_integral: float  # bulk temperature plus 1.5 times the mean flash over the contact lines of the mesh [K]
    film_specific: float  # least film thickness over the mean Ra of both flanks [-]
    factors: dict[str, float]  # factors of the permissible stresses by their names [-]
    notes: tuple[str, ...]  # what is assumed and what is left out
    # root stress over the mesh; None where the tooth is no solid
    pinion: RootStress | None = field(repr=False, default=None)
    gear: RootStress | None = field(repr=False, default=None)
    # at the loaded points [-], [K]
    points_film_specific: FloatArray = field(repr=False, default_factory=lambda: np.zeros(0))
    points_temperature: FloatArray = field(repr=False, default_factory=lambda: np.zeros(0))

    def scalars(self) -> dict[str, Any]:
        """The single values by their names, SI units."""
        return {n: v for n in self.__dataclass_fields__ if isinstance(v := getattr(self, n), str | float)}

    def columns(self) -> dict[str, str | float]:
        """Worst grade, safety factors, integral temperature and specific film: the columns of maps and studies."""
        return {"strength": self.status} | {name: getattr(self, name) for name in COLUMNS}

    def to_dict(self) -> dict[str, Any]:
        """Single values, grades, factors, root stress over the mesh, for JSON; not-a-number becomes None."""
        plain: dict[str, Any] = {n: _plain(v) for n, v in self.scalars().items()}
        plain["grades"] = [{"kind": g.kind, "level": g.level, "text": g.text} for g in self.grades]
        plain["factors"] = {n: _plain(v) for n, v in self.factors.items()}
        plain["notes"] = list(self.notes)
        for name, root in (("pinion", self.pinion), ("gear", self.gear)):
            plain[name] = None if root is None else _root_dict(root)
        return plain

    def to_frame(self) -> pandas.DataFrame:
        """One row: the single values by their names, SI units."""
        import pandas

        return pandas.DataFrame([self.scalars() | {"grades": "; ".join(map(str, self.grades))}])

    def table(self) -> Table:
        """The figures a reader looks for first; grades, assumptions and what is left out below."""
        values = {name: getattr(self, name) for name in _SHOWN}
        kept = tuple(name for name in _SHOWN if math.isfinite(values[name]))
        return Table(
            kept,
            [tuple(values[name] for name in kept)],
            title=f"Strength: {self.status.upper()}. Safety factors after ISO 10300, public sources, not certified.",
            notes=(*(f"{g.level:9}{g.text}" for g in self.grades), *(f"{'note':9}{note}" for note in self.notes)),
            name="strength",
            vertical=True,
        )

    def root_table(self) -> Table:
        """Root stress of both members over the mesh, one row for each roll of the tooth pair."""
        rows = [
            (member.member, *line)
            for member in (self.pinion, self.gear)
            if member is not None
            for line in zip(member.roll, member.history, member.history_compression, strict=True)
        ]
        return Table(("member", "pinion_angle", "root_stress", "root_compression"), rows, name="root stress")

    def __repr__(self) -> str:
        roots = f"root {self.root_stress_pinion / 1e6:.4g} and {self.root_stress_gear / 1e6:.4g} MPa"
        return f"Strength({self.status}: {self.pressure_flank / 1e9:.4g} GPa, {roots}, {len(self.grades)} grades)"


def _plain(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _root_dict(root: RootStress) -> dict[str, Any]:
    plain = {n: getattr(root, n) for n in root.__dataclass_fields__}
    return {n: v.tolist() if isinstance(v, np.ndarray) else _plain(v) for n, v in plain.items()}
