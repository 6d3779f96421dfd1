"""`ehl.common.records.dataclass` against the dataclass of the standard library."""

import copy
import dataclasses
import inspect
import pickle
import re
from pathlib import Path
from typing import Any

import pytest

from ehl.common.records import dataclass

pytestmark = pytest.mark.fast


def classes(decorate: Any) -> tuple[type[Any], ...]:
    """Frozen, derived, changeable, by identity, and a plain class derived from a frozen one."""

    @decorate(frozen=True)
    class Base:
        """Of all kinds of fields."""

        a: int
        b: float = 2.0
        c: list[int] = dataclasses.field(default_factory=list, repr=False, compare=False)
        d: dict[str, int] = dataclasses.field(default_factory=dict, init=False)
        e: int = dataclasses.field(default=3, init=False)

        def __post_init__(self) -> None:
            self.d["a"] = self.a

    @decorate(frozen=True, repr=False)
    class Derived(Base):
        """With a further field."""

        f: str = "x"

    @decorate
    class Changeable:
        """Not frozen."""

        a: int

    @decorate(frozen=True, eq=False)
    class Identity(Base):
        """Compared by identity."""

        def __hash__(self) -> int:
            return 5

    class Plain(Base):
        pass

    return Base, Derived, Changeable, Identity, Plain


def told(action: Any, value: Any) -> Any:
    """Result of an action, or name and text of its error."""
    try:
        return action(value)
    except (TypeError, AttributeError) as error:
        return type(error).__name__, str(error)


ACTIONS = [
    lambda v: (hash(v) is None, type(v)(1) == type(v)(1), type(v)(1) == type(v)(2), v == 1),
    lambda v: setattr(v, "a", 3),
    lambda v: delattr(v, "a"),
    lambda v: setattr(v, "other", 3),
    lambda v: dataclasses.asdict(v),
    lambda v: dataclasses.replace(v, a=7).a,
    lambda v: type(v)(),
    lambda v: copy.deepcopy(v).__dict__,
    lambda v: type(v).__match_args__,
    lambda v: str(inspect.signature(type(v))),
    lambda v: None if type(v).__name__ == "Derived" else repr(v),
]


@pytest.mark.parametrize("number", range(len(ACTIONS)))
def test_same_behaviour(number: int) -> None:
    for own, usual in zip(classes(dataclass), classes(dataclasses.dataclass), strict=True):
        assert told(ACTIONS[number], own(1)) == told(ACTIONS[number], usual(1))


def test_classes_of_the_program_can_be_pickled() -> None:
    from ehl.fluid.rheology import LinearStress

    assert pickle.loads(pickle.dumps(LinearStress(1.0, 2.0))) == LinearStress(1.0, 2.0)


def test_modules_use_it() -> None:
    """The command line imports public names only and is an exception."""
    root = Path(__file__).resolve().parents[2]
    usual = re.compile(r"^from dataclasses import .*\bdataclass\b", re.M)
    files = [file for name in ("ehl", "regression", "efficiency") for file in (root / name).rglob("*.py")]
    found = {file.name for file in files if usual.search(file.read_text(encoding="utf-8"))}
    assert found == {"options.py"}
