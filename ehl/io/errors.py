"""Errors a user can act on. The command line turns them into one sentence and an exit code."""

from __future__ import annotations


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
        if self.value is None:
            sentence = f"{self.field} is missing; needed: {self.allowed}."
        else:
            sentence = f"{self.field} = {self.value!r} cannot be used; allowed: {self.allowed}."
        return f"{sentence} {self.hint}" if self.hint else sentence

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
