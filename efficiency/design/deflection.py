"""Tables [assembly.misalignment] and [assembly.deflection]: displacements without load and under load."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import AliasChoices, Field, field_validator, model_validator

from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel

Error = Annotated[float, ValueRange("m", ge=-2e-3, le=2e-3)]
ShaftAngleError = Annotated[
    float, ValueRange("rad", ge=-0.01, le=0.01), Field(validation_alias=AliasChoices("shaft_angle_error", "alpha"))
]


Row = tuple[float, float, float, float, float]
_ZERO: Row = (0.0, 0.0, 0.0, 0.0, 0.0)


class Misalignment(InputModel):
    """Displacement of the members from their nominal position."""

    E: Error = 0.0  # displacement along the offset [m]
    P: Error = 0.0  # displacement along the pinion axis [m]
    G: Error = 0.0  # displacement along the gear axis [m]
    shaft_angle_error: ShaftAngleError = 0.0  # added to the shaft angle [rad]; alias in files: `alpha`


MISALIGNMENTS = tuple(Misalignment.model_fields)


class Deflection(Misalignment):
    """Displacements of shafts, bearings and housing under load, in the axes of the misalignment."""

    # pinion torque of these displacements, which are proportional to the torque [N m]
    torque: Annotated[float, ValueRange("N*m", gt=0.0, le=1e6)] | None = None
    # in their place: a file, or its rows of torque (negative on the coast flanks) and the displacements [SI]
    table: tuple[Row, ...] = ()

    @field_validator("table", mode="before")
    @classmethod
    def _read(cls, given: Any) -> Any:
        return _rows(Path(given)) if isinstance(given, str | Path) else given

    @model_validator(mode="after")
    def _at_a_torque(self) -> Self:
        moved = any(getattr(self, name) for name in MISALIGNMENTS)
        if self.table and (moved or self.torque is not None):
            raise InputError("table", "given together with E, P, G, alpha or torque", "one of both")
        if moved and self.torque is None:
            raise InputError("torque", None, "the pinion torque of these displacements, such as '300 N m'")
        return self

    @property
    def moves(self) -> bool:
        """Whether any displacement is nonzero."""
        return bool(self.table) or any(getattr(self, name) for name in MISALIGNMENTS)

    def at(self, torque: float) -> dict[str, float]:
        """Displacements at a pinion torque [N m], negative on the coast flanks, by their names [m], [rad].

        A table is interpolated linearly, from zero displacement at zero torque unless it has a row for it. Raises
        `InputError` for a torque beyond the rows of the table.
        """
        if not self.table:
            share = torque / (self.torque or 1.0)
            return {name: share * getattr(self, name) for name in MISALIGNMENTS}
        rows = np.array(self.table if any(row[0] == 0.0 for row in self.table) else (*self.table, _ZERO))
        rows = rows[np.argsort(rows[:, 0])]
        low, high = rows[0, 0], rows[-1, 0]
        if not low <= torque <= high:
            raise InputError(
                "assembly.deflection.table",
                f"no row for {torque:.6g} N m",
                f"{low:.6g} to {high:.6g} N m, negative on the coast flanks",
                "Add rows for the largest torque of both flanks.",
            )
        return {name: float(np.interp(torque, rows[:, 0], rows[:, 1 + k])) for k, name in enumerate(MISALIGNMENTS)}


def _rows(path: Path) -> tuple[Sequence[float], ...]:
    """Rows of a table of deflections: columns torque, E, P, G and shaft_angle_error or alpha, each with its unit."""
    from ehl.common.table_reader import read_table

    length, angle = ValueRange("m", ge=-2e-3, le=2e-3), ValueRange("rad", ge=-0.01, le=0.01)
    columns = {"torque": ValueRange("N*m", ge=-1e6, le=1e6), "E": length, "P": length, "G": length}
    found = read_table(path, columns | dict.fromkeys(("shaft_angle_error", "alpha"), angle), ("torque",), bare=False)
    if len(found) < 2:
        raise InputError(path.name, "torque alone", "at least one of the columns E, P, G, alpha")
    torque = np.array(found["torque"], float)
    if np.unique(torque).size < torque.size:
        raise InputError(f"{path.name}, column torque", "equal values", "each torque once")
    moved = [found.get(name, np.zeros(torque.size)) for name in ("E", "P", "G")]
    moved.append(found.get("alpha", found.get("shaft_angle_error", np.zeros(torque.size))))
    return tuple(tuple(float(value) for value in row) for row in zip(torque, *moved, strict=True))
