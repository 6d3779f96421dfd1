"""Tables and graded notes of a gear pair: one operating point, maps, comparisons, duty cycles, uncertainty.

They are used for terminal, page, workbook, CSV and data frames.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, fields
from itertools import product
from typing import Any

import numpy as np

from efficiency.conditions.duty import DutyCycle
from efficiency.conditions.grid import Grid
from efficiency.loss.compare import Comparison
from efficiency.loss.efficiency_result import EfficiencyResult, pair_notes
from efficiency.loss.power_loss import friction_along_mesh
from ehl.common.arrays import BoolArray, FloatArray
from ehl.common.data import reason_text
from ehl.common.quantities import quantity
from ehl.common.sections import Notes
from ehl.common.table import Column, Table, cell
from ehl.state import ContactState
from ehl.uncertainty.result import InputUncertainty
from regression.friction.models import FrictionFlag
from regression.friction.published_registry import model_label


def result_notes(
    result: EfficiencyResult, of_design: Sequence[str] = (), case: str = "", *, strength: bool = True
) -> list[tuple[str, str]]:
    """Case and text of all notes on one operating point.

    of_design: notes on the unloaded pair.
    case: name of the operating point.
    strength: whether the grades of the strength are included.
    """
    said = [f"not converged: {reason_text(result.reason)}"] if result.status != "converged" else []
    edges = False
    if strength and result.has_strength:
        said += [grade.text for grade in result.strength.grades]
        edges = any(grade.kind == "edges" for grade in result.strength.grades)
    # the grade of the edge load contains a remedy and replaces the note
    said += [note for note in result.notes if not (edges and note.startswith("edges carry"))]
    if outside := outside_note(result.outside_range_share, model_label(result.friction_model)):
        warmest = float(result.points.state.temperature_oil.max())
        said.append(f"{outside}; oil at the teeth {quantity('temperature').text(warmest)}")
    # notes on the unloaded pair belong to all cases
    return [(case, text) for text in said] + [("", note) for note in of_design if note not in said]


def grid_notes(grid: Grid) -> Notes:
    """Notes of a map, one for each kind with the worst point."""
    return Notes(pair_notes(said_of_grid(grid)), len(grid.results))


def said_of_grid(grid: Grid) -> list[tuple[str, str]]:
    """Operating point and text of all notes on a map; grades of strength where requested."""
    solved = [(point.result, bool(point.requested.get("strength"))) for point in grid.points if point.result]
    return [
        pair for result, graded in solved for pair in result_notes(result, (), operating_state(result), strength=graded)
    ]


def duty_notes(cycle: DutyCycle) -> Notes:
    """Notes of a duty cycle, one for each kind with the worst row of the cycle."""
    said = []
    for number, point in enumerate(cycle.points, start=1):
        row = f"row {number}"
        if point.result is None:
            said += [(row, f"no result: {note}") for note in point.notes]
        else:
            said += result_notes(point.result, (), row)
    return Notes(pair_notes(said), len(cycle.points))


def outside_note(share: float, model: str) -> str:
    """A note if more than 1 % of the sliding power lies outside the range of a friction model; otherwise empty."""
    text = f"{percent(share, 1)} % of the sliding power lies outside the range of {model}; friction `ehl` has no range"
    return text if share > 0.01 else ""


_SUMMARY = (
    *("efficiency", "efficiency_error", "efficiency_lower", "efficiency_upper", "efficiency_with_rolling"),
    *("power_loss", "power_loss_rolling", "power_input", "friction_coefficient_mean"),
    *("outside_range_share", "measured_share"),
    *("temperature_bulk_pinion", "pressure_hertz_max", "transmission_error_loaded", "transmission_error_unloaded"),
    "torque_residual",
)
_EDGE = ("pressure_edge", "pressure_edge_lower", "pressure_edge_upper", "edge_load_share", "edge_loss_share")
_RANGES = (
    *("pressure_hertz", "load_per_length", "radius_equivalent", "half_width", "speed_entrainment", "speed_sliding"),
    *("speed_sliding_lengthwise", "slide_to_roll", "slide_to_roll_total", "film_central", "film_ratio"),
    *("temperature_flash", "mu"),
)
_DERIVED = ("load_per_length", "half_width", "speed_sliding", "slide_to_roll_total")
CARRIED = 0.999  # share of the load of the points whose largest film ratio is stated (this work)
_LUBRICATION = ("film_central", "film_ratio", "temperature_flash", "rolling_traction")


def percent(value: float, digits: int = 3) -> str:
    """A share in percent for a sentence; a dash if it is not finite."""
    return f"{100.0 * value:.{digits}f}" if math.isfinite(value) else "–"


def timing(result: Any, count: str, status: str = "") -> str:
    """Status of a study or an optimisation, number of points or evaluations and wall time."""
    again = f", {result.reused} from an earlier run" if result.reused else ""
    workers = "process" if result.jobs == 1 else "processes"
    return f"{status or result.status}: {count}{again}, {result.seconds:.1f} s with {result.jobs} {workers}"


def operating_point(result: EfficiencyResult | Comparison) -> str:
    """Pair, side, torque, speed and oil in one line."""
    torque, speed, temperature = operating_state(result).split(", ")
    return f"{result.design}, {result.side}, {torque}, {speed}, {result.conditions.oil} at {temperature}"


def operating_state(result: EfficiencyResult | Comparison) -> str:
    """Torque, speed and oil temperature as text."""
    names = ("torque", "speed", "temperature")
    return ", ".join(quantity(name).text(getattr(result.conditions, name)) for name in names)


def efficiency_table(result: EfficiencyResult) -> Table:
    """The main figures of one operating point."""
    values = {name: result.value(name) for name in _SUMMARY}
    limits = limit_columns([result])
    if result.efficiency_lower < result.efficiency_upper:
        limits |= _uncertain(limits["efficiency_lower"].decimals or 0)
    else:  # no uncertain input, or failed
        del values["efficiency_lower"], values["efficiency_upper"]
    columns: dict[Any, Any] = {limits.get(name, name): value for name, value in values.items()}
    if result.edges.load_share > 0.0:
        columns |= {name: result.value(name) for name in _EDGE}
    film, flash = _finite(result.lubrication.film_ratio), _finite(result.lubrication.temperature_flash)
    columns[Column("film_ratio_min", of="film_ratio", label="film ratio, minimum")] = film.min(initial=math.inf)
    film = _finite(result.lubrication.film_ratio[carrying_points(result.points.force)])
    label = f"film ratio, maximum ({percent(CARRIED, 1)} % of the load)"
    columns[Column("film_ratio_max", of="film_ratio", label=label)] = film.max(initial=-math.inf)
    columns["temperature_flash"] = flash.max(initial=-math.inf)
    if result.solution.contacts:
        columns["contacts"] = result.solution.contacts
        columns[Column("failed", label="failed contacts")] = sum(result.solution.contacts_failed.values())
        if result.friction_range.flags["predicted"]:
            label = "share of the loss near failed contacts"
            columns[Column("predicted_share", of="share", label=label)] = result.friction_range.flag_shares["predicted"]
    status = f"{result.status}: {reason_text(result.reason)}" if result.reason else result.status
    return Table(
        tuple(columns),
        [tuple(columns.values())],
        title=f"{operating_point(result)}, friction: {model_label(result.friction_model)}",
        notes=(
            *(() if result.reason else (inputs_note(result.inputs),)),
            f"{status}, {result.solution.points_loaded} points, {result.conditions.driver} driving",
            *(f"neglected  {note}" for note in result.skipped),
        ),
        vertical=True,
    )


def carrying_points(force: FloatArray) -> BoolArray:
    """Mask of the most loaded points that carry the share `CARRIED` of the load.

    The others are at the ends of the loaded lines: their number and film depend on the last digit of the torque.
    """
    order = np.argsort(-force)
    before = np.cumsum(force[order]) - force[order]
    mask = np.empty(force.size, bool)
    mask[order] = before <= CARRIED * force.sum()
    return mask


def limit_columns(results: Iterable[Any]) -> dict[str, Column]:
    """Columns of the limits of the efficiency, with two significant digits of the narrowest interval."""
    widths = (100.0 * (result.efficiency_upper - result.efficiency_lower) for result in results)
    narrowest = min((width for width in widths if width > 0.0), default=1.0)
    decimals = max(0, 1 - math.floor(math.log10(narrowest)))
    return {name: Column(name, decimals=decimals) for name in ("efficiency_lower", "efficiency_upper")}


def _uncertain(decimals: int) -> dict[str, Column]:
    """Columns of an uncertain loss: one more digit than its limits have, for comparisons with similar pairs."""
    exact = {name: Column(name, decimals=decimals + 1) for name in ("efficiency", "efficiency_with_rolling")}
    names = ("power_loss", "power_loss_rolling", "friction_coefficient_mean")
    return exact | {name: Column(name, digits=3, rounded=True) for name in names}


def inputs_note(inputs: InputUncertainty) -> str:
    """Uncertainty of the efficiency from the inputs, in one line, without the numerical error."""
    if not inputs.low < inputs.high:
        return f"inputs   {'; '.join(inputs.notes) or 'no input of this friction model is uncertain'}"
    return "; ".join((f"inputs   {inputs.headline()}, {100.0 * inputs.level:.0f} % interval", *inputs.notes))


def _finite(values: Any) -> Any:
    return values[np.isfinite(values)]


def range_table(result: EfficiencyResult) -> Table:
    """Minimum and maximum of the local conditions at the loaded points."""
    parts = (result.friction, result.lubrication, result.points.state)
    sources = {name: next(part for part in parts if hasattr(part, name)) for name in _RANGES}
    found = {name: _finite(getattr(source, name)) for name, source in sources.items()}
    ends = [
        ("minimum", *(values.min(initial=math.inf) for values in found.values())),
        ("maximum", *(values.max(initial=-math.inf) for values in found.values())),
    ]
    title = "Local conditions at the loaded points, and friction over them."
    return Table(("end", *found), ends, title=title, vertical=True)


def result_table(result: EfficiencyResult) -> Table:
    """Scalar values, ranges of the local conditions and counts of the flags of the friction model, one per line."""
    columns: dict[Any, Any] = {name: cell(value) for name, value in result.scalars(interval=True).items()}
    for name, (low, high) in result.friction_range.ranges.items():
        columns |= {Column(f"{name} (minimum)", of=name): low, Column(f"{name} (maximum)", of=name): high}
    columns |= {f"points flagged {name}": count for name, count in result.friction_range.flags.items()}
    failed = result.solution.contacts_failed
    columns |= {f"contacts failed {reason_text(reason)}": count for reason, count in failed.items()}
    return Table(tuple(columns), [tuple(columns.values())], name="result", vertical=True)


def remarks_table(results: Sequence[EfficiencyResult]) -> Table:
    """Notes and neglected effects, each once, with the number of results they belong to."""
    counts = Counter(
        (kind, text)
        for result in results
        for kind, texts in (("note", result.notes), ("skipped", result.skipped))
        for text in texts
    )
    rows = [(kind, text, count) for (kind, text), count in counts.items()]
    return Table(("kind", "text", "results"), rows, name="remarks")


def position_table(result: EfficiencyResult) -> Table:
    """One row per mesh position: load, pressure, transmission error, friction, loss, shares of tooth pairs, forces."""
    loads = result.load.positions
    shares = [load.share for load in loads]
    pairs = sorted({pair for share in shares for pair, part in share.items() if part > 0.0})
    columns: dict[Any, Any] = {
        "pinion_angle": result.cycle.pinion_angle,
        "force": [float(load.force.sum()) for load in loads],
        "pairs loaded": [sum(part > 0.0 for part in share.values()) for share in shares],
        "pressure_hertz_max": [float(load.pressure_hertz.max()) for load in loads],
        "transmission_error_loaded": result.cycle.transmission_error,
        "friction_coefficient_mean": friction_along_mesh(result),
        "power_loss": result.cycle.power_loss,
        "power_loss_rolling": result.cycle.power_loss_rolling,
        "transmission_error_unloaded": [load.position.transmission_error for load in loads],
        "pressure_edge": [float(np.max(load.pressure_max, initial=0.0, where=load.at_edge)) for load in loads],
        "points_loaded": [int(np.count_nonzero(load.force > 0.0)) for load in loads],
    }
    columns |= {f"share of pair {pair:+d}": [share.get(pair, 0.0) for share in shares] for pair in pairs}
    if (forces := result.forces) is not None:
        columns["stiffness_mesh"] = forces.stiffness
        for member, way in product(("pinion", "gear"), ("axial", "radial", "tangential")):
            columns[f"force_{way}_{member}"] = getattr(getattr(forces, member), way)
    return Table.from_columns(columns, title="Positions of a pinion pitch.", name="positions")


def point_table(result: EfficiencyResult) -> Table:
    """One row per loaded point: position on the gear, local conditions, friction with its interval and flag, loss."""
    points, friction = result.points, result.friction
    places = ("pair", "face_gear", "height_gear", "face_pinion", "height_pinion", "length")
    columns: dict[Any, Any] = {
        "mesh position": points.position + 1,
        "pinion_angle": result.cycle.pinion_angle[points.position],
        **{name: points.values(result.load.cycle, name) for name in places},
        "force": points.force,
    }
    columns |= {f.name: getattr(points.state, f.name) for f in fields(ContactState)}
    columns |= {name: getattr(points.state, name) for name in _DERIVED}
    columns |= {name: getattr(result.lubrication, name) for name in _LUBRICATION}
    if result.has_strength:
        columns["film_specific"] = result.strength.points_film_specific
    columns |= {
        "friction_coefficient": friction.mu,
        "friction_lower": friction.lower,
        "friction_upper": friction.upper,
        "flag": [FrictionFlag(flag).name.lower() for flag in friction.flag],
        "power_loss": friction.mu * points.force * points.speed_sliding,
    }
    return Table.from_columns(columns, name="points")


def map_table(grid: Grid, names: Sequence[str] = ()) -> Table:
    """All operating points of a map, one per row, with all values of the results or those of `names`."""
    rows = [point.row() for point in grid.points]
    if names:
        rows = [{name: row.get(name) for name in (*grid.axes, *names)} for row in rows]
    return Table.from_records(rows, name="map")


def efficiency_grids(grid: Grid) -> list[Table]:
    """Efficiency over torque (rows) and speed (columns), one table per temperature."""
    values, speed = grid.values(), quantity("speed")
    heads = [speed.text(value) for value in grid.axes["speed"]]
    columns: list[Column | str] = ["torque", *(Column(head, of="efficiency", label=head) for head in heads)]
    tables = []
    for number, kelvin in enumerate(grid.axes["temperature"]):
        celsius = quantity("temperature").to_display(kelvin)
        rows = [(torque, *line) for torque, line in zip(grid.axes["torque"], values[:, :, number], strict=True)]
        title = f"Mesh efficiency at {celsius:.4g} degC."
        note = _outside_note(grid, number)
        tables.append(Table(columns, rows, title, (note,) * bool(note), name=f"efficiency at {celsius:.4g} degC"))
    return tables


def _outside_note(grid: Grid, number: int) -> str:
    """Share of the sliding power outside the range of the friction model at one temperature, with its maximum."""
    share = grid.values("outside_range_share")[:, :, number]
    outside = np.nan_to_num(share)
    if not outside.any():
        return ""
    row, column = np.unravel_index(int(np.argmax(outside)), outside.shape)
    torque = quantity("torque").text(grid.axes["torque"][row])
    speed = quantity("speed").text(grid.axes["speed"][column])
    return (
        f"outside the range of {model_label(grid.results[0].friction_model)}: at most "
        f"{percent(float(outside.max()), 1)} % of the sliding power, at {torque}, {speed}"
    )


def duty_table(cycle: DutyCycle) -> Table:
    """Rows of a duty cycle with the total in the last row."""
    rows = [asdict(row) for row in cycle.rows]
    total: dict[str, Any] = dict.fromkeys(rows[0]) | {"side": "total", "efficiency": cycle.efficiency}
    total |= {name: cycle.total(name) for name in ("hours", *(n for n in rows[0] if n.startswith("energy_")))}
    outside = sum(row.outside_range_share * row.energy_loss for row in cycle.rows) / cycle.total("energy_loss")
    rolling = quantity("energy_loss_rolling").text(cycle.total("energy_loss_rolling"))
    summary = (
        f"efficiency of the cycle {percent(cycle.efficiency)} +- {percent(cycle.efficiency_error, 4)} % "
        f"(numerical error); rolling loss not included, {rolling}; "
        f"{percent(outside, 1)} % of the loss outside the range of the friction model"
    )
    return Table.from_records(
        [*rows, total],
        title=f"{cycle.design}, {cycle.oil}, friction: {model_label(cycle.friction_model)}",
        notes=(inputs_note(cycle.inputs), summary),
        name="duty",
    )
