"""Errors of the program as tests expect them: by their field or reason, not by their wording."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from ehl.common.errors import ConvergenceError, InputError


@contextmanager
def refuses(field: str) -> Iterator[pytest.ExceptionInfo[InputError]]:
    """An `InputError` that names this field."""
    with pytest.raises(InputError) as caught:
        yield caught
    assert caught.value.field == field


@contextmanager
def fails(reason: str) -> Iterator[pytest.ExceptionInfo[ConvergenceError]]:
    """A `ConvergenceError` with this reason."""
    with pytest.raises(ConvergenceError) as caught:
        yield caught
    assert caught.value.reason == reason
