"""One lubricated line contact: lubricant, elasticity, Reynolds equation, heat, asperities, friction."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ehl.contact import Contact
    from ehl.contact_result import ContactResult
    from ehl.fluid.lubricant import Lubricant
    from ehl.fluid.oil import Oil
    from ehl.io.data import shipped
    from ehl.io.errors import ConvergenceError, InputError, MixedEhlError
    from ehl.material import Material
    from ehl.path import PathResult, solve_path
    from ehl.quantities import Quantity, quantity
    from ehl.state import ContactState
    from ehl.view.table import Table

__version__ = "0.1.0"
# goes up where the numbers of a contact change by more than rounding: keys of cases and stored runs name it
SOLVER = f"ehl {__version__}, engine 3"

# name -> module: compiled code is loaded when it is asked for, not when the command line starts
_MODULES = {
    "Contact": "ehl.contact",
    "ContactResult": "ehl.contact_result",
    "ContactState": "ehl.state",
    "ConvergenceError": "ehl.io.errors",
    "InputError": "ehl.io.errors",
    "Lubricant": "ehl.fluid.lubricant",
    "Material": "ehl.material",
    "MixedEhlError": "ehl.io.errors",
    "Oil": "ehl.fluid.oil",
    "PathResult": "ehl.path",
    "Quantity": "ehl.quantities",
    "Table": "ehl.view.table",
    "quantity": "ehl.quantities",
    "shipped": "ehl.io.data",
    "solve_path": "ehl.path",
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
