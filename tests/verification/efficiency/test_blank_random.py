"""Random sensible blanks are answered, or refused by a listed reason."""

from __future__ import annotations

import math

import pytest
from twins.random_blanks import REASONS, blank_content, run_case

from efficiency.blanks.inputs import PairBlankInput
from efficiency.blanks.pair import pitch_cones


def test_blanks_are_answered_or_refused_by_a_listed_reason() -> None:
    rows = [run_case(2, index, "blank") for index in range(300)]
    assert [row["detail"] for row in rows if row["outcome"] == "wrong"] == []
    assert sum(row["outcome"] == "answered" for row in rows) >= 0.98 * len(rows)
    assert {row["reason"] for row in rows if row["outcome"] == "refused"} <= set(REASONS)


@pytest.mark.parametrize("index", range(0, 60, 5))
def test_converged_cones_lie_near_the_printed_iteration(index: int) -> None:
    # the tolerance of the standard, 1 %, lets delta_2 err by some tenths of a degree
    inputs = PairBlankInput.model_validate(blank_content(2, index))
    converged, printed = (
        pitch_cones(inputs.model_copy(update={"pitch_cones": mode})) for mode in ("converged", "standard")
    )
    assert abs(converged.closure) < 1e-10
    assert abs(math.degrees(converged.pitch_angle_2 - printed.pitch_angle_2)) < 0.5
