"""From contact solutions to a friction formula: plan, sweep, dataset, fit, formula file.

A notebook needs `import regression`: a `Plan` says which contacts are solved, `sweep` computes them into a `Run`, `fit`
makes a `Formula` of it. All of it is loaded when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from regression.calibration.calibrate import calibrate
    from regression.calibration.synthetic import synthetic_measurement
    from regression.data.dataset import Dataset, load_dataset
    from regression.formula import Formula, fit, friction_model, published
    from regression.plan.operating_range import OperatingRange, WeightedPoints, operating_range
    from regression.plan.plan import Plan
    from regression.sweeping.run import Run, slurm_script, sweep

__version__ = "0.1.0"

__all__ = [
    "Dataset",
    "Formula",
    "OperatingRange",
    "Plan",
    "Run",
    "WeightedPoints",
    "__version__",
    "calibrate",
    "fit",
    "friction_model",
    "load_dataset",
    "operating_range",
    "published",
    "slurm_script",
    "sweep",
    "synthetic_measurement",
]

_MODULES = {
    "Dataset": "regression.data.dataset",
    "Formula": "regression.formula",
    "OperatingRange": "regression.plan.operating_range",
    "Plan": "regression.plan.plan",
    "Run": "regression.sweeping.run",
    "WeightedPoints": "regression.plan.operating_range",
    "calibrate": "regression.calibration.calibrate",
    "fit": "regression.formula",
    "friction_model": "regression.formula",
    "load_dataset": "regression.data.dataset",
    "operating_range": "regression.plan.operating_range",
    "published": "regression.formula",
    "slurm_script": "regression.sweeping.run",
    "sweep": "regression.sweeping.run",
    "synthetic_measurement": "regression.calibration.synthetic",
}


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        value = getattr(import_module(_MODULES[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'regression' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
