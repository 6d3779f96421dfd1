"""Standard output of the commands: its width, and texts that are wrapped at it."""

from __future__ import annotations

import os
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console
    from rich.text import Text

_WIDTH = 80  # characters of a line where the output is no terminal
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f]")


def terminal() -> Console:
    """Standard output; a file or pipe has lines of 80 characters unless the variable COLUMNS is set."""
    from rich.console import Console

    console = Console(highlight=False)
    return console if console.is_terminal or "COLUMNS" in os.environ else Console(width=_WIDTH, highlight=False)


def print_text(text: str, indent: int = 0) -> None:
    """Print a text wrapped at the width of the output; lines after the first are indented.

    Words longer than the width, such as paths, stay whole.
    """
    from rich.text import Text

    console = terminal()
    lines = Text(plain(text), overflow="ignore").wrap(console, max(console.width - indent, 1))
    for number, line in enumerate(lines):
        line.rstrip()
        if number and indent:
            line.pad_left(indent)
        console.print(line, soft_wrap=True)


def wrapped(text: str, style: str = "") -> Text:
    """A text without control characters that is wrapped at the width."""
    from rich.text import Text

    return Text(plain(text), style, overflow="fold")


def plain(text: str) -> str:
    """Text without control characters."""
    return _CONTROL.sub(" ", text)
