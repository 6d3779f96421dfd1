"""What the command line calls: a design file and names in, results out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from efficiency.contact.pair import Side
from efficiency.design import OPERATION_LIMITS, Design, load_design
from efficiency.gear_mesh import GearMesh, gear_mesh
from efficiency.loss.compare import Comparison, compare_models
from efficiency.loss.efficiency import load_mesh, mesh_efficiency
from efficiency.loss.friction_equilibrium import load_mesh_with_friction
from efficiency.loss.kinematics import Operation
from efficiency.loss.map import EfficiencyMap, efficiency_map
from efficiency.loss.result import EfficiencyResult
from ehl.oil import Oil
from regression.friction_models import FrictionModel, friction_model, shipped_formulas

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
        Of the pinion, in its driving direction [N m]; here and below, within the range of the design file.
    speed : float, optional
        Of the pinion [rad/s].
    temperature_oil : float, optional
        [K].
    oil : str, optional
        Name of an oil card.
    """

    torque: float | None = None
    speed: float | None = None
    temperature_oil: float | None = None
    oil: str | None = None


def resolve_design(design: Design | str | Path) -> Design:
    """A design, or the one of that name or file."""
    return design if isinstance(design, Design) else load_design(design)


def resolve_friction(friction: FrictionModel | str, design: Design) -> FrictionModel:
    """A friction model, or the one of that name: ``ehl``, ``ehl:smooth``, or any of `regression.friction_model`."""
    if not isinstance(friction, str):
        return friction
    if friction.partition(":")[0] == "ehl":
        from efficiency.loss.ehl_friction import ehl_friction

        return ehl_friction(friction, (design.pinion.body(), design.gear.body()))
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
    mesh = gear_mesh(design, side, positions, points_per_line).mesh
    if friction_in_equilibrium:
        return mesh_efficiency(load_mesh_with_friction(mesh, torque, model, oil, operation), model, oil, operation)
    return mesh_efficiency(load_mesh(mesh, torque), model, oil, operation)


def run_compare(
    design: Design | str | Path,
    frictions: Sequence[FrictionModel | str] | None = None,
    conditions: Conditions = Conditions(),
    *,
    side: Side = "drive",
    positions: int = POSITIONS,
    points_per_line: int = POINTS_PER_LINE,
    geared: GearMesh | None = None,
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
    return compare_models(load_mesh(geared.mesh, torque), models, oil, operation, geared.pitch)


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
        lambda speed, temperature: _operation(design, speed, temperature),
        operations[1],
        operations[2],
        report,
    )


def _operation(design: Design, speed: float, temperature: float) -> Operation:
    return Operation(speed, temperature, design.pinion.roughness_rms, design.gear.roughness_rms)


def _operating_point(design: Design, conditions: Conditions) -> tuple[float, Operation, Oil]:
    default = design.operation

    def chosen(name: str) -> float:
        value = getattr(conditions, name)
        return float(getattr(default, name)) if value is None else OPERATION_LIMITS[name].check(value, name)

    torque, speed, temperature = (chosen(name) for name in OPERATION_LIMITS)
    return torque, _operation(design, speed, temperature), Oil.load(conditions.oil or default.oil)
