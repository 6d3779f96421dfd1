"""A gear run as figures and as one HTML page for print: load, lubrication, friction and loss of one operating point,
efficiency over several."""

from __future__ import annotations

import math
import platform
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from efficiency.geometry.pair_geometry import geometry_notes
from efficiency.loss.notes import pair_notes
from efficiency.output import plots_flank as flank_plots
from efficiency.output.flank_map import FlankMap
from efficiency.output.geometry_tables import blank_table, misalignment_text, setting_tables, words
from efficiency.output.machine_summary import FLANKS, Units, summary_rows
from efficiency.output.notes import result_notes
from efficiency.output.plots_geometry import blank_figure
from efficiency.output.plots_load import (
    plot_friction_and_loss,
    plot_load_sharing,
    plot_pair_load,
    plot_root_stress,
    plot_transmission_error,
)
from efficiency.output.plots_map import is_map, map_figures
from efficiency.output.tables import (
    efficiency_grids,
    efficiency_table,
    operating_point,
    operating_state,
    percent,
    position_table,
    range_table,
)
from ehl import __version__
from ehl.common.errors import InputError
from ehl.common.pages import write_report
from ehl.common.sections import Folded, Item, KeyFigures, MainResult, Notes, Picture, Row, Section, Text
from ehl.common.table import Table
from ehl.surface.finish import default_correlation_length
from regression.friction.published_registry import model_label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from efficiency.conditions.grid import Grid
    from efficiency.design.design import Design, FlankSurfaceInput, MemberInput
    from efficiency.loss.efficiency_result import EfficiencyResult

Named = tuple[str, "Figure", str]


def load_figures(flank: FlankMap) -> Iterator[Named]:
    """(name, figure, caption) of what the load does to the flanks."""
    yield (
        "contact_pattern_gear",
        flank_plots.contact_figure(flank),
        "Contact pattern under load: Hertz pressure where the flank carries load in the mesh cycle. Orange: the "
        "lines in contact where the pressure is greatest, as wide as their load per length.",
    )
    yield "contact_pattern_pinion", flank_plots.contact_figure(flank, "pinion"), "The same on the pinion."
    for field, caption in (
        (flank_plots.PRESSURE, "Hertz pressure on the gear flank; outlined: what carries load."),
        (flank_plots.LOAD, "Load per length of contact line."),
    ):
        yield field.name, flank_plots.field_figure(flank, field), caption


def loss_figures(flank: FlankMap) -> Iterator[Named]:
    """(name, figure, caption) of lubrication, friction and loss over the gear flank."""
    yield (
        "sliding",
        flank_plots.sliding_figure(flank),
        "Sliding velocity in the projection of the flank; along a tooth of a hypoid gear it does not vanish at the "
        "pitch cone (dash-dotted).",
    )
    for field, caption in (
        (flank_plots.SLIDE_TO_ROLL, "Length of the sliding vector over the entrainment speed."),
        (flank_plots.FILM_RATIO, "Smooth isothermal film over the composite roughness Rq."),
        (flank_plots.FRICTION, f"Friction coefficient of the model: {model_label(flank.result.friction_model)}."),
        (flank_plots.FLASH, "Bulk temperature and flash."),
        (
            flank_plots.LOSS,
            "Mean power loss per projected area of the flank; its integral, with what edges lose, is the loss.",
        ),
    ):
        yield field.name, flank_plots.field_figure(flank, field), caption


def mesh_figures(result: EfficiencyResult) -> Iterator[Named]:
    """(name, figure, caption) of what changes as the pair goes through the mesh."""
    yield "load_sharing", plot_load_sharing(result), "Share of the torque one tooth pair carries."
    yield "pair_load", plot_pair_load(result), "Normal force and greatest pressure of one tooth pair."
    yield (
        "transmission_error",
        plot_transmission_error(result),
        "Transmission error without load and under load, each less its mean.",
    )
    yield (
        "friction_and_loss",
        plot_friction_and_loss(result),
        "Friction coefficient and power loss at each position of a pinion pitch.",
    )


def strength_figures(flank: FlankMap) -> Iterator[Named]:
    """(name, figure, caption) of root stress and micropitting; none of a result without its pair."""
    result = flank.result
    if result.source is None:
        return
    if result.strength.pinion is not None or result.strength.gear is not None:
        yield (
            "root_stress",
            plot_root_stress(result),
            "Greatest tensile stress of the root fillets, over the roll of a tooth pair and along the face.",
        )
    if flank.drawable:
        field = flank_plots.FILM_SPECIFIC
        caption = "Film over the mean Ra of both flanks: micropitting begins where it is least."
        yield field.name, flank_plots.field_figure(flank, field), caption


