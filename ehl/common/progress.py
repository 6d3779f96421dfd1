"""How far long work is: told deep inside of it, shown by whoever listens."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Listener = Callable[..., None]
_listener: ContextVar[Listener | None] = ContextVar("listener", default=None)


def tell(step: str, done: int, total: int, seconds: float | None = None) -> None:
    """Say that so many parts of a step are done, and how long the others will take as estimated; nobody may listen."""
    listener = _listener.get()
    if listener is not None:
        listener(step, done, total, *(() if seconds is None else (seconds,)))


@contextmanager
def listening(listener: Listener) -> Iterator[None]:
    """Hear what is told in the block."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)
