"""Folders and files that are written, and what stops that as an `InputError`."""

from __future__ import annotations

from pathlib import Path

from ehl.io.errors import InputError


def make_folder(folder: Path, field: str) -> None:
    """Make a folder, and those it lies in, where there is none.

    Raises
    ------
    InputError
        Naming `field`: the folder cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(field, str(folder), "a folder that can be written", f"{error}.") from None


def write_file(path: Path, content: str | bytes, field: str = "path", *, folder: bool = False) -> None:
    """Write a file, its folder too if `folder`.

    Raises
    ------
    InputError
        Naming `field`: the file cannot be written.
    """
    try:
        if folder:
            path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.encode() if isinstance(content, str) else content)
    except OSError as error:
        raise InputError(field, str(path), "a writable file", f"{error}.") from None
