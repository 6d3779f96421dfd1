"""Sections and design files of a search."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.machine_settings.design_file import targets_text
from efficiency.machine_settings.inputs import targets_beside
from efficiency.optimisation.check import CHECK_GRID
from efficiency.optimisation.evaluation import duty_results, settings_of, targets_of
from efficiency.optimisation.plots import optimisation_figures, progress_figure
from efficiency.optimisation.problem import EDGE_FREE, START, state_text
from efficiency.optimisation.result import state_of
from efficiency.output.flank_map import FlankMap
from efficiency.output.gear_report import SPIN
from efficiency.output.plots_flank import LOSS, PRESSURE, contact_figure, field_figure, field_values
from efficiency.output.plots_load import plot_transmission_error
from efficiency.pair import GearPair
from ehl.common.files import write_file
from ehl.common.notes import GRADES, Note
from ehl.common.quantities import quantities
from ehl.common.sections import Head, Item, KeyFigures, MainResult, Medium, Notes, Picture, Row, Section, Text
from ehl.common.table import Column, Table
from regression.friction.published_registry import model_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from efficiency.optimisation.evaluation import Evaluation
    from efficiency.optimisation.result import Candidate, Optimisation

_POINTS_SHOWN = 8


def _variable(name: str) -> Column:
    return Column(name, of=f"optimise.{name}")


def change_text(share: float) -> str:
    """A change with its sign, in percent."""
    return f"{100.0 * share:+.1f} %" if math.isfinite(share) else "–"


def _edge_free(best: Candidate, name: str) -> bool:
    """Whether edges carry so little that it counts as none."""
    return name == "edge_load_share" and best.exact.figures[name] <= EDGE_FREE


def _figure_change(best: Candidate, name: str) -> str:
    """Change of a figure; a share of the torque as it is, since that of the start may be next to nothing."""
    if name != "edge_load_share":
        return change_text(best.change(name))
    return f"{100.0 * best.exact.figures[name]:.2g} % ({100.0 * best.start.figures[name]:.2g} % before)"


def evaluations_table(result: Optimisation) -> Table:
    """Every evaluation of the search, in its order."""
    variables = [v.name for v in result.problem.variables]
    names, front = result.problem.figures, {point.key for point in result.front}
    rows = [
        (
            number,
            *(point.variables[name] for name in variables),
            *(point.figures.get(name, math.nan) for name in names),
            state_of(point, result.allowed),
            point.key in front,
            point.reason or limit_text(point, result.allowed),
            point.seconds,
        )
        for number, point in enumerate(result.evaluations)
    ]
    columns: tuple[Column | str, ...] = (
        "number",
        *map(_variable, variables),
        *names,
        "status",
        "front",
        "reason",
        "seconds",
    )
    return Table(columns, rows, name="evaluations")


def limit_text(point: Evaluation, allowed: dict[str, float]) -> str:
    """Limits a point exceeds, and by how much."""
    above = [f"{quantities()[name].label} {change_text(share)}" for name, share in point.excess(allowed).items()]
    return ", ".join(above)


def front_table(result: Optimisation) -> Table:
    """The Pareto front of the search, least of the first objective first."""
    variables = [v.name for v in result.problem.variables]
    names = result.problem.figures
    checked = {candidate.point.key: candidate.name for candidate in result.candidates}
    start = result.start.figures
    rows = [
        (
            checked.get(point.key, ""),
            point.figures["power_loss"] / start["power_loss"] - 1.0 if "power_loss" in start else math.nan,
            *(point.figures[name] for name in names),
            *(point.variables[name] for name in variables),
        )
        for point in result.front
    ]
    return Table(
        (Column("design", label="checked as"), "loss_change", *names, *map(_variable, variables)),
        rows,
        title="Pareto front of the search, on its coarse mesh: within the limits nothing beats one of these in all.",
        name="pareto",
    )


def candidates_table(result: Optimisation) -> Table:
    """Start and checked points on the full mesh in all states: a column for each."""
    names, variables = result.problem.figures, [v.name for v in result.problem.variables]
    rows: list[tuple[object, ...]] = []
    if result.candidates:
        first = result.candidates[0]
        own = result.problem.start_values
        rows.append(
            (
                f"{result.name} (start)",
                0.0,
                *(math.nan,) * 4,
                *(first.start.figures[name] for name in names),
                *(own[name] for name in variables),
                "",
            )
        )
    for c in result.candidates:
        rows.append(
            (
                c.name,
                c.change("power_loss"),
                *c.gain_interval,
                *c.solved_gain,
                *(c.exact.figures.get(name, math.nan) for name in names),
                *(c.point.variables[name] for name in variables),
                c.verdict,
            )
        )
    heads = ("loss_change", "gain_lower", "gain_upper", "solved_gain", "solved_gain_error")
    columns = [*map(Column, ("design", *heads, *names)), *map(_variable, variables), Column("verdict")]
    kept = [k for k, c in enumerate(columns) if not c.name.startswith("solved") or any(_known(r[k]) for r in rows)]
    return Table(
        [columns[k] for k in kept],
        [tuple(row[k] for k in kept) for row in rows],
        title=headline(result),
        notes=(timing(result),),
        name="candidates",
        vertical=True,
    )


def _known(value: object) -> bool:
    return isinstance(value, float) and math.isfinite(value)


def headline(result: Optimisation) -> str:
    """The answer in one sentence."""
    best = result.best
    if best is None:
        return f"{result.name}: {result.reason}."
    low, high = best.gain_interval
    interval = f" (90 % interval {100.0 * low:.1f} to {100.0 * high:.1f} %)" if math.isfinite(low) else ""
    first = quantities()[result.problem.objectives[0]].label
    if result.problem.objectives[0] == "power_loss":
        return f"{result.name}: {100.0 * best.gain:.1f} % less loss{interval} within all limits, as {best.name}."
    change = change_text(best.change(result.problem.objectives[0]))
    return f"{result.name}: {first} {change}, loss {change_text(best.change('power_loss'))}{interval}, as {best.name}."


def timing(result: Optimisation) -> str:
    """How many evaluations in what time."""
    again = f", {result.reused} computed before" if result.reused else ""
    workers = "process" if result.jobs == 1 else "processes"
    count = len(result.evaluations)
    return f"{result.status}: {count} evaluations{again}, {result.seconds:.0f} s with {result.jobs} {workers}"


def optimisation_sections(result: Optimisation, medium: Medium) -> list[Section]:
    """Sections of a search: gain and its costs, before and after, trade-offs, checked designs."""
    if medium == "files":
        tables = [front_table(result), candidates_table(result), evaluations_table(result)]
        return [Section("", [Head(headline(result)), *tables])]
    if medium == "terminal":
        return [Section("", [candidates_table(result), Notes([Note("warning", note) for note in result.notes])])]
    head = Head(
        f"Less loss: {result.name}",
        f"{duty_text(result)}; {result.problem.oil}, friction: {model_label(result.problem.friction)}",
        f"{timing(result).capitalize()}. {SPIN}",
    )
    return [
        Section("", [head, *_answer(result)]),
        *_before_after(result),
        Section("The trade", optimisation_figures(result)),
        Section("Checked designs", [replace(candidates_table(result), title="", notes=())]),
        Section("How it was searched", _search(result)),
    ]


def plot_optimisation(result: Optimisation, ax: Axes | None) -> Axes:
    """Least first objective within the limits over the evaluations."""
    return progress_figure(result, ax)


def write_designs(result: Optimisation, folder: Path) -> list[Path]:
    """Design file, targets and machine summary of each checked point.

    Raises `InputError`: the folder cannot be written.
    """
    written = []
    for candidate in result.candidates:
        path = folder / f"{candidate.name}.toml"
        write_file(path, design_head(result, candidate) + result.settings(candidate).text, "output", folder=True)
        GearPair(path).export(folder / candidate.name, ("summary",))
        inputs = targets_of(result.problem, candidate.point.variables, candidate.name)
        beside = targets_beside(path)
        write_file(beside, targets_text(inputs, f"Targets that {path.name} was made from."), "output")
        written += [path, beside]
    return written


def duty_text(result: Optimisation) -> str:
    """The duty in words."""
    rows, known = result.problem.duty, quantities()
    if len(rows) == 1:
        at = (("torque", rows[0].torque), ("speed", rows[0].speed), ("temperature", rows[0].temperature))
        return ", ".join(known[name].text(value) for name, value in at)
    return f"duty cycle of {len(rows)} operating points, {sum(row.hours for row in rows):.4g} h"


def design_head(result: Optimisation, candidate: Candidate) -> str:
    """Comment over a design file: where its ease-off and blank come from and what it does."""
    changes = ", ".join(
        f"{quantities()[name].label} {change_text(candidate.change(name))}" for name in result.problem.figures
    )
    values = ", ".join(f"{name} {candidate.point.variables[name]:.10g}" for name in candidate.point.variables)
    lines = [
        f"Found by `mixed-ehl optimise` from {result.name}, {duty_text(result)}, over",
        f"{len(result.problem.states)} states: {changes} against the start.",
        f"Variables, SI units, targets those of the {result.problem.flanks} flanks: {values}.",
    ]
    return "".join(f"# {line}\n" for line in lines)


def _answer(result: Optimisation) -> list[Item]:
    best = result.best
    notes = [Note("warning", note) for note in result.notes]
    if best is None:
        answer = MainResult("no gain", f"{result.name}: {result.reason}")
        none = "The start is as good as this search finds within its limits."
        return [answer, Notes(notes, none=none)]
    known = quantities()
    first = result.problem.objectives[0]
    low, high = best.gain_interval
    said: list[tuple[str, str]] = []
    if math.isfinite(low):
        interval = f"{100.0 * low:.1f} to {100.0 * high:.1f} % less loss"
        said.append(
            (
                interval,
                "90 % interval by oil, surfaces and formula, aligned pair; fully correlated errors before and after",
            )
        )
        if low <= 0.0:
            text = "the interval of the gain reaches zero: the gain is smaller than the uncertainty of friction"
            notes.insert(0, Note("warning", text))
    gain, error = best.solved_gain
    if math.isfinite(gain):
        text = f"less loss with solved contacts, aligned; the formula promises {100.0 * aligned_gain(best):.1f} %"
        said.append((f"{100.0 * gain:.1f} ±\N{NO-BREAK SPACE}{100.0 * error:.1f} %", text))
    uncertain = [
        c.name for c in result.candidates if c is not best and c.holds and c.gain > 0.0 and c.gain_interval[0] <= 0.0
    ]
    if uncertain:
        notes.append(
            Note("warning", f"others whose gain is smaller than the uncertainty of friction: {', '.join(uncertain)}")
        )
    worse = [name for name in result.problem.figures if best.change(name) > 0.005]
    costs = [name for name in worse if not _edge_free(best, name)]
    price = ", ".join(f"{known[name].label} {_figure_change(best, name)}" for name in costs)
    notes.append(
        Note("warning", f"what it costs: {price}")
        if price
        else Note(
            "for information",
            "no figure of objectives and limits is worse than before"
            + (", but the torque at edges, which is below its least limit" if worse else ""),
        )
    )
    if math.isfinite(low):
        ends, loss = best.exact.losses["interval"], best.exact.losses["aligned"][0]
        text = (
            f"the loss itself is known to {change_text(ends[0] / loss - 1.0)} and {change_text(ends[1] / loss - 1.0)}"
        )
        notes.append(Note("for information", text))
    others = [name for name in result.problem.figures if name != first]
    return [
        MainResult(change_text(best.change(first)), f"{known[first].label}, {best.name} against the start", said),
        KeyFigures([(_figure_change(best, name), known[name].label) for name in others]),
        Notes(sorted(notes, key=lambda note: GRADES.index(note.grade))),
    ]


def aligned_gain(candidate: Candidate) -> float:
    """Gain of the aligned pair by the formula [-]."""
    return 1.0 - candidate.exact.losses["aligned"][0] / candidate.start.losses["aligned"][0]


def _before_after(result: Optimisation) -> list[Section]:
    """Pattern, pressure, loss and transmission error of start and best, aligned, at the first operating point."""
    best = result.best
    if best is None:
        return []
    before = GearPair(settings_of(result.problem, {}).design)
    both = before, GearPair(result.settings(best).design)
    results: list[EfficiencyResult] = [duty_results(pair, result.problem, {}, CHECK_GRID)[0] for pair in both]
    maps = [FlankMap.of(pair.design.flanks(), found) for pair, found in zip(both, results, strict=True)]
    names = (f"Start: {result.name}", f"After: {best.name}")
    # both on one scale, or the eye is misled
    pressure, loss = (max(float(np.nanmax(field_values(m, what))) for m in maps) for what in (PRESSURE, LOSS))
    figures: tuple[tuple[str, list[Callable[[], Figure | Axes]]], ...] = (
        ("pattern under load", [partial(contact_figure, m, top=pressure) for m in maps]),
        (PRESSURE.title, [partial(field_figure, m, PRESSURE, top=pressure) for m in maps]),
        (LOSS.title, [partial(field_figure, m, LOSS, top=loss) for m in maps]),
        ("transmission error", _on_one_scale(results)),
    )
    rows = [
        Row([Picture(draw, f"{name}, {what}.") for name, draw in zip(names, drawn, strict=True)])
        for what, drawn in figures
    ]
    return [Section("Before and after, aligned, at the first operating point", rows)]


def _on_one_scale(results: list[EfficiencyResult]) -> list[Callable[[], Figure | Axes]]:
    """Transmission errors of both results with the same axis."""
    drawn = [plot_transmission_error(found) for found in results]
    low, high = zip(*(axes.get_ylim() for axes in drawn), strict=True)
    for axes in drawn:
        axes.set_ylim(min(low), max(high))
    return [partial(lambda axes: axes, axes) for axes in drawn]


def _search(result: Optimisation) -> list[Item]:
    problem, known = result.problem, quantities()
    spans = ", ".join(f"{v.quantity.label} {v.quantity.span(v.low, v.high)}" for v in problem.variables)
    allowed = ", ".join(
        f"{known[name].label} {known[name].text(value)}{' (start)' if problem.limits[name] == START else ''}"
        for name, value in result.allowed.items()
    )
    states = "; ".join(state_text(state) for state in problem.states)
    loss = "the mean" if problem.over == "mean" else "the worst"
    counts = Counter(state_of(point, result.allowed) for point in result.evaluations)
    reasons = Counter(p.reason.partition(":")[0] for p in result.evaluations if p.reason)
    rows = [(reason, count) for reason, count in reasons.most_common(_POINTS_SHOWN)]
    blocks: list[Item] = [
        Text(f"Variables ({problem.flanks} flanks): {spans}."),
        Text(f"Limits: {allowed or 'none'}. Edge load below {100.0 * EDGE_FREE:g} % of the torque counts as none."),
        Text(f"States: {states}. The loss is {loss} over them, all else the worst."),
        Text(
            f"{len(result.evaluations)} evaluations with seed {result.seed}: {counts['feasible']} within the limits, "
            f"{counts['limit']} beyond one, {counts['failed']} that cannot be made or computed. All are in "
            "evaluations.csv, and in points.jsonl with the problem in problem.json; the same command resumes."
        ),
    ]
    if rows:
        blocks.append(Table(("why a point cannot be made", "points"), rows))
    blocks.append(front_table(result))
    return blocks
