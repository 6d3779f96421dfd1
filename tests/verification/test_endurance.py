"""Mutated files of every kind give an answer or one clear refusal."""

import warnings
from pathlib import Path

import numpy as np
import pytest
from mutated_files import Hang, Impossible, finite, kinds, outcome, run

from ehl import InputError

INPUTS = 40


def test_mutated_files_of_every_kind_give_an_answer_or_a_refusal(tmp_path: Path) -> None:
    found = kinds(tmp_path)
    assert len(found) == 23
    for name, kind in found.items():
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tally = run(kind, INPUTS, tmp_path / f"input{kind.suffix}", f"0 {name} False")
        assert dict(tally.faults) == {}, name
        assert sum(tally.counts.values()) == INPUTS
        assert tally.counts["answer"] > 0
        assert (tally.counts["refusal"] > 0) == (name != "quantities")  # which refuses within a file


def test_the_outcomes_are_distinguished() -> None:
    """A reader that crashes, one that hangs, one with an impossible answer, one that refuses."""

    def hang() -> None:
        raise Hang

    def refuse() -> None:
        raise InputError("field", 1, "2")

    outcomes = {
        "traceback": lambda: 1 // 0,
        "hang": hang,
        "impossible": lambda: finite([float("nan")], "mu"),
        "refusal": refuse,
        "answer": lambda: None,
    }
    assert {name: outcome(task)[0] for name, task in outcomes.items()} == {name: name for name in outcomes}
    with pytest.raises(Impossible):
        finite([0.0], "viscosity", 0.0)
