"""Every number of a gear run as tables in SI units, for spreadsheets and CSV files: names of docs/nomenclature.md."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from efficiency.loss.regions import FACES, HEIGHTS, friction_along_mesh
from ehl.state import ContactState
from regression.friction.conditions import UNITS
from regression.friction.models import FrictionFlag

if TYPE_CHECKING:
    from efficiency.loss.compare import Comparison
    from efficiency.loss.map import EfficiencyMap
    from efficiency.loss.result import EfficiencyResult

Cell = float | int | str | None

# units of what a result and its parts hold; what is not here has none
RESULT_UNITS: dict[str, str] = {
    "torque_pinion": "N m",
    "speed_pinion": "rad/s",
    "temperature_oil": "K",
    "temperature_inlet": "K",
    "temperature_bulk_1": "K",
    "temperature_bulk_2": "K",
    "roughness_rms_1": "m",
    "roughness_rms_2": "m",
    "correlation_length": "m",
    "power_loss": "W",
    "power_loss_rolling": "W",
    "power_input": "W",
    "power_output": "W",
    "pressure_max": "Pa",
    "pressure_edge": "Pa",
    "pressure_edge_lower": "Pa",
    "pressure_edge_upper": "Pa",
    "transmission_error_loaded": "rad",
    "transmission_error_unloaded": "rad",
    "seconds": "s",
}
_STATE_UNITS = UNITS | {
    "temperature_bulk_1": "K",
    "temperature_bulk_2": "K",
    "temperature_flash": "K",
    "film_central": "m",
}
_DERIVED = ("load_per_length", "half_width", "speed_sliding", "slide_to_roll_total")
_LUBRICATION = ("film_central", "film_ratio", "temperature_flash", "rolling_traction")


@dataclass(frozen=True)
class DataTable:
    """One table: a sheet of a workbook, or a CSV file.

    Parameters
    ----------
    name : str
        Of the sheet and of the file.
    header : sequence of str
        Names of the columns, with their units in brackets.
    rows : sequence of sequences
        Numbers, words, or None where there is nothing.
    """

    name: str
    header: tuple[str, ...]
    rows: Sequence[tuple[Cell, ...]]

    @classmethod
    def of_columns(cls, name: str, columns: Mapping[str, Iterable[Any]], units: Mapping[str, str]) -> DataTable:
        """A table from columns of equal length; units by the names of the columns."""
        header = tuple(with_unit(column, units) for column in columns)
        return cls(name, header, tuple(tuple(map(cell, row)) for row in zip(*columns.values(), strict=True)))


def with_unit(name: str, units: Mapping[str, str]) -> str:
    """A name with its unit in brackets: ``pressure_hertz [Pa]``."""
    unit = units.get(name, "")
    return f"{name} [{unit.replace('*', ' ')}]" if unit else name


def cell(value: Any) -> Cell:
    """A value as a number or a word; None where it is not a number."""
    if isinstance(value, bool | np.bool_):
        return str(bool(value)).lower()
    if isinstance(value, int | np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return None if value is None else str(value)


def scalars(result: Any) -> dict[str, Cell]:
    """The single values of a result by their names, without arrays and groups."""
    kept = (str, bool, int, float, np.floating, np.integer)
    every = {f.name: getattr(result, f.name) for f in fields(result)}
    return {name: cell(value) for name, value in every.items() if isinstance(value, kept)}


def result_tables(result: EfficiencyResult) -> list[DataTable]:
    """One operating point: the result, its remarks, the mesh positions, every point that carries load."""
    return [result_table(result), remarks_table([result]), positions_table(result), points_table(result)]


def result_table(result: EfficiencyResult) -> DataTable:
    """Single values, ranges of the local conditions and counts of the friction model's flags, one a line."""
    rows: list[tuple[Cell, ...]] = [(name, value, _unit(name)) for name, value in scalars(result).items()]
    for name, (low, high) in result.ranges.items():
        rows += [(f"{name} (least)", cell(low), _unit(name)), (f"{name} (greatest)", cell(high), _unit(name))]
    rows += [(f"points flagged {name}", count, "") for name, count in result.flags.items()]
    rows += [(f"contacts failed {reason}", count, "") for reason, count in result.contacts_failed.items()]
    return DataTable("result", ("quantity", "value", "unit"), rows)


def _unit(name: str) -> str:
    return (RESULT_UNITS | _STATE_UNITS).get(name, "").replace("*", " ")


def remarks_table(results: Sequence[EfficiencyResult]) -> DataTable:
    """Notes and what the model leaves out, each once, with the number of results they belong to."""
    counts: dict[tuple[str, str], int] = {}
    for result in results:
        for kind, texts in (("note", result.notes), ("skipped", result.skipped)):
            for text in texts:
                counts[kind, text] = counts.get((kind, text), 0) + 1
    rows = [(kind, text, count) for (kind, text), count in counts.items()]
    return DataTable("remarks", ("kind", "text", "results"), rows)


