"""Tables of the assembly: misalignment without load, deflection under load, and stiffness of shafts and bearings.

The stiffness is given as matrices, or as shafts on bearings.
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import AliasChoices, Field, field_validator, model_validator

from efficiency.ltca.shaft_deflection import Compliances, MemberCompliance, shaft_compliance
from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel
from ehl.material import Material

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
            allowed = f"{low:.6g} to {high:.6g} N m, negative on the coast flanks"
            hint = "Add rows for the largest torque of both flanks."
            raise InputError("assembly.deflection.table", f"no row for {torque:.6g} N m", allowed, hint)
        return {name: float(np.interp(torque, rows[:, 0], rows[:, 1 + k])) for k, name in enumerate(MISALIGNMENTS)}


def _rows(path: Path) -> tuple[Sequence[float], ...]:
    """Rows of a table of deflections: columns torque, E, P, G and shaft_angle_error or alpha, each with its unit."""
    from ehl.common.table_reader import read_table

    length, angle = ValueRange("m", ge=-2e-3, le=2e-3), ValueRange("rad", ge=-0.01, le=0.01)
    columns = {"torque": ValueRange("N*m", ge=-1e6, le=1e6), "E": length, "P": length, "G": length}
    found, _ = read_table(path, columns | dict.fromkeys(("shaft_angle_error", "alpha"), angle), ("torque",), bare=False)
    if len(found) < 2:
        raise InputError(path.name, "torque alone", "at least one of the columns E, P, G, alpha")
    torque = np.array(found["torque"], float)
    if np.unique(torque).size < torque.size:
        raise InputError(f"{path.name}, column torque", "equal values", "each torque once")
    moved = [found.get(name, np.zeros(torque.size)) for name in ("E", "P", "G")]
    moved.append(found.get("alpha", found.get("shaft_angle_error", np.zeros(torque.size))))
    return tuple(tuple(float(value) for value in row) for row in zip(torque, *moved, strict=True))


Place = Annotated[float, ValueRange("m", ge=-5.0, le=5.0)]
SpringRate = Annotated[float, ValueRange("N/m", ge=0.0, le=1e14)]
Diameter = Annotated[float, ValueRange("m", gt=0.0, le=2.0)]
MatrixRow = Annotated[tuple[float, ...], Field(min_length=6, max_length=6)]

# asymmetry by rounding of printed values, as a fraction of the diagonal
_ASYMMETRY = 1e-3
# smallest eigenvalue of the matrix scaled to a unit diagonal
_SINGULAR = 1e-9
_REMEDY = (
    "Give the stiffness of the supported member in N/m, N and N m (inverse of the compliance at the reference point). "
    "If the rotation about the own axis is free, enter the torsional stiffness of the shaft."
)


class BearingStiffnessInput(InputModel):
    """A bearing of a shaft by its stiffness."""

    position: Place  # along the axis from the crossing point [m], positive towards the teeth
    # stiffness [N/m]
    radial: Annotated[float, ValueRange("N/m", gt=0.0, le=1e14)]
    axial: SpringRate = 0.0


class MemberStiffnessInput(InputModel):
    """Shaft, bearings and housing of one member."""

    # reference point of the matrix on the axis, where the mesh force acts on the shaft: distance from the crossing
    # point [m], positive towards the teeth
    reference_point: Place
    # force [N] and moment [N m] by displacement [m] and rotation [rad] along x, y, z, six rows of six: N/m, N, N m
    matrix: Annotated[tuple[MatrixRow, ...], Field(min_length=6, max_length=6)] | None = None
    bearings: tuple[BearingStiffnessInput, ...] = ()  # instead of the matrix: at least two at different positions
    # diameters of a shaft with bearings [m]
    shaft_diameter: Diameter | None = None
    shaft_bore: Annotated[float, ValueRange("m", ge=0.0, le=2.0)] = 0.0
    material: str = "steel"  # material of the shaft

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if (self.matrix is None) == (not self.bearings):
            raise InputError("matrix", self.matrix and "with bearings", "either a matrix or bearings with a shaft")
        if self.matrix is not None:
            if self.shaft_diameter is not None or self.shaft_bore:
                raise InputError("shaft_diameter", "with a matrix", "a shaft only with bearings")
            _require_stiffness(np.array(self.matrix))
            return self
        places = {bearing.position for bearing in self.bearings}
        if len(places) < 2:
            raise InputError("bearings", f"{len(places)} position", "at least two bearings at different positions")
        if not any(bearing.axial for bearing in self.bearings):
            raise InputError("bearings", "axial = 0 for all", "an axial stiffness above 0 N/m of at least one bearing")
        if self.shaft_diameter is None:
            raise InputError("shaft_diameter", None, "the diameter of the shaft, such as '40 mm'")
        if self.shaft_bore >= self.shaft_diameter:
            allowed = f"below the diameter of {self.shaft_diameter * 1e3:.6g} mm"
            raise InputError("shaft_bore", f"{self.shaft_bore * 1e3:.6g} mm", allowed)
        Material.load(self.material)
        return self

    def compliance(self) -> MemberCompliance:
        """Displacement under force and moment at the reference point."""
        if self.matrix is not None:
            given = np.array(self.matrix)
            size = 1.0 / np.sqrt(np.diag(given))
            scaled = np.linalg.inv(0.5 * (given + given.T) * np.outer(size, size))
            return MemberCompliance(scaled * np.outer(size, size), self.reference_point)
        steel = Material.load(self.material)
        bearings = [(b.position, b.radial, b.axial) for b in self.bearings]
        shaft = self.reference_point, bearings, self.shaft_diameter or math.nan, self.shaft_bore
        matrix = shaft_compliance(*shaft, steel.youngs_modulus, steel.poisson_ratio)
        return MemberCompliance(matrix, self.reference_point)


class StiffnessInput(InputModel):
    """Shafts, bearings and housing of both members; a member without input is rigid."""

    pinion: MemberStiffnessInput | None = None
    gear: MemberStiffnessInput | None = None

    @property
    def given(self) -> bool:
        """Whether any member deflects."""
        return self.pinion is not None or self.gear is not None

    def compliances(self) -> Compliances:
        """Compliances of pinion and gear."""
        pinion, gear = (None if given is None else given.compliance() for given in (self.pinion, self.gear))
        return pinion, gear


def _require_stiffness(matrix: FloatArray) -> None:
    diagonal = np.diag(matrix)
    allowed = "a symmetric positive definite matrix"
    if np.any(diagonal <= 0.0):
        row = int(np.argmin(diagonal)) + 1
        raise InputError("matrix", f"{diagonal.min():.6g} on the diagonal, row {row}", allowed, _REMEDY)
    size = 1.0 / np.sqrt(diagonal)
    scaled = matrix * np.outer(size, size)
    skew = np.abs(scaled - scaled.T)
    if skew.max() > _ASYMMETRY:
        i, j = np.unravel_index(int(skew.argmax()), skew.shape)
        value = f"{matrix[i, j]:.6g} in row {i + 1}, column {j + 1}, {matrix[j, i]:.6g} in row {j + 1}, column {i + 1}"
        raise InputError("matrix", value, allowed, "Both must be equal by reciprocity of force and displacement.")
    smallest = float(np.linalg.eigvalsh(0.5 * (scaled + scaled.T)).min())
    if smallest < _SINGULAR:
        raise InputError("matrix", f"smallest eigenvalue {smallest:.3g} at a unit diagonal", allowed, _REMEDY)
