"""A small evaluator of cell formulas, with the precedence of spreadsheets; cells may hold arrays."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.special import erf, erfc

_TOKEN = re.compile(r"\s*(?:(\d[\d.]*(?:E[+-]?\d+)?)|(\$?[A-Za-z_][A-Za-z0-9_.$]*)|(<=|>=|<>|[-+*/^(),<>=]))")
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "ABS": np.abs,
    "EXP": np.exp,
    "LN": np.log,
    "LOG10": np.log10,
    "SQRT": np.sqrt,
    "SINH": np.sinh,
    "TANH": np.tanh,
    "ASINH": np.arcsinh,
    "ATANH": np.arctanh,
    "ERF": erf,
    "ERFC": erfc,
    "IF": np.where,
    "MAX": np.maximum,
    "MIN": np.minimum,
    "ISNUMBER": np.isfinite,
    "NA": lambda: np.nan,
    "AND": lambda *parts: np.logical_and.reduce(np.broadcast_arrays(*parts)),
    "OR": lambda *parts: np.logical_or.reduce(np.broadcast_arrays(*parts)),
    "NOT": np.logical_not,
    # an error is a nan here, and a comparison with it false
    "IFERROR": lambda value, otherwise: value,
}


class _Parser:
    def __init__(self, text: str, names: Mapping[str, Any]) -> None:
        self.tokens = [found.groups() for found in _TOKEN.finditer(text)]
        assert sum(len("".join(part or "" for part in token)) for token in self.tokens) == len(text.replace(" ", ""))
        self.place = 0
        self.names = dict(names)

    def peek(self) -> str:
        return "".join(part or "" for part in self.tokens[self.place]) if self.place < len(self.tokens) else ""

    def take(self, sign: str | None = None) -> str:
        token = self.peek()
        assert sign is None or token == sign, f"{token!r} in place of {sign!r}"
        self.place += 1
        return token

    def comparison(self) -> Any:
        left = self.sum()
        while self.peek() in ("<", "<=", ">", ">=", "="):
            sign, right = self.take(), self.sum()
            left = {"<": left < right, "<=": left <= right, ">": left > right, ">=": left >= right}[sign]
        return left

    def sum(self) -> Any:
        left = self.product()
        while self.peek() in ("+", "-"):
            left = left + self.product() if self.take() == "+" else left - self.product()
        return left

    def product(self) -> Any:
        left = self.power()
        while self.peek() in ("*", "/"):
            left = left * self.power() if self.take() == "*" else left / self.power()
        return left

    def power(self) -> Any:
        left = self.sign()
        while self.peek() == "^":  # from the left, as in a spreadsheet
            self.take()
            left = left ** self.sign()
        return left

    def sign(self) -> Any:
        if self.peek() == "-":  # binds tighter than the power
            self.take()
            return -self.sign()
        return self.atom()

    def atom(self) -> Any:
        number, name, _ = self.tokens[self.place]
        token = self.take()
        if number is not None:
            return np.float64(number)
        if name is None:
            assert token == "("
            value = self.comparison()
            self.take(")")
            return value
        if self.peek() != "(":
            return self.names[name] if name != "FALSE" else False
        self.take("(")
        if name == "LET":
            return self.let()
        parts = []
        while self.peek() != ")":
            parts.append(self.comparison())
            if self.peek() == ",":
                self.take()
        self.take(")")
        return FUNCTIONS[name](*parts)

    def let(self) -> Any:
        while True:
            following = self.tokens[self.place + 1][2]
            if following == ")":
                value = self.comparison()
                self.take(")")
                return value
            name = self.take()
            self.take(",")
            self.names[name] = self.comparison()
            self.take(",")


def evaluate_cell(text: str, names: Mapping[str, Any]) -> Any:
    """The value of a formula; `names` holds cells and defined names."""
    assert text.startswith("=")
    parser = _Parser(text[1:], names)
    with np.errstate(all="ignore"):
        value = parser.comparison()
    assert parser.peek() == ""
    return value
