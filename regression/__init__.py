"""From contact solutions to a friction formula: plan, sweep, dataset, fit, formula file.

A notebook needs `import regression`: a `Plan` says which contacts are solved, `sweep` computes them into a `Run`, `fit`
makes a `Formula` of it. All of it is loaded when it is first used.
"""

from __future__ import annotations

from ehl.common.lazy import lazy_exports
from ehl.common.version import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)
