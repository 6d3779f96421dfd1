"""Shipped data: `data/` of a checkout, or `ehl/_data/` of an installed wheel; reasons as text, and references."""

from __future__ import annotations

import csv
import os
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ehl.common.errors import InputError, check_choice, near, same_name

_PACKAGED = Path(__file__).resolve().parents[1] / "_data"
_ROOT = _PACKAGED if _PACKAGED.is_dir() else Path(__file__).resolve().parents[2] / "data"


def data_path(*parts: str) -> Path:
    """Path of a shipped data file or folder.

    *parts: path components below the data folder, e.g. ``("oils", "fva3.toml")``.
    """
    return _ROOT.joinpath(*parts)


def data_rows(*parts: str) -> list[dict[str, str]]:
    """Rows of a shipped CSV file by their heads, without comments; `parts` as for `data_path`."""
    lines = data_path(*parts).read_text(encoding="utf-8").splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith(("#", '"#'))))


@cache
def data_names(folder: str, suffix: str = ".toml") -> tuple[str, ...]:
    """Names (without suffix) of the shipped files in one data folder, sorted."""
    place = data_path(folder)
    every = os.listdir(place) if place.is_dir() else ()
    return tuple(sorted(name.removesuffix(suffix) for name in every if name.endswith(suffix)))


def shipped(kind: str) -> tuple[str, ...]:
    """Names of the shipped files of one kind.

    Parameters
    ----------
    kind : str
        "oils", "materials", "finishes", "additives", "designs", "axles", "blanks", "targets", "plans", "formulas" or
        "datasets".

    Returns
    -------
    tuple of str

    Raises
    ------
    InputError
        There is no such kind.

    Examples
    --------
    >>> import ehl
    >>> "75w90" in ehl.shipped("oils")
    True
    """
    suffixes = {"formulas": ".json", "datasets": ".h5"}
    surfaces = ("materials", "finishes", "additives")
    kinds = ("oils", *surfaces, "designs", "axles", "blanks", "targets", "plans", "formulas", "datasets")
    check_choice("kind", kind, kinds)
    return data_names(kind, suffixes.get(kind, ".toml"))


def named_file(field: str, folder: str, name: str | Path, suffix: str = ".toml") -> Path:
    """Path of a file, or of the shipped file of that name; `InputError` for `field` if there is none."""
    path = Path(name)
    names = data_names(folder, suffix)
    if os.path.exists(path):  # Path.exists raises an error if the name is too long
        return path
    if path.suffix:
        if path.suffix == suffix and path.stem in names:
            raise InputError(field, str(path), "an existing file", f"Without {suffix} it is the shipped {path.stem}.")
        return path
    name = same_name(str(name), names)
    if name not in names:
        kind = suffix.removeprefix(".").upper()
        kinds = (("designs", "a design"), ("oils", "an oil"), ("plans", "a plan"), ("blanks", "a blank"))
        others = (f"{name} is {words}." for other, words in kinds if name in data_names(other))
        hint = next(others, near(name, names))
        raise InputError(field, name, f"a {kind} file or one of " + ", ".join(names), hint)
    return data_path(folder, f"{name}{suffix}")


@cache
def _sentences() -> Mapping[str, str]:
    return {row["reason"]: row["sentence"] for row in data_rows("reasons.csv")}


def reason_text(reason: str) -> str:
    """A reason as text, also one that is followed by a colon and its detail; any other text as it is."""
    code, mark, detail = reason.partition(": ")
    return _sentences().get(code, code) + mark + detail


def counted_reasons(counts: Mapping[str, int]) -> str:
    """Reasons as text, each after its number of cases."""
    return ", ".join(f"{count} {reason_text(reason)}" for reason, count in sorted(counts.items()))


_NOT_BIBTEX = ("type", "uses")
_PLACES = ("journal", "booktitle", "publisher", "school", "organization")
_BIBTEX_TYPES = {"software": "misc", "standard": "misc"}  # types without a BibTeX type of their own


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
        return "\n".join(f"[{number}] {reference_line(entry)}" for number, entry in enumerate(self.entries.values(), 1))

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


def reference_line(entry: dict[str, Any]) -> str:
    """An entry as one line of text."""
    authors = entry.get("author", "").replace(" and ", ", ")
    place = next((entry[key] for key in _PLACES if key in entry), "")
    numbers = ", ".join(str(entry[name]) for name in ("volume", "pages") if name in entry)
    parts = [f"{authors} ({entry['year']})" if authors and "year" in entry else authors, entry["title"]]
    parts += [f"{place} {numbers}".strip() if place else "", f"doi:{entry['doi']}" if "doi" in entry else ""]
    return ". ".join(part.rstrip(".") for part in parts if part) + "."


@cache
def all_references() -> dict[str, dict[str, Any]]:
    """Every entry of the file by its key."""
    return tomllib.loads(data_path("references.toml").read_text(encoding="utf-8"))
