"""Oil cards as files: TOML, numbers in SI."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from ehl.common.errors import InputError
from ehl.common.files import toml_text, write_file

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
    return f"# {head}; numbers in SI units.\n" + toml_text(content)


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
