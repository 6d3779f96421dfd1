"""Efficiency of a gear pair: summary of the method.

geometry  ->  mesh cycle  ->  load distribution  ->  local conditions  ->  friction  ->  power loss  ->  efficiency

Normal and friction forces carry the torque together (`efficiency.loss.friction_equilibrium`): a few solutions of the
load per torque are used for every friction model, speed and temperature. Without friction in the balance one load
distribution is used for all, and the loss is linear in a constant friction coefficient.
"""

import math
import time
import tomllib
from collections.abc import Sequence
from dataclasses import asdict, astuple, replace
from functools import cache
from typing import Any, TypeVar, cast

import numpy as np

from efficiency.loss import efficiency_result as results
from efficiency.loss.friction_equilibrium import balance_error, balance_friction, closed
from efficiency.loss.kinematics import LoadedPoints, Operation, loaded_points
from efficiency.loss.lubrication import SolvedFriction, at_hottest, local_lubrication
from efficiency.loss.power_loss import efficiency_of, position_losses, rolling_losses
from efficiency.loss.uncertainty import stand_in
from efficiency.ltca.limits import edges_yield, points_above_hardness
from efficiency.ltca.load_distribution import LoadDistribution
from efficiency.ltca.mesh_grids import LoadedGrids
from efficiency.ltca.tangent_load import TangentLoad
from ehl.common.arrays import BoolArray, FloatArray
from ehl.common.data import data_path, reason_text
from ehl.common.errors import ConvergenceError
from ehl.common.quantities import quantity
from ehl.fluid.oil import Oil
from regression.formula import Formula
from regression.friction import models
from regression.friction.conditions import Conditions
from regression.friction.published_registry import PUBLISHED, model_label

T = TypeVar("T")
SHAFTS = "shafts, bearings and gear-body deformation outside the tooth model"
SKIPPED = (SHAFTS, "churning, windage and bearing losses")
FRICTIONLESS = "friction in the torque balance"
AS_WARM_AS_THE_OIL = "tooth temperature: taken as the oil temperature"
# the change on halving a grid can be small by chance, as line ends and the edge of the loaded area move past points
SAFETY = 2.0
# results that are nan after a failure
_UNKNOWN: dict[str, Any] = dict.fromkeys(
    (
        *("efficiency", "efficiency_with_rolling", "efficiency_error"),
        *("power_loss", "power_loss_rolling", "power_input", "power_output", "friction_coefficient_mean"),
    ),
    math.nan,
) | {"errors": results.EfficiencyErrors(*(math.nan,) * 4)}
RANGES = (
    *("pressure_hertz", "radius_equivalent", "speed_entrainment", "slide_to_roll", "slide_to_roll_total"),
    *("speed_sliding", "speed_sliding_lengthwise", "load_per_length", "film_ratio_formula"),
)


def solve_friction(runs: Sequence[models.Run[T]], friction: models.FrictionModel, oil: Oil) -> list[T]:
    """Results of runs with the same friction model and oil; the points of all are evaluated together."""
    formula = stand_in(friction, oil)[0] if friction.solves_contacts else friction
    return models.solve_together(runs, friction, oil, formula)


def mesh_efficiency(
    loaded: LoadedGrids,
    friction: models.FrictionModel,
    oil: Oil,
    operation: Operation,
    load_balance: results.LoadBalance = "frictionless",
) -> results.EfficiencyResult:
    """Friction, power loss and efficiency of a loaded mesh.

    loaded: from `load_grids`.
    friction: friction model; solved contacts of the fine grid are also used for the coarse grid.
    operation: speed, oil temperature and roughness.
    load_balance: forces in the torque balance: normal and friction forces, or only the normal forces.
    Returns: status ``failed`` if the load did not converge, if the pressure exceeds the hardness of the softer member,
    if friction exceeds the torque, or if the friction model has no value at a loaded point. Then efficiency and loss
    are nan, while load and pressure are those of elastic teeth.
    """
    run = balanced_efficiency(loaded, friction, oil, operation, load_balance)
    return solve_friction([run], friction, oil)[0]


