"""Values that record what is computed with them: a function of arrays becomes a list of operations.

A function written with numpy and scipy ufuncs and arithmetic is called once with `Value`s instead of arrays. What it
returns then contains every operation, down to the arguments, and can be printed in any language.
"""

from __future__ import annotations

import itertools
import math
import operator
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Any

import numpy as np

_serial = itertools.count()
_naming: list[tuple[str, ...]] = []  # packages of `local_names`, while it is on

COMPARISONS = {"less": "<", "less_equal": "<=", "greater": ">", "greater_equal": ">="}
LOGICAL = ("and", "or", "not", "isfinite", *COMPARISONS)
# operations of a printer: these and the four arithmetic operations, power, choose
FUNCTIONS = (
    *("negative", "absolute", "exp", "log", "log10", "sqrt", "sin", "cos", "tan", "arctan", "sinh", "cosh", "tanh"),
    *("arcsinh", "arctanh", "maximum", "minimum"),
)
_FOLDED: dict[str, Callable[..., float]] = {
    "add": operator.add,
    "subtract": operator.sub,
    "multiply": operator.mul,
    "divide": operator.truediv,
    "power": operator.pow,
    "negative": operator.neg,
    "sqrt": math.sqrt,
    "exp": math.exp,
    "log": math.log,
    "log10": math.log10,
    "greater": operator.gt,
    "less": operator.lt,
}


class NotRecordable(TypeError):
    """The recorded function does something that only works with real arrays."""


class Value(np.lib.mixins.NDArrayOperatorsMixin):
    """One number of a recorded computation, instead of an array of any shape.

    operation: ``argument``, ``coefficient``, ``constant``, a name of `FUNCTIONS` or `LOGICAL`, ``add``, ``subtract``,
        ``multiply``, ``divide``, ``power`` or ``choose`` (condition, value if true, value if not).
    operands: values from which it is computed.
    number: of a constant or a coefficient.
    name: its name in the program, or empty.
    """

    def __init__(
        self, operation: str, operands: tuple[Value, ...] = (), number: float = math.nan, name: str = ""
    ) -> None:
        self.operation = operation
        self.operands = operands
        self.number = number
        self.name = name
        self.serial = next(_serial)
        if operands and _naming:
            _name_locals()

    __hash__ = object.__hash__  # == is recorded, so that values are distinguished by identity

    @property
    def logical(self) -> bool:
        """Whether it is true or false rather than a number."""
        return self.operation in LOGICAL

    def __bool__(self) -> bool:
        raise NotRecordable("a branch on a value: use np.where")

    def __float__(self) -> float:
        raise NotRecordable("a conversion to float, as of math.exp: use the ufunc of numpy")

    def __array_ufunc__(
        self, ufunc: np.ufunc, method: str, *inputs: Any, out: tuple[Any, ...] | None = None, where: Any = True
    ) -> Any:
        if method != "__call__":
            raise NotRecordable(f"np.{ufunc.__name__}.{method}")
        if ufunc.__name__ == "matmul":
            raise NotRecordable("a matrix product that is not `columns @ coefficients`")
        result = record(ufunc.__name__, *inputs)
        if where is True:
            return result
        if out is None:
            raise NotRecordable(f"np.{ufunc.__name__} with where but without out")
        return choose(where, result, out[0])

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if function.__name__ not in _ARRAY_FUNCTIONS:
            raise NotRecordable(f"np.{function.__name__}")
        return _ARRAY_FUNCTIONS[function.__name__](*args, **kwargs)

    def __getattr__(self, name: str) -> Callable[..., Value]:
        # numpy calls the method of that name for the elements of an object array, which np.asarray makes of a value
        if name in FUNCTIONS or name in _LOWERED:
            return lambda *others: record(name, self, *others)
        raise AttributeError(name)


class ValueColumns:
    """A matrix of values, one row per point: what np.column_stack makes of them."""

    __array_ufunc__ = None

    def __init__(self, columns: Sequence[Any]) -> None:
        self.columns = [value_of(column) for column in columns]

    def __matmul__(self, coefficients: Any) -> Value:
        """The sum of columns times coefficients."""
        factors = np.asarray(coefficients).tolist()
        if len(factors) != len(self.columns):
            raise NotRecordable(f"a product of {len(self.columns)} columns with {len(factors)} coefficients")
        terms = [record("multiply", factor, column) for factor, column in zip(factors, self.columns, strict=True)]
        total = terms[0]
        for term in terms[1:]:
            total = record("add", total, term)
        return total


# to a type checker a value is the array it stands for, which has no type of its own: Any
def argument(name: str) -> Any:
    """A number the caller of the program gives."""
    return Value("argument", name=name)


def coefficient(name: str, number: float) -> Any:
    """A fitted number that keeps its name in the program."""
    return Value("coefficient", number=number, name=name)


def constant(number: float) -> Any:
    """A number written into the program."""
    return Value("constant", number=float(number))


def value_of(thing: Any) -> Value:
    """A value as it is; a number, or a value inside of an array without dimension, as a value.

    Raises `NotRecordable`: it is an array of several numbers, or no number at all.
    """
    if isinstance(thing, Value):
        return thing
    if isinstance(thing, np.ndarray) and thing.ndim == 0:
        return value_of(thing.item())
    if isinstance(thing, (bool, int, float, np.generic)):
        return Value("constant", number=float(thing))
    raise NotRecordable(f"{type(thing).__name__} among the values")


