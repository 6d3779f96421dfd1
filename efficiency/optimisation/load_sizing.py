"""Crowning and edge relief sized for a torque, so that the edge load is small over a box of misalignments.

The relief of each loaded edge grows with its share of the torque, and the crowning grows with it at toe and heel, until
the worst state of the box is below the limit. Each step computes new machine settings and the loaded contact in every
state; the elastic bodies are those of the first step.
"""

import math
from collections.abc import Mapping
from itertools import product
from pathlib import Path

from efficiency.conditions.conditions import checked
from efficiency.contact.gear_flanks import MEMBERS
from efficiency.contact.relief import EdgeRelief
from efficiency.ltca.limits import EDGE_LIMIT, edge_load
from efficiency.machine_settings.design_file import targets_text
from efficiency.machine_settings.inputs import FlankTarget, MemberTargets, SettingsInput, load_targets, targets_next_to
from efficiency.machine_settings.solve import machine_settings
from efficiency.pair import GearPair
from ehl.common.errors import ConvergenceError
from ehl.common.files import write_file
from ehl.common.progress import report_progress
from ehl.common.records import dataclass
from ehl.common.threads import one_thread
from ehl.common.units import parse_quantity

BOX = {"E": "0.05 mm", "P": "0.05 mm"}
"""Default half widths of the box of misalignments."""
# relief of edges without one: amount and length in mean normal modules, length at the ends in face widths (ours)
TIP, ENDS = (0.004, 0.5), (0.006, 0.12)
# bounds of the growth of relief and exponent of the crowning in one step, maximum number of steps (ours)
_GROWTH, _CROWNING, _STEPS = (1.15, 1.8), 0.5, 12
_GRID = 12, 21


@dataclass(frozen=True)
class LoadSizing:
    """Targets sized for a torque."""

    targets: SettingsInput  # with their crowning and relief
    shares: tuple[float, ...]  # share of the torque on edges in the worst state after each step [-]

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
) -> LoadSizing:
    """Crowning and relief for which the edges carry less than `EDGE_LIMIT` of a torque.

    Parameters
    ----------
    targets : SettingsInput, str or Path
        Initial targets, a file or the name of shipped targets; sufficient relief is kept.
    torque : float or str, optional
        Pinion torque on the drive side [N m]; default: that of the targets.
    misalignment : mapping, optional
        Half widths of the box of E, P, G [m]; default: `BOX`.

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
    box = {n: parse_quantity(v, "m", field=n) for n, v in {**BOX, **(misalignment or {})}.items()}
    corners = [dict(zip(box, signs, strict=True)) for signs in product((-1.0, 1.0), repeat=len(box))]
    states: list[dict[str, float]] = [{}, *({n: sign * box[n] for n, sign in corner.items()} for corner in corners)]
    torque = targets.operation.torque if torque is None else checked("torque", torque)
    reference: GearPair | None = None
    shares: list[float] = []
    for step in range(_STEPS):
        report_progress("load sizing", step, _STEPS)
        made = machine_settings(targets, transmission=False)
        if reference is None:
            # the relief depends on the module of the cut pair
            reference = GearPair(made.design)
            targets = _with_relief(targets, reference)
            made = machine_settings(targets, transmission=False)
        pair = reference.sharing_bodies(made.design)
        worst: dict[str, float] = {}
        total = 0.0
        for state in states:
            mesh = pair.mesh("drive", positions=_GRID[0], points_per_line=_GRID[1], **state)
            load = mesh.load(torque).grids.fine
            if load.reason:
                raise ConvergenceError(load.reason, f"no load distribution at {torque:g} N m")
            edges = edge_load(load, mesh.grids.teeth)
            total = max(total, edges.share)
            worst = {e: max(worst.get(e, 0.0), edges.shares.get(e, 0.0)) for e in worst | edges.shares}
        shares.append(total)
        if total < EDGE_LIMIT:
            return LoadSizing(targets, tuple(shares))
        targets = _grown(targets, worst)
    raise ConvergenceError(
        "edges_carry",
        f"edges still carry {100.0 * shares[-1]:.2g} % of {torque:g} N m after {_STEPS} steps: use less torque, larger "
        "teeth, or a smaller box of misalignments",
    )


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


def _grown(targets: SettingsInput, shares: Mapping[str, float]) -> SettingsInput:
    """Targets with more relief at the loaded edges, and more crowning at loaded toe and heel."""
    changed: dict[str, MemberTargets] = {}
    crowning = {"toe": 1.0, "heel": 1.0}
    for name in MEMBERS:
        member: MemberTargets = getattr(targets, name)
        parts = {}
        for edge in ("tip", "toe", "heel"):
            share = shares.get(f"{name} {edge}", 0.0)
            own: EdgeRelief = getattr(member.edge_relief, edge)
            if share > 0.1 * EDGE_LIMIT:
                factor = min(max((share / EDGE_LIMIT) ** 0.3, _GROWTH[0]), _GROWTH[1])
                parts[edge] = own.model_copy(update={"amount": min(own.amount * factor, 0.2 * own.length, 1e-3)})
                if edge != "tip":
                    crowning[edge] = max(crowning[edge], factor**_CROWNING)
        changed[name] = member.model_copy(update={"edge_relief": member.edge_relief.model_copy(update=parts)})

    def crowned(flank: FlankTarget) -> FlankTarget:
        more = {f"crowning_{end}": getattr(flank, f"crowning_{end}") * factor for end, factor in crowning.items()}
        if targets.cutting.pinion == "conjugate":  # equal at both ends
            more = dict.fromkeys(more, math.sqrt(math.prod(more.values())))
        return flank.model_copy(update=more)

    both = {side: crowned(getattr(targets.targets, side)) for side in ("drive", "coast")}
    return targets.model_copy(update={**changed, "targets": targets.targets.model_copy(update=both)})
