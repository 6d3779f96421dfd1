"""Samples of the campaigns of `tests/twins`: random contacts, and the same contact seen otherwise."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from twins.contact_invariances import cases, checked

ROOT = Path(__file__).parents[3]


def test_sample_of_the_campaign() -> None:
    """No traceback, no contact over its budget, no impossible answer; nine of ten that are accepted have an answer."""
    command = [sys.executable, "-m", "validation", "contact_campaign", "--count", "64", "--seed", "7", "--jobs", "1"]
    ended = subprocess.run(command, cwd=ROOT, env=dict(os.environ), capture_output=True, text=True, timeout=500)
    assert ended.returncode == 0, ended.stderr
    found = {text: int(number) for number, text in re.findall(r"^ +(\d+)  (.+)$", ended.stdout, flags=re.M)}
    assert sum(found.values()) == 64
    assert not [text for text in found if text[0].isupper()], found
    failed = sum(number for text, number in found.items() if text.startswith("failed"))
    assert failed <= 0.1 * (64 - found.get("refused", 0)), found


ROWS = cases(4, 11)
CHANGES = [{"exchanged", "other units"}, {"exchanged", "other units", "mirrored", "twice the size"}]


@pytest.mark.parametrize("number", range(2))
def test_the_same_contact_seen_otherwise(number: int) -> None:
    found = checked(number, ROWS[number], 1.0, 128)
    assert {row["change"] for row in found} == CHANGES[number]
    # film ratios from 0.5 on: no history that amplifies the last digit
    assert all(row["equal"] and row["inside"] for row in found)
