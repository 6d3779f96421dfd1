"""Printing on the terminal: a table, or JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any


def print_json(content: dict[str, Any]) -> None:
    """One JSON object on standard output, strict (no NaN)."""
    print(json.dumps(content, allow_nan=False))


def print_rows(title: str, rows: Sequence[tuple[str, str, str]], lines: Sequence[str]) -> None:
    """Print quantities with values and units as a table, and lines of text below it."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title=title)
    table.add_column("quantity")
    table.add_column("value", justify="right")
    table.add_column("unit")
    for row in rows:
        table.add_row(*row)
    console = Console()
    console.print(table)
    for line in lines:
        console.print(line)
