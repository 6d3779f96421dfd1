"""Spiral bevel and hypoid gear pairs: geometry, contact, load, friction, power loss, efficiency.

>>> import efficiency
>>> pair = efficiency.load("fm_spiral_bevel_14x39")
>>> mesh = pair.mesh(side="drive", positions=4, points_per_line=9)
>>> mesh.load("300 N m").efficiency("constant:0.05", speed="1500 rpm").status
'converged'
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from efficiency.conditions.duty import DutyCycle as DutyCycle
    from efficiency.conditions.grid import Grid as Grid
    from efficiency.loss.efficiency_result import EfficiencyResult as EfficiencyResult
    from efficiency.pair import GearPair as GearPair
    from efficiency.pair import LoadedMesh as LoadedMesh
    from efficiency.pair import Mesh as Mesh
    from efficiency.pair import load as load
    from efficiency.templates import new_file as new_file
    from efficiency.templates import new_questions as new_questions

__version__ = "0.1.0"

_HOMES = {
    "load": "efficiency.pair",
    "GearPair": "efficiency.pair",
    "Mesh": "efficiency.pair",
    "LoadedMesh": "efficiency.pair",
    "EfficiencyResult": "efficiency.loss.efficiency_result",
    "Grid": "efficiency.conditions.grid",
    "DutyCycle": "efficiency.conditions.duty",
    "new_file": "efficiency.templates",
    "new_questions": "efficiency.templates",
    "blank": "efficiency.blanks.pair:pair_blank",
    "settings": "efficiency.machine_settings.solve:machine_settings",
    "machine_corrections": "efficiency.machine_settings.correction",
    "study": "efficiency.studies.parameter_study:run_study",
    "import_design": "efficiency.output.design_import:design_from_sheet",
    "optimise": "efficiency.optimisation.optimise:optimise",
    "demo": "efficiency.studies.demonstration:run_demo",
    "serve_app": "efficiency.app.server",
    "doctor": "efficiency.installation:examine",
    "warmup": "efficiency.installation:warm_up",
}
__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    # heavy libraries are loaded when they are asked for, not when the command line starts
    if name in _HOMES:
        module, _, attribute = _HOMES[name].partition(":")
        value = getattr(import_module(module), attribute or name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'efficiency' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
