"""One lubricated line contact: lubricant, elasticity, Reynolds equation, heat, asperities, friction."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ehl.path import solve_path

__version__ = "0.1.0"

__all__ = ["__version__", "solve_path"]


def __getattr__(name: str) -> Any:
    # compiled code is loaded when it is asked for, not when the command line starts
    if name == "solve_path":
        from ehl.path import solve_path

        return solve_path
    raise AttributeError(f"module 'ehl' has no attribute {name!r}")
