"""Oil cards as files: TOML, numbers in SI."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from ehl.io.errors import InputError
from ehl.io.files import write_file

if TYPE_CHECKING:
    from ehl.fluid.oil import Oil


def card_text(card: Oil, head: str) -> str:
    """The card as TOML, numbers in SI.

    Parameters
    ----------
    card : Oil
    head : str
        First line, a comment.
    """
    content: dict[str, Any] = card.model_dump(exclude_none=True)
    for name, field in type(card).model_fields.items():  # what the hash of a card leaves out belongs to its file
        value = getattr(card, name)
        if field.exclude and value is not None and value != field.default:
            content[name] = value.model_dump() if isinstance(value, BaseModel) else value
    return f"# {head}; numbers in SI units.\n" + "\n".join(_toml(content, ()))


def write_card(card: Oil, path: Path, head: str) -> None:
    """Write the card, and make sure that it reads back as it is; `head` as of `card_text`.

    Raises
    ------
    InputError
        The path does not end in .toml or cannot be written.
    """
    if path.suffix != ".toml":
        raise InputError("path", str(path), "a file name ending in .toml")
    write_file(path, card_text(card, head))
    type(card).load(str(path))


def _toml(table: dict[str, Any], path: tuple[str, ...]) -> list[str]:
    plain = {key: value for key, value in table.items() if not isinstance(value, dict)}
    lines = [f"[{'.'.join(map(_key, path))}]"] if path and (plain or not table) else []
    lines += [f"{_key(key)} = {_literal(value)}" for key, value in plain.items()]
    lines.append("")
    for key, value in table.items():
        if isinstance(value, dict):
            lines += _toml(value, (*path, key))
    return lines


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _literal(key)


def _literal(value: Any) -> str:
    if isinstance(value, (tuple, list)):
        return "[" + ", ".join(_literal(entry) for entry in value) + "]"
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
        return f'"{escaped}"'
    return repr(value)
