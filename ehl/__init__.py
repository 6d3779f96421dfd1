"""One lubricated line contact: lubricant, elasticity, Reynolds equation, heat, asperities, friction."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ehl.common.data import shipped
    from ehl.common.errors import ConvergenceError, InputError, MixedEhlError
    from ehl.common.quantities import Quantity, quantity
    from ehl.common.table import Table
    from ehl.contact import Contact
    from ehl.fluid.lubricant import Lubricant
    from ehl.fluid.oil import Oil
    from ehl.material import Material
    from ehl.result import ContactResult
    from ehl.sequence import PathResult, solve_path
    from ehl.state import ContactState

from ehl.common.version import SOLVER as SOLVER
from ehl.common.version import __version__

# name -> module: compiled code is loaded when it is asked for, not when the command line starts
_MODULES = {
    "Contact": "ehl.contact",
    "ContactResult": "ehl.result",
    "ContactState": "ehl.state",
    "ConvergenceError": "ehl.common.errors",
    "InputError": "ehl.common.errors",
    "Lubricant": "ehl.fluid.lubricant",
    "Material": "ehl.material",
    "MixedEhlError": "ehl.common.errors",
    "Oil": "ehl.fluid.oil",
    "PathResult": "ehl.sequence",
    "Quantity": "ehl.common.quantities",
    "Table": "ehl.common.table",
    "quantity": "ehl.common.quantities",
    "shipped": "ehl.common.data",
    "solve_path": "ehl.sequence",
}

__all__ = [
    "Contact",
    "ContactResult",
    "ContactState",
    "ConvergenceError",
    "InputError",
    "Lubricant",
    "Material",
    "MixedEhlError",
    "Oil",
    "PathResult",
    "Quantity",
    "Table",
    "__version__",
    "quantity",
    "shipped",
    "solve_path",
]


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        value = getattr(import_module(_MODULES[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'ehl' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
