"""Command line, folder of results and CSV tables of the validation scripts."""

from __future__ import annotations

import argparse
import csv
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

OUT = Path("validation/out")


def command_line(head: str | None) -> argparse.ArgumentParser:
    """The parser of a script; its help is the head of the file."""
    return argparse.ArgumentParser(description=head, formatter_class=argparse.RawDescriptionHelpFormatter)


def one_of(known: Collection[str]) -> Callable[[str], str]:
    """Type of an argument that is one of these names; for lists of names that may be empty."""

    def checked(text: str) -> str:
        if text not in known:
            raise argparse.ArgumentTypeError(f"{text!r} is none of {', '.join(known)}")
        return text

    return checked


def write_rows(path: Path, rows: Sequence[Any]) -> None:
    """Rows, dataclasses or dictionaries with the same names, as CSV; the folder is made."""
    named = [row if isinstance(row, Mapping) else asdict(row) for row in rows]
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(named[0]))
        writer.writeheader()
        writer.writerows(named)
