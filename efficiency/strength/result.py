"""Result of the strength of a loaded pair: grades, root stress, safety factors, scuffing and micropitting numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from efficiency.strength.root_stress import RootStress
from ehl.common.arrays import FloatArray, finite_or_none
from ehl.common.pages import TableResult
from ehl.common.table import Table

if TYPE_CHECKING:
    import pandas

Level = Literal["note", "warning"]

_SHOWN = (
    *("pressure_flank", "contact_endurance", "safety_contact", "root_stress_pinion", "root_stress_gear"),
    *("safety_root_pinion", "safety_root_gear", "temperature_flash", "temperature_integral", "safety_scuffing"),
    *("film_specific", "safety_micropitting"),
)

COLUMNS = ("safety_contact", "safety_root_pinion", "safety_root_gear", "temperature_integral", "film_specific")


@dataclass(frozen=True)
class Grade:
    """An exceeded limit with its most severe value."""

    kind: str
    level: Level
    text: str  # finding, place and remedy

    def __str__(self) -> str:
        return f"{self.level.upper() if self.level == 'warning' else self.level}: {self.text}"


@dataclass(frozen=True)
class Strength(TableResult):
    """Strength of a pair at one operating point; SI units, nan for unknown values.

    Safety factors are after ISO 10300-2 and -3, from public sources, and not a certified calculation. The stresses are
    those of the loaded tooth contact with the given torque: the K factors of the standard are 1.
    """

    status: Literal["ok", "note", "warning"]  # most severe level of the grades
    grades: tuple[Grade, ...]  # one for each kind of limit, the most severe first
    pressure_flank: float  # maximum Hertz pressure inside the flanks without edges [Pa]
    contact_endurance: float  # contact endurance of the weaker member [Pa]
    # pressure at first yield below the surface, and the shakedown limit, above which cyclic plasticity occurs [Pa]
    pressure_yield: float
    pressure_shakedown: float
    # maximum elastic pressure at an edge [Pa], share of the torque on edges [-]
    pressure_edge: float
    edge_load_share: float
    safety_contact: float  # S_H: permissible contact stress over `pressure_flank` [-]
    # maximum tensile stress of the root fillets over the mesh cycle [Pa]
    root_stress_pinion: float
    root_stress_gear: float
    # most negative stress of the fillets on the opposite side [Pa]
    root_compression_pinion: float
    root_compression_gear: float
    # S_F: permissible root stress over `root_stress_pinion` or `root_stress_gear` [-]
    safety_root_pinion: float
    safety_root_gear: float
    temperature_flash: float  # maximum contact temperature, bulk plus flash of Blok [K]
    temperature_integral: float  # bulk temperature plus 1.5 times the mean flash over the contact lines of the mesh [K]
    safety_scuffing: float  # permissible over computed integral temperature, both in degC [-]
    film_specific: float  # minimum film thickness over the mean Ra of both flanks [-]
    safety_micropitting: float  # `film_specific` over the permissible film of the oil card [-]
    factors: dict[str, float]  # factors of the permissible stresses by name [-]
    notes: tuple[str, ...]  # assumptions
    # root stress over the mesh; None if it is unavailable
    pinion: RootStress | None = field(repr=False, default=None)
    gear: RootStress | None = field(repr=False, default=None)
    # at the loaded points [-]
    points_film_specific: FloatArray = field(repr=False, default_factory=lambda: np.zeros(0))

    def scalars(self) -> dict[str, Any]:
        """Scalar values by name, SI units."""
        return {n: v for n in self.__dataclass_fields__ if isinstance(v := getattr(self, n), str | float)}

    def columns(self) -> dict[str, str | float]:
        """Columns of maps and studies: most severe grade, safety factors, integral temperature, specific film."""
        return {"strength": self.status} | {name: getattr(self, name) for name in COLUMNS}

    def to_dict(self) -> dict[str, Any]:
        """Scalar values, grades, factors and root stress over the mesh, for JSON; nan becomes None."""
        inner = {name: getattr(self, name) for name in ("grades", "factors", "notes", "pinion", "gear")}
        return dict(finite_or_none(self.scalars() | inner))

    def to_frame(self) -> pandas.DataFrame:
        """One row of the scalar values by name, SI units."""
        import pandas

        return pandas.DataFrame([self.scalars() | {"grades": "; ".join(map(str, self.grades))}])

    def table(self) -> Table:
        """The most important figures, with grades and assumptions below."""
        values = {name: getattr(self, name) for name in _SHOWN}
        kept = tuple(name for name in _SHOWN if math.isfinite(values[name]))
        title = f"Strength: {self.status.upper()}. Safety factors after ISO 10300, public sources, not certified."
        notes = (*(f"{g.level:9}{g.text}" for g in self.grades), *(f"{'note':9}{note}" for note in self.notes))
        return Table(kept, [tuple(values[name] for name in kept)], title, notes, "strength", vertical=True)

    def root_table(self) -> Table:
        """Root stress of both members over the mesh, one row for each roll of the tooth pair."""
        rows = []
        for member in filter(None, (self.pinion, self.gear)):
            lines = zip(member.roll, member.history, member.history_compression, strict=True)
            rows += [(member.member, *line) for line in lines]
        return Table(("member", "pinion_angle", "root_stress", "root_compression"), rows, name="root stress")

    def __repr__(self) -> str:
        roots = f"root {self.root_stress_pinion / 1e6:.4g} and {self.root_stress_gear / 1e6:.4g} MPa"
        return f"Strength({self.status}: {self.pressure_flank / 1e9:.4g} GPa, {roots}, {len(self.grades)} grades)"