def _mesh_efficiency(
    loaded: LoadedGrids, friction: models.FrictionModel, oil: Oil, operation: Operation
) -> models.Run[results.EfficiencyResult]:
    clock = time.perf_counter()
    mesh, modulus = loaded.mesh, loaded.mesh.teeth.effective_modulus
    fine = loaded_points(loaded.fine, modulus, operation)
    coarse = loaded_points(loaded.coarse, modulus, operation)
    table, estimate = yield models.Request(fine.state, whole=True)
    estimate_coarse = yield from _on_coarse(friction, estimate, loaded, fine, coarse)
    load, moved, moved_coarse = loaded.fine, 0.0, 0.0
    if loaded.balance is not None and isinstance(load, TangentLoad) and isinstance(loaded.coarse, TangentLoad):
        load, moved = closed(load, estimate.mu, loaded.balance.way)
        other, moved_coarse = closed(loaded.coarse, estimate_coarse.mu, loaded.balance.way)
        fine, coarse = (replace(p, force=own.loaded["force"]) for p, own in ((fine, load), (coarse, other)))
        loaded = LoadedGrids(mesh, load, other, loaded.balance)
    lubrication = local_lubrication(fine, estimate, table, (mesh.teeth.material_pinion, mesh.teeth.material_gear))
    reason = _reason(loaded, estimate, estimate_coarse)
    if not reason and not math.isfinite(moved + moved_coarse):
        reason = "self_locking"
    losses = position_losses(fine, estimate.mu, len(mesh.fine))
    rolling = rolling_losses(fine, lubrication.rolling_traction, len(mesh.fine))
    coarse_losses = position_losses(coarse, estimate_coarse.mu, len(mesh.fine))
    sliding_power = float(position_losses(fine, np.ones(fine.force.size), len(mesh.fine)).mean())
    figures = _efficiencies(losses, rolling, loaded.fine.torque, operation)
    errors = _errors(losses, coarse_losses, estimate, load, moved, operation)
    cold = operation.temperature_bulk_pinion is None and operation.temperature_bulk_gear is None
    found = results.EfficiencyResult(
        design=mesh.design,
        side=mesh.side,
        friction_model=friction.name,
        conditions=_conditions(loaded, oil, operation, fine),
        **figures,
        efficiency_error=sum(astuple(errors)),
        errors=errors,
        friction_coefficient_mean=figures["power_loss"] / sliding_power if sliding_power > 0.0 else math.nan,
        pressure_hertz_max=loaded.fine.pressure_hertz_max,
        edges=_edge_contact(loaded, fine, estimate),
        cycle=_cycle(loaded, losses, rolling),
        outside_range_share=_outside_range(fine, estimate),
        friction_range=_friction_range(fine, estimate, table),
        solution=_solution_size(loaded, fine, estimate),
        status="failed" if reason else "converged",
        reason=reason,
        deflection={} if mesh.deflection is None else asdict(mesh.deflection),
        skipped=(
            *SKIPPED[mesh.deflection is not None :],
            *(FRICTIONLESS,) * (loaded.balance is None),
            *(AS_WARM_AS_THE_OIL,) * cold,
        ),
        notes=_notes(loaded, friction, estimate, fine, operation, oil),
        seconds=time.perf_counter() - clock,
        load=loaded.fine,
        points=fine,
        friction=estimate,
        lubrication=lubrication,
        case=results.ResultCase(friction, operation, oil),
    )
    return replace(found, **_UNKNOWN) if reason else found


def _efficiencies(losses: FloatArray, rolling: FloatArray, torque: float, operation: Operation) -> dict[str, Any]:
    """Efficiencies and powers from the losses at each position."""
    power_pinion, power_loss = torque * operation.speed, float(losses.mean())
    power_input = power_pinion if operation.driver == "pinion" else power_pinion + power_loss
    at: tuple[Any, ...] = torque, operation.speed, operation.driver
    return {
        "efficiency": efficiency_of(power_loss, *at),
        "efficiency_with_rolling": efficiency_of(float((losses + rolling).mean()), *at),
        "power_loss": power_loss,
        "power_loss_rolling": float(rolling.mean()),
        "power_input": power_input,
        "power_output": power_input - power_loss,
    }


