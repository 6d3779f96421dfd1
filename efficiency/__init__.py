"""Spiral bevel and hypoid gear pairs: geometry, contact, load, friction, power loss, efficiency.

>>> import efficiency
>>> pair = efficiency.load("fm_spiral_bevel_14x39")
>>> mesh = pair.mesh(side="drive", positions=4, points_per_line=9)
>>> mesh.load("300 N m").efficiency("constant:0.05", speed="1500 rpm").status
'converged'
"""

from ehl.common import lazy_exports
from ehl.common.version import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)
