"""Friction formulas from contact solutions: plan, sweep, dataset, fit, formula file.

A `Plan` defines the contacts, `sweep` solves them into a `Run`, and `fit` returns a `Formula`. Modules are loaded at
first use.
"""

from ehl.common import lazy_exports
from ehl.common.version import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)