def _errors(
    losses: FloatArray,
    coarse: FloatArray,
    estimate: models.FrictionEstimate,
    load: LoadDistribution,
    moved: float,
    operation: Operation,
) -> results.EfficiencyErrors:
    """Numerical errors of the efficiency from the losses at each position of both grids and the torque balance."""

    def efficiency_at(losses: FloatArray) -> float:
        return efficiency_of(float(losses.mean()), load.torque, operation.speed, operation.driver)

    error = estimate.mean_error if isinstance(estimate, SolvedFriction) else 0.0
    distance = load.distance if isinstance(load, TangentLoad) else 0.0
    return results.EfficiencyErrors(
        positions=SAFETY * abs(efficiency_at(losses) - efficiency_at(losses[::2])),
        points=SAFETY * abs(efficiency_at(losses) - efficiency_at(coarse)),
        contacts=abs(efficiency_at(losses * (1.0 + error)) - efficiency_at(losses)),
        balance=balance_error(float(losses.mean()) / (load.torque * operation.speed), moved, distance),
    )


def _conditions(
    loaded: LoadedGrids, oil: Oil, operation: Operation, points: LoadedPoints
) -> results.OperatingConditions:
    bulk_pinion, bulk_gear = operation.bulk
    return results.OperatingConditions(
        torque=loaded.fine.torque,
        speed=operation.speed,
        temperature=operation.temperature,
        oil=oil.name,
        driver=operation.driver,
        load_balance="frictionless" if loaded.balance is None else "frictional",
        temperature_inlet=operation.inlet,
        temperature_bulk_pinion=bulk_pinion,
        temperature_bulk_gear=bulk_gear,
        roughness_rms_pinion=operation.roughness_rms_pinion,
        roughness_rms_gear=operation.roughness_rms_gear,
        correlation_length=float(np.median(points.state.correlation_length)),
        peklenik_number=float(np.median(points.state.peklenik_number)),
    )


def _edge_contact(loaded: LoadedGrids, points: LoadedPoints, estimate: models.FrictionEstimate) -> results.EdgeContact:
    power, edges = estimate.mu * points.force * points.speed_sliding, loaded.edges
    lost = _share(power, loaded.fine.loaded["at_edge"].astype(bool))
    return results.EdgeContact(edges.pressure, edges.pressure_lower, edges.pressure_upper, edges.share, lost)


def _cycle(loaded: LoadedGrids, losses: FloatArray, rolling: FloatArray) -> results.MeshCycle:
    return results.MeshCycle(
        transmission_error_loaded=float(np.ptp(loaded.fine.transmission_error)),
        transmission_error_unloaded=loaded.mesh.unloaded_error,
        pinion_angle=np.array([p.pinion_angle for p in loaded.mesh.fine]),
        power_loss=losses,
        power_loss_rolling=rolling,
        transmission_error=loaded.fine.transmission_error,
    )


def _friction_range(
    points: LoadedPoints, estimate: models.FrictionEstimate, table: Conditions
) -> results.FrictionRange:
    return results.FrictionRange(
        ranges={name: (float(table[name].min()), float(table[name].max())) for name in RANGES},
        flags={flag.name.lower(): int(np.count_nonzero(estimate.flag == flag)) for flag in models.FrictionFlag},
        flag_shares=_flag_shares(points, estimate),
        measured_share=_measured_share(points, table),
    )


def _solution_size(
    loaded: LoadedGrids, points: LoadedPoints, estimate: models.FrictionEstimate
) -> results.SolutionSize:
    solved = estimate if isinstance(estimate, SolvedFriction) else None
    return results.SolutionSize(
        positions=len(loaded.mesh.fine),
        points_per_line=loaded.mesh.points_per_line,
        points_loaded=points.force.size,
        contacts=solved.contacts if solved else 0,
        contacts_failed=dict(solved.failed) if solved else {},
        torque_residual=loaded.fine.torque_residual,
        compatibility_residual=loaded.fine.compatibility_residual,
    )