def positions_table(result: EfficiencyResult) -> DataTable:
    """One row per mesh position: power loss, transmission error, load, share of each tooth pair."""
    loads = result.load.positions
    pairs = sorted({pair for load in loads for pair, share in load.share.items() if share > 0.0})
    columns: dict[str, Iterable[Any]] = {
        "pinion_angle": result.pinion_angle,
        "power_loss": result.power_loss_positions,
        "power_loss_rolling": result.power_loss_rolling_positions,
        "transmission_error_loaded": result.transmission_error_positions,
        "transmission_error_unloaded": [load.position.transmission_error for load in loads],
        "force": [float(load.force.sum()) for load in loads],
        "pressure_max": [float(load.pressure_hertz.max()) for load in loads],
        "pressure_edge": [float(np.max(load.pressure_max, initial=0.0, where=load.at_edge)) for load in loads],
        "points_loaded": [int(np.count_nonzero(load.force > 0.0)) for load in loads],
    }
    shares = [load.share for load in loads]
    columns |= {f"share of pair {pair:+d}": [share.get(pair, 0.0) for share in shares] for pair in pairs}
    units = RESULT_UNITS | {"pinion_angle": "rad", "force": "N"}
    return DataTable.of_columns("positions", columns, units)


def points_table(result: EfficiencyResult) -> DataTable:
    """One row per loaded point: place on the gear, local conditions, friction with its interval and flag, loss."""
    points, friction = result.points, result.friction
    loads = result.load.positions

    def of_position(name: str) -> np.ndarray[Any, np.dtype[Any]]:
        return np.array(
            [getattr(loads[k].position, name)[i] for k, i in zip(points.position, points.index, strict=True)]
        )

    columns: dict[str, Iterable[Any]] = {
        "position": points.position,
        "pinion_angle": result.pinion_angle[points.position],
        "pair": of_position("pair"),
        "face_gear": of_position("face_gear"),
        "height_gear": of_position("height_gear"),
        "face_pinion": of_position("face_pinion"),
        "height_pinion": of_position("height_pinion"),
        "length": of_position("length"),
        "force": points.force,
    }
    columns |= {f.name: getattr(points.state, f.name) for f in fields(ContactState)}
    columns |= {name: getattr(points.state, name) for name in _DERIVED}
    columns |= {name: getattr(result.lubrication, name) for name in _LUBRICATION}
    columns |= {
        "friction_coefficient": friction.mu,
        "friction_lower": friction.lower,
        "friction_upper": friction.upper,
        "flag": [FrictionFlag(flag).name.lower() for flag in friction.flag],
        "power_loss": friction.mu * points.force * points.speed_sliding,
    }
    lengths = ("face_gear", "height_gear", "face_pinion", "height_pinion", "length")
    units = _STATE_UNITS | dict.fromkeys(lengths, "m") | {"pinion_angle": "rad", "force": "N", "power_loss": "W"}
    return DataTable.of_columns("points", columns, units)


def map_tables(grid: EfficiencyMap) -> list[DataTable]:
    """All operating points of a map, one a row; the efficiency over torque and speed at each temperature; remarks."""
    rows = [scalars(result) for result in grid.results]
    tables = [DataTable.of_columns("map", {name: [row[name] for row in rows] for name in rows[0]}, RESULT_UNITS)]
    values = grid.values()
    for number, temperature in enumerate(grid.temperature_oil):
        header = ("torque_pinion [N m]", *(f"at {speed:.6g} rad/s" for speed in grid.speed_pinion))
        lines = [
            (torque, *map(cell, line)) for torque, line in zip(grid.torque_pinion, values[:, :, number], strict=True)
        ]
        tables.append(DataTable(f"efficiency at {temperature:.6g} K", header, lines))
    return [*tables, remarks_table(grid.results)]


def comparison_tables(comparison: Comparison) -> list[DataTable]:
    """A row per way to the efficiency, friction and loss along the mesh, loss by region of the flank, remarks."""
    rows = [scalars(row) for row in comparison.rows]
    models = DataTable.of_columns("models", {name: [row[name] for row in rows] for name in rows[0]}, RESULT_UNITS)
    names = [row.name for row in comparison.rows[: len(comparison.results)]]
    angle = comparison.results[0].pinion_angle
    friction = {name: friction_along_mesh(result) for name, result in zip(names, comparison.results, strict=True)}
    loss = {name: result.power_loss_positions for name, result in zip(names, comparison.results, strict=True)}
    unit = {"pinion_angle": "rad"}
    header = ("model", *(f"{height}, {face}" for height in HEIGHTS for face in FACES))
    shares = [
        (row.name, *(cell(share) for line in row.loss_regions for share in line))
        for row in comparison.rows
        if row.loss_regions
    ]
    return [
        models,
        DataTable.of_columns("friction along the mesh", {"pinion_angle": angle} | friction, unit),
        DataTable.of_columns("loss along the mesh", {"pinion_angle": angle} | loss, unit | dict.fromkeys(loss, "W")),
        DataTable("share of loss by region", header, shares),
        remarks_table(comparison.results),
    ]
