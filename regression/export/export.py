"""Languages of exported formulas, by name or by the suffix of the file.

A language is a function of a `Program` and a name in a file of its own, and a row of `_LANGUAGES`.
"""

import re
from collections.abc import Callable
from pathlib import Path

from ehl.common.errors import InputError, check_choice
from regression.export.c_text import c_text
from regression.export.fmu import friction_fmu
from regression.export.fortran_text import fortran_text
from regression.export.matlab_text import matlab_text
from regression.export.program import Program
from regression.export.python_text import python_text

# content of a program's file and suffixes of such files
_LANGUAGES: dict[str, tuple[Callable[[Program, str], str | bytes], tuple[str, ...]]] = {
    "python": (python_text, (".py",)),
    "c": (c_text, (".c",)),
    "fortran": (fortran_text, (".f90", ".f08")),
    "matlab": (matlab_text, (".m",)),
    "fmu": (friction_fmu, (".fmu",)),
}
LANGUAGES = tuple(_LANGUAGES)


def identifier(path: Path) -> str:
    """Name of the function or unit in a file.

    Raises `InputError`: it is no identifier.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,30}", path.stem):
        hint = "The function takes the name of the file."
        raise InputError("path", path.name, "a file name of letters, digits and _ that starts with a letter", hint)
    return path.stem


def writer_of(path: Path, language: str | None) -> Callable[[Program, str], str | bytes]:
    """Function that writes a program in a language, or in that of the suffix of the file.

    Raises `InputError`: the language is not known, or not that of the suffix.
    """
    suffixes = {suffix: name for name, (_, own) in _LANGUAGES.items() for suffix in own}
    if language is None and path.suffix not in suffixes:
        hint = "Name the language, or give the file one of the suffixes " + ", ".join(suffixes) + "."
        raise InputError("language", None, "one of " + ", ".join(LANGUAGES), hint)
    language = language or suffixes[path.suffix]
    check_choice("language", language, LANGUAGES)
    if suffixes.get(path.suffix, language) != language:
        allowed = f"{suffixes[path.suffix]} for a file {path.suffix}"
        raise InputError("language", language, allowed, "Change one of them.")
    return _LANGUAGES[language][0]