def balanced_efficiency(
    loaded: LoadedGrids,
    friction: models.FrictionModel,
    oil: Oil,
    operation: Operation,
    load_balance: results.LoadBalance,
    *,
    many: bool = False,
) -> models.Run[results.EfficiencyResult]:
    """`mesh_efficiency` as a run of `solve_friction`.

    many: for one of many points, such as of a map: faster, with a larger stated error of the balance.
    """
    if load_balance == "frictionless" or loaded.coarse.reason:
        return (yield from _mesh_efficiency(loaded, friction, oil, operation))
    try:
        balanced = yield from balance_friction(loaded, operation, many=many)
    except ConvergenceError as error:
        reason = cast("results.Reason", error.reason)
        without = mesh_efficiency(loaded, models.ConstantFriction(0.0), oil, operation)
        note = f"{error.detail}: no state of uniform motion exists at this torque"
        return replace(
            without,
            friction_model=friction.name,
            conditions=replace(without.conditions, load_balance=load_balance),
            status="failed",
            reason=reason,
            notes=(*without.notes, note),
            case=replace(without.case, model=friction),
            **_UNKNOWN,
        )
    return (yield from _mesh_efficiency(balanced, friction, oil, operation))


def _on_coarse(
    model: models.FrictionModel,
    estimate: models.FrictionEstimate,
    loaded: LoadedGrids,
    fine: LoadedPoints,
    coarse: LoadedPoints,
) -> models.Run[models.FrictionEstimate]:
    """Friction on the coarse grid, that of solved contacts from the fine grid.

    The coarse grid serves only the error estimate, so it needs no interval and no check of the range.
    """
    if model.solves_contacts:
        mu, without = _values_on_lines(estimate.mu, (loaded.fine, fine), (loaded.coarse, coarse)), "NOT_CONVERGED"
    else:
        mu, without = (yield models.Request(coarse.state))[1].mu, "UNDEFINED"
    flag = np.where(np.isfinite(mu), models.FrictionFlag.OK, models.FrictionFlag[without]).astype(np.int8)
    return models.FrictionEstimate(mu, mu, mu, flag)


def _reason(loaded: LoadedGrids, *frictions: models.FrictionEstimate) -> results.Reason:
    for load in (loaded.fine, loaded.coarse):
        if load.reason == "newton_limit":
            return "load_newton_limit"
        if load.reason == "active_set_limit":
            return "load_active_set_limit"
    teeth = loaded.mesh.teeth
    if any(points_above_hardness(load, teeth)[0] or edges_yield(load, teeth) for load in (loaded.fine, loaded.coarse)):
        return "pressure_above_hardness"
    if any(np.any(friction.flag == models.FrictionFlag.NOT_CONVERGED) for friction in frictions):
        return "friction_not_converged"
    return "friction_undefined" if any(np.any(_missing(friction)) for friction in frictions) else ""


def _missing(friction: models.FrictionEstimate) -> BoolArray:
    return (friction.flag >= models.FrictionFlag.NOT_CONVERGED) | ~np.isfinite(friction.mu)


def _notes(
    loaded: LoadedGrids,
    model: models.FrictionModel,
    friction: models.FrictionEstimate,
    points: LoadedPoints,
    operation: Operation,
    oil: Oil,
) -> tuple[str, ...]:
    notes = loaded.notes
    name = model_label(model.name)
    if moved := loaded.mesh.deflection:
        ways = ", ".join(f"{way} {getattr(moved, way) * 1e6:.4g} um" for way in ("E", "P", "G"))
        angle = quantity("deflection.shaft_angle_error").to_display(moved.shaft_angle_error)
        notes += (f"shafts and bearings deflect: {ways}, shaft angle {angle:.4g} arcmin, after {moved.rounds} rounds",)
    if at_hottest(operation):
        notes += ("bulk temperature of the teeth limited to 200 degC, the end of the oil laws: the estimate is higher",)
    if isinstance(model, Formula) and (other := model.oil_note(oil)):
        notes += (other,)
    if isinstance(model, Formula) and _outside_range(points, friction) > 0.01:
        notes += tuple(filter(None, (model.range_note(points.state, oil=oil),)))
    finishes = (operation.finish_pinion, operation.finish_gear)
    if isinstance(model, Formula) and any(finish is not None and finish.state == "new" for finish in finishes):
        notes += (f"new surfaces, but {name} was fitted to run-in surfaces: friction is about 5 % too low",)
    if model.name in PUBLISHED and PUBLISHED[model.name].mark:
        notes += (f"{name} {PUBLISHED[model.name].certainty_words}",)
    missing = int(np.count_nonzero(_missing(friction)))
    if missing:
        notes += (f"{name} has no value at {missing} of {friction.mu.size} loaded points",)
    if isinstance(friction, SolvedFriction) and friction.failed:
        reasons = ", ".join(f"{reason_text(reason)}: {count}" for reason, count in sorted(friction.failed.items()))
        share = _flag_shares(points, friction)[models.FrictionFlag.PREDICTED.name.lower()]
        how = f"predicted by the others, {100.0 * share:.2g} % of the loss" if share > 0.0 else "omitted"
        notes += (f"{sum(friction.failed.values())} of {friction.contacts} contacts not solved ({reasons}): {how}",)
    blind = not model.uses_texture and not isinstance(model, models.ConstantFriction)
    if blind and np.any(points.state.peklenik_number != 1.0):
        notes += ("the friction model assumes isotropic roughness: the Peklenik number has no effect",)
    return notes


