"""Graded notes on the results of a gear pair for terminal and pages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from efficiency.loss.efficiency_result import pair_notes
from efficiency.output.tables import operating_state, percent
from ehl.common.data import reason_text
from ehl.common.quantities import quantity
from ehl.common.sections import Notes
from regression.friction.published_registry import model_label

if TYPE_CHECKING:
    from efficiency.conditions.duty import DutyCycle
    from efficiency.conditions.grid import Grid
    from efficiency.loss.compare import Comparison
    from efficiency.loss.efficiency_result import EfficiencyResult
    from ehl.common.notes import Note


def result_notes(
    result: EfficiencyResult, of_design: Sequence[str] = (), case: str = "", *, strength: bool = True
) -> list[tuple[str, str]]:
    """Case and text of all notes on one operating point.

    of_design: notes on the unloaded pair.
    case: name of the operating point.
    strength: whether the grades of the strength are included.
    """
    said = [f"not converged: {reason_text(result.reason)}"] if result.status != "converged" else []
    edges = False
    if strength and result.has_strength:
        said += [grade.text for grade in result.strength.grades]
        edges = any(grade.kind == "edges" for grade in result.strength.grades)
    # the grade of the edge load contains a remedy and replaces the note
    said += [note for note in result.notes if not (edges and note.startswith("edges carry"))]
    if outside := outside_note(result.outside_range_share, model_label(result.friction_model)):
        warmest = float(result.points.state.temperature_oil.max())
        said.append(f"{outside}; oil at the teeth {quantity('temperature').text(warmest)}")
    # notes on the unloaded pair belong to all cases
    return [(case, text) for text in said] + [("", note) for note in of_design if note not in said]


def grid_notes(grid: Grid) -> Notes:
    """Notes of a map, one for each kind with the worst point."""
    return Notes(pair_notes(said_of_grid(grid)), len(grid.results))


def said_of_grid(grid: Grid) -> list[tuple[str, str]]:
    """Operating point and text of all notes on a map; grades of strength where requested."""
    solved = [(point.result, bool(point.requested.get("strength"))) for point in grid.points if point.result]
    return [
        pair for result, graded in solved for pair in result_notes(result, (), operating_state(result), strength=graded)
    ]


def duty_notes(cycle: DutyCycle) -> Notes:
    """Notes of a duty cycle, one for each kind with the worst row of the cycle."""
    said = []
    for number, point in enumerate(cycle.points, start=1):
        row = f"row {number}"
        if point.result is None:
            said += [(row, f"no result: {note}") for note in point.notes]
        else:
            said += result_notes(point.result, (), row)
    return Notes(pair_notes(said), len(cycle.points))


def comparison_notes(comparison: Comparison) -> list[Note]:
    """Notes of a comparison, one for each kind with the model for which it is worst."""
    return pair_notes(
        pair for result in comparison.results for pair in result_notes(result, (), model_label(result.friction_model))
    )


def outside_note(share: float, model: str) -> str:
    """A note if more than 1 % of the sliding power lies outside the range of a friction model; otherwise empty."""
    text = f"{percent(share, 1)} % of the sliding power lies outside the range of {model}; friction `ehl` has no range"
    return text if share > 0.01 else ""
