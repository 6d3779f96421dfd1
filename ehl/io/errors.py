"""Errors a user can act on. The command line turns them into one sentence and an exit code."""

from __future__ import annotations


def _shown(value: object) -> str:
    try:
        return _one_line(repr(value), 300)
    except (ValueError, RecursionError):  # an integer of 10 000 digits, lists within lists without end
        return f"a value too long to print ({type(value).__name__})"


def _one_line(text: str, longest: int) -> str:
    """A text a user's file is part of, fit for a terminal: short, and without control characters."""
    if len(text) > longest:
        text = f"{text[: longest // 2]}... ({len(text)} characters) ...{text[-longest // 4 :]}"
    return "".join(sign if sign.isprintable() or sign == "\n" else f"\\x{ord(sign):02x}" for sign in text)


class MixedEhlError(Exception):
    """Base of all errors raised on purpose by the three packages."""

    exit_code = 1


class InputError(MixedEhlError, ValueError):
    """An input that cannot be used.

    Parameters
    ----------
    field : str
        Name of the field as the user wrote it (``contact.radius_equivalent``), or the file's name.
    value : object
        The value as the user wrote it; None where it is missing.
    allowed : str
        What would be accepted, with its unit.
    hint : str, optional
        What to do about it.
    """

    exit_code = 2

    def __init__(self, field: str, value: object, allowed: str, hint: str = "") -> None:
        self.field, self.value, self.allowed, self.hint = field, value, allowed, hint
        super().__init__(str(self))

    def __str__(self) -> str:
        field, allowed = _one_line(self.field, 300), _one_line(self.allowed, 2000)
        if self.value is None:
            sentence = f"{field} is missing; needed: {allowed}."
        else:
            sentence = f"{field} = {_shown(self.value)} cannot be used; allowed: {allowed}."
        return f"{sentence} {_one_line(self.hint, 2000)}" if self.hint else sentence

    def __reduce__(self) -> tuple[type[InputError], tuple[str, object, str, str]]:
        return (type(self), (self.field, self.value, self.allowed, self.hint))


class ConvergenceError(MixedEhlError):
    """A solver did not reach its tolerance.

    Parameters
    ----------
    reason : str
        One word of the solver's enumerated list of reasons.
    detail : str, optional
        Where and by how much.
    """

    exit_code = 1

    def __init__(self, reason: str, detail: str = "") -> None:
        self.reason, self.detail = reason, detail
        super().__init__(str(self))

    def __str__(self) -> str:
        return f"not converged ({self.reason})" + (f": {self.detail}" if self.detail else "")

    def __reduce__(self) -> tuple[type[ConvergenceError], tuple[str, str]]:
        return (type(self), (self.reason, self.detail))
