"""Ease-off and edge relief sized for a torque: little load on edges over a box of misalignments, the load central.

The relief of each loaded edge grows with its share of the torque on either flank, and the crowning of a flank with its
own at toe and heel, until the worst state of the box is below the limit on the drive and on the coast side. The contact
position of each flank moves against the centre of its load, and its bias is the best of three. Each step computes new
machine settings and the loaded contact; between the first step and the last check only the worst states are computed.
The elastic bodies are those of the first step.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np

from efficiency.conditions.conditions import checked
from efficiency.contact.gear_flanks import MEMBERS, Side
from efficiency.contact.relief import EdgeRelief
from efficiency.ltca.limits import EDGE_LIMIT, edge_load
from efficiency.machine_settings.design_file import targets_text
from efficiency.machine_settings.inputs import FlankTarget, MemberTargets, SettingsInput, load_targets, targets_next_to
from efficiency.machine_settings.solve import machine_settings
from efficiency.optimisation.problem import half_widths
from efficiency.pair import GearPair
from ehl.common.errors import ConvergenceError
from ehl.common.files import write_file
from ehl.common.progress import report_progress
from ehl.common.threads import one_thread
from ehl.common.units import parse_quantity

BOX = {"E": "0.05 mm", "P": "0.05 mm", "G": "0.05 mm"}
"""Default half widths of the box of misalignments."""
# relief of edges without one: amount and length in mean normal modules, length at the ends in face widths (this work)
TIP, ENDS = (0.004, 0.5), (0.006, 0.12)
# bounds of the growth of relief and exponent of the crowning in one step, maximum number of steps (this work)
_GROWTH, _CROWNING, _STEPS = (1.15, 1.8), 0.5, 14
# trials of the bias; displacement of the contact position over that of the load; largest central displacement of the
# load, in half face widths (this work)
_BIAS, _CENTRING, CENTRAL = (-0.25, 0.0, 0.25), 0.6, 0.1
# states of each flank that a step computes besides the aligned one
_WORST = 2
_GRID = 12, 21
State = dict[str, float]


@dataclass(frozen=True)
class FlankLoad:
    """Load of one flank over the box."""

    shares: tuple[float, ...]  # share of the torque on edges in each state [-]
    edges: dict[str, float]  # largest share at each edge [-]
    # of the load of the aligned pair along the gear face, from its middle to the heel, in half face widths
    centre: float

    @property
    def worst(self) -> float:
        """Largest share on edges [-]."""
        return max(self.shares)


@dataclass(frozen=True)
class LoadSizing:
    """Targets sized for a torque."""

    targets: SettingsInput  # with their ease-off and relief
    shares: tuple[float, ...]  # share of the torque on edges in the worst state after each step [-]
    sides: dict[Side, FlankLoad]  # load of each flank over the whole box

    def __str__(self) -> str:
        return "; ".join(
            f"{side}: edges carry at most {100.0 * load.worst:.2g} % over the box, "
            f"load {100.0 * load.centre:+.0f} % of the half face width from the middle"
            for side, load in self.sides.items()
        )

    def write_next_to(self, design: Path) -> Path:
        """Write the targets to the folder of the design file made from them; returns their file."""
        path = targets_next_to(design)
        write_file(path, targets_text(self.targets, f"Targets of {design.name}."))
        return path


@one_thread
def sized_for_load(
    targets: SettingsInput | str | Path,
    torque: float | str | None = None,
    misalignment: Mapping[str, float | str] | None = None,
    coast_torque: float | str | None = None,
) -> LoadSizing:
    """Ease-off and relief for which the edges carry less than `EDGE_LIMIT` of a torque on both flanks.

    Parameters
    ----------
    targets : SettingsInput, str or Path
        Initial targets, a file or the name of shipped targets; sufficient relief is kept.
    torque : float or str, optional
        Pinion torque on the drive side [N m]; default: that of the targets.
    misalignment : mapping, optional
        Half widths of the box of E, P, G [m]; default: `BOX`.
    coast_torque : float or str, optional
        Pinion torque on the coast side [N m]; default: that of the drive side. 0: the drive side alone.

    Returns
    -------
    LoadSizing

    Raises
    ------
    ConvergenceError
        The limit is not met (`edges_carry`), or a step has no settings or no load distribution.

    Examples
    --------
    >>> sizing = efficiency.sized_for_load("targets.toml", "300 N m", {"E": "0.1 mm"})  # doctest: +SKIP
    >>> design = efficiency.settings(sizing.targets)  # doctest: +SKIP
    """
    if not isinstance(targets, SettingsInput):
        targets = load_targets(targets)
    box = half_widths({**BOX, **(misalignment or {})})
    corners = [dict(zip(box, signs, strict=True)) for signs in product((-1.0, 1.0), repeat=len(box))]
    states: list[State] = [{}, *({n: sign * box[n] for n, sign in corner.items()} for corner in corners if corner)]
    drive = targets.operation.torque if torque is None else checked("torque", torque)
    coast = drive if coast_torque is None else parse_quantity(coast_torque, "N*m", field="coast_torque")
    torques: dict[Side, float] = {"drive": drive}
    if coast:
        torques["coast"] = checked("torque", coast)
    # the relief depends on the module of the cut pair
    reference = GearPair(machine_settings(targets, transmission=False).design)
    targets = _with_relief(targets, reference)

    def loads(targets: SettingsInput, chosen: Mapping[Side, Sequence[State]]) -> dict[Side, FlankLoad]:
        pair = reference.sharing_bodies(machine_settings(targets, transmission=False).design)
        return {side: _flank_load(pair, side, torques[side], chosen[side]) for side in torques}

    whole: dict[Side, Sequence[State]] = dict.fromkeys(torques, states)
    report_progress("steps", 0, _STEPS)
    found = loads(targets, whole)
    active, complete = _worst_states(states, found), True
    shares = []
    if max(load.worst for load in found.values()) >= EDGE_LIMIT and targets.cutting.pinion != "conjugate":
        shares.append(max(load.worst for load in found.values()))
        targets, found = _best_bias(targets, found, lambda trial: loads(trial, active))
        complete = False
    for step in range(1, _STEPS + 1):
        report_progress("steps", step, _STEPS)
        shares.append(max(load.worst for load in found.values()))
        good = shares[-1] < EDGE_LIMIT
        if good and complete and (step > 1 or all(abs(load.centre) < CENTRAL for load in found.values())):
            return LoadSizing(targets, tuple(shares), found)
        if complete:
            active = _worst_states(states, found)
        if good and not complete:
            complete = True
        else:
            targets = _grown(targets, found)
            complete = False
        found = loads(targets, whole if complete else active)
    raise ConvergenceError(
        "edges_carry",
        f"edges still carry {100.0 * shares[-1]:.2g} % of {drive:g} N m after {_STEPS} steps: use less torque, larger "
        "teeth, or a smaller box of misalignments",
    )


def _worst_states(states: Sequence[State], found: Mapping[Side, FlankLoad]) -> dict[Side, Sequence[State]]:
    """The aligned state and those with the most load on edges, for each flank."""
    rows = range(1, len(states))
    return {
        side: [states[0], *(states[i] for i in sorted(rows, key=lambda i: -load.shares[i])[:_WORST])]
        for side, load in found.items()
    }


def _flank_load(pair: GearPair, side: Side, torque: float, states: Sequence[State]) -> FlankLoad:
    shares, worst, centre = [], dict[str, float](), 0.0
    half = 0.5 * pair.design.gear.blank.face_width
    for state in states:
        mesh = pair.mesh(side, positions=_GRID[0], points_per_line=_GRID[1], **state)
        load = mesh.load(torque).grids.fine
        if load.reason:
            raise ConvergenceError(load.reason, f"no load distribution at {torque:g} N m on the {side} side")
        edges = edge_load(load, mesh.grids.teeth)
        shares.append(edges.share)
        worst = {e: max(worst.get(e, 0.0), edges.shares.get(e, 0.0)) for e in worst | edges.shares}
        if not state:
            force = np.concatenate([p.force for p in load.positions])
            face = np.concatenate([p.position.face_gear for p in load.positions])
            centre = float(force @ face / force.sum()) / half - 1.0
    return FlankLoad(tuple(shares), worst, centre)


def _best_bias(
    targets: SettingsInput, found: dict[Side, FlankLoad], loads: Callable[[SettingsInput], dict[Side, FlankLoad]]
) -> tuple[SettingsInput, dict[Side, FlankLoad]]:
    """Targets with the bias of each flank, one of three, that leaves the least load on edges."""
    best = {side: (load.worst, 0.0) for side, load in found.items()}
    for bias in _BIAS:
        if not bias:
            continue
        try:
            trial = loads(_changed(targets, {side: _biased(targets, side, bias) for side in found}))
        except ConvergenceError:
            continue
        for side, load in trial.items():
            best[side] = min(best[side], (load.worst, bias))
    chosen = {side: _biased(targets, side, bias) for side, (_, bias) in best.items() if bias}
    if not chosen:
        return targets, found
    targets = _changed(targets, chosen)
    return targets, loads(targets)


def _biased(targets: SettingsInput, side: Side, bias: float) -> FlankTarget:
    flank: FlankTarget = getattr(targets.targets, side)
    return flank.model_copy(update={"bias": min(max(flank.bias + bias, -2.0), 2.0)})


def _changed(targets: SettingsInput, flanks: Mapping[Side, FlankTarget]) -> SettingsInput:
    both = {str(side): flank for side, flank in flanks.items()}
    return targets.model_copy(update={"targets": targets.targets.model_copy(update=both)})


def _with_relief(targets: SettingsInput, pair: GearPair) -> SettingsInput:
    """Targets with relief at all edges of both members."""
    module = pair.mesh("drive", *_GRID).pitch.module_normal
    changed: dict[str, MemberTargets] = {}
    for name in MEMBERS:
        member: MemberTargets = getattr(targets, name)
        face = getattr(pair.design, name).blank.face_width
        tip = EdgeRelief(amount=TIP[0] * module, length=TIP[1] * module)
        end = EdgeRelief(amount=ENDS[0] * module, length=ENDS[1] * face)
        own = member.edge_relief
        relief = own.model_copy(update={"tip": own.tip or tip, "toe": own.toe or end, "heel": own.heel or end})
        changed[name] = member.model_copy(update={"edge_relief": relief})
    return targets.model_copy(update=changed)


def _grown(targets: SettingsInput, loads: Mapping[Side, FlankLoad]) -> SettingsInput:
    """Targets with more relief at loaded edges, more crowning at loaded toe and heel, and the load nearer the middle.

    The relief is common to both flanks of a member, the ease-off is that of each flank.
    """
    changed: dict[str, MemberTargets] = {}
    crowning: dict[Side, dict[str, float]] = {side: {"toe": 1.0, "heel": 1.0} for side in loads}
    for name in MEMBERS:
        member: MemberTargets = getattr(targets, name)
        parts = {}
        for edge in ("tip", "toe", "heel"):
            own: EdgeRelief = getattr(member.edge_relief, edge)
            factors = {side: _factor(load.edges.get(f"{name} {edge}", 0.0)) for side, load in loads.items()}
            factor = max(factors.values())
            if factor > 1.0:
                parts[edge] = own.model_copy(update={"amount": min(own.amount * factor, 0.2 * own.length, 1e-3)})
            if edge != "tip":
                for side, own_factor in factors.items():
                    crowning[side][edge] = max(crowning[side][edge], own_factor**_CROWNING)
        changed[name] = member.model_copy(update={"edge_relief": member.edge_relief.model_copy(update=parts)})

    def sized(side: Side) -> FlankTarget:
        flank: FlankTarget = getattr(targets.targets, side)
        more = {f"crowning_{end}": getattr(flank, f"crowning_{end}") * x for end, x in crowning[side].items()}
        if targets.cutting.pinion == "conjugate":  # equal at both ends
            return flank.model_copy(update=dict.fromkeys(more, math.sqrt(math.prod(more.values()))))
        if abs(loads[side].centre) > 0.5 * CENTRAL:
            more["contact_face"] = min(max(flank.contact_face - _CENTRING * loads[side].centre, -0.6), 0.6)
        return flank.model_copy(update=more)

    return _changed(targets.model_copy(update=changed), {side: sized(side) for side in loads})


def _factor(share: float) -> float:
    """Growth of the relief of an edge with a share of the torque."""
    if share <= 0.1 * EDGE_LIMIT:
        return 1.0
    return min(max(float((share / EDGE_LIMIT) ** 0.3), _GROWTH[0]), _GROWTH[1])
