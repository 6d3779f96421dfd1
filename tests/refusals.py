"""Errors of the program as tests expect them: by their field or reason, not by their wording."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from ehl.common.errors import ConvergenceError, InputError


@contextmanager
def refuses(field: str) -> Iterator[pytest.ExceptionInfo[InputError]]:
    """An `InputError` that names this field."""
    with pytest.raises(InputError) as caught:
        yield caught
    assert caught.value.field == field


def refused(outcome: Any, *fields: str) -> None:
    """A command that ends with exit code 2 and a message of a readable length that names these fields."""
    assert outcome.code == 2, outcome
    assert 0 < len(outcome.err) < 5000
    assert [field for field in fields if field not in outcome.err] == []


@contextmanager
def fails(reason: str) -> Iterator[pytest.ExceptionInfo[ConvergenceError]]:
    """A `ConvergenceError` with this reason."""
    with pytest.raises(ConvergenceError) as caught:
        yield caught
    assert caught.value.reason == reason
