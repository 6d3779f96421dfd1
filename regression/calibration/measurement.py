"""Measured table: one row per friction value, columns with the names of docs/nomenclature.md, units in the header."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.files import read_bytes
from ehl.common.table_reader import read_table
from ehl.common.units import ValueRange
from ehl.common.validation import value_range_of
from regression.calibration.setup import ConditionsInput

CONDITIONS = {name: value_range_of(ConditionsInput, name) for name in ConditionsInput.model_fields}
LOADS = ("pressure_hertz", "load", "load_per_length")
NEEDED = ("radius_equivalent", "speed_entrainment", "slide_to_roll", "temperature_oil")
MEASURED: dict[str, ValueRange] = {
    # negative values: sign of the slip, or noise of a friction near 0
    "friction_coefficient": ValueRange("", ge=-2.0, le=2.0, hint="mu, not a friction force."),
    "friction_uncertainty": ValueRange("", gt=0.0, le=1.0, hint="One standard deviation of mu."),
}
MIN_FRICTION = -0.1  # noise of a friction near 0, at slip of either sign
MAX_SLIP = 4.0  # slide-to-roll ratio: 2 is pure sliding; larger values are usually percentages without unit
# rows of one condition: relative difference of load, speed and slip, and temperatures [K]
SAME, SAME_TEMPERATURE, SAME_SLIP = 0.02, 1.5, 1e-4
LABEL = "curve"
SYNTHETIC = "# SYNTHETIC"  # first line of a table of synthetic friction
COLUMNS: dict[str, ValueRange | None] = {**CONDITIONS, **MEASURED, LABEL: None}


@dataclass(frozen=True, eq=False)
class Measurement:
    """A measured table in SI units."""

    name: str  # file name, with "(synthetic)" for synthetic data
    file_hash: str  # SHA-256 of the file
    columns: dict[str, FloatArray]  # conditions by name, including constant ones; shape (n,)
    load: str  # the one of `LOADS` that is given
    # mu and its standard deviation [-]; nan if not given; shape (n,)
    friction: FloatArray
    uncertainty: FloatArray
    curve: tuple[str, ...]  # label of each row
    row_numbers: tuple[int, ...]  # number of each row in the file, counted from 1 (first of averaged rows)
    notes: tuple[str, ...] = ()  # processing of the rows

    @property
    def size(self) -> int:
        """Number of rows."""
        return len(self.curve)


def read_measurement(path: Path, fixed: Mapping[str, float], *, roughness_rms: float = 0.0) -> Measurement:
    """Read a table of measured friction.

    path: CSV, XLSX or the export of a test rig (`ehl.common.table_reader.read_table`). Slip in both directions is
        combined (`folded`).
    fixed: conditions of all rows in SI units; each either here or in the table.
    roughness_rms: roughness of rows if neither the table nor `fixed` states it [m].
    Raises `InputError`: the message states file, row and column.
    """
    instead = ConditionsInput.instead
    table, numbers = read_table(path, COLUMNS, ("friction_coefficient",), missing=True, instead=instead)
    size = len(next(iter(table.values())))
    for name in fixed:
        if name in table:
            raise InputError(f"conditions.{name}", fixed[name], f"{name} either in [conditions] or in {path.name}")
    given = {*table, *fixed}
    hint = "Give it as a column of the table, or under [conditions] of the setup if it is the same for all rows."
    loads = [name for name in LOADS if name in given]
    if len(loads) != 1:
        raise InputError(f"{path.name}, load", " and ".join(loads) or None, "exactly one of " + ", ".join(LOADS), hint)
    for name in NEEDED:
        if name not in given:
            meaning = f"{instead['speed']} " if name in ("speed_entrainment", "slide_to_roll") else ""
            raise InputError(f"{path.name}, column {name}", None, CONDITIONS[name].expected(), meaning + hint)
    columns = {
        name: np.array(table[name] if name in table else np.full(size, fixed[name]), dtype=float)
        for name in CONDITIONS
        if name in given
    }
    columns.setdefault("roughness_rms", np.full(size, roughness_rms))
    content = read_bytes(path, "file", "a CSV or XLSX file")
    measurement = Measurement(
        name=path.name + (" (synthetic)" if content.startswith(SYNTHETIC.encode()) else ""),
        file_hash=hashlib.sha256(content).hexdigest(),
        columns=columns,
        load=loads[0],
        friction=np.array(table["friction_coefficient"], dtype=float),
        uncertainty=np.array(table.get("friction_uncertainty", np.full(size, np.nan)), dtype=float),
        curve=tuple(str(label) for label in table.get(LABEL, ("1",) * size)),
        row_numbers=numbers,
    )
    largest = float(np.abs(columns["slide_to_roll"]).max())
    if largest > MAX_SLIP:
        hint = "For values in % write the unit in the header: slide_to_roll [%]."
        raise InputError(f"{path.name}, column slide_to_roll", largest, f"at most {MAX_SLIP:g}", hint)
    measurement = folded(measurement)
    least = MIN_FRICTION if np.median(measurement.friction) >= 0.0 else 0.0
    low = np.flatnonzero(measurement.friction < least)
    if low.size:
        where = f"{path.name}, row {measurement.row_numbers[low[0]]}, friction_coefficient"
        hint = "Friction is positive, or has the sign of the slip."
        raise InputError(where, float(measurement.friction[low[0]]), f"at least {least:g}", hint)
    return measurement


def folded(measurement: Measurement) -> Measurement:
    """A measurement with slip in both directions combined and repeats averaged; other measurements are unchanged.

    At each condition mu = (mu(+s) - mu(-s))/2, which removes the zero offset (mu(+s) + mu(-s))/2 of the force sensor.
    For friction without sign it is the mean of both. Rows of one condition agree in load, speed and slip to 2 % and in
    temperature to 1.5 K. A condition measured in one direction only is corrected by the median offset.
    """
    slip, mu = measurement.columns["slide_to_roll"], measurement.friction
    back, forth = slip < 0.0, slip > 0.0
    if not back.any():
        return measurement
    signed = bool(np.mean(mu[back]) < 0.0)
    group = _conditions(measurement)
    both = set(group[back]) & set(group[forth])
    if not signed and len(both) < 0.5 * len(set(group[back])):
        return measurement
    sign = np.where(back & signed, -1.0, 1.0)
    first, place = np.unique(group, return_index=True)
    means = {k: [float(np.mean(mu[(group == k) & way])) for way in (forth, back)] for k in both}
    offsets = [0.5 * (one + other) for one, other in means.values()] if signed else []
    offset = float(np.median(offsets)) if offsets else 0.0
    friction = np.array(
        [
            0.5 * (means[k][0] + sign[(group == k) & back][0] * means[k][1])
            if k in both
            else float(np.mean(sign[group == k] * (mu[group == k] - offset)))
            for k in first
        ]
    )
    unsigned = measurement.columns | {"slide_to_roll": np.abs(slip)}
    mean = {name: np.array([np.mean(values[group == k]) for k in first]) for name, values in unsigned.items()}
    known = measurement.uncertainty
    note = f"{len(mu)} rows with slip in both directions averaged to {len(first)} conditions"
    if offsets:
        note += f"; offset of mu {offset:+.4f} (median), {min(offsets):+.4f} to {max(offsets):+.4f}"
    return replace(
        measurement,
        columns=mean,
        friction=friction,
        uncertainty=np.array([np.sqrt(np.mean(known[group == k] ** 2) / np.sum(group == k)) for k in first]),
        curve=tuple(measurement.curve[k] for k in place),
        row_numbers=tuple(measurement.row_numbers[k] for k in place),
        notes=(note,),
    )


def _conditions(measurement: Measurement) -> NDArray[np.int64]:
    """Number of the condition of each row, independent of the sign of its slip, in the order of the file."""
    relative = {name: np.abs(values) for name, values in measurement.columns.items() if name != "temperature_oil"}
    temperature = measurement.columns["temperature_oil"]
    group = np.full(measurement.size, -1)
    for k in range(measurement.size):
        if group[k] < 0:
            same = np.abs(temperature - temperature[k]) <= SAME_TEMPERATURE
            for name, values in relative.items():
                slack = SAME_SLIP if name == "slide_to_roll" else 0.0
                same &= np.abs(values - values[k]) <= SAME * values[k] + slack
            group[same & (group < 0)] = k
    return group
