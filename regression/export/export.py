"""Writes a formula as program text into a file: language by name or by the suffix of the file.

A language is a function of a `Program` and a name in a file of its own, and a row of `_LANGUAGES`.
"""

import re
from collections.abc import Callable
from pathlib import Path

from ehl.common.errors import InputError
from ehl.common.files import write_file
from regression.export.c_text import c_text
from regression.export.fmu import friction_fmu
from regression.export.fortran_text import fortran_text
from regression.export.matlab_text import matlab_text
from regression.export.program import Program, program_of
from regression.export.python_text import python_text
from regression.friction.fitted import FittedFormula

# content of a program's file and suffixes of such files
_LANGUAGES: dict[str, tuple[Callable[[Program, str], str | bytes], tuple[str, ...]]] = {
    "python": (python_text, (".py",)),
    "c": (c_text, (".c",)),
    "fortran": (fortran_text, (".f90", ".f08")),
    "matlab": (matlab_text, (".m",)),
    "fmu": (friction_fmu, (".fmu",)),
}
LANGUAGES = tuple(_LANGUAGES)


def export_formula(
    formula: FittedFormula,
    path: Path,
    language: str | None = None,
    *,
    oil: str | None = None,
    oil_arguments: bool = False,
    guard: bool = True,
) -> Program:
    """Write a formula as code; arguments as of `FittedFormula.export`.

    Raises `InputError`: the language is not known, the name is no identifier, or the file cannot be written.
    """
    text, _ = _LANGUAGES[_language(path, language)]
    if oil is not None and oil_arguments:
        raise InputError("oil", oil, "not together with oil_arguments")
    name = identifier(path)
    program = program_of(formula, oil=oil, oil_arguments=oil_arguments, guard=guard)
    write_file(path, text(program, name))
    return program


def identifier(path: Path) -> str:
    """Name of the function or unit in a file.

    Raises `InputError`: it is no identifier.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,30}", path.stem):
        hint = "The function takes the name of the file."
        raise InputError("path", path.name, "a file name of letters, digits and _ that starts with a letter", hint)
    return path.stem


def _language(path: Path, language: str | None) -> str:
    suffixes = {suffix: name for name, (_, own) in _LANGUAGES.items() for suffix in own}
    if language is None and path.suffix not in suffixes:
        hint = "Name the language, or give the file one of the suffixes " + ", ".join(suffixes) + "."
        raise InputError("language", None, "one of " + ", ".join(LANGUAGES), hint)
    if language is not None and language not in LANGUAGES:
        raise InputError("language", language, "one of " + ", ".join(LANGUAGES))
    return language or suffixes[path.suffix]
