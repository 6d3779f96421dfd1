"""Docstrings of the public interface: complete after numpydoc, and their examples run.

Functions and classes that a package exports are held to all of `COMPLETE`; their methods to `DOCUMENTED`, as one line
says all there is to say of `to_dict`. Input models take their fields as keywords: those are in the table of inputs.
"""

import doctest
import importlib
import inspect
import re
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from numpydoc.validate import validate
from pydantic import BaseModel

PACKAGES = ("ehl", "regression", "efficiency")
DOCUMENTED = {
    "GL03",  # double blank lines
    "GL08",  # no docstring
    "SS01",  # no summary
    "SS03",  # summary without full stop
    "PR02",  # unknown parameters documented
    "PR03",  # parameters in another order
    "PR04",  # parameter without type
}
COMPLETE = DOCUMENTED | {
    "GL07",  # sections out of order
    "PR01",  # parameters not documented
    "PR07",  # parameter without description
    "RT01",  # no Returns
    "YD01",  # no Yields
}
FIELDS = {"PR01", "PR02", "PR03"}  # of input models, whose signature is made of their fields


def own(name: str, member: Any) -> bool:
    """Public and documented by us: not inherited from pydantic, pandas or the standard library."""
    return not name.startswith("_") and getattr(member, "__module__", "").split(".")[0] in PACKAGES


def public() -> Iterator[tuple[str, Any]]:
    """Every public name of the packages, and the public methods of public classes."""
    for package in PACKAGES:
        module = importlib.import_module(package)
        for name in module.__all__:
            thing = getattr(module, name)
            if isinstance(thing, str | types.ModuleType):
                continue
            yield f"{package}.{name}", thing
            if inspect.isclass(thing):
                for key, member in inspect.getmembers(thing):
                    target = member.fget if isinstance(member, property) else member
                    if callable(target) and own(key, target):
                        yield f"{package}.{name}.{key}", member


PUBLIC = dict(public())
# what a reader of an example has imported
EXPORTED = {name.rpartition(".")[2]: thing for name, thing in PUBLIC.items() if name.count(".") == 1} | {
    package: importlib.import_module(package) for package in PACKAGES
}


def path_of(name: str) -> str:
    """Where the object is defined, as numpydoc imports it; methods by their class."""
    thing = PUBLIC[name]
    parent = PUBLIC.get(name.rpartition(".")[0])
    if parent is not None and inspect.isclass(parent):
        for cls in parent.__mro__:
            if name.rpartition(".")[2] in vars(cls):
                return f"{cls.__module__}.{cls.__qualname__}.{name.rpartition('.')[2]}"
    return f"{thing.__module__}.{thing.__qualname__}"


@pytest.mark.parametrize("package", PACKAGES)
def test_docstrings_of_a_package_are_complete(package: str) -> None:
    assert 5 <= len(importlib.import_module(package).__all__) <= 23
    for name in (name for name in PUBLIC if name.startswith(f"{package}.")):
        checked = COMPLETE if name.count(".") == 1 else DOCUMENTED
        if inspect.isclass(PUBLIC[name]) and issubclass(PUBLIC[name], BaseModel):
            checked = checked - FIELDS
        assert not [f"{code} {text}" for code, text in validate(path_of(name))["errors"] if code in checked], name


@pytest.mark.usefixtures("small_search")
@pytest.mark.parametrize("name", [name for name in PUBLIC if name.count(".") == 1])
def test_docstring_has_an_example_that_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    thing = PUBLIC[name]
    if inspect.isclass(thing) and issubclass(thing, Exception):
        return
    finder = doctest.DocTestFinder(recurse=inspect.isclass(thing), exclude_empty=True)
    tests = [test for test in finder.find(thing, name, globs=EXPORTED) if test.examples]
    assert tests, "no Examples section"
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    output: list[str] = []
    for test in tests:
        runner.run(test, out=output.append)
    assert runner.failures == 0, "".join(output)


def test_types_of_public_names_are_checked() -> None:
    """`mypy` of the gate checks the stubs strictly: a name is Any only where its module is left out of that."""
    for package in PACKAGES:
        module = importlib.import_module(package)
        for thing in (getattr(module, name) for name in module.__all__):
            defined = "ehl" if isinstance(thing, str) else thing.__module__
            assert defined.partition(".")[0] in PACKAGES
            assert not re.search(r"_kernels|ehl\.compile", defined)
