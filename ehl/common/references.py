"""References of a result: entries of `data/references.toml` for its laws, formulas and standards."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any

from ehl.common.data import data_path

_NOT_BIBTEX = ("type", "uses")
# types without a BibTeX type of their own
_BIBTEX_TYPES = {"software": "misc", "standard": "misc"}


@dataclass(frozen=True, repr=False)
class Citation:
    """References of a result, in the order of the file.

    Parameters
    ----------
    entries : dict
        Key to the fields of the entry, including `type` and `uses`.
    """

    entries: dict[str, dict[str, Any]]

    @classmethod
    def of(cls, uses: Iterable[str]) -> Citation:
        """Entries of the program and of some uses, each entry once."""
        wanted = {"program", *uses}
        return cls({key: entry for key, entry in all_references().items() if wanted & {*entry["uses"]}})

    @property
    def text(self) -> str:
        """Numbered list with one entry per line."""
        return "\n".join(f"[{number}] {line(entry)}" for number, entry in enumerate(self.entries.values(), 1))

    @property
    def bibtex(self) -> str:
        """The entries as BibTeX."""
        texts = []
        for key, entry in self.entries.items():
            fields = [f"  {name} = {{{value}}}" for name, value in entry.items() if name not in _NOT_BIBTEX]
            kind = _BIBTEX_TYPES.get(entry["type"], entry["type"])
            texts.append(f"@{kind}{{{key},\n" + ",\n".join(fields) + "\n}")
        return "\n\n".join(texts)

    def __repr__(self) -> str:
        return self.text


def line(entry: dict[str, Any]) -> str:
    """An entry as one line of text."""
    authors = entry.get("author", "").replace(" and ", ", ")
    place = entry.get("journal") or entry.get("booktitle") or entry.get("publisher") or entry.get("school")
    place = place or entry.get("organization")
    numbers = ", ".join(str(entry[name]) for name in ("volume", "pages") if name in entry)
    parts = [f"{authors} ({entry['year']})" if authors and "year" in entry else authors, entry["title"]]
    parts += [f"{place} {numbers}".strip() if place else "", f"doi:{entry['doi']}" if "doi" in entry else ""]
    return ". ".join(part.rstrip(".") for part in parts if part) + "."


@cache
def all_references() -> dict[str, dict[str, Any]]:
    """Every entry of the file by its key."""
    return tomllib.loads(data_path("references.toml").read_text(encoding="utf-8"))
