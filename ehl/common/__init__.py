"""Common ground of the three packages: errors, units, validation, files, tables, notes, pages, progress.

Here: lazy public names of a package, read from the stub next to its `__init__`, so that each name is written once.
"""

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any


def lazy_exports(package: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """`__getattr__`, `__dir__` and `__all__` of a package whose `__init__.pyi` imports its public names.

    A module is imported when one of its names is first used, so that the command line starts without compiled code.
    Type checkers and editors read the types from the stub.

    package: `__name__` of the package.
    file: `__file__` of its `__init__`, next to which the stub lies.
    """
    places: dict[str, tuple[str, str]] = {}
    imported: dict[str, tuple[str, str]] = {}
    for node in ast.parse(Path(file).with_suffix(".pyi").read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom):
            for name in node.names:
                known = places if name.asname else imported
                known[name.asname or name.name] = (str(node.module), name.name)
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Name):
            places |= {target.id: imported[node.value.id] for target in node.targets if isinstance(target, ast.Name)}
    public = sorted(["__version__", *places])

    def load(name: str) -> Any:
        if name not in places:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, attribute = places[name]
        value = getattr(import_module(module), attribute)
        setattr(sys.modules[package], name, value)
        return value

    return load, lambda: public, public
