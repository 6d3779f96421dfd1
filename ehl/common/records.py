"""`dataclass` whose methods are compiled at the import in one step.

The dataclasses of Python 3.11 compile six functions for each class. With more than 200 classes that was a fifth of the
processor time of a command. Here only `__init__` is compiled; the other methods are shared by all classes and use
`__dataclass_fields__`. `fields`, `replace`, `asdict` and pickling work as those of the standard library.
"""

from __future__ import annotations

import dataclasses
import sys
from reprlib import recursive_repr
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:

    def dataclass(cls=None, /, *, frozen=False, eq=True, repr=True, **options):
        """As `dataclasses.dataclass`."""
        if cls is None:
            return lambda other: dataclass(other, frozen=frozen, eq=eq, repr=repr, **options)
        if options:
            return dataclasses.dataclass(cls, frozen=frozen, eq=eq, repr=repr, **options)
        hashed = cls.__dict__.get("__hash__") is not None
        cls = dataclasses.dataclass(cls, init=False, eq=False, repr=False)
        cls.__dataclass_params__.eq, cls.__dataclass_params__.repr = eq, repr
        own = {"__init__": _initialiser(cls, frozen)}
        own |= {"__repr__": _repr} if repr else {}
        own |= {"__eq__": _equal} if eq else {}
        own |= {"__setattr__": _refused_value, "__delattr__": _refused_removal} if frozen else {}
        for name, method in own.items():
            if name not in cls.__dict__:
                setattr(cls, name, method)
        if eq and not hashed:
            cls.__hash__ = _hash if frozen else None
        return cls


class _Factory:
    def __repr__(self) -> str:
        return "<factory>"


_FACTORY, _MISSING = _Factory(), dataclasses.MISSING


def _initialiser(cls: type, frozen: bool) -> Any:
    """`__init__` of the fields of a class."""
    parts, lines, defaults, types = [], [], {}, {}
    for field in dataclasses.fields(cls):
        name, made = field.name, field.default_factory is not _MISSING
        if made or field.default is not _MISSING:
            defaults[name] = field.default_factory if made else field.default
        value = f"_given_[{name!r}]()" if made else name
        if field.init:
            types[name] = field.type
            default = "_factory_" if made else f"_given_[{name!r}]"
            parts.append(f"{name}={default}" if name in defaults else name)
            value = f"{value} if {name} is _factory_ else {name}" if made else name
        elif not made:
            continue
        lines.append(f"_set_(self, {name!r}, {value})" if frozen else f"self.{name} = {value}")
    if hasattr(cls, "__post_init__"):
        lines.append("self.__post_init__()")
    head, body = ", ".join(["self", *parts]), "\n  ".join(lines or ["pass"])
    text = f"def _made_(_given_, _factory_, _set_):\n def __init__({head}):\n  {body}\n return __init__"
    found: dict[str, Any] = {}
    exec(text, sys.modules[cls.__module__].__dict__, found)
    method = found["_made_"](defaults, _FACTORY, object.__setattr__)
    method.__qualname__, method.__annotations__ = f"{cls.__qualname__}.__init__", {**types, "return": None}
    return method


@recursive_repr()
def _repr(self: Any) -> str:
    shown = ", ".join(f"{f.name}={getattr(self, f.name)!r}" for f in dataclasses.fields(self) if f.repr)
    return f"{type(self).__qualname__}({shown})"


def _compared(self: Any) -> tuple[Any, ...]:
    return tuple(getattr(self, field.name) for field in dataclasses.fields(self) if field.compare)


def _equal(self: Any, other: object) -> Any:
    return _compared(self) == _compared(other) if other.__class__ is self.__class__ else NotImplemented


def _hash(self: Any) -> int:
    return hash(_compared(self))


def _refuse(self: Any, name: str, what: str) -> None:
    if "__dataclass_fields__" in type(self).__dict__ or name in self.__dataclass_fields__:
        raise dataclasses.FrozenInstanceError(f"cannot {what} field {name!r}")


def _refused_value(self: Any, name: str, value: Any) -> None:
    _refuse(self, name, "assign to")
    object.__setattr__(self, name, value)


def _refused_removal(self: Any, name: str) -> None:
    _refuse(self, name, "delete")
    object.__delattr__(self, name)
