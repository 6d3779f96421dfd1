"""The measured table: one row per friction value, columns by the names of docs/nomenclature.md, units in the header."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from ehl import inputs
from ehl.common.errors import InputError
from ehl.common.files import read_bytes
from ehl.common.table_reader import numbered_table
from ehl.common.units import ValueRange
from ehl.fluid.viscosity import Temperature

Array = NDArray[np.float64]


def _quantity(annotation: object) -> ValueRange:
    return next(part for part in get_args(annotation) if isinstance(part, ValueRange))


CONDITIONS: dict[str, ValueRange] = {
    "pressure_hertz": _quantity(inputs.Pressure),
    "load": ValueRange("N", gt=0.0, le=1e7),
    "load_per_length": _quantity(inputs.LoadPerLength),
    "radius_equivalent": _quantity(inputs.Radius),
    "speed_entrainment": _quantity(inputs.Speed),
    "slide_to_roll": _quantity(inputs.SlideToRoll),
    "temperature_oil": _quantity(Temperature),
    "roughness_rms": _quantity(inputs.Rms),
}
LOADS = ("pressure_hertz", "load", "load_per_length")
NEEDED = ("radius_equivalent", "speed_entrainment", "slide_to_roll", "temperature_oil")
MEASURED: dict[str, ValueRange] = {
    # the noise of a friction near 0 may be negative
    "friction_coefficient": ValueRange("", ge=-0.1, le=2.0, hint="mu, not a friction force."),
    "friction_uncertainty": ValueRange("", gt=0.0, le=1.0, hint="One standard deviation of mu."),
}
LABEL = "curve"
SYNTHETIC = "# SYNTHETIC"  # how a table of synthetic friction begins
COLUMNS: dict[str, ValueRange | None] = {**CONDITIONS, **MEASURED, LABEL: None}


@dataclass(frozen=True, eq=False)
class Measurement:
    """A measured table, SI.

    Parameters
    ----------
    name : str
        File name, and "(synthetic)" where the file says so.
    file_hash : str
        SHA-256 of the file.
    columns : dict of ndarray, shape (n,)
        Conditions by name; those that hold for all rows are filled in.
    load : str
        Which of `LOADS` there is.
    friction, uncertainty : ndarray, shape (n,)
        mu and its standard deviation [-]; nan where none is given.
    curve : tuple of str
        Label of each row.
    row_numbers : tuple of int
        Of each row in the file, counted from 1; below a header of one line where not given.
    """

    name: str
    file_hash: str
    columns: dict[str, Array]
    load: str
    friction: Array
    uncertainty: Array
    curve: tuple[str, ...]
    row_numbers: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if not self.row_numbers:
            object.__setattr__(self, "row_numbers", tuple(range(2, self.size + 2)))

    @property
    def size(self) -> int:
        """Number of rows."""
        return len(self.curve)


def read_measurement(path: Path, fixed: Mapping[str, float], *, friction: bool = True) -> Measurement:
    """Read a table of measured friction.

    Parameters
    ----------
    path : Path
        CSV or XLSX as `ehl.common.table_reader.read_table` takes it.
    fixed : mapping
        Conditions that hold for every row, SI; each either here or in the table.
    friction : bool
        Whether the column friction_coefficient is needed (not for a planned test).

    Raises
    ------
    InputError
        Naming file, row and column.
    """
    table, numbers = numbered_table(path, COLUMNS, ("friction_coefficient",) if friction else (), missing=True)
    size = len(next(iter(table.values())))
    for name in fixed:
        if name in table:
            raise InputError(f"conditions.{name}", fixed[name], f"{name} either in [conditions] or in {path.name}")
    given = {*table, *fixed}
    loads = [name for name in LOADS if name in given]
    if len(loads) != 1:
        hint = "Give it as a column of the table, or under [conditions] of the setup where it holds for all rows."
        raise InputError(f"{path.name}, load", " and ".join(loads) or None, "exactly one of " + ", ".join(LOADS), hint)
    for name in NEEDED:
        if name not in given:
            hint = "Give it as a column of the table, or under [conditions] of the setup where it holds for all rows."
            raise InputError(f"{path.name}, column {name}", None, CONDITIONS[name].expected, hint)
    columns = {
        name: np.array(table[name] if name in table else np.full(size, fixed[name]), dtype=float)
        for name in CONDITIONS
        if name in given
    }
    columns.setdefault("roughness_rms", np.zeros(size))
    nothing, content = np.full(size, np.nan), read_bytes(path, "file", "a CSV or XLSX file")
    return Measurement(
        name=path.name + (" (synthetic)" if content.startswith(SYNTHETIC.encode()) else ""),
        file_hash=hashlib.sha256(content).hexdigest(),
        columns=columns,
        load=loads[0],
        friction=np.array(table.get("friction_coefficient", nothing), dtype=float),
        uncertainty=np.array(table.get("friction_uncertainty", nothing), dtype=float),
        curve=tuple(str(label) for label in table.get(LABEL, ("1",) * size)),
        row_numbers=numbers,
    )
