"""Report sections, figures (trade-offs, parallel coordinates, progress) and design files of an optimisation."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from efficiency.loss.efficiency_result import EfficiencyResult
from efficiency.machine_settings.design_file import targets_text
from efficiency.machine_settings.inputs import targets_next_to
from efficiency.optimisation.check import CHECK_GRID
from efficiency.optimisation.evaluation import Evaluation, duty_results, settings_of, targets_of
from efficiency.optimisation.problem import EDGE_FREE, START, state_text
from efficiency.optimisation.result import Candidate, Optimisation, state_of
from efficiency.output.flank_map import FlankMap
from efficiency.output.gear_report import SPIN
from efficiency.output.plots_flank import LOSS, PRESSURE, contact_figure, field_figure, field_values
from efficiency.output.plots_load import plot_transmission_error
from efficiency.output.tables import timing
from efficiency.pair import GearPair
from ehl.common.data import reason_text
from ehl.common.figures import BLUE, GREY, ORANGE, axes_or_new, new_figure
from ehl.common.files import write_file
from ehl.common.notes import GRADES, Note
from ehl.common.quantities import quantities
from ehl.common.sections import Head, Item, KeyFigures, MainResult, Medium, Notes, Picture, Row, Section, Text
from ehl.common.table import Column, Table
from regression.friction.published_registry import model_label

_LIGHT = "0.8"
# axes end at this multiple of the start, so that the front remains visible
_VIEW = 1.6


def optimisation_figures(result: Optimisation) -> list[Picture]:
    """Figures of a search."""
    trade = (
        "Points of the search: grey above a limit, blue within all limits, orange the front; the square is the start. "
        "Figures are relative to the start, the edge load in % of the torque; the dashed line is the limit."
    )
    parallel = (
        "Parallel coordinates of the front: variables between their bounds, then figures relative to the start, edge "
        "load in % of the torque; one line for each point, darker for less loss."
    )
    progress = "Lowest first objective within the limits over the evaluations."
    return [
        Picture(partial(trade_figure, result), trade, "trade"),
        Picture(partial(parallel_figure, result), parallel, "parallel"),
        Picture(partial(plot_optimisation, result), progress, "progress"),
    ]


def _scale(result: Optimisation, name: str) -> float:
    """Divisor of an axis: the figure of the start; the unit for shares of the torque, which may vanish there."""
    start = result.start.figures[name]
    return start if start > 0.0 and name != "edge_load_share" else float(quantities()[name].to_si(1.0))


def _shares(points: list[Evaluation], result: Optimisation, name: str) -> np.ndarray:
    return np.array([point.figures[name] for point in points]) / _scale(result, name)


def _label(result: Optimisation, name: str) -> str:
    quantity = quantities()[name]
    scale = _scale(result, name)
    if scale == result.start.figures[name]:
        return f"{quantity.label}\nrelative to the start, {quantity.text(scale)} [-]"
    return quantity.axis_label


def trade_figure(result: Optimisation) -> Figure:
    """First objective over each of the others and the limited figures."""
    first, *rest = result.problem.figures
    names = rest[:3] or [first]
    figure = new_figure(1.0 + 3.6 * len(names), 3.8)
    computed = [point for point in result.evaluations if point.figures]
    front = list(result.front)
    within = [p for p in computed if p.feasible(result.allowed)]
    beyond = [p for p in computed if not p.feasible(result.allowed)]
    for axes, name in zip(np.atleast_1d(figure.subplots(1, len(names), sharey=True)), names, strict=True):
        for points, style in (
            (beyond, {"color": _LIGHT, "s": 12, "label": "above a limit"}),
            (within, {"color": BLUE, "s": 16, "label": "within the limits"}),
            (front, {"color": ORANGE, "s": 26, "label": "front"}),
            ([result.start], {"color": "k", "s": 40, "marker": "s", "label": "start"}),
        ):
            axes.scatter(_shares(points, result, name), _shares(points, result, first), **style)
        across = _shares(computed, result, name)
        if name in result.allowed:
            limit = result.allowed[name] / _scale(result, name)
            axes.axvline(limit, color=GREY, lw=0.8, ls="--")
            across = np.append(across, limit)
        _window(axes, across, _shares(computed, result, first))
        axes.set_xlabel(_label(result, name))
        axes.grid(alpha=0.3)
    figure.axes[0].set_ylabel(_label(result, first))
    figure.axes[0].legend(fontsize=8, frameon=False)
    return figure


def _window(axes: Axes, across: np.ndarray, up: np.ndarray) -> None:
    """Limit the axes to the points near the start."""
    for values, limits in ((across, axes.set_xlim), (up, axes.set_ylim)):
        near = values[values < _VIEW * max(1.0, float(np.median(values)))]
        low, high = float(near.min()), float(near.max())
        gap = 0.06 * max(high - low, 1e-3)
        limits(low - gap, high + gap)


def parallel_figure(result: Optimisation) -> Figure:
    """One line for each point of the front over variables and figures."""
    variables, names = result.problem.variables, result.problem.figures
    front = list(result.front) or [result.start]
    columns = [np.array([v.place(point.variables[v.name]) for point in front]) for v in variables]
    shares = [_shares(front, result, name) for name in names]
    own = [v.place(result.problem.start_values[v.name]) for v in variables]
    starts = [result.start.figures[name] / _scale(result, name) for name in names]
    ranges = [(min(float(s.min()), at), max(float(s.max()), at)) for s, at in zip(shares, starts, strict=True)]
    many = len(variables) + len(names)
    figure = new_figure(min(2.0 + 1.1 * many, 13.0), 4.4 if many < 12 else 6.0)
    axes = figure.add_subplot()

    def between(value: Any, span: tuple[float, float]) -> Any:
        return (value - span[0]) / (span[1] - span[0]) if span[1] > span[0] else 0.0 * value + 0.5

    lines = np.array([*columns, *map(between, shares, ranges)])
    start = [*own, *map(between, starts, ranges)]
    order = np.argsort(np.argsort(shares[0]))
    for k in range(len(front)):
        strength = 1.0 - 0.8 * order[k] / max(len(front) - 1, 1)
        axes.plot(lines[:, k], color=BLUE, alpha=float(strength), lw=1.2)
    axes.plot(start, color="k", lw=1.6, ls="--", marker="s", ms=4, label="start")
    heads = [f"{v.quantity.label}\n{v.quantity.span(v.low, v.high)}" for v in variables]
    heads += [
        f"{quantities()[name].label}\n"
        + (f"{low:.2g} to {high:.2g} %" if name == "edge_load_share" else f"{100.0 * low:.0f} to {100.0 * high:.0f} %")
        for name, (low, high) in zip(names, ranges, strict=True)
    ]
    axes.set_xticks(
        range(len(heads)), heads, **({"rotation": 60, "ha": "right"} if many < 12 else {"rotation": 90}), fontsize=8
    )
    axes.set_yticks([0.0, 1.0], ["low", "high"])
    axes.set_xlabel("variables between their bounds, figures relative to the start [-]")
    axes.grid(axis="x", alpha=0.4)
    axes.legend(fontsize=8, frameon=False, loc="upper right")
    return figure


def plot_optimisation(result: Optimisation, ax: Axes | None = None) -> Axes:
    """Least value of the first objective so far, over the evaluations."""
    name = result.problem.objectives[0]
    axes = axes_or_new(ax, 6.4, 3.4)
    kept = np.array([p.figures[name] if p.feasible(result.allowed) else np.inf for p in result.evaluations])
    least = np.minimum.accumulate(kept)
    scale = result.start.figures[name]
    known = np.isfinite(least)
    axes.step(np.flatnonzero(known), least[known] / scale, where="post", color=BLUE, lw=1.5)
    within = np.isfinite(kept)
    axes.scatter(np.flatnonzero(within), kept[within] / scale, color=GREY, s=10)
    axes.set(xlabel="evaluations [-]", ylabel=_label(result, name))
    axes.grid(alpha=0.3)
    return axes


_POINTS_SHOWN = 8


def _variable(name: str) -> Column:
    return Column(name, of=f"optimise.{name}")


def change_text(share: float) -> str:
    """A change with its sign, in percent."""
    return f"{100.0 * share:+.1f} %" if math.isfinite(share) else "–"


def _figure_change(best: Candidate, name: str) -> str:
    """Change of a figure; the edge load is stated in % of the torque, because that of the start may vanish."""
    if name != "edge_load_share":
        return change_text(best.change(name))
    return f"{100.0 * best.exact.figures[name]:.2g} % ({100.0 * best.start.figures[name]:.2g} % before)"


def evaluations_table(result: Optimisation) -> Table:
    """Every evaluation of the search, in its order."""
    variables = [v.name for v in result.problem.variables]
    names, front = result.problem.figures, {point.key for point in result.front}

    def exceeded(point: Evaluation) -> str:
        excess = point.excess(result.allowed).items()
        return ", ".join(f"{quantities()[name].label} {change_text(share)}" for name, share in excess)

    rows = []
    for number, p in enumerate(result.evaluations):
        values = *(p.variables[name] for name in variables), *(p.figures.get(name, math.nan) for name in names)
        found = state_of(p, result.allowed), p.key in front, p.reason or exceeded(p)
        rows.append((number, *values, *found, p.seconds))
    columns: list[Column | str] = ["number", *map(_variable, variables), *names, "status", "front", "reason", "seconds"]
    return Table(columns, rows, name="evaluations")


def front_table(result: Optimisation) -> Table:
    """The Pareto front of the search, in the order of the first objective."""
    variables = [v.name for v in result.problem.variables]
    names = result.problem.figures
    checked = {candidate.point.key: candidate.name for candidate in result.candidates}
    start = result.start.figures
    rows = []
    for point in result.front:
        loss = point.figures["power_loss"] / start["power_loss"] - 1.0 if "power_loss" in start else math.nan
        values = *(point.figures[name] for name in names), *(point.variables[name] for name in variables)
        rows.append((checked.get(point.key, ""), loss, *values))
    heads: list[Column | str] = [Column("design", label="checked as"), "loss_change", *names]
    title = "Pareto front of the search on its coarse mesh: no point within the limits is better in all objectives."
    return Table([*heads, *map(_variable, variables)], rows, title, name="pareto")


def candidates_table(result: Optimisation) -> Table:
    """Start and checked points on the full mesh in all states, one column each."""
    names, variables = result.problem.figures, [v.name for v in result.problem.variables]
    unknown = math.nan, math.nan
    start, at = f"{result.name} (start)", result.problem.start_values
    checked = [(start, 0.0, unknown, unknown, c.start.figures, at, "start") for c in result.candidates[:1]]
    if not checked:
        coarse = f"{result.name} (start, mesh of the search)"
        checked = [(coarse, 0.0, unknown, unknown, result.start.figures, at, "")]
    for c in result.candidates:
        gains = c.change("power_loss"), c.gain_interval, c.solved_gain
        checked.append((c.name, *gains, c.exact.figures, c.point.variables, c.verdict))
    rows = [
        (name, loss, *gain, *solved, *(got.get(n, math.nan) for n in names), *(at[n] for n in variables), verdict)
        for name, loss, gain, solved, got, at, verdict in checked
    ]
    heads = ("loss_change", "gain_lower", "gain_upper", "solved_gain", "solved_gain_error")
    columns = [*map(Column, ("design", *heads, *names)), *map(_variable, variables), Column("verdict")]
    optional = ("gain_lower", "gain_upper", *(name for name in heads if name.startswith("solved")))
    kept = [k for k, c in enumerate(columns) if c.name not in optional or any(_known(row[k]) for row in rows)]
    kept = kept if result.candidates else kept[:-1]
    shown = [tuple(row[k] for k in kept) for row in rows]
    return Table([columns[k] for k in kept], shown, headline(result), (_timing(result),), "candidates", vertical=True)


def _timing(result: Optimisation) -> str:
    """A search without a better point is complete as well."""
    return timing(result, f"{len(result.evaluations)} evaluations", "search completed")


def _known(value: object) -> bool:
    return isinstance(value, float) and math.isfinite(value)


def headline(result: Optimisation) -> str:
    """The result in one sentence."""
    best = result.best
    if best is None:
        return f"{result.name}: {reason_text(result.reason)}."
    low, high = best.gain_interval
    interval = f" (90 % interval {100.0 * low:.1f} to {100.0 * high:.1f} %)" if math.isfinite(low) else ""
    first = quantities()[result.problem.objectives[0]].label
    if result.problem.objectives[0] == "power_loss":
        return f"{result.name}: {100.0 * best.gain:.1f} % less loss{interval} within all limits; design {best.name}."
    change = change_text(best.change(result.problem.objectives[0]))
    return f"{result.name}: {first} {change}, loss {change_text(best.change('power_loss'))}{interval}; {best.name}."


def optimisation_sections(result: Optimisation, medium: Medium) -> list[Section]:
    """Sections of an optimisation: result, comparison with the start, trade-offs, checked designs, search."""
    if medium == "files":
        tables = [front_table(result), candidates_table(result), evaluations_table(result)]
        return [Section("", [Head(headline(result)), *tables])]
    if medium == "terminal":
        return [Section("", [candidates_table(result), Notes(_notes(result))])]
    head = Head(
        f"Less loss: {result.name}",
        f"{duty_text(result)}; {result.problem.oil}, friction: {model_label(result.problem.friction)}",
        f"{_timing(result).capitalize()}. {SPIN}",
    )
    return [
        Section("", [head, *_answer(result)]),
        *_before_after(result),
        Section("Trade-offs", optimisation_figures(result)),
        Section("Checked designs", [replace(candidates_table(result), title="", notes=())]),
        Section("Search", _search(result)),
    ]


def write_designs(result: Optimisation, folder: Path) -> list[Path]:
    """Design file, targets and machine summary of each checked point.

    Raises `InputError`: the folder cannot be written.
    """
    written = []
    for candidate in result.candidates:
        path = folder / f"{candidate.name}.toml"
        write_file(path, design_head(result, candidate) + result.settings(candidate).text, "output")
        GearPair(path).export(folder / candidate.name, ("summary",))
        inputs = targets_of(result.problem, candidate.point.variables, candidate.name)
        file = targets_next_to(path)
        write_file(file, targets_text(inputs, f"Targets of {path.name}."), "output")
        written += [path, file]
    return written


def duty_text(result: Optimisation) -> str:
    """The operating point or the duty cycle in words."""
    rows, known = result.problem.duty, quantities()
    if len(rows) == 1:
        at = (("torque", rows[0].torque), ("speed", rows[0].speed), ("temperature", rows[0].temperature))
        return ", ".join(known[name].text(value) for name, value in at)
    return f"duty cycle of {len(rows)} operating points, {sum(row.hours for row in rows):.4g} h"


def design_head(result: Optimisation, candidate: Candidate) -> str:
    """Comment at the top of a design file: its origin and its changes against the start."""
    changes = ", ".join(
        f"{quantities()[name].label} {change_text(candidate.change(name))}" for name in result.problem.figures
    )
    values = ", ".join(f"{name} {candidate.point.variables[name]:.10g}" for name in candidate.point.variables)
    lines = [
        f"Found by `mixed-ehl optimise` from {result.name}, {duty_text(result)}, over",
        f"{len(result.problem.states)} states. Changes against the start: {changes}.",
        f"Variables in SI units, targets of the {result.problem.flanks} flanks: {values}.",
    ]
    return "".join(f"# {line}\n" for line in lines)


def _notes(result: Optimisation) -> list[Note]:
    known = ("gain by kind of variable", "the search uses")
    return [Note("for information" if note.startswith(known) else "warning", note) for note in result.notes]


def _answer(result: Optimisation) -> list[Item]:
    best = result.best
    notes = _notes(result)
    if best is None:
        answer = MainResult("no better design", f"{result.name}: {reason_text(result.reason)}")
        none = "The search found no better point within the limits."
        return [answer, Notes(notes, none=none)]
    known = quantities()
    first = result.problem.objectives[0]
    low, high = best.gain_interval
    rows: list[tuple[str, str]] = []
    if math.isfinite(low):
        interval = f"{100.0 * low:.1f} to {100.0 * high:.1f} % less loss"
        rows.append((interval, "90 % interval from oil, surfaces and formula, aligned pair; fully correlated errors"))
        if low <= 0.0:
            text = "the interval of the gain includes zero: the gain is smaller than the uncertainty of friction"
            notes.insert(0, Note("warning", text))
    gain, error = best.solved_gain
    if math.isfinite(gain):
        predicted = 1.0 - best.exact.losses["aligned"][0] / best.start.losses["aligned"][0]
        text = f"less loss with solved contacts, aligned; predicted by the formula: {100.0 * predicted:.1f} %"
        rows.append((f"{100.0 * gain:.1f} ±\N{NO-BREAK SPACE}{100.0 * error:.1f} %", text))
    uncertain = [
        c.name for c in result.candidates if c is not best and c.holds and c.gain > 0.0 and c.gain_interval[0] <= 0.0
    ]
    if uncertain:
        text = f"other designs with a gain smaller than the uncertainty of friction: {', '.join(uncertain)}"
        notes.append(Note("warning", text))
    worse = [name for name in result.problem.figures if best.change(name) > 0.005]
    free = {"edge_load_share"} if best.exact.figures.get("edge_load_share", 1.0) <= EDGE_FREE else set()
    costs = [name for name in worse if name not in free]
    price = ", ".join(f"{known[name].label} {_figure_change(best, name)}" for name in costs)
    if price:
        notes.append(Note("warning", f"increased figures: {price}"))
    else:
        negligible = ", except the edge load, which is negligible" if worse else ""
        notes.append(Note("for information", f"no objective and no limited figure has increased{negligible}"))
    if math.isfinite(low):
        ends, loss = best.exact.losses["interval"], best.exact.losses["aligned"][0]
        span = f"{change_text(ends[0] / loss - 1.0)} to {change_text(ends[1] / loss - 1.0)}"
        notes.append(Note("for information", f"90 % interval of the loss itself: {span}"))
    others = [name for name in result.problem.figures if name != first]
    return [
        MainResult(change_text(best.change(first)), f"{known[first].label}, {best.name} against the start", rows),
        KeyFigures([(_figure_change(best, name), known[name].label) for name in others]),
        Notes(sorted(notes, key=lambda note: GRADES.index(note.grade))),
    ]


def _before_after(result: Optimisation) -> list[Section]:
    """Contact pattern, pressure, loss and transmission error of start and best design, aligned, first duty row."""
    best, known = result.best, quantities()
    if best is None:
        return []
    before = GearPair(settings_of(result.problem, {}).design)
    both = before, GearPair(result.settings(best).design)
    results: list[EfficiencyResult] = [duty_results(pair, result.problem, {}, CHECK_GRID)[0] for pair in both]
    maps = [FlankMap.of(pair.design.flanks(), found) for pair, found in zip(both, results, strict=True)]
    names = (f"Start: {result.name}", f"Optimised: {best.name}")
    # both on the same scale for comparison
    pressure, loss = (max(float(np.nanmax(field_values(m, what))) for m in maps) for what in (PRESSURE, LOSS))
    figures: tuple[tuple[str, list[Callable[[], Figure | Axes]]], ...] = (
        ("contact pattern under load", [partial(contact_figure, m, top=pressure) for m in maps]),
        (known[PRESSURE].label, [partial(field_figure, m, PRESSURE, top=pressure) for m in maps]),
        (known[LOSS].label, [partial(field_figure, m, LOSS, top=loss) for m in maps]),
        ("transmission error", _on_one_scale(results)),
    )
    rows = [
        Row([Picture(draw, f"{name}, {what}.") for name, draw in zip(names, drawn, strict=True)])
        for what, drawn in figures
    ]
    return [Section("Start and optimised design, aligned, at the first operating point", rows)]


def _on_one_scale(results: list[EfficiencyResult]) -> list[Callable[[], Figure | Axes]]:
    """Transmission errors of both results with the same vertical axis."""
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
    loss = "mean" if problem.over == "mean" else "maximum"
    counts = Counter(state_of(point, result.allowed) for point in result.evaluations)
    reasons = Counter(p.reason.partition(":")[0] for p in result.evaluations if p.reason)
    rows = [(reason_text(reason), count) for reason, count in reasons.most_common(_POINTS_SHOWN)]
    blocks: list[Item] = [
        Text(f"Variables ({problem.flanks} flanks): {spans}."),
        Text(f"Limits: {allowed or 'none'}. An edge load below {100.0 * EDGE_FREE:g} % of the torque is negligible."),
        Text(f"States: {states}. The loss is the {loss} over them; all other figures are the worst."),
        Text(
            f"{len(result.evaluations)} evaluations with seed {result.seed}: {counts['feasible']} within the limits, "
            f"{counts['limit']} above a limit, {counts['failed']} without a design or a result. All are listed in "
            "evaluations.csv and in points.jsonl; problem.json holds the problem. The same command resumes the search."
        ),
    ]
    if rows:
        blocks.append(Table(("reason of failure", "points"), rows))
    blocks.append(front_table(result))
    return blocks
