"""Reasons of a status as sentences, from `data/reasons.csv`."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from functools import cache

from ehl.common.data import data_path


@cache
def _sentences() -> Mapping[str, str]:
    with data_path("reasons.csv").open(encoding="utf-8", newline="") as file:
        return {row["reason"]: row["sentence"] for row in csv.DictReader(file)}


def reason_text(reason: str) -> str:
    """A reason in words, also one that is followed by a colon and its detail; any other text as it is."""
    code, mark, detail = reason.partition(": ")
    return _sentences().get(code, code) + mark + detail
