"""Array types by element type.

Numbers for files without non-finite values.
"""

import math
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
Values = TypeVar("Values", float, FloatArray)  # a number or an array


def finite_or_none(value: Any) -> Any:
    """Copy of a value for JSON, with None instead of non-finite numbers.

    value: a scalar, or arrays, dicts, lists, tuples and records (dataclasses) of them; arrays and tuples become lists,
        records dicts.
    """
    if is_dataclass(value):
        return {field.name: finite_or_none(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, dict):
        return {key: finite_or_none(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return finite_or_none(value.tolist())
    if isinstance(value, (list, tuple)):
        return [finite_or_none(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
