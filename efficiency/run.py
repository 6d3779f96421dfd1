"""What the command line calls: a design file and names in, results out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import cos
from pathlib import Path
from typing import Any

from efficiency.contact.gear_flanks import Side
from efficiency.design.design import OPERATION_LIMITS, CoolingInput, Design, MemberInput, Misalignment, load_design
from efficiency.gear_mesh import GearMesh, gear_mesh
from efficiency.loss.compare import Comparison, compare_models
from efficiency.loss.duty import DutyRow
from efficiency.loss.duty_cycle import DutyCycle, duty_cycle
from efficiency.loss.efficiency import LoadedGrids, MeshGrids, load_grids, mesh_efficiency
from efficiency.loss.friction_equilibrium import load_grids_with_friction
from efficiency.loss.heat_balance import HeatBalance, balance_heat, wetted_heat_transfer
from efficiency.loss.kinematics import TEXTURE, Driver, Operation
from efficiency.loss.map import EfficiencyMap, efficiency_map
from efficiency.loss.parameter_map import OPERATION_AXES, ParameterMap, Place, parameter_map
from efficiency.loss.result import EfficiencyResult
from efficiency.loss.uncertainty import EfficiencyUncertainty, UncertainInputs, efficiency_uncertainty
from efficiency.ltca.external_load import read_load
from ehl.fluid.oil import Oil
from ehl.io.errors import InputError
from ehl.io.validation import value_range_of
from regression.formula import friction_model, shipped_formulas
from regression.friction.models import FrictionModel

POSITIONS, POINTS_PER_LINE = 24, 31
# beside the formulas shipped for the oil in use
DEFAULT_MODELS = (
    "constant:0.05",
    "xu_kahraman_2007",
    "benedict_kelley_1961",
    "schlenk_1994",
    "arana_2019",
    "ehl:smooth",
    "ehl",
)


@dataclass(frozen=True)
class Conditions:
    """Operating point; what is None comes from the design file.

    Parameters
    ----------
    torque : float, optional
        At the pinion shaft [N m]; here and below, within the range of the design file.
    speed : float, optional
        Of the pinion [rad/s].
    temperature_oil : float, optional
        [K].
    oil : str, optional
        Name of an oil card.
    driver : {"pinion", "gear"}, optional
        Member the power comes from.
    """

    torque: float | None = None
    speed: float | None = None
    temperature_oil: float | None = None
    oil: str | None = None
    driver: Driver | None = None


def resolve_design(design: Design | str | Path) -> Design:
    """A design, or the one of that name or file."""
    return design if isinstance(design, Design) else load_design(design)


def resolve_friction(friction: FrictionModel | str, design: Design) -> FrictionModel:
    """A friction model, or the one of that name: solved contacts (``ehl``...) or any of `regression.friction_model`."""
    if not isinstance(friction, str):
        return friction
    if friction.partition(":")[0] == "ehl":
        from efficiency.loss.ehl_friction import ehl_friction

        return ehl_friction(friction, (design.pinion.elastic_material(), design.gear.elastic_material()))
    return friction_model(friction)


def run_gear(
    design: Design | str | Path,
    friction: FrictionModel | str = "constant:0.05",
    conditions: Conditions = Conditions(),
    *,
    side: Side = "drive",
    positions: int = POSITIONS,
    points_per_line: int = POINTS_PER_LINE,
    friction_in_equilibrium: bool = False,
    load_from: Path | None = None,
) -> EfficiencyResult:
    """Efficiency of a pair at one operating point.

    Parameters
    ----------
    design : Design, str or Path
        A design, the name of a shipped one, or a design file.
    friction : FrictionModel or str
        Friction model or its name.
    conditions : Conditions
        What differs from the operating point of the design file.
    side : {"drive", "coast"}
        Which flanks carry the load.
    positions, points_per_line : int
        Resolution; the result states the error.
    friction_in_equilibrium : bool
        Let the friction forces take part in carrying the torque.
    load_from : Path, optional
        CSV file with the load distribution of another program (`efficiency.ltca.external_load`).

    Raises
    ------
    InputError
        A value that cannot be used, a torque of the wrong sign among them.
    ConvergenceError
        The flanks do not exist or do not mesh, or friction takes the whole torque.
    """
    design = resolve_design(design)
    model = resolve_friction(friction, design)
    torque, operation, oil = _operating_point(design, conditions)
    geared = gear_mesh(design, side, positions, points_per_line)
    if load_from is not None:
        if friction_in_equilibrium:
            raise InputError("load_from", str(load_from), "no file where friction takes part in carrying the torque")
        return mesh_efficiency(_external_load(geared, load_from, conditions), model, oil, operation)
    return _solver(geared.mesh, torque, oil, friction_in_equilibrium)(model, operation)


def run_heat_balance(
    design: Design | str | Path,
    friction: FrictionModel | str = "constant:0.05",
    conditions: Conditions = Conditions(),
    cooling: CoolingInput | None = None,
    *,
    side: Side = "drive",
    positions: int = POSITIONS,
    points_per_line: int = POINTS_PER_LINE,
    friction_in_equilibrium: bool = False,
) -> HeatBalance:
    """Efficiency at the bulk temperatures where friction heat and cooling of the teeth agree; else as `run_gear`.

    Parameters
    ----------
    cooling : CoolingInput, optional
        In place of the design's. What it leaves open: the heat transfer of flanks wetted once per turn
        (`efficiency.loss.heat_balance.wetted_heat_transfer`) on both flanks of all teeth.
    """
    design = resolve_design(design)
    model = resolve_friction(friction, design)
    torque, operation, oil = _operating_point(design, conditions)
    geared = gear_mesh(design, side, positions, points_per_line)
    solve = _solver(geared.mesh, torque, oil, friction_in_equilibrium)
    spirals = geared.pitch.spiral_angle_pinion, geared.pitch.spiral_angle_gear
    chosen = design.cooling if cooling is None else cooling
    return balance_heat(
        lambda operation: solve(model, operation),
        operation,
        thermal_resistances(design, chosen, operation, oil, spirals),
        (design.pinion.elastic_material(), design.gear.elastic_material()),
        warm_inlet=chosen.oil_inlet == "bulk",
    )


def thermal_resistances(
    design: Design, cooling: CoolingInput, operation: Operation, oil: Oil, spiral_angles: tuple[float, float]
) -> tuple[float, float]:
    """Thermal resistance of pinion and gear teeth to the oil [K/W]; what is not given is the default (ours)."""
    lubricant = oil.at(operation.temperature_oil)
    ratio = design.pinion.blank.teeth / design.gear.blank.teeth
    found = []
    for member, given, speed, spiral in (
        (design.pinion, cooling.pinion, operation.speed_pinion, spiral_angles[0]),
        (design.gear, cooling.gear, operation.speed_pinion * ratio, spiral_angles[1]),
    ):
        blank = member.blank
        height = blank.mean_addendum + blank.mean_dedendum
        area = given.cooled_area or 2.0 * blank.teeth * blank.face_width / cos(spiral) * height
        transfer = given.heat_transfer_coefficient or wetted_heat_transfer(lubricant, speed)
        found.append(given.thermal_resistance or 1.0 / (transfer * area))
    return found[0], found[1]


def run_uncertainty(
    design: Design | str | Path,
    friction: FrictionModel | str,
    conditions: Conditions = Conditions(),
    inputs: UncertainInputs | None = None,
    *,
    side: Side = "drive",
    positions: int = POSITIONS,
    points_per_line: int = POINTS_PER_LINE,
    friction_in_equilibrium: bool = False,
    temperatures: tuple[float, float, float] | None = None,
) -> EfficiencyUncertainty:
    """Interval of the efficiency from those of formula, boundary friction and roughness; as `run_gear`.

    `temperatures` are the bulk ones of pinion and gear and that of the oil at the contacts [K], as a heat balance found
    them.
    """
    design = resolve_design(design)
    model = resolve_friction(friction, design)
    torque, operation, oil = _operating_point(design, conditions)
    if temperatures is not None:
        pinion, gear, inlet = temperatures
        operation = replace(
            operation, temperature_bulk_pinion=pinion, temperature_bulk_gear=gear, temperature_inlet=inlet
        )
    mesh = gear_mesh(design, side, positions, points_per_line).mesh
    solve = _solver(mesh, torque, oil, friction_in_equilibrium)
    return efficiency_uncertainty(solve, model, operation, inputs or UncertainInputs())


def run_duty(
    design: Design | str | Path,
    friction: FrictionModel | str,
    duty: Sequence[DutyRow],
    *,
    oil: str | None = None,
    positions: int = POSITIONS,
    points_per_line: int = POINTS_PER_LINE,
    report: Callable[[int, int], None] | None = None,
) -> DutyCycle:
    """Efficiency at every row of a duty cycle (`efficiency.loss.duty.read_duty`) and the energies of all."""
    design = resolve_design(design)
    model = resolve_friction(friction, design)
    meshes: dict[Side, MeshGrids] = {}

    def load(side: Side, torque: float) -> LoadedGrids:
        if side not in meshes:
            meshes[side] = gear_mesh(design, side, positions, points_per_line).mesh
        return load_grids(meshes[side], torque)

    def run(row: DutyRow) -> Operation:
        return Operation.of_design(design, abs(row.speed), row.temperature_oil, row.driver)

    return duty_cycle(duty, load, model, Oil.load(oil or design.operation.oil), run, report)


def run_parameter_map(
    design: Design | str | Path,
    friction: FrictionModel | str,
    axes: Mapping[str, Sequence[Any]],
    conditions: Conditions = Conditions(),
    *,
    side: Side = "drive",
    positions: int = POSITIONS,
    points_per_line: int = POINTS_PER_LINE,
    report: Callable[[int, int], None] | None = None,
) -> ParameterMap:
    """Efficiency over any axes of `efficiency.loss.parameter_map.AXES`, in SI units.

    Parameters
    ----------
    axes : mapping
        ``design`` takes designs (of different offset, say), by name, file or object; misalignments E, P, G, alpha add
        to nothing: they replace those of the design.
    conditions : Conditions
        What has no axis and differs from the operating point of the (first) design.
    """
    designs = [resolve_design(d) for d in axes.get("design", (design,))]
    chosen = {name: list(values) for name, values in axes.items()}
    if "design" in chosen:
        chosen["design"] = designs
    for name, values in chosen.items():
        if name in OPERATION_LIMITS:
            chosen[name] = [OPERATION_LIMITS[name].check(value, name) for value in values]
        elif name in TEXTURE:
            chosen[name] = [TEXTURE[name].check(value, name) for value in values]
        elif name.startswith("roughness_rms"):
            chosen[name] = [value_range_of(MemberInput, "roughness_rms").check(value, name) for value in values]
    torque, operation, oil = _operating_point(designs[0], conditions)

    def pair(place: Place) -> Design:
        chosen_pair: Design = place.get("design", designs[0])
        return chosen_pair

    def make_mesh(place: Place) -> MeshGrids:
        aligned = pair(place)
        moved = {name: place[name] for name in Misalignment.model_fields if name in place}
        if moved:
            aligned = aligned.with_misalignment(**aligned.assembly.misalignment.model_dump() | moved)
        return gear_mesh(aligned, side, positions, points_per_line).mesh

    def at(place: Place) -> Operation:
        here = Operation.of_design(pair(place), operation.speed_pinion, operation.temperature_oil, operation.driver)
        names = {"speed": ("speed_pinion",), "roughness_rms": ("roughness_rms_pinion", "roughness_rms_gear")}
        return replace(
            here,
            **{
                field: value
                for name, value in place.items()
                if name in OPERATION_AXES
                for field in names.get(name, (name,))
            },
        )

    return parameter_map(
        make_mesh,
        lambda place: resolve_friction(friction, pair(place)),
        oil,
        chosen,
        at,
        lambda place: float(place.get("torque", torque)),
        report,
    )


def _solver(
    mesh: MeshGrids, torque: float, oil: Oil, friction_in_equilibrium: bool
) -> Callable[[FrictionModel, Operation], EfficiencyResult]:
    """Efficiency of a mesh at a torque; the frictionless load is solved once."""
    if friction_in_equilibrium:
        return lambda model, operation: mesh_efficiency(
            load_grids_with_friction(mesh, torque, model, oil, operation), model, oil, operation
        )
    loaded = load_grids(mesh, torque)
    return lambda model, operation: mesh_efficiency(loaded, model, oil, operation)


def run_compare(
    design: Design | str | Path,
    frictions: Sequence[FrictionModel | str] | None = None,
    conditions: Conditions = Conditions(),
    *,
    side: Side = "drive",
    positions: int = POSITIONS,
    points_per_line: int = POINTS_PER_LINE,
    geared: GearMesh | None = None,
    load_from: Path | None = None,
) -> Comparison:
    """The same pair at the same point with several friction models, and the closed forms; as `run_gear`.

    Without `frictions` it is the formulas shipped for the oil and `DEFAULT_MODELS`. `geared` is the mesh of that design
    where it is known already.
    """
    design = resolve_design(design)
    if frictions is None:
        frictions = (*shipped_formulas(conditions.oil or design.operation.oil), *DEFAULT_MODELS)
    models = [resolve_friction(friction, design) for friction in frictions]
    torque, operation, oil = _operating_point(design, conditions)
    if geared is None:
        geared = gear_mesh(design, side, positions, points_per_line)
    loaded = load_grids(geared.mesh, torque) if load_from is None else _external_load(geared, load_from, conditions)
    return compare_models(loaded, models, oil, operation, geared.pitch)


def _external_load(geared: GearMesh, path: Path, conditions: Conditions) -> LoadedGrids:
    """Load of another program; a torque asked for has to be that of the file."""
    return read_load(path, geared.pair, geared.mesh.teeth, conditions.torque)


def run_map(
    design: Design | str | Path,
    friction: FrictionModel | str,
    torques: Sequence[float],
    speeds: Sequence[float],
    temperatures: Sequence[float],
    *,
    oil: str | None = None,
    side: Side = "drive",
    positions: int = POSITIONS,
    points_per_line: int = POINTS_PER_LINE,
    report: Callable[[int, int], None] | None = None,
) -> EfficiencyMap:
    """Efficiency over lists of torque [N m], speed [rad/s] and oil temperature [K]; an empty list means the file's."""
    design = resolve_design(design)
    model = resolve_friction(friction, design)
    default = design.operation
    operations = [
        [OPERATION_LIMITS[name].check(value, name) for value in values] or [getattr(default, name)]
        for name, values in (("torque", torques), ("speed", speeds), ("temperature_oil", temperatures))
    ]
    geared: GearMesh = gear_mesh(design, side, positions, points_per_line)
    return efficiency_map(
        geared.mesh,
        model,
        Oil.load(oil or default.oil),
        operations[0],
        lambda speed, temperature: Operation.of_design(design, speed, temperature, default.driver),
        operations[1],
        operations[2],
        report,
    )


def _operating_point(design: Design, conditions: Conditions) -> tuple[float, Operation, Oil]:
    default = design.operation

    def chosen(name: str) -> float:
        value = getattr(conditions, name)
        return float(getattr(default, name)) if value is None else OPERATION_LIMITS[name].check(value, name)

    torque, speed, temperature = (chosen(name) for name in OPERATION_LIMITS)
    operation = Operation.of_design(design, speed, temperature, conditions.driver or default.driver)
    return torque, operation, Oil.load(conditions.oil or default.oil)
