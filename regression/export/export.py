"""Writes a formula as program text into a file: language by name or by the suffix of the file."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from ehl.common.errors import InputError
from ehl.common.files import write_file
from regression.export.c_text import c_text
from regression.export.fortran_text import fortran_text
from regression.export.latex_text import latex_text
from regression.export.matlab_text import matlab_text
from regression.export.program import Program, program_of
from regression.export.python_text import python_text
from regression.export.spreadsheet import spreadsheet_text, write_workbook
from regression.friction.formula import FittedFormula

_TEXTS: dict[str, Callable[[Program, str], str]] = {
    "python": python_text,
    "c": c_text,
    "fortran": fortran_text,
    "matlab": matlab_text,
    "latex": latex_text,
    "spreadsheet": lambda program, name: spreadsheet_text(program),
}
LANGUAGES = tuple(_TEXTS)
_SUFFIXES = {
    ".py": "python",
    ".c": "c",
    ".f90": "fortran",
    ".f08": "fortran",
    ".m": "matlab",
    ".tex": "latex",
    ".xlsx": "spreadsheet",
    ".txt": "spreadsheet",
}
_WITHOUT_LOOPS = ("latex", "spreadsheet")


def export_formula(
    formula: FittedFormula,
    path: Path,
    language: str | None = None,
    *,
    oil: str | None = None,
    oil_arguments: bool = False,
    guard: bool = True,
) -> Program:
    """Write a formula as code.

    Parameters
    ----------
    formula : FittedFormula
        A fitted formula.
    path : Path
        File to write; its stem becomes the name of the function. A spreadsheet is a workbook as .xlsx and the formula
        for one cell as any other file.
    language : str, optional
        One of `LANGUAGES`; by the suffix of the file if not given.
    oil : str, optional
        Oil card whose laws are written into the code; needed where the formula was fitted to several.
    oil_arguments : bool
        Take the oil's properties as arguments.
    guard : bool
        Flag points within the range that lie far from all cases of the fit: a loop over stored numbers.

    Returns
    -------
    Program
        What was written.

    Raises
    ------
    InputError
        The language is not known or cannot hold the formula, the name is no identifier, or the file cannot be written.
    """
    language = _language(path, language)
    if oil is not None and oil_arguments:
        raise InputError("oil", oil, "not together with oil_arguments")
    loops = language not in _WITHOUT_LOOPS
    program = program_of(formula, oil=oil, oil_arguments=oil_arguments, loops=loops, guard=guard)
    if language == "spreadsheet" and path.suffix == ".xlsx":
        write_workbook(program, path)
        return program
    if language not in _WITHOUT_LOOPS and not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,30}", path.stem):
        hint = "The function takes the name of the file."
        raise InputError("path", path.name, "a file name of letters, digits and _ that starts with a letter", hint)
    write_file(path, _TEXTS[language](program, path.stem))
    return program


def _language(path: Path, language: str | None) -> str:
    if language is None:
        if path.suffix not in _SUFFIXES:
            hint = "Name the language, or give the file one of the suffixes " + ", ".join(_SUFFIXES) + "."
            raise InputError("language", None, "one of " + ", ".join(LANGUAGES), hint)
        return _SUFFIXES[path.suffix]
    if language not in LANGUAGES:
        raise InputError("language", language, "one of " + ", ".join(LANGUAGES))
    return language
