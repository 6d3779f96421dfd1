"""Options of the command line: files that cannot be written are refused at once; errors name the options."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from ehl import InputError

FIGURE = (".png", ".svg", ".pdf")


def check_outputs(outputs: Mapping[str, Path | None], suffixes: Mapping[str, tuple[str, ...]] | None = None) -> None:
    """Refuse files that cannot be written.

    Parameters
    ----------
    outputs : mapping
        Option to file; None where the option was not given.
    suffixes : mapping, optional
        Option to the endings its file may have; any where it is not named.

    Raises
    ------
    InputError
        Naming option and file; or two options name the same file.
    """
    given = {option: path for option, path in outputs.items() if path is not None}
    for option, path in given.items():
        if path.is_dir():
            raise InputError(option, str(path), "a file", "This is a folder.")
        folder = path.parent
        if not folder.is_dir():
            raise InputError(option, str(path), "a file in a folder that exists", f"There is no folder {folder}.")
        if not os.access(path if path.exists() else folder, os.W_OK):
            raise InputError(option, str(path), "a file that can be written", "Check its permissions.")
        endings = (suffixes or {}).get(option)
        if endings and path.suffix.lower() not in endings:
            raise InputError(option, str(path), "a file name ending in " + " or ".join(endings))
    resolved = [path.resolve() for path in given.values()]
    for option, path in given.items():
        if resolved.count(path.resolve()) > 1:
            raise InputError(option, str(path), "a file of its own for each option")


@contextmanager
def option_names(options: Mapping[str, str]) -> Iterator[None]:
    """Let errors in the block name the option where the Python interface names its keyword.

    Parameters
    ----------
    options : mapping
        Keyword to option.

    Raises
    ------
    InputError
        That of the block.
    """
    try:
        yield
    except InputError as error:
        raise InputError(options.get(error.field, error.field), error.value, error.allowed, error.hint) from None