def gear_figures(design: Design, result: EfficiencyResult) -> list[Named]:
    """(name, figure, caption) of all figures of one operating point, friction and loss first."""
    flank = FlankMap.of(design.flanks(), result)
    on_tooth = [*load_figures(flank), *loss_figures(flank)] if flank.drawable else []
    return [*reversed(list(mesh_figures(result))), *on_tooth, *strength_figures(flank)]


def write_gear_report(
    design: Design,
    result: EfficiencyResult,
    path: Path,
    grid: Grid | None = None,
    units: Units = "metric",
    more: Sequence[Table] = (),
) -> Path:
    """One self-contained page of one operating point; with a map, of the map and one of its points in detail.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    flank = FlankMap.of(design.flanks(), result)
    if grid is not None and not is_map(grid):
        raise InputError("report", ", ".join(grid.axes), "a grid over torque, speed and temperature")
    of_design = geometry_notes(design, "coast" if result.side == "coast" else "drive")
    on_tooth = [
        Section("Contact under load", [_pictures(load_figures(flank))]),
        Section("Lubrication, friction and loss on the tooth", [_pictures(loss_figures(flank))]),
    ]
    sections = [
        _headline(result, of_design, grid),
        *([Section("Efficiency over torque, speed and temperature", _map_blocks(grid, result))] if grid else []),
        *(on_tooth if flank.drawable else ()),
        *([Section("Uncertainty of the inputs", _input_blocks(result))] if result.inputs.sources else []),
        *([Section("Strength", _strength_blocks(result, flank))] if result.source else []),
        Section("Over the mesh", [_pictures(mesh_figures(result))]),
        Section("Results in numbers", _number_blocks(result, more)),
        Section("Design", _design_blocks(design, units)),
        Section("How it was computed", _model_blocks(result)),
    ]
    return write_report(
        path,
        f"Gear efficiency: {design.name}",
        f"{operating_point(result)}, friction: {model_label(result.friction_model)}. "
        f"{misalignment_text(design).capitalize()}. "
        f"Source of the design: {design.source or 'not stated'}",
        sections,
        f"mixed-ehl {__version__}, Python {platform.python_version()}. Churning, windage and bearing losses are not "
        "part of any figure here.",
    )


def nearest_point(design: Design, grid: Grid) -> EfficiencyResult:
    """The result of a map that lies next to the operating point of the design file; one that did not fail if any."""
    operation = design.operation
    usable = [result for result in grid.results if result.status == "converged"] or list(grid.results)

    def distance(result: EfficiencyResult) -> float:
        return (
            abs(result.torque / operation.torque - 1.0)
            + abs(result.speed / operation.speed - 1.0)
            + abs(result.temperature - operation.temperature) / 50.0
        )

    return min(usable, key=distance)


def _headline(result: EfficiencyResult, of_design: Sequence[str], grid: Grid | None) -> Section:
    film = result.lubrication.film_ratio
    tiles = [
        (f"{result.power_loss:.4g} W", f"friction loss of {result.power_input / 1e3:.4g} kW"),
        (f"{result.friction_coefficient_mean:.4f}", "mean friction coefficient"),
        (f"{result.pressure_max / 1e9:.2f} GPa", "greatest Hertz pressure"),
    ]
    if np.isfinite(film).any():
        tiles.append((f"{np.nanmin(film):.2g}", "minimum film ratio"))
    tiles.append((f"{percent(result.outside_range_share, 1)} %", f"of the sliding power outside {_range(result)}"))
    said = result_notes(result, of_design, operating_state(result) if grid else "")
    cases = 1
    if grid is not None:
        cases = len(grid.points)
        own = {text for _, text in said}
        for other in grid.results:
            said += [pair for pair in result_notes(other, (), operating_state(other)) if pair[1] not in own]
    return Section("", [answer(result, grid), KeyFigures(tiles), Notes(pair_notes(said), cases)])


def answer(result: EfficiencyResult, grid: Grid | None = None) -> MainResult:
    """The efficiency of one operating point with what is known of it; of a map also its range."""
    if not math.isfinite(result.efficiency):
        return MainResult("no answer", f"mesh efficiency: {result.reason}")
    known = []
    inputs = result.inputs
    if inputs.low < inputs.high:
        most = ", ".join(f"{name} {percent(half, 1)}" for name, half in list(inputs.groups.items())[:3])
        interval = f"{percent(inputs.low, 1)} to {percent(inputs.high, 1)} %"
        known.append((interval, f"{percent(inputs.level, 0)} % interval by uncertain inputs, most by {most} points"))
    else:
        known.append(("no interval", "; ".join(inputs.notes) or "no input of this friction model is uncertain"))
    if math.isfinite(result.efficiency_error):
        error = 100.0 * result.efficiency_error
        known.append((f"±\N{NO-BREAK SPACE}{error:.1g} %", "error of the solution: mesh, lines, equilibrium"))
    label = f"mesh efficiency, {model_label(result.friction_model)}"
    if grid is not None:
        values = grid.values()
        ends = f"{percent(float(np.nanmin(values)), 2)} to {percent(float(np.nanmax(values)), 2)} %"
        known.append((ends, f"over the {len(grid.points)} points of the map"))
        label = f"mesh efficiency at {operating_state(result)}, {model_label(result.friction_model)}"
    return MainResult(f"{percent(result.efficiency, 2)} %", label, known)


def _range(result: EfficiencyResult) -> str:
    return f"the range of {model_label(result.friction_model)}"


def _map_blocks(grid: Grid, shown: EfficiencyResult) -> list[Item]:
    return [
        _pictures(map_figures(grid)),
        *efficiency_grids(grid),
        Text(f"The sections below are of one point of it, {operating_point(shown)}."),
    ]


def _number_blocks(result: EfficiencyResult, more: Sequence[Table]) -> list[Item]:
    return [
        replace(efficiency_table(result), title="", notes=()),
        *more,
        range_table(result),
        Folded("Positions of a pinion pitch", [position_table(result)]),
    ]


def _model_blocks(result: EfficiencyResult) -> list[Item]:
    return [
        Table(("left out", "because or instead"), [_reason(text) for text in result.skipped]),
        Text(
            f"{result.positions} positions of the mesh, {result.points_per_line} points per contact line, "
            f"{result.points_loaded} loaded points; loads by {result.load_balance} equilibrium, {result.driver} "
            f"driving. Loss and friction of the operating point took {result.seconds:.2g} s."
        ),
    ]


def _reason(text: str) -> tuple[str, str]:
    what, _, why = text.partition(": ")
    return what, why


def _strength_blocks(result: EfficiencyResult, flank: FlankMap) -> list[Item]:
    strength = result.strength
    table = replace(strength.table(), notes=())
    assumed = Table(("assumed",), [(note,) for note in strength.notes])
    return [_pictures(strength_figures(flank)), table, Folded("What is assumed of the strength", [assumed])]


def _input_blocks(result: EfficiencyResult) -> list[Item]:
    return [
        Picture(result.inputs.plot(), "What each input alone does to the efficiency; the error of the solution apart."),
        Folded("Where each spread comes from", [result.inputs.table()]),
    ]


def _pictures(figures: Iterator[Named]) -> Row:
    return Row([Picture(figure, caption) for _, figure, caption in figures])


def _finish(member: MemberInput, texture: FlankSurfaceInput) -> tuple[str, ...]:
    """Finish, Rq, and what the design or the finish says of the waves."""
    finish, rms = member.surface_finish(), member.roughness_rms
    length, ratio = float(default_correlation_length(rms)), 1.0
    if finish is not None and rms > 0.0:
        length, ratio = finish.with_rms(rms).correlation_length.value, finish.lay_ratio.value
    how = "-" if finish is None else f"{finish.name}, {finish.state.replace('_', ' ')}"
    length = length if texture.correlation_length is None else texture.correlation_length
    ratio = ratio if texture.peklenik_number is None else texture.peklenik_number
    return how, f"{rms * 1e6:.3g}", f"{length * 1e6:.3g}", f"{ratio:.3g}"


def _design_blocks(design: Design, units: Units) -> list[Item]:
    rows = summary_rows(design, units)
    flanks = (
        Table((words(part), "unit", *FLANKS), lines, "Settings that are zero for all four flanks are not listed.")
        for part, lines in setting_tables(rows).items()
    )
    surface = [
        (name, member.material, *_finish(member, design.surface))
        for name, member in (("pinion", design.pinion), ("gear", design.gear))
    ]
    waves = ("correlation length [µm]", "its ratio along the marks to across")
    heads = ("member", "material", "finish", "roughness Rq [µm]", *waves)
    return [
        Picture(blank_figure(design), "Axial section of both members in the plane of the axes."),
        Table(("quantity", "unit", "pinion", "gear"), blank_table(rows)),
        Table(heads, surface),
        *flanks,
    ]