def record(operation: str, *inputs: Any) -> Value:
    """The value of a ufunc of that name."""
    values = tuple(value_of(thing) for thing in inputs)
    if operation in _LOWERED:
        return value_of(_LOWERED[operation](*values))
    if operation not in FUNCTIONS and operation not in LOGICAL and operation not in _FOLDED:
        raise NotRecordable(f"the function {operation}")
    if operation in _FOLDED and all(value.operation == "constant" for value in values):
        return Value("constant", number=_FOLDED[operation](*(value.number for value in values)))
    simple = _simplified(operation, values)
    return Value(operation, values) if simple is None else simple


def choose(condition: Any, yes: Any, no: Any) -> Any:
    """`yes` if the condition holds, otherwise `no`."""
    test = value_of(condition)
    if test.operation == "constant":
        return value_of(yes if test.number else no)
    return Value("choose", (test, value_of(yes), value_of(no)))


def _simplified(operation: str, values: tuple[Value, ...]) -> Value | None:
    """What leaves a finite number as it is, but for the last digit."""
    first, last = values[0], values[-1]
    if (operation in ("multiply", "divide") and _is(first, 0.0)) or (operation == "multiply" and _is(last, 0.0)):
        return value_of(0.0)
    if operation == "subtract" and first is last:
        return value_of(0.0)
    if operation == "multiply":
        if _is(first, 1.0):
            return last
        if _is(last, 1.0):
            return first
    if operation in ("divide", "power") and _is(last, 1.0):
        return first
    if operation == "add" and _is(first, 0.0):
        return last
    if operation in ("add", "subtract") and _is(last, 0.0):
        return first
    if operation in ("and", "or"):
        for one, other in ((first, last), (last, first)):
            if one.operation == "constant":
                return other if bool(one.number) == (operation == "and") else one
    if operation == "exp" and first.operation == "log":
        return first.operands[0]
    return None


def _is(value: Value, number: float) -> bool:
    return value.operation == "constant" and value.number == number


def _log1p(x: Value) -> Value:
    # the series of atanh keeps the digits at small x
    return record("multiply", 2.0, record("arctanh", x / (2.0 + x)))


_LOWERED: dict[str, Callable[..., Any]] = {
    "true_divide": lambda x, y: x / y,
    "float_power": lambda x, y: x**y,
    "positive": lambda x: x,
    "square": lambda x: x * x,
    "reciprocal": lambda x: 1.0 / x,
    "cbrt": lambda x: x ** (1.0 / 3.0),
    "hypot": lambda x, y: np.absolute(x) if _is(y, 0.0) else np.sqrt(x * x + y * y),
    "fabs": lambda x: np.absolute(x),
    "fmax": lambda x, y: np.maximum(x, y),
    "fmin": lambda x, y: np.minimum(x, y),
    "clip": lambda x, low, high: np.minimum(np.maximum(x, low), high),
    "log2": lambda x: np.log(x) / math.log(2.0),
    "exp2": lambda x: 2.0**x,
    "log1p": _log1p,
    "expm1": lambda x: record("multiply", 2.0 * np.exp(0.5 * x), record("sinh", 0.5 * x)),
    "expit": lambda x: 1.0 / (1.0 + np.exp(-x)),
    "logaddexp": lambda x, y: np.maximum(x, y) + _log1p(np.exp(-np.absolute(x - y))),
    "bitwise_and": lambda x, y: record("and", x, y),
    "bitwise_or": lambda x, y: record("or", x, y),
    "invert": lambda x: record("not", x),
    "logical_and": lambda x, y: record("and", x, y),
    "logical_or": lambda x, y: record("or", x, y),
    "logical_not": lambda x: record("not", x),
}

_ARRAY_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "where": choose,
    "clip": lambda x, low, high: record("clip", x, low, high),
    "column_stack": ValueColumns,
    "ones_like": lambda x, dtype=None: constant(1.0),
    "zeros_like": lambda x, dtype=None: constant(0.0),
    "full_like": lambda x, fill, dtype=None: value_of(fill),
    "ravel": lambda x: x,
    "shape": lambda x: (),
}


@contextmanager
def local_names(packages: tuple[str, ...]) -> Iterator[None]:
    """Name values after the local variables that hold them in the functions of these packages.

    The exported program then reads like the function it was recorded from.
    """
    _naming.append(packages)
    try:
        yield
    finally:
        _naming.pop()


def _name_locals() -> None:
    """Name the values held by local variables of the functions that compute; a profiler can block other threads."""
    frame: FrameType | None = sys._getframe(2)
    while frame is not None:
        module = str(frame.f_globals.get("__name__", ""))
        if module != __name__ and module.startswith(_naming[-1]):
            for name, thing in frame.f_locals.items():
                value = thing.item() if isinstance(thing, np.ndarray) and thing.shape == () else thing
                if isinstance(value, Value) and value.operands and not value.name and len(name) > 2:
                    value.name = name.strip("_")
        frame = frame.f_back
