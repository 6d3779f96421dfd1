"""Report sections of one operating point (load, lubrication, friction, loss), of a map and of a duty cycle."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from efficiency.conditions.duty import DutyCycle
from efficiency.conditions.grid import Grid
from efficiency.cylindrical_gears.design import CylindricalDesign
from efficiency.design.design import Design, FlankSurfaceInput, MemberInput, PairDesign
from efficiency.geometry.design_drawing import design_drawing
from efficiency.geometry.pair_geometry import geometry_notes
from efficiency.loss.efficiency import measured_states
from efficiency.loss.efficiency_result import EfficiencyResult, pair_notes
from efficiency.output import plots_flank, plots_load, tables
from efficiency.output.flank_map import FlankMap
from efficiency.output.geometry_report import AXIAL_SECTION, misalignment_text
from efficiency.output.machine_summary import Units, settings_tables
from efficiency.output.plots_geometry import blank_figure
from ehl.common.data import reason_text
from ehl.common.errors import InputError
from ehl.common.quantities import quantity
from ehl.common.sections import (
    Folded,
    Head,
    Item,
    KeyFigures,
    MainResult,
    Medium,
    Notes,
    Picture,
    Row,
    Section,
    Text,
    picture,
)
from ehl.common.table import Table
from ehl.fluid.pressure_viscosity import alpha_of
from ehl.surface.finish import default_correlation_length
from ehl.uncertainty.result import plot_sources
from regression.friction.published_registry import model_label

SPIN = "Churning, windage and bearing losses are not included."


def gear_sections(result: EfficiencyResult, medium: Medium, units: Units = "metric") -> list[Section]:
    """Sections of one operating point; `units` apply to the tables of the design."""
    if medium == "page":
        return page_sections(result, None, units)
    if medium == "files":
        design = design_of(result) if result.case.mesh else None
        drawing = [design_drawing(design).table(units)] if isinstance(design, Design) else []
        own = [result.inputs.table()] if result.inputs.sources else []
        own.append(tables.remarks_table([result]))
        own += [result.strength.table(), result.strength.root_table()] if result.has_strength else []
        points = [tables.position_table(result), tables.point_table(result)]
        return [Section("", [Head(_title(result)), tables.result_table(result), *own, *points, *drawing])]
    strength = [replace(result.strength.table(), notes=result.strength.notes)] if result.has_strength else []
    inputs = [] if result.own_inputs is None else [result.own_inputs.table()]
    notes = Notes(pair_notes(tables.result_notes(result)))
    return [Section("", [tables.efficiency_table(result), notes, *strength, *inputs])]


# main figures of the results
plot_gear, plot_map, plot_duty = plots_load.plot_friction_and_loss, plots_load.plot_map, plots_load.plot_duty


def design_of(result: EfficiencyResult) -> PairDesign:
    """The design of a result."""
    if result.case.mesh is None:
        raise InputError("report", "a result without its mesh", "a result of `GearPair`, `Mesh` or `LoadedMesh`")
    design: PairDesign = result.case.mesh.design
    return design


def _title(result: EfficiencyResult) -> str:
    return f"{tables.operating_point(result)}, friction: {model_label(result.friction_model)}"


def _fields(flank: FlankMap, **captions: str) -> list[Picture]:
    """Fields over the gear flank."""
    return [picture(name, caption, plots_flank.field_figure, flank, name) for name, caption in captions.items()]


def load_figures(flank: FlankMap) -> list[Picture]:
    """Figures of the loaded flanks."""
    text = (
        "Contact pattern under load: Hertz pressure over the loaded part of the flank in the mesh cycle. Orange: "
        "contact lines at the position of maximum pressure, with a width in proportion to the load per length."
    )
    of_pinion = "Contact pattern under load on the pinion."
    return [
        picture("contact_pattern_gear", text, plots_flank.contact_figure, flank),
        picture("contact_pattern_pinion", of_pinion, plots_flank.contact_figure, flank, "pinion"),
        *_fields(
            flank,
            pressure_hertz="Hertz pressure on the gear flank; the outline encloses the loaded part.",
            load_per_length="Load per length of contact line.",
        ),
    ]


def loss_figures(flank: FlankMap) -> list[Picture]:
    """Lubrication, friction and loss over the gear flank."""
    text = (
        "Sliding velocity in the projection of the flank. In a hypoid gear the lengthwise component does not vanish at "
        "the pitch cone (dash-dotted line)."
    )
    return [
        picture("sliding", text, plots_flank.sliding_figure, flank),
        *_fields(
            flank,
            slide_to_roll_total="Magnitude of the sliding vector over the entrainment speed.",
            film_ratio="Smooth isothermal film over the composite roughness Rq.",
            friction_coefficient=f"Friction coefficient of the model: {model_label(flank.result.friction_model)}.",
            temperature_flash="Maximum surface temperature: bulk temperature plus flash temperature.",
            loss_density="Mean power loss per projected area; its integral plus the loss at edges is the loss.",
        ),
    ]


def mesh_figures(result: EfficiencyResult) -> list[Picture]:
    """Figures over the mesh cycle."""
    caption = "Transmission error without load and under load, each about its mean."
    about_loss = "Friction coefficient and power loss at each position of a pinion pitch."
    return [
        picture("load_sharing", "Share of the torque on one tooth pair.", plots_load.plot_load_sharing, result),
        picture("pair_load", "Normal force and maximum pressure of one tooth pair.", plots_load.plot_pair_load, result),
        picture("transmission_error", caption, plots_load.plot_transmission_error, result),
        picture("friction_and_loss", about_loss, plots_load.plot_friction_and_loss, result),
    ]


def _force_items(result: EfficiencyResult) -> list[Item]:
    """Mesh stiffness and shaft forces, folded."""
    if result.forces is None:
        return []
    caption = (
        "Mesh stiffness: derivative of the pinion torque by the pinion rotation. Forces of the mesh on the shafts: "
        "axial positive away from the crossing point, radial away from the other member, tangential in the direction "
        "of the torque; the values are in the table of the positions."
    )
    return [Folded("Mesh stiffness and shaft forces", [picture("forces", caption, plots_load.plot_forces, result)])]


def _strength_figures(flank: FlankMap) -> Iterator[Picture]:
    """Root stress and micropitting."""
    result = flank.result
    if result.strength.pinion is not None or result.strength.gear is not None:
        caption = "Maximum tensile stress of the root fillets, over the roll angle of a tooth pair and along the face."
        yield picture("root_stress", caption, plots_load.plot_root_stress, result)
    if flank.drawable:
        caption = "Film thickness over the mean Ra of both flanks: micropitting begins at its minimum."
        yield from _fields(flank, film_specific=caption)


def page_sections(result: EfficiencyResult, grid: Grid | None, units: Units) -> list[Section]:
    """Sections of the page of one operating point; for a map, its sections and one of its points in detail."""
    design, placed = design_of(result), ""
    flank: FlankMap | None = None
    of_design: Sequence[str] = ()
    if isinstance(design, Design):
        flank = FlankMap.of(design.flanks(), result)
        of_design = geometry_notes(design, "coast" if result.side == "coast" else "drive")
        placed, of_teeth = f"{misalignment_text(design).capitalize()}. ", _design_items(design, units)
    else:
        of_teeth = [Table(("quantity", "pinion / gear"), cast(CylindricalDesign, design).rows())]
    source = f"{placed}Source of the design: {design.source or 'not stated'}"
    head = Head(f"Gear efficiency: {design.name}", source, SPIN)
    on_tooth: list[Section] = []
    if flank is not None and flank.drawable:
        on_tooth = [
            Section("Contact under load", [Row(load_figures(flank))]),
            Section("Lubrication, friction and loss on the tooth", [Row(loss_figures(flank))]),
        ]
    figures = replace(tables.efficiency_table(result), title="", notes=())
    ranges = replace(tables.range_table(result), title="")
    positions = Folded("Positions of a pinion pitch", [tables.position_table(result)])
    return [
        Section("", [head, _inputs_table(result, design), *_headline(result, of_design, grid)]),
        *([Section("Efficiency over torque, speed and temperature", _map_items(grid, result))] if grid else []),
        *on_tooth,
        *([Section("Uncertainty of the inputs", _input_items(result))] if result.inputs.sources else []),
        *([Section("Strength", _strength_items(result, flank))] if flank is not None else []),
        Section("Mesh cycle", [Row(mesh_figures(result)), *_force_items(result)]),
        Section("Numerical results", [Row([figures, ranges]), positions]),
        Section("Design", of_teeth),
        Section("Method", _model_items(result)),
    ]


def _inputs_table(result: EfficiencyResult, design: PairDesign) -> Table:
    """Pair, operating point, oil at its temperature and at the teeth, finish, friction model."""
    pair = design.name
    if isinstance(design, Design):
        pinion, gear = design.pinion.blank, design.gear.blank
        pair += f", {pinion.teeth} x {gear.teeth}, face width {1e3 * gear.face_width:.4g} mm"
        if design.assembly.hypoid_offset:
            pair += f", offset {1e3 * design.assembly.hypoid_offset:.4g} mm"
    at, alpha, viscosity = result.conditions, quantity("pressure_viscosity"), quantity("viscosity_inlet")
    warmest = float(np.max(result.points.state.temperature_oil, initial=at.temperature))
    texts = []
    for kelvin, where in ((at.temperature, ""), (warmest, " at the teeth")):
        lubricant = result.case.card.at(kelvin)
        texts.append(
            f"{quantity('temperature').text(kelvin)}{where}: {viscosity.text(lubricant.viscosity_inlet)}, "
            f"alpha* {alpha.text(float(alpha_of(lubricant.pressure_law, 'star')))}"
        )
    finishes = []
    for name, member in (("pinion", design.pinion), ("gear", design.gear)):
        finish = member.surface_finish()
        made = "" if finish is None else f" {finish.name}, {finish.state.replace('_', ' ')},"
        finishes.append(f"{name}{made} Rq {1e6 * member.roughness_rms:.3g} um")
    rows = [
        ("pair", pair),
        ("operating point", f"{result.side} flanks, {tables.operating_state(result)}, {at.driver} driving"),
        ("oil", f"{at.oil}; {'; '.join(dict.fromkeys(texts))}"),
        ("finish", "; ".join(finishes)),
        ("friction", model_label(result.friction_model)),
    ]
    return Table(("input", "value"), rows)


def _headline(result: EfficiencyResult, of_design: Sequence[str], grid: Grid | None) -> list[Item]:
    film = result.lubrication.film_ratio
    with_rolling, loss = tables.percent(result.efficiency_with_rolling, 2), quantity("power_loss")
    tiles = [
        (loss.text(result.power_loss), f"sliding loss of {result.power_input / 1e3:.4g} kW"),
        (
            loss.text(result.power_loss_rolling),
            f"rolling loss, not included in the efficiency; with it {with_rolling} %",
        ),
        (f"{result.friction_coefficient_mean:.4f}", "mean friction coefficient"),
        (f"{result.pressure_hertz_max / 1e9:.2f} GPa", "maximum Hertz pressure"),
    ]
    if np.isfinite(film).any():
        tiles.append((f"{np.nanmin(film):.2g}", "minimum film ratio"))
    outside = f"of the sliding power outside the range of {model_label(result.friction_model)}"
    tiles.append((f"{tables.percent(result.outside_range_share, 1)} %", outside))
    said = tables.result_notes(result, of_design, tables.operating_state(result) if grid else "")
    cases = 1
    if grid is not None:
        cases = len(grid.points)
        own = {text for _, text in said}
        said += [pair for pair in tables.said_of_grid(grid) if pair[1] not in own]
    return [answer(result, grid), KeyFigures(tiles), Notes(pair_notes(said), cases)]


def answer(result: EfficiencyResult, grid: Grid | None = None) -> MainResult:
    """Efficiency of one operating point with its interval and error; for a map also its range."""
    if not math.isfinite(result.efficiency):
        return MainResult("no result", f"mesh efficiency: {reason_text(result.reason)}")
    known = []
    inputs = result.inputs
    if inputs.low < inputs.high:
        most = ", ".join(f"{name} ±{tables.percent(half, 1)}" for name, half in list(inputs.groups.items())[:3])
        interval = f"{tables.percent(inputs.low, 1)} to {tables.percent(inputs.high, 1)} %"
        level = tables.percent(inputs.level, 0)
        known.append((interval, f"{level} % interval from uncertain inputs; largest contributions {most} points"))
    else:
        known.append(("no interval", "; ".join(inputs.notes) or "no input of this friction model is uncertain"))
    if math.isfinite(result.efficiency_error):
        error = 100.0 * result.efficiency_error
        known.append((f"±\N{NO-BREAK SPACE}{error:.1g} %", "numerical error: positions, contact lines, equilibrium"))
    label = f"mesh efficiency, {model_label(result.friction_model)}"
    if grid is not None:
        values = grid.values()
        ends = f"{tables.percent(float(np.nanmin(values)), 2)} to {tables.percent(float(np.nanmax(values)), 2)} %"
        known.append((ends, f"range over the {len(grid.points)} points of the map"))
        label = f"mesh efficiency at {tables.operating_state(result)}, {model_label(result.friction_model)}"
    return MainResult(f"{tables.percent(result.efficiency, 2)} %", label, known)


def _map_items(grid: Grid, shown: EfficiencyResult) -> list[Item]:
    return [
        Row(plots_load.map_figures(grid)),
        *tables.efficiency_grids(grid),
        *([Text(f"{grid.interpolation}.")] if grid.interpolation else []),
        Text(f"The following sections refer to one point of the map, {tables.operating_point(shown)}."),
    ]


def _model_items(result: EfficiencyResult) -> list[Item]:
    size, at = result.solution, result.conditions
    return [
        Text(f"Neglected: {'; '.join(result.skipped)}."),
        Text(
            f"{size.positions} positions of the mesh, {size.points_per_line} points per contact line, "
            f"{size.points_loaded} loaded points; loads from {at.load_balance} equilibrium, {at.driver} "
            f"driving. Computing friction and loss took {result.seconds:.2g} s."
        ),
    ]


def _strength_items(result: EfficiencyResult, flank: FlankMap) -> list[Item]:
    strength = result.strength
    table = replace(strength.table(), notes=())
    assumed = Table(("assumption",), [(note,) for note in strength.notes])
    return [Row([*_strength_figures(flank), table]), Folded("Assumptions on the strength", [assumed])]


def _input_items(result: EfficiencyResult) -> list[Item]:
    caption = "Change of the efficiency by each single input; the numerical error is not included."
    bars = picture("", caption, plot_sources, result.inputs)
    known, share = measured_states(), result.friction_range.measured_share
    text = (
        f"{tables.percent(share, 1)} % of the sliding power lies within the local conditions of measured gears "
        f"({known['name']}; {known['states']} states), whose computed friction deviates by "
        f"{100 * known['bias']:+.0f} % with a standard deviation of {100 * known['deviation']:.0f} %. "
        "The rest is not validated by measured gears."
    )
    return [bars, Text(text), Folded("Sources of the spreads", [result.inputs.table()])]


def _finish(member: MemberInput, texture: FlankSurfaceInput) -> tuple[str, ...]:
    """Finish, Rq, correlation length and its ratio, from the design or the finish."""
    finish, rms = member.surface_finish(), member.roughness_rms
    length, ratio = float(default_correlation_length(rms)), 1.0
    if finish is not None and rms > 0.0:
        length, ratio = float(finish.length_at(rms)), finish.lay_ratio.value
    how = "-" if finish is None else f"{finish.name}, {finish.state.replace('_', ' ')}"
    length = length if texture.correlation_length is None else texture.correlation_length
    ratio = ratio if texture.peklenik_number is None else texture.peklenik_number
    return how, f"{rms * 1e6:.3g}", f"{length * 1e6:.3g}", f"{ratio:.3g}"


def _design_items(design: Design, units: Units) -> list[Item]:
    surface = [
        (name, member.material, *_finish(member, design.surface))
        for name, member in (("pinion", design.pinion), ("gear", design.gear))
    ]
    waves = ("correlation length [µm]", "correlation length along over across the lay [-]")
    heads = ("member", "material", "finish", "roughness Rq [µm]", *waves)
    return [
        picture("", AXIAL_SECTION, blank_figure, design),
        Table(heads, surface),
        Folded(
            "Gear data for drawings, cutters and machine settings",
            [design_drawing(design).table(units), *settings_tables(design, units)],
        ),
    ]


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
    over = tables.efficiency_grids(grid) if plots_load.is_map(grid) else []
    if medium == "files":
        return [Section("", [Head(title), tables.map_table(grid), *over, tables.remarks_table(grid.results)])]
    if medium == "terminal":
        skipped = dict.fromkeys(text for result in grid.results for text in result.skipped)
        below: list[Item] = [tables.grid_notes(grid), *(Text(f"neglected: {text}") for text in skipped)]
        below += [Text(grid.interpolation)] if grid.interpolation else []
        return [Section("", [*(over or [tables.map_table(grid)]), *below])]
    if plots_load.is_map(grid):
        found = page_sections(nearest_point(grid), grid, units)
        # only the figures of the map are written as files
        return [found[0], found[1], *(Section(part.title, [_unnamed(x) for x in part.items]) for part in found[2:])]
    lines = picture("efficiency", "Mesh efficiency over the axes.", plots_load.plot_map, grid)
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
    energy = picture("duty", "Energy loss at each operating point.", plots_load.plot_duty, duty)
    return [
        Section("", [Head(title, footer=SPIN), answer, tables.duty_notes(duty)]),
        Section("Energies", [energy, replace(tables.duty_table(duty), title="")]),
    ]
