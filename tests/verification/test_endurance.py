"""A sample of the endurance campaign: mutated files of every kind give an answer or one clear refusal."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

KINDS = 23


def test_mutated_files_of_every_kind_give_an_answer_or_a_refusal(tmp_path: Path) -> None:
    tallies = importlib.import_module("endurance").campaign(40, 1, [0], 60.0, tmp_path)
    by_reader = [tally for tally in tallies if not tally.kind.endswith("by command")]
    assert len(by_reader) == KINDS
    assert {tally.kind: tally.faults for tally in tallies if tally.faults} == {}
    for tally in by_reader:
        assert sum(tally.counts.values()) == 40
        assert tally.counts["answer"] > 0
        assert tally.counts["refusal"] > 0


def test_the_campaign_sees_what_it_looks_for() -> None:
    """A reader that crashes, one that hangs, one with an impossible answer, one that says nothing."""
    endurance, made = importlib.import_module("endurance"), importlib.import_module("endurance_kinds")
    errors = importlib.import_module("ehl")

    def hang() -> None:
        raise endurance.Hang

    def refuse(text: str) -> None:
        raise errors.InputError("field", 1, text)

    outcomes = {
        "traceback": lambda: 1 // 0,
        "hang": hang,
        "impossible": lambda: made.finite([float("nan")], "mu"),
        "refusal": lambda: refuse("2"),
        "answer": lambda: None,
    }
    assert {name: endurance.outcome(task)[0] for name, task in outcomes.items()} == {name: name for name in outcomes}
    with pytest.raises(made.Impossible):
        made.finite([0.0], "viscosity", 0.0)
