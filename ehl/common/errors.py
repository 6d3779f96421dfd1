"""Errors of the three packages. The command line prints them as one sentence and returns an exit code."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable, Mapping
from typing import SupportsIndex, cast

_MOST_SHOWN, _MOST_TEXT = 20, 4000  # problems in a message; its length [characters]


def _shown(value: object) -> str:
    try:
        return _one_line(repr(value), 300)
    except (ValueError, RecursionError):  # an integer of 10 000 digits, or deeply nested lists
        return f"a value too long to print ({type(value).__name__})"


def _one_line(text: str, longest: int) -> str:
    """A text from the input of a user for printing: short, and without control characters."""
    if len(text) > longest:
        text = f"{text[: longest // 2]}... ({len(text)} characters) ...{text[-longest // 4 :]}"
    return "".join(sign if sign.isprintable() or sign == "\n" else f"\\x{ord(sign):02x}" for sign in text)


class MixedEhlError(Exception):
    """Base class of all errors of the three packages."""

    exit_code = 1


class InputError(MixedEhlError, ValueError):
    """An invalid input.

    Parameters
    ----------
    field : str
        Name of the field as the user wrote it (``contact.radius_equivalent``), or name of the file.
    value : object
        The value as the user wrote it; None if it is missing.
    allowed : str
        Allowed values, with unit.
    hint : str, optional
        Remedy.
    also : iterable of InputError, optional
        Further errors of the same input; each has a separate line in the message.
    """

    exit_code = 2

    def __init__(
        self, field: str, value: object, allowed: str, hint: str = "", also: Iterable[InputError] = ()
    ) -> None:
        self.field, self.value, self.allowed, self.hint = field, value, allowed, hint
        self.also = tuple(problem for error in also for problem in error.problems)
        super().__init__(field, value, allowed, hint, self.also)

    @property
    def problems(self) -> tuple[InputError, ...]:
        """Every problem of the input as a separate error, this one first."""
        return (InputError(self.field, self.value, self.allowed, self.hint), *self.also) if self.also else (self,)

    @classmethod
    def of(cls, problems: Iterable[InputError]) -> InputError:
        """One error that contains one or more others."""
        first, *others = problems
        return cls(first.field, first.value, first.allowed, first.hint, (*first.also, *others))

    def changed(self, change: Callable[[InputError], InputError]) -> InputError:
        """Copy with a function applied to every problem."""
        return InputError.of(change(problem) for problem in self.problems)

    def __str__(self) -> str:
        lines = [self._sentence()]
        for number, problem in enumerate(self.also):
            if len(lines) == _MOST_SHOWN or sum(map(len, lines)) > _MOST_TEXT:
                lines.append(f"And {len(self.also) - number} more.")
                break
            lines.append(problem._sentence())
        return lines[0] if len(lines) == 1 else "\n  ".join([f"{1 + len(self.also)} problems:", *lines])

    def _sentence(self) -> str:
        field, allowed = _one_line(self.field, 300), _one_line(self.allowed, 2000)
        if self.value is None:
            sentence = f"{field} is missing; needed: {allowed}."
        else:
            sentence = f"{field} = {_shown(self.value)} cannot be used; allowed: {allowed}."
        return f"{sentence} {_one_line(self.hint, 2000)}" if self.hint else sentence


def same_name(name: str, known: Iterable[str]) -> str:
    """The entry of `known` that differs only in case, blanks, hyphens and underscores; otherwise the name itself."""
    names = tuple(known)
    if name in names:
        return name
    found = [other for other in names if _plain(other) == _plain(name)]
    return found[0] if len(found) == 1 else name


def _plain(name: str) -> str:
    return "".join(sign for sign in name.casefold() if sign not in " -_")


def near(name: object, known: Iterable[str]) -> str:
    """The hint "Did you mean ...?" if a known name is similar to the given one; otherwise an empty text."""
    from difflib import get_close_matches  # only when something is wrong

    given = {text.lower(): text for text in known}
    found = get_close_matches(str(name)[:100].lower(), given, n=2, cutoff=0.65)
    return f"Did you mean {' or '.join(repr(given[text]) for text in found)}?" if found else ""


def remedy(name: object, instead: Mapping[str, str]) -> str:
    """What to give instead of a quantity without an input of its own, from its name without the number of a body."""
    return instead.get(re.sub(r"_?[12]$", "", str(name).lower()), "")


def check_choice(field: str, value: object, known: Iterable[str], hint: str = "") -> None:
    """Raise an `InputError` with all known names, by default with the most similar one, for any other value."""
    names = tuple(known)
    if value not in names:
        raise InputError(field, value, "one of " + ", ".join(names), hint or near(value, names))


def check_count(field: str, value: object, least: int, most: int, hint: str = "", *, even: bool = False) -> None:
    """Raise an `InputError` unless a value is a whole number, with `even` an even one, within two ends."""
    try:
        number = least - 1 if isinstance(value, bool) else operator.index(cast("SupportsIndex", value))
    except TypeError:
        number = least - 1
    if not least <= number <= most or (even and number % 2):
        raise InputError(field, value, f"{'an even' if even else 'a whole'} number from {least} to {most}", hint)


class ConvergenceError(MixedEhlError):
    """A solver did not reach its tolerance.

    Parameters
    ----------
    reason : str
        One of the reasons of the solver.
    detail : str, optional
        Location and size of the residual.
    """

    def __init__(self, reason: str, detail: str = "") -> None:
        self.reason, self.detail = reason, detail
        super().__init__(reason, detail)

    def __str__(self) -> str:
        from ehl.common.data import reason_text  # reads data with the errors of this module

        return f"{reason_text(self.reason)} ({self.reason})" + (f": {self.detail}" if self.detail else "")
