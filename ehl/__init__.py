"""One lubricated line contact: lubricant, elasticity, Reynolds equation, heat, asperities, friction."""

from ehl.common import lazy_exports
from ehl.common.version import SOLVER as SOLVER
from ehl.common.version import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)
