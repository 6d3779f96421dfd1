"""Report sections of maps and duty cycles."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

from efficiency.conditions.duty import DutyCycle
from efficiency.conditions.grid import Grid
from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.output import tables
from efficiency.output.gear_report import SPIN, design_of, page_sections
from efficiency.output.machine_summary import Units
from efficiency.output.plots_load import is_map, plot_duty, plot_map
from ehl.common.errors import InputError
from ehl.common.sections import Head, Item, MainResult, Medium, Picture, Row, Section, Text
from regression.friction.published_registry import model_label

_MAIN = (
    *("efficiency", "efficiency_error", "power_loss", "friction_coefficient_mean", "pressure_hertz_max"),
    *("outside_range_share", "status", "reason"),
)

_DUTY = (  # of a terminal
    *("side", "torque", "speed", "temperature", "hours", "efficiency", "energy_input", "energy_loss"),
    "outside_range_share",
)


def map_sections(grid: Grid, medium: Medium, units: Units = "metric") -> list[Section]:
    """Sections of a grid; over torque, speed and temperature the page also has one point in detail."""
    if not grid.results:
        raise InputError("report", grid.reason, "a grid with a result")
    first = grid.results[0]
    title = f"{first.design}, {first.side}: map, friction: {model_label(first.friction_model)}"
    if medium == "files":
        return [Section("", [Head(title), *tables.map_tables(grid)])]
    if medium == "terminal":
        skipped = dict.fromkeys(text for result in grid.results for text in result.skipped)
        below: list[Item] = [tables.grid_notes(grid), *(Text(f"neglected: {text}") for text in skipped)]
        below += [Text(grid.interpolation)] if grid.interpolation else []
        return [Section("", [*(tables.efficiency_grids(grid) if is_map(grid) else [tables.map_table(grid)]), *below])]
    if is_map(grid):
        found = page_sections(nearest_point(grid), grid, units)
        # only the figures of the map are written as files
        return [found[0], found[1], *(Section(part.title, [_unnamed(x) for x in part.items]) for part in found[2:])]
    lines = Picture(partial(plot_map, grid), "Mesh efficiency over the axes.", "efficiency")
    return [
        Section("", [Head(title, footer=SPIN), tables.grid_notes(grid)]),
        Section("Efficiency", [lines, tables.map_table(grid, _MAIN)]),
    ]


def _unnamed(item: Item) -> Item:
    if isinstance(item, Row):
        return Row([_unnamed(inner) for inner in item.items])
    return replace(item, name="") if isinstance(item, Picture) else item


def nearest_point(grid: Grid) -> EfficiencyResult:
    """The result of a map nearest to the operating point of the design file, converged if possible."""
    usable = [result for result in grid.results if result.status == "converged"] or list(grid.results)
    operation = design_of(usable[0]).operation

    def distance(result: EfficiencyResult) -> float:
        at = result.conditions
        torque, speed = abs(at.torque / operation.torque - 1.0), abs(at.speed / operation.speed - 1.0)
        return torque + speed + abs(at.temperature - operation.temperature) / 50.0

    return min(usable, key=distance)


def duty_sections(duty: DutyCycle, medium: Medium, units: Units = "metric") -> list[Section]:
    """Sections of a duty cycle."""
    title = f"{duty.design}: duty cycle, friction: {model_label(duty.friction_model)}"
    if medium == "files":
        return [Section("", [Head(title), tables.duty_table(duty), tables.remarks_table(duty.results)])]
    if medium == "terminal":
        unlike = [] if all(result.status == "converged" for result in duty.results) else ["status", "reason"]
        return [Section("", [tables.duty_table(duty).select([*_DUTY, *unlike]), tables.duty_notes(duty)])]
    inputs = duty.inputs
    known = [(f"±\N{NO-BREAK SPACE}{tables.percent(duty.efficiency_error, 4)} %", "numerical error")]
    if inputs.low < inputs.high:
        interval = f"{tables.percent(inputs.low, 2)} to {tables.percent(inputs.high, 2)} %"
        known.insert(0, (interval, f"{tables.percent(inputs.level, 0)} % interval from uncertain inputs"))
    value = f"{tables.percent(duty.efficiency, 2)} %" if math.isfinite(duty.efficiency) else "no result"
    answer = MainResult(value, "efficiency of the cycle", known)
    energy = Picture(partial(plot_duty, duty), "Energy loss at each operating point.", "duty")
    return [
        Section("", [Head(title, footer=SPIN), answer, tables.duty_notes(duty)]),
        Section("Energies", [energy, replace(tables.duty_table(duty), title="")]),
    ]