def _flag_shares(points: LoadedPoints, estimate: models.FrictionEstimate) -> dict[str, float]:
    """Share of the loss by flag; points without friction are weighted with the mean friction of the others."""
    known = np.isfinite(estimate.mu)
    typical = float(estimate.mu[known].mean()) if known.any() else 1.0
    power = np.where(known, estimate.mu, typical) * points.force * points.speed_sliding
    total = max(float(power.sum()), np.finfo(float).tiny)
    return {flag.name.lower(): float(power[estimate.flag == flag].sum()) / total for flag in models.FrictionFlag}


def _share(power: FloatArray, where: BoolArray) -> float:
    """Share of a power at some of its points [-]: 0 without power, nan if it is not available everywhere."""
    total = float(power.sum())
    return float(power[where].sum()) / total if total != 0.0 else 0.0


def _outside_range(points: LoadedPoints, estimate: models.FrictionEstimate) -> float:
    """Share of the sliding power at points outside the range of the model, including points without a value."""
    outside = (estimate.flag == models.FrictionFlag.OUTSIDE_RANGE) | (estimate.flag == models.FrictionFlag.UNDEFINED)
    return _share(points.force * points.speed_sliding, outside)


@cache
def measured_states() -> dict[str, Any]:
    """Measured gear states of the validation: their number, deviation of computed friction, and local conditions."""
    content = data_path("reference/measured", "gears.toml").read_text(encoding="utf-8")
    return dict(tomllib.loads(content)["fzg_states"])


def _measured_share(points: LoadedPoints, table: Conditions) -> float:
    """Share of the sliding power at points within the local conditions of the measured gears [-]."""
    power = points.force * points.speed_sliding
    within = np.full(power.shape, power > 0.0)
    for name, limits in measured_states().items():
        if isinstance(limits, list):
            within &= (table[name] >= limits[0]) & (table[name] <= limits[1])
    return _share(power, within)


def _values_on_lines(
    values: FloatArray, known: tuple[LoadDistribution, LoadedPoints], wanted: tuple[LoadDistribution, LoadedPoints]
) -> FloatArray:
    """Values at the loaded points of the wanted grid, from those of another grid of the same positions and lines.

    Linear interpolation along each contact line, constant beyond its last known point. A line without a known point
    (it carries a negligible load on one of the grids) has the mean of its position.
    """
    lines, wanted_lines = (points.values(load.cycle, "line_number") for load, points in (known, wanted))
    places, wanted_places = (points.values(load.cycle, "position") for load, points in (known, wanted))
    result = np.empty(wanted[1].force.size)
    for position in np.unique(wanted[1].position):
        here = known[1].position == position
        target_points = wanted[1].position == position
        for line in np.unique(wanted_lines[target_points]):
            target = np.flatnonzero(target_points & (wanted_lines == line))
            source = np.flatnonzero(here & (lines == line))
            if source.size == 0:
                result[target] = values[here].mean()
                continue
            chord = places[source[-1]] - places[source[0]]
            if source.size == 1 or not chord.any():
                result[target] = values[source[0]]
                continue
            run = places[source] @ chord
            order = np.argsort(run)
            result[target] = np.interp(wanted_places[target] @ chord, run[order], values[source][order])
    return result
